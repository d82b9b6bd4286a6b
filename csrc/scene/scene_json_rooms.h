/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rooms and portals of a scene file as people draw them: kept while reading, decomposed and joined at the
 * end. */
#ifndef ENF_SCENE_SCENE_JSON_ROOMS_H
#define ENF_SCENE_SCENE_JSON_ROOMS_H

#include "scene/scene_data.h"

enum { ENF_DRAWN_NONE = 0, ENF_DRAWN_PRISM = 1, ENF_DRAWN_MESH = 2 };

typedef struct EnfDrawnRoom {
    uint32_t kind, room;
    uint64_t number_first, point_count, size_first, size_count, index_first; /* into EnfDrawn's arrays */
    double z[2];
} EnfDrawnRoom;

typedef struct EnfDrawnPortal {
    uint32_t kinds[2], sides[2], opening, index; /* index: in the file */
    uint64_t number_first, point_count;
} EnfDrawnPortal;

typedef struct EnfDrawn {
    double *numbers;
    uint32_t *sizes, *indices;
    EnfDrawnRoom *rooms;
    EnfDrawnPortal *portals;
    uint32_t *portal_index; /* [file_portal_count] index in the scene of the file's portals */
    uint64_t number_count, size_count, index_count, room_count, portal_count, file_portal_count;
} EnfDrawn;

EnfStatus enf_drawn_build(EnfDrawn *drawn, EnfScene *scene);
void enf_drawn_free(EnfDrawn *drawn);

#endif
