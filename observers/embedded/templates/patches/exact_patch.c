%% if effects
%% include "patches/term_places.c"

%% endif
/* The contact patch: a polyline r(xi) for xi >= 0, the limits of r at plus and minus `level`.

   In xi, the place along the patch over the pressure there, a turn adds the same slope everywhere and
   friction cuts off what is beyond the limits. The corners are stored, innermost and oldest first: where,
   r there, and by how much the slope changes. From 0 to the first corner the slope is rest - angle, after
   the last it is 0. A turn takes the corner at the limit further in, or adds one; nothing else moves but
   r. Units are those in which neither mu nor k matters: r k / mu [N/m^3] and xi k / mu [N/(m^3 rad)]. */

/* Where the angle is a state of the observer, the slope of the torque by it is computed too. */
#define ANGLE_IS_ESTIMATED ${angle_is_state|int}
/* Turns below this are rounding, not motion [rad]. */
#define STILL 1e-12
/* Corners beyond carry no torque, and could not be squared [1/m]. */
#define FAR_OUT 1e15
/* A turn this far from rest has wiped out what was before, and its digits are lost to the sums of slopes [rad]. */
#define FAR_TURN 100.0
/* Places that are free before a sample: with more than ${depth} - PLACES corners, the least one is dropped, as in Python. */
#define PLACES 3

%% if rig_at_run_time
/* The stiffness k, the half-length a and the caster length e, and what follows from them alone. */
static void set_geometry(${name}_patch_t *patch, ${real} k, ${real} a, ${real} e) {
    ${real} moment[2];
    patch->k = k;
    patch->geometry[0] = a;
    patch->geometry[1] = e;
    unit_moment(0.0, patch->geometry, moment);
    patch->still_moment = moment[0];
    patch->level = 0.75 / (a * a * a);
}

%% endif
static ${real} smaller(${real} a, ${real} b) { return a < b ? a : b; }

static void clear_patch(${name}_patch_t *patch, ${real} psi) {
    patch->angle = psi;
    patch->rest = psi;
    patch->corners = 0;
}

/* Drops the corner that contributes least to M_z, straight from its neighbour to the next: the area that
   this cuts off, times z / (1 + z^2)^(5/2), z = a xi, with which r enters the torque. */
static void drop_corner(${name}_patch_t *patch, ${real} scale) {
    int32_t i, least = 1;
    ${real} least_weight = (${real})INFINITY, before, after, chord, span;
    for (i = 1; i < patch->corners - 1; ++i) {
        const ${real} z = ${a} * scale * patch->xi[i], u = 1.0 + z * z;
        span = patch->xi[i + 1] - patch->xi[i - 1];
        chord = patch->r[i + 1] - patch->r[i - 1];
        /* r off the chord, times the span. */
        chord = fabs((patch->r[i] - patch->r[i - 1]) * span - chord * (patch->xi[i] - patch->xi[i - 1]));
        if (!(chord * z >= least_weight * u * u * sqrt(u))) {
            least_weight = chord * z / (u * u * sqrt(u));
            least = i;
        }
    }
    before = patch->rest - patch->angle;
    for (i = 0; i < least; ++i) {
        before += patch->d[i];
    }
    after = before + patch->d[least];
    span = patch->xi[least + 1] - patch->xi[least - 1];
    chord = span > 0.0 ? (patch->r[least + 1] - patch->r[least - 1]) / span : before;
    patch->d[least - 1] += chord - before;
    patch->d[least + 1] += after - chord;
    for (i = least; i < patch->corners - 1; ++i) {
        patch->xi[i] = patch->xi[i + 1];
        patch->r[i] = patch->r[i + 1];
        patch->d[i] = patch->d[i + 1];
        if (ANGLE_IS_ESTIMATED) {
            patch->clipped[i] = patch->clipped[i + 1];
        }
    }
    --patch->corners;
}

/* One more corner behind all others; where there is no place for it, its change of slope is that of the last one.
   clipped: 1 where a stretch at the limit begins, -1 where it ends. */
static void add_corner(${name}_patch_t *patch, ${real} xi, ${real} r, ${real} d, int8_t clipped) {
    if (patch->corners == ${depth}) {
        patch->d[${depth} - 1] += d;
        return;
    }
    patch->xi[patch->corners] = xi;
    patch->r[patch->corners] = r;
    patch->d[patch->corners] = d;
    if (ANGLE_IS_ESTIMATED) {
        patch->clipped[patch->corners] = clipped;
    }
    ++patch->corners;
}

/* The corners from `first` on, which is beyond the limit, anew: those beyond are replaced by the points at
   which their two stretches cross it. */
static void clip_from(${name}_patch_t *patch, int32_t first, ${real} turn, ${real} level) {
    ${real} xi[${depth}], r[${depth}], d[${depth}];
    ${real} slope = patch->rest - patch->angle, slope_before, xi_in = 0.0, r_in = 0.0;
    const int32_t count = patch->corners - first;
    int32_t i;
    for (i = 0; i < first; ++i) {
        slope += patch->d[i];
    }
    if (first > 0) {
        xi_in = patch->xi[first - 1];
        r_in = patch->r[first - 1];
    }
    /* Most often there is one, which is not worth a call to copy it. */
    xi[0] = patch->xi[first];
    r[0] = patch->r[first];
    d[0] = patch->d[first];
    for (i = 1; i < count; ++i) {
        xi[i] = patch->xi[first + i];
        r[i] = patch->r[first + i];
        d[i] = patch->d[first + i];
    }
    patch->corners = first;
    slope_before = slope;
    for (i = 0; i < count; ++i) {
        const bool last = i == count - 1;
        const ${real} limit = r[i] > 0.0 ? level : -level;
        const ${real} out = last ? -turn : slope + d[i];
        if (fabs(r[i]) <= level) {
            add_corner(patch, xi[i], r[i], out - slope_before, 0);
            slope_before = out;
        } else {
            if (r[i] > 0.0 ? r_in <= level : r_in >= -level) {
                const ${real} x = xi_in + (limit - r_in) / (r[i] - r_in) * (xi[i] - xi_in);
                add_corner(patch, x, limit, -slope_before, 1);
                slope_before = 0.0;
            }
            if (last ? (r[i] > 0.0 ? turn > 0.0 : turn < 0.0)
                     : (r[i] > 0.0 ? r[i + 1] <= level : r[i + 1] >= -level)) {
                const ${real} x = last ? xi[i] + (r[i] - limit) / turn
                                     : xi[i] + (limit - r[i]) / (r[i + 1] - r[i]) * (xi[i + 1] - xi[i]);
                add_corner(patch, x, limit, out - slope_before, -1);
                slope_before = out;
            }
        }
        xi_in = xi[i];
        r_in = r[i];
        slope = out;
    }
}

/* One sample: the patch at an angle psi [rad] under a load; level = 3 F_N / (4 a^3), scale = mu / k. */
static void turn_patch(${name}_patch_t *patch, ${real} psi, ${real} level, ${real} scale) {
    ${real} turn, xi = 0.0, r = 0.0;
    int32_t i, first = -1;
    if (fabs(psi - patch->rest) > FAR_TURN) {
        clear_patch(patch, psi > patch->angle ? psi - FAR_TURN / 2.0 : psi + FAR_TURN / 2.0);
    }
    if (patch->corners > ${depth} - PLACES) {
        drop_corner(patch, scale);
    }
    turn = psi - patch->angle;
    patch->is_turning = fabs(turn) > STILL;
    if (patch->is_turning != 0) {
        patch->angle = psi;
    } else {
        turn = 0.0;
    }
    for (i = 0; i < patch->corners; ++i) {
        r = patch->r[i] - patch->xi[i] * turn;
        patch->r[i] = r;
        if (ANGLE_IS_ESTIMATED) {
            patch->clipped[i] = 0;
        }
        if (first < 0 && fabs(r) > level) {
            first = i;
        }
    }
    if (patch->corners > 0) {
        xi = patch->xi[patch->corners - 1];
    }
    if (first >= 0) {
        clip_from(patch, first, turn, level);
    }
    if (patch->is_turning == 0) {
        return;
    }
    /* The tail comes from the last corner, as it was, and reaches the far limit where it is not beyond; a loop that
       closes to the last digit ends on the limit: the tail is flat from there. */
    level = turn > 0.0 ? -level : level;
    if (turn > 0.0 ? r >= level : r <= level) {
        add_corner(patch, xi + (r - level) / turn, level, turn, 1);
    }
}

%% if angle_is_state or not window
/* Moment of the patch over k [m^3 rad], its derivative by scale, and, where it is used, by the angle. */
static void patch_moment(const ${name}_patch_t *patch, ${real} scale, ${real} *moment) {
    ${real} total = (patch->rest - patch->angle) * ${still_moment}, by_scale = 0.0, by_angle = -${still_moment};
    ${real} corner_moment[2] = {0.0, 0.0}, z = 0.0;
    int32_t i;
    for (i = 0; i < patch->corners; ++i) {
        z = smaller(scale * patch->xi[i], FAR_OUT);
        unit_moment(z${geometry}, corner_moment);
        total += patch->d[i] * corner_moment[0];
        by_scale += patch->d[i] * corner_moment[1] * patch->xi[i];
        if (ANGLE_IS_ESTIMATED && patch->clipped[i] != 0) {
            by_angle += (patch->clipped[i] > 0 ? 1.0 : -1.0) * (corner_moment[0] - z * corner_moment[1]);
        }
    }
    /* At rest the end of the patch moves with the last corner. */
    if (ANGLE_IS_ESTIMATED && patch->is_turning == 0) {
        by_angle = patch->corners > 0 ? by_angle + corner_moment[0] : 0.0;
    }
    moment[0] = total;
    moment[1] = by_scale;
    moment[2] = by_angle;
}

%% endif
static void begin_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu) {
    (void)mu;
%% if effects
    {
        ${real} angle = 0.0;
        initial_memory(signals, &angle${", patch->own" if own else ""});
        clear_patch(patch, angle);
    }
%% else
    clear_patch(patch, signals[0]);
%% endif
}

/* Turns the patch to the signals of a sample: angle, rate, load, time; scale = mu / k. beside: the torque beside the
   patch [N m] and its derivative by the angle; slide: effective friction over mu, and what is beside it. */
static void turn_to_sample(${name}_patch_t *patch, const ${real} *signals, ${real} scale, ${real} *beside, ${real} *slide) {
%% if effects
    ${real} terms[TERMS]${", own_next[%s]" % own if own};
    sample_terms(signals, ${"patch->own, " if own}terms${", own_next" if own});
    set_numbers(patch->own, own_next, ${own}); %% if own
    turn_patch(patch, terms[TERM_PSI], ${level} * terms[TERM_BASE], scale);
    beside[0] = terms[TERM_TORQUE];
    beside[1] = terms[TERM_TORQUE_BY_PSI];
    slide[0] = terms[TERM_SLIDE];
    slide[1] = terms[TERM_BESIDE];
%% else
    turn_patch(patch, signals[0], ${level} * signals[2], scale);
    (void)beside;
    (void)slide;
%% endif
}
