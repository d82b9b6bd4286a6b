/* SPDX-License-Identifier: GPL-3.0-or-later
 * The scene's life: create, add, destroy. What is added is only copied here; commit.c and validate.c judge
 * it. */
#include "scene/scene_data.h"
#include "base/memory.h"
#include "base/status.h"
#include "scene/commit.h"
#include "scene/extras.h"
#include "scene/problems.h"
#include "scene/room_shapes.h"

#include <math.h>
#include <string.h>

EnfStatus enf_scene_create(EnfScene **out_scene) {
    if (!out_scene)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_create: out_scene is NULL");
    EnfScene *scene = ENF_NEW(EnfScene, 1);
    /* The [count + 1] arrays begin with their zero; those that are indexed by offsets exist even when empty,
     * because C knows no NULL + 0. */
    if (!scene || !ENF_RESERVE(scene->cell_vertex_first, 1) || !ENF_RESERVE(scene->cell_face_first, 1) ||
        !ENF_RESERVE(scene->face_index_first, 1) || !ENF_RESERVE(scene->portal_vertex_first, 1) || !ENF_RESERVE(scene->cell_vertices, 1) ||
        !ENF_RESERVE(scene->face_indices, 1) || !ENF_RESERVE(scene->portal_vertices, 1) || !ENF_RESERVE(scene->object_cells, 1)) {
        enf_scene_destroy(scene);
        return enf_fail_memory();
    }
    scene->cell_vertex_first[0] = scene->cell_face_first[0] = 0;
    scene->face_index_first[0] = scene->portal_vertex_first[0] = 0;
    scene->hub = ENF_NONE;
    *out_scene = scene;
    return ENF_OK;
}

void enf_scene_destroy(EnfScene *scene) {
    if (!scene)
        return;
    enf_scene_drop_derived(scene);
    for (uint32_t i = 0; i < scene->room_count; i++)
        enf_free(scene->rooms[i].name);
    for (uint32_t i = 0; i < scene->opening_count; i++)
        enf_free(scene->openings[i].name);
    for (uint32_t i = 0; i < scene->object_count; i++)
        enf_free(scene->objects[i].name);
    for (uint32_t i = 0; i < scene->light_count; i++)
        enf_free(scene->lights[i].name);
    for (uint32_t i = 0; i < scene->camera_count; i++)
        enf_free(scene->cameras[i].name);
    enf_free(scene->rooms);
    enf_free(scene->openings);
    enf_free(scene->opening_shut);
    enf_free(scene->objects);
    enf_free(scene->object_cells);
    enf_free(scene->occluders);
    enf_free(scene->occluder_corner_first);
    enf_free(scene->occluder_corners);
    enf_free(scene->lights);
    enf_free(scene->cameras);
    enf_free(scene->cell_rooms);
    enf_free(scene->cell_openings);
    enf_free(scene->cell_vertex_first);
    enf_free(scene->cell_vertices);
    enf_free(scene->cell_face_first);
    enf_free(scene->face_index_first);
    enf_free(scene->face_indices);
    enf_free(scene->portal_cells);
    enf_free(scene->portal_openings);
    enf_free(scene->portal_vertex_first);
    enf_free(scene->portal_vertices);
    enf_problems_destroy(scene->problems);
    enf_extras_destroy(scene->extras);
    enf_room_shapes_destroy(scene->shapes);
    enf_free(scene);
}

/* Room for one more element whose index stays below ENF_NONE. */
#define GROW(array, count) ((count) < ENF_NONE - 1 && ENF_RESERVE(array, (uint64_t)(count) + 1))

/* double[3] elements with any stride, which needn't be a multiple of 8. */
static void copy_points(double (*out)[3], const double *points, uint64_t count, uint64_t stride) {
    if (stride == 0)
        stride = 3 * sizeof(double);
    const char *from = (const char *)points;
    for (uint64_t i = 0; i < count; i++)
        memcpy(out[i], from + i * stride, 3 * sizeof(double));
}

EnfStatus enf_scene_add_room(EnfScene *scene, const char *name, uint32_t kind, uint32_t *out_room) {
    if (!scene)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_room: scene is NULL");
    char *copy = enf_strdup(name ? name : "");
    if (!copy || !GROW(scene->rooms, scene->room_count)) {
        enf_free(copy);
        return enf_fail_memory();
    }
    scene->committed = 0;
    scene->rooms[scene->room_count] = (EnfRoomData){copy, kind, 0};
    if (out_room)
        *out_room = scene->room_count;
    scene->room_count++;
    return ENF_OK;
}

EnfStatus enf_scene_add_cell(EnfScene *scene, uint32_t room, uint32_t opening, const double *vertices, uint64_t vertex_count,
                             uint64_t vertex_stride, const uint32_t *face_sizes, uint64_t face_count, const uint32_t *face_indices,
                             uint32_t *out_cell) {
    if (!scene || (vertex_count && !vertices) || (face_count && !face_sizes))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_cell: NULL argument");
    uint64_t index_count = 0;
    for (uint64_t f = 0; f < face_count; f++)
        index_count += face_sizes[f];
    if (index_count && !face_indices)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_cell: face_indices is NULL");
    uint32_t c = scene->cell_count;
    uint64_t v = scene->cell_vertex_first[c], f0 = scene->cell_face_first[c], i0 = scene->face_index_first[f0];
    if (vertex_count >= ENF_NONE - v || face_count >= ENF_NONE - f0 || index_count >= ENF_NONE - i0 || c >= ENF_NONE - 1)
        return enf_fail(ENF_ERROR_BAD_INPUT, "cell %u: too many cells, vertices or faces for 32-bit indices", c);
    if (!ENF_RESERVE(scene->cell_rooms, (uint64_t)c + 1) || !ENF_RESERVE(scene->cell_openings, (uint64_t)c + 1) ||
        !ENF_RESERVE(scene->cell_vertex_first, (uint64_t)c + 2) || !ENF_RESERVE(scene->cell_face_first, (uint64_t)c + 2) ||
        !ENF_RESERVE(scene->cell_vertices, v + vertex_count) || !ENF_RESERVE(scene->face_index_first, f0 + face_count + 1) ||
        !ENF_RESERVE(scene->face_indices, i0 + index_count))
        return enf_fail_memory();
    scene->committed = 0;
    scene->cell_rooms[c] = room;
    scene->cell_openings[c] = opening;
    if (vertex_count)
        copy_points(scene->cell_vertices + v, vertices, vertex_count, vertex_stride);
    scene->cell_vertex_first[c + 1] = (uint32_t)(v + vertex_count);
    uint64_t at = i0;
    for (uint64_t f = 0; f < face_count; f++) {
        at += face_sizes[f];
        scene->face_index_first[f0 + f + 1] = (uint32_t)at;
    }
    if (index_count)
        memcpy(scene->face_indices + i0, face_indices, (size_t)index_count * sizeof *face_indices);
    scene->cell_face_first[c + 1] = (uint32_t)(f0 + face_count);
    scene->cell_count++;
    if (out_cell)
        *out_cell = c;
    return ENF_OK;
}

EnfStatus enf_scene_add_portal(EnfScene *scene, uint32_t cell_a, uint32_t cell_b, const double *polygon, uint64_t vertex_count,
                               uint64_t vertex_stride, uint32_t opening, uint32_t *out_portal) {
    if (!scene || (vertex_count && !polygon))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_portal: NULL argument");
    uint32_t p = scene->portal_count;
    uint64_t v = scene->portal_vertex_first[p];
    if (vertex_count >= ENF_NONE - v || p >= ENF_NONE - 1)
        return enf_fail(ENF_ERROR_BAD_INPUT, "portal %u: too many portals or vertices for 32-bit indices", p);
    if (!ENF_RESERVE(scene->portal_cells, (uint64_t)p + 1) || !ENF_RESERVE(scene->portal_openings, (uint64_t)p + 1) ||
        !ENF_RESERVE(scene->portal_vertex_first, (uint64_t)p + 2) || !ENF_RESERVE(scene->portal_vertices, v + vertex_count))
        return enf_fail_memory();
    scene->committed = 0;
    scene->portal_cells[p][0] = cell_a;
    scene->portal_cells[p][1] = cell_b;
    scene->portal_openings[p] = opening;
    if (vertex_count)
        copy_points(scene->portal_vertices + v, polygon, vertex_count, vertex_stride);
    scene->portal_vertex_first[p + 1] = (uint32_t)(v + vertex_count);
    scene->portal_count++;
    if (out_portal)
        *out_portal = p;
    return ENF_OK;
}

EnfStatus enf_scene_add_opening(EnfScene *scene, const char *name, uint32_t kind, uint32_t state, uint32_t *out_opening) {
    if (!scene)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_opening: scene is NULL");
    char *copy = enf_strdup(name ? name : "");
    if (!copy || !GROW(scene->openings, scene->opening_count) || !GROW(scene->opening_shut, scene->opening_count)) {
        enf_free(copy);
        return enf_fail_memory();
    }
    scene->committed = 0;
    scene->openings[scene->opening_count] = (EnfOpeningData){copy, kind, state};
    scene->opening_shut[scene->opening_count] = state == ENF_STATE_CLOSED;
    scene->shut_count += scene->opening_shut[scene->opening_count];
    if (out_opening)
        *out_opening = scene->opening_count;
    scene->opening_count++;
    return ENF_OK;
}

EnfStatus enf_scene_add_object(EnfScene *scene, const char *name, const double bounds[6], const uint32_t *cells, uint64_t cell_count,
                               uint32_t mesh, uint32_t *out_object) {
    if (!scene || !bounds || (cell_count && !cells))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_object: NULL argument");
    uint64_t first = scene->object_cell_count;
    if (cell_count >= ENF_NONE - first)
        return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: too many cells for 32-bit indices", scene->object_count);
    char *copy = enf_strdup(name ? name : "");
    if (!copy || !GROW(scene->objects, scene->object_count) || !ENF_RESERVE(scene->object_cells, first + cell_count)) {
        enf_free(copy);
        return enf_fail_memory();
    }
    scene->committed = 0;
    EnfObjectData *object = &scene->objects[scene->object_count];
    object->name = copy;
    memcpy(object->bounds, bounds, sizeof object->bounds);
    object->cell_first = (uint32_t)first;
    object->cell_count = (uint32_t)cell_count;
    object->mesh = mesh;
    object->occluder = ENF_NONE;
    if (cell_count)
        memcpy(scene->object_cells + first, cells, (size_t)cell_count * sizeof *cells);
    scene->object_cell_count = (uint32_t)(first + cell_count);
    if (out_object)
        *out_object = scene->object_count;
    scene->object_count++;
    return ENF_OK;
}

EnfStatus enf_scene_add_light(EnfScene *scene, const char *name, const double position[3], uint32_t *out_light) {
    if (!scene || !position)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_light: NULL argument");
    char *copy = enf_strdup(name ? name : "");
    if (!copy || !GROW(scene->lights, scene->light_count)) {
        enf_free(copy);
        return enf_fail_memory();
    }
    scene->committed = 0;
    EnfLightData *light = &scene->lights[scene->light_count];
    light->name = copy;
    memcpy(light->position, position, sizeof light->position);
    if (out_light)
        *out_light = scene->light_count;
    scene->light_count++;
    return ENF_OK;
}

EnfCamera enf_default_camera(void) {
    EnfCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.struct_size = (uint32_t)sizeof camera;
    camera.type = ENF_CAMERA_PERSP;
    for (int k = 0; k < 4; k++)
        camera.world_from_camera[5 * k] = 1.0;
    /* Blender's own defaults: 50 mm on a 36 mm sensor at 16:9. */
    camera.angle_x = 2.0 * atan(36.0 / 100.0);
    camera.angle_y = 2.0 * atan(36.0 / 100.0 * 9.0 / 16.0);
    camera.ortho_width = 6.0;
    camera.ortho_height = 6.0 * 9.0 / 16.0;
    camera.clip_near = 0.1;
    camera.clip_far = 1000.0;
    return camera;
}

EnfStatus enf_scene_add_camera(EnfScene *scene, const char *name, const EnfCamera *camera, uint32_t *out_camera) {
    if (!scene || !camera)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_camera: NULL argument");
    if (camera->struct_size != sizeof *camera)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "camera %u: struct_size %u, expected %u: start from enf_default_camera()",
                        scene->camera_count, camera->struct_size, (unsigned)sizeof *camera);
    char *copy = enf_strdup(name ? name : "");
    if (!copy || !GROW(scene->cameras, scene->camera_count)) {
        enf_free(copy);
        return enf_fail_memory();
    }
    scene->committed = 0;
    scene->cameras[scene->camera_count].name = copy;
    scene->cameras[scene->camera_count].camera = *camera;
    if (out_camera)
        *out_camera = scene->camera_count;
    scene->camera_count++;
    return ENF_OK;
}
