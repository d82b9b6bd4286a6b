/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which wide instructions the compiler knows and the processor has, for code that is chosen at run time. */
#ifndef ENF_BASE_SIMD_H
#define ENF_BASE_SIMD_H

#if defined(__x86_64__) && defined(__GNUC__)
#define ENF_HAVE_AVX2 1
#include <immintrin.h>
#endif

/* Functions of target avx2, and files compiled with -mavx2 -mbmi. */
static inline int enf_processor_avx2(void) {
#ifdef ENF_HAVE_AVX2
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi");
#else
    return 0;
#endif
}

/* Files compiled with -mavx512f -mavx512vl -mavx512dq -mavx512bw -mbmi. */
static inline int enf_processor_avx512(void) {
#ifdef ENF_HAVE_AVX2
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("bmi");
#else
    return 0;
#endif
}

/* A mask as a number. gcc (12 at least) makes one instruction of a comparison and the zero extension of its mask, which sets the low byte
 * or two of the number only and trusts the mask register to clear the rest: where it runs out of registers the number lies on the stack,
 * with bits left there by others above (sse.md, *avx512vl_cmpv8si3_zero_extendsi). The empty line keeps the two apart. */
#if defined(__GNUC__) && !defined(__clang__)
#define ENF_MASK_APART(mask) __asm__("" : "+k"(mask))
#else
#define ENF_MASK_APART(mask) (void)0
#endif

#endif
