/* Moment of the patch over k [m^3 rad], its derivative by scale, and, where it is used, by the angle. */
static void patch_moment(const ${name}_patch_t *patch, ${real} scale, ${real} *moment) {
    ${real} total = (patch->rest - patch->angle) * ${still_moment}, by_scale = 0.0, by_angle = -${still_moment};
    ${real} corner_moment[2] = {0.0, 0.0}, z = 0.0;
    int32_t i;
    for (i = 0; i < patch->corners; ++i) {
        z = smaller(scale * patch->xi[i], FAR_OUT);
        unit_moment(patch, z, corner_moment);
        total += patch->d[i] * corner_moment[0];
        by_scale += patch->d[i] * corner_moment[1] * patch->xi[i];
        if (ANGLE_IS_ESTIMATED && patch->clipped[i] != 0) {
            by_angle += (patch->clipped[i] > 0 ? 1.0 : -1.0) * (corner_moment[0] - z * corner_moment[1]);
        }
    }
    /* At rest the end of the patch moves with the last corner. */
    if (ANGLE_IS_ESTIMATED && patch->is_turning == 0) {
        by_angle = patch->corners > 0 ? by_angle + corner_moment[0] : 0.0;
    }
    moment[0] = total;
    moment[1] = by_scale;
    moment[2] = by_angle;
}

/* Advances the patch to angle and load of a sample. torque: M_z [N m], its derivatives by mu, by k over its
   nominal value, and by the angle. */
static void advance_patch(${name}_state_t *state, ${real} psi, ${real} F_N, ${real} mu, ${real} stiffness, ${real} *torque) {
    const ${real} k = ${k} * stiffness, scale = mu / k;
    ${real} moment[3];
    if (is_known(F_N) && F_N >= state->least_load) {
        state->F_N = F_N;
    }
    turn_patch(&state->patch, psi, ${level} * state->F_N, scale);
    patch_moment(&state->patch, scale, moment);
    torque[0] = k * moment[0];
    torque[1] = moment[1];
    torque[2] = ${k} * (moment[0] - scale * moment[1]);
    torque[3] = k * moment[2];
}

/* The state before the first sample. */
static void begin(${name}_state_t *state, const ${real} *sample) {
    const ${real} *arg[] = {sample${constants_at}};
    ${real} *res[${start_res}] = {state->values[0]};
    (void)begin_filter(arg, res, 0, 0, 0);
    clear_patch(&state->patch, sample[0]);
    state->F_N = sample[2];
    state->least_load = ${least_load} * sample[2];
    state->now = 0;
}

/* One sample: from one half of the state to the other; where the estimate is not finite the observer starts anew. */
static int32_t advance(${name}_state_t *state, const ${real} *sample) {
    ${real} output[OUTPUTS], torque[4], *before = state->values[state->now], *after = state->values[1 - state->now];
    const ${real} *arg[] = {before, sample${constants_at}};
    ${real} *res[${res}] = {after, output};
    int i;
${patch_before}    (void)filter(arg, res, 0, 0, 0);
    if (!(is_known(output[OUT_MU]) && is_known(output[OUT_MU_STD]) && is_known(output[OUT_M_Z_PREDICTED]))) {
        /* The patch has moved: what it has become is not to be relied on. */
        ${name}_reset(state);
        state->output[OUT_STATUS] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
${patch_after}    state->now = 1 - state->now;
    for (i = 0; i < OUTPUTS; ++i) {
        state->output[i] = output[i];
    }
    return (int32_t)output[OUT_STATUS];
}
