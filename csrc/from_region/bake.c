/* SPDX-License-Identifier: GPL-3.0-or-later
 * Runs a bake: prepares the scene, cuts it into blocks, takes each through the stages of the chosen method, puts the rows together.
 *
 * A block sees nothing of what other blocks found, so its answer doesn't depend on where, when and beside what it is
 * computed: shards, a bake that goes on after a crash and any number of threads give the same bytes. */
#include "from_region/bake.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "base/timer.h"
#include "from_region/chain_search.h"
#include "from_region/might_see.h"

/* Method `sample` up to this many cells asks about every pair, so that it shares nothing with the might-see sets and can
 * judge them; above, the square of the cells would not fit (32 MB here). */
#define SAMPLE_ALL_PAIRS_MAX 4096

/* Sightlines aimed for a pair not yet proven before the search begins: more cost more than they save it. */
#define SEED_EFFORT 0.3

/* What a block learns about pairs serves the pairs it asks later, so many blocks cost more (ALGORITHMS.md). So a bake is one
 * block, unless something is to be kept or shared: then 8 to 16, of 512 cells or more. [Cells] */
#define BLOCKS_WANTED   12
#define BLOCK_CELLS_MIN 512

static uint32_t block_cells(const EnfRegionVisDef *def, uint32_t cells) {
    if (def->block_cells)
        return def->block_cells;
    if (!def->state_path)
        return UINT32_MAX;
    uint32_t size = cells / BLOCKS_WANTED;
    return size < BLOCK_CELLS_MIN ? BLOCK_CELLS_MIN : size;
}

EnfRegionVisDef enf_default_region_vis_def(void) {
    EnfRegionVisDef def;
    memset(&def, 0, sizeof def);
    def.struct_size = (uint32_t)sizeof def;
    def.method = ENF_REGION_EXACT;
    def.sample_effort = 1;
    def.shard_count = 1;
    def.seed = 1;
    return def;
}

EnfRegionVisStats enf_default_region_vis_stats(void) {
    EnfRegionVisStats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = (uint32_t)sizeof stats;
    return stats;
}

/* A bake as a whole. */
typedef struct Bake {
    const EnfScene *scene;
    EnfRegionVisDef def; /* from_cells and state_path are the bake's own copies */
    uint8_t *asked;      /* [cells of the scene] row asked for; NULL: all */
    EnfRegionModel *model;
    EnfBakePart part; /* of the scene, that the model holds; its `inside` NULL: the whole */
    EnfBakeBlocks blocks;
    EnfBlockAnswer *answers;    /* [blocks.count] */
    uint32_t *todo, todo_count; /* blocks of this shard not loaded from the state file */
    EnfBakeQuestion question;
    EnfRegionVisStats stats;
    EnfJob *job;
    EnfMutex *mutex; /* guards the state file, done_count, outgrown and status */
    uint32_t done_count, block_threads;
    int outgrown; /* a block wants a larger part of the scene */
    EnfStatus status;
    char message[256];
    double started, deadline; /* wall seconds; deadline 0: none */
} Bake;

int enf_bake_should_stop(const EnfRegionBake *bake) {
    return enf_job_cancelled(bake->job) || (bake->deadline > 0 && enf_wall_seconds() > bake->deadline);
}

void enf_bake_report(const EnfRegionBake *bake, const char *phase, double fraction) {
    enf_job_report(bake->job, phase, bake->progress_from + bake->progress_share * fraction);
}

/* ---- One block --------------------------------------------------------------------------------------------- */
/* Pairs that another block decides. */
static void mark_foreign(EnfRegionBake *block, const EnfBakeBlocks *blocks, uint32_t index) {
    const EnfPairTable *t = &block->table;
    for (uint32_t c = blocks->first[index]; c < blocks->first[index + 1]; ++c) {
        uint32_t i = blocks->cells[c];
        for (uint64_t b = t->first[i]; b < t->first[i + 1]; ++b)
            for (uint64_t bits = t->bits[b]; bits; bits &= bits - 1) {
                uint32_t j = t->block[b] * 64 + enf_lowest_bit64(bits);
                if (blocks->of[j] != ENF_NONE && blocks->of[j] != index && enf_bake_owner(block->model, i, j) == j)
                    *enf_pair_slot(t, i, j) = ENF_SLOT_FOREIGN;
            }
    }
}

/* CPU seconds of what works on the block. */
static double block_clock(const EnfRegionBake *block) {
    return block->stats.threads > 1 ? enf_cpu_seconds() : enf_thread_cpu_seconds();
}

static EnfStatus block_stages(EnfRegionBake *block, const EnfBakeBlocks *blocks, uint32_t index) {
    EnfRegionVisStats *stats = &block->stats;
    EnfStatus status = ENF_OK;
    double cpu = block_clock(block), now;
    int sampled = block->def.method == ENF_REGION_SAMPLE;
    if (sampled && blocks->count == 1 && block->scene->cell_count <= SAMPLE_ALL_PAIRS_MAX) {
        if (!enf_pair_table_all(&block->table, block->scene->cell_count))
            status = enf_fail_memory();
    } else {
        status = enf_might_see(block);
        if (status == ENF_OK && blocks->count > 1 && !block->outgrown_count)
            mark_foreign(block, blocks, index);
    }
    if (status != ENF_OK || block->outgrown_count)
        return status;
    stats->might_pairs = 2 * block->table.slot_first[block->table.cell_count];
    now = block_clock(block), stats->might_s = now - cpu, cpu = now;
    if (!enf_bake_should_stop(block))
        status = enf_seed_sightlines(block, sampled ? block->def.sample_effort : SEED_EFFORT);
    now = block_clock(block), stats->seed_s = now - cpu, cpu = now;
    if (status == ENF_OK && !sampled && !enf_bake_should_stop(block))
        status = enf_chain_search(block);
    if (status == ENF_OK && !sampled)
        status = enf_widen_grazing_lines(block);
    stats->search_s = block_clock(block) - cpu;
    return status;
}

static void block_free(EnfRegionBake *block) {
    enf_pair_table_free(&block->table);
    enf_line_store_free(&block->lines);
    enf_might_sets_destroy(block->might);
    enf_free((void *)block->wanted);
}

static void note_failure(Bake *bake, EnfStatus status) {
    if (bake->status != ENF_OK)
        return;
    bake->status = status;
    snprintf(bake->message, sizeof bake->message, "%s", enf_last_error());
}

/* Task `task` of the blocks to do. Errors are noted in the bake: the message belongs to this thread. */
static void run_block(void *context, uint64_t task, uint32_t thread) {
    Bake *bake = context;
    uint32_t index = bake->todo[task], n = bake->model->cell_count;
    (void)thread;
    EnfRegionBake block = {.scene = bake->scene, .def = bake->def, .model = bake->model, .job = bake->job, .deadline = bake->deadline};
    block.stats = enf_default_region_vis_stats();
    block.stats.threads = bake->block_threads;
    enf_mutex_lock(bake->mutex);
    block.progress_from = (double)bake->done_count / bake->todo_count, block.progress_share = 1.0 / bake->todo_count;
    EnfStatus status = bake->status;
    enf_mutex_unlock(bake->mutex);
    if (status != ENF_OK)
        return;
    uint8_t *wanted = NULL;
    EnfBlockAnswer *answer = &bake->answers[index];
    if (bake->def.variant_of)
        status = enf_bake_variant(&block, bake->def.variant_of, &wanted, answer);
    else if (bake->blocks.count > 1 || bake->asked) {
        wanted = ENF_NEW(uint8_t, (uint64_t)n + 1);
        if (!wanted)
            status = enf_fail_memory();
        for (uint32_t c = bake->blocks.first[index]; c < bake->blocks.first[index + 1] && wanted; ++c)
            wanted[bake->blocks.cells[c]] = 1;
    }
    block.wanted = wanted;
    if (status == ENF_OK)
        status = block_stages(&block, &bake->blocks, index);
    int whole = !enf_bake_should_stop(&block);
    if (status == ENF_OK && !block.outgrown_count)
        status = enf_block_answer_take(&block, answer);
    block_free(&block);
    enf_mutex_lock(bake->mutex);
    ++bake->done_count;
    for (uint32_t k = 0; k < block.outgrown_count; ++k)
        enf_bake_part_reach(&bake->part, enf_rm_scene_cell(bake->model, block.outgrown[k]));
    bake->outgrown |= block.outgrown_count > 0;
    enf_free(block.outgrown);
    /* What a time limit cut short isn't kept: the next start does it again, whole. */
    if (status == ENF_OK && whole && !block.outgrown_count && bake->def.state_path)
        status = enf_bake_state_append(bake->def.state_path, index, answer);
    if (status != ENF_OK)
        note_failure(bake, status);
    enf_mutex_unlock(bake->mutex);
}

/* ---- The whole --------------------------------------------------------------------------------------------- */
static void bake_destroy(void *context) {
    Bake *bake = context;
    if (!bake)
        return;
    enf_region_model_destroy(bake->model);
    for (uint32_t k = 0; bake->answers && k < bake->question.block_count; ++k) /* the blocks may be gone, with a model that failed */
        enf_block_answer_free(&bake->answers[k]);
    enf_free(bake->answers), enf_free(bake->todo);
    enf_bake_blocks_free(&bake->blocks);
    enf_bake_question_free(&bake->question);
    enf_mutex_destroy(bake->mutex);
    enf_free((void *)bake->def.from_cells), enf_free((void *)bake->def.state_path);
    enf_free(bake->asked);
    enf_bake_part_free(&bake->part);
    enf_free(bake);
}

static EnfStatus check_def(const EnfScene *scene, const EnfRegionVisDef *def) {
    if (!scene || !def)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: scene or def is NULL");
    if (def->struct_size != sizeof *def)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT,
                        "region vis: def.struct_size is %u, expected %u; get the def from "
                        "enf_default_region_vis_def",
                        def->struct_size, (unsigned)sizeof *def);
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "region vis: the scene isn't committed");
    if (def->method > ENF_REGION_EXACT)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: method is %u, expected 0, 1 or 2", def->method);
    if (!def->shard_count || def->shard_index >= def->shard_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: shard_index is %u of %u", def->shard_index, def->shard_count);
    if (def->shard_count > 1 && !def->state_path)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: a shard needs a state_path: its share is worth nothing "
                                                    "without the others'");
    if (def->variant_of) {
        if (def->shard_count > 1 || def->state_path || def->from_cells)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: a variant takes no shards, state_path or from_cells");
        if (def->method != ENF_REGION_EXACT)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: a variant is exact; method is %u", def->method);
        EnfStatus status = enf_region_result_may_vary(def->variant_of, scene);
        if (status != ENF_OK)
            return status;
    }
    if (def->from_count && !def->from_cells)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: from_count is %u but from_cells is NULL", def->from_count);
    for (uint32_t i = 0; i < def->from_count; ++i)
        if (def->from_cells[i] >= scene->cell_count)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: from_cells[%u] is %u, the scene has %u cells", i, def->from_cells[i],
                            scene->cell_count);
    return ENF_OK;
}

static EnfStatus bake_create(const EnfScene *scene, const EnfRegionVisDef *def, Bake **out_bake) {
    EnfStatus status = check_def(scene, def);
    if (status != ENF_OK)
        return status;
    Bake *bake = ENF_NEW(Bake, 1);
    if (!bake)
        return enf_fail_memory();
    bake->scene = scene, bake->def = *def;
    bake->def.from_cells = NULL, bake->def.state_path = enf_strdup(def->state_path);
    bake->mutex = enf_mutex_create();
    int ok = bake->mutex && (bake->def.state_path || !def->state_path);
    if (def->from_cells && ok) {
        uint32_t *copy = ENF_NEW(uint32_t, (uint64_t)def->from_count + 1);
        bake->asked = ENF_NEW(uint8_t, (uint64_t)scene->cell_count + 1);
        bake->def.from_cells = copy;
        ok = copy && bake->asked;
        for (uint32_t i = 0; ok && i < def->from_count; ++i)
            copy[i] = def->from_cells[i], bake->asked[def->from_cells[i]] = 1;
    }
    if (!ok) {
        bake_destroy(bake);
        return enf_fail_memory();
    }
    bake->stats = enf_default_region_vis_stats();
    bake->stats.method = def->method;
    bake->stats.cells = scene->cell_count, bake->stats.portals = scene->portal_count;
    bake->stats.threads = def->threads ? def->threads : enf_processor_count();
    *out_bake = bake;
    return ENF_OK;
}

/* Method `sample` asks about all pairs of a small scene, in one table. */
static int samples_all(const Bake *bake) {
    return bake->def.method == ENF_REGION_SAMPLE && bake->scene->cell_count <= SAMPLE_ALL_PAIRS_MAX;
}

/* The model, and its cells in blocks; anew when the part has been widened. */
static EnfStatus make_model(Bake *bake) {
    const EnfRegionVisDef *def = &bake->def;
    enf_region_model_destroy(bake->model);
    bake->model = NULL;
    enf_bake_blocks_free(&bake->blocks);
    EnfStatus status = enf_region_model_create(bake->scene, NULL, def->clearance, bake->part.inside, &bake->model);
    /* A variant asks few pairs, anywhere: one block. */
    uint32_t largest = def->variant_of || samples_all(bake) ? UINT32_MAX : block_cells(def, bake->scene->cell_count);
    if (status == ENF_OK)
        status = enf_bake_blocks(bake->model, bake->asked, largest, &bake->blocks);
    return status;
}

/* The blocks of this shard that aren't done. */
static void list_todo(Bake *bake) {
    bake->todo_count = bake->done_count = 0;
    bake->outgrown = 0;
    for (uint32_t k = 0; k < bake->blocks.count; ++k)
        if (!bake->answers[k].done && (uint64_t)k * bake->def.shard_count / bake->blocks.count == bake->def.shard_index)
            bake->todo[bake->todo_count++] = k;
}

/* Model, blocks, and what a state file has of them. */
static EnfStatus prepare(Bake *bake) {
    const EnfRegionVisDef *def = &bake->def;
    enf_job_report(bake->job, "preparing", 0);
    EnfStatus status = ENF_OK;
    if (bake->asked && !samples_all(bake))
        status = enf_bake_part_begin(&bake->part, bake->scene, def->from_cells, def->from_count);
    if (status == ENF_OK)
        status = make_model(bake);
    if (status == ENF_OK)
        status = enf_bake_question(bake->scene, bake->model, def, bake->blocks.count, &bake->question);
    if (status != ENF_OK)
        return status;
    uint32_t count = bake->blocks.count;
    bake->stats.clearance = bake->model->delta * bake->model->inverse_scale;
    bake->stats.blocks = count;
    bake->answers = ENF_NEW(EnfBlockAnswer, (uint64_t)count + 1);
    bake->todo = ENF_NEW(uint32_t, (uint64_t)count + 1);
    if (!bake->answers || !bake->todo)
        return enf_fail_memory();
    if (def->state_path) {
        int whole = 0;
        status = enf_bake_state_read(def->state_path, &bake->question, NULL, NULL, &bake->answers, &whole);
        if (status == ENF_OK && !whole)
            status = enf_bake_state_write(def->state_path, &bake->question, bake->answers);
        if (status != ENF_OK)
            return status;
    }
    for (uint32_t k = 0; k < count; ++k)
        bake->stats.blocks_loaded += bake->answers[k].done;
    list_todo(bake);
    return ENF_OK;
}

/* Works off the blocks to do. Many: each on one thread. Few: one after the other, on all. */
static void run_blocks(Bake *bake) {
    uint32_t threads = bake->stats.threads;
    int side_by_side = threads > 1 && bake->todo_count >= 4 * threads;
    bake->block_threads = side_by_side ? 1 : threads;
    enf_parallel_for(bake->todo_count, side_by_side ? threads : 1, run_block, bake);
}

static EnfStatus bake_run(Bake *bake, EnfRegionVis **out_result) {
    EnfRegionVisStats *stats = &bake->stats;
    double cpu = enf_cpu_seconds();
    bake->started = enf_wall_seconds();
    bake->deadline = bake->def.time_limit > 0 ? bake->started + bake->def.time_limit : 0;
    EnfStatus status = prepare(bake);
    if (status != ENF_OK)
        return status;
    for (run_blocks(bake); bake->outgrown && bake->status == ENF_OK; run_blocks(bake)) {
        status = enf_bake_part_widen(&bake->part, bake->scene);
        if (status == ENF_OK)
            status = make_model(bake);
        if (status != ENF_OK)
            return status;
        list_todo(bake);
    }
    if (bake->status != ENF_OK)
        return enf_fail(bake->status, "%s", bake->message);
    if (enf_job_cancelled(bake->job))
        stats->interrupted = 2;
    else if (bake->deadline > 0 && enf_wall_seconds() > bake->deadline)
        stats->interrupted = 1;
    enf_job_report(bake->job, "rows", 0.99);
    for (uint32_t k = 0; k < bake->blocks.count; ++k)
        if (bake->answers[k].done)
            enf_bake_add_counters(stats, &bake->answers[k].stats);
        else
            stats->partial = 1;
    stats->wall_s = enf_wall_seconds() - bake->started;
    stats->cpu_s = enf_cpu_seconds() - cpu;
    stats->peak_bytes = enf_peak_bytes();
    EnfRegionModel *model = bake->model;
    bake->model = NULL; /* the result's, also when it fails */
    status = enf_region_result_create(bake->scene, model, &bake->question, bake->asked, bake->answers, stats, out_result);
    if (status == ENF_OK && stats->blocks_loaded && (status = enf_region_result_check(*out_result, bake->def.state_path)) != ENF_OK) {
        enf_region_vis_destroy(*out_result);
        *out_result = NULL;
    }
    return status;
}

static void destroy_result(void *result) {
    enf_region_vis_destroy(result);
}

static EnfStatus bake_work(EnfJob *job, void *context) {
    Bake *bake = context;
    EnfRegionVis *result = NULL;
    bake->job = job;
    EnfStatus status = bake_run(bake, &result);
    if (status == ENF_OK)
        enf_job_set_result(job, result, destroy_result);
    if (status == ENF_OK && bake->stats.interrupted == 2)
        return enf_fail(ENF_ERROR_CANCELLED, "region vis: cancelled; the result holds what was decided by then");
    return status;
}

EnfStatus enf_region_vis_start(const EnfScene *scene, const EnfRegionVisDef *def, EnfJob **out_job) {
    Bake *bake = NULL;
    if (!out_job)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: out_job is NULL");
    EnfStatus status = bake_create(scene, def, &bake);
    if (status != ENF_OK)
        return status;
    status = enf_job_start(bake_work, bake, bake_destroy, out_job);
    if (status != ENF_OK)
        bake_destroy(bake);
    return status;
}

EnfStatus enf_region_vis_take(EnfJob *job, EnfRegionVis **out_result) {
    if (!job || !out_result)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: job or out_result is NULL");
    if (!enf_job_ended(job))
        return enf_fail(ENF_ERROR_STATE, "region vis: the job hasn't ended; wait for it first");
    EnfRegionVis *result = enf_job_take_result(job, destroy_result);
    if (!result)
        return enf_fail(ENF_ERROR_STATE, "region vis: the job has no result, or it was taken before");
    *out_result = result;
    return ENF_OK;
}

EnfStatus enf_region_vis_run(const EnfScene *scene, const EnfRegionVisDef *def, EnfRegionVis **out_result) {
    Bake *bake = NULL;
    if (!out_result)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: out_result is NULL");
    EnfStatus status = bake_create(scene, def, &bake);
    if (status != ENF_OK)
        return status;
    status = bake_run(bake, out_result);
    bake_destroy(bake);
    return status;
}
