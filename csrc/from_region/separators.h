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

#include "base/bits.h"

/* Corners of a window. A clip that would need more is left undone: a larger window, the safe direction. */
#define ENF_WINDOW_MAX 24

/* Coordinates side by side, so that they load as vectors; behind the last corner stand the first again (ENF_WINDOW_WRAP times):
 * corner i + 1 of the last edge is at hand, and whole vectors may be read. Whoever writes corners calls enf_window_wrap. */
#define ENF_WINDOW_WRAP 8
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
    for (uint32_t k = 0, n = window->count; n && k < ENF_WINDOW_WRAP; ++k)
        window->x[n + k] = window->x[k], window->y[n + k] = window->y[k], window->z[n + k] = window->z[k];
}
static inline void enf_window_copy(EnfWindow *to, const EnfWindow *from) {
    to->count = from->count, to->own = from->own;
    for (uint32_t i = 0; i < from->count + ENF_WINDOW_WRAP; i += 8) {
        memcpy(to->x + i, from->x + i, 8 * sizeof(double));
        memcpy(to->y + i, from->y + i, 8 * sizeof(double));
        memcpy(to->z + i, from->z + i, 8 * sizeof(double));
    }
}

/* What a plane leaves of a window of n corners: one run, from the one after `in` to `out`. below: bit i, corner i lies behind it; some do,
 * not all. */
typedef struct EnfRun {
    uint32_t in, out, kept;
    int torn; /* more than one way in: corners so close to the plane that rounding mixes their sides. Such a window is left as it is */
} EnfRun;
static inline EnfRun enf_window_run(uint32_t below, uint32_t n) {
    uint32_t all = ((uint32_t)1 << n) - 1, after = (below >> 1 | below << (n - 1)) & all, enters = below & ~after, leaves = after & ~below;
    return (EnfRun){enf_lowest_bit64(enters), enf_lowest_bit64(leaves), (uint32_t)enf_popcount64(all & ~below),
                    (enters & (enters - 1)) != 0};
}
/* `own` of the window that is left: the crossing after `in`, the run, the crossing after `out`. */
static inline uint32_t enf_run_own(uint32_t own, uint32_t n, EnfRun run) {
    return (uint32_t)((own | (uint64_t)own << n) >> run.in) & (((uint32_t)1 << (run.kept + 1)) - 1);
}

/* Half-spaces n . x >= d that hold for every point a line may reach, side by side; and for boxes in single precision, d lowered by
 * what that costs. What is no plane is null (0 . x >= -1), and so are the ENF_HALFSPACES_NULL single ones behind the last: whole
 * vectors may be read. */
#define ENF_HALFSPACES_MAX  64 /* one bit each; what finds no room is left out: fewer planes bound less */
#define ENF_HALFSPACES_NULL 16
typedef struct EnfHalfspaces {
    uint32_t count;
    double x[ENF_HALFSPACES_MAX + 8], y[ENF_HALFSPACES_MAX + 8], z[ENF_HALFSPACES_MAX + 8], d[ENF_HALFSPACES_MAX + 8];
    float single[4][ENF_HALFSPACES_MAX + ENF_HALFSPACES_NULL]; /* x, y, z, d */
} EnfHalfspaces;

static inline void enf_halfspaces_add(EnfHalfspaces *planes, double x, double y, double z, double d) {
    uint32_t at = planes->count;
    if (at == ENF_HALFSPACES_MAX)
        return;
    planes->x[at] = x, planes->y[at] = y, planes->z[at] = z, planes->d[at] = d;
    planes->count = at + 1;
}

/* Adds the planes of the shaft between two boxes: what every segment from one to the other keeps in front of (Haines & Wallace 1991).
 * from, to: low xyz, high xyz. */
void enf_shaft(const double from[6], const double to[6], EnfHalfspaces *planes);

/* Planes in single precision, side by side; null behind the last. */
#define ENF_GROUP 8
typedef struct EnfPlaneGroup {
    float x[ENF_GROUP], y[ENF_GROUP], z[ENF_GROUP], d[ENF_GROUP];
} EnfPlaneGroup;

/* The inner loops, compiled plainly, for AVX2 and for AVX-512 from one source (separators_body.h): the same operations on each
 * number in the same order, so the same bits. */
typedef struct EnfSeparatorKernel {
    /* Adds planes (d lowered by a bound on all rounding) that hold for every point x beyond `pass` on a line from `source` through
     * `pass` (forward 1), or before `pass` on a line that goes on to `source` (forward -1): up to one a corner of both, for which there
     * must be room. Gives which they are, a bit each. */
    uint64_t (*separators)(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                           double forward, EnfHalfspaces *planes);
    /* Keeps what lies in front of the planes of the bits, one after the other. 0 as soon as nothing is left. `clipped` is set when
     * something was cut off. */
    int (*clip_all)(EnfWindow *window, const EnfHalfspaces *planes, uint64_t which, int *clipped);
    int (*clip)(EnfWindow *window, const double plane[4], int *clipped);
    /* Brings the single precision up to date for the planes from `first` on. */
    void (*round)(EnfHalfspaces *planes, uint32_t first);
    /* 0: the box (centre, half size) lies wholly outside one of the planes (never said of one that touches the region they
     * bound). Otherwise tells which planes it isn't wholly inside of. */
    int (*touches)(const EnfHalfspaces *planes, const float box[6], uint64_t *out_cuts);
    /* Bit k: some of the box a and some of b (centre, half size) lies behind the k-th plane, or before it (sign -1). In single
     * precision: it only errs to yes. Here and below, count is at most 64. */
    uint64_t (*facing)(const EnfPlaneGroup *groups, uint32_t count, float sign, const float a[6], const float b[6]);
    /* Bit k: the line p + t d, from inside of all planes, may leave by the k-th first; walked backward when sign is -1. Errs to yes, by
     * as much as single precision can't tell. */
    uint64_t (*leaving)(const EnfPlaneGroup *groups, uint32_t count, float sign, const float p[3], const float d[3]);
    /* Bit k: box[at[k]] touches. */
    uint64_t (*touching)(const EnfHalfspaces *planes, const float (*box)[6], const uint32_t *at, uint32_t count);
    /* Both, of planes and boxes side by side. */
    uint64_t (*ways)(const EnfHalfspaces *planes, const EnfPlaneGroup *groups, const float (*box)[6], uint32_t count, float sign,
                     const float a[6], const float b[6]);
} EnfSeparatorKernel;
extern const EnfSeparatorKernel enf_separators_plain;
extern const EnfSeparatorKernel *const enf_separators_avx2, *const enf_separators_avx512; /* NULL: not compiled */
/* The best this processor has. */
const EnfSeparatorKernel *enf_separator_kernel(void);

#endif
