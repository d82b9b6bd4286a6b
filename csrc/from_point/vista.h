/* SPDX-License-Identifier: GPL-3.0-or-later
 * Vistas: what each window shows to eyes outdoors, prepared as slopes of sightlines, and looked up for all windows in view. */
#ifndef ENF_FROM_POINT_VISTA_H
#define ENF_FROM_POINT_VISTA_H

#include "from_point/view_data.h"

#include <string.h>

/* Sixteen rectangles of slopes, rounded to order-preserving keys: what overlaps as numbers overlaps as keys. Unused lanes overlap nothing. */
#define ENF_SLOPE_LANES 16
typedef struct EnfSlopes16 {
    int16_t lo[2][ENF_SLOPE_LANES], hi[2][ENF_SLOPE_LANES];
} EnfSlopes16;

/* A cell that straight lines through the window reach by one row of portals; those before it are its parents'. */
typedef struct EnfVistaStage {
    uint32_t cell, portal, opening;
    uint32_t parent; /* its number in the vista, below its own; the first is its own */
} EnfVistaStage;
#define ENF_VISTA_STAGES 256

/* What one window shows: stages, and objects in them. Their slopes lie in blocks, from one of their own on. */
typedef struct EnfVista {
    uint32_t stage_first, stage_count, stage_block;
    uint32_t object_first, object_count; /* into objects and object_stages; their slopes: one block in sixteen */
    uint32_t complete;                   /* 0: more can be seen through it than was prepared */
} EnfVista;

/* Windows of one direction: corner + x u + y v + z n, z inwards, in the order of a tree over their boxes. */
typedef struct EnfFacade {
    double corner[3], u[3], v[3], n[3];
    double farthest; /* z */
    double reach;    /* no coordinate is larger. [Units: metres] */
    double slack;    /* by which a window's surface may stray from its z. [Units: metres] */
    EnfBlockTree tree;
    uint32_t vista_first; /* and of the frames: one eighth */
    int turned;           /* against the scene's axes */
} EnfFacade;
typedef struct EnfWindows8 {
    float x0[8], y0[8], x1[8], y1[8], z[8];
} EnfWindows8;

struct EnfVistas {
    EnfFacade *facades;
    EnfBoxes8 *boxes;
    EnfWindows8 *windows;
    EnfVista *vistas;
    EnfVistaStage *stages;
    EnfSlopes16 *stage_slopes, *object_slopes;
    uint32_t *objects;
    uint8_t *object_stages;
    uint32_t facade_count, box_count, vista_count, stage_count, stage_block_count, object_count;
    uint32_t incomplete_count;            /* of the windows */
    uint64_t tried;                       /* pairs of boxes, in preparing all this */
    EnfBoxSet outdoors, outdoor_objects;  /* cells, and objects in them */
    uint32_t *boundless, boundless_count; /* cells outdoors without shape */
};

/* Prepares them when first asked for, under the lock. */
EnfStatus enf_view_index_need_vistas(EnfViewIndex *index);
void enf_vistas_destroy(struct EnfVistas *vistas); /* NULL is fine */

/* Slopes as keys: a <= b means that key(a) <= key(b). */
static inline int16_t enf_slope_key(float slope) {
    int32_t bits;
    memcpy(&bits, &slope, sizeof bits);
    bits ^= (bits >> 31) & 0x7FFFFFFF;
    return (int16_t)(bits >> 16);
}

/* For an only eye, outdoors: everything outdoors within the screen, and what the windows in it that look at the eye show, into the
 * answer. *out_done 0: not all that these can show is prepared, and nothing was added. */
EnfStatus enf_sweep(EnfView *view, const EnfScreen *screen, int *out_done);

/* frustum.c: the outdoors of it. */
void enf_cull_outdoors(EnfView *view, const EnfScreen *screen, const struct EnfVistas *vistas);

#endif
