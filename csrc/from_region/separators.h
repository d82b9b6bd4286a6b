/* SPDX-License-Identifier: GPL-3.0-or-later
 * Separating planes of two portal windows: what bounds the view through one beyond the other.
 *
 * Based on: S. Teller, "Visibility computations in densely occluded polyhedral environments", 1992, section 5.2
 * (antipenumbra; separating planes as its conservative hull). Proof of the direction: ALGORITHMS.md.
 *
 * Windows are convex, planar, counter-clockwise about the direction of travel. */
#ifndef ENF_FROM_REGION_SEPARATORS_H
#define ENF_FROM_REGION_SEPARATORS_H

#include <stdint.h>

/* Corners of a window. A clip that would need more is left undone: a larger window, the safe direction. */
#define ENF_WINDOW_MAX 24
/* Two planes families, and room for the portals' own planes. */
#define ENF_SEPARATORS_MAX (2 * ENF_WINDOW_MAX + 2)

typedef struct EnfWindow {
    uint32_t count;
    double v[ENF_WINDOW_MAX][3];
} EnfWindow;

/* Planes n . x >= d (n, d in [0..2], [3]; d lowered by a bound on all rounding) that hold for every point x beyond `pass` on
 * a line from `source` through `pass`. Writes at most source->count + pass->count planes and gives their number. */
uint32_t enf_separators(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass,
                        const double pass_normal[3], double (*planes)[4]);

/* The same looking back: for every point x before `pass` on a line that goes on to `source`. */
uint32_t enf_separators_back(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass,
                             const double pass_normal[3], double (*planes)[4]);

/* Keeps the part of the window with n . x >= d. Gives 0 when nothing is left. `clipped` is set when something was cut off. */
int enf_window_clip(EnfWindow *window, const double plane[4], int *clipped);

/* Planes in single precision, four at a time, for boxes (centre, half size). */
#define ENF_PACK_MAX ((ENF_SEPARATORS_MAX + 3) / 4)
typedef struct EnfPlanePack {
    uint32_t groups;
    float f[ENF_PACK_MAX][7][4]; /* nx ny nz |nx| |ny| |nz| d */
} EnfPlanePack;
void enf_plane_pack(EnfPlanePack *pack, const double (*planes)[4], uint32_t count);
/* 1: the box lies wholly outside one of the planes (never said of a box that touches the region they bound). */
int enf_pack_misses_box(const EnfPlanePack *pack, const float box[6]);

#endif
