/* What the effects make of a sample. */
enum {
%% for name in terms
    TERM_${name|upper},
%% endfor
    TERMS
};

static void begin_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu) {
    ${real} angle = 0.0;
    (void)mu;
    initial_memory(signals, &angle${", patch->own" if own else ""});
    clear_patch(patch, angle);
}

%% if not is_window or angle_is_state == "1"
/* Moment of the patch over k [m^3 rad], its derivative by scale, and, where it is used, by the angle. */
static void patch_moment(const ${name}_patch_t *patch, ${real} scale, ${real} *moment) {
    ${real} total = (patch->rest - patch->angle) * ${still_moment}, by_scale = 0.0, by_angle = -${still_moment};
    ${real} corner_moment[2] = {0.0, 0.0}, z = 0.0;
    int32_t i;
    for (i = 0; i < patch->corners; ++i) {
        z = smaller(scale * patch->xi[i], FAR_OUT);
        unit_moment(patch, z, corner_moment);
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
/* Advances the patch to the signals of a sample: angle, rate, load, time; scale = mu / k. terms: what the effects
   make of the sample; slide: effective friction over mu, and what is beside it. */
static void turn_with_effects(${name}_patch_t *patch, const ${real} *signals, ${real} scale, ${real} *terms, ${real} *slide) {
%% if own
    ${real} own_next[${own}];
    int32_t i;
    sample_terms(signals, patch->own, terms, own_next);
    for (i = 0; i < ${own}; ++i) {
        patch->own[i] = own_next[i];
    }
%% else
    sample_terms(signals, terms);
%% endif
    turn_patch(patch, terms[TERM_PSI], ${level} * terms[TERM_BASE], scale);
    slide[0] = terms[TERM_SLIDE];
    slide[1] = terms[TERM_BESIDE];
}
%% if not is_window

/* The same; torque: M_z [N m], its derivative by mu and by the angle. */
static void advance_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu, ${real} retention, ${real} *torque, ${real} *slide) {
    ${real} terms[TERMS], moment[3];
    const ${real} scale = mu / ${k};
    (void)retention;
    turn_with_effects(patch, signals, scale, terms, slide);
    patch_moment(patch, scale, moment);
    torque[0] = ${k} * moment[0] + terms[TERM_TORQUE];
    torque[1] = moment[1];
    torque[2] = ${k} * moment[2] + terms[TERM_TORQUE_BY_PSI];
}
%% endif
