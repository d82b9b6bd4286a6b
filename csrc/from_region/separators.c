/* SPDX-License-Identifier: GPL-3.0-or-later
 * Separating planes, window clipping, and boxes against planes. */
#include "from_region/separators.h"

#include <math.h>
#include <string.h>

#include "geometry/vec3.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/* [Model units] A plane counts as separating when the corners of both windows keep to their sides within this: some ten
 * roundings of coordinates below 1. */
#define ON_PLANE 1e-15

/* Planes flatter than this sine to both windows bound next to nothing. */
#define SINE_SQUARE_MIN 1e-8

/* [Model units] Windows nearer to each other than this give no planes: what rounding does to a plane grows with the distance from
 * them over their gap. */
#define GAP_MIN 1e-6

/* [Model units] Room for single precision: eight terms of at most 1, each within 2^-24. */
#define SINGLE_SLACK 1e-6

/* For each edge of `source` the plane through it that touches `pass` with the two on opposite sides: n . x >= d beyond pass,
 * turned round when sign is -1. clockwise: the windows run clockwise about `normal`. */
static uint32_t edge_planes(const EnfWindow *source, const double normal[3], const EnfWindow *pass,
                            const double pass_normal[3], int clockwise, double sign, double slack, double (*planes)[4]) {
    uint32_t written = 0, n = source->count, count = pass->count;
    /* Coordinates side by side and padded with the last corner: loops of a fixed step, without branches. */
    double px[ENF_WINDOW_MAX + 4], py[ENF_WINDOW_MAX + 4], pz[ENF_WINDOW_MAX + 4], height[ENF_WINDOW_MAX + 4];
    double angle_u[ENF_WINDOW_MAX + 4];
    double level = vec_dot(normal, source->v[0]);
    uint32_t padded = (count + 3) & ~3u;
    for (uint32_t k = 0; k < padded; ++k) {
        const double *v = pass->v[k < count ? k : count - 1];
        px[k] = v[0], py[k] = v[1], pz[k] = v[2];
        height[k] = vec_dot(normal, v) - level;
    }
    for (uint32_t i = 0; i < n; ++i) {
        const double *a = source->v[i], *b = source->v[i + 1 < n ? i + 1 : 0];
        double e[3], u[3], r[3];
        vec_sub(e, b, a);
        /* u: in the source's plane, perpendicular to the edge, pointing into the source; not a unit vector. */
        if (clockwise) vec_cross(u, e, normal);
        else vec_cross(u, normal, e);
        double u0 = u[0], u1 = u[1], u2 = u[2], a0 = a[0], a1 = a[1], a2 = a[2];
        for (uint32_t k = 0; k < padded; k += 4)
            for (uint32_t j = k; j < k + 4; ++j)
                angle_u[j] = ((px[j] - a0) * u0 + (py[j] - a1) * u1) + (pz[j] - a2) * u2;
        double best_u = angle_u[0], best_w = height[0];
        uint32_t best = 0;
        for (uint32_t k = 1; k < count; ++k) {
            /* The smaller angle from the source's plane: the plane that turns into pass first. */
            int better = angle_u[k] * best_w - height[k] * best_u > 0;
            best = better ? k : best;
            best_u = angle_u[best], best_w = height[best];
        }
        if (best_w <= 0) continue; /* pass reaches behind the source's plane: no plane through this edge separates */
        double n3[3], *plane = planes[written];
        vec_sub(r, pass->v[best], a);
        vec_cross(n3, e, r);
        double size2 = vec_dot(n3, n3);
        if (!(size2 > 1e-30)) continue; /* too short an edge or lever to carry a direction */
        double c = vec_dot(n3, pass_normal), length2 = vec_dot(e, e);
        if (best_w * best_w * length2 < SINE_SQUARE_MIN * (best_u * best_u + best_w * best_w * length2) &&
            size2 - c * c < SINE_SQUARE_MIN * size2)
            continue;
        /* Any length near 1 will do. */
        double f = (double)(1.0f / sqrtf((float)size2));
        if (vec_dot(n3, u) > 0) f = -f;
        vec_scale(n3, f, n3);
        double d = vec_dot(n3, a);
        /* The computed plane, whatever rounding did to it, has to separate the windows as they are stored. */
        double n0 = n3[0], n1 = n3[1], n2 = n3[2];
        for (uint32_t k = 0; k < padded; k += 4)
            for (uint32_t j = k; j < k + 4; ++j) angle_u[j] = (n0 * px[j] + n1 * py[j]) + n2 * pz[j];
        double least = angle_u[0], most = d;
        for (uint32_t k = 1; k < padded; ++k) least = angle_u[k] < least ? angle_u[k] : least;
        for (uint32_t k = 0; k < n; ++k) {
            double h = vec_dot(n3, source->v[k]);
            most = h > most ? h : most;
        }
        if (!(least - d >= -ON_PLANE) || !(most - d <= ON_PLANE)) continue;
        vec_scale(plane, sign, n3);
        plane[3] = sign * d - slack;
        ++written;
    }
    return written;
}

/* How far planes are moved outward; 0: no planes. A line leaves source at n . x <= d + ON_PLANE and passes pass at >= d -
 * ON_PLANE, at least `gap` further on; over the scene's extent (below 1) it falls by no more than 2 ON_PLANE / gap. sign 1: pass
 * lies in front of source, -1: behind. */
static double slack_of(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                       double sign) {
    double above = 1, before = 1;
    double level = sign * vec_dot(source_normal, source->v[0]), pass_level = sign * vec_dot(pass_normal, pass->v[0]);
    for (uint32_t i = 0; i < pass->count; ++i) above = fmin(above, sign * vec_dot(source_normal, pass->v[i]) - level);
    for (uint32_t i = 0; i < source->count; ++i) before = fmin(before, pass_level - sign * vec_dot(pass_normal, source->v[i]));
    double gap = fmax(above, before);
    return gap > GAP_MIN ? ON_PLANE * (2 + 3 / gap) : 0;
}

uint32_t enf_separators(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass,
                        const double pass_normal[3], double (*planes)[4]) {
    double reversed[3] = {-pass_normal[0], -pass_normal[1], -pass_normal[2]};
    double slack = slack_of(source, source_normal, pass, pass_normal, 1);
    if (!(slack > 0)) return 0;
    uint32_t count = edge_planes(source, source_normal, pass, pass_normal, 0, 1, slack, planes);
    return count + edge_planes(pass, reversed, source, source_normal, 1, -1, slack, planes + count);
}

uint32_t enf_separators_back(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass,
                             const double pass_normal[3], double (*planes)[4]) {
    double reversed[3] = {-source_normal[0], -source_normal[1], -source_normal[2]};
    double slack = slack_of(source, source_normal, pass, pass_normal, -1);
    if (!(slack > 0)) return 0;
    uint32_t count = edge_planes(source, reversed, pass, pass_normal, 1, 1, slack, planes);
    return count + edge_planes(pass, pass_normal, source, source_normal, 0, -1, slack, planes + count);
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
    uint32_t crossings = 0;
    for (uint32_t i = 0; i < n; ++i) crossings += (h[i] < 0) != (h[i + 1 < n ? i + 1 : 0] < 0);
    /* More than two: corners so close to the plane that rounding mixes their sides. Left as it is. */
    if (n - outside + 2 > ENF_WINDOW_MAX || crossings > 2) return 1;
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
