FMI3(const char *, GetVersion)(void) { return "3.0"; }

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

%% for kind, further in (("ModelExchange", ""), ("ScheduledExecution", ", fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock"))
FMI3(fmi3Instance, Instantiate${kind})(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
                                       fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger${further}) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    ${unused(further)} %% if further
    if (logger != NULL) logger(environment, fmi3Error, "logStatusError", "only co-simulation is offered");
    return NULL;
}

%% endfor
FMI3(fmi3Status, EnterInitializationMode)(fmi3Instance c, fmi3Boolean tolerance_given, fmi3Float64 tolerance,
                                         fmi3Float64 start, fmi3Boolean stop_given, fmi3Float64 stop) {
    (void)tolerance_given, (void)tolerance, (void)stop_given, (void)stop;
    ((instance_t *)c)->state.end = start;
    return enter(c, INSTANTIATED, INITIALISING);
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

%% for name in ("GetNumberOfEventIndicators", "GetNumberOfContinuousStates")
FMI3(fmi3Status, ${name})(fmi3Instance c, size_t *count) {
    (void)c;
    *count = 0;
    return fmi3OK;
}

%% endfor
