/* What the effects make of a sample: angle, load, speed of a lever arm of one half-length, load times the factor
   on friction, growth of the patch, slip of a sample at 1 m/s, the Maxwell branches' decay and gain, torque beside
   the patch and its derivative by the angle, effective friction over mu and beside it. */
enum {
    TERM_${name|upper}, %% for name in terms
    TERMS
};
