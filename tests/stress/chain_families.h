/* SPDX-License-Identifier: GPL-3.0-or-later
 * Generated families of portal chains, each about one numerical difficulty, and the motions that must not change an answer. */
#ifndef ENF_TESTS_CHAIN_FAMILIES_H
#define ENF_TESTS_CHAIN_FAMILIES_H

#include "chain.h"
#include "stress_random.h"

typedef struct ChainFamily {
    const char *name;
    int degenerate; /* coincidences on purpose: shared planes, collinear or common edges, near-coplanar portals */
    void (*make)(Random *random, Chain *out);
} ChainFamily;

extern const ChainFamily chain_families[];
extern const uint32_t chain_family_count;

/* Motions and rewritings that leave the answer alone (up to the clearance). */
enum { VARIANT_ROTATE, VARIANT_FAR, VARIANT_SCALE, VARIANT_REVERSE, VARIANT_REWIND, VARIANT_SPLIT, VARIANT_COUNT };
extern const char *const chain_variant_names[VARIANT_COUNT];
/* VARIANT_SPLIT puts a window-sized portal between two others (a cell cut in two by a plane). Returns 0 when the chain is too long for it. */
int chain_vary(uint32_t variant, Random *random, const Chain *chain, Chain *out);

#endif
