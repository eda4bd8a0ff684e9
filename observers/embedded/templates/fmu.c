/* $described
   As a slave of FMI 2.0 co-simulation: a communication step is one sample.

   $generated */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "$name.h"
#include "fmi2.h"

#define GUID "$guid"

/* Value references, as in modelDescription.xml. */
enum { PSI, PSI_DOT, TORQUE, LOAD, INPUTS, MU = INPUTS, MU_STD, M_Z_PREDICTED, INFORMED, STATUS };
enum { INSTANTIATED, INITIALISING, STEPPING, TERMINATED };

/* All that a saved state holds: one block, without a pointer. */
typedef struct {
    char guid[sizeof GUID];
    ${name}_state_t observer;
    double given[INPUTS];
    double before; /* communication point of the last sample, if there was one */
    int32_t sampled, phase;
} held_t;

typedef struct {
    held_t held;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char name[64];
} instance_t;

static void begin_anew(held_t *held) {
    int i;
    memset(held, 0, sizeof *held);
    memcpy(held->guid, GUID, sizeof GUID);
    for (i = 0; i < INPUTS; ++i) held->given[i] = (double)NAN;
    ${name}_init(&held->observer);
}

static fmi2Status fault(const instance_t *one, const char *message) {
    if (one->logger != NULL) one->logger(one->environment, one->name, fmi2Error, "logStatusError", message);
    return fmi2Error;
}

/* From one phase into the next. */
static fmi2Status enter(instance_t *one, int32_t from, int32_t to) {
    if (one->held.phase != from) return fault(one, "called out of order");
    one->held.phase = to;
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
    instance_t *one = calloc(1, sizeof *one);
    (void)resources, (void)visible, (void)logging;
    if (one == NULL) return NULL;
    if (callbacks != NULL) {
        one->logger = callbacks->logger;
        one->environment = callbacks->componentEnvironment;
    }
    if (name != NULL) strncat(one->name, name, sizeof one->name - 1);
    begin_anew(&one->held);
    if (type == fmi2CoSimulation && guid != NULL && strcmp(guid, GUID) == 0) return one;
    fault(one, type == fmi2CoSimulation ? "the GUID is another model's" : "only co-simulation is offered");
    free(one);
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
    begin_anew(&((instance_t *)c)->held);
    return fmi2OK;
}

/* Takes the inputs as a sample. Its time is that since the last one, as where steps vary it was not known
   how long this one lasts; only the first has to take the step that it begins. */
FMI2(fmi2Status, DoStep)(fmi2Component c, fmi2Real at, fmi2Real step, fmi2Boolean kept) {
    held_t *held = &((instance_t *)c)->held;
    ${name}_sample_t sample;
    (void)kept;
    if (held->phase != STEPPING) return fault(c, "fmi2DoStep before initialisation, or after termination");
    if (!(step > 0.0)) return fault(c, "a communication step must be greater than 0 s");
    sample.psi = ($real)held->given[PSI];
    sample.psi_dot = ($real)held->given[PSI_DOT];
    sample.$torque = ($real)held->given[TORQUE];
    sample.F_N = ($real)held->given[LOAD];
    sample.dt = ($real)(held->sampled ? at - held->before : step);
    ${name}_step(&held->observer, &sample);
    held->before = at;
    held->sampled = 1;
    return fmi2OK;
}

FMI2(fmi2Status, SetReal)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2Real values[]) {
    size_t i;
    for (i = 0; i < count; ++i) {
        if (at[i] >= INPUTS) return fault(c, "only inputs can be set");
        ((instance_t *)c)->held.given[at[i]] = values[i];
    }
    return fmi2OK;
}

FMI2(fmi2Status, GetReal)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2Real values[]) {
    const held_t *held = &((instance_t *)c)->held;
    ${name}_estimate_t now;
    size_t i;
    ${name}_estimate(&held->observer, &now);
    for (i = 0; i < count; ++i) {
        if (at[i] > M_Z_PREDICTED) return fault(c, "no real variable has this value reference");
        values[i] = at[i] < INPUTS    ? held->given[at[i]]
                    : at[i] == MU     ? (double)now.mu
                    : at[i] == MU_STD ? (double)now.mu_std
                                      : (double)now.M_z_predicted;
    }
    return fmi2OK;
}

static fmi2Status flag(fmi2Component c, fmi2ValueReference only, const fmi2ValueReference at[], size_t count,
                       int values[]) {
    ${name}_estimate_t now;
    size_t i;
    ${name}_estimate(&((instance_t *)c)->held.observer, &now);
    for (i = 0; i < count; ++i) {
        if (at[i] != only) return fault(c, "no variable of this type has this value reference");
        values[i] = only == INFORMED ? (int)now.informed : (int)now.status;
    }
    return fmi2OK;
}

FMI2(fmi2Status, GetInteger)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2Integer values[]) {
    return flag(c, STATUS, at, count, values);
}

FMI2(fmi2Status, GetBoolean)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2Boolean values[]) {
    return flag(c, INFORMED, at, count, values);
}

/* A state that is there already may be handed in, to be overwritten. */
FMI2(fmi2Status, GetFMUstate)(fmi2Component c, fmi2FMUstate *state) {
    if (*state == NULL) *state = malloc(sizeof(held_t));
    if (*state == NULL) return fault(c, "no memory for a state");
    memcpy(*state, &((instance_t *)c)->held, sizeof(held_t));
    return fmi2OK;
}

FMI2(fmi2Status, SetFMUstate)(fmi2Component c, fmi2FMUstate state) {
    memcpy(&((instance_t *)c)->held, state, sizeof(held_t));
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
    *size = sizeof(held_t);
    return fmi2OK;
}

FMI2(fmi2Status, SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (size != sizeof(held_t)) return fault(c, "a state has another size");
    memcpy(bytes, state, size);
    return fmi2OK;
}

FMI2(fmi2Status, DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    if (size != sizeof(held_t) || memcmp(bytes, GUID, sizeof GUID) != 0)
        return fault(c, "these bytes are no state of this model");
    if (*state == NULL) *state = malloc(size);
    if (*state == NULL) return fault(c, "no memory for a state");
    memcpy(*state, bytes, size);
    return fmi2OK;
}

/* What is not offered, as modelDescription.xml says. ------------------------------------------------- */

static fmi2Status nothing(fmi2Component c, size_t count) {
    return count == 0 ? fmi2OK : fault(c, "not offered by this model");
}

FMI2(fmi2Status, SetInteger)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2Integer v[]) {
    (void)at, (void)v;
    return nothing(c, count);
}

FMI2(fmi2Status, SetBoolean)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2Boolean v[]) {
    (void)at, (void)v;
    return nothing(c, count);
}

FMI2(fmi2Status, SetString)(fmi2Component c, const fmi2ValueReference at[], size_t count, const fmi2String v[]) {
    (void)at, (void)v;
    return nothing(c, count);
}

FMI2(fmi2Status, GetString)(fmi2Component c, const fmi2ValueReference at[], size_t count, fmi2String v[]) {
    (void)at, (void)v;
    return nothing(c, count);
}

FMI2(fmi2Status, GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference of[], size_t count,
                                          const fmi2ValueReference by[], size_t known, const fmi2Real along[],
                                          fmi2Real v[]) {
    (void)of, (void)by, (void)known, (void)along, (void)v;
    return nothing(c, count);
}

FMI2(fmi2Status, SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference at[], size_t count,
                                         const fmi2Integer order[], const fmi2Real v[]) {
    (void)at, (void)order, (void)v;
    return nothing(c, count);
}

FMI2(fmi2Status, GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference at[], size_t count,
                                          const fmi2Integer order[], fmi2Real v[]) {
    (void)at, (void)order, (void)v;
    return nothing(c, count);
}

FMI2(fmi2Status, CancelStep)(fmi2Component c) { return fault(c, "a step is over when fmi2DoStep returns"); }

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
