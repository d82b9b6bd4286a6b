/* SPDX-License-Identifier: GPL-3.0-or-later
 * Might-see sets held against each other: what is seen through p and q is seen through q and some r.
 *
 * A line through p and q (one after the other) ends in the cell behind q or leaves it by a portal r that can follow the two; then
 * it is a line through q and r. So M(p, q) may be cut to {to(q)} and the union of M(q, r) over those r, again and again: each round
 * looks one portal further. Supersets throughout. */
#include "from_region/might_see.h"

/* Each round halves what is left to gain; the search decides the rest. */
#define ROUNDS 4

/* bits (beside the blocks of p) &= to(q) and the union of M(q, r). Gives whether anything went. */
static int refine_pair(EnfMightSets *sets, const EnfRegionModel *m, uint32_t p, uint32_t q, uint64_t follow, uint64_t *bits) {
    uint32_t cell = m->to[q], portals = m->out_first[cell + 1] - m->out_first[cell], count = sets->count[q];
    const uint32_t *block = sets->block + sets->first[p], *next = sets->block + sets->first[q];
    const uint64_t *pairs = sets->pairs + sets->pair_first[q];
    uint64_t gone = 0;
    for (uint32_t b = 0, n = 0; b < sets->count[p]; ++b) {
        if (!bits[b])
            continue;
        uint64_t keep = block[b] == cell >> 6 ? (uint64_t)1 << (cell & 63) : 0;
        while (n < count && next[n] < block[b])
            ++n;
        if (n < count && next[n] == block[b])
            for (uint32_t k = 0; k < portals && (bits[b] & ~keep); ++k)
                if (k >= 64 || follow >> k & 1)
                    keep |= pairs[(uint64_t)k * count + n];
        gone |= bits[b] & ~keep;
        bits[b] &= keep;
    }
    return gone != 0;
}

void enf_might_sets_refine(EnfMightSets *sets, const EnfRegionModel *m) {
    int changed = 1;
    for (int round = 0; round < ROUNDS && changed; ++round) {
        changed = 0;
        for (uint32_t p = 0; p < 2 * m->portal_count; ++p) {
            if (!sets->known[p])
                continue;
            uint32_t cell = m->to[p], portals = m->out_first[cell + 1] - m->out_first[cell];
            uint64_t *bits = sets->pairs + sets->pair_first[p];
            for (uint32_t k = 0; k < portals; ++k, bits += sets->count[p]) {
                uint32_t q = m->out[m->out_first[cell] + k];
                if (q != enf_rm_reverse(p) && sets->known[q])
                    changed |= refine_pair(sets, m, p, q, sets->follow[sets->follow_first[p] + k], bits);
            }
        }
    }
    for (uint32_t p = 0; p < 2 * m->portal_count; ++p) {
        if (!sets->known[p])
            continue;
        uint32_t cell = m->to[p], portals = m->out_first[cell + 1] - m->out_first[cell];
        for (uint32_t b = 0; b < sets->count[p]; ++b) {
            uint64_t word = sets->block[sets->first[p] + b] == cell >> 6 ? (uint64_t)1 << (cell & 63) : 0;
            for (uint32_t k = 0; k < portals; ++k)
                word |= sets->pairs[sets->pair_first[p] + (uint64_t)k * sets->count[p] + b];
            sets->bits[sets->first[p] + b] = word;
        }
    }
}
