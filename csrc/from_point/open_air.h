/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cells outdoors that an eye sees whole: nothing is to be clipped on the way there. */
#ifndef ENF_FROM_POINT_OPEN_AIR_H
#define ENF_FROM_POINT_OPEN_AIR_H

#include "from_point/view_data.h"

/* A face of a cell outdoors. */
struct EnfOpenFace {
    double n[3], d;                      /* outward: n . (p - origin) = d */
    uint32_t source_first, source_count; /* into EnfViewIndex.open_sources: the cells behind it */
    uint32_t is_open, reserved;          /* none of it is wall */
};

/* Fills index->open_faces, open_sources and EnfViewCell.face_first, face_count. */
EnfStatus enf_build_open_faces(EnfViewIndex *index);
/* What the only eye has to do with a cell outdoors. An answer that is wrong costs, it hides nothing.
 * flags & ENF_CELL_OPEN: no wall stands between the eye and any place in it; it may have the whole screen.
 * rank: more than that of every cell a straight way from the eye comes through before it. */
const EnfCellState *enf_open_air(EnfView *view, uint32_t c);
/* Whether it matters what exactly is seen of cell c: objects are there, or windows that look at the eye, or such a cell lies behind. */
int enf_needs_care(EnfView *view, uint32_t c);

#endif
