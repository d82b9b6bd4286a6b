/* SPDX-License-Identifier: GPL-3.0-or-later
 * The search along chains of portals for the pairs still open in the table. */
#ifndef ENF_FROM_REGION_CHAIN_SEARCH_H
#define ENF_FROM_REGION_CHAIN_SEARCH_H

#include "from_region/bake.h"
#include "from_region/might_see.h"
#include "from_region/separators.h"

/* Longest chain followed; what lies beyond is left undecided. */
#define ENF_CHAIN_MAX 250

/* A chain that reached an open cell, as the stabbing tests see it. */
typedef struct EnfChain {
    const uint32_t *portals;
    uint32_t count;
    const EnfWindow *source; /* what is left of the first portal's window: lines of the chain pass there */
    const EnfWindow *target; /* the same of the last portal; NULL when count is 1 */
} EnfChain;

enum { ENF_CHAIN_HIDDEN = 0, ENF_CHAIN_VISIBLE = 1, ENF_CHAIN_GRAZING = 2, ENF_CHAIN_UNDECIDED = 3 };

/* Scratch memory of the stabbing tests, one a thread. */
typedef struct EnfStabScratch EnfStabScratch;
EnfStabScratch *enf_stab_scratch_create(void);
void enf_stab_scratch_destroy(EnfStabScratch *scratch);

/* Whether a line passes the whole chain. VISIBLE: through the inner polygons, the line in out_p, out_d (checked). GRAZING: only
 * through outer polygons, the line in out_p, out_d. HIDDEN: certified for the outer polygons. */
uint32_t enf_chain_test(const EnfRegionModel *model, const EnfChain *chain, EnfStabScratch *scratch, EnfRegionVisStats *stats,
                        double out_p[3], double out_d[3]);

/* Whether the windows of the whole chain, contracted, say HIDDEN; if not, out_p, out_d: a guess, from the middle of what is left of
 * the first to that of the last. Needs no inner polygons. */
int enf_chain_is_shut(const EnfRegionModel *model, const EnfChain *chain, EnfStabScratch *scratch, double out_p[3], double out_d[3]);

/* Narrows the windows of a chain (chain->count of them, as known so far) against each other. 0: no line passes. */
int enf_chain_contract(const EnfRegionModel *model, const EnfChain *chain, EnfWindow *windows);
/* The same from whole windows, each by the planes of every two before it and behind it: finds nearly all that is left, at the cube of the
 * chain's length; still far less than the stabbing cone. */
int enf_chain_contract_pairs(const EnfRegionModel *model, const EnfChain *chain, EnfWindow *windows);

/* Decides the open pairs of the table: methods FLOW and EXACT. */
EnfStatus enf_chain_search(EnfRegionBake *bake);

#endif
