/* Runs an observer along a recording on this machine. Each of the count samples is a row psi, psi_dot, ${torque}, F_N,
   dt; each output is a row ${estimate|join(", ")}. */
#include "${name}.h"

#ifdef _WIN32
__declspec(dllexport)
#endif
void run(int64_t count, const ${real} *samples, ${real} *outputs) {
    static ${name}_state_t state;
    int64_t i;
    ${name}_init(&state);
    for (i = 0; i < count; ++i) {
        const ${real} *row = samples + 5 * i;
        ${real} *output = outputs + ${estimate|length} * i;
        ${name}_sample_t sample;
        ${name}_estimate_t estimate;
        sample.psi = row[0], sample.psi_dot = row[1], sample.${torque} = row[2], sample.F_N = row[3], sample.dt = row[4];
        ${name}_step(&state, &sample);
        ${name}_estimate(&state, &estimate);
        output[${loop.index0}] = (${real})estimate.${name}; %% for name in estimate
    }
}
