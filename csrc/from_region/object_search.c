/* SPDX-License-Identifier: GPL-3.0-or-later
 * Objects as targets: is this chair ever seen from that room, and through what?
 *
 * A line that meets an object's box in a cell enters it by one of the box's faces, or enters the cell inside of the box. So
 * from each source the chains are followed towards the cells that hold undecided objects; where one arrives, each
 * face that may be entered is put behind it as one more portal, and the chain test decides. A face's outer polygon reaches as far
 * beyond the cell's walls as placement lets objects (0.1 m), so that what is certified hidden is; a witness counts only when
 * it meets the box within the cell itself. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "from_region/might_see.h"
#include "from_region/region_result.h"
#include "from_region/search_worker.h"
#include "geometry/polygon.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"

/* An object in one of its cells. */
typedef struct Placed {
    uint32_t object, cell;
    uint32_t face_first, face_count; /* portals of the extended model */
    float box[6];                    /* model units, centre and half size, rounded outward */
} Placed;

/* Rows searched before they are packed: what a row needs meanwhile is as long as there are objects. */
#define ROWS_AT_ONCE 64

typedef struct Row {
    uint8_t *state; /* [placed] ENF_PAIR_* */
    uint32_t *line; /* [placed] ENF_NONE: none */
    EnfLineStore lines;
    EnfStatus status;
} Row;

struct EnfObjectVis {
    const EnfRegionVis *result;
    const EnfRegionModel *whole; /* the result's, or `made` where that one is a part */
    EnfRegionModel *made;
    EnfRegionModel model; /* the whole, with the faces as further portals */
    uint32_t placed_count;
    Placed *placed;         /* by cell, by object in a cell */
    uint32_t *placed_first; /* [cells + 1] */
    uint32_t row_count, *from;
    uint8_t *asked;             /* [objects] */
    Row rows_raw[ROWS_AT_ONCE]; /* while the search runs */
    uint32_t row_at;            /* row of rows_raw[0] */
    uint64_t *first;            /* [rows + 1] */
    uint32_t *objects, *cells, *line;
    uint8_t *status;
    EnfLineStore lines;
};

/* One source's search. */
typedef struct Look {
    EnfObjectVis *vis;
    Row *row;
} Look;

/* ---- The extended model ------------------------------------------------------------------------------------ */
/* Corners of the box's side k (0: low, 1: high) across axis a, counter-clockwise about the outward normal. */
static void box_side(const double box[6], int a, int k, double (*out)[3]) {
    int u = (a + 1) % 3, v = (a + 2) % 3;
    for (int i = 0; i < 4; ++i) {
        int at = k ? i : 3 - i;
        out[i][a] = box[a + 3 * k];
        out[i][u] = box[u + (at == 1 || at == 2 ? 3 : 0)];
        out[i][v] = box[v + (at >= 2 ? 3 : 0)];
    }
}

/* The part of a face within the cell's planes moved out by the margin. Gives its number of corners, 0: nothing. */
static uint32_t clip_to_cell(const EnfScene *scene, uint32_t cell, double (*polygon)[3], uint32_t count, double (*other)[3],
                             uint32_t room) {
    double margin = ENF_CONTACT_MARGIN_METRES;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1] && count; ++f) {
        uint32_t back = 0, front = 0;
        if (count + 1 > room)
            return count; /* larger than need be: safe */
        int beyond = 0;
        for (uint32_t i = 0; i < count; ++i)
            beyond |= vec_dot(scene->face_planes[f].n, polygon[i]) > scene->face_planes[f].d + margin;
        if (!beyond)
            continue;
        enf_polygon_split(polygon, count, scene->face_planes[f].n, scene->face_planes[f].d + margin, scene->tolerance, other, &back, NULL,
                          &front);
        memcpy(polygon, other, back * sizeof *polygon);
        count = back;
    }
    return count;
}

static int add_face(EnfObjectVis *vis, double (*polygon)[3], uint32_t count, const double inward[3]) {
    EnfRegionModel *m = &vis->model;
    uint32_t p = m->portal_count, first = m->raw.first[p];
    double n[3];
    if (!(enf_polygon_normal(n, polygon, count) > 0))
        return 1; /* a flat box has sides without area */
    if (!ENF_RESERVE(m->raw.first, (uint64_t)p + 2) || !ENF_RESERVE(m->raw.vertices, (uint64_t)first + count) ||
        !ENF_RESERVE(m->plane, 2 * (uint64_t)p + 2) || !ENF_RESERVE(m->passes, (uint64_t)p + 1) || !ENF_RESERVE(m->to, 2 * (uint64_t)p + 2))
        return 0;
    /* Counter-clockwise about the outward normal is clockwise about the way in: as raw polygons run. */
    for (uint32_t i = 0; i < count; ++i)
        vec_scale(m->raw.vertices[first + i], m->scale, polygon[i]);
    m->raw.first[p + 1] = first + count;
    vec_copy(m->plane[2 * p], inward);
    m->plane[2 * p][3] = vec_dot(inward, m->raw.vertices[first]);
    for (int k = 0; k < 4; ++k)
        m->plane[2 * p + 1][k] = -m->plane[2 * p][k];
    m->passes[p] = 1;
    m->to[2 * p] = m->to[2 * p + 1] = ENF_NONE;
    m->portal_count = p + 1;
    return 1;
}

#define FACE_ROOM 64
static int add_faces(EnfObjectVis *vis, Placed *placed) {
    const EnfScene *scene = vis->result->scene;
    const EnfRegionModel *m = vis->whole;
    double box[6], polygon[FACE_ROOM][3], other[FACE_ROOM][3];
    for (int k = 0; k < 3; ++k) {
        box[k] = scene->objects[placed->object].bounds[k] - m->origin[k];
        box[k + 3] = scene->objects[placed->object].bounds[k + 3] - m->origin[k];
        double low = box[k] * m->scale, high = box[k + 3] * m->scale;
        placed->box[k] = (float)(0.5 * (low + high));
        placed->box[k + 3] = nextafterf((float)(fmax(high - placed->box[k], placed->box[k] - low)), INFINITY);
    }
    placed->face_first = vis->model.portal_count;
    for (int a = 0; a < 3; ++a)
        for (int k = 0; k < 2; ++k) {
            double inward[3] = {0, 0, 0};
            inward[a] = k ? -1 : 1;
            box_side(box, a, k, polygon);
            uint32_t count = clip_to_cell(scene, placed->cell, polygon, 4, other, FACE_ROOM);
            if (count >= 3 && !add_face(vis, polygon, count, inward))
                return 0;
        }
    placed->face_count = vis->model.portal_count - placed->face_first;
    return 1;
}

#define CLONE(field, count)                                                                                                                \
    do {                                                                                                                                   \
        to->field = enf_alloc(((count) + 1) * sizeof *to->field);                                                                          \
        if (!to->field)                                                                                                                    \
            return 0;                                                                                                                      \
        memcpy(to->field, from->field, (count) * sizeof *to->field);                                                                       \
    } while (0)

/* What the chain test reads of a model; polygons and bounds are computed anew, with those of the faces. */
static int clone_model(EnfRegionModel *to, const EnfRegionModel *from) {
    uint64_t portals = from->portal_count;
    memset(to, 0, sizeof *to);
    to->scene = from->scene, to->kernel = from->kernel;
    to->cell_count = from->cell_count, to->portal_count = from->portal_count;
    memcpy(to->origin, from->origin, sizeof to->origin);
    to->scale = from->scale, to->inverse_scale = from->inverse_scale;
    to->delta = from->delta, to->touch = from->touch, to->order_slack = from->order_slack;
    CLONE(passes, portals);
    CLONE(plane, 2 * portals);
    CLONE(to, 2 * portals);
    CLONE(raw.first, portals + 1);
    CLONE(raw.vertices, from->raw.first[portals]);
    return 1;
}

static EnfStatus place_objects(EnfObjectVis *vis, const uint32_t *objects, uint32_t object_count) {
    const EnfScene *scene = vis->result->scene;
    uint32_t n = scene->cell_count;
    vis->asked = ENF_NEW(uint8_t, (uint64_t)scene->object_count + 1);
    vis->placed_first = ENF_NEW(uint32_t, (uint64_t)n + 2);
    if (!vis->asked || !vis->placed_first || !clone_model(&vis->model, vis->whole))
        return enf_fail_memory();
    for (uint32_t i = 0; i < (objects ? object_count : scene->object_count); ++i)
        vis->asked[objects ? objects[i] : i] = 1;
    for (uint32_t c = 0; c < n; ++c) {
        vis->placed_first[c] = vis->placed_count;
        for (uint32_t i = scene->cell_object_first[c]; i < scene->cell_object_first[c + 1]; ++i) {
            uint32_t object = scene->cell_object_list[i];
            if (!vis->asked[object])
                continue;
            if (!ENF_RESERVE(vis->placed, (uint64_t)vis->placed_count + 1))
                return enf_fail_memory();
            Placed *placed = &vis->placed[vis->placed_count++];
            memset(placed, 0, sizeof *placed);
            placed->object = object, placed->cell = c;
            if (!add_faces(vis, placed))
                return enf_fail_memory();
        }
    }
    vis->placed_first[n] = vis->placed_count;
    EnfRegionModel *m = &vis->model;
    uint64_t portals = m->portal_count;
    double *deviation = ENF_NEW(double, portals + 1);
    m->outer.first = ENF_NEW(uint32_t, portals + 1);
    m->inner.first = ENF_NEW(uint32_t, portals + 1);
    m->centre = enf_alloc_array(portals + 1, sizeof *m->centre);
    m->radius = ENF_NEW(double, portals + 1);
    m->box = enf_alloc_array(portals + 1, sizeof *m->box);
    EnfStatus status = deviation && m->outer.first && m->inner.first && m->centre && m->radius && m->box ? ENF_OK : enf_fail_memory();
    if (status == ENF_OK) {
        memcpy(deviation, scene->portal_deviation, scene->portal_count * sizeof *deviation);
        status = enf_region_model_shape_portals(m, deviation);
    }
    enf_free(deviation);
    return status;
}

/* ---- One source -------------------------------------------------------------------------------------------- */
static void settle(Look *look, uint32_t at, uint8_t state, const double p[3], const double d[3], const uint32_t *portals, uint32_t count) {
    Row *row = look->row;
    if (state != ENF_PAIR_UNDECIDED && !enf_line_store_add(&row->lines, p, d, portals, count)) {
        row->status = ENF_ERROR_OUT_OF_MEMORY;
        return;
    }
    row->state[at] = state;
    row->line[at] = state == ENF_PAIR_UNDECIDED ? ENF_NONE : row->lines.count - 1;
}

/* What the chain shows of one object. */
static void test_object(EnfSearchWorker *w, Look *look, uint32_t at, uint32_t count, const EnfWindow *source, const EnfWindow *target,
                        const EnfHalfspaces *planes) {
    EnfObjectVis *vis = look->vis;
    const EnfRegionModel *m = vis->whole;
    const Placed *placed = &vis->placed[at];
    uint32_t last = w->chain[count - 1], portals[ENF_CHAIN_MAX + 2];
    double p[3], d[3], t;
    uint64_t cuts;
    if (!w->m->kernel->touches(planes, placed->box, &cuts))
        return;
    /* A box that reaches into the portal may be entered by no face at all: then any line into the cell may meet it. */
    const float *hole = vis->model.box[last >> 1];
    int inside = !placed->face_count;
    if (!inside) {
        inside = 1;
        for (int k = 0; k < 3; ++k)
            inside &= fabsf(hole[k] - placed->box[k]) <= (hole[k + 3] + placed->box[k + 3]) * 1.000001f;
    }
    if (inside) {
        EnfChain chain = {w->chain, count, source, target};
        uint32_t state = enf_chain_test(w->m, &chain, w->stab, &w->out->stats, p, d);
        if (state == ENF_CHAIN_HIDDEN)
            return;
        if (state == ENF_CHAIN_VISIBLE && vec_normalize(d) > 0 && enf_line_meets_object(m, p, d, last, placed->cell, placed->object, &t)) {
            settle(look, at, ENF_PAIR_VISIBLE, p, d, w->chain, count);
            return;
        }
        if (!look->row->state[at])
            settle(look, at, ENF_PAIR_UNDECIDED, NULL, NULL, NULL, 0);
    }
    memcpy(portals, w->chain, count * sizeof *portals);
    for (uint32_t f = placed->face_first; f < placed->face_first + placed->face_count; ++f) {
        EnfWindow face;
        portals[count] = 2 * f;
        if (!enf_window_load(&vis->model, 2 * f, &face))
            face.count = 0;
        EnfChain chain = {portals, count + 1, source, &face};
        uint32_t state = enf_chain_test(&vis->model, &chain, w->stab, &w->out->stats, p, d);
        if (state == ENF_CHAIN_HIDDEN)
            continue;
        int met =
            state != ENF_CHAIN_UNDECIDED && vec_normalize(d) > 0 && enf_line_meets_object(m, p, d, last, placed->cell, placed->object, &t);
        if (state == ENF_CHAIN_VISIBLE && met) {
            settle(look, at, ENF_PAIR_VISIBLE, p, d, w->chain, count);
            return;
        }
        if (state == ENF_CHAIN_GRAZING && met && look->row->state[at] != ENF_PAIR_GRAZING)
            settle(look, at, ENF_PAIR_GRAZING, p, d, w->chain, count);
        else if (!look->row->state[at])
            settle(look, at, ENF_PAIR_UNDECIDED, NULL, NULL, NULL, 0);
    }
}

/* A chain has arrived in a cell with undecided objects. */
static uint32_t look_into(EnfSearchWorker *w, uint32_t count, const EnfWindow *source, const EnfWindow *target) {
    Look *look = w->on_reach_context;
    EnfObjectVis *vis = look->vis;
    uint32_t last = w->chain[count - 1], cell = w->m->to[last];
    EnfHalfspaces planes;
    EnfWindow none;
    none.count = 0;
    enf_window_planes(w, w->chain[0], last, source, target ? target : &none, &planes);
    int open = 0;
    for (uint32_t at = vis->placed_first[cell]; at < vis->placed_first[cell + 1]; ++at) {
        if (look->row->state[at] == ENF_PAIR_VISIBLE)
            continue;
        test_object(w, look, at, count, source, target, &planes);
        open |= look->row->state[at] != ENF_PAIR_VISIBLE;
    }
    if (!open)
        enf_search_close_target(w, cell);
    if (look->row->status != ENF_OK)
        w->stop = 1;
    return ENF_CHAIN_UNDECIDED;
}

/* Objects that the sightlines of the result meet already. Gives whether any in this cell is left. */
static int try_sightline(Look *look, uint32_t from, uint64_t entry) {
    EnfObjectVis *vis = look->vis;
    const EnfRegionVis *r = vis->result;
    uint32_t cell = r->cells[entry], first = 0, last = 0;
    int backward = 0, left = 0, known = 0;
    const EnfLine *line = r->line[entry] == ENF_NONE ? NULL : &r->lines.lines[r->line[entry]];
    uint32_t portals[ENF_WALK_MAX];
    double d[3];
    if (line && r->status[entry] == ENF_PAIR_VISIBLE && enf_region_result_cut_line(r, line, from, cell, &first, &last, &backward)) {
        const uint32_t *own = r->lines.portals + line->portal_first;
        known = 1;
        for (uint32_t k = first; k <= last; ++k)
            portals[k - first] = backward ? enf_rm_reverse(own[first + last - k]) : own[k];
        vec_scale(d, backward ? -1 : 1, line->d);
        known = vec_normalize(d) > 0;
    }
    for (uint32_t at = vis->placed_first[cell]; at < vis->placed_first[cell + 1]; ++at) {
        double t;
        if (known && enf_line_meets_object(vis->whole, line->p, d, portals[last - first], cell, vis->placed[at].object, &t))
            settle(look, at, ENF_PAIR_VISIBLE, line->p, d, portals, last - first + 1);
        else
            left = 1;
    }
    return left;
}

/* The search proper, towards the cells whose pairs stand open in the block's table. */
static EnfStatus search(EnfRegionBake *block, Look *look, uint32_t from) {
    const EnfRegionVis *r = look->vis->result;
    EnfSearchWorker *w = ENF_NEW(EnfSearchWorker, 1);
    uint32_t *rank = ENF_NEW(uint32_t, (uint64_t)r->cell_count + 1);
    EnfFound found;
    memset(&found, 0, sizeof found);
    EnfPairTable *table = &block->table;
    EnfStatus status = w && rank ? ENF_OK : enf_fail_memory();
    uint32_t widest = (uint32_t)(table->first[from + 1] - table->first[from]);
    if (status == ENF_OK && !enf_search_worker_create(w, block, widest))
        status = enf_fail_memory();
    if (status == ENF_OK) {
        for (uint32_t c = 0; c < r->cell_count; ++c)
            rank[c] = c != from;
        EnfSearchState seen = {table->slots, block->might->bits};
        w->on_reach = look_into, w->on_reach_context = look;
        enf_search_source(w, from, rank, &seen, &found);
        if (found.failed)
            status = enf_fail_memory();
        else if (look->row->status != ENF_OK)
            status = enf_fail_memory();
    }
    if (status == ENF_OK && (found.capped || found.stopped)) /* what wasn't seen by then isn't known hidden */
        for (uint32_t i = 0; i < found.finding_count; ++i)
            for (uint32_t at = look->vis->placed_first[found.findings[i].cell]; at < look->vis->placed_first[found.findings[i].cell + 1];
                 ++at)
                if (look->row->state[at] == ENF_PAIR_HIDDEN)
                    settle(look, at, ENF_PAIR_UNDECIDED, NULL, NULL, NULL, 0);
    if (w)
        enf_search_worker_free(w);
    enf_free(w), enf_free(rank);
    enf_found_free(&found);
    return status;
}

static void look_from_cell(void *context, uint64_t task, uint32_t thread) {
    EnfObjectVis *vis = context;
    const EnfRegionVis *r = vis->result;
    Row *row = &vis->rows_raw[task];
    Look look = {vis, row};
    uint32_t from = vis->from[vis->row_at + task], n = r->cell_count, left = 0;
    (void)thread;
    row->state = ENF_NEW(uint8_t, (uint64_t)vis->placed_count + 1);
    row->line = ENF_NEW(uint32_t, (uint64_t)vis->placed_count + 1);
    uint8_t *wanted = ENF_NEW(uint8_t, (uint64_t)n + 1), *open = ENF_NEW(uint8_t, (uint64_t)n + 1);
    row->status = row->state && row->line && wanted && open ? ENF_OK : ENF_ERROR_OUT_OF_MEMORY;
    EnfRegionBake block = {.scene = r->scene, .model = vis->whole, .wanted = wanted};
    block.def = enf_default_region_vis_def();
    block.stats = enf_default_region_vis_stats();
    block.stats.threads = 1;
    if (row->status == ENF_OK) {
        for (uint32_t at = 0; at < vis->placed_count; ++at)
            row->line[at] = ENF_NONE;
        for (uint32_t at = vis->placed_first[from]; at < vis->placed_first[from + 1]; ++at)
            row->state[at] = ENF_PAIR_VISIBLE;
        wanted[from] = 1;
        for (uint64_t e = r->first[from]; e < r->first[from + 1]; ++e)
            if (r->cells[e] != from && try_sightline(&look, from, e))
                open[r->cells[e]] = 1, ++left;
    }
    if (row->status == ENF_OK && left) {
        row->status = enf_might_see(&block);
        const EnfPairTable *t = &block.table;
        if (row->status == ENF_OK) {
            for (uint64_t b = t->first[from]; b < t->first[from + 1]; ++b)
                for (uint64_t bits = t->bits[b]; bits; bits &= bits - 1) {
                    uint32_t c = t->block[b] * 64 + enf_lowest_bit64(bits);
                    if (!open[c])
                        *enf_pair_slot(t, from, c) = ENF_SLOT_HIDDEN;
                }
            row->status = search(&block, &look, from);
        }
    }
    enf_pair_table_free(&block.table);
    enf_line_store_free(&block.lines);
    enf_might_sets_destroy(block.might);
    enf_free(wanted), enf_free(open);
}

/* ---- Rows -------------------------------------------------------------------------------------------------- */
/* Packs one row and frees it. best: [objects] scratch. */
static EnfStatus pack_row(EnfObjectVis *vis, uint32_t k, Row *row, uint32_t *best) {
    const EnfScene *scene = vis->result->scene;
    uint64_t total = vis->first[k];
    EnfStatus status = row->status == ENF_OK ? ENF_OK : enf_fail_memory();
    memset(best, 0, scene->object_count * sizeof *best); /* placed index + 1 */
    for (uint32_t at = 0; at < vis->placed_count && status == ENF_OK; ++at) {
        uint32_t *b = &best[vis->placed[at].object];
        if (row->state[at] != ENF_PAIR_HIDDEN && (!*b || row->state[at] < row->state[*b - 1])) /* VISIBLE, GRAZING, UNDECIDED */
            *b = at + 1;
    }
    for (uint32_t o = 0; o < scene->object_count && status == ENF_OK; ++o) {
        int nowhere = vis->asked[o] && scene->placed_first[o] == scene->placed_first[o + 1];
        if (!best[o] && !nowhere)
            continue;
        if (!ENF_RESERVE(vis->objects, total + 1) || !ENF_RESERVE(vis->status, total + 1) || !ENF_RESERVE(vis->cells, total + 1) ||
            !ENF_RESERVE(vis->line, total + 1)) {
            status = enf_fail_memory();
            break;
        }
        vis->objects[total] = o;
        vis->status[total] = best[o] ? row->state[best[o] - 1] : ENF_PAIR_UNDECIDED;
        vis->cells[total] = best[o] ? vis->placed[best[o] - 1].cell : ENF_NONE;
        vis->line[total] = best[o] && row->line[best[o] - 1] != ENF_NONE ? row->line[best[o] - 1] + vis->lines.count : ENF_NONE;
        ++total;
    }
    for (uint32_t i = 0; i < row->lines.count && status == ENF_OK; ++i) {
        const EnfLine *l = &row->lines.lines[i];
        if (!enf_line_store_add(&vis->lines, l->p, l->d, row->lines.portals + l->portal_first, l->portal_count))
            status = enf_fail_memory();
    }
    vis->first[k + 1] = total;
    enf_free(row->state), enf_free(row->line);
    enf_line_store_free(&row->lines);
    memset(row, 0, sizeof *row);
    return status;
}

static EnfStatus make_all_rows(EnfObjectVis *vis, uint32_t threads) {
    uint32_t *best = ENF_NEW(uint32_t, (uint64_t)vis->result->scene->object_count + 1);
    EnfStatus status = best ? ENF_OK : enf_fail_memory();
    for (uint32_t at = 0; at < vis->row_count && status == ENF_OK; at += ROWS_AT_ONCE) {
        uint32_t count = vis->row_count - at < ROWS_AT_ONCE ? vis->row_count - at : ROWS_AT_ONCE;
        vis->row_at = at;
        enf_parallel_for(count, threads ? threads : enf_processor_count(), look_from_cell, vis);
        for (uint32_t k = 0; k < count; ++k) {
            EnfStatus packed = pack_row(vis, at + k, &vis->rows_raw[k], best);
            if (status == ENF_OK)
                status = packed;
        }
    }
    enf_free(best);
    return status;
}

EnfStatus enf_object_vis_run(const EnfRegionVis *r, const uint32_t *from_cells, uint32_t from_count, const uint32_t *objects,
                             uint32_t object_count, uint32_t threads, EnfObjectVis **out) {
    if (!r || !out || (from_count && !from_cells) || (object_count && !objects))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object vis: result, out_objects, from_cells or objects is NULL");
    if (r->stats.method != ENF_REGION_EXACT || r->stats.partial)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object vis: wants a whole result of method exact");
    for (uint32_t i = 0; i < from_count; ++i)
        if (from_cells[i] >= r->cell_count || r->first[from_cells[i]] == r->first[from_cells[i] + 1])
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object vis: from_cells[%u] is %u, of which the result has no row", i,
                            from_cells[i]);
    for (uint32_t i = 0; i < object_count; ++i)
        if (objects[i] >= r->scene->object_count)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object vis: objects[%u] is %u of %u", i, objects[i], r->scene->object_count);
    EnfObjectVis *vis = ENF_NEW(EnfObjectVis, 1);
    if (!vis)
        return enf_fail_memory();
    vis->result = r, vis->whole = r->model;
    vis->row_count = from_cells ? from_count : r->cell_count;
    vis->from = ENF_NEW(uint32_t, (uint64_t)vis->row_count + 1);
    vis->first = ENF_NEW(uint64_t, (uint64_t)vis->row_count + 1);
    EnfStatus status = vis->from && vis->first ? ENF_OK : enf_fail_memory();
    for (uint32_t k = 0; k < vis->row_count && status == ENF_OK; ++k)
        vis->from[k] = from_cells ? from_cells[k] : k;
    if (status == ENF_OK && r->model->cell_of) {
        status = enf_region_model_create(r->scene, r->question.states, r->question.clearance, NULL, &vis->made);
        vis->whole = vis->made;
    }
    if (status == ENF_OK)
        status = place_objects(vis, objects, object_count);
    if (status == ENF_OK)
        status = make_all_rows(vis, threads);
    if (status != ENF_OK)
        enf_object_vis_destroy(vis);
    else
        *out = vis;
    return status;
}

void enf_object_vis_destroy(EnfObjectVis *vis) {
    if (!vis)
        return;
    enf_region_model_clear(&vis->model);
    enf_region_model_destroy(vis->made);
    enf_line_store_free(&vis->lines);
    enf_free(vis->placed), enf_free(vis->placed_first), enf_free(vis->from), enf_free(vis->asked);
    enf_free(vis->first), enf_free(vis->objects), enf_free(vis->cells), enf_free(vis->line), enf_free(vis->status);
    enf_free(vis);
}

uint32_t enf_object_vis_row_count(const EnfObjectVis *vis) {
    return vis ? vis->row_count : 0;
}
const uint64_t *enf_object_vis_row_first(const EnfObjectVis *vis) {
    return vis ? vis->first : NULL;
}
const uint32_t *enf_object_vis_row_objects(const EnfObjectVis *vis) {
    return vis ? vis->objects : NULL;
}
const uint8_t *enf_object_vis_row_status(const EnfObjectVis *vis) {
    return vis ? vis->status : NULL;
}
const uint32_t *enf_object_vis_row_cells(const EnfObjectVis *vis) {
    return vis ? vis->cells : NULL;
}

EnfStatus enf_object_vis_witness(const EnfObjectVis *vis, uint64_t entry, double out_segment[6], uint32_t *out_portals, uint32_t capacity,
                                 uint32_t *out_portal_count) {
    if (!vis || !out_segment || (capacity && !out_portals))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object vis witness: objects, out_segment or out_portals is NULL");
    if (entry >= vis->first[vis->row_count])
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object vis witness: entry %llu of %llu", (unsigned long long)entry,
                        (unsigned long long)vis->first[vis->row_count]);
    if (vis->status[entry] == ENF_PAIR_UNDECIDED)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object vis witness: entry %llu is undecided", (unsigned long long)entry);
    const EnfRegionModel *m = vis->whole;
    const double *box = vis->result->scene->objects[vis->objects[entry]].bounds;
    if (vis->line[entry] == ENF_NONE) {
        for (int k = 0; k < 3; ++k)
            out_segment[k] = out_segment[k + 3] = 0.5 * (box[k] + box[k + 3]);
        if (out_portal_count)
            *out_portal_count = 0;
        return ENF_OK;
    }
    const EnfLine *line = &vis->lines.lines[vis->line[entry]];
    const uint32_t *portals = vis->lines.portals + line->portal_first;
    const double *plane = m->plane[portals[0]];
    double slope = vec_dot(plane, line->d), end;
    double start = (plane[3] - vec_dot(plane, line->p)) / slope - 0.01 * m->delta / slope;
    (void)enf_line_meets_object(m, line->p, line->d, portals[line->portal_count - 1], vis->cells[entry], vis->objects[entry], &end);
    for (int k = 0; k < 3; ++k) {
        out_segment[k] = (line->p[k] + start * line->d[k]) * m->inverse_scale + m->origin[k];
        out_segment[k + 3] = (line->p[k] + end * line->d[k]) * m->inverse_scale + m->origin[k];
    }
    for (uint32_t i = 0; i < line->portal_count && i < capacity; ++i)
        out_portals[i] = portals[i] >> 1;
    if (out_portal_count)
        *out_portal_count = line->portal_count;
    return ENF_OK;
}
