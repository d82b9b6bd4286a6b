/* SPDX-License-Identifier: GPL-3.0-or-later
 * One step along a chain: which window a portal shows, and what the source keeps. */
#include "from_region/search_worker.h"

#include "geometry/vec3.h"

void enf_window_planes(const EnfSearchWorker *w, uint32_t first_portal, uint32_t last, const EnfWindow *source, const EnfWindow *pass,
                       EnfHalfspaces *planes) {
    const EnfRegionModel *m = w->m;
    const double *from = m->plane[first_portal], *at = m->plane[last];
    planes->count = 0;
    enf_halfspaces_add(planes, at[0], at[1], at[2], at[3] - m->order_slack);
    if (first_portal != last) {
        enf_halfspaces_add(planes, from[0], from[1], from[2], from[3] - m->order_slack);
        if (source->count && pass->count)
            (void)m->kernel->separators(source, from, pass, at, 1, planes);
    }
    m->kernel->round(planes, 0);
}

int enf_window_step(const EnfSearchWorker *w, uint32_t first_portal, uint32_t last, const EnfWindow *source, const EnfWindow *pass,
                    const EnfHalfspaces *planes, uint64_t cutting, uint32_t r, EnfWindow *out_source, EnfWindow *out_pass) {
    const EnfRegionModel *m = w->m;
    const double *at = m->plane[r];
    int clipped = 0;
    ++w->out->stats.clips;
    if (!enf_window_load(m, r, out_pass))
        out_pass->count = 0; /* too many corners: goes on unclipped */
    else if (!m->kernel->clip_all(out_pass, planes, cutting, &clipped))
        return ENF_STEP_EMPTY;
    if (out_pass->count && !out_pass->own && pass->count)
        return ENF_STEP_SAME;
    enf_window_copy(out_source, source);
    if (!source->count)
        return ENF_STEP_NARROWED;
    /* The source lies behind r; and, seen backward from the new window through the one passed before, within their planes. */
    EnfHalfspaces back;
    uint64_t cutting_back = 1;
    back.count = 0;
    enf_halfspaces_add(&back, -at[0], -at[1], -at[2], -at[3] - m->order_slack);
    if (first_portal != last && out_pass->count && pass->count)
        cutting_back |= m->kernel->separators(out_pass, at, pass, m->plane[last], -1, &back);
    return m->kernel->clip_all(out_source, &back, cutting_back, &clipped) ? ENF_STEP_NARROWED : ENF_STEP_EMPTY;
}

int enf_turns_back(const EnfSearchWorker *w, uint32_t depth, uint32_t r) {
    for (uint32_t i = 0; i <= depth; ++i)
        if (enf_rm_turns_back(w->m, w->chain[i], r))
            return 1;
    return 0;
}
