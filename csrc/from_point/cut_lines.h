/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which lines of an aperture cut a polygon, four corners at once where the processor can; both twins give equal bits. */
#ifndef ENF_FROM_POINT_CUT_LINES_H
#define ENF_FROM_POINT_CUT_LINES_H

#include "from_point/aperture.h"

/* Bit k: some corner (x[i], y[i]), i < count, lies outside of line k; none set: all of the polygon is inside. ENF_CUT_AWAY: all
 * corners lie outside of one line. x, y are read in fours. line_count: at most ENF_APERTURE_CORNERS. */
typedef uint32_t (*EnfCutLines)(const double *x, const double *y, uint32_t count, const EnfCorner *lines, uint32_t line_count);
#define ENF_CUT_AWAY 0x80000000u
EnfCutLines enf_cut_lines(int use_simd);

/* Walks' plans (parallax.h): a corner's inverse depth, and the line from it as a half-space a x + b y + c - drift z >= 0. */
typedef struct EnfDeepLine {
    double z, c, drift;
} EnfDeepLine;
/* The same for corners with depths. */
typedef uint32_t (*EnfCutDeep)(const double *x, const double *y, const double *z, uint32_t count, const EnfCorner *lines,
                               const EnfDeepLine *deep, uint32_t line_count);
EnfCutDeep enf_cut_deep(int use_simd);

#endif
