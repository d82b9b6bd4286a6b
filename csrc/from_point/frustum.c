/* SPDX-License-Identifier: GPL-3.0-or-later
 * Answers without portals: frustum culling, the baseline; and what is given when nothing better is known (the eye or its near plane
 * in a wall) or can be had in time. */
#include "from_point/aperture_planes.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>

int enf_beyond_limit(const EnfView *view, const double bounds[6]) {
    const double limit = view->def.distance_limit;
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

typedef struct Culling {
    EnfView *view;
    EnfPlanes planes; /* of the boxes being compared */
    EnfBoxesTest test;
    const uint32_t *ids; /* of the boxes of one tree */
    uint32_t item_count;
    int failed;
} Culling;

static void take_cells(void *user, uint32_t block, uint32_t mask) {
    Culling *culling = user;
    if (!enf_answer_room(&culling->view->answer, 8, 0)) {
        culling->failed = 1;
        return;
    }
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < culling->item_count)
            enf_answer_cell(culling->view, culling->ids[block * 8 + lane], ENF_NONE);
}

static void take_objects(void *user, uint32_t block, uint32_t mask) {
    Culling *culling = user;
    EnfView *view = culling->view;
    const int limited = isfinite(view->def.distance_limit);
    if (!enf_answer_room(&view->answer, 0, 8)) {
        culling->failed = 1;
        return;
    }
    for (uint32_t lane = 0; lane < 8; lane++) {
        if (!(mask >> lane & 1) || block * 8 + lane >= culling->item_count)
            continue;
        uint32_t object = culling->ids[block * 8 + lane];
        if (view->object_seen[object] != view->query && !(limited && enf_beyond_limit(view, view->index->scene->objects[object].bounds)))
            enf_answer_object(view, object, ENF_NONE);
    }
}

static void cull(Culling *culling, const EnfBoxes8 *blocks, const EnfBlockTree *tree, const uint32_t *ids, EnfTreeLeaf take) {
    culling->ids = ids;
    culling->item_count = tree->item_count;
    enf_tree_query(blocks, tree, &culling->planes, culling->test, take, culling);
}

/* The view as half-spaces, and the cells that touch them. */
static int cull_cells(Culling *culling, const EnfScreen *screen) {
    EnfView *view = culling->view;
    const EnfViewIndex *index = view->index;
    EnfAperturePlanes planes;
    culling->test = enf_boxes_test((int)view->def.use_simd);
    culling->failed = 0;
    planes.count = 0;
    for (uint32_t i = 0; i < screen->view.n; i++) {
        uint32_t j = (i + 1) % screen->view.n;
        double a = screen->view.y[i] - screen->view.y[j], b = screen->view.x[j] - screen->view.x[i], n[3], d;
        double c = -(a * screen->view.x[i] + b * screen->view.y[i]) + 2 * screen->outset * (fabs(a) + fabs(b));
        enf_line_plane(view, screen, a, b, c, n, &d);
        enf_add_plane(&planes, n, d);
    }
    enf_add_depth_planes(view, screen, &planes);
    /* Cells: without the near plane, the eye's own cell counts as seen. */
    EnfAperturePlanes cells = planes;
    enf_planes_drop_near(&cells);
    enf_planes_single(view, &cells, &culling->planes);
    cull(culling, index->cell_boxes.blocks, &index->cell_boxes.tree, index->cell_boxes.ids, take_cells);
    if (culling->failed || !enf_answer_room(&view->answer, index->boundless_count + view->start_count, 0))
        return 0;
    for (uint32_t i = 0; i < index->boundless_count; i++)
        enf_answer_cell(view, index->boundless_cells[i], ENF_NONE);
    for (uint32_t i = 0; i < view->start_count; i++)
        enf_answer_cell(view, view->start_cells[i], ENF_NONE);
    enf_planes_single(view, &planes, &culling->planes);
    return 1;
}

/* one_tree: over all objects, made when first asked for; else by the trees of the cells. */
static EnfStatus cull_screen(EnfView *view, const EnfScreen *screen, int one_tree) {
    EnfViewIndex *index = view->index;
    Culling culling = {.view = view};
    if (!cull_cells(&culling, screen))
        return enf_fail_memory();
    if (!view->def.want_objects)
        return ENF_OK;
    view->stats.objects_tested += index->scene->object_count;
    if (one_tree) {
        EnfStatus status = enf_view_index_need_all_objects(index);
        if (status != ENF_OK)
            return status;
        cull(&culling, index->all_objects.blocks, &index->all_objects.tree, index->all_objects.ids, take_objects);
    } else {
        for (uint32_t c = 0; c < index->scene->cell_count && !culling.failed; c++) {
            const EnfViewCell *cell = &index->cells[c];
            if (cell->objects.item_count)
                cull(&culling, index->object_blocks, &cell->objects, index->object_ids + cell->object_first, take_objects);
        }
        cull(&culling, index->unplaced.blocks, &index->unplaced.tree, index->unplaced.ids, take_objects);
    }
    return culling.failed ? enf_fail_memory() : ENF_OK;
}

EnfStatus enf_frustum_cull(EnfView *view, const EnfScreen *screen) {
    return cull_screen(view, screen, 1);
}

/* ---- For want of anything better ---------------------------------------------------------------------------------------------- */
/* The tree over all objects takes a microsecond an object to make: beyond these no query may wait for it. */
enum { MOST_IN_ONE_TREE = 50000 };

uint64_t enf_fallback_work(const EnfView *view, uint32_t screens) {
    const EnfScene *scene = view->index->scene;
    const uint64_t objects = view->def.want_objects ? scene->object_count : 0;
    const uint64_t places = view->def.want_objects ? scene->cell_object_first[scene->cell_count] + (uint64_t)scene->unplaced_count : 0;
    /* Each is listed once; cells and places of objects are compared for every screen, eight at a time. */
    return objects + scene->cell_count + screens * (places + scene->cell_count) / 4;
}

/* All there is, compared with nothing. */
static EnfStatus take_everything(EnfView *view) {
    const EnfScene *scene = view->index->scene;
    const uint32_t objects = view->def.want_objects ? scene->object_count : 0;
    if (!enf_answer_room(&view->answer, scene->cell_count, objects))
        return enf_fail_memory();
    for (uint32_t c = 0; c < scene->cell_count; c++)
        enf_answer_cell(view, c, ENF_NONE);
    for (uint32_t o = 0; o < objects; o++)
        if (view->object_seen[o] != view->query)
            enf_answer_object(view, o, ENF_NONE);
    view->stats.budget_hit = 2;
    return ENF_OK;
}

EnfStatus enf_fall_back(EnfView *view) {
    EnfStatus status = ENF_OK;
    if (view->stats.budget_hit == 2)
        return ENF_OK;
    view->fallback_work += enf_fallback_work(view, view->screens.screen_count);
    if (view->fallback_work > view->def.work_budget / 2)
        return take_everything(view);
    for (uint32_t s = 0; s < view->screens.screen_count && status == ENF_OK; s++)
        status = cull_screen(view, &view->screens.screen[s], view->index->scene->object_count <= MOST_IN_ONE_TREE);
    return status;
}
