/* Parameters, rig and beliefs; $name.json has them by name and unit. */
static const $real constants[$constants_count] = {
$constants
};

/* M_z [N m] of the patch, with its derivatives by mu and by k; they go with mu and k into five numbers. */
static void torque_of(const ${name}_patch_t *patch, $real mu, $real stiffness, $real *five) {
    const $real k = $k * stiffness, scale = mu / k;
    $real moment[3];
    patch_moment(patch, scale, moment);
    five[0] = k * moment[0];
    five[1] = moment[1];
    five[2] = moment[0] - scale * moment[1];
    five[3] = mu;
    five[4] = k;
}

/* The state before the first sample. */
static void begin(${name}_state_t *state, const $real *sample) {
    const $real *arg[$arg] = {sample, constants};
    $real *res[$res] = {state->values[0]};
    int i;
    start(arg, res, state->integers, state->scratch, 0);
    for (i = 0; i < $window; ++i) clear_patch(&state->patches[i], sample[0]);
    state->F_N = sample[2];
    state->now = 0;
    state->newest = 0;
}

/* One sample: from the one half of the state to the other, which counts only if all went well. The patch
   is kept as every sample of the window left it, and its torque taken anew at what is now believed. */
static int32_t advance(${name}_state_t *state, const $real *sample) {
    $real said[4], stiffness = 1.0, mu = 1.0, *before = state->values[state->now];
    const $real *arg[$arg] = {before, sample, constants};
    $real *res[$res] = {state->values[1 - state->now], said};
    const int32_t oldest = (state->newest + 1) % $window;
    ${name}_patch_t patch;
    int32_t i;
    for (i = 0; i < $window; ++i) {
        const $real *x = before + $x_at + $states * i;
        mu = exp(x[0]);
$stiffness_of_x        torque_of(&state->patches[(oldest + i) % $window], mu, stiffness, before + $memory_at + $memory_size * i);
    }
    patch = state->patches[state->newest];
    if (is_known(sample[2]) && sample[2] > 0.0) state->F_N = sample[2];
    turn_patch(&patch, is_known(sample[0]) ? sample[0] : patch.angle, $level * state->F_N, mu / ($k * stiffness));
    torque_of(&patch, mu, stiffness, before + $memory_at + $memory_size * ($window - 1) + 5);
    $step(arg, res, state->integers, state->scratch, 0);
    state->patches[oldest] = patch;
    state->newest = oldest;
    if (!(is_known(said[0]) && is_known(said[1]) && is_known(said[2]))) {
        state->said[3] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    state->now = 1 - state->now;
    for (i = 0; i < 4; ++i) state->said[i] = said[i];
    return (int32_t)said[3];
}
