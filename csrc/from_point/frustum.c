/* SPDX-License-Identifier: GPL-3.0-or-later
 * Answers without portals: frustum culling, the baseline; and what is given when nothing better is known (the eye or its near plane
 * in a wall) or can be had in time. */
#include "from_point/aperture_planes.h"
#include "from_point/vista.h"

#include "geometry/vec3.h"

#include <math.h>

int enf_beyond_limit(const EnfView *view, const double bounds[6]) {
    const double limit = view->def.distance_limit;
    for (uint32_t e = 0; e < view->screens.eye_count; e++)
        if (box_distance2(bounds, view->screens.eyes[e]) <= limit * limit * (1 + 1e-9))
            return 0;
    return 1;
}

typedef struct Culling {
    EnfView *view;
    EnfBoxesTest test;
    const uint32_t *ids; /* of the boxes of one tree */
    uint32_t item_count, compared;
} Culling;

static int take_cells(void *user, uint32_t block, uint32_t mask) {
    Culling *culling = user;
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < culling->item_count)
            enf_answer_cell(culling->view, culling->ids[block * 8 + lane], ENF_NONE);
    return 1;
}

static int take_objects(void *user, uint32_t block, uint32_t mask) {
    Culling *culling = user;
    EnfView *view = culling->view;
    const int limited = isfinite(view->def.distance_limit);
    for (uint32_t lane = 0; lane < 8; lane++) {
        if (!(mask >> lane & 1) || block * 8 + lane >= culling->item_count)
            continue;
        uint32_t object = culling->ids[block * 8 + lane];
        if (view->object_seen[object] != view->query && !(limited && enf_beyond_limit(view, view->index->scene->objects[object].bounds)))
            enf_answer_object(view, object, ENF_NONE);
    }
    return 1;
}

static void cull_set(Culling *culling, const EnfPlanes *planes, const EnfBoxSet *set, EnfTreeLeaf take) {
    culling->ids = set->ids;
    culling->item_count = set->tree.item_count;
    culling->compared += enf_tree_query(set->blocks, &set->tree, planes, culling->test, take, culling);
}

void enf_screen_planes(const EnfView *view, const EnfScreen *screen, EnfPlanes *for_objects, EnfPlanes *for_cells) {
    EnfAperturePlanes planes;
    planes.count = 0;
    for (uint32_t i = 0; i < screen->view.n; i++) {
        uint32_t j = (i + 1) % screen->view.n;
        double a = screen->view.y[i] - screen->view.y[j], b = screen->view.x[j] - screen->view.x[i], n[3], d;
        double c = -(a * screen->view.x[i] + b * screen->view.y[i]) + 2 * screen->outset * (fabs(a) + fabs(b));
        enf_line_plane(view, screen, a, b, c, n, &d);
        enf_add_plane(&planes, n, d);
    }
    enf_add_depth_planes(view, screen, &planes);
    enf_planes_single(view, &planes, for_objects);
    enf_planes_drop_near(&planes);
    enf_planes_single(view, &planes, for_cells);
}

static void take_boundless(EnfView *view, const uint32_t *cells, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        enf_answer_cell(view, cells[i], ENF_NONE);
    for (uint32_t i = 0; i < view->start_count; i++)
        enf_answer_cell(view, view->start_cells[i], ENF_NONE);
}

void enf_frustum_cull(EnfView *view, const EnfScreen *screen) {
    const EnfViewIndex *index = view->index;
    Culling culling = {.view = view, .test = enf_boxes_test((int)view->def.use_simd)};
    EnfPlanes for_objects, for_cells;
    enf_screen_planes(view, screen, &for_objects, &for_cells);
    cull_set(&culling, &for_cells, &index->cell_boxes, take_cells);
    take_boundless(view, index->boundless_cells, index->boundless_count);
    if (!view->def.want_objects)
        return;
    view->stats.objects_tested += index->scene->object_count;
    cull_set(&culling, &for_objects, &index->all_objects, take_objects);
}

void enf_cull_outdoors(EnfView *view, const EnfPlanes *for_objects, const EnfPlanes *for_cells) {
    const EnfViewIndex *index = view->index;
    const struct EnfVistas *vistas = index->vistas;
    Culling culling = {.view = view, .test = enf_boxes_test((int)view->def.use_simd)};
    cull_set(&culling, for_cells, &vistas->outdoors, take_cells);
    take_boundless(view, vistas->boundless, vistas->boundless_count);
    if (view->def.want_objects) {
        view->stats.objects_tested += vistas->outdoor_objects.tree.item_count + index->unplaced.tree.item_count;
        cull_set(&culling, for_objects, &vistas->outdoor_objects, take_objects);
        const uint32_t before = view->answer.object_count;
        cull_set(&culling, for_objects, &index->unplaced, take_objects);
        view->stats.objects_unplaced += view->answer.object_count - before;
    }
    view->stats.work += ENF_WORK_BLOCK * culling.compared + view->answer.cell_count + view->answer.object_count;
}

/* ---- For want of anything better ---------------------------------------------------------------------------------------------- */
uint64_t enf_fallback_work(const EnfView *view, uint32_t screens) {
    const EnfScene *scene = view->index->scene;
    const uint64_t objects = view->def.want_objects ? scene->object_count : 0;
    /* Each is listed once, and compared for every screen, eight at a time. */
    return objects + scene->cell_count + screens * (objects + scene->cell_count) / 4;
}

/* `count` items, the stamp that says that they are in the answer, and no step: as fast as memory goes. */
static void list_all(uint32_t count, uint32_t stamp, uint32_t *items, uint32_t *steps, uint32_t *seen) {
    for (uint32_t i = 0; i < count; i++) {
        items[i] = i;
        steps[i] = ENF_NONE;
        seen[i] = stamp;
    }
}

/* All there is, compared with nothing. */
static void take_everything(EnfView *view) {
    const EnfScene *scene = view->index->scene;
    view->answer.cell_count = scene->cell_count;
    list_all(scene->cell_count, view->query, view->answer.cells, view->cell_step, view->cell_seen);
    view->answer.object_count = view->def.want_objects ? scene->object_count : 0;
    list_all(view->answer.object_count, view->query, view->answer.objects, view->object_step, view->object_seen);
    view->stats.budget_hit = 2;
}

void enf_fall_back_screen(EnfView *view, const EnfScreen *screen) {
    view->fallback_work += enf_fallback_work(view, 1);
    if (view->fallback_work <= view->def.work_budget / 2)
        enf_frustum_cull(view, screen);
    else if (view->stats.budget_hit != 2)
        take_everything(view);
}

void enf_fall_back(EnfView *view) {
    for (uint32_t s = 0; s < view->screens.screen_count; s++)
        enf_fall_back_screen(view, &view->screens.screen[s]);
}
