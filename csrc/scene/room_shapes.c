/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells a room has, while a scene is being built. */
#include "scene/room_shapes.h"
#include "base/memory.h"

int enf_room_shapes_update(EnfScene *scene) {
    if (!scene->shapes && !(scene->shapes = ENF_NEW(EnfRoomShapes, 1)))
        return 0;
    EnfRoomShapes *s = scene->shapes;
    if (!ENF_RESERVE(s->head, scene->room_count) || !ENF_RESERVE(s->tail, scene->room_count) || !ENF_RESERVE(s->next, scene->cell_count))
        return 0;
    for (; s->rooms < scene->room_count; s->rooms++)
        s->head[s->rooms] = s->tail[s->rooms] = ENF_NONE;
    for (; s->cells < scene->cell_count; s->cells++) {
        uint32_t c = s->cells, room = scene->cell_rooms[c];
        s->next[c] = ENF_NONE;
        if (room >= s->rooms)
            continue; /* no room, or one that is missing: commit will say so */
        if (s->head[room] == ENF_NONE)
            s->head[room] = c;
        else
            s->next[s->tail[room]] = c;
        s->tail[room] = c;
    }
    return 1;
}

void enf_room_shapes_destroy(EnfRoomShapes *shapes) {
    if (!shapes)
        return;
    enf_free(shapes->head);
    enf_free(shapes->tail);
    enf_free(shapes->next);
    enf_free(shapes);
}
