/* SPDX-License-Identifier: GPL-3.0-or-later
 * The stabbing cone: all six-vectors on the inner side of every edge of a chain of portals, by its extremal rays.
 *
 * Based on: Teller 1992 (stabbing lines as cone and Klein quadric); T. Motzkin et al. 1953 (double description). */
#ifndef ENF_FROM_REGION_STAB_CONE_H
#define ENF_FROM_REGION_STAB_CONE_H

#include <stdint.h>

#include "from_region/line_side.h"

/* Rows used at most; further ones are left out (a larger cone: the safe direction for "hidden"). */
#define ENF_CONE_ROWS 128
#define ENF_CONE_PLACES 64
/* Rays at most; beyond, the test gives up. */
#define ENF_CONE_RAYS 320

typedef struct EnfConeRay {
    EnfBoundedLine line;
    uint64_t tight[2]; /* rows it lies on exactly */
    uint64_t planes;   /* portals in whose planes it lies, bit by place */
    uint64_t maybe[2]; /* rows it may lie on: the sign was lost in rounding */
    double value, error; /* of the row being added */
} EnfConeRay;

typedef struct EnfStabCone {
    EnfBoundedLine rows[ENF_CONE_ROWS];
    uint32_t row_portal[ENF_CONE_ROWS]; /* portal of each row, in the order they were added */
    uint64_t place_rows[ENF_CONE_PLACES][2]; /* rows of each portal */
    uint32_t place_count, last_place;
    uint32_t row_count;
    uint64_t applied[2]; /* rows the cone has been cut by */
    EnfBoundedLine lineality[6];
    uint32_t lineality_count;
    EnfConeRay rays[ENF_CONE_RAYS];
    uint32_t ray_count;
    int ambiguous;      /* signs the filter couldn't decide */
    int dropped_rows;
    uint64_t rays_made;
} EnfStabCone;

enum { ENF_CONE_EMPTY = 0, ENF_CONE_STABBED = 1, ENF_CONE_UNKNOWN = 2 };

/* Forgets all rows. */
void enf_cone_begin(EnfStabCone *cone);
/* One edge a -> b of the portal at `place` in the chain; the inside is where the row is positive for lines in the
 * direction of travel. plane_error: how far corners may stray from the portal's plane (0 when it is aligned exactly). */
void enf_cone_add_edge(EnfStabCone *cone, const double a[3], const double b[3], double plane_error, uint32_t place);
/* Runs the double description. EMPTY: certified, no line lies strictly inside all rows. STABBED: out_line is a line in the
 * cone as far as doubles tell (check it). UNKNOWN: neither. */
int enf_cone_solve(EnfStabCone *cone, double out_line[6]);

#endif
