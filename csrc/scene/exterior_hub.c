/* SPDX-License-Identifier: GPL-3.0-or-later
 * The hub: the one exterior cell that goes on for ever, when the outdoors near the building are cells of their own.
 *
 * Nothing marks it in a file; it is known by its portals. They tile the surface of the box that the room's other cells
 * fill, so whoever is in the hub is outside of the box. The box stands as the scene does: turned, when the scene was turned
 * after it was cut. Where that doesn't hold, an exterior cell without geometry is everything that no other cell is (safe
 * direction: larger). */
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/exterior.h"

static double portal_area(const EnfScene *scene, uint32_t p) {
    double n[3];
    uint32_t first = scene->portal_vertex_first[p];
    return enf_polygon_normal(n, scene->portal_vertices + first, scene->portal_vertex_first[p + 1] - first);
}

/* The plane of the hub's largest portal whose normal lies across `axis` (NULL: any); ENF_NONE: there is none. */
static uint32_t largest_portal(const EnfScene *scene, uint32_t hub, const double *axis) {
    uint32_t best = ENF_NONE;
    double most = 0.0;
    for (uint32_t i = scene->cell_portal_first[hub]; i < scene->cell_portal_first[hub + 1]; i++) {
        uint32_t p = scene->cell_portals[i].portal;
        double area = portal_area(scene, p);
        if (area > most && !(axis && fabs(vec_dot(scene->portal_planes[p].n, axis)) > 0.5)) {
            most = area;
            best = p;
        }
    }
    return best;
}

/* An axis-parallel direction gets exactly its axis, so that such a box is what its corners say. */
static void straighten(double n[3]) {
    for (int k = 0; k < 3; k++)
        if (fabs(n[k]) > 1.0 - 1e-14)
            vec_set(n, k == 0, k == 1, k == 2);
}

/* Three directions of the hub's portals, each where it is the most like the scene's axis of that number if that can be. */
static int find_axes(EnfScene *scene, uint32_t hub) {
    double axes[3][3], unused[3];
    uint32_t p = largest_portal(scene, hub, NULL), q = p == ENF_NONE ? p : largest_portal(scene, hub, scene->portal_planes[p].n);
    if (q == ENF_NONE)
        return 0;
    vec_copy(axes[0], scene->portal_planes[p].n);
    straighten(axes[0]);
    vec_mad(axes[1], scene->portal_planes[q].n, -vec_dot(axes[0], scene->portal_planes[q].n), axes[0]);
    if (!(vec_normalize(axes[1]) > 0.5))
        return 0;
    straighten(axes[1]);
    vec_cross(axes[2], axes[0], axes[1]);
    straighten(axes[2]);
    for (int k = 0; k < 3; k++)
        for (int i = k + 1; i < 3; i++)
            if (fabs(axes[i][k]) > fabs(axes[k][k])) {
                vec_copy(unused, axes[i]);
                vec_copy(axes[i], axes[k]);
                vec_copy(axes[k], unused);
            }
    memcpy(scene->hub_axes, axes, sizeof axes);
    return 1;
}

static void along_axes(const EnfScene *scene, const double local[3], double out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = vec_dot(scene->hub_axes[k], local);
}

/* The box of the room's cells that have geometry, along the hub's axes; 0 when there is none. */
static int box_of_others(EnfScene *scene, uint32_t room) {
    box_empty(scene->hub_box);
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (scene->cell_rooms[c] == room)
            for (uint32_t v = scene->cell_vertex_first[c]; v < scene->cell_vertex_first[c + 1]; v++) {
                double local[3], at[3];
                vec_sub(local, scene->cell_vertices[v], scene->origin);
                along_axes(scene, local, at);
                box_add_point(scene->hub_box, at);
            }
    return !box_is_empty(scene->hub_box);
}

/* Whether all corners of portal p lie in one side of the box. */
static int in_a_side(const EnfScene *scene, uint32_t p) {
    for (int side = 0; side < 6; side++) {
        double most = 0.0;
        for (uint32_t v = scene->portal_vertex_first[p]; v < scene->portal_vertex_first[p + 1]; v++) {
            double local[3], at[3];
            vec_sub(local, scene->portal_vertices[v], scene->origin);
            along_axes(scene, local, at);
            most = fmax(most, fabs(at[side % 3] - scene->hub_box[side]));
        }
        if (most <= scene->tolerance)
            return 1;
    }
    return 0;
}

static int is_sealed(const EnfScene *scene, uint32_t hub) {
    double area = 0.0, whole = 2.0 * box_half_area(scene->hub_box);
    for (uint32_t i = scene->cell_portal_first[hub]; i < scene->cell_portal_first[hub + 1]; i++) {
        uint32_t p = scene->cell_portals[i].portal;
        if (scene->cell_rooms[scene->cell_portals[i].to] != scene->cell_rooms[hub] || scene->portal_openings[p] != ENF_NONE ||
            !in_a_side(scene, p))
            return 0;
        area += portal_area(scene, p);
    }
    return fabs(area - whole) <= 1e-6 * whole;
}

void enf_find_hub(EnfScene *scene) {
    scene->hub = ENF_NONE;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (enf_is_exterior(scene, c) && scene->cell_vertex_first[c] == scene->cell_vertex_first[c + 1] && find_axes(scene, c) &&
            box_of_others(scene, scene->cell_rooms[c]) && is_sealed(scene, c)) {
            scene->hub = c;
            return;
        }
}

int enf_hub_holds(const EnfScene *scene, const double local[3]) {
    double at[3];
    along_axes(scene, local, at);
    for (int k = 0; k < 3; k++)
        if (at[k] < scene->hub_box[k] + scene->tolerance || at[k] > scene->hub_box[3 + k] - scene->tolerance)
            return 1;
    return 0;
}

int enf_hub_touches(const EnfScene *scene, const double box[6]) {
    double middle[3];
    for (int k = 0; k < 3; k++)
        middle[k] = 0.5 * (box[k] + box[3 + k]) - scene->origin[k];
    for (int k = 0; k < 3; k++) {
        double at = vec_dot(scene->hub_axes[k], middle), reach = 0.0;
        for (int i = 0; i < 3; i++)
            reach += 0.5 * (box[3 + i] - box[i]) * fabs(scene->hub_axes[k][i]);
        if (at - reach < scene->hub_box[k] || at + reach > scene->hub_box[3 + k])
            return 1;
    }
    return 0;
}
