/* SPDX-License-Identifier: GPL-3.0-or-later
 * A perspective camera's pixels and what lies behind them. Internal to the core. */
#ifndef ENF_RAYCAST_SCREEN_H
#define ENF_RAYCAST_SCREEN_H

#include "raycast/ray_surface.h"

typedef struct Screen {
    double eye[3];       /* recentred */
    double axes[3][3];   /* camera's x, y, z in world */
    double left, top;    /* tangents */
    double per_x, per_y; /* pixels a tangent */
    double near_guard;   /* metres; nothing nearer is projected, only to avoid dividing by nothing */
    /* The ray through pixel centre x, y goes along base + x * across + y * down, one metre along the view axis. */
    double base[3], across[3], down[3];
} Screen;

/* ENF_ERROR_BAD_INPUT: not a finite perspective camera below 180 degrees. */
EnfStatus enf_screen_make(const EnfRaycaster *raycaster, const EnfCamera *camera, uint32_t width, uint32_t height, Screen *out_screen);

/* 1 / depth over the screen: a * x + b * y + c at pixel centres. */
typedef struct InverseDepth {
    double a, b, c;
} InverseDepth;
/* point: on the plane, recentred. */
InverseDepth enf_inverse_depth(const Screen *screen, const double normal[3], const double point[3]);

/* One picture being made. */
typedef struct ImageTask {
    const EnfRaycaster *r;
    const Screen *screen;
    EnfRaycastImage *image;
    const struct RayKernel *kernel;
    uint32_t cell; /* that holds the eye; ENF_NONE: in none */
} ImageTask;

/* Pictures by rays: tiles filled when their corners go one way, or packets only. */
EnfStatus enf_image_by_rays(const ImageTask *task);
EnfStatus enf_image_by_spans(const ImageTask *task);

/* What a surface puts into normal and uv: linear over the screen but for the depth. */
typedef struct FrameFill {
    float normal[3];
    InverseDepth inverse;
    double from[2];                     /* uv of the eye's foot */
    double base[2], across[2], down[2]; /* u and v of the ray through pixel 0, 0, and a pixel on */
} FrameFill;
/* ENF_NONE: zeros. */
FrameFill enf_frame_fill(const ImageTask *task, uint32_t surface);
/* normal and uv of `count` pixels of row y from x on. */
void enf_image_write_frame(const ImageTask *task, uint32_t x, uint32_t y, uint32_t count, const FrameFill *fill);

#endif
