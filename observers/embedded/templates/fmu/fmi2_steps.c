FMI2(const char *, GetTypesPlatform)(void) { return "default"; }
FMI2(const char *, GetVersion)(void) { return "2.0"; }

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

FMI2(fmi2Status, SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_given, fmi2Real tolerance, fmi2Real start,
                                 fmi2Boolean stop_given, fmi2Real stop) {
    (void)c, (void)tolerance_given, (void)tolerance, (void)start, (void)stop_given, (void)stop;
    return fmi2OK;
}

FMI2(fmi2Status, EnterInitializationMode)(fmi2Component c) { return enter(c, INSTANTIATED, INITIALISING); }
FMI2(fmi2Status, DoStep)(fmi2Component c, fmi2Real at, fmi2Real step, fmi2Boolean no_set_state) {
    fmu_state_t *state = &((instance_t *)c)->state;
    (void)no_set_state;
    if (state->phase != STEPPING) return report(c, "fmi2DoStep before initialisation, or after termination");
    if (!(step > 0.0)) return report(c, "a communication step must be greater than 0 s");
    take_sample(state, at, step);
    return fmi2OK;
}

FMI2(fmi2Status, CancelStep)(fmi2Component c) { return report(c, "a step is over when fmi2DoStep returns"); }

