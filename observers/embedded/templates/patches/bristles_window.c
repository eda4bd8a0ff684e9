
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

/* What is kept of samples before the first one, whose signals are given. */
static void begin_kept(${name}_state_t *state, const ${real} *signals) {
    int32_t i;
%% if angle_is_state
    /* The torque beside the patch moves the wheel from the first sample on. */
    ${real} terms[TERMS]${", own_next[%s]" % own if own};
    sample_terms(signals, ${"state->patch.own, " if own}terms${", own_next" if own});
%% else
    (void)signals;
%% endif
    for (i = 0; i < ${window}; ++i) {
        state->M_z[i] = ${"terms[TERM_TORQUE]" if angle_is_state else "0.0"};
        state->by_mu[i] = 0.0;
        state->mu[i] = ${prior_mu};
        state->by_k[i] = 0.0; %% if by_k
        state->stiffness[i] = 1.0; %% if by_k
        state->nominal[i] = 0.0; %% if by_k
        state->angle[i] = 0.0; %% if angle_is_state
        state->by_angle[i] = 0.0; %% if angle_is_state
    }
}

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
