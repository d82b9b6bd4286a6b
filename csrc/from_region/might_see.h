/* SPDX-License-Identifier: GPL-3.0-or-later
 * Might-see sets: for each directed portal a superset of the cells that lines through it can reach. */
#ifndef ENF_FROM_REGION_MIGHT_SEE_H
#define ENF_FROM_REGION_MIGHT_SEE_H

#include "from_region/bake.h"
#include "from_region/separators.h"

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
     * pairs[pair_first[p] + k * count[p]]. Not changed after the floods. */
    uint64_t *pair_first, *pairs, pair_total;
    uint64_t *follow_first, *follow, follow_total; /* follow[follow_first[p] + k]: portals r that can come after p, q (bit: the
                                                    * first 64 that leave to(q)) */
} EnfMightSets;

/* Fills bake->might and, unless it is there already, bake->table: a pair is in the table when each of the two might see the
 * other, as far as known. With bake->wanted only these cells' portals get sets. Where that needs more of the scene than the model
 * holds, it sets bake->outgrown and leaves the rest undone. */
EnfStatus enf_might_see(EnfRegionBake *bake);

/* Takes a cell out of the set of every portal of another: the two are known not to see each other, so no line through a
 * portal of the one (in either direction) reaches the other. */
void enf_might_sets_exclude(EnfMightSets *sets, const EnfRegionModel *model, uint32_t at, uint32_t hidden);
/* Takes one cell out of one portal's set. */
void enf_might_set_exclude(EnfMightSets *sets, uint32_t portal, uint32_t cell);
/* Takes out of the sets of two portals what no third one leads on to, a few times over (might_refine.c). */
void enf_might_sets_refine(EnfMightSets *sets, const EnfRegionModel *model);
void enf_might_sets_destroy(EnfMightSets *sets);

/* The outer polygon of a directed portal, counter-clockwise about its direction; 0 when it has too many corners (the
 * caller must then do without a window: see ENF_WINDOW_MAX). */
int enf_window_load(const EnfRegionModel *model, uint32_t directed, EnfWindow *window);

#endif
