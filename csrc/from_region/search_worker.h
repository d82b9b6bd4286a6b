/* SPDX-License-Identifier: GPL-3.0-or-later
 * One thread's state of the chain search, and the steps its parts share. */
#ifndef ENF_FROM_REGION_SEARCH_WORKER_H
#define ENF_FROM_REGION_SEARCH_WORKER_H

#include <string.h>

#include "from_region/chain_search.h"

/* Cells as bits, words that are zero left out. */
typedef struct EnfTargetWord {
    uint32_t word;  /* local */
    uint32_t place; /* of its block in the might-see set of the portal they are targets of; that has none: anything */
    uint64_t bits;
} EnfTargetWord;
typedef struct EnfTargets {
    uint32_t count;
    EnfTargetWord *list; /* room for all local words */
} EnfTargets;

typedef struct EnfSearchFrame {
    EnfWindow pass; /* of the frame's own portal */
    uint32_t beam;  /* depth of the frame whose source, pass and planes bound the lines beyond: this one, or an earlier one where the
                      * portals since then cut nothing off */
    EnfWindow source;
    EnfHalfspaces planes;
    EnfTargets targets;
} EnfSearchFrame;

typedef struct EnfFinding {
    uint64_t place; /* of the pair in the table's slots */
    uint32_t cell;
    uint32_t state; /* ENF_CHAIN_* */
    uint32_t line;  /* in grazing, for GRAZING */
} EnfFinding;

/* What one source found, looked up so far that entering it is quick. */
typedef struct EnfFound {
    EnfFoundLines lines; /* that clear every portal */
    EnfLineStore grazing;
    EnfFinding *findings;
    uint32_t finding_count;
    EnfMightBits gone; /* what isn't seen through the source's portals */
    EnfRegionVisStats stats;
    uint8_t failed, stopped, capped;
} EnfFound;

/* What a source sees of what others found: copies beside the bake's table and sets (search_order.c). */
typedef struct EnfSearchState {
    uint32_t *slots; /* beside table.slots */
    uint64_t *bits;  /* beside might->bits */
} EnfSearchState;

typedef struct EnfSearchWorker {
    const EnfRegionBake *bake;
    const EnfSearchState *seen;
    const EnfRegionModel *m;
    uint32_t *local;      /* [cells / 64] local word of a block, ENF_NONE outside the source's row */
    uint32_t *word_block; /* [words] the block of a local word */
    uint64_t *open;       /* [words] targets not settled */
    uint64_t *flagged;    /* [words] reached by a chain that could be neither proven nor excluded */
    uint64_t *missed;     /* [words] open when all lines through a portal of the source were followed */
    uint32_t words, word_capacity;
    uint32_t source;
    EnfSearchFrame *frames[ENF_CHAIN_MAX + 2];
    uint32_t chain[ENF_CHAIN_MAX + 2];
    uint8_t *on_chain; /* [cells] convex cells of the chain; [cells + portals] portals of the chain */
    EnfWalk walk;
    EnfStabScratch *stab;
    /* Instead of the chain test at an open cell, when set: gives ENF_CHAIN_HIDDEN to go no further along this chain. */
    uint32_t (*on_reach)(struct EnfSearchWorker *worker, uint32_t count, const EnfWindow *source, const EnfWindow *target);
    void *on_reach_context;
    EnfFound *out;
    uint64_t chains, cap;
    int stop;
} EnfSearchWorker;

void enf_found_free(EnfFound *found);
int enf_search_worker_create(EnfSearchWorker *worker, const EnfRegionBake *bake, uint32_t widest);
void enf_search_worker_free(EnfSearchWorker *worker);
/* No longer a target of the source at hand. */
void enf_search_close_target(EnfSearchWorker *worker, uint32_t cell);
/* Decides the open pairs of a source with cells of higher rank. */
void enf_search_source(EnfSearchWorker *worker, uint32_t source, const uint32_t *rank, const EnfSearchState *seen, EnfFound *out);

/* ---- Targets (search_targets.c) ---- */
/* The open cells that the portal of a source might see. All of these give the number of words left. */
uint32_t enf_targets_from(const EnfSearchWorker *worker, uint32_t portal, EnfTargets *targets);
/* Those of `before` (of portal `last`) that might be seen through r, the k-th portal that leaves its cell, and are still open. */
uint32_t enf_targets_through(const EnfSearchWorker *worker, uint32_t last, uint32_t k, uint32_t r, const EnfTargets *before,
                             EnfTargets *targets);
/* Drops the targets that no line through the two portals and within the planes enters: portal by portal. */
uint32_t enf_targets_drop(EnfSearchWorker *worker, const EnfHalfspaces *planes, uint32_t first_portal, uint32_t last, EnfTargets *targets);
/* Keeps those in a row of local words. */
uint32_t enf_targets_keep(EnfTargets *targets, const uint64_t *words);

/* Where few targets are left: adds the planes of the shaft from the source's window to the portals by which the targets are
 * entered. What lines to them pass lies in it. */
void enf_aim(const EnfSearchWorker *worker, EnfSearchFrame *frame, uint32_t first_portal, uint32_t last);

/* ---- Windows (search_step.c) ---- */
/* The window of portal r that lines through (source, pass of portal `last`, planes found for the two; cutting: those that may cut r)
 * can reach, and what is left of the source for them; first_portal: the portal of the source; pass NULL: r is the second portal of the chain. A
 * window with count 0 stands for "not known". ENF_STEP_EMPTY: no line gets through. ENF_STEP_SAME: all lines that the planes let
 * come, pass: nothing new is known beyond, out_source isn't written. */
enum { ENF_STEP_EMPTY = 0, ENF_STEP_NARROWED = 1, ENF_STEP_SAME = 2 };
int enf_window_step(const EnfSearchWorker *worker, uint32_t first_portal, uint32_t last, const EnfWindow *source, const EnfWindow *pass,
                    const EnfHalfspaces *planes, uint64_t cutting, uint32_t r, EnfWindow *out_source, EnfWindow *out_pass);
/* Whether portal r faces against one entered before (chain[0 .. depth]): no line crosses both forward. */
int enf_turns_back(const EnfSearchWorker *worker, uint32_t depth, uint32_t r);
/* The planes that bound what is seen beyond portal `last`. */
void enf_window_planes(const EnfSearchWorker *worker, uint32_t first_portal, uint32_t last, const EnfWindow *source, const EnfWindow *pass,
                       EnfHalfspaces *planes);

#endif
