/* SPDX-License-Identifier: GPL-3.0-or-later
 * On which side of a plane a cell lies. */
#ifndef ENF_SCENE_CELL_SIDE_H
#define ENF_SCENE_CELL_SIDE_H

#include "geometry/vec3.h"
#include "scene/scene_data.h"

/* How far the cell's vertices lie, least and most, from the plane n . (x - from) = d, along n. [Metres] A cell without any: least > most. */
static inline void enf_cell_reach(const EnfScene *scene, uint32_t c, const double from[3], const double n[3], double d, double *low,
                                  double *high) {
    double local[3];
    *low = DBL_MAX, *high = -DBL_MAX;
    for (uint32_t v = scene->cell_vertex_first[c]; v < scene->cell_vertex_first[c + 1]; v++) {
        vec_sub(local, scene->cell_vertices[v], from);
        double distance = vec_dot(n, local) - d;
        *low = fmin(*low, distance);
        *high = fmax(*high, distance);
    }
}

/* How plainly what reaches so far lies on one side: 1 all in front, -1 all behind, 0 as much as not, or in the plane. */
static inline double enf_plain_side(double low, double high) {
    return high > low ? (high + low) / (high - low) : 0.0;
}

#endif
