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
#include <string.h>

/* Corners of a window. A clip that would need more is left undone: a larger window, the safe direction. */
#define ENF_WINDOW_MAX 24
/* Two planes families, and room for the portals' own planes. */
#define ENF_SEPARATORS_MAX (2 * ENF_WINDOW_MAX + 2)

/* Coordinates side by side, so that they load as vectors; behind the last corner stand the first again (ENF_WINDOW_WRAP times):
 * corner i + 1 of the last edge is at hand, and whole vectors may be read. Whoever writes corners calls enf_window_wrap. */
#define ENF_WINDOW_WRAP 4
#define ENF_WINDOW_ROOM (ENF_WINDOW_MAX + 2 * ENF_WINDOW_WRAP)
typedef struct EnfWindow {
    uint32_t count;
    uint32_t own; /* bit i: edge i, i + 1 lies on an edge of the polygon that was loaded; others were cut */
    double x[ENF_WINDOW_ROOM], y[ENF_WINDOW_ROOM], z[ENF_WINDOW_ROOM];
} EnfWindow;

static inline void enf_window_put(EnfWindow *window, uint32_t i, const double v[3]) {
    window->x[i] = v[0], window->y[i] = v[1], window->z[i] = v[2];
}
static inline void enf_window_corner(const EnfWindow *window, uint32_t i, double out[3]) {
    out[0] = window->x[i], out[1] = window->y[i], out[2] = window->z[i];
}
static inline void enf_window_wrap(EnfWindow *window) {
    for (uint32_t k = 0, n = window->count; n && k < ENF_WINDOW_WRAP; ++k) {
        uint32_t i = k < n ? k : 0; /* of a triangle the fourth is the first again */
        window->x[n + k] = window->x[i], window->y[n + k] = window->y[i], window->z[n + k] = window->z[i];
    }
}
static inline void enf_window_copy(EnfWindow *to, const EnfWindow *from) {
    size_t bytes = (from->count + ENF_WINDOW_WRAP) * sizeof(double);
    to->count = from->count, to->own = from->own;
    memcpy(to->x, from->x, bytes), memcpy(to->y, from->y, bytes), memcpy(to->z, from->z, bytes);
}

/* Planes n . x >= d (n, d in [0..2], [3]; d lowered by a bound on all rounding) that hold for every point x beyond `pass` on
 * a line from `source` through `pass`. Writes at most source->count + pass->count planes and gives their number. */
uint32_t enf_separators(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                        double (*planes)[4]);

/* The same looking back: for every point x before `pass` on a line that goes on to `source`. */
uint32_t enf_separators_back(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                             double (*planes)[4]);

/* The same as enf_separators by the SIMD kernel or its scalar twin: for tests that hold both to equal bits. */
uint32_t enf_separators_twin(int simd, const EnfWindow *source, const double source_normal[3], const EnfWindow *pass,
                             const double pass_normal[3], double (*planes)[4]);

/* Keeps the part of the window with n . x >= d. Gives 0 when nothing is left. `clipped` is set when something was cut off. */
int enf_window_clip(EnfWindow *window, const double plane[4], int *clipped);
/* By one plane after the other, those of the bits; 0 as soon as nothing is left. */
int enf_window_clip_all(EnfWindow *window, const double (*planes)[4], uint64_t which, int *clipped);
static inline uint64_t enf_planes_all(uint32_t count) {
    return ((uint64_t)1 << count) - 1;
} /* count < 64 */

/* Planes of the shaft between two boxes: what every segment from one to the other keeps in front of (Haines & Wallace 1991).
 * from, to: low xyz, high xyz. Writes at most `room`, in all 18: fewer bound less. */
#define ENF_SHAFT_MAX 18
uint32_t enf_shaft(const double from[6], const double to[6], uint32_t room, double (*planes)[4]);
/* Planes of a frame at most: one bit each in 64. */
#define ENF_PLANES_MAX 62

/* Planes in single precision, four at a time, for boxes (centre, half size). */
#define ENF_PACK_MAX ((ENF_PLANES_MAX + 3) / 4)
typedef struct EnfPlanePack {
    uint32_t groups;
    float f[ENF_PACK_MAX][7][4]; /* nx ny nz |nx| |ny| |nz| d */
} EnfPlanePack;
/* Planes before `first` are in the pack already. */
void enf_plane_pack(EnfPlanePack *pack, const double (*planes)[4], uint32_t first, uint32_t count);
/* As enf_pack_misses_box; otherwise tells which planes the box isn't wholly inside of (bit by plane). */
int enf_pack_cuts_box(const EnfPlanePack *pack, const float box[6], uint64_t *out_cuts);
/* 1: the box lies wholly outside one of the planes (never said of a box that touches the region they bound). */
int enf_pack_misses_box(const EnfPlanePack *pack, const float box[6]);

#endif
