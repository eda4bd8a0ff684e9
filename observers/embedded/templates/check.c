/* Compares this build with the estimates of Python: check ${name}_vector.csv

   Prints the largest differences; status 0 if those of mu and mu_std are at most ${tolerance}, that of the torque
   at most ${tolerance} of its largest value, and all flags equal.

   ${generated} */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "${name}.h"

enum { PSI, PSI_DOT, TORQUE, LOAD, DT, MU, MU_STD, M_Z, INFORMED, STATUS, COLUMNS };

static double difference(double actual, double expected) {
    if (isnan(actual) || isnan(expected)) return isnan(actual) && isnan(expected) ? 0.0 : INFINITY;
    return fabs(actual - expected);
}

int main(int argc, char **argv) {
    static ${name}_state_t state;
    char line[1024], *at;
    double row[COLUMNS], worst[3] = {0.0}, size = 0.0;
    int samples = 0, flags = 0, i;
    FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (file == NULL) {
        fprintf(stderr, "usage: %s ${name}_vector.csv\n", argv[0]);
        return 2;
    }
    ${name}_init(&state);
    while (fgets(line, sizeof line, file) != NULL) {
        ${name}_sample_t sample;
        ${name}_estimate_t estimate;
        double actual[3];
        if (line[0] == '#' || line[0] == 'p') continue;
        for (i = 0, at = line; i < COLUMNS; ++i) {
            row[i] = strtod(at, &at);
            if (*at == ',') ++at;
        }
        sample.psi = (${real})row[PSI];
        sample.psi_dot = (${real})row[PSI_DOT];
        sample.${torque} = (${real})row[TORQUE];
        sample.F_N = (${real})row[LOAD];
        sample.dt = (${real})row[DT];
        ${name}_step(&state, &sample);
        ${name}_estimate(&state, &estimate);
        actual[0] = estimate.mu, actual[1] = estimate.mu_std, actual[2] = estimate.M_z_predicted;
        for (i = 0; i < 3; ++i) worst[i] = fmax(worst[i], difference(actual[i], row[MU + i]));
        size = fmax(size, fabs(row[M_Z]));
        flags += estimate.status != (int)row[STATUS] || estimate.informed != (int)row[INFORMED];
        ++samples;
    }
    fclose(file);
    printf("%s\n%d samples: mu off by %.1e, mu_std by %.1e, M_z by %.1e N m; flags differ in %d\n",
           ${name}_version(), samples, worst[0], worst[1], worst[2], flags);
    return samples > 0 && flags == 0 && worst[0] <= ${tolerance} && worst[1] <= ${tolerance} &&
                   worst[2] <= ${tolerance} * size
               ? 0
               : 1;
}
