/* SPDX-License-Identifier: GPL-3.0-or-later
 * Objects of visible cells seen through the cells' apertures: eight bounds at once against the aperture's planes, the few
 * that remain by separating planes through the eye in double precision.
 *
 * Based on: Mulloni et al. 2007, sections 3.2.3 and 3.2.4 (cell-to-geometry). */
#include "from_point/aperture_planes.h"
#include "from_point/occlusion.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Tangents from the eye to the box's outline in the plane of axes i, j: when all directions of the aperture lie beyond
 * one of them, the plane through eye and box edge (along the third axis) separates them. */
static int tangent_separates(const double lo[3], const double hi[3], int i, int j, const EnfAperturePlanes *planes) {
    /* The corners of the rectangle that are leftmost and rightmost as seen from the origin. */
    double li, lj, ri, rj;
    if (lo[i] > 0) {
        li = lo[j] > 0 ? lo[i] : hi[j] < 0 ? hi[i] : lo[i];
        lj = hi[j];
        ri = lo[j] > 0 ? hi[i] : lo[i];
        rj = lo[j];
    } else if (hi[i] < 0) {
        li = hi[j] < 0 ? hi[i] : lo[j] > 0 ? lo[i] : hi[i];
        lj = lo[j];
        ri = hi[j] < 0 ? lo[i] : hi[i];
        rj = hi[j];
    } else if (lo[j] > 0) {
        li = lo[i];
        lj = lo[j];
        ri = hi[i];
        rj = lo[j];
    } else if (hi[j] < 0) {
        li = hi[i];
        lj = hi[j];
        ri = lo[i];
        rj = hi[j];
    } else
        return 0; /* the eye is inside of the outline */
    int left = 1, right = 1;
    for (uint32_t k = 0; k < planes->direction_count && (left || right); k++) {
        double di = planes->direction[k][i], dj = planes->direction[k][j];
        /* 1e-12: rounding of directions and tangents; beyond means beyond by more. */
        left &= li * dj - lj * di > 1e-12 * (fabs(li) + fabs(lj)) * (fabs(di) + fabs(dj));
        right &= ri * dj - rj * di < -1e-12 * (fabs(ri) + fabs(rj)) * (fabs(di) + fabs(dj));
    }
    return left || right;
}

/* The exact test: bounds against an aperture. */
static int box_in_aperture(const EnfView *view, const double bounds[6], const EnfAperturePlanes *planes) {
    const double *eye = view->screens.eyes[0];
    double lo[3], hi[3], size = 0;
    for (int c = 0; c < 3; c++) {
        lo[c] = bounds[c] - eye[c];
        hi[c] = bounds[3 + c] - eye[c];
        size += fmax(fabs(lo[c]), fabs(hi[c]));
    }
    for (uint32_t k = 0; k < planes->count; k++) {
        const double *n = planes->n[k];
        double s = (n[0] > 0 ? n[0] * hi[0] : n[0] * lo[0]) + (n[1] > 0 ? n[1] * hi[1] : n[1] * lo[1]) +
                   (n[2] > 0 ? n[2] * hi[2] : n[2] * lo[2]) + planes->d[k];
        /* Rounding of the sum, four orders above what it can be and two below ENF_SLIVER. */
        if (s < -1e-12 * ((fabs(n[0]) + fabs(n[1]) + fabs(n[2])) * size + fabs(planes->d[k])))
            return 0;
    }
    if (planes->direction_count == 0)
        return 1;
    /* Often the middle of the box is seen: done. */
    double middle[3] = {0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1]), 0.5 * (lo[2] + hi[2])};
    uint32_t k = 0;
    while (k < planes->count && dot3(planes->n[k], middle) + planes->d[k] >= 0)
        k++;
    if (k == planes->count)
        return 1;
    return !tangent_separates(lo, hi, 0, 1, planes) && !tangent_separates(lo, hi, 1, 2, planes) && !tangent_separates(lo, hi, 2, 0, planes);
}

static int beyond_limit(const EnfView *view, const double bounds[6]) {
    const double limit = view->def.distance_limit;
    if (!isfinite(limit))
        return 0;
    for (uint32_t e = 0; e < view->screens.eye_count; e++) {
        double sum = 0;
        for (int c = 0; c < 3; c++) {
            double eye = view->screens.eyes[e][c];
            double d = fmax(0, fmax(bounds[c] - eye, eye - bounds[3 + c]));
            sum += d * d;
        }
        if (sum <= limit * limit * (1 + 1e-9))
            return 0;
    }
    return 1;
}

typedef struct Collect {
    EnfView *view;
    const EnfScreen *screen;
    const EnfAperture *aperture;
    const EnfAperturePlanes *planes;
    const EnfPlanes *single;
    const uint32_t *ids;
    const double (*boxes)[6];
    uint32_t item_count, step;
    int failed;
} Collect;

static void collect_block(void *user, uint32_t block, uint32_t mask) {
    Collect *collect = user;
    EnfView *view = collect->view;
    if (!enf_answer_room(&view->answer, 0, 8)) {
        collect->failed = 1;
        return;
    }
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < collect->item_count) {
            ENF_PREFETCH(&view->object_seen[collect->ids[block * 8 + lane]]);
            if (collect->boxes)
                ENF_PREFETCH(collect->boxes[block * 8 + lane]);
        }
    while (mask) {
        uint32_t lane = 0, slot;
        while (!(mask >> lane & 1))
            lane++;
        mask &= mask - 1;
        slot = block * 8 + lane;
        if (slot >= collect->item_count)
            continue;
        uint32_t object = collect->ids[slot];
        if (view->object_seen[object] == view->query)
            continue;
        const double *bounds = collect->boxes ? collect->boxes[slot] : view->index->scene->objects[object].bounds;
        view->stats.objects_refined++;
        if (box_in_aperture(view, bounds, collect->planes) && !beyond_limit(view, bounds) &&
            !(view->occluding && enf_occlusion_hides_box(view, collect->screen, bounds, collect->aperture->rect)))
            enf_answer_object(view, object, collect->step);
    }
}

static EnfStatus collect_tree(Collect *collect, const EnfBoxes8 *blocks, const EnfBlockTree *tree, EnfBoxesTest test) {
    EnfView *view = collect->view;
    const uint32_t count = tree->item_count / 8 + (tree->item_count % 8 != 0);
    collect->item_count = tree->item_count;
    view->stats.objects_tested += tree->item_count;
    if (count <= ENF_TREE_TOP) {
        uint8_t masks[ENF_TREE_TOP];
        test(blocks + tree->first_block, count, collect->single, masks);
        for (uint32_t b = 0; b < count; b++)
            if (masks[b])
                collect_block(collect, b, masks[b]);
    } else
        enf_tree_query(blocks, tree, collect->single, test, collect_block, collect);
    return collect->failed ? enf_fail_memory() : ENF_OK;
}

EnfStatus enf_collect_objects(EnfView *view, const EnfScreen *screen) {
    const EnfViewIndex *index = view->index;
    EnfBoxesTest test = enf_boxes_test((int)view->def.use_simd);
    EnfPlanes single;
    EnfAperturePlanes planes;
    Collect collect = {view, screen, NULL, &planes, &single, NULL, NULL, 0, ENF_NONE, 0};
    EnfStatus status = ENF_OK;
    for (uint32_t i = 0; i < view->visited_count && status == ENF_OK; i++) {
        const EnfViewCell *cell = &index->cells[view->visited[i]];
        const EnfCellState *state = &view->states[view->visited[i]];
        if (i + 2 < view->visited_count) {
            const EnfViewCell *ahead = &index->cells[view->visited[i + 2]];
            const char *blocks = (const char *)&index->object_blocks[ahead->objects.first_block];
            if (ahead->objects.item_count) {
                for (uint32_t line = 0; line < 9; line++)
                    ENF_PREFETCH(blocks + 64 * line);
                ENF_PREFETCH(&index->object_ids[ahead->object_first]);
                ENF_PREFETCH(&index->object_ids[ahead->object_first + 16]);
            }
        }
        if (cell->objects.item_count == 0)
            continue;
        collect.ids = index->object_ids + cell->object_first;
        collect.boxes = (const double(*)[6])(index->object_boxes + cell->object_first);
        for (uint32_t k = 0; k < state->live_count && status == ENF_OK; k++) {
            const EnfAperture *a = &view->apertures[state->live[k]];
            enf_aperture_planes(view, screen, a, &planes);
            enf_planes_single(view, &planes, &single);
            collect.step = a->step;
            collect.aperture = a;
            status = collect_tree(&collect, index->object_blocks, &cell->objects, test);
        }
    }
    if (status == ENF_OK && index->unplaced.tree.item_count) {
        uint32_t before = view->answer.object_count;
        /* Nobody knows which cell they are in: visible wherever the view reaches. */
        EnfAperture whole = view->apertures[0];
        enf_aperture_planes(view, screen, &whole, &planes);
        enf_planes_single(view, &planes, &single);
        collect.ids = index->unplaced.ids;
        collect.boxes = NULL;
        collect.step = ENF_NONE;
        collect.aperture = &whole;
        status = collect_tree(&collect, index->unplaced.blocks, &index->unplaced.tree, test);
        view->stats.objects_unplaced += view->answer.object_count - before;
    }
    return status;
}

/* ---- Frustum culling: the baseline -------------------------------------------------------------------------- */
typedef struct CollectCells {
    EnfView *view;
    int failed;
} CollectCells;

static void collect_cell_block(void *user, uint32_t block, uint32_t mask) {
    CollectCells *collect = user;
    const EnfBoxSet *set = &collect->view->index->cell_boxes;
    if (!enf_answer_room(&collect->view->answer, 8, 0)) {
        collect->failed = 1;
        return;
    }
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < set->tree.item_count)
            enf_answer_cell(collect->view, set->ids[block * 8 + lane], ENF_NONE);
}

static void collect_frustum_block(void *user, uint32_t block, uint32_t mask) {
    CollectCells *collect = user;
    EnfView *view = collect->view;
    const EnfBoxSet *set = &view->index->all_objects;
    const int limited = isfinite(view->def.distance_limit);
    if (!enf_answer_room(&view->answer, 0, 8)) {
        collect->failed = 1;
        return;
    }
    for (uint32_t lane = 0; lane < 8; lane++) {
        if (!(mask >> lane & 1) || block * 8 + lane >= set->tree.item_count)
            continue;
        uint32_t object = set->ids[block * 8 + lane];
        if (view->object_seen[object] != view->query && !(limited && beyond_limit(view, view->index->scene->objects[object].bounds)))
            enf_answer_object(view, object, ENF_NONE);
    }
}

EnfStatus enf_frustum_cull(EnfView *view, const EnfScreen *screen) {
    EnfViewIndex *index = view->index;
    EnfAperturePlanes planes;
    EnfPlanes single;
    CollectCells collect = {view, 0};
    EnfBoxesTest test = enf_boxes_test((int)view->def.use_simd);
    planes.count = planes.direction_count = 0;
    for (uint32_t i = 0; i < screen->view.n; i++) {
        uint32_t j = (i + 1) % screen->view.n;
        double a = screen->view.y[i] - screen->view.y[j], b = screen->view.x[j] - screen->view.x[i], n[3], d;
        double c = -(a * screen->view.x[i] + b * screen->view.y[i]) + 2 * screen->outset * (fabs(a) + fabs(b));
        enf_line_plane(view, screen, a, b, c, n, &d);
        enf_add_plane(&planes, n, d);
    }
    uint32_t sides_only = planes.count;
    enf_add_depth_planes(view, screen, &planes);
    /* Cells: without the near plane, the eye's own cell counts as seen. */
    EnfAperturePlanes cells = planes;
    cells.count = sides_only;
    for (uint32_t k = sides_only + 1; k < planes.count; k++)
        enf_add_plane(&cells, planes.n[k], planes.d[k]);
    enf_planes_single(view, &cells, &single);
    enf_tree_query(index->cell_boxes.blocks, &index->cell_boxes.tree, &single, test, collect_cell_block, &collect);
    if (!enf_answer_room(&view->answer, index->boundless_count + view->start_count, 0))
        return enf_fail_memory();
    for (uint32_t i = 0; i < index->boundless_count; i++)
        enf_answer_cell(view, index->boundless_cells[i], ENF_NONE);
    for (uint32_t i = 0; i < view->start_count; i++)
        enf_answer_cell(view, view->start_cells[i], ENF_NONE);
    if (view->def.want_objects && !collect.failed) {
        EnfStatus status = enf_view_index_need_all_objects(index);
        if (status != ENF_OK)
            return status;
        enf_planes_single(view, &planes, &single);
        view->stats.objects_tested += index->all_objects.tree.item_count;
        enf_tree_query(index->all_objects.blocks, &index->all_objects.tree, &single, test, collect_frustum_block, &collect);
    }
    return collect.failed ? enf_fail_memory() : ENF_OK;
}
