/* SPDX-License-Identifier: GPL-3.0-or-later
 * Witnesses first: sightlines aimed from lines already known at the portals that lead to cells not yet proven.
 *
 * From each source cell knowledge grows outward: a line that reaches cell X is turned about one of its points so that it
 * leaves X through each portal behind which lies an unproven cell. What a line passes is proven for all pairs of cells on
 * it, in both directions. Sources run in batches: each sees the table as it stood before its batch, and what a batch found
 * is recorded in the order of its sources, so that the answer doesn't depend on threads. */
#include <string.h>

#include "base/batches.h"
#include "base/memory.h"
#include "base/status.h"
#include "from_region/bake.h"
#include "geometry/vec3.h"

/* Sources that see the same table: small enough to profit from each other's lines, enough to feed the threads. */
#define BATCH 32

typedef struct Frontier {
    double p[3], d[3];
    double t_from, t_to; /* between leaving the source and entering `cell` */
    uint32_t cell, came_by;
} Frontier;

typedef struct Scratch {
    uint32_t *mark; /* [cells] == stamp: the source sees it */
    uint32_t stamp;
    Frontier *queue;
    EnfWalk walk;
} Scratch;

typedef struct Seeds { /* of one source */
    EnfFoundLines lines;
    uint64_t walked;
    int failed; /* out of memory */
} Seeds;

typedef struct Seeding {
    EnfRegionBake *bake;
    uint32_t *sources; /* [source_count] */
    uint32_t source_count;
    Scratch *scratch; /* [threads] */
    Seeds found[BATCH];
    double effort;
} Seeding;

static uint32_t slot_of(const EnfRegionBake *bake, uint32_t a, uint32_t b) {
    const uint32_t *slot = enf_pair_slot(&bake->table, a, b);
    return slot ? *slot : ENF_SLOT_HIDDEN;
}

/* A source being seeded. */
typedef struct Source {
    const Seeding *seeding;
    Scratch *s;
    Seeds *out;
    uint32_t cell, queue_count;
    uint64_t random;
} Source;

/* Looks for the source among the cells of the walk and marks what it sees beyond. Gives whether anything was new. */
static int harvest(Source *from) {
    EnfRegionBake *bake = from->seeding->bake;
    const EnfRegionModel *m = bake->model;
    Scratch *s = from->s;
    EnfWalk *w = &s->walk;
    uint32_t at = ENF_NONE;
    for (uint32_t i = 0; i < w->count && at == ENF_NONE; ++i)
        if (enf_rm_from(m, w->portals[i]) == from->cell)
            at = i;
    if (at == ENF_NONE)
        return 0;
    int news = 0;
    for (uint32_t i = at; i < w->count; ++i) {
        uint32_t cell = m->to[w->portals[i]];
        if (s->mark[cell] == s->stamp)
            continue;
        uint32_t slot = slot_of(bake, from->cell, cell);
        if (slot == ENF_SLOT_HIDDEN)
            continue;
        s->mark[cell] = s->stamp;
        if (slot == ENF_SLOT_OPEN)
            news = 1;
        if (!ENF_RESERVE(s->queue, (uint64_t)from->queue_count + 1)) {
            from->out->failed = 1;
            return 0;
        }
        Frontier *f = &s->queue[from->queue_count++];
        vec_copy(f->p, w->p), vec_copy(f->d, w->d);
        f->t_from = w->t[at], f->t_to = w->t[i];
        f->cell = cell, f->came_by = w->portals[i];
    }
    if (news && enf_line_clearance(m, w->p, w->d, w->portals, w->count) >= m->delta && enf_portals_chain(m, w->portals, w->count))
        if (!enf_found_lines_add(&from->out->lines, bake, bake->table.slots, w->p, w->d, w->portals, w->count))
            from->out->failed = 1;
    return news;
}

/* Follows the line through y on the portal both ways, and harvests what it passes. */
static int walk(Source *from, uint32_t portal, const double y[3], const double d[3]) {
    enf_walk_line(from->seeding->bake->model, portal, y, d, 1, &from->s->walk);
    ++from->out->walked;
    return harvest(from);
}

/* Lines of earlier batches that pass the source are where it starts from. */
static int start_from_known(EnfRegionBake *bake, Scratch *s, uint32_t source, uint32_t *queue_count) {
    const EnfPairTable *table = &bake->table;
    const EnfRegionModel *m = bake->model;
    for (uint64_t b = table->first[source]; b < table->first[source + 1]; ++b)
        for (uint64_t bits = table->bits[b]; bits; bits &= bits - 1) {
            uint32_t cell = table->block[b] * 64 + enf_lowest_bit64(bits);
            uint32_t slot = slot_of(bake, source, cell);
            if (!enf_slot_is_visible(slot) || s->mark[cell] == s->stamp)
                continue;
            const EnfLine *line = &bake->lines.lines[slot - 1];
            const uint32_t *portals = bake->lines.portals + line->portal_first;
            uint32_t at = ENF_NONE, end = ENF_NONE; /* portals leaving the source and entering the cell */
            int backward = 0;
            for (uint32_t i = 0; i < line->portal_count; ++i) {
                if (enf_rm_from(m, portals[i]) == source)
                    at = i;
                if (at != ENF_NONE && m->to[portals[i]] == cell)
                    end = i;
            }
            if (end == ENF_NONE) {
                backward = 1, at = ENF_NONE;
                for (uint32_t i = line->portal_count; i-- > 0;) {
                    if (m->to[portals[i]] == source)
                        at = i;
                    if (at != ENF_NONE && enf_rm_from(m, portals[i]) == cell)
                        end = i;
                }
            }
            if (end == ENF_NONE)
                continue;
            if (!ENF_RESERVE(s->queue, (uint64_t)*queue_count + 1))
                return 0;
            s->mark[cell] = s->stamp;
            Frontier *f = &s->queue[(*queue_count)++];
            vec_copy(f->p, line->p), vec_copy(f->d, line->d);
            double sign = backward ? -1.0 : 1.0;
            vec_scale(f->d, sign, line->d);
            const double *first = m->plane[portals[at]], *last = m->plane[portals[end]];
            f->t_from = sign * (first[3] - vec_dot(first, line->p)) / vec_dot(first, line->d);
            f->t_to = sign * (last[3] - vec_dot(last, line->p)) / vec_dot(last, line->d);
            f->cell = cell, f->came_by = backward ? enf_rm_reverse(portals[end]) : portals[end];
        }
    return 1;
}

/* Straight out by each portal of the source, and from there through each portal of the cell behind. */
static void look_around(Source *from) {
    const EnfRegionModel *m = from->seeding->bake->model;
    for (uint32_t o = m->out_first[from->cell]; o < m->out_first[from->cell + 1] && !from->out->failed; ++o) {
        uint32_t portal = m->out[o], next = m->to[portal];
        if (!enf_rm_count(&m->inner, portal >> 1))
            continue;
        double x[3], y[3], d[3];
        enf_portal_sample(m, portal >> 1, &from->random, x);
        (void)walk(from, portal, x, m->plane[portal]);
        for (uint32_t i = m->out_first[next]; i < m->out_first[next + 1] && !m->dead_end[next]; ++i) {
            uint32_t r = m->out[i];
            if (r == enf_rm_reverse(portal) || !enf_rm_count(&m->inner, r >> 1) || from->s->mark[m->to[r]] == from->s->stamp)
                continue;
            enf_portal_sample(m, portal >> 1, &from->random, x);
            enf_portal_sample(m, r >> 1, &from->random, y);
            vec_sub(d, y, x);
            (void)walk(from, r, y, d);
        }
    }
}

/* Turns the line that reached a cell so that it leaves through portal r: `effort` times, a part of one by chance, or until the cell behind
 * is seen. */
static void aim(Source *from, uint32_t head, uint32_t r) {
    const EnfRegionModel *m = from->seeding->bake->model;
    const Scratch *s = from->s;
    for (double effort = from->seeding->effort; effort > 0 && !from->out->failed; effort -= 1) {
        if (effort < 1 && enf_mix_unit(&from->random) >= effort)
            return;
        const Frontier *f = &s->queue[head];
        double y[3], pivot[3], d[3];
        enf_portal_sample(m, r >> 1, &from->random, y);
        vec_mad(pivot, f->p, f->t_from + enf_mix_unit(&from->random) * (f->t_to - f->t_from), f->d);
        vec_sub(d, y, pivot);
        if (walk(from, r, y, d) && s->mark[m->to[r]] == s->stamp)
            return;
    }
}

static void seed_source(void *context, uint64_t task, uint32_t thread) {
    Seeding *seeding = context;
    EnfRegionBake *bake = seeding->bake;
    const EnfRegionModel *m = bake->model;
    Scratch *s = &seeding->scratch[thread];
    uint32_t source = seeding->sources[task];
    Source from = {seeding, s, &seeding->found[task % BATCH], source, 0, 0};
    from.random = enf_mix64(bake->def.seed * 0x9E3779B97F4A7C15u + source) & ~(uint64_t)0xFFFFFFFF;
    ++s->stamp;
    s->mark[source] = s->stamp;
    if (enf_bake_should_stop(bake))
        return;
    if (!start_from_known(bake, s, source, &from.queue_count))
        from.out->failed = 1;
    look_around(&from);
    for (uint32_t head = 0; head < from.queue_count && !from.out->failed; ++head) {
        uint32_t cell = s->queue[head].cell;
        if (m->dead_end[cell])
            continue;
        for (uint32_t i = m->out_first[cell]; i < m->out_first[cell + 1] && !from.out->failed; ++i) {
            uint32_t r = m->out[i], target = m->to[r];
            if (r == enf_rm_reverse(s->queue[head].came_by) || s->mark[target] == s->stamp || !enf_rm_count(&m->inner, r >> 1))
                continue;
            if (slot_of(bake, source, target) == ENF_SLOT_OPEN)
                aim(&from, head, r);
        }
    }
}

static EnfStatus enter_batch(void *context, uint64_t first, uint64_t end) {
    Seeding *seeding = context;
    EnfRegionBake *bake = seeding->bake;
    for (uint64_t k = 0; k < end - first; ++k) {
        Seeds *seeds = &seeding->found[k];
        if (seeds->failed)
            return enf_fail_memory();
        bake->stats.seed_lines += seeds->walked;
        for (uint32_t i = 0; i < seeds->lines.store.count; ++i) {
            int64_t pairs = enf_found_line_enter(&seeds->lines, i, bake);
            if (pairs < 0)
                return enf_fail_memory();
            bake->stats.seed_pairs += 2 * (uint64_t)pairs;
        }
        enf_found_lines_clear(&seeds->lines);
        seeds->walked = 0; /* a source that is left out, because time is up, leaves it so */
    }
    enf_bake_report(bake, "sightlines", 0.05 + 0.15 * (double)end / seeding->source_count);
    return ENF_OK;
}

EnfStatus enf_seed_sightlines(EnfRegionBake *bake, double effort) {
    uint32_t cells = bake->model->cell_count, threads = bake->stats.threads;
    Seeding seeding = {.bake = bake, .effort = effort};
    EnfStatus status = ENF_OK;
    seeding.sources = ENF_NEW(uint32_t, (uint64_t)cells + 1);
    seeding.scratch = ENF_NEW(Scratch, threads);
    if (!seeding.sources || !seeding.scratch)
        status = enf_fail_memory();
    for (uint32_t t = 0; t < threads && status == ENF_OK; ++t) {
        seeding.scratch[t].mark = ENF_NEW(uint32_t, (uint64_t)cells + 1);
        if (!seeding.scratch[t].mark)
            status = enf_fail_memory();
    }
    if (status == ENF_OK)
        for (uint32_t c = 0; c < cells; ++c)
            if (!bake->wanted || bake->wanted[c])
                seeding.sources[seeding.source_count++] = c;
    if (status == ENF_OK)
        status = enf_run_batches(&(EnfBatches){seeding.source_count, BATCH, 0, threads, seed_source, enter_batch, &seeding});
    for (uint32_t t = 0; t < threads && seeding.scratch; ++t)
        enf_free(seeding.scratch[t].mark), enf_free(seeding.scratch[t].queue);
    for (uint32_t k = 0; k < BATCH; ++k)
        enf_found_lines_free(&seeding.found[k].lines);
    enf_free(seeding.scratch), enf_free(seeding.sources);
    return status;
}
