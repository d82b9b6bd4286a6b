/* SPDX-License-Identifier: GPL-3.0-or-later
 * Triangles to voxels, conservatively: every voxel that a triangle touches.
 *
 * Based on: Akenine-Moeller, Fast 3D triangle-box overlap testing, 2001 (13 separating axes). Deviation: for each column along the
 * axis of the triangle's largest normal component only the voxels its plane can meet are tested, so that a large slanted face costs its area and
 * not its box. */
#include "base/status.h"
#include "detect/voxel_size.h"
#include "enfilade/voxels.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Voxels are taken larger by this part of their size, and by 64 ulp of the triangle's farthest coordinate: rounding stays below it. */
#define SLACK 1e-9

typedef struct Triangle {
    double p[3][3];                    /* in voxels from the origin */
    double edge[3][3];                 /* p1 - p0, p2 - p1, p0 - p2 */
    double normal[3], normal_error[3]; /* what rounding may have made of it: of slivers, all */
    double slack;                      /* voxels */
} Triangle;

/* Whether the axis cross(edge, unit vector) separates the triangle from the cube of half size `half` round `centre`. */
static int edge_separates(const Triangle *t, const double centre[3], double half) {
    for (int e = 0; e < 3; e++)
        for (int a = 0; a < 3; a++) {
            int b = (a + 1) % 3, c = (a + 2) % 3;
            double nb = -t->edge[e][c], nc = t->edge[e][b]; /* unit a x edge, components b and c */
            double reach = half * (fabs(nb) + fabs(nc));
            double s0 = nb * (t->p[0][b] - centre[b]) + nc * (t->p[0][c] - centre[c]);
            double s1 = nb * (t->p[1][b] - centre[b]) + nc * (t->p[1][c] - centre[c]);
            double s2 = nb * (t->p[2][b] - centre[b]) + nc * (t->p[2][c] - centre[c]);
            double low = fmin(s0, fmin(s1, s2)), high = fmax(s0, fmax(s1, s2));
            if (low > reach || high < -reach)
                return 1;
        }
    return 0;
}

/* The voxels along one axis that the interval low..high can touch; 0 when none in the grid. */
static int clip_range(double low, double high, double slack, uint32_t size, int64_t out[2]) {
    double a = floor(low - slack), b = floor(high + slack);
    if (!(b >= 0) || !(a < (double)size))
        return 0;
    out[0] = a < 0 ? 0 : (int64_t)a;
    out[1] = b >= (double)size ? (int64_t)size - 1 : (int64_t)b;
    return 1;
}

static void mark_triangle(const uint32_t size[3], const Triangle *t, uint8_t value, uint8_t *voxels) {
    int64_t range[3][2];
    int main_axis = 0;
    for (int a = 0; a < 3; a++) {
        if (!clip_range(fmin(t->p[0][a], fmin(t->p[1][a], t->p[2][a])), fmax(t->p[0][a], fmax(t->p[1][a], t->p[2][a])), t->slack, size[a],
                        range[a]))
            return;
        if (fabs(t->normal[a]) > fabs(t->normal[main_axis]))
            main_axis = a;
    }
    int u = (main_axis + 1) % 3, v = (main_axis + 2) % 3;
    const double half = 0.5 + t->slack;
    const double n = t->normal[main_axis], *error = t->normal_error, *p = t->p[0];
    uint64_t stride[3] = {1, size[0], (uint64_t)size[0] * size[1]};
    for (int64_t i = range[u][0]; i <= range[u][1]; i++)
        for (int64_t j = range[v][0]; j <= range[v][1]; j++) {
            double centre[3];
            centre[u] = (double)i + 0.5;
            centre[v] = (double)j + 0.5;
            int64_t k0 = range[main_axis][0], k1 = range[main_axis][1];
            /* Where the plane can be over this column; a sliver without a sure normal, or one too large for it, is tested all along. */
            double du = centre[u] - p[u], dv = centre[v] - p[v], rise = (t->normal[u] * du + t->normal[v] * dv) / n;
            double middle = p[main_axis] - rise;
            double unsure = 2 * (error[u] * fabs(du) + error[v] * fabs(dv) + error[main_axis] * fabs(rise)) / fabs(n);
            if (fabs(n) > 4 * error[main_axis] && isfinite(middle) && isfinite(unsure)) {
                double spread = half * (fabs(t->normal[u]) + fabs(t->normal[v])) / fabs(n) + unsure + 1e-6 + t->slack;
                int64_t column[2];
                if (!clip_range(middle - spread, middle + spread, t->slack, size[main_axis], column))
                    continue;
                k0 = column[0] > k0 ? column[0] : k0;
                k1 = column[1] < k1 ? column[1] : k1;
            }
            for (int64_t k = k0; k <= k1; k++) {
                uint8_t *voxel = voxels + (uint64_t)i * stride[u] + (uint64_t)j * stride[v] + (uint64_t)k * stride[main_axis];
                if ((*voxel & value) == value)
                    continue;
                centre[main_axis] = (double)k + 0.5;
                if (!edge_separates(t, centre, half))
                    *voxel |= value;
            }
        }
}

EnfStatus enf_voxels_mark(const uint32_t size[3], const double origin[3], double step, const double *vertices, uint64_t vertex_count,
                          uint64_t vertex_stride, const uint32_t *triangles, uint64_t triangle_count, uint8_t value, uint8_t *voxels) {
    uint64_t total;
    EnfStatus status =
        voxel_total(__func__, size, origin && (vertices || !vertex_count) && (triangles || !triangle_count) && voxels, &total);
    if (status != ENF_OK)
        return status;
    if (!(step > 0) || !isfinite(step) || !isfinite(origin[0]) || !isfinite(origin[1]) || !isfinite(origin[2]))
        return enf_fail(ENF_ERROR_BAD_INPUT, "voxels of %g m at (%g, %g, %g): the step must be positive, all finite", step, origin[0],
                        origin[1], origin[2]);
    if (vertex_stride == 0)
        vertex_stride = 3 * sizeof(double);
    for (uint64_t i = 0; i < triangle_count; i++) {
        Triangle t;
        double farthest = 0;
        for (int c = 0; c < 3; c++) {
            uint32_t index = triangles[3 * i + (uint64_t)c];
            double point[3];
            if (index >= vertex_count)
                return enf_fail(ENF_ERROR_BAD_INPUT, "triangle %llu: corner %u of %llu vertices", (unsigned long long)i, index,
                                (unsigned long long)vertex_count);
            memcpy(point, (const char *)vertices + index * vertex_stride, sizeof point);
            for (int a = 0; a < 3; a++) {
                t.p[c][a] = (point[a] - origin[a]) / step;
                if (!isfinite(t.p[c][a]))
                    return enf_fail(ENF_ERROR_BAD_INPUT, "triangle %llu: vertex %u isn't finite", (unsigned long long)i, index);
                farthest = fmax(farthest, fabs(t.p[c][a]));
            }
        }
        t.slack = SLACK + 64 * DBL_EPSILON * farthest;
        for (int e = 0; e < 3; e++)
            for (int a = 0; a < 3; a++)
                t.edge[e][a] = t.p[(e + 1) % 3][a] - t.p[e][a];
        for (int a = 0; a < 3; a++) {
            int b = (a + 1) % 3, c = (a + 2) % 3;
            double plus = t.edge[0][b] * t.edge[1][c], minus = t.edge[0][c] * t.edge[1][b];
            t.normal[a] = plus - minus;
            t.normal_error[a] = 4 * DBL_EPSILON * (fabs(plus) + fabs(minus)); /* edges, products and their difference: 3 roundings each */
        }
        mark_triangle(size, &t, value, voxels);
    }
    return ENF_OK;
}
