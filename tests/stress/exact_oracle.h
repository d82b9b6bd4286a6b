/* SPDX-License-Identifier: GPL-3.0-or-later
 * Exact decision whether a straight line passes a chain of convex portals: rational arithmetic throughout, nothing shared with
 * the engine that it judges. */
#ifndef ENF_TESTS_EXACT_ORACLE_H
#define ENF_TESTS_EXACT_ORACLE_H

#include "chain.h"

enum { ORACLE_NONE = 0, ORACLE_STAB = 1, ORACLE_UNKNOWN = 2 };

/* Call once before / after use of the others. */
void oracle_begin(void);
void oracle_end(void);

/* ORACLE_STAB: some line passes strictly inside every portal, in the chain's direction. ORACLE_NONE: none does (a line may still
 * touch edges). ORACLE_UNKNOWN: the bounded search could not tell. */
int oracle_decide(const Chain *chain);

/* Whether the segment passes strictly inside every portal of the chain, in order: exact. */
int oracle_segment_passes(const Chain *chain, const double from[3], const double to[3]);

#endif
