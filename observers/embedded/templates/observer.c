/* $described
   $generated */
#include "$name.h"

/* The patch and the estimator: written by casadi $casadi from the functions that run in Python. ------- */

$core
/* What turns them into an observer. ------------------------------------------------------------------ */

/* No sensor means a number this large, in SI units. */
static int is_known($real value) { return fabs(value) < $sensible; }

void ${name}_init(${name}_state_t *state) {
    state->said[0] = $prior_mu;
    state->said[1] = $prior_std;
    state->said[2] = ($real)NAN;
    state->said[3] = ${NAME}_MISSING;
    state->psi = 0.0;
    state->age = 0.0;
    state->rate = 0.0;
    state->seen = 0;
    state->now = -1;
}

void ${name}_reset(${name}_state_t *state) { ${name}_init(state); }

/* The yaw rate from the past of the angle, through a low pass of first order. */
static void follow_angle(${name}_state_t *state, $real psi, $real dt) {
    state->age += dt;
    if (is_known(psi)) {
        const $real turn = state->seen ? psi - state->psi : 0.0;
        state->rate += state->age / ($memory + state->age) * (turn / state->age - state->rate);
        state->psi = psi;
        state->age = 0.0;
        state->seen = 1;
    }
}

$stepping
int32_t ${name}_step(${name}_state_t *state, const ${name}_sample_t *sample) {
    $real now[6];
    if (!(sample->dt > 0.0 && sample->dt <= $longest_step)) {
        state->said[3] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    follow_angle(state, sample->psi, sample->dt);
    now[0] = sample->psi;
    now[1] = is_known(sample->psi_dot) ? sample->psi_dot : state->rate;
    now[2] = sample->F_N;
    now[3] = sample->dt;
    now[4] = $M_z;
    now[5] = $M;
    if (state->now < 0) {
        if (!(is_known(now[0]) && is_known(now[2]) && now[2] > 0.0)) return ${NAME}_MISSING;
        begin(state, now);
    }
    return advance(state, now);
}

void ${name}_estimate(const ${name}_state_t *state, ${name}_estimate_t *estimate) {
    estimate->mu = state->said[0];
    estimate->mu_std = state->said[1];
    estimate->M_z_predicted = state->said[2];
    estimate->informed = state->said[1] < $informed_below * state->said[0];
    estimate->status = (int32_t)state->said[3];
}

const char *${name}_version(void) { return "$version"; }
