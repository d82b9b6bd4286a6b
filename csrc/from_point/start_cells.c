/* SPDX-License-Identifier: GPL-3.0-or-later
 * Where sight starts: the cells that hold the eyes (or touch what lies between them, or between eye and near plane),
 * closed over portals so near that no side of them is certain. Each start cell gets the whole screen. */
#include "from_point/view_data.h"

#include "base/memory.h"
#include "geometry/vec3.h"

#include <math.h>
#include <string.h>

static int add_start(EnfView *view, uint32_t cell) {
    if (view->start_marks[cell] == view->start_stamp)
        return 1;
    if (!ENF_VIEW_ROOM(view, start_cells, start_capacity, view->start_count + 1))
        return 0;
    view->start_marks[cell] = view->start_stamp;
    view->start_cells[view->start_count++] = cell;
    return 1;
}

/* Whether all start points lie behind every face of the cell by `margin`. */
static int holds_all(const EnfView *view, uint32_t cell, double margin) {
    const EnfScene *scene = view->index->scene;
    const EnfScreens *screens = &view->screens;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; f++)
        for (uint32_t k = 0; k < screens->start_point_count; k++) {
            double local[3];
            vec_sub(local, screens->start_points[k], scene->origin);
            if (vec_dot(scene->face_planes[f].n, local) - scene->face_planes[f].d > -margin)
                return 0;
        }
    return 1;
}

/* Whether some face has all start points outside: then the hull of them misses the cell. */
static int misses_all(const EnfView *view, uint32_t cell, double margin) {
    const EnfScene *scene = view->index->scene;
    const EnfScreens *screens = &view->screens;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; f++) {
        uint32_t outside = 0;
        for (uint32_t k = 0; k < screens->start_point_count; k++) {
            double local[3];
            vec_sub(local, screens->start_points[k], scene->origin);
            outside += vec_dot(scene->face_planes[f].n, local) - scene->face_planes[f].d > margin;
        }
        if (outside == screens->start_point_count)
            return 1;
    }
    return 0;
}

/* Whether the hull of the start points may touch the portal, within `margin`: their bounds overlap, the portal's plane
 * passes among them, and no edge of it has them all outside. */
static int touches_portal(const EnfView *view, const EnfPortalSide *side, double margin) {
    const EnfScreens *screens = &view->screens;
    const double(*v)[3] = (const double(*)[3])(view->index->vertices + side->vertex_first);
    double low = INFINITY, high = -INFINITY;
    for (uint32_t k = 0; k < screens->start_point_count; k++) {
        double q[3];
        vec_sub(q, screens->start_points[k], v[0]);
        double d = vec_dot(side->n, q);
        low = fmin(low, d);
        high = fmax(high, d);
    }
    margin += side->slack + 2 * screens->start_grown;
    if (low > margin || high < -margin)
        return 0;
    for (int c = 0; c < 3; c++) {
        double lo = INFINITY, hi = -INFINITY;
        for (uint32_t i = 0; i < side->vertex_count; i++) {
            lo = fmin(lo, v[i][c]);
            hi = fmax(hi, v[i][c]);
        }
        if (lo > screens->start_bounds[3 + c] + margin || hi < screens->start_bounds[c] - margin)
            return 0;
    }
    for (uint32_t i = 0; i < side->vertex_count; i++) {
        double edge[3], outward[3];
        vec_sub(edge, v[(i + 1) % side->vertex_count], v[i]);
        vec_cross(outward, side->n, edge); /* clockwise round n, which points away from where it is counter-clockwise */
        vec_normalize(outward);
        uint32_t outside = 0;
        for (uint32_t k = 0; k < screens->start_point_count; k++) {
            double q[3];
            vec_sub(q, screens->start_points[k], v[i]);
            outside += vec_dot(outward, q) > margin;
        }
        if (outside == screens->start_point_count && side->slack == 0)
            return 0;
    }
    return 1;
}

typedef struct BoxVisit {
    EnfView *view;
    int failed;
} BoxVisit;

static int visit_box(void *user, uint32_t block, uint32_t mask) {
    BoxVisit *visit = user;
    const EnfBoxSet *set = &visit->view->index->cell_boxes;
    for (uint32_t lane = 0; lane < 8; lane++) {
        uint32_t slot = block * 8 + lane;
        if (!(mask >> lane & 1) || slot >= set->tree.item_count)
            continue;
        uint32_t cell = set->ids[slot];
        if (enf_over_budget(visit->view))
            return 0;
        visit->view->stats.work += ENF_WORK_START;
        /* Without faces nothing tells where the cell is but its portals: those are left to the closure below. */
        if ((visit->view->index->cells[cell].flags & ENF_VIEW_CELL_FACES) &&
            !misses_all(visit->view, cell, visit->view->index->tolerance + visit->view->screens.start_grown * 2) &&
            !add_start(visit->view, cell))
            visit->failed = 1;
    }
    return !visit->failed;
}

/* The cells that hold a start point. */
static EnfStatus add_holders(EnfView *view, const double point[3], double margin, uint32_t *out_count) {
    const EnfViewIndex *index = view->index;
    uint32_t found[64], *all = found, count = 0;
    EnfStatus status = enf_scene_locate(index->scene, point, found, 64, &count);
    if (status != ENF_OK)
        return status;
    if (count > 64) {
        all = ENF_NEW(uint32_t, count);
        if (!all)
            return enf_fail_memory();
        status = enf_scene_locate(index->scene, point, all, count, &count);
    }
    for (uint32_t i = 0; i < count && status == ENF_OK; i++) {
        /* The locator's tolerance is coarser than ours: what the point misses by more than ours isn't a start. */
        if ((index->cells[all[i]].flags & ENF_VIEW_CELL_FACES) && misses_all(view, all[i], margin + 2 * view->screens.start_grown))
            continue;
        if (!add_start(view, all[i]))
            status = enf_fail_memory();
    }
    if (all != found)
        enf_free(all);
    *out_count = count;
    return status;
}

/* Whatever the hull of eyes and near planes cuts, through walls too. 0: out of memory. */
static int add_all_cut(EnfView *view, double margin) {
    const EnfViewIndex *index = view->index;
    const EnfScreens *screens = &view->screens;
    EnfPlanes planes;
    planes.count = planes.loose = 0;
    for (int c = 0; c < 3; c++) {
        double n[3] = {0, 0, 0};
        n[c] = 1;
        enf_planes_add(&planes, n, index->origin[c] - screens->start_bounds[c] + margin, index->reach);
        n[c] = -1;
        enf_planes_add(&planes, n, screens->start_bounds[3 + c] - index->origin[c] + margin, index->reach);
    }
    BoxVisit visit = {view, 0};
    enf_tree_query(index->cell_boxes.blocks, &index->cell_boxes.tree, &planes, enf_boxes_test((int)view->def.use_simd), visit_box, &visit);
    return !visit.failed;
}

/* What lies behind portals of start cells so near that no side of them is certain. 0: out of memory. */
static int add_neighbours(EnfView *view, double margin) {
    const EnfViewIndex *index = view->index;
    const EnfScene *scene = index->scene;
    for (uint32_t i = 0; i < view->start_count; i++) { /* grows as it goes */
        const EnfViewCell *cell = &index->cells[view->start_cells[i]];
        view->stats.work += enf_over_budget(view) ? 0 : ENF_WORK_START;
        for (uint32_t s = 0; s < cell->side_count && !enf_over_budget(view); s++) {
            view->stats.work += ENF_WORK_START / 5;
            const EnfPortalSide *side = &index->sides[cell->side_first + s];
            /* From the recess of a shut door sight goes on to both sides (traversal.c). */
            int recess = side->opening != ENF_NONE && side->opening == scene->cell_openings[view->start_cells[i]];
            if (view->start_marks[side->to] != view->start_stamp && (recess || enf_portal_passes(scene, side->portal)) &&
                touches_portal(view, side, margin) && !add_start(view, side->to))
                return 0;
        }
    }
    return 1;
}

/* Whether the one start cell surely holds all there is. */
static int encloses_all(const EnfView *view, double margin) {
    return view->start_count == 1 && (view->index->cells[view->start_cells[0]].flags & ENF_VIEW_CELL_FACES) &&
           holds_all(view, view->start_cells[0], margin + 2 * view->screens.start_grown) && view->screens.eye_count <= 8;
}

/* Out of budget it finds some of them. */
EnfStatus enf_find_start_cells(EnfView *view) {
    const EnfScene *scene = view->index->scene;
    const EnfScreens *screens = &view->screens;
    const double margin = view->def.start_tolerance > 0 ? view->def.start_tolerance : view->index->tolerance;
    view->start_count = 0;
    if (++view->start_stamp == 0) { /* once in 4 billion queries */
        memset(view->start_marks, 0, sizeof *view->start_marks * scene->cell_count);
        view->start_stamp = 1;
    }
    int enclosed = 0;
    uint32_t points = screens->start_point_count;
    if (view->start_hint != ENF_NONE) {
        if (!add_start(view, view->start_hint))
            return enf_fail_memory();
        points = 0;
    }
    for (uint32_t k = 0; k < points && !enclosed && !enf_over_budget(view); k++) {
        uint32_t count;
        EnfStatus status = add_holders(view, screens->start_points[k], margin, &count);
        if (status != ENF_OK)
            return status;
        enclosed = k == 0 && count == 1 && encloses_all(view, margin);
    }
    if (!enclosed && screens->start_point_count > 1 && !add_all_cut(view, margin))
        return enf_fail_memory();
    view->start_enclosed = enclosed;
    if (!enclosed && !add_neighbours(view, margin))
        return enf_fail_memory();
    view->stats.start_cells += view->start_count;
    return ENF_OK;
}
