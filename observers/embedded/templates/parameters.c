/* Those that the code was generated with: volatile, as a calibration tool may lay others over them. */
const volatile ${name}_parameters_t ${name}_defaults = {
    ${p.literal}, /* ${p.field} [${p.unit}] */ %% for p in parameters
};

int32_t ${name}_check_parameters(const ${name}_parameters_t *at) {
%% for p in parameters
    if (!(${p.condition})) {
        return ${loop.index}; /* ${p.field} */
    }
%% endfor
%% for place, condition in relations
    if (!(${condition})) {
        return ${place};
    }
%% endfor
    return 0;
}

/* The vector of constants of the computation. */
static void take_parameters(${name}_state_t *state, const volatile ${name}_parameters_t *at) {
    state->constants[${place}] = ${value}; %% for place, value in constants
%% for p in parameters
    state->constants[${place}] = ${"1.0 / " if p.inverse}at->${p.field}; %% for place in p.places
%% endfor
    set_geometry(&state->patch, at->k, at->a, at->e); %% if rig_at_run_time
}
