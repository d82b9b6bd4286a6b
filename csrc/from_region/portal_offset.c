/* SPDX-License-Identifier: GPL-3.0-or-later
 * Portals enlarged and shrunk in their plane, so that geometry that touches becomes geometry that clearly does or doesn't.
 *
 * Safe direction: the enlarged polygon contains every point of the plane within `offset` of the portal (mitred, sharp
 * corners bevelled outside the rounded one); the shrunk one contains no point within `offset` of an edge. */
#include "from_region/region_model.h"

#include <math.h>
#include <stdlib.h>

/* A mitre longer than twice the offset is cut by a bevel at the offset's distance from the corner. */
#define MITRE_LIMIT_COSINE (-0.5)

static int compare_points(const void *left, const void *right) {
    const double *a = left, *b = right;
    if (a[0] != b[0])
        return a[0] < b[0] ? -1 : 1;
    if (a[1] != b[1])
        return a[1] < b[1] ? -1 : 1;
    return 0;
}

static double turn(const double *a, const double *b, const double *c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Andrew's monotone chain; drops duplicates and collinear points. points are sorted in place; hull needs count + 1 slots. */
static uint32_t convex_hull(double (*points)[2], uint32_t count, double (*hull)[2]) {
    if (count > 16)
        qsort(points, count, sizeof *points, compare_points);
    else
        for (uint32_t i = 1; i < count; ++i) { /* the few corners a portal has */
            double x = points[i][0], y = points[i][1];
            uint32_t k = i;
            for (; k > 0 && (points[k - 1][0] > x || (points[k - 1][0] == x && points[k - 1][1] > y)); --k)
                points[k][0] = points[k - 1][0], points[k][1] = points[k - 1][1];
            points[k][0] = x, points[k][1] = y;
        }
    uint32_t size = 0;
    for (uint32_t i = 0; i < count; ++i) {
        while (size >= 2 && turn(hull[size - 2], hull[size - 1], points[i]) <= 0)
            --size;
        hull[size][0] = points[i][0], hull[size][1] = points[i][1];
        ++size;
    }
    uint32_t lower = size + 1;
    for (uint32_t k = count - 1; k-- > 0;) {
        while (size >= lower && turn(hull[size - 2], hull[size - 1], points[k]) <= 0)
            --size;
        hull[size][0] = points[k][0], hull[size][1] = points[k][1];
        ++size;
    }
    return size > 1 ? size - 1 : size;
}

static uint32_t enlarge(double (*hull)[2], uint32_t count, double offset, double (*out)[2]) {
    uint32_t size = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const double *before = hull[(i + count - 1) % count], *at = hull[i], *after = hull[(i + 1) % count];
        double e1[2] = {at[0] - before[0], at[1] - before[1]}, e2[2] = {after[0] - at[0], after[1] - at[1]};
        double l1 = hypot(e1[0], e1[1]), l2 = hypot(e2[0], e2[1]);
        e1[0] /= l1, e1[1] /= l1, e2[0] /= l2, e2[1] /= l2;
        double n1[2] = {e1[1], -e1[0]}, n2[2] = {e2[1], -e2[0]}; /* outward of a counter-clockwise polygon */
        double cosine = n1[0] * n2[0] + n1[1] * n2[1];
        if (cosine > MITRE_LIMIT_COSINE) {
            double f = offset / (1 + cosine);
            out[size][0] = at[0] + f * (n1[0] + n2[0]);
            out[size][1] = at[1] + f * (n1[1] + n2[1]);
            ++size;
        } else {
            /* The bisector of a very sharp corner: outward normal of the bevel. */
            double b[2] = {e1[0] - e2[0], e1[1] - e2[1]};
            double l = hypot(b[0], b[1]);
            b[0] /= l, b[1] /= l;
            double t1 = (offset - offset * (b[0] * n1[0] + b[1] * n1[1])) / (b[0] * e1[0] + b[1] * e1[1]);
            double t2 = (offset - offset * (b[0] * n2[0] + b[1] * n2[1])) / (b[0] * e2[0] + b[1] * e2[1]);
            out[size][0] = at[0] + offset * n1[0] + t1 * e1[0], out[size][1] = at[1] + offset * n1[1] + t1 * e1[1];
            ++size;
            out[size][0] = at[0] + offset * n2[0] + t2 * e2[0], out[size][1] = at[1] + offset * n2[1] + t2 * e2[1];
            ++size;
        }
    }
    return size;
}

static uint32_t shrink(double (*hull)[2], uint32_t count, double offset, double (*out)[2], double (*other)[2]) {
    uint32_t size = count;
    for (uint32_t i = 0; i < count; ++i)
        out[i][0] = hull[i][0], out[i][1] = hull[i][1];
    for (uint32_t i = 0; i < count && size > 2; ++i) {
        const double *a = hull[i], *b = hull[(i + 1) % count];
        double n[2] = {a[1] - b[1], b[0] - a[0]}; /* inward */
        double l = hypot(n[0], n[1]);
        n[0] /= l, n[1] /= l;
        double d = n[0] * a[0] + n[1] * a[1] + offset;
        uint32_t kept = 0;
        for (uint32_t k = 0; k < size; ++k) {
            const double *p = out[k], *q = out[(k + 1) % size];
            double hp = n[0] * p[0] + n[1] * p[1] - d, hq = n[0] * q[0] + n[1] * q[1] - d;
            if (hp >= 0)
                other[kept][0] = p[0], other[kept][1] = p[1], ++kept;
            if ((hp > 0 && hq < 0) || (hp < 0 && hq > 0)) {
                double t = hp / (hp - hq);
                other[kept][0] = p[0] + t * (q[0] - p[0]), other[kept][1] = p[1] + t * (q[1] - p[1]);
                ++kept;
            }
        }
        size = kept;
        for (uint32_t k = 0; k < size; ++k)
            out[k][0] = other[k][0], out[k][1] = other[k][1];
    }
    return size > 2 ? size : 0;
}

uint32_t enf_portal_offset(const double (*points)[3], uint32_t count, const double normal[3], double plane_d, double offset,
                           double (*out)[3], double (*scratch)[2]) {
    if (count < 3)
        return 0;
    /* A frame u, v with u x v = normal: the axis least along the normal, made orthogonal. */
    double ax = fabs(normal[0]), ay = fabs(normal[1]), az = fabs(normal[2]);
    double axis[3] = {ax <= ay && ax <= az, ay < ax && ay <= az, az < ax && az < ay};
    double u[3] = {normal[1] * axis[2] - normal[2] * axis[1], normal[2] * axis[0] - normal[0] * axis[2],
                   normal[0] * axis[1] - normal[1] * axis[0]};
    double l = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int k = 0; k < 3; ++k)
        u[k] /= l;
    double v[3] = {normal[1] * u[2] - normal[2] * u[1], normal[2] * u[0] - normal[0] * u[2], normal[0] * u[1] - normal[1] * u[0]};
    /* About the first corner, so that a small portal far from the centre keeps its digits. */
    double base[3] = {points[0][0], points[0][1], points[0][2]};
    double height = normal[0] * base[0] + normal[1] * base[1] + normal[2] * base[2] - plane_d;
    for (int k = 0; k < 3; ++k)
        base[k] -= height * normal[k];
    uint32_t room = 2 * count + 2;
    double(*flat)[2] = scratch, (*hull)[2] = scratch + room, (*result)[2] = scratch + 2 * (size_t)room,
    (*other)[2] = scratch + 3 * (size_t)room;
    for (uint32_t i = 0; i < count; ++i) {
        double p[3] = {points[i][0] - base[0], points[i][1] - base[1], points[i][2] - base[2]};
        flat[i][0] = u[0] * p[0] + u[1] * p[1] + u[2] * p[2];
        flat[i][1] = v[0] * p[0] + v[1] * p[1] + v[2] * p[2];
    }
    uint32_t size = convex_hull(flat, count, hull);
    if (size < 3)
        return 0;
    if (offset > 0)
        size = enlarge(hull, size, offset, result);
    else
        size = shrink(hull, size, -offset, result, other);
    for (uint32_t i = 0; i < size; ++i)
        for (int k = 0; k < 3; ++k)
            out[i][k] = base[k] + result[i][0] * u[k] + result[i][1] * v[k];
    return size;
}
