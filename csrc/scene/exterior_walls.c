/* SPDX-License-Identifier: GPL-3.0-or-later
 * How far the walls before a room's faces reach outwards, where openings tell: to these openings' outer ends.
 *
 * The outdoors then begin in the plane of the openings' outer portals, and no cell of theirs reaches into a recess. Only a
 * face with an opening that leads outdoors is moved, no farther than its shallowest opening, and not where that would stand
 * before an opening (safe direction: the outdoors are larger). A wall without openings may be as thin as it likes. */
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/exterior.h"

#include <stdlib.h>

/* Faces this parallel are one wall. */
#define SAME_WAY (1.0 - 1e-9)
/* No opening has told yet. */
#define UNTOLD DBL_MAX

typedef struct Walls {
    const EnfScene *scene;
    double wall, slab, fine;
    double *depths; /* [faces] */
} Walls;

/* Portal p, which leads outdoors along `out`, is the end of an opening of cell c. */
static void tell(Walls *w, uint32_t c, uint32_t p, const double out[3]) {
    const EnfScene *s = w->scene;
    double limit = fabs(out[2]) > 0.7071 ? w->slab : w->wall;
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1]; f++) {
        double low = DBL_MAX, high = -DBL_MAX;
        const EnfPlane *plane = &s->face_planes[f];
        if (!(vec_dot(plane->n, out) > SAME_WAY))
            continue;
        for (uint32_t v = s->portal_vertex_first[p]; v < s->portal_vertex_first[p + 1]; v++) {
            double local[3];
            vec_sub(local, s->portal_vertices[v], s->origin);
            double distance = vec_dot(plane->n, local) - plane->d;
            low = fmin(low, distance);
            high = fmax(high, distance);
        }
        /* Deeper than walls are: a bay or a porch, and nobody knows how thick its wall is. */
        w->depths[f] = fmin(w->depths[f], high > limit || high - low > w->fine ? 0.0 : fmax(high, 0.0));
    }
}

static int is_rooms_own(const EnfScene *s, uint32_t c) {
    return s->cell_rooms[c] != ENF_NONE && !enf_is_exterior(s, c) && s->cell_openings[c] == ENF_NONE;
}

static uint32_t inner_cell(const EnfScene *s, uint32_t p, uint32_t hub, double out[3]) {
    int side = s->portal_cells[p][1] == hub;
    vec_scale(out, side ? 1.0 : -1.0, s->portal_planes[p].n);
    return s->portal_cells[p][!side];
}

/* Whether what stands right before portal p lies in the cell with its faces moved out. */
static int is_blocked(const Walls *w, uint32_t c, uint32_t p, const double out[3], double (**scratch)[3]) {
    const EnfScene *s = w->scene;
    uint32_t count = s->portal_vertex_first[p + 1] - s->portal_vertex_first[p], none;
    uint32_t most = count + s->cell_face_first[c + 1] - s->cell_face_first[c] + 2;
    double around = 0.0, n[3];
    if (!ENF_RESERVE(*scratch, 3 * (uint64_t)most))
        return -1;
    double(*a)[3] = *scratch, (*b)[3] = a + most, (*spare)[3] = b + most;
    for (uint32_t i = 0; i < count; i++) {
        vec_sub(a[i], s->portal_vertices[s->portal_vertex_first[p] + i], s->origin);
        vec_mad(a[i], a[i], 4.0 * w->fine, out);
    }
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1] && count >= 3; f++) {
        enf_polygon_split(a, count, s->face_planes[f].n, s->face_planes[f].d + w->depths[f], w->fine, b, &count, spare, &none);
        double(*t)[3] = a;
        a = b;
        b = t;
    }
    for (uint32_t i = 0; i < count; i++)
        around += vec_distance(a[i], a[(i + 1) % count]);
    return count >= 3 && enf_polygon_normal(n, a, count) > w->fine * around;
}

/* Walls that would stand before an opening aren't there. 0: no memory. */
static int clear_openings(Walls *w, uint32_t hub) {
    const EnfScene *s = w->scene;
    double(*boxes)[6] = enf_alloc_array(s->cell_count, sizeof *boxes), (*scratch)[3] = NULL;
    EnfBoxTree tree = {NULL, NULL, 0, 0};
    int ok = boxes != NULL;
    for (uint32_t c = 0; c < s->cell_count && ok; c++) {
        double most = 0.0;
        box_empty(boxes[c]);
        for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1]; f++)
            most = fmax(most, w->depths[f]);
        if (most == 0.0)
            continue;
        memcpy(boxes[c], s->cell_bounds[c], sizeof boxes[c]);
        box_grow(boxes[c], ENF_MITRE * most);
    }
    ok = ok && enf_box_tree_build(&tree, (const double(*)[6])boxes, s->cell_count);
    for (uint32_t p = 0; p < s->portal_count && ok; p++) {
        double box[6], out[3];
        uint32_t c;
        EnfBoxWalk walk;
        if (s->portal_cells[p][0] != hub && s->portal_cells[p][1] != hub)
            continue;
        inner_cell(s, p, hub, out);
        box_empty(box);
        for (uint32_t v = s->portal_vertex_first[p]; v < s->portal_vertex_first[p + 1]; v++)
            box_add_point(box, s->portal_vertices[v]);
        box_grow(box, 8.0 * w->fine);
        enf_box_walk_begin(&walk, &tree, box);
        while (ok && (c = enf_box_walk_next(&walk)) != ENF_NONE) {
            int blocked = box_touches_box(box, boxes[c]) ? is_blocked(w, c, p, out, &scratch) : 0;
            ok = blocked >= 0;
            for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1] && blocked > 0; f++)
                w->depths[f] = 0.0;
        }
    }
    enf_box_tree_free(&tree);
    enf_free(boxes);
    enf_free(scratch);
    return ok;
}

int enf_walls_measure(const EnfScene *scene, uint32_t hub, double wall, double slab, double *depths) {
    Walls walls = {scene, wall, slab, 4.0 * scene->tolerance, depths}, *w = &walls;
    uint32_t faces = scene->cell_face_first[scene->cell_count];
    for (uint32_t f = 0; f < faces; f++)
        depths[f] = UNTOLD;
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        double out[3];
        if (scene->portal_cells[p][0] != hub && scene->portal_cells[p][1] != hub)
            continue;
        uint32_t c = inner_cell(scene, p, hub, out);
        if (is_rooms_own(scene, c))
            tell(w, c, p, out);
        else if (scene->cell_openings[c] != ENF_NONE)
            for (uint32_t i = scene->cell_portal_first[c]; i < scene->cell_portal_first[c + 1]; i++)
                if (is_rooms_own(scene, scene->cell_portals[i].to))
                    tell(w, scene->cell_portals[i].to, p, out);
    }
    for (uint32_t f = 0; f < faces; f++)
        if (depths[f] == UNTOLD || depths[f] <= w->fine)
            depths[f] = 0.0;
    return clear_openings(w, hub);
}
