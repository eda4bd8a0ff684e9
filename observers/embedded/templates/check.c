/* Compares this build with the estimates of Python: check ${name}_vector.csv

   Status 0 if all flags are equal, mu, mu_eff, their deviations and the innovation of usable samples are within ${limit}
   standard deviations, and torques within ${limit} of the largest; 2 if the file is no such vector. ${limit_comment}

   ${generated} */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "${name}.h"

enum { PSI, PSI_DOT, TORQUE, LOAD, DT, ${estimate|join(", ")|upper}, COLUMNS };
enum { FRICTION, DEVIATION, INNOVATION, TORQUES, KINDS };

static const char columns[] = "psi,psi_dot,${torque},F_N,dt,${estimate|join(",")}";

static int foreign(const char *path, int line) {
    fprintf(stderr,
            "%s: line %d is none of a ${name}_vector.csv; give the one that was written together with this check.c (a recording"
            " goes to the example)\n",
            path, line);
    return 2;
}

static double difference(double actual, double expected) {
    if (isnan(actual) || isnan(expected)) return isnan(actual) && isnan(expected) ? 0.0 : HUGE_VAL;
    return fabs(actual - expected);
}

/* The larger of a difference so far and that of one more number, over its scale. */
static void note(double *worst, double actual, double expected, double scale) {
    if (isnan(expected)) scale = 1.0;
    *worst = fmax(*worst, difference(actual, expected) / scale);
}

int main(int argc, char **argv) {
    static ${name}_state_t state;
    char line[1024], *at;
    double row[COLUMNS], worst[KINDS] = {0.0}, mu = 0.0, size = 0.0;
    int samples = 0, flags = 0, first = 0, lines = 0, headed = 0, same, i;
    FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (file == NULL) {
        fprintf(stderr, "usage: %s ${name}_vector.csv\n", argv[0]);
        return 2;
    }
    ${name}_init(&state);
    while (fgets(line, sizeof line, file) != NULL) {
        ${name}_sample_t sample;
        ${name}_estimate_t estimate;
        char *end;
        ++lines;
        if (line[0] == '#') continue;
        if (!headed) {
            line[strcspn(line, "\r\n")] = '\0';
            headed = strcmp(line, columns) == 0;
            if (headed) continue;
            fclose(file);
            return foreign(argv[1], lines);
        }
        for (i = 0, at = line; i < COLUMNS; ++i) {
            row[i] = strtod(at, &end);
            if (end == at || (*end == ',') != (i < COLUMNS - 1)) {
                fclose(file);
                return foreign(argv[1], lines);
            }
            at = end + 1;
        }
        sample.${field} = (${real})row[${place}]; %% for field, place in sensors
        sample.dt = (${real})row[DT];
        ${name}_step(&state, &sample);
        ${name}_estimate(&state, &estimate);
        mu = fmax(mu, difference(estimate.mu, row[MU]));
        note(&worst[FRICTION], estimate.mu, row[MU], row[MU_STD]);
        note(&worst[FRICTION], estimate.mu_eff, row[MU_EFF], row[MU_EFF_STD]);
        note(&worst[DEVIATION], estimate.mu_std, row[MU_STD], row[MU_STD]);
        note(&worst[DEVIATION], estimate.mu_eff_std, row[MU_EFF_STD], row[MU_EFF_STD]);
        /* Until friction is known, the deviation that it is divided by hangs on all that was rounded. */
        if (row[USABLE] != 0.0) note(&worst[INNOVATION], sqrt(estimate.nis), sqrt(row[NIS]), 1.0);
        note(&worst[TORQUES], estimate.M_z_predicted, row[M_Z_PREDICTED], 1.0);
        note(&worst[TORQUES], estimate.M_slide, row[M_SLIDE], 1.0);
        size = fmax(size, fabs(row[M_Z_PREDICTED]));
        flags += estimate.status != (int)row[STATUS] || estimate.informed != (int)row[INFORMED] ||
                 estimate.usable != (int)row[USABLE];
        ++samples;
        if (first == 0 && (flags > 0 || fmax(worst[FRICTION], fmax(worst[DEVIATION], worst[INNOVATION])) > ${limit})) {
            first = samples;
        }
    }
    fclose(file);
    if (samples == 0) return foreign(argv[1], lines);
    worst[TORQUES] /= size;
    printf("%s\n%d samples: mu off by %.1e; in standard deviations mu off by %.1e, mu_std by %.1e, innovation by %.1e;"
           " torques by %.1e of the largest; flags differ in %d\n",
           ${name}_version(), samples, mu, worst[FRICTION], worst[DEVIATION], worst[INNOVATION], worst[TORQUES], flags);
    same = flags == 0;
    for (i = 0; i < KINDS; ++i) same = same && worst[i] <= ${limit};
    if (same) {
        printf("the same as in Python: all within ${limit}\n");
    } else if (first > 0) {
        printf("NOT the same as in Python: off by more than ${limit}, or a flag differs, first in sample %d of the file\n", first);
    } else {
        printf("NOT the same as in Python: a torque is off by more than ${limit}\n");
    }
    return !same;
}
