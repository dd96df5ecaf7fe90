/* `real` is one number. The vector of runs is in lanes.h. */
#ifndef SCALAR_H
#define SCALAR_H

#include <math.h>

typedef double real;
#define REAL(x) (x)
#define NAME(f) model_##f
#define PIECE(f) f
#define R_EXP exp
#define R_LOG log
#define R_POW pow
#define R_CONSTPOW pow
#define R_SQRT sqrt
#define R_SIN sin
#define R_COS cos
#define R_TAN tan
#define R_ASIN asin
#define R_ACOS acos
#define R_ATAN atan
#define R_SINH sinh
#define R_COSH cosh
#define R_TANH tanh
#define R_ATAN2 atan2
#define R_FABS fabs
#define R_FMIN fmin
#define R_FMAX fmax
#define R_FLOOR floor
#define R_CEIL ceil
#define R_FMOD fmod
#define R_COPYSIGN copysign
#define R_EXPM1 expm1
#define R_LOG1P log1p
#define R_HYPOT hypot
#define R_ERF erf
#define R_SIGN(a) ((a) > 0 ? 1.0 : (a) < 0 ? -1.0 : (a))
#define R_LT(a, b) ((a) < (b) ? 1.0 : 0.0)
#define R_LE(a, b) ((a) <= (b) ? 1.0 : 0.0)
#define R_EQ(a, b) ((a) == (b) ? 1.0 : 0.0)
#define R_NE(a, b) ((a) != (b) ? 1.0 : 0.0)
#define R_NOT(a) ((a) != 0 ? 0.0 : 1.0)
#define R_AND(a, b) ((a) != 0 && (b) != 0 ? 1.0 : 0.0)
#define R_OR(a, b) ((a) != 0 || (b) != 0 ? 1.0 : 0.0)
#define R_IF_ELSE_ZERO(a, b) ((a) != 0 ? (b) : 0.0)

#endif
