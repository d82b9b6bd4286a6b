/* SPDX-License-Identifier: GPL-3.0-or-later
 * Reading *.enf.json (csrc/README.md, "Scene files"). One pass, nothing is kept but the scene itself.
 *
 * Top-level keys may come in any order, so indices are checked at commit. Unknown keys are kept as raw text
 * (extras.h). Rooms drawn as "prism" or "mesh" are decomposed and portals between "sides" are split after the
 * file is read (the file's own cells and portals keep their indices): scene_json_rooms.c. */
#include "base/json_reader.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"
#include "scene/extras.h"
#include "scene/scene_file.h"
#include "scene/scene_json_rooms.h"

#include <stdio.h>
#include <string.h>

typedef struct Loader {
    EnfScene *scene;
    EnfJson json;
    /* scratch, reused from item to item */
    double (*points)[3];
    uint32_t *sizes, *indices;
    char *name;
    uint64_t point_count, size_count, index_count;
    uint32_t item, index; /* what is being read, for messages and extras */
    uint32_t seen;        /* bit k: key k of the item's table was read */
    EnfDrawn drawn;       /* prisms, meshes and sides, kept until the end */
} Loader;

static int no_memory(Loader *l) {
    if (!l->json.failed) {
        l->json.failed = 1;
        l->json.status = enf_fail_memory();
    }
    return 0;
}

/* A failing add_* call: its reason, with the line. */
static int check(Loader *l, EnfStatus status) {
    if (status == ENF_OK)
        return 1;
    l->json.failed = 1;
    l->json.status = status;
    return 0;
}

static void set_context(Loader *l, uint32_t item, uint32_t index) {
    static const char *const words[] = {"", "room", "cell", "portal", "opening", "object", "light", "camera"};
    l->item = item;
    l->index = index;
    l->seen = 0;
    if (index == ENF_NONE)
        l->json.context[0] = 0;
    else
        snprintf(l->json.context, sizeof l->json.context, "%s %u: ", words[item], index);
}

/* The index of the key just read in `keys` (ends in NULL), or -1 after keeping an unknown one. -2: failed. */
static int known_key(Loader *l, const char *const *keys) {
    for (int k = 0; keys[k]; k++)
        if (strcmp(l->json.text, keys[k]) == 0) {
            if (l->seen >> k & 1)
                return enf_json_fail(&l->json, "the key \"%s\" stands twice", keys[k]) - 2;
            l->seen |= 1u << k;
            return k;
        }
    const char *key = l->json.key_at, *value;
    uint64_t key_size = l->json.key_size, value_size;
    if (!enf_json_skip(&l->json, &value, &value_size))
        return -2;
    if (!enf_extras_add(l->scene, l->item, l->index, key, (size_t)key_size, value, (size_t)value_size))
        return no_memory(l) - 2;
    return -1;
}

static int need(Loader *l, int key, const char *name) {
    if (l->json.failed)
        return 0;
    if (!(l->seen >> key & 1))
        return enf_json_fail(&l->json, "the key \"%s\" is missing", name);
    return 1;
}

static int read_name(Loader *l) {
    if (!enf_json_string(&l->json))
        return 0;
    uint64_t size = l->json.text_size + 1;
    if (!ENF_RESERVE(l->name, size))
        return no_memory(l);
    memcpy(l->name, l->json.text, (size_t)size);
    return 1;
}

/* A word of a list; gives its place. */
static int read_word(Loader *l, const char *const *words, uint32_t *out) {
    if (!enf_json_string(&l->json))
        return 0;
    for (uint32_t k = 0; words[k]; k++)
        if (strcmp(l->json.text, words[k]) == 0) {
            *out = k;
            return 1;
        }
    return enf_json_fail(&l->json, "\"%.40s\" is unknown here", l->json.text);
}

/* Exactly `count` numbers. */
static int read_numbers(Loader *l, double *out, uint32_t count) {
    if (!enf_json_enter_array(&l->json))
        return 0;
    for (uint32_t i = 0; i < count; i++) {
        if (!enf_json_next_element(&l->json))
            return enf_json_fail(&l->json, "%u numbers, %u are needed", i, count);
        if (!enf_json_number(&l->json, &out[i]))
            return 0;
    }
    if (enf_json_next_element(&l->json))
        return enf_json_fail(&l->json, "more than %u numbers", count);
    return !l->json.failed;
}

static int append_points(Loader *l) {
    if (!enf_json_enter_array(&l->json))
        return 0;
    while (enf_json_next_element(&l->json)) {
        if (!ENF_RESERVE(l->points, l->point_count + 1))
            return no_memory(l);
        if (!read_numbers(l, l->points[l->point_count], 3))
            return 0;
        l->point_count++;
    }
    return !l->json.failed;
}

static int read_points(Loader *l) {
    l->point_count = 0;
    return append_points(l);
}

/* Appends the indices of one array. */
static int read_indices(Loader *l) {
    if (!enf_json_enter_array(&l->json))
        return 0;
    while (enf_json_next_element(&l->json)) {
        if (!ENF_RESERVE(l->indices, l->index_count + 1))
            return no_memory(l);
        if (!enf_json_index(&l->json, &l->indices[l->index_count]))
            return 0;
        l->index_count++;
    }
    return !l->json.failed;
}

static int read_faces(Loader *l) {
    l->size_count = l->index_count = 0;
    if (!enf_json_enter_array(&l->json))
        return 0;
    while (enf_json_next_element(&l->json)) {
        uint64_t before = l->index_count;
        if (!ENF_RESERVE(l->sizes, l->size_count + 1))
            return no_memory(l);
        if (!read_indices(l))
            return 0;
        l->sizes[l->size_count++] = (uint32_t)(l->index_count - before);
    }
    return !l->json.failed;
}

/* null or an index. */
static int read_optional_index(Loader *l, uint32_t *out) {
    *out = ENF_NONE;
    return enf_json_peek(&l->json) == 'n' ? enf_json_null(&l->json) : enf_json_index(&l->json, out);
}

/* One ring of [x, y] corners onto the drawn rooms' corners. */
static int read_ring(Loader *l) {
    EnfDrawn *d = &l->drawn;
    uint32_t size = 0;
    if (!enf_json_enter_array(&l->json))
        return 0;
    while (enf_json_next_element(&l->json)) {
        if (!ENF_RESERVE(d->numbers, d->number_count + 2))
            return no_memory(l);
        if (!read_numbers(l, d->numbers + d->number_count, 2))
            return 0;
        d->number_count += 2;
        size++;
    }
    if (!ENF_RESERVE(d->sizes, d->size_count + 1))
        return no_memory(l);
    d->sizes[d->size_count++] = size;
    return !l->json.failed;
}

static int read_rings(Loader *l) {
    if (!enf_json_enter_array(&l->json))
        return 0;
    while (enf_json_next_element(&l->json))
        if (!read_ring(l))
            return 0;
    return !l->json.failed;
}

/* {"outline": ring, "holes": [ring, ...], "z": [z0, z1]}; the outline must come first in memory, so it is
 * read first. */
static int read_prism(Loader *l, EnfDrawnRoom *room) {
    static const char *const keys[] = {"outline", "z", "holes", NULL};
    uint32_t outer = l->seen;
    int key = 0;
    l->seen = 0;
    room->kind = ENF_DRAWN_PRISM;
    room->number_first = l->drawn.number_count;
    room->size_first = l->drawn.size_count;
    if (!enf_json_enter_object(&l->json))
        return 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if (key == 2 && !(l->seen & 1))
            return enf_json_fail(&l->json, "\"outline\" should stand before \"holes\"");
        if ((key == 0 && !read_ring(l)) || (key == 1 && !read_numbers(l, room->z, 2)) || (key == 2 && !read_rings(l)))
            return 0;
    }
    if (!need(l, 0, "outline") || !need(l, 1, "z"))
        return 0;
    room->size_count = l->drawn.size_count - room->size_first;
    l->seen = outer;
    return 1;
}

/* {"vertices": [[x, y, z], ...], "faces": [[i, j, k, ...], ...]} */
static int read_mesh(Loader *l, EnfDrawnRoom *room) {
    static const char *const keys[] = {"vertices", "faces", NULL};
    EnfDrawn *d = &l->drawn;
    uint32_t outer = l->seen;
    int key = 0;
    l->seen = 0;
    l->point_count = l->size_count = l->index_count = 0;
    if (!enf_json_enter_object(&l->json))
        return 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if ((key == 0 && !read_points(l)) || (key == 1 && !read_faces(l)))
            return 0;
    }
    if (!need(l, 0, "vertices"))
        return 0;
    room->kind = ENF_DRAWN_MESH;
    room->number_first = d->number_count;
    room->size_first = d->size_count;
    room->index_first = d->index_count;
    room->point_count = l->point_count;
    room->size_count = l->size_count;
    if (!ENF_RESERVE(d->numbers, d->number_count + 3 * l->point_count) || !ENF_RESERVE(d->sizes, d->size_count + l->size_count) ||
        !ENF_RESERVE(d->indices, d->index_count + l->index_count))
        return no_memory(l);
    if (l->point_count)
        memcpy(d->numbers + d->number_count, l->points, (size_t)l->point_count * sizeof *l->points);
    if (l->size_count)
        memcpy(d->sizes + d->size_count, l->sizes, (size_t)l->size_count * sizeof *l->sizes);
    if (l->index_count)
        memcpy(d->indices + d->index_count, l->indices, (size_t)l->index_count * sizeof *l->indices);
    d->number_count += 3 * l->point_count;
    d->size_count += l->size_count;
    d->index_count += l->index_count;
    l->seen = outer;
    return 1;
}

static int read_room(Loader *l) {
    static const char *const keys[] = {"name", "kind", "prism", "mesh", NULL};
    static const char *const kinds[] = {"interior", "exterior", NULL};
    uint32_t kind = ENF_ROOM_INTERIOR;
    int key = 0;
    EnfDrawnRoom drawn = {0};
    drawn.room = l->index;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if (key >= 2 && drawn.kind)
            return enf_json_fail(&l->json, "\"prism\" and \"mesh\" stand both");
        if ((key == 0 && !read_name(l)) || (key == 1 && !read_word(l, kinds, &kind)) || (key == 2 && !read_prism(l, &drawn)) ||
            (key == 3 && !read_mesh(l, &drawn)))
            return 0;
    }
    if (l->json.failed)
        return 0;
    if (drawn.kind) {
        if (!ENF_RESERVE(l->drawn.rooms, l->drawn.room_count + 1))
            return no_memory(l);
        l->drawn.rooms[l->drawn.room_count++] = drawn;
    }
    return check(l, enf_scene_add_room(l->scene, l->name, kind, NULL));
}

static int read_cell(Loader *l) {
    static const char *const keys[] = {"room", "opening", "vertices", "faces", NULL};
    uint32_t room = ENF_NONE, opening = ENF_NONE;
    int key = 0;
    l->point_count = l->size_count = l->index_count = 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if ((key == 0 && !read_optional_index(l, &room)) || (key == 1 && !read_optional_index(l, &opening)) ||
            (key == 2 && !read_points(l)) || (key == 3 && !read_faces(l)))
            return 0;
    }
    return !l->json.failed && check(l, enf_scene_add_cell(l->scene, room, opening, l->points ? l->points[0] : NULL, l->point_count, 0,
                                                          l->sizes, l->size_count, l->indices, NULL));
}

/* [{"room": i}, {"cell": j}] */
static int read_sides(Loader *l, EnfDrawnPortal *portal) {
    static const char *const keys[] = {"room", "cell", NULL};
    uint32_t outer = l->seen;
    if (!enf_json_enter_array(&l->json))
        return 0;
    for (int side = 0; side < 2; side++) {
        int key = 0, given = 0;
        if (!enf_json_next_element(&l->json))
            return enf_json_fail(&l->json, "\"sides\" has %d entries, 2 are needed", side);
        if (!enf_json_enter_object(&l->json))
            return 0;
        l->seen = 0;
        while (key > -2 && enf_json_next_key(&l->json)) {
            key = known_key(l, keys);
            if (key >= 0 && !enf_json_index(&l->json, &portal->sides[side]))
                return 0;
            if (key >= 0)
                portal->kinds[side] = key == 0 ? ENF_SIDE_ROOM : ENF_SIDE_CELL;
            given += key >= 0;
        }
        if (!l->json.failed && given != 1)
            return enf_json_fail(&l->json, "side %d names neither one \"room\" nor one \"cell\"", side);
    }
    l->seen = outer;
    if (enf_json_next_element(&l->json))
        return enf_json_fail(&l->json, "\"sides\" has more than 2 entries");
    return !l->json.failed;
}

static int keep_drawn_portal(Loader *l, EnfDrawnPortal *portal) {
    EnfDrawn *d = &l->drawn;
    portal->index = l->index;
    portal->number_first = d->number_count;
    portal->point_count = l->point_count;
    if (!ENF_RESERVE(d->portals, d->portal_count + 1) || !ENF_RESERVE(d->numbers, d->number_count + 3 * l->point_count))
        return no_memory(l);
    if (l->point_count)
        memcpy(d->numbers + d->number_count, l->points, (size_t)l->point_count * sizeof *l->points);
    d->number_count += 3 * l->point_count;
    d->portals[d->portal_count++] = *portal;
    return 1;
}

static int read_portal(Loader *l) {
    static const char *const keys[] = {"cells", "polygon", "opening", "sides", NULL};
    uint32_t opening = ENF_NONE;
    EnfDrawnPortal drawn = {0};
    int key = 0;
    l->point_count = l->index_count = 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if ((key == 0 && !read_indices(l)) || (key == 1 && !read_points(l)) || (key == 2 && !read_optional_index(l, &opening)) ||
            (key == 3 && !read_sides(l, &drawn)))
            return 0;
    }
    if (!need(l, 1, "polygon"))
        return 0;
    if (!ENF_RESERVE(l->drawn.portal_index, (uint64_t)l->index + 1))
        return no_memory(l);
    l->drawn.portal_index[l->index] = l->scene->portal_count;
    l->drawn.file_portal_count = (uint64_t)l->index + 1;
    if (l->seen >> 3 & 1) {
        if (l->seen & 1)
            return enf_json_fail(&l->json, "\"cells\" and \"sides\" stand both");
        drawn.opening = opening;
        return keep_drawn_portal(l, &drawn);
    }
    if (!need(l, 0, "cells"))
        return 0;
    if (l->index_count != 2)
        return enf_json_fail(&l->json, "\"cells\" has %llu entries, 2 are needed", (unsigned long long)l->index_count);
    return check(
        l, enf_scene_add_portal(l->scene, l->indices[0], l->indices[1], l->points ? l->points[0] : NULL, l->point_count, 0, opening, NULL));
}

static int read_opening(Loader *l) {
    static const char *const keys[] = {"name", "kind", "state", NULL};
    static const char *const kinds[] = {"door", "window", "hole", "virtual", NULL};
    static const char *const states[] = {"open", "closed", "glass", NULL};
    uint32_t kind = ENF_OPENING_HOLE, state = ENF_STATE_OPEN;
    int key = 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if ((key == 0 && !read_name(l)) || (key == 1 && !read_word(l, kinds, &kind)) || (key == 2 && !read_word(l, states, &state)))
            return 0;
    }
    return !l->json.failed && check(l, enf_scene_add_opening(l->scene, l->name, kind, state, NULL));
}

static int read_bounds(Loader *l, double bounds[6]) {
    if (!enf_json_enter_array(&l->json))
        return 0;
    for (int corner = 0; corner < 2; corner++) {
        if (!enf_json_next_element(&l->json))
            return enf_json_fail(&l->json, "\"bounds\" has %d corners, 2 are needed", corner);
        if (!read_numbers(l, bounds + 3 * corner, 3))
            return 0;
    }
    if (enf_json_next_element(&l->json))
        return enf_json_fail(&l->json, "\"bounds\" has more than 2 corners");
    return !l->json.failed;
}

/* "bounds", or [[[x, y, z], ...], ...]: convex polygons. */
static int read_occluder(Loader *l) {
    static const char *const words[] = {"bounds", NULL};
    uint32_t word;
    l->point_count = l->size_count = 0;
    if (enf_json_peek(&l->json) == '"')
        return read_word(l, words, &word);
    if (!enf_json_enter_array(&l->json))
        return 0;
    while (enf_json_next_element(&l->json)) {
        uint64_t before = l->point_count;
        if (!ENF_RESERVE(l->sizes, l->size_count + 1))
            return no_memory(l);
        if (!append_points(l))
            return 0;
        l->sizes[l->size_count++] = (uint32_t)(l->point_count - before);
    }
    return l->json.failed || l->size_count ? !l->json.failed : enf_json_fail(&l->json, "\"occluder\" has no polygons");
}

static int read_object(Loader *l) {
    static const char *const keys[] = {"name", "bounds", "cells", "mesh", "occluder", NULL};
    double bounds[6];
    uint32_t mesh = ENF_NONE, object;
    int key = 0;
    l->index_count = 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if ((key == 0 && !read_name(l)) || (key == 1 && !read_bounds(l, bounds)) || (key == 2 && !read_indices(l)) ||
            (key == 3 && !read_optional_index(l, &mesh)) || (key == 4 && !read_occluder(l)))
            return 0;
    }
    return need(l, 1, "bounds") && check(l, enf_scene_add_object(l->scene, l->name, bounds, l->indices, l->index_count, mesh, &object)) &&
           (!(l->seen >> 4 & 1) ||
            check(l, enf_scene_set_occluder(l->scene, object, l->points ? l->points[0] : NULL, 0, l->sizes, l->size_count)));
}

static int read_light(Loader *l) {
    static const char *const keys[] = {"name", "position", NULL};
    double position[3];
    int key = 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        if ((key == 0 && !read_name(l)) || (key == 1 && !read_numbers(l, position, 3)))
            return 0;
    }
    return need(l, 1, "position") && check(l, enf_scene_add_light(l->scene, l->name, position, NULL));
}

static int read_matrix(Loader *l, double out[16]) {
    if (!enf_json_enter_array(&l->json))
        return 0;
    for (int row = 0; row < 4; row++) {
        if (!enf_json_next_element(&l->json))
            return enf_json_fail(&l->json, "\"matrix_world\" has %d rows, 4 are needed", row);
        if (!read_numbers(l, out + 4 * row, 4))
            return 0;
    }
    if (enf_json_next_element(&l->json))
        return enf_json_fail(&l->json, "\"matrix_world\" has more than 4 rows");
    return !l->json.failed;
}

static int read_camera(Loader *l) {
    static const char *const keys[] = {"name", "matrix_world", "type", "angle_x", "angle_y", "clip", "shift", "ortho_size", NULL};
    static const char *const types[] = {"PERSP", "ORTHO", "PANO", NULL};
    EnfCamera camera = enf_default_camera();
    double pair[2];
    int key = 0;
    while (key > -2 && enf_json_next_key(&l->json)) {
        key = known_key(l, keys);
        switch (key) {
        case 0:
            read_name(l);
            break;
        case 1:
            read_matrix(l, camera.world_from_camera);
            break;
        case 2:
            read_word(l, types, &camera.type);
            break;
        case 3:
            enf_json_number(&l->json, &camera.angle_x);
            break;
        case 4:
            enf_json_number(&l->json, &camera.angle_y);
            break;
        case 5:
            if (read_numbers(l, pair, 2)) {
                camera.clip_near = pair[0];
                camera.clip_far = pair[1];
            }
            break;
        case 6:
            if (read_numbers(l, pair, 2)) {
                camera.shift_x = pair[0];
                camera.shift_y = pair[1];
            }
            break;
        case 7:
            if (read_numbers(l, pair, 2)) {
                camera.ortho_width = pair[0];
                camera.ortho_height = pair[1];
            }
            break;
        default:
            break;
        }
        if (l->json.failed)
            return 0;
    }
    return !l->json.failed && check(l, enf_scene_add_camera(l->scene, l->name, &camera, NULL));
}

static int read_items(Loader *l, uint32_t item, int (*read)(Loader *)) {
    if (!enf_json_enter_array(&l->json))
        return 0;
    uint32_t seen = l->seen;
    for (uint32_t index = 0; enf_json_next_element(&l->json); index++) {
        set_context(l, item, index);
        if (l->name)
            l->name[0] = 0;
        if (!enf_json_enter_object(&l->json) || !read(l))
            return 0;
    }
    set_context(l, ENF_ITEM_SCENE, ENF_NONE);
    l->seen = seen;
    return !l->json.failed;
}

static int read_header(Loader *l, int key) {
    double version;
    if (key == 0) {
        if (!enf_json_string(&l->json))
            return 0;
        if (strcmp(l->json.text, "enfilade-scene") != 0)
            return enf_json_fail(&l->json, "\"format\" is \"%.40s\", not \"enfilade-scene\"", l->json.text);
        return 1;
    }
    if (!enf_json_number(&l->json, &version))
        return 0;
    if (version != 1.0)
        return enf_json_fail(&l->json, "\"version\" is %g; this library reads 1", version);
    return 1;
}

EnfStatus enf_scene_read_json(EnfScene *scene, const char *text, uint64_t size) {
    static const char *const keys[] = {"format", "version", "rooms", "cells", "portals", "openings", "objects", "lights", "cameras", NULL};
    static int (*const readers[])(Loader *) = {read_room, read_cell, read_portal, read_opening, read_object, read_light, read_camera};
    static const uint32_t items[] = {ENF_ITEM_ROOM,   ENF_ITEM_CELL,  ENF_ITEM_PORTAL, ENF_ITEM_OPENING,
                                     ENF_ITEM_OBJECT, ENF_ITEM_LIGHT, ENF_ITEM_CAMERA};
    Loader loader = {0}, *l = &loader;
    l->scene = scene;
    enf_json_begin(&l->json, text, size);
    set_context(l, ENF_ITEM_SCENE, ENF_NONE);
    if (enf_json_enter_object(&l->json)) {
        int key = 0;
        while (key > -2 && enf_json_next_key(&l->json)) {
            key = known_key(l, keys);
            if (key >= 0 && !(key < 2 ? read_header(l, key) : read_items(l, items[key - 2], readers[key - 2])))
                break;
        }
        need(l, 0, "format");
        need(l, 1, "version");
        enf_json_finish(&l->json);
    }
    EnfStatus status = enf_json_status(&l->json);
    if (status == ENF_OK)
        status = enf_drawn_build(&l->drawn, scene);
    enf_drawn_free(&l->drawn);
    enf_extras_sort(scene->extras);
    enf_json_end(&l->json);
    enf_free(l->points);
    enf_free(l->sizes);
    enf_free(l->indices);
    enf_free(l->name);
    return status;
}
