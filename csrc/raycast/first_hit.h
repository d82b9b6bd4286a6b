/* SPDX-License-Identifier: GPL-3.0-or-later
 * What the rays of a picture meet: the nearest triangle, and the room, the cell and the openings on the way to it. Internal to the core. */
#ifndef ENF_RAYCAST_FIRST_HIT_H
#define ENF_RAYCAST_FIRST_HIT_H

#include "enfilade/preview.h"
#include "raycast/triangle_tree.h"

typedef struct SightRay {
    TreeRay ray;
    uint32_t cell; /* that holds its origin; ENF_NONE: looked for */
    int known;     /* 0: no cell is asked, as where walls as drawn and cells don't agree */
} SightRay;

typedef struct Seen {
    double distance;               /* infinity: nothing */
    double position[3], normal[3]; /* towards the viewer */
    double plane[3];               /* as wound */
    double walk_from[3];           /* inside `cell`, next to position */
    EnfMaterial material;
    uint32_t object, cell, openings;
} Seen;

/* count: at most TREE_RAYS, those of neighbouring pixels best: they are walked and met together. All that are known start in one cell.
 * openings: 0: they aren't counted. */
void enf_first_hits(const EnfPreview *image, const SightRay *rays, uint32_t count, int openings, Seen *out);

#endif
