/* SPDX-License-Identifier: GPL-3.0-or-later
 * Planar polygons in space. */
#include "geometry/polygon.h"
#include "base/memory.h"
#include "geometry/vec3.h"

#include <stdlib.h>
#include <string.h>

double enf_polygon_normal(double normal[3], double (*points)[3], uint32_t count) {
    double a[3], b[3], c[3], sum[3] = {0, 0, 0};
    vec_set(a, 0.0, 0.0, 0.0);
    for (uint32_t i = 1; i < count; i++) {
        vec_sub(b, points[i], points[0]);
        vec_cross(c, a, b);
        vec_add(sum, sum, c);
        vec_copy(a, b);
    }
    vec_copy(normal, sum);
    return 0.5 * vec_normalize(normal);
}

void enf_polygon_centroid(double centroid[3], double (*points)[3], uint32_t count) {
    double normal[3], a[3], b[3], c[3], sum[3] = {0, 0, 0}, weight = 0.0;
    double area = enf_polygon_normal(normal, points, count);
    for (uint32_t i = 1; i + 1 < count && area > 0.0; i++) {
        vec_sub(a, points[i], points[0]);
        vec_sub(b, points[i + 1], points[0]);
        vec_cross(c, a, b);
        double w = vec_dot(c, normal);
        vec_add(a, a, b);
        vec_mad(sum, sum, w / 3.0, a);
        weight += w;
    }
    if (weight > 0.0) {
        vec_mad(centroid, points[0], 1.0 / weight, sum);
        return;
    }
    vec_set(sum, 0.0, 0.0, 0.0);
    for (uint32_t i = 0; i < count; i++) {
        vec_sub(a, points[i], points[0]);
        vec_mad(sum, sum, 1.0 / count, a);
    }
    if (count)
        vec_add(centroid, points[0], sum);
}

void enf_cut_segment(double out[3], const double a[3], const double b[3], double distance_a, double distance_b) {
    int swap = 0;
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k]) {
            swap = a[k] > b[k];
            break;
        }
    if (swap) {
        const double *t = a;
        a = b;
        b = t;
        double s = distance_a;
        distance_a = distance_b;
        distance_b = s;
    }
    double t = distance_a / (distance_a - distance_b);
    for (int k = 0; k < 3; k++)
        out[k] = a[k] == b[k] ? a[k] : a[k] + t * (b[k] - a[k]); /* axis-parallel edges stay so exactly */
}

void enf_polygon_split(double (*points)[3], uint32_t count, const double n[3], double d, double eps, double (*back)[3],
                       uint32_t *back_count, double (*front)[3], uint32_t *front_count) {
    uint32_t b = 0, f = 0;
    int any_back = 0, any_front = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double *p = points[i], *q = points[i + 1 < count ? i + 1 : 0];
        double dp = vec_dot(n, p) - d, dq = vec_dot(n, q) - d;
        if (dp < -eps)
            any_back = 1;
        if (dp > eps)
            any_front = 1;
        if (dp <= eps) {
            if (back)
                vec_copy(back[b], p);
            b++;
        }
        if (dp >= -eps) {
            if (front)
                vec_copy(front[f], p);
            f++;
        }
        if ((dp > eps && dq < -eps) || (dp < -eps && dq > eps)) {
            double cut[3];
            enf_cut_segment(cut, p, q, dp, dq);
            if (back)
                vec_copy(back[b], cut);
            if (front)
                vec_copy(front[f], cut);
            b++;
            f++;
        }
    }
    *back_count = any_back ? b : 0;
    *front_count = any_front ? f : 0;
}

void enf_plane_axes(const double n[3], double u[3], double v[3]) {
    double x = fabs(n[0]), y = fabs(n[1]), z = fabs(n[2]), axis[3] = {0, 0, 0};
    axis[x <= y && x <= z ? 0 : y <= z ? 1 : 2] = 1.0;
    vec_cross(u, axis, n);
    vec_normalize(u);
    vec_cross(v, n, u);
}

static int compare_flat(const void *left, const void *right) {
    const EnfFlatPoint *a = left, *b = right;
    if (a->x != b->x)
        return a->x < b->x ? -1 : 1;
    if (a->y != b->y)
        return a->y < b->y ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

static EnfFlatPoint *flatten(double (*points)[3], uint32_t count, const double n[3]) {
    EnfFlatPoint *flat = ENF_NEW(EnfFlatPoint, count);
    double u[3], v[3], local[3];
    enf_plane_axes(n, u, v);
    for (uint32_t i = 0; flat && i < count; i++) {
        vec_sub(local, points[i], points[0]);
        flat[i] = (EnfFlatPoint){vec_dot(local, u), vec_dot(local, v), i};
    }
    return flat;
}

static double turn(const EnfFlatPoint *a, const EnfFlatPoint *b, const EnfFlatPoint *c) {
    return (b->x - a->x) * (c->y - b->y) - (b->y - a->y) * (c->x - b->x);
}

/* Signed distance of b from the line a-c, positive when a, b, c turn left. */
static double bulge(const EnfFlatPoint *a, const EnfFlatPoint *b, const EnfFlatPoint *c) {
    double length = hypot(c->x - a->x, c->y - a->y);
    return length > 0.0 ? turn(a, b, c) / length : hypot(b->x - a->x, b->y - a->y);
}

uint32_t enf_flat_hull(EnfFlatPoint *points, uint32_t count, EnfFlatPoint *hull) {
    if (count > 16)
        qsort(points, count, sizeof *points, compare_flat);
    else
        for (uint32_t i = 1; i < count; i++) { /* the few corners a portal has */
            EnfFlatPoint point = points[i];
            uint32_t k = i;
            for (; k > 0 && compare_flat(&points[k - 1], &point) > 0; k--)
                points[k] = points[k - 1];
            points[k] = point;
        }
    uint32_t size = 0;
    for (uint32_t i = 0; i < count; i++) {
        while (size >= 2 && turn(&hull[size - 2], &hull[size - 1], &points[i]) <= 0.0)
            size--;
        hull[size++] = points[i];
    }
    uint32_t lower = size + 1;
    for (uint32_t i = count - 1; i-- > 0;) {
        while (size >= lower && turn(&hull[size - 2], &hull[size - 1], &points[i]) <= 0.0)
            size--;
        hull[size++] = points[i];
    }
    return size > 1 ? size - 1 : size;
}

/* The hull, then corners that stick out by no more than eps are dropped. */
uint32_t enf_planar_hull(double (*points)[3], uint32_t count, const double n[3], double eps, uint32_t *hull) {
    if (count == 0)
        return 0;
    EnfFlatPoint *flat = flatten(points, count, n);
    EnfFlatPoint *chain = ENF_NEW(EnfFlatPoint, (uint64_t)count + 1);
    if (!flat || !chain) {
        enf_free(flat);
        enf_free(chain);
        return 0;
    }
    uint32_t size = enf_flat_hull(flat, count, chain);
    for (uint32_t i = 0; i < size && size > 2;) {
        if (bulge(&chain[(i + size - 1) % size], &chain[i], &chain[(i + 1) % size]) <= eps) {
            memmove(&chain[i], &chain[i + 1], (size - i - 1) * sizeof *chain);
            size--;
            i = i ? i - 1 : 0;
        } else
            i++;
    }
    for (uint32_t i = 0; i < size; i++)
        hull[i] = chain[i].index;
    enf_free(flat);
    enf_free(chain);
    return size;
}

int enf_polygon_is_convex(double (*points)[3], uint32_t count, const double n[3], double eps) {
    EnfFlatPoint *flat = flatten(points, count, n);
    if (!flat)
        return 0;
    int convex = 1;
    double total = 0.0;
    for (uint32_t i = 0; i < count && convex; i++) {
        const EnfFlatPoint *a = &flat[i], *b = &flat[(i + 1) % count], *c = &flat[(i + 2) % count];
        if (bulge(a, b, c) < -eps)
            convex = 0;
        double x = b->x - a->x, y = b->y - a->y, X = c->x - b->x, Y = c->y - b->y;
        total += atan2(x * Y - y * X, x * X + y * Y);
    }
    enf_free(flat);
    /* Left turns of one round sum to 2 pi; stars that go round twice have no right turn either. */
    return convex && fabs(total - 6.283185307179586) < 1.0;
}

static int inside_triangle(const EnfFlatPoint *a, const EnfFlatPoint *b, const EnfFlatPoint *c, const EnfFlatPoint *p) {
    /* On the two edges a corner does no harm; on the new diagonal it does. */
    return turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0 && turn(c, a, p) >= 0.0;
}

/* Corners of a ring before and after the i-th. */
static const EnfFlatPoint *before(const EnfFlatPoint *ring, uint32_t count, uint32_t i) {
    return &ring[(i + count - 1) % count];
}
static const EnfFlatPoint *after(const EnfFlatPoint *ring, uint32_t count, uint32_t i) {
    return &ring[(i + 1) % count];
}

static int same_place(const EnfFlatPoint *a, const EnfFlatPoint *b) {
    return a->x == b->x && a->y == b->y;
}

/* Whether no other corner lies in the ear at i. */
static int is_clear(const EnfFlatPoint *ring, uint32_t count, uint32_t i) {
    const EnfFlatPoint *a = before(ring, count, i), *b = &ring[i], *c = after(ring, count, i);
    for (uint32_t j = 0; j < count; j++) {
        const EnfFlatPoint *p = &ring[j];
        if (!same_place(p, a) && !same_place(p, b) && !same_place(p, c) && inside_triangle(a, b, c, p))
            return 0;
    }
    return 1;
}

/* The fattest ear, by its area over its longest edge squared: keeps slivers away. In polygons of hundreds of corners the first one found:
 * cubic otherwise. ENF_NONE: no ear is proper. */
static uint32_t find_ear(const EnfFlatPoint *ring, uint32_t count) {
    uint32_t best = ENF_NONE;
    double best_shape = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const EnfFlatPoint *a = before(ring, count, i), *b = &ring[i], *c = after(ring, count, i);
        double area = turn(a, b, c);
        if (area <= 0.0)
            continue;
        double x = c->x - a->x, y = c->y - a->y, longest = x * x + y * y;
        longest = fmax(longest, (b->x - a->x) * (b->x - a->x) + (b->y - a->y) * (b->y - a->y));
        longest = fmax(longest, (c->x - b->x) * (c->x - b->x) + (c->y - b->y) * (c->y - b->y));
        if (area / longest <= best_shape || !is_clear(ring, count, i))
            continue;
        best = i;
        best_shape = area / longest;
        if (count > 256)
            break;
    }
    return best;
}

/* Where no ear has area: a corner on a line (to be dropped), or one of a crossing polygon (to be cut anyway). */
static uint32_t flattest_corner(const EnfFlatPoint *ring, uint32_t count) {
    uint32_t best = 1;
    double least = INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        double area = fabs(turn(before(ring, count, i), &ring[i], after(ring, count, i)));
        if (area < least) {
            least = area;
            best = i;
        }
    }
    return best;
}

uint32_t enf_polygon_triangulate(double (*points)[3], uint32_t count, const double n[3], uint32_t (*triangles)[3]) {
    if (count < 3)
        return 0;
    EnfFlatPoint *ring = flatten(points, count, n);
    if (!ring)
        return 0;
    uint32_t made = 0, left = count;
    int fan = count > 4 && enf_polygon_is_convex(points, count, n, 0.0);
    for (; left >= 3; left--) {
        uint32_t at = fan || left == 3 ? 1 : find_ear(ring, left);
        if (at == ENF_NONE)
            at = flattest_corner(ring, left);
        triangles[made][0] = before(ring, left, at)->index;
        triangles[made][1] = ring[at].index;
        triangles[made++][2] = after(ring, left, at)->index;
        memmove(&ring[at], &ring[at + 1], (left - at - 1) * sizeof *ring);
    }
    enf_free(ring);
    return made;
}
