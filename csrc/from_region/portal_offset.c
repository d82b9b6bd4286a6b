/* SPDX-License-Identifier: GPL-3.0-or-later
 * Portals enlarged and shrunk in their plane, so that geometry that touches becomes geometry that clearly does or doesn't.
 *
 * Safe direction: the enlarged polygon contains every point of the plane within `offset` of the portal (mitred, sharp
 * corners bevelled outside the rounded one); the shrunk one contains no point within `offset` of an edge. */
#include "from_region/region_model.h"

#include <math.h>
#include <string.h>

/* A mitre longer than twice the offset is cut by a bevel at the offset's distance from the corner. */
#define MITRE_LIMIT_COSINE (-0.5)

static uint32_t enlarge(const EnfFlatPoint *hull, uint32_t count, double offset, EnfFlatPoint *out) {
    uint32_t size = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const EnfFlatPoint *before = &hull[(i + count - 1) % count], *at = &hull[i], *after = &hull[(i + 1) % count];
        double e1[2] = {at->x - before->x, at->y - before->y}, e2[2] = {after->x - at->x, after->y - at->y};
        double l1 = hypot(e1[0], e1[1]), l2 = hypot(e2[0], e2[1]);
        e1[0] /= l1, e1[1] /= l1, e2[0] /= l2, e2[1] /= l2;
        double n1[2] = {e1[1], -e1[0]}, n2[2] = {e2[1], -e2[0]}; /* outward of a counter-clockwise polygon */
        double cosine = n1[0] * n2[0] + n1[1] * n2[1];
        if (cosine > MITRE_LIMIT_COSINE) {
            double f = offset / (1 + cosine);
            out[size++] = (EnfFlatPoint){at->x + f * (n1[0] + n2[0]), at->y + f * (n1[1] + n2[1]), i};
        } else {
            /* The bisector of a very sharp corner: outward normal of the bevel. */
            double b[2] = {e1[0] - e2[0], e1[1] - e2[1]};
            double l = hypot(b[0], b[1]);
            b[0] /= l, b[1] /= l;
            double t1 = (offset - offset * (b[0] * n1[0] + b[1] * n1[1])) / (b[0] * e1[0] + b[1] * e1[1]);
            double t2 = (offset - offset * (b[0] * n2[0] + b[1] * n2[1])) / (b[0] * e2[0] + b[1] * e2[1]);
            out[size++] = (EnfFlatPoint){at->x + offset * n1[0] + t1 * e1[0], at->y + offset * n1[1] + t1 * e1[1], i};
            out[size++] = (EnfFlatPoint){at->x + offset * n2[0] + t2 * e2[0], at->y + offset * n2[1] + t2 * e2[1], i};
        }
    }
    return size;
}

static uint32_t shrink(const EnfFlatPoint *hull, uint32_t count, double offset, EnfFlatPoint *out, EnfFlatPoint *other) {
    uint32_t size = count;
    memcpy(out, hull, count * sizeof *out);
    for (uint32_t i = 0; i < count && size > 2; ++i) {
        const EnfFlatPoint *a = &hull[i], *b = &hull[(i + 1) % count];
        double n[2] = {a->y - b->y, b->x - a->x}; /* inward */
        double l = hypot(n[0], n[1]);
        n[0] /= l, n[1] /= l;
        double d = n[0] * a->x + n[1] * a->y + offset;
        uint32_t kept = 0;
        for (uint32_t k = 0; k < size; ++k) {
            const EnfFlatPoint *p = &out[k], *q = &out[(k + 1) % size];
            double hp = n[0] * p->x + n[1] * p->y - d, hq = n[0] * q->x + n[1] * q->y - d;
            if (hp >= 0)
                other[kept++] = *p;
            if ((hp > 0 && hq < 0) || (hp < 0 && hq > 0)) {
                double t = hp / (hp - hq);
                other[kept++] = (EnfFlatPoint){p->x + t * (q->x - p->x), p->y + t * (q->y - p->y), i};
            }
        }
        size = kept;
        memcpy(out, other, size * sizeof *out);
    }
    return size > 2 ? size : 0;
}

uint32_t enf_portal_offset(const double (*points)[3], uint32_t count, const double normal[3], double plane_d, double offset,
                           double (*out)[3], EnfFlatPoint *scratch) {
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
    EnfFlatPoint *flat = scratch, *hull = flat + room, *result = hull + room, *other = result + room;
    for (uint32_t i = 0; i < count; ++i) {
        double p[3] = {points[i][0] - base[0], points[i][1] - base[1], points[i][2] - base[2]};
        flat[i] = (EnfFlatPoint){u[0] * p[0] + u[1] * p[1] + u[2] * p[2], v[0] * p[0] + v[1] * p[1] + v[2] * p[2], i};
    }
    uint32_t size = enf_flat_hull(flat, count, hull);
    if (size < 3)
        return 0;
    if (offset > 0)
        size = enlarge(hull, size, offset, result);
    else
        size = shrink(hull, size, -offset, result, other);
    for (uint32_t i = 0; i < size; ++i)
        for (int k = 0; k < 3; ++k)
            out[i][k] = base[k] + result[i].x * u[k] + result[i].y * v[k];
    return size;
}
