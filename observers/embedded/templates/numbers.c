/* fmin and fmax with NaN as those of math.h have it, which are calls on some targets. */
static inline ${real} lesser(${real} x, ${real} y) { return x < y || y != y ? x : y; }
static inline ${real} greater(${real} x, ${real} y) { return x > y || y != y ? x : y; }

%% if single
/* ln x to 1e-7 for x > 0 that is no subnormal: exponent and mantissa by their bits, and the series of artanh. */
static inline float natural_log(float x) {
    int32_t bits, exponent;
    float t, square;
    memcpy(&bits, &x, sizeof bits);
    exponent = (bits - 0x3F3504F3) >> 23; /* the mantissa in 1/sqrt(2) ... sqrt(2) */
    bits -= exponent * 0x800000;
    memcpy(&x, &bits, sizeof x);
    t = (x - 1.0) / (x + 1.0);
    square = t * t;
    return (float)exponent * 0.693147181 + 2.0 * t * (1.0 + square * (0.333333333 + square * (0.2 + square * (0.142857143 + square * 0.111111111))));
}
%% else
static inline double natural_log(double x) { return log(x); }
%% endif
%% if creep

/* The root of w + ln w = x: a guess to a tenth from the bits of a float, and ${"one step" if single else "two steps"} of fourth order.
   Source: Fritsch, Shafer, Crowley, Algorithm 443, Comm. ACM 16 (1973) 123. */
static inline ${real} wright_omega(${real} x) {
    const float rough = x > -80.0 ? (x < 80.0 ? (float)x : 80.0f) : -80.0f;
    int32_t bits;
    float guess;
    ${real} w;
%% if not single
    int i;
%% endif
    if (x < 1.0) {
        bits = (int32_t)(12102203.2f * rough + 1064866805.0f); /* e^x */
        memcpy(&guess, &bits, sizeof guess);
        w = (${real})guess;
        w = w * (1.0 + 1.33333333 * w) / (1.0 + w * (2.33333333 + 0.833333333 * w));
    } else {
        const float size = (float)x;
        memcpy(&bits, &size, sizeof bits);
        guess = (float)(bits - 1064866805) * 8.26295829e-8f; /* ln x */
        w = x - (${real})guess * (1.0 - 1.0 / x);
    }
%% if not single
    for (i = 0; i < 2; ++i)
%% endif
    {
        const ${real} residual = x - w - natural_log(w);
        const ${real} a = 2.0 * (1.0 + w) * (1.0 + w + 0.66666666666666667 * residual);
        w *= 1.0 + residual / (1.0 + w) * (a - residual) / (a - 2.0 * residual);
    }
    return w;
}
%% endif
