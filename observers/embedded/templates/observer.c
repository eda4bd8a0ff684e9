/* ${title}
   ${generated} */
#include "${name}.h"

#include <string.h>

/* Order of the output of a step. */
enum {
%% for name in output
    OUT_${name|upper},
%% endfor
    OUTPUTS
};

/* Computation: written by CasADi ${casadi} from the Functions that run in Python. -------------------------- */

${core}
/* Public functions. ---------------------------------------------------------------------------------- */

/* A sensor that is missing gives NAN; infinite or larger values count as missing too. */
static int is_known(${real} value) { return fabs(value) < ${largest_value}; }

void ${name}_init(${name}_state_t *state) {
    int32_t i;
    for (i = 0; i < OUTPUTS; ++i) state->output[i] = (${real})NAN;
    state->output[OUT_MU] = ${prior_mu};
    state->output[OUT_MU_STD] = ${prior_std};
    state->output[OUT_STATUS] = ${NAME}_MISSING;
    state->psi = 0.0;
    state->age = 0.0;
    state->rate = 0.0;
    state->seen = 0;
    state->now = -1;
}

void ${name}_reset(${name}_state_t *state) { ${name}_init(state); }

/* Yaw rate from past angles through a first-order low-pass filter. */
static void update_rate(${name}_state_t *state, ${real} psi, ${real} dt) {
    state->age += dt;
    if (is_known(psi)) {
        const ${real} turn = state->seen ? psi - state->psi : 0.0;
        state->rate += (turn - state->rate * state->age) / (${rate_time_constant} + state->age);
        state->psi = psi;
        state->age = 0.0;
        state->seen = 1;
    }
}

${stepping}
int32_t ${name}_step(${name}_state_t *state, const ${name}_sample_t *sample) {
    ${real} now[6];
    if (!(sample->dt > 0.0 && sample->dt <= ${longest_step})) {
        state->output[OUT_STATUS] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    update_rate(state, sample->psi, sample->dt);
    now[0] = sample->psi;
    now[1] = is_known(sample->psi_dot) ? sample->psi_dot : state->rate;
    now[2] = sample->F_N;
    now[3] = sample->dt;
    now[4] = ${"sample->M_z" if torque == "M_z" else "(%s)NAN" % real};
    now[5] = ${"sample->M" if torque == "M" else "(%s)NAN" % real};
    if (state->now < 0) {
        if (!(is_known(now[0]) && is_known(now[2]) && now[2] >= ${least_first_load})) {
            state->output[OUT_STATUS] = ${NAME}_MISSING;
            return ${NAME}_MISSING;
        }
        begin(state, now);
    }
    return advance(state, now);
}

void ${name}_estimate(const ${name}_state_t *state, ${name}_estimate_t *estimate) {
%% for name in numbers
    estimate->${name} = state->output[OUT_${name|upper}];
%% endfor
    estimate->informed = state->output[OUT_MU_STD] < ${informed_below} * state->output[OUT_MU];
    estimate->status = (int32_t)state->output[OUT_STATUS];
}

const char *${name}_version(void) { return "${version}"; }
