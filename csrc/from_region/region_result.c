/* SPDX-License-Identifier: GPL-3.0-or-later
 * The finished answer: sparse rows with a status and a sightline a pair, and the questions asked of them. */
#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/number.h"
#include "base/status.h"
#include "from_region/bake.h"
#include "geometry/vec3.h"

struct EnfRegionVis {
    const EnfScene *scene;
    EnfRegionModel *model;
    EnfLineStore lines;
    uint32_t cell_count;
    uint64_t *first;  /* [cells + 1] */
    uint32_t *cells;
    uint8_t *status;
    uint32_t *line;   /* beside cells: line index, ENF_NONE without */
    uint32_t *room_first, *room_cells; /* cells of each room */
    EnfRegionVisStats stats;
};

static uint8_t status_of(uint32_t slot, uint32_t method) {
    if (slot == ENF_SLOT_OPEN) return method == ENF_REGION_SAMPLE ? ENF_PAIR_HIDDEN : ENF_PAIR_UNDECIDED;
    if (slot == ENF_SLOT_HIDDEN) return ENF_PAIR_HIDDEN;
    if (slot == ENF_SLOT_UNDECIDED) return ENF_PAIR_UNDECIDED;
    return enf_slot_is_grazing(slot) ? ENF_PAIR_GRAZING : ENF_PAIR_VISIBLE;
}

static EnfStatus fill_rows(EnfRegionVis *r, EnfRegionBake *bake) {
    const EnfPairTable *table = &bake->table;
    uint32_t n = r->cell_count, method = bake->stats.method;
    EnfRegionVisStats *stats = &bake->stats;
    for (int pass = 0; pass < 2; ++pass) {
        uint64_t total = 0, asked = 0;
        for (uint32_t i = 0; i < n; ++i) {
            r->first[i] = total;
            if (bake->wanted && !bake->wanted[i]) {
                if (pass) ++stats->skipped_cells;
                continue;
            }
            int self = 0;
            asked += n;
            uint64_t b = table->first[i], end = table->first[i + 1];
            for (; b <= end; ++b) {
                uint64_t bits = b < end ? table->bits[b] : 0;
                uint32_t base = b < end ? table->block[b] * 64 : 0;
                for (;;) {
                    uint32_t j = bits ? base + enf_lowest_bit64(bits) : ENF_NONE;
                    if (!self && (j != ENF_NONE ? j > i : b == end)) { /* the diagonal isn't in the table */
                        if (pass) {
                            r->cells[total] = i, r->status[total] = ENF_PAIR_VISIBLE, r->line[total] = ENF_NONE;
                            ++stats->proven_pairs;
                        }
                        ++total, self = 1;
                    }
                    if (!bits) break;
                    bits &= bits - 1;
                    uint32_t slot = *enf_pair_slot(table, i, j);
                    uint8_t status = status_of(slot, method);
                    if (status == ENF_PAIR_HIDDEN) continue;
                    if (pass) {
                        r->cells[total] = j, r->status[total] = status, r->line[total] = ENF_NONE;
                        if (status == ENF_PAIR_VISIBLE) r->line[total] = slot - 1, ++stats->proven_pairs;
                        else if (status == ENF_PAIR_GRAZING)
                            r->line[total] = (slot & ~ENF_SLOT_GRAZING) - 1, ++stats->grazing_pairs;
                        else ++stats->undecided_pairs;
                    }
                    ++total;
                }
            }
        }
        r->first[n] = total;
        if (pass) {
            stats->visible_pairs = total;
            stats->hidden_certified = method == ENF_REGION_SAMPLE ? 0 : asked - total;
        } else {
            r->cells = ENF_NEW(uint32_t, total + 1);
            r->status = ENF_NEW(uint8_t, total + 1);
            r->line = ENF_NEW(uint32_t, total + 1);
            if (!r->cells || !r->status || !r->line) return enf_fail_memory();
        }
    }
    return ENF_OK;
}

static EnfStatus list_room_cells(EnfRegionVis *r) {
    const EnfScene *scene = r->scene;
    r->room_first = ENF_NEW(uint32_t, (uint64_t)scene->room_count + 2);
    r->room_cells = ENF_NEW(uint32_t, (uint64_t)scene->cell_count + 1);
    if (!r->room_first || !r->room_cells) return enf_fail_memory();
    for (uint32_t c = 0; c < scene->cell_count; ++c)
        if (scene->cell_rooms[c] != ENF_NONE) ++r->room_first[scene->cell_rooms[c] + 1];
    for (uint32_t k = 0; k < scene->room_count; ++k) r->room_first[k + 1] += r->room_first[k];
    for (uint32_t c = 0; c < scene->cell_count; ++c)
        if (scene->cell_rooms[c] != ENF_NONE) r->room_cells[r->room_first[scene->cell_rooms[c]]++] = c;
    for (uint32_t k = scene->room_count; k > 0; --k) r->room_first[k] = r->room_first[k - 1];
    r->room_first[0] = 0;
    return ENF_OK;
}

EnfStatus enf_region_result_create(EnfRegionBake *bake, EnfRegionVis **out_result) {
    EnfRegionVis *r = ENF_NEW(EnfRegionVis, 1);
    if (!r) return enf_fail_memory();
    r->scene = bake->scene;
    r->cell_count = bake->scene->cell_count;
    r->first = ENF_NEW(uint64_t, (uint64_t)r->cell_count + 1);
    EnfStatus status = r->first ? fill_rows(r, bake) : enf_fail_memory();
    if (status == ENF_OK) status = list_room_cells(r);
    if (status != ENF_OK) {
        enf_region_vis_destroy(r);
        return status;
    }
    r->model = bake->model, bake->model = NULL;
    r->lines = bake->lines;
    memset(&bake->lines, 0, sizeof bake->lines);
    r->stats = bake->stats;
    *out_result = r;
    return ENF_OK;
}

void enf_region_vis_destroy(EnfRegionVis *r) {
    if (!r) return;
    enf_region_model_destroy(r->model);
    enf_line_store_free(&r->lines);
    enf_free(r->first), enf_free(r->cells), enf_free(r->status), enf_free(r->line);
    enf_free(r->room_first), enf_free(r->room_cells);
    enf_free(r);
}

uint32_t enf_region_vis_cell_count(const EnfRegionVis *r) { return r ? r->cell_count : 0; }
const uint64_t *enf_region_vis_row_first(const EnfRegionVis *r) { return r ? r->first : NULL; }
const uint32_t *enf_region_vis_row_cells(const EnfRegionVis *r) { return r ? r->cells : NULL; }
const uint8_t *enf_region_vis_row_status(const EnfRegionVis *r) { return r ? r->status : NULL; }

/* Where j stands in row i, or the number of entries when it doesn't. */
static uint64_t find_entry(const EnfRegionVis *r, uint32_t i, uint32_t j) {
    uint64_t low = r->first[i], high = r->first[i + 1];
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        if (r->cells[middle] < j) low = middle + 1;
        else high = middle;
    }
    return low < r->first[i + 1] && r->cells[low] == j ? low : r->first[r->cell_count];
}

EnfStatus enf_region_vis_pair(const EnfRegionVis *r, uint32_t from, uint32_t to, uint32_t *out_status) {
    if (!r || !out_status) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis pair: result or out_status is NULL");
    if (from >= r->cell_count || to >= r->cell_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis pair: cells %u, %u of %u", from, to, r->cell_count);
    uint64_t at = find_entry(r, from, to);
    *out_status = at < r->first[r->cell_count] ? r->status[at] : ENF_PAIR_HIDDEN;
    return ENF_OK;
}

/* The part of a line between two of its cells. Gives 0 when it doesn't hold both. */
static int cut_line(const EnfRegionVis *r, const EnfLine *line, uint32_t from, uint32_t to, uint32_t *out_first,
                    uint32_t *out_last, int *out_backward) {
    const EnfRegionModel *m = r->model;
    const uint32_t *portals = r->lines.portals + line->portal_first;
    for (int backward = 0; backward < 2; ++backward) {
        uint32_t a = backward ? to : from, b = backward ? from : to;
        for (uint32_t i = 0; i < line->portal_count; ++i)
            if (enf_rm_from(m, portals[i]) == a)
                for (uint32_t k = i; k < line->portal_count; ++k)
                    if (m->to[portals[k]] == b) {
                        *out_first = i, *out_last = k, *out_backward = backward;
                        return 1;
                    }
    }
    return 0;
}

EnfStatus enf_region_vis_witness(const EnfRegionVis *r, uint32_t from, uint32_t to, double out_segment[6],
                                 uint32_t *out_portals, uint32_t capacity, uint32_t *out_portal_count,
                                 double *out_clearance) {
    if (!r || !out_segment || (capacity && !out_portals))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis witness: result, out_segment or out_portals is NULL");
    if (from >= r->cell_count || to >= r->cell_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis witness: cells %u, %u of %u", from, to, r->cell_count);
    uint64_t at = find_entry(r, from, to);
    if (at >= r->first[r->cell_count] || r->line[at] == ENF_NONE)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis witness: cells %u and %u have no sightline", from, to);
    const EnfRegionModel *m = r->model;
    const EnfLine *line = &r->lines.lines[r->line[at]];
    const uint32_t *portals = r->lines.portals + line->portal_first;
    uint32_t first = 0, last = 0;
    int backward = 0;
    if (!cut_line(r, line, from, to, &first, &last, &backward))
        return enf_fail(ENF_ERROR_INTERNAL, "region vis witness: the sightline of cells %u and %u misses them", from, to);
    /* Into the end cells by half the way to the line's next portal, or a hundredth of the clearance where it has none: cells of
     * portal files have no walls of their own. */
    const double *plane0 = m->plane[portals[first]], *plane1 = m->plane[portals[last]];
    double t0 = (plane0[3] - vec_dot(plane0, line->p)) / vec_dot(plane0, line->d);
    double t1 = (plane1[3] - vec_dot(plane1, line->p)) / vec_dot(plane1, line->d);
    double before = t0 - 0.01 * m->delta / vec_dot(plane0, line->d);
    double after = t1 + 0.01 * m->delta / vec_dot(plane1, line->d);
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
        out_portals[i] = portals[backward ? last - i : first + i] >> 1;
    if (out_portal_count) *out_portal_count = count;
    if (out_clearance)
        *out_clearance = enf_line_clearance(m, line->p, line->d, portals + first, count) * m->inverse_scale;
    return ENF_OK;
}

EnfStatus enf_region_vis_rooms(const EnfRegionVis *r, uint32_t room_a, uint32_t room_b, uint32_t *out_status,
                               uint32_t *out_from, uint32_t *out_to) {
    if (!r || !out_status) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis rooms: result or out_status is NULL");
    if (room_a >= r->scene->room_count || room_b >= r->scene->room_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis rooms: rooms %u, %u of %u", room_a, room_b,
                        r->scene->room_count);
    uint32_t best = ENF_PAIR_HIDDEN, from = ENF_NONE, to = ENF_NONE;
    for (uint32_t i = r->room_first[room_a]; i < r->room_first[room_a + 1] && best != ENF_PAIR_VISIBLE; ++i) {
        uint32_t cell = r->room_cells[i];
        for (uint64_t k = r->first[cell]; k < r->first[cell + 1] && best != ENF_PAIR_VISIBLE; ++k) {
            if (r->scene->cell_rooms[r->cells[k]] != room_b) continue;
            /* VISIBLE 1 before GRAZING 2 before UNDECIDED 3 */
            if (best == ENF_PAIR_HIDDEN || r->status[k] < best) best = r->status[k], from = cell, to = r->cells[k];
        }
    }
    *out_status = best;
    if (out_from) *out_from = from;
    if (out_to) *out_to = to;
    return ENF_OK;
}

/* Whether the line of an entry, from where it enters `cell` to where it leaves it, meets the box (metres). Cells without
 * faces can't tell where a line ends in them. */
static int sightline_hits(const EnfRegionVis *r, uint64_t at, uint32_t from, uint32_t cell, const double box[6]) {
    const EnfScene *scene = r->scene;
    uint32_t first, last;
    int backward;
    if (scene->cell_face_first[cell] == scene->cell_face_first[cell + 1] || r->line[at] == ENF_NONE) return 0;
    const EnfLine *line = &r->lines.lines[r->line[at]];
    if (!cut_line(r, line, from, cell, &first, &last, &backward)) return 0;
    const EnfRegionModel *m = r->model;
    const double *plane = m->plane[r->lines.portals[line->portal_first + (backward ? first : last)]];
    double sign = backward ? -1 : 1, d[3], p[3];
    double low = sign * (plane[3] - vec_dot(plane, line->p)) / vec_dot(plane, line->d) * m->inverse_scale, high = 1e300;
    for (int k = 0; k < 3; ++k) d[k] = sign * line->d[k], p[k] = line->p[k] * m->inverse_scale;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; ++f) {
        double slope = vec_dot(scene->face_planes[f].n, d);
        if (slope > 0) high = fmin(high, (scene->face_planes[f].d - vec_dot(scene->face_planes[f].n, p)) / slope);
    }
    for (int k = 0; k < 3; ++k) {
        double near_side = box[k] - m->origin[k] - p[k], far_side = box[k + 3] - m->origin[k] - p[k];
        if (d[k] == 0) {
            if (near_side > 0 || far_side < 0) return 0;
            continue;
        }
        double t0 = near_side / d[k], t1 = far_side / d[k];
        low = fmax(low, fmin(t0, t1)), high = fmin(high, fmax(t0, t1));
    }
    return low < high;
}

EnfStatus enf_region_vis_object(const EnfRegionVis *r, uint32_t from, uint32_t object, uint32_t *out_status,
                                uint32_t *out_cell) {
    if (!r || !out_status) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis object: result or out_status is NULL");
    if (from >= r->cell_count || object >= r->scene->object_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis object: cell %u of %u, object %u of %u", from,
                        r->cell_count, object, r->scene->object_count);
    const uint32_t *cells = NULL;
    uint32_t count = 0, best = ENF_PAIR_HIDDEN, best_cell = ENF_NONE;
    EnfStatus status = enf_scene_object_cells(r->scene, object, &cells, &count);
    if (status != ENF_OK) return status;
    if (!count) best = ENF_PAIR_UNDECIDED;
    for (uint32_t i = 0; i < count && best != ENF_PAIR_VISIBLE; ++i) {
        uint64_t at = find_entry(r, from, cells[i]);
        if (at >= r->first[r->cell_count]) continue;
        uint32_t found = r->status[at];
        if (found == ENF_PAIR_VISIBLE && cells[i] != from &&
            !sightline_hits(r, at, from, cells[i], r->scene->objects[object].bounds))
            found = ENF_PAIR_UNDECIDED;
        if (best == ENF_PAIR_HIDDEN || found < best) best = found, best_cell = cells[i];
    }
    *out_status = best;
    if (out_cell) *out_cell = best_cell;
    return ENF_OK;
}

EnfStatus enf_region_vis_stats(const EnfRegionVis *r, EnfRegionVisStats *out) {
    if (!r || !out) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis stats: result or out_stats is NULL");
    if (out->struct_size != sizeof *out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "region vis stats: struct_size is %u, expected %u",
                        out->struct_size, (unsigned)sizeof *out);
    *out = r->stats;
    return ENF_OK;
}

EnfStatus enf_region_vis_write_matrix(const EnfRegionVis *r, const char *path) {
    if (!r || !path) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "write matrix: result or path is NULL");
    EnfFileWriter writer;
    EnfStatus status = enf_file_write_begin(&writer, path);
    if (status != ENF_OK) return status;
    for (uint32_t i = 0; i < r->cell_count; ++i) {
        for (uint64_t k = r->first[i]; k < r->first[i + 1]; ++k)
            fprintf(writer.file, k == r->first[i] ? "%u" : " %u", r->cells[k]);
        fputc('\n', writer.file);
    }
    return enf_file_write_end(&writer, !ferror(writer.file));
}

EnfStatus enf_region_vis_write_witnesses(const EnfRegionVis *r, const char *path) {
    if (!r || !path) return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "write witnesses: result or path is NULL");
    EnfFileWriter writer;
    EnfStatus status = enf_file_write_begin(&writer, path);
    if (status != ENF_OK) return status;
    for (uint32_t i = 0; i < r->cell_count && status == ENF_OK; ++i)
        for (uint64_t k = r->first[i]; k < r->first[i + 1] && status == ENF_OK; ++k) {
            uint32_t j = r->cells[k];
            double segment[6];
            /* Each pair once; where only one row was asked for, its own direction. A grazing pair's line touches or misses an edge: no
             * proof, so it isn't here (enf_region_vis_witness gives it). */
            if (j == i || r->line[k] == ENF_NONE || r->status[k] != ENF_PAIR_VISIBLE || (j < i && r->first[j + 1] > r->first[j])) continue;
            status = enf_region_vis_witness(r, i, j, segment, NULL, 0, NULL, NULL);
            if (status != ENF_OK) break;
            fprintf(writer.file, "%u %u", i, j);
            for (int c = 0; c < 6; ++c) {
                char text[32];
                enf_number_format(text, segment[c]);
                fprintf(writer.file, " %s", text);
            }
            fputc('\n', writer.file);
        }
    EnfStatus end = enf_file_write_end(&writer, status == ENF_OK && !ferror(writer.file));
    return status != ENF_OK ? status : end;
}
