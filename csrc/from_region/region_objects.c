/* SPDX-License-Identifier: GPL-3.0-or-later
 * Objects seen from a cell. */
#include <math.h>

#include "base/status.h"
#include "from_region/region_result.h"
#include "geometry/vec3.h"

/* Whether the line of an entry, from where it enters `cell` to where it leaves it, meets the box (metres). Cells without
 * faces can't tell where a line ends in them. */
static int sightline_hits(const EnfRegionVis *r, uint64_t at, uint32_t from, uint32_t cell, const double box[6]) {
    const EnfScene *scene = r->scene;
    uint32_t first, last;
    int backward;
    if (scene->cell_face_first[cell] == scene->cell_face_first[cell + 1] || r->line[at] == ENF_NONE)
        return 0;
    const EnfLine *line = &r->lines.lines[r->line[at]];
    if (!enf_region_result_cut_line(r, line, from, cell, &first, &last, &backward))
        return 0;
    const EnfRegionModel *m = r->model;
    const double *plane = m->plane[enf_rm_own_portal(m, r->lines.portals[line->portal_first + (backward ? first : last)])];
    double sign = backward ? -1 : 1, d[3], p[3];
    double low = sign * (plane[3] - vec_dot(plane, line->p)) / vec_dot(plane, line->d) * m->inverse_scale, high = 1e300;
    for (int k = 0; k < 3; ++k)
        d[k] = sign * line->d[k], p[k] = line->p[k] * m->inverse_scale;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; ++f) {
        double slope = vec_dot(scene->face_planes[f].n, d);
        if (slope > 0)
            high = fmin(high, (scene->face_planes[f].d - vec_dot(scene->face_planes[f].n, p)) / slope);
    }
    for (int k = 0; k < 3; ++k) {
        double near_side = box[k] - m->origin[k] - p[k], far_side = box[k + 3] - m->origin[k] - p[k];
        if (d[k] == 0) {
            if (near_side > 0 || far_side < 0)
                return 0;
            continue;
        }
        double t0 = near_side / d[k], t1 = far_side / d[k];
        low = fmax(low, fmin(t0, t1)), high = fmin(high, fmax(t0, t1));
    }
    return low < high;
}

EnfStatus enf_region_vis_object(const EnfRegionVis *r, uint32_t from, uint32_t object, uint32_t *out_status, uint32_t *out_cell) {
    if (!r || !out_status)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis object: result or out_status is NULL");
    if (from >= r->cell_count || object >= r->scene->object_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis object: cell %u of %u, object %u of %u", from, r->cell_count, object,
                        r->scene->object_count);
    const uint32_t *cells = NULL;
    uint32_t count = 0, best = ENF_PAIR_HIDDEN, best_cell = ENF_NONE;
    EnfStatus status = enf_scene_object_cells(r->scene, object, &cells, &count);
    if (status != ENF_OK)
        return status;
    if (!count)
        best = ENF_PAIR_UNDECIDED;
    for (uint32_t i = 0; i < count && best != ENF_PAIR_VISIBLE; ++i) {
        uint64_t at = enf_region_result_find(r, from, cells[i]);
        if (at >= r->first[r->cell_count])
            continue;
        uint32_t found = r->status[at];
        if (found == ENF_PAIR_VISIBLE && cells[i] != from && !sightline_hits(r, at, from, cells[i], r->scene->objects[object].bounds))
            found = ENF_PAIR_UNDECIDED;
        if (best == ENF_PAIR_HIDDEN || found < best)
            best = found, best_cell = cells[i];
    }
    *out_status = best;
    if (out_cell)
        *out_cell = best_cell;
    return ENF_OK;
}
