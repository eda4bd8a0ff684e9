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

