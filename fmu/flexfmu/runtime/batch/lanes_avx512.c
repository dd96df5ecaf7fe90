/* The vector of runs for processors with AVX512. */
#include "model.h"
#include "target.h"

#if defined(MODEL_AVX512) && defined(__x86_64__) && defined(__GNUC__)
enum { LANES = 8 };
#define LANES_NAME avx512_
#define LANES_ADVANCE batch_advance_avx512
TARGET_BEGIN("avx512f,avx512dq,fma")
#include "lanes_loop.h"
TARGET_END
#else
typedef int lanes_avx512_are_left_out;
#endif
