/* SPDX-License-Identifier: GPL-3.0-or-later
 * A chain of portals: what a line of sight has to pass, one polygon after the other. */
#ifndef ENF_TESTS_CHAIN_H
#define ENF_TESTS_CHAIN_H

#include <stdint.h>

enum { CHAIN_MAX_PORTALS = 12, CHAIN_MAX_CORNERS = 16 };

typedef struct ChainPortal {
    uint32_t corner_count;
    double corners[CHAIN_MAX_CORNERS][3]; /* metres; convex; either winding */
    double forward[3];                    /* roughly the direction in which the chain crosses it */
} ChainPortal;

typedef struct Chain {
    uint32_t portal_count;
    ChainPortal portals[CHAIN_MAX_PORTALS];
} Chain;

#endif
