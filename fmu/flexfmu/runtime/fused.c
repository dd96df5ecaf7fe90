/* The rates of one run for processors that multiply and add in one operation: some 1.5 times as fast. */
#include "fused.h"

#ifdef HAS_FUSED
#include "scalar.h"

#undef NAME
#undef PIECE
#define NAME(f) fused_##f
#define PIECE(f) fused_piece_##f
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
#include "model_rates.h"
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#else
typedef int fused_is_left_out;
#endif
