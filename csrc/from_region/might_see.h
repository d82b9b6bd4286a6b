/* SPDX-License-Identifier: GPL-3.0-or-later
 * Might-see sets: for each directed portal a superset of the cells that lines through it can reach. */
#ifndef ENF_FROM_REGION_MIGHT_SEE_H
#define ENF_FROM_REGION_MIGHT_SEE_H

#include "from_region/bake.h"
#include "from_region/separators.h"

#define ENF_MIGHT_ABREAST 4

/* Sparse sets of cells, as 64-bit blocks; the cell a portal leads to is among them. Of portals nobody asked about known == 0: they
 * have no set, and everything may be seen through them. */
typedef struct EnfMightSets {
    uint64_t *first; /* [2 * portals] into block and bits */
    uint32_t *count; /* [2 * portals] blocks */
    uint8_t *known;  /* [2 * portals] */
    uint32_t *block;
    uint64_t *bits;
    uint64_t total;
    EnfChangeLog log; /* of bits, when on */
    /* The same for two portals passed one after the other, q the k-th that leaves to(p): bits beside p's blocks, at
     * pairs[pair_first[p] + k * count[p]]; ENF_MIGHT_ABREAST words behind the last may be read. Not changed after the floods. */
    uint64_t *pair_first, *pairs, pair_total;
    uint64_t *follow_first, *follow, follow_total; /* follow[follow_first[p] + k]: portals r that can come after p, q (bit: the
                                                    * first 64 that leave to(q)) */
} EnfMightSets;

/* Fills bake->might and, unless it is there already, bake->table: a pair is in the table when each of the two might see the
 * other, as far as known. With bake->wanted only these cells' portals get sets. Where that needs more of the scene than the model
 * holds, it sets bake->outgrown and leaves the rest undone. */
EnfStatus enf_might_see(EnfRegionBake *bake);

/* The place of a block among those of the portal's set, ENF_NONE when it isn't there. */
static inline uint32_t enf_might_place(const EnfMightSets *sets, uint32_t portal, uint32_t wanted) {
    uint32_t count = sets->count[portal], low = 0;
    const uint32_t *block = sets->block + sets->first[portal];
    if (!count || wanted < block[0] || wanted > block[count - 1])
        return ENF_NONE;
    if (block[count - 1] - block[0] + 1 == count)
        return wanted - block[0]; /* no gaps: no search */
    for (uint32_t size = count; size > 1;) {
        uint32_t half = size / 2;
        low = block[low + half] <= wanted ? low + half : low;
        size -= half;
    }
    return block[low] == wanted ? low : ENF_NONE;
}

/* What is to be taken out of the sets: numbers of bits, 64 times the place in `bits` and the bit there. */
typedef struct EnfMightBits {
    uint64_t *list;
    uint64_t count;
} EnfMightBits;
void enf_might_sets_exclude(EnfMightSets *sets, const EnfMightBits *which);
/* Takes out of the sets of two portals what no third one leads on to, a few times over (might_refine.c). */
EnfStatus enf_might_sets_refine(EnfMightSets *sets, const EnfRegionModel *model);
void enf_might_sets_destroy(EnfMightSets *sets);

/* The outer polygon of a directed portal, counter-clockwise about its direction; 0 when it has too many corners (the
 * caller must then do without a window: see ENF_WINDOW_MAX). */
int enf_window_load(const EnfRegionModel *model, uint32_t directed, EnfWindow *window);

#endif
