/* The contact patch: ${bristles} bristles. Deformation q and stress are over half-length and stiffness [1]. */

enum { BRISTLES = ${bristles}${", TRIED = BRISTLES / %d" % coarse if coarse} };
%% include "patches/term_places.c"

%% if not static_limit or not slide
/* Limit of a bristle over mu. */
static inline ${real} limit_over_mu(int32_t i, const ${real} *terms, ${real} speed) {
    ${real} pressure = 0.0; %% if grows
    const ${real} pressure = bristle_of[i].pressure; %% if not grows
%% if limited
    ${real} factor = 1.0;
    limit_factor(fabs(bristle_of[i].lever) * speed, &factor);
%% else
    const ${real} factor = 1.0;
    (void)speed;
%% endif
    pressure_at(bristle_of[i].place, terms[TERM_GROWTH], &pressure); %% if grows
    return terms[TERM_BASE] * pressure * factor;
}

%% endif
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
        const ${real} v = greater(fabs(bristle_of[i].lever) * speed, ${rest_speed});
        const ${real} creep = 1.0 + ${creep} * (natural_log(v) - ${log_reference});
%% else
        const ${real} creep = 1.0;
%% endif
        total += fabs(bristle_of[i].moment) * limit_over_mu(i, terms, speed) * creep;
    }
    return terms[TERM_SLIDE] * total * ${slide_weight} / terms[TERM_BASE];
%% endif
}

/* Slip that brings a bristle back to its limit, and its derivatives by stress and, through the limit, by mu. */
typedef struct {
    ${real} slip, by_stress, by_mu;
} slip_t;

/* Limits of the bristles: those of the sample, or the pressure times a scale. share: of the spring in the stiffness
   of spring and Maxwell branch. */
typedef struct {
    ${real} scale, over_mu${", mu_over_k" if by_k}${", share" if relaxation else ""};
    ${real} rest_scale, offset, least_slip, knots_per_scale, creep_scale; %% if creep
    ${real} of_bristle[BRISTLES]; %% if not static_limit
} limits_t;

static inline ${real} limit_over_scale(const limits_t *limits, int32_t i) {
%% if static_limit
    (void)limits;
    return bristle_of[i].pressure;
%% else
    return limits->of_bristle[i];
%% endif
}

%% if creep
/* Slip of a bristle beyond ${rest_factor} of its limit, where friction is that of rest. It grows with the log of a
   bristle's own speed: size - slip (1 + gain) = limit (1 + c ln(slip / (reach * reference))).
   With w = slip (1 + gain) / (limit c) that is w + ln w = size / (limit c) + ...; log_pressure and offset are in knots of the
   table of its root. */
static inline slip_t slip_of(${real} stress, ${real} pressure, ${real} rest_limit, const limits_t *limits, int32_t i) {
    const ${real} size = fabs(stress), at_rest = size - rest_limit;
    const ${real} limit = limits->scale * pressure; %% if not static_limit
    slip_t now;
    if (at_rest > limits->least_slip${"" if static_limit else " && limit > 1e-12"}) {
%% if static_limit
        const ${real} w = wright_omega(size * limits->knots_per_scale * bristle_of[i].inverse_pressure + limits->offset - bristle_of[i].log_pressure);
%% else
        const ${real} w = wright_omega(${omega_knots_per_unit} * (size / (limit * ${creep}) - natural_log(limit)) + limits->offset);
        (void)i;
%% endif
        const ${real} slip = w * limits->creep_scale * pressure;
        now.slip = stress < 0.0 ? -slip : slip;
        now.by_stress = w / (1.0 + w);
        now.by_mu = now.by_stress * (now.slip - stress${shared}) * limits->over_mu;
    } else {
        now.slip = (stress < 0.0 ? -at_rest : at_rest)${shared};
        now.by_stress = 1.0;
        now.by_mu = (stress < 0.0 ? rest_limit : -rest_limit) * limits->over_mu${shared};
    }
    return now;
}
%% else
/* Slip of a bristle beyond its limit. */
static inline slip_t slip_of(${real} stress, ${real} pressure, ${real} rest_limit, const limits_t *limits, int32_t i) {
    slip_t now;
    (void)pressure;
    (void)i;
    now.slip = (stress > 0.0 ? stress - rest_limit : stress + rest_limit)${shared};
    now.by_stress = 1.0;
    now.by_mu = (stress > 0.0 ? -rest_limit : rest_limit) * limits->over_mu${shared};
    return now;
}
%% endif

static void find_limits(const ${real} *terms, ${real} mu, limits_t *limits) {
    const ${real} slope = (1.0 + terms[TERM_GAIN]) * terms[TERM_REACH]; %% if creep
%% if not static_limit
    int32_t i;
    for (i = 0; i < BRISTLES; ++i) {
        limits->of_bristle[i] = limit_over_mu(i, terms, terms[TERM_SPEED]);
    }
    limits->scale = mu;
%% else
    limits->scale = mu * terms[TERM_BASE];
%% endif
    limits->over_mu = 1.0 / mu;
    limits->share = 1.0 / (1.0 + terms[TERM_GAIN]); %% if relaxation
%% if creep
    limits->rest_scale = limits->scale * ${rest_factor};
    limits->knots_per_scale = ${omega_knots_per_unit} / (limits->scale * ${creep});
    limits->offset = ${omega_knots_per_unit} * (${offset - omega_from} + natural_log(slope * ${"limits->knots_per_scale / %r" % omega_knots_per_unit if static_limit else 1 / creep}));
    limits->creep_scale = limits->scale * ${creep}${shared};
    limits->least_slip = slope * ${rest_speed};
%% endif
}

/* How the memory follows mu${" and k" if by_k}, to first order: share of its derivative that a walk of mu leaves, change of mu.
   With k, which is over its nominal value, the shares are a matrix, by which the derivatives by mu and k are multiplied. %% if by_k
   What the last sample's turn still lacked, and its derivatives: the next sample adds it, in the same loop. %% if compliant
   */
typedef struct {
    ${real} retention, change${", mu_from_k, k_from_mu, k_retention, k_change" if by_k}${", further, further_by_mu" if compliant}${", further_by_k" if compliant and by_k}${", gain" if compliant and relaxation};
} follow_t;

/* A bristle${" and its Maxwell branch" if relaxation}: stress, and its derivative by mu${" and by k" if by_k}. */
typedef struct {
    ${real} ${part}, ${part}_by_mu${", %s_by_k" % part if by_k}; %% for part in parts
} stress_t;

/* A bristle at the mu of the sample. */
static inline stress_t follow_friction(const ${name}_patch_t *restrict patch, const follow_t *restrict follow, int32_t i) {
    stress_t now;
%% for part in parts
    {
%% if compliant
        const ${real} follows = ${"follow->gain * " if part == "branch"}patch->follows[i];
        const ${real} ${part} = patch->${part}[i] - follows * follow->further, by_mu = patch->${part}_by_mu[i] - follows * follow->further_by_mu;
        const ${real} by_k = patch->${part}_by_k[i] - follows * follow->further_by_k; %% if by_k
%% else
        const ${real} ${part} = patch->${part}[i], by_mu = patch->${part}_by_mu[i]${", by_k = patch->%s_by_k[i]" % part if by_k};
%% endif
        now.${part}_by_mu = by_mu * follow->retention${" + by_k * follow->mu_from_k" if by_k};
        now.${part}_by_k = by_mu * follow->k_from_mu + by_k * follow->k_retention; %% if by_k
        now.${part} = ${part} + now.${part}_by_mu * follow->change${" + now.%s_by_k * follow->k_change" % part if by_k};
    }
%% endfor
    return now;
}

%% if compliant
/* Torque and slope of the patch${" at the nominal k" if by_k} after a turn; no bristle turns yet.
   One of ${coarse} bristles stands for its neighbours: M_z is that of all before, with what these make of the turn. %% if coarse
   */
static void try_turn(const ${name}_patch_t *restrict patch, ${"const follow_t *restrict follow, " if coarse}const ${real} *restrict terms, const limits_t *restrict limits, ${real} turn, ${real} *M_z, ${real} *slope) {
    ${real} total = 0.0, by_turn = 0.0;
    int32_t j;
    (void)terms; %% if not relaxation
    for (j = 0; j < ${"TRIED" if coarse else "BRISTLES"}; ++j) {
%% if coarse
        const int32_t i = tried_of[j].at;
        const stress_t was = follow_friction(patch, follow, i);
        const ${real} q = was.q, moment = tried_of[j].moment;
        const ${real} branch = was.branch; %% if relaxation
%% else
        const int32_t i = j;
        const ${real} q = patch->q[i], moment = bristle_of[i].moment;
        const ${real} branch = patch->branch[i]; %% if relaxation
%% endif
        const ${real} stretch = -(bristle_of[i].lever * turn);
        const ${real} pressure = limit_over_scale(limits, i);
        const ${real} rest_limit = limits->${"rest_scale" if creep else "scale"} * pressure;
        ${real} follows = 1.0;
        ${real} stress = q + branch * terms[TERM_DECAY] + (1.0 + terms[TERM_GAIN]) * stretch; %% if relaxation
        ${real} stress = q + stretch; %% if not relaxation
        if (fabs(stress) > rest_limit) {
            const slip_t now = slip_of(stress, pressure, rest_limit, limits, i);
            stress -= ${gained}now.slip;
            follows -= now.by_stress;
        }
        total += moment * ${"(stress - q%s)" % (" - branch" if relaxation) if coarse else "stress"};
        by_turn -= moment * bristle_of[i].lever * follows;
    }
    *M_z = ${"*M_z + " if coarse}total;
    *slope = ${gained}by_turn;
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
        if (off < 0.0) {
            low = M_z;
        } else {
            high = M_z;
        }
        step = M_z - off / (1.0 - slope * by_torque);
        M_z = step >= low && step <= high ? step : 0.5 * (low + high);
    }
    return M_z;
}

%% endif
static void begin_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu) {
    (void)memset(patch, 0, sizeof *patch);
    patch->slope = ${stiff}; %% if compliant
    initial_memory(signals, &patch->angle${", patch->own" if own else ""});
    patch->retained = 1.0;
    patch->mu = mu;
    patch->stiffness = 1.0; %% if by_k
}

/* Every bristle after a turn, its derivative by mu at that turn${", and by how much it follows the turn" if compliant}.
   sums: torque at the nominal k, its derivative by the turn and by mu${" and, through the bristles, by k" if by_k}. */
static void turn_bristles(${name}_patch_t *restrict patch, ${"const follow_t *follow, " if coarse or not compliant}const ${real} *restrict terms, const limits_t *restrict limits, ${real} turn, ${real} *sums) {
    const ${real} gain = terms[TERM_GAIN]; %% if relaxation
    ${real} total = 0.0, by_turn = 0.0, by_mu = 0.0${", by_k = 0.0" if by_k};
    int32_t i;
    (void)terms; %% if not relaxation
    for (i = 0; i < BRISTLES; ++i) {
        const ${real} stretch = -(bristle_of[i].lever * turn);
%% if compliant and not coarse
        const stress_t was = {
            patch->${part}[i], patch->${part}_by_mu[i],${" patch->%s_by_k[i]," % part if by_k} %% for part in parts
        };
%% else
        const stress_t was = follow_friction(patch, follow, i);
%% endif
        const ${real} q = was.q + stretch;
%% if relaxation
        const ${real} branch = was.branch * terms[TERM_DECAY] + gain * stretch;
        const ${real} branch_by_mu = was.branch_by_mu * terms[TERM_DECAY];
        const ${real} branch_by_k = was.branch_by_k * terms[TERM_DECAY]; %% if by_k
%% endif
        const ${real} pressure = limit_over_scale(limits, i);
        const ${real} rest_limit = limits->${"rest_scale" if creep else "scale"} * pressure;
        ${real} slip = 0.0, slip_by_mu = 0.0, ${"slip_by_k = 0.0, " if by_k}follow_turn = 1.0;
        if (fabs(q${branched}) > rest_limit) {
            const slip_t now = slip_of(q${branched}, pressure, rest_limit, limits, i);
            slip = now.slip;
            slip_by_mu = now.by_stress${shared} * (was.q_by_mu${branched_by_mu}) + now.by_mu;
            slip_by_k = now.by_stress${shared} * (was.q_by_k${" + branch_by_k" if relaxation}) - now.by_mu * limits->mu_over_k; %% if by_k
            follow_turn -= now.by_stress;
        }
        patch->q[i] = q - slip;
        patch->q_by_mu[i] = was.q_by_mu - slip_by_mu;
        follow_turn = bristle_of[i].lever * follow_turn;
        patch->follows[i] = follow_turn; %% if compliant
%% if relaxation
        patch->branch[i] = branch - gain * slip;
        patch->branch_by_mu[i] = branch_by_mu - gain * slip_by_mu;
        total += bristle_of[i].moment * (patch->q[i] + patch->branch[i]);
        by_mu += bristle_of[i].moment * (patch->q_by_mu[i] + patch->branch_by_mu[i]);
%% else
        total += bristle_of[i].moment * patch->q[i];
        by_mu += bristle_of[i].moment * patch->q_by_mu[i];
%% endif
%% if by_k
        patch->q_by_k[i] = was.q_by_k - slip_by_k;
        patch->branch_by_k[i] = branch_by_k - gain * slip_by_k; %% if relaxation
        by_k += bristle_of[i].moment * (patch->q_by_k[i]${" + patch->branch_by_k[i]" if relaxation});
%% endif
        by_turn -= bristle_of[i].moment * follow_turn;
    }
    sums[0] = total;
    sums[1] = ${gained}by_turn;
    sums[2] = by_mu;
    sums[3] = by_k; %% if by_k
}

/* Advances the patch to the signals of a sample: angle, rate, load, time. torque: M_z [N m] and its derivatives, see
   TORQUES; slide: effective friction over mu, and what is beside it. */
static void advance_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu, ${real} stiffness, const ${real} *retention, ${real} *torque, ${real} *slide) {
    limits_t limits;
    ${real} terms[TERMS], sums[${4 if by_k else 3}], turn;
    ${real} M_z, slope, by_torque = 0.0, deflected = 0.0, further, turn_by_mu, goal${", turn_by_k" if by_k}; %% if compliant
    ${real} own_next[${own}]; %% if own
    follow_t follow;
    int32_t i; %% if compliant and not coarse
    follow.retention = retention[0] * patch->retained;
    follow.change = mu - patch->mu;
%% if by_k
    follow.mu_from_k = retention[1] * patch->retained;
    follow.k_from_mu = retention[2] * patch->retained;
    follow.k_retention = retention[3] * patch->retained;
    follow.k_change = stiffness - patch->stiffness;
    patch->stiffness = stiffness;
%% else
    (void)stiffness;
    torque[BY_STIFFNESS] = 0.0;
%% endif
    patch->retained = 1.0;
%% if compliant
    follow.further = patch->further;
    follow.further_by_mu = patch->further_by_mu;
    follow.further_by_k = patch->further_by_k; %% if by_k
    follow.gain = patch->gain; %% if relaxation
%% for kept in ("angle", "M_z")
    {
        const ${real} by_mu = patch->${kept}_by_mu${", by_k = patch->%s_by_k" % kept if by_k};
        patch->${kept}_by_mu = by_mu * retention[0]${" + by_k * retention[1]" if by_k};
        patch->${kept}_by_k = by_mu * retention[2] + by_k * retention[3]; %% if by_k
        patch->${kept} += patch->${kept}_by_mu * follow.change${" + patch->%s_by_k * follow.k_change" % kept if by_k};
    }
%% endfor
%% endif
    patch->mu = mu;
    sample_terms(signals, ${"patch->own, " if own}terms${", own_next" if own});
    set_numbers(patch->own, own_next, ${own}); %% if own
%% if by_k
    /* Limits of stress over k depend on mu over k: their derivative by k follows from that by mu. */
    find_limits(terms, mu / stiffness, &limits);
    limits.over_mu = 1.0 / mu;
    limits.mu_over_k = mu / stiffness;
%% else
    find_limits(terms, mu, &limits);
%% endif
%% if compliant
    /* Newton's steps from the slope of the last sample; after the last one the patch is taken as linear. */
    goal = terms[TERM_PSI] - patch->angle;
    slope = patch->slope${times_k};
%% if coarse
    M_z = balanced_torque(patch->M_z${times_k} + slope * goal, slope, terms[TERM_F_N]);
    deflection(M_z, terms[TERM_F_N], &deflected, &by_torque);
    turn = goal + deflected;
    M_z = patch->M_z;
    try_turn(patch, &follow, terms, &limits, turn, &M_z, &slope);
    M_z *= stiffness; %% if by_k
    slope *= stiffness; %% if by_k
    M_z = balanced_torque(M_z + slope * (goal - turn), slope, terms[TERM_F_N]);
    deflection(M_z, terms[TERM_F_N], &deflected, &by_torque);
    turn = goal + deflected;
%% else
    for (i = 0; i < BRISTLES; ++i) {
        const stress_t now = follow_friction(patch, &follow, i);
%% for part in parts
        patch->${part}[i] = now.${part};
        patch->${part}_by_mu[i] = now.${part}_by_mu;
        patch->${part}_by_k[i] = now.${part}_by_k; %% if by_k
%% endfor
    }
    M_z = patch->M_z${times_k};
    turn = 0.0;
    for (i = 0; i < ${evaluations}; ++i) {
        const ${real} before = turn;
        M_z = balanced_torque(M_z + slope * (goal - turn), slope, terms[TERM_F_N]);
        deflection(M_z, terms[TERM_F_N], &deflected, &by_torque);
        turn = goal + deflected;
        /* Newton's error is the square of the last step. */
        if (i == ${evaluations} - 1 || (i > 0 && fabs(turn - before) < 1e-10)) {
            break;
        }
        try_turn(patch, terms, &limits, turn, &M_z, &slope);
        M_z *= stiffness; %% if by_k
        slope *= stiffness; %% if by_k
    }
%% endif
    turn_bristles(patch, ${"&follow, " if coarse}terms, &limits, turn, sums);
    slope = sums[1]${times_k};
    M_z = balanced_torque(sums[0]${times_k} + slope * (goal - turn), slope, terms[TERM_F_N]);
    deflection(M_z, terms[TERM_F_N], &deflected, &by_torque);
    further = goal + deflected - turn;
    /* A turn by mu${" or by k" if by_k} moves the torque, which moves the turn. */
    patch->M_z = sums[0] + sums[1] * further;
    torque[BY_MU] = (sums[2]${times_k} - slope * patch->angle_by_mu) / (1.0 - slope * by_torque);
    turn_by_mu = by_torque * torque[BY_MU] - patch->angle_by_mu;
    patch->further = further;
    patch->further_by_mu = turn_by_mu;
    patch->angle += turn + further;
    patch->angle_by_mu += turn_by_mu;
    patch->M_z_by_mu = sums[2] + sums[1] * turn_by_mu;
%% if by_k
    torque[BY_STIFFNESS] = (patch->M_z + stiffness * sums[3] - slope * patch->angle_by_k) / (1.0 - slope * by_torque);
    turn_by_k = by_torque * torque[BY_STIFFNESS] - patch->angle_by_k;
    patch->further_by_k = turn_by_k;
    patch->angle_by_k += turn_by_k;
    patch->M_z_by_k = sums[3] + sums[1] * turn_by_k;
%% endif
    patch->gain = terms[TERM_GAIN]; %% if relaxation
    torque[BY_ANGLE] = slope / (1.0 - slope * by_torque) + terms[TERM_TORQUE_BY_PSI];
%% else
    turn = terms[TERM_PSI] - patch->angle;
    turn_bristles(patch, &follow, terms, &limits, turn, sums);
    patch->M_z = sums[0];
    patch->angle += turn;
    torque[BY_MU] = sums[2]${times_k};
    torque[BY_STIFFNESS] = patch->M_z + stiffness * sums[3]; %% if by_k
    torque[BY_ANGLE] = sums[1]${times_k} + terms[TERM_TORQUE_BY_PSI];
%% endif
    patch->slope = sums[1]; %% if compliant
    torque[M_Z] = patch->M_z${times_k} + terms[TERM_TORQUE];
    slide[0] = slide_over_mu(terms);
    slide[1] = terms[TERM_BESIDE];
}

/* A change of the ground: the memory was made on the old one. The bristles follow with the next sample. */
static void forget_sensitivity(${name}_patch_t *patch, ${real} share) {
    patch->retained *= share;
%% if compliant
%% for kept in ("angle", "M_z")
    patch->${kept}_by_mu *= share;
    patch->${kept}_by_k *= share; %% if by_k
%% endfor
%% endif
}
