/* SPDX-License-Identifier: GPL-3.0-or-later
 * The targets of a branch of the search: cells still open that might be seen along it. */
#include "from_region/search_worker.h"

#include "geometry/vec3.h"

/* What might be seen through the portal of the cells in one local word. */
static inline uint64_t seen_through(const EnfSearchWorker *w, uint32_t portal, uint32_t word, uint32_t *out_place) {
    const EnfMightSets *might = w->bake->might;
    *out_place = ENF_NONE;
    if (!might->known[portal])
        return ~(uint64_t)0;
    *out_place = enf_might_place(might, portal, w->word_block[word]);
    return *out_place == ENF_NONE ? 0 : w->seen->bits[might->first[portal] + *out_place];
}

uint32_t enf_targets_from(const EnfSearchWorker *w, uint32_t portal, EnfTargets *targets) {
    targets->count = 0;
    for (uint32_t word = 0, place; word < w->words; ++word) {
        uint64_t bits = w->open[word] ? w->open[word] & seen_through(w, portal, word, &place) : 0;
        if (bits)
            targets->list[targets->count++] = (EnfTargetWord){word, place, bits};
    }
    return targets->count;
}

uint32_t enf_targets_through(const EnfSearchWorker *w, uint32_t last, uint32_t k, uint32_t r, const EnfTargets *before,
                             EnfTargets *targets) {
    const EnfMightSets *might = w->bake->might;
    const uint64_t *pairs = NULL;
    if (might->known[last])
        pairs = might->pairs + might->pair_first[last] + (uint64_t)k * might->count[last];
    targets->count = 0;
    for (uint32_t i = 0; i < before->count; ++i) {
        const EnfTargetWord *from = &before->list[i];
        uint64_t bits = from->bits & w->open[from->word];
        if (pairs)
            bits &= pairs[from->place];
        if (!bits)
            continue;
        uint32_t place;
        if ((bits &= seen_through(w, r, from->word, &place)))
            targets->list[targets->count++] = (EnfTargetWord){from->word, place, bits};
    }
    return targets->count;
}

uint32_t enf_targets_keep(EnfTargets *targets, const uint64_t *words) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < targets->count; ++i) {
        EnfTargetWord target = targets->list[i];
        if (target.bits &= words[target.word])
            targets->list[count++] = target;
    }
    return targets->count = count;
}

uint32_t enf_targets_drop(EnfSearchWorker *w, const EnfHalfspaces *planes, uint32_t first_portal, uint32_t last, EnfTargets *targets) {
    const EnfRegionModel *m = w->m;
    uint32_t count = 0;
    for (uint32_t n = 0; n < targets->count; ++n) {
        EnfTargetWord target = targets->list[n];
        for (uint64_t bits = target.bits; bits; bits &= bits - 1) {
            uint32_t cell = w->word_block[target.word] * 64 + enf_lowest_bit64(bits), portals = m->out_first[cell + 1] - m->out_first[cell];
            uint64_t ways = 0;
            for (uint32_t k = 0; k < portals && !ways; k += 64)
                ways = enf_rm_ways(m, planes, cell, k, -1, first_portal, last);
            if (!ways) {
                target.bits &= ~(bits & (~bits + 1));
                ++w->out->stats.targets_dropped;
            }
        }
        if (target.bits)
            targets->list[count++] = target;
    }
    return targets->count = count;
}

/* Cells. More targets are too scattered for a shaft to leave enough out: 2 costs the fewest instructions (1, 4, 8: 0.5 to 4 %
 * more), at 22 % fewer chains. */
#define AIM_TARGETS 2

void enf_aim(const EnfSearchWorker *w, EnfSearchFrame *f, uint32_t first_portal, uint32_t last) {
    const EnfRegionModel *m = w->m;
    uint32_t cells[AIM_TARGETS], count = 0;
    for (uint32_t n = 0; n < f->targets.count; ++n)
        for (uint64_t bits = f->targets.list[n].bits; bits; bits &= bits - 1) {
            if (count == AIM_TARGETS)
                return;
            cells[count++] = w->word_block[f->targets.list[n].word] * 64 + enf_lowest_bit64(bits);
        }
    if (!f->source.count)
        return;
    double from[6], to[6], corner[3];
    box_empty(from), box_empty(to);
    for (uint32_t i = 0; i < f->source.count; ++i)
        enf_window_corner(&f->source, i, corner), box_add_point(from, corner);
    for (uint32_t c = 0; c < count; ++c)
        for (uint32_t k = 0, i = m->out_first[cells[c]]; i + k < m->out_first[cells[c] + 1]; k += 64)
            for (uint64_t ways = enf_rm_ways(m, &f->planes, cells[c], k, -1, first_portal, last); ways; ways &= ways - 1) {
                const float *box = m->out_box[i + k + enf_lowest_bit64(ways)];
                for (int a = 0; a < 3; ++a) {
                    double low = (double)box[a] - (double)box[a + 3], high = (double)box[a] + (double)box[a + 3];
                    to[a] = low < to[a] ? low : to[a];
                    to[a + 3] = high > to[a + 3] ? high : to[a + 3];
                }
            }
    uint32_t first = f->planes.count;
    enf_shaft(from, to, &f->planes);
    m->kernel->round(&f->planes, first);
}
