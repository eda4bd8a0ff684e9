/* Takes a sample of plausible values, NAN for others, into now: psi, psi_dot, M_z or M, F_N; returns 1 where one is
   implausible. An angle that jumps and stays is that of a sensor whose zero has moved: the jump is taken off. */
static int32_t screen_sample(${name}_state_t *state, const ${name}_sample_t *sample, ${real} *now) {
    const ${real} bounds[4] = {PSI_LIMIT, PSI_RATE_LIMIT, TORQUE_LIMIT, LOAD_LIMIT};
    const ${real} psi = sample->psi - state->offset;
    int32_t i, implausible = 0;
    now[0] = sample->psi;
    now[1] = sample->psi_dot;
    now[2] = sample->${torque};
    now[3] = sample->F_N;
    for (i = 0; i < 4; ++i) {
        if (fabs(now[i]) < bounds[i]) {
            continue;
        }
        if (is_known(now[i])) {
            implausible = 1;
        }
        now[i] = (${real})NAN;
    }
    state->age += sample->dt;
    state->other_age += sample->dt;
    if (!is_known(now[0]) || state->now < 0) {
        return implausible;
    }
    now[0] = psi;
    if (state->waiting >= 0.0 && fabs(psi - state->other) < fabs(psi - state->psi) &&
        fabs(psi - state->other) <= SLACK + PSI_RATE_LIMIT * state->other_age) {
        state->waiting += state->other_age;
        if (state->waiting + 0.5 * sample->dt >= REZERO_TIME) {
            state->offset += state->jump;
            state->waiting = -1.0;
            now[0] = psi - state->jump;
            return implausible;
        }
    } else if (fabs(psi - state->psi) <= SLACK + PSI_RATE_LIMIT * state->age) {
        state->waiting = -1.0;
        return implausible;
    } else {
        state->waiting = 0.0;
        state->jump = psi - state->psi;
    }
    state->other = psi;
    state->other_age = 0.0;
    now[0] = (${real})NAN;
    return 1;
}
