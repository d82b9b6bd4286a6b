/* SPDX-License-Identifier: GPL-3.0-or-later
 * The search along chains of portals: from each portal of a source cell, depth first, towards open cells only.
 *
 * Based on: Teller 1992 (cell-to-cell flow, separating planes) with targets: a branch lives only as long as a cell whose
 * pair with the source is still open might be seen through it. A target is dropped from a branch when it isn't in the
 * might-see set of the portal entered, or lies outside a separating plane of (source window, window passed).
 *
 * A pair is searched from one of its cells only, the one from which it costs less. Sources go in batches; what a batch found is
 * entered in the order of its sources, and a source sees what all batches but its own and the one before have found (search_order.c):
 * the same answer for any number of threads. */
#include "from_region/search_worker.h"

#include <string.h>

#include "base/memory.h"
#include "geometry/vec3.h"

/* Portals entered for one source cell before what is left is called undecided. [Count] Seconds at most a cell. */
#define CHAIN_CAP_DEFAULT 2000000u

/* Portals entered between two looks at the clock. */
#define CLOCK_INTERVAL 4096u

/* Portals along a chain from which on the window half way bounds it, too: among columns a third less CPU, in shorter chains no gain. */
#define MIDDLE_DEPTH 10

static EnfSearchFrame *new_frame(EnfSearchWorker *w, uint32_t depth) {
    EnfSearchFrame *f = enf_alloc(sizeof *f);
    EnfTargetWord *list = enf_alloc_array(w->word_capacity, sizeof *list);
    if (!f || !list) {
        enf_free(f), enf_free(list);
        w->out->failed = 1, w->stop = 1;
        return NULL;
    }
    f->targets = (EnfTargets){0, list};
    return w->frames[depth] = f;
}

/* NULL: out of memory, and the search ends. */
static inline EnfSearchFrame *frame_at(EnfSearchWorker *w, uint32_t depth) {
    return w->frames[depth] ? w->frames[depth] : new_frame(w, depth);
}

static inline int is_target(const EnfSearchWorker *w, const EnfTargets *targets, uint32_t cell) {
    uint32_t k = w->local[cell >> 6];
    for (uint32_t i = 0; i < targets->count; ++i)
        if (targets->list[i].word == k)
            return targets->list[i].bits >> (cell & 63) & 1;
    return 0;
}

static inline int is_open(const EnfSearchWorker *w, uint32_t cell) {
    uint32_t k = w->local[cell >> 6];
    return k != ENF_NONE && (w->open[k] >> (cell & 63) & 1);
}

void enf_search_close_target(EnfSearchWorker *w, uint32_t cell) {
    uint32_t k = w->local[cell >> 6];
    if (k != ENF_NONE)
        w->open[k] &= ~((uint64_t)1 << (cell & 63));
}

static void add_finding(EnfSearchWorker *w, uint32_t cell, uint32_t state, uint32_t line) {
    EnfFound *out = w->out;
    const EnfPairTable *table = &w->bake->table;
    if (!ENF_RESERVE(out->findings, (uint64_t)out->finding_count + 1)) {
        out->failed = 1, w->stop = 1;
        return;
    }
    uint64_t place = (uint64_t)(enf_pair_slot(table, w->source, cell) - table->slots);
    out->findings[out->finding_count++] = (EnfFinding){place, cell, state, line};
}

/* Keeps a line if it clears all it passes; the search doesn't stand on that. */
static void keep_line(EnfSearchWorker *w, const double p[3], const double d[3], const uint32_t *portals, uint32_t count) {
    if (enf_line_clearance(w->m, p, d, portals, count) < w->m->delta)
        return;
    if (!enf_found_lines_add(&w->out->lines, w->bake, w->seen->slots, p, d, portals, count))
        w->out->failed = 1, w->stop = 1;
}

/* A line proven through the chain of `count` portals: all that the source sees along it is settled. */
static void take_line(EnfSearchWorker *w, uint32_t count, const double p[3], const double d[3]) {
    const EnfRegionModel *m = w->m;
    enf_walk_line(m, w->chain[0], p, d, 1, &w->walk);
    uint32_t at = 0;
    while (at < w->walk.count && w->walk.portals[at] != w->chain[0])
        ++at;
    keep_line(w, w->walk.p, w->walk.d, w->walk.portals, w->walk.count);
    for (uint32_t i = at; i < w->walk.count; ++i)
        enf_search_close_target(w, m->to[w->walk.portals[i]]);
    /* In cells that aren't convex (the outside) a walk may turn off through a portal that lies nearer than the chain's. */
    if (!is_open(w, m->to[w->chain[count - 1]]))
        return;
    keep_line(w, p, d, w->chain, count);
    for (uint32_t i = 0; i < count; ++i)
        enf_search_close_target(w, m->to[w->chain[i]]);
}

/* The chain of `count` portals reaches an open cell. Gives ENF_CHAIN_*; HIDDEN: no line passes the chain at all, so nothing
 * beyond it needs a look. */
static uint32_t reach(EnfSearchWorker *w, uint32_t count, const EnfWindow *source, const EnfWindow *target) {
    uint32_t cell = w->m->to[w->chain[count - 1]];
    if (w->on_reach)
        return w->on_reach(w, count, source, target);
    if (w->bake->def.method == ENF_REGION_FLOW) {
        add_finding(w, cell, ENF_CHAIN_UNDECIDED, 0);
        enf_search_close_target(w, cell);
        return ENF_CHAIN_UNDECIDED;
    }
    EnfChain chain = {w->chain, count, source, target};
    double p[3], d[3];
    ++w->out->stats.line_tests;
    uint32_t state = enf_chain_test(w->m, &chain, w->stab, &w->out->stats, p, d);
    if (state == ENF_CHAIN_HIDDEN)
        return state;
    if (state == ENF_CHAIN_VISIBLE) {
        take_line(w, count, p, d);
        return state;
    }
    uint32_t line = 0, k = w->local[cell >> 6];
    if (w->flagged[k] >> (cell & 63) & 1 && state == ENF_CHAIN_UNDECIDED)
        return state; /* nothing new */
    w->flagged[k] |= (uint64_t)1 << (cell & 63);
    if (state == ENF_CHAIN_GRAZING) {
        keep_line(w, p, d, w->chain, count); /* between delta and the 5 % more that inner polygons ask for it is visible */
        line = w->out->grazing.count;
        if (!enf_line_store_add(&w->out->grazing, p, d, w->chain, count))
            w->out->failed = 1, w->stop = 1;
    }
    add_finding(w, cell, state, line);
    return state;
}

static void search_from(EnfSearchWorker *w, uint32_t depth);

/* Enters the k-th portal that leaves the cell of the frame at `depth`, and goes on from there. */
static void enter(EnfSearchWorker *w, uint32_t depth, uint32_t k) {
    const EnfRegionModel *m = w->m;
    EnfSearchFrame *f = w->frames[depth], *g = w->frames[depth + 1];
    uint32_t last = w->chain[depth], r = m->out[m->out_first[m->to[last]] + k], next = m->to[r];
    if (r == enf_rm_reverse(last))
        return;
    if (m->convex[next] ? w->on_chain[next] : w->on_chain[m->cell_count + (r >> 1)])
        return;
    if (!enf_targets_through(w, last, k, r, &f->targets, &g->targets))
        return;
    const EnfSearchFrame *beam = w->frames[f->beam];
    uint64_t cutting;
    if (!m->kernel->touches(&beam->planes, m->box[r >> 1], &cutting) || enf_turns_back(w, depth, r))
        return;
    int step =
        enf_window_step(w, w->chain[0], w->chain[f->beam], &beam->source, &beam->pass, &beam->planes, cutting, r, &g->source, &g->pass);
    if (step == ENF_STEP_EMPTY)
        return;
    g->beam = step == ENF_STEP_SAME ? f->beam : depth + 1;
    EnfFound *out = w->out;
    ++out->stats.chains;
    if (++w->chains > w->cap || depth + 3 > ENF_CHAIN_MAX) {
        out->capped = 1, w->stop = 1;
        return;
    }
    if (w->chains % CLOCK_INTERVAL == 0 && enf_bake_should_stop(w->bake)) {
        out->stopped = 1, w->stop = 1;
        return;
    }
    w->chain[depth + 1] = r;
    if (is_target(w, &g->targets, next))
        if (reach(w, depth + 2, &w->frames[g->beam]->source, &g->pass) == ENF_CHAIN_HIDDEN)
            return;
    if (w->stop || m->dead_end[next])
        return;
    w->on_chain[next] = 1, w->on_chain[m->cell_count + (r >> 1)] = 1;
    search_from(w, depth + 1);
    w->on_chain[next] = 0, w->on_chain[m->cell_count + (r >> 1)] = 0;
}

/* What bounds the lines between source and pass when they are far apart: the window half way along the chain, before the pass. */
static void add_middle_planes(EnfSearchWorker *w, uint32_t depth) {
    const EnfRegionModel *m = w->m;
    EnfSearchFrame *f = w->frames[depth];
    const EnfWindow *middle = &w->frames[depth / 2]->pass;
    uint32_t known = f->planes.count;
    if (!middle->count || !f->pass.count || known + middle->count + f->pass.count > ENF_HALFSPACES_MAX)
        return;
    (void)m->kernel->separators(middle, m->plane[w->chain[depth / 2]], &f->pass, m->plane[w->chain[depth]], 1, &f->planes);
    m->kernel->round(&f->planes, known);
}

/* The frame at `depth` has its windows and targets: finds its planes and drops targets. Gives whether any is left. */
static int prepare(EnfSearchWorker *w, uint32_t depth) {
    EnfSearchFrame *f = w->frames[depth];
    uint32_t first = w->chain[0], last = w->chain[depth];
    if (!enf_targets_keep(&f->targets, w->open))
        return 0;
    if (f->beam != depth)
        return 1;
    enf_window_planes(w, first, last, &f->source, &f->pass, &f->planes);
    if (depth >= MIDDLE_DEPTH)
        add_middle_planes(w, depth);
    if (!enf_targets_drop(w, &f->planes, first, last, &f->targets))
        return 0;
    enf_aim(w, f, first, last);
    return 1;
}

/* Depth first through the portals by which lines within the beam may leave. */
static void search_from(EnfSearchWorker *w, uint32_t depth) {
    const EnfRegionModel *m = w->m;
    if (!prepare(w, depth) || !frame_at(w, depth + 1))
        return;
    const EnfHalfspaces *planes = &w->frames[w->frames[depth]->beam]->planes;
    uint32_t last = w->chain[depth], cell = m->to[last], portals = m->out_first[cell + 1] - m->out_first[cell];
    for (uint32_t k = 0; k < portals; k += 64) {
        uint64_t ways = enf_rm_ways(m, planes, cell, k, 1, w->chain[0], last);
        for (; ways && !w->stop; ways &= ways - 1)
            enter(w, depth, k + enf_lowest_bit64(ways));
    }
}

/* The open targets of the source that are its to search, as local words. Gives whether there are any. */
static int load_targets(EnfSearchWorker *w, const uint32_t *rank) {
    const EnfPairTable *t = &w->bake->table;
    uint32_t source = w->source;
    uint64_t any = 0, first = t->first[source], end = t->first[source + 1];
    w->words = (uint32_t)(end - first);
    for (uint64_t b = first; b < end; ++b) {
        uint32_t k = (uint32_t)(b - first);
        w->word_block[k] = t->block[b];
        w->local[t->block[b]] = k;
        w->flagged[k] = 0;
        uint64_t open = 0, slot = enf_pair_slots_of(t, source, b);
        for (uint64_t bits = t->bits[b]; bits; bits &= bits - 1) {
            uint32_t cell = t->block[b] * 64 + enf_lowest_bit64(bits);
            uint64_t at = cell > source ? slot++ : 0;
            if (rank[cell] <= rank[source])
                continue;
            if (cell < source)
                at = (uint64_t)(enf_pair_slot(t, source, cell) - t->slots);
            if (w->seen->slots[at] == ENF_SLOT_OPEN)
                open |= bits & (~bits + 1);
        }
        w->open[k] = open;
        any |= open;
    }
    return any != 0;
}

/* News for whoever comes by this portal: none of the cells (a row of local words) is seen through it. */
static void note_gone(EnfSearchWorker *w, uint32_t portal, const uint64_t *cells) {
    const EnfMightSets *might = w->bake->might;
    EnfMightBits *gone = &w->out->gone;
    uint64_t first = might->first[portal];
    for (uint64_t b = first; b < first + might->count[portal]; ++b) {
        uint32_t k = w->local[might->block[b]];
        uint64_t bits = k == ENF_NONE ? 0 : w->seen->bits[b] & cells[k];
        if (!bits)
            continue;
        if (!ENF_RESERVE(gone->list, gone->count + 64))
            return; /* only a saving is lost */
        for (; bits; bits &= bits - 1)
            gone->list[gone->count++] = b * 64 + enf_lowest_bit64(bits);
    }
}

/* What no chain reached is hidden; what a chain reached without a proof keeps its finding. */
static void conclude(EnfSearchWorker *w) {
    const EnfRegionModel *m = w->m;
    int decided = !w->out->stopped && !w->out->capped && !w->out->failed;
    for (uint32_t k = 0; k < w->words; ++k) {
        w->open[k] &= ~w->flagged[k];
        for (uint64_t bits = w->open[k]; bits; bits &= bits - 1) {
            uint32_t cell = w->word_block[k] * 64 + enf_lowest_bit64(bits);
            add_finding(w, cell, decided ? ENF_CHAIN_HIDDEN : ENF_CHAIN_UNDECIDED, 0);
        }
    }
    for (uint32_t i = m->out_first[w->source]; i < m->out_first[w->source + 1] && decided; ++i)
        note_gone(w, m->out[i], w->open), note_gone(w, enf_rm_reverse(m->out[i]), w->open);
}

/* Follows all lines through a portal of the source. */
static void search_portal(EnfSearchWorker *w, uint32_t p) {
    const EnfRegionModel *m = w->m;
    EnfSearchFrame *f = w->frames[0];
    uint32_t next = m->to[p];
    if (!enf_targets_from(w, p, &f->targets))
        return;
    w->chain[0] = p;
    if (!enf_window_load(m, p, &f->source))
        f->source.count = 0;
    f->pass.count = 0, f->beam = 0;
    ++w->out->stats.chains, ++w->chains;
    if (is_open(w, next))
        (void)reach(w, 1, &f->source, NULL);
    w->on_chain[next] = 1, w->on_chain[m->cell_count + (p >> 1)] = 1;
    if (!w->stop && !m->dead_end[next])
        search_from(w, 0);
    w->on_chain[next] = 0, w->on_chain[m->cell_count + (p >> 1)] = 0;
    if (w->stop)
        return;
    /* What is still open isn't seen through it. */
    for (uint32_t k = 0; k < w->words; ++k)
        w->missed[k] = w->open[k] & ~w->flagged[k];
    note_gone(w, p, w->missed);
}

void enf_search_source(EnfSearchWorker *w, uint32_t source, const uint32_t *rank, const EnfSearchState *seen, EnfFound *out) {
    const EnfRegionModel *m = w->m;
    w->out = out, w->source = source, w->seen = seen;
    w->chains = 0, w->stop = 0;
    if (enf_bake_should_stop(w->bake)) {
        out->stopped = 1;
        return;
    }
    if (load_targets(w, rank) && frame_at(w, 0)) {
        w->on_chain[source] = 1;
        for (uint32_t i = m->out_first[source]; i < m->out_first[source + 1] && !w->stop; ++i)
            search_portal(w, m->out[i]);
        w->on_chain[source] = 0;
        conclude(w);
    }
    for (uint32_t k = 0; k < w->words; ++k)
        w->local[w->word_block[k]] = ENF_NONE;
}

void enf_found_free(EnfFound *found) {
    enf_found_lines_free(&found->lines);
    enf_line_store_free(&found->grazing);
    enf_free(found->findings), enf_free(found->gone.list);
}

int enf_search_worker_create(EnfSearchWorker *w, const EnfRegionBake *bake, uint32_t widest) {
    uint32_t blocks = bake->model->cell_count / 64 + 1;
    w->bake = bake, w->m = bake->model;
    w->word_capacity = widest + 1;
    w->local = ENF_NEW(uint32_t, blocks);
    w->word_block = ENF_NEW(uint32_t, w->word_capacity);
    w->open = ENF_NEW(uint64_t, w->word_capacity);
    w->flagged = ENF_NEW(uint64_t, w->word_capacity);
    w->missed = ENF_NEW(uint64_t, w->word_capacity);
    w->on_chain = ENF_NEW(uint8_t, (uint64_t)bake->model->cell_count + bake->model->portal_count + 1);
    w->stab = enf_stab_scratch_create();
    w->cap = bake->def.chain_cap ? bake->def.chain_cap : CHAIN_CAP_DEFAULT;
    if (!w->local || !w->word_block || !w->open || !w->flagged || !w->missed || !w->on_chain || !w->stab)
        return 0;
    for (uint32_t i = 0; i < blocks; ++i)
        w->local[i] = ENF_NONE;
    return 1;
}

void enf_search_worker_free(EnfSearchWorker *w) {
    enf_free(w->local), enf_free(w->word_block), enf_free(w->open), enf_free(w->flagged), enf_free(w->missed), enf_free(w->on_chain);
    for (uint32_t i = 0; i < ENF_CHAIN_MAX + 2; ++i)
        if (w->frames[i])
            enf_free(w->frames[i]->targets.list), enf_free(w->frames[i]);
    enf_stab_scratch_destroy(w->stab);
}
