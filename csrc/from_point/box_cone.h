/* SPDX-License-Identifier: GPL-3.0-or-later
 * Eight boxes against the cone of directions that one eye sees through an aperture: what its planes can't tell. */
#ifndef ENF_FROM_POINT_BOX_CONE_H
#define ENF_FROM_POINT_BOX_CONE_H

#include "from_point/block_tree.h"

#define ENF_CONE_MAX 13
/* The cone's edges. For each, and each two axes i, j: the cross product with a point about the origin less that of the eye, and
 * how much rounding may be. */
typedef struct EnfCone {
    uint32_t count;
    uint32_t views; /* bit k: looked at along axis k */
    float d[ENF_CONE_MAX][3];
    float eye[ENF_CONE_MAX][3], margin[ENF_CONE_MAX][3];
    /* All directions go up (1) or down (-1) along an axis, or neither (0); and the eye's coordinate there, times that and less the margin. */
    float side[3], behind[3];
} EnfCone;

/* directions: user's frame. eye: about the boxes' origin. reach: largest coordinate of any box about it. */
void enf_cone_make(EnfCone *cone, const double (*directions)[3], uint32_t count, uint32_t views, const double eye[3], double reach);

/* Of the boxes in `mask` (which touch all planes): those that no plane through the eye and an edge of the box parts from the cone. Errs towards keeping. */
uint32_t enf_boxes_in_cone(const EnfBoxes8 *block, uint32_t mask, const EnfCone *cone, int use_simd);

#endif
