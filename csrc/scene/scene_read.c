/* SPDX-License-Identifier: GPL-3.0-or-later
 * Reading a scene back: counts, flat views, names; and the one edit that needs no new commit, a door's state.
 */
#include "scene/scene_data.h"
#include "base/status.h"

EnfStatus enf_scene_counts(const EnfScene *scene, EnfSceneCounts *out_counts) {
    if (!scene || !out_counts)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_counts: NULL argument");
    EnfSceneCounts counts = {(uint32_t)sizeof counts,
                             scene->room_count,
                             scene->cell_count,
                             scene->portal_count,
                             scene->opening_count,
                             scene->object_count,
                             scene->light_count,
                             scene->camera_count,
                             0,
                             0,
                             0};
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        const uint32_t *cells = scene->portal_cells[p];
        /* Uncommitted scenes may still hold dangling indices. */
        if (cells[0] < scene->cell_count && cells[1] < scene->cell_count) {
            uint32_t a = scene->cell_rooms[cells[0]], b = scene->cell_rooms[cells[1]];
            counts.seams += a != ENF_NONE && a == b && scene->portal_openings[p] == ENF_NONE;
        }
        uint32_t opening = scene->portal_openings[p];
        counts.closed_portals += opening < scene->opening_count && scene->openings[opening].state == ENF_STATE_CLOSED;
    }
    *out_counts = counts;
    return ENF_OK;
}

const uint32_t *enf_scene_cell_rooms(const EnfScene *scene) {
    return scene ? scene->cell_rooms : NULL;
}
const uint32_t *enf_scene_cell_openings(const EnfScene *scene) {
    return scene ? scene->cell_openings : NULL;
}
const uint32_t *enf_scene_portal_cells(const EnfScene *scene) {
    return scene && scene->portal_cells ? scene->portal_cells[0] : NULL;
}
const uint32_t *enf_scene_portal_openings(const EnfScene *scene) {
    return scene ? scene->portal_openings : NULL;
}
const uint32_t *enf_scene_portal_vertex_first(const EnfScene *scene) {
    return scene ? scene->portal_vertex_first : NULL;
}
const double *enf_scene_portal_vertices(const EnfScene *scene) {
    return scene && scene->portal_vertices ? scene->portal_vertices[0] : NULL;
}
const uint32_t *enf_scene_cell_vertex_first(const EnfScene *scene) {
    return scene ? scene->cell_vertex_first : NULL;
}
const double *enf_scene_cell_vertices(const EnfScene *scene) {
    return scene && scene->cell_vertices ? scene->cell_vertices[0] : NULL;
}

const char *enf_scene_room_name(const EnfScene *scene, uint32_t room) {
    return scene && room < scene->room_count ? scene->rooms[room].name : NULL;
}
uint32_t enf_scene_room_kind(const EnfScene *scene, uint32_t room) {
    return scene && room < scene->room_count ? scene->rooms[room].kind : ENF_NONE;
}
const char *enf_scene_opening_name(const EnfScene *scene, uint32_t opening) {
    return scene && opening < scene->opening_count ? scene->openings[opening].name : NULL;
}
const char *enf_scene_object_name(const EnfScene *scene, uint32_t object) {
    return scene && object < scene->object_count ? scene->objects[object].name : NULL;
}
const char *enf_scene_camera_name(const EnfScene *scene, uint32_t camera) {
    return scene && camera < scene->camera_count ? scene->cameras[camera].name : NULL;
}

EnfStatus enf_scene_opening(const EnfScene *scene, uint32_t opening, uint32_t *out_kind, uint32_t *out_state) {
    if (!scene || opening >= scene->opening_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "opening %u doesn't exist", opening);
    if (out_kind)
        *out_kind = scene->openings[opening].kind;
    if (out_state)
        *out_state = scene->openings[opening].state;
    return ENF_OK;
}

EnfStatus enf_scene_set_opening_state(EnfScene *scene, uint32_t opening, uint32_t state) {
    if (!scene || opening >= scene->opening_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "opening %u doesn't exist", opening);
    if (state > ENF_STATE_GLASS)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "opening %u: state %u is none of open, closed, glass", opening, state);
    scene->state_serial += scene->openings[opening].state != state;
    scene->openings[opening].state = state;
    scene->shut_count -= scene->opening_shut[opening];
    scene->opening_shut[opening] = state == ENF_STATE_CLOSED;
    scene->shut_count += scene->opening_shut[opening];
    return ENF_OK;
}

EnfStatus enf_scene_object_cells(const EnfScene *scene, uint32_t object, const uint32_t **out_cells, uint32_t *out_count) {
    if (!scene || !out_cells || !out_count || object >= scene->object_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object %u doesn't exist, or a NULL argument", object);
    if (scene->committed) {
        *out_cells = scene->placed_cells + scene->placed_first[object];
        *out_count = scene->placed_first[object + 1] - scene->placed_first[object];
    } else {
        *out_cells = scene->object_cells + scene->objects[object].cell_first;
        *out_count = scene->objects[object].cell_count;
    }
    return ENF_OK;
}

EnfStatus enf_scene_camera(const EnfScene *scene, uint32_t camera, EnfCamera *out_camera) {
    if (!scene || !out_camera || camera >= scene->camera_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "camera %u doesn't exist, or a NULL argument", camera);
    *out_camera = scene->cameras[camera].camera;
    return ENF_OK;
}
