/* SPDX-License-Identifier: GPL-3.0-or-later
 * Reading *.enf.json (csrc/README.md, "Scene files"): what an item's keys hold is said by a table, item by item decoded by
 * jansson, read into one Item, added to the scene, forgotten.
 *
 * Top-level keys may come in any order, so indices are checked at commit. Unknown keys are kept as raw text
 * (extras.h). Rooms drawn as "prism" or "mesh" are decomposed and portals between "sides" are split after the
 * file is read (the file's own cells and portals keep their indices): scene_json_rooms.c. */
#include "base/json_text.h"
#include "base/memory.h"
#include "base/status.h"
#include "scene/extras.h"
#include "scene/problems.h"
#include "scene/scene_file.h"
#include "scene/scene_json_rooms.h"

#include <math.h>
#include <string.h>

/* What the keys of an item said; its lists stand in the loader's arrays from the firsts on. */
typedef struct Item {
    const char *name;
    uint32_t kind, state, room, opening, mesh, cell;
    uint64_t number_first, size_first, index_first;
    double bounds[6], position[3], z[2];
    EnfCamera camera;
    uint32_t shape; /* ENF_DRAWN_* */
    int occluder, sides, unknown;
    EnfDrawnPortal drawn;
} Item;

typedef struct Loader {
    EnfScene *scene;
    EnfJson json;
    EnfDrawn lists; /* those of the item in hand come last; those of prisms, meshes and sides stay until the end */
    Item item;
} Loader;

/* A key that is known: how its value is read, and to where in the loader's Item. */
typedef struct Field Field;
struct Field {
    const char *key;
    int (*read)(Loader *, const json_t *value, const Field *);
    size_t to;
    uint32_t needed, rows, columns; /* rows, columns: of the numbers */
    const char *const *words;       /* the strings it may be */
    const Field *inside;            /* the keys of the object, or list of objects, that it is */
};

#define TO(member) offsetof(Item, member)

static void *target(Loader *l, const Field *field) {
    return (char *)&l->item + field->to;
}

static int no_memory(Loader *l) {
    l->json.status = enf_fail_memory();
    return 0;
}

/* A failing call that adds: its reason. */
static int check(Loader *l, EnfStatus status) {
    l->json.status = status;
    return status == ENF_OK;
}

static int expect(Loader *l, int right, const char *wanted) {
    return right || enf_json_fail(&l->json, "%s expected", wanted);
}

static int read_fields(Loader *l, const json_t *object, const Field *fields) {
    size_t known = 0;
    if (!expect(l, json_is_object(object), "an object"))
        return 0;
    for (const Field *field = fields; field->key; field++) {
        const json_t *value = json_object_get(object, field->key);
        if (!value && field->needed)
            return enf_json_fail(&l->json, "the key \"%s\" is missing", field->key);
        l->json.key = field->key;
        if (value && !field->read(l, value, field))
            return 0;
        l->json.key = NULL;
        known += value != NULL;
    }
    l->item.unknown |= known < json_object_size(object);
    return 1;
}

/* ---- Values ---------------------------------------------------------------------------------------------- */
static int read_name(Loader *l, const json_t *value, const Field *field) {
    *(const char **)target(l, field) = json_string_value(value);
    return expect(l, json_is_string(value), "a string");
}

/* A word of a list; gives its place. */
static int read_word(Loader *l, const json_t *value, const Field *field) {
    if (!expect(l, json_is_string(value), "a string"))
        return 0;
    for (uint32_t k = 0; field->words[k]; k++)
        if (strcmp(json_string_value(value), field->words[k]) == 0) {
            *(uint32_t *)target(l, field) = k;
            return 1;
        }
    return enf_json_fail(&l->json, "\"%.40s\" is unknown here", json_string_value(value));
}

static int whole(Loader *l, const json_t *value, uint32_t *out) {
    double number = json_number_value(value);
    if (!expect(l, json_is_number(value) && number >= 0.0 && number < (double)ENF_NONE && number == floor(number),
                "a whole number from 0 to 4294967294"))
        return 0;
    *out = (uint32_t)number;
    return 1;
}

/* An index, or null. */
static int read_index(Loader *l, const json_t *value, const Field *field) {
    return json_is_null(value) || whole(l, value, target(l, field));
}

static int read_number(Loader *l, const json_t *value, const Field *field) {
    *(double *)target(l, field) = json_number_value(value);
    return expect(l, json_is_number(value), "a number");
}

static int numbers(Loader *l, const json_t *row, double *out, uint32_t count) {
    if (!expect(l, json_is_array(row), "an array"))
        return 0;
    if (json_array_size(row) != count)
        return enf_json_fail(&l->json, "%llu numbers, %u are needed", (unsigned long long)json_array_size(row), count);
    for (uint32_t i = 0; i < count; i++) {
        const json_t *number = json_array_get(row, i);
        if (!expect(l, json_is_number(number), "a number"))
            return 0;
        out[i] = json_number_value(number);
    }
    return 1;
}

static int read_numbers(Loader *l, const json_t *value, const Field *field) {
    return numbers(l, value, target(l, field), field->columns);
}

static int read_matrix(Loader *l, const json_t *value, const Field *field) {
    double *out = target(l, field);
    if (!expect(l, json_is_array(value), "an array"))
        return 0;
    if (json_array_size(value) != field->rows)
        return enf_json_fail(&l->json, "%llu rows, %u are needed", (unsigned long long)json_array_size(value), field->rows);
    for (uint32_t row = 0; row < field->rows; row++)
        if (!numbers(l, json_array_get(value, row), out + row * field->columns, field->columns))
            return 0;
    return 1;
}

/* ---- Lists: appended to the loader's arrays -------------------------------------------------------------- */
static int push_size(Loader *l, uint64_t size) {
    EnfDrawn *d = &l->lists;
    if (!ENF_RESERVE(d->sizes, d->size_count + 1))
        return no_memory(l);
    d->sizes[d->size_count++] = (uint32_t)size;
    return 1;
}

static int read_corners(Loader *l, const json_t *value, const Field *field) {
    EnfDrawn *d = &l->lists;
    size_t count = json_array_size(value);
    if (!expect(l, json_is_array(value), "an array"))
        return 0;
    if (!ENF_RESERVE(d->numbers, d->number_count + field->columns * count))
        return no_memory(l);
    for (size_t i = 0; i < count; i++, d->number_count += field->columns)
        if (!numbers(l, json_array_get(value, i), d->numbers + d->number_count, field->columns))
            return 0;
    return 1;
}

static int read_indices(Loader *l, const json_t *value, const Field *field) {
    EnfDrawn *d = &l->lists;
    size_t count = json_array_size(value);
    (void)field;
    if (!expect(l, json_is_array(value), "an array"))
        return 0;
    if (!ENF_RESERVE(d->indices, d->index_count + count))
        return no_memory(l);
    for (size_t i = 0; i < count; i++)
        if (!whole(l, json_array_get(value, i), &d->indices[d->index_count++]))
            return 0;
    return 1;
}

/* One list, and its size. */
static int read_ring(Loader *l, const json_t *value, const Field *field) {
    return (field->columns ? read_corners : read_indices)(l, value, field) && push_size(l, json_array_size(value));
}

static int read_rings(Loader *l, const json_t *value, const Field *field) {
    if (!expect(l, json_is_array(value), "an array"))
        return 0;
    for (size_t i = 0; i < json_array_size(value); i++)
        if (!read_ring(l, json_array_get(value, i), field))
            return 0;
    return 1;
}

/* "bounds", or convex polygons. */
static int read_occluder(Loader *l, const json_t *value, const Field *field) {
    l->item.occluder = 1;
    if (json_is_string(value))
        return expect(l, strcmp(json_string_value(value), "bounds") == 0, "\"bounds\" or polygons");
    return read_rings(l, value, field) && (json_array_size(value) || enf_json_fail(&l->json, "the occluder has no polygons"));
}

/* ---- Objects in items ------------------------------------------------------------------------------------- */
static int read_shape(Loader *l, const json_t *value, const Field *field) {
    if (l->item.shape)
        return enf_json_fail(&l->json, "\"prism\" and \"mesh\" stand both");
    l->item.shape = field->rows;
    return read_fields(l, value, field->inside);
}

/* [{"room": i}, {"cell": j}] */
static int read_sides(Loader *l, const json_t *value, const Field *field) {
    Item *item = &l->item;
    item->sides = 1;
    if (!expect(l, json_array_size(value) == 2, "an array of 2 sides"))
        return 0;
    for (int side = 0; side < 2; side++) {
        item->room = item->cell = ENF_NONE;
        if (!read_fields(l, json_array_get(value, (size_t)side), field->inside))
            return 0;
        if ((item->room == ENF_NONE) == (item->cell == ENF_NONE))
            return enf_json_fail(&l->json, "side %d names neither one \"room\" nor one \"cell\"", side);
        item->drawn.kinds[side] = item->cell == ENF_NONE ? ENF_SIDE_ROOM : ENF_SIDE_CELL;
        item->drawn.sides[side] = item->cell == ENF_NONE ? item->room : item->cell;
    }
    return 1;
}

/* ---- The items: their keys, and adding them ---------------------------------------------------------------- */
static const char *const room_kinds[] = {"interior", "exterior", NULL};
static const char *const opening_kinds[] = {"door", "window", "hole", "virtual", NULL};
static const char *const states[] = {"open", "closed", "glass", NULL};
static const char *const camera_types[] = {"PERSP", "ORTHO", "PANO", NULL};

static const Field prism_fields[] = {{"outline", read_ring, .needed = 1, .columns = 2},
                                     {"holes", read_rings, .columns = 2},
                                     {"z", read_numbers, TO(z), .needed = 1, .columns = 2},
                                     {NULL}};
static const Field mesh_fields[] = {{"vertices", read_corners, .needed = 1, .columns = 3}, {"faces", read_rings}, {NULL}};
static const Field room_fields[] = {{"name", read_name, TO(name)},
                                    {"kind", read_word, TO(kind), .words = room_kinds},
                                    {"prism", read_shape, .rows = ENF_DRAWN_PRISM, .inside = prism_fields},
                                    {"mesh", read_shape, .rows = ENF_DRAWN_MESH, .inside = mesh_fields},
                                    {NULL}};
static const Field cell_fields[] = {{"room", read_index, TO(room)},
                                    {"opening", read_index, TO(opening)},
                                    {"vertices", read_corners, .columns = 3},
                                    {"faces", read_rings},
                                    {NULL}};
static const Field side_fields[] = {{"room", read_index, TO(room)}, {"cell", read_index, TO(cell)}, {NULL}};
static const Field portal_fields[] = {{"cells", read_indices},
                                      {"polygon", read_corners, .needed = 1, .columns = 3},
                                      {"opening", read_index, TO(opening)},
                                      {"sides", read_sides, .inside = side_fields},
                                      {NULL}};
static const Field opening_fields[] = {{"name", read_name, TO(name)},
                                       {"kind", read_word, TO(kind), .words = opening_kinds},
                                       {"state", read_word, TO(state), .words = states},
                                       {NULL}};
static const Field object_fields[] = {{"name", read_name, TO(name)},
                                      {"bounds", read_matrix, TO(bounds), .needed = 1, .rows = 2, .columns = 3},
                                      {"cells", read_indices},
                                      {"mesh", read_index, TO(mesh)},
                                      {"occluder", read_occluder, .columns = 3},
                                      {NULL}};
static const Field light_fields[] = {
    {"name", read_name, TO(name)}, {"position", read_numbers, TO(position), .needed = 1, .columns = 3}, {NULL}};
static const Field camera_fields[] = {{"name", read_name, TO(name)},
                                      {"matrix_world", read_matrix, TO(camera.world_from_camera), .rows = 4, .columns = 4},
                                      {"type", read_word, TO(camera.type), .words = camera_types},
                                      {"angle_x", read_number, TO(camera.angle_x)},
                                      {"angle_y", read_number, TO(camera.angle_y)},
                                      {"clip", read_numbers, TO(camera.clip_near), .columns = 2},
                                      {"shift", read_numbers, TO(camera.shift_x), .columns = 2},
                                      {"ortho_size", read_numbers, TO(camera.ortho_width), .columns = 2},
                                      {NULL}};

static int add_room(Loader *l) {
    const Item *item = &l->item;
    EnfDrawn *d = &l->lists;
    if (item->shape) {
        if (!ENF_RESERVE(d->rooms, d->room_count + 1))
            return no_memory(l);
        d->rooms[d->room_count++] = (EnfDrawnRoom){.kind = item->shape,
                                                   .room = l->json.index,
                                                   .number_first = item->number_first,
                                                   .point_count = (d->number_count - item->number_first) / 3,
                                                   .size_first = item->size_first,
                                                   .size_count = d->size_count - item->size_first,
                                                   .index_first = item->index_first,
                                                   .z = {item->z[0], item->z[1]}};
    }
    return check(l, enf_scene_add_room(l->scene, item->name, item->kind, NULL));
}

static int add_cell(Loader *l) {
    const Item *item = &l->item;
    const EnfDrawn *d = &l->lists;
    return check(l, enf_scene_add_cell(l->scene, item->room, item->opening, d->numbers + item->number_first,
                                       (d->number_count - item->number_first) / 3, 0, d->sizes + item->size_first,
                                       d->size_count - item->size_first, d->indices + item->index_first, NULL));
}

static int add_portal(Loader *l) {
    Item *item = &l->item;
    EnfDrawn *d = &l->lists;
    const uint32_t *cells = d->indices + item->index_first;
    uint64_t cell_count = d->index_count - item->index_first, point_count = (d->number_count - item->number_first) / 3;
    if (!ENF_RESERVE(d->portal_index, (uint64_t)l->json.index + 1) || (item->sides && !ENF_RESERVE(d->portals, d->portal_count + 1)))
        return no_memory(l);
    d->portal_index[l->json.index] = l->scene->portal_count;
    d->file_portal_count = (uint64_t)l->json.index + 1;
    if (item->sides && cell_count)
        return enf_json_fail(&l->json, "\"cells\" and \"sides\" stand both");
    if (item->sides) {
        item->drawn.opening = item->opening;
        item->drawn.index = l->json.index;
        item->drawn.number_first = item->number_first;
        item->drawn.point_count = point_count;
        d->portals[d->portal_count++] = item->drawn;
        return 1;
    }
    if (cell_count != 2)
        return enf_json_fail(&l->json, "%llu \"cells\", 2 are needed", (unsigned long long)cell_count);
    return check(l,
                 enf_scene_add_portal(l->scene, cells[0], cells[1], d->numbers + item->number_first, point_count, 0, item->opening, NULL));
}

static int add_opening(Loader *l) {
    return check(l, enf_scene_add_opening(l->scene, l->item.name, l->item.kind, l->item.state, NULL));
}

static int add_object(Loader *l) {
    const Item *item = &l->item;
    const EnfDrawn *d = &l->lists;
    uint32_t object;
    return check(l, enf_scene_add_object(l->scene, item->name, item->bounds, d->indices + item->index_first,
                                         d->index_count - item->index_first, item->mesh, &object)) &&
           (!item->occluder || check(l, enf_scene_set_occluder(l->scene, object, d->numbers + item->number_first, 0,
                                                               d->sizes + item->size_first, d->size_count - item->size_first)));
}

static int add_light(Loader *l) {
    return check(l, enf_scene_add_light(l->scene, l->item.name, l->item.position, NULL));
}

static int add_camera(Loader *l) {
    return check(l, enf_scene_add_camera(l->scene, l->item.name, &l->item.camera, NULL));
}

/* A key of the file. */
typedef struct TopKey TopKey;
struct TopKey {
    const char *key;
    int (*read)(Loader *, const TopKey *);
    uint32_t item, kind; /* kind: what an item is when it doesn't say */
    const Field *fields;
    int (*add)(Loader *);
};

/* ---- The file ------------------------------------------------------------------------------------------------ */
/* Skips a value and keeps it as the text it is, with its key, where it begins. */
static int keep_text(Loader *l, uint32_t item, uint32_t index, const char *from) {
    return enf_json_skip(&l->json) && (enf_extras_add(l->scene, item, index, from, (size_t)(l->json.at - from)) || no_memory(l));
}

/* Walks the text of an item, or of what is in it, once more and keeps what is unknown. */
static int keep_unknown(Loader *l, uint32_t item, const Field *fields) {
    EnfJson *json = &l->json;
    char open = enf_json_peek(json), close = open == '[' ? ']' : '}';
    enf_json_enter(json, open);
    for (uint64_t i = 0; enf_json_next(json, close, i); i++) {
        if (open == '[') { /* a list of objects */
            keep_unknown(l, item, fields);
            continue;
        }
        enf_json_peek(json);
        const char *from = json->at, *key = enf_json_key(json);
        const Field *field = fields;
        while (key && field->key && strcmp(field->key, key) != 0)
            field++;
        if (!key)
            return 0;
        if (!field->key)
            keep_text(l, item, json->index, from);
        else if (field->inside)
            keep_unknown(l, item, field->inside);
        else
            enf_json_skip(json);
    }
    return json->status == ENF_OK;
}

static int read_item(Loader *l, const TopKey *top) {
    EnfDrawn *d = &l->lists;
    l->item = (Item){.kind = top->kind,
                     .room = ENF_NONE,
                     .opening = ENF_NONE,
                     .mesh = ENF_NONE,
                     .number_first = d->number_count,
                     .size_first = d->size_count,
                     .index_first = d->index_count,
                     .camera = enf_default_camera()};
    const json_t *value = enf_json_value(&l->json);
    const char *from = l->json.from;
    if (!value || !read_fields(l, value, top->fields) || !top->add(l))
        return 0;
    enf_json_forget(&l->json);
    if (!l->item.shape && !l->item.sides) {
        d->number_count = l->item.number_first;
        d->size_count = l->item.size_first;
        d->index_count = l->item.index_first;
    }
    if (!l->item.unknown)
        return 1;
    l->json.at = from;
    return keep_unknown(l, top->item, top->fields);
}

static int read_items(Loader *l, const TopKey *top) {
    EnfJson *json = &l->json;
    enf_json_enter(json, '[');
    json->key = NULL;
    json->item = enf_item_word(top->item);
    for (uint64_t i = 0; enf_json_next(json, ']', i); i++) {
        json->index = (uint32_t)i;
        if (!read_item(l, top))
            return 0;
    }
    json->item = NULL;
    return json->status == ENF_OK;
}

static int read_format(Loader *l, const TopKey *top) {
    const json_t *value = enf_json_value(&l->json);
    (void)top;
    if (!value || !expect(l, json_is_string(value), "a string"))
        return 0;
    return strcmp(json_string_value(value), "enfilade-scene") == 0 ||
           enf_json_fail(&l->json, "it is \"%.40s\", not \"enfilade-scene\"", json_string_value(value));
}

static int read_version(Loader *l, const TopKey *top) {
    const json_t *value = enf_json_value(&l->json);
    (void)top;
    if (!value || !expect(l, json_is_number(value), "a number"))
        return 0;
    return json_number_value(value) == 1.0 || enf_json_fail(&l->json, "it is %g; this library reads 1", json_number_value(value));
}

static const TopKey top_keys[] = {{"format", read_format},
                                  {"version", read_version},
                                  {"rooms", read_items, ENF_ITEM_ROOM, ENF_ROOM_INTERIOR, room_fields, add_room},
                                  {"cells", read_items, ENF_ITEM_CELL, 0, cell_fields, add_cell},
                                  {"portals", read_items, ENF_ITEM_PORTAL, 0, portal_fields, add_portal},
                                  {"openings", read_items, ENF_ITEM_OPENING, ENF_OPENING_HOLE, opening_fields, add_opening},
                                  {"objects", read_items, ENF_ITEM_OBJECT, 0, object_fields, add_object},
                                  {"lights", read_items, ENF_ITEM_LIGHT, 0, light_fields, add_light},
                                  {"cameras", read_items, ENF_ITEM_CAMERA, 0, camera_fields, add_camera},
                                  {NULL}};

static int read_scene(Loader *l) {
    EnfJson *json = &l->json;
    uint32_t seen = 0; /* bit k: key k of the table */
    enf_json_enter(json, '{');
    for (uint64_t i = 0; enf_json_next(json, '}', i); i++) {
        enf_json_peek(json);
        const char *from = json->at, *key = enf_json_key(json);
        const TopKey *top = top_keys;
        while (key && top->key && strcmp(top->key, key) != 0)
            top++;
        if (!key)
            return 0;
        if (!top->key) {
            if (!keep_text(l, ENF_ITEM_SCENE, ENF_NONE, from))
                return 0;
        } else {
            if (seen >> (top - top_keys) & 1)
                return enf_json_fail(json, "the key \"%s\" stands twice", key);
            seen |= 1u << (top - top_keys);
            json->key = top->key;
            if (!top->read(l, top))
                return 0;
            json->key = NULL;
        }
        enf_json_forget(json);
    }
    for (uint32_t k = 0; k < 2 && json->status == ENF_OK; k++)
        if (!(seen >> k & 1))
            return enf_json_fail(json, "the key \"%s\" is missing", top_keys[k].key);
    return enf_json_finish(json);
}

EnfStatus enf_scene_read_json(EnfScene *scene, const char *text, uint64_t size) {
    Loader loader = {.scene = scene}, *l = &loader;
    EnfDrawn *d = &l->lists;
    enf_json_begin(&l->json, text, size);
    /* Never NULL: what is nothing long is taken from them too. */
    if (!ENF_RESERVE(d->numbers, 1) || !ENF_RESERVE(d->sizes, 1) || !ENF_RESERVE(d->indices, 1))
        no_memory(l);
    else if (read_scene(l))
        l->json.status = enf_drawn_build(d, scene);
    enf_drawn_free(d);
    enf_extras_sort(scene->extras);
    enf_json_end(&l->json);
    return l->json.status;
}
