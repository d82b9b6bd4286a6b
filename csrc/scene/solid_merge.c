/* SPDX-License-Identifier: GPL-3.0-or-later
 * Joining convex pieces whose union is convex.
 *
 * A and B lie on two sides of one plane. If every corner of B lies behind all other planes of A, and the
 * other way round, both are the parts of one convex body that the plane cuts: A = P and behind, B = P and in
 * front, with P the common half-spaces. */
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/solid_bsp.h"

#include <stdlib.h>

typedef struct Facet {
    uint32_t code, solid, face;
} Facet;

typedef struct Pair {
    uint32_t a, b, plane;
    double area;
} Pair;

static int compare_facets(const void *left, const void *right) {
    const Facet *a = left, *b = right;
    if (a->code != b->code)
        return a->code < b->code ? -1 : 1;
    return a->solid < b->solid ? -1 : a->solid > b->solid;
}

static int compare_pairs(const void *left, const void *right) {
    const Pair *a = left, *b = right;
    if (a->area != b->area)
        return a->area > b->area ? -1 : 1;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return a->b < b->b ? -1 : a->b > b->b;
}

/* Whether all corners of b lie behind every face of a but those in `code`. */
static int fits(const EnfShape *s, const EnfSolid *a, uint32_t code, const EnfSolid *b) {
    for (uint32_t f = 0; f < a->face_count; f++) {
        if (a->faces[f].plane == code)
            continue;
        if (a->faces[f].plane == ENF_NONE)
            return 0;
        const EnfShapePlane *plane = &s->planes[a->faces[f].plane / 2];
        double sign = a->faces[f].plane & 1 ? -1.0 : 1.0;
        for (uint32_t i = 0; i < b->index_count; i++)
            if (sign * (vec_dot(plane->n, s->pool.points[b->indices[i]]) - plane->d) > s->eps)
                return 0;
    }
    return 1;
}

static double face_area(const EnfShape *s, const EnfSolid *solid, uint32_t face) {
    const EnfSolidFace *f = &solid->faces[face];
    const uint32_t *loop = solid->indices + f->first;
    double a[3], b[3], c[3], sum[3] = {0, 0, 0};
    for (uint32_t i = 1; i + 1 < f->count; i++) {
        vec_sub(a, s->pool.points[loop[i]], s->pool.points[loop[0]]);
        vec_sub(b, s->pool.points[loop[i + 1]], s->pool.points[loop[0]]);
        vec_cross(c, a, b);
        vec_add(sum, sum, c);
    }
    return 0.5 * vec_length(sum);
}

/* One face from all faces of a and b in one plane. */
static int merge_face(const EnfShape *s, EnfSolid *out, uint32_t code, const EnfSolid *a, const EnfSolid *b) {
    const EnfSolid *both[2] = {a, b};
    uint32_t *ids = NULL, *hull = NULL, *loop = NULL, count = 0;
    double(*points)[3] = NULL, n[3];
    int ok = 1;
    vec_scale(n, code & 1 ? -1.0 : 1.0, s->planes[code / 2].n);
    for (int k = 0; k < 2 && ok; k++)
        for (uint32_t f = 0; f < both[k]->face_count && ok; f++)
            if (both[k]->faces[f].plane == code)
                for (uint32_t i = 0; i < both[k]->faces[f].count && ok; i++) {
                    uint32_t id = both[k]->indices[both[k]->faces[f].first + i], known = 0;
                    for (uint32_t j = 0; j < count; j++)
                        known |= ids[j] == id;
                    if (known)
                        continue;
                    ok = ENF_RESERVE(ids, (uint64_t)count + 1) && ENF_RESERVE(points, (uint64_t)count + 1);
                    if (ok) {
                        ids[count] = id;
                        vec_copy(points[count++], s->pool.points[id]);
                    }
                }
    ok = ok && ENF_RESERVE(hull, count) && ENF_RESERVE(loop, count);
    if (ok) {
        uint32_t size = enf_planar_hull(points, count, n, 0.0, hull);
        for (uint32_t i = 0; i < size; i++)
            loop[i] = ids[hull[i]];
        if (size >= 3)
            ok = enf_solid_add_face(out, loop, size, code);
    }
    enf_free(ids);
    enf_free(hull);
    enf_free(loop);
    enf_free(points);
    return ok;
}

/* 1: *a is both and *b is empty; 0: out of memory; -1: the union isn't what it should be, nothing is changed.
 * Corners may be off their planes by eps, and over thin slivers that adds up: the volume has the last word.
 */
static int merge_pair(const EnfShape *s, EnfSolid *a, EnfSolid *b, uint32_t plane) {
    EnfSolid merged = {0};
    const EnfSolid *both[2] = {a, b};
    int ok = 1;
    for (int k = 0; k < 2 && ok; k++)
        for (uint32_t f = 0; f < both[k]->face_count && ok; f++) {
            uint32_t code = both[k]->faces[f].plane, known = code == 2 * plane + (uint32_t)k;
            for (uint32_t j = 0; j < merged.face_count; j++)
                known |= merged.faces[j].plane == code;
            if (!known)
                ok = merge_face(s, &merged, code, a, b);
        }
    if (ok) {
        double box[6], before = enf_solid_volume(a, &s->pool) + enf_solid_volume(b, &s->pool);
        enf_solid_bounds(&merged, &s->pool, box);
        double change = fabs(enf_solid_volume(&merged, &s->pool) - before);
        if (change > 2.0 * s->eps * box_half_area(box) + 1e-9 * before) {
            enf_solid_free(&merged);
            return -1;
        }
    }
    if (!ok) {
        enf_solid_free(&merged);
        return 0;
    }
    enf_solid_free(a);
    enf_solid_free(b);
    *a = merged;
    return 1;
}

static int find_pairs(const EnfShape *s, const EnfSolidList *list, Pair **out, uint32_t *out_count) {
    Facet *facets = NULL;
    Pair *pairs = NULL;
    double(*boxes)[6] = enf_alloc_array(list->count, sizeof *boxes);
    uint32_t facet_count = 0, pair_count = 0;
    int ok = boxes != NULL;
    for (uint32_t i = 0; i < list->count && ok; i++) {
        enf_solid_bounds(&list->items[i], &s->pool, boxes[i]);
        box_grow(boxes[i], s->eps);
        for (uint32_t f = 0; f < list->items[i].face_count && ok; f++)
            if (list->items[i].faces[f].plane != ENF_NONE) {
                ok = ENF_RESERVE(facets, (uint64_t)facet_count + 1);
                if (ok)
                    facets[facet_count++] = (Facet){list->items[i].faces[f].plane, i, f};
            }
    }
    if (ok && facet_count)
        qsort(facets, facet_count, sizeof *facets, compare_facets);
    for (uint32_t low = 0; ok && low < facet_count;) {
        uint32_t plane = facets[low].code / 2, middle = low, high;
        while (middle < facet_count && facets[middle].code == 2 * plane)
            middle++;
        for (high = middle; high < facet_count && facets[high].code == 2 * plane + 1;)
            high++;
        for (uint32_t i = low; i < middle && ok; i++)
            for (uint32_t j = middle; j < high && ok; j++) {
                uint32_t a = facets[i].solid, b = facets[j].solid;
                if (a == b || !box_touches_box(boxes[a], boxes[b]) || !fits(s, &list->items[a], 2 * plane, &list->items[b]) ||
                    !fits(s, &list->items[b], 2 * plane + 1, &list->items[a]))
                    continue;
                ok = ENF_RESERVE(pairs, (uint64_t)pair_count + 1);
                if (ok)
                    pairs[pair_count++] = (Pair){a, b, plane, face_area(s, &list->items[a], facets[i].face)};
            }
        low = high;
    }
    enf_free(facets);
    enf_free(boxes);
    *out = pairs;
    *out_count = pair_count;
    return ok;
}

int enf_solids_merge(EnfShape *shape, EnfSolidList *list) {
    for (;;) {
        Pair *pairs = NULL;
        uint32_t count = 0, done = 0;
        unsigned char *touched = ENF_NEW(unsigned char, list->count);
        int ok = touched && find_pairs(shape, list, &pairs, &count);
        if (ok && count)
            qsort(pairs, count, sizeof *pairs, compare_pairs);
        for (uint32_t i = 0; i < count && ok; i++) {
            if (touched[pairs[i].a] || touched[pairs[i].b])
                continue;
            int merged = merge_pair(shape, &list->items[pairs[i].a], &list->items[pairs[i].b], pairs[i].plane);
            ok = merged != 0;
            if (merged > 0) {
                touched[pairs[i].a] = touched[pairs[i].b] = 1;
                done++;
            }
        }
        enf_free(pairs);
        enf_free(touched);
        if (!ok)
            return 0;
        if (done == 0)
            return 1;
        uint32_t kept = 0;
        for (uint32_t i = 0; i < list->count; i++)
            if (list->items[i].face_count)
                list->items[kept++] = list->items[i];
        list->count = kept;
    }
}
