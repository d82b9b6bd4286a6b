/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whether a line passes a whole chain of portals. */
#include <string.h>

#include "base/memory.h"
#include "from_region/chain_search.h"
#include "geometry/vec3.h"

struct EnfStabScratch {
    int unused;
};

EnfStabScratch *enf_stab_scratch_create(void) { return ENF_NEW(EnfStabScratch, 1); }
void enf_stab_scratch_destroy(EnfStabScratch *scratch) { enf_free(scratch); }

static void centroid(const EnfWindow *window, double out[3]) {
    vec_set(out, 0, 0, 0);
    for (uint32_t i = 0; i < window->count; ++i) vec_add(out, out, window->v[i]);
    vec_scale(out, 1.0 / window->count, out);
}

/* Whether the line clears every portal of the chain, by the inner polygons. */
static int passes(const EnfRegionModel *m, const EnfChain *chain, const double p[3], const double d[3]) {
    for (uint32_t i = 0; i < chain->count; ++i) {
        uint32_t r = chain->portals[i], e = m->inner.first[r >> 1], end = m->inner.first[(r >> 1) + 1];
        const double *plane = m->plane[r];
        double slope = vec_dot(plane, d), x[3];
        if (slope < ENF_CROSSING_SINE_MIN || e == end) return 0;
        vec_mad(x, p, (plane[3] - vec_dot(plane, p)) / slope, d);
        for (; e < end; ++e)
            if (vec_dot(m->inner_edge[e], x) < m->inner_edge[e][3]) return 0;
    }
    return 1;
}

uint32_t enf_chain_test(const EnfRegionModel *m, const EnfChain *chain, EnfStabScratch *scratch,
                        EnfRegionVisStats *stats, double p[3], double d[3]) {
    double y[3];
    (void)scratch;
    if (!chain->source->count || (chain->target && !chain->target->count)) return ENF_CHAIN_UNDECIDED;
    centroid(chain->source, p);
    if (chain->target) {
        centroid(chain->target, y);
        vec_sub(d, y, p);
    } else vec_copy(d, m->plane[chain->portals[0]]);
    if (vec_normalize(d) > 0 && passes(m, chain, p, d) &&
        enf_line_clearance(m, p, d, chain->portals, chain->count) >= m->delta) {
        ++stats->line_hits;
        return ENF_CHAIN_VISIBLE;
    }
    return ENF_CHAIN_UNDECIDED;
}
