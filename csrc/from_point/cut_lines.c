/* SPDX-License-Identifier: GPL-3.0-or-later
 * Polygons against the lines of an aperture: scalar, and AVX2 behind a runtime check. Most polygons are cut by no line, or by
 * one: what isn't cut is neither copied nor measured again. */
#include "from_point/cut_lines.h"

#include "base/simd.h"

static uint32_t cut_scalar(const double *x, const double *y, uint32_t count, const EnfCorner *lines, uint32_t line_count) {
    uint32_t cut = 0;
    for (uint32_t k = 0; k < line_count; k++) {
        uint32_t outside = 0;
        /* The order of operations is the vector twin's: equal bits. */
        for (uint32_t i = 0; i < count; i++)
            outside += lines[k].a * x[i] + lines[k].b * y[i] + lines[k].c < 0;
        cut |= (uint32_t)(outside > 0) << k;
        if (outside == count)
            return cut | ENF_CUT_AWAY;
    }
    return cut;
}

static uint32_t cut_deep_scalar(const double *x, const double *y, const double *z, uint32_t count, const EnfCorner *lines,
                                const EnfDeepLine *deep, uint32_t line_count) {
    uint32_t cut = 0;
    for (uint32_t k = 0; k < line_count; k++) {
        uint32_t outside = 0;
        for (uint32_t i = 0; i < count; i++)
            outside += (lines[k].a * x[i] + lines[k].b * y[i]) + (deep[k].c - deep[k].drift * z[i]) < 0;
        cut |= (uint32_t)(outside > 0) << k;
        if (outside == count)
            return cut | ENF_CUT_AWAY;
    }
    return cut;
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2"))) static uint32_t cut_avx2(const double *x, const double *y, uint32_t count, const EnfCorner *lines,
                                                         uint32_t line_count) {
    const __m256d zero = _mm256_setzero_pd();
    const uint32_t last = (count - 1) & ~3u, lanes = (1u << (count - last)) - 1;
    uint32_t cut = 0;
    for (uint32_t k = 0; k < line_count; k++) {
        const __m256d a = _mm256_set1_pd(lines[k].a), b = _mm256_set1_pd(lines[k].b), c = _mm256_set1_pd(lines[k].c);
        uint32_t some = 0, all = 15;
        for (uint32_t i = 0; i < last; i += 4) {
            __m256d d = _mm256_add_pd(_mm256_mul_pd(a, _mm256_loadu_pd(x + i)), _mm256_mul_pd(b, _mm256_loadu_pd(y + i)));
            uint32_t outside = (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(_mm256_add_pd(d, c), zero, _CMP_LT_OQ));
            some |= outside;
            all &= outside;
        }
        __m256d d = _mm256_add_pd(_mm256_mul_pd(a, _mm256_loadu_pd(x + last)), _mm256_mul_pd(b, _mm256_loadu_pd(y + last)));
        uint32_t outside = (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(_mm256_add_pd(d, c), zero, _CMP_LT_OQ)) & lanes;
        cut |= (uint32_t)((some | outside) != 0) << k;
        if (all == 15 && outside == lanes)
            return cut | ENF_CUT_AWAY;
    }
    return cut;
}

__attribute__((target("avx2"))) static uint32_t cut_deep_avx2(const double *x, const double *y, const double *z, uint32_t count,
                                                              const EnfCorner *lines, const EnfDeepLine *deep, uint32_t line_count) {
    uint32_t cut = 0;
    for (uint32_t k = 0; k < line_count; k++) {
        const __m256d a = _mm256_set1_pd(lines[k].a), b = _mm256_set1_pd(lines[k].b);
        const __m256d c = _mm256_set1_pd(deep[k].c), drift = _mm256_set1_pd(deep[k].drift);
        uint32_t some = 0, outside_all = 1;
        for (uint32_t i = 0; i < count; i += 4) {
            const uint32_t lanes = count - i >= 4 ? 15u : (1u << (count - i)) - 1;
            __m256d d = _mm256_add_pd(_mm256_mul_pd(a, _mm256_loadu_pd(x + i)), _mm256_mul_pd(b, _mm256_loadu_pd(y + i)));
            d = _mm256_add_pd(d, _mm256_sub_pd(c, _mm256_mul_pd(drift, _mm256_loadu_pd(z + i))));
            const uint32_t outside = (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(d, _mm256_setzero_pd(), _CMP_LT_OQ)) & lanes;
            some |= outside;
            outside_all &= outside == lanes;
        }
        cut |= (uint32_t)(some != 0) << k;
        if (outside_all)
            return cut | ENF_CUT_AWAY;
    }
    return cut;
}
#endif

EnfCutDeep enf_cut_deep(int use_simd) {
#ifdef ENF_HAVE_AVX2
    if (use_simd && enf_processor_avx2())
        return cut_deep_avx2;
#endif
    (void)use_simd;
    return cut_deep_scalar;
}

EnfCutLines enf_cut_lines(int use_simd) {
#ifdef ENF_HAVE_AVX2
    if (use_simd && enf_processor_avx2())
        return cut_avx2;
#endif
    (void)use_simd;
    return cut_scalar;
}
