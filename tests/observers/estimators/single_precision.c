/* Generated code in float on random but valid samples, its covariance checked after each. */
#include <math.h>

#include "run.c"

enum { CHANNELS = 4, PSI = 0, RATE, MOMENT, LOAD, DT, MISSED = 1, RESET = 8 };

static double uniform(uint64_t *seed) { return (double)(draw(seed) >> 11) / 9007199254740992.0; }
static double decades(uint64_t *seed, double low, double high) { return low * pow(high / low, uniform(seed)); }
static double sign(uint64_t *seed) { return uniform(seed) < 0.5 ? 1 : -1; }

/* The wheel is turned, held and jolted; the torque is that of a stop with the tyre's stiffness, shifted, or noise. A channel gives nothing in
   one sample of twenty, wild numbers at times, and fails for hundreds of samples with chance `bouts`. Returns the samples before a D of the
   covariance is not positive, or an estimate not valid; `seen` are missing torques, resets, least and greatest D. */
int64_t drive(brushgrip_state_t *state, int64_t count, uint64_t seed, int32_t n, double bouts, double wildest, double *seen) {
    const double usual[CHANNELS] = {0.1, 1.0, 7.0, 400.0};
    double psi = 0, rate = 0, load = 400, moment = 0, noise = 0, shift = 0;
    REAL row[WIDTH], outputs[OUTPUTS];
    int64_t i, left = 0, gone[CHANNELS] = {0};
    int is_noise = 0, j;
    seen[2] = INFINITY;
    for (i = 0; i < count; ++i) {
        const double dt = decades(&seed, 1e-4, 1), slide = 0.017 * load;
        double turn;
        if (left-- <= 0) {
            left = (int64_t)decades(&seed, 1, 3000);
            rate = uniform(&seed) < 0.2 ? 0 : sign(&seed) * decades(&seed, 1e-9, 30);
            noise = decades(&seed, 1e-5, 0.5), is_noise = uniform(&seed) < 0.3;
            shift = uniform(&seed) < 0.3 ? sign(&seed) * decades(&seed, 0.1, 30) : 0;
            load = decades(&seed, 50, 5000);
        }
        if (fabs(psi + rate * dt) > 1) rate = -rate;
        turn = uniform(&seed) < 5e-4 ? 2 * uniform(&seed) - 1 - psi : fmod(rate * dt, 1);
        psi += turn;
        moment = fmin(fmax(moment - 160 * turn, -slide), slide);
        row[PSI] = (REAL)psi, row[RATE] = (REAL)(turn / dt), row[LOAD] = (REAL)load, row[DT] = (REAL)dt;
        row[MOMENT] = (REAL)((is_noise ? 2 * slide * (2 * uniform(&seed) - 1) : moment) + (shift + noise * sign(&seed)) * slide);
        for (j = 0; j < CHANNELS; ++j) {
            if (gone[j]-- <= 0) gone[j] = uniform(&seed) < bouts ? (int64_t)decades(&seed, 2, 300) : 0;
            if (uniform(&seed) < 0.004) row[j] = (REAL)(sign(&seed) * (uniform(&seed) < 0.2 ? INFINITY : usual[j] * decades(&seed, 10, wildest)));
            if (gone[j] > 0 || uniform(&seed) < 0.05) row[j] = (REAL)NAN;
        }
        step(state, row, outputs);
        seen[0] += ((int)outputs[STATUS] & MISSED) != 0, seen[1] += ((int)outputs[STATUS] & RESET) != 0;
        for (j = 0; j < n; ++j) {
            const double D = (double)(state->FACTOR)[j * n + j];
            if (!(D > 0)) return i;
            seen[2] = fmin(seen[2], D), seen[3] = fmax(seen[3], D);
        }
        if (!is_valid(outputs, 0, 1e4f)) return i;
    }
    return count;
}
