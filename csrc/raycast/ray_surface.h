/* SPDX-License-Identifier: GPL-3.0-or-later
 * What a surface's number stands for, and where on it a ray hit. Internal to the core. */
#ifndef ENF_RAYCAST_RAY_SURFACE_H
#define ENF_RAYCAST_RAY_SURFACE_H

#include "raycast/ray_model.h"

typedef struct SurfaceFrame {
    double normal[3];
    double point[3]; /* recentred */
    double u[3], v[3];
} SurfaceFrame;

/* surface must exist */
void enf_surface_frame(const EnfRaycaster *raycaster, uint32_t surface, SurfaceFrame *out_frame);

#endif
