/* SPDX-License-Identifier: GPL-3.0-or-later
 * Corners of a portal onto a perspective screen, four at once where the processor can; both twins give equal bits. */
#ifndef ENF_FROM_POINT_PROJECT_CORNERS_H
#define ENF_FROM_POINT_PROJECT_CORNERS_H

#include "from_point/aperture.h"

/* Portals' corners are read in fours: arrays of them end with this many spare ones. */
#define ENF_CORNER_SPARE 4

typedef struct EnfHomogeneous {
    double u[ENF_PORTAL_CORNERS + 4], v[ENF_PORTAL_CORNERS + 4], w[ENF_PORTAL_CORNERS + 4];
} EnfHomogeneous;

/* U, V, W = rows . (corner - eye) of `count` corners. Bits of the result: 1, 2, 4, 8: all corners lie beyond the right, left,
 * upper, lower side of rect (x0 y0 x1 y1); 16: all have W > 0, |U| and |V| <= 256 W, and x, y hold U / W, V / W. */
typedef uint32_t (*EnfProjectCorners)(const double (*corners)[3], uint32_t count, const double eye[3], const double (*rows)[3],
                                      const double rect[4], EnfHomogeneous *out, double *x, double *y);
#define ENF_CORNERS_PLAIN 16u
EnfProjectCorners enf_project_corners(int use_simd);

#endif
