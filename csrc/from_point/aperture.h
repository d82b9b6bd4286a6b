/* SPDX-License-Identifier: GPL-3.0-or-later
 * Apertures: convex polygons on the screen through which the viewer still sees.
 *
 * Screen coordinates are U/W, V/W; the whole view is [-1, 1] x [-1, 1]. Polygons wind counter-clockwise. */
#ifndef ENF_FROM_POINT_APERTURE_H
#define ENF_FROM_POINT_APERTURE_H

#include <stdint.h>

/* Corners of a working polygon: a portal has at most 32 (view_index.c), each clip line adds at most one. */
#define ENF_POLY_MAX 96 /* and room for projections written in fours */
/* Corners of a stored aperture; beyond, edges are removed outward. */
#define ENF_APERTURE_CORNERS 12
#define ENF_PORTAL_CORNERS   32

/* How far clip lines are moved outward. [Unit: half screens] Rounding of projection and clipping is below 2e-14 for
 * what the guards of projection let through; direction: larger apertures, more visible. */
#define ENF_LINE_OUTSET 1e-12
/* Thinner than this (area per length, half screens) is no aperture: what remains of a chain along shared edges, where
 * each step may have added 2 * ENF_LINE_OUTSET. The one tolerance that drops something: no witness wider than
 * 2e-10 of half the screen is lost by it. */
#define ENF_SLIVER 1e-10

typedef struct EnfPoly {
    uint32_t n;
    double x[ENF_POLY_MAX], y[ENF_POLY_MAX];
} EnfPoly;

/* A corner, and the line from it to the next corner, moved outward: a x + b y + c >= 0 inside (not normalised).
 * a = b = 0: too short an edge to be a line; no constraint (safe direction). */
typedef struct EnfCorner {
    double x, y, a, b, c;
} EnfCorner;

/* Clips `poly` by those lines of an aperture whose bits are set. Returns where the result is: `poly` or `other`; n = 0 when
 * nothing is left. */
EnfPoly *enf_poly_clip(EnfPoly *poly, EnfPoly *other, const EnfCorner *corners, uint32_t lines);
#define ENF_ALL_LINES(count) ((1u << (count)) - 1)
/* The convex hull of `poly`'s points, in any order; in place. */
void enf_poly_hull(EnfPoly *poly);
/* The hull of two convex, counter-clockwise polygons; linear time. */
void enf_corners_hull(const EnfCorner *a, uint32_t a_count, const EnfCorner *b, uint32_t b_count, EnfPoly *out);
/* The same for two that have one edge in common, to the bit, and nothing else: what they are together, when that is convex or
 * turns inward at an end of the edge by so little that its hull is. 0: not so. */
int enf_corners_join(const EnfCorner *a, uint32_t a_count, const EnfCorner *b, uint32_t b_count, EnfPoly *out);
double enf_poly_area(const EnfPoly *poly);
/* min x, min y, max x, max y */
void enf_poly_rect(const EnfPoly *poly, double rect[4]);
/* Whether the polygon is thinner than ENF_SLIVER. */
int enf_poly_is_sliver(const EnfPoly *poly, double area, const double rect[4]);
/* Fits the polygon for storage: removes very short edges, and edges beyond ENF_APERTURE_CORNERS, outward. */
void enf_poly_tidy(EnfPoly *poly);
/* Corners alone; and then their lines, `outset` half screens outward. */
void enf_poly_store(const EnfPoly *poly, EnfCorner *corners);
void enf_corners_outline(EnfCorner *corners, uint32_t count, const double rect[4], double outset);
/* Moves every corner outward to a grid of 1/32, but not out of `view`, and takes the hull. */
void enf_poly_snap(EnfPoly *poly, const double view[4]);
/* Widens the polygon by a square of half side `by` (Minkowski sum). */
void enf_poly_grow(EnfPoly *poly, double by);
void enf_poly_from_rect(EnfPoly *poly, const double rect[4]);
void enf_poly_append(EnfPoly *poly, const EnfCorner *corners, uint32_t count);

/* The libm's fmin and fmax are calls; these are an instruction. Not for NaN. */
static inline double enf_lesser(double a, double b) {
    return a < b ? a : b;
}
static inline double enf_greater(double a, double b) {
    return a > b ? a : b;
}

#endif
