/* The sensors of a car as the sample of its mean front wheel, which is ${held}.
   ${generated} */
#ifndef ${NAME}_VEHICLE_H
#define ${NAME}_VEHICLE_H

#include "${name}.h"

#include <math.h>

${functions}
/* Speed up to which the car stands [m/s]. Beyond it take no step; ${name}_reset before the first sample of the next
   standstill, and after the brakes were applied or released. */
#define ${NAME}_STANDSTILL ((${real})${standstill})

/* The sample from the way of the rack [m], positive to the left, the force of the gear on it [N], its speed [m/s]
   and acceleration [m/s^2], dt after the last one [s]. */
static inline ${name}_sample_t ${name}_from_rack(${real} rack, ${real} force, ${real} speed, ${real} acceleration, ${real} dt) {
    ${name}_sample_t sample = {0};
    wheel_of_rack(rack, force, speed, acceleration, &sample.psi, &sample.M_z);
    sample.psi_dot = (${real})NAN;
    sample.F_N = ${load};
    sample.dt = dt;
    return sample;
}

/* The same from the handwheel's angle [rad], the torque of its torsion bar and of the motor [N m], 0 without one. */
static inline ${name}_sample_t ${name}_from_handwheel(${real} handwheel, ${real} T_bar, ${real} T_motor, ${real} speed, ${real} acceleration, ${real} dt) {
    ${real} rack, force;
    rack_of_handwheel(handwheel, T_bar, T_motor, &rack, &force);
    return ${name}_from_rack(rack, force, speed, acceleration, dt);
}

#endif
