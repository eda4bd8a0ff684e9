/* Runs generated code along samples and on random bytes.

   Compiled with REAL, its type of number, and TORQUE, the name of the torque in a sample. */
#include <stdint.h>
#include <string.h>

#include "brushgrip.h"

enum { WIDTH = 5, INFORMED = 3, USABLE, STATUS = 9, OUTPUTS };

static void step(brushgrip_state_t *state, const REAL *row, REAL *outputs) {
    brushgrip_sample_t sample;
    brushgrip_estimate_t estimate;
    sample.psi = row[0], sample.psi_dot = row[1], sample.TORQUE = row[2], sample.F_N = row[3], sample.dt = row[4];
    brushgrip_step(state, &sample);
    brushgrip_estimate(state, &estimate);
    outputs[0] = estimate.mu, outputs[1] = estimate.mu_std, outputs[2] = estimate.M_z_predicted;
    outputs[INFORMED] = (REAL)estimate.informed, outputs[USABLE] = (REAL)estimate.usable;
    outputs[5] = estimate.mu_eff, outputs[6] = estimate.mu_eff_std;
    outputs[7] = estimate.M_slide, outputs[8] = estimate.nis, outputs[STATUS] = (REAL)estimate.status;
}

int64_t state_size(void) { return (int64_t)sizeof(brushgrip_state_t); }

/* The estimates of a state that has begun. */
void run_on(brushgrip_state_t *state, int64_t count, const REAL *samples, REAL *outputs) {
    int64_t i;
    for (i = 0; i < count; ++i) step(state, samples + WIDTH * i, outputs + OUTPUTS * i);
}

static uint64_t draw(uint64_t *seed) {
    *seed ^= *seed << 13, *seed ^= *seed >> 7, *seed ^= *seed << 17;
    return *seed;
}

static int is_valid(const REAL *outputs, REAL least, REAL greatest) {
    /* Written so that NaN fails. */
    return outputs[0] >= least && outputs[0] <= greatest && outputs[1] >= 0 && outputs[1] < 1e9f && (outputs[INFORMED] == 0 || outputs[INFORMED] == 1) &&
           outputs[STATUS] >= 0 && outputs[STATUS] < 4096;
}

/* Samples of any usual size, a third of them with random bytes in some or all fields: how many leave an invalid
   estimate; refused counts those that were ignored. */
int64_t fuzz(brushgrip_state_t *state, int64_t count, uint64_t seed, const REAL *usual, REAL least, REAL greatest, int64_t *refused) {
    REAL row[WIDTH], outputs[OUTPUTS];
    int64_t i, invalid = 0;
    int j;
    *refused = 0;
    for (i = 0; i < count; ++i) {
        const uint64_t which = draw(&seed);
        for (j = 0; j < WIDTH; ++j) {
            const uint64_t bits = draw(&seed);
            const double turn = (double)(bits >> 11) / 9007199254740992.0 * 2.0 - 1.0;
            row[j] = (REAL)(usual[j] * (j < 3 ? turn : 1.0 + 0.5 * turn));
            if (which % 3 == 0 && (which >> (8 + j)) % 2) memcpy(&row[j], &bits, sizeof(REAL));
        }
        if (which % 1000 == 7) brushgrip_reset(state);
        step(state, row, outputs);
        invalid += !is_valid(outputs, least, greatest);
        *refused += outputs[STATUS] == 128;
    }
    return invalid;
}

/* A state that goes on with a wheel that turns to and fro at random, by `turn` a sample at most, under random torque
   and load: how many samples leave an invalid estimate. */
int64_t wander(brushgrip_state_t *state, int64_t count, uint64_t seed, const REAL *usual, REAL turn, REAL least, REAL greatest) {
    REAL row[WIDTH], outputs[OUTPUTS], psi = 0;
    int64_t i, invalid = 0;
    int j;
    for (i = 0; i < count; ++i) {
        for (j = 0; j < WIDTH; ++j) {
            const double drawn = (double)(draw(&seed) >> 11) / 9007199254740992.0 * 2.0 - 1.0;
            row[j] = j == 0 ? (REAL)drawn : (REAL)(usual[j] * (j < 3 ? drawn : 1.0 + 0.5 * drawn));
        }
        psi += turn * row[0];
        psi = psi > usual[0] || psi < -usual[0] ? psi - 2 * turn * row[0] : psi;
        row[0] = psi;
        step(state, row, outputs);
        invalid += !is_valid(outputs, least, greatest);
    }
    return invalid;
}

#ifdef ALONE
#include <stdio.h>
#include <stdlib.h>

/* fuzz COUNT PSI PSI_DOT TORQUE F_N DT: a program for the sanitisers. */
int main(int argc, char **argv) {
    static brushgrip_state_t state;
    REAL usual[WIDTH];
    int64_t refused, invalid;
    int j;
    if (argc != 2 + WIDTH) return 2;
    for (j = 0; j < WIDTH; ++j) usual[j] = (REAL)atof(argv[2 + j]);
    brushgrip_init(&state);
    invalid = fuzz(&state, atoll(argv[1]), 88172645463325252u, usual, 0.0, 10.0, &refused);
    invalid += wander(&state, atoll(argv[1]), 88172645463325252u, usual, (REAL)0.05, 0.0, 10.0);
    printf("%lld invalid, %lld refused\n", (long long)invalid, (long long)refused);
    return invalid != 0;
}
#endif
