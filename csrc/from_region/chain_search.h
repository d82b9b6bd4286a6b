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
uint32_t enf_chain_test(const EnfRegionModel *model, const EnfChain *chain, EnfStabScratch *scratch,
                        EnfRegionVisStats *stats, double out_p[3], double out_d[3]);

/* ---- Contraction (chain_contract.c) ---- */
/* Narrows the windows of a chain against each other, and splits them where that stalls. `windows` (chain->count of them,
 * followed by room: in all ENF_CONTRACT_LEVELS * chain->count) start as what is known. try_line is asked at each piece and
 * ends the search by giving 1. HIDDEN: every piece came out empty. UNDECIDED: the budget of pieces is spent. */
#define ENF_CONTRACT_LEVELS 24
typedef struct EnfContraction {
    const EnfRegionModel *model;
    const EnfChain *chain;
    EnfWindow *windows;
    double reserve; /* a window that holds no disc of this radius is empty */
    uint32_t budget, pieces;
    int (*try_line)(void *context, const EnfWindow *source, const EnfWindow *target);
    void *context;
} EnfContraction;
uint32_t enf_chain_contract(EnfContraction *contraction);

/* Outer polygons are shrunk by half a touch, so a line that clears the portals by a touch keeps half of it from the edge of
 * each window; roundings down a chain take far less than a tenth. A window too narrow for what is left shows nothing. */
#define ENF_RESERVE_SHARE 0.4

/* Decides the open pairs of the table: methods FLOW and EXACT. */
EnfStatus enf_chain_search(EnfRegionBake *bake);

#endif
