/* SPDX-License-Identifier: GPL-3.0-or-later
 * A software depth buffer for occluders inside a view: what furniture, columns and facades hide, without a GPU.
 *
 * Based on: Aila and Miettinen, dPVS, 2004 (conservative occluder rasterization); Johansson and Roupe, Efficient real-time
 * rendering of building information models, 2009, section 4.3 (the hardware queries that it stands in for).
 *
 * Safe direction: a pixel counts as covered only where one convex occluder polygon covers all of it, at the farthest depth the
 * polygon has in that pixel; an object is hidden only if every pixel that its bounds touch is covered nearer than its nearest
 * corner. Whatever doesn't fit (behind the eye, not finite, too many corners) occludes nothing, or stays visible. Internal to the core. */
#ifndef ENF_FROM_POINT_DEPTH_BUFFER_H
#define ENF_FROM_POINT_DEPTH_BUFFER_H

#include "enfilade/base.h"

typedef struct EnfDepthBuffer EnfDepthBuffer;

typedef struct EnfDepthBufferStats {
    uint64_t occluders;         /* polygons given */
    uint64_t occluders_dropped; /* of them not usable: not finite, outside the view, thinner than a pixel */
    uint64_t pixels_written;
    uint64_t tests;
    uint64_t hidden;
    uint64_t tiles_read; /* 8 x 8 tiles looked at by tests */
} EnfDepthBufferStats;

/* width, height: pixels, 8..4096, rounded up to multiples of 8. Allocates 4 bytes a pixel and a coarse level. */
EnfStatus enf_depth_buffer_create(uint32_t width, uint32_t height, EnfDepthBuffer **out_buffer);
void enf_depth_buffer_destroy(EnfDepthBuffer *buffer);

/* Empties the buffer for a view whose screen is the rectangle of tangents [left, right] x [bottom, top] at distance 1.
 * near: what lies nearer isn't drawn by the camera: it occludes nothing. [Units: metres]
 * use_simd 0: the scalar twin, with equal bits. Costs what was drawn before. */
void enf_depth_buffer_begin(EnfDepthBuffer *buffer, const double tangents[4], double near, int use_simd);

/* Draws a convex planar polygon. corners: double[3] in camera space (eye at 0, looking along -z, y up, metres);
 * at most 64. Both sides occlude. */
void enf_depth_buffer_occlude(EnfDepthBuffer *buffer, const double (*corners)[3], uint32_t count);

/* Whether a convex body, given by points in camera space, may be seen: 0 only when it is certainly hidden within the screen (parts of it
 * outside of the screen don't count as seen). within: tangents left, right, bottom, top; parts outside of them don't count either; or NULL. */
int enf_depth_buffer_visible(EnfDepthBuffer *buffer, const double (*points)[3], uint32_t count, const double within[4]);
/* The same for a rectangle of tangents (left, right, bottom, top) at an inverse depth that nothing in it exceeds. */
int enf_depth_buffer_rect_visible(EnfDepthBuffer *buffer, const double rect[4], double nearest);

EnfDepthBufferStats enf_depth_buffer_stats(const EnfDepthBuffer *buffer);
/* Inverse depths, row by row from the bottom, `width` floats a row; 0: nothing. For tests and pictures. */
const float *enf_depth_buffer_pixels(const EnfDepthBuffer *buffer, uint32_t *out_width, uint32_t *out_height);

#endif
