/* Tyre-road friction at standstill, estimated from the torque at the steered wheel.

   ${title}

   ${generated}
   ${rig_comment}
   C99 without heap, recursion, input, output or static variables: any number of observers may run at once, also
   in different threads, each with a state of its own.

       static ${name}_state_t state;
       ${name}_init(&state);
       for (;;) {
           ${name}_step(&state, &sample);
           ${name}_estimate(&state, &estimate);
       }
*/
#ifndef ${NAME}_H
#define ${NAME}_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One sample of the sensors; NAN where a sensor gave none. Infinite values and those beyond 1e9 count as NAN. */
typedef struct {
    ${real} psi;     /* yaw (steering) angle [rad] */
    ${real} psi_dot; /* ${"yaw rate [rad/s]; a missing one is derived from psi" if uses_rate else "not used: the rate is estimated"} */
    ${real} ${torque};     /* ${torque_meaning} [N m] */
    ${real} F_N;     /* vertical load [N]; where it is missing, the last one stands; missing is one below
                        a twentieth of the first, and the aligning torque with it */
    ${real} dt;      /* time since the last sample, greater than 0 and at most 3600 [s] */
} ${name}_sample_t;

/* Status of a sample; several flags may be set. */
enum {
    ${NAME}_USED = 0,
    ${NAME}_${flag} = ${number}, /* ${remedy} */ %% for flag, number, remedy in flags
};

/* Estimate after a sample. */
typedef struct {
    ${real} mu;            /* coefficient of the model's own law [1]; act on mu_eff */
    ${real} mu_std;        /* its standard deviation [1] */
    ${real} M_z_predicted; /* predicted aligning torque [N m]; NAN before the first sample, as all below */
    ${real} mu_eff;        /* friction to act on: M_slide over that of the declared patch with mu = 1 [1] */
    ${real} mu_eff_std;    /* its standard deviation [1] */
    ${real} M_slide;       /* torque of steady full slide at the present load, mean of both directions [N m] */
    ${real} nis;           /* square of measured minus predicted over its variance [1]; NAN if not measured */
    int32_t informed;    /* 0 while the estimate rests on the prior, else 1 */
    int32_t usable;      /* 1 where a controller may act on mu_eff: informed by this sample, and no flag is set */
    int32_t status;      /* flags as above */
} ${name}_estimate_t;

%% if weaker
/* Share of mu_eff and M_slide, the means of both directions of turning, that the weaker direction holds less [1]. The
   lower end of its 95 % band is mu_eff * (1 - ${NAME}_WEAKER) - 2 * mu_eff_std. */
#define ${NAME}_WEAKER ${weaker}

%% elif ratio
/* ${NAME}_WEAKER is not defined: with r the parameter ${ratio}, the weaker direction of turning holds the share
   |1 - r| / (1 + r) of mu_eff and M_slide less, which are the means of both directions. */

%% else
/* ${NAME}_WEAKER is not defined: friction has a state for each direction of turning, and mu_eff and M_slide are those of
   the direction that loads the patch. */

%% endif
%% if tunable
/* Parameters. Those of the prior (${prior|join(", ")}) count from the next ${name}_reset on, all others from the next
   sample. */
typedef struct {
    ${real} ${p.field}; /* ${p.about} [${p.unit}]; ${p.range} */ %% for p in parameters
} ${name}_parameters_t;

/* Those that the code was generated with, and that ${name}_init takes. */
extern const volatile ${name}_parameters_t ${name}_defaults;

%% endif
/* Version of the code: generator, observer, type of numbers, and a digest of code and parameters. */
#define ${NAME}_VERSION "${version}"
/* The first two words of every state: what code it belongs to, by the digest above, and its size in bytes. */
#define ${NAME}_STATE_LAYOUT 0x${layout}u
#define ${NAME}_STATE_BYTES ${bytes}u

${types}/* One observer, ${bytes} bytes; its fields are private. */
typedef struct {
    uint32_t layout, size;
    ${real} output[${output|length}];
    ${real} evidence[${evidence_start|length}]; %% if checked
    ${real} psi, age, rate, offset, other, other_age, waiting, jump;
    int32_t has_psi, now;
    ${real} constants[${constants_size}]; /* made of the parameters */ %% if tunable
${private_fields}
} ${name}_state_t;

/* Initialises an observer; to be called before any other function. */
void ${name}_init(${name}_state_t *state);

/* Advances the observer by one sample and returns the sample's status. The patch is at rest at the angle of
   the first sample with a known psi and a load of at least 0.001 N; until then the estimate is the prior. A sample
   that is NULL or whose dt is out of range is ignored, with status ${NAME}_REFUSED. The same status means that no finite estimate
   resulted, or that the state is none of this code: not initialised, or of another version. */
int32_t ${name}_step(${name}_state_t *state, const ${name}_sample_t *sample);

/* Writes the estimate after the last sample; nothing where an argument is NULL. Of a state that is none of this code all
   numbers are NAN, and the status is ${NAME}_REFUSED. */
void ${name}_estimate(const ${name}_state_t *state, ${name}_estimate_t *estimate);

%% if tunable
/* Forgets the patch and what was learnt, as when the car has driven since. The parameters stay those that were set last;
   ${name}_init takes ${name}_defaults. */
%% else
/* Returns to the state after ${name}_init, as when the car has driven since. */
%% endif
void ${name}_reset(${name}_state_t *state);

%% if tunable
/* 0 where all parameters are in range, else the place of the first that is not, counted from 1 in the order above; that
   of mu also where it does not lie between least and greatest. */
int32_t ${name}_check_parameters(const ${name}_parameters_t *parameters);

/* Gives an observer other parameters, at any time; it goes on from its state. Returns as ${name}_check_parameters does:
   where that is not 0 the observer keeps those that it has. */
int32_t ${name}_set_parameters(${name}_state_t *state, const volatile ${name}_parameters_t *parameters);

%% endif
/* Goes on from a state that was stored as bytes, ${NAME}_STATE_BYTES of them. Returns 0; 1 where they are those of another
   code, of other parameters, or of another size: the observer then stays as it is. */
int32_t ${name}_restore(${name}_state_t *state, const void *stored, uint32_t size);

/* ${NAME}_VERSION, of the code that runs. */
const char *${name}_version(void);

#ifdef __cplusplus
}
#endif

#endif
