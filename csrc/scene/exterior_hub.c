/* SPDX-License-Identifier: GPL-3.0-or-later
 * The hub: the one exterior cell that goes on for ever, when the outdoors near the building are cells of their own.
 *
 * Nothing marks it in a file; it is known by its portals. They tile the surface of the box that the room's other cells
 * fill, so whoever is in the hub is outside of the box. Where that doesn't hold, an exterior cell without geometry is
 * everything that no other cell is (safe direction: larger). */
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/exterior.h"

/* The box of the room's cells that have geometry; 0 when there is none. */
static int box_of_others(const EnfScene *scene, uint32_t room, double box[6]) {
    box_empty(box);
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (scene->cell_rooms[c] == room)
            for (uint32_t v = scene->cell_vertex_first[c]; v < scene->cell_vertex_first[c + 1]; v++)
                box_add_point(box, scene->cell_vertices[v]);
    return !box_is_empty(box);
}

/* Whether all corners of portal p lie in one side of the box. */
static int in_a_side(const EnfScene *scene, uint32_t p, const double box[6]) {
    for (int side = 0; side < 6; side++) {
        double most = 0.0;
        for (uint32_t v = scene->portal_vertex_first[p]; v < scene->portal_vertex_first[p + 1]; v++)
            most = fmax(most, fabs(scene->portal_vertices[v][side % 3] - box[side]));
        if (most <= scene->tolerance)
            return 1;
    }
    return 0;
}

static int is_sealed(const EnfScene *scene, uint32_t hub, const double box[6]) {
    double area = 0.0, n[3];
    for (uint32_t i = scene->cell_portal_first[hub]; i < scene->cell_portal_first[hub + 1]; i++) {
        uint32_t p = scene->cell_portals[i].portal, first = scene->portal_vertex_first[p];
        if (scene->cell_rooms[scene->cell_portals[i].to] != scene->cell_rooms[hub] || scene->portal_openings[p] != ENF_NONE ||
            !in_a_side(scene, p, box))
            return 0;
        area += enf_polygon_normal(n, scene->portal_vertices + first, scene->portal_vertex_first[p + 1] - first);
    }
    double whole = 2.0 * box_half_area(box);
    return fabs(area - whole) <= 1e-6 * whole;
}

void enf_find_hub(EnfScene *scene) {
    scene->hub = ENF_NONE;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (enf_is_exterior(scene, c) && scene->cell_vertex_first[c] == scene->cell_vertex_first[c + 1] &&
            box_of_others(scene, scene->cell_rooms[c], scene->hub_box) && is_sealed(scene, c, scene->hub_box)) {
            scene->hub = c;
            return;
        }
}
