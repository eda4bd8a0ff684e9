/* Least time of a step in microseconds: timer SAMPLES ROUNDS, samples as five floats each. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "brushgrip.h"

static double now(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return 1e6 * (double)at.tv_sec + 1e-3 * (double)at.tv_nsec;
}

int main(int argc, char **argv) {
    static brushgrip_state_t state;
    static float samples[100000][5];
    FILE *file = argc == 3 ? fopen(argv[1], "rb") : NULL;
    size_t count, i;
    int round;
    double least = 1e30;
    if (file == NULL) return 2;
    count = fread(samples, sizeof samples[0], 100000, file);
    fclose(file);
    for (round = 0; round < atoi(argv[2]); ++round) {
        const double begin = now();
        double took;
        brushgrip_init(&state);
        for (i = 0; i < count; ++i) {
            const brushgrip_sample_t sample = {samples[i][0], samples[i][1], samples[i][2], samples[i][3],
                                               samples[i][4]};
            brushgrip_step(&state, &sample);
        }
        took = (now() - begin) / (double)count;
        if (took < least) least = took;
    }
    printf("%.4f\n", least);
    return 0;
}
