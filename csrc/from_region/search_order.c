/* SPDX-License-Identifier: GPL-3.0-or-later
 * In which order sources are searched, what each sees of what others found, and how it is entered.
 *
 * Sources go in batches of fixed size. A source of batch b sees the table as batches up to b - 2 left it, never anything newer:
 * so batches b - 1 and b can run at the same time, one long source doesn't leave the other threads idle, and the answer is
 * the same for any number of threads. Two copies of what changes (pair states, might-see sets) serve odd and even batches; when
 * batch b - 2 has ended, nobody reads the copy it read, and batch b gets it, brought up to date. */
#include <stdlib.h>
#include <string.h>

#include "base/batches.h"
#include "base/memory.h"
#include "base/status.h"
#include "from_region/search_worker.h"

#define BATCH 8

typedef struct Search {
    EnfRegionBake *bake;
    EnfSearchWorker *workers;
    uint32_t *sources, *rank;
    uint32_t count;                         /* of sources */
    EnfSearchState seen[2];                 /* of even and odd batches */
    EnfChangeLog slots_before, bits_before; /* what the batch entered last changed */
    EnfFound found[2 * BATCH];
} Search;

/* Enters what one source found; VISIBLE wins over GRAZING, GRAZING over UNDECIDED. */
static EnfStatus enter_found(EnfRegionBake *bake, EnfFound *found) {
    EnfStatus status = found->failed ? enf_fail_memory() : ENF_OK;
    int contradicted = 0; /* then nothing is to be built on it */
    enf_bake_add_counters(&bake->stats, &found->stats);
    bake->stats.chain_capped += found->capped;
    for (uint32_t i = 0; i < found->lines.store.count && status == ENF_OK; ++i)
        if (enf_found_line_enter(&found->lines, i, bake) < 0)
            status = enf_fail_memory();
    for (uint32_t i = 0; i < found->finding_count && status == ENF_OK; ++i) {
        const EnfFinding *finding = &found->findings[i];
        uint32_t *slot = &bake->table.slots[finding->place];
        if (enf_slot_is_visible(*slot) || enf_slot_is_grazing(*slot))
            contradicted |= finding->state == ENF_CHAIN_HIDDEN;
        else if (finding->state == ENF_CHAIN_HIDDEN)
            enf_pair_set(&bake->table, slot, ENF_SLOT_HIDDEN);
        else if (finding->state == ENF_CHAIN_UNDECIDED)
            enf_pair_set(&bake->table, slot, ENF_SLOT_UNDECIDED);
        else {
            const EnfLine *line = &found->grazing.lines[finding->line];
            if (!enf_line_store_add(&bake->lines, line->p, line->d, found->grazing.portals + line->portal_first, line->portal_count))
                status = enf_fail_memory();
            else
                enf_pair_set(&bake->table, slot, ENF_SLOT_GRAZING | bake->lines.count);
        }
    }
    if (!contradicted)
        enf_might_sets_exclude(bake->might, &found->gone);
    enf_found_lines_clear(&found->lines);
    found->grazing.count = 0, found->grazing.portal_total = 0;
    found->finding_count = 0, found->gone.count = 0;
    memset(&found->stats, 0, sizeof found->stats);
    found->failed = found->stopped = found->capped = 0;
    return status;
}

typedef struct Order {
    double cost;
    uint32_t cell;
    uint8_t open, later;
} Order;

static int compare_order(const void *a, const void *b) {
    const Order *x = a, *y = b;
    if (x->later != y->later)
        return x->later ? 1 : -1;
    if (x->cost != y->cost)
        return x->cost < y->cost ? -1 : 1;
    return (x->cell > y->cell) - (x->cell < y->cell);
}

/* What a search from the cell will cost, in any unit: by all that is seen through its portals, and by its size. Narrow beams are
 * soon cut off, and what they fail to see needn't be looked for when it comes to the wide ones (fewest open pairs first takes 40 %
 * more chains). */
static double search_cost(const EnfRegionBake *bake, uint32_t cell) {
    const EnfRegionModel *m = bake->model;
    const EnfMightSets *might = bake->might;
    const float *box = m->cell_box[cell];
    double seen = 0;
    for (uint32_t i = m->out_first[cell]; i < m->out_first[cell + 1]; ++i)
        for (uint64_t b = might->first[m->out[i]], end = b + might->count[m->out[i]]; b < end; ++b)
            seen += enf_popcount64(might->bits[b]);
    return seen * ((double)box[3] + (double)box[4] + (double)box[5]);
}

/* Source cells by what they cost, cheapest first; with rows asked for, those cells before all others. Cells without
 * open pairs have no rank. */
static uint32_t order_sources(const EnfRegionBake *bake, uint32_t *sources, uint32_t *rank, Order *order) {
    const EnfPairTable *t = &bake->table;
    for (uint32_t i = 0; i < t->cell_count; ++i)
        order[i] = (Order){0, i, 0, bake->wanted && !bake->wanted[i]};
    for (uint32_t i = 0; i < t->cell_count; ++i)
        for (uint64_t b = t->first[i]; b < t->first[i + 1]; ++b) {
            const uint32_t *slot = t->slots + enf_pair_slots_of(t, i, b);
            for (uint64_t bits = t->bits[b]; bits; bits &= bits - 1) {
                uint32_t j = t->block[b] * 64 + enf_lowest_bit64(bits);
                if (j > i && *slot++ == ENF_SLOT_OPEN)
                    order[i].open = order[j].open = 1;
            }
        }
    uint32_t count = 0, asked = 0;
    for (uint32_t i = 0; i < t->cell_count; ++i)
        if (order[i].open) {
            order[asked] = order[i];
            order[asked++].cost = search_cost(bake, i);
        }
    qsort(order, asked, sizeof *order, compare_order);
    for (uint32_t i = 0; i < asked; ++i) {
        rank[order[i].cell] = i;
        if (!order[i].later)
            sources[count++] = order[i].cell;
    }
    return count;
}

static void swap_logs(EnfChangeLog *a, EnfChangeLog *b) {
    EnfChangeLog c = *a;
    *a = *b, *b = c;
    a->on = 1, a->count = 0;
}

/* Brings a copy up to date that lacks what two batches changed. */
static void update(EnfSearchState *seen, const EnfRegionBake *bake, const EnfChangeLog *slots, const EnfChangeLog *bits) {
    for (uint64_t i = 0; i < slots->count; ++i)
        seen->slots[slots->places[i]] = bake->table.slots[slots->places[i]];
    for (uint64_t i = 0; i < bits->count; ++i)
        seen->bits[bits->places[i]] = bake->might->bits[bits->places[i]];
}

/* A batch has ended: its findings go into the table, and the copy it read is brought up to date for the batch after the next. It
 * lacks what this batch and the one before it changed. */
static EnfStatus enter_batch(void *context, uint64_t first, uint64_t end) {
    Search *s = context;
    EnfRegionBake *bake = s->bake;
    EnfChangeLog *slots = &bake->table.log, *bits = &bake->might->log;
    for (uint64_t at = first; at < end; ++at) {
        EnfStatus status = enter_found(bake, &s->found[at % (2 * BATCH)]);
        if (status != ENF_OK)
            return status;
    }
    if (slots->failed || bits->failed)
        return enf_fail_memory();
    EnfSearchState *seen = &s->seen[first / BATCH & 1];
    update(seen, bake, &s->slots_before, &s->bits_before);
    update(seen, bake, slots, bits);
    swap_logs(slots, &s->slots_before);
    swap_logs(bits, &s->bits_before);
    enf_bake_report(bake, "search", 0.2 + 0.79 * (double)end / s->count);
    return ENF_OK;
}

static void search_source(void *context, uint64_t at, uint32_t thread) {
    Search *s = context;
    enf_search_source(&s->workers[thread], s->sources[at], s->rank, &s->seen[at / BATCH & 1], &s->found[at % (2 * BATCH)]);
}

static int copy_state(const EnfRegionBake *bake, EnfSearchState *to) {
    uint64_t slots = bake->table.slot_first[bake->table.cell_count], blocks = bake->might->total;
    to->slots = enf_alloc((slots + 1) * sizeof *to->slots);
    to->bits = enf_alloc((blocks + 1) * sizeof *to->bits);
    if (!to->slots || !to->bits)
        return 0;
    memcpy(to->slots, bake->table.slots, slots * sizeof *to->slots);
    if (blocks)
        memcpy(to->bits, bake->might->bits, blocks * sizeof *to->bits);
    return 1;
}

static EnfStatus prepare(Search *s) {
    EnfRegionBake *bake = s->bake;
    uint32_t n = bake->model->cell_count, threads = bake->stats.threads, widest = 0;
    for (uint32_t c = 0; c < n; ++c)
        if (bake->table.first[c + 1] - bake->table.first[c] > widest)
            widest = (uint32_t)(bake->table.first[c + 1] - bake->table.first[c]);
    s->sources = ENF_NEW(uint32_t, (uint64_t)n + 1);
    s->rank = ENF_NEW(uint32_t, (uint64_t)n + 1);
    s->workers = ENF_NEW(EnfSearchWorker, threads);
    Order *order = ENF_NEW(Order, (uint64_t)n + 1);
    int ok = s->sources && s->rank && s->workers && order;
    if (ok)
        s->count = order_sources(bake, s->sources, s->rank, order);
    enf_free(order);
    if (!ok)
        return enf_fail_memory();
    if (!s->count)
        return ENF_OK;
    for (uint32_t t = 0; t < threads; ++t)
        if (!enf_search_worker_create(&s->workers[t], bake, widest))
            return enf_fail_memory();
    for (int k = 0; k < 2; ++k)
        if (!copy_state(bake, &s->seen[k]))
            return enf_fail_memory();
    bake->table.log.on = bake->might->log.on = 1;
    return ENF_OK;
}

EnfStatus enf_chain_search(EnfRegionBake *bake) {
    Search search = {.bake = bake};
    uint32_t threads = bake->stats.threads;
    EnfStatus status = prepare(&search);
    if (status == ENF_OK && search.count)
        status = enf_run_batches(&(EnfBatches){search.count, BATCH, 1, threads, search_source, enter_batch, &search});
    for (uint32_t t = 0; t < threads && search.workers; ++t)
        enf_search_worker_free(&search.workers[t]);
    for (uint32_t k = 0; k < 2 * BATCH; ++k)
        enf_found_free(&search.found[k]);
    for (int k = 0; k < 2; ++k)
        enf_free(search.seen[k].slots), enf_free(search.seen[k].bits);
    enf_free(search.slots_before.places), enf_free(search.bits_before.places);
    enf_free(search.workers), enf_free(search.sources), enf_free(search.rank);
    return status;
}
