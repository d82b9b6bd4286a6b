/* SPDX-License-Identifier: GPL-3.0-or-later
 * One chain of portals, asked directly: does any straight line pass them all, in this order? No scene, no bake.
 *
 * The answer is the same as a bake's for cells in a row with these portals (statuses and guarantees: region_vis.h), with the
 * chain's own extent as the scene's. */
#ifndef ENFILADE_CHAIN_QUERY_H
#define ENFILADE_CHAIN_QUERY_H

#include "enfilade/region_vis.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Memory that stays from query to query. One thread at a time may use one; any number may exist. */
typedef struct EnfChainQuery EnfChainQuery;

/* What shows the answer. */
enum {
    ENF_SHOWN_BY_NOTHING = 0, /* UNDECIDED */
    ENF_SHOWN_BY_LINE = 1,    /* a witness guessed: VISIBLE */
    ENF_SHOWN_BY_WINDOWS = 2, /* the portals clip each other away: HIDDEN */
    ENF_SHOWN_BY_CONE = 3     /* the stabbing cone: a witness (VISIBLE, GRAZING), or proof that there is none (HIDDEN) */
};

typedef struct EnfChainAnswer {
    uint32_t struct_size;
    uint32_t status;      /* ENF_PAIR_* */
    uint32_t shown_by;    /* ENF_SHOWN_BY_* */
    uint32_t exact_signs; /* signs of the cone that only exact arithmetic could tell; 0: none was needed */
    double segment[6];    /* VISIBLE, GRAZING: from just before the first portal to just behind the last, metres */
    double clearance;     /* of that line, metres; see enf_region_vis_witness */
    double delta;         /* the clearance asked for, as used, metres */
} EnfChainAnswer;
ENF_API EnfChainAnswer enf_default_chain_answer(void);

/* The caller destroys it. ENF_ERROR_OUT_OF_MEMORY. Thread-safe. */
ENF_API EnfStatus enf_chain_query_create(EnfChainQuery **out_query);
ENF_API void enf_chain_query_destroy(EnfChainQuery *query); /* NULL is fine */

/* vertices: double[3] each, metres, the corners of portal 0, then of portal 1, ...; corner_counts: [portal_count]. A portal is
 * convex and planar (else its hull, and as much larger as it strays), its corners run counter-clockwise about the way the
 * line goes: their normal by the right-hand rule points on along the chain. clearance: metres, <= 0: 2.5e-7 of the extent.
 * 1 to 250 portals. ENF_ERROR_INVALID_ARGUMENT names the portal that has no area, no plane or no number. Thread-safe on
 * different queries. */
ENF_API EnfStatus enf_chain_query(EnfChainQuery *query, const double *vertices, const uint32_t *corner_counts, uint32_t portal_count,
                                  double clearance, EnfChainAnswer *out_answer);

#ifdef __cplusplus
}
#endif
#endif
