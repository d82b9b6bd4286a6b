/* SPDX-License-Identifier: GPL-3.0-or-later
 * Door states as variants: what a changed opening can't change is taken over from the result before.
 *
 * A pair seen by a line that passes nothing newly shut is seen still, by the same line. A hidden pair can only be seen now by a
 * line through something newly open: then its cells lie in the might-see sets of that portal, one on each side. All else
 * that was hidden stays hidden. What remains (lines cut, pairs across a new way, what was undecided or grazing) is asked
 * again, and nothing else is flooded or searched. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "from_region/might_see.h"
#include "from_region/region_result.h"

typedef struct Variant {
    EnfRegionBake *block;
    const EnfRegionVis *before;
    uint64_t *open; /* pairs to ask: lower cell << 32 | higher, each once after sorting */
    uint64_t open_count;
    uint8_t *has_open;  /* [cells] */
    uint8_t *line_cut;  /* [lines] something along it is shut now */
    uint32_t *new_line; /* [lines] index + 1 in the block's store, 0: not there yet */
} Variant;

EnfStatus enf_region_result_may_vary(const EnfRegionVis *before, const EnfScene *scene) {
    if (before->stats.partial || before->question.asked_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: variant_of holds only some rows; a whole result is needed");
    if (before->stats.method != ENF_REGION_EXACT)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: variant_of must be a result of method exact");
    if (before->scene != scene && enf_bake_geometry_hash(before->scene) != enf_bake_geometry_hash(scene))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: variant_of is the result of another scene");
    return ENF_OK;
}

static int compare_u64(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static int add_open(Variant *v, uint32_t i, uint32_t j) {
    if (!ENF_RESERVE(v->open, v->open_count + 1))
        return 0;
    v->open[v->open_count++] = i < j ? (uint64_t)i << 32 | j : (uint64_t)j << 32 | i;
    return 1;
}

/* Whether the line passes all its portals first .. last, and no cell between them is a dead end. */
static int passes_still(const EnfRegionModel *m, const uint32_t *portals, uint32_t first, uint32_t last) {
    for (uint32_t k = first; k <= last; ++k)
        if (!m->passes[portals[k] >> 1] || (k < last && m->dead_end[m->to[portals[k]]]))
            return 0;
    return 1;
}

/* Whether entry `at` of row i (its cell j) is known without asking again. */
static int is_kept(const Variant *v, uint64_t at, uint32_t i) {
    const EnfRegionVis *before = v->before;
    if (before->status[at] != ENF_PAIR_VISIBLE)
        return 0;
    const EnfLine *line = &before->lines.lines[before->line[at]];
    if (!v->line_cut[before->line[at]])
        return 1;
    uint32_t first, last;
    int backward;
    return enf_region_result_cut_line(before, line, i, before->cells[at], &first, &last, &backward) &&
           passes_still(v->block->model, before->lines.portals + line->portal_first, first, last);
}

/* Pairs of which one cell might be seen through `o`, the other through it backward, and that were hidden. */
static int open_across(Variant *v, const EnfMightSets *sets, uint32_t o) {
    uint32_t r = enf_rm_reverse(o);
    const EnfRegionVis *before = v->before;
    for (uint32_t a = 0; a < sets->count[r]; ++a)
        for (uint64_t left = sets->bits[sets->first[r] + a]; left; left &= left - 1) {
            uint32_t i = sets->block[sets->first[r] + a] * 64 + enf_lowest_bit64(left);
            for (uint32_t b = 0; b < sets->count[o]; ++b)
                for (uint64_t right = sets->bits[sets->first[o] + b]; right; right &= right - 1) {
                    uint32_t j = sets->block[sets->first[o] + b] * 64 + enf_lowest_bit64(right);
                    if (i == j || enf_region_result_find(before, i, j) < before->first[before->cell_count])
                        continue;
                    if (!add_open(v, i, j))
                        return 0;
                }
        }
    return 1;
}

/* The hidden pairs that something newly open may show. */
static EnfStatus open_new_ways(Variant *v) {
    const EnfRegionModel *m = v->block->model, *old = v->before->model;
    uint32_t count = 0, *ways = NULL;
    EnfStatus status = ENF_OK;
    for (uint32_t p = 0; p < m->portal_count && status == ENF_OK; ++p) {
        /* A cell that is a dead end no longer: whoever looks through it leaves it by one of its portals. */
        int live[2];
        for (int k = 0; k < 2; ++k)
            live[k] = old->dead_end[enf_rm_from(m, 2 * p + k)] && !m->dead_end[enf_rm_from(m, 2 * p + k)];
        if (!m->passes[p] || (old->passes[p] && !live[0] && !live[1]))
            continue;
        if (!ENF_RESERVE(ways, (uint64_t)count + 1))
            status = enf_fail_memory();
        else
            ways[count++] = 2 * p; /* pairs are unordered: one direction tells of both */
    }
    if (count && status == ENF_OK) {
        EnfRegionBake flood = *v->block;
        uint8_t *wanted = ENF_NEW(uint8_t, (uint64_t)m->cell_count + 1);
        uint32_t none = 0;
        memset(&flood.table, 0, sizeof flood.table);
        flood.table.slots = &none; /* sets are wanted, no rows */
        flood.wanted = wanted, flood.might = NULL;
        for (uint32_t k = 0; k < count && wanted; ++k)
            wanted[m->to[ways[k]]] = wanted[enf_rm_from(m, ways[k])] = 1;
        status = wanted ? enf_might_see(&flood) : enf_fail_memory();
        for (uint32_t k = 0; k < count && status == ENF_OK; ++k)
            if (!open_across(v, flood.might, ways[k]))
                status = enf_fail_memory();
        enf_might_sets_destroy(flood.might);
        enf_free(wanted);
    }
    enf_free(ways);
    return status;
}

/* The state of a kept pair in the block's store; 0 when memory runs out. */
static uint32_t take_line(Variant *v, uint32_t line) {
    const EnfLineStore *from = &v->before->lines;
    if (!v->new_line[line]) {
        const EnfLine *l = &from->lines[line];
        if (!enf_line_store_add(&v->block->lines, l->p, l->d, from->portals + l->portal_first, l->portal_count))
            return 0;
        v->new_line[line] = v->block->lines.count;
    }
    return v->new_line[line];
}

/* The table's rows out of pairs, sorted by cell and cell, both ways round. */
static EnfStatus make_table(EnfPairTable *t, const uint64_t *directed, uint64_t count, uint32_t cells) {
    t->cell_count = cells;
    t->first = ENF_NEW(uint64_t, (uint64_t)cells + 1);
    t->block = ENF_NEW(uint32_t, count + 1);
    t->bits = ENF_NEW(uint64_t, count + 1);
    if (!t->first || !t->block || !t->bits)
        return enf_fail_memory();
    uint64_t blocks = 0, k = 0;
    for (uint32_t i = 0; i < cells; ++i) {
        t->first[i] = blocks;
        for (; k < count && directed[k] >> 32 == i; ++k) {
            uint32_t j = (uint32_t)directed[k];
            if (blocks == t->first[i] || t->block[blocks - 1] != j >> 6)
                t->block[blocks++] = j >> 6;
            t->bits[blocks - 1] |= (uint64_t)1 << (j & 63);
        }
    }
    t->first[cells] = blocks;
    return enf_pair_table_finish(t) ? ENF_OK : enf_fail_memory();
}

typedef struct Directed {
    uint64_t *pairs; /* first cell << 32 | second */
    uint64_t count;
} Directed;

static int add_both_ways(Directed *to, uint32_t i, uint32_t j) {
    if (!ENF_RESERVE(to->pairs, to->count + 2))
        return 0;
    to->pairs[to->count++] = (uint64_t)i << 32 | j, to->pairs[to->count++] = (uint64_t)j << 32 | i;
    return 1;
}

static void drop_doubles(Variant *v) {
    uint64_t unique = 0;
    if (v->open_count)
        qsort(v->open, v->open_count, sizeof *v->open, compare_u64);
    for (uint64_t k = 0; k < v->open_count; ++k)
        if (!k || v->open[k] != v->open[k - 1])
            v->open[unique++] = v->open[k];
    v->open_count = v->block->stats.pairs_reopened = unique;
}

/* The table of what is open, and of known pairs of cells that have something open: sightlines start from those. */
static EnfStatus make_table_of(Variant *v) {
    const EnfRegionVis *before = v->before;
    uint32_t n = before->cell_count;
    Directed directed = {NULL, 0};
    int ok = 1;
    for (uint64_t k = 0; k < v->open_count && ok; ++k) {
        uint32_t i = (uint32_t)(v->open[k] >> 32), j = (uint32_t)v->open[k];
        v->has_open[i] = v->has_open[j] = 1;
        ok = add_both_ways(&directed, i, j);
    }
    for (uint32_t i = 0; i < n && ok; ++i)
        for (uint64_t k = before->first[i]; k < before->first[i + 1] && ok; ++k) {
            uint32_t j = before->cells[k];
            if (j <= i || !is_kept(v, k, i))
                continue;
            ++v->block->stats.pairs_kept;
            if (v->has_open[i] || v->has_open[j])
                ok = add_both_ways(&directed, i, j);
        }
    if (directed.count)
        qsort(directed.pairs, directed.count, sizeof *directed.pairs, compare_u64);
    EnfStatus status = ok ? make_table(&v->block->table, directed.pairs, directed.count, n) : enf_fail_memory();
    enf_free(directed.pairs);
    return status;
}

/* Known pairs with their lines: into the table, or, of cells that have nothing open, straight into the answer. */
static EnfStatus enter_known(Variant *v, EnfBlockAnswer *answer) {
    const EnfRegionVis *before = v->before;
    for (uint32_t i = 0; i < before->cell_count; ++i)
        for (uint64_t k = before->first[i]; k < before->first[i + 1]; ++k) {
            uint32_t j = before->cells[k];
            if (j <= i || !is_kept(v, k, i))
                continue;
            uint32_t state = take_line(v, before->line[k]);
            if (!state)
                return enf_fail_memory();
            if (v->has_open[i] || v->has_open[j]) {
                *enf_pair_slot(&v->block->table, i, j) = state;
                continue;
            }
            if (!ENF_RESERVE(answer->pairs, (uint64_t)answer->pair_count + 1))
                return enf_fail_memory();
            uint32_t *pair = answer->pairs[answer->pair_count++];
            pair[0] = i, pair[1] = j, pair[2] = state;
        }
    return ENF_OK;
}

EnfStatus enf_bake_variant(EnfRegionBake *block, const EnfRegionVis *before, uint8_t **out_wanted, EnfBlockAnswer *answer) {
    const EnfRegionModel *m = block->model;
    uint32_t n = m->cell_count;
    if (m->delta != before->model->delta)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: clearance %g m, but variant_of was baked with %g m",
                        m->delta * m->inverse_scale, before->stats.clearance);
    Variant v = {.block = block, .before = before};
    v.has_open = ENF_NEW(uint8_t, (uint64_t)n + 1);
    v.line_cut = ENF_NEW(uint8_t, (uint64_t)before->lines.count + 1);
    v.new_line = ENF_NEW(uint32_t, (uint64_t)before->lines.count + 1);
    EnfStatus status = v.has_open && v.line_cut && v.new_line ? ENF_OK : enf_fail_memory();
    for (uint32_t k = 0; k < before->lines.count && status == ENF_OK; ++k) {
        const EnfLine *line = &before->lines.lines[k];
        v.line_cut[k] = line->portal_count && !passes_still(m, before->lines.portals + line->portal_first, 0, line->portal_count - 1);
    }
    for (uint32_t i = 0; i < n && status == ENF_OK; ++i)
        for (uint64_t k = before->first[i]; k < before->first[i + 1] && status == ENF_OK; ++k)
            if (before->cells[k] > i && !is_kept(&v, k, i) && !add_open(&v, i, before->cells[k]))
                status = enf_fail_memory();
    if (status == ENF_OK)
        status = open_new_ways(&v);
    if (status == ENF_OK) {
        drop_doubles(&v);
        status = make_table_of(&v);
    }
    if (status == ENF_OK)
        status = enter_known(&v, answer);
    enf_free(v.open), enf_free(v.line_cut), enf_free(v.new_line);
    *out_wanted = v.has_open;
    return status;
}
