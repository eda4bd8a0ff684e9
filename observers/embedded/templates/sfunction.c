/* ${title}
   As a block of Simulink, an S-function of level 2:

       mex ${name}_sfun.c ${name}.c

   Input ports, one number each: psi [rad], psi_dot [rad/s], ${torque} [N m], F_N [N], NaN where a sensor gave none;
   ${"a missing psi_dot is derived from psi" if uses_rate else "psi_dot is not used: the rate is estimated"}.
   Output ports: ${estimate|join(", ")}, torques in N m. Parameter: the sample time [s].
   Outputs are those of the last sample, without direct feedthrough, so that a controller may close its loop over
   them; the block takes its sample when Simulink updates discrete states. Each block has a state of its own.

   ${generated} */
#define S_FUNCTION_NAME ${name}_sfun
#define S_FUNCTION_LEVEL 2

#include "simstruc.h"

#include "${name}.h"

enum { PSI, PSI_DOT, TORQUE, LOAD, INPUTS };
enum { PORTS = ${estimate|length} };

static real_T sample_time(SimStruct *S) { return mxGetScalar(ssGetSFcnParam(S, 0)); }

static ${name}_state_t *state_of(SimStruct *S) { return (${name}_state_t *)ssGetDWork(S, 0); }

static void mdlInitializeSizes(SimStruct *S) {
    int_T i;
    ssSetNumSFcnParams(S, 1);
    if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) return;
    ssSetSFcnParamTunable(S, 0, 0);
    if (!(sample_time(S) > 0.0 && sample_time(S) <= ${longest_step})) {
        ssSetErrorStatus(S, "The sample time must be greater than 0 s and at most ${longest_step} s.");
        return;
    }
    if (!ssSetNumInputPorts(S, INPUTS) || !ssSetNumOutputPorts(S, PORTS)) return;
    for (i = 0; i < INPUTS; ++i) {
        ssSetInputPortWidth(S, i, 1);
        ssSetInputPortRequiredContiguous(S, i, 1);
        ssSetInputPortDirectFeedThrough(S, i, 0);
    }
    for (i = 0; i < PORTS; ++i) ssSetOutputPortWidth(S, i, 1);
    ssSetNumSampleTimes(S, 1);
    /* The width is in doubles, whose alignment suits every number of the state. */
    ssSetNumDWork(S, 1);
    ssSetDWorkWidth(S, 0, (int_T)((sizeof(${name}_state_t) + sizeof(real_T) - 1) / sizeof(real_T)));
    ssSetDWorkDataType(S, 0, SS_DOUBLE);
    ssSetOptions(S, SS_OPTION_EXCEPTION_FREE_CODE);
}

static void mdlInitializeSampleTimes(SimStruct *S) {
    ssSetSampleTime(S, 0, sample_time(S));
    ssSetOffsetTime(S, 0, 0.0);
}

#define MDL_INITIALIZE_CONDITIONS
static void mdlInitializeConditions(SimStruct *S) { ${name}_init(state_of(S)); }

static void mdlOutputs(SimStruct *S, int_T tid) {
    ${name}_estimate_t estimate;
    (void)tid;
    ${name}_estimate(state_of(S), &estimate);
    *ssGetOutputPortRealSignal(S, ${loop.index0}) = (real_T)estimate.${name}; %% for name in estimate
}

#define MDL_UPDATE
static void mdlUpdate(SimStruct *S, int_T tid) {
    ${name}_sample_t sample;
    (void)tid;
    sample.${field} = (${real})*ssGetInputPortRealSignal(S, ${place}); %% for field, place in sensors
    sample.dt = (${real})sample_time(S);
    ${name}_step(state_of(S), &sample);
}

static void mdlTerminate(SimStruct *S) { (void)S; }

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
