/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernel in AVX2: four edges, or a box against eight planes, at a time. */
#include "from_region/separators.h"

#if defined(__AVX2__)
#include <immintrin.h>

#define INLINE  static inline __attribute__((always_inline))
#define LANES   4
#define SINGLES 8

typedef __m256d vd, vm;
typedef __m256 vf;

INLINE vd vd_load(const double *from) {
    return _mm256_loadu_pd(from);
}
/* Not one load: it would wait for the two stores it straddles. */
INLINE vd vd_after(const double *from) {
    vd low = vd_load(from), high = vd_load(from + 4);
    return _mm256_shuffle_pd(low, _mm256_permute2f128_pd(low, high, 0x21), 5);
}
INLINE void vd_store(double *to, vd v) {
    _mm256_storeu_pd(to, v);
}
INLINE vd vd_all(double v) {
    return _mm256_set1_pd(v);
}
INLINE vd vd_sqrt(vd v) {
    return _mm256_sqrt_pd(v);
}
INLINE vm vd_below(vd a, vd b) {
    return _mm256_cmp_pd(a, b, _CMP_LT_OQ);
}
INLINE vd vd_choose(vm mask, vd yes, vd no) {
    return _mm256_blendv_pd(no, yes, mask);
}
INLINE vd vd_least(vd a, vd b) {
    return _mm256_min_pd(a, b);
}
INLINE vd vd_most(vd a, vd b) {
    return _mm256_max_pd(a, b);
}
INLINE void vd_single(float *to, vd v) {
    _mm_storeu_ps(to, _mm256_cvtpd_ps(v));
}
INLINE vm vm_and(vm a, vm b) {
    return _mm256_and_pd(a, b);
}
INLINE uint32_t vm_bits(vm mask) {
    return (uint32_t)_mm256_movemask_pd(mask);
}
INLINE vf vf_load(const float *from) {
    return _mm256_loadu_ps(from);
}
INLINE void vf_store(float *to, vf v) {
    _mm256_storeu_ps(to, v);
}
INLINE vf vf_all(float v) {
    return _mm256_set1_ps(v);
}
INLINE vf vf_size(vf v) {
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), v);
}
INLINE uint32_t vf_below(vf a, vf b) {
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ));
}

typedef vf v8;
#define v8_load  vf_load
#define v8_store vf_store
#define v8_all   vf_all
#define v8_size  vf_size
#define v8_below vf_below
INLINE v8 v8_pick(v8 a, v8 b, v8 yes, v8 no) {
    return _mm256_blendv_ps(no, yes, _mm256_cmp_ps(a, b, _CMP_LT_OQ));
}

#include "from_region/separators_body.h"

static const EnfSeparatorKernel kernel = SEPARATOR_KERNEL;
const EnfSeparatorKernel *const enf_separators_avx2 = &kernel;
#else
const EnfSeparatorKernel *const enf_separators_avx2 = NULL; /* this compiler or processor has none */
#endif
