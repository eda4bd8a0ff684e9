%% if not tunable
/* Parameters, rig and tuning; ${name}.json lists them by name and unit. */
static const ${real} constants[${constants|length}] = {
    ${value}, /* ${label} */ %% for value, label in constants
};

%% endif
/* The state before the first sample. */
static void begin(${name}_state_t *state, const ${real} *sample) {
    const ${real} *arg[${arg}] = {sample, ${"state->constants" if tunable else "constants"}};
    ${real} *res[${res}] = {state->values[0]};
    (void)${initial}(arg, res, state->integers, state->scratch, 0);
    state->now = 0;
}

/* One sample: from one half of the state to the other, which becomes valid only if the estimate is finite. */
static int32_t advance(${name}_state_t *state, const ${real} *sample) {
    ${real} output[OUTPUTS];
    const ${real} *arg[${arg}] = {state->values[state->now], sample, ${"state->constants" if tunable else "constants"}};
    ${real} *res[${res}] = {state->values[1 - state->now], output};
    (void)${step}(arg, res, state->integers, state->scratch, 0);
    if (!(is_known(output[OUT_MU]) && is_known(output[OUT_MU_STD]) && is_known(output[OUT_M_Z_PREDICTED]))) {
        state->output[OUT_STATUS] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    state->now = 1 - state->now;
    set_numbers(state->output, output, OUTPUTS);
    return (int32_t)output[OUT_STATUS];
}
