/* A small co-simulation master for the sanitisers: two instances in turn, a state saved, transferred and restored,
   calls that must be refused. Compiled with GUID. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2.h"

fmi2Component fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
                              fmi2Boolean, fmi2Boolean);
void fmi2FreeInstance(fmi2Component);
fmi2Status fmi2EnterInitializationMode(fmi2Component);
fmi2Status fmi2ExitInitializationMode(fmi2Component);
fmi2Status fmi2Reset(fmi2Component);
fmi2Status fmi2SetReal(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Real[]);
fmi2Status fmi2GetReal(fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
fmi2Status fmi2GetInteger(fmi2Component, const fmi2ValueReference[], size_t, fmi2Integer[]);
fmi2Status fmi2DoStep(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
fmi2Status fmi2GetFMUstate(fmi2Component, fmi2FMUstate *);
fmi2Status fmi2SetFMUstate(fmi2Component, fmi2FMUstate);
fmi2Status fmi2FreeFMUstate(fmi2Component, fmi2FMUstate *);
fmi2Status fmi2SerializedFMUstateSize(fmi2Component, fmi2FMUstate, size_t *);
fmi2Status fmi2SerializeFMUstate(fmi2Component, fmi2FMUstate, fmi2Byte[], size_t);
fmi2Status fmi2DeSerializeFMUstate(fmi2Component, const fmi2Byte[], size_t, fmi2FMUstate *);

static int messages = 0;

static void count_message(fmi2ComponentEnvironment who, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {
    (void)who, (void)name, (void)status, (void)category, (void)message;
    ++messages;
}

static const fmi2CallbackFunctions CALLBACKS = {count_message, calloc, free, NULL, NULL};
static const fmi2ValueReference INPUTS[] = {0, 1, 2, 3}, MU[] = {4}, NONE[] = {4000000000u};

static fmi2Component start(const char *name) {
    fmi2Component one = fmi2Instantiate(name, fmi2CoSimulation, GUID, "", &CALLBACKS, 0, 0);
    if (one == NULL || fmi2EnterInitializationMode(one) != fmi2OK || fmi2ExitInitializationMode(one) != fmi2OK)
        exit(3);
    return one;
}

static double mu_after(fmi2Component one, int from, int to) {
    double mu;
    int i;
    for (i = from; i < to; ++i) {
        const double inputs[] = {0.2 * sin(0.05 * i), i % 7 ? NAN : 0.0, -7.0 * sin(0.05 * i), i % 11 ? 400.0 : -INFINITY};
        if (fmi2SetReal(one, INPUTS, 4, inputs) != fmi2OK || fmi2DoStep(one, 0.01 * i, 0.01, 1) != fmi2OK) exit(4);
    }
    return fmi2GetReal(one, MU, 1, &mu) == fmi2OK ? mu : NAN;
}

int main(void) {
    fmi2Component one = start("a name that is longer than any that is saved, so that it has to be cut off"),
                  two = start("two");
    fmi2FMUstate saved = NULL, received = NULL;
    fmi2Byte *bytes;
    size_t size;
    double first, other, nothing = 0.0;
    int whole, refused = 0;
    mu_after(one, 0, 200);
    fmi2GetFMUstate(one, &saved);
    fmi2GetFMUstate(one, &saved);
    fmi2SerializedFMUstateSize(one, saved, &size);
    bytes = malloc(size);
    fmi2SerializeFMUstate(one, saved, bytes, size);
    first = mu_after(one, 200, 300);
    if (fmi2DeSerializeFMUstate(two, bytes, size, &received) != fmi2OK) return 5;
    fmi2SetFMUstate(two, received);
    other = mu_after(two, 200, 300);
    refused += fmi2DeSerializeFMUstate(two, bytes, size - 1, &received) == fmi2Error;
    refused += fmi2SetReal(one, NONE, 1, &nothing) == fmi2Error;
    refused += fmi2GetReal(one, NONE, 1, &nothing) == fmi2Error;
    refused += fmi2GetInteger(one, NONE, 1, &whole) == fmi2Error;
    refused += fmi2Instantiate("three", fmi2ModelExchange, GUID, "", &CALLBACKS, 0, 0) == NULL;
    refused += fmi2Instantiate("four", fmi2CoSimulation, "another", "", NULL, 0, 0) == NULL;
    fmi2Reset(one);
    fmi2FreeFMUstate(one, &saved);
    fmi2FreeFMUstate(two, &received);
    fmi2FreeFMUstate(two, &received);
    fmi2FreeInstance(one);
    fmi2FreeInstance(two);
    fmi2FreeInstance(NULL);
    free(bytes);
    printf("mu %g and %g; %d refused, %d messages\n", first, other, refused, messages);
    return first == other && refused == 6 && messages == 5 ? 0 : 1;
}
