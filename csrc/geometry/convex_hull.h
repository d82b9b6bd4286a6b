/* SPDX-License-Identifier: GPL-3.0-or-later
 * Convex hull of points in space, coplanar triangles merged into polygons. */
#ifndef ENF_GEOMETRY_CONVEX_HULL_H
#define ENF_GEOMETRY_CONVEX_HULL_H

#include "enfilade/base.h"

typedef struct EnfHull {
    uint32_t *face_sizes;   /* [face_count] */
    uint32_t *face_indices; /* faces in turn, counter-clockwise seen from outside; into the given points */
    uint32_t face_count, index_count;
} EnfHull;

enum { ENF_HULL_OK = 0, ENF_HULL_FLAT = 1, ENF_HULL_NO_MEMORY = 2 };

/* eps [metres]: points that stick out by no more don't become corners, corners out of a face's plane by no
 * more belong to it. So the polyhedron may leave points outside by eps: users push its planes out to the
 * farthest point where that matters. */
int enf_hull_build(EnfHull *hull, double (*points)[3], uint32_t count, double eps);
void enf_hull_free(EnfHull *hull);

#endif
