/* ${title}
   ${generated} */
#include "${name}.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#ifdef __FAST_MATH__
#error "compile without -ffast-math: missing samples are NAN"
#endif

/* Order of the output of a step. */
enum {
    OUT_${name|upper}, %% for name in output
    OUTPUTS
};

static inline void set_numbers(${real} *numbers, const ${real} *values, int32_t count) {
    int32_t i;
    for (i = 0; i < count; ++i) {
        numbers[i] = values[i];
    }
}

static inline void fill_numbers(${real} *numbers, ${real} value, int32_t count) {
    int32_t i;
    for (i = 0; i < count; ++i) {
        numbers[i] = value;
    }
}

/* Computation: written by CasADi ${casadi} from the Functions that run in Python. -------------------------- */

${core}
/* Public functions. ---------------------------------------------------------------------------------- */

/* Limits of what a sensor may give; beyond ${largest_value} a value is missing. */
#define PSI_LIMIT ((${real})${limits[0]}) /* [rad] */
#define PSI_RATE_LIMIT ((${real})${limits[1]}) /* [rad/s] */
#define LOAD_LIMIT ((${real})${limits[2]}) /* [N] */
#define TORQUE_LIMIT ((${real})${limits[3]}) /* [N m] */
#define REZERO_TIME ((${real})${limits[4]}) /* time after which a jump of psi is that of the sensor's zero [s] */
#define SLACK ((${real})${slack}) /* change of psi that is plausible in any time [rad] */

/* A sensor that is missing gives NAN; infinite or larger values count as missing too. */
static bool is_known(${real} value) { return fabs(value) < ${largest_value}; }

%% if tunable
%% include "parameters.c"

/* The state before the first sample, with the parameters that it has. */
static void clear_state(${name}_state_t *state) {
%% else
void ${name}_init(${name}_state_t *state) {
%% endif
    static const ${real} start[${evidence_start|length}] = {${evidence_start|join(", ")}}; %% if checked
    state->layout = ${NAME}_STATE_LAYOUT;
    state->size = (uint32_t)sizeof *state;
    fill_numbers(state->output, (${real})NAN, OUTPUTS);
    state->output[OUT_MU] = ${prior_mu};
    state->output[OUT_MU_STD] = ${prior_std};
    state->output[OUT_STATUS] = ${NAME}_MISSING;
    state->psi = 0.0;
    state->age = 0.0;
    state->rate = 0.0;
    state->offset = 0.0;
    state->other = 0.0;
    state->other_age = 0.0;
    state->waiting = -1.0;
    state->jump = 0.0;
    state->has_psi = 0;
    state->now = -1;
    set_numbers(state->evidence, start, ${evidence_start|length}); %% if checked
    set_numbers(state->result, state->output, OUTPUTS); %% if supervised
}

%% if tunable
void ${name}_init(${name}_state_t *state) {
    take_parameters(state, &${name}_defaults);
    clear_state(state);
}

void ${name}_reset(${name}_state_t *state) { clear_state(state); }

int32_t ${name}_set_parameters(${name}_state_t *state, const volatile ${name}_parameters_t *parameters) {
    const ${name}_parameters_t taken = *parameters;
    const int32_t fault = ${name}_check_parameters(&taken);
    if (fault != 0) {
        return fault;
    }
    take_parameters(state, &taken);
    if (state->now < 0) {
        clear_state(state);
    }
    return 0;
}
%% else
void ${name}_reset(${name}_state_t *state) { ${name}_init(state); }
%% endif

%% include "sample_screening.c"
%% if checked

/* Evidence of a wrong unit, sign or sensor after a sample; sets suspect to 1 or 0. */
${evidence}
%% endif

/* Yaw rate from past angles, through a first-order low-pass filter. */
static void update_rate(${name}_state_t *state, ${real} psi) {
    if (is_known(psi)) {
        const ${real} turn = state->has_psi ? psi - state->psi : 0.0;
        state->rate += (turn - state->rate * state->age) / (${rate_time_constant} + state->age);
        state->psi = psi;
        state->age = 0.0;
        state->has_psi = 1;
    }
}

%% if checked
static int32_t gather_sample(${name}_state_t *state, const ${name}_sample_t *sample) {
    const ${real} raw[${torques|length + 4}] = {sample->psi, sample->psi_dot, sample->F_N, sample->dt${raw_torques}};
    ${real} after[${evidence_start|length}], suspect;
    gather_evidence(state->evidence, raw, ${half_length}, after, &suspect);
    set_numbers(state->evidence, after, ${evidence_start|length});
    return suspect != 0.0 ? ${NAME}_SUSPECT : 0;
}
%% endif

${stepping}
/* A state of this code and of its parameters. */
static bool is_own(const ${name}_state_t *state) {
    return state->layout == ${NAME}_STATE_LAYOUT && state->size == (uint32_t)sizeof *state;
}

int32_t ${name}_restore(${name}_state_t *state, const void *stored, uint32_t size) {
    uint32_t words[2];
    if (state == NULL || stored == NULL || size != (uint32_t)sizeof *state) {
        return 1;
    }
    (void)memcpy(words, stored, sizeof words);
    if (words[0] != ${NAME}_STATE_LAYOUT || words[1] != size) {
        return 1;
    }
    (void)memcpy(state, stored, sizeof *state);
    return 0;
}

int32_t ${name}_step(${name}_state_t *state, const ${name}_sample_t *sample) {
    ${real} passed[4], now[${torques|length + 4}];
    int32_t implausible, suspect = 0, status;
    if (state == NULL || !is_own(state)) {
        return ${NAME}_REFUSED;
    }
    if (!(sample != NULL && sample->dt > 0.0 && sample->dt <= ${longest_step})) {
        state->${result}[OUT_STATUS] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    implausible = screen_sample(state, sample, passed) != 0 ? ${NAME}_IMPLAUSIBLE : 0;
    update_rate(state, passed[0]);
    now[0] = passed[0];
    now[1] = is_known(passed[1]) ? passed[1] : state->rate;
    if (fabs(now[1]) >= PSI_RATE_LIMIT) {
        implausible = ${NAME}_IMPLAUSIBLE;
        now[1] = (${real})NAN;
    }
    now[2] = passed[3];
    now[3] = sample->dt;
    now[${loop.index0 + 4}] = ${"passed[2]" if name == torque else "(%s)NAN" % real}; %% for name in torques
    if (state->now < 0) {
        if (!(is_known(now[0]) && is_known(now[2]) && now[2] >= ${least_first_load})) {
            status = ${NAME}_MISSING | implausible;
            state->${result}[OUT_STATUS] = (${real})status;
            return status;
        }
        begin(state, now);
        begin_supervision(state, now); %% if supervised
    }
    suspect = gather_sample(state, sample); %% if checked
%% if supervised
    now[${torques.index(torque) + 4}] = passed[2] / state->own[OWN_SCALE]; %% if scaled
    status = advance(state, now);
    if (status == ${NAME}_REFUSED) {
        state->result[OUT_STATUS] = ${NAME}_REFUSED;
        return status;
    }
    now[${torques.index(torque) + 4}] = passed[2]; %% if scaled
    status = supervise(state, now, status) | implausible | suspect;
%% else
    status = advance(state, now) | implausible | suspect;
%% endif
    state->${result}[OUT_STATUS] = (${real})status;
    return status;
}

void ${name}_estimate(const ${name}_state_t *state, ${name}_estimate_t *estimate) {
    if (state == NULL || estimate == NULL) {
        return;
    }
    if (!is_own(state)) {
        estimate->${name} = (${real})NAN; %% for name in numbers
        estimate->informed = 0;
        estimate->usable = 0;
        estimate->status = ${NAME}_REFUSED;
        return;
    }
    estimate->${name} = state->${result}[OUT_${name|upper}]; %% for name in numbers
    estimate->status = (int32_t)state->${result}[OUT_STATUS];
    estimate->informed = estimate->mu_std < ${informed_below} * estimate->mu &&
                         (estimate->status & ${uninformed}) == 0;
    estimate->usable = estimate->informed != 0 && estimate->status == ${NAME}_USED;
}

const char *${name}_version(void) { return ${NAME}_VERSION; }
