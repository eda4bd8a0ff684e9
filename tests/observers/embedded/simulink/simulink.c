/* What an S-function includes at its end; here a loop along samples, as Simulink's over the major steps. */
#include <stdint.h>
#include <stdlib.h>

/* Rows of inputs, and of the outputs at each; 0 if the sample time is refused. */
int64_t simulate(int64_t count, real_T sample_time, const real_T *inputs, real_T *outputs) {
    SimStruct S = {0};
    int64_t i;
    int j;
    S.parameters_count = 1;
    S.parameter = &sample_time;
    mdlInitializeSizes(&S);
    if (S.error != NULL) return 0;
    S.dwork = calloc((size_t)S.dwork_width, sizeof(real_T));
    mdlInitializeSampleTimes(&S);
    mdlInitializeConditions(&S);
    for (i = 0; i < count; ++i) {
        for (j = 0; j < S.inputs; ++j) S.in[j] = inputs[i * S.inputs + j];
        mdlOutputs(&S, 0);
        for (j = 0; j < S.outputs; ++j) outputs[i * S.outputs + j] = S.out[j];
        mdlUpdate(&S, 0);
    }
    mdlTerminate(&S);
    free(S.dwork);
    return S.sample_time == sample_time ? count : -1;
}
