/* The torque of the patch: M_z [N m], its derivatives by mu, by k over its nominal value and, where that is a state, by
   the angle. */
enum { M_Z, BY_MU, BY_STIFFNESS, BY_ANGLE, TORQUES };

