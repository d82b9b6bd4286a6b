/* SPDX-License-Identifier: GPL-3.0-or-later
 * Row fills, scalar and AVX2, chosen at run time. */
#include "raycast/row_fill.h"

#if defined(__x86_64__) && defined(__GNUC__)
#define ENF_FILL_AVX2 1
#include <immintrin.h>
#endif

static void fill_scalar(float *depth, uint32_t count, float base, float slope) {
    for (uint32_t i = 0; i < count; i++)
        depth[i] = 1.0f / (base + slope * (float)(int32_t)i);
}

#ifdef ENF_FILL_AVX2
__attribute__((target("avx2"))) static void fill_avx2(float *depth, uint32_t count, float base, float slope) {
    const __m256 b = _mm256_set1_ps(base), s = _mm256_set1_ps(slope), one = _mm256_set1_ps(1.0f);
    __m256i index = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    uint32_t i = 0;
    for (; i + 8 <= count; i += 8) {
        __m256 v = _mm256_add_ps(b, _mm256_mul_ps(s, _mm256_cvtepi32_ps(index)));
        _mm256_storeu_ps(depth + i, _mm256_div_ps(one, v));
        index = _mm256_add_epi32(index, _mm256_set1_epi32(8));
    }
    for (; i < count; i++)
        depth[i] = 1.0f / (base + slope * (float)(int32_t)i);
}
#endif

EnfFillDepth enf_fill_depth(int use_simd) {
#ifdef ENF_FILL_AVX2
    if (use_simd && __builtin_cpu_supports("avx2"))
        return fill_avx2;
#endif
    (void)use_simd;
    return fill_scalar;
}
