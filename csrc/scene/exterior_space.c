/* SPDX-License-Identifier: GPL-3.0-or-later
 * The space round a building as few convex cells: a box is cut along the building's outer faces (solid_bsp.c), and what
 * sight reaches from the box's sides is outdoors.
 *
 * Safe direction. A part of the box isn't outdoors only when no way leads there: the flood below goes on through every
 * common face of two parts unless bodies stand right behind the whole of it (but for gaps narrower than `slit`). Where
 * cuts are missing or moved, a part is mixed and is outdoors as a whole: larger. Nothing rests on faces having been
 * found exactly. What no way leads to (shafts and hollows inside of the building) is left out. */
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/exterior.h"

typedef struct Builder {
    const EnfScene *scene;
    const EnfBodies *bodies;
    EnfShape shape;
    double slit; /* metres */
    double step; /* metres: how far beside a face one looks for what stands there */
    EnfCover cover;
    double (*points)[3];
    EnfSolidList leaves;
    EnfDecomposition all; /* of its seams: common faces of leaves */
    double (*world)[3];
    unsigned char *reached;
} Builder;

/* ---- Outer faces --------------------------------------------------------------------------------------------------- */
/* The plane for an outer face: one that looks the same way and lies no more than `slit` from it; the innermost of all
 * that fall together. ENF_NONE: no memory. */
static uint32_t plane_for(Builder *b, const double n[3], double (*points)[3], uint32_t count, double area, double **reach) {
    EnfShape *s = &b->shape;
    for (uint32_t p = 0; p < s->plane_count; p++) {
        EnfShapePlane *plane = &s->planes[p];
        double low = DBL_MAX, high = -DBL_MAX;
        if (!(vec_dot(plane->n, n) > 0.99999))
            continue;
        for (uint32_t i = 0; i < count; i++) {
            double d = vec_dot(plane->n, points[i]);
            low = fmin(low, d);
            high = fmax(high, d);
        }
        if (fmax(high, (*reach)[p]) - fmin(low, plane->d) > b->slit + s->eps)
            continue;
        (*reach)[p] = fmax(high, (*reach)[p]);
        plane->d = fmin(low, plane->d);
        plane->area += area;
        return p;
    }
    if (!ENF_RESERVE(s->planes, (uint64_t)s->plane_count + 1) || !ENF_RESERVE(*reach, (uint64_t)s->plane_count + 1))
        return ENF_NONE;
    EnfShapePlane *plane = &s->planes[s->plane_count];
    memset(plane, 0, sizeof *plane);
    vec_copy(plane->n, n);
    for (int k = 0; k < 3; k++) /* axis-parallel walls get exact planes */
        if (fabs(n[k]) > 1.0 - 1e-14) {
            vec_set(plane->n, 0.0, 0.0, 0.0);
            plane->n[k] = n[k] < 0.0 ? -1.0 : 1.0;
        }
    plane->area = area;
    plane->d = DBL_MAX;
    double high = -DBL_MAX;
    for (uint32_t i = 0; i < count; i++) {
        plane->d = fmin(plane->d, vec_dot(plane->n, points[i]));
        high = fmax(high, vec_dot(plane->n, points[i]));
    }
    (*reach)[s->plane_count] = high;
    return s->plane_count++;
}

/* The parts of all bodies' faces that no other body stands before. 0: no memory. */
static int take_outer_faces(Builder *b) {
    const EnfBodies *bodies = b->bodies;
    EnfShape *s = &b->shape;
    double *reach = NULL;
    int ok = 1;
    for (uint32_t k = 0; k < bodies->count && ok; k++)
        for (uint32_t f = bodies->items[k].face_first; f < bodies->items[k].face_first + bodies->items[k].face_count && ok; f++) {
            const EnfBodyFace *face = &bodies->faces[f];
            ok = ENF_RESERVE(b->points, face->count);
            for (uint32_t i = 0; i < face->count && ok; i++)
                vec_mad(b->points[i], bodies->points[face->first + i], b->step, face->n);
            ok = ok && enf_bodies_uncovered(bodies, b->points, face->count, k, 2.0 * b->step, &b->cover);
            for (uint32_t i = 0; ok && i < b->cover.now.count; i++) {
                double(*points)[3] = b->cover.now.points + b->cover.now.items[i].first, n[3], longest = 0.0;
                uint32_t count = b->cover.now.items[i].count;
                double area = enf_polygon_normal(n, points, count);
                for (uint32_t j = 0; j < count; j++)
                    longest = fmax(longest, vec_distance(points[j], points[(j + 1) % count]));
                /* Narrower than a slit: a cut along it would only shave off what counts as closed. */
                if (area <= fmax(b->slit, 4.0 * b->step) * longest)
                    continue;
                for (uint32_t j = 0; j < count; j++)
                    vec_mad(points[j], points[j], -b->step, face->n);
                uint32_t plane = plane_for(b, face->n, points, count, area, &reach);
                ok = plane != ENF_NONE && enf_shape_add_fragment(s, points, count, plane, f);
            }
        }
    s->face_count = bodies->face_count;
    for (uint32_t i = 0; i < s->fragment_count && ok; i++) {
        const EnfFragment *fragment = &s->fragments[i];
        const EnfShapePlane *plane = &s->planes[fragment->plane];
        for (uint32_t j = fragment->first; j < fragment->first + fragment->count; j++)
            vec_mad(s->fragment_points[j], s->fragment_points[j], plane->d - vec_dot(plane->n, s->fragment_points[j]), plane->n);
    }
    enf_free(reach);
    return ok;
}

static int begin_shape(Builder *b, const double box[6]) {
    EnfShape *s = &b->shape;
    double largest = 0.0;
    for (int k = 0; k < 6; k++) {
        s->box[k] = box[k] - b->scene->origin[k % 3];
        largest = fmax(largest, fabs(box[k]));
    }
    vec_copy(s->centre, b->scene->origin);
    s->size = box_diagonal(s->box);
    s->eps = ENF_TOLERANCE_ROOM * s->size + ENF_TOLERANCE_COORDINATE * largest;
    s->fine = s->eps;
    s->keeps_all = 1;
    s->fragment_eps = b->slit + s->eps;
    b->step = 2.0 * s->eps + 4.0 * b->bodies->fine;
    if (!ENF_RESERVE(s->pool.points, 1) || !take_outer_faces(b))
        return 0;
    enf_shape_weigh_directions(s);
    if (!ENF_RESERVE(s->planes, (uint64_t)s->plane_count + 6))
        return 0;
    static const int axis_of[6] = {2, 2, 1, 0, 1, 0}, high_of[6] = {0, 1, 0, 1, 1, 0}; /* as enf_solid_box has them */
    for (int f = 0; f < 6; f++) {
        EnfShapePlane *plane = &s->planes[s->plane_count];
        memset(plane, 0, sizeof *plane);
        plane->n[axis_of[f]] = 1.0;
        plane->d = s->box[axis_of[f] + 3 * high_of[f]];
        s->box_codes[f] = 2 * s->plane_count++ + (high_of[f] ? 0 : 1);
    }
    return 1;
}

/* ---- The flood ------------------------------------------------------------------------------------------------------ */
static double pieces_area(const EnfPieces *pieces) {
    double area = 0.0, n[3];
    for (uint32_t i = 0; i < pieces->count; i++)
        area += enf_polygon_normal(n, pieces->points + pieces->items[i].first, pieces->items[i].count);
    return area;
}

/* Whether bodies stand behind the whole common face, seen from the leaf `from`. -1: no memory. */
static int is_wall(Builder *b, const EnfSeam *seam, uint32_t from) {
    double n[3], around = 0.0;
    if (!ENF_RESERVE(b->points, seam->count))
        return -1;
    for (uint32_t i = 0; i < seam->count; i++)
        vec_sub(b->points[i], b->all.seam_points[seam->first + i], b->scene->origin);
    for (uint32_t i = 0; i < seam->count; i++)
        around += vec_distance(b->points[i], b->points[(i + 1) % seam->count]);
    enf_polygon_normal(n, b->points, seam->count); /* towards cells[0] */
    double sense = seam->cells[0] == from ? -1.0 : 1.0;
    for (uint32_t i = 0; i < seam->count; i++)
        vec_mad(b->points[i], b->points[i], sense * b->step, n);
    if (!enf_bodies_uncovered(b->bodies, b->points, seam->count, ENF_NONE, 1.5 * b->step, &b->cover))
        return -1;
    return pieces_area(&b->cover.now) <= 0.5 * fmax(b->slit, b->step) * around;
}

static int holds_point(const Builder *b, const EnfSolid *solid, const double point[3]) {
    for (uint32_t f = 0; f < solid->face_count; f++) {
        const EnfShapePlane *plane = &b->shape.planes[solid->faces[f].plane / 2];
        double distance = vec_dot(plane->n, point) - plane->d;
        if ((solid->faces[f].plane & 1 ? -distance : distance) > b->step)
            return 0;
    }
    return 1;
}

static int touches_box(const Builder *b, const EnfSolid *solid) {
    for (uint32_t f = 0; f < solid->face_count; f++)
        if (solid->faces[f].plane / 2 >= b->shape.plane_count - 6) /* the box's planes are the last */
            return 1;
    return 0;
}

/* 0: no memory. */
static int flood(Builder *b, double (*seeds)[3], uint32_t seed_count) {
    uint32_t leaves = b->leaves.count, depth = 0;
    uint32_t *first = ENF_NEW(uint32_t, (uint64_t)leaves + 2), *list = ENF_NEW(uint32_t, 2 * (uint64_t)b->all.seam_count + 1),
             *stack = ENF_NEW(uint32_t, (uint64_t)leaves + 1);
    b->reached = ENF_NEW(unsigned char, leaves);
    int ok = first && list && stack && b->reached;
    for (uint32_t i = 0; i < b->all.seam_count && ok; i++)
        for (int k = 0; k < 2; k++)
            first[b->all.seams[i].cells[k] + 2]++;
    for (uint32_t c = 0; c < leaves && ok; c++)
        first[c + 2] += first[c + 1];
    for (uint32_t i = 0; i < b->all.seam_count && ok; i++)
        for (int k = 0; k < 2; k++)
            list[first[b->all.seams[i].cells[k] + 1]++] = i;
    for (uint32_t c = 0; c < leaves && ok; c++) {
        int begins = touches_box(b, &b->leaves.items[c]);
        for (uint32_t i = 0; i < seed_count && !begins; i++)
            begins = holds_point(b, &b->leaves.items[c], seeds[i]);
        if (begins) {
            b->reached[c] = 1;
            stack[depth++] = c;
        }
    }
    while (depth && ok) {
        uint32_t c = stack[--depth];
        for (uint32_t i = first[c]; i < first[c + 1] && ok; i++) {
            const EnfSeam *seam = &b->all.seams[list[i]];
            uint32_t other = seam->cells[0] == c ? seam->cells[1] : seam->cells[0];
            if (b->reached[other])
                continue;
            int wall = is_wall(b, seam, c);
            ok = wall >= 0;
            if (wall == 0) {
                b->reached[other] = 1;
                stack[depth++] = other;
            }
        }
    }
    enf_free(first);
    enf_free(list);
    enf_free(stack);
    return ok;
}

/* ---- Together --------------------------------------------------------------------------------------------------------- */
/* Fills the shape's volume and surface with those of what was reached, and takes the rest out of the list. */
static void keep_reached(Builder *b) {
    EnfShape *s = &b->shape;
    double n[3], size[3];
    for (int k = 0; k < 3; k++)
        size[k] = s->box[3 + k] - s->box[k];
    s->surface = 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    for (uint32_t i = 0; i < b->all.seam_count; i++) {
        const EnfSeam *seam = &b->all.seams[i];
        if (b->reached[seam->cells[0]] != b->reached[seam->cells[1]])
            s->surface += enf_polygon_normal(n, b->all.seam_points + seam->first, seam->count);
    }
    uint32_t kept = 0;
    for (uint32_t c = 0; c < b->leaves.count; c++)
        if (b->reached[c]) {
            s->volume += enf_solid_volume(&b->leaves.items[c], &s->pool);
            b->leaves.items[kept++] = b->leaves.items[c];
        } else
            enf_solid_free(&b->leaves.items[c]);
    b->leaves.count = kept;
}

int enf_space_build(const EnfScene *scene, const EnfBodies *bodies, const double box[6], double (*seeds)[3], uint32_t seed_count,
                    double slit, EnfSpace *space) {
    Builder builder, *b = &builder;
    memset(b, 0, sizeof *b);
    memset(space, 0, sizeof *space);
    b->scene = scene;
    b->bodies = bodies;
    b->slit = slit;
    int ok = begin_shape(b, box);
    if (ok) {
        int status = enf_bsp_build(&b->shape, &b->leaves);
        ok = status != ENF_BSP_NO_MEMORY;
        space->gave_up = status == ENF_BSP_TOO_COMPLEX;
    }
    if (ok && !space->gave_up) {
        space->leaves = b->leaves.count;
        b->world = enf_alloc_array(b->shape.pool.count, sizeof *b->world);
        ok = b->world != NULL;
        for (uint32_t v = 0; v < b->shape.pool.count && ok; v++)
            vec_add(b->world[v], b->shape.pool.points[v], scene->origin);
        ok = ok && enf_seams_build(&b->all, &b->shape, &b->leaves, b->world) && flood(b, seeds, seed_count);
    }
    if (ok && !space->gave_up) {
        keep_reached(b);
        space->reached = b->leaves.count;
        ok = enf_solids_merge(&b->shape, &b->leaves) && enf_decomposition_write(&space->cells, &b->shape, &b->leaves);
        space->gave_up = ok && !enf_decomposition_balances(&space->cells, &b->shape);
    }
    enf_cover_free(&b->cover);
    enf_free(b->points);
    enf_solid_list_free(&b->leaves);
    enf_decomposition_free(&b->all);
    enf_free(b->world);
    enf_free(b->reached);
    enf_shape_free(&b->shape);
    if (!ok)
        enf_decomposition_free(&space->cells);
    return ok;
}
