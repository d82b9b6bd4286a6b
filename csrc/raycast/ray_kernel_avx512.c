/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernels in AVX-512: a cell's sixteen corners in one register, packets' lanes as masks. */
#include "raycast/ray_kernel.h"

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__) && defined(__AVX512BW__)
#include "base/simd.h"

#define LANE_TYPE_(name, lanes) name##lanes
#define LANE_TYPE(name, lanes)  LANE_TYPE_(name, lanes)
#define INLINE                  static inline __attribute__((always_inline))
#define WIDE_DOUBLES            8

typedef __m512 vf16;
typedef __m256 vf8;
typedef uint32_t vu16 __attribute__((vector_size(64)));
typedef uint32_t vu8 __attribute__((vector_size(32)));

INLINE uint32_t number8(__mmask8 mask) {
    ENF_MASK_APART(mask);
    return mask;
}
INLINE uint32_t number16(__mmask16 mask) {
    ENF_MASK_APART(mask);
    return mask;
}

#include "raycast/ray_exit_avx.h"

INLINE uint32_t lanes_lt16(vf16 a, vf16 b) {
    return number16(_mm512_cmp_ps_mask(a, b, _CMP_LT_OQ));
}
INLINE uint32_t lanes_lt8(vf8 a, vf8 b) {
    return number8(_mm256_cmp_ps_mask(a, b, _CMP_LT_OQ));
}
INLINE uint32_t lanes_eq16(vu16 a, vu16 b) {
    return number16(_mm512_cmpeq_epi32_mask((__m512i)a, (__m512i)b));
}
INLINE uint32_t lanes_eq8(vu8 a, vu8 b) {
    return number8(_mm256_cmpeq_epi32_mask((__m256i)a, (__m256i)b));
}
INLINE void lanes_put16(float *to, uint32_t lanes, vf16 v) {
    _mm512_mask_storeu_ps(to, (__mmask16)lanes, v);
}
INLINE void lanes_put_index16(uint32_t *to, uint32_t lanes, vu16 v) {
    _mm512_mask_storeu_epi32(to, (__mmask16)lanes, (__m512i)v);
}
INLINE vf16 lanes_get16(const float *from) {
    return _mm512_loadu_ps(from);
}
INLINE vf8 lanes_get8(const float *from) {
    return _mm256_loadu_ps(from);
}
INLINE vf16 lanes_all16(float v) {
    return _mm512_set1_ps(v);
}
INLINE vf8 lanes_all8(float v) {
    return _mm256_set1_ps(v);
}
INLINE vf16 lanes_pick16(uint32_t lanes, vf16 yes, vf16 no) {
    return _mm512_mask_blend_ps((__mmask16)lanes, no, yes);
}
INLINE vf8 lanes_pick8(uint32_t lanes, vf8 yes, vf8 no) {
    return _mm256_mask_blend_ps((__mmask8)lanes, no, yes);
}
INLINE vu16 lanes_get_index16(const uint32_t *from) {
    return (vu16)_mm512_loadu_si512(from);
}
INLINE vu8 lanes_get_index8(const uint32_t *from) {
    return (vu8)_mm256_loadu_si256((const __m256i *)from);
}
INLINE vu16 lanes_all_index16(uint32_t v) {
    return (vu16)_mm512_set1_epi32((int)v);
}
INLINE vu8 lanes_all_index8(uint32_t v) {
    return (vu8)_mm256_set1_epi32((int)v);
}
INLINE vu16 lanes_pick_index16(uint32_t lanes, vu16 yes, vu16 no) {
    return (vu16)_mm512_mask_blend_epi32((__mmask16)lanes, (__m512i)no, (__m512i)yes);
}
INLINE vu8 lanes_pick_index8(uint32_t lanes, vu8 yes, vu8 no) {
    return (vu8)_mm256_mask_blend_epi32((__mmask8)lanes, (__m256i)no, (__m256i)yes);
}

#define RUN_WAVE run_wave
static void run_wave(const EnfRaycaster *r, RayBlock *b);

#include "raycast/ray_kernel_body.h"
#include "raycast/ray_wave_avx512.h"

static const RayKernel table = RAY_KERNEL_TABLE;
const RayKernel *const enf_ray_kernel_avx512 = &table;
#else
const RayKernel *const enf_ray_kernel_avx512 = NULL; /* this compiler or processor has none */
#endif
