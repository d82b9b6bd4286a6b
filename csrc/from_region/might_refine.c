/* SPDX-License-Identifier: GPL-3.0-or-later
 * Might-see sets held against each other: what is seen through p and q is seen through q and some r.
 *
 * A line through p and q (one after the other) ends in the cell behind q or leaves it by a portal r that can follow the two; then
 * it is a line through q and r. So M(p, q) may be cut to {to(q)} and the union of M(q, r) over those r, again and again: each round
 * looks one portal further. Supersets throughout. */
#include "base/memory.h"
#include "from_region/might_see.h"

/* Each round halves what is left to gain; the search decides the rest. */
#define ROUNDS 4

typedef struct Refining {
    EnfMightSets *sets;
    const EnfRegionModel *m;
    uint64_t *keep;    /* [blocks of the portal that has most] */
    uint32_t *changed; /* beside follow: the last step in which the set of the two portals lost something */
    uint32_t step;     /* portals gone through, from 1 on */
} Refining;

/* keep[i] := the union of word i of the rows: row k starts at rows + k * stride, which: the first 64, from 64 on all. Reads up to
 * ENF_MIGHT_ABREAST - 1 words more than `run`: so many are put together without a loop. */
static void unite_rows(const uint64_t *rows, uint64_t stride, uint32_t count, uint64_t which, uint32_t run, uint64_t *keep) {
    for (uint32_t i = 0; i < run; i += ENF_MIGHT_ABREAST) {
        uint64_t sum[ENF_MIGHT_ABREAST] = {0};
        for (uint64_t left = which; left; left &= left - 1) {
            const uint64_t *row = rows + enf_lowest_bit64(left) * stride + i;
            for (int a = 0; a < ENF_MIGHT_ABREAST; ++a)
                sum[a] |= row[a];
        }
        for (uint64_t k = 64; k < count; ++k)
            for (int a = 0; a < ENF_MIGHT_ABREAST; ++a)
                sum[a] |= rows[k * stride + i + a];
        for (uint32_t a = 0; a < ENF_MIGHT_ABREAST && i + a < run; ++a)
            keep[i + a] = sum[a];
    }
}

/* keep := what is seen through q and any of the portals that follow, in the blocks of p. */
static void gather(const EnfMightSets *sets, const EnfRegionModel *m, uint32_t p, uint32_t q, uint64_t follow, uint64_t *keep) {
    uint32_t portals = m->out_first[m->to[q] + 1] - m->out_first[m->to[q]], size = sets->count[p], count = sets->count[q];
    const uint32_t *block = sets->block + sets->first[p], *next = sets->block + sets->first[q];
    const uint64_t *rows = sets->pairs + sets->pair_first[q];
    for (uint32_t b = 0, n = 0; b < size;) {
        while (n < count && next[n] < block[b])
            ++n;
        uint32_t run = 0; /* blocks that both have, side by side */
        while (b + run < size && n + run < count && block[b + run] == next[n + run])
            ++run;
        unite_rows(rows + n, count, portals, follow, run, keep + b);
        b += run, n += run;
        if (!run)
            keep[b++] = 0;
    }
}

/* bits (beside the blocks of p) &= to(q) and the union of M(q, r). Gives whether anything went. */
static int refine_pair(Refining *x, uint32_t p, uint32_t q, uint64_t follow, uint64_t *bits) {
    const EnfMightSets *sets = x->sets;
    uint32_t cell = x->m->to[q], size = sets->count[p];
    const uint32_t *block = sets->block + sets->first[p];
    uint64_t gone = 0;
    gather(sets, x->m, p, q, follow, x->keep);
    for (uint32_t b = 0; b < size; ++b) {
        uint64_t keep = x->keep[b] | (block[b] == cell >> 6 ? (uint64_t)1 << (cell & 63) : 0);
        gone |= bits[b] & ~keep;
        bits[b] &= keep;
    }
    return gone != 0;
}

/* Whether what is seen through q and a portal that follows has changed after a step. */
static int has_changed(const Refining *x, uint32_t q, uint64_t follow, uint32_t step) {
    const uint32_t *changed = x->changed + x->sets->follow_first[q];
    for (; follow; follow &= follow - 1)
        if (changed[enf_lowest_bit64(follow)] > step)
            return 1;
    for (uint32_t k = 64, cell = x->m->to[q]; k < x->m->out_first[cell + 1] - x->m->out_first[cell]; ++k)
        if (changed[k] > step)
            return 1;
    return 0;
}

/* All sets of p and a second portal. What depends on nothing that changed since the last round is as it was. */
static int refine_portal(Refining *x, uint32_t p, uint32_t round) {
    EnfMightSets *sets = x->sets;
    const EnfRegionModel *m = x->m;
    uint32_t cell = m->to[p], portals = m->out_first[cell + 1] - m->out_first[cell], last = x->step - 2 * m->portal_count;
    uint64_t *bits = sets->pairs + sets->pair_first[p];
    int changed = 0;
    for (uint32_t k = 0; k < portals; ++k, bits += sets->count[p]) {
        uint32_t q = m->out[m->out_first[cell] + k];
        uint64_t at = sets->follow_first[p] + k;
        if (q == enf_rm_reverse(p) || !sets->known[q] || (round && !has_changed(x, q, sets->follow[at], last)))
            continue;
        if (refine_pair(x, p, q, sets->follow[at], bits))
            x->changed[at] = x->step, changed = 1;
    }
    return changed;
}

/* M(p): to(p) and the union over q. */
static void unite(EnfMightSets *sets, const EnfRegionModel *m, uint32_t p) {
    uint32_t cell = m->to[p], portals = m->out_first[cell + 1] - m->out_first[cell], size = sets->count[p];
    const uint32_t *block = sets->block + sets->first[p];
    uint64_t *bits = sets->bits + sets->first[p];
    for (uint32_t b = 0; b < size; ++b)
        bits[b] = block[b] == cell >> 6 ? (uint64_t)1 << (cell & 63) : 0;
    for (uint32_t k = 0; k < portals; ++k) {
        const uint64_t *seen = sets->pairs + sets->pair_first[p] + (uint64_t)k * size;
        for (uint32_t b = 0; b < size; ++b)
            bits[b] |= seen[b];
    }
}

EnfStatus enf_might_sets_refine(EnfMightSets *sets, const EnfRegionModel *m) {
    uint32_t widest = 0, count = 2 * m->portal_count;
    for (uint32_t p = 0; p < count; ++p)
        widest = sets->count[p] > widest ? sets->count[p] : widest;
    Refining x = {sets, m, ENF_NEW(uint64_t, (uint64_t)widest + 1), ENF_NEW(uint32_t, sets->follow_total + 1), 0};
    EnfStatus status = x.keep && x.changed ? ENF_OK : enf_fail_memory();
    int changed = status == ENF_OK;
    for (uint32_t round = 0; round < ROUNDS && changed; ++round) {
        changed = 0;
        for (uint32_t p = 0; p < count; ++p) {
            ++x.step;
            if (sets->known[p])
                changed |= refine_portal(&x, p, round);
        }
    }
    for (uint32_t p = 0; p < count && status == ENF_OK; ++p)
        if (sets->known[p])
            unite(sets, m, p);
    enf_free(x.keep), enf_free(x.changed);
    return status;
}
