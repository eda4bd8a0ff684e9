
%% if by_k
/* M_z [N m] of a sample at mu and k over its nominal value, and its derivatives: the bristles' is linear in both, times k. */
static void kept_torque(const ${name}_state_t *state, int32_t at, ${real} mu, ${real} stiffness, ${real} *torque) {
    const ${real} change = state->by_mu[at] * (mu - state->mu[at]) + state->by_k[at] * (stiffness - state->stiffness[at]);
    torque[M_Z] = state->M_z[at] + (stiffness - state->stiffness[at]) * state->nominal[at] + stiffness * change;
    torque[BY_MU] = state->by_mu[at] * stiffness;
    torque[BY_STIFFNESS] = state->nominal[at] + change + state->by_k[at] * stiffness;
}
%% else
/* M_z [N m] of a sample at mu, and its derivative by mu: linear in mu. */
static void kept_torque(const ${name}_state_t *state, int32_t at, ${real} mu, ${real} stiffness, ${real} *torque) {
    (void)stiffness;
    torque[M_Z] = state->M_z[at] + state->by_mu[at] * (mu - state->mu[at]);
    torque[BY_MU] = state->by_mu[at];
    torque[BY_STIFFNESS] = 0.0;
}
%% endif

%% include "patches/begin_kept.c"
/* Advances the patch to the signals of a sample, and stores what the window keeps of it. */
static void follow_sample(${name}_state_t *state, int32_t at, const ${real} *signals, ${real} mu, ${real} stiffness, const ${real} *retention, ${real} *slide) {
    ${real} torque[TORQUES];
    advance_patch(&state->patch, signals, mu, stiffness, retention, torque, slide);
    state->M_z[at] = torque[M_Z];
    state->by_mu[at] = torque[BY_MU]${" / stiffness" if by_k};
    state->by_k[at] = (torque[BY_STIFFNESS] - state->patch.M_z) / stiffness; %% if by_k
    state->stiffness[at] = stiffness; %% if by_k
    state->nominal[at] = state->patch.M_z; %% if by_k
    state->mu[at] = mu;
    state->angle[at] = signals[0]; %% if angle_is_state
    state->by_angle[at] = torque[BY_ANGLE]; %% if angle_is_state
}
