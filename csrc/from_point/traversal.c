/* SPDX-License-Identifier: GPL-3.0-or-later
 * The traversal: cells in order of distance from a heap, each with all apertures that have reached it.
 *
 * Based on: Luebke & Georges 1995 (portals and mirrors), Mulloni et al. 2007 (box and clip). Ours: the ordering, containment
 * and merging of apertures per cell, and the bounds on work (csrc/ALGORITHMS.md, "From a point").
 *
 * Safe direction: an aperture is dropped only when it is thinner than ENF_SLIVER or another aperture of the same cell
 * contains it; merging takes hulls; running out of budget gives the frustum's answer. */
#include "from_point/arrival.h"
#include "from_point/cell_queue.h"
#include "from_point/glance.h"
#include "from_point/occlusion.h"
#include "from_point/open_air.h"
#include "from_point/parallax.h"
#include "from_point/project_side.h"
#include "from_point/walls.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/* ---- Visiting a cell ----------------------------------------------------------------------------------------- */
/* Whether some eye lies on the near side of the portal's plane; `slack` metres beyond it still counts. */
static int on_near_side(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, double slack, double *out_distance) {
    const double *origin = view->index->origin;
    double best = -INFINITY;
    if (screen->ortho) {
        *out_distance = INFINITY;
        return side->n[0] * screen->look[0] + side->n[1] * screen->look[1] + side->n[2] * screen->look[2] > (slack > 0 ? -1e-6 : 0);
    }
    for (uint32_t e = 0; e < view->screens.eye_count; e++) {
        const double *eye = view->screens.eyes[e];
        double q[3] = {eye[0] - origin[0], eye[1] - origin[1], eye[2] - origin[2]};
        double d = side->offset - (side->n[0] * q[0] + side->n[1] * q[1] + side->n[2] * q[2]);
        best = d > best ? d : best;
    }
    *out_distance = best;
    return best > -slack;
}

/* Whether the whole portal lies beyond the distance limit or the far plane. */
static int too_far(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side) {
    const double(*v)[3] = (const double(*)[3])(view->index->vertices + side->vertex_first);
    const double limit = view->def.distance_limit, far_depth = view->screens.far_depth;
    for (uint32_t e = 0; e < view->screens.eye_count; e++) {
        const double *eye = view->screens.eyes[e];
        double nearest = INFINITY, centre[3] = {0, 0, 0}, radius = 0, depth = INFINITY;
        for (uint32_t i = 0; i < side->vertex_count; i++) {
            double d = 0;
            for (int c = 0; c < 3; c++) {
                centre[c] += (v[i][c] - eye[c]) / side->vertex_count;
                d += screen->look[c] * (v[i][c] - eye[c]);
            }
            depth = fmin(depth, d);
        }
        for (uint32_t i = 0; i < side->vertex_count; i++) {
            double x = v[i][0] - eye[0] - centre[0], y = v[i][1] - eye[1] - centre[1], z = v[i][2] - eye[2] - centre[2];
            radius = fmax(radius, x * x + y * y + z * z);
        }
        nearest = sqrt(centre[0] * centre[0] + centre[1] * centre[1] + centre[2] * centre[2]) - sqrt(radius);
        double plane = side->n[0] * centre[0] + side->n[1] * centre[1] + side->n[2] * centre[2];
        nearest = fmax(nearest, fabs(plane) - side->slack);
        /* 1e-9 relative: rounding of the norms. */
        if ((screen->ortho || nearest * (1 + 1e-9) <= limit) && depth - 1e-9 * fabs(depth) <= far_depth)
            return 0;
    }
    return 1;
}

/* What crossing the sides of one cell shares. */
typedef struct Crossing {
    EnfView *view;
    const EnfScreen *screen;
    enum { CROSS_GOES_ON, CROSS_OUT_OF_BUDGET, CROSS_OUT_OF_MEMORY } state;
    int start, limited;
    int outdoors; /* the one eye may see cells whole that lie behind this one */
    int glances;  /* windows may be looked through as rectangles: one eye, exact clipping, nothing else that hides */
    /* The opening whose own cell the eye is in, ENF_NONE: none. In the recess of a shut door one sees the room on one's side of
     * the leaf; which side that is nobody said: both. */
    uint32_t recess;
    /* The pending apertures; a list of their own, because a portal may lead back into this cell. */
    uint32_t pending[ENF_CELL_APERTURES];
    uint32_t first, end; /* of the pending ones: those to carry through the side */
    double rect[4];      /* bounds of these */
    const EnfWall *wall;
} Crossing;

/* Looks into a room from outdoors through a window that the aperture holds wholly. 0: that has to be done by apertures. */
static int look_in(Crossing *crossing, const EnfPortalSide *side, uint32_t aperture) {
    EnfView *view = crossing->view;
    const EnfViewIndex *index = view->index;
    const EnfGlance *window = &index->glances[side->glance];
    EnfGlimpse glimpse;
    EnfAperturePlanes planes;
    const EnfCellState *room = &view->states[window->room];
    if (!enf_glance(view, window, &glimpse))
        return 0;
    if (room->stamp == view->stamp && room->flags & ENF_CELL_START)
        glimpse.sees_room = 0; /* has the whole screen already */
    uint32_t step = view->apertures[aperture].step;
    if (!enf_arrival_room(view, 2)) {
        crossing->state = CROSS_OUT_OF_MEMORY;
        return 1;
    }
    if (window->recess != ENF_NONE) {
        const EnfViewCell *recess = &index->cells[window->recess];
        step = enf_make_step(view, window->recess, side->portal, step);
        enf_answer_cell(view, window->recess, step);
        view->stats.visits++;
        view->stats.work += ENF_WORK_VISIT;
        if (recess->objects.item_count && view->def.want_objects) {
            enf_glimpse_planes(view, crossing->screen, window, glimpse.outer, &planes);
            enf_collect_through(view, crossing->screen, recess, &planes, step);
        }
    }
    if (glimpse.sees_portals) {
        EnfPoly poly;
        double rect[4];
        enf_glimpse_polygon(crossing->screen, window, glimpse.inner, &poly);
        enf_poly_rect(&poly, rect);
        enf_arrive(view, crossing->screen, &index->sides[window->inner_side], &poly, rect, enf_poly_area(&poly), crossing->screen->outset,
                   NULL, step);
    } else if (glimpse.sees_room) {
        const EnfViewCell *cell = &index->cells[window->room];
        step = enf_make_step(view, window->room, index->sides[window->inner_side].portal, step);
        enf_answer_cell(view, window->room, step);
        view->stats.visits++;
        view->stats.work += ENF_WORK_VISIT;
        if (cell->objects.item_count && view->def.want_objects) {
            enf_glimpse_planes(view, crossing->screen, window, glimpse.inner, &planes);
            enf_collect_through(view, crossing->screen, cell, &planes, step);
        }
    }
    return 1;
}

static uint32_t project_work(const EnfScreens *screens) {
    const uint32_t eyes = screens->eye_count;
    return eyes == 1 ? ENF_WORK_PROJECT : (ENF_WORK_PROJECT + 2 * eyes) * eyes;
}

static int is_shut(const Crossing *crossing, const EnfPortalSide *side) {
    return side->opening != ENF_NONE && side->opening != crossing->recess &&
           crossing->view->index->scene->openings[side->opening].state == ENF_STATE_CLOSED;
}

/* Looks through a side with the eyes of a walk. What is thin as their middle sees it need not be so for others: nothing is too thin. */
static void cross_by_parallax(Crossing *crossing, const EnfPortalSide *side) {
    EnfView *view = crossing->view;
    const EnfScreen *screen = crossing->screen;
    EnfDeepPoly base, seen;
    double error, rect[4];
    const int kind = enf_project_parallax(view, screen, side, &base, &error);
    if (kind == ENF_PROJECT_OUT)
        return;
    view->stats.portals_projected++;
    view->stats.work += 2 * (ENF_WORK_PROJECT + ENF_WORK_CLIP * (crossing->end - crossing->first));
    if (is_shut(crossing, side))
        return;
    for (uint32_t k = crossing->first; k < crossing->end; k++) {
        const uint32_t aperture = crossing->pending[k], step = view->apertures[aperture].step;
        if (!enf_arrival_room(view, 1)) {
            crossing->state = CROSS_OUT_OF_MEMORY;
            return;
        }
        if (kind == ENF_PROJECT_WHOLE && view->apertures[aperture].nearness == 0) { /* no more is known than that it is in the view */
            enf_arrive_whole(view, screen, side->to, side->portal, step);
            return;
        }
        if (kind == ENF_PROJECT_WHOLE) {
            view->stats.portals_unclipped++;
            enf_parallax_poly(view, aperture, &seen);
        } else {
            enf_deep_copy(&seen, &base);
            enf_parallax_clip(view, aperture, &seen);
            if (view->apertures[aperture].nearness > 0)
                enf_parallax_clip(view, 0, &seen); /* the first one is the whole view */
            if (seen.screen.n < 3)
                continue;
        }
        enf_poly_rect(&seen.screen, rect);
        enf_arrive(view, screen, side, &seen.screen, rect, enf_poly_area(&seen.screen), enf_greater(screen->outset, 8 * error), seen.z,
                   step);
    }
}

/* A side as the screen shows it, before any aperture cuts it. */
typedef struct Picture {
    int kind;        /* ENF_PROJECT_*; of the polygon: */
    EnfPoly poly;    /* the last aperture may cut it where it stands */
    double rect[4];  /* its bounds */
    double area;     /* and area */
    double error;    /* of its corners, on the screen */
    double distance; /* metres from the foremost eye to the side's plane */
} Picture;

/* What of a picture an aperture shows. */
typedef struct Cutting {
    EnfPoly room[2];
    EnfPoly *poly; /* in `room`, or the picture's own */
    double rect[4], area;
} Cutting;

/* Whether an eye may look through the side at what isn't seen whole already; from how far, and how far beyond it some eye still may. */
static int is_faced(const Crossing *crossing, const EnfPortalSide *side, double *out_distance, double *out_slack) {
    const EnfView *view = crossing->view;
    const EnfCellState *target = &view->states[side->to];
    *out_slack = side->slack + (crossing->start ? fmax(view->index->tolerance, view->def.start_tolerance) : 0);
    return on_near_side(view, crossing->screen, side, *out_slack, out_distance) &&
           !(crossing->limited && too_far(view, crossing->screen, side)) &&
           !(target->stamp == view->stamp && (target->flags & (ENF_CELL_START | ENF_CELL_WHOLE)));
}

/* 0: the side doesn't show, or is shut. Its distance is known. */
static int picture_side(const Crossing *crossing, const EnfPortalSide *side, double slack, Picture *out) {
    EnfView *view = crossing->view;
    /* Near its plane the winding of a projection isn't certain: take its hull. */
    int hull = slack > 0 && (side->slack > 0 || out->distance < view->index->tolerance);
    out->kind = enf_project_side(view, crossing->screen, side, hull, crossing->rect, &out->poly, &out->error);
    if (out->kind == ENF_PROJECT_OUT)
        return 0;
    view->stats.portals_projected++;
    view->stats.work += project_work(&view->screens) + ENF_WORK_CLIP * (crossing->end - crossing->first);
    return !is_shut(crossing, side);
}

/* Looks in through the first aperture that holds the picture wholly. 0: there is none, or it has to be done by apertures. */
static int look_in_whole(Crossing *crossing, const EnfPortalSide *side, const Picture *picture) {
    EnfView *view = crossing->view;
    if (side->glance == ENF_NONE || !crossing->glances || picture->kind != ENF_PROJECT_POLYGON)
        return 0;
    for (uint32_t k = crossing->first; k < crossing->end; k++) {
        const uint32_t aperture = crossing->pending[k];
        if (view->cut(picture->poly.x, picture->poly.y, picture->poly.n, enf_aperture_lines(view, aperture),
                      view->apertures[aperture].count) == 0)
            return look_in(crossing, side, aperture);
    }
    return 0;
}

/* The picture as the aperture shows it; `last`: the picture won't be asked again. 0: it shows nothing. */
static int cut_picture(EnfView *view, const EnfScreen *screen, Picture *picture, uint32_t aperture, int last, Cutting *out) {
    const EnfAperture *a = &view->apertures[aperture];
    EnfPoly *base = &picture->poly, *copy = &out->room[0];
    double *rect = out->rect;
    for (int q = 0; q < 4; q++)
        rect[q] = q < 2 ? enf_greater(a->rect[q], picture->rect[q]) : enf_lesser(a->rect[q], picture->rect[q]);
    if (rect[0] > rect[2] || rect[1] > rect[3])
        return 0;
    const EnfCorner *lines = enf_aperture_lines(view, aperture);
    out->poly = copy;
    if (picture->kind == ENF_PROJECT_WHOLE) {
        copy->n = 0;
        enf_poly_append(copy, lines, a->count);
        memcpy(rect, a->rect, sizeof out->rect);
        out->area = a->area;
        return 1;
    }
    if (view->def.method == ENF_VIEW_BOX) {
        for (int q = 0; q < 4; q++) /* rectangles widen by the outset as lines do */
            rect[q] += q < 2 ? -screen->outset : screen->outset;
        enf_poly_from_rect(copy, rect);
        out->area = (rect[2] - rect[0]) * (rect[3] - rect[1]);
        return 1;
    }
    uint32_t cut = view->cut(base->x, base->y, base->n, lines, a->count);
    if (cut & ENF_CUT_AWAY)
        return 0;
    if (last)
        out->poly = base;
    else {
        copy->n = base->n;
        memcpy(copy->x, base->x, sizeof *base->x * base->n);
        memcpy(copy->y, base->y, sizeof *base->y * base->n);
    }
    memcpy(rect, picture->rect, sizeof out->rect);
    out->area = picture->area;
    if (!cut)
        return 1;
    out->poly = enf_poly_clip(out->poly, &out->room[1], lines, cut);
    if (out->poly->n < 3)
        return 0;
    enf_poly_rect(out->poly, rect);
    out->area = enf_poly_area(out->poly);
    return 1;
}

/* Carries what an aperture shows of the picture into the cell beyond. 0: it needs no other aperture, or can't go on. */
static int carry_through(Crossing *crossing, const EnfPortalSide *side, Picture *picture, uint32_t k) {
    EnfView *view = crossing->view;
    const EnfViewIndex *index = view->index;
    const EnfScreen *screen = crossing->screen;
    const uint32_t aperture = crossing->pending[k];
    Cutting shown;
    if (!cut_picture(view, screen, picture, aperture, k + 1 == crossing->end, &shown))
        return 1;
    if (enf_poly_is_sliver(shown.poly, shown.area, shown.rect)) {
        view->stats.apertures_sliver++;
        return 1;
    }
    if (view->occluding && enf_occlusion_hides_portal(view, screen, side, picture->distance, shown.poly, shown.rect))
        return 1;
    const uint32_t step = view->apertures[aperture].step;
    if (!enf_arrival_room(view, 1)) {
        crossing->state = CROSS_OUT_OF_MEMORY;
        return 0;
    }
    if (crossing->outdoors && index->cells[side->to].face_count && enf_open_air(view, side->to)->flags & ENF_CELL_OPEN) {
        enf_arrive_whole(view, screen, side->to, side->portal, step);
        return 0;
    }
    enf_arrive(view, screen, side, shown.poly, shown.rect, shown.area, enf_greater(screen->outset, 2 * picture->error), NULL, step);
    return 1;
}

/* Looks through one side with the apertures [first, end). */
static void cross_side(Crossing *crossing, const EnfPortalSide *side) {
    EnfView *view = crossing->view;
    Picture picture;
    double slack;
    if (crossing->state != CROSS_GOES_ON)
        return;
    /* A single cell may have a million portals. */
    view->stats.work += ENF_WORK_PORTAL;
    view->stats.portals_tested++;
    if (enf_over_budget(view)) {
        crossing->state = CROSS_OUT_OF_BUDGET;
        return;
    }
    if (!is_faced(crossing, side, &picture.distance, &slack))
        return;
    if (view->screens.from_middle) {
        cross_by_parallax(crossing, side);
        return;
    }
    if (!picture_side(crossing, side, slack, &picture) || look_in_whole(crossing, side, &picture))
        return;
    picture.area = 0;
    if (picture.kind == ENF_PROJECT_WHOLE) {
        view->stats.portals_unclipped++;
        memcpy(picture.rect, crossing->rect, sizeof picture.rect);
    } else {
        enf_poly_rect(&picture.poly, picture.rect);
        picture.area = enf_poly_area(&picture.poly);
    }
    uint32_t k = crossing->first;
    while (k < crossing->end && carry_through(crossing, side, &picture, k))
        k++;
}

static int cross_wall_block(void *user, uint32_t block, uint32_t mask) {
    Crossing *crossing = user;
    const EnfViewIndex *index = crossing->view->index;
    const uint32_t *slots = index->wall_sides + crossing->wall->slot_first + block * 8;
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < crossing->wall->tree.item_count)
            ENF_PREFETCH(&index->sides[slots[lane]]);
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < crossing->wall->tree.item_count) {
            const EnfPortalSide *side = &index->sides[slots[lane]];
            ENF_PREFETCH(&crossing->view->states[side->to]);
            ENF_PREFETCH(&index->vertices[side->vertex_first]);
            ENF_PREFETCH(&index->vertices[side->vertex_first + 3]);
            ENF_PREFETCH(&index->cells[side->to]);
            if (side->glance != ENF_NONE)
                enf_glance_prefetch(&index->glances[side->glance]);
        }
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < crossing->wall->tree.item_count)
            cross_side(crossing, &index->sides[index->wall_sides[crossing->wall->slot_first + block * 8 + lane]]);
    return crossing->state == CROSS_GOES_ON;
}

/* A cell with many portals: wall by wall, for each aperture only what its planes touch. */
static void cross_walls(Crossing *crossing, const EnfViewCell *cell) {
    EnfView *view = crossing->view;
    const EnfViewIndex *index = view->index;
    EnfBoxesTest test = enf_boxes_test((int)view->def.use_simd);
    uint8_t away_few[64], *away = away_few;
    uint32_t pending = crossing->end;
    double slack = crossing->start ? fmax(index->tolerance, view->def.start_tolerance) : 0;
    if (cell->wall_count > sizeof away_few)
        away = NULL; /* test each time */
    for (uint32_t w = 0; w < cell->wall_count && away; w++) {
        int faces = crossing->screen->ortho;
        for (uint32_t e = 0; e < view->screens.eye_count && !faces; e++)
            faces = !enf_wall_faces_away(index, &index->walls[cell->wall_first + w], view->screens.eyes[e], slack);
        away[w] = (uint8_t)!faces;
    }
    for (uint32_t k = 0; k < pending; k++) {
        EnfAperturePlanes planes;
        EnfPlanes single;
        enf_aperture_planes(view, crossing->screen, crossing->pending[k], &planes);
        /* Sight passes a portal before the near plane too: only its sides and the far plane count. */
        enf_planes_drop_near(&planes);
        enf_planes_single(view, &planes, &single);
        view->stats.work += ENF_WORK_PLANES + cell->wall_count;
        crossing->first = k;
        crossing->end = k + 1;
        memcpy(crossing->rect, view->apertures[crossing->pending[k]].rect, sizeof crossing->rect);
        for (uint32_t w = 0; w < cell->wall_count; w++) {
            if (away && away[w])
                continue;
            crossing->wall = &index->walls[cell->wall_first + w];
            view->stats.work +=
                ENF_WORK_BLOCK * enf_tree_query(index->wall_blocks, &crossing->wall->tree, &single, test, cross_wall_block, crossing);
        }
    }
}

static EnfStatus visit(EnfView *view, const EnfScreen *screen, uint32_t c, int *out_done) {
    const EnfViewIndex *index = view->index;
    const EnfViewCell *cell = &index->cells[c];
    EnfCellState *state = &view->states[c];
    Crossing crossing;
    state->flags &= (uint8_t)~ENF_CELL_IN_HEAP;
    if (state->flags & ENF_CELL_VISITED)
        view->repeat_visits++;
    else {
        state->flags |= ENF_CELL_VISITED;
        view->visited[view->visited_count++] = c;
        enf_answer_cell(view, c, view->apertures[state->live[0]].step);
        if (view->occluding)
            enf_occlusion_draw(view, screen, c);
    }
    crossing.state = CROSS_GOES_ON;
    crossing.view = view;
    crossing.screen = screen;
    crossing.start = state->flags & ENF_CELL_START;
    crossing.recess = crossing.start ? index->scene->cell_openings[c] : ENF_NONE;
    crossing.limited = isfinite(view->def.distance_limit) || isfinite(view->screens.far_depth);
    crossing.outdoors = cell->flags & ENF_VIEW_CELL_OUTDOORS && view->one_eye;
    crossing.glances = crossing.outdoors && !view->occluding && !isfinite(view->def.distance_limit) && view->def.method == ENF_VIEW_CLIP;
    crossing.first = crossing.end = 0;
    crossing.rect[0] = crossing.rect[1] = INFINITY;
    crossing.rect[2] = crossing.rect[3] = -INFINITY;
    for (uint32_t i = 0; i < state->live_count; i++) {
        EnfAperture *a = &view->apertures[state->live[i]];
        if (!a->pending)
            continue;
        a->pending = 0;
        crossing.pending[crossing.end++] = state->live[i];
        for (int k = 0; k < 2; k++) { /* not asked for by parallax */
            crossing.rect[k] = enf_lesser(crossing.rect[k], a->rect[k]);
            crossing.rect[2 + k] = enf_greater(crossing.rect[2 + k], a->rect[2 + k]);
        }
    }
    if (crossing.end == 0)
        return ENF_OK;
    view->stats.visits++;
    view->stats.work += ENF_WORK_VISIT;
    if (cell->wall_count)
        cross_walls(&crossing, cell);
    else {
        enf_queue_prefetch(view, c);
        for (uint32_t s = 0; s < cell->side_count; s++)
            cross_side(&crossing, &index->sides[cell->side_first + s]);
    }
    *out_done = crossing.state == CROSS_GOES_ON;
    return crossing.state == CROSS_OUT_OF_MEMORY ? enf_fail_memory() : ENF_OK;
}

EnfStatus enf_traverse(EnfView *view, const EnfScreen *screen, int *out_done) {
    *out_done = 1;
    view->project = enf_project_corners((int)view->def.use_simd);
    view->cut = enf_cut_lines((int)view->def.use_simd);
    view->cut_deep = enf_cut_deep((int)view->def.use_simd);
    if (++view->stamp == 0) { /* once in 4 billion queries */
        for (uint32_t c = 0; c < view->index->scene->cell_count; c++)
            view->states[c].stamp = 0;
        view->stamp = 1;
    }
    view->heap_count = view->passage_count = view->aperture_count = view->visited_count = view->repeat_visits = 0;
    view->free_aperture = ENF_NONE;
    view->one_eye = view->screens.eye_count == 1 && !screen->ortho;
    view->one_middle = view->one_eye || view->screens.from_middle;
    view->starts_outdoors = 0;
    for (uint32_t i = 0; i < view->start_count; i++) {
        if (!enf_arrival_room(view, 1))
            return enf_fail_memory();
        enf_arrive_whole(view, screen, view->start_cells[i], ENF_NONE, ENF_NONE);
    }
    EnfStatus status = ENF_OK;
    for (uint32_t cell; status == ENF_OK && *out_done && (cell = enf_queue_next(view)) != ENF_NONE;) {
        if (enf_over_budget(view)) {
            *out_done = 0;
            return ENF_OK;
        }
        status = visit(view, screen, cell, out_done);
    }
    view->stats.visit_cap_hit |= view->repeat_visits > view->def.visit_cap;
    return status;
}
