/* ${title}
   FMI 2.0 co-simulation slave: a communication step is one sample.

   ${generated} */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "${name}.h"
#include "fmi2.h"

%% include "fmu_state.c"
/* The interface of FMI 2.0. ------------------------------------------------------------------------------ */

typedef struct {
    fmu_state_t state;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char name[64];
} instance_t;

static fmi2Status report(const instance_t *instance, const char *message) {
    if (instance->logger != NULL) instance->logger(instance->environment, instance->name, fmi2Error, "logStatusError", message);
    return fmi2Error;
}

/* Goes from one phase to the next. */
static fmi2Status enter(instance_t *instance, int32_t from, int32_t to) {
    if (instance->state.phase != from) return report(instance, "called out of order");
    instance->state.phase = to;
    return fmi2OK;
}

FMI2(const char *, GetTypesPlatform)(void) { return "default"; }
FMI2(const char *, GetVersion)(void) { return "2.0"; }

FMI2(fmi2Status, SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK;
}

FMI2(fmi2Component, Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    instance_t *instance = calloc(1, sizeof *instance);
    (void)resources, (void)visible, (void)logging;
    if (instance == NULL) return NULL;
    if (callbacks != NULL) {
        instance->logger = callbacks->logger;
        instance->environment = callbacks->componentEnvironment;
    }
    if (name != NULL) strncat(instance->name, name, sizeof instance->name - 1);
    reset_state(&instance->state);
    if (type == fmi2CoSimulation && guid != NULL && strcmp(guid, GUID) == 0) return instance;
    report(instance, type == fmi2CoSimulation ? "the GUID is another model's" : "only co-simulation is offered");
    free(instance);
    return NULL;
}

FMI2(void, FreeInstance)(fmi2Component c) { free(c); }

FMI2(fmi2Status, SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_given, fmi2Real tolerance, fmi2Real start,
                                 fmi2Boolean stop_given, fmi2Real stop) {
    (void)c, (void)tolerance_given, (void)tolerance, (void)start, (void)stop_given, (void)stop;
    return fmi2OK;
}

FMI2(fmi2Status, EnterInitializationMode)(fmi2Component c) { return enter(c, INSTANTIATED, INITIALISING); }
FMI2(fmi2Status, ExitInitializationMode)(fmi2Component c) { return enter(c, INITIALISING, STEPPING); }
FMI2(fmi2Status, Terminate)(fmi2Component c) { return enter(c, STEPPING, TERMINATED); }

FMI2(fmi2Status, Reset)(fmi2Component c) {
    reset_state(&((instance_t *)c)->state);
    return fmi2OK;
}

FMI2(fmi2Status, DoStep)(fmi2Component c, fmi2Real at, fmi2Real step, fmi2Boolean no_set_state) {
    fmu_state_t *state = &((instance_t *)c)->state;
    (void)no_set_state;
    if (state->phase != STEPPING) return report(c, "fmi2DoStep before initialisation, or after termination");
    if (!(step > 0.0)) return report(c, "a communication step must be greater than 0 s");
    take_sample(state, at, step);
    return fmi2OK;
}

FMI2(fmi2Status, SetReal)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2Real values[]) {
    const char *fault = set_numbers(&((instance_t *)c)->state, at, count, values);
    return fault == NULL ? fmi2OK : report(c, fault);
}

FMI2(fmi2Status, GetReal)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2Real values[]) {
    size_t i;
    for (i = 0; i < count; ++i)
        if (!find_number(&((instance_t *)c)->state, at[i], &values[i])) return report(c, "no real variable has this value reference");
    return fmi2OK;
}

static fmi2Status flag(fmi2Component c, fmi2ValueReference only, const fmi2ValueReference at[], size_t count,
                       int values[]) {
    ${name}_estimate_t estimate;
    size_t i;
    ${name}_estimate(&((instance_t *)c)->state.observer, &estimate);
    for (i = 0; i < count; ++i) {
        if (at[i] != only && (at[i] != USABLE || only != INFORMED)) return report(c, "no variable of this type has this value reference");
        values[i] = at[i] == INFORMED ? (int)estimate.informed : at[i] == USABLE ? (int)estimate.usable : (int)estimate.status;
    }
    return fmi2OK;
}

FMI2(fmi2Status, GetInteger)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2Integer values[]) {
    return flag(c, STATUS, at, count, values);
}

FMI2(fmi2Status, GetBoolean)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2Boolean values[]) {
    return flag(c, INFORMED, at, count, values);
}

/* An existing state is overwritten. */
FMI2(fmi2Status, GetFMUstate)(fmi2Component c, fmi2FMUstate *state) {
    if (*state == NULL) *state = malloc(sizeof(fmu_state_t));
    if (*state == NULL) return report(c, "no memory for a state");
    memcpy(*state, &((instance_t *)c)->state, sizeof(fmu_state_t));
    return fmi2OK;
}

FMI2(fmi2Status, SetFMUstate)(fmi2Component c, fmi2FMUstate state) {
    memcpy(&((instance_t *)c)->state, state, sizeof(fmu_state_t));
    return fmi2OK;
}

FMI2(fmi2Status, FreeFMUstate)(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

FMI2(fmi2Status, SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c, (void)state;
    *size = SERIALISED;
    return fmi2OK;
}

FMI2(fmi2Status, SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (size != SERIALISED) return report(c, "a serialised state has another size");
    serialise(state, bytes);
    return fmi2OK;
}

FMI2(fmi2Status, DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    const char *fault = fault_of(bytes, size);
    if (fault != NULL) return report(c, fault);
    if (*state == NULL) *state = malloc(sizeof(fmu_state_t));
    if (*state == NULL) return report(c, "no memory for a state");
    memcpy(*state, bytes, sizeof(fmu_state_t));
    return fmi2OK;
}

/* Not supported, see modelDescription.xml. ------------------------------------------------- */

static fmi2Status unsupported(fmi2Component c, size_t count) {
    return count == 0 ? fmi2OK : report(c, "not offered by this model");
}

FMI2(fmi2Status, SetInteger)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2Integer v[]) {
    (void)at, (void)v;
    return unsupported(c, count);
}

FMI2(fmi2Status, SetBoolean)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2Boolean v[]) {
    (void)at, (void)v;
    return unsupported(c, count);
}

FMI2(fmi2Status, SetString)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2String v[]) {
    (void)at, (void)v;
    return unsupported(c, count);
}

FMI2(fmi2Status, GetString)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2String v[]) {
    (void)at, (void)v;
    return unsupported(c, count);
}

FMI2(fmi2Status, GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference of[], size_t count,
                                          const fmi2ValueReference by[], size_t known, const fmi2Real along[],
                                          fmi2Real v[]) {
    (void)of, (void)by, (void)known, (void)along, (void)v;
    return unsupported(c, count);
}

FMI2(fmi2Status, SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference at[], size_t count,
                                         const fmi2Integer order[], const fmi2Real v[]) {
    (void)at, (void)order, (void)v;
    return unsupported(c, count);
}

FMI2(fmi2Status, GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference at[], size_t count,
                                          const fmi2Integer order[], fmi2Real v[]) {
    (void)at, (void)order, (void)v;
    return unsupported(c, count);
}

FMI2(fmi2Status, CancelStep)(fmi2Component c) { return report(c, "a step is over when fmi2DoStep returns"); }

/* The standard's answer of a slave whose steps are over when they return. */
FMI2(fmi2Status, GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

FMI2(fmi2Status, GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

FMI2(fmi2Status, GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

FMI2(fmi2Status, GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

FMI2(fmi2Status, GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
