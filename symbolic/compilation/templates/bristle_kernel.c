/* A patch of bristles along a recording, with derivatives along any number of directions.

   Every expression of one bristle, of the elements in series and of a sample's scalars is an inlined function of
   CasADi's; here are the loops over samples, bristles and directions. The search for the torque at which patch and
   elements balance is not differentiated: one differentiated step of Newton follows, as in symbolic.elements_in_series. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef _MSC_VER
#define INLINE static __forceinline
#else
#define INLINE static inline __attribute__((always_inline, unused))
#endif
#define natural_log log
#define natural_logf logf
INLINE double lesser(double x, double y) { return x < y ? x : y; }
INLINE double greater(double x, double y) { return x > y ? x : y; }
INLINE float lesserf(float x, float y) { return x < y ? x : y; }
INLINE float greaterf(float x, float y) { return x > y ? x : y; }

/* Bristles, stresses of one, parameters, scalars of a sample, memory of the effects, and all memory. */
enum { BRISTLES = ${bristles}, STRESSES = ${stresses}, PARAMETERS = ${parameters}, SCALARS = ${scalars}, OWN = ${own}, MEMORY = ${memory} };
static const double node_${name}[BRISTLES] = {${numbers}}; %% for name, numbers in nodes.items()

${functions}
/* Coefficients of the bristles in a sample, and those that they share. */
typedef struct {
    double lever[BRISTLES], limit[BRISTLES], moment[BRISTLES], shared[${shared}];
} coefficients_t;

%% if creep
/* The logarithm of each bristle's sliding speed, in single precision: the differentiated step of Newton squares its error. */
static void seek_all(const double *stress, const coefficients_t *at, double turn, float *log_speed) {
    float shared[${shared}];
    int i;
    for (i = 0; i < ${shared}; ++i) shared[i] = (float)at->shared[i];
    for (i = 0; i < BRISTLES; ++i) {
        seek(${single_stress_at_i}, (float)turn, (float)at->lever[i], (float)at->limit[i], shared, &log_speed[i]);
    }
}

%% endif

/* Several sums at a time, in an order that is always the same. */
static double sum(const double *x) {
    double part[8] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, rest = 0.0;
    int i, j;
    for (i = 0; i + 8 <= BRISTLES; i += 8) {
        for (j = 0; j < 8; ++j) part[j] += x[i + j];
    }
    for (; i < BRISTLES; ++i) rest += x[i];
    for (j = 0; j < 4; ++j) part[j] += part[j + 4];
    return (part[0] + part[1]) + (part[2] + part[3]) + rest;
}

%% if compliant
/* Torque of the patch after a turn, and its slope. */
static void try_turn(const double *stress, const coefficients_t *at, double turn, double *torque, double *slope) {
    double total[BRISTLES], by_turn[BRISTLES];
    float log_speed[BRISTLES]; %% if creep
    int i;
    seek_all(stress, at, turn, log_speed); %% if creep
    for (i = 0; i < BRISTLES; ++i) {
        double ${"found[4], " if creep}after[STRESSES], follow[STRESSES];
        find(${stress_at_i}, turn, at->lever[i], at->limit[i], at->shared, log_speed[i], found); %% if creep
        tangent(${stress_at_i}, turn, at->lever[i], at->limit[i], at->shared${", found" if creep}, after, follow);
        total[i] = at->moment[i] * (after[0]${" + after[1]" if stresses == 2});
        by_turn[i] = at->moment[i] * (follow[0]${" + follow[1]" if stresses == 2});
    }
    *torque = sum(total);
    *slope = sum(by_turn);
}

/* The torque at which patch and elements balance, sought from a turn on. */
static double balanced_torque(const double *stress, const coefficients_t *at, double goal, const double *elements, double root) {
    double torque, slope, deflected, residual, low, high;
    int i;
    try_turn(stress, at, root, &torque, &slope);
    deflection(torque, elements, &deflected);
    /* The residual rises with the turn by at least one to one, so its value at one turn brackets the root. */
    residual = root - goal - deflected;
    low = lesser(root, root - residual);
    high = greater(root, root - residual);
    for (i = 0; i < ${search_steps}; ++i) {
        double step;
        balance(torque + slope * (goal - root), slope, elements, &torque);
        deflection(torque, elements, &deflected);
        step = residual < 0.0 ? greater(goal + deflected, root) : lesser(goal + deflected, root);
        step = step >= low && step <= high ? step : (low + high) / 2.0;
        /* This step and the differentiated one of Newton each square what is left [rad]; derivatives are right to 1e-6. */
        if (fabs(step - root) <= 1e-5) break;
        root = step;
        if (i + 1 < ${search_steps}) {
            try_turn(stress, at, root, &torque, &slope);
            deflection(torque, elements, &deflected);
            residual = root - goal - deflected;
            low = residual < 0.0 ? root : low;
            high = residual < 0.0 ? high : root;
        }
    }
    return torque;
}

%% endif
/* Advances memory and its derivatives by `count` samples of four signals. seeds: the directions, each in the
   parameters, a, e and a factor on the load. torque: M_z after each sample; by: its derivatives, a row a sample. */
#ifdef _WIN32
__declspec(dllexport)
#endif
void run(int64_t count, int64_t directions, const double *signals, const double *theta, const double *geometry,
         const double *seeds, double *memory, double *memory_by, double *torque, double *by) {
    int64_t n, j;
    int i, s;
    double angle = memory[0], rise, followed = 0.0; %% if compliant
    for (n = 0; n < count; ++n, signals += 4) {
        double *stress = memory + 1, scalars[SCALARS], beside_patch, goal, turn, further = 0.0;
        double next[STRESSES][BRISTLES], step_by[${step_partials}][BRISTLES], place_by[${place_partials}][BRISTLES], total[BRISTLES];
        double *own = stress + STRESSES * BRISTLES, own_next[OWN]; %% if own
        double follows[STRESSES][BRISTLES], elements[1 + PARAMETERS], root, M_z, slope, deflected, softness; %% if compliant
        coefficients_t at;
        float log_speed[BRISTLES]; %% if creep
        sample(${"own, " if own}signals, theta, geometry, ${"own_next, " if own}scalars);
        share(scalars, at.shared);
        beside(scalars, &beside_patch);
        for (i = 0; i < BRISTLES; ++i) {
            place(node_u[i], node_v[i], node_w[i], scalars, &at.lever[i], &at.limit[i], &at.moment[i]);
        }
        for (i = 0; directions > 0 && i < BRISTLES; ++i) {
            double partial[${place_partials}];
            place_partials(node_u[i], node_v[i], node_w[i], scalars, partial);
            for (s = 0; s < ${place_partials}; ++s) place_by[s][i] = partial[s];
        }
        goal = scalars[0] - memory[0];
        turn = goal;
%% if compliant
        elements[0] = scalars[2];
        for (i = 0; i < PARAMETERS; ++i) elements[1 + i] = theta[i];
        rise = scalars[0] - angle;
        angle = scalars[0];
        root = balanced_torque(stress, &at, goal, elements, rise * followed);
        deflection(root, elements, &deflected);
        turn = goal + deflected;
%% endif
        seek_all(stress, &at, turn, log_speed); %% if creep
        for (i = 0; i < BRISTLES; ++i) {
            double ${"found[4], " if creep}after[STRESSES], follow[STRESSES], partial[${step_partials}];
            find(${stress_at_i}, turn, at.lever[i], at.limit[i], at.shared, log_speed[i], found); %% if creep
            advance(${stress_at_i}, turn, at.lever[i], at.limit[i], at.shared${", found" if creep}, after, follow, partial);
            for (s = 0; s < STRESSES; ++s) next[s][i] = after[s];
            for (s = 0; s < ${step_partials}; ++s) step_by[s][i] = partial[s];
            for (s = 0; s < STRESSES; ++s) follows[s][i] = follow[s]; %% if compliant
            total[i] = at.moment[i] * (follow[0]${" + follow[1]" if stresses == 2}); %% if compliant
        }
%% if compliant
        compliance(root, elements, &softness);
        slope = 1.0 - sum(total) * softness;
        for (i = 0; i < BRISTLES; ++i) total[i] = at.moment[i] * (next[0][i]${" + next[1][i]" if stresses == 2});
        M_z = root + (sum(total) - root) / slope;
        deflection(M_z, elements, &deflected);
        compliance(M_z, elements, &softness);
        further = goal + deflected - turn;
        /* The patch is likely to follow the next sample by the same share; by all of it after a rest, 0/0 being no less. */
        followed = greater(lesser((turn + further) / rise, 1.0), 0.0);
%% endif
        for (j = 0; j < directions; ++j) {
            const double *seed = seeds + (PARAMETERS + 3) * j;
            double *patch_by = memory_by + MEMORY * j, *stress_by = patch_by + 1;
            double scalars_by[SCALARS], shared_by[${shared}], next_by[STRESSES][BRISTLES], moment_by[BRISTLES];
            double beside_by, turn_by;
            double *own_by = stress_by + STRESSES * BRISTLES, own_next_by[OWN]; %% if own
            double elements_by[1 + PARAMETERS], goal_by, deflected_by, further_by; %% if compliant
            sample_along(${"own, " if own}signals, theta, geometry, ${"own_by, " if own}seed, seed + PARAMETERS, seed[PARAMETERS + 2], ${"own_next_by, " if own}scalars_by);
            for (i = 0; i < OWN; ++i) own_by[i] = own_next_by[i]; %% if own
            share_along(scalars, scalars_by, shared_by);
            beside_along(scalars, scalars_by, &beside_by);
            turn_by = scalars_by[0] - patch_by[0];
%% if compliant
            goal_by = turn_by;
            elements_by[0] = scalars_by[2];
            for (i = 0; i < PARAMETERS; ++i) elements_by[1 + i] = seed[i];
            deflection_along(root, elements, elements_by, &deflected_by);
            turn_by = goal_by + deflected_by;
%% endif
            for (i = 0; i < BRISTLES; ++i) {
                const double lever_by = ${place_sums[0]};
                const double limit_by = ${place_sums[1]};
                moment_by[i] = ${place_sums[2]};
                next_by[${loop.index0}][i] = ${terms}; %% for terms in step_sums
            }
%% if compliant
            for (i = 0; i < BRISTLES; ++i) {
                total[i] = at.moment[i] * (next_by[0][i]${" + next_by[1][i]" if stresses == 2}) + moment_by[i] * (next[0][i]${" + next[1][i]" if stresses == 2});
            }
            deflection_along(M_z, elements, elements_by, &deflected_by);
            further_by = goal_by + deflected_by + softness * sum(total) / slope - turn_by;
            turn_by += further_by;
            for (s = 0; s < STRESSES; ++s) {
                for (i = 0; i < BRISTLES; ++i) next_by[s][i] += follows[s][i] * further_by;
            }
%% endif
            patch_by[0] += turn_by;
            for (i = 0; i < BRISTLES; ++i) total[i] = 0.0;
            for (s = 0; s < STRESSES; ++s) {
                for (i = 0; i < BRISTLES; ++i) {
                    stress_by[s * BRISTLES + i] = next_by[s][i];
                    total[i] += at.moment[i] * next_by[s][i] + moment_by[i] * (next[s][i]${" + follows[s][i] * further" if compliant});
                }
            }
            by[n * directions + j] = sum(total) + beside_by;
        }
        memory[0] += turn + further;
        for (i = 0; i < BRISTLES; ++i) total[i] = 0.0;
        for (s = 0; s < STRESSES; ++s) {
            for (i = 0; i < BRISTLES; ++i) {
                stress[s * BRISTLES + i] = next[s][i]${" + follows[s][i] * further" if compliant};
                total[i] += at.moment[i] * stress[s * BRISTLES + i];
            }
        }
        for (i = 0; i < OWN; ++i) own[i] = own_next[i]; %% if own
        torque[n] = sum(total) + beside_patch;
    }
}
