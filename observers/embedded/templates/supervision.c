/* Supervision: friction is acquired among hypotheses before the estimator tracks it. -------------------------- */

enum { HYPOTHESES = ${ratios|length}, POINTS = ${points}, PARTS = ${parts|length} };
/* Own numbers of the supervision. */
enum {
%% for name in own
    OWN_${name|upper},
%% endfor
    OWN
};
/* The present branch of the path, and what the torques so far were worth. */
enum {
%% for name in track
    TRACK_${name|upper},
%% endfor
    TRACK
};

/* mu at the declared k under each hypothesis [1]. */
static const ${real} RATIOS[HYPOTHESES] = {${ratios|join(", ")}};

/* The hypotheses begin anew: mean and deviation of the stiffness over the declared one [1], of the zero [N m]. */
static void begin_search(${name}_state_t *state, ${real} gain, ${real} gain_std, ${real} zero, ${real} zero_std) {
    int32_t i;
    for (i = 0; i < HYPOTHESES; ++i) {
        ${real} *part = state->hypotheses[i];
        part[0] = 0.0;
        part[1] = gain;
        part[2] = zero;
        part[3] = gain_std * gain_std;
        part[4] = 0.0;
        part[5] = zero_std * zero_std;
    }
    state->track[TRACK_REACH] = 0.0;
    state->track[TRACK_EXPLAINED] = 0.0;
    state->track[TRACK_WIDEST] = 0.0;
}

/* The state before the first sample. The first verdict, before any torque counts, is the prior. */
static void begin_supervision(${name}_state_t *state, const ${real} *sample) {
    const ${real} slide = 0.375 * sample[2] * ${a};
    int32_t i;
    for (i = 0; i < OWN; ++i) {
        state->own[i] = 0.0;
    }
    state->own[OWN_ACQUIRING] = 1.0;
    state->own[OWN_PHASE] = 1.0;
    state->own[OWN_SCALE] = 1.0;
    state->own[OWN_F_N] = sample[2];
    state->own[OWN_F_N_FIRST] = sample[2];
    for (i = 0; i < ${verdict}; ++i) {
        state->verdict[i] = 0.0;
    }
    for (i = 0; i < TRACK; ++i) {
        state->track[i] = 0.0;
    }
    state->track[TRACK_COUNT] = 1.0;
    state->track[TRACK_EXTREME] = sample[0];
    state->track[TRACK_ORIGIN] = sample[0];
    for (i = 0; i < POINTS; ++i) {
        state->points[i] = sample[0];
    }
%% if block
    for (i = 0; i < ${block}; ++i) {
        state->block[i] = 0.0;
    }
%% endif
    begin_search(state, 1.0, ${vague}, 0.0, ${zero_std});
}

/* The search for a new ground: what the patch was before its last turn back is forgotten. */
static void restart_search(${name}_state_t *state, ${real} zero_std) {
    const ${real} scale = state->own[OWN_SCALE], reach = state->track[TRACK_REACH];
    int32_t i;
    begin_search(state, scale, ${restart_std}, scale * ${zero_state}, zero_std);
    state->track[TRACK_REACH] = reach;
    state->track[TRACK_COUNT] = state->track[TRACK_DIRECTION] == 0.0 ? 1.0 : 2.0;
    state->points[0] = state->track[TRACK_ORIGIN] + ${slid} * state->track[TRACK_DIRECTION];
    for (i = 1; i < POINTS; ++i) {
        state->points[i] = state->track[TRACK_ORIGIN];
    }
    state->own[OWN_PHASE] = 0.0;
}

/* All hypotheses after a torque [N m] of this variance. */
static void weigh_torque(${name}_state_t *state, const ${real} *turns, const ${real} *tyre, ${real} M_z, ${real} variance, ${real} share) {
    const int32_t count = (int32_t)state->track[TRACK_COUNT];
    int32_t i, j;
    for (i = 0; i < HYPOTHESES; ++i) {
        ${real} expected = 0.0, part[PARTS] = {0};
        for (j = 0; j < count; ++j) {
            const ${real} order = (${real})j;
            ${real} M = 0.0;
            const ${real} *arg[] = {&turns[j], &order, &RATIOS[i], &state->own[OWN_F_N], tyre};
            ${real} *res[1] = {&M};
            (void)branch(arg, res, 0, 0, 0);
            expected += M;
        }
        {
            const ${real} *arg[] = {state->hypotheses[i], &expected, &M_z, &variance, &share};
            ${real} *res[1] = {part};
            (void)hypothesis(arg, res, 0, 0, 0);
        }
        for (j = 0; j < PARTS; ++j) {
            state->hypotheses[i][j] = part[j];
        }
    }
}

${hand_over}
/* A sample while friction is acquired: torques are weighed and the verdict is given in turn. */
static void acquire(${name}_state_t *state, ${real} psi, ${real} M_z, ${real} added, const ${real} *tyre, const ${real} *limits) {
    const bool known = is_known(psi) && is_known(M_z);
    const ${real} torque = known ? M_z : 0.0, at = is_known(psi) ? psi : state->track[TRACK_EXTREME];
    /* Within the angle's noise of the farthest angle, the wheel may or may not have turned back. */
    const ${real} turned = (state->track[TRACK_EXTREME] - at) * state->track[TRACK_DIRECTION];
    const bool is_certain = !((turned > 0.0) && (turned <= limits[${noise_limit}]));
    const ${real} counts = known && is_certain && (state->own[OWN_PHASE] == 0.0) ? 1.0 : 0.0, one = 1.0, nothing = 0.0;
    ${real} track[TRACK] = {0}, points[POINTS] = {0}, turns[POINTS] = {0}, own[OWN] = {0}, handover[4] = {0};
    ${real} share = 0.0, size = 0.0, variance = 0.0, noisy = 0.0;
    int32_t i;
    {
        const ${real} *arg[] = {&torque, &state->own[OWN_F_N], &tyre[1], &nothing, &nothing, &one, &nothing};
        ${real} *res[3] = {&size, &variance, &noisy};
        (void)torque_error(arg, res, 0, 0, 0);
    }
    {
        const ${real} *arg[] = {state->track, state->points, &at, &size, &limits[${noise_limit}], &counts};
        ${real} *res[4] = {track, points, turns, &share};
        (void)follow_turns(arg, res, 0, 0, 0);
    }
    for (i = 0; i < TRACK; ++i) {
        state->track[i] = track[i];
    }
    for (i = 0; i < POINTS; ++i) {
        state->points[i] = points[i];
    }
    if (counts != 0.0) {
        const ${real} *arg[] = {&torque, &state->own[OWN_F_N], &tyre[1], &added, &track[TRACK_REACH], &share, &limits[${error_limit}]};
        ${real} *res[3] = {&size, &variance, &noisy};
        (void)torque_error(arg, res, 0, 0, 0);
        state->track[TRACK_EXPLAINED] += noisy;
        weigh_torque(state, turns, tyre, torque, variance, share);
    } else if (state->own[OWN_PHASE] != 0.0) {
        const ${real} *arg[${verdict_arg}] = {&state->hypotheses[0][0], &state->track[TRACK_EXPLAINED], limits};
        ${real} *res[${verdict_res}] = {state->verdict}, work[${verdict_work}];
        int32_t integers[${verdict_integers}];
        (void)verdict_of(arg, res, integers, work, 0);
    } else {
        /* Without a torque there is nothing to weigh. */
    }
    {
        const ${real} *arg[] = {state->own, state->verdict, state->output, &state->track[TRACK_WIDEST], &counts, &share, tyre, limits};
        ${real} *res[3] = {own, handover, state->result};
        (void)conclude(arg, res, 0, 0, 0);
    }
    for (i = 0; i < OWN; ++i) {
        state->own[i] = own[i];
    }
    hand_over(state, handover);
}

/* A sample while the estimator tracks. */
static void follow(${name}_state_t *state, ${real} psi, const ${real} *tyre, const ${real} *limits) {
    const ${real} at = is_known(psi) ? psi : state->track[TRACK_EXTREME];
    const ${real} known = is_known(state->output[OUT_NIS]) ? 1.0 : 0.0;
    ${real} track[TRACK] = {0}, own[OWN] = {0}, share = 0.0;
    int32_t i;
    {
        const ${real} *arg[] = {state->track, &at, &limits[${noise_limit}], &known};
        ${real} *res[2] = {track, &share};
        (void)turn(arg, res, 0, 0, 0);
    }
    {
        const ${real} *arg[] = {state->own, state->output, &share, &track[TRACK_WIDEST], tyre, limits};
        ${real} *res[2] = {own, state->result};
        (void)follow_output(arg, res, 0, 0, 0);
    }
    for (i = 0; i < TRACK; ++i) {
        state->track[i] = track[i];
    }
    for (i = 0; i < OWN; ++i) {
        state->own[i] = own[i];
    }
}

/* What follows from a sample and from what the estimator made of it; the torque as measured. */
static int32_t supervise(${name}_state_t *state, const ${real} *sample, ${real} torque, int32_t status) {
    const ${real} tyre[3] = {${tyre|join(", ")}};
    ${real} psi = sample[0], M_z = torque, added = 0.0, limits[${limits}] = {0};
    const bool lifted = is_known(sample[2]) && !(sample[2] >= ${least_load} * state->own[OWN_F_N_FIRST]);
    if (is_known(sample[2]) && !lifted) {
        state->own[OWN_F_N] = sample[2];
    }
    if (((status & ${NAME}_RESET) != 0) && (state->own[OWN_ACQUIRING] == 0.0)) {
        state->own[OWN_AGAIN] = 1.0;
    }
    {
%% if block
        ${real} block[${block}] = {0};
        int32_t i;
        const ${real} *arg[] = {state->block, sample, &state->own[OWN_AGAIN]${constants_at}};
        ${real} *res[5] = {block, &psi, &M_z, &added, limits};
        (void)observe_torque(arg, res, 0, 0, 0);
        for (i = 0; i < ${block}; ++i) {
            state->block[i] = block[i];
        }
%% else
        ${real} given = 0.0; /* angle and torque are what they are, the latter not divided by s */
        const ${real} *arg[] = {0, sample, &state->own[OWN_AGAIN]${constants_at}};
        ${real} *res[5] = {0, &given, &given, &added, limits};
        (void)observe_torque(arg, res, 0, 0, 0);
%% endif
    }
    if (lifted) {
        M_z = (${real})NAN;
    }
    if ((status & ${NAME}_RESET) != 0) {
        if (state->own[OWN_ACQUIRING] == 0.0) {
            restart_search(state, limits[${zero_limit}] * 0.375 * state->own[OWN_F_N] * ${a});
        }
        state->own[OWN_ACQUIRING] = 1.0;
    }
    if (state->own[OWN_ACQUIRING] != 0.0) {
        acquire(state, psi, M_z, added, tyre, limits);
    } else {
        follow(state, psi, tyre, limits);
    }
    return (int32_t)state->result[OUT_STATUS];
}
