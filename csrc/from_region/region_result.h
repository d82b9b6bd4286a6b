/* SPDX-License-Identifier: GPL-3.0-or-later
 * The finished answer as its own parts read it. */
#ifndef ENF_FROM_REGION_REGION_RESULT_H
#define ENF_FROM_REGION_REGION_RESULT_H

#include "from_region/bake.h"

struct EnfRegionVis {
    const EnfScene *scene;
    EnfRegionModel *model; /* with the door states of the bake; of --from perhaps a part, while rows and lines are in the scene's numbers */
    EnfBakeQuestion question;
    EnfLineStore lines;
    uint32_t cell_count;
    uint64_t *first; /* [cells + 1] */
    uint32_t *cells;
    uint8_t *status;
    uint32_t *line;                    /* beside cells: line index, ENF_NONE without */
    uint32_t *room_first, *room_cells; /* cells of each room */
    EnfRegionVisStats stats;
};

/* Where j stands in row i, or the number of entries when it doesn't. */
uint64_t enf_region_result_find(const EnfRegionVis *result, uint32_t i, uint32_t j);
/* The part of a line between two of its cells. Gives 0 when it doesn't hold both. */
int enf_region_result_cut_line(const EnfRegionVis *result, const EnfLine *line, uint32_t from, uint32_t to, uint32_t *out_first,
                               uint32_t *out_last, int *out_backward);

/* Whether the line, from its crossing of directed portal `entry` (of the model) into `cell` (of the scene) to where it leaves it, meets
 * the object's box; and where. It shows the object, so it must pass through: touching an edge doesn't count, while a box without
 * thickness is met by crossing it. Cells without faces have no end. p, d, out_t: model units. */
int enf_line_meets_object(const EnfRegionModel *model, const double p[3], const double d[3], uint32_t entry, uint32_t cell, uint32_t object,
                          double *out_t);

#endif
