/* SPDX-License-Identifier: GPL-3.0-or-later
 * Might-see sets by floods through two-portal frusta.
 *
 * For a portal p and each portal q by which a line can leave the cell behind p, the separating planes of p and q bound
 * everything beyond q; the flood goes on through portals that touch this region and can be crossed the right way round.
 * Superset by construction: a line through p leaves by some q, and then every portal it passes meets all these tests. */
#include "from_region/might_see.h"

#include <stdlib.h>
#include <string.h>

#include "base/batches.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/sort_keys.h"
#include "geometry/vec3.h"

#define BATCH 32 /* cells */

typedef struct CellSets {
    uint32_t *block;
    uint64_t *bits;
    uint32_t *count; /* blocks of each outgoing portal */
    uint32_t total;
    uint64_t *pairs, *follow; /* as in EnfMightSets, portal after portal */
    uint64_t pair_total, follow_total;
    uint8_t failed;
} CellSets;

typedef struct Scratch {
    uint32_t *mark, stamp;            /* [cells] visited in this flood */
    uint64_t *words;                  /* [cells / 64] the set being built */
    uint32_t *fresh;                  /* places of portals to be tested */
    uint32_t *touched, touched_count; /* its non-zero words */
    uint32_t *cells;                  /* those of each pair's flood, one after the other */
    uint32_t cell_total;
    uint32_t *ends;
    uint32_t *place; /* [cells / 64] index of a word among `touched`, once sorted */
} Scratch;

typedef struct Flooding {
    EnfRegionBake *bake;
    Scratch *scratch;
    uint32_t *cells; /* [cell_count] to be flooded */
    uint32_t cell_count;
    CellSets *sets; /* [2 * BATCH] */
} Flooding;

int enf_window_load(const EnfRegionModel *m, uint32_t directed, EnfWindow *window) {
    uint32_t first = m->outer.first[directed >> 1], count = enf_rm_count(&m->outer, directed >> 1);
    if (count > ENF_WINDOW_MAX - 4) { /* room to clip */
        window->count = 0;
        return 0;
    }
    window->count = count, window->own = ((uint32_t)1 << count) - 1;
    for (uint32_t i = 0; i < count; ++i)
        enf_window_put(window, i, m->outer.vertices[first + (directed & 1 ? count - 1 - i : i)]);
    enf_window_wrap(window);
    return 1;
}

static void add_cell(Scratch *s, uint32_t cell) {
    uint64_t *word = &s->words[cell >> 6];
    if (!*word)
        s->touched[s->touched_count++] = cell >> 6;
    *word |= (uint64_t)1 << (cell & 63);
}

/* Adds to s->fresh the portals that leave the cell, faced by p and q, for cells not visited yet. Gives how many there are then. What comes
 * of a test moves an index, here and in the flood, it doesn't branch: nobody can foretell it. */
static inline uint32_t add_fresh(const EnfRegionModel *m, Scratch *s, uint32_t cell, uint32_t p, uint32_t q, uint32_t count) {
    uint32_t first = m->out_first[cell], end = m->dead_end[cell] ? first : m->out_first[cell + 1];
    uint32_t back_p = m->way[p] ^ 1, back_q = m->way[q] ^ 1;
    for (uint32_t at = first; at < end; at += 64) {
        uint32_t size = end - at < 64 ? end - at : 64;
        const EnfPlaneGroup *groups = m->groups + m->group_first[cell] + (at - first) / ENF_GROUP;
        uint64_t facing = m->kernel->facing(groups, size, 1, m->box[p >> 1], m->box[q >> 1]);
        for (uint32_t i = at; i < at + size; ++i, facing >>= 1) {
            s->fresh[count] = i;
            count += (uint32_t)(facing & 1) & (s->mark[m->out_to[i]] != s->stamp) & (m->out_way[i] != back_p) & (m->out_way[i] != back_q);
        }
    }
    return count;
}

/* From the cell behind q through all that lines through p and q can pass. */
static void flood(const EnfRegionModel *m, Scratch *s, uint32_t p, uint32_t q, const EnfHalfspaces *planes) {
    uint32_t *cells = s->cells + s->cell_total, head = 0, tail = 0;
    ++s->stamp;
    if (m->convex[enf_rm_from(m, p)])
        s->mark[enf_rm_from(m, p)] = s->stamp; /* a line doesn't come back to them */
    if (m->convex[m->to[p]])
        s->mark[m->to[p]] = s->stamp;
    s->mark[m->to[q]] = s->stamp;
    cells[tail++] = m->to[q];
    while (head < tail) {
        uint32_t count = 0;
        while (head < tail && count < 64) {
            uint32_t cell = cells[head++];
            add_cell(s, cell);
            count = add_fresh(m, s, cell, p, q, count);
        }
        for (uint32_t from = 0; from < count; from += 64) {
            uint32_t size = count - from < 64 ? count - from : 64;
            uint64_t touching = m->kernel->touching(planes, (const float(*)[6])m->out_box, s->fresh + from, size);
            for (uint32_t i = from; i < from + size; ++i, touching >>= 1) {
                uint32_t next = m->out_to[s->fresh[i]], seen = s->mark[next], enters = (uint32_t)(touching & 1) & (seen != s->stamp);
                cells[tail] = next;
                tail += enters;
                s->mark[next] = enters ? s->stamp : seen;
            }
        }
    }
    s->cell_total += tail;
}

/* The portals that can come after p and q, as far as the planes of the two tell. */
static uint64_t portals_that_follow(const EnfRegionModel *m, uint32_t p, uint32_t q, const EnfHalfspaces *planes) {
    uint32_t cell = m->to[q], count = m->out_first[cell + 1] - m->out_first[cell];
    uint64_t follow = 0;
    for (uint64_t ways = count ? enf_rm_ways(m, planes, cell, 0, 1, p, q) : 0; ways; ways &= ways - 1) {
        uint32_t r = m->out[m->out_first[cell] + enf_lowest_bit64(ways)];
        if (r != enf_rm_reverse(q) && !enf_rm_turns_back(m, p, r) && !enf_rm_turns_back(m, q, r))
            follow |= ways & (~ways + 1);
    }
    return follow;
}

/* Floods from p through each q. ends[k]: end of the k-th flood in s->cells; follow[k]. */
static int flood_portal(const EnfRegionModel *m, Scratch *s, uint32_t p, uint32_t *ends, uint64_t *follow) {
    EnfWindow source, pass, cut;
    EnfHalfspaces planes;
    uint32_t first = m->out_first[m->to[p]], portals = m->out_first[m->to[p] + 1] - first;
    int has_source = enf_window_load(m, p, &source);
    s->cell_total = 0;
    memset(follow, 0, portals * sizeof *follow), memset(ends, 0, portals * sizeof *ends);
    add_cell(s, m->to[p]);
    if (m->dead_end[m->to[p]])
        return 1;
    for (uint32_t k = 0; k < portals; ++k) {
        uint32_t q = m->out[first + k];
        ends[k] = s->cell_total;
        if (q == enf_rm_reverse(p) || enf_rm_turns_back(m, p, q))
            continue;
        const double *from = m->plane[p], *at = m->plane[q];
        planes.count = 0;
        enf_halfspaces_add(&planes, from[0], from[1], from[2], from[3]), enf_halfspaces_add(&planes, at[0], at[1], at[2], at[3]);
        if (has_source && enf_window_load(m, q, &pass)) {
            const EnfWindow *seen_from = &source;
            if (!m->convex[m->to[p]]) { /* else each lies wholly on the right side of the other */
                double behind[4] = {-at[0], -at[1], -at[2], -at[3] - m->order_slack};
                double front[4] = {from[0], from[1], from[2], from[3] - m->order_slack};
                int clipped = 0;
                enf_window_copy(&cut, &source);
                if (!m->kernel->clip(&pass, front, &clipped) || !m->kernel->clip(&cut, behind, &clipped))
                    continue;
                seen_from = &cut;
            }
            (void)m->kernel->separators(seen_from, from, &pass, at, 1, &planes);
        }
        m->kernel->round(&planes, 0);
        if (!ENF_RESERVE(s->cells, (uint64_t)s->cell_total + m->cell_count + 1))
            return 0;
        flood(m, s, p, q, &planes);
        follow[k] = portals_that_follow(m, p, q, &planes);
        ends[k] = s->cell_total;
    }
    return 1;
}

static void flood_cell(void *context, uint64_t task, uint32_t thread) {
    Flooding *f = context;
    const EnfRegionModel *m = f->bake->model;
    Scratch *s = &f->scratch[thread];
    CellSets *out = &f->sets[task % (2 * BATCH)];
    uint32_t cell = f->cells[task], portals = m->out_first[cell + 1] - m->out_first[cell];
    out->total = 0, out->pair_total = out->follow_total = 0, out->failed = 0;
    if (!ENF_RESERVE(out->count, (uint64_t)portals + 1)) {
        out->failed = 1;
        return;
    }
    for (uint32_t i = 0; i < portals; ++i) {
        uint32_t p = m->out[m->out_first[cell] + i], pairs = m->out_first[m->to[p] + 1] - m->out_first[m->to[p]];
        s->touched_count = 0;
        if (!ENF_RESERVE(s->ends, (uint64_t)pairs + 1) || !ENF_RESERVE(out->follow, out->follow_total + pairs + 1) ||
            !flood_portal(m, s, p, s->ends, out->follow + out->follow_total))
            out->failed = 1;
        qsort(s->touched, s->touched_count, sizeof *s->touched, compare_indices);
        uint64_t words = (uint64_t)pairs * s->touched_count;
        if (out->failed || !ENF_RESERVE(out->block, (uint64_t)out->total + s->touched_count) ||
            !ENF_RESERVE(out->bits, (uint64_t)out->total + s->touched_count) || !ENF_RESERVE(out->pairs, out->pair_total + words + 1))
            out->failed = 1;
        for (uint32_t k = 0; k < s->touched_count; ++k) {
            uint32_t w = s->touched[k];
            s->place[w] = k;
            if (!out->failed)
                out->block[out->total + k] = w, out->bits[out->total + k] = s->words[w];
            s->words[w] = 0;
        }
        if (out->failed)
            return;
        uint64_t *pair_bits = out->pairs + out->pair_total;
        memset(pair_bits, 0, words * sizeof *pair_bits);
        for (uint32_t k = 0, c = 0; k < pairs; ++k)
            for (; c < s->ends[k]; ++c)
                pair_bits[(uint64_t)k * s->touched_count + s->place[s->cells[c] >> 6]] |= (uint64_t)1 << (s->cells[c] & 63);
        out->total += s->touched_count, out->pair_total += words, out->follow_total += pairs;
        out->count[i] = s->touched_count;
    }
}

void enf_might_sets_exclude(EnfMightSets *sets, const EnfMightBits *which) {
    for (uint64_t i = 0; i < which->count; ++i) {
        uint64_t block = which->list[i] >> 6, bit = (uint64_t)1 << (which->list[i] & 63);
        if (!(sets->bits[block] & bit))
            continue;
        sets->bits[block] &= ~bit;
        if (sets->log.on)
            enf_log_change(&sets->log, block);
    }
}

void enf_might_sets_destroy(EnfMightSets *sets) {
    if (!sets)
        return;
    enf_free(sets->first), enf_free(sets->count), enf_free(sets->known), enf_free(sets->block), enf_free(sets->bits);
    enf_free(sets->pair_first), enf_free(sets->pairs), enf_free(sets->follow_first), enf_free(sets->follow);
    enf_free(sets->log.places), enf_free(sets);
}

/* Adds the sets of one cell's portals to all. */
static EnfStatus append_sets(EnfMightSets *sets, const EnfRegionModel *m, uint32_t cell, const CellSets *done) {
    if (done->failed || !ENF_RESERVE(sets->block, sets->total + done->total) || !ENF_RESERVE(sets->bits, sets->total + done->total) ||
        !ENF_RESERVE(sets->pairs, sets->pair_total + done->pair_total + ENF_MIGHT_ABREAST) ||
        !ENF_RESERVE(sets->follow, sets->follow_total + done->follow_total + 1))
        return enf_fail_memory();
    if (done->total) { /* a cell that sees nothing has no block, and memcpy takes no NULL even for nothing */
        memcpy(sets->block + sets->total, done->block, done->total * sizeof *done->block);
        memcpy(sets->bits + sets->total, done->bits, done->total * sizeof *done->bits);
    }
    if (done->pair_total)
        memcpy(sets->pairs + sets->pair_total, done->pairs, done->pair_total * sizeof *done->pairs);
    if (done->follow_total)
        memcpy(sets->follow + sets->follow_total, done->follow, done->follow_total * sizeof *done->follow);
    for (uint32_t i = m->out_first[cell]; i < m->out_first[cell + 1]; ++i) {
        uint32_t p = m->out[i], blocks = done->count[i - m->out_first[cell]], pairs = m->out_first[m->to[p] + 1] - m->out_first[m->to[p]];
        sets->first[p] = sets->total, sets->count[p] = blocks, sets->known[p] = 1;
        sets->pair_first[p] = sets->pair_total, sets->follow_first[p] = sets->follow_total;
        sets->total += blocks, sets->pair_total += (uint64_t)pairs * blocks, sets->follow_total += pairs;
    }
    return ENF_OK;
}

static EnfStatus append_batch(void *context, uint64_t first, uint64_t end) {
    Flooding *f = context;
    EnfRegionBake *bake = f->bake;
    EnfStatus status = ENF_OK;
    for (uint64_t at = first; at < end && status == ENF_OK; ++at)
        status = append_sets(bake->might, bake->model, f->cells[at], &f->sets[at % (2 * BATCH)]);
    enf_bake_report(bake, "might-see sets", 0.05 * (double)end / f->cell_count);
    return status;
}

/* One row: the union over the outgoing portals of the cell, without itself. */
static EnfStatus append_row(EnfRegionBake *bake, Scratch *s, uint32_t cell, uint64_t *total) {
    const EnfRegionModel *m = bake->model;
    const EnfMightSets *sets = bake->might;
    EnfPairTable *table = &bake->table;
    s->touched_count = 0;
    for (uint32_t i = m->out_first[cell]; i < m->out_first[cell + 1]; ++i) {
        uint32_t p = m->out[i];
        for (uint32_t k = 0; k < sets->count[p]; ++k) {
            uint32_t w = sets->block[sets->first[p] + k];
            uint64_t bits = sets->bits[sets->first[p] + k];
            if (!bits)
                continue;
            if (!s->words[w])
                s->touched[s->touched_count++] = w;
            s->words[w] |= bits;
        }
    }
    s->words[cell >> 6] &= ~((uint64_t)1 << (cell & 63));
    qsort(s->touched, s->touched_count, sizeof *s->touched, compare_indices);
    if (!ENF_RESERVE(table->block, *total + s->touched_count + 1) || !ENF_RESERVE(table->bits, *total + s->touched_count + 1))
        return enf_fail_memory();
    for (uint32_t k = 0; k < s->touched_count; ++k) {
        uint32_t w = s->touched[k];
        if (s->words[w])
            table->block[*total] = w, table->bits[*total] = s->words[w], ++*total;
        s->words[w] = 0;
    }
    return ENF_OK;
}

static int row_has(const EnfPairTable *t, uint32_t i, uint32_t j) {
    uint64_t low = t->first[i], high = t->first[i + 1];
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        if (t->block[middle] < j >> 6)
            low = middle + 1;
        else
            high = middle;
    }
    return low < t->first[i + 1] && t->block[low] == j >> 6 && (t->bits[low] >> (j & 63) & 1);
}

/* Keeps i, j only when both rows have it; of cells that weren't flooded it takes one row's word. */
static void symmetrise(EnfPairTable *t, const uint8_t *wanted) {
    for (uint32_t i = 0; i < t->cell_count; ++i)
        for (uint64_t b = t->first[i]; b < t->first[i + 1]; ++b)
            for (uint64_t bits = t->bits[b]; bits; bits &= bits - 1) {
                uint32_t j = t->block[b] * 64 + enf_lowest_bit64(bits);
                if ((!wanted || wanted[j]) && !row_has(t, j, i))
                    t->bits[b] &= ~((uint64_t)1 << (j & 63));
            }
}

/* Which rows have each cell that wasn't flooded, cell after cell, ascending: for rows are gone through in order. end: [cells + 1], zeroed,
 * gets where each cell's rows end. NULL: out of memory. */
static uint32_t *list_columns(const EnfPairTable *t, const uint8_t *wanted, uint64_t *end) {
    uint32_t *list = NULL;
    uint64_t total = 0;
    for (int fill = 0; fill < 2; ++fill) {
        for (uint32_t i = 0; i < t->cell_count; ++i)
            for (uint64_t b = t->first[i]; b < t->first[i + 1]; ++b)
                for (uint64_t word = t->bits[b]; word; word &= word - 1) {
                    uint32_t j = t->block[b] * 64 + enf_lowest_bit64(word);
                    if (wanted[j])
                        continue;
                    if (fill)
                        list[end[j]] = i;
                    ++end[j];
                }
        for (uint32_t j = 0; j < t->cell_count && !fill; ++j) {
            uint64_t size = end[j];
            end[j] = total, total += size;
        }
        if (!fill && !(list = enf_alloc((total + 1) * sizeof *list)))
            return NULL;
    }
    end[t->cell_count] = total;
    return list;
}

/* Rows of the cells that weren't flooded, read off the others' columns; between them. */
static EnfStatus add_columns(EnfPairTable *t, const uint8_t *wanted) {
    uint32_t n = t->cell_count, *block = NULL;
    uint64_t *end = ENF_NEW(uint64_t, (uint64_t)n + 1), *first = ENF_NEW(uint64_t, (uint64_t)n + 1), *bits = NULL, blocks = 0;
    uint32_t *list = end && first ? list_columns(t, wanted, end) : NULL;
    if (!list || !ENF_RESERVE(block, t->first[n] + end[n] + 1) || !ENF_RESERVE(bits, t->first[n] + end[n] + 1)) {
        enf_free(end), enf_free(first), enf_free(list), enf_free(block);
        return enf_fail_memory();
    }
    for (uint32_t j = 0; j < n; ++j) {
        first[j] = blocks;
        for (uint64_t b = t->first[j]; b < t->first[j + 1]; ++b)
            block[blocks] = t->block[b], bits[blocks++] = t->bits[b];
        for (uint64_t k = j ? end[j - 1] : 0; k < end[j]; ++k) {
            if (blocks == first[j] || block[blocks - 1] != list[k] >> 6)
                block[blocks] = list[k] >> 6, bits[blocks++] = 0;
            bits[blocks - 1] |= (uint64_t)1 << (list[k] & 63);
        }
    }
    first[n] = blocks;
    enf_free(list), enf_free(end), enf_free(t->first), enf_free(t->block), enf_free(t->bits);
    t->first = first, t->block = block, t->bits = bits;
    return ENF_OK;
}

/* The rows of the table from the sets of all cells flooded. */
static EnfStatus make_rows(EnfRegionBake *bake, Scratch *s) {
    EnfPairTable *t = &bake->table;
    uint32_t n = bake->model->cell_count;
    uint64_t total = 0;
    t->cell_count = n;
    t->first = ENF_NEW(uint64_t, (uint64_t)n + 1);
    EnfStatus status = t->first ? ENF_OK : enf_fail_memory();
    for (uint32_t c = 0; c < n && status == ENF_OK; ++c) {
        t->first[c] = total;
        if (!bake->wanted || bake->wanted[c])
            status = append_row(bake, s, c, &total);
    }
    if (status != ENF_OK)
        return status;
    t->first[n] = total;
    symmetrise(t, bake->wanted);
    if (bake->wanted)
        status = add_columns(t, bake->wanted);
    return status != ENF_OK ? status : enf_pair_table_finish(t) ? ENF_OK : enf_fail_memory();
}

/* Notes which cells at the rim of the model the floods have reached. */
static EnfStatus look_at_rim(EnfRegionBake *bake) {
    const EnfRegionModel *m = bake->model;
    const EnfMightSets *sets = bake->might;
    uint8_t *noted = ENF_NEW(uint8_t, (uint64_t)m->cell_count + 1);
    EnfStatus status = noted ? ENF_OK : enf_fail_memory();
    for (uint64_t b = 0; b < sets->total && status == ENF_OK; ++b)
        for (uint64_t bits = sets->bits[b]; bits && status == ENF_OK; bits &= bits - 1) {
            uint32_t c = sets->block[b] * 64 + enf_lowest_bit64(bits);
            if (!m->rim[c] || noted[c])
                continue;
            noted[c] = 1;
            if (!ENF_RESERVE(bake->outgrown, (uint64_t)bake->outgrown_count + 1))
                status = enf_fail_memory();
            else
                bake->outgrown[bake->outgrown_count++] = c;
        }
    enf_free(noted);
    return status;
}

/* Floods the cells wanted. What lies beyond is known only as what these might see: flooding that as well would double what blocks cost,
 * for a tenth of the search. */
static EnfStatus flood_all(Flooding *f) {
    EnfRegionBake *bake = f->bake;
    uint32_t n = bake->model->cell_count;
    f->cells = ENF_NEW(uint32_t, (uint64_t)n + 1);
    EnfStatus status = f->cells ? ENF_OK : enf_fail_memory();
    for (uint32_t c = 0; c < n && status == ENF_OK; ++c)
        if (!bake->wanted || bake->wanted[c])
            f->cells[f->cell_count++] = c;
    if (status == ENF_OK)
        status = enf_run_batches(&(EnfBatches){f->cell_count, BATCH, 1, bake->stats.threads, flood_cell, append_batch, f});
    if (status == ENF_OK && bake->model->rim)
        status = look_at_rim(bake);
    enf_free(f->cells);
    return status;
}

EnfStatus enf_might_see(EnfRegionBake *bake) {
    const EnfRegionModel *m = bake->model;
    uint32_t n = m->cell_count, threads = bake->stats.threads, words = n / 64 + 1;
    uint32_t widest = 1; /* portals of a cell */
    for (uint32_t c = 0; c < n; ++c)
        widest = m->out_first[c + 1] - m->out_first[c] > widest ? m->out_first[c + 1] - m->out_first[c] : widest;
    uint64_t directed = 2 * (uint64_t)m->portal_count;
    Flooding f = {.bake = bake};
    EnfMightSets *sets = ENF_NEW(EnfMightSets, 1);
    bake->might = sets;
    if (sets) {
        sets->first = ENF_NEW(uint64_t, directed + 1);
        sets->count = ENF_NEW(uint32_t, directed + 1);
        sets->known = ENF_NEW(uint8_t, directed + 1);
        sets->pair_first = ENF_NEW(uint64_t, directed + 1);
        sets->follow_first = ENF_NEW(uint64_t, directed + 1);
    }
    f.scratch = ENF_NEW(Scratch, threads);
    f.sets = ENF_NEW(CellSets, 2 * BATCH);
    EnfStatus status = ENF_OK;
    if (!sets || !sets->first || !sets->count || !sets->known || !sets->pair_first || !sets->follow_first || !f.scratch || !f.sets)
        status = enf_fail_memory();
    for (uint32_t t = 0; t < threads && status == ENF_OK; ++t) {
        Scratch *s = &f.scratch[t];
        s->mark = ENF_NEW(uint32_t, (uint64_t)n + 1);
        s->fresh = ENF_NEW(uint32_t, (uint64_t)widest + 64);
        s->words = ENF_NEW(uint64_t, words);
        s->touched = ENF_NEW(uint32_t, words);
        s->place = ENF_NEW(uint32_t, words);
        if (!s->mark || !s->fresh || !s->words || !s->touched || !s->place)
            status = enf_fail_memory();
    }
    if (status == ENF_OK)
        status = flood_all(&f);
    if (status == ENF_OK && !bake->outgrown_count)
        status = enf_might_sets_refine(sets, m);
    if (status == ENF_OK && !bake->outgrown_count && !bake->table.slots)
        status = make_rows(bake, &f.scratch[0]);
    for (uint32_t t = 0; t < threads && f.scratch; ++t) {
        Scratch *s = &f.scratch[t];
        enf_free(s->mark), enf_free(s->fresh), enf_free(s->words), enf_free(s->touched), enf_free(s->place);
        enf_free(s->ends), enf_free(s->cells);
    }
    for (uint32_t k = 0; k < 2 * BATCH && f.sets; ++k)
        enf_free(f.sets[k].block), enf_free(f.sets[k].bits), enf_free(f.sets[k].count), enf_free(f.sets[k].pairs),
            enf_free(f.sets[k].follow);
    enf_free(f.scratch), enf_free(f.sets);
    return status;
}
