/* SPDX-License-Identifier: GPL-3.0-or-later
 * A bake in progress: what its stages share. */
#ifndef ENF_FROM_REGION_BAKE_H
#define ENF_FROM_REGION_BAKE_H

#include "base/job_control.h"
#include "enfilade/region_vis.h"
#include "from_region/pair_table.h"
#include "from_region/region_model.h"
#include "from_region/sightline.h"

/* The pairs decided by one block, and the lines that show them: what a state file keeps. Unordered pairs that are not hidden,
 * each once; `state` as in the pair table, lines counted in this answer. */
typedef struct EnfBlockAnswer {
    uint32_t done; /* 0: not computed */
    uint32_t pair_count;
    uint32_t (*pairs)[3]; /* [pair_count] cell, cell, state */
    EnfLineStore lines;
    EnfRegionVisStats stats;
} EnfBlockAnswer;

/* One block of a bake in progress: what its stages share. */
typedef struct EnfRegionBake {
    const EnfScene *scene;
    EnfRegionVisDef def;         /* pointers in it are not to be used */
    const EnfRegionModel *model; /* cells and portals below are the model's */
    const uint8_t *wanted;       /* [cells] cells of the block, whose rows are to be decided; NULL: all */
    uint32_t *outgrown;          /* [outgrown_count] cells at the rim of the model that it might see: it wants a larger part of the scene */
    uint32_t outgrown_count;
    EnfPairTable table; /* made by enf_might_see, unless a variant brings one */
    EnfLineStore lines;
    struct EnfMightSets *might;
    EnfRegionVisStats stats;              /* its counters; stats.threads: those the stages may use */
    EnfJob *job;                          /* NULL when run without one */
    double progress_from, progress_share; /* of the whole bake's progress */
    double deadline;                      /* wall seconds; 0: none */
} EnfRegionBake;

/* Whether to stop: cancelled, or past the deadline. */
int enf_bake_should_stop(const EnfRegionBake *bake);
/* Tells the job; fraction: of this block. */
void enf_bake_report(const EnfRegionBake *bake, const char *phase, double fraction);

/* ---- Lines found (found_lines.c) ---- */
/* Lines that threads find beside each other, to be entered one after the other. Which pairs a line may prove is looked up by
 * the finder: entering them then costs little, and other threads wait for it. */
typedef struct EnfFoundLines {
    EnfLineStore store;
    uint64_t *places; /* in the table's slots, line after line */
    uint64_t *ends;   /* [store.count] of a line's places */
} EnfFoundLines;
/* slots: the table's states, or an older copy of them. Gives 0 when memory runs out. */
int enf_found_lines_add(EnfFoundLines *found, const EnfRegionBake *bake, const uint32_t *slots, const double p[3], const double d[3],
                        const uint32_t *portals, uint32_t count);
/* Adds a checked line to the bake and marks the pairs along it visible; a line that proves nothing new isn't kept. Gives the
 * number of unordered pairs it proved, -1 when memory runs out. */
int64_t enf_found_line_enter(const EnfFoundLines *found, uint32_t line, EnfRegionBake *bake);
void enf_found_lines_clear(EnfFoundLines *found);
void enf_found_lines_free(EnfFoundLines *found);

/* Sightlines aimed where knowledge ends, from every cell wanted: fills the table with visible pairs. */
EnfStatus enf_seed_sightlines(EnfRegionBake *bake, double effort);

/* Moves each grazing pair's line to where it keeps furthest from all edges (grazing_line.c). */
EnfStatus enf_widen_grazing_lines(EnfRegionBake *bake);

/* ---- Some rows (bake_part.c) ---- */
typedef struct EnfBakePart {
    uint8_t *inside; /* [cells of the scene] for enf_region_model_create; NULL: the whole scene */
} EnfBakePart;
/* What lies around these cells. */
EnfStatus enf_bake_part_begin(EnfBakePart *part, const EnfScene *scene, const uint32_t *cells, uint32_t count);
/* Notes a cell at the rim, around which the part is to be widened; widens it. */
void enf_bake_part_reach(EnfBakePart *part, uint32_t cell);
EnfStatus enf_bake_part_widen(EnfBakePart *part, const EnfScene *scene);
void enf_bake_part_free(EnfBakePart *part);

/* ---- Blocks (bake_blocks.c) ---- */
/* Cells cut into blocks of neighbours, at most `largest` each. A pair is decided by the block of one of its cells. The same
 * cells make the same blocks, whatever part of the scene the model is. */
typedef struct EnfBakeBlocks {
    uint32_t count;
    uint32_t *first; /* [count + 1] */
    uint32_t *cells; /* ascending in a block */
    uint32_t *of;    /* [cells] block of a cell, ENF_NONE: not asked for */
} EnfBakeBlocks;
/* asked: [cells of the scene]; NULL: all. */
EnfStatus enf_bake_blocks(const EnfRegionModel *model, const uint8_t *asked, uint32_t largest, EnfBakeBlocks *out);
void enf_bake_blocks_free(EnfBakeBlocks *blocks);
/* Which of two cells' blocks decides the pair: the cell with fewer portals; it has fewer chains. */
uint32_t enf_bake_owner(const EnfRegionModel *model, uint32_t i, uint32_t j);

/* ---- Answers (block_answer.c) ---- */
/* Adds what the block found to the answer, in the scene's cells and portals; takes over its lines. */
EnfStatus enf_block_answer_take(EnfRegionBake *block, EnfBlockAnswer *out);
void enf_block_answer_free(EnfBlockAnswer *answer);
void enf_bake_add_counters(EnfRegionVisStats *to, const EnfRegionVisStats *from);

/* ---- State files (bake_state.c) ---- */
typedef struct EnfBakeQuestion {
    uint64_t geometry; /* hash of cells, portals and their corners */
    uint64_t question; /* hash of geometry, door states and of everything in the def that the answer depends on */
    double clearance;  /* metres */
    uint32_t method, block_count;
    uint32_t cell_count, portal_count, opening_count;
    uint8_t *states;      /* [openings] ENF_STATE_* as baked */
    uint32_t asked_count; /* 0: all rows */
    uint32_t *asked;      /* [asked_count] ascending */
} EnfBakeQuestion;
EnfStatus enf_bake_question(const EnfScene *scene, const EnfRegionModel *model, const EnfRegionVisDef *def, uint32_t block_count,
                            EnfBakeQuestion *out);
EnfStatus enf_bake_question_copy(EnfBakeQuestion *to, const EnfBakeQuestion *from);
void enf_bake_question_free(EnfBakeQuestion *question);
uint64_t enf_bake_geometry_hash(const EnfScene *scene);
/* Reads what blocks a state file holds into answers (made here when NULL); a file cut short by a crash gives what is whole in it, and
 * *out_whole tells whether anything had to be left. It must be about expected's scene. What else is asked of it:
 *   as NULL, out_question NULL  a bake that goes on: expected's question; no file, or an empty one, is a first start
 *   out_question given          any question, given there; on failure, too: it tells how many answers there are to free
 *   as                          expected's question, found in the file of that name */
EnfStatus enf_bake_state_read(const char *path, const EnfBakeQuestion *expected, const char *as, EnfBakeQuestion *out_question,
                              EnfBlockAnswer **answers, int *out_whole);
/* A new file with these answers (those done), through a temporary one. */
EnfStatus enf_bake_state_write(const char *path, const EnfBakeQuestion *question, const EnfBlockAnswer *answers);
/* Adds one block at the end of the file. */
EnfStatus enf_bake_state_append(const char *path, uint32_t block, const EnfBlockAnswer *answer);

/* ---- Variants (bake_variant.c) ---- */
/* Sets a block up from the result of other door states: pairs that the changed openings may change come into its table, open;
 * what else is known goes into the answer. *out_wanted: the cells of open pairs, the caller's to free. */
EnfStatus enf_bake_variant(EnfRegionBake *block, const EnfRegionVis *before, uint8_t **out_wanted, EnfBlockAnswer *answer);

/* ---- Results (region_result.c) ---- */
/* The rows out of all answers; takes over the model, not the answers. asked: [cells of the scene]; NULL: all rows. */
EnfStatus enf_region_result_create(const EnfScene *scene, EnfRegionModel *model, const EnfBakeQuestion *question, const uint8_t *asked,
                                   const EnfBlockAnswer *answers, const EnfRegionVisStats *stats, EnfRegionVis **out_result);
/* Of a result with answers from the state file `path`: whether its rows ascend; else some pair stands there twice. */
EnfStatus enf_region_result_check(const EnfRegionVis *result, const char *path);
/* Whether a bake of the scene, as it is now, can be a variant of this result. */
EnfStatus enf_region_result_may_vary(const EnfRegionVis *result, const EnfScene *scene);

#endif
