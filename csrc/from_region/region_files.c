/* SPDX-License-Identifier: GPL-3.0-or-later
 * Results as files: matrix, witnesses, and whole, as state files that come back as results. */
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/number.h"
#include "base/status.h"
#include "from_region/region_result.h"

EnfStatus enf_region_vis_write_matrix(const EnfRegionVis *r, const char *path) {
    if (!r || !path)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "write matrix: result or path is NULL");
    EnfFileWriter writer;
    EnfStatus status = enf_file_write_begin(&writer, path);
    if (status != ENF_OK)
        return status;
    for (uint32_t i = 0; i < r->cell_count; ++i) {
        for (uint64_t k = r->first[i]; k < r->first[i + 1]; ++k)
            fprintf(writer.file, k == r->first[i] ? "%u" : " %u", r->cells[k]);
        fputc('\n', writer.file);
    }
    return enf_file_write_end(&writer, 1);
}

EnfStatus enf_region_vis_write_witnesses(const EnfRegionVis *r, const char *path) {
    if (!r || !path)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "write witnesses: result or path is NULL");
    EnfFileWriter writer;
    EnfStatus status = enf_file_write_begin(&writer, path);
    if (status != ENF_OK)
        return status;
    for (uint32_t i = 0; i < r->cell_count && status == ENF_OK; ++i)
        for (uint64_t k = r->first[i]; k < r->first[i + 1] && status == ENF_OK; ++k) {
            uint32_t j = r->cells[k];
            double segment[6];
            /* Each pair once; where only one row was asked for, its own direction. A grazing pair's line touches or misses an edge: no
             * proof, so it isn't here (enf_region_vis_witness gives it). */
            if (j == i || r->line[k] == ENF_NONE || r->status[k] != ENF_PAIR_VISIBLE || (j < i && r->first[j + 1] > r->first[j]))
                continue;
            status = enf_region_vis_witness(r, i, j, segment, NULL, 0, NULL, NULL);
            if (status != ENF_OK)
                break;
            fprintf(writer.file, "%u %u", i, j);
            for (int c = 0; c < 6; ++c) {
                char text[32];
                enf_number_format(text, segment[c]);
                fprintf(writer.file, " %s", text);
            }
            fputc('\n', writer.file);
        }
    EnfStatus end = enf_file_write_end(&writer, status == ENF_OK);
    return status != ENF_OK ? status : end;
}

/* ---- Whole results ----------------------------------------------------------------------------------------- */
EnfStatus enf_region_vis_save(const EnfRegionVis *r, const char *path) {
    if (!r || !path)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis save: result or path is NULL");
    if (r->stats.partial)
        return enf_fail(ENF_ERROR_STATE, "region vis save: a shard's result is only a part");
    EnfBlockAnswer answer = {.done = 1, .lines = r->lines, .stats = r->stats};
    EnfBakeQuestion question = r->question;
    question.block_count = 1;
    question.geometry = enf_bake_geometry_hash(r->scene);
    EnfStatus status = ENF_OK;
    for (uint32_t i = 0; i < r->cell_count && status == ENF_OK; ++i)
        for (uint64_t k = r->first[i]; k < r->first[i + 1]; ++k) {
            uint32_t j = r->cells[k];
            /* Each pair once: from its lower cell, or from the only one whose row was asked for. */
            if (j == i || (j < i && r->first[j + 1] > r->first[j]))
                continue;
            if (!ENF_RESERVE(answer.pairs, (uint64_t)answer.pair_count + 1)) {
                status = enf_fail_memory();
                break;
            }
            uint32_t slot = r->line[k] == ENF_NONE ? ENF_SLOT_UNDECIDED : r->line[k] + 1;
            if (r->status[k] == ENF_PAIR_GRAZING)
                slot |= ENF_SLOT_GRAZING;
            uint32_t *pair = answer.pairs[answer.pair_count++];
            pair[0] = i, pair[1] = j, pair[2] = slot;
        }
    if (status == ENF_OK)
        status = enf_bake_state_write(path, &question, &answer);
    enf_free(answer.pairs);
    return status;
}

EnfStatus enf_region_result_check(const EnfRegionVis *r, const char *path) {
    for (uint32_t i = 0; i < r->cell_count; ++i)
        for (uint64_t k = r->first[i] + 1; k < r->first[i + 1]; ++k)
            if (r->cells[k] <= r->cells[k - 1])
                return enf_fail(ENF_ERROR_BAD_INPUT, "%s: the state files tell twice of cells %u and %u", path, i, r->cells[k]);
    return ENF_OK;
}

/* torn: a file of which a part had to be left, NULL: none. path: the first; several: it isn't the only one. */
static EnfStatus make_result(const EnfScene *scene, const EnfBakeQuestion *question, const EnfBlockAnswer *answers, const char *torn,
                             const char *path, int several, EnfRegionVis **out_result) {
    EnfRegionVisStats stats = enf_default_region_vis_stats();
    for (uint32_t k = 0; k < question->block_count; ++k)
        if (answers[k].done)
            enf_bake_add_counters(&stats, &answers[k].stats);
        else
            return torn ? enf_fail(ENF_ERROR_STATE,
                                   "%s: a record is cut short or damaged, and block %u of %u is missing: do its share again", torn, k,
                                   question->block_count)
                        : enf_fail(ENF_ERROR_STATE, "%s%s: block %u of %u is missing: a share is not there or not finished", path,
                                   several ? " and the other files" : "", k, question->block_count);
    uint8_t *asked = NULL;
    EnfRegionModel *model = NULL;
    EnfStatus status = ENF_OK;
    if (question->asked_count) {
        asked = ENF_NEW(uint8_t, (uint64_t)scene->cell_count + 1);
        if (!asked)
            return enf_fail_memory();
        for (uint32_t i = 0; i < question->asked_count; ++i)
            if (question->asked[i] < scene->cell_count)
                asked[question->asked[i]] = 1;
    }
    status = enf_region_model_create(scene, question->states, question->clearance, NULL, &model);
    stats.method = question->method, stats.cells = scene->cell_count, stats.portals = scene->portal_count;
    stats.clearance = question->clearance;
    stats.blocks = stats.blocks_loaded = question->block_count;
    if (status == ENF_OK)
        status = enf_region_result_create(scene, model, question, asked, answers, &stats, out_result);
    enf_free(asked);
    if (status == ENF_OK && (status = enf_region_result_check(*out_result, path)) != ENF_OK) {
        enf_region_vis_destroy(*out_result);
        *out_result = NULL;
    }
    return status;
}

EnfStatus enf_region_vis_load(const EnfScene *scene, const char *const *paths, uint32_t path_count, EnfRegionVis **out_result) {
    if (!scene || !paths || !path_count || !out_result)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis load: scene, paths or out_result is NULL, or no path");
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "region vis load: the scene isn't committed");
    EnfBakeQuestion about = {.geometry = enf_bake_geometry_hash(scene)}, first;
    about.cell_count = scene->cell_count, about.portal_count = scene->portal_count, about.opening_count = scene->opening_count;
    EnfBlockAnswer *answers = NULL;
    const char *torn = NULL;
    memset(&first, 0, sizeof first);
    EnfStatus status = ENF_OK;
    for (uint32_t k = 0; k < path_count && status == ENF_OK; ++k) {
        int whole = 0;
        status = enf_bake_state_read(paths[k], k ? &first : &about, k ? paths[0] : NULL, k ? NULL : &first, &answers, &whole);
        if (!whole && !torn)
            torn = paths[k];
    }
    if (status == ENF_OK)
        status = make_result(scene, &first, answers, torn, paths[0], path_count > 1, out_result);
    for (uint32_t k = 0; answers && k < first.block_count; ++k)
        enf_block_answer_free(&answers[k]);
    enf_free(answers);
    enf_bake_question_free(&first);
    return status;
}
