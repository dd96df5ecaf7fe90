/* The vector of runs for processors with AVX2. */
#include "model.h"
#include "target.h"

#if defined(MODEL_AVX2) && defined(__x86_64__) && defined(__GNUC__)
enum { LANES = 4 };
#define LANES_NAME avx2_
#define LANES_ADVANCE batch_advance_avx2
TARGET_BEGIN("avx2,fma")
#include "lanes_loop.h"
TARGET_END
#else
typedef int lanes_avx2_are_left_out;
#endif
