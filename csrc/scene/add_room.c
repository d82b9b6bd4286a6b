/* SPDX-License-Identifier: GPL-3.0-or-later
 * Adding rooms as people draw them. First form: the convex hull as one cell (safe: larger). */
#include "base/memory.h"
#include "base/status.h"
#include "scene/scene_data.h"

EnfStatus enf_scene_add_room_polyhedron(EnfScene *scene, uint32_t room, const double *vertices, uint64_t vertex_count,
                                        uint64_t vertex_stride, const uint32_t *face_sizes, uint64_t face_count,
                                        const uint32_t *face_indices, uint32_t *out_first_cell, uint32_t *out_cell_count) {
    uint32_t cell;
    EnfStatus status = enf_scene_add_cell(scene, room, ENF_NONE, vertices, vertex_count, vertex_stride, face_sizes, face_count,
                                          face_indices, &cell);
    if (status == ENF_OK) {
        *out_first_cell = cell;
        *out_cell_count = 1;
    }
    return status;
}

EnfStatus enf_scene_add_room_prism(EnfScene *scene, uint32_t room, const double *corners, const uint32_t *ring_sizes,
                                   uint64_t ring_count, double z0, double z1, uint32_t *out_first_cell,
                                   uint32_t *out_cell_count) {
    if (!corners || !ring_sizes || ring_count < 1)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_room_prism: NULL argument");
    uint32_t n = ring_sizes[0];
    double(*vertices)[3] = enf_alloc_array(2 * (uint64_t)n, sizeof *vertices);
    if (!vertices)
        return enf_fail_memory();
    for (uint32_t i = 0; i < n; i++)
        for (int k = 0; k < 2; k++) {
            vertices[2 * i + (uint32_t)k][0] = corners[2 * i];
            vertices[2 * i + (uint32_t)k][1] = corners[2 * i + 1];
            vertices[2 * i + (uint32_t)k][2] = k ? z1 : z0;
        }
    EnfStatus status = enf_scene_add_room_polyhedron(scene, room, vertices[0], 2 * (uint64_t)n, 0, NULL, 0, NULL,
                                                     out_first_cell, out_cell_count);
    enf_free(vertices);
    return status;
}

EnfStatus enf_scene_join(EnfScene *scene, uint32_t side_a_kind, uint32_t side_a, uint32_t side_b_kind, uint32_t side_b,
                         const double *polygon, uint64_t vertex_count, uint64_t vertex_stride, uint32_t opening,
                         uint32_t *out_first_portal, uint32_t *out_portal_count) {
    uint32_t sides[2] = {side_a, side_b}, kinds[2] = {side_a_kind, side_b_kind}, portal;
    for (int s = 0; s < 2; s++)
        if (kinds[s] == ENF_SIDE_ROOM) {
            uint32_t c = 0;
            while (c < scene->cell_count && scene->cell_rooms[c] != sides[s])
                c++;
            if (c == scene->cell_count)
                return enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_join: room %u has no cell", sides[s]);
            sides[s] = c;
        }
    EnfStatus status = enf_scene_add_portal(scene, sides[0], sides[1], polygon, vertex_count, vertex_stride, opening, &portal);
    if (status == ENF_OK) {
        *out_first_portal = portal;
        *out_portal_count = 1;
    }
    return status;
}
