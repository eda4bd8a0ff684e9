/* Runs generated code from outside: along samples, two at once, and on random bytes.

   Compiled with REAL, its type of number, and TORQUE, the name of the torque in a sample. */
#include <stdint.h>
#include <string.h>

#include "brushgrip.h"

enum { WIDTH = 5 };

static void take(brushgrip_state_t *state, const REAL *row, REAL *said) {
    brushgrip_sample_t sample;
    brushgrip_estimate_t now;
    sample.psi = row[0], sample.psi_dot = row[1], sample.TORQUE = row[2], sample.F_N = row[3], sample.dt = row[4];
    brushgrip_step(state, &sample);
    brushgrip_estimate(state, &now);
    said[0] = now.mu, said[1] = now.mu_std, said[2] = now.M_z_predicted;
    said[3] = (REAL)now.informed, said[4] = (REAL)now.status;
}

int64_t state_size(void) { return (int64_t)sizeof(brushgrip_state_t); }

/* What is said after each sample. */
void follow(int64_t count, const REAL *samples, REAL *said) {
    static brushgrip_state_t state;
    int64_t i;
    brushgrip_init(&state);
    for (i = 0; i < count; ++i) take(&state, samples + WIDTH * i, said + WIDTH * i);
}

/* The same for two that take turns, the second backwards through the samples. */
void follow_two(int64_t count, const REAL *samples, REAL *said, REAL *other) {
    static brushgrip_state_t one, two;
    int64_t i;
    brushgrip_init(&one);
    brushgrip_init(&two);
    for (i = 0; i < count; ++i) {
        take(&one, samples + WIDTH * i, said + WIDTH * i);
        take(&two, samples + WIDTH * (count - 1 - i), other + WIDTH * i);
    }
}

static uint64_t drawn(uint64_t *seed) {
    *seed ^= *seed << 13, *seed ^= *seed >> 7, *seed ^= *seed << 17;
    return *seed;
}

static int is_sound(const REAL *said, REAL least, REAL greatest) {
    /* Written so that NaN fails. */
    return said[0] >= least && said[0] <= greatest && said[1] >= 0 && said[1] < 1e9f && (said[3] == 0 || said[3] == 1) &&
           said[4] >= 0 && said[4] < 256;
}

/* Samples with random bytes in them, in some fields or in all: how many leave an estimate that is none;
   refused counts those that were left out. */
int64_t fuzz(int64_t count, uint64_t seed, const REAL *usual, REAL least, REAL greatest, int64_t *refused) {
    static brushgrip_state_t state;
    REAL row[WIDTH], said[WIDTH];
    int64_t i, unsound = 0;
    int j;
    *refused = 0;
    brushgrip_init(&state);
    for (i = 0; i < count; ++i) {
        const uint64_t which = drawn(&seed);
        for (j = 0; j < WIDTH; ++j) {
            const uint64_t bits = drawn(&seed);
            const double turn = (double)(bits >> 11) / 9007199254740992.0 * 2.0 - 1.0;
            row[j] = (REAL)(usual[j] * (j < 3 ? turn : 1.0 + 0.5 * turn));
            if (which % 3 == 0 && (which >> (8 + j)) % 2) memcpy(&row[j], &bits, sizeof(REAL));
        }
        if (which % 1000 == 7) brushgrip_reset(&state);
        take(&state, row, said);
        unsound += !is_sound(said, least, greatest);
        *refused += said[4] == 128;
    }
    return unsound;
}

#ifdef ALONE
#include <stdio.h>
#include <stdlib.h>

/* fuzz COUNT PSI PSI_DOT TORQUE F_N DT: as a program, for compilers that watch what it does. */
int main(int argc, char **argv) {
    REAL usual[WIDTH];
    int64_t refused, unsound;
    int j;
    if (argc != 2 + WIDTH) return 2;
    for (j = 0; j < WIDTH; ++j) usual[j] = (REAL)atof(argv[2 + j]);
    unsound = fuzz(atoll(argv[1]), 88172645463325252u, usual, 0.0, 10.0, &refused);
    printf("%lld unsound, %lld refused\n", (long long)unsound, (long long)refused);
    return unsound != 0;
}
#endif
