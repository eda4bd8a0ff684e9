/* Uses all of the interface and nothing else, to see how much code that takes. */
#include "brushgrip.h"

int probe(brushgrip_state_t *state, const brushgrip_sample_t *sample, brushgrip_estimate_t *estimate) {
    brushgrip_init(state);
    brushgrip_reset(state);
    brushgrip_estimate(state, estimate);
    return brushgrip_step(state, sample) + brushgrip_version()[0];
}
