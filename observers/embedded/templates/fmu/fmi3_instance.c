typedef struct {
    fmu_state_t state;
    fmi3LogMessageCallback logger;
    fmi3InstanceEnvironment environment;
} instance_t;

static fmi3Status report(const instance_t *instance, const char *message) {
    if (instance->logger != NULL) instance->logger(instance->environment, fmi3Error, "logStatusError", message);
    return fmi3Error;
}

