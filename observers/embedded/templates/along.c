/* Takes an observer along a recording on the host. Of count samples, a row each: psi, psi_dot, $torque, F_N, dt in;
   mu, mu_std, M_z_predicted, informed, status out. */
#include "$name.h"

void along(int64_t count, const $real *samples, $real *said) {
    static ${name}_state_t state;
    int64_t i;
    ${name}_init(&state);
    for (i = 0; i < count; ++i) {
        const $real *row = samples + 5 * i;
        $real *out = said + 5 * i;
        ${name}_sample_t sample;
        ${name}_estimate_t now;
        sample.psi = row[0], sample.psi_dot = row[1], sample.$torque = row[2], sample.F_N = row[3], sample.dt = row[4];
        ${name}_step(&state, &sample);
        ${name}_estimate(&state, &now);
        out[0] = now.mu, out[1] = now.mu_std, out[2] = now.M_z_predicted;
        out[3] = ($real)now.informed, out[4] = ($real)now.status;
    }
}
