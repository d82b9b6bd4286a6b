/* SPDX-License-Identifier: GPL-3.0-or-later
 * A single ray's questions to a prism in 32-byte registers, for the AVX2 and the AVX-512 kernel: there too, since a comparison comes as a
 * number from these registers sooner than from mask registers. Included after INLINE. */
#ifndef ENF_RAYCAST_RAY_EXIT_AVX_H
#define ENF_RAYCAST_RAY_EXIT_AVX_H

/* Which band of the section a height lies in: heights ascend, the links after them are looked at with them and left out again. */
INLINE uint32_t band_at(const PrismSection *s, float z) {
    uint32_t below = (uint32_t)_mm_movemask_ps(_mm_cmplt_ps(_mm_set1_ps(z), _mm_loadu_ps(s->height)));
    return (uint32_t)__builtin_ctz((below & 7u) | 8u);
}

INLINE uint32_t right_of(const float *px, const float *py, float ox, float oy, float dx, float dy) {
    __m256 x = _mm256_sub_ps(_mm256_loadu_ps(px), _mm256_set1_ps(ox)), y = _mm256_sub_ps(_mm256_loadu_ps(py), _mm256_set1_ps(oy));
    __m256 side = _mm256_sub_ps(_mm256_mul_ps(_mm256_set1_ps(dx), y), _mm256_mul_ps(_mm256_set1_ps(dy), x));
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(side, _mm256_setzero_ps(), _CMP_LT_OQ));
}

INLINE uint32_t first_exit(const PrismNode *node, float ox, float oy, float dx, float dy) {
    uint32_t right = right_of(node->x, node->y, ox, oy, dx, dy) | right_of(node->x + 8, node->y + 8, ox, oy, dx, dy) << 8;
    return (uint32_t)__builtin_ctz((right & ~(right >> 1) & 0x7FFFu) | 0x8000u);
}

#endif
