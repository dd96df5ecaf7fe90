/* Rates by fused operations, which round otherwise in the last bits; whether this processor has them. */
#ifndef FUSED_H
#define FUSED_H

#include "model.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(NOT_FUSED)
#define HAS_FUSED
void fused_rates(const double *x, const double *u, const double *p, const double *mode, double *dx, double *imbalance,
                 double *friction);

static inline int fused_here(void) { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }
#endif

#endif
