/* SPDX-License-Identifier: GPL-3.0-or-later
 * Projection of portal corners: scalar, and AVX2 behind a runtime check. */
#include "from_point/project_corners.h"

#include "base/simd.h"

#include <math.h>

static uint32_t project_scalar(const double (*corners)[3], uint32_t count, const double eye[3], const double (*rows)[3],
                               const double rect[4], EnfHomogeneous *out, double *x, double *y) {
    uint32_t codes = 15 | ENF_CORNERS_PLAIN;
    for (uint32_t i = 0; i < count; i++) {
        double q0 = corners[i][0] - eye[0], q1 = corners[i][1] - eye[1], q2 = corners[i][2] - eye[2];
        /* The order of operations is the vector twin's: equal bits. */
        double u = rows[0][0] * q0 + rows[0][1] * q1 + rows[0][2] * q2;
        double v = rows[1][0] * q0 + rows[1][1] * q1 + rows[1][2] * q2;
        double w = rows[2][0] * q0 + rows[2][1] * q1 + rows[2][2] * q2;
        double wide = 256 * w;
        out->u[i] = u;
        out->v[i] = v;
        out->w[i] = w;
        codes &= (uint32_t)(u > rect[2] * w) | (uint32_t)(u < rect[0] * w) << 1 | (uint32_t)(v > rect[3] * w) << 2 |
                 (uint32_t)(v < rect[1] * w) << 3 | (uint32_t)(w > 0 && fabs(u) <= wide && fabs(v) <= wide) << 4;
    }
    if (codes == ENF_CORNERS_PLAIN)
        for (uint32_t i = 0; i < count; i++) {
            double inverse = 1.0 / out->w[i];
            x[i] = out->u[i] * inverse;
            y[i] = out->v[i] * inverse;
        }
    return codes;
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2"))) static uint32_t project_avx2(const double (*corners)[3], uint32_t count, const double eye[3],
                                                             const double (*rows)[3], const double rect[4], EnfHomogeneous *out, double *x,
                                                             double *y) {
    const __m256d ex = _mm256_set1_pd(eye[0]), ey = _mm256_set1_pd(eye[1]), ez = _mm256_set1_pd(eye[2]);
    const __m256d sign = _mm256_set1_pd(-0.0), zero = _mm256_setzero_pd();
    uint32_t codes = 15 | ENF_CORNERS_PLAIN;
    for (uint32_t i = 0; i < count; i += 4) {
        const double *p = corners[i];
        /* x0 y0 z0 x1 | y1 z1 x2 y2 | z2 x3 y3 z3 to rows of x, y, z */
        __m256d a = _mm256_loadu_pd(p), b = _mm256_loadu_pd(p + 4), c = _mm256_loadu_pd(p + 8);
        __m256d ab = _mm256_blend_pd(a, b, 12), ac = _mm256_permute2f128_pd(a, c, 0x21), bc = _mm256_blend_pd(b, c, 12);
        __m256d q0 = _mm256_sub_pd(_mm256_shuffle_pd(ab, ac, 10), ex);
        __m256d q1 = _mm256_sub_pd(_mm256_shuffle_pd(ab, bc, 5), ey);
        __m256d q2 = _mm256_sub_pd(_mm256_shuffle_pd(ac, bc, 10), ez);
        __m256d h[3];
        for (int r = 0; r < 3; r++) {
            h[r] = _mm256_add_pd(_mm256_mul_pd(_mm256_set1_pd(rows[r][0]), q0), _mm256_mul_pd(_mm256_set1_pd(rows[r][1]), q1));
            h[r] = _mm256_add_pd(h[r], _mm256_mul_pd(_mm256_set1_pd(rows[r][2]), q2));
        }
        _mm256_storeu_pd(out->u + i, h[0]);
        _mm256_storeu_pd(out->v + i, h[1]);
        _mm256_storeu_pd(out->w + i, h[2]);
        uint32_t lanes = count - i >= 4 ? 15u : (1u << (count - i)) - 1;
        uint32_t right = (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(h[0], _mm256_mul_pd(_mm256_set1_pd(rect[2]), h[2]), _CMP_GT_OQ));
        uint32_t left = (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(h[0], _mm256_mul_pd(_mm256_set1_pd(rect[0]), h[2]), _CMP_LT_OQ));
        uint32_t upper = (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(h[1], _mm256_mul_pd(_mm256_set1_pd(rect[3]), h[2]), _CMP_GT_OQ));
        uint32_t lower = (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(h[1], _mm256_mul_pd(_mm256_set1_pd(rect[1]), h[2]), _CMP_LT_OQ));
        __m256d wide = _mm256_mul_pd(_mm256_set1_pd(256), h[2]);
        __m256d far = _mm256_max_pd(_mm256_andnot_pd(sign, h[0]), _mm256_andnot_pd(sign, h[1]));
        uint32_t plain =
            (uint32_t)_mm256_movemask_pd(_mm256_and_pd(_mm256_cmp_pd(far, wide, _CMP_LE_OQ), _mm256_cmp_pd(h[2], zero, _CMP_GT_OQ)));
        codes &= (uint32_t)((right & lanes) == lanes) | (uint32_t)((left & lanes) == lanes) << 1 |
                 (uint32_t)((upper & lanes) == lanes) << 2 | (uint32_t)((lower & lanes) == lanes) << 3 |
                 (uint32_t)((plain & lanes) == lanes) << 4;
    }
    if (codes == ENF_CORNERS_PLAIN)
        for (uint32_t i = 0; i < count; i += 4) {
            __m256d inverse = _mm256_div_pd(_mm256_set1_pd(1), _mm256_loadu_pd(out->w + i));
            _mm256_storeu_pd(x + i, _mm256_mul_pd(_mm256_loadu_pd(out->u + i), inverse));
            _mm256_storeu_pd(y + i, _mm256_mul_pd(_mm256_loadu_pd(out->v + i), inverse));
        }
    return codes;
}
#endif

EnfProjectCorners enf_project_corners(int use_simd) {
#ifdef ENF_HAVE_AVX2
    if (use_simd && enf_processor_avx2())
        return project_avx2;
#endif
    (void)use_simd;
    return project_scalar;
}
