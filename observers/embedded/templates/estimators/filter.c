/* The state before the first sample. */
static void begin(${name}_state_t *state, const ${real} *sample) {
    ${name}_filter_t *first = &state->filter[0];
    begin_filter(sample${constants_at}, ${first|join(", ")});
    begin_patch(&state->patch, sample, ${prior_mu});
    state->now = 0;
}

/* One sample: from one half of the filter's state to the other. The patch is advanced in place, so that a sample
   whose numbers fail starts the observer anew. */
static int32_t advance(${name}_state_t *state, const ${real} *sample) {
    const ${name}_filter_t *before = &state->filter[state->now];
    ${name}_filter_t *after = &state->filter[1 - state->now];
    ${real} output[OUTPUTS], now[${clean}], signals[4], torque[TORQUES] = {0}, slide[2] = {0}, imputed = 0.0;
    const ${real} mu = state->output[OUT_MU];
    ${real} retention[${walk + 1}]; %% if follows_mu
    const ${real} retention[1] = {1.0}; %% if not follows_mu
    clean(sample, before->last, now, &imputed);
%% if other
    /* The states of both directions of friction are exchanged before the patch is advanced. */
    const ${real} mu_now = now[${exchanged}] != 0.0 && now[${clean_dt}] > 0.0 ? any_exp(before->x[${other}]) : mu;
%% endif
%% if follows_mu
    retentions(before->factor, before->last, now${", mu" if walk > 1}${constants_at}, retention);
%% endif
%% if not advances_at_corrected_state
    /* The patch at the angle of the sample; the states that its torque depends on only walk until then. */
    patch_signals(before->x, now, signals);
    advance_patch(&state->patch, signals, ${mu_now}, ${stiffness_before}, retention, torque, slide);
%% endif
    {
        const ${real} memory[${memory|length}] = {${memory|join(", ")}};
        filter(${before|join(", ")}, memory, sample, mu${constants_at}, ${after|join(", ")}, output);
    }
%% if advances_at_corrected_state
    if (is_known(output[OUT_MU])) {
        /* The patch follows the corrected angle; its torque is for the next sample. */
        patch_signals(after->x, now, signals);
        advance_patch(&state->patch, signals, output[OUT_MU], ${stiffness_after}, retention, torque, slide);
        after->M_z[0] = torque[M_Z];
        after->slopes[${loop.index0}] = ${slope}; %% for slope in slopes
        effective_friction(output[OUT_MU], output[OUT_MU_STD], signals[2], slide, &output[OUT_MU_EFF], &output[OUT_MU_EFF_STD], &output[OUT_M_SLIDE]); %% if slides
        output[OUT_M_Z_PREDICTED] = torque[M_Z];
    }
%% endif
%% include "estimators/refuse.c"
    if (((int32_t)output[OUT_STATUS] & ${NAME}_RESET) != 0) { %% if follows_mu
        forget_sensitivity(&state->patch, retention[${walk}]); %% if follows_mu
    } %% if follows_mu
    state->now = 1 - state->now;
    set_numbers(state->output, output, OUTPUTS);
    return (int32_t)output[OUT_STATUS];
}
