/* fmin and fmax with NaN as those of math.h have it, which are calls on some targets. */ %% if "lesser" in used or "greater" in used
static inline ${real} lesser(${real} x, ${real} y) { return x < y || y != y ? x : y; } %% if "lesser" in used
static inline ${real} greater(${real} x, ${real} y) { return x > y || y != y ? x : y; } %% if "greater" in used

%% if single and ("natural_log" in used or "any_log" in used)
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
%% endif
static inline ${real} natural_log(${real} x) { return log(x); } %% if not single and "natural_log" in used
%% if single and "any_log" in used
/* ln of any number; what is 0, negative, huge or NAN is left to math.h. */
static inline float any_log(float x) {
    uint32_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits - 0x00800000u < 0x7F000000u ? natural_log(x) : log(x);
}
%% endif
static inline double any_log(double x) { return log(x); } %% if not single and "any_log" in used
%% if single and "any_exp" in used
/* e^x to 1e-7: a power of two by its bits, and a polynomial; 0 below 1e-38; what is huge or NAN is left
   to math.h.
   Source: Moshier, Cephes mathematical library, expf. */
static inline float any_exp(float x) {
    float power, rest, shift;
    uint32_t bits;
    if (!(fabs(x) < 87.0)) {
        return x < 0.0 ? 0.0 : exp(x);
    }
    shift = x * 1.44269504 + 127.5;
    bits = (uint32_t)shift;
    shift = (float)bits - 127.0;
    rest = x - shift * 0.693359375 + shift * 2.12194440e-4;
    bits <<= 23;
    (void)memcpy(&power, &bits, sizeof power);
    return power * (1.0 + rest + rest * rest * (0.5 + rest * (1.66666655e-1 + rest * (4.16657959e-2 + rest * (8.33345191e-3 + rest * (1.39819999e-3 + rest * 1.98756915e-4))))));
}
%% endif
static inline double any_exp(double x) { return exp(x); } %% if not single and "any_exp" in used
%% if creep

/* Wright's function between two knots: a cubic through values and slopes. The last ${omega_far} are ${omega_sparse} times as far apart. */
static const ${real} omega_of[${omega|length}][4] = {
    {${knot}}, %% for knot in omega
};

static inline ${real} omega_between(${real} place) {
    const int32_t i = place > 0.0 ? (int32_t)place : 0;
    const ${real} t = place > 0.0 ? place - (${real})i : 0.0, *of = omega_of[i];
    return of[0] + t * (of[1] + t * (of[2] + t * of[3]));
}

%% if single
/* The root w of w + ln w = x, by the place of x among the knots; right to 1e-5 of w. */
%% else
/* The root w of w + ln w = x, by the place of x among the knots: right to 1e-5, and a step of fourth order.
   Source: Fritsch, Shafer, Crowley, Algorithm 443, Comm. ACM 16 (1973) 123. */
%% endif
static inline ${real} wright_omega(${real} place) {
    /* Bounded as it is used: rounding may lift the last place beyond the table. */
    const ${real} sparse = ${omega_near}.0 + (place - ${omega_near}.0) * ${1 / omega_sparse};
    ${real} w;
    const double x = place / ${omega_knots_per_unit} + ${omega_from}; %% if not single
    if (place < ${omega_near}.0) {
        w = omega_between(place);
    } else if (sparse < ${omega_near + omega_far}.0) {
        w = omega_between(sparse);
    } else {
        const float x = place / ${omega_knots_per_unit} + ${omega_from}; %% if single
        const ${real} log_x = natural_log(x), share = log_x / x;
        w = x - log_x + share * (1.0 + 0.5 * (log_x - 2.0) / x);
    }
%% if not single
    if (place > 0.0) {
        const double residual = x - w - log(w);
        const double a = 2.0 * (1.0 + w) * (1.0 + w + 0.66666666666666667 * residual);
        w *= 1.0 + residual / (1.0 + w) * (a - residual) / (a - 2.0 * residual);
    } else {
        /* As e^x, less its square. */
        w = exp(x);
        w *= 1.0 - w * (1.0 - 1.5 * w);
    }
%% endif
    return w;
}
%% endif
