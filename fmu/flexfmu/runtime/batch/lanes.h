/* `real` is a vector: one number of each of LANES runs that advance together. GCC and Clang only. */
#ifndef LANES_H
#define LANES_H

#include <math.h>

typedef double real __attribute__((vector_size(8 * LANES)));
typedef long long lane_mask __attribute__((vector_size(8 * LANES)));

#define LANE_FUNCTION static inline __attribute__((always_inline, unused))
LANE_FUNCTION real lanes_of(double x) { return x - (real){0}; }
LANE_FUNCTION real lanes_where(lane_mask m, real a, real b) {
    return (real)((m & (lane_mask)a) | (~m & (lane_mask)b));
}
LANE_FUNCTION real lanes_flag(lane_mask m) { return (real)(m & (lane_mask)lanes_of(1.0)); }

#define REAL(x) lanes_of(x)
#define R_FABS(a) ((real)((lane_mask)(a) & ~(lane_mask)lanes_of(-0.0)))
#define R_FMIN(a, b) lanes_where((a) < (b), a, b)
#define R_FMAX(a, b) lanes_where((a) > (b), a, b)
#define R_LT(a, b) lanes_flag((a) < (b))
#define R_LE(a, b) lanes_flag((a) <= (b))
#define R_EQ(a, b) lanes_flag((a) == (b))
#define R_NE(a, b) lanes_flag((a) != (b))
#define R_NOT(a) lanes_flag((a) == lanes_of(0.0))
#define R_AND(a, b) lanes_flag(((a) != lanes_of(0.0)) & ((b) != lanes_of(0.0)))
#define R_OR(a, b) lanes_flag(((a) != lanes_of(0.0)) | ((b) != lanes_of(0.0)))
#define R_IF_ELSE_ZERO(a, b) lanes_where((a) != lanes_of(0.0), b, lanes_of(0.0))
#define R_SIGN(a) (lanes_flag((a) > lanes_of(0.0)) - lanes_flag((a) < lanes_of(0.0)))

/* Sine and cosine after fdlibm (Sun Microsystems 1993): reduced by parts of pi/2, then two polynomials.
   To rounding for |x| < 1e5. `turn` is 0 for the sine, 1 for the cosine. */
LANE_FUNCTION real lanes_wave(real x, long long turn) {
    const real shift = lanes_of(6755399441055744.0);
    real t = x * lanes_of(0.63661977236758134308) + shift, n = t - shift;
    real r = ((x - n * lanes_of(1.57079632673412561417)) - n * lanes_of(6.07710050630396597660e-11)) -
             n * lanes_of(2.02226624871116645580e-21);
    real z = r * r, w = z * z;
    real s = r + r * z * (lanes_of(-1.66666666666666324348e-01) + z * (lanes_of(8.33333333332248946124e-03) +
             z * (lanes_of(-1.98412698298579493134e-04) + z * (lanes_of(2.75573137070700676789e-06) +
             z * (lanes_of(-2.50507602534068634195e-08) + z * lanes_of(1.58969099521155010221e-10))))));
    real c = lanes_of(1.0) - lanes_of(0.5) * z + w * (lanes_of(4.16666666666666019037e-02) +
             z * (lanes_of(-1.38888888888741095749e-03) + z * (lanes_of(2.48015872894767294178e-05) +
             z * (lanes_of(-2.75573143513906633035e-07) + z * (lanes_of(2.08757232129817482790e-09) +
             z * lanes_of(-1.13596475577881948265e-11))))));
    lane_mask quarter = (lane_mask)t + turn;
    real value = lanes_where((quarter & 1) != 0, c, s);
    return (real)((lane_mask)value ^ ((quarter & 2) << 62));
}
#define R_SIN(a) lanes_wave(a, 0)
#define R_COS(a) lanes_wave(a, 1)

#define LANES_BY_ONE(name, f)                                 \
    LANE_FUNCTION real name(real a) {                         \
        int i;                                                \
        for (i = 0; i < LANES; ++i) a[i] = f(a[i]);           \
        return a;                                             \
    }
#define LANES_BY_TWO(name, f)                                 \
    LANE_FUNCTION real name(real a, real b) {                 \
        int i;                                                \
        for (i = 0; i < LANES; ++i) a[i] = f(a[i], b[i]);     \
        return a;                                             \
    }
LANES_BY_ONE(R_SQRT, sqrt)
LANES_BY_ONE(R_EXP, exp)
LANES_BY_ONE(R_LOG, log)
LANES_BY_ONE(R_TAN, tan)
LANES_BY_ONE(R_ASIN, asin)
LANES_BY_ONE(R_ACOS, acos)
LANES_BY_ONE(R_ATAN, atan)
LANES_BY_ONE(R_SINH, sinh)
LANES_BY_ONE(R_COSH, cosh)
LANES_BY_ONE(R_TANH, tanh)
LANES_BY_ONE(R_FLOOR, floor)
LANES_BY_ONE(R_CEIL, ceil)
LANES_BY_ONE(R_EXPM1, expm1)
LANES_BY_ONE(R_LOG1P, log1p)
LANES_BY_ONE(R_ERF, erf)
LANES_BY_TWO(R_POW, pow)
LANES_BY_TWO(R_CONSTPOW, pow)
LANES_BY_TWO(R_ATAN2, atan2)
LANES_BY_TWO(R_FMOD, fmod)
LANES_BY_TWO(R_COPYSIGN, copysign)
LANES_BY_TWO(R_HYPOT, hypot)

#endif
