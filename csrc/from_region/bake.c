/* SPDX-License-Identifier: GPL-3.0-or-later
 * Runs a bake: prepares the scene, then the stages of the chosen method, then the rows. */
#include "from_region/bake.h"

#include <stddef.h>
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

int enf_bake_should_stop(EnfRegionBake *bake) {
    return enf_job_cancelled(bake->job) || (bake->deadline > 0 && enf_wall_seconds() > bake->deadline);
}

int64_t enf_bake_record_line(EnfRegionBake *bake, const double p[3], const double d[3], const uint32_t *portals,
                             uint32_t count) {
    int64_t pairs = 0;
    const EnfRegionModel *m = bake->model;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t from = enf_rm_from(m, portals[i]);
        for (uint32_t k = i; k < count; ++k) {
            uint32_t *slot = enf_pair_slot(&bake->table, from, m->to[portals[k]]);
            if (!slot || enf_slot_is_visible(*slot)) continue;
            if (!pairs && !enf_line_store_add(&bake->lines, p, d, portals, count)) return -1;
            *slot = bake->lines.count; /* index + 1 */
            ++pairs;
        }
    }
    return pairs;
}

static void bake_destroy(void *context) {
    EnfRegionBake *bake = context;
    if (!bake) return;
    enf_region_model_destroy(bake->model);
    enf_pair_table_free(&bake->table);
    enf_line_store_free(&bake->lines);
    enf_might_sets_destroy(bake->might);
    enf_free((void *)bake->def.from_cells);
    enf_free(bake->wanted);
    enf_free(bake);
}

static EnfStatus bake_create(const EnfScene *scene, const EnfRegionVisDef *def, EnfRegionBake **out_bake) {
    if (!scene || !def) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: scene or def is NULL");
    if (def->struct_size != sizeof *def)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: def.struct_size is %u, expected %u; get the def from "
                        "enf_default_region_vis_def", def->struct_size, (unsigned)sizeof *def);
    if (!scene->committed) return enf_fail(ENF_ERROR_STATE, "region vis: the scene isn't committed");
    if (def->method > ENF_REGION_EXACT)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: method is %u, expected 0, 1 or 2", def->method);
    if (def->shard_count != 1 || def->shard_index != 0 || def->state_path)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: shards and state files are reserved and not made yet");
    if (def->from_count && !def->from_cells)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: from_count is %u but from_cells is NULL",
                        def->from_count);
    for (uint32_t i = 0; i < def->from_count; ++i)
        if (def->from_cells[i] >= scene->cell_count)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: from_cells[%u] is %u, the scene has %u cells", i,
                            def->from_cells[i], scene->cell_count);
    EnfRegionBake *bake = ENF_NEW(EnfRegionBake, 1);
    if (!bake) return enf_fail_memory();
    bake->scene = scene, bake->def = *def;
    bake->def.from_cells = NULL, bake->def.state_path = NULL;
    int ok = 1;
    if (def->from_cells) {
        uint32_t *copy = ENF_NEW(uint32_t, (uint64_t)def->from_count + 1);
        bake->wanted = ENF_NEW(uint8_t, (uint64_t)scene->cell_count + 1);
        bake->def.from_cells = copy;
        ok = copy && bake->wanted;
        for (uint32_t i = 0; ok && i < def->from_count; ++i)
            copy[i] = def->from_cells[i], bake->wanted[def->from_cells[i]] = 1;
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

static EnfStatus bake_stages(EnfRegionBake *bake) {
    double cpu = enf_cpu_seconds(), now;
    enf_job_report(bake->job, "preparing", 0);
    EnfStatus status = enf_region_model_create(bake->scene, bake->def.clearance, &bake->model);
    if (status != ENF_OK) return status;
    EnfRegionVisStats *stats = &bake->stats;
    stats->clearance = bake->model->delta * bake->model->inverse_scale;
    if (bake->def.method == ENF_REGION_SAMPLE && bake->scene->cell_count <= SAMPLE_ALL_PAIRS_MAX) {
        if (!enf_pair_table_all(&bake->table, bake->scene->cell_count)) return enf_fail_memory();
    } else {
        status = enf_might_see(bake);
    }
    stats->might_pairs = 2 * bake->table.slot_first[bake->table.cell_count];
    now = enf_cpu_seconds(), stats->might_s = now - cpu, cpu = now;
    if (status == ENF_OK && !enf_bake_should_stop(bake))
        status = enf_seed_sightlines(bake, bake->def.method == ENF_REGION_SAMPLE ? bake->def.sample_effort : 0.5);
    now = enf_cpu_seconds(), stats->seed_s = now - cpu, cpu = now;
    if (status == ENF_OK && bake->def.method != ENF_REGION_SAMPLE && !enf_bake_should_stop(bake))
        status = enf_chain_search(bake);
    stats->search_s = enf_cpu_seconds() - cpu;
    return status;
}

static EnfStatus bake_run(EnfRegionBake *bake, EnfRegionVis **out_result) {
    double cpu = enf_cpu_seconds();
    bake->started = enf_wall_seconds();
    bake->deadline = bake->def.time_limit > 0 ? bake->started + bake->def.time_limit : 0;
    EnfStatus status = bake_stages(bake);
    if (status != ENF_OK) return status;
    if (enf_job_cancelled(bake->job)) bake->stats.interrupted = 2;
    else if (bake->deadline > 0 && enf_wall_seconds() > bake->deadline) bake->stats.interrupted = 1;
    enf_job_report(bake->job, "rows", 0.99);
    bake->stats.wall_s = enf_wall_seconds() - bake->started;
    bake->stats.cpu_s = enf_cpu_seconds() - cpu;
    bake->stats.peak_bytes = enf_peak_bytes();
    return enf_region_result_create(bake, out_result);
}

static void destroy_result(void *result) { enf_region_vis_destroy(result); }

static EnfStatus bake_work(EnfJob *job, void *context) {
    EnfRegionBake *bake = context;
    EnfRegionVis *result = NULL;
    bake->job = job;
    EnfStatus status = bake_run(bake, &result);
    if (status == ENF_OK) enf_job_set_result(job, result, destroy_result);
    if (status == ENF_OK && bake->stats.interrupted == 2)
        return enf_fail(ENF_ERROR_CANCELLED, "region vis: cancelled; the result holds what was decided by then");
    return status;
}

EnfStatus enf_region_vis_start(const EnfScene *scene, const EnfRegionVisDef *def, EnfJob **out_job) {
    EnfRegionBake *bake = NULL;
    if (!out_job) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: out_job is NULL");
    EnfStatus status = bake_create(scene, def, &bake);
    if (status != ENF_OK) return status;
    status = enf_job_start(bake_work, bake, bake_destroy, out_job);
    if (status != ENF_OK) bake_destroy(bake);
    return status;
}

EnfStatus enf_region_vis_take(EnfJob *job, EnfRegionVis **out_result) {
    if (!job || !out_result) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: job or out_result is NULL");
    if (!enf_job_ended(job)) return enf_fail(ENF_ERROR_STATE, "region vis: the job hasn't ended; wait for it first");
    EnfRegionVis *result = enf_job_take_result(job, destroy_result);
    if (!result) return enf_fail(ENF_ERROR_STATE, "region vis: the job has no result, or it was taken before");
    *out_result = result;
    return ENF_OK;
}

EnfStatus enf_region_vis_run(const EnfScene *scene, const EnfRegionVisDef *def, EnfRegionVis **out_result) {
    EnfRegionBake *bake = NULL;
    if (!out_result) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis: out_result is NULL");
    EnfStatus status = bake_create(scene, def, &bake);
    if (status != ENF_OK) return status;
    status = bake_run(bake, out_result);
    bake_destroy(bake);
    return status;
}
