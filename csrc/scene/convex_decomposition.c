/* SPDX-License-Identifier: GPL-3.0-or-later
 * A room's shape cut into convex cells and seams: partition (solid_bsp.c), merge (solid_merge.c), weld and
 * clean, seams (room_seams.c). Whatever goes wrong ends in the convex hull as one cell, which is larger than
 * the room: safe, and counted. */
#include "scene/convex_decomposition.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/convex_hull.h"
#include "geometry/sort_keys.h"
#include "geometry/vec3.h"
#include "scene/curved_walls.h"

#include <stdlib.h>

void enf_decomposition_free(EnfDecomposition *d) {
    enf_free(d->cell_point_first);
    enf_free(d->cell_face_first);
    enf_free(d->face_sizes);
    enf_free(d->face_indices);
    enf_free(d->points);
    enf_free(d->seams);
    enf_free(d->seam_points);
    memset(d, 0, sizeof *d);
}

typedef struct Output {
    EnfDecomposition *d;
    uint32_t point_count, face_count, index_count;
} Output;

static int begin_output(Output *out) {
    EnfDecomposition *d = out->d;
    out->point_count = out->face_count = out->index_count = 0;
    d->cell_count = 0;
    if (!ENF_RESERVE(d->cell_point_first, 1) || !ENF_RESERVE(d->cell_face_first, 1))
        return 0;
    d->cell_point_first[0] = d->cell_face_first[0] = 0;
    return 1;
}

static int end_cell(Output *out) {
    EnfDecomposition *d = out->d;
    d->cell_count++;
    if (!ENF_RESERVE(d->cell_point_first, (uint64_t)d->cell_count + 1) || !ENF_RESERVE(d->cell_face_first, (uint64_t)d->cell_count + 1))
        return 0;
    d->cell_point_first[d->cell_count] = out->point_count;
    d->cell_face_first[d->cell_count] = out->face_count;
    return 1;
}

/* The hull of everything given, as one cell without faces: commit builds them. */
static int give_hull(EnfDecomposition *d, double (*vertices)[3], uint32_t count) {
    Output out = {d, 0, 0, 0};
    d->seam_count = 0;
    d->volume = 0.0;
    if (!begin_output(&out) || !ENF_RESERVE(d->points, count))
        return 0;
    memcpy(d->points, vertices, count * sizeof *vertices);
    out.point_count = count;
    return end_cell(&out);
}

/* representative[v]: the corner that stands for pool vertex v, a given one where there is one within eps.
 * Only vertices that some solid uses are looked at. */
static int weld_pool(const EnfShape *s, const EnfSolidList *solids, uint32_t *representative) {
    uint32_t n = s->pool.count, used = 0;
    Ordered *order = ENF_NEW(Ordered, n);
    unsigned char *is_used = ENF_NEW(unsigned char, n);
    int ok = order && is_used;
    for (uint32_t c = 0; c < solids->count && ok; c++)
        for (uint32_t i = 0; i < solids->items[c].index_count; i++)
            is_used[solids->items[c].indices[i]] = 1;
    for (uint32_t i = 0; i < n && ok; i++) {
        representative[i] = i;
        if (is_used[i] || i < s->given_count)
            order[used++] = (Ordered){s->pool.points[i][0], i};
    }
    if (ok) {
        qsort(order, used, sizeof *order, compare_ordered);
        for (uint32_t i = 0; i < used; i++)
            for (uint32_t j = i + 1; j < used && order[j].x - order[i].x <= s->eps; j++) {
                uint32_t a = order[i].index, b = order[j].index;
                if (representative[a] != representative[b] && vec_distance(s->pool.points[a], s->pool.points[b]) <= s->eps) {
                    uint32_t low = representative[a] < representative[b] ? representative[a] : representative[b];
                    representative[a] = representative[b] = low;
                }
            }
        for (uint32_t i = 0; i < n; i++)
            while (representative[i] != representative[representative[i]])
                representative[i] = representative[representative[i]];
    }
    enf_free(order);
    enf_free(is_used);
    return ok;
}

/* Each edge of the loops runs once in either direction. -1: no memory. */
static int is_closed(const uint32_t *sizes, uint32_t faces, const uint32_t *indices, uint32_t index_count) {
    Pair *pairs = ENF_NEW(Pair, index_count);
    if (!pairs)
        return -1;
    uint32_t n = 0;
    int closed = faces >= 4;
    for (uint32_t f = 0; f < faces; indices += sizes[f++])
        for (uint32_t i = 0; i < sizes[f]; i++)
            pairs[n++] = (Pair){indices[i], indices[(i + 1) % sizes[f]]};
    qsort(pairs, n, sizeof *pairs, compare_pairs);
    for (uint32_t i = 0; i < n && closed; i++) {
        Pair back = {pairs[i].to, pairs[i].from};
        closed = (i == 0 || compare_pairs(&pairs[i], &pairs[i - 1]) != 0) && bsearch(&back, pairs, n, sizeof *pairs, compare_pairs);
    }
    enf_free(pairs);
    return closed;
}

/* Scratch of writing cells. */
typedef struct Cleaner {
    uint32_t *sizes, *indices; /* the cell's loops in representatives */
    uint32_t *corners;         /* sorted */
    uint32_t *count_of;        /* [pool] in how many loops a vertex stands; zero between uses */
    double (*points)[3];
} Cleaner;

/* Maps a solid's loops to representatives and drops what is no corner: repeated vertices, and those that
 * stand in fewer than three loops (a neighbour's corner in the middle of an edge). Gives the number of faces;
 * *out_indices their length. */
static int clean_loops(Cleaner *k, const EnfSolid *solid, const uint32_t *representative, uint32_t *out_faces, uint32_t *out_indices) {
    uint32_t faces = 0, at = 0;
    if (!ENF_RESERVE(k->sizes, solid->face_count) || !ENF_RESERVE(k->indices, solid->index_count))
        return 0;
    for (int pass = 0; pass < 2; pass++) {
        uint32_t read_faces = pass ? faces : solid->face_count, read = 0, write = 0, kept = 0;
        for (uint32_t f = 0; f < read_faces; f++) {
            uint32_t size = pass ? k->sizes[f] : solid->faces[f].count, begin = write;
            for (uint32_t i = 0; i < size; i++) {
                uint32_t v = pass ? k->indices[read + i] : representative[solid->indices[solid->faces[f].first + i]];
                if ((pass && k->count_of[v] < 3) || (write > begin && k->indices[write - 1] == v))
                    continue;
                k->indices[write++] = v;
            }
            read += size;
            while (write - begin > 1 && k->indices[begin] == k->indices[write - 1])
                write--;
            if (write - begin < 3)
                write = begin;
            else
                k->sizes[kept++] = write - begin;
        }
        faces = kept;
        at = write;
        if (pass == 0)
            for (uint32_t i = 0; i < at; i++)
                k->count_of[k->indices[i]]++;
    }
    /* Back to zero: every vertex of the solid, dropped ones too. */
    for (uint32_t i = 0; i < solid->index_count; i++)
        k->count_of[representative[solid->indices[i]]] = 0;
    *out_faces = faces;
    *out_indices = at;
    return 1;
}

/* Writes one cell. Where cleaning left a hole (slivers at rounding level), the hull of its corners is the
 * cell. */
static int write_cell(Output *out, Cleaner *k, const EnfShape *s, const EnfSolid *solid, const uint32_t *representative,
                      double (*world)[3]) {
    EnfDecomposition *d = out->d;
    uint32_t faces, count, corners = 0;
    if (!clean_loops(k, solid, representative, &faces, &count))
        return 0;
    int closed = is_closed(k->sizes, faces, k->indices, count);
    if (closed < 0)
        return 0;
    const uint32_t *source = k->indices;
    uint32_t source_count = count;
    if (!closed) {
        source = solid->indices;
        source_count = solid->index_count;
    }
    if (!ENF_RESERVE(k->corners, source_count))
        return 0;
    for (uint32_t i = 0; i < source_count; i++)
        k->corners[i] = closed ? source[i] : representative[source[i]];
    qsort(k->corners, source_count, sizeof *k->corners, compare_indices);
    for (uint32_t i = 0; i < source_count; i++)
        if (i == 0 || k->corners[i] != k->corners[i - 1])
            k->corners[corners++] = k->corners[i];
    if (!ENF_RESERVE(d->points, (uint64_t)out->point_count + corners))
        return 0;
    for (uint32_t i = 0; i < corners; i++)
        vec_copy(d->points[out->point_count + i], world[k->corners[i]]);
    EnfHull hull = {0};
    if (!closed) {
        if (!ENF_RESERVE(k->points, corners))
            return 0;
        for (uint32_t i = 0; i < corners; i++)
            vec_copy(k->points[i], s->pool.points[k->corners[i]]);
        int status = enf_hull_build(&hull, k->points, corners, 0.01 * s->eps);
        if (status == ENF_HULL_NO_MEMORY)
            return 0;
        faces = hull.face_count;
        count = hull.index_count;
    }
    int ok =
        ENF_RESERVE(d->face_sizes, (uint64_t)out->face_count + faces) && ENF_RESERVE(d->face_indices, (uint64_t)out->index_count + count);
    if (ok && faces) {
        memcpy(d->face_sizes + out->face_count, closed ? k->sizes : hull.face_sizes, faces * sizeof(uint32_t));
        for (uint32_t i = 0; i < count; i++) {
            uint32_t index = closed ? k->indices[i] : hull.face_indices[i];
            if (closed) {
                uint32_t *found = bsearch(&index, k->corners, corners, sizeof *k->corners, compare_indices);
                index = (uint32_t)(found - k->corners);
            }
            d->face_indices[out->index_count + i] = index;
        }
    }
    enf_hull_free(&hull);
    out->point_count += corners;
    out->face_count += faces;
    out->index_count += count;
    return ok && end_cell(out);
}

int enf_decomposition_write(EnfDecomposition *d, const EnfShape *s, const EnfSolidList *solids) {
    Output out = {d, 0, 0, 0};
    Cleaner cleaner = {NULL, NULL, NULL, NULL, NULL};
    uint32_t *representative = ENF_NEW(uint32_t, s->pool.count);
    double(*world)[3] = enf_alloc_array(s->pool.count, sizeof *world);
    cleaner.count_of = ENF_NEW(uint32_t, s->pool.count);
    int ok = representative && world && cleaner.count_of && begin_output(&out) && weld_pool(s, solids, representative);
    for (uint32_t v = 0; v < s->pool.count && ok; v++) {
        uint32_t r = representative[v];
        if (r < s->given_count)
            vec_copy(world[v], s->given_world[r]);
        else
            vec_add(world[v], s->pool.points[r], s->centre);
    }
    for (uint32_t c = 0; c < solids->count && ok; c++) {
        d->volume += enf_solid_volume(&solids->items[c], &s->pool);
        ok = write_cell(&out, &cleaner, s, &solids->items[c], representative, world);
    }
    ok = ok && enf_seams_build(d, s, solids, world);
    enf_free(representative);
    enf_free(world);
    enf_free(cleaner.sizes);
    enf_free(cleaner.indices);
    enf_free(cleaner.corners);
    enf_free(cleaner.count_of);
    enf_free(cleaner.points);
    return ok;
}

static int compare_solids_volume(const EnfShape *s, const EnfSolidList *solids) {
    double volume = 0.0;
    for (uint32_t c = 0; c < solids->count; c++)
        volume += enf_solid_volume(&solids->items[c], &s->pool);
    /* A layer of the resolution's thickness over all walls may be lost or gained; more is a shape that
     * crosses itself. */
    return fabs(volume - s->volume) <= 4.0 * s->fine * s->surface + 1e-9 * s->volume;
}

/* All faces of all cells are the room's surface or seams, which count twice. A seam that was lost would hide
 * what lies behind it: features of just the resolution's size can do that. */
int enf_decomposition_balances(const EnfDecomposition *d, const EnfShape *s) {
    double faces = 0.0, seams = 0.0, edges = 0.0, a[3], b[3], cross[3];
    const uint32_t *loop = d->face_indices;
    for (uint32_t c = 0; c < d->cell_count; c++) {
        double(*p)[3] = d->points + d->cell_point_first[c];
        for (uint32_t f = d->cell_face_first[c]; f < d->cell_face_first[c + 1]; loop += d->face_sizes[f++]) {
            double sum[3] = {0, 0, 0};
            for (uint32_t i = 0; i < d->face_sizes[f]; i++) {
                const double *q = p[loop[i]], *r = p[loop[(i + 1) % d->face_sizes[f]]];
                edges += vec_distance(q, r);
                vec_sub(a, q, p[loop[0]]);
                vec_sub(b, r, p[loop[0]]);
                vec_cross(cross, a, b);
                vec_add(sum, sum, cross);
            }
            faces += 0.5 * vec_length(sum);
        }
    }
    for (uint32_t i = 0; i < d->seam_count; i++) {
        double(*p)[3] = d->seam_points + d->seams[i].first, sum[3] = {0, 0, 0};
        for (uint32_t k = 1; k + 1 < d->seams[i].count; k++) {
            vec_sub(a, p[k], p[0]);
            vec_sub(b, p[k + 1], p[0]);
            vec_cross(cross, a, b);
            vec_add(sum, sum, cross);
        }
        seams += 0.5 * vec_length(sum);
    }
    return fabs(faces - s->surface - 2.0 * seams) <= 4.0 * s->fine * edges + 1e-9 * s->surface;
}

/* The common part. Frees the shape. Out of memory: ENF_ERROR_OUT_OF_MEMORY. */
static EnfStatus decompose(EnfDecomposition *d, EnfShape *s, int shape_status) {
    EnfSolidList solids = {NULL, 0};
    int ok = shape_status != ENF_SHAPE_NO_MEMORY, whole = shape_status == ENF_SHAPE_OK;
    d->shape_volume = s->volume;
    if (ok && whole && s->volume <= s->eps * s->surface) {
        d->gave_up = 1; /* no inside to speak of (a bow tie, a sheet): the hull, which commit calls flat if it is */
        whole = 0;
    }
    if (ok && whole) {
        int status = enf_bsp_build(s, &solids);
        ok = status != ENF_BSP_NO_MEMORY;
        d->gave_up = status == ENF_BSP_TOO_COMPLEX || (ok && (solids.count == 0 || !compare_solids_volume(s, &solids)));
        whole = !d->gave_up;
    }
    if (ok && whole) {
        ok = enf_solids_merge(s, &solids) && enf_decomposition_write(d, s, &solids);
        d->gave_up = ok && !enf_decomposition_balances(d, s);
        whole = !d->gave_up;
    }
    if (ok && !whole)
        ok = give_hull(d, s->given_world, s->given_count);
    enf_solid_list_free(&solids);
    enf_shape_free(s);
    if (ok)
        return ENF_OK;
    enf_decomposition_free(d);
    return enf_fail_memory();
}

/* What fails at the usual resolution may be sound at a coarser one, where the features in the way are one
 * corner. In diagonals of the room: 2e-6, 1.6e-5, 1.3e-4, the last a millimetre in a room of 10 m. */
static const double resolutions[] = {1.0, 8.0, 64.0};
enum { RESOLUTIONS = sizeof resolutions / sizeof *resolutions };

static EnfStatus decompose_faces(EnfDecomposition *out, double (*vertices)[3], uint32_t vertex_count, const uint32_t *face_sizes,
                                 uint32_t face_count, const uint32_t *face_indices) {
    for (int k = 0;; k++) {
        EnfShape shape;
        memset(out, 0, sizeof *out);
        int made = enf_shape_from_polyhedron(&shape, out, resolutions[k], vertices, vertex_count, face_sizes, face_count, face_indices);
        EnfStatus status = decompose(out, &shape, made);
        if (status != ENF_OK || !out->gave_up || k + 1 == RESOLUTIONS)
            return status;
        enf_decomposition_free(out);
    }
}

EnfStatus enf_decompose_polyhedron(EnfDecomposition *out, double (*vertices)[3], uint32_t vertex_count, const uint32_t *face_sizes,
                                   uint32_t face_count, const uint32_t *face_indices) {
    memset(out, 0, sizeof *out);
    uint64_t at = 0;
    if (vertex_count < 4)
        return enf_fail(ENF_ERROR_BAD_INPUT, "a room's shape needs at least 4 vertices, it has %u", vertex_count);
    for (uint32_t i = 0; i < vertex_count; i++)
        if (!vec_finite(vertices[i]) || fabs(vertices[i][0]) > 1e60 || fabs(vertices[i][1]) > 1e60 || fabs(vertices[i][2]) > 1e60)
            return enf_fail(ENF_ERROR_BAD_INPUT, "vertex %u of the room's shape is not finite or too far out (%g, %g, %g)", i,
                            vertices[i][0], vertices[i][1], vertices[i][2]);
    for (uint32_t f = 0; f < face_count; at += face_sizes[f++])
        for (uint32_t i = 0; i < face_sizes[f]; i++)
            if (face_indices[at + i] >= vertex_count)
                return enf_fail(ENF_ERROR_BAD_INPUT, "face %u of the room's shape: vertex %u doesn't exist (%u vertices)", f,
                                face_indices[at + i], vertex_count);
    EnfStraightened straight;
    if (!enf_curves_straighten(&straight, vertices, face_sizes, face_count, face_indices))
        return enf_fail_memory();
    EnfStatus status = ENF_OK;
    if (straight.facets) {
        status = decompose_faces(out, vertices, vertex_count, straight.face_sizes, straight.face_count, straight.face_indices);
        out->facets = straight.facets;
        out->depth = straight.depth;
    }
    /* A wall thinner than a chord is deep crosses itself then: as it was given. */
    if (status == ENF_OK && (!straight.facets || out->gave_up || out->not_closed)) {
        enf_decomposition_free(out);
        status = decompose_faces(out, vertices, vertex_count, face_sizes, face_count, face_indices);
    }
    enf_straightened_free(&straight);
    return status;
}

static EnfStatus decompose_rings(EnfDecomposition *out, const double *corners, const uint32_t *ring_sizes, uint64_t ring_count, double z0,
                                 double z1) {
    for (int k = 0;; k++) {
        EnfShape shape;
        memset(out, 0, sizeof *out);
        int made = enf_shape_from_prism(&shape, resolutions[k], corners, ring_sizes, ring_count, z0, z1);
        EnfStatus status = decompose(out, &shape, made);
        if (status != ENF_OK || !out->gave_up || k + 1 == RESOLUTIONS)
            return status;
        enf_decomposition_free(out);
    }
}

EnfStatus enf_decompose_prism(EnfDecomposition *out, const double *corners, const uint32_t *ring_sizes, uint64_t ring_count, double z0,
                              double z1) {
    memset(out, 0, sizeof *out);
    uint64_t count = 0;
    if (!(isfinite(z0) && isfinite(z1) && z0 < z1 && fabs(z0) < 1e60 && fabs(z1) < 1e60))
        return enf_fail(ENF_ERROR_BAD_INPUT, "a prism's heights must be finite and ascend (%g, %g)", z0, z1);
    for (uint64_t r = 0; r < ring_count; r++) {
        if (ring_sizes[r] < 3)
            return enf_fail(ENF_ERROR_BAD_INPUT, "ring %llu of the prism has %u corners, at least 3 are needed", (unsigned long long)r,
                            ring_sizes[r]);
        count += ring_sizes[r];
    }
    if (count == 0 || count > 10000000)
        return enf_fail(ENF_ERROR_BAD_INPUT, "a prism of %llu corners", (unsigned long long)count);
    for (uint64_t i = 0; i < 2 * count; i++)
        if (!isfinite(corners[i]) || fabs(corners[i]) > 1e60)
            return enf_fail(ENF_ERROR_BAD_INPUT, "corner %llu of the prism is not finite or too far out", (unsigned long long)(i / 2));
    double(*straight)[2] = enf_alloc_array(count, sizeof *straight), depth;
    uint32_t *sizes = ENF_NEW(uint32_t, ring_count);
    int64_t facets = -1;
    if (straight && sizes) {
        memcpy(straight, corners, count * sizeof *straight);
        memcpy(sizes, ring_sizes, ring_count * sizeof *sizes);
        facets = enf_rings_straighten(straight, sizes, ring_count, &depth);
    }
    EnfStatus status = facets < 0 ? enf_fail_memory() : ENF_OK;
    if (facets > 0) {
        status = decompose_rings(out, straight[0], sizes, ring_count, z0, z1);
        out->facets = (uint32_t)facets;
        out->depth = depth;
    }
    if (status == ENF_OK && (facets == 0 || out->gave_up)) {
        enf_decomposition_free(out);
        status = decompose_rings(out, corners, ring_sizes, ring_count, z0, z1);
    }
    enf_free(straight);
    enf_free(sizes);
    return status;
}
