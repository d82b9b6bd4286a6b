/* SPDX-License-Identifier: GPL-3.0-or-later
 * What is known of each pair of cells that might see each other: sparse symmetric rows, one state for an unordered pair.
 *
 * Row i lists the cells it might see as 64-bit blocks. The state of a pair sits in the row of its lower index. Memory
 * follows the number of pairs that might see each other, not the square of the cells. */
#ifndef ENF_FROM_REGION_PAIR_TABLE_H
#define ENF_FROM_REGION_PAIR_TABLE_H

#include "base/bits.h"
#include "enfilade/base.h"

/* States. A line index plus one means: visible by that line. With ENF_SLOT_GRAZING set: grazing by that line. */
#define ENF_SLOT_OPEN      0u
#define ENF_SLOT_HIDDEN    0xFFFFFFFFu
#define ENF_SLOT_FOREIGN   0xFFFFFFFEu /* another block's to decide */
#define ENF_SLOT_UNDECIDED 0xFFFFFFFDu
#define ENF_SLOT_GRAZING   0x80000000u

/* Places that were written, for those who keep copies. */
typedef struct EnfChangeLog {
    uint64_t *places;
    uint64_t count;
    uint8_t on, failed; /* failed: memory ran out, and a place is missing */
} EnfChangeLog;
void enf_log_change(EnfChangeLog *log, uint64_t place);

typedef struct EnfPairTable {
    uint32_t cell_count;
    uint64_t *first;      /* [cells + 1] blocks of each row */
    uint32_t *block;      /* [blocks] index / 64, ascending in a row */
    uint64_t *bits;       /* [blocks] */
    uint32_t *before;     /* [blocks] states of this row before the block */
    uint64_t *slot_first; /* [cells + 1] */
    uint32_t *slots;      /* [pairs i < j] */
    EnfChangeLog log;     /* of slots, when on */
} EnfPairTable;

static inline int enf_slot_is_visible(uint32_t slot) {
    return slot != ENF_SLOT_OPEN && slot < ENF_SLOT_GRAZING;
}
static inline int enf_slot_is_grazing(uint32_t slot) {
    return slot >= ENF_SLOT_GRAZING && slot < ENF_SLOT_UNDECIDED;
}

/* From rows of blocks (each row ascending; block/bits already in place in `table`), symmetric, without the diagonal: counts
 * the pairs and makes their states, all open. Gives 0 when memory runs out. */
int enf_pair_table_finish(EnfPairTable *table);
void enf_pair_table_free(EnfPairTable *table);
/* The rows where every cell might see every other. */
int enf_pair_table_all(EnfPairTable *table, uint32_t cell_count);

/* The state of pair i, j; NULL when they can't see each other (not in the table). */
uint32_t *enf_pair_slot(const EnfPairTable *table, uint32_t i, uint32_t j);
/* Where the states of row i with the cells of its block b above i begin: one after the other, as their bits. */
static inline uint64_t enf_pair_slots_of(const EnfPairTable *table, uint32_t i, uint64_t b) {
    return table->slot_first[i] + table->before[b];
}
/* Writes a state found by enf_pair_slot. */
static inline void enf_pair_set(EnfPairTable *table, uint32_t *slot, uint32_t state) {
    *slot = state;
    if (table->log.on)
        enf_log_change(&table->log, (uint64_t)(slot - table->slots));
}

#endif
