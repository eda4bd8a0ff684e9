/* Supervision: friction is acquired among hypotheses before the estimator tracks it. -------------------------- */

enum { HYPOTHESES = ${hypotheses.RATIOS|length}, POINTS = ${branches.POINTS}, PATHS = ${branches.PATHS} };
/* Own numbers of the supervision, the present branch of the path with what the torques so far were worth, the tuning,
   moments of stiffness over the declared one [1], zero [N m] and twist [1] under a hypothesis. */
%% for prefix, names in (("OWN", acquisition.OWN), ("TRACK", branches.TRACK), ("LIMIT", hypotheses.SETTINGS), ("PART", parts), ("VERDICT", verdicts.VERDICT))
enum {
    ${prefix}_${name|upper}, %% for name in names
    ${prefix}S
};
%% endfor

/* mu at the declared k under each hypothesis [1]. */
static const ${real} RATIOS[HYPOTHESES] = {${hypotheses.RATIOS|join(", ")}};

/* The hypotheses begin anew: mean and deviation of the stiffness over the declared one [1], of the zero [N m]; mean of the
   twist before the first sample [1]. */
static void begin_search(${name}_state_t *state, ${real} gain, ${real} gain_std, ${real} zero, ${real} zero_std, ${real} twist) {
    int32_t i;
    for (i = 0; i < HYPOTHESES; ++i) {
        ${real} *part = state->hypotheses[i];
        fill_numbers(part, 0.0, PARTS);
        part[PART_GAIN] = gain;
        part[PART_ZERO] = zero;
        part[PART_D_GAIN] = gain_std * gain_std;
        part[PART_D_ZERO] = zero_std * zero_std;
        part[PART_TWIST] = twist;
        part[PART_D_TWIST] = ${hypotheses.TWIST_STD} * ${hypotheses.TWIST_STD};
        part[PART_GEAR] = 1.0; %% if gear
        part[PART_D_GEAR] = ${gear_spread} * ${gear_spread}; %% if gear
    }
    state->track[TRACK_REACH] = 0.0;
    state->track[TRACK_EXPLAINED] = 0.0;
    state->track[TRACK_WIDEST] = 0.0;
}

/* The state before the first sample. The first verdict, before any torque counts, is the prior. */
static void begin_supervision(${name}_state_t *state, const ${real} *sample) {
    fill_numbers(state->own, 0.0, OWNS);
    state->own[OWN_ACQUIRING] = 1.0;
    state->own[OWN_PHASE] = 1.0;
    state->own[OWN_SCALE] = 1.0;
    state->own[OWN_F_N] = sample[2];
    state->own[OWN_F_N_FIRST] = sample[2];
    state->own[OWN_PATCH_PSI] = sample[0];
    fill_numbers(state->verdict, 0.0, VERDICTS);
    fill_numbers(state->track, 0.0, TRACKS);
    state->track[TRACK_COUNT] = 1.0;
    state->track[TRACK_COUNT_SLID] = 1.0;
    state->track[TRACK_EXTREME] = sample[0];
    state->track[TRACK_ORIGIN] = sample[0];
    fill_numbers(state->points, sample[0], POINTS * PATHS);
    fill_numbers(state->block, 0.0, ${block}); %% if block
    begin_search(state, 1.0, ${hypotheses.VAGUE}, 0.0, ${zero_std}, 0.0);
}

/* The search anew on a ground that has changed; M_z is the torque [N m]; where an innovation lasted, the scale and the
   zero may have moved by so many times their deviations. */
static void restart_search(${name}_state_t *state, ${real} M_z, const ${real} *tyre, bool tracked, ${real} zero_std, ${real} moved) {
    const ${real} scale = state->own[OWN_SCALE];
    /* Garbage may have moved the zero of the estimator anywhere. */
    const ${real} zero = scale * ${zero_state}, most = ${tracking.MAX_ZERO_DEVIATIONS} * zero_std;
    const ${real} gain = tracked ? any_exp(state->verdict[VERDICT_LOG_GAIN]) : scale, gain_std = tracked ? moved * ${hypotheses.RESTART_STD} : ${hypotheses.VAGUE};
    ${real} track[TRACKS];
    new_ground(state->track, M_z, state->result[OUT_M_SLIDE], tyre, track, state->points);
    begin_search(state, gain, gain_std, (zero > most) ? most : ((zero < -most) ? -most : zero), moved * zero_std, 0.5 * gain);
    set_numbers(state->track, track, TRACKS);
    state->own[OWN_PHASE] = 0.0;
    if (state->own[OWN_DOUBT] > ${tracking.AFTERWARDS}) {
        state->own[OWN_DOUBT] = ${tracking.AFTERWARDS};
    }
}

/* The branches of both paths up to the angle psi: k times the turn [N/m^2 rad], the place up to which the patch slides over
   mu at the declared k, and which paths have it: 0, 1, or 2 for both. Returns their number. */
static int32_t find_branches(const ${name}_state_t *state, ${real} psi, const ${real} *tyre, ${real} *weight, ${real} *place, int32_t *path_of) {
    const int32_t counts[PATHS] = {(int32_t)state->track[TRACK_COUNT], (int32_t)state->track[TRACK_COUNT_SLID]};
    const ${real} now = state->own[OWN_LOAD];
    const ${real} rest = state->own[OWN_LOAD_AT_REST]; %% if contact
    int32_t path, j, shared = 0, found = 0;
    while ((counts[0] - shared > 1) && (counts[1] - shared > 1) && (state->points[counts[0] - 1 - shared] == state->points[POINTS + counts[1] - 1 - shared])) {
        ++shared;
    }
    for (path = 0; path < PATHS; ++path) {
        const ${real} *points = &state->points[path * POINTS];
        for (j = 0; j < counts[path] - (path == 0 ? 0 : shared); ++j) {
            const ${real} turn = (j + 1 < counts[path] ? points[j + 1] : psi) - points[j];
            /* A branch that begins at a turning point is the virgin one at twice the scale. */
            const ${real} virgin = fabs(j == 0 ? turn : 0.5 * turn);
            /* At rest, where the wheel turned back, friction may be another: a branch began at the limit there. */
            const ${real} load = j + 1 < counts[path] ? rest : (j == 0 ? now : 0.5 * (now + rest)); %% if contact
            const ${real} load = now; %% if not contact
            weight[found] = tyre[0] * turn;
            place[found] = 3.0 * load / (4.0 * tyre[1] * tyre[1] * tyre[1] * tyre[0] * virgin);
            place[found] = place[found] < ${branches.FAR} ? place[found] : ${branches.FAR};
            path_of[found] = j < counts[path] - shared ? path : 2;
            ++found;
        }
    }
    return found;
}

/* The hypotheses, those within so many of the likeliest, after a torque [N m] of this variance. From one turning point to the
   next the torque changes by that of a branch: the patch sticks, less what is beyond the place up to which it slides; that
   place is as mu over k. The others stay as much less likely than the likeliest as they were. */
static void weigh_torque(${name}_state_t *state, int32_t beside, ${real} psi, const ${real} *tyre, ${real} M_z, ${real} variance, ${real} share) {
    ${real} weight[PATHS * POINTS], place[PATHS * POINTS], stuck, change;
    int32_t path_of[PATHS * POINTS], i, j, likeliest = 0, first, last;
    const int32_t branches = find_branches(state, psi, tyre, weight, place, path_of);
    beyond(0.0, tyre[1], tyre[2], &stuck);
    for (i = 1; i < HYPOTHESES; ++i) {
        if (state->hypotheses[i][PART_LOG_LIKELIHOOD] >= state->hypotheses[likeliest][PART_LOG_LIKELIHOOD]) {
            likeliest = i;
        }
    }
    change = -state->hypotheses[likeliest][PART_LOG_LIKELIHOOD];
    first = likeliest > beside ? likeliest - beside : 0;
    last = likeliest + beside < HYPOTHESES ? likeliest + beside : HYPOTHESES - 1;
    for (i = first; i <= last; ++i) {
        ${real} sums[3] = {0.0, 0.0, 0.0}, part[PARTS];
        for (j = 0; j < branches; ++j) {
            ${real} slides;
            beyond(RATIOS[i] * place[j], tyre[1], tyre[2], &slides);
            sums[path_of[j]] -= weight[j] * (stuck - slides);
        }
        hypothesis(state->hypotheses[i], sums[0] + sums[2], sums[1] + sums[2], M_z, variance, share${", " ~ dry if gear}, part);
        state->hypotheses[i][PART_${name|upper}] = part[PART_${name|upper}]; %% for name in parts
    }
    change += state->hypotheses[likeliest][PART_LOG_LIKELIHOOD];
    for (i = 0; i < HYPOTHESES; ++i) {
        if ((i < first) || (i > last)) {
            state->hypotheses[i][PART_LOG_LIKELIHOOD] += change;
        }
    }
}

%% include "estimators/take_acquired.c"

/* A torque: it is weighed, or the verdict is given, in turn. Returns 1 where it was weighed; what it is worth. */
static ${real} search(${name}_state_t *state, int32_t beside, ${real} psi, ${real} M_z, ${real} added, const ${real} *tyre, const ${real} *limits, ${real} *worth) {
    const bool known = is_known(psi) && is_known(M_z);
    const ${real} torque = known ? M_z : 0.0, given = is_known(psi) ? psi : state->track[TRACK_EXTREME];
    /* Within the angle's noise of the farthest angle, the wheel may or may not have turned back. */
    const ${real} direction = state->track[TRACK_DIRECTION], turned = (state->track[TRACK_EXTREME] - given) * direction;
    const bool is_certain = !((turned > 0.0) && (turned <= limits[LIMIT_PSI_NOISE]));
    /* At rest that noise is no turn: the torque tells its zero. */
    const ${real} away = fabs(given - state->track[TRACK_ORIGIN]);
    const ${real} at = ((direction == 0.0) && (away <= ${branches.START} * limits[LIMIT_PSI_NOISE])) ? state->track[TRACK_ORIGIN] : given;
    const bool weighs = known && is_certain && (state->own[OWN_PHASE] == 0.0);
    const ${real} counts = weighs ? 1.0 : 0.0;
    ${real} track[TRACKS], points[POINTS * PATHS], share, size, variance, noisy;
    torque_error(torque, state->own[OWN_F_N], tyre[1], 0.0, 0.0, 1.0, 0.0, &size, &variance, &noisy);
    follow_turns(state->track, state->points, at, torque, size, limits[LIMIT_PSI_NOISE], counts, track, points, &share);
    set_numbers(state->track, track, TRACKS);
    set_numbers(state->points, points, POINTS * PATHS);
    if (weighs) {
        torque_error(torque, state->own[OWN_F_N], tyre[1], added, track[TRACK_REACH], share, limits[LIMIT_ERROR], &size, &variance, &noisy);
        state->track[TRACK_EXPLAINED] += noisy;
        variance += ${dry_std} * ${dry_std} / share; %% if gear
        weigh_torque(state, beside, at, tyre, torque, variance, share);
    } else if (state->own[OWN_PHASE] != 0.0) {
        verdict_of(&state->hypotheses[0][0], state->track[TRACK_EXPLAINED], state->track[TRACK_REACH], limits, state->verdict);
    } else {
        /* Without a torque there is nothing to weigh. */
    }
    *worth = share;
    return counts;
}

/* A sample while friction is acquired. */
static void acquire(${name}_state_t *state, ${real} psi, ${real} M_z, ${real} added, const ${real} *tyre, const ${real} *limits) {
    ${real} own[OWNS], handed[${handover}], share;
    const ${real} counts = search(state, HYPOTHESES, psi, M_z, added, tyre, limits, &share);
    conclude(state->own, state->verdict, state->output, state->track[TRACK_WIDEST], state->track[TRACK_COUNT], counts, share, M_z, added, tyre, limits, own, handed, state->result);
    set_numbers(state->own, own, OWNS);
    take_acquired(state, handed);
}

/* A sample while the estimator tracks; the search for s goes on until friction is confirmed or the model doubted. */
static void follow(${name}_state_t *state, ${real} psi, ${real} M_z, ${real} added, const ${real} *tyre, const ${real} *limits) {
    const ${real} at = is_known(psi) ? psi : state->track[TRACK_EXTREME];
    const ${real} known = is_known(state->output[OUT_NIS]) ? 1.0 : 0.0;
    ${real} track[TRACKS], own[OWNS], share, worth, least, counts = 0.0, now;
    sliding(state->output[OUT_MU], state->own[OWN_LOAD], tyre, &least);
    turn(state->track, at, limits[LIMIT_PSI_NOISE], ${tracking.CONFIRMS} * least, known, track, &share);
    now = fabs(track[TRACK_EXTREME] - track[TRACK_ORIGIN]);
    if (state->own[OWN_PHASE] < ${acquisition.OVER|float}) {
        counts = search(state, ${tracking.BESIDE}, psi, M_z, added, tyre, limits, &worth);
        /* A branch tells something only where its torque was weighed. */
        share *= counts;
        if ((state->own[OWN_PHASE] == 1.0) && (state->verdict[VERDICT_UNEXPLAINED] == 0.0)) {
            scale_excess(state->verdict, limits, &state->own[OWN_EXCESS]);
        }
    } else {
        set_numbers(state->track, track, TRACKS);
    }
    follow_output(state->own, state->verdict, state->output, share, now, ${interval}, M_z, added, counts, tyre, limits, own, state->result);
    set_numbers(state->own, own, OWNS);
}

/* What follows from a sample, its torque as measured, and from what the estimator made of it. */
static int32_t supervise(${name}_state_t *state, const ${real} *sample, int32_t status) {
    ${"const " if not contact}${real} tyre[3] = {${tyre|join(", ")}};
    ${real} psi, M_z, added, limits[LIMITS], sensed[6];
    ${real} signals[4]; %% if added_torque or contact
    ${real} added_by_effects, at_torque; %% if added_torque
    ${real} loads[2]; %% if contact
    ${real} behind, zero_std; %% if has_gap
    ${real} block[${block}]; %% if block
    const bool lifted = is_known(sample[2]) && !(sample[2] >= ${least_load} * state->own[OWN_F_N_FIRST]);
    const bool tracked = state->own[OWN_ACQUIRING] == 0.0, lost = state->own[OWN_LOST] != 0.0;
    const bool changed = ((status & ${NAME}_RESET) != 0) || lost;
    if (is_known(sample[2]) && !lifted) {
        state->own[OWN_F_N] = sample[2];
    }
    if (changed && tracked) {
        state->own[OWN_AGAIN] = ((state->own[OWN_CONFIRMED] > 0.0) && (state->own[OWN_DOUBT] < ${acquisition.FAILED_FOR_LONG})) ? 1.0 : ${acquisition.FAILED|float};
    }
    state->own[OWN_LOST] = 0.0;
    set_numbers(sensed, sample, 6);
    if (lifted) {
        sensed[4] = (${real})NAN;
    }
    observe_torque(${"state->block, " if block}sensed, state->own[OWN_AGAIN]${constants_at}, ${"block, " if block}&psi, &M_z, &added, limits);
    set_numbers(state->block, block, ${block}); %% if block
    if (lifted) {
        M_z = (${real})NAN;
    }
    patch_signals(${newest_x}, ${newest_last}, signals); %% if added_torque or contact
%% if added_torque
    /* Friction is acquired on the declared patch that stands for the model's, without what effects add to its torque. */
    added_torque(signals, &added_by_effects);
    state->output[OUT_M_Z_PREDICTED] -= added_by_effects;
    signals[0] = psi;
    added_torque(signals, &at_torque);
    M_z -= at_torque;
%% endif
    state->own[OWN_LOAD] = state->own[OWN_F_N]; %% if not contact
    state->own[OWN_LOAD_AT_REST] = state->own[OWN_F_N]; %% if not contact
%% if contact
    /* Friction that depends on rate and load acts as another load, a patch that grows has another half-length. */
    signals[2] = state->own[OWN_F_N];
    equivalent_contact(signals, loads, &tyre[1]);
    state->own[OWN_LOAD] = loads[0];
    state->own[OWN_LOAD_AT_REST] = loads[1];
%% endif
%% if has_gap
    /* Nor with the turn through a gap. */
    zero_std = ${restart_zero_std};
    patch_angle(state->own[OWN_PATCH_PSI], psi, M_z, added + zero_std * zero_std, state->own[OWN_F_N], &behind);
    state->own[OWN_PATCH_PSI] = behind;
    if (is_known(psi)) {
        psi = behind;
    }
%% endif
    if (changed) {
        if (tracked || lost) {
            const bool tells = ((status & ${NAME}_RESET) != 0) && is_known(M_z)${" && false" if gear};
            restart_search(state, tells ? M_z : 0.0, tyre, tracked, ${restart_zero_std},
                           (tracked && lost && (state->own[OWN_CONFIRMED] == ${acquisition.PROVED|float})) ? ${tracking.MAY_HAVE_MOVED} : 1.0);
        }
        state->own[OWN_ACQUIRING] = 1.0;
    }
    if (state->own[OWN_ACQUIRING] != 0.0) {
        acquire(state, psi, M_z, added, tyre, limits);
    } else {
        follow(state, psi, M_z, added, tyre, limits);
    }
    state->output[OUT_M_Z_PREDICTED] += added_by_effects; %% if added_torque
    state->result[OUT_M_Z_PREDICTED] += added_by_effects; %% if added_torque
    return (int32_t)state->result[OUT_STATUS];
}
