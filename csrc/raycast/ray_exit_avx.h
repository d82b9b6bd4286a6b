/* SPDX-License-Identifier: GPL-3.0-or-later
 * A single ray's questions to a prism in 32-byte registers, for the AVX2 and the AVX-512 kernel: there too, since a comparison comes as a
 * number from these registers sooner than from mask registers. Included after INLINE. */
#ifndef ENF_RAYCAST_RAY_EXIT_AVX_H
#define ENF_RAYCAST_RAY_EXIT_AVX_H

/* Which band of the section a height lies in: heights ascend, the links after them are looked at with them and left out again. */
INLINE uint32_t band_at(const PrismSection *s, float z) {
    uint32_t below = (uint32_t)_mm_movemask_ps(_mm_cmplt_ps(_mm_set1_ps(z), _mm_loadu_ps(s->height)));
    return (uint32_t)__builtin_ctz(below | 8u); /* whatever the fourth says */
}

INLINE uint32_t right_of(const float *px, const float *py, float ox, float oy, float dx, float dy) {
    __m256 x = _mm256_sub_ps(_mm256_loadu_ps(px), _mm256_set1_ps(ox)), y = _mm256_sub_ps(_mm256_loadu_ps(py), _mm256_set1_ps(oy));
    __m256 side = _mm256_sub_ps(_mm256_mul_ps(_mm256_set1_ps(dx), y), _mm256_mul_ps(_mm256_set1_ps(dy), x));
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(side, _mm256_setzero_ps(), _CMP_LT_OQ));
}

/* The sections a ray may leave by, as bits; a sound outline has one at most. */
INLINE uint32_t all_exits(const PrismNode *node, float ox, float oy, float dx, float dy) {
#ifdef __AVX512F__
    __m512 x = _mm512_sub_ps(_mm512_loadu_ps(node->x), _mm512_set1_ps(ox)), y = _mm512_sub_ps(_mm512_loadu_ps(node->y), _mm512_set1_ps(oy));
    __m512 side = _mm512_sub_ps(_mm512_mul_ps(_mm512_set1_ps(dx), y), _mm512_mul_ps(_mm512_set1_ps(dy), x));
    uint32_t right = number16(_mm512_cmp_ps_mask(side, _mm512_setzero_ps(), _CMP_LT_OQ));
#else
    uint32_t right = right_of(node->x, node->y, ox, oy, dx, dy) | right_of(node->x + 8, node->y + 8, ox, oy, dx, dy) << 8;
#endif
    return right & ~(right >> 1) & 0x7FFFu;
}

/* The first of them. Gives 0 where there is none. */
INLINE int find_exit(const PrismNode *node, float ox, float oy, float dx, float dy, uint32_t *k) {
    uint32_t exits = all_exits(node, ox, oy, dx, dy);
    *k = (uint32_t)__builtin_ctz(exits | 0x8000u);
    return exits != 0;
}

/* All bits where `beyond` > 0, and then the distance is that of the cap. */
INLINE uint32_t take_cap(float beyond, float cap_distance, float *distance) {
    __m128 mask = _mm_cmpgt_ss(_mm_set_ss(beyond), _mm_setzero_ps());
    *distance = _mm_cvtss_f32(_mm_blendv_ps(_mm_set_ss(*distance), _mm_set_ss(cap_distance), mask));
    return (uint32_t)_mm_cvtsi128_si32(_mm_castps_si128(mask));
}

#endif
