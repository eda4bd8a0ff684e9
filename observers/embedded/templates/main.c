/* Reads a recording and prints t,${estimate|join(",")}, one row a sample.

       example RECORDING.csv

   The table has columns t,psi,F_N,${torque} and may have psi_dot, in any order, in SI units; other columns are
   ignored. Lines that begin with # are comments; an empty field or nan is a missing sample.

   ${generated} */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "${name}.h"

enum { T, PSI, PSI_DOT, TORQUE, LOAD, COLUMNS };
static const char *const NAMES[COLUMNS] = {"t", "psi", "psi_dot", "${torque}", "F_N"};

/* Cuts a line into its fields, in place; returns their number. */
static int split(char *line, char **fields, int maximum) {
    int count = 0;
    line[strcspn(line, "\r\n")] = '\0';
    while (count < maximum) {
        char *comma = strchr(line, ',');
        fields[count++] = line;
        if (comma == NULL) break;
        *comma = '\0';
        line = comma + 1;
    }
    return count;
}

static double number(const char *field) {
    char *end;
    const double value = strtod(field, &end);
    return end == field ? (double)NAN : value;
}

static void step(${name}_state_t *state, const double *row, double dt) {
    ${name}_sample_t sample;
    ${name}_estimate_t estimate;
    sample.${field} = (${real})row[${place}]; %% for field, place in sensors
    sample.dt = (${real})dt;
    ${name}_step(state, &sample);
    ${name}_estimate(state, &estimate);
    printf("%.9g,%.${digits}g,%.${digits}g,%.${digits}g,%d,%d,", row[T], (double)estimate.mu, (double)estimate.mu_std,
           (double)estimate.M_z_predicted, (int)estimate.informed, (int)estimate.usable);
    printf("%.${digits}g,%.${digits}g,%.${digits}g,%.${digits}g,%d\n", (double)estimate.mu_eff, (double)estimate.mu_eff_std,
           (double)estimate.M_slide, (double)estimate.nis, (int)estimate.status);
}

int main(int argc, char **argv) {
    static ${name}_state_t state;
    char line[4096], *fields[64];
    int column[COLUMNS] = {-1, -1, -1, -1, -1}, rows = -1, i, j;
    double row[COLUMNS], last[COLUMNS] = {0.0};
    FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (file == NULL) {
        fprintf(stderr, "usage: %s RECORDING.csv, a file that can be read\n", argv[0]);
        return 2;
    }
    ${name}_init(&state);
    printf("t,${estimate|join(",")}\n");
    while (fgets(line, sizeof line, file) != NULL) {
        const int count = line[0] == '#' ? 0 : split(line, fields, 64);
        if (count == 0) continue;
        for (j = 0; rows < 0 && j < COLUMNS; ++j)
            for (i = 0; i < count; ++i)
                if (strcmp(fields[i], NAMES[j]) == 0) column[j] = i;
        if (++rows == 0) {
            for (j = 0; j < COLUMNS; ++j)
                if (column[j] < 0 && j != PSI_DOT) {
                    fprintf(stderr, "%s: the first line names no column %s; commas between columns, SI units%s\n", argv[1], NAMES[j],
                            j == LOAD ? "; a load that was not recorded needs a column too, with its value [N] in every row" : "");
                    fclose(file);
                    return 2;
                }
            continue;
        }
        for (j = 0; j < COLUMNS; ++j)
            row[j] = column[j] >= 0 && column[j] < count ? number(fields[column[j]]) : (double)NAN;
        /* The first sample has no predecessor: its dt is that of the second. */
        if (rows == 2) step(&state, last, row[T] - last[T]);
        if (rows >= 2) step(&state, row, row[T] - last[T]);
        memcpy(last, row, sizeof row);
    }
    fclose(file);
    return rows >= 2 ? 0 : 2;
}
