/* Runs an observer along a recording on this machine. Each of the count samples is a row psi, psi_dot, ${torque}, F_N,
   dt; each output is a row mu, mu_std, M_z_predicted, informed, status. */
#include "${name}.h"

void run(int64_t count, const ${real} *samples, ${real} *outputs) {
    static ${name}_state_t state;
    int64_t i;
    ${name}_init(&state);
    for (i = 0; i < count; ++i) {
        const ${real} *row = samples + 5 * i;
        ${real} *output = outputs + 5 * i;
        ${name}_sample_t sample;
        ${name}_estimate_t estimate;
        sample.psi = row[0], sample.psi_dot = row[1], sample.${torque} = row[2], sample.F_N = row[3], sample.dt = row[4];
        ${name}_step(&state, &sample);
        ${name}_estimate(&state, &estimate);
        output[0] = estimate.mu, output[1] = estimate.mu_std, output[2] = estimate.M_z_predicted;
        output[3] = (${real})estimate.informed, output[4] = (${real})estimate.status;
    }
}
