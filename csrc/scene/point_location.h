/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells hold a point. */
#ifndef ENF_SCENE_POINT_LOCATION_H
#define ENF_SCENE_POINT_LOCATION_H

#include "geometry/box_tree.h"
#include "scene/scene_data.h"

typedef struct EnfLocator {
    EnfBoxTree cells;      /* cells with geometry, by their vertices' bounds */
    EnfBoxTree hulls;      /* cells without, by their portals' bounds */
    uint32_t *graph_cells; /* [graph_count] cells without faces, ascending */
    uint32_t graph_count;
    uint8_t *graph_convex; /* [cells] 1: no faces, and convex as far as its portals tell */
} EnfLocator;

int enf_locator_build(EnfScene *scene); /* 0: out of memory */
void enf_locator_destroy(EnfLocator *locator);

#endif
