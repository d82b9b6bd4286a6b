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

/* What windows show: cells, or objects. A window's lie in blocks of their own, sixteen a block; an item's place is its slot. */
typedef struct EnfVistaItems {
    EnfSlopes16 *slopes; /* [blocks] */
    uint32_t *ids;       /* [slots] */
    uint32_t *stages;    /* [slots] the slot of the cell behind which it is seen, below its own; of the first cell, its own */
    uint32_t block_count;
} EnfVistaItems;

/* What one window shows: stages, that is cells which straight lines reach by one row of portals each, and objects in them. */
typedef struct EnfVista {
    uint32_t cell_block, cell_count, object_block, object_count;
    uint32_t complete; /* 0: more can be seen through it than was prepared */
    uint32_t work;     /* as EnfViewStats counts it */
} EnfVista;
#define ENF_VISTA_STAGES 256

/* Windows of one direction: corner + x u + y v + z n, z inwards, in the order of a tree over their boxes. */
typedef struct EnfFacade {
    double corner[3], u[3], v[3], n[3];
    double farthest;          /* z */
    double reach;             /* no coordinate is larger. [Units: metres] */
    double slack;             /* by which a window's surface may stray from its z. [Units: metres] */
    float centre[3], half[3]; /* of the windows' box, as in EnfBoxes8 */
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
    EnfVistaItems cells, objects; /* objects: that are nowhere outdoors */
    uint32_t *portals, *openings; /* [slots of cells] by which each is entered */
    uint32_t facade_count, box_count, vista_count;
    uint64_t tried;                       /* pairs of boxes, in preparing all this */
    EnfBoxSet outdoors, outdoor_objects;  /* cells, and objects in them */
    uint32_t *boundless, boundless_count; /* cells outdoors without shape */
    int pays;                             /* sweeping costs less than comparing what is indoors with the frustum */
};

/* Part of making an index. */
EnfStatus enf_build_vistas(EnfViewIndex *index);
void enf_vistas_destroy(struct EnfVistas *vistas); /* NULL is fine */

/* Slopes as keys: a <= b means that key(a) <= key(b). */
static inline int16_t enf_slope_key(float slope) {
    int32_t bits;
    memcpy(&bits, &slope, sizeof bits);
    bits ^= (bits >> 31) & 0x7FFFFFFF;
    return (int16_t)(bits >> 16);
}

/* For an only eye, outdoors: everything outdoors within the screen, and what the windows in it that look at the eye show, into the
 * answer. *out_done 0: not all that these can show is prepared, or the budget is spent. */
EnfStatus enf_sweep(EnfView *view, const EnfScreen *screen, int *out_done);
/* Steps to what was swept are made when somebody asks for them. */
EnfStatus enf_sweep_steps(EnfView *view);

/* frustum.c: the outdoors of it. */
void enf_cull_outdoors(EnfView *view, const EnfPlanes *for_objects, const EnfPlanes *for_cells);

#endif
