/* SPDX-License-Identifier: GPL-3.0-or-later
 * Judging values, indices and enums: whatever would make the later steps fall over. */
#include "scene/validate.h"
#include "geometry/vec3.h"
#include "scene/problems.h"

#define ERROR(item, index, code, ...) enf_problem_add(scene, ENF_SEVERITY_ERROR, item, index, code, NULL, __VA_ARGS__)

/* Coordinates whose squares' products overflow can't be computed with. [Unit: metres] */
#define HUGE_COORDINATE 1e60

static void check_points(EnfScene *scene, uint32_t item, uint32_t index, double (*points)[3], uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const double *p = points[i];
        if (!vec_finite(p)) {
            ERROR(item, index, ENF_PROBLEM_NOT_FINITE, "vertex %u is not finite (%g, %g, %g)", i, p[0], p[1], p[2]);
            return;
        }
        if (fabs(p[0]) > HUGE_COORDINATE || fabs(p[1]) > HUGE_COORDINATE || fabs(p[2]) > HUGE_COORDINATE) {
            ERROR(item, index, ENF_PROBLEM_HUGE_COORDINATE, "vertex %u is too far out (%g, %g, %g)", i, p[0], p[1], p[2]);
            return;
        }
    }
}

static void check_cells(EnfScene *scene) {
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        uint32_t room = scene->cell_rooms[c], opening = scene->cell_openings[c];
        uint32_t first = scene->cell_vertex_first[c], count = scene->cell_vertex_first[c + 1] - first;
        if (room != ENF_NONE && room >= scene->room_count)
            ERROR(ENF_ITEM_CELL, c, ENF_PROBLEM_DANGLING_INDEX, "room %u doesn't exist (%u rooms)", room, scene->room_count);
        if (opening != ENF_NONE && opening >= scene->opening_count)
            ERROR(ENF_ITEM_CELL, c, ENF_PROBLEM_DANGLING_INDEX, "opening %u doesn't exist (%u openings)", opening, scene->opening_count);
        check_points(scene, ENF_ITEM_CELL, c, scene->cell_vertices + first, count);
        for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
            uint32_t local = f - scene->cell_face_first[c];
            uint32_t begin = scene->face_index_first[f], end = scene->face_index_first[f + 1];
            if (end - begin < 3)
                ERROR(ENF_ITEM_CELL, c, ENF_PROBLEM_CELL_BAD_FACE, "face %u has %u corners, at least 3 are needed", local, end - begin);
            for (uint32_t i = begin; i < end; i++)
                if (scene->face_indices[i] >= count) {
                    ERROR(ENF_ITEM_CELL, c, ENF_PROBLEM_DANGLING_INDEX, "face %u: vertex %u doesn't exist (%u vertices)", local,
                          scene->face_indices[i], count);
                    break;
                }
        }
    }
}

static void check_portals(EnfScene *scene) {
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        const uint32_t *cells = scene->portal_cells[p];
        uint32_t first = scene->portal_vertex_first[p], count = scene->portal_vertex_first[p + 1] - first;
        for (int side = 0; side < 2; side++)
            if (cells[side] >= scene->cell_count)
                ERROR(ENF_ITEM_PORTAL, p, ENF_PROBLEM_DANGLING_INDEX, "cell %u doesn't exist (%u cells)", cells[side], scene->cell_count);
        if (cells[0] == cells[1])
            ERROR(ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_SELF, "joins cell %u with itself", cells[0]);
        if (scene->portal_openings[p] != ENF_NONE && scene->portal_openings[p] >= scene->opening_count)
            ERROR(ENF_ITEM_PORTAL, p, ENF_PROBLEM_DANGLING_INDEX, "opening %u doesn't exist (%u openings)", scene->portal_openings[p],
                  scene->opening_count);
        if (count < 3)
            ERROR(ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_TOO_FEW_VERTICES, "%u vertices, at least 3 are needed", count);
        check_points(scene, ENF_ITEM_PORTAL, p, scene->portal_vertices + first, count);
    }
}

static void check_objects(EnfScene *scene) {
    for (uint32_t o = 0; o < scene->object_count; o++) {
        const EnfObjectData *object = &scene->objects[o];
        if (!vec_finite(object->bounds) || !vec_finite(object->bounds + 3))
            ERROR(ENF_ITEM_OBJECT, o, ENF_PROBLEM_NOT_FINITE, "\"%.60s\": bounds are not finite", object->name);
        else if (box_is_empty(object->bounds))
            ERROR(ENF_ITEM_OBJECT, o, ENF_PROBLEM_BAD_BOUNDS, "\"%.60s\": bounds have a minimum above their maximum", object->name);
        for (uint32_t i = 0; i < object->cell_count; i++)
            if (scene->object_cells[object->cell_first + i] >= scene->cell_count) {
                ERROR(ENF_ITEM_OBJECT, o, ENF_PROBLEM_DANGLING_INDEX, "\"%.60s\": cell %u doesn't exist (%u cells)", object->name,
                      scene->object_cells[object->cell_first + i], scene->cell_count);
                break;
            }
    }
}

static void check_cameras(EnfScene *scene) {
    for (uint32_t i = 0; i < scene->camera_count; i++) {
        const EnfCamera *camera = &scene->cameras[i].camera;
        const char *name = scene->cameras[i].name;
        int finite = 1;
        for (int k = 0; k < 16; k++)
            finite &= isfinite(camera->world_from_camera[k]) != 0;
        const double values[] = {camera->angle_x,     camera->angle_y,      camera->shift_x,   camera->shift_y,
                                 camera->ortho_width, camera->ortho_height, camera->clip_near, camera->clip_far};
        for (int k = 0; k < 8; k++)
            finite &= isfinite(values[k]) != 0;
        if (!finite) {
            ERROR(ENF_ITEM_CAMERA, i, ENF_PROBLEM_NOT_FINITE, "\"%.60s\": matrix, angles or clip are not finite", name);
            continue;
        }
        if (camera->type > ENF_CAMERA_PANO)
            ERROR(ENF_ITEM_CAMERA, i, ENF_PROBLEM_BAD_ENUM, "\"%.60s\": type %u is unknown", name, camera->type);
        if (camera->type == ENF_CAMERA_PERSP &&
            (!(camera->angle_x > 0.0) || !(camera->angle_y > 0.0) || camera->angle_x >= 3.1415926535 || camera->angle_y >= 3.1415926535))
            ERROR(ENF_ITEM_CAMERA, i, ENF_PROBLEM_BAD_CAMERA, "\"%.60s\": field of view %g x %g isn't between 0 and pi", name,
                  camera->angle_x, camera->angle_y);
        if (camera->type == ENF_CAMERA_ORTHO && (!(camera->ortho_width > 0.0) || !(camera->ortho_height > 0.0)))
            ERROR(ENF_ITEM_CAMERA, i, ENF_PROBLEM_BAD_CAMERA, "\"%.60s\": orthographic size %g x %g isn't positive", name,
                  camera->ortho_width, camera->ortho_height);
        if (!(camera->clip_far > camera->clip_near) || camera->clip_near < 0.0)
            ERROR(ENF_ITEM_CAMERA, i, ENF_PROBLEM_BAD_CAMERA, "\"%.60s\": clip from %g to %g is empty", name, camera->clip_near,
                  camera->clip_far);
    }
}

void enf_validate_values(EnfScene *scene) {
    for (uint32_t r = 0; r < scene->room_count; r++)
        if (scene->rooms[r].kind > ENF_ROOM_EXTERIOR)
            ERROR(ENF_ITEM_ROOM, r, ENF_PROBLEM_BAD_ENUM, "kind %u is unknown", scene->rooms[r].kind);
    for (uint32_t i = 0; i < scene->opening_count; i++)
        if (scene->openings[i].kind > ENF_OPENING_VIRTUAL || scene->openings[i].state > ENF_STATE_GLASS)
            ERROR(ENF_ITEM_OPENING, i, ENF_PROBLEM_BAD_ENUM, "kind %u or state %u is unknown", scene->openings[i].kind,
                  scene->openings[i].state);
    check_cells(scene);
    check_portals(scene);
    check_objects(scene);
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (!vec_finite(scene->lights[i].position))
            ERROR(ENF_ITEM_LIGHT, i, ENF_PROBLEM_NOT_FINITE, "\"%.60s\": position is not finite", scene->lights[i].name);
    check_cameras(scene);
}
