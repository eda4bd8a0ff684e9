/* As little of Simulink's simstruc.h as a generated S-function asks for, after its published reference. It
   stands in for Simulink, which is not at hand: it shows that the code compiles and steps, no more. */
#ifndef SIMSTRUC_H
#define SIMSTRUC_H

#include <stddef.h>

typedef double real_T;
typedef int int_T;
typedef double mxArray;
enum { SS_DOUBLE = 0, SS_OPTION_EXCEPTION_FREE_CODE = 1, MOST = 10 };

typedef struct {
    int_T parameters_expected, parameters_count, inputs, outputs, dworks;
    const mxArray *parameter;
    const char *error;
    real_T sample_time, offset, in[MOST], out[MOST], *dwork;
    int_T in_width[MOST], out_width[MOST], through[MOST], dwork_width, dwork_type;
    unsigned options;
} SimStruct;

#define mxGetScalar(array) (*(array))
#define ssSetNumSFcnParams(S, n) ((S)->parameters_expected = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters_expected)
#define ssGetSFcnParamsCount(S) ((S)->parameters_count)
#define ssGetSFcnParam(S, i) ((S)->parameter + (i))
#define ssSetSFcnParamTunable(S, i, yes) ((void)(S), (void)(i), (void)(yes))
#define ssSetErrorStatus(S, text) ((S)->error = (text))
#define ssSetNumInputPorts(S, n) ((S)->inputs = (n), (n) <= (int_T)MOST)
#define ssSetNumOutputPorts(S, n) ((S)->outputs = (n), (n) <= (int_T)MOST)
#define ssSetInputPortWidth(S, i, n) ((S)->in_width[i] = (n))
#define ssSetOutputPortWidth(S, i, n) ((S)->out_width[i] = (n))
#define ssSetInputPortRequiredContiguous(S, i, yes) ((void)(S), (void)(i), (void)(yes))
#define ssSetInputPortDirectFeedThrough(S, i, yes) ((S)->through[i] = (yes))
#define ssSetNumSampleTimes(S, n) ((void)(S), (void)(n))
#define ssSetSampleTime(S, i, t) ((void)(i), (S)->sample_time = (t))
#define ssSetOffsetTime(S, i, t) ((void)(i), (S)->offset = (t))
#define ssSetNumDWork(S, n) ((S)->dworks = (n))
#define ssSetDWorkWidth(S, i, n) ((void)(i), (S)->dwork_width = (n))
#define ssSetDWorkDataType(S, i, type) ((void)(i), (S)->dwork_type = (type))
#define ssSetOptions(S, given) ((S)->options = (given))
#define ssGetDWork(S, i) ((void)(i), (void *)(S)->dwork)
#define ssGetInputPortRealSignal(S, i) ((const real_T *)&(S)->in[i])
#define ssGetOutputPortRealSignal(S, i) (&(S)->out[i])

#endif
