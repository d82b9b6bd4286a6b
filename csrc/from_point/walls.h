/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walls: the many portals of one cell (a facade's windows, a hall's doors) sorted by plane, with a hierarchy. */
#ifndef ENF_FROM_POINT_WALLS_H
#define ENF_FROM_POINT_WALLS_H

#include "from_point/view_index.h"

/* For every cell with ENF_WALL_SIDES portal sides or more. The index's sides are packed already. */
EnfStatus enf_build_walls(EnfViewIndex *index);
/* Whether every side of the wall turns its back to `eye` (user's frame): certainly nothing is seen through it. */
int enf_wall_faces_away(const EnfViewIndex *index, const EnfWall *wall, const double eye[3], double slack);

#endif
