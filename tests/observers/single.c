/* Runs the filter in single precision on random but valid samples and checks the state after each.

   The wheel is turned, held and jolted without sense; the torque is now that of the tyre, now noise. A
   channel gives nothing in one sample of twenty, in bouts now and then, and wild numbers at times. */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int ekf_step(const float **arg, float **res, long long *iw, float *w, int mem);
int ekf_step_work(long long *arg, long long *res, long long *iw, long long *w);
int tyre(const float **arg, float **res, long long *iw, float *w, int mem);
int tyre_work(long long *arg, long long *res, long long *iw, long long *w);

enum { PSI, PSI_DOT, F_N, DT, M_Z, M, CHANNELS };
enum { MISSING = 1, HELD = 2, REJECTED = 4, RESET = 8, BOUND = 16 };
enum { SOUND, NOT_FINITE, NOT_POSITIVE };
enum { STILL, WANDERING, SWEEPING, CREEPING, JUMPING, PATHS };
enum { OF_THE_TYRE, SHIFTED, NOISE, TORQUES };

struct setup {
    long long size, n, factor, last, last_size, status, steering;
    float a, J_A, b_t;
};

struct report {
    long long steps, missing, held, rejected, resets, bound, fault, at;
    double least_D, greatest_D, greatest_U;
};

struct world {
    uint64_t seed;
    long long left, gone[CHANNELS];
    int path, torque;
    double psi, rate, load, mu, zero, noise, reach, shift, step;
    float memory[2][256], seen[4], theta[2], geometry[2], torques[1];
    int now;
};

/* splitmix64, the same on every machine. */
static double uniform(struct world *it) {
    uint64_t z = it->seed += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}
static double between(struct world *it, double low, double high) { return low + (high - low) * uniform(it); }
static double decades(struct world *it, double low, double high) { return low * pow(high / low, uniform(it)); }
static int chance(struct world *it, double share) { return uniform(it) < share; }
static double sign(struct world *it) { return chance(it, 0.5) ? 1 : -1; }
static double clamped(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* Another way to turn the wheel, another ground, another kind of torque. */
static void turn_a_page(struct world *it, double slide) {
    it->left = (long long)decades(it, 1, 3000);
    it->path = (int)(PATHS * uniform(it));
    it->torque = (int)(TORQUES * uniform(it));
    it->rate = sign(it) * decades(it, 1e-3, 30);
    it->step = decades(it, 1e-12, 1e-4);
    it->mu = decades(it, 0.05, 3);
    it->noise = decades(it, 1e-5, 0.5);
    it->reach = decades(it, 1e-4, 1);
    it->zero = between(it, -0.1, 0.1) * slide;
    it->shift = it->torque == SHIFTED ? sign(it) * decades(it, 0.1, 30) : 0;
    if (chance(it, 0.2)) it->psi = 0; /* around zero the smallest turns survive rounding */
}

static double turned(struct world *it, double psi, double dt) {
    double limit = it->reach;
    switch (it->path) {
    case STILL: return psi;
    case WANDERING: psi += it->rate * sqrt(dt) * (uniform(it) - 0.5); break;
    case SWEEPING: psi += it->rate * dt; break;
    case CREEPING: psi += it->step * between(it, -1, 1); limit = 1; break;
    default: psi = between(it, -1, 1) * it->reach; limit = 1;
    }
    if (fabs(psi) > limit) it->rate = -it->rate;
    return clamped(psi, -limit, limit);
}

static double wild(struct world *it, double scale) {
    if (chance(it, 0.2)) return sign(it) * INFINITY;
    return sign(it) * decades(it, 10, chance(it, 0.01) ? 1e30 : 1e6) * scale;
}

static void sampled(struct world *it, const struct setup *s, float *sample, long long *iw, float *w) {
    double slide = 0.375 * it->load * s->a, dt = decades(it, 1e-4, 1), psi, moment, steer;
    const float *arg[4] = {it->memory[it->now], it->seen, it->theta, it->geometry};
    float *res[2] = {it->memory[!it->now], it->torques};
    int c;

    if (it->left-- <= 0) turn_a_page(it, slide);
    if (chance(it, 0.002)) it->load = decades(it, 50, 5000);
    it->load = clamped(it->load * exp(0.02 * (uniform(it) - 0.5)), 50, 5000);
    steer = between(it, -2, 2) * slide;
    if (s->steering && it->torque == OF_THE_TYRE && it->path != STILL) {
        /* The wheel obeys the torques, as long as the step is short enough for it to stay stable. */
        dt = decades(it, 1e-4, 2e-2);
        it->rate = (it->rate + dt * (it->torques[0] + steer) / s->J_A) / (1 + dt * s->b_t / s->J_A);
        psi = it->psi + dt * it->rate;
    } else
        psi = turned(it, chance(it, 5e-4) ? between(it, -1, 1) : it->psi, dt);
    it->seen[0] = (float)psi;
    it->seen[1] = (float)((psi - it->psi) / dt);
    it->seen[2] = (float)it->load;
    it->seen[3] = (float)dt;
    it->theta[0] = (float)it->mu;
    it->psi = psi;
    tyre(arg, res, iw, w, 0);
    it->now = !it->now;
    if (!isfinite(it->torques[0])) abort();

    moment = it->torque == NOISE ? between(it, -2, 2) * slide : it->torques[0] + it->zero;
    moment += (it->shift + it->noise * between(it, -1, 1)) * slide;
    sample[PSI] = (float)(s->steering ? psi + it->shift * 0.03 + 1e-3 * it->noise * between(it, -1, 1) : psi);
    sample[PSI_DOT] = (float)(it->seen[1] * between(it, 0.9, 1.1));
    sample[F_N] = (float)(it->load * between(it, 0.98, 1.02));
    sample[DT] = (float)dt;
    sample[M_Z] = (float)moment;
    sample[M] = (float)steer;
    for (c = 0; c < CHANNELS; ++c) {
        double often = chance(it, 0.2) ? 0.02 : 0;
        if (c == DT) continue;
        if (it->gone[c]-- <= 0) it->gone[c] = chance(it, 3e-4) ? (long long)decades(it, 2, 300) : 0;
        if (chance(it, often)) sample[c] = (float)wild(it, c == M_Z || c == M ? slide : 0.1);
        if (c == F_N && fabs(sample[c]) > 5000) sample[c] = chance(it, 0.5) ? -400 : INFINITY;
        if (it->gone[c] > 0 || chance(it, 0.05)) sample[c] = NAN;
    }
}

/* Where the state is not sound, and how: `last` may hold the NaN of a missing measurement. */
static void checked(const struct setup *s, const float *state, struct report *r) {
    long long i, j;
    for (i = 0; i < s->size && r->fault == SOUND; ++i) {
        if (i >= s->last && i < s->last + s->last_size) continue;
        if (!isfinite(state[i])) r->fault = NOT_FINITE, r->at = i;
    }
    for (j = 0; j < s->n && r->fault == SOUND; ++j) {
        const float *column = state + s->factor + j * s->n;
        if (!(column[j] > 0)) r->fault = NOT_POSITIVE, r->at = s->factor + j * s->n + j;
        r->least_D = fmin(r->least_D, column[j]);
        r->greatest_D = fmax(r->greatest_D, column[j]);
        for (i = 0; i < j; ++i) r->greatest_U = fmax(r->greatest_U, fabs(column[i]));
    }
}

static void counted(int status, struct report *r) {
    r->steps += 1;
    r->missing += (status & MISSING) != 0;
    r->held += (status & HELD) != 0;
    r->rejected += (status & REJECTED) != 0;
    r->resets += (status & RESET) != 0;
    r->bound += (status & BOUND) != 0;
}

/* Up to `steps` samples from the state given, fewer where a state is not sound: then `state` is that
   state, `before` the one before it and `sample` what lay between them. Returns 0, or 1 for no memory. */
int drive(const struct setup *s, long long steps, uint64_t seed, const float *constants, const float *theta,
          const float *geometry, float *state, float *before, float *sample, struct report *r) {
    long long size[2][4], in, bytes;
    struct world it = {.seed = seed, .load = 400};
    char *room;
    const float **arg;
    float **res, *w, said[4];
    long long *iw;

    ekf_step_work(&size[0][0], &size[0][1], &size[0][2], &size[0][3]);
    tyre_work(&size[1][0], &size[1][1], &size[1][2], &size[1][3]);
    for (in = 0; in < 4; ++in) if (size[1][in] > size[0][in]) size[0][in] = size[1][in];
    bytes = 8 * (size[0][0] + size[0][1] + size[0][2]) + 4 * size[0][3];
    room = malloc((size_t)bytes);
    if (!room) return 1;
    arg = (const float **)room;
    res = (float **)(arg + size[0][0]);
    iw = (long long *)(res + size[0][1]);
    w = (float *)(iw + size[0][2]);
    memcpy(it.theta, theta, sizeof it.theta);
    memcpy(it.geometry, geometry, sizeof it.geometry);
    r->least_D = INFINITY;
    while (steps-- > 0 && r->fault == SOUND) {
        sampled(&it, s, sample, iw, w);
        memcpy(before, state, sizeof(float) * (size_t)s->size);
        arg[0] = before, arg[1] = sample, arg[2] = constants;
        res[0] = state, res[1] = said;
        ekf_step(arg, res, iw, w, 0);
        checked(s, state, r);
        counted((int)state[s->status], r);
    }
    free(room);
    return 0;
}
