/* SPDX-License-Identifier: GPL-3.0-or-later
 * A portal between rooms, split among their cells. */
#include "base/memory.h"
#include "base/status.h"
#include "scene/scene_data.h"

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
