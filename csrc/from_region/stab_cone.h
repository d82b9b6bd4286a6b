/* SPDX-License-Identifier: GPL-3.0-or-later
 * The stabbing cone: all six-vectors on the inner side of every edge of a chain of portals, by its extremal rays, decided
 * exactly.
 *
 * Based on: Teller 1992 (stabbing lines as cone and Klein quadric); T. Motzkin et al. 1953 (double description).
 *
 * Input is rounded to a grid once (corners to 2^-44, normals to 2^-50: the reserve of the offset polygons pays for it); from
 * there on every sign is the exact one: a filter with proven bounds first, whole numbers of any length (GMP) where it can't
 * tell. So the combinatorics of the double description are exact, however degenerate the chain. */
#ifndef ENF_FROM_REGION_STAB_CONE_H
#define ENF_FROM_REGION_STAB_CONE_H

#include <stdint.h>

#include "from_region/line_side.h"

#define ENF_CONE_CORNER_BITS 44

/* Rows used at most; further ones are left out: a larger cone, the safe direction for "empty"; "stabbed" isn't said then. */
#define ENF_CONE_ROWS 256
/* Rays made at most in one test; beyond, the test gives up. */
#define ENF_CONE_RAYS 4096
/* Rays a cone may have at a time. */
#define ENF_CONE_ACTIVE 384

#define ENF_CONE_WORDS (ENF_CONE_ROWS / 64)

/* A linear function of lines, as whole numbers and as bounded doubles; the two agree but for a power of two. */
typedef struct EnfConeRow {
    EnfBoundedLine line; /* (m, d) of an edge: the row value is a plain dot product */
    double whole[6];     /* edge: corners a, b in grid steps; otherwise: the coefficients in grid steps */
    int exponent;        /* line = whole row * 2^-exponent */
    uint8_t is_edge, exact_known;
} EnfConeRow;

/* A vector of the cone, never changed once made: a combination of two earlier ones that makes a row zero. */
typedef struct EnfConeRay {
    EnfBoundedLine line;
    uint64_t tight[ENF_CONE_WORDS]; /* rows it lies on, exactly */
    uint32_t positive, negative;    /* it is value(positive) * negative - value(negative) * positive; */
    uint32_t row;                   /* values of this row. ENF_CONE_ROWS: an axis (positive), or one reversed (negative) */
    int exponent;                   /* line = exact numbers * 2^-exponent, once those are known */
    uint8_t exact_known;
} EnfConeRay;

typedef struct EnfExactLines EnfExactLines; /* whole numbers of rows and rays */

typedef struct EnfStabCone {
    EnfConeRow rows[ENF_CONE_ROWS];
    uint32_t row_count, dropped_rows;
    EnfConeRay rays[ENF_CONE_RAYS];
    uint32_t ray_count;
    uint32_t lineality[6], lineality_count;
    uint32_t active[ENF_CONE_ACTIVE], active_count; /* the cone's extremal rays */
    uint64_t applied[ENF_CONE_WORDS];
    EnfExactLines *exact;
    uint8_t too_long; /* a whole number found no room: nothing is certain any more */
    /* statistics, added to */
    uint64_t signs, unsure, rays_made;
} EnfStabCone;

enum { ENF_CONE_EMPTY = 0, ENF_CONE_STABBED = 1, ENF_CONE_UNKNOWN = 2 };

EnfStabCone *enf_cone_create(void); /* NULL: no memory */
void enf_cone_destroy(EnfStabCone *cone);
/* Forgets all rows. */
void enf_cone_begin(EnfStabCone *cone);
/* Lines whose direction has n . d > 0. |n| <= 2. */
void enf_cone_add_direction(EnfStabCone *cone, const double n[3]);
/* One edge a -> b of a portal; the inside is where the row is positive for lines in the direction of travel. Coordinates
 * within +-2. */
void enf_cone_add_edge(EnfStabCone *cone, const double a[3], const double b[3]);
/* EMPTY: no line lies strictly inside all rows. STABBED: some line does; out_line is it, as far as doubles tell. Both
 * certain. UNKNOWN: too many rays, or numbers too long. */
int enf_cone_solve(EnfStabCone *cone, double out_line[6]);

#endif
