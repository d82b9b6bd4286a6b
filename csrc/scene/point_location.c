/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells hold a point. */
#include "scene/point_location.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/exterior.h"
#include "scene/hull_contains.h"

/* Whether all its portals lie on the cell's own side of each other's planes, as those of a convex cell do. */
static int convex_to_portals(const EnfScene *scene, uint32_t c) {
    uint32_t first = scene->cell_portal_first[c], end = scene->cell_portal_first[c + 1];
    /* Quadratic in the portals: a cell of thousands counts as not convex, which only means more start cells.
     */
    if (enf_is_exterior(scene, c) || end - first > 2048)
        return 0;
    for (uint32_t i = first; i < end; i++) {
        uint32_t p = scene->cell_portals[i].portal;
        double sign = scene->cell_portals[i].side ? -1.0 : 1.0;
        for (uint32_t j = first; j < end; j++) {
            uint32_t q = scene->cell_portals[j].portal;
            for (uint32_t v = scene->portal_vertex_first[q]; v < scene->portal_vertex_first[q + 1]; v++) {
                double local[3];
                vec_sub(local, scene->portal_vertices[v], scene->origin);
                double beyond = sign * (vec_dot(scene->portal_planes[p].n, local) - scene->portal_planes[p].d);
                if (beyond > scene->tolerance + scene->portal_deviation[p])
                    return 0;
            }
        }
    }
    return 1;
}

/* The cells without faces, and which of them their portals' hull proves. */
static int list_graph_cells(const EnfScene *scene, EnfLocator *locator) {
    for (uint32_t c = 0; c < scene->cell_count; c++)
        locator->graph_count += scene->cell_face_first[c] == scene->cell_face_first[c + 1];
    locator->graph_cells = ENF_NEW(uint32_t, locator->graph_count);
    locator->graph_convex = ENF_NEW(uint8_t, scene->cell_count);
    if (!locator->graph_cells || !locator->graph_convex)
        return 0;
    uint32_t n = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (scene->cell_face_first[c] == scene->cell_face_first[c + 1]) {
            locator->graph_cells[n++] = c;
            locator->graph_convex[c] = (uint8_t)convex_to_portals(scene, c);
        }
    return 1;
}

int enf_locator_build(EnfScene *scene) {
    EnfLocator *locator = ENF_NEW(EnfLocator, 1);
    double(*boxes)[6] = enf_alloc_array(scene->cell_count, sizeof *boxes);
    scene->locator = locator;
    int ok = locator && boxes;
    for (int graph = 0; ok && graph < 2; graph++) {
        for (uint32_t c = 0; c < scene->cell_count; c++) {
            int has_faces = scene->cell_face_first[c] < scene->cell_face_first[c + 1];
            box_empty(boxes[c]);
            if (has_faces != graph) {
                memcpy(boxes[c], scene->cell_bounds[c], sizeof boxes[c]);
                if (!box_is_empty(boxes[c]))
                    box_grow(boxes[c], scene->tolerance);
            }
        }
        ok = enf_box_tree_build(graph ? &locator->hulls : &locator->cells, (const double(*)[6])boxes, scene->cell_count);
    }
    enf_free(boxes);
    return ok && list_graph_cells(scene, locator);
}

void enf_locator_destroy(EnfLocator *locator) {
    if (!locator)
        return;
    enf_box_tree_free(&locator->cells);
    enf_box_tree_free(&locator->hulls);
    enf_free(locator->graph_cells);
    enf_free(locator->graph_convex);
    enf_free(locator);
}

/* Faces only: behind every one, up to `tolerance`, or by that much where it is negative. */
static int cell_holds(const EnfScene *scene, uint32_t c, const double local[3], double tolerance) {
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++)
        if (vec_dot(scene->face_planes[f].n, local) - scene->face_planes[f].d > tolerance)
            return 0;
    return 1;
}

/* Outdoors is what no other cell holds: cells outdoors may reach into recesses and walls' plaster. */
static int is_indoors(const EnfScene *scene, const double point[3], const double local[3]) {
    double query[6];
    uint32_t cell;
    EnfBoxWalk walk;
    vec_copy(query, point);
    vec_copy(query + 3, point);
    enf_box_walk_begin(&walk, &scene->locator->cells, query);
    while ((cell = enf_box_walk_next(&walk)) != ENF_NONE)
        if (!enf_is_exterior(scene, cell) && cell_holds(scene, cell, local, -scene->tolerance))
            return 1;
    return 0;
}

/* Portals only: on the cell's own side of every one, up to the tolerance. The exterior's cell is everything
 * that no other cell holds: it isn't convex, so no plane of a portal excludes it. */
static int portals_allow(const EnfScene *scene, uint32_t c, const double local[3]) {
    if (c == scene->hub)
        return enf_hub_holds(scene, local);
    if (enf_is_exterior(scene, c))
        return 1;
    for (uint32_t i = scene->cell_portal_first[c]; i < scene->cell_portal_first[c + 1]; i++) {
        const EnfCellPortal *side = &scene->cell_portals[i];
        const EnfPlane *plane = &scene->portal_planes[side->portal];
        double beyond = vec_dot(plane->n, local) - plane->d;
        if (side->side)
            beyond = -beyond;
        if (beyond > scene->tolerance + scene->portal_deviation[side->portal])
            return 0;
    }
    return 1;
}

typedef struct PortalCorners {
    const EnfScene *scene;
    uint32_t first, end; /* into cell_portals */
} PortalCorners;

static uint32_t count_corners(const PortalCorners *corners) {
    uint32_t count = 0;
    for (uint32_t i = corners->first; i < corners->end; i++) {
        uint32_t p = corners->scene->cell_portals[i].portal;
        count += corners->scene->portal_vertex_first[p + 1] - corners->scene->portal_vertex_first[p];
    }
    return count;
}

/* Corners are asked for in ascending order: stepping through the portals costs nothing. */
typedef struct CornerWalk {
    PortalCorners corners;
    uint32_t portal, passed;
} CornerWalk;

static void portal_corner(const void *user, uint32_t i, double out[3]) {
    CornerWalk *walk = (CornerWalk *)user;
    const EnfScene *scene = walk->corners.scene;
    if (i < walk->passed) {
        walk->portal = walk->corners.first;
        walk->passed = 0;
    }
    for (;;) {
        uint32_t p = scene->cell_portals[walk->portal].portal;
        uint32_t n = scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p];
        if (i < walk->passed + n) {
            vec_copy(out, scene->portal_vertices[scene->portal_vertex_first[p] + i - walk->passed]);
            return;
        }
        walk->passed += n;
        walk->portal++;
    }
}

/* Whether the hull of the cell's portals, all of it inside of a convex cell, has the point strictly inside.
 */
static int portals_prove(const EnfScene *scene, uint32_t c, const double point[3]) {
    CornerWalk walk = {{scene, scene->cell_portal_first[c], scene->cell_portal_first[c + 1]}, scene->cell_portal_first[c], 0};
    return scene->locator->graph_convex[c] && enf_hull_contains(count_corners(&walk.corners), portal_corner, &walk, point);
}

/* Whether the point lies on one of the cell's portals: then it is in the two cells that the portal joins and
 * in no other. */
static int on_portal(const EnfScene *scene, uint32_t c, const double point[3], uint32_t *out_other) {
    for (uint32_t i = scene->cell_portal_first[c]; i < scene->cell_portal_first[c + 1]; i++) {
        uint32_t p = scene->cell_portals[i].portal, first = scene->portal_vertex_first[p];
        uint32_t n = scene->portal_vertex_first[p + 1] - first;
        double local[3], normal[3];
        double(*v)[3] = scene->portal_vertices + first;
        vec_sub(local, point, v[0]);
        if (fabs(vec_dot(local, scene->portal_planes[p].n)) > scene->tolerance + scene->portal_deviation[p])
            continue;
        vec_scale(normal, -1.0, scene->portal_planes[p].n); /* the winding is counter-clockwise round it */
        int inside = 1;
        for (uint32_t k = 0; k < n && inside; k++) {
            double edge[3], out[3];
            vec_sub(edge, v[(k + 1) % n], v[k]);
            vec_sub(local, point, v[k]);
            vec_cross(out, edge, normal);
            inside = vec_dot(out, local) <= -scene->tolerance * vec_length(edge);
        }
        if (inside) {
            *out_other = scene->cell_portals[i].to;
            return 1;
        }
    }
    return 0;
}

/* The answer as it grows. */
typedef struct Found {
    uint32_t *cells, capacity, count;
} Found;

static void add(Found *found, uint32_t cell) {
    if (found->count < found->capacity)
        found->cells[found->count] = cell;
    found->count++;
}

/* Cells with faces that hold the point; those outdoors step back where a room does. local: the point about the scene's origin. */
static void locate_by_faces(const EnfScene *scene, const double point[3], const double local[3], const double query[6], Found *found) {
    uint32_t cell;
    int indoors = -1; /* not asked yet */
    EnfBoxWalk walk;
    enf_box_walk_begin(&walk, &scene->locator->cells, query);
    while ((cell = enf_box_walk_next(&walk)) != ENF_NONE) {
        if (!cell_holds(scene, cell, local, scene->tolerance))
            continue;
        if (enf_is_exterior(scene, cell)) {
            if (indoors < 0)
                indoors = is_indoors(scene, point, local);
            if (indoors)
                continue;
        }
        add(found, cell);
    }
}

/* Portal graphs. A cell that is convex as far as its portals tell holds their hull; cells don't overlap,
 * so a point strictly inside of one hull is in that cell, or in one whose shape is unknown: not convex,
 * or unlimited. */
static void locate_by_portals(const EnfScene *scene, const double point[3], const double local[3], const double query[6], Found *found) {
    uint32_t proven = 0, other, cell;
    EnfBoxWalk walk;
    enf_box_walk_begin(&walk, &scene->locator->hulls, query);
    while (!proven && (cell = enf_box_walk_next(&walk)) != ENF_NONE) {
        if (!scene->locator->graph_convex[cell] || !portals_allow(scene, cell, local))
            continue;
        if (on_portal(scene, cell, point, &other) && scene->locator->graph_convex[other]) {
            add(found, other);
            proven = 1;
        } else if (box_holds_point(scene->cell_bounds[cell], point))
            proven = portals_prove(scene, cell, point) != 0;
        if (proven)
            add(found, cell);
    }
    /* Else all that the planes can't exclude. */
    for (uint32_t i = 0; i < scene->locator->graph_count; i++) {
        uint32_t c = scene->locator->graph_cells[i];
        if (!(proven && scene->locator->graph_convex[c]) && portals_allow(scene, c, local))
            add(found, c);
    }
}

EnfStatus enf_scene_locate(const EnfScene *scene, const double point[3], uint32_t *out_cells, uint32_t capacity, uint32_t *out_count) {
    if (!scene || !point || !out_count || (capacity && !out_cells))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_locate: NULL argument");
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_scene_locate: the scene isn't committed");
    if (!vec_finite(point))
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_locate: the point isn't finite");
    double local[3], query[6];
    vec_sub(local, point, scene->origin);
    vec_copy(query, point);
    vec_copy(query + 3, point);
    Found found = {out_cells, capacity, 0};
    locate_by_faces(scene, point, local, query, &found);
    if (!found.count)
        locate_by_portals(scene, point, local, query, &found);
    *out_count = found.count;
    return ENF_OK;
}
