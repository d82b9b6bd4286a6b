/* SPDX-License-Identifier: GPL-3.0-or-later
 * One step along a chain: which targets a portal keeps, which window it shows, what the source keeps. */
#include "from_region/search_worker.h"

#include <math.h>

#include "geometry/vec3.h"

int enf_targets_through(const EnfSearchWorker *w, uint32_t portal, const uint64_t *parent, uint64_t *targets) {
    const EnfMightSets *might = w->bake->might;
    uint64_t any = 0, first = might->first[portal], end = first + might->count[portal];
    if (!might->known[portal]) {
        for (uint32_t k = 0; k < w->words; ++k)
            any |= targets[k] = parent[k] & w->open[k];
        return any != 0;
    }
    memset(targets, 0, w->words * sizeof *targets);
    for (uint64_t b = first; b < end; ++b) {
        uint32_t k = w->local[might->block[b]];
        if (k == ENF_NONE)
            continue;
        targets[k] = parent[k] & w->seen->bits[b] & w->open[k];
        any |= targets[k];
    }
    return any != 0;
}

int enf_targets_after(const EnfSearchWorker *w, uint32_t last, uint32_t k, uint64_t *targets) {
    const EnfMightSets *might = w->bake->might;
    if (!might->known[last])
        return 1;
    uint32_t count = might->count[last];
    const uint32_t *block = might->block + might->first[last];
    const uint64_t *bits = might->pairs + might->pair_first[last] + (uint64_t)k * count;
    uint64_t any = 0;
    for (uint32_t b = 0; b < count; ++b) { /* every target left is in one of these blocks: it was in the set of `last` */
        uint32_t word = w->local[block[b]];
        if (word != ENF_NONE)
            any |= targets[word] &= bits[b];
    }
    return any != 0;
}

int enf_targets_drop(EnfSearchWorker *w, const EnfPlanePack *pack, uint64_t *targets) {
    const EnfRegionModel *m = w->m;
    uint64_t any = 0;
    for (uint32_t k = 0; k < w->words; ++k)
        for (uint64_t bits = targets[k]; bits; bits &= bits - 1) {
            uint32_t cell = w->word_block[k] * 64 + enf_lowest_bit64(bits);
            int hit = 0;
            if (!enf_pack_misses_box(pack, m->cell_box[cell]))
                for (uint32_t i = m->out_first[cell]; i < m->out_first[cell + 1] && !hit; ++i)
                    hit = !enf_pack_misses_box(pack, m->box[m->out[i] >> 1]);
            if (hit)
                any = 1;
            else {
                targets[k] &= ~(bits & (~bits + 1));
                ++w->out->stats.targets_dropped;
            }
        }
    return any != 0;
}

/* Cells. More targets are too scattered for a shaft to leave enough out: 2 costs the fewest instructions (1, 4, 8: 0.5 to 4 %
 * more), at 22 % fewer chains. */
#define AIM_TARGETS 2

void enf_aim(const EnfSearchWorker *w, EnfSearchFrame *f) {
    const EnfRegionModel *m = w->m;
    uint32_t cells = 0;
    for (uint32_t k = 0; k < w->words; ++k)
        cells += (uint32_t)enf_popcount64(f->targets[k]);
    if (cells > AIM_TARGETS || !f->source.count)
        return;
    double from[6], to[6], corner[3];
    box_empty(from), box_empty(to);
    for (uint32_t i = 0; i < f->source.count; ++i)
        enf_window_corner(&f->source, i, corner), box_add_point(from, corner);
    for (uint32_t k = 0; k < w->words; ++k)
        for (uint64_t bits = f->targets[k]; bits; bits &= bits - 1) {
            uint32_t cell = w->word_block[k] * 64 + enf_lowest_bit64(bits);
            for (uint32_t i = m->out_first[cell]; i < m->out_first[cell + 1]; ++i) {
                const float *box = m->box[m->out[i] >> 1];
                if (enf_pack_misses_box(&f->pack, box))
                    continue;
                for (int c = 0; c < 3; ++c) {
                    to[c] = fmin(to[c], (double)box[c] - (double)box[c + 3]);
                    to[c + 3] = fmax(to[c + 3], (double)box[c] + (double)box[c + 3]);
                }
            }
        }
    uint32_t first = f->plane_count;
    f->plane_count += enf_shaft(from, to, ENF_PLANES_MAX - first, f->planes + first);
    enf_plane_pack(&f->pack, (const double(*)[4])f->planes, first, f->plane_count);
}

uint32_t enf_window_planes(const EnfSearchWorker *w, uint32_t first_portal, uint32_t last, const EnfWindow *source, const EnfWindow *pass,
                           double (*planes)[4]) {
    const EnfRegionModel *m = w->m;
    uint32_t count = 0;
    memcpy(planes[count], m->plane[last], sizeof *planes);
    planes[count++][3] -= m->order_slack;
    if (first_portal != last) {
        memcpy(planes[count], m->plane[first_portal], sizeof *planes);
        planes[count++][3] -= m->order_slack;
        if (source->count && pass->count)
            count += enf_separators(source, m->plane[first_portal], pass, m->plane[last], planes + count);
    }
    return count;
}

int enf_window_step(const EnfSearchWorker *w, uint32_t first_portal, uint32_t last, const EnfWindow *source, const EnfWindow *pass,
                    const double (*planes)[4], uint64_t cutting, uint32_t r, EnfWindow *out_source, EnfWindow *out_pass) {
    const EnfRegionModel *m = w->m;
    const double *at = m->plane[r];
    int clipped = 0;
    ++w->out->stats.clips;
    if (!enf_window_load(m, r, out_pass))
        out_pass->count = 0; /* too many corners: goes on unclipped */
    else if (!enf_window_clip_all(out_pass, planes, cutting, &clipped))
        return 0;
    if (out_pass->count && !out_pass->own && pass->count)
        return ENF_STEP_SAME;
    enf_window_copy(out_source, source);
    double behind[4] = {-at[0], -at[1], -at[2], -at[3] - m->order_slack};
    if (out_source->count && !enf_window_clip(out_source, behind, &clipped))
        return 0;
    if (first_portal != last && out_source->count && out_pass->count && pass->count) {
        /* Seen backward: through the window passed before, from the new one, on the source. */
        double back[ENF_SEPARATORS_MAX][4];
        uint32_t count = enf_separators_back(out_pass, at, pass, m->plane[last], back);
        if (!enf_window_clip_all(out_source, (const double(*)[4])back, enf_planes_all(count), &clipped))
            return 0;
    }
    return 1;
}

int enf_turns_back(const EnfSearchWorker *w, uint32_t depth, uint32_t r) {
    /* Less than the two least sines together (chain_test.c): no line crosses both at these. */
    const double *at = w->m->plane[r], opposite = fmax(ENF_HIDDEN_SINE_MIN, fmin(w->m->touch, ENF_CROSSING_SINE_MIN));
    for (uint32_t i = 0; i <= depth; ++i) {
        const double *before = w->m->plane[w->chain[i]];
        if (fabs(before[0] + at[0]) + fabs(before[1] + at[1]) + fabs(before[2] + at[2]) < opposite)
            return 1;
    }
    return 0;
}
