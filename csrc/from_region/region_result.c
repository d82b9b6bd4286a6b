/* SPDX-License-Identifier: GPL-3.0-or-later
 * The finished answer: sparse rows with a status and a sightline a pair, and the questions asked of them. */
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "from_region/region_result.h"
#include "geometry/vec3.h"

static uint8_t status_of(uint32_t slot) {
    if (slot == ENF_SLOT_UNDECIDED)
        return ENF_PAIR_UNDECIDED;
    return enf_slot_is_grazing(slot) ? ENF_PAIR_GRAZING : ENF_PAIR_VISIBLE;
}

/* All lines in the order of blocks, and where each block's begin. */
static EnfStatus join_lines(EnfRegionVis *r, const EnfBlockAnswer *answers, uint32_t block_count, uint32_t *offset) {
    uint64_t lines = 0, portals = 0;
    for (uint32_t b = 0; b < block_count; ++b) {
        offset[b] = (uint32_t)lines;
        lines += answers[b].lines.count, portals += answers[b].lines.portal_total;
    }
    if (lines >= ENF_SLOT_GRAZING || portals > UINT32_MAX)
        return enf_fail(ENF_ERROR_OUT_OF_MEMORY, "region vis: %llu sightlines are more than a result can hold", (unsigned long long)lines);
    EnfLineStore *to = &r->lines;
    if (!ENF_RESERVE(to->lines, lines + 1) || !ENF_RESERVE(to->portals, portals + 1))
        return enf_fail_memory();
    for (uint32_t b = 0; b < block_count; ++b) {
        const EnfLineStore *from = &answers[b].lines;
        for (uint32_t i = 0; i < from->count; ++i) {
            to->lines[to->count] = from->lines[i];
            to->lines[to->count++].portal_first += to->portal_total;
        }
        if (from->portal_total)
            memcpy(to->portals + to->portal_total, from->portals, from->portal_total * sizeof *to->portals);
        to->portal_total += from->portal_total;
    }
    return ENF_OK;
}

typedef struct Entry {
    uint32_t cell, line;
    uint8_t status;
} Entry;

/* Entries of all rows in the order in which pairs come; at: [cells + 1], zeroed, gets where each row ends. */
static EnfStatus spread_pairs(uint32_t cells, const EnfBlockAnswer *answers, uint32_t block_count, const uint32_t *line_offset,
                              uint64_t *at, Entry **out_entries) {
    uint64_t total = 0;
    for (uint32_t b = 0; b < block_count; ++b)
        for (uint32_t k = 0; k < answers[b].pair_count; ++k)
            ++at[answers[b].pairs[k][0]], ++at[answers[b].pairs[k][1]];
    for (uint32_t i = 0; i < cells; ++i) {
        uint64_t size = at[i] + 1; /* the diagonal */
        at[i] = total, total += size;
    }
    Entry *entries = *out_entries = enf_alloc((total + 1) * sizeof *entries);
    if (!entries)
        return enf_fail_memory();
    for (uint32_t i = 0; i < cells; ++i)
        entries[at[i]++] = (Entry){i, ENF_NONE, ENF_PAIR_VISIBLE};
    for (uint32_t b = 0; b < block_count; ++b)
        for (uint32_t k = 0; k < answers[b].pair_count; ++k) {
            const uint32_t *pair = answers[b].pairs[k];
            Entry entry = {pair[1], ENF_NONE, status_of(pair[2])};
            if (entry.status != ENF_PAIR_UNDECIDED)
                entry.line = (pair[2] & ~ENF_SLOT_GRAZING) - 1 + line_offset[b];
            entries[at[pair[0]]++] = entry;
            entry.cell = pair[0];
            entries[at[pair[1]]++] = entry;
        }
    return ENF_OK;
}

/* The rows asked for, read off by the other cell: the relation is symmetric, so each comes out ascending, without sorting. end: of the
 * spread rows. Gives in *out_rows how many there are. */
static EnfStatus read_off_rows(EnfRegionVis *r, const Entry *entries, const uint64_t *end, const uint8_t *asked, uint64_t *out_rows) {
    uint32_t n = r->cell_count;
    uint64_t kept = 0, rows = 0;
    for (uint32_t i = 0; i < n; ++i) {
        r->first[i] = kept;
        if (asked && !asked[i])
            continue;
        kept += end[i] - (i ? end[i - 1] : 0);
        ++rows;
    }
    r->first[n] = kept;
    r->cells = enf_alloc((kept + 1) * sizeof *r->cells);
    r->status = enf_alloc(kept + 1);
    r->line = enf_alloc((kept + 1) * sizeof *r->line);
    uint64_t *to = ENF_NEW(uint64_t, (uint64_t)n + 1);
    if (!r->cells || !r->status || !r->line || !to) {
        enf_free(to);
        return enf_fail_memory();
    }
    memcpy(to, r->first, n * sizeof *to);
    for (uint32_t i = 0; i < n; ++i)
        for (uint64_t k = i ? end[i - 1] : 0; k < end[i]; ++k)
            if (!asked || asked[entries[k].cell]) {
                uint64_t place = to[entries[k].cell]++;
                r->cells[place] = i, r->status[place] = entries[k].status, r->line[place] = entries[k].line;
            }
    enf_free(to);
    *out_rows = rows;
    return ENF_OK;
}

static void count_pairs(EnfRegionVis *r, uint64_t rows) {
    EnfRegionVisStats *stats = &r->stats;
    uint64_t kept = r->first[r->cell_count];
    for (uint64_t k = 0; k < kept; ++k)
        if (r->status[k] == ENF_PAIR_VISIBLE)
            ++stats->proven_pairs;
        else if (r->status[k] == ENF_PAIR_GRAZING)
            ++stats->grazing_pairs;
        else
            ++stats->undecided_pairs;
    stats->visible_pairs = kept;
    stats->skipped_cells = r->cell_count - rows;
    stats->hidden_certified = stats->method == ENF_REGION_SAMPLE || stats->partial ? 0 : rows * r->cell_count - kept;
}

static EnfStatus fill_rows(EnfRegionVis *r, const EnfBlockAnswer *answers, uint32_t block_count, const uint8_t *asked) {
    uint32_t *line_offset = ENF_NEW(uint32_t, (uint64_t)block_count + 1);
    uint64_t rows = 0, *at = ENF_NEW(uint64_t, (uint64_t)r->cell_count + 1);
    Entry *entries = NULL;
    EnfStatus status = line_offset && at ? join_lines(r, answers, block_count, line_offset) : enf_fail_memory();
    if (status == ENF_OK)
        status = spread_pairs(r->cell_count, answers, block_count, line_offset, at, &entries);
    if (status == ENF_OK)
        status = read_off_rows(r, entries, at, asked, &rows);
    if (status == ENF_OK)
        count_pairs(r, rows);
    enf_free(line_offset), enf_free(at), enf_free(entries);
    return status;
}

static EnfStatus list_room_cells(EnfRegionVis *r) {
    const EnfScene *scene = r->scene;
    r->room_first = ENF_NEW(uint32_t, (uint64_t)scene->room_count + 2);
    r->room_cells = ENF_NEW(uint32_t, (uint64_t)scene->cell_count + 1);
    if (!r->room_first || !r->room_cells)
        return enf_fail_memory();
    for (uint32_t c = 0; c < scene->cell_count; ++c)
        if (scene->cell_rooms[c] != ENF_NONE)
            ++r->room_first[scene->cell_rooms[c] + 1];
    for (uint32_t k = 0; k < scene->room_count; ++k)
        r->room_first[k + 1] += r->room_first[k];
    for (uint32_t c = 0; c < scene->cell_count; ++c)
        if (scene->cell_rooms[c] != ENF_NONE)
            r->room_cells[r->room_first[scene->cell_rooms[c]]++] = c;
    for (uint32_t k = scene->room_count; k > 0; --k)
        r->room_first[k] = r->room_first[k - 1];
    r->room_first[0] = 0;
    return ENF_OK;
}

EnfStatus enf_region_result_create(const EnfScene *scene, EnfRegionModel *model, const EnfBakeQuestion *question, const uint8_t *asked,
                                   const EnfBlockAnswer *answers, const EnfRegionVisStats *stats, EnfRegionVis **out_result) {
    EnfRegionVis *r = ENF_NEW(EnfRegionVis, 1);
    if (!r) {
        enf_region_model_destroy(model);
        return enf_fail_memory();
    }
    r->scene = scene, r->model = model, r->stats = *stats;
    r->cell_count = scene->cell_count;
    r->first = ENF_NEW(uint64_t, (uint64_t)r->cell_count + 1);
    EnfStatus status = r->first ? enf_bake_question_copy(&r->question, question) : enf_fail_memory();
    if (status == ENF_OK)
        status = fill_rows(r, answers, question->block_count, asked);
    if (status == ENF_OK)
        status = list_room_cells(r);
    if (status != ENF_OK) {
        enf_region_vis_destroy(r);
        return status;
    }
    *out_result = r;
    return ENF_OK;
}

void enf_region_vis_destroy(EnfRegionVis *r) {
    if (!r)
        return;
    enf_region_model_destroy(r->model);
    enf_bake_question_free(&r->question);
    enf_line_store_free(&r->lines);
    enf_free(r->first), enf_free(r->cells), enf_free(r->status), enf_free(r->line);
    enf_free(r->room_first), enf_free(r->room_cells);
    enf_free(r);
}

uint32_t enf_region_vis_cell_count(const EnfRegionVis *r) {
    return r ? r->cell_count : 0;
}
const uint64_t *enf_region_vis_row_first(const EnfRegionVis *r) {
    return r ? r->first : NULL;
}
const uint32_t *enf_region_vis_row_cells(const EnfRegionVis *r) {
    return r ? r->cells : NULL;
}
const uint8_t *enf_region_vis_row_status(const EnfRegionVis *r) {
    return r ? r->status : NULL;
}

uint64_t enf_region_result_find(const EnfRegionVis *r, uint32_t i, uint32_t j) {
    uint64_t low = r->first[i], high = r->first[i + 1];
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        if (r->cells[middle] < j)
            low = middle + 1;
        else
            high = middle;
    }
    return low < r->first[i + 1] && r->cells[low] == j ? low : r->first[r->cell_count];
}

EnfStatus enf_region_vis_pair(const EnfRegionVis *r, uint32_t from, uint32_t to, uint32_t *out_status) {
    if (!r || !out_status)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis pair: result or out_status is NULL");
    if (from >= r->cell_count || to >= r->cell_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis pair: cells %u, %u of %u", from, to, r->cell_count);
    uint64_t at = enf_region_result_find(r, from, to);
    *out_status = at < r->first[r->cell_count] ? r->status[at] : ENF_PAIR_HIDDEN;
    return ENF_OK;
}

int enf_region_result_cut_line(const EnfRegionVis *r, const EnfLine *line, uint32_t from, uint32_t to, uint32_t *out_first,
                               uint32_t *out_last, int *out_backward) {
    const uint32_t(*cells)[2] = (const uint32_t(*)[2])r->scene->portal_cells, *portals = r->lines.portals + line->portal_first;
    for (int backward = 0; backward < 2; ++backward) {
        uint32_t a = backward ? to : from, b = backward ? from : to;
        for (uint32_t i = 0; i < line->portal_count; ++i)
            if (cells[portals[i] >> 1][portals[i] & 1] == a)
                for (uint32_t k = i; k < line->portal_count; ++k)
                    if (cells[portals[k] >> 1][~portals[k] & 1] == b) {
                        *out_first = i, *out_last = k, *out_backward = backward;
                        return 1;
                    }
    }
    return 0;
}

/* Where the line leaves the cell, ahead of t (sign 1) or behind it (-1); t itself for a cell without faces. Model units. */
static double leave_cell(const EnfRegionVis *r, uint32_t cell, const EnfLine *line, double t, double sign) {
    const EnfScene *scene = r->scene;
    double at = 1e300;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; ++f) {
        double slope = sign * vec_dot(scene->face_planes[f].n, line->d);
        if (!(slope > 0))
            continue;
        double ahead = (scene->face_planes[f].d * r->model->scale - vec_dot(scene->face_planes[f].n, line->p)) / slope;
        if (ahead < at)
            at = ahead;
    }
    return at < 1e300 && at > sign * t ? sign * at : t;
}

EnfStatus enf_region_vis_witness(const EnfRegionVis *r, uint32_t from, uint32_t to, double out_segment[6], uint32_t *out_portals,
                                 uint32_t capacity, uint32_t *out_portal_count, double *out_clearance) {
    if (!r || !out_segment || (capacity && !out_portals))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis witness: result, out_segment or out_portals is NULL");
    if (from >= r->cell_count || to >= r->cell_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis witness: cells %u, %u of %u", from, to, r->cell_count);
    uint64_t at = enf_region_result_find(r, from, to);
    if (at >= r->first[r->cell_count] || r->line[at] == ENF_NONE)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis witness: cells %u and %u have no sightline", from, to);
    const EnfRegionModel *m = r->model;
    const EnfLine *line = &r->lines.lines[r->line[at]];
    uint32_t first = 0, last = 0, portals[ENF_WALK_MAX]; /* the model's */
    int backward = 0;
    if (!enf_region_result_cut_line(r, line, from, to, &first, &last, &backward))
        return enf_fail(ENF_ERROR_INTERNAL, "region vis witness: the sightline of cells %u and %u misses them", from, to);
    for (uint32_t i = 0; i < line->portal_count; ++i)
        portals[i] = enf_rm_own_portal(m, r->lines.portals[line->portal_first + i]);
    uint32_t cell0 = backward ? to : from, cell1 = backward ? from : to;
    /* Into the end cells by half the way to the line's next portal, or to the wall; by a hundredth of the clearance where there is
     * neither: cells of portal files have no walls of their own. */
    const double *plane0 = m->plane[portals[first]], *plane1 = m->plane[portals[last]];
    double t0 = (plane0[3] - vec_dot(plane0, line->p)) / vec_dot(plane0, line->d);
    double t1 = (plane1[3] - vec_dot(plane1, line->p)) / vec_dot(plane1, line->d);
    double before = t0 - 0.01 * m->delta / vec_dot(plane0, line->d);
    double after = t1 + 0.01 * m->delta / vec_dot(plane1, line->d);
    double wall0 = leave_cell(r, cell0, line, t0, -1);
    double wall1 = leave_cell(r, cell1, line, t1, 1);
    if (wall0 < before)
        before = 0.5 * (t0 + wall0);
    if (wall1 > after)
        after = 0.5 * (t1 + wall1);
    if (first > 0) {
        const double *plane = m->plane[portals[first - 1]];
        before = 0.5 * (t0 + (plane[3] - vec_dot(plane, line->p)) / vec_dot(plane, line->d));
    }
    if (last + 1 < line->portal_count) {
        const double *plane = m->plane[portals[last + 1]];
        after = 0.5 * (t1 + (plane[3] - vec_dot(plane, line->p)) / vec_dot(plane, line->d));
    }
    for (int k = 0; k < 3; ++k) {
        double a = (line->p[k] + before * line->d[k]) * m->inverse_scale + m->origin[k];
        double b = (line->p[k] + after * line->d[k]) * m->inverse_scale + m->origin[k];
        out_segment[k] = backward ? b : a;
        out_segment[k + 3] = backward ? a : b;
    }
    uint32_t count = last - first + 1;
    for (uint32_t i = 0; i < count && i < capacity; ++i)
        out_portals[i] = r->lines.portals[line->portal_first + (backward ? last - i : first + i)] >> 1;
    if (out_portal_count)
        *out_portal_count = count;
    if (out_clearance)
        *out_clearance = enf_line_clearance(m, line->p, line->d, portals + first, count) * m->inverse_scale;
    return ENF_OK;
}

EnfStatus enf_region_vis_rooms(const EnfRegionVis *r, uint32_t room_a, uint32_t room_b, uint32_t *out_status, uint32_t *out_from,
                               uint32_t *out_to) {
    if (!r || !out_status)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis rooms: result or out_status is NULL");
    if (room_a >= r->scene->room_count || room_b >= r->scene->room_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis rooms: rooms %u, %u of %u", room_a, room_b, r->scene->room_count);
    uint32_t best = ENF_PAIR_HIDDEN, from = ENF_NONE, to = ENF_NONE;
    for (uint32_t i = r->room_first[room_a]; i < r->room_first[room_a + 1] && best != ENF_PAIR_VISIBLE; ++i) {
        uint32_t cell = r->room_cells[i];
        for (uint64_t k = r->first[cell]; k < r->first[cell + 1] && best != ENF_PAIR_VISIBLE; ++k) {
            if (r->scene->cell_rooms[r->cells[k]] != room_b)
                continue;
            /* VISIBLE 1 before GRAZING 2 before UNDECIDED 3 */
            if (best == ENF_PAIR_HIDDEN || r->status[k] < best)
                best = r->status[k], from = cell, to = r->cells[k];
        }
    }
    *out_status = best;
    if (out_from)
        *out_from = from;
    if (out_to)
        *out_to = to;
    return ENF_OK;
}

EnfStatus enf_region_vis_stats(const EnfRegionVis *r, EnfRegionVisStats *out) {
    if (!r || !out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis stats: result or out_stats is NULL");
    if (out->struct_size != sizeof *out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis stats: struct_size is %u, expected %u", out->struct_size,
                        (unsigned)sizeof *out);
    *out = r->stats;
    return ENF_OK;
}
