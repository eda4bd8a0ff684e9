/* The window: the last ${window} samples in a ring, the states at each, and the patch after each. */

enum { STATES = ${states}, CLEAN = ${clean} };
/* A row of a sample: what was measured, whether it is accepted, and the jump of the variance of ln mu. */
enum {
%% for name in row
    ROW_${name|upper},
%% endfor
    ROW
};

%% if bristles
/* M_z [N m] of a sample at states x, with its derivative by mu: linear in mu. */
static void torque_at(const ${name}_state_t *state, int32_t at, const ${real} *x, ${real} *torque) {
    torque[0] = state->M_z[at] + state->by_mu[at] * (exp(x[${log_mu}]) - state->mu[at]);
    torque[1] = state->by_mu[at];
    torque[2] = 0.0;
%% if steering
    torque[0] += state->by_angle[at] * (x[${psi}] - state->angle[at]);
    torque[3] = state->by_angle[at];
%% endif
}

%% else
/* Moment of the corners of a patch over k [m^3 rad], and its derivative by scale. */
static void corner_moments(const ${name}_patch_t *patch, ${real} scale, ${real} *moment) {
    ${real} corner_moment[2];
    int32_t i;
    moment[0] = (patch->rest - patch->angle) * ${still_moment};
    moment[1] = 0.0;
    for (i = 0; i < patch->corners; ++i) {
        unit_moment(patch, smaller(scale * patch->xi[i], FAR_OUT), corner_moment);
        moment[0] += patch->d[i] * corner_moment[0];
        moment[1] += patch->d[i] * corner_moment[1] * patch->xi[i];
    }
}

/* Stores the patch with a sample; of more corners than fit, those that contribute least to M_z are dropped, and
   what is lost is stored as linear in the scale mu / k: the torque at the scale of now and its derivative stay. */
static void store_patch(${name}_state_t *state, int32_t at, ${real} scale) {
    ${name}_patch_t patch = state->patch;
    ${real} whole[2] = {0.0, 0.0}, left[2] = {0.0, 0.0};
    int32_t i;
    if (patch.corners > ${stored}) {
        corner_moments(&patch, scale, whole);
        while (patch.corners > ${stored}) {
            drop_corner(&patch, scale);
        }
        corner_moments(&patch, scale, left);
    }
    state->lost[at][1] = whole[1] - left[1];
    state->lost[at][0] = whole[0] - left[0] - scale * state->lost[at][1];
    state->slope[at] = patch.rest - patch.angle;
    state->corners[at] = (int8_t)patch.corners;
    for (i = 0; i < patch.corners; ++i) {
        state->xi[at][i] = patch.xi[i];
        state->d[at][i] = patch.d[i];
    }
}

/* M_z [N m] of a sample at states x, with its derivatives by mu and by k over its nominal value. */
static void torque_at(const ${name}_state_t *state, int32_t at, const ${real} *x, ${real} *torque) {
    const ${name}_patch_t *patch = &state->patch;
    const ${real} stiffness = ${stiffness}, k = ${k} * stiffness, scale = exp(x[${log_mu}]) / k;
    ${real} total = state->slope[at] * ${still_moment} + state->lost[at][0] + scale * state->lost[at][1];
    ${real} by_scale = state->lost[at][1], moment[2];
    int32_t i;
    for (i = 0; i < state->corners[at]; ++i) {
        unit_moment(patch, smaller(scale * state->xi[at][i], FAR_OUT), moment);
        total += state->d[at][i] * moment[0];
        by_scale += state->d[at][i] * moment[1] * state->xi[at][i];
    }
    torque[0] = k * total;
    torque[1] = by_scale;
    torque[2] = ${k} * (total - scale * by_scale);
%% if steering
    torque[0] += state->by_angle[at] * (x[${psi}] - state->angle[at]);
    torque[3] = state->by_angle[at];
%% endif
}

%% endif
/* The state before the first sample: an empty window, whose places have no time. */
static void begin(${name}_state_t *state, const ${real} *sample) {
    int32_t i, j;
    {
        const ${real} *arg[] = {sample${constants_at}};
        ${real} *res[3] = {state->mean, state->factor, state->last};
        (void)begin_window(arg, res, 0, 0, 0);
    }
    for (i = 0; i < ${window}; ++i) {
        for (j = 0; j < STATES; ++j) {
            state->x[i][j] = state->mean[j];
        }
        for (j = 0; j < ROW; ++j) {
            state->row[i][j] = 0.0;
        }
        state->row[i][ROW_F_N] = sample[2];
%% if bristles
        state->M_z[i] = 0.0;
        state->by_mu[i] = 0.0;
        state->mu[i] = ${prior_mu};
%% else
        state->slope[i] = 0.0;
        state->lost[i][0] = 0.0;
        state->lost[i][1] = 0.0;
        state->corners[i] = 0;
%% endif
%% if steering
        state->angle[i] = 0.0;
        state->by_angle[i] = 0.0;
%% endif
    }
    for (j = 0; j < STATES * STATES; ++j) {
        state->P_newest[j] = state->factor[j];
    }
    for (j = 0; j < 2; ++j) {
        state->counts[j] = 0.0;
    }
    for (j = 0; j < 4; ++j) {
        state->monitor[j] = 0.0;
    }
%% if bristles or effects
    begin_patch(&state->patch, &state->last[0], ${prior_mu});
%% else
    clear_patch(&state->patch, sample[0]);
%% endif
%% if steering
    /* The torque that moves the wheel from the first sample on. */
    {
        ${real} terms[TERMS]${", own_next[%s]" % own if own else ""};
        sample_terms(&state->last[0], ${"state->patch.own, " if own else ""}terms${", own_next" if own else ""});
        for (i = 0; i < ${window}; ++i) {
            ${"state->M_z[i] = terms[TERM_TORQUE]" if bristles else "state->lost[i][0] = terms[TERM_TORQUE] / " ~ k};
        }
    }
%% endif
    state->newest = ${window} - 1;
    state->now = 0;
}

/* One sample of the filter over the window: from mean and factor to those of the next sample. */
static void filter_sample(const ${name}_state_t *state, int32_t at, int32_t next, ${real} *mean, ${real} *factor, ${real} *eliminated) {
    ${real} torque[4], mean_next[STATES] = {0}, factor_next[STATES * STATES] = {0};
    int32_t i;
    torque_at(state, at, state->x[at], torque);
    {
        const ${real} *arg[] = {mean, factor, state->x[at], torque, state->row[at], state->row[next]${constants_at}};
        ${real} *res[3] = {mean_next, factor_next, eliminated};
        (void)forward(arg, res, 0, 0, 0);
    }
    for (i = 0; i < STATES; ++i) {
        mean[i] = mean_next[i];
    }
    for (i = 0; i < STATES * STATES; ++i) {
        factor[i] = factor_next[i];
    }
}

/* The oldest sample leaves the window: its measurement enters the arrival cost. */
static void update_arrival_cost(${name}_state_t *state, int32_t oldest) {
    ${real} eliminated[${eliminated}], limited[STATES] = {0};
    const ${real} *arg[] = {state->mean${constants_at}};
    ${real} *res[1] = {limited};
    int32_t i;
    filter_sample(state, oldest, (oldest + 1) % ${window}, state->mean, state->factor, eliminated);
    (void)limit(arg, res, 0, 0, 0);
    for (i = 0; i < STATES; ++i) {
        state->mean[i] = limited[i];
    }
}

/* Which samples of the window count after the test of the newest innovation: accepted, reset, run, missing,
   expected, nis, inconsistent. Without a reset only the newest changes. */
static void accept_samples(${name}_state_t *state, const ${real} *test) {
    const int32_t run = test[2] < ${window} ? (int32_t)test[2] : ${window};
    const int32_t count = test[1] == 0.0 ? 1 : run;
    int32_t age;
    for (age = 0; age < count; ++age) {
        ${real} *row = state->row[(state->newest + ${window} - age) % ${window}];
        ${real} place = (${real})age, accepted = 0.0, jump = 0.0;
        const ${real} *arg[] = {row, &place, test${constants_at}};
        ${real} *res[2] = {&accepted, &jump};
        (void)accept(arg, res, 0, 0, 0);
        row[ROW_ACCEPTED] = accepted;
        row[ROW_JUMP] = jump;
    }
    if (test[1] != 0.0) {
        const ${real} *arg[] = {test${constants_at}};
        ${real} jump = 0.0, *res[1] = {&jump};
        (void)reset_arrival(arg, res, 0, 0, 0);
        /* U D U' with another variance of the first state, ln mu: one element of D. */
        state->factor[0] += jump;
    }
}

/* The states of the whole window: forward elimination as a filter, and back substitution. */
static void smooth(${name}_state_t *state) {
    ${real} mean[STATES], factor[STATES * STATES], costate[STATES], before[STATES] = {0};
    const int32_t oldest = (state->newest + 1) % ${window};
    int32_t i, j;
    for (j = 0; j < STATES; ++j) {
        mean[j] = state->mean[j];
        costate[j] = 0.0;
    }
    for (j = 0; j < STATES * STATES; ++j) {
        factor[j] = state->factor[j];
    }
    for (i = 0; i < ${window}; ++i) {
        const int32_t at = (oldest + i) % ${window};
        filter_sample(state, at, i < ${window} - 1 ? (at + 1) % ${window} : at, mean, factor, state->eliminated[at]);
    }
    for (j = 0; j < STATES * STATES; ++j) {
        state->P_newest[j] = state->eliminated[state->newest][STATES + j];
    }
    for (i = ${window} - 1; i >= 0; --i) {
        const int32_t at = (oldest + i) % ${window};
        const ${real} *arg[] = {costate, state->eliminated[at], state->row[at], state->row[(at + 1) % ${window}]${constants_at}};
        ${real} *res[2] = {before, state->x[at]};
        (void)backward(arg, res, 0, 0, 0);
        for (j = 0; j < STATES; ++j) {
            costate[j] = before[j];
        }
    }
}

%% if bristles or effects
/* Advances the patch to the signals of a sample, and stores what the window keeps of it. */
static void follow_sample(${name}_state_t *state, int32_t at, const ${real} *signals, ${real} mu, ${real} retention, ${real} *slide) {
%% if bristles
    ${real} torque[3];
    advance_patch(&state->patch, signals, mu, retention, torque, slide);
    state->M_z[at] = torque[0];
    state->by_mu[at] = torque[1];
    state->mu[at] = mu;
%% if steering
    state->by_angle[at] = torque[2];
%% endif
%% else
    const ${real} scale = mu / ${k};
    ${real} terms[TERMS];
    (void)retention;
    turn_with_effects(&state->patch, signals, scale, terms, slide);
%% if steering
    {
        ${real} moment[3];
        patch_moment(&state->patch, scale, moment);
        state->by_angle[at] = ${k} * moment[2] + terms[TERM_TORQUE_BY_PSI];
    }
%% endif
    store_patch(state, at, scale);
    /* The torque beside the patch does not depend on mu. */
    state->lost[at][0] += terms[TERM_TORQUE] / ${k};
%% endif
%% if steering
    state->angle[at] = signals[0];
%% endif
}

%% endif
/* One sample. */
static int32_t advance(${name}_state_t *state, const ${real} *sample) {
    ${real} now[CLEAN] = {0}, imputed = 0.0, newest[STATES] = {0}, P[STATES * STATES] = {0};
    ${real} torque[4] = {0}, test[7] = {0}, counts[2] = {0}, monitor[4] = {0}, output[OUTPUTS] = {0};
    ${real} ${"retention[2], slide[2]" if bristles else "slide[2]" if effects else "scale"};
%% if steering
    ${real} signals[4];
%% endif
    const int32_t last = state->newest, at = (last + 1) % ${window};
    int32_t i;
    {
        const ${real} *arg[] = {sample, state->last${constants_at}};
        ${real} *res[2] = {now, &imputed};
        (void)clean(arg, res, 0, 0, 0);
    }
    update_arrival_cost(state, at);
    {
%% if steering
        const ${real} *arg[] = {state->x[last], torque, state->P_newest, state->last, now${constants_at}};
%% else
        const ${real} *arg[] = {state->x[last], state->P_newest, state->last, now${constants_at}};
%% endif
        ${real} *res[2] = {newest, P};
%% if steering
        torque_at(state, last, state->x[last], torque);
%% endif
        (void)predict(arg, res, 0, 0, 0);
    }
%% if bristles
    retentions(state->P_newest, now${constants_at}, retention);
%% endif
%% if steering
%% elif bristles or effects
    follow_sample(state, at, now, exp(newest[${log_mu}]), ${"retention[0]" if bristles else "1.0"}, slide);
%% else
    scale = exp(newest[${log_mu}]) / (${k} * ${stiffness_newest});
    turn_patch(&state->patch, now[0], ${level} * now[2], scale);
    store_patch(state, at, scale);
%% endif
    for (i = 0; i < STATES; ++i) {
        state->x[at][i] = newest[i];
    }
%% for name, place in measured
    state->row[at][ROW_${name|upper}] = now[${place}];
%% endfor
    state->row[at][ROW_ACCEPTED] = 1.0;
    state->row[at][ROW_JUMP] = 0.0;
    state->newest = at;
%% if steering
    /* The angle is measured, which does not depend on the torque of the same sample. */
%% else
    torque_at(state, at, newest, torque);
%% endif
    {
        const ${real} *arg[] = {newest, torque, now, P, state->counts, state->monitor${constants_at}};
        ${real} *res[3] = {test, counts, monitor};
        (void)test_innovation(arg, res, 0, 0, 0);
    }
%% if bristles
    /* Deformation that depends on the old friction does not fit samples of a new ground: they stay rejected. */
    test[2] = 1.0;
%% endif
    accept_samples(state, test);
    smooth(state);
%% if steering
    /* The patch follows the corrected angle. */
    signals[0] = state->x[at][${psi}];
    signals[1] = state->x[at][${psi_dot}];
    signals[2] = now[2];
    signals[3] = now[3];
    follow_sample(state, at, signals, exp(state->x[at][${log_mu}]), ${"retention[0]" if bristles else "1.0"}, slide);
    torque_at(state, at, state->x[at], torque);
    test[4] = torque[0];
%% endif
%% if bristles
    if (test[1] != 0.0) {
        state->by_mu[at] *= retention[1];
        forget_sensitivity(&state->patch, retention[1]);
    }
%% endif
    {
        const ${real} *arg[] = {state->x[at], state->P_newest, newest, now, test, &imputed${", slide" if bristles or effects else ""}${constants_at}};
        ${real} *res[1] = {output};
        (void)step_output(arg, res, 0, 0, 0);
    }
    for (i = 0; i < CLEAN; ++i) {
        state->last[i] = now[i];
    }
    for (i = 0; i < 2; ++i) {
        state->counts[i] = counts[i];
    }
    for (i = 0; i < 4; ++i) {
        state->monitor[i] = monitor[i];
    }
    if (!(is_known(output[OUT_MU]) && is_known(output[OUT_MU_STD]) && is_known(output[OUT_M_Z_PREDICTED]))) {
        ${name}_reset(state);
        state->output[OUT_STATUS] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
    for (i = 0; i < OUTPUTS; ++i) {
        state->output[i] = output[i];
    }
    return (int32_t)output[OUT_STATUS];
}
