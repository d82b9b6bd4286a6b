/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernel in AVX-512: eight edges, or a box against sixteen planes, at a time. */
#include "from_region/separators.h"

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__) && defined(__AVX512BW__)
#include "base/simd.h"

#define INLINE  static inline __attribute__((always_inline))
#define LANES   8
#define SINGLES 16

typedef __m512d vd;
typedef __mmask8 vm;
typedef __m512 vf;

INLINE vd vd_load(const double *from) {
    return _mm512_loadu_pd(from);
}
/* Not one load: it would wait for the two stores it straddles. */
INLINE vd vd_after(const double *from) {
    return _mm512_castsi512_pd(_mm512_alignr_epi64(_mm512_loadu_si512(from + 8), _mm512_loadu_si512(from), 1));
}
INLINE void vd_store(double *to, vd v) {
    _mm512_storeu_pd(to, v);
}
INLINE vd vd_all(double v) {
    return _mm512_set1_pd(v);
}
INLINE vd vd_sqrt(vd v) {
    return _mm512_sqrt_pd(v);
}
INLINE vm vd_below(vd a, vd b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ);
}
INLINE vd vd_choose(vm mask, vd yes, vd no) {
    return _mm512_mask_blend_pd(mask, no, yes);
}
INLINE vd vd_least(vd a, vd b) {
    return _mm512_min_pd(a, b);
}
INLINE vd vd_most(vd a, vd b) {
    return _mm512_max_pd(a, b);
}
INLINE void vd_single(float *to, vd v) {
    _mm256_storeu_ps(to, _mm512_cvtpd_ps(v));
}
INLINE vm vm_and(vm a, vm b) {
    return a & b;
}
INLINE uint32_t vm_bits(vm mask) {
    ENF_MASK_APART(mask);
    return mask;
}
INLINE vf vf_load(const float *from) {
    return _mm512_loadu_ps(from);
}
INLINE void vf_store(float *to, vf v) {
    _mm512_storeu_ps(to, v);
}
INLINE vf vf_all(float v) {
    return _mm512_set1_ps(v);
}
INLINE vf vf_size(vf v) {
    return _mm512_abs_ps(v);
}
INLINE uint32_t vf_below(vf a, vf b) {
    __mmask16 mask = _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
    ENF_MASK_APART(mask);
    return mask;
}

/* The planes of the bits, one after the other, on a window of up to eight corners in registers. Stops, with the rest of the
 * bits, before a cut that gives more. Gives 0 when nothing is left. */
INLINE int clip_in_registers(EnfWindow *window, const double *px, const double *py, const double *pz, const double *pd, uint64_t *which,
                             int *clipped) {
    uint32_t n = window->count, all = (1u << n) - 1, own = window->own, cuts = 0;
    const __m512i lanes = _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7);
    if (n > LANES)
        return 1;
    vd x = vd_load(window->x), y = vd_load(window->y), z = vd_load(window->z);
    for (; *which; *which &= *which - 1) {
        uint32_t k = enf_lowest_bit64(*which);
        vd h = ((vd_all(px[k]) * x + vd_all(py[k]) * y) + vd_all(pz[k]) * z) - vd_all(pd[k]);
        uint32_t below = vm_bits(vd_below(h, vd_all(0))) & all;
        if (!below)
            continue;
        *clipped = 1;
        if (below == all)
            return 0;
        const EnfRun run = enf_window_run(below, n);
        if (run.torn)
            continue;
        if (run.kept + 2 > LANES)
            break;
        /* Corner i of the new window lies between two of the old: the one after the way in is followed by the kept ones. */
        __m512i size = _mm512_set1_epi64(n), from = _mm512_add_epi64(lanes, _mm512_set1_epi64(run.in));
        from = _mm512_mask_sub_epi64(from, _mm512_cmpge_epi64_mask(from, size), from, size);
        vm ways = (vm)(1u | 1u << (run.kept + 1));
        __m512i a = _mm512_mask_set1_epi64(from, (vm)(ways & ~1u), run.out),
                b = _mm512_mask_set1_epi64(from, 1, run.in + 1 < n ? run.in + 1 : 0);
        vd ha = _mm512_permutexvar_pd(a, h), hb = _mm512_permutexvar_pd(b, h), t = ha / (ha - hb);
        vd xa = _mm512_permutexvar_pd(a, x), ya = _mm512_permutexvar_pd(a, y), za = _mm512_permutexvar_pd(a, z);
        vd xb = _mm512_permutexvar_pd(b, x), yb = _mm512_permutexvar_pd(b, y), zb = _mm512_permutexvar_pd(b, z);
        x = vd_choose(ways, xa + t * (xb - xa), xa);
        y = vd_choose(ways, ya + t * (yb - ya), ya);
        z = vd_choose(ways, za + t * (zb - za), za);
        own = enf_run_own(own, n, run);
        n = run.kept + 2, all = (1u << n) - 1, cuts = 1;
    }
    if (cuts) {
        /* Corners n, n + 1, ... are the first again. */
        __m512i low = lanes, high = _mm512_add_epi64(lanes, _mm512_set1_epi64(8)), size = _mm512_set1_epi64(n);
        for (int k = 0; k < 5; ++k) { /* 15 less five triangles */
            low = _mm512_mask_sub_epi64(low, _mm512_cmpge_epi64_mask(low, size), low, size);
            high = _mm512_mask_sub_epi64(high, _mm512_cmpge_epi64_mask(high, size), high, size);
        }
        window->count = n, window->own = own;
        vd_store(window->x, _mm512_permutexvar_pd(low, x)), vd_store(window->x + 8, _mm512_permutexvar_pd(high, x));
        vd_store(window->y, _mm512_permutexvar_pd(low, y)), vd_store(window->y + 8, _mm512_permutexvar_pd(high, y));
        vd_store(window->z, _mm512_permutexvar_pd(low, z)), vd_store(window->z + 8, _mm512_permutexvar_pd(high, z));
    }
    return 1;
}
#define CLIP_IN_REGISTERS

typedef __m256 v8;
INLINE v8 v8_load(const float *from) {
    return _mm256_loadu_ps(from);
}
INLINE v8 v8_all(float v) {
    return _mm256_set1_ps(v);
}
INLINE void v8_store(float *to, v8 v) {
    _mm256_storeu_ps(to, v);
}
INLINE v8 v8_size(v8 v) {
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), v);
}
INLINE v8 v8_pick(v8 a, v8 b, v8 yes, v8 no) {
    return _mm256_mask_blend_ps(_mm256_cmp_ps_mask(a, b, _CMP_LT_OQ), no, yes);
}
INLINE uint32_t v8_below(v8 a, v8 b) {
    return vm_bits(_mm256_cmp_ps_mask(a, b, _CMP_LT_OQ));
}

#include "from_region/separators_body.h"

static const EnfSeparatorKernel kernel = SEPARATOR_KERNEL;
const EnfSeparatorKernel *const enf_separators_avx512 = &kernel;
#else
const EnfSeparatorKernel *const enf_separators_avx512 = NULL; /* this compiler or processor has none */
#endif
