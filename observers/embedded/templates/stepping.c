/* Parameters, rig and beliefs; $name.json has them by name and unit. */
static const $real constants[$constants_count] = {
$constants
};

/* The state before the first sample. */
static void begin(${name}_state_t *state, const $real *sample) {
    const $real *arg[$arg] = {sample, constants};
    $real *res[$res] = {state->values[0]};
    $start(arg, res, state->integers, state->scratch, 0);
    state->now = 0;
}

/* One sample: from the one half of the state to the other, which counts only if all went well. */
static int32_t advance(${name}_state_t *state, const $real *sample) {
    $real said[4];
    const $real *arg[$arg] = {state->values[state->now], sample, constants};
    $real *res[$res] = {state->values[1 - state->now], said};
    int i;
    $step(arg, res, state->integers, state->scratch, 0);
    if (!(is_known(said[0]) && is_known(said[1]) && is_known(said[2]))) {
        state->said[3] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    state->now = 1 - state->now;
    for (i = 0; i < 4; ++i) state->said[i] = said[i];
    return (int32_t)said[3];
}
