/* SPDX-License-Identifier: GPL-3.0-or-later
 * Objects of visible cells seen through the cells' apertures: eight bounds at once against the aperture's planes, then, where
 * not even the middle is seen, by separating planes through the eye (box_cone.c).
 *
 * Based on: Mulloni et al. 2007, sections 3.2.3 and 3.2.4 (cell-to-geometry). */
#include "from_point/aperture_planes.h"
#include "from_point/box_cone.h"
#include "from_point/occlusion.h"

#include <math.h>
#include <string.h>

typedef struct Collect {
    EnfView *view;
    const EnfScreen *screen;
    const EnfAperture *aperture; /* for occluders alone */
    EnfAperturePlanes *planes;
    EnfPlanes single;
    EnfCone cone;
    int cone_ready;
    const EnfBoxes8 *blocks; /* of the tree */
    const uint32_t *ids;
    uint32_t item_count, step;
} Collect;

/* The planes from now on. */
static void collect_within(Collect *collect, EnfAperturePlanes *planes, uint32_t step) {
    collect->planes = planes;
    collect->cone_ready = 0;
    collect->step = step;
    enf_planes_single(collect->view, planes, &collect->single);
}

static int collect_block(void *user, uint32_t block, uint32_t found) {
    Collect *collect = user;
    uint32_t mask = found & 0xFF, sure = found >> 8;
    EnfView *view = collect->view;
    const EnfBoxes8 *boxes = &collect->blocks[block];
    const uint32_t *ids = collect->ids + block * 8;
    if (enf_over_budget(view)) /* one cell may hold millions */
        return 0;
    if (block * 8 + 8 > collect->item_count)
        mask &= (1u << (collect->item_count - block * 8)) - 1; /* unused lanes */
    for (uint32_t left = mask; left; left &= left - 1, view->stats.work++)
        ENF_PREFETCH(&view->object_seen[ids[enf_lowest_bit(left)]]);
    if (mask & ~sure) { /* not even the middle of the box is seen for certain */
        if (!collect->cone_ready) {
            const EnfViewIndex *index = view->index;
            double eye[3];
            for (int c = 0; c < 3; c++)
                eye[c] = view->screens.eyes[0][c] - index->origin[c];
            enf_aperture_directions(view, collect->screen, collect->planes);
            enf_cone_make(&collect->cone, (const double(*)[3])collect->planes->direction, collect->planes->direction_count,
                          collect->planes->views, eye, index->reach);
            collect->cone_ready = 1;
        }
        for (uint32_t left = mask & ~sure; left; left &= left - 1)
            view->stats.objects_refined++;
        view->stats.work += ENF_WORK_CONE;
        mask = (mask & sure) | enf_boxes_in_cone(boxes, mask & ~sure, &collect->cone, (int)view->def.use_simd);
    }
    for (; mask; mask &= mask - 1) {
        uint32_t object = ids[enf_lowest_bit(mask)];
        if (view->object_seen[object] == view->query)
            continue;
        const double *bounds = view->index->scene->objects[object].bounds;
        if ((isfinite(view->def.distance_limit) && enf_beyond_limit(view, bounds)) ||
            (view->occluding && enf_occlusion_hides_box(view, collect->screen, bounds, collect->aperture->rect)))
            continue;
        enf_answer_object(view, object, collect->step);
    }
    return 1;
}

static void collect_tree(Collect *collect, const EnfBoxes8 *blocks, const EnfBlockTree *tree, EnfBoxesTest test) {
    EnfView *view = collect->view;
    const uint32_t count = tree->item_count / 8 + (tree->item_count % 8 != 0);
    collect->item_count = tree->item_count;
    collect->blocks = blocks + tree->first_block;
    view->stats.objects_tested += tree->item_count;
    if (count <= ENF_TREE_TOP) {
        uint16_t masks[ENF_TREE_TOP];
        test(collect->blocks, count, &collect->single, masks);
        for (uint32_t b = 0; b < count; b++)
            if (masks[b])
                collect_block(collect, b, masks[b]);
        view->stats.work += ENF_WORK_PLANES + ENF_WORK_BLOCK * count;
    } else
        view->stats.work += ENF_WORK_PLANES + ENF_WORK_BLOCK * enf_tree_query(blocks, tree, &collect->single, test, collect_block, collect);
}

static void collect_cell(Collect *collect, const EnfViewCell *cell, EnfBoxesTest test) {
    collect->ids = collect->view->index->object_ids + cell->object_first;
    collect_tree(collect, collect->view->index->object_blocks, &cell->objects, test);
}

void enf_collect_through(EnfView *view, const EnfScreen *screen, const EnfViewCell *cell, EnfAperturePlanes *planes, uint32_t step) {
    Collect collect;
    collect.view = view;
    collect.screen = screen;
    collect.aperture = NULL;
    collect_within(&collect, planes, step);
    collect_cell(&collect, cell, enf_boxes_test((int)view->def.use_simd));
}

void enf_collect_objects(EnfView *view, const EnfScreen *screen) {
    const EnfViewIndex *index = view->index;
    EnfBoxesTest test = enf_boxes_test((int)view->def.use_simd);
    EnfAperturePlanes planes;
    Collect collect;
    collect.view = view;
    collect.screen = screen;
    for (uint32_t i = 0; i < view->visited_count && !enf_over_budget(view); i++) {
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
        for (uint32_t k = 0; k < state->live_count; k++) {
            enf_aperture_planes(view, screen, state->live[k], &planes);
            collect.aperture = &view->apertures[state->live[k]];
            collect_within(&collect, &planes, collect.aperture->step);
            collect_cell(&collect, cell, test);
        }
    }
    if (index->unplaced.tree.item_count) {
        uint32_t before = view->answer.object_count;
        /* Nobody knows which cell they are in: visible wherever the view reaches. The first aperture is the whole screen. */
        enf_aperture_planes(view, screen, 0, &planes);
        collect_within(&collect, &planes, ENF_NONE);
        collect.aperture = &view->apertures[0];
        collect.ids = index->unplaced.ids;
        collect_tree(&collect, index->unplaced.blocks, &index->unplaced.tree, test);
        view->stats.objects_unplaced += view->answer.object_count - before;
    }
}
