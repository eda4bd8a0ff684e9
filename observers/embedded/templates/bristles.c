/* The contact patch: ${bristles} bristles. Deformation q and stress are over half-length and stiffness [1]. */

enum { BRISTLES = ${bristles} };
/* What the effects make of a sample: angle, load, speed of a lever arm of one half-length, load times the factor
   on friction, growth of the patch, slip of a sample at 1 m/s, the Maxwell branches' decay and gain, torque beside
   the patch and its derivative by the angle, effective friction over mu and beside it. */
enum {
%% for name in terms
    TERM_${name|upper},
%% endfor
    TERMS
};

/* Limit of a bristle over mu. */
static inline ${real} limit_over_mu(int32_t i, const ${real} *terms, ${real} speed) {
%% if grows
    ${real} pressure = 0.0;
%% else
    const ${real} pressure = pressure_of[i];
%% endif
%% if limited
    ${real} factor = 1.0;
    limit_factor(fabs(lever_of[i]) * speed, &factor);
%% else
    const ${real} factor = 1.0;
    (void)speed;
%% endif
%% if grows
    pressure_at(place_of[i], terms[TERM_GROWTH], &pressure);
%% endif
    return terms[TERM_BASE] * pressure * factor;
}

/* Effective friction over mu: every bristle at its limit, against the turn. */
static ${real} slide_over_mu(const ${real} *terms) {
%% if slide
    return terms[TERM_SLIDE] * ${slide};
%% else
    const ${real} speed = ${slide_rate} * ${a};
    ${real} total = 0.0;
    int32_t i;
    for (i = 0; i < BRISTLES; ++i) {
%% if creep
        const ${real} v = greater(fabs(lever_of[i]) * speed, ${rest_speed});
        const ${real} creep = 1.0 + ${creep} * (natural_log(v) - ${log_reference});
%% else
        const ${real} creep = 1.0;
%% endif
        total += fabs(moment_of[i]) * limit_over_mu(i, terms, speed) * creep;
    }
    return terms[TERM_SLIDE] * total * ${slide_weight} / terms[TERM_BASE];
%% endif
}

/* Slip that brings a bristle back to its limit, and its derivatives by stress and by limit. */
typedef struct {
    ${real} slip, by_stress, by_limit;
} slip_t;

static inline slip_t slip_of(${real} stress, ${real} limit, const ${real} *terms) {
    const ${real} size = fabs(stress), share = 1.0 / (1.0 + terms[TERM_GAIN]);
    const ${real} side = stress < 0.0 ? -1.0 : 1.0;
    slip_t now = {0.0, 0.0, 0.0};
%% if creep
    /* Friction grows with the log of the bristle's own speed above the speed at which it rests:
       size - slip (1 + gain) = limit (1 + c ln(slip / (reach * reference))). */
    const ${real} at_rest = size - limit * (1.0 + ${creep} * (${log_rest}));
    const ${real} growth = limit * ${creep};
    if (at_rest <= 0.0) return now;
    if (at_rest * share > terms[TERM_REACH] * ${rest_speed} && growth > 1e-12) {
        const ${real} slope = (1.0 + terms[TERM_GAIN]) / growth;
        const ${real} w = wright_omega((size - limit) / growth + ${log_reference} + natural_log(terms[TERM_REACH] * slope));
        now.slip = side * w / slope;
        now.by_stress = share * w / (1.0 + w);
        now.by_limit = -side * now.by_stress * (size - w / slope * (1.0 + terms[TERM_GAIN])) / limit;
    } else {
        now.slip = side * at_rest * share;
        now.by_stress = share;
        now.by_limit = -side * share * (1.0 + ${creep} * (${log_rest}));
    }
%% else
    if (size > limit) {
        now.slip = side * (size - limit) * share;
        now.by_stress = share;
        now.by_limit = -side * share;
    }
%% endif
    return now;
}

%% if compliant
/* Torque and slope of the patch after a turn; nothing moves yet. */
static void try_turn(const ${name}_patch_t *patch, const ${real} *terms, const ${real} *limit, ${real} turn, ${real} *M_z, ${real} *slope) {
    ${real} total = 0.0, by_turn = 0.0;
    int32_t i;
    for (i = 0; i < BRISTLES; ++i) {
        const ${real} stretch = -lever_of[i] * turn;
%% if relaxation
        const ${real} stress = patch->q[i] + patch->branch[i] * terms[TERM_DECAY] + (1.0 + terms[TERM_GAIN]) * stretch;
%% else
        const ${real} stress = patch->q[i] + stretch;
%% endif
        const slip_t now = slip_of(stress, limit[i], terms);
        total += moment_of[i] * (stress - (1.0 + terms[TERM_GAIN]) * now.slip);
        by_turn -= moment_of[i] * lever_of[i] * (1.0 - (1.0 + terms[TERM_GAIN]) * now.by_stress);
    }
    *M_z = total;
    *slope = (1.0 + terms[TERM_GAIN]) * by_turn;
}

/* The torque at which the elements in series balance a patch that is linear: rigid + slope deflection(M_z). */
static ${real} balanced_torque(${real} rigid, ${real} slope, ${real} F_N) {
    ${real} low = lesser(0.0, rigid), high = greater(0.0, rigid), M_z = rigid, turn = 0.0, by_torque = 0.0;
    int32_t i;
    deflection(rigid, F_N, &turn, &by_torque);
    M_z = lesser(high, greater(low, rigid + slope * turn));
    for (i = 0; i < ${balance_steps}; ++i) {
        ${real} off, step;
        deflection(M_z, F_N, &turn, &by_torque);
        off = M_z - rigid - slope * turn;
        if (off < 0.0) low = M_z;
        else high = M_z;
        step = M_z - off / (1.0 - slope * by_torque);
        M_z = step >= low && step <= high ? step : 0.5 * (low + high);
    }
    return M_z;
}

%% endif
static void clear_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu) {
    int32_t i;
    for (i = 0; i < BRISTLES; ++i) {
        patch->q[i] = 0.0;
        patch->q_by_mu[i] = 0.0;
%% if relaxation
        patch->branch[i] = 0.0;
        patch->branch_by_mu[i] = 0.0;
%% endif
    }
    initial_memory(signals, &patch->angle${", patch->own" if own else ""});
    patch->angle_by_mu = 0.0;
    patch->mu = mu;
    patch->M_z = 0.0;
    patch->M_z_by_mu = 0.0;
    patch->slope = ${stiff};
}

/* The memory follows mu to first order; retention is the share of its derivative that a walk of mu leaves. */
static void follow_friction(${name}_patch_t *patch, ${real} mu, ${real} retention) {
    const ${real} change = mu - patch->mu;
    int32_t i;
    for (i = 0; i < BRISTLES; ++i) {
        patch->q_by_mu[i] *= retention;
        patch->q[i] += patch->q_by_mu[i] * change;
%% if relaxation
        patch->branch_by_mu[i] *= retention;
        patch->branch[i] += patch->branch_by_mu[i] * change;
%% endif
    }
    patch->angle_by_mu *= retention;
    patch->angle += patch->angle_by_mu * change;
    patch->M_z += patch->M_z_by_mu * retention * change;
    patch->mu = mu;
}

/* Every bristle after a turn, its derivative by mu at that turn, and by how much it follows the turn.
   sums: torque, its derivative by the turn and by mu. */
static void turn_bristles(${name}_patch_t *patch, const ${real} *terms, const ${real} *limit, ${real} turn, ${real} *follows, ${real} *sums) {
    const ${real} gain = terms[TERM_GAIN], over_mu = 1.0 / patch->mu;
    ${real} total = 0.0, by_turn = 0.0, by_mu = 0.0;
    int32_t i;
    for (i = 0; i < BRISTLES; ++i) {
        const ${real} stretch = -lever_of[i] * turn, limit_by_mu = limit[i] * over_mu;
        const ${real} q = patch->q[i] + stretch;
%% if relaxation
        const ${real} branch = patch->branch[i] * terms[TERM_DECAY] + gain * stretch;
        const ${real} branch_by_mu = patch->branch_by_mu[i] * terms[TERM_DECAY];
%% else
        const ${real} branch = 0.0, branch_by_mu = 0.0;
%% endif
        const slip_t now = slip_of(q + branch, limit[i], terms);
        const ${real} slip_by_mu = now.by_stress * (patch->q_by_mu[i] + branch_by_mu) + now.by_limit * limit_by_mu;
        patch->q[i] = q - now.slip;
        patch->q_by_mu[i] -= slip_by_mu;
        follows[i] = -lever_of[i] * (1.0 - (1.0 + gain) * now.by_stress);
%% if relaxation
        patch->branch[i] = branch - gain * now.slip;
        patch->branch_by_mu[i] = branch_by_mu - gain * slip_by_mu;
        total += moment_of[i] * (patch->q[i] + patch->branch[i]);
        by_mu += moment_of[i] * (patch->q_by_mu[i] + patch->branch_by_mu[i]);
%% else
        total += moment_of[i] * patch->q[i];
        by_mu += moment_of[i] * patch->q_by_mu[i];
%% endif
        by_turn += moment_of[i] * follows[i];
    }
    sums[0] = total;
    sums[1] = (1.0 + gain) * by_turn;
    sums[2] = by_mu;
}

/* Advances the patch to the signals of a sample: angle, rate, load, time. torque: M_z [N m], its derivative by
   mu and by the angle; slide: effective friction over mu, and what is beside it. */
static void advance_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu, ${real} retention, ${real} *torque, ${real} *slide) {
    ${real} terms[TERMS], limit[BRISTLES], follows[BRISTLES], sums[3], turn;
%% if compliant
    ${real} M_z, slope, by_torque = 0.0, deflected = 0.0, further, turn_by_mu, goal;
%% endif
%% if own
    ${real} own_next[${own}];
%% endif
    int32_t i;
    follow_friction(patch, mu, retention);
    sample_terms(signals, ${"patch->own, " if own else ""}terms${", own_next" if own else ""});
%% if own
    for (i = 0; i < ${own}; ++i) patch->own[i] = own_next[i];
%% endif
    for (i = 0; i < BRISTLES; ++i) limit[i] = mu * limit_over_mu(i, terms, terms[TERM_SPEED]);
%% if compliant
    /* Newton's steps from the slope of the last sample; after the last one the patch is taken as linear. */
    goal = terms[TERM_PSI] - patch->angle;
    M_z = patch->M_z;
    slope = patch->slope;
    turn = 0.0;
    for (i = 0; i < ${evaluations}; ++i) {
        M_z = balanced_torque(M_z + slope * (goal - turn), slope, terms[TERM_F_N]);
        deflection(M_z, terms[TERM_F_N], &deflected, &by_torque);
        turn = goal + deflected;
        if (i < ${evaluations} - 1) try_turn(patch, terms, limit, turn, &M_z, &slope);
    }
    turn_bristles(patch, terms, limit, turn, follows, sums);
    slope = sums[1];
    M_z = balanced_torque(sums[0] + slope * (goal - turn), slope, terms[TERM_F_N]);
    deflection(M_z, terms[TERM_F_N], &deflected, &by_torque);
    further = goal + deflected - turn;
    /* A turn by mu moves the torque, which moves the turn. */
    torque[1] = (sums[2] - slope * patch->angle_by_mu) / (1.0 - slope * by_torque);
    turn_by_mu = by_torque * torque[1] - patch->angle_by_mu;
    for (i = 0; i < BRISTLES; ++i) {
        patch->q[i] += follows[i] * further;
        patch->q_by_mu[i] += follows[i] * turn_by_mu;
%% if relaxation
        patch->branch[i] += terms[TERM_GAIN] * follows[i] * further;
        patch->branch_by_mu[i] += terms[TERM_GAIN] * follows[i] * turn_by_mu;
%% endif
    }
    patch->M_z = sums[0] + slope * further;
    patch->slope = slope;
    patch->angle += turn + further;
    patch->angle_by_mu += turn_by_mu;
    torque[2] = slope / (1.0 - slope * by_torque) + terms[TERM_TORQUE_BY_PSI];
%% else
    turn = terms[TERM_PSI] - patch->angle;
    turn_bristles(patch, terms, limit, turn, follows, sums);
    patch->M_z = sums[0];
    patch->slope = sums[1];
    patch->angle += turn;
    torque[1] = sums[2];
    torque[2] = sums[1] + terms[TERM_TORQUE_BY_PSI];
%% endif
    torque[0] = patch->M_z + terms[TERM_TORQUE];
    patch->M_z_by_mu = torque[1];
    slide[0] = slide_over_mu(terms);
    slide[1] = terms[TERM_BESIDE];
}

/* A change of the ground: the memory was made on the old one. */
static void forget_sensitivity(${name}_patch_t *patch, ${real} share) {
    int32_t i;
    for (i = 0; i < BRISTLES; ++i) {
        patch->q_by_mu[i] *= share;
%% if relaxation
        patch->branch_by_mu[i] *= share;
%% endif
    }
    patch->angle_by_mu *= share;
    patch->M_z_by_mu *= share;
}
