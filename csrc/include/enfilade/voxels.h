/* SPDX-License-Identifier: GPL-3.0-or-later
 * Voxels: what finding rooms in bare geometry needs to be fast. A grid of cubes marked by triangles, regions of free
 * voxels labelled, labels grown.
 *
 * A grid is the caller's array of size[0] * size[1] * size[2] elements, x running fastest, then y, then z; voxel (i, j, k) is the cube
 * from origin + step * (i, j, k) to origin + step * (i + 1, j + 1, k + 1). Units: metres. Nothing is kept between calls.
 * Threads: "safe on different arrays". Errors: ENF_ERROR_INVALID_ARGUMENT for NULL, ENF_ERROR_BAD_INPUT with the reason for a size of
 * 0 or above 2^32 - 2 voxels, a step that isn't positive, a corner index out of range, coordinates that aren't finite. */
#ifndef ENFILADE_VOXELS_H
#define ENFILADE_VOXELS_H

#include "enfilade/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sets the bits `value` in every voxel that a triangle touches, conservatively: a voxel is left alone only when a plane separates it
 * from the triangle by more than rounding (Akenine-Moeller 2001), so a wall without a hole leaves no way through, not even by a corner.
 * vertices: double[3] each, stride in bytes (0 = packed); triangles: 3 corner indices each. Parts outside the grid are left out. */
ENF_API EnfStatus enf_voxels_mark(const uint32_t size[3], const double origin[3], double step, const double *vertices,
                                  uint64_t vertex_count, uint64_t vertex_stride, const uint32_t *triangles, uint64_t triangle_count,
                                  uint8_t value, uint8_t *voxels);

/* Numbers the regions of voxels with the same value other than 0 that hang together by faces: 1, 2, ... in the order of their first
 * voxel; 0 where `kinds` is 0. labels and kinds are two arrays. out_count: how many regions. */
ENF_API EnfStatus enf_voxels_label(const uint32_t size[3], const uint8_t *kinds, uint32_t *labels, uint32_t *out_count);

/* Spreads the labels that stand in `labels` (0: none) through passable voxels (not 0), one step by faces at a time, at most `steps`
 * (0: until nothing changes). Where two fronts meet in the same step the lower label wins: the same bits every time. When memory runs out the steps so far stand. Labels
 * from 2^31 on are refused. */
ENF_API EnfStatus enf_voxels_grow(const uint32_t size[3], const uint8_t *passable, uint32_t steps, uint32_t *labels);

/* The boxes of labels 0..count, uint32_t[6] each: the first voxel along x, y, z, then one beyond the last. A label that stands nowhere has
 * ENF_NONE three times, then 0. ENF_ERROR_BAD_INPUT for labels above count. */
ENF_API EnfStatus enf_voxels_boxes(const uint32_t size[3], const uint32_t *labels, uint32_t count, uint32_t *boxes);

/* Free voxels (0 in `blocked`) from each one on downward and upward along z, itself counted, 255 at most; 255 too when the run leaves the grid,
 * 0 where something is in the way. */
ENF_API EnfStatus enf_voxels_runs(const uint32_t size[3], const uint8_t *blocked, uint8_t *down, uint8_t *up);

/* Sets `mask` to 1 in every voxel of the boxes of 2 * reach + 1 voxels round the voxels that weren't 0, in place. reach: along x, y, z, 254 at
 * most (ENF_ERROR_BAD_INPUT). ENF_ERROR_OUT_OF_MEMORY leaves the mask alone. */
ENF_API EnfStatus enf_voxels_widen(const uint32_t size[3], const uint8_t reach[3], uint8_t *mask);

/* Puts names[label] for each label, in place: names is uint32_t[count + 1]. ENF_ERROR_BAD_INPUT for labels above count; then nothing is changed. */
ENF_API EnfStatus enf_voxels_rename(const uint32_t size[3], const uint32_t *names, uint32_t count, uint32_t *labels);

#ifdef __cplusplus
}
#endif
#endif
