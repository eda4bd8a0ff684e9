
/* Advances the patch to the signals of a sample; torque: M_z [N m] and its derivatives, see TORQUES. */
static void advance_patch(${name}_patch_t *patch, const ${real} *signals, ${real} mu, ${real} stiffness, const ${real} *retention, ${real} *torque, ${real} *slide) {
    const ${real} k = ${k} * stiffness, scale = mu / k;
    ${real} moment[3], beside[2] = {0.0, 0.0};
    (void)retention;
    turn_to_sample(patch, signals, scale, beside, slide);
    patch_moment(patch, scale, moment);
    torque[M_Z] = k * moment[0]${" + beside[0]" if effects};
    torque[BY_MU] = moment[1];
    torque[BY_STIFFNESS] = ${k} * (moment[0] - scale * moment[1]);
    torque[BY_ANGLE] = k * moment[2]${" + beside[1]" if effects};
}
