/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells hold a point. */
#include "scene/point_location.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"

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
    return ok;
}

void enf_locator_destroy(EnfLocator *locator) {
    if (!locator)
        return;
    enf_box_tree_free(&locator->cells);
    enf_box_tree_free(&locator->hulls);
    enf_free(locator);
}

/* Faces only: behind every one, up to the tolerance. */
static int cell_holds(const EnfScene *scene, uint32_t c, const double local[3]) {
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++)
        if (vec_dot(scene->face_planes[f].n, local) - scene->face_planes[f].d > scene->tolerance)
            return 0;
    return 1;
}

/* Portals only: on the cell's own side of every one, up to the tolerance. The exterior's cell is everything that no other cell
 * holds: it isn't convex, so no plane of a portal excludes it. */
static int portals_allow(const EnfScene *scene, uint32_t c, const double local[3]) {
    uint32_t room = scene->cell_rooms[c];
    if (room != ENF_NONE && scene->rooms[room].kind == ENF_ROOM_EXTERIOR)
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

EnfStatus enf_scene_locate(const EnfScene *scene, const double point[3], uint32_t *out_cells, uint32_t capacity,
                           uint32_t *out_count) {
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
    uint32_t count = 0, cell;
    EnfBoxWalk walk;
    enf_box_walk_begin(&walk, &scene->locator->cells, query);
    while ((cell = enf_box_walk_next(&walk)) != ENF_NONE)
        if (cell_holds(scene, cell, local)) {
            if (count < capacity)
                out_cells[count] = cell;
            count++;
        }
    /* Portal graphs: what the planes can't exclude. */
    if (count == 0)
        for (uint32_t c = 0; c < scene->cell_count; c++)
            if (scene->cell_face_first[c] == scene->cell_face_first[c + 1] && portals_allow(scene, c, local)) {
                if (count < capacity)
                    out_cells[count] = c;
                count++;
            }
    *out_count = count;
    return ENF_OK;
}
