/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernels in AVX2: a cell's sixteen corners in two registers. */
#include "raycast/ray_kernel.h"

#if defined(__AVX2__)
#include <immintrin.h>

#define LANE_TYPE_(name, lanes) name##lanes
#define LANE_TYPE(name, lanes)  LANE_TYPE_(name, lanes)
#define INLINE                  static inline __attribute__((always_inline))
#define WIDE_DOUBLES            4

typedef float vf16 __attribute__((vector_size(64)));
typedef __m256 vf8;
typedef union Halves {
    vf16 whole;
    __m256 half[2];
} Halves;
typedef uint32_t vu16 __attribute__((vector_size(64)));
typedef uint32_t vu8 __attribute__((vector_size(32)));
typedef union IndexHalves {
    vu16 whole;
    vu8 half[2];
} IndexHalves;

#include "raycast/ray_exit_avx.h"

INLINE __m256i mask8(uint32_t lanes) {
    const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)lanes), bits), bits);
}
INLINE uint32_t lanes_lt8(vf8 a, vf8 b) {
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ));
}
INLINE uint32_t lanes_lt16(vf16 a, vf16 b) {
    Halves l = {a}, r = {b};
    return lanes_lt8(l.half[0], r.half[0]) | lanes_lt8(l.half[1], r.half[1]) << 8;
}
INLINE uint32_t lanes_eq8(vu8 a, vu8 b) {
    return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32((__m256i)a, (__m256i)b)));
}
INLINE uint32_t lanes_eq16(vu16 a, vu16 b) {
    IndexHalves l = {a}, r = {b};
    return lanes_eq8(l.half[0], r.half[0]) | lanes_eq8(l.half[1], r.half[1]) << 8;
}
INLINE void lanes_put8(float *to, uint32_t lanes, vf8 v) {
    _mm256_maskstore_ps(to, mask8(lanes), v);
}
INLINE void lanes_put16(float *to, uint32_t lanes, vf16 v) {
    Halves h = {v};
    lanes_put8(to, lanes, h.half[0]);
    lanes_put8(to + 8, lanes >> 8, h.half[1]);
}
INLINE void lanes_put_index8(uint32_t *to, uint32_t lanes, vu8 v) {
    _mm256_maskstore_epi32((int *)to, mask8(lanes), (__m256i)v);
}
INLINE void lanes_put_index16(uint32_t *to, uint32_t lanes, vu16 v) {
    IndexHalves h = {v};
    lanes_put_index8(to, lanes, h.half[0]);
    lanes_put_index8(to + 8, lanes >> 8, h.half[1]);
}
INLINE vf8 lanes_get8(const float *from) {
    return _mm256_loadu_ps(from);
}
INLINE vf16 lanes_get16(const float *from) {
    Halves h;
    h.half[0] = lanes_get8(from);
    h.half[1] = lanes_get8(from + 8);
    return h.whole;
}
INLINE vf8 lanes_all8(float v) {
    return _mm256_set1_ps(v);
}
INLINE vf16 lanes_all16(float v) {
    Halves h;
    h.half[0] = h.half[1] = _mm256_set1_ps(v);
    return h.whole;
}
INLINE vf8 lanes_pick8(uint32_t lanes, vf8 yes, vf8 no) {
    return _mm256_blendv_ps(no, yes, _mm256_castsi256_ps(mask8(lanes)));
}
INLINE vf16 lanes_pick16(uint32_t lanes, vf16 yes, vf16 no) {
    Halves y = {yes}, n = {no};
    y.half[0] = lanes_pick8(lanes, y.half[0], n.half[0]);
    y.half[1] = lanes_pick8(lanes >> 8, y.half[1], n.half[1]);
    return y.whole;
}

INLINE vu8 lanes_get_index8(const uint32_t *from) {
    return (vu8)_mm256_loadu_si256((const __m256i *)from);
}
INLINE vu16 lanes_get_index16(const uint32_t *from) {
    IndexHalves h;
    h.half[0] = lanes_get_index8(from);
    h.half[1] = lanes_get_index8(from + 8);
    return h.whole;
}
INLINE vu8 lanes_all_index8(uint32_t v) {
    return (vu8)_mm256_set1_epi32((int)v);
}
INLINE vu16 lanes_all_index16(uint32_t v) {
    IndexHalves h;
    h.half[0] = h.half[1] = lanes_all_index8(v);
    return h.whole;
}
INLINE vu8 lanes_pick_index8(uint32_t lanes, vu8 yes, vu8 no) {
    return (vu8)_mm256_blendv_epi8((__m256i)no, (__m256i)yes, mask8(lanes));
}
INLINE vu16 lanes_pick_index16(uint32_t lanes, vu16 yes, vu16 no) {
    IndexHalves y = {yes}, n = {no};
    y.half[0] = lanes_pick_index8(lanes, y.half[0], n.half[0]);
    y.half[1] = lanes_pick_index8(lanes >> 8, y.half[1], n.half[1]);
    return y.whole;
}

#include "raycast/ray_kernel_body.h"

static const RayKernel table = RAY_KERNEL_TABLE;
const RayKernel *const enf_ray_kernel_avx2 = &table;
#else
const RayKernel *const enf_ray_kernel_avx2 = NULL; /* this compiler or processor has none */
#endif
