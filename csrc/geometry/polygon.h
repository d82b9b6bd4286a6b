/* SPDX-License-Identifier: GPL-3.0-or-later
 * Planar polygons: normal, area, splitting by a plane, planar convex hulls, triangulation. */
#ifndef ENF_GEOMETRY_POLYGON_H
#define ENF_GEOMETRY_POLYGON_H

#include <stdint.h>

/* Unit Newell normal (zero when the polygon has no area); gives the area. Computed relative to the first
 * corner, so far-away polygons lose nothing. */
double enf_polygon_normal(double normal[3], double (*points)[3], uint32_t count);
/* Area centroid for a convex polygon; the mean of its corners when it has no area. */
void enf_polygon_centroid(double centroid[3], double (*points)[3], uint32_t count);

/* Where the segment crosses a plane, given the signed distances of its ends (of opposite sign). The same bits
 * whichever end comes first: neighbours that share an edge share its cut. */
void enf_cut_segment(double out[3], const double a[3], const double b[3], double distance_a, double distance_b);

/* Splits a convex polygon by the plane n.p = d; corners within eps count as on it. back and front have room
 * for count + 1 points each (either may be NULL); a side without area (all its corners on the plane or
 * beyond) gets count 0. A polygon wholly on the plane gives both counts 0. */
void enf_polygon_split(double (*points)[3], uint32_t count, const double n[3], double d, double eps, double (*back)[3],
                       uint32_t *back_count, double (*front)[3], uint32_t *front_count);

/* Two axes that span the plane, with u x v = n (n unit). */
void enf_plane_axes(const double n[3], double u[3], double v[3]);

/* A point of a plane, and the number it had. */
typedef struct EnfFlatPoint {
    double x, y;
    uint32_t index;
} EnfFlatPoint;
/* Their convex hull, counter-clockwise, without doubles and corners on its edges (Andrew's monotone chain, 1979): gives how many there are in
 * `hull`, which has room for count + 1. count: 1 or more. Sorts the points. */
uint32_t enf_flat_hull(EnfFlatPoint *points, uint32_t count, EnfFlatPoint *hull);

/* Convex hull of points seen along n (counter-clockwise about n): fills `hull` (room for count) with indices,
 * gives their number (below 3 when all lie on a line). Points within eps of an edge of the hull are left out.
 * 0 too when memory runs out. */
uint32_t enf_planar_hull(double (*points)[3], uint32_t count, const double n[3], double eps, uint32_t *hull);

/* Whether the polygon is convex about n: turns left everywhere (up to eps, metres of a corner behind a line)
 * and once round. */
int enf_polygon_is_convex(double (*points)[3], uint32_t count, const double n[3], double eps);

/* Ear clipping (Meisters 1975) of a simple polygon, counter-clockwise about n: fills (count - 2) triangles of
 * indices, gives their number. A polygon that crosses itself is cut as far as possible and the rest fanned. 0
 * when memory runs out. */
uint32_t enf_polygon_triangulate(double (*points)[3], uint32_t count, const double n[3], uint32_t (*triangles)[3]);

#endif
