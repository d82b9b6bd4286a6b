/* SPDX-License-Identifier: GPL-3.0-or-later
 * A binary space partition by the planes of a room's faces: its leaves are convex, those inside are the room.
 * Based on: Fuchs, Kedem, Naylor, On Visible Surface Generation by A Priori Tree Structures, 1980; Thibault,
 * Naylor, Set Operations on Polyhedra Using Binary Space Partitioning Trees, 1987. Ours in the choice of
 * planes:
 *   1. A plane with all other faces on one side costs nothing (it only cuts off what is outside).
 *   2. Otherwise the plane that splits the fewest faces; then the walls' main directions before odd ones (a
 * curved wall's facets come last, so it doesn't shatter the room), upright before level before slanted, much
 * shared area before little. Which leaves are inside is asked of the shape itself (winding number), not of
 * the last plane: coplanar faces that look both ways (a stair's tread and the ceiling below it) would fool
 * that. */
#include "scene/solid_bsp.h"
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

#include <stdlib.h>

/* Planes looked at per split, the largest first: bounds a node's cost on curved rooms of thousands of facets.
 */
enum { MOST_CANDIDATES = 48, MOST_LEAVES = 100000, MOST_FRAGMENTS = 2000000 };

void enf_solid_list_free(EnfSolidList *list) {
    for (uint32_t i = 0; i < list->count; i++)
        enf_solid_free(&list->items[i]);
    enf_free(list->items);
    memset(list, 0, sizeof *list);
}

/* A part of space yet to be split: a convex solid and the faces in it. */
typedef struct Region {
    EnfSolid solid;
    uint32_t *fragments;
    uint32_t count;
} Region;

typedef struct Candidate {
    uint32_t plane;
    double area; /* in this region */
    double cost;
    int is_free;
} Candidate;

typedef struct Splitter {
    EnfShape *shape;
    EnfSolidList *inside;
    Region *stack;
    uint32_t depth;
    Candidate *candidates;
    uint32_t candidate_count;
    double *plane_area;   /* [planes] scratch, zero between uses */
    uint32_t *face_stamp; /* [faces] */
    uint32_t stamp;
    uint32_t leaves;
} Splitter;

/* Planes that look the same way, to 2.5 degrees. */
#define SAME_WAY 0.999

/* -1 behind, 1 in front, 0 in the plane, 2 on both sides. Only what looks the plane's way and lies before it may count as in it from
 * farther: of two faces of a gap both must cut, and a face behind a cut that stood for it would leave what is before it open. */
static int side_of(const EnfShape *s, const EnfFragment *fragment, const EnfShapePlane *plane) {
    int back = 0, front = 0;
    double before = vec_dot(s->planes[fragment->plane].n, plane->n) > SAME_WAY ? s->fragment_eps : s->eps;
    for (uint32_t i = 0; i < fragment->count; i++) {
        double distance = vec_dot(plane->n, s->fragment_points[fragment->first + i]) - plane->d;
        back |= distance < -s->eps;
        front |= distance > before;
    }
    return back && front ? 2 : front ? 1 : back ? -1 : 0;
}

static double fragment_area(const EnfShape *s, const EnfFragment *fragment) {
    double n[3];
    return enf_polygon_normal(n, s->fragment_points + fragment->first, fragment->count);
}

static int compare_candidates(const void *left, const void *right) {
    const Candidate *a = left, *b = right;
    if (a->area != b->area)
        return a->area > b->area ? -1 : 1;
    return a->plane < b->plane ? -1 : a->plane > b->plane;
}

static int list_candidates(Splitter *t, const Region *region) {
    EnfShape *s = t->shape;
    t->candidate_count = 0;
    for (uint32_t i = 0; i < region->count; i++) {
        const EnfFragment *fragment = &s->fragments[region->fragments[i]];
        if (t->plane_area[fragment->plane] == 0.0) {
            if (!ENF_RESERVE(t->candidates, (uint64_t)t->candidate_count + 1))
                return 0;
            t->candidates[t->candidate_count++] = (Candidate){fragment->plane, 0.0, 0.0, 0};
        }
        t->plane_area[fragment->plane] += fragment_area(s, fragment) + 1e-300;
    }
    for (uint32_t i = 0; i < t->candidate_count; i++) {
        Candidate *c = &t->candidates[i];
        c->area = t->plane_area[c->plane];
        t->plane_area[c->plane] = 0.0;
    }
    qsort(t->candidates, t->candidate_count, sizeof *t->candidates, compare_candidates);
    if (t->candidate_count > MOST_CANDIDATES)
        t->candidate_count = MOST_CANDIDATES;
    return 1;
}

static void judge(Splitter *t, const Region *region, Candidate *c) {
    const EnfShape *s = t->shape;
    const EnfShapePlane *plane = &s->planes[c->plane];
    uint32_t back = 0, front = 0, split = 0, coplanar = 0;
    t->stamp++;
    for (uint32_t i = 0; i < region->count; i++) {
        const EnfFragment *fragment = &s->fragments[region->fragments[i]];
        int side = fragment->plane == c->plane ? 0 : side_of(s, fragment, plane);
        back += side == -1;
        front += side == 1;
        if (t->face_stamp[fragment->face] != t->stamp && (side == 2 || side == 0)) {
            t->face_stamp[fragment->face] = t->stamp;
            split += side == 2;
            coplanar += side == 0;
        }
    }
    c->is_free = split == 0 && (back == 0 || front == 0);
    double upright = fabs(plane->n[2]);
    double tilt = upright < 1e-3 ? 0.0 : upright > 1.0 - 1e-6 ? 0.4 : 0.8;
    c->cost = split + tilt + 0.6 * (1.0 - plane->weight) - 0.25 * (coplanar > 4 ? 4 : coplanar);
}

/* Even-odd over all rings: their winding doesn't matter. */
static int inside_rings(const EnfShape *s, double x, double y) {
    int inside = 0;
    double(*ring)[2] = s->ring_corners;
    for (uint64_t r = 0; r < s->ring_count; ring += s->ring_sizes[r++]) {
        uint32_t n = s->ring_sizes[r];
        for (uint32_t i = 0, j = n - 1; i < n; j = i++)
            if ((ring[i][1] > y) != (ring[j][1] > y) &&
                x < ring[j][0] + (ring[i][0] - ring[j][0]) * ((y - ring[j][1]) / (ring[i][1] - ring[j][1])))
                inside = !inside;
    }
    return inside;
}

/* Sum of the triangles' solid angles over 4 pi (van Oosterom, Strackee 1983): 1 inside, 0 outside, whatever
 * the faces' cut. */
static double winding_number(const EnfShape *s, const double point[3]) {
    double sum = 0.0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        double a[3], b[3], c[3], cross[3];
        vec_sub(a, s->pool.points[s->triangles[i][0]], point);
        vec_sub(b, s->pool.points[s->triangles[i][1]], point);
        vec_sub(c, s->pool.points[s->triangles[i][2]], point);
        double la = vec_length(a), lb = vec_length(b), lc = vec_length(c);
        vec_cross(cross, b, c);
        sum += atan2(vec_dot(a, cross), la * lb * lc + vec_dot(a, b) * lc + vec_dot(b, c) * la + vec_dot(c, a) * lb);
    }
    return sum / 6.283185307179586;
}

static int is_inside(const EnfShape *s, const EnfSolid *solid) {
    double centre[3];
    if (s->keeps_all)
        return 1;
    enf_solid_centre(solid, &s->pool, centre);
    if (s->prism)
        return inside_rings(s, centre[0], centre[1]);
    return winding_number(s, centre) > 0.5;
}

static int split_fragments(Splitter *t, const Region *region, uint32_t plane_index, Region *back, Region *front) {
    EnfShape *s = t->shape;
    const EnfShapePlane *plane = &s->planes[plane_index];
    back->fragments = ENF_NEW(uint32_t, region->count);
    front->fragments = ENF_NEW(uint32_t, region->count);
    if (!back->fragments || !front->fragments)
        return 0;
    for (uint32_t i = 0; i < region->count; i++) {
        uint32_t index = region->fragments[i];
        EnfFragment fragment = s->fragments[index];
        int side = fragment.plane == plane_index ? 0 : side_of(s, &fragment, plane);
        if (side == -1)
            back->fragments[back->count++] = index;
        else if (side == 1)
            front->fragments[front->count++] = index;
        else if (side == 2) {
            uint32_t b, f, room = fragment.count + 1, at = s->fragment_point_count;
            if (!ENF_RESERVE(s->fragment_points, (uint64_t)at + 2 * (uint64_t)room) ||
                !ENF_RESERVE(s->fragments, (uint64_t)s->fragment_count + 2))
                return 0;
            enf_polygon_split(s->fragment_points + fragment.first, fragment.count, plane->n, plane->d, s->eps, s->fragment_points + at, &b,
                              s->fragment_points + at + room, &f);
            if (b >= 3) {
                s->fragments[s->fragment_count] = (EnfFragment){at, b, fragment.plane, fragment.face};
                back->fragments[back->count++] = s->fragment_count++;
            }
            if (f >= 3) {
                s->fragments[s->fragment_count] = (EnfFragment){at + room, f, fragment.plane, fragment.face};
                front->fragments[front->count++] = s->fragment_count++;
            }
            s->fragment_point_count = at + 2 * room;
        }
    }
    return 1;
}

static void free_region(Region *region) {
    enf_solid_free(&region->solid);
    enf_free(region->fragments);
    memset(region, 0, sizeof *region);
}

/* Puts a part back to work, keeps it as a leaf, or forgets it. */
static int settle(Splitter *t, Region *region) {
    if (region->solid.face_count < 4) {
        free_region(region); /* thinner than eps: nothing of it is left */
        return ENF_BSP_OK;
    }
    if (region->count) {
        if (!ENF_RESERVE(t->stack, (uint64_t)t->depth + 1))
            return ENF_BSP_NO_MEMORY;
        t->stack[t->depth++] = *region;
        memset(region, 0, sizeof *region);
        return ENF_BSP_OK;
    }
    if (++t->leaves > MOST_LEAVES || t->shape->fragment_count > MOST_FRAGMENTS)
        return ENF_BSP_TOO_COMPLEX;
    if (is_inside(t->shape, &region->solid)) {
        if (!ENF_RESERVE(t->inside->items, (uint64_t)t->inside->count + 1))
            return ENF_BSP_NO_MEMORY;
        t->inside->items[t->inside->count++] = region->solid;
        memset(&region->solid, 0, sizeof region->solid);
    }
    free_region(region);
    return ENF_BSP_OK;
}

static int cut_region(Splitter *t, Region *region, uint32_t plane_index, Region *back, Region *front) {
    EnfShape *s = t->shape;
    const EnfShapePlane *plane = &s->planes[plane_index];
    return enf_solid_cut(&region->solid, &s->pool, plane_index, plane->n, plane->d, s->eps, &back->solid, &front->solid) &&
           split_fragments(t, region, plane_index, back, front);
}

/* Takes all free planes at once (each cuts off a leaf), or else the cheapest one. */
static int split_region(Splitter *t, Region *region) {
    if (!list_candidates(t, region))
        return ENF_BSP_NO_MEMORY;
    uint32_t best = 0, free_count = 0;
    for (uint32_t i = 0; i < t->candidate_count; i++) {
        judge(t, region, &t->candidates[i]);
        free_count += t->candidates[i].is_free != 0;
        if (t->candidates[i].cost < t->candidates[best].cost)
            best = i;
    }
    int status = ENF_BSP_OK;
    if (free_count == 0) {
        Region back = {0}, front = {0};
        if (!cut_region(t, region, t->candidates[best].plane, &back, &front))
            status = ENF_BSP_NO_MEMORY;
        if (status == ENF_BSP_OK)
            status = settle(t, &back);
        if (status == ENF_BSP_OK)
            status = settle(t, &front);
        free_region(&back);
        free_region(&front);
        return status;
    }
    /* Upright ones first: what they cut off keeps its whole height, and floor and ceiling then border on one cell each. */
    for (uint32_t k = 0; k < 2 * t->candidate_count && status == ENF_BSP_OK && region->count; k++) {
        uint32_t i = k % t->candidate_count;
        int upright = fabs(t->shape->planes[t->candidates[i].plane].n[2]) < 0.7071;
        if (!t->candidates[i].is_free || upright != (k < t->candidate_count))
            continue;
        Region back = {0}, front = {0};
        if (!cut_region(t, region, t->candidates[i].plane, &back, &front))
            status = ENF_BSP_NO_MEMORY;
        /* The side with faces goes on; when neither has any, both are leaves and the loop ends. */
        free_region(region);
        *region = back.count ? back : front;
        Region *leaf = back.count ? &front : &back;
        if (status == ENF_BSP_OK)
            status = settle(t, leaf);
        free_region(leaf);
    }
    if (status == ENF_BSP_OK)
        status = settle(t, region);
    return status;
}

int enf_bsp_build(EnfShape *shape, EnfSolidList *inside) {
    Splitter splitter = {shape, inside, NULL, 0, NULL, 0, NULL, NULL, 0, 0}, *t = &splitter;
    Region root = {0};
    double box[6];
    memcpy(box, shape->box, sizeof box);
    if (!shape->keeps_all)
        box_grow(box, 0.125 * shape->size);
    if (shape->prism) {
        box[2] = shape->z0;
        box[5] = shape->z1;
    }
    t->plane_area = ENF_NEW(double, shape->plane_count);
    t->face_stamp = ENF_NEW(uint32_t, shape->face_count);
    root.fragments = ENF_NEW(uint32_t, shape->fragment_count);
    int status = ENF_BSP_NO_MEMORY;
    if (t->plane_area && t->face_stamp && root.fragments && enf_solid_box(&root.solid, &shape->pool, box)) {
        for (int f = 0; f < 6; f++)
            root.solid.faces[f].plane = shape->box_codes[f];
        for (uint32_t i = 0; i < shape->fragment_count; i++)
            root.fragments[i] = i;
        root.count = shape->fragment_count;
        status = settle(t, &root);
    }
    free_region(&root);
    while (status == ENF_BSP_OK && t->depth) {
        Region region = t->stack[--t->depth];
        status = split_region(t, &region);
        free_region(&region);
    }
    while (t->depth)
        free_region(&t->stack[--t->depth]);
    enf_free(t->stack);
    enf_free(t->candidates);
    enf_free(t->plane_area);
    enf_free(t->face_stamp);
    return status;
}
