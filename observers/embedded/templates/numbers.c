%% if "lesser" in used or "greater" in used
/* fmin and fmax with NaN as those of math.h have it, which are calls on some targets. */
%% endif
%% if "lesser" in used
static inline ${real} lesser(${real} x, ${real} y) { return x < y || y != y ? x : y; }
%% endif
%% if "greater" in used
static inline ${real} greater(${real} x, ${real} y) { return x > y || y != y ? x : y; }
%% endif

%% if "natural_log" in used
%% if single
/* ln x to 1e-7 for x > 0 that is no subnormal: exponent and mantissa by their bits, and the series of artanh. */
static inline float natural_log(float x) {
    uint32_t bits;
    int32_t exponent;
    float t, square;
    (void)memcpy(&bits, &x, sizeof bits);
    /* The mantissa in 1/sqrt(2) ... sqrt(2), whose least number has the bits 0x3F3504F3; those of 1 are 0x3F800000. */
    exponent = (int32_t)((bits - 0x3F3504F3u + 0x3F800000u) >> 23) - 127;
    bits -= (uint32_t)exponent << 23;
    (void)memcpy(&x, &bits, sizeof x);
    t = (x - 1.0) / (x + 1.0);
    square = t * t;
    return (float)exponent * 0.693147181 + 2.0 * t * (1.0 + square * (0.333333333 + square * (0.2 + square * (0.142857143 + square * 0.111111111))));
}
%% else
static inline ${real} natural_log(${real} x) { return log(x); }
%% endif
%% endif
%% if creep

%% if single
/* Wright's function: value, and slope times spacing. */
static const float omega_of[${omega|length}][2] = {
%% for knot in omega
    {${knot}},
%% endfor
};

/* The root w of w + ln w = x between two knots, a cubic through values and slopes; right to 1e-5 of w. */
static inline float wright_omega(float x) {
    const float place = (greater(x, ${omega_from}) - ${omega_from}) * ${omega_knots_per_unit};
    if (place < ${omega_intervals}.0) {
        const int32_t i = (int32_t)place;
        const float t = place - (float)i, *at = omega_of[i], *next = omega_of[i + 1];
        const float rise = next[0] - at[0], bend = at[1] + next[1] - 2.0 * rise;
        return at[0] + t * (at[1] + t * (rise - at[1] - bend + t * bend));
    }
    {
        const float log_x = natural_log(x), share = log_x / x;
        return x - log_x + share * (1.0 + 0.5 * (log_x - 2.0) / x);
    }
}
%% else
/* The root w of w + ln w = x: a guess, and three steps of fourth order.
   Source: Fritsch, Shafer, Crowley, Algorithm 443, Comm. ACM 16 (1973) 123. */
static double wright_omega(double x) {
    double w = x < 1.0 ? exp(x) / (1.0 + exp(x)) : x - log(x) * (1.0 - 1.0 / x);
    int i;
    for (i = 0; i < 3; ++i) {
        const double residual = x - w - log(w);
        const double a = 2.0 * (1.0 + w) * (1.0 + w + 0.66666666666666667 * residual);
        w *= 1.0 + residual / (1.0 + w) * (a - residual) / (a - 2.0 * residual);
    }
    return w;
}
%% endif
%% endif
