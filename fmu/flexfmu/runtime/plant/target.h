/* Between TARGET_BEGIN and TARGET_END functions are compiled for processors with these further instructions. */
#ifndef TARGET_H
#define TARGET_H

#define TARGET_PRAGMA(words) _Pragma(#words)
#ifdef __clang__
#define TARGET_BEGIN(set) TARGET_PRAGMA(clang attribute push(__attribute__((target(set))), apply_to = function))
#define TARGET_END TARGET_PRAGMA(clang attribute pop)
#else
#define TARGET_BEGIN(set) TARGET_PRAGMA(GCC push_options) TARGET_PRAGMA(GCC target(set))
#define TARGET_END TARGET_PRAGMA(GCC pop_options)
#endif

#endif
