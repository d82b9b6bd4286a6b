/* SPDX-License-Identifier: GPL-3.0-or-later
 * What one block found, apart from the tables it was found with. */
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "from_region/bake.h"

void enf_bake_add_counters(EnfRegionVisStats *to, const EnfRegionVisStats *from) {
    to->might_pairs += from->might_pairs;
    to->seed_lines += from->seed_lines, to->seed_pairs += from->seed_pairs;
    to->chains += from->chains, to->clips += from->clips, to->targets_dropped += from->targets_dropped;
    to->line_tests += from->line_tests, to->line_hits += from->line_hits;
    to->cone_tests += from->cone_tests, to->cone_hidden += from->cone_hidden, to->cone_visible += from->cone_visible;
    to->cone_rays += from->cone_rays, to->filter_failures += from->filter_failures;
    to->exact_signs += from->exact_signs, to->cone_signs += from->cone_signs, to->chain_capped += from->chain_capped;
    to->pairs_kept += from->pairs_kept, to->pairs_reopened += from->pairs_reopened;
    to->might_s += from->might_s, to->seed_s += from->seed_s, to->search_s += from->search_s;
}

EnfStatus enf_block_answer_take(EnfRegionBake *block, EnfBlockAnswer *out) {
    const EnfPairTable *t = &block->table;
    const EnfRegionModel *m = block->model;
    uint32_t count = out->pair_count;
    for (uint32_t i = 0; i < t->cell_count; ++i)
        for (uint64_t b = t->first[i]; b < t->first[i + 1]; ++b) {
            if (t->block[b] < i >> 6)
                continue;
            for (uint64_t bits = t->bits[b]; bits; bits &= bits - 1) {
                uint32_t j = t->block[b] * 64 + enf_lowest_bit64(bits);
                if (j <= i)
                    continue;
                uint32_t slot = *enf_pair_slot(t, i, j);
                if (slot == ENF_SLOT_HIDDEN || slot == ENF_SLOT_FOREIGN)
                    continue;
                if (slot == ENF_SLOT_OPEN) {
                    if (block->def.method == ENF_REGION_SAMPLE)
                        continue; /* a lower bound */
                    slot = ENF_SLOT_UNDECIDED;
                }
                if (!ENF_RESERVE(out->pairs, (uint64_t)count + 1))
                    return enf_fail_memory();
                out->pairs[count][0] = enf_rm_scene_cell(m, i), out->pairs[count][1] = enf_rm_scene_cell(m, j);
                out->pairs[count++][2] = slot;
            }
        }
    out->pair_count = count;
    out->lines = block->lines;
    for (uint32_t k = 0; k < out->lines.portal_total; ++k)
        out->lines.portals[k] = enf_rm_scene_portal(m, out->lines.portals[k]);
    memset(&block->lines, 0, sizeof block->lines);
    out->stats = block->stats;
    out->done = 1;
    return ENF_OK;
}

void enf_block_answer_free(EnfBlockAnswer *answer) {
    enf_free(answer->pairs);
    enf_line_store_free(&answer->lines);
    memset(answer, 0, sizeof *answer);
}
