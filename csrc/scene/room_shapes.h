/* SPDX-License-Identifier: GPL-3.0-or-later
 * What is remembered of decomposed rooms, so that enf_scene_join can split a portal among their cells. */
#ifndef ENF_SCENE_ROOM_SHAPES_H
#define ENF_SCENE_ROOM_SHAPES_H

#include "scene/scene_data.h"

typedef struct EnfRoomShapes EnfRoomShapes;
void enf_room_shapes_destroy(EnfRoomShapes *shapes); /* NULL is fine */

#endif
