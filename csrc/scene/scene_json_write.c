/* SPDX-License-Identifier: GPL-3.0-or-later
 * Writing *.enf.json: one item a line, numbers as the shortest text that reads back the same, unknown keys as
 * they came. */
#include "base/file.h"
#include "base/json_text.h"
#include "base/number.h"
#include "base/status.h"
#include "scene/extras.h"

#include <inttypes.h>

typedef struct Writer {
    const EnfScene *scene;
    FILE *file;
    int comma; /* the next key of the open object needs one before it */
} Writer;

static void put_number(Writer *w, double value) {
    char text[32];
    enf_number_format(text, value);
    fputs(text, w->file);
}

static void put_numbers(Writer *w, const double *values, int count) {
    fputc('[', w->file);
    for (int i = 0; i < count; i++) {
        if (i)
            fputs(", ", w->file);
        put_number(w, values[i]);
    }
    fputc(']', w->file);
}

static void put_points(Writer *w, double (*points)[3], uint32_t count) {
    fputc('[', w->file);
    for (uint32_t i = 0; i < count; i++) {
        if (i)
            fputs(", ", w->file);
        put_numbers(w, points[i], 3);
    }
    fputc(']', w->file);
}

static void put_indices(Writer *w, const uint32_t *indices, uint32_t count) {
    fputc('[', w->file);
    for (uint32_t i = 0; i < count; i++)
        fprintf(w->file, i ? ", %" PRIu32 : "%" PRIu32, indices[i]);
    fputc(']', w->file);
}

static void put_key(Writer *w, const char *key) {
    fprintf(w->file, w->comma ? ", \"%s\": " : "\"%s\": ", key);
    w->comma = 1;
}

static void put_index_key(Writer *w, const char *key, uint32_t index) {
    if (index != ENF_NONE) {
        put_key(w, key);
        fprintf(w->file, "%" PRIu32, index);
    }
}

static void put_extras(Writer *w, uint32_t item, uint32_t index, const char *separator) {
    uint64_t first = 0, count = enf_extras_find(w->scene->extras, item, index, &first);
    for (uint64_t i = first; i < first + count; i++) {
        const EnfExtra *extra = &w->scene->extras->items[i];
        fputs(w->comma ? separator : "", w->file);
        fwrite(w->scene->extras->text + extra->text, 1, (size_t)extra->size, w->file);
        w->comma = 1;
    }
}

static void put_room(Writer *w, uint32_t i) {
    static const char *const kinds[] = {"interior", "exterior"};
    put_key(w, "name");
    enf_json_put_string(w->file, w->scene->rooms[i].name);
    put_key(w, "kind");
    enf_json_put_string(w->file, kinds[w->scene->rooms[i].kind <= ENF_ROOM_EXTERIOR ? w->scene->rooms[i].kind : 0]);
}

static void put_cell(Writer *w, uint32_t i) {
    const EnfScene *s = w->scene;
    uint32_t vertices = s->cell_vertex_first[i + 1] - s->cell_vertex_first[i];
    put_index_key(w, "room", s->cell_rooms[i]);
    put_index_key(w, "opening", s->cell_openings[i]);
    if (vertices) {
        put_key(w, "vertices");
        put_points(w, s->cell_vertices + s->cell_vertex_first[i], vertices);
    }
    if (s->cell_face_first[i] < s->cell_face_first[i + 1]) {
        put_key(w, "faces");
        fputc('[', w->file);
        for (uint32_t f = s->cell_face_first[i]; f < s->cell_face_first[i + 1]; f++) {
            if (f > s->cell_face_first[i])
                fputs(", ", w->file);
            put_indices(w, s->face_indices + s->face_index_first[f], s->face_index_first[f + 1] - s->face_index_first[f]);
        }
        fputc(']', w->file);
    }
}

static void put_portal(Writer *w, uint32_t i) {
    const EnfScene *s = w->scene;
    put_key(w, "cells");
    put_indices(w, s->portal_cells[i], 2);
    put_key(w, "polygon");
    put_points(w, s->portal_vertices + s->portal_vertex_first[i], s->portal_vertex_first[i + 1] - s->portal_vertex_first[i]);
    put_index_key(w, "opening", s->portal_openings[i]);
}

static void put_opening(Writer *w, uint32_t i) {
    static const char *const kinds[] = {"door", "window", "hole", "virtual"}, *const states[] = {"open", "closed", "glass"};
    const EnfOpeningData *opening = &w->scene->openings[i];
    put_key(w, "name");
    enf_json_put_string(w->file, opening->name);
    put_key(w, "kind");
    enf_json_put_string(w->file, kinds[opening->kind <= ENF_OPENING_VIRTUAL ? opening->kind : ENF_OPENING_HOLE]);
    put_key(w, "state");
    enf_json_put_string(w->file, states[opening->state <= ENF_STATE_GLASS ? opening->state : ENF_STATE_OPEN]);
}

static void put_object(Writer *w, uint32_t i) {
    const EnfObjectData *object = &w->scene->objects[i];
    put_key(w, "name");
    enf_json_put_string(w->file, object->name);
    put_key(w, "bounds");
    fputc('[', w->file);
    put_numbers(w, object->bounds, 3);
    fputs(", ", w->file);
    put_numbers(w, object->bounds + 3, 3);
    fputc(']', w->file);
    if (object->cell_count) {
        put_key(w, "cells");
        put_indices(w, w->scene->object_cells + object->cell_first, object->cell_count);
    }
    put_index_key(w, "mesh", object->mesh);
    if (object->occluder == ENF_NONE)
        return;
    const EnfOccluderData *occluder = &w->scene->occluders[object->occluder];
    const uint32_t *first = w->scene->occluder_corner_first + occluder->polygon_first;
    put_key(w, "occluder");
    if (occluder->whole) {
        fputs("\"bounds\"", w->file);
        return;
    }
    for (uint32_t p = 0; p < occluder->polygon_count; p++) {
        fputs(p ? ", " : "[", w->file);
        put_points(w, w->scene->occluder_corners + first[p], first[p + 1] - first[p]);
    }
    fputc(']', w->file);
}

static void put_light(Writer *w, uint32_t i) {
    put_key(w, "name");
    enf_json_put_string(w->file, w->scene->lights[i].name);
    put_key(w, "position");
    put_numbers(w, w->scene->lights[i].position, 3);
}

static void put_pair(Writer *w, const char *key, double a, double b) {
    double pair[2] = {a, b};
    put_key(w, key);
    put_numbers(w, pair, 2);
}

static void put_camera(Writer *w, uint32_t i) {
    static const char *const types[] = {"PERSP", "ORTHO", "PANO"};
    const EnfCamera *camera = &w->scene->cameras[i].camera;
    put_key(w, "name");
    enf_json_put_string(w->file, w->scene->cameras[i].name);
    put_key(w, "matrix_world");
    fputc('[', w->file);
    for (int row = 0; row < 4; row++) {
        if (row)
            fputs(", ", w->file);
        put_numbers(w, camera->world_from_camera + 4 * row, 4);
    }
    fputc(']', w->file);
    put_key(w, "type");
    enf_json_put_string(w->file, types[camera->type <= ENF_CAMERA_PANO ? camera->type : 0]);
    put_key(w, "angle_x");
    put_number(w, camera->angle_x);
    put_key(w, "angle_y");
    put_number(w, camera->angle_y);
    put_pair(w, "clip", camera->clip_near, camera->clip_far);
    if (camera->shift_x != 0.0 || camera->shift_y != 0.0)
        put_pair(w, "shift", camera->shift_x, camera->shift_y);
    if (camera->type == ENF_CAMERA_ORTHO)
        put_pair(w, "ortho_size", camera->ortho_width, camera->ortho_height);
}

static void put_items(Writer *w, const char *key, uint32_t item, uint32_t count, void (*put)(Writer *, uint32_t)) {
    if (count == 0 && item > ENF_ITEM_PORTAL)
        return; /* openings, objects, lights, cameras may be absent */
    fprintf(w->file, ",\n \"%s\": [", key);
    for (uint32_t i = 0; i < count; i++) {
        fputs(i ? ",\n  {" : "\n  {", w->file);
        w->comma = 0;
        put(w, i);
        put_extras(w, item, i, ", ");
        fputc('}', w->file);
    }
    fputc(']', w->file);
}

/* JSON has no NaN: such a scene must not become a file that can't be read. */
static EnfStatus check_finite(const double *values, uint64_t count, const char *what) {
    for (uint64_t i = 0; i < count; i++)
        if (!(values[i] - values[i] == 0.0))
            return enf_fail(ENF_ERROR_BAD_INPUT, "%s: coordinate %" PRIu64 " is not finite, a scene file can't hold it", what, i);
    return ENF_OK;
}

static EnfStatus check_all_finite(const EnfScene *s) {
    EnfStatus status = ENF_OK;
    uint32_t cell_vertices = s->cell_vertex_first[s->cell_count], portal_vertices = s->portal_vertex_first[s->portal_count];
    if (cell_vertices)
        status = check_finite(s->cell_vertices[0], 3 * (uint64_t)cell_vertices, "cells");
    if (status == ENF_OK && portal_vertices)
        status = check_finite(s->portal_vertices[0], 3 * (uint64_t)portal_vertices, "portals");
    for (uint32_t i = 0; i < s->object_count && status == ENF_OK; i++)
        status = check_finite(s->objects[i].bounds, 6, "objects");
    for (uint32_t i = 0; i < s->light_count && status == ENF_OK; i++)
        status = check_finite(s->lights[i].position, 3, "lights");
    for (uint32_t i = 0; i < s->camera_count && status == ENF_OK; i++)
        status = check_finite(s->cameras[i].camera.world_from_camera, 24, "cameras");
    return status;
}

EnfStatus enf_scene_save_json(const EnfScene *scene, const char *path_utf8) {
    if (!scene || !path_utf8)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_save_json: NULL argument");
    EnfStatus status = check_all_finite(scene);
    if (status != ENF_OK)
        return status;
    EnfFileWriter out;
    status = enf_file_write_begin(&out, path_utf8);
    if (status != ENF_OK)
        return status;
    Writer writer = {scene, out.file, 1}, *w = &writer;
    fputs("{\"format\": \"enfilade-scene\", \"version\": 1", out.file);
    put_extras(w, ENF_ITEM_SCENE, ENF_NONE, ",\n ");
    put_items(w, "rooms", ENF_ITEM_ROOM, scene->room_count, put_room);
    put_items(w, "cells", ENF_ITEM_CELL, scene->cell_count, put_cell);
    put_items(w, "portals", ENF_ITEM_PORTAL, scene->portal_count, put_portal);
    put_items(w, "openings", ENF_ITEM_OPENING, scene->opening_count, put_opening);
    put_items(w, "objects", ENF_ITEM_OBJECT, scene->object_count, put_object);
    put_items(w, "lights", ENF_ITEM_LIGHT, scene->light_count, put_light);
    put_items(w, "cameras", ENF_ITEM_CAMERA, scene->camera_count, put_camera);
    fputs("}\n", out.file);
    return enf_file_write_end(&out, 1);
}
