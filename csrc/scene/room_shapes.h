/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells a room has, while a scene is being built: enf_scene_join asks for them portal by portal. */
#ifndef ENF_SCENE_ROOM_SHAPES_H
#define ENF_SCENE_ROOM_SHAPES_H

#include "scene/scene_data.h"

typedef struct EnfRoomShapes {
    uint32_t *head, *tail; /* [rooms] first and last cell, ENF_NONE for none */
    uint32_t *next;        /* [cells] next cell of the same room, ascending */
    uint32_t rooms, cells; /* how many are linked in */
} EnfRoomShapes;

/* Links in what was added since the last call: constant time a cell. 0: out of memory. */
int enf_room_shapes_update(EnfScene *scene);
void enf_room_shapes_destroy(EnfRoomShapes *shapes); /* NULL is fine */

#endif
