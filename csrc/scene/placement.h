/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells an object is drawn in, when nobody said. */
#ifndef ENF_SCENE_PLACEMENT_H
#define ENF_SCENE_PLACEMENT_H

#include "scene/scene_data.h"

/* Fills placed_first, placed_cells, cell_object_first, cell_object_list, unplaced_objects. Needs bounds and
 * the locator. */
EnfStatus enf_scene_place_objects(EnfScene *scene);

#endif
