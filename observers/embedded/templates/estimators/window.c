/* The window: the last ${window} samples in a ring, the states at each, and the patch after each. */

enum { STATES = ${states}, CLEAN = ${clean}, COUNTS = ${counts}, MONITOR = ${monitor} };
/* Result of the test of the newest innovation. */
enum {
    TEST_${name|upper}, %% for name in test
    TEST
};
/* A row of a sample: what was measured, whether it is accepted, and the jump of the variance of ln mu. */
enum {
    ROW_${name|upper}, %% for name in row
    ROW
};

/* M_z [N m] of a sample at states x, with its derivatives. */
static void torque_at(const ${name}_state_t *state, int32_t at, const ${real} *x, ${real} *torque) {
    kept_torque(state, at, any_exp(x[${log_mu}]), ${stiffness}, torque);
%% if angle_is_state
    torque[M_Z] += state->by_angle[at] * (x[${psi}] - state->angle[at]);
    torque[BY_ANGLE] = state->by_angle[at];
%% else
    torque[BY_ANGLE] = 0.0;
%% endif
}

/* The state before the first sample: an empty window, whose places have no time. */
static void begin(${name}_state_t *state, const ${real} *sample) {
    int32_t i;
    begin_window(sample${constants_at}, state->mean, state->factor, state->last);
    for (i = 0; i < ${window}; ++i) {
        set_numbers(state->x[i], state->mean, STATES);
        fill_numbers(state->row[i], 0.0, ROW);
        state->row[i][ROW_F_N] = sample[2];
    }
    set_numbers(state->P_newest, state->factor, STATES * STATES);
    fill_numbers(state->counts, 0.0, COUNTS);
    fill_numbers(state->monitor, 0.0, MONITOR);
    begin_patch(&state->patch, sample, ${prior_mu});
    begin_kept(state, state->last); /* at rest */
    state->newest = ${window} - 1;
    state->now = 0;
}

/* One sample of the filter over the window: from mean and factor to those of the next sample. */
static void filter_sample(const ${name}_state_t *state, int32_t at, int32_t next, ${real} *mean, ${real} *factor, ${real} *eliminated) {
    ${real} torque[TORQUES], mean_next[STATES], factor_next[STATES * STATES];
    torque_at(state, at, state->x[at], torque);
    forward(mean, factor, state->x[at], torque, state->row[at], state->row[next]${constants_at}, mean_next, factor_next, eliminated);
    set_numbers(mean, mean_next, STATES);
    set_numbers(factor, factor_next, STATES * STATES);
}

/* The oldest sample leaves the window: its measurement enters the arrival cost. */
static void update_arrival_cost(${name}_state_t *state, int32_t oldest) {
    ${real} eliminated[${eliminated}], limited[STATES];
    filter_sample(state, oldest, (oldest + 1) % ${window}, state->mean, state->factor, eliminated);
    limit(state->mean${constants_at}, limited);
    set_numbers(state->mean, limited, STATES);
}

/* Which samples of the window count after the test of the newest innovation. Without a reset only the newest changes. */
static void accept_samples(${name}_state_t *state, const ${real} *test) {
    const int32_t run = test[TEST_RUN] < ${window} ? (int32_t)test[TEST_RUN] : ${window};
    const int32_t count = test[TEST_RESET] == 0.0 ? 1 : run;
    int32_t age;
    for (age = 0; age < count; ++age) {
        ${real} *row = state->row[(state->newest + ${window} - age) % ${window}];
        ${real} accepted, jump;
        accept(row, (${real})age, test${constants_at}, &accepted, &jump);
        row[ROW_ACCEPTED] = accepted;
        row[ROW_JUMP] = jump;
    }
    if (test[TEST_RESET] != 0.0) {
        ${real} jump;
        reset_arrival(test${constants_at}, &jump);
        state->factor[0] += jump;
    }
}

/* The states of the whole window: forward elimination as a filter, and back substitution. */
static void smooth(${name}_state_t *state) {
    ${real} mean[STATES], factor[STATES * STATES], costate[STATES], before[STATES];
    const int32_t oldest = (state->newest + 1) % ${window};
    int32_t i;
    set_numbers(mean, state->mean, STATES);
    fill_numbers(costate, 0.0, STATES);
    set_numbers(factor, state->factor, STATES * STATES);
    for (i = 0; i < ${window}; ++i) {
        const int32_t at = (oldest + i) % ${window};
        filter_sample(state, at, i < ${window} - 1 ? (at + 1) % ${window} : at, mean, factor, state->eliminated[at]);
    }
    set_numbers(state->P_newest, &state->eliminated[state->newest][STATES], STATES * STATES);
    for (i = ${window} - 1; i >= 0; --i) {
        const int32_t at = (oldest + i) % ${window};
        backward(costate, state->eliminated[at], state->row[at], state->row[(at + 1) % ${window}]${constants_at}, before, state->x[at]);
        set_numbers(costate, before, STATES);
    }
}

/* One sample. */
static int32_t advance(${name}_state_t *state, const ${real} *sample) {
    ${real} now[CLEAN], imputed = 0.0, signals[4], newest[STATES], P[STATES * STATES];
    ${real} torque[TORQUES] = {0}, slide[2] = {0}, test[TEST], counts[COUNTS], monitor[MONITOR], output[OUTPUTS];
    ${real} retention[${walk + 1}]; %% if follows_mu
    const ${real} retention[1] = {1.0}; %% if not follows_mu
    const int32_t last = state->newest, at = (last + 1) % ${window};
    clean(sample, state->last, now, &imputed);
    update_arrival_cost(state, at);
    /* Prediction. */
    torque_at(state, last, state->x[last], torque); %% if moves_states
    predict(state->x[last], torque, state->P_newest, state->last, now${constants_at}, newest, P);
%% if follows_mu
    retentions(state->P_newest, state->last, now${", any_exp(newest[%s])" % log_mu if walk > 1}${constants_at}, retention);
%% endif
%% if not advances_at_corrected_state
    /* The patch at the angle of the sample. */
    patch_signals(newest, now, signals);
    follow_sample(state, at, signals, any_exp(newest[${log_mu}]), ${stiffness_newest}, retention, slide);
%% endif
    set_numbers(state->x[at], newest, STATES);
    state->row[at][ROW_${name|upper}] = now[${place}]; %% for name, place in measured
    state->row[at][ROW_ACCEPTED] = 1.0;
    state->row[at][ROW_JUMP] = 0.0;
    state->newest = at;
    /* Test of the innovation; where the patch follows the correction, it does not depend on the torque of the sample. */
    torque_at(state, at, newest, torque); %% if not advances_at_corrected_state
    test_innovation(newest, torque, now, P, state->counts, state->monitor${constants_at}, test, counts, monitor);
    now[${place}] = test[TEST_EVIDENCE]; /* how far mu walks to the next sample */ %% for place in evidence
%% if follows_mu
    /* Deformation that depends on the old friction does not fit samples of a new ground: they stay rejected. */
    test[TEST_RUN] = 1.0;
%% endif
    accept_samples(state, test);
    /* Correction of all samples. */
    smooth(state);
%% if advances_at_corrected_state
    /* The patch follows the corrected angle. */
    patch_signals(state->x[at], now, signals);
    follow_sample(state, at, signals, any_exp(state->x[at][${log_mu}]), ${stiffness_corrected}, retention, slide);
    torque_at(state, at, state->x[at], torque);
    test[TEST_EXPECTED] = torque[M_Z];
%% endif
%% if follows_mu
    if (test[TEST_RESET] != 0.0) {
        state->by_mu[at] *= retention[${walk}];
        state->by_k[at] *= retention[${walk}]; %% if walk > 1
        forget_sensitivity(&state->patch, retention[${walk}]);
    }
%% endif
    step_output(state->x[at], state->P_newest, newest, now, test, imputed, slide${constants_at}, output);
    set_numbers(state->last, now, CLEAN);
    set_numbers(state->counts, counts, COUNTS);
    set_numbers(state->monitor, monitor, MONITOR);
%% include "estimators/refuse.c"
    set_numbers(state->output, output, OUTPUTS);
    return (int32_t)output[OUT_STATUS];
}
