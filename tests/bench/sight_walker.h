/* SPDX-License-Identifier: GPL-3.0-or-later
 * An oracle: walks a straight line from cell to cell through portal polygons, and says by how much it clears them.
 * Uses the scene's public arrays alone and shares no code with the engines. */
#ifndef ENF_TESTS_SIGHT_WALKER_H
#define ENF_TESTS_SIGHT_WALKER_H

#include "enfilade/scene.h"

typedef struct SightWalker SightWalker;

SightWalker *sight_walker_create(const EnfScene *scene); /* NULL: out of memory */
void sight_walker_destroy(SightWalker *walker);

typedef struct SightWalk {
    uint32_t cells[512];   /* start cell first */
    uint32_t portals[512]; /* portals[i] leads from cells[i] to cells[i + 1] */
    uint32_t cell_count;
    double clearance;         /* least angle (radians, small-angle) between the line and an edge it passes; inf without portals */
    double clearance_at[512]; /* the same up to cells[i] */
    double t_enter[512];      /* eye + t * direction is where cells[i] is entered */
} SightWalk;

/* From eye in cell `start` along direction (any length), until the line leaves the cells or t exceeds t_max. Closed
 * openings stop it. Boundary hits count as passing with clearance 0. */
void sight_walk(const SightWalker *walker, uint32_t start, const double eye[3], const double direction[3], double t_max, SightWalk *out);

/* Whether the line between t0 and t1 passes through the inside of the box (min xyz, max xyz), by more than rounding. */
int sight_meets_box(const double eye[3], const double direction[3], double t0, double t1, const double box[6]);

/* A small generator for tests: splitmix64. */
typedef struct SightRng {
    uint64_t state;
} SightRng;
uint64_t sight_next(SightRng *rng);
double sight_unit(SightRng *rng); /* [0, 1) */

/* A random point of a cell: a convex combination of its own vertices (of its portals' without geometry). degenerate != 0:
 * on a face, an edge, a corner, or a portal of it instead. 0 when the cell has neither vertices nor portals. */
int sight_point_in_cell(const SightWalker *walker, SightRng *rng, uint32_t cell, int degenerate, double out[3]);

#endif
