/* SPDX-License-Identifier: GPL-3.0-or-later
 * Planes by the group, shafts, and the choice of the kernel. */
#include "from_region/separators.h"

#include <math.h>
#include <stddef.h>

#include "base/simd.h"
#include "from_region/separators_slack.h"

const EnfSeparatorKernel *enf_separator_kernel(void) {
    if (enf_separators_avx512 && enf_processor_avx512())
        return enf_separators_avx512;
    if (enf_separators_avx2 && enf_processor_avx2())
        return enf_separators_avx2;
    return &enf_separators_plain;
}

void enf_shaft(const double from[6], const double to[6], EnfHalfspaces *planes) {
    double low[3], high[3], by_low[3], by_high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = from[k] < to[k] ? from[k] : to[k], high[k] = from[k + 3] > to[k + 3] ? from[k + 3] : to[k + 3];
        by_low[k] = to[k] - from[k], by_high[k] = to[k + 3] - from[k + 3];
    }
    /* The box of both. */
    enf_halfspaces_add(planes, 1, 0, 0, low[0] - ENF_SHAFT_SLACK), enf_halfspaces_add(planes, -1, 0, 0, -high[0] - ENF_SHAFT_SLACK);
    enf_halfspaces_add(planes, 0, 1, 0, low[1] - ENF_SHAFT_SLACK), enf_halfspaces_add(planes, 0, -1, 0, -high[1] - ENF_SHAFT_SLACK);
    enf_halfspaces_add(planes, 0, 0, 1, low[2] - ENF_SHAFT_SLACK), enf_halfspaces_add(planes, 0, 0, -1, -high[2] - ENF_SHAFT_SLACK);
    /* Seen along each axis: the hull of two rectangles has slanted edges between corners of the same name, where neither
     * rectangle's corner is further out both ways. */
    for (int k = 0; k < 3; ++k) {
        int u = k < 2 ? k + 1 : 0, v = u < 2 ? u + 1 : 0;
        for (int corner = 0; corner < 4; ++corner) {
            double du = corner & 1 ? by_high[u] : -by_low[u], dv = corner & 2 ? by_high[v] : -by_low[v]; /* outward */
            if (!(du * dv < 0))
                continue;
            int cu = corner & 1 ? u + 3 : u, cv = corner & 2 ? v + 3 : v;
            double size = 1 / (fabs(du) > fabs(dv) ? fabs(du) : fabs(dv)), n[3];
            n[k] = 0, n[u] = (corner & 1 ? -size : size) * fabs(dv), n[v] = (corner & 2 ? -size : size) * fabs(du); /* inward */
            double a = n[u] * from[cu] + n[v] * from[cv], b = n[u] * to[cu] + n[v] * to[cv];
            enf_halfspaces_add(planes, n[0], n[1], n[2], (a < b ? a : b) - ENF_SHAFT_SLACK);
        }
    }
}
