/* What is kept of samples before the first one, whose signals are given. */
static void begin_kept(${name}_state_t *state, const ${real} *signals) {
    int32_t i;
%% if effects and angle_is_state
    /* The torque beside the patch moves the wheel from the first sample on. */
    ${real} terms[TERMS]${", own_next[%s]" % own if own};
    sample_terms(signals, ${"state->patch.own, " if own}terms${", own_next" if own});
%% else
    (void)signals;
%% endif
    for (i = 0; i < ${window}; ++i) {
%% if bristles
        state->M_z[i] = ${"terms[TERM_TORQUE]" if angle_is_state else "0.0"};
        state->by_mu[i] = 0.0;
        state->mu[i] = ${prior_mu};
        state->by_k[i] = 0.0; %% if by_k
        state->stiffness[i] = 1.0; %% if by_k
        state->nominal[i] = 0.0; %% if by_k
%% else
        state->slope[i] = 0.0;
        state->beside[i] = ${"terms[TERM_TORQUE]" if angle_is_state else "0.0"}; %% if effects
        state->corners[i] = 0;
%% endif
        state->angle[i] = 0.0; %% if angle_is_state
        state->by_angle[i] = 0.0; %% if angle_is_state
    }
}

