/* SPDX-License-Identifier: GPL-3.0-or-later
 * What rays met in the cells against what stands in the rooms. Internal to the core. */
#ifndef ENF_RAYCAST_FURNITURE_MERGE_H
#define ENF_RAYCAST_FURNITURE_MERGE_H

#include "raycast/screen.h"

/* At most RAY_BLOCK rays that have been walked. */
typedef struct MergeRays {
    uint32_t count;
    const float *o[3], *d[3]; /* [count] */
    const float *limit;       /* [count] where a ray that hit nothing ends; NULL: never */
    const uint32_t *start;    /* [count] cells that hold the origins; ENF_NONE: not asked for furniture */
    float *distance;          /* [count] in: to the wall, infinity for none; out: to what is nearer */
    uint32_t *surface;        /* [count] */
    uint32_t *cell, *portals; /* [count] set anew for rays that furniture stops; both NULL: not needed */
} MergeRays;

void enf_furniture_merge(const EnfRaycaster *raycaster, const MergeRays *rays, int any);
/* The whole picture, after its walls are drawn with their depths. */
void enf_image_merge_furniture(const ImageTask *task);

#endif
