/* SPDX-License-Identifier: GPL-3.0-or-later
 * What is remembered of decomposed rooms. */
#include "scene/room_shapes.h"
#include "base/memory.h"

struct EnfRoomShapes {
    int reserved;
};

void enf_room_shapes_destroy(EnfRoomShapes *shapes) { enf_free(shapes); }
