
/* M_z [N m] of a sample at mu, and its derivatives by mu and by k over its nominal value. */
static void kept_torque(const ${name}_state_t *state, int32_t at, ${real} mu, ${real} stiffness, ${real} *torque) {
    const ${name}_patch_t *patch = &state->patch; %% if rig_at_run_time
    const ${real} k = ${k} * stiffness, scale = mu / k;
    ${real} total = state->slope[at] * ${still_moment}, by_scale = 0.0, moment[2];
    int32_t i;
    for (i = 0; i < state->corners[at]; ++i) {
        unit_moment(smaller(scale * state->xi[at][i], FAR_OUT)${geometry}, moment);
        total += state->d[at][i] * moment[0];
        by_scale += state->d[at][i] * moment[1] * state->xi[at][i];
    }
    torque[M_Z] = k * total${" + state->beside[at]" if effects};
    torque[BY_MU] = by_scale;
    torque[BY_STIFFNESS] = ${k} * (total - scale * by_scale);
}

%% include "patches/begin_kept.c"
/* Advances the patch to the signals of a sample, and stores what the window keeps of it. */
static void follow_sample(${name}_state_t *state, int32_t at, const ${real} *signals, ${real} mu, ${real} stiffness, const ${real} *retention, ${real} *slide) {
    const ${name}_patch_t *patch = &state->patch;
    const ${real} k = ${k} * stiffness, scale = mu / k;
    ${real} beside[2] = {0.0, 0.0};
    int32_t i;
    (void)retention;
    turn_to_sample(&state->patch, signals, scale, beside, slide);
%% if angle_is_state
    {
        ${real} moment[3];
        patch_moment(&state->patch, scale, moment);
        state->by_angle[at] = k * moment[2]${" + beside[1]" if effects};
        state->angle[at] = signals[0];
    }
%% endif
    state->slope[at] = patch->rest - patch->angle;
    state->corners[at] = (int8_t)patch->corners;
    for (i = 0; i < patch->corners; ++i) {
        state->xi[at][i] = patch->xi[i];
        state->d[at][i] = patch->d[i];
    }
    state->beside[at] = beside[0]; %% if effects
}
