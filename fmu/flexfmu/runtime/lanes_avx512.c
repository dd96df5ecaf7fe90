/* The vector of runs for processors with AVX512. */
#include "model.h"

#if defined(MODEL_AVX512) && defined(__x86_64__) && defined(__GNUC__)
enum { LANES = 8 };
#define LANES_NAME avx512_
#define LANES_ADVANCE batch_advance_avx512
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,fma")
#endif
#include "lanes_loop.h"
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#else
typedef int lanes_avx512_are_left_out;
#endif
