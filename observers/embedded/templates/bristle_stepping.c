/* The state before the first sample. */
static void begin(${name}_state_t *state, const ${real} *sample) {
    const ${real} *arg[] = {sample${constants_at}};
    ${real} *res[1] = {state->values[0]};
    ${real} signals[4];
    signals[0] = sample[0];
    signals[1] = is_known(sample[1]) ? sample[1] : 0.0;
    signals[2] = sample[2];
    signals[3] = sample[3];
    (void)begin_filter(arg, res, 0, 0, 0);
    begin_patch(&state->patch, signals, ${prior_mu});
    state->now = 0;
}

/* One sample: from one half of the filter's state to the other. The patch is advanced in place, so that a sample
   whose numbers fail starts the observer anew. */
static int32_t advance(${name}_state_t *state, const ${real} *sample) {
    ${real} output[OUTPUTS], now[${clean}], signals[4], retention[2], torque[3], slide[2];
    ${real} *before = state->values[state->now], *after = state->values[1 - state->now];
    const ${real} *arg[] = {before, sample${constants_at}};
    ${real} *res[2] = {after, output};
    int i;
    clean_sample(sample, &before[${last}], now);
    retentions(before, now${constants_at}, retention);
    for (i = 0; i < 4; ++i) {
        signals[i] = now[i];
    }
%% if is_angle_known
    advance_patch(&state->patch, signals, state->output[OUT_MU], retention[0], torque, slide);
    before[${at["memory.M_z"]}] = torque[0];
    before[${at["memory.by_mu"]}] = torque[1];
    before[${at["memory.mu"]}] = state->output[OUT_MU];
    before[${at["memory.slide"]}] = slide[0];
    before[${at["memory.beside"]}] = slide[1];
%% endif
    (void)filter(arg, res, 0, 0, 0);
%% if not is_angle_known
    if (is_known(output[OUT_MU])) {
        signals[0] = after[${at["psi"]}];
        signals[1] = after[${at["psi_dot"]}];
        advance_patch(&state->patch, signals, output[OUT_MU], retention[0], torque, slide);
        after[${at["M_z"]}] = torque[0];
%% for slope in slopes
        after[${at["slopes"] + loop.index0}] = ${slope};
%% endfor
        effective_friction(output[OUT_MU], output[OUT_MU_STD], signals[2], slide, &output[OUT_MU_EFF], &output[OUT_MU_EFF_STD], &output[OUT_M_SLIDE]);
        after[${at["output.M_z_predicted"]}] = torque[0];
        output[OUT_M_Z_PREDICTED] = torque[0];
    }
%% endif
    if (!(is_known(output[OUT_MU]) && is_known(output[OUT_MU_STD]) && is_known(output[OUT_M_Z_PREDICTED]))) {
        ${name}_reset(state);
        state->output[OUT_STATUS] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
%% if bristles
    if (((int32_t)output[OUT_STATUS] & ${NAME}_RESET) != 0) {
        forget_sensitivity(&state->patch, retention[1]);
    }
%% endif
    state->now = 1 - state->now;
    for (i = 0; i < OUTPUTS; ++i) {
        state->output[i] = output[i];
    }
    return (int32_t)output[OUT_STATUS];
}
