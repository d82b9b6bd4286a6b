/* SPDX-License-Identifier: GPL-3.0-or-later
 * Facets of walls that bulge into a room, taken together so that they don't shatter it. */
#ifndef ENF_SCENE_CURVED_WALLS_H
#define ENF_SCENE_CURVED_WALLS_H

#include "enfilade/base.h"

/* A room's shape with fewer facets; `vertices` stay the caller's. */
typedef struct EnfStraightened {
    uint32_t *face_sizes, *face_indices;
    uint32_t face_count;
    uint32_t facets; /* that were replaced by fewer */
    double depth;    /* metres that the room grew into its wall at most */
} EnfStraightened;

/* Fills *out; facets 0: nothing was to do, and the arrays stay NULL. The shape must be sound as enf_decompose_polyhedron
 * checks it. 0: out of memory. */
int enf_curves_straighten(EnfStraightened *out, double (*vertices)[3], const uint32_t *face_sizes, uint32_t face_count,
                          const uint32_t *face_indices);
void enf_straightened_free(EnfStraightened *straightened);

/* The same for the rings of a prism, `ring_count` of them one after the other in corners: thins both out in place. Rings wind
 * either way. Gives the number of facets replaced; -1: out of memory. */
int64_t enf_rings_straighten(double (*corners)[2], uint32_t *ring_sizes, uint64_t ring_count, double *out_depth);

#endif
