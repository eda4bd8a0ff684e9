/* What an FMU of any version has: variables, the state of an instance, a sample. ------------------------- */

#define GUID "${guid}"

/* Value references, as in modelDescription.xml. */
enum { PSI, PSI_DOT, TORQUE, LOAD, INPUTS, MU = INPUTS, MU_STD, M_Z_PREDICTED, INFORMED, STATUS, MU_EFF, MU_EFF_STD, M_SLIDE, NIS, TIME, USABLE, WEAKER, PARAMETERS };
enum { INSTANTIATED, INITIALISING, STEPPING, TERMINATED };

/* The FMU state: one block without pointers. */
typedef struct {
    char guid[sizeof GUID];
    ${name}_state_t observer;
    ${name}_parameters_t parameters; %% if tunable
    double inputs[INPUTS];
    double last_point; /* communication point of the last sample, if there was one */
    double end;        /* of the last communication step, or the start */
    int32_t sampled, phase;
} fmu_state_t;

static void reset_state(fmu_state_t *state) {
    int i;
    memset(state, 0, sizeof *state);
    memcpy(state->guid, GUID, sizeof GUID);
    for (i = 0; i < INPUTS; ++i) state->inputs[i] = (double)NAN;
    ${name}_init(&state->observer);
    state->parameters = ${name}_defaults; %% if tunable
}

/* Advances by one sample. Its dt is the time since the last communication point, which differs from `step` where
   steps vary; the first sample has none and takes `step`. */
static void take_sample(fmu_state_t *state, double at, double step) {
    ${name}_sample_t sample;
    sample.${field} = (${real})state->inputs[${place}]; %% for field, place in sensors
    sample.dt = (${real})(state->sampled ? at - state->last_point : step);
    (void)${name}_step(&state->observer, &sample);
    state->last_point = at;
    state->end = at + step;
    state->sampled = 1;
}

/* Sets inputs${" and parameters" if tunable}; why that cannot be, NULL where it can. */
static const char *set_numbers(fmu_state_t *state, const uint32_t at[], size_t count, const double values[]) {
    size_t i;
    ${name}_parameters_t parameters = state->parameters; %% if tunable
    int changed = 0; %% if tunable
    for (i = 0; i < count; ++i) {
        if (at[i] < INPUTS) {
            state->inputs[at[i]] = values[i];
            continue;
        }
%% if tunable
        changed = 1;
        switch (at[i]) {
        case PARAMETERS + ${loop.index0}: parameters.${p.field} = (${real})values[i]; break; %% for p in parameters
        default: return "only inputs and parameters can be set";
        }
%% else
        return "only inputs can be set";
%% endif
    }
%% if tunable
    if (changed && ${name}_set_parameters(&state->observer, &parameters) != 0)
        return "a parameter is out of its range, see modelDescription.xml; the parameters stay as they were";
    state->parameters = parameters;
%% endif
    return NULL;
}

/* The value of an input${", a parameter" if tunable} or a real output; 0 where no real variable has this reference. */
static int find_number(const fmu_state_t *state, uint32_t at, double *value) {
    ${name}_estimate_t estimate;
    ${name}_estimate(&state->observer, &estimate);
    switch (at) {
    case ${name|upper}: *value = (double)estimate.${name}; break; %% for name in numbers
%% if ratio
    case WEAKER: *value = fabs(1.0 - (double)state->parameters.${ratio}) / (1.0 + (double)state->parameters.${ratio}); break;
%% else
    case WEAKER: *value = (double)${NAME ~ "_WEAKER" if weaker else "NAN"}; break;
%% endif
    case TIME: *value = state->end; break; %% if number == 3
    case PARAMETERS + ${loop.index0}: *value = (double)state->parameters.${p.field}; break; %% for p in parameters
    default:
        if (at >= INPUTS) return 0;
        *value = state->inputs[at];
    }
    return 1;
}

/* The value of a flag, or of the status; 0 where no such variable has this reference. */
static int find_flag(const fmu_state_t *state, uint32_t at, int32_t *value) {
    ${name}_estimate_t estimate;
    ${name}_estimate(&state->observer, &estimate);
    *value = at == INFORMED ? estimate.informed : at == USABLE ? estimate.usable : estimate.status;
    return at == INFORMED || at == USABLE || at == STATUS;
}

/* Serialised, a state is its block and the digest of that. The block begins with the GUID, which goes with the code
   and its parameters. */
enum { SERIALISED = sizeof(fmu_state_t) + sizeof(uint64_t) };

/* FNV-1a, 64 bits: it changes with every single byte. */
static uint64_t digest_of(const void *block) {
    const unsigned char *bytes = block;
    uint64_t digest = 14695981039346656037u;
    size_t i;
    for (i = 0; i < sizeof(fmu_state_t); ++i) digest = (digest ^ bytes[i]) * 1099511628211u;
    return digest;
}

static void serialise(const void *state, void *bytes) {
    const uint64_t digest = digest_of(state);
    memcpy(bytes, state, sizeof(fmu_state_t));
    memcpy((unsigned char *)bytes + sizeof(fmu_state_t), &digest, sizeof digest);
}

/* Why bytes are no state of this model; NULL where they are. */
static const char *fault_of(const void *bytes, size_t size) {
    uint64_t digest;
    if (size != SERIALISED || memcmp(bytes, GUID, sizeof GUID) != 0) return "these bytes are no state of this model";
    memcpy(&digest, (const unsigned char *)bytes + sizeof(fmu_state_t), sizeof digest);
    return digest == digest_of(bytes) ? NULL : "the bytes of this state are damaged";
}

