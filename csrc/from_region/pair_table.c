/* SPDX-License-Identifier: GPL-3.0-or-later
 * Sparse symmetric rows of pair states. */
#include "from_region/pair_table.h"

#include <string.h>

#include "base/memory.h"

/* The bits of a block that belong to indices above i. */
static uint64_t above(uint32_t i, uint32_t block) {
    if (block > i >> 6)
        return ~(uint64_t)0;
    if (block < i >> 6)
        return 0;
    return (i & 63) == 63 ? 0 : ~(uint64_t)0 << ((i & 63) + 1);
}

void enf_log_change(EnfChangeLog *log, uint64_t place) {
    if (!ENF_RESERVE(log->places, log->count + 1))
        log->failed = 1;
    else
        log->places[log->count++] = place;
}

int enf_pair_table_finish(EnfPairTable *t) {
    uint64_t blocks = t->first[t->cell_count];
    t->before = ENF_NEW(uint32_t, blocks + 1);
    t->slot_first = ENF_NEW(uint64_t, (uint64_t)t->cell_count + 1);
    if (!t->before || !t->slot_first)
        return 0;
    uint64_t total = 0;
    for (uint32_t i = 0; i < t->cell_count; ++i) {
        uint32_t row = 0;
        t->slot_first[i] = total;
        for (uint64_t b = t->first[i]; b < t->first[i + 1]; ++b) {
            t->before[b] = row;
            row += (uint32_t)enf_popcount64(t->bits[b] & above(i, t->block[b]));
        }
        total += row;
    }
    t->slot_first[t->cell_count] = total;
    t->slots = ENF_NEW(uint32_t, total + 1);
    return t->slots != NULL;
}

int enf_pair_table_all(EnfPairTable *t, uint32_t cell_count) {
    uint64_t words = ((uint64_t)cell_count + 63) / 64, blocks = words * cell_count;
    t->cell_count = cell_count;
    t->first = ENF_NEW(uint64_t, (uint64_t)cell_count + 1);
    t->block = ENF_NEW(uint32_t, blocks + 1);
    t->bits = ENF_NEW(uint64_t, blocks + 1);
    if (!t->first || !t->block || !t->bits)
        return 0;
    for (uint32_t i = 0; i < cell_count; ++i) {
        t->first[i + 1] = (i + 1) * words;
        for (uint64_t w = 0; w < words; ++w) {
            uint64_t bits = ~(uint64_t)0;
            if (w == words - 1 && (cell_count & 63))
                bits >>= 64 - (cell_count & 63);
            if (w == i >> 6)
                bits &= ~((uint64_t)1 << (i & 63));
            t->block[i * words + w] = (uint32_t)w, t->bits[i * words + w] = bits;
        }
    }
    return enf_pair_table_finish(t);
}

void enf_pair_table_free(EnfPairTable *t) {
    enf_free(t->first), enf_free(t->block), enf_free(t->bits), enf_free(t->before), enf_free(t->slot_first);
    enf_free(t->slots), enf_free(t->log.places);
    memset(t, 0, sizeof *t);
}

uint32_t *enf_pair_slot(const EnfPairTable *t, uint32_t i, uint32_t j) {
    if (i > j) {
        uint32_t k = i;
        i = j, j = k;
    }
    uint64_t low = t->first[i], end = t->first[i + 1];
    uint32_t wanted = j >> 6;
    if (low == end || wanted < t->block[low] || wanted > t->block[end - 1])
        return NULL;
    if (t->block[end - 1] - t->block[low] + 1 == end - low)
        low += wanted - t->block[low]; /* no gaps: no search */
    else
        for (uint64_t high = end; high - low > 1;) {
            uint64_t middle = low + (high - low) / 2;
            if (t->block[middle] <= wanted)
                low = middle;
            else
                high = middle;
        }
    if (t->block[low] != wanted)
        return NULL;
    uint64_t bit = (uint64_t)1 << (j & 63), bits = t->bits[low];
    if (!(bits & bit) || i == j)
        return NULL;
    return &t->slots[t->slot_first[i] + t->before[low] + (uint32_t)enf_popcount64(bits & above(i, wanted) & (bit - 1))];
}
