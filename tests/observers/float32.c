/* Runs the filter in single precision: on random but valid samples, the state checked after each, or on
   samples given.

   The wheel is turned, held and jolted without sense; the torque is now that of the tyre, now noise. A
   channel gives nothing in one sample of twenty and wild numbers or infinity at times; where that is
   asked for, it fails for hundreds of samples on end too, and its wild numbers know no bounds. */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int ekf_step(const float **arg, float **res, long long *iw, float *w, int mem);
int ekf_step_work(long long *arg, long long *res, long long *iw, long long *w);
int tyre(const float **arg, float **res, long long *iw, float *w, int mem);
int tyre_work(long long *arg, long long *res, long long *iw, long long *w);

enum { PSI, PSI_DOT, F_N, DT, M_Z, M, CHANNELS };
enum { OUTPUTS = 8 };
enum { MISSING = 1, HELD = 2, REJECTED = 4, RESET = 8, BOUND = 16 };
enum { SOUND, NOT_FINITE, NOT_POSITIVE };
enum { STILL, WANDERING, SWEEPING, CREEPING, JUMPING, PATHS };
enum { OF_THE_TYRE, SHIFTED, NOISE, TORQUES };

#define MEMORY 64

struct setup {
    long long size, n, factor, last, last_size, status, steering;
    float a, J_A, b_t, bouts, wildest, heaviest;
};

struct report {
    long long steps, missing, held, rejected, resets, bound, fault, at;
    double least_D, greatest_D, greatest_U;
};

struct world {
    uint64_t seed;
    long long left, gone[CHANNELS];
    int path, torque;
    double psi, rate, load, mu, zero, noise, reach, shift, creep;
    float memory[2][MEMORY], seen[4], theta[2], geometry[2], moment;
    int now;
};

/* Arguments and scratch of the Functions: they want more of both than they have inputs and outputs. */
struct room {
    const float **arg;
    float **res, *w;
    long long *iw;
};

static struct room opened(void) {
    struct room room;
    long long step[4], other[4];
    int i;

    ekf_step_work(&step[0], &step[1], &step[2], &step[3]);
    tyre_work(&other[0], &other[1], &other[2], &other[3]);
    for (i = 0; i < 4; ++i) step[i] = step[i] > other[i] ? step[i] : other[i];
    room.arg = calloc((size_t)step[0], sizeof *room.arg);
    room.res = calloc((size_t)step[1], sizeof *room.res);
    room.iw = calloc((size_t)step[2] + 1, sizeof *room.iw);
    room.w = calloc((size_t)step[3] + 1, sizeof *room.w);
    if (!room.arg || !room.res || !room.iw || !room.w) abort();
    return room;
}

static void closed(struct room room) {
    free(room.arg);
    free(room.res);
    free(room.iw);
    free(room.w);
}

static void step(const struct room *room, const float *before, const float *sample,
                 const float *constants, float *state, float *said) {
    room->arg[0] = before, room->arg[1] = sample, room->arg[2] = constants;
    room->res[0] = state, room->res[1] = said;
    ekf_step(room->arg, room->res, room->iw, room->w, 0);
}

/* splitmix64, the same on every machine. */
static double uniform(struct world *it) {
    uint64_t z = it->seed += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}
static double between(struct world *it, double low, double high) {
    return low + (high - low) * uniform(it);
}
static double decades(struct world *it, double low, double high) {
    return low * pow(high / low, uniform(it));
}
static int chance(struct world *it, double share) { return uniform(it) < share; }
static double sign(struct world *it) { return chance(it, 0.5) ? 1 : -1; }
static double clamped(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* Another way to turn the wheel, another ground, another kind of torque. */
static void turn_a_page(struct world *it, double slide) {
    it->left = (long long)decades(it, 1, 3000);
    it->path = (int)(PATHS * uniform(it));
    it->torque = (int)(TORQUES * uniform(it));
    it->rate = sign(it) * decades(it, 1e-3, 30);
    it->creep = decades(it, 1e-12, 1e-4);
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
    case CREEPING: psi += it->creep * between(it, -1, 1); limit = 1; break;
    default: psi = between(it, -1, 1) * it->reach; limit = 1;
    }
    if (fabs(psi) > limit) it->rate = -it->rate;
    return clamped(psi, -limit, limit);
}

static double wild(struct world *it, double scale, double wildest) {
    if (chance(it, 0.2)) return sign(it) * INFINITY;
    return sign(it) * decades(it, 10, wildest) * scale;
}

/* The next turn of the wheel, and what the tyre makes of it; returns the time that it took. */
static double moved(struct world *it, const struct setup *s, double steer, const struct room *room) {
    double dt = decades(it, 1e-4, 1), psi;

    if (s->steering && it->torque == OF_THE_TYRE && it->path != STILL) {
        /* The wheel obeys the torques; in steps so short that it does so stably. */
        dt = decades(it, 1e-4, 2e-2);
        it->rate = (it->rate + dt * (it->moment + steer) / s->J_A) / (1 + dt * s->b_t / s->J_A);
        psi = it->psi + dt * it->rate;
    } else
        psi = turned(it, chance(it, 5e-4) ? between(it, -1, 1) : it->psi, dt);
    it->seen[0] = (float)psi;
    it->seen[1] = (float)((psi - it->psi) / dt);
    it->seen[2] = (float)it->load;
    it->seen[3] = (float)dt;
    it->theta[0] = (float)it->mu;
    it->psi = psi;
    room->arg[0] = it->memory[it->now], room->arg[1] = it->seen;
    room->arg[2] = it->theta, room->arg[3] = it->geometry;
    it->now = !it->now;
    room->res[0] = it->memory[it->now], room->res[1] = &it->moment;
    tyre(room->arg, room->res, room->iw, room->w, 0);
    return dt;
}

static void sampled(struct world *it, const struct setup *s, float *sample, const struct room *room) {
    double slide, steer, moment, shake;
    int c;

    if (chance(it, 0.002)) it->load = decades(it, 50, 5000);
    it->load = clamped(it->load * exp(0.02 * (uniform(it) - 0.5)), 50, 5000);
    slide = 0.375 * it->load * s->a;
    if (it->left-- <= 0) turn_a_page(it, slide);
    steer = between(it, -2, 2) * slide;
    sample[DT] = (float)moved(it, s, steer, room);
    moment = it->torque == NOISE ? between(it, -2, 2) * slide : it->moment + it->zero;
    shake = it->shift + it->noise * between(it, -1, 1);
    sample[PSI] = (float)(s->steering ? it->psi + 0.03 * shake : it->psi);
    sample[PSI_DOT] = (float)(it->seen[1] * between(it, 0.9, 1.1));
    sample[F_N] = (float)(it->load * between(it, 0.98, 1.02));
    sample[M_Z] = (float)(moment + shake * slide);
    sample[M] = (float)steer;
    for (c = 0; c < CHANNELS; ++c) {
        double scale = c == M_Z || c == M ? slide : c == F_N ? 400 : 0.1;
        if (c == DT) continue;
        if (it->gone[c]-- <= 0) it->gone[c] = chance(it, s->bouts) ? (long long)decades(it, 2, 300) : 0;
        if (chance(it, 0.004)) sample[c] = (float)wild(it, scale, s->wildest);
        if (c == F_N && sample[c] > s->heaviest) sample[c] = -sample[c];
        if (it->gone[c] > 0 || chance(it, 0.05)) sample[c] = NAN;
    }
}

/* Where the state is not sound, and how: `last` and, before the status, nis may hold the
   NaN of a missing measurement. */
static void checked(const struct setup *s, const float *state, struct report *r) {
    long long i, j;
    for (i = 0; i < s->size && r->fault == SOUND; ++i) {
        if (i >= s->last && i < s->last + s->last_size) continue;
        if (i == s->status - 1) continue;
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
   state, `before` the one before it and `sample` what lay between them. */
void drive(const struct setup *s, long long steps, uint64_t seed, const float *constants,
           const float *theta, const float *geometry, float *state, float *before, float *sample,
           struct report *r) {
    struct world it = {.seed = seed, .load = 400};
    struct room room = opened();
    float said[OUTPUTS];

    memcpy(it.theta, theta, sizeof it.theta);
    memcpy(it.geometry, geometry, sizeof it.geometry);
    r->least_D = INFINITY;
    while (steps-- > 0 && r->fault == SOUND) {
        sampled(&it, s, sample, &room);
        memcpy(before, state, sizeof(float) * (size_t)s->size);
        step(&room, before, sample, constants, state, said);
        checked(s, state, r);
        if (r->fault != NOT_FINITE) counted((int)state[s->status], r);
    }
    closed(room);
}

/* The samples given, six numbers each; says `OUTPUTS` numbers of each. */
void follow(long long size, long long steps, const float *samples, const float *constants, float *state,
            float *before, float *said) {
    struct room room = opened();

    for (; steps > 0; --steps, samples += CHANNELS, said += OUTPUTS) {
        memcpy(before, state, sizeof(float) * (size_t)size);
        step(&room, before, samples, constants, state, said);
    }
    closed(room);
}
