/* ${title}
   FMI 3.0 co-simulation: a communication step is one sample.

   ${generated} */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "${name}.h"
#include "fmi3.h"

%% include "fmu_state.c"
/* The interface of FMI 3.0. ------------------------------------------------------------------------------ */

typedef struct {
    fmu_state_t state;
    fmi3LogMessageCallback logger;
    fmi3InstanceEnvironment environment;
} instance_t;

static fmi3Status report(const instance_t *instance, const char *message) {
    if (instance->logger != NULL) instance->logger(instance->environment, fmi3Error, "logStatusError", message);
    return fmi3Error;
}

/* Goes from one phase to the next. */
static fmi3Status enter(instance_t *instance, int32_t from, int32_t to) {
    if (instance->state.phase != from) return report(instance, "called out of order");
    instance->state.phase = to;
    return fmi3OK;
}

FMI3(const char *, GetVersion)(void) { return "3.0"; }

FMI3(fmi3Status, SetDebugLogging)(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[]) {
    (void)c, (void)on, (void)count, (void)categories;
    return fmi3OK;
}

FMI3(fmi3Instance, InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                           fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                           const fmi3ValueReference intermediate[], size_t intermediates,
                                           fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                           fmi3IntermediateUpdateCallback update) {
    instance_t *instance = calloc(1, sizeof *instance);
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)intermediate, (void)intermediates, (void)update;
    if (instance == NULL) return NULL;
    instance->logger = logger;
    instance->environment = environment;
    reset_state(&instance->state);
    if (token != NULL && strcmp(token, GUID) == 0) return instance;
    report(instance, "the instantiation token is another model's");
    free(instance);
    return NULL;
}

FMI3(fmi3Instance, InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                            fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                            fmi3LogMessageCallback logger) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    if (logger != NULL) logger(environment, fmi3Error, "logStatusError", "only co-simulation is offered");
    return NULL;
}

FMI3(fmi3Instance, InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources,
                                                 fmi3Boolean visible, fmi3Boolean logging,
                                                 fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                                 fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                                 fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)update, (void)lock, (void)unlock;
    if (logger != NULL) logger(environment, fmi3Error, "logStatusError", "only co-simulation is offered");
    return NULL;
}

FMI3(void, FreeInstance)(fmi3Instance c) { free(c); }

FMI3(fmi3Status, EnterInitializationMode)(fmi3Instance c, fmi3Boolean tolerance_given, fmi3Float64 tolerance,
                                         fmi3Float64 start, fmi3Boolean stop_given, fmi3Float64 stop) {
    (void)tolerance_given, (void)tolerance, (void)stop_given, (void)stop;
    ((instance_t *)c)->state.end = start;
    return enter(c, INSTANTIATED, INITIALISING);
}

FMI3(fmi3Status, ExitInitializationMode)(fmi3Instance c) { return enter(c, INITIALISING, STEPPING); }
FMI3(fmi3Status, Terminate)(fmi3Instance c) { return enter(c, STEPPING, TERMINATED); }

FMI3(fmi3Status, Reset)(fmi3Instance c) {
    reset_state(&((instance_t *)c)->state);
    return fmi3OK;
}

FMI3(fmi3Status, DoStep)(fmi3Instance c, fmi3Float64 at, fmi3Float64 step, fmi3Boolean no_set_state, fmi3Boolean *event,
                        fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
    instance_t *instance = c;
    (void)no_set_state;
    if (instance->state.phase != STEPPING) return report(c, "fmi3DoStep before initialisation, or after termination");
    if (!(step > 0.0)) return report(c, "a communication step must be greater than 0 s");
    take_sample(&instance->state, at, step);
    *event = false;
    *terminate = false;
    *early = false;
    *last = instance->state.end;
    return fmi3OK;
}

FMI3(fmi3Status, SetFloat64)(fmi3Instance c, const fmi3ValueReference at[], size_t count, const fmi3Float64 values[],
                            size_t values_count) {
    const char *fault;
    if (values_count != count) return report(c, "no variable is an array");
    fault = set_numbers(&((instance_t *)c)->state, at, count, values);
    return fault == NULL ? fmi3OK : report(c, fault);
}

FMI3(fmi3Status, GetFloat64)(fmi3Instance c, const fmi3ValueReference at[], size_t count, fmi3Float64 values[],
                            size_t values_count) {
    size_t i;
    if (values_count != count) return report(c, "no variable is an array");
    for (i = 0; i < count; ++i) {
        if (at[i] == TIME) values[i] = ((instance_t *)c)->state.end;
        else if (!find_number(&((instance_t *)c)->state, at[i], &values[i])) return report(c, "no Float64 variable has this value reference");
    }
    return fmi3OK;
}

FMI3(fmi3Status, GetInt32)(fmi3Instance c, const fmi3ValueReference at[], size_t count, fmi3Int32 values[],
                          size_t values_count) {
    ${name}_estimate_t estimate;
    size_t i;
    ${name}_estimate(&((instance_t *)c)->state.observer, &estimate);
    if (values_count != count) return report(c, "no variable is an array");
    for (i = 0; i < count; ++i) {
        if (at[i] != STATUS) return report(c, "no Int32 variable has this value reference");
        values[i] = estimate.status;
    }
    return fmi3OK;
}

FMI3(fmi3Status, GetBoolean)(fmi3Instance c, const fmi3ValueReference at[], size_t count, fmi3Boolean values[],
                            size_t values_count) {
    ${name}_estimate_t estimate;
    size_t i;
    ${name}_estimate(&((instance_t *)c)->state.observer, &estimate);
    if (values_count != count) return report(c, "no variable is an array");
    for (i = 0; i < count; ++i) {
        if (at[i] != INFORMED && at[i] != USABLE) return report(c, "no Boolean variable has this value reference");
        values[i] = at[i] == INFORMED ? estimate.informed != 0 : estimate.usable != 0;
    }
    return fmi3OK;
}

/* An existing state is overwritten. */
FMI3(fmi3Status, GetFMUState)(fmi3Instance c, fmi3FMUState *state) {
    if (*state == NULL) *state = malloc(sizeof(fmu_state_t));
    if (*state == NULL) return report(c, "no memory for a state");
    memcpy(*state, &((instance_t *)c)->state, sizeof(fmu_state_t));
    return fmi3OK;
}

FMI3(fmi3Status, SetFMUState)(fmi3Instance c, fmi3FMUState state) {
    memcpy(&((instance_t *)c)->state, state, sizeof(fmu_state_t));
    return fmi3OK;
}

FMI3(fmi3Status, FreeFMUState)(fmi3Instance c, fmi3FMUState *state) {
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

FMI3(fmi3Status, SerializedFMUStateSize)(fmi3Instance c, fmi3FMUState state, size_t *size) {
    (void)c, (void)state;
    *size = SERIALISED;
    return fmi3OK;
}

FMI3(fmi3Status, SerializeFMUState)(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    if (size != SERIALISED) return report(c, "a serialised state has another size");
    serialise(state, bytes);
    return fmi3OK;
}

FMI3(fmi3Status, DeserializeFMUState)(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    const char *fault = fault_of(bytes, size);
    if (fault != NULL) return report(c, fault);
    if (*state == NULL) *state = malloc(sizeof(fmu_state_t));
    if (*state == NULL) return report(c, "no memory for a state");
    memcpy(*state, bytes, sizeof(fmu_state_t));
    return fmi3OK;
}

/* No output depends on an input but by the step between them. */
FMI3(fmi3Status, GetNumberOfVariableDependencies)(fmi3Instance c, fmi3ValueReference at, size_t *count) {
    (void)c, (void)at;
    *count = 0;
    return fmi3OK;
}

FMI3(fmi3Status, GetVariableDependencies)(fmi3Instance c, fmi3ValueReference at, size_t elements[], fmi3ValueReference of[],
                                         size_t of_elements[], fmi3DependencyKind kinds[], size_t count) {
    (void)c, (void)at, (void)elements, (void)of, (void)of_elements, (void)kinds, (void)count;
    return fmi3OK;
}

/* Not supported, see modelDescription.xml. --------------------------------------------------------------- */

static fmi3Status unsupported(fmi3Instance c, size_t count) {
    return count == 0 ? fmi3OK : report(c, "not offered by this model");
}

%% for type in ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "Int64", "UInt64", "String")
FMI3(fmi3Status, Get${type})(fmi3Instance c, const fmi3ValueReference at[], size_t count, fmi3${type} values[], size_t n) {
    (void)at, (void)values, (void)n;
    return unsupported(c, count);
}

%% endfor
%% for type in ("Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean", "String")
FMI3(fmi3Status, Set${type})(fmi3Instance c, const fmi3ValueReference at[], size_t count, const fmi3${type} values[], size_t n) {
    (void)at, (void)values, (void)n;
    return unsupported(c, count);
}

%% endfor
FMI3(fmi3Status, GetBinary)(fmi3Instance c, const fmi3ValueReference at[], size_t count, size_t sizes[], fmi3Binary values[], size_t n) {
    (void)at, (void)sizes, (void)values, (void)n;
    return unsupported(c, count);
}

FMI3(fmi3Status, SetBinary)(fmi3Instance c, const fmi3ValueReference at[], size_t count, const size_t sizes[], const fmi3Binary values[], size_t n) {
    (void)at, (void)sizes, (void)values, (void)n;
    return unsupported(c, count);
}

FMI3(fmi3Status, GetClock)(fmi3Instance c, const fmi3ValueReference at[], size_t count, fmi3Clock values[]) {
    (void)at, (void)values;
    return unsupported(c, count);
}

FMI3(fmi3Status, SetClock)(fmi3Instance c, const fmi3ValueReference at[], size_t count, const fmi3Clock values[]) {
    (void)at, (void)values;
    return unsupported(c, count);
}

FMI3(fmi3Status, GetDirectionalDerivative)(fmi3Instance c, const fmi3ValueReference of[], size_t count, const fmi3ValueReference by[],
                                          size_t known, const fmi3Float64 seed[], size_t seeds, fmi3Float64 along[], size_t n) {
    (void)of, (void)by, (void)known, (void)seed, (void)seeds, (void)along, (void)n;
    return unsupported(c, count);
}

FMI3(fmi3Status, GetAdjointDerivative)(fmi3Instance c, const fmi3ValueReference of[], size_t count, const fmi3ValueReference by[],
                                      size_t known, const fmi3Float64 seed[], size_t seeds, fmi3Float64 along[], size_t n) {
    (void)of, (void)by, (void)known, (void)seed, (void)seeds, (void)along, (void)n;
    return unsupported(c, count);
}

FMI3(fmi3Status, GetOutputDerivatives)(fmi3Instance c, const fmi3ValueReference at[], size_t count, const fmi3Int32 orders[],
                                      fmi3Float64 values[], size_t n) {
    (void)at, (void)orders, (void)values, (void)n;
    return unsupported(c, count);
}

{% set of_clocks = [
    ("GetIntervalDecimal", "fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]", "(void)intervals, (void)qualifiers"),
    ("GetIntervalFraction", "fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]", "(void)counters, (void)resolutions, (void)qualifiers"),
    ("GetShiftDecimal", "fmi3Float64 shifts[]", "(void)shifts"),
    ("GetShiftFraction", "fmi3UInt64 counters[], fmi3UInt64 resolutions[]", "(void)counters, (void)resolutions"),
    ("SetIntervalDecimal", "const fmi3Float64 intervals[]", "(void)intervals"),
    ("SetIntervalFraction", "const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]", "(void)counters, (void)resolutions"),
    ("SetShiftDecimal", "const fmi3Float64 shifts[]", "(void)shifts"),
    ("SetShiftFraction", "const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]", "(void)counters, (void)resolutions"),
] %}
%% for name, more, unused in of_clocks
FMI3(fmi3Status, ${name})(fmi3Instance c, const fmi3ValueReference at[], size_t count, ${more}) {
    (void)at, ${unused};
    return unsupported(c, count);
}

%% endfor
FMI3(fmi3Status, UpdateDiscreteStates)(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals,
                                      fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    (void)again, (void)terminate, (void)nominals, (void)values, (void)defined, (void)next;
    return unsupported(c, 1);
}

FMI3(fmi3Status, CompletedIntegratorStep)(fmi3Instance c, fmi3Boolean no_set_state, fmi3Boolean *event, fmi3Boolean *terminate) {
    (void)no_set_state, (void)event, (void)terminate;
    return unsupported(c, 1);
}

FMI3(fmi3Status, SetTime)(fmi3Instance c, fmi3Float64 time) {
    (void)time;
    return unsupported(c, 1);
}

FMI3(fmi3Status, SetContinuousStates)(fmi3Instance c, const fmi3Float64 states[], size_t count) {
    (void)states;
    return unsupported(c, count);
}

%% for name in ("GetContinuousStateDerivatives", "GetEventIndicators", "GetContinuousStates", "GetNominalsOfContinuousStates")
FMI3(fmi3Status, ${name})(fmi3Instance c, fmi3Float64 values[], size_t count) {
    (void)values;
    return unsupported(c, count);
}

%% endfor
%% for name in ("GetNumberOfEventIndicators", "GetNumberOfContinuousStates")
FMI3(fmi3Status, ${name})(fmi3Instance c, size_t *count) {
    (void)c;
    *count = 0;
    return fmi3OK;
}

%% endfor
FMI3(fmi3Status, ActivateModelPartition)(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    return unsupported(c, 1);
}

%% for mode in ("EnterConfigurationMode", "ExitConfigurationMode", "EnterEventMode", "EnterContinuousTimeMode", "EnterStepMode", "EvaluateDiscreteStates")
FMI3(fmi3Status, ${mode})(fmi3Instance c) { return unsupported(c, 1); }
%% endfor
