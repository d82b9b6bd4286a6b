/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whether a sightline meets an object's box within a cell: slabs (Kay & Kajiya 1986), between the portal and the cell's faces. */
#include <math.h>

#include "from_region/region_result.h"
#include "geometry/vec3.h"

int enf_line_meets_object(const EnfRegionModel *m, const double p[3], const double d[3], uint32_t entry, uint32_t cell, uint32_t object,
                          double *out_t) {
    const EnfScene *scene = m->scene;
    const double *plane = m->plane[entry], *box = scene->objects[object].bounds;
    double low = (plane[3] - vec_dot(plane, p)) / vec_dot(plane, d), high = 1e300;
    int flat = 0;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; ++f) {
        double slope = vec_dot(scene->face_planes[f].n, d);
        if (slope > 0)
            high = fmin(high, (scene->face_planes[f].d * m->scale - vec_dot(scene->face_planes[f].n, p)) / slope);
    }
    for (int k = 0; k < 3; ++k) {
        double near_side = (box[k] - m->origin[k]) * m->scale - p[k];
        double far_side = (box[k + 3] - m->origin[k]) * m->scale - p[k];
        flat |= !(near_side < far_side);
        if (d[k] == 0) {
            if (near_side > 0 || far_side < 0)
                return 0;
            continue;
        }
        double t0 = near_side / d[k], t1 = far_side / d[k];
        low = fmax(low, fmin(t0, t1)), high = fmin(high, fmax(t0, t1));
    }
    *out_t = low;
    return flat ? low <= high : low < high;
}
