/* SPDX-License-Identifier: GPL-3.0-or-later
 * Convex polyhedra that are cut by planes. */
#include "geometry/convex_solid.h"
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

#include <stdlib.h>

void enf_solid_free(EnfSolid *solid) {
    enf_free(solid->faces);
    enf_free(solid->indices);
    memset(solid, 0, sizeof *solid);
}

int enf_solid_add_face(EnfSolid *solid, const uint32_t *loop, uint32_t count, uint32_t plane) {
    if (!ENF_RESERVE(solid->faces, (uint64_t)solid->face_count + 1) || !ENF_RESERVE(solid->indices, (uint64_t)solid->index_count + count))
        return 0;
    solid->faces[solid->face_count++] = (EnfSolidFace){solid->index_count, count, plane};
    memcpy(solid->indices + solid->index_count, loop, count * sizeof *loop);
    solid->index_count += count;
    return 1;
}

int enf_solid_box(EnfSolid *solid, EnfVertexPool *pool, const double box[6]) {
    static const uint32_t loops[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}};
    memset(solid, 0, sizeof *solid);
    if (!ENF_RESERVE(pool->points, (uint64_t)pool->count + 8))
        return 0;
    uint32_t first = pool->count;
    for (int i = 0; i < 8; i++)
        vec_set(pool->points[pool->count++], box[i & 1 ? 3 : 0], box[i & 2 ? 4 : 1], box[i & 4 ? 5 : 2]);
    for (int f = 0; f < 6; f++) {
        uint32_t loop[4];
        for (int k = 0; k < 4; k++)
            loop[k] = first + loops[f][k];
        if (!enf_solid_add_face(solid, loop, 4, ENF_NONE))
            return 0;
    }
    return 1;
}

typedef struct Cut {
    uint32_t a, b, vertex;
} Cut;

typedef struct Rim {
    double angle;
    uint32_t vertex;
} Rim;

static int compare_rim(const void *left, const void *right) {
    const Rim *a = left, *b = right;
    if (a->angle != b->angle)
        return a->angle < b->angle ? -1 : 1;
    return a->vertex < b->vertex ? -1 : a->vertex > b->vertex;
}

/* Scratch of one cut. */
typedef struct Cutter {
    EnfVertexPool *pool;
    const double *n;
    double d, eps;
    Cut *cuts;
    uint32_t cut_count;
    uint32_t *back, *front, *rim;
    uint32_t rim_count;
} Cutter;

static double distance_of(const Cutter *c, uint32_t v) {
    return vec_dot(c->n, c->pool->points[v]) - c->d;
}

/* Both faces of an edge ask for its cut: the second gets the first one's vertex. ENF_NONE: out of memory. */
static uint32_t cut_edge(Cutter *c, uint32_t a, uint32_t b) {
    uint32_t low = a < b ? a : b, high = a < b ? b : a;
    for (uint32_t i = 0; i < c->cut_count; i++)
        if (c->cuts[i].a == low && c->cuts[i].b == high)
            return c->cuts[i].vertex;
    if (!ENF_RESERVE(c->cuts, (uint64_t)c->cut_count + 1) || !ENF_RESERVE(c->pool->points, (uint64_t)c->pool->count + 1) ||
        !ENF_RESERVE(c->rim, (uint64_t)c->rim_count + 1))
        return ENF_NONE;
    uint32_t vertex = c->pool->count++;
    enf_cut_segment(c->pool->points[vertex], c->pool->points[low], c->pool->points[high], distance_of(c, low), distance_of(c, high));
    c->cuts[c->cut_count++] = (Cut){low, high, vertex};
    c->rim[c->rim_count++] = vertex;
    return vertex;
}

static int note_rim(Cutter *c, uint32_t v) {
    for (uint32_t i = 0; i < c->rim_count; i++)
        if (c->rim[i] == v)
            return 1;
    if (!ENF_RESERVE(c->rim, (uint64_t)c->rim_count + 1))
        return 0;
    c->rim[c->rim_count++] = v;
    return 1;
}

/* The new face: all vertices on the plane in order round their middle; the solid is convex, so they are in
 * convex position. */
static int add_cap(const Cutter *c, EnfSolid *solid, uint32_t plane, int flip) {
    if (c->rim_count < 3)
        return 1;
    Rim *rim = ENF_NEW(Rim, c->rim_count);
    uint32_t *loop = ENF_NEW(uint32_t, c->rim_count);
    int ok = rim && loop;
    if (ok) {
        double u[3], v[3], middle[3] = {0, 0, 0}, local[3];
        enf_plane_axes(c->n, u, v);
        for (uint32_t i = 0; i < c->rim_count; i++)
            vec_mad(middle, middle, 1.0 / c->rim_count, c->pool->points[c->rim[i]]);
        for (uint32_t i = 0; i < c->rim_count; i++) {
            vec_sub(local, c->pool->points[c->rim[i]], middle);
            rim[i] = (Rim){atan2(vec_dot(local, v), vec_dot(local, u)), c->rim[i]};
        }
        qsort(rim, c->rim_count, sizeof *rim, compare_rim);
        for (uint32_t i = 0; i < c->rim_count; i++)
            loop[i] = rim[flip ? c->rim_count - 1 - i : i].vertex;
        ok = enf_solid_add_face(solid, loop, c->rim_count, plane);
    }
    enf_free(rim);
    enf_free(loop);
    return ok;
}

static int cut_faces(Cutter *c, const EnfSolid *solid, EnfSolid *back, EnfSolid *front) {
    for (uint32_t f = 0; f < solid->face_count; f++) {
        const EnfSolidFace *face = &solid->faces[f];
        const uint32_t *loop = solid->indices + face->first;
        uint32_t b = 0, n = 0;
        int any_back = 0, any_front = 0;
        if (!ENF_RESERVE(c->back, 2 * (uint64_t)face->count) || !ENF_RESERVE(c->front, 2 * (uint64_t)face->count))
            return 0;
        for (uint32_t i = 0; i < face->count; i++) {
            uint32_t p = loop[i], q = loop[i + 1 < face->count ? i + 1 : 0];
            double dp = distance_of(c, p), dq = distance_of(c, q);
            any_back |= dp < -c->eps;
            any_front |= dp > c->eps;
            if (dp <= c->eps)
                c->back[b++] = p;
            if (dp >= -c->eps)
                c->front[n++] = p;
            if (dp <= c->eps && dp >= -c->eps && !note_rim(c, p))
                return 0;
            if ((dp > c->eps && dq < -c->eps) || (dp < -c->eps && dq > c->eps)) {
                uint32_t cut = cut_edge(c, p, q);
                if (cut == ENF_NONE)
                    return 0;
                c->back[b++] = cut;
                c->front[n++] = cut;
            }
        }
        if (any_back && b >= 3 && !enf_solid_add_face(back, c->back, b, face->plane))
            return 0;
        if (any_front && n >= 3 && !enf_solid_add_face(front, c->front, n, face->plane))
            return 0;
    }
    return 1;
}

static int copy_solid(EnfSolid *to, const EnfSolid *from) {
    for (uint32_t f = 0; f < from->face_count; f++)
        if (!enf_solid_add_face(to, from->indices + from->faces[f].first, from->faces[f].count, from->faces[f].plane))
            return 0;
    return 1;
}

int enf_solid_cut(const EnfSolid *solid, EnfVertexPool *pool, uint32_t p, const double n[3], double d, double eps, EnfSolid *back,
                  EnfSolid *front) {
    Cutter cutter = {pool, n, d, eps, NULL, 0, NULL, NULL, NULL, 0}, *c = &cutter;
    memset(back, 0, sizeof *back);
    memset(front, 0, sizeof *front);
    int any_back = 0, any_front = 0, ok = 1;
    for (uint32_t i = 0; i < solid->index_count; i++) {
        double distance = distance_of(c, solid->indices[i]);
        any_back |= distance < -eps;
        any_front |= distance > eps;
    }
    if (!any_front)
        ok = copy_solid(back, solid);
    else if (!any_back)
        ok = copy_solid(front, solid);
    else
        ok = cut_faces(c, solid, back, front) && add_cap(c, back, 2 * p, 0) && add_cap(c, front, 2 * p + 1, 1);
    enf_free(c->cuts);
    enf_free(c->back);
    enf_free(c->front);
    enf_free(c->rim);
    if (!ok) {
        enf_solid_free(back);
        enf_solid_free(front);
    }
    return ok;
}

double enf_solid_volume(const EnfSolid *solid, const EnfVertexPool *pool) {
    if (!solid->index_count)
        return 0.0;
    const double *origin = pool->points[solid->indices[0]];
    double sum = 0.0;
    for (uint32_t f = 0; f < solid->face_count; f++) {
        const uint32_t *loop = solid->indices + solid->faces[f].first;
        double a[3], b[3], c[3], cross[3];
        vec_sub(a, pool->points[loop[0]], origin);
        for (uint32_t i = 1; i + 1 < solid->faces[f].count; i++) {
            vec_sub(b, pool->points[loop[i]], origin);
            vec_sub(c, pool->points[loop[i + 1]], origin);
            vec_cross(cross, b, c);
            sum += vec_dot(a, cross);
        }
    }
    return sum / 6.0;
}

void enf_solid_bounds(const EnfSolid *solid, const EnfVertexPool *pool, double box[6]) {
    box_empty(box);
    for (uint32_t i = 0; i < solid->index_count; i++)
        box_add_point(box, pool->points[solid->indices[i]]);
}

void enf_solid_centre(const EnfSolid *solid, const EnfVertexPool *pool, double centre[3]) {
    vec_set(centre, 0.0, 0.0, 0.0);
    for (uint32_t i = 0; i < solid->index_count; i++)
        vec_mad(centre, centre, 1.0 / solid->index_count, pool->points[solid->indices[i]]);
}
