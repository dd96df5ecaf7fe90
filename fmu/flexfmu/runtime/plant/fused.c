/* The rates of one run for processors that multiply and add in one operation: some 1.5 times as fast. */
#include "fused.h"

#ifdef HAS_FUSED
#include "scalar.h"
#include "target.h"

#undef NAME
#undef PIECE
#define NAME(f) fused_##f
#define PIECE(f) fused_piece_##f
TARGET_BEGIN("avx2,fma")
#include "model_rates.h"
TARGET_END
#else
typedef int fused_is_left_out;
#endif
