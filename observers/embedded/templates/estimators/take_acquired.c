/* What was acquired replaces that of the estimator, not correlated with the rest. */
static void take_acquired(${name}_state_t *state, const ${real} *handed) {
%% if window
    /* But the last step, nothing is left in the window. */
    const int32_t newest = state->newest, last = (newest + ${window} - 1) % ${window};
    int32_t j;
%% else
    ${name}_filter_t *filter = &state->filter[state->now];
%% endif
    int32_t i;
    for (i = 0; i < ${states}; ++i) {
%% for state in handed
        ${P}[${state.index} * ${states} + i] = 0.0;
        ${P}[i * ${states} + ${state.index}] = 0.0;
%% endfor
    }
    ${x}[${state.index}] = handed[${state.at}]; %% for state in handed
    ${P}[${entry.index}] = handed[${entry.at}]; %% for entry in handed_covariance
%% if window
    set_numbers(state->mean, state->x[last], ${states});
    state->mean[${state.index}] = handed[${state.at}]; %% for state in handed
    for (i = 0; i < ${window}; ++i) {
        if (i != newest) {
            for (j = 0; j < ${states}; ++j) {
                state->x[i][j] = state->mean[j];
            }
            state->row[i][ROW_DT] = 0.0;
        }
        state->row[i][ROW_ACCEPTED] = 0.0;
        state->row[i][ROW_JUMP] = 0.0;
%% if follows_mu
        state->by_mu[i] = 0.0;
        state->by_k[i] = 0.0; %% if walk > 1
%% endif
    }
    for (i = 0; i < ${states}; ++i) {
        for (j = 0; j < ${states}; ++j) {
            state->factor[i * ${states} + j] = i == j ? state->P_newest[i * ${states} + j] : 0.0;
        }
    }
    state->factor[${entry.index}] = handed[${entry.at}]; %% for entry in handed_factor
%% endif
    fill_numbers(${own_state}counts, 0.0, ${counts}); %% if not advances_at_corrected_state
    /* Angles that all are rejected count on: after some, the estimated angle begins anew. */
    fill_numbers(&${own_state}counts[1], 0.0, ${counts} - 1); %% if advances_at_corrected_state
    fill_numbers(${own_state}monitor, 0.0, ${monitor});
    state->output[OUT_MU] = any_exp(handed[0]);
    forget_sensitivity(&state->patch, 0.0); %% if follows_mu
}
