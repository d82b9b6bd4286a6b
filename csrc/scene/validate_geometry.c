/* SPDX-License-Identifier: GPL-3.0-or-later
 * How portals and cells lie to one another: touching, sides, overlaps, duplicates, what leads nowhere. */
#include "base/memory.h"
#include "geometry/convex_solid.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/cell_side.h"
#include "scene/point_location.h"
#include "scene/problems.h"
#include "scene/validate.h"

#include <stdlib.h>

/* A portal may hang this far off its cell without being told of. [Unit: portal radii] */
#define OFF_CELL 0.01

static int has_geometry(const EnfScene *s, uint32_t c) {
    return s->cell_face_first[c] < s->cell_face_first[c + 1];
}

/* How far the whole polygon lies beyond one of the cell's faces; 0 or less when it touches (or no face
 * tells). */
static double gap_to_cell(const EnfScene *s, uint32_t p, uint32_t c) {
    double gap = 0.0, local[3];
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1]; f++) {
        double nearest = DBL_MAX;
        for (uint32_t v = s->portal_vertex_first[p]; v < s->portal_vertex_first[p + 1]; v++) {
            vec_sub(local, s->portal_vertices[v], s->origin);
            nearest = fmin(nearest, vec_dot(s->face_planes[f].n, local) - s->face_planes[f].d);
        }
        gap = fmax(gap, nearest);
    }
    return gap;
}

/* Cells that the outdoors were cut into reach round the ends of openings, up to the walls between them. */
static int is_round_the_house(const EnfScene *s, uint32_t c) {
    return s->hub != ENF_NONE && s->cell_rooms[c] == s->cell_rooms[s->hub];
}

static void check_portal_at_cells(EnfScene *s, uint32_t p) {
    double side_of[2] = {0.0, 0.0};
    double *where = s->portal_centres[p], radius = s->portal_radii[p];
    for (int side = 0; side < 2; side++) {
        uint32_t c = s->portal_cells[p][side];
        if (!has_geometry(s, c))
            continue;
        double low, high, gap = gap_to_cell(s, p, c), box[6]; /* cell_bounds holds the portal too */
        box_empty(box);
        for (uint32_t v = s->cell_vertex_first[c]; v < s->cell_vertex_first[c + 1]; v++)
            box_add_point(box, s->cell_vertices[v]);
        double size = 0.5 * box_diagonal(box);
        enf_cell_reach(s, c, s->origin, s->portal_planes[p].n, s->portal_planes[p].d, &low, &high);
        side_of[side] = is_round_the_house(s, c) ? 0.0 : enf_plain_side(low, high);
        /* cells[0] lies behind the portal (its normal points away from it), cells[1] in front. */
        double beyond = side ? -low : high, depth = high - low;
        if (gap > 2.0 * (radius + size))
            enf_problem_add(s, ENF_SEVERITY_ERROR, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_OFF_CELL, where,
                            "is %.3g m away from cell %u, which it should lie at", gap, c);
        else if (gap > OFF_CELL * radius + s->tolerance && !is_round_the_house(s, c))
            enf_problem_add(s, ENF_SEVERITY_WARNING, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_OFF_CELL, where,
                            "doesn't touch cell %u: %.3g m between them", c, gap);
        else if (beyond > OFF_CELL * depth + s->tolerance && !is_round_the_house(s, c))
            enf_problem_add(s, ENF_SEVERITY_WARNING, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_IN_CELL, where,
                            "cell %u reaches %.3g m to the other side of it: who stands there doesn't look through it", c, beyond);
    }
    if (side_of[0] * side_of[1] > ENF_ONE_SIDE * ENF_ONE_SIDE)
        enf_problem_add(s, ENF_SEVERITY_ERROR, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_ORIENTATION, where,
                        "cells %u and %u lie on the same side of it: no one could look through", s->portal_cells[p][0],
                        s->portal_cells[p][1]);
}

/* Portal graphs: a cell lies on its own side of all its portals, so its other portals do too. When all of
 * them lie plainly on the other side of one, its winding is the wrong way round. */
static void check_winding(EnfScene *s, uint32_t c) {
    uint32_t first = s->cell_portal_first[c], end = s->cell_portal_first[c + 1];
    if (has_geometry(s, c) || end - first < 2 || end - first > 256)
        return;
    /* The outside goes round the building: of a slab with one window in the east the others all lie behind that one. */
    if (enf_is_exterior(s, c))
        return;
    for (uint32_t i = first; i < end; i++) {
        const EnfCellPortal *own = &s->cell_portals[i];
        double least = DBL_MAX, local[3];
        for (uint32_t j = first; j < end; j++) {
            uint32_t q = s->cell_portals[j].portal;
            if (i == j)
                continue;
            for (uint32_t v = s->portal_vertex_first[q]; v < s->portal_vertex_first[q + 1]; v++) {
                vec_sub(local, s->portal_vertices[v], s->portal_centres[own->portal]);
                double beyond = vec_dot(s->portal_planes[own->portal].n, local) * (own->side ? -1.0 : 1.0);
                least = fmin(least, beyond);
            }
        }
        if (least > s->tolerance)
            enf_problem_add(s, ENF_SEVERITY_WARNING, ENF_ITEM_PORTAL, own->portal, ENF_PROBLEM_PORTAL_ORIENTATION,
                            s->portal_centres[own->portal],
                            "all other portals of cell %u lie behind it: the cell has two minds about where it lies", c);
    }
}

typedef struct Keyed {
    uint32_t a, b, portal;
} Keyed;

static int compare_keyed(const void *left, const void *right) {
    const Keyed *x = left, *y = right;
    if (x->a != y->a)
        return x->a < y->a ? -1 : 1;
    if (x->b != y->b)
        return x->b < y->b ? -1 : 1;
    return x->portal < y->portal ? -1 : x->portal > y->portal;
}

/* Same corners, whatever their order. */
static int same_polygon(const EnfScene *s, uint32_t p, uint32_t q) {
    uint32_t n = s->portal_vertex_first[p + 1] - s->portal_vertex_first[p];
    if (n != s->portal_vertex_first[q + 1] - s->portal_vertex_first[q] || n > 64 ||
        vec_distance(s->portal_centres[p], s->portal_centres[q]) > s->tolerance)
        return 0;
    for (uint32_t i = 0; i < n; i++) {
        int found = 0;
        for (uint32_t j = 0; j < n; j++)
            found |= vec_distance(s->portal_vertices[s->portal_vertex_first[p] + i], s->portal_vertices[s->portal_vertex_first[q] + j]) <=
                     s->tolerance;
        if (!found)
            return 0;
    }
    return 1;
}

static int check_duplicates(EnfScene *s) {
    Keyed *keys = ENF_NEW(Keyed, s->portal_count);
    if (!keys)
        return 0;
    for (uint32_t p = 0; p < s->portal_count; p++) {
        uint32_t a = s->portal_cells[p][0], b = s->portal_cells[p][1];
        keys[p] = (Keyed){a < b ? a : b, a < b ? b : a, p};
    }
    if (s->portal_count)
        qsort(keys, s->portal_count, sizeof *keys, compare_keyed);
    for (uint32_t i = 1; i < s->portal_count; i++)
        /* A window back: pairs of cells with hundreds of portals between them stay linear. */
        for (uint32_t j = i; j-- > 0 && i - j <= 16 && keys[j].a == keys[i].a && keys[j].b == keys[i].b;)
            if (same_polygon(s, keys[i].portal, keys[j].portal)) {
                enf_problem_add(s, ENF_SEVERITY_INFO, ENF_ITEM_PORTAL, keys[i].portal, ENF_PROBLEM_PORTAL_DUPLICATE,
                                s->portal_centres[keys[i].portal], "is the same as portal %u", keys[j].portal);
                break;
            }
    enf_free(keys);
    return 1;
}

/* A cell as a solid about the scene's origin, to be cut by another's planes. */
static int cell_solid(const EnfScene *s, uint32_t c, EnfSolid *solid, EnfVertexPool *pool) {
    uint32_t first = s->cell_vertex_first[c], count = s->cell_vertex_first[c + 1] - first;
    memset(solid, 0, sizeof *solid);
    pool->count = 0;
    if (!ENF_RESERVE(pool->points, count))
        return 0;
    for (uint32_t i = 0; i < count; i++)
        vec_sub(pool->points[pool->count++], s->cell_vertices[first + i], s->origin);
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1]; f++)
        if (!enf_solid_add_face(solid, s->face_indices + s->face_index_first[f], s->face_index_first[f + 1] - s->face_index_first[f],
                                ENF_NONE))
            return 0;
    return 1;
}

/* Volume that two cells share; -1: no memory. */
static double shared_volume(const EnfScene *s, uint32_t a, uint32_t b, EnfVertexPool *pool) {
    EnfSolid solid, back, front;
    int ok = cell_solid(s, a, &solid, pool);
    for (uint32_t f = s->cell_face_first[b]; f < s->cell_face_first[b + 1] && ok && solid.face_count; f++) {
        const EnfPlane *plane = &s->face_planes[f];
        ok = enf_solid_cut(&solid, pool, 0, plane->n, plane->d, s->tolerance, &back, &front);
        enf_solid_free(&solid);
        if (ok)
            enf_solid_free(&front);
        solid = back;
    }
    double volume = ok ? enf_solid_volume(&solid, pool) : -1.0;
    enf_solid_free(&solid);
    return volume;
}

static double cell_volume(const EnfScene *s, uint32_t c, EnfVertexPool *pool) {
    EnfSolid solid;
    double volume = cell_solid(s, c, &solid, pool) ? enf_solid_volume(&solid, pool) : -1.0;
    enf_solid_free(&solid);
    return volume;
}

/* One face plane between two cells tells most neighbours apart at once. */
static int separated(const EnfScene *s, uint32_t a, uint32_t b, double depth) {
    for (uint32_t f = s->cell_face_first[a]; f < s->cell_face_first[a + 1]; f++) {
        double nearest = DBL_MAX, local[3];
        for (uint32_t v = s->cell_vertex_first[b]; v < s->cell_vertex_first[b + 1]; v++) {
            vec_sub(local, s->cell_vertices[v], s->origin);
            nearest = fmin(nearest, vec_dot(s->face_planes[f].n, local) - s->face_planes[f].d);
        }
        if (nearest > -depth)
            return 1;
    }
    return 0;
}

static int check_overlaps(EnfScene *s) {
    EnfVertexPool pool = {NULL, 0};
    int ok = 1;
    for (uint32_t a = 0; a < s->cell_count && ok; a++) {
        if (!has_geometry(s, a))
            continue;
        /* A thousandth of the smaller cell is overlap that someone drew; less is how walls are measured. */
        double size = box_diagonal(s->cell_bounds[a]), box[6];
        uint32_t b, found = 0;
        EnfBoxWalk walk;
        box_empty(box);
        for (uint32_t v = s->cell_vertex_first[a]; v < s->cell_vertex_first[a + 1]; v++)
            box_add_point(box, s->cell_vertices[v]);
        enf_box_walk_begin(&walk, &s->locator->cells, box);
        while (ok && found < 8 && (b = enf_box_walk_next(&walk)) != ENF_NONE) {
            if (b <= a || is_round_the_house(s, a) || is_round_the_house(s, b))
                continue;
            double depth = 1e-3 * fmin(size, box_diagonal(s->cell_bounds[b]));
            if (!box_touches_box(box, s->cell_bounds[b]) || separated(s, a, b, depth) || separated(s, b, a, depth))
                continue;
            double volume = shared_volume(s, a, b, &pool), va = cell_volume(s, a, &pool), vb = cell_volume(s, b, &pool);
            ok = volume >= 0.0 && va >= 0.0 && vb >= 0.0;
            if (!ok || volume <= 1e-6 * fmin(va, vb))
                continue;
            found++;
            /* Voids deeper than their walls overlap rooms in most models: only worth a note. */
            int opening = s->cell_openings[a] != ENF_NONE || s->cell_openings[b] != ENF_NONE;
            enf_problem_add(s, opening ? ENF_SEVERITY_INFO : ENF_SEVERITY_WARNING, ENF_ITEM_CELL, b, ENF_PROBLEM_CELL_OVERLAP,
                            s->cell_centres[b], "overlaps cell %u by %.3g m3; who stands there is in both", a, volume);
        }
    }
    enf_free(pool.points);
    return ok;
}

static int check_uses(EnfScene *s) {
    unsigned char *room = ENF_NEW(unsigned char, s->room_count), *opening = ENF_NEW(unsigned char, s->opening_count);
    if (!room || !opening) {
        enf_free(room);
        enf_free(opening);
        return 0;
    }
    for (uint32_t c = 0; c < s->cell_count; c++) {
        if (s->cell_rooms[c] != ENF_NONE)
            room[s->cell_rooms[c]] = 1;
        if (s->cell_openings[c] != ENF_NONE)
            opening[s->cell_openings[c]] = 1;
        if (s->cell_portal_first[c] == s->cell_portal_first[c + 1] && s->cell_count > 1)
            enf_problem_add(s, ENF_SEVERITY_INFO, ENF_ITEM_CELL, c, ENF_PROBLEM_CELL_NO_PORTAL, s->cell_centres[c],
                            "has no portal: nothing is seen from it or into it");
    }
    for (uint32_t p = 0; p < s->portal_count; p++)
        if (s->portal_openings[p] != ENF_NONE)
            opening[s->portal_openings[p]] = 1;
    for (uint32_t r = 0; r < s->room_count; r++)
        if (!room[r])
            enf_problem_add(s, ENF_SEVERITY_INFO, ENF_ITEM_ROOM, r, ENF_PROBLEM_ROOM_EMPTY, NULL, "\"%.60s\" has no cell",
                            s->rooms[r].name);
    for (uint32_t i = 0; i < s->opening_count; i++)
        if (!opening[i])
            enf_problem_add(s, ENF_SEVERITY_INFO, ENF_ITEM_OPENING, i, ENF_PROBLEM_OPENING_UNUSED, NULL, "\"%.60s\" has no portal",
                            s->openings[i].name);
    enf_free(room);
    enf_free(opening);
    return 1;
}

int enf_validate_geometry(EnfScene *scene) {
    if (scene->cell_count == 0)
        enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_SCENE, ENF_NONE, ENF_PROBLEM_SCENE_EMPTY, NULL,
                        "has no cells: nothing is hidden from anywhere");
    for (uint32_t p = 0; p < scene->portal_count; p++)
        check_portal_at_cells(scene, p);
    for (uint32_t c = 0; c < scene->cell_count; c++)
        check_winding(scene, c);
    return check_duplicates(scene) && check_overlaps(scene) && check_uses(scene);
}
