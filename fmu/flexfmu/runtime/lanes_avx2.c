/* The vector of runs for processors with AVX2. */
#include "model.h"

#if defined(MODEL_AVX2) && defined(__x86_64__) && defined(__GNUC__)
enum { LANES = 4 };
#define LANES_NAME avx2_
#define LANES_ADVANCE batch_advance_avx2
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
#include "lanes_loop.h"
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#else
typedef int lanes_avx2_are_left_out;
#endif
