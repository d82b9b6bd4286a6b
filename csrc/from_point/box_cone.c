/* SPDX-License-Identifier: GPL-3.0-or-later
 * Separating planes through the eye and a box's edges, eight boxes at once. Seen along axis k the box is a rectangle and the
 * edges of the cone are directions in its plane: when all of these pass all corners on the same side, a line through the eye
 * parts them, and with it a plane along k. The cross products of a direction with the four corners lie within the middle's
 * +- (|dj| hi + |di| hj): no corner is chosen. That needs boxes narrower than what the cone leaves; wide ones, beside the eye,
 * are parted by the plane through it along their sides.
 *
 * AVX2 when the processor has it, else a scalar twin with the same order of operations: equal bits. */
#include "from_point/box_cone.h"

#include "base/simd.h"

#include <math.h>

/* Seen along axis p. */
static const int axis_i[3] = {1, 2, 0}, axis_j[3] = {2, 0, 1};

void enf_cone_make(EnfCone *cone, const double (*directions)[3], uint32_t count, uint32_t views, const double eye[3], double reach) {
    double size = reach + fabs(eye[0]) + fabs(eye[1]) + fabs(eye[2]);
    cone->views = views;
    cone->count = count <= ENF_CONE_MAX ? count : 0; /* no directions part nothing: kept */
    for (int p = 0; p < 3; p++) {
        uint32_t up = 0, down = 0;
        for (uint32_t k = 0; k < cone->count; k++) {
            up += directions[k][p] >= 0;
            down += directions[k][p] <= 0;
        }
        cone->side[p] = !cone->count ? 0 : up == cone->count ? 1 : down == cone->count ? -1 : 0;
        cone->behind[p] = (float)(cone->side[p] * eye[p] - 1e-6 * size);
    }
    for (uint32_t k = 0; k < cone->count; k++)
        for (int p = 0; p < 3; p++) {
            cone->d[k][p] = (float)directions[k][p];
            if (!(views >> p & 1))
                continue;
            double di = directions[k][axis_i[p]], dj = directions[k][axis_j[p]];
            cone->eye[k][p] = (float)(dj * eye[axis_i[p]] - di * eye[axis_j[p]]);
            /* Single precision sums of six terms, each below |d| size: less than 10 roundings of 6e-8 each. */
            cone->margin[k][p] = (float)(1e-6 * (fabs(di) + fabs(dj)) * size);
        }
}

static uint32_t in_cone_scalar(const EnfBoxes8 *box, uint32_t mask, const EnfCone *cone) {
    const float *c[3] = {box->cx, box->cy, box->cz}, *h[3] = {box->hx, box->hy, box->hz};
    for (int p = 0; p < 3; p++)
        for (int i = 0; i < 8 && cone->side[p] != 0; i++) {
            float foremost = cone->side[p] * c[p][i] + h[p][i];
            mask &= ~((uint32_t)(foremost < cone->behind[p]) << i);
        }
    for (int p = 0; p < 3 && mask && cone->count; p++) {
        if (!(cone->views >> p & 1))
            continue;
        const float *ci = c[axis_i[p]], *cj = c[axis_j[p]], *hi = h[axis_i[p]], *hj = h[axis_j[p]];
        uint32_t left = mask, right = mask;
        for (uint32_t k = 0; k < cone->count && (left | right); k++) {
            float di = cone->d[k][axis_i[p]], dj = cone->d[k][axis_j[p]], ai = fabsf(di), aj = fabsf(dj);
            for (int i = 0; i < 8; i++) {
                float cross = dj * ci[i] - di * cj[i];
                cross = cross - cone->eye[k][p];
                float about = aj * hi[i] + ai * hj[i];
                about = about + cone->margin[k][p];
                left &= ~((uint32_t) !(cross > about) << i);
                right &= ~((uint32_t) !(-about > cross) << i);
            }
        }
        mask &= ~(left | right);
    }
    return mask;
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2"))) static uint32_t in_cone_avx2(const EnfBoxes8 *box, uint32_t mask, const EnfCone *cone) {
    const float *c[3] = {box->cx, box->cy, box->cz}, *h[3] = {box->hx, box->hy, box->hz};
    const __m256 zero = _mm256_setzero_ps();
    for (int p = 0; p < 3; p++)
        if (cone->side[p] != 0) {
            __m256 foremost = _mm256_mul_ps(_mm256_set1_ps(cone->side[p]), _mm256_loadu_ps(c[p]));
            foremost = _mm256_add_ps(foremost, _mm256_loadu_ps(h[p]));
            mask &= ~(uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(foremost, _mm256_set1_ps(cone->behind[p]), _CMP_LT_OQ));
        }
    for (int p = 0; p < 3 && mask && cone->count; p++) {
        if (!(cone->views >> p & 1))
            continue;
        int i = axis_i[p], j = axis_j[p];
        __m256 ci = _mm256_loadu_ps(c[i]), cj = _mm256_loadu_ps(c[j]), hi = _mm256_loadu_ps(h[i]), hj = _mm256_loadu_ps(h[j]);
        uint32_t left = mask, right = mask;
        for (uint32_t k = 0; k < cone->count && (left | right); k++) {
            float di = cone->d[k][i], dj = cone->d[k][j];
            __m256 cross = _mm256_sub_ps(_mm256_mul_ps(_mm256_set1_ps(dj), ci), _mm256_mul_ps(_mm256_set1_ps(di), cj));
            cross = _mm256_sub_ps(cross, _mm256_set1_ps(cone->eye[k][p]));
            __m256 about = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(fabsf(dj)), hi), _mm256_mul_ps(_mm256_set1_ps(fabsf(di)), hj));
            about = _mm256_add_ps(about, _mm256_set1_ps(cone->margin[k][p]));
            left &= (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(cross, about, _CMP_GT_OQ));
            right &= (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(_mm256_sub_ps(zero, about), cross, _CMP_GT_OQ));
        }
        mask &= ~(left | right);
    }
    return mask;
}
#endif

uint32_t enf_boxes_in_cone(const EnfBoxes8 *block, uint32_t mask, const EnfCone *cone, int use_simd) {
#ifdef ENF_HAVE_AVX2
    if (use_simd && enf_processor_avx2())
        return in_cone_avx2(block, mask, cone);
#endif
    (void)use_simd;
    return in_cone_scalar(block, mask, cone);
}
