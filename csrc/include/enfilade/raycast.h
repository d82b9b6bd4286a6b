/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rays and pictures through the cells: from cell to cell until a wall (DESIGN.md section 6, "Rays").
 *
 * A raycaster packs the faces and portals of a committed scene; opening states are read at each call. Walls are the faces of cells
 * where no passable portal lies. A cell without geometry (outdoors, portal files) has no walls: what leaves it through no portal
 * has hit nothing. Furniture isn't in the cells, so it isn't here.
 * Threads: one raycaster serves any number of threads at once ("thread-safe"), while nobody changes its scene.
 * Based on: Maria, Horna, Aveneau, Efficient ray traversal of constrained Delaunay tetrahedralization and convex volumes, 2014. */
#ifndef ENFILADE_RAYCAST_H
#define ENFILADE_RAYCAST_H

#include "enfilade/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnfRaycaster EnfRaycaster;

/* Linear in the scene's size. The scene must outlive it; after an edit and a new commit, make another. ENF_ERROR_STATE: not committed. */
ENF_API EnfStatus enf_raycaster_create(const EnfScene *scene, EnfRaycaster **out_raycaster);
ENF_API void enf_raycaster_destroy(EnfRaycaster *raycaster); /* NULL is fine */

typedef struct EnfRay {
    double origin[3];
    double direction[3]; /* any length > 0; distances are in its units: metres when it has length 1 */
    double max_distance; /* stop there; infinity for none */
    uint32_t cell;       /* that holds the origin; ENF_NONE: found first (a location costs more than a short walk) */
    uint32_t reserved;
} EnfRay;

/* Surfaces: face f of the scene (counted over all cells in order) is surface f; the leaf of closed portal p is surface
 * enf_raycaster_face_count + p. */
typedef struct EnfRayHit {
    double distance;  /* to the surface; infinity: nothing was hit; max_distance when it ended on the way */
    uint32_t surface; /* ENF_NONE: nothing */
    uint32_t cell;    /* where it ended; ENF_NONE: the origin is in no cell */
    uint32_t portals; /* passed on the way */
    uint32_t reserved;
} EnfRayHit;

/* Walks `count` rays. Rays with NaN or a zero direction hit nothing, in no cell. Never fails on rays; checks only the pointers.
 * Thread-safe. */
ENF_API EnfStatus enf_raycast_rays(const EnfRaycaster *raycaster, const EnfRay *rays, uint64_t count, EnfRayHit *out_hits);

/* The picture of a perspective camera by span portals: scan conversion of cell faces inside apertures, one interval of whole
 * pixels a row, so that each pixel is written exactly once. Row 0 is the top. Any output may be NULL.
 * depth: metres along the view axis, infinity where nothing is hit. surface, cell: as in EnfRayHit. portals: passed before the hit, at most 255.
 * threads: 0 one a core; the same bits for any number. ENF_ERROR_BAD_INPUT: not a finite perspective camera below 180 degrees. */
typedef struct EnfRaycastImage {
    uint32_t struct_size;
    uint32_t width, height; /* 1 .. 16384 */
    uint32_t threads;
    float *depth;      /* [height][width] */
    uint32_t *surface; /* [height][width] */
    uint32_t *cell;    /* [height][width] */
    uint8_t *portals;  /* [height][width] */
    uint64_t spans;    /* out: row intervals written */
    uint64_t visits;   /* out: cells entered */
    uint64_t patched;  /* out: pixels that rounding left to no face and the nearest one got */
} EnfRaycastImage;
ENF_API EnfRaycastImage enf_default_raycast_image(void);
ENF_API EnfStatus enf_raycast_image(const EnfRaycaster *raycaster, const EnfCamera *camera, EnfRaycastImage *image);

ENF_API uint32_t enf_raycaster_face_count(const EnfRaycaster *raycaster);

#ifdef __cplusplus
}
#endif
#endif
