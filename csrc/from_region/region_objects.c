/* SPDX-License-Identifier: GPL-3.0-or-later
 * Objects seen from a cell. */
#include "base/status.h"
#include "from_region/region_result.h"
#include "geometry/vec3.h"

/* Whether the line of an entry meets the object within `cell`. Cells without faces can't tell where a line ends in them. */
static int sightline_hits(const EnfRegionVis *r, uint64_t at, uint32_t from, uint32_t cell, uint32_t object) {
    uint32_t first, last;
    int backward;
    if (r->scene->cell_face_first[cell] == r->scene->cell_face_first[cell + 1] || r->line[at] == ENF_NONE)
        return 0;
    const EnfLine *line = &r->lines.lines[r->line[at]];
    if (!enf_region_result_cut_line(r, line, from, cell, &first, &last, &backward))
        return 0;
    uint32_t entry = enf_rm_own_portal(r->model, r->lines.portals[line->portal_first + (backward ? first : last)]);
    double d[3], t;
    vec_scale(d, backward ? -1 : 1, line->d);
    return enf_line_meets_object(r->model, line->p, d, entry, cell, object, &t);
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
        if (found == ENF_PAIR_VISIBLE && cells[i] != from && !sightline_hits(r, at, from, cells[i], object))
            found = ENF_PAIR_UNDECIDED;
        if (best == ENF_PAIR_HIDDEN || found < best)
            best = found, best_cell = cells[i];
    }
    *out_status = best;
    if (out_cell)
        *out_cell = best_cell;
    return ENF_OK;
}
