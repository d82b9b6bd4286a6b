/* SPDX-License-Identifier: GPL-3.0-or-later
 * From-region visibility: which cells, rooms and objects are seen from anywhere in which cell (DESIGN.md section 6).
 *
 * What the statuses mean, with a clearance delta in metres (def.clearance). A portal's clearance is taken in its plane:
 * a line clears a portal by c when it crosses the portal's plane inside the polygon, at least c from each edge.
 *   VISIBLE    some straight line from cell to cell clears every portal on its way by at least delta, crossing its plane at a
 *              sine of 1e-7 or more: the witness, checked apart from the search that found it.
 *   GRAZING    some line passes; that none clears every portal by 1.05 delta is certified. The witness is the line that keeps
 *              furthest from the edges of the portals it passes (within 1 % of the best through these portals, where that is more
 *              than 1e-4 delta), with its clearance; it may be as little as half a touch, or below 0 by the rounding of a
 *              portal that isn't flat.
 *   UNDECIDED  neither could be shown: a time limit, a cap, a weaker method. Counts as seen.
 *   HIDDEN     certified: no line clears every portal by a touch, none flatter to a portal than a touch over its least width (at
 *              least a sine of 1e-9, at most 1e-7): those squeeze through less than a touch. A touch is what rounding can make of
 *              edges that line up: 1e-11 of the scene's extent (a nanometre in 100 m), or 8 units in the last place of the largest
 *              coordinate (1.5e-8 m at 1e7 m) where that is more.
 * So in metres: whatever is seen by a line with clearance 1.05 delta or more is VISIBLE (or UNDECIDED); from delta up to there VISIBLE or
 * GRAZING, from a touch up to delta GRAZING (or UNDECIDED), never HIDDEN; lines that only touch edges see nothing. Portals *enlarged* by
 * however little would report those as well: doors in line and sills at one height make them everywhere (0.3 to 0.6 % more
 * pairs on the portal files, each a line that touches three or more edges).
 * Method `sample` is the exception: it proves VISIBLE pairs only and reports the rest as not seen (a lower bound).
 *
 * Threads: a bake only reads its scene, which must stay committed and unchanged until the job has ended. Results are
 * read-only: every query on one result is thread-safe. */
#ifndef ENFILADE_REGION_VIS_H
#define ENFILADE_REGION_VIS_H

#include "enfilade/base.h"
#include "enfilade/job.h"
#include "enfilade/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnfRegionVis EnfRegionVis;

enum { ENF_REGION_SAMPLE = 0, ENF_REGION_FLOW = 1, ENF_REGION_EXACT = 2 };
enum { ENF_PAIR_HIDDEN = 0, ENF_PAIR_VISIBLE = 1, ENF_PAIR_GRAZING = 2, ENF_PAIR_UNDECIDED = 3 };

typedef struct EnfRegionVisDef {
    uint32_t struct_size;
    uint32_t method;  /* ENF_REGION_*, default EXACT */
    uint32_t threads; /* 0: one a core. The answer has the same bits for any number */
    uint32_t from_count;
    const uint32_t *from_cells;     /* [from_count] rows wanted; NULL: all. Costs what these rows need, whatever the size of the scene.
                               Read during the start call only */
    double clearance;               /* metres; <= 0: 2.5e-7 of the scene's extent */
    double time_limit;              /* wall seconds; <= 0: none. What isn't decided by then is UNDECIDED */
    double sample_effort;           /* sightlines aimed for a pair not yet proven (method `sample`), default 1 */
    uint32_t shard_index;           /* 0 .. shard_count - 1: which share of the blocks this bake does */
    uint32_t shard_count;           /* default 1. More needs a state_path; the result then holds only the pairs of its share
                             (stats.partial), and enf_region_vis_load puts the shares together */
    const char *state_path;         /* UTF-8; NULL: none. Finished blocks are kept there; a bake of the same question that finds the
                               file goes on from it, also after a crash. Read during the start call only */
    uint64_t seed;                  /* of the sightlines' directions; default 1 */
    uint64_t chain_cap;             /* portals entered a source cell before the rest is left UNDECIDED; 0: default */
    uint32_t block_cells;           /* a bake is cut into blocks of neighbouring cells, at most this many, each done for itself: the unit of
                               shards and of what a state file keeps. 0: default, with a state_path a 12th of the cells, at least
                               512, else one block. Statuses don't depend on it; sightlines may, so give it where
                               a bake with and one without state file are to have the same bytes */
    uint32_t reserved;              /* 0 */
    const EnfRegionVis *variant_of; /* NULL: none. A whole result of the same scene with other door states: only what the changed
                                       openings can change is asked again. Must live until the job has ended */
} EnfRegionVisDef;
ENF_API EnfRegionVisDef enf_default_region_vis_def(void);

/* Starts the bake in the background and returns at once. The scene must be committed (ENF_ERROR_STATE otherwise). */
ENF_API EnfStatus enf_region_vis_start(const EnfScene *scene, const EnfRegionVisDef *def, EnfJob **out_job);
/* Takes the result of an ended job (wait first; ENF_ERROR_STATE when it hasn't ended or was taken before). A cancelled bake
 * has a result too: what it had not decided is UNDECIDED. The caller destroys it; it outlives the job, not the scene. */
ENF_API EnfStatus enf_region_vis_take(EnfJob *job, EnfRegionVis **out_result);
/* Start, wait, take. */
ENF_API EnfStatus enf_region_vis_run(const EnfScene *scene, const EnfRegionVisDef *def, EnfRegionVis **out_result);
ENF_API void enf_region_vis_destroy(EnfRegionVis *result);

/* The result out of state files: all shards of one bake (same scene, same question), in any order; the same bytes as the bake
 * in one piece gives. The openings of the scene may stand otherwise now: the result is that of the states baked (for
 * def.variant_of). ENF_ERROR_STATE when blocks are missing, ENF_ERROR_BAD_INPUT for files of another scene or question. */
ENF_API EnfStatus enf_region_vis_load(const EnfScene *scene, const char *const *state_paths_utf8, uint32_t path_count,
                                      EnfRegionVis **out_result);
/* Writes a whole result as a state file that enf_region_vis_load reads; through a temporary file. */
ENF_API EnfStatus enf_region_vis_save(const EnfRegionVis *result, const char *path_utf8);

/* ---- Rows ------------------------------------------------------------------------------------------------ */
/* Row i: the cells that cell i sees (statuses VISIBLE, GRAZING, UNDECIDED), ascending, i itself among them. Views owned by
 * the result. row_first: [cells + 1] into cells and statuses. Rows not asked for (def.from_cells) are empty. */
ENF_API uint32_t enf_region_vis_cell_count(const EnfRegionVis *result);
ENF_API const uint64_t *enf_region_vis_row_first(const EnfRegionVis *result);
ENF_API const uint32_t *enf_region_vis_row_cells(const EnfRegionVis *result);
ENF_API const uint8_t *enf_region_vis_row_status(const EnfRegionVis *result); /* ENF_PAIR_* beside each */
ENF_API EnfStatus enf_region_vis_pair(const EnfRegionVis *result, uint32_t from, uint32_t to, uint32_t *out_status);

/* The sightline of a pair: out_segment = start xyz in `from`, end xyz in `to`, metres (half way to the wall behind, where it has one).
 * Writes the portals it passes, in order, at most `capacity`, and gives the whole number. *out_clearance: the least clearance along it, metres; negative:
 * it misses a portal by that much (GRAZING). ENF_ERROR_INVALID_ARGUMENT when the pair has none (hidden or undecided). */
ENF_API EnfStatus enf_region_vis_witness(const EnfRegionVis *result, uint32_t from, uint32_t to, double out_segment[6],
                                         uint32_t *out_portals, uint32_t capacity, uint32_t *out_portal_count, double *out_clearance);

/* ---- Rooms ------------------------------------------------------------------------------------------------- */
/* Room a sees room b when a cell of a sees a cell of b. Status: the best among its cells (VISIBLE before GRAZING before
 * UNDECIDED). out_from, out_to (may be NULL): the pair of cells that shows it; ENF_NONE when hidden. */
ENF_API EnfStatus enf_region_vis_rooms(const EnfRegionVis *result, uint32_t room_a, uint32_t room_b, uint32_t *out_status,
                                       uint32_t *out_from, uint32_t *out_to);

/* ---- Objects ------------------------------------------------------------------------------------------------ */
/* A first answer at once, whether an object's bounds are ever seen from a cell. VISIBLE: it is drawn in that cell, or the
 * sightline into one of its cells goes on to its bounds. HIDDEN: certified, none of its cells is seen. UNDECIDED (GRAZING where
 * the cell is): its cell is seen, and that one sightline misses it; counts as seen. *out_cell (may be NULL): the cell of the
 * object that shows it; ENF_NONE when hidden. An object in no cell is UNDECIDED. */
ENF_API EnfStatus enf_region_vis_object(const EnfRegionVis *result, uint32_t from, uint32_t object, uint32_t *out_status,
                                        uint32_t *out_cell);

/* The whole answer: each object's bounds, box by box, as targets of the search from each cell asked for, with the statuses and
 * guarantees of cells. VISIBLE: some line clears every portal, enters the object's cell and meets its bounds there. HIDDEN:
 * no line through the portals meets the bounds, in any of its cells (their walls taken 0.1 m further out, as placement does).
 * Objects of other bounds hide nothing. UNDECIDED too where the bounds are a line or a point, or in no cell. */
typedef struct EnfObjectVis EnfObjectVis;
/* from_cells NULL: all cells. objects NULL: all objects. threads 0: one a processor; the answer has the same bits for any.
 * Blocks. The result (method exact, rows of these cells) is only read. The caller destroys what is made, before the result. */
ENF_API EnfStatus enf_object_vis_run(const EnfRegionVis *result, const uint32_t *from_cells, uint32_t from_count, const uint32_t *objects,
                                     uint32_t object_count, uint32_t threads, EnfObjectVis **out_objects);
ENF_API void enf_object_vis_destroy(EnfObjectVis *objects);
/* Row k: what the k-th cell asked for sees. Views owned by the handle. row_first: [rows + 1]; objects ascending; beside them
 * ENF_PAIR_* (never HIDDEN) and the cell of the object that shows it (ENF_NONE: it is in no cell). */
ENF_API uint32_t enf_object_vis_row_count(const EnfObjectVis *objects);
ENF_API const uint64_t *enf_object_vis_row_first(const EnfObjectVis *objects);
ENF_API const uint32_t *enf_object_vis_row_objects(const EnfObjectVis *objects);
ENF_API const uint8_t *enf_object_vis_row_status(const EnfObjectVis *objects);
ENF_API const uint32_t *enf_object_vis_row_cells(const EnfObjectVis *objects);
/* The sightline of the entry-th entry of all rows (0 .. row_first[rows] - 1), VISIBLE or GRAZING: start in the cell asked for, end on
 * the object's bounds; the portals it passes in order, as enf_region_vis_witness gives them (none: it is drawn in that cell, and
 * the segment is a point of its bounds). ENF_ERROR_INVALID_ARGUMENT when UNDECIDED. */
ENF_API EnfStatus enf_object_vis_witness(const EnfObjectVis *objects, uint64_t entry, double out_segment[6], uint32_t *out_portals,
                                         uint32_t capacity, uint32_t *out_portal_count);

/* ---- Statistics ---------------------------------------------------------------------------------------------- */
typedef struct EnfRegionVisStats {
    uint32_t struct_size;
    uint32_t method, threads, interrupted; /* interrupted: 1 by the time limit, 2 cancelled */
    uint64_t cells, portals;
    uint64_t visible_pairs;    /* ordered, i = j among them: everything in the rows */
    uint64_t proven_pairs;     /* ordered: VISIBLE, with a witness (i = j among them) */
    uint64_t grazing_pairs;    /* ordered */
    uint64_t undecided_pairs;  /* ordered */
    uint64_t hidden_certified; /* ordered pairs asked about and not in the rows (0 for method sample) */
    double wall_s, cpu_s;      /* of the bake alone, loading apart */
    uint64_t peak_bytes;       /* the library's allocations at most */
    double clearance;          /* metres, as used */
    /* counters of the stages, in the order they run */
    uint64_t might_pairs;             /* ordered pairs left by the might-see sets */
    uint64_t seed_lines;              /* sightlines walked */
    uint64_t seed_pairs;              /* ordered pairs they proved */
    uint64_t chains;                  /* portals entered by the search */
    uint64_t clips;                   /* windows clipped */
    uint64_t targets_dropped;         /* targets outside a separating plane */
    uint64_t line_tests;              /* chains that reached an unproven cell */
    uint64_t line_hits;               /* of them settled by a line found at once */
    uint64_t cone_tests;              /* chains that went to the stabbing cone */
    uint64_t cone_hidden;             /* of them certified empty */
    uint64_t cone_visible;            /* of them gave a line */
    uint64_t cone_rays;               /* extremal rays computed */
    uint64_t filter_failures;         /* signs of the cone the floating-point filter couldn't decide */
    uint64_t exact_signs;             /* of them decided by exact arithmetic: all */
    uint64_t chain_capped;            /* source cells whose search hit the cap */
    uint64_t skipped_cells;           /* cells no question was asked about */
    double might_s, seed_s, search_s; /* CPU seconds */
    uint64_t blocks;                  /* of the whole bake */
    uint64_t blocks_loaded;           /* of them taken from a state file */
    uint64_t pairs_kept;              /* unordered pairs whose answer a variant took over */
    uint64_t pairs_reopened;          /* unordered pairs it asked again */
    uint64_t partial;                 /* 1: a shard: the rows hold its own pairs only, so nothing may be hidden by them */
    uint64_t cone_signs;              /* signs the stabbing cone asked for; filter_failures of them left the filter undecided */
} EnfRegionVisStats;
ENF_API EnfRegionVisStats enf_default_region_vis_stats(void);
ENF_API EnfStatus enf_region_vis_stats(const EnfRegionVis *result, EnfRegionVisStats *out_stats);

/* ---- Files ------------------------------------------------------------------------------------------------- */
/* Matrix and witness files as DESIGN.md section 8 has them; written through a temporary file. Witness lines: i < j, the
 * segment in metres with 17 digits, for every VISIBLE pair: each line is a proof. */
ENF_API EnfStatus enf_region_vis_write_matrix(const EnfRegionVis *result, const char *path_utf8);
ENF_API EnfStatus enf_region_vis_write_witnesses(const EnfRegionVis *result, const char *path_utf8);

#ifdef __cplusplus
}
#endif
#endif
