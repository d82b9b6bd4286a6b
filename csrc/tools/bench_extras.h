/* SPDX-License-Identifier: GPL-3.0-or-later
 * Parts of `enfilade bench view`: pairs of eyes, walks, occluders. */
#ifndef ENF_TOOLS_BENCH_EXTRAS_H
#define ENF_TOOLS_BENCH_EXTRAS_H

#include "sight_walker.h"
#include "enfilade/portal_vis.h"

typedef struct BenchCamera {
    EnfCamera camera;
    uint32_t start; /* the cell that holds its eye */
} BenchCamera;

/* The same cameras as stereo pairs, along walks, and with occluders where there are any; prints a line each. */
int bench_extras(const char *spec, const EnfScene *scene, const SightWalker *walker, const BenchCamera *cameras, uint32_t count,
                 EnfView *view);

#endif
