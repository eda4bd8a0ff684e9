/* ${title}
   FMI ${number}.0 co-simulation: a communication step is one sample.

   ${generated} */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "${name}.h"
#include "${fmi}.h"

%% include "fmu/state.c"
/* The interface of FMI ${number}.0. ------------------------------------------------------------------------------ */

typedef struct {
    fmu_state_t state;
    ${fmi}${logger} logger;
    ${instance}Environment environment;
    char name[64]; %% if number == 2
} instance_t;

static ${fmi}Status report(const instance_t *instance, const char *message) {
    if (instance->logger != NULL) instance->logger(instance->environment, ${"instance->name, " if number == 2}${fmi}Error, "logStatusError", message);
    return ${fmi}Error;
}

%% if array
static const char *const NO_ARRAY = "no variable is an array";

%% endif
/* Goes from one phase to the next. */
static ${fmi}Status enter(instance_t *instance, int32_t from, int32_t to) {
    if (instance->state.phase != from) return report(instance, "called out of order");
    instance->state.phase = to;
    return ${fmi}OK;
}

%% include "fmu/" ~ fmi ~ "_steps.c"
${fmi|upper}(${fmi}Status, Set${real_type})(${instance} c, const ${fmi}ValueReference at[], size_t count, const ${fmi}${real_type} values[]${array}) {
    const char *fault = ${"values_count != count ? NO_ARRAY : " if array}set_numbers(&((instance_t *)c)->state, at, count, values);
    return fault == NULL ? ${fmi}OK : report(c, fault);
}

${fmi|upper}(${fmi}Status, Get${real_type})(${instance} c, const ${fmi}ValueReference at[], size_t count, ${fmi}${real_type} values[]${array}) {
    size_t i;
    if (values_count != count) return report(c, NO_ARRAY); %% if array
    for (i = 0; i < count; ++i)
        if (!find_number(&((instance_t *)c)->state, at[i], &values[i])) return report(c, "no ${real_type} variable has this value reference");
    return ${fmi}OK;
}

%% for type in (integer_type, "Boolean")
${fmi|upper}(${fmi}Status, Get${type})(${instance} c, const ${fmi}ValueReference at[], size_t count, ${fmi}${type} values[]${array}) {
    size_t i;
    int32_t value;
    if (values_count != count) return report(c, NO_ARRAY); %% if array
    for (i = 0; i < count; ++i) {
        if (!find_flag(&((instance_t *)c)->state, at[i], &value) || (at[i] == STATUS) != ${"0" if type == "Boolean" else "1"}) return report(c, "no ${type} variable has this value reference");
        values[i] = ${"value != 0" if type == "Boolean" else "value"};
    }
    return ${fmi}OK;
}

%% endfor
${fmi|upper}(${fmi}Status, SetDebugLogging)(${instance} c, ${fmi}Boolean on, size_t count, const ${fmi}String categories[]) {
    (void)c, (void)on, (void)count, (void)categories;
    return ${fmi}OK;
}

${fmi|upper}(void, FreeInstance)(${instance} c) { free(c); }

${fmi|upper}(${fmi}Status, ExitInitializationMode)(${instance} c) { return enter(c, INITIALISING, STEPPING); }
${fmi|upper}(${fmi}Status, Terminate)(${instance} c) { return enter(c, STEPPING, TERMINATED); }

${fmi|upper}(${fmi}Status, Reset)(${instance} c) {
    reset_state(&((instance_t *)c)->state);
    return ${fmi}OK;
}

/* An existing state is overwritten. */
${fmi|upper}(${fmi}Status, Get${state})(${instance} c, ${fmi}${state} *state) {
    if (*state == NULL) *state = malloc(sizeof(fmu_state_t));
    if (*state == NULL) return report(c, "no memory for a state");
    memcpy(*state, &((instance_t *)c)->state, sizeof(fmu_state_t));
    return ${fmi}OK;
}

${fmi|upper}(${fmi}Status, Set${state})(${instance} c, ${fmi}${state} state) {
    memcpy(&((instance_t *)c)->state, state, sizeof(fmu_state_t));
    return ${fmi}OK;
}

${fmi|upper}(${fmi}Status, Free${state})(${instance} c, ${fmi}${state} *state) {
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return ${fmi}OK;
}

${fmi|upper}(${fmi}Status, Serialized${state}Size)(${instance} c, ${fmi}${state} state, size_t *size) {
    (void)c, (void)state;
    *size = SERIALISED;
    return ${fmi}OK;
}

${fmi|upper}(${fmi}Status, Serialize${state})(${instance} c, ${fmi}${state} state, ${fmi}Byte bytes[], size_t size) {
    if (size != SERIALISED) return report(c, "a serialised state has another size");
    serialise(state, bytes);
    return ${fmi}OK;
}

${fmi|upper}(${fmi}Status, ${deserialize})(${instance} c, const ${fmi}Byte bytes[], size_t size, ${fmi}${state} *state) {
    const char *fault = fault_of(bytes, size);
    if (fault != NULL) return report(c, fault);
    if (*state == NULL) *state = malloc(sizeof(fmu_state_t));
    if (*state == NULL) return report(c, "no memory for a state");
    memcpy(*state, bytes, sizeof(fmu_state_t));
    return ${fmi}OK;
}

/* Not supported, see modelDescription.xml. --------------------------------------------------------------- */

static ${fmi}Status unsupported(${instance} c, size_t count) {
    return count == 0 ? ${fmi}OK : report(c, "not offered by this model");
}

%% for name, parameters in unsupported
${fmi|upper}(${fmi}Status, ${name})(${instance} c${", " if parameters}${parameters}) {
    ${unused(parameters)} %% if parameters
    return unsupported(c, ${"count" if "size_t count" in parameters else "1"});
}

%% endfor
%% for name, parameters in discarded
${fmi|upper}(${fmi}Status, ${name})(${instance} c, ${parameters}) {
    (void)c, ${unused(parameters)}
    return ${fmi}Discard;
}

%% endfor
