/* SPDX-License-Identifier: GPL-3.0-or-later
 * Separating planes, window clipping, and boxes against planes. */
#include "from_region/separators.h"

#include <math.h>
#include <string.h>

#include "geometry/vec3.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/* [Model units] An edge shorter than this, or a corner nearer to the edge's line, gives a plane whose direction rounding
 * could turn by more than 1e-8: it is left out, so less is cut off. */
#define CONDITION_MIN 1e-6

/* Rounding of the coordinates a plane comes from, times a safety of about 20: divided by the length of the shortest lever, it
 * bounds how far the computed plane strays from a separating one within the unit box. */
#define ROUNDING 1e-14

/* [Model units] Room for single precision: eight terms of at most 1, each within 2^-24. */
#define SINGLE_SLACK 1e-6

/* For each edge of `source` the plane through it that touches `pass` with the two on opposite sides. flip = 0: n . x >= d
 * holds beyond pass; flip = 1: called with the windows exchanged and normals reversed, and the planes are turned round. */
static uint32_t edge_planes(const EnfWindow *source, const double normal[3], const EnfWindow *pass, int flip,
                            double (*planes)[4]) {
    uint32_t written = 0, n = source->count;
    for (uint32_t i = 0; i < n; ++i) {
        const double *a = source->v[i], *b = source->v[i + 1 < n ? i + 1 : 0];
        double e[3], u[3];
        vec_sub(e, b, a);
        double length2 = vec_dot(e, e);
        if (length2 < CONDITION_MIN * CONDITION_MIN) continue;
        double length = sqrt(length2);
        /* u: in the source's plane, perpendicular to the edge, pointing into the source. A window reversed in direction
         * runs clockwise about `normal`, so the sign turns. */
        vec_cross(u, normal, e);
        vec_scale(u, (flip ? -1.0 : 1.0) / length, u);
        double best_u = 0, best_w = 0, nearest2 = DBL_MAX;
        for (uint32_t k = 0; k < pass->count; ++k) {
            double r[3];
            vec_sub(r, pass->v[k], a);
            double vu = vec_dot(r, u), vw = vec_dot(r, normal), r2 = vu * vu + vw * vw;
            if (r2 < nearest2) nearest2 = r2;
            /* The smaller angle from the source's plane: the plane that turns into pass first. */
            if (!k || vu * best_w - vw * best_u > 0) best_u = vu, best_w = vw;
        }
        if (nearest2 < CONDITION_MIN * CONDITION_MIN) continue;
        if (best_w <= 0) continue; /* pass reaches behind the source's plane: no plane through this edge separates */
        double r = sqrt(best_u * best_u + best_w * best_w), lever = sqrt(nearest2);
        if (length < lever) lever = length;
        double *plane = planes[written++], sign = flip ? -1.0 : 1.0;
        for (int k = 0; k < 3; ++k) plane[k] = sign * (best_u * normal[k] - best_w * u[k]) / r;
        plane[3] = vec_dot(plane, a) - ROUNDING / lever;
    }
    return written;
}

uint32_t enf_separators(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass,
                        const double pass_normal[3], double (*planes)[4]) {
    double reversed[3] = {-pass_normal[0], -pass_normal[1], -pass_normal[2]};
    uint32_t count = edge_planes(source, source_normal, pass, 0, planes);
    return count + edge_planes(pass, reversed, source, 1, planes + count);
}

int enf_window_clip(EnfWindow *window, const double plane[4], int *clipped) {
    double h[ENF_WINDOW_MAX];
    uint32_t n = window->count, outside = 0;
    for (uint32_t i = 0; i < n; ++i) {
        h[i] = vec_dot(plane, window->v[i]) - plane[3];
        outside += h[i] < 0;
    }
    if (!outside) return 1;
    *clipped = 1;
    if (outside == n) return 0;
    if (n - outside + 2 > ENF_WINDOW_MAX) return 1;
    EnfWindow result;
    result.count = 0;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t j = i + 1 < n ? i + 1 : 0;
        if (h[i] >= 0) vec_copy(result.v[result.count++], window->v[i]);
        if ((h[i] < 0) != (h[j] < 0)) {
            double t = h[i] / (h[i] - h[j]);
            for (int k = 0; k < 3; ++k)
                result.v[result.count][k] = window->v[i][k] + t * (window->v[j][k] - window->v[i][k]);
            ++result.count;
        }
    }
    window->count = result.count;
    memcpy(window->v, result.v, result.count * sizeof *result.v);
    return 1;
}

void enf_plane_pack(EnfPlanePack *pack, const double (*planes)[4], uint32_t count) {
    pack->groups = (count + 3) / 4;
    for (uint32_t i = 0; i < 4 * pack->groups; ++i) {
        float(*group)[4] = pack->f[i >> 2];
        for (int k = 0; k < 3; ++k) {
            float n = i < count ? (float)planes[i][k] : 0;
            group[k][i & 3] = n;
            group[k + 3][i & 3] = fabsf(n);
        }
        group[6][i & 3] = i < count ? (float)(planes[i][3] - SINGLE_SLACK) : -1;
    }
}

int enf_pack_misses_box(const EnfPlanePack *pack, const float box[6]) {
#if defined(__SSE2__)
    __m128 cx = _mm_set1_ps(box[0]), cy = _mm_set1_ps(box[1]), cz = _mm_set1_ps(box[2]);
    __m128 hx = _mm_set1_ps(box[3]), hy = _mm_set1_ps(box[4]), hz = _mm_set1_ps(box[5]);
    for (uint32_t g = 0; g < pack->groups; ++g) {
        const float(*f)[4] = pack->f[g];
        __m128 s = _mm_add_ps(_mm_add_ps(_mm_mul_ps(_mm_loadu_ps(f[0]), cx), _mm_mul_ps(_mm_loadu_ps(f[1]), cy)),
                              _mm_mul_ps(_mm_loadu_ps(f[2]), cz));
        __m128 r = _mm_add_ps(_mm_add_ps(_mm_mul_ps(_mm_loadu_ps(f[3]), hx), _mm_mul_ps(_mm_loadu_ps(f[4]), hy)),
                              _mm_mul_ps(_mm_loadu_ps(f[5]), hz));
        if (_mm_movemask_ps(_mm_cmplt_ps(_mm_add_ps(s, r), _mm_loadu_ps(f[6])))) return 1;
    }
#else
    for (uint32_t g = 0; g < pack->groups; ++g)
        for (int i = 0; i < 4; ++i) {
            const float(*f)[4] = pack->f[g];
            float s = (f[0][i] * box[0] + f[1][i] * box[1]) + f[2][i] * box[2];
            float r = (f[3][i] * box[3] + f[4][i] * box[4]) + f[5][i] * box[5];
            if (s + r < f[6][i]) return 1;
        }
#endif
    return 0;
}
