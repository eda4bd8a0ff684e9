/* Parameters, rig and tuning; ${name}.json lists them by name and unit. */
static const ${real} constants[${constants|length}] = {
%% for value, label in constants
    ${value}, /* ${label} */
%% endfor
};

/* The state before the first sample. */
static void begin(${name}_state_t *state, const ${real} *sample) {
    const ${real} *arg[${arg}] = {sample, constants};
    ${real} *res[${res}] = {state->values[0]};
    ${initial}(arg, res, state->integers, state->scratch, 0);
    state->now = 0;
}

/* One sample: from one half of the state to the other, which becomes valid only if the estimate is finite. */
static int32_t advance(${name}_state_t *state, const ${real} *sample) {
    ${real} output[4];
    const ${real} *arg[${arg}] = {state->values[state->now], sample, constants};
    ${real} *res[${res}] = {state->values[1 - state->now], output};
    int i;
    ${step}(arg, res, state->integers, state->scratch, 0);
    if (!(is_known(output[0]) && is_known(output[1]) && is_known(output[2]))) {
        state->output[3] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    state->now = 1 - state->now;
    for (i = 0; i < 4; ++i) state->output[i] = output[i];
    return (int32_t)output[3];
}
