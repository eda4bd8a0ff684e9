/* ln mu and M_0 as acquired replace those of the estimator, not correlated with the rest. */
static void hand_over(${name}_state_t *state, const ${real} *handed) {
    const ${real} mu = exp(handed[0]);
%% if window
    /* But the last step, nothing is left in the window. */
    const int32_t newest = state->newest, last = (newest + ${window} - 1) % ${window};
    int32_t i, j;
    for (i = 0; i < STATES; ++i) {
%% for state in handed
        state->P_newest[${state.index} * STATES + i] = 0.0;
        state->P_newest[i * STATES + ${state.index}] = 0.0;
%% endfor
    }
%% for state in handed
    state->x[newest][${state.index}] = handed[${state.at}];
    state->x[last][${state.index}] = handed[${state.at}];
    state->P_newest[${state.index} * STATES + ${state.index}] = handed[${state.at + 1}];
%% endfor
    for (i = 0; i < ${window}; ++i) {
        if (i != newest) {
            for (j = 0; j < STATES; ++j) {
                state->x[i][j] = state->x[last][j];
            }
            state->row[i][ROW_DT] = 0.0;
        }
        state->row[i][ROW_ACCEPTED] = 0.0;
        state->row[i][ROW_JUMP] = 0.0;
%% if bristles
        state->by_mu[i] = 0.0;
%% endif
    }
    for (i = 0; i < STATES; ++i) {
        state->mean[i] = state->x[last][i];
        for (j = 0; j < STATES; ++j) {
            state->factor[i * STATES + j] = i == j ? state->P_newest[i * STATES + j] : 0.0;
        }
    }
    for (i = 0; i < 2; ++i) {
        state->counts[i] = 0.0;
    }
    for (i = 0; i < 4; ++i) {
        state->monitor[i] = 0.0;
    }
%% else
    ${real} *values = state->values[state->now];
    int32_t i;
    for (i = 0; i < ${states}; ++i) {
%% for state in handed
        values[${factor} + ${state.index} * ${states} + i] = 0.0;
        values[${factor} + i * ${states} + ${state.index}] = 0.0;
%% endfor
    }
%% for state in handed
    values[${x} + ${state.index}] = handed[${state.at}];
    values[${factor} + ${state.index} * ${states + 1}] = handed[${state.at + 1}];
%% endfor
    for (i = 0; i < 2; ++i) {
        values[${counts} + i] = 0.0;
    }
    for (i = 0; i < 4; ++i) {
        values[${monitor} + i] = 0.0;
    }
    values[${output} + OUT_MU] = mu;
%% endif
    state->output[OUT_MU] = mu;
%% if bristles
    forget_sensitivity(&state->patch, 0.0);
%% endif
}

