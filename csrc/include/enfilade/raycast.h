/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rays and pictures through the cells: from cell to cell until a wall (DESIGN.md section 6, "Rays").
 *
 * A raycaster packs the faces and portals of a committed scene; opening states are read at each call. Walls are the faces of cells
 * where no passable portal lies. A cell without geometry (outdoors, portal files) has no walls: what leaves it through no portal
 * has hit nothing. Furniture isn't in the cells: it comes as triangles (enfilade/triangles.h), met by Embree.
 *
 * Surfaces are numbered: face f of the scene (counted over all cells in order) is surface f; the leaf of closed portal p is surface
 * face count + p; triangle t of the furniture is surface face count + portal count + t.
 *
 * Threads: one raycaster serves any number of threads at once ("thread-safe"), while nobody changes its scene or furniture.
 * Based on: Maria, Horna, Aveneau, Efficient ray traversal of constrained Delaunay tetrahedralization and convex volumes, 2014. */
#ifndef ENFILADE_RAYCAST_H
#define ENFILADE_RAYCAST_H

#include "enfilade/scene.h"
#include "enfilade/triangles.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnfRaycaster EnfRaycaster;

/* Linear in the scene's size. The scene must outlive it; after an edit and a new commit, make another. ENF_ERROR_STATE: not committed. */
ENF_API EnfStatus enf_raycaster_create(const EnfScene *scene, EnfRaycaster **out_raycaster);
ENF_API void enf_raycaster_destroy(EnfRaycaster *raycaster); /* NULL is fine */
ENF_API uint32_t enf_raycaster_face_count(const EnfRaycaster *raycaster);

/* ---- Furniture ------------------------------------------------------------------------------------------- */
/* From now on rays meet these committed triangles too, wherever they stand; any-hit queries pass glass. NULL: none again. They stay the
 * caller's and must outlive the raycaster or the next call of this. Not thread-safe. ENF_ERROR_STATE: not committed. */
ENF_API EnfStatus enf_raycaster_furnish(EnfRaycaster *raycaster, const EnfTriangles *triangles);

/* ---- What was hit ------------------------------------------------------------------------------------------ */
enum { ENF_SURFACE_FACE = 0, ENF_SURFACE_LEAF = 1, ENF_SURFACE_FURNITURE = 2 };
typedef struct EnfSurface {
    uint32_t struct_size;
    uint32_t kind;     /* ENF_SURFACE_* */
    uint32_t cell;     /* of a face; ENF_NONE */
    uint32_t portal;   /* of a leaf; ENF_NONE */
    uint32_t opening;  /* of a leaf; ENF_NONE */
    uint32_t object;   /* of furniture, as given; ENF_NONE */
    double normal[3];  /* unit. Face: into its cell. Leaf: from cells[0] to cells[1]. Furniture: by the triangle's winding */
    double point[3];   /* where uv is 0, 0; world metres */
    double u[3], v[3]; /* unit; uv are metres along them. u is level, v climbs where the surface isn't level itself */
} EnfSurface;
ENF_API EnfSurface enf_default_surface(void);
/* ENF_ERROR_INVALID_ARGUMENT: no such surface. Thread-safe. */
ENF_API EnfStatus enf_raycaster_surface(const EnfRaycaster *raycaster, uint32_t surface, EnfSurface *out_surface);

/* ---- Single rays in double precision ------------------------------------------------------------------------- */
/* The reference: every plane of every cell, in doubles, one ray at a time, without furniture. Slower by far than the arrays below. */
typedef struct EnfRay {
    double origin[3];
    double direction[3]; /* any length > 0; distances are in its units: metres when it has length 1 */
    double max_distance; /* stop there; infinity for none */
    uint32_t cell;       /* that holds the origin; ENF_NONE: found first (a location costs more than a short walk) */
    uint32_t reserved;
} EnfRay;

typedef struct EnfRayHit {
    double distance;   /* to the surface; infinity: nothing was hit; max_distance when it ended on the way */
    uint32_t surface;  /* ENF_NONE: nothing */
    uint32_t cell;     /* where it ended; ENF_NONE: the origin is in no cell */
    uint32_t portals;  /* passed on the way, seams between cells of one room among them */
    uint32_t openings; /* of these, doors, windows and holes; the two portals of a thick one count once */
} EnfRayHit;

/* Walks `count` rays. Rays with NaN or a zero direction hit nothing, in no cell. Never fails on rays; checks only the pointers.
 * Thread-safe. */
ENF_API EnfStatus enf_raycast_rays(const EnfRaycaster *raycaster, const EnfRay *rays, uint64_t count, EnfRayHit *out_hits);

/* ---- Arrays of rays ------------------------------------------------------------------------------------------- */
/* Coordinates are single precision, relative to this point: subtract it in double before rounding, and far models lose no digit.
 * Thread-safe. */
ENF_API void enf_raycaster_origin(const EnfRaycaster *raycaster, double out_origin[3]);

/* How the rays are walked. The hits are the same but for rays that meet an edge to the last bit.
 * AUTO: PACKETS16 when `coherent` is set, else WAVES. */
enum { ENF_RAYS_AUTO = 0, ENF_RAYS_SINGLE = 1, ENF_RAYS_PACKETS8 = 2, ENF_RAYS_PACKETS16 = 3, ENF_RAYS_WAVES = 4 };
/* The instructions used at most; the same bits by all. */
enum { ENF_SIMD_BEST = 0, ENF_SIMD_NONE = 1, ENF_SIMD_AVX2 = 2, ENF_SIMD_AVX512 = 3 };

/* One array a coordinate, [count] each. */
typedef struct EnfRayBatch {
    uint32_t struct_size;
    uint32_t method;            /* ENF_RAYS_* */
    uint32_t simd;              /* ENF_SIMD_* */
    uint32_t threads;           /* 0: one a core; the same bits for any number */
    uint32_t coherent;          /* 1: rays next to each other go alike (pixels of a tile, shadows to one light) */
    uint32_t without_furniture; /* 1: walls and leaves only */
    uint64_t count;
    const float *origin_x, *origin_y, *origin_z;          /* metres, relative to enf_raycaster_origin */
    const float *direction_x, *direction_y, *direction_z; /* any length > 0; distances are in its units */
    const float *max_distance;                            /* NULL: infinity. Hits count when nearer than this */
    const uint32_t *cell;                                 /* that holds the origin; NULL or ENF_NONE: found first */
    const uint32_t *target_cell; /* any-hit only: the cell that holds the ray's end (a light's): a ray that reaches it through
                                    openings is past all walls. NULL or ENF_NONE: not known */
} EnfRayBatch;
ENF_API EnfRayBatch enf_default_ray_batch(void);

/* One array a result, [count] each; any may be NULL. */
typedef struct EnfRayHits {
    uint32_t struct_size;
    uint32_t reserved;
    float *distance;   /* in units of the direction; infinity: nothing hit before max_distance */
    uint32_t *surface; /* ENF_NONE: nothing hit */
    uint32_t *cell;    /* where it ended, i.e. where a ray that bounces off begins; ENF_NONE: the origin is in no cell */
    uint8_t *portals;  /* passed on the way, at most 255 */
    float *normal;     /* [count][3], unit, towards the ray's side; 0, 0, 0 where nothing is hit */
    float *uv;         /* [count][2], faces, leaves, furniture: metres along EnfSurface.u, v */
} EnfRayHits;
ENF_API EnfRayHits enf_default_ray_hits(void);

/* The nearest hit of each ray. Rays with NaN or a zero direction hit nothing, in no cell. ENF_ERROR_INVALID_ARGUMENT: a NULL
 * among the coordinates, a bad struct_size or method. Thread-safe. */
ENF_API EnfStatus enf_raycast_closest(const EnfRaycaster *raycaster, const EnfRayBatch *batch, EnfRayHits *hits);
/* Whether something is hit before max_distance. out_blocked: [count], 1 or 0; rays whose origin is in no cell: 0 (the safe
 * direction: lit). Thread-safe. */
ENF_API EnfStatus enf_raycast_any(const EnfRaycaster *raycaster, const EnfRayBatch *batch, uint8_t *out_blocked);

/* ---- Pictures ------------------------------------------------------------------------------------------------- */
/* SPANS: scan conversion of cell faces inside apertures, one interval of whole pixels a row, so that each pixel is written exactly
 * once. TILES: 16 x 16 pixels are filled when the rays at their corners take one way, else rays. PACKETS: rays, 4 x 4 pixels at a time. */
enum { ENF_IMAGE_SPANS = 0, ENF_IMAGE_TILES = 1, ENF_IMAGE_PACKETS = 2 };

/* The picture of a perspective camera. Row 0 is the top. Any output may be NULL.
 * depth: metres along the view axis, infinity where nothing is hit. surface, cell, normal, uv: as in EnfRayHits. portals: passed before
 * the hit, at most 255.
 * threads: 0 one a core; the same bits for any number. ENF_ERROR_BAD_INPUT: not a finite perspective camera below 180 degrees. */
typedef struct EnfRaycastImage {
    uint32_t struct_size;
    uint32_t width, height; /* 1 .. 16384 */
    uint32_t threads;
    float *depth;               /* [height][width] */
    uint32_t *surface;          /* [height][width] */
    uint32_t *cell;             /* [height][width] */
    uint8_t *portals;           /* [height][width] */
    uint64_t spans;             /* out: row intervals written */
    uint64_t visits;            /* out: cells entered */
    uint64_t patched;           /* out: pixels that rounding left to no face and the nearest one got */
    float *normal;              /* [height][width][3] */
    float *uv;                  /* [height][width][2] */
    uint32_t method;            /* ENF_IMAGE_* */
    uint32_t simd;              /* ENF_SIMD_* */
    uint32_t without_furniture; /* 1: walls and leaves only */
    uint32_t reserved;
} EnfRaycastImage;
ENF_API EnfRaycastImage enf_default_raycast_image(void);
ENF_API EnfStatus enf_raycast_image(const EnfRaycaster *raycaster, const EnfCamera *camera, EnfRaycastImage *image);

#ifdef __cplusplus
}
#endif
#endif
