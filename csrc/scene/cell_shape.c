/* SPDX-License-Identifier: GPL-3.0-or-later
 * Each cell's faces: are they closed, convex and right side out? If not, or if there are none, the convex
 * hull of the vertices is the cell: it holds at least as much, so a camera or object in the cell stays in it.
 */
#include "base/memory.h"
#include "geometry/convex_hull.h"
#include "geometry/polygon.h"
#include "geometry/sort_keys.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/problems.h"
#include "scene/validate.h"

#include <stdlib.h>

typedef struct Shaper {
    EnfScene *scene;
    double (*points)[3]; /* the cell's vertices about the scene's origin */
    double (*corners)[3];
    Pair *pairs;
    /* the faces as they shall be */
    uint32_t *cell_face_first, *face_index_first, *face_indices;
    uint64_t face_count, index_count;
    int changed;
} Shaper;

/* Edges without their opposite; ENF_NONE: no memory. */
static uint32_t count_open_edges(Shaper *k, uint32_t c) {
    const EnfScene *s = k->scene;
    uint32_t begin = s->face_index_first[s->cell_face_first[c]], end = s->face_index_first[s->cell_face_first[c + 1]];
    uint32_t n = 0, open = 0;
    if (!ENF_RESERVE(k->pairs, (uint64_t)end - begin))
        return ENF_NONE;
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1]; f++) {
        uint32_t first = s->face_index_first[f], size = s->face_index_first[f + 1] - first;
        for (uint32_t i = 0; i < size; i++)
            k->pairs[n++] = (Pair){s->face_indices[first + i], s->face_indices[first + (i + 1) % size]};
    }
    qsort(k->pairs, n, sizeof *k->pairs, compare_pairs);
    for (uint32_t i = 0; i < n; i++) {
        Pair back = {k->pairs[i].to, k->pairs[i].from};
        open += (i && compare_pairs(&k->pairs[i], &k->pairs[i - 1]) == 0) || !bsearch(&back, k->pairs, n, sizeof *k->pairs, compare_pairs);
    }
    return open;
}

/* 1: the faces are good; 0: the hull is needed (a problem says why); -1: no memory. */
static int judge_faces(Shaper *k, uint32_t c, uint32_t count, double tolerance) {
    EnfScene *s = k->scene;
    const double *where = s->cell_vertices[s->cell_vertex_first[c]];
    uint32_t open = count_open_edges(k, c);
    if (open == ENF_NONE)
        return -1;
    if (open) {
        enf_problem_add(s, ENF_SEVERITY_WARNING, ENF_ITEM_CELL, c, ENF_PROBLEM_CELL_OPEN, where,
                        "its faces don't close (%u open edges); its convex hull is taken", open);
        return 0;
    }
    double volume = 0.0, worst = 0.0, bent = 0.0;
    uint32_t worst_face = 0, worst_vertex = 0, bent_face = 0;
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1]; f++) {
        uint32_t first = s->face_index_first[f], size = s->face_index_first[f + 1] - first;
        double n[3], to[3];
        if (!ENF_RESERVE(k->corners, size))
            return -1;
        for (uint32_t i = 0; i < size; i++)
            vec_copy(k->corners[i], k->points[s->face_indices[first + i]]);
        double area = enf_polygon_normal(n, k->corners, size);
        vec_sub(to, k->corners[0], k->points[0]);
        volume += area * vec_dot(n, to) / 3.0;
        if (area == 0.0)
            continue; /* a face of no area bounds nothing; its plane is skipped at commit */
        for (uint32_t i = 0; i < size; i++) {
            vec_sub(to, k->corners[i], k->corners[0]);
            if (fabs(vec_dot(n, to)) > bent) {
                bent = fabs(vec_dot(n, to));
                bent_face = f - s->cell_face_first[c];
            }
        }
        for (uint32_t i = 0; i < count; i++) {
            vec_sub(to, k->points[i], k->corners[0]);
            if (vec_dot(n, to) > worst) {
                worst = vec_dot(n, to);
                worst_face = f - s->cell_face_first[c];
                worst_vertex = i;
            }
        }
    }
    if (volume < 0.0)
        enf_problem_add(s, ENF_SEVERITY_WARNING, ENF_ITEM_CELL, c, ENF_PROBLEM_CELL_INSIDE_OUT, where,
                        "its faces run clockwise seen from outside; its convex hull is taken");
    else if (worst > tolerance && bent > tolerance)
        enf_problem_add(s, ENF_SEVERITY_WARNING, ENF_ITEM_CELL, c, ENF_PROBLEM_CELL_FACE_NOT_PLANAR, where,
                        "face %u is %.3g m out of plane; its convex hull is taken", bent_face, bent);
    else if (worst > tolerance)
        enf_problem_add(s, ENF_SEVERITY_WARNING, ENF_ITEM_CELL, c, ENF_PROBLEM_CELL_NOT_CONVEX, where,
                        "isn't convex: vertex %u lies %.3g m outside of face %u; its convex hull is taken", worst_vertex, worst,
                        worst_face);
    else
        return 1;
    return 0;
}

static int keep_faces(Shaper *k, uint32_t c) {
    const EnfScene *s = k->scene;
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1]; f++) {
        uint32_t first = s->face_index_first[f], size = s->face_index_first[f + 1] - first;
        if (!ENF_RESERVE(k->face_index_first, k->face_count + 2) || !ENF_RESERVE(k->face_indices, k->index_count + size))
            return 0;
        memcpy(k->face_indices + k->index_count, s->face_indices + first, size * sizeof(uint32_t));
        k->index_count += size;
        k->face_index_first[++k->face_count] = (uint32_t)k->index_count;
    }
    return 1;
}

static int take_hull(Shaper *k, uint32_t c, uint32_t count, double size) {
    EnfScene *s = k->scene;
    EnfHull hull;
    k->changed = 1;
    int status = enf_hull_build(&hull, k->points, count, 1e-9 * size);
    if (status == ENF_HULL_NO_MEMORY)
        return 0;
    if (status == ENF_HULL_FLAT) {
        enf_problem_add(s, ENF_SEVERITY_ERROR, ENF_ITEM_CELL, c, ENF_PROBLEM_CELL_FLAT, s->cell_vertices[s->cell_vertex_first[c]],
                        "its %u vertices lie in one plane: it has no inside", count);
        return 1;
    }
    int ok = ENF_RESERVE(k->face_index_first, k->face_count + hull.face_count + 1) &&
             ENF_RESERVE(k->face_indices, k->index_count + hull.index_count);
    if (ok) {
        memcpy(k->face_indices + k->index_count, hull.face_indices, hull.index_count * sizeof(uint32_t));
        for (uint32_t f = 0; f < hull.face_count; f++) {
            k->index_count += hull.face_sizes[f];
            k->face_index_first[++k->face_count] = (uint32_t)k->index_count;
        }
    }
    enf_hull_free(&hull);
    return ok;
}

int enf_shape_cells(EnfScene *scene) {
    Shaper shaper, *k = &shaper;
    memset(k, 0, sizeof *k);
    k->scene = scene;
    int ok = ENF_RESERVE(k->cell_face_first, (uint64_t)scene->cell_count + 1) && ENF_RESERVE(k->face_index_first, 1);
    if (ok)
        k->cell_face_first[0] = k->face_index_first[0] = 0;
    for (uint32_t c = 0; c < scene->cell_count && ok; c++) {
        uint32_t first = scene->cell_vertex_first[c], count = scene->cell_vertex_first[c + 1] - first;
        double box[6];
        box_empty(box);
        ok = ENF_RESERVE(k->points, count);
        for (uint32_t i = 0; i < count && ok; i++) {
            vec_sub(k->points[i], scene->cell_vertices[first + i], scene->origin);
            box_add_point(box, k->points[i]);
        }
        double size = box_diagonal(box);
        /* Cells cut from a room are as exact as the room's resolution, and the room may be larger than the
         * cell. */
        double tolerance = 2.0 * ENF_TOLERANCE_ROOM * size + scene->tolerance;
        if (ok && count) {
            int good = 0;
            if (scene->cell_face_first[c] < scene->cell_face_first[c + 1])
                good = judge_faces(k, c, count, tolerance);
            ok = good == 1 ? keep_faces(k, c) : good == 0 ? take_hull(k, c, count, size) : 0;
        }
        if (ok && k->index_count >= ENF_NONE)
            ok = 0;
        k->cell_face_first[c + 1] = (uint32_t)k->face_count;
    }
    if (ok && k->changed) {
        enf_free(scene->cell_face_first);
        enf_free(scene->face_index_first);
        enf_free(scene->face_indices);
        scene->cell_face_first = k->cell_face_first;
        scene->face_index_first = k->face_index_first;
        scene->face_indices = k->face_indices;
        k->cell_face_first = k->face_index_first = k->face_indices = NULL;
    }
    enf_free(k->points);
    enf_free(k->corners);
    enf_free(k->pairs);
    enf_free(k->cell_face_first);
    enf_free(k->face_index_first);
    enf_free(k->face_indices);
    return ok;
}
