/* Friction between tyre and road from the steering torque of a wheel that stands still.

   $described

   $generated C99, no heap, no recursion,
   no input or output, no data that is written to but the caller's: any number of observers may run at
   once, also in different threads, each with a state of its own.

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

/* One sample of the sensors; NAN where a sensor gave none. What is infinite, or beyond 1e9, counts as none. */
typedef struct {
    $real psi;     /* yaw (steering) angle [rad] */
    $real psi_dot; /* $rate_said */
    $real $torque;     /* $torque_said */
    $real F_N;     /* vertical load [N]; the last one holds where there is none greater than 0 */
    $real dt;      /* time since the last sample, greater than 0 and at most 3600 [s] */
} ${name}_sample_t;

/* What became of a sample; several may hold at once. */
enum {
    ${NAME}_USED = 0,
$flags
};

/* What the observer says after a sample. */
typedef struct {
    $real mu;            /* friction coefficient [1] */
    $real mu_std;        /* its standard deviation [1] */
    $real M_z_predicted; /* aligning torque of the model [N m], before its measurement was seen; NAN at first */
    int32_t informed;    /* 0 while the estimate rests on what was believed beforehand, else 1 */
    int32_t status;      /* flags as above */
} ${name}_estimate_t;

$types/* One observer, $bytes bytes; all of it is the observer's own. */
typedef struct {
    $real said[4];
    $real psi, age, rate;
    int32_t seen, now;
$private
} ${name}_state_t;

/* Makes an observer that has seen nothing. To be called before anything else. */
void ${name}_init(${name}_state_t *state);

/* Takes one more sample; returns its status. The first with a known psi and a load greater than 0 says
   where the patch stands at rest; before it the estimate is what was believed beforehand. A sample with
   a dt out of range is left out, ${NAME}_REFUSED. Should numbers ever fail, so that no finite estimate is
   left, that is flagged the same way. */
int32_t ${name}_step(${name}_state_t *state, const ${name}_sample_t *sample);

/* What the observer says after its last sample. */
void ${name}_estimate(const ${name}_state_t *state, ${name}_estimate_t *estimate);

/* Forgets all samples, as when the car has driven since: the next usable one starts anew. */
void ${name}_reset(${name}_state_t *state);

/* Which code this is: generator, observer, type of numbers, and a digest of code and parameters. */
const char *${name}_version(void);

#ifdef __cplusplus
}
#endif

#endif
