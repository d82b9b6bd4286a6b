/* SPDX-License-Identifier: GPL-3.0-or-later
 * The traversal: cells in order of distance from a heap, each with all apertures that have reached it.
 *
 * Based on: Luebke & Georges 1995 (portals and mirrors), Mulloni et al. 2007 (box and clip). Ours: the ordering, containment
 * and merging of apertures per cell, and the bounds on work (csrc/ALGORITHMS.md, "From a point").
 *
 * Safe direction: an aperture is dropped only when it is thinner than ENF_SLIVER or another aperture of the same cell
 * contains it; merging takes hulls; running out of budget gives the frustum's answer. */
#include "from_point/glance.h"
#include "from_point/occlusion.h"
#include "from_point/project_corners.h"
#include "from_point/project_side.h"
#include "from_point/walls.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/* Merging may add this much area and still count as exact. Outdoors, cut along the planes of many facades, what arrives is
 * cut the same way and rejoins badly: thirty times as much, which costs 0.4 % more cells in a town and halves its time. */
#define MERGE_GROWTH          1e-3
#define MERGE_GROWTH_OUTDOORS 3e-2
/* Hulls of everything a cell has are tried with no more apertures than this: the try is quadratic. */
#define MERGE_ALL_MOST 4
/* After so many lossy merges, or so many apertures after its first visit, a cell has one aperture on a coarse grid: it
 * can grow only finitely often. */
#define MERGES_BEFORE_SNAP  12
#define REGROWN_BEFORE_SNAP 48

/* ---- The heap ---------------------------------------------------------------------------------------------- */
/* Equal distances are ordered by the centres themselves, so that the input's order of cells doesn't matter. */
static int entry_before(const EnfView *view, const EnfHeapEntry *a, const EnfHeapEntry *b) {
    if (a->key != b->key)
        return a->key < b->key;
    const double *ca = view->index->cells[a->cell].centre, *cb = view->index->cells[b->cell].centre;
    for (int i = 0; i < 3; i++)
        if (ca[i] != cb[i])
            return ca[i] < cb[i];
    return a->cell < b->cell;
}

static void heap_push(EnfView *view, double key, uint32_t cell) {
    EnfHeapEntry entry = {key, cell};
    uint32_t i = view->heap_count++;
    while (i > 0 && entry_before(view, &entry, &view->heap[(i - 1) / 2])) {
        view->heap[i] = view->heap[(i - 1) / 2];
        i = (i - 1) / 2;
    }
    view->heap[i] = entry;
}

static uint32_t heap_pop(EnfView *view) {
    uint32_t cell = view->heap[0].cell, n = --view->heap_count, i = 0;
    EnfHeapEntry last = view->heap[n];
    for (;;) {
        uint32_t child = 2 * i + 1;
        if (child >= n)
            break;
        if (child + 1 < n && entry_before(view, &view->heap[child + 1], &view->heap[child]))
            child++;
        if (!entry_before(view, &view->heap[child], &last))
            break;
        view->heap[i] = view->heap[child];
        i = child;
    }
    view->heap[i] = last;
    return cell;
}

/* ---- Apertures of a cell ----------------------------------------------------------------------------------- */
static EnfCellState *touch_state(EnfView *view, uint32_t cell) {
    EnfCellState *state = &view->states[cell];
    if (state->stamp != view->stamp) {
        state->stamp = view->stamp;
        state->live_count = state->flags = state->merges = state->regrown = 0;
    }
    return state;
}

static void drop_live(EnfCellState *state, uint32_t i) {
    state->live[i] = state->live[--state->live_count];
}

static int grow_steps(EnfView *view, uint32_t more) {
    uint32_t wanted = view->step_count + more + (view->step_count + more) / 2 + 16;
    if (!ENF_RESERVE(view->step_cell, wanted) || !ENF_RESERVE(view->step_portal, wanted) || !ENF_RESERVE(view->step_parent, wanted))
        return 0;
    view->step_capacity = wanted;
    return 1;
}

static uint32_t make_step(EnfView *view, uint32_t cell, uint32_t portal, uint32_t parent) {
    view->step_cell[view->step_count] = cell;
    view->step_portal[view->step_count] = portal;
    view->step_parent[view->step_count] = parent;
    return view->step_count++;
}

/* Appends the polygon to the pool as the aperture about to be placed. */
static void make_aperture(EnfView *view, double outset, const EnfPoly *poly, uint32_t step, EnfAperture *a) {
    enf_poly_rect(poly, a->rect);
    a->area = enf_poly_area(poly);
    a->first = view->corner_count;
    a->count = (uint16_t)poly->n;
    a->pending = 1;
    a->step = step;
    a->outset = outset;
    enf_poly_store(poly, a->rect, outset, view->corners + a->first);
}

static int rect_within(const double a[4], const double b[4], double tolerance) {
    return a[0] >= b[0] - tolerance && a[1] >= b[1] - tolerance && a[2] <= b[2] + tolerance && a[3] <= b[3] + tolerance;
}

static int poly_within(const EnfPoly *poly, const EnfCorner *lines, uint32_t count) {
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t i = 0; i < poly->n; i++)
            if (lines[k].a * poly->x[i] + lines[k].b * poly->y[i] + lines[k].c < 0)
                return 0;
    return 1;
}

static int aperture_within(const EnfView *view, const EnfAperture *a, const EnfAperture *b) {
    return rect_within(a->rect, b->rect, 2 * b->outset) &&
           enf_corners_inside(view->corners + a->first, a->count, view->corners + b->first, b->count);
}

/* The hull of two apertures; gives how much area it adds over their union (an upper bound). */
static double merged_hull(EnfView *view, const EnfAperture *a, const EnfAperture *b, EnfPoly *hull, int exact) {
    view->stats.hulls++;
    enf_corners_hull(view->corners + a->first, a->count, view->corners + b->first, b->count, hull);
    double area = enf_poly_area(hull), both = a->area + b->area;
    double w = fmin(a->rect[2], b->rect[2]) - fmax(a->rect[0], b->rect[0]);
    double h = fmin(a->rect[3], b->rect[3]) - fmax(a->rect[1], b->rect[1]);
    if (exact && w > 0 && h > 0 && area - both <= MERGE_GROWTH * area && area - both + w * h > MERGE_GROWTH * area) {
        EnfPoly one, two; /* they may overlap by so much that the sum of areas hides what the hull adds */
        one.n = 0;
        enf_poly_append(&one, view->corners + a->first, a->count);
        EnfPoly *common = enf_poly_clip(&one, &two, view->corners + b->first, b->count);
        both -= common->n >= 3 ? enf_poly_area(common) : 0;
    } else if (w > 0 && h > 0 && exact)
        both -= fmin(w * h, fmin(a->area, b->area));
    return area - both;
}

/* Whether the hull of all the cell has and `a` adds next to nothing: three faces of a box seen from outside make no convex
 * pair, but together its outline. Fills `hull`. */
static int merge_all(EnfView *view, const EnfCellState *state, const EnfAperture *a, EnfPoly *hull) {
    double rect[4] = {a->rect[0], a->rect[1], a->rect[2], a->rect[3]}, sum = a->area;
    uint32_t corners = a->count;
    for (uint32_t i = 0; i < state->live_count; i++) {
        const EnfAperture *live = &view->apertures[state->live[i]];
        rect[0] = fmin(rect[0], live->rect[0]);
        rect[1] = fmin(rect[1], live->rect[1]);
        rect[2] = fmax(rect[2], live->rect[2]);
        rect[3] = fmax(rect[3], live->rect[3]);
        sum += live->area;
        corners += live->count;
    }
    if (sum < 0.499 * (rect[2] - rect[0]) * (rect[3] - rect[1]) || corners > ENF_POLY_MAX)
        return 0;
    hull->n = 0;
    enf_poly_append(hull, view->corners + a->first, a->count);
    for (uint32_t i = 0; i < state->live_count; i++) {
        const EnfAperture *live = &view->apertures[state->live[i]];
        enf_poly_append(hull, view->corners + live->first, live->count);
    }
    view->stats.hulls++;
    enf_poly_hull(hull);
    double area = enf_poly_area(hull);
    if (area - sum > MERGE_GROWTH * area)
        return 0;
    /* The union is at least the sum less what pairs have in common. */
    for (uint32_t i = 0; i <= state->live_count; i++)
        for (uint32_t j = 0; j < i; j++) {
            const EnfAperture *one = i < state->live_count ? &view->apertures[state->live[i]] : a;
            const EnfAperture *two = &view->apertures[state->live[j]];
            if (fmin(one->rect[2], two->rect[2]) <= fmax(one->rect[0], two->rect[0]) ||
                fmin(one->rect[3], two->rect[3]) <= fmax(one->rect[1], two->rect[1]))
                continue;
            EnfPoly common, other;
            common.n = 0;
            enf_poly_append(&common, view->corners + one->first, one->count);
            EnfPoly *clipped = enf_poly_clip(&common, &other, view->corners + two->first, two->count);
            sum -= clipped->n >= 3 ? enf_poly_area(clipped) : 0;
        }
    if (area - sum > MERGE_GROWTH * area)
        return 0;
    enf_poly_tidy(hull);
    return 1;
}

/* Everything the cell has, and `poly`, as one aperture on the grid. */
static void collapse(EnfView *view, const double view_rect[4], EnfCellState *state, EnfPoly *poly) {
    while (state->live_count > 0) {
        const EnfAperture *live = &view->apertures[state->live[--state->live_count]];
        if (poly->n + live->count > ENF_POLY_MAX)
            enf_poly_hull(poly);
        enf_poly_append(poly, view->corners + live->first, live->count);
    }
    enf_poly_hull(poly);
    enf_poly_snap(poly, view_rect);
    if (!(state->flags & ENF_CELL_SNAPPED)) {
        state->flags |= ENF_CELL_SNAPPED;
        view->stats.cells_snapped++;
    }
}

/* An aperture arrives in a cell. `rect` method: rectangles that unite. Room for corners, apertures, steps, heap is made. */
static void arrive(EnfView *view, const EnfScreen *screen, double outset, const EnfPortalSide *side, EnfPoly *poly, uint32_t parent) {
    const int box = view->def.method == ENF_VIEW_BOX;
    EnfCellState *state = touch_state(view, side->to);
    EnfAperture a;
    EnfPoly hulls[2], *hull = &hulls[0], *trial = &hulls[1];
    if (!box && poly->n > 4)
        enf_poly_tidy(poly);
    make_aperture(view, outset, poly, ENF_NONE, &a);
    for (uint32_t i = 0; i < state->live_count; i++)
        if (aperture_within(view, &a, &view->apertures[state->live[i]])) {
            view->stats.apertures_contained++;
            return;
        }
    for (uint32_t i = 0; i < state->live_count;)
        if (aperture_within(view, &view->apertures[state->live[i]], &a))
            drop_live(state, i);
        else
            i++;
    uint32_t step = a.step = make_step(view, side->to, side->portal, parent);
    if (state->flags & ENF_CELL_VISITED && state->regrown < 255 && ++state->regrown > REGROWN_BEFORE_SNAP)
        state->merges = MERGES_BEFORE_SNAP;
    uint32_t most = view->def.max_apertures;
    double growth = MERGE_GROWTH;
    if (view->index->cells[side->to].flags & ENF_VIEW_CELL_OUTDOORS) {
        most = ENF_CELL_APERTURES;
        growth = MERGE_GROWTH_OUTDOORS;
    }
    if (view->repeat_visits > view->def.visit_cap)
        most = 1;
    if (box)
        most = 1;
    if (state->merges >= MERGES_BEFORE_SNAP) {
        collapse(view, screen->view_rect, state, poly);
        make_aperture(view, outset, poly, step, &a);
    } else {
        for (uint32_t i = 0; i < state->live_count && !box;) {
            const EnfAperture *live = &view->apertures[state->live[i]];
            /* Apart by more than the rounding of a common edge: the hull adds what lies between. */
            if (live->rect[0] - a.rect[2] > 1e-6 || a.rect[0] - live->rect[2] > 1e-6 || live->rect[1] - a.rect[3] > 1e-6 ||
                a.rect[1] - live->rect[3] > 1e-6) {
                i++;
                continue;
            }
            /* A convex polygon fills at least half of its bounding rectangle: the two can't make up such a hull. */
            double wide = fmax(live->rect[2], a.rect[2]) - fmin(live->rect[0], a.rect[0]);
            double high = fmax(live->rect[3], a.rect[3]) - fmin(live->rect[1], a.rect[1]);
            if (a.area + live->area < 0.499 * wide * high) {
                i++;
                continue;
            }
            double added = merged_hull(view, &a, live, hull, 1);
            if (added <= growth * (a.area + live->area)) {
                view->stats.merges_exact++;
                if (live->area > a.area) { /* the why of the larger part */
                    view->step_parent[step] = view->step_parent[live->step];
                    view->step_portal[step] = view->step_portal[live->step];
                }
                outset = fmax(outset, live->outset);
                enf_poly_tidy(hull);
                drop_live(state, i);
                make_aperture(view, outset, hull, step, &a);
                i = 0; /* the larger one may now merge with, or contain, others */
            } else
                i++;
        }
        if (state->live_count >= 2 && state->live_count <= MERGE_ALL_MOST && !box && merge_all(view, state, &a, hull)) {
            view->stats.merges_exact += state->live_count;
            for (; state->live_count > 0; state->live_count--)
                outset = fmax(outset, view->apertures[state->live[state->live_count - 1]].outset);
            make_aperture(view, outset, hull, step, &a);
        }
        while (state->live_count >= most) {
            uint32_t best = 0;
            double least = INFINITY;
            for (uint32_t i = 0; i < state->live_count && !box; i++) {
                double added = merged_hull(view, &a, &view->apertures[state->live[i]], trial, 0);
                if (added < least) {
                    EnfPoly *swap = hull;
                    hull = trial;
                    trial = swap;
                    least = added;
                    best = i;
                }
            }
            const EnfAperture *live = &view->apertures[state->live[best]];
            if (box) {
                double rect[4] = {fmin(a.rect[0], live->rect[0]), fmin(a.rect[1], live->rect[1]), fmax(a.rect[2], live->rect[2]),
                                  fmax(a.rect[3], live->rect[3])};
                enf_poly_from_rect(hull, rect);
            } else
                enf_poly_tidy(hull);
            outset = fmax(outset, live->outset);
            drop_live(state, best);
            view->stats.merges_forced++;
            if (++state->merges >= MERGES_BEFORE_SNAP)
                collapse(view, screen->view_rect, state, hull);
            make_aperture(view, outset, hull, step, &a);
            for (uint32_t i = 0; i < state->live_count;)
                if (aperture_within(view, &view->apertures[state->live[i]], &a))
                    drop_live(state, i);
                else
                    i++;
        }
    }
    view->stats.apertures++;
    view->corner_count += a.count;
    state->live[state->live_count++] = view->aperture_count;
    view->apertures[view->aperture_count++] = a;
    if (!(state->flags & ENF_CELL_IN_HEAP)) {
        state->flags |= ENF_CELL_IN_HEAP;
        const EnfViewCell *cell = &view->index->cells[side->to];
        if (cell->flags & ENF_VIEW_CELL_PASSAGE) {
            view->passages[view->passage_count++] = side->to;
            return;
        }
        const double *eye = view->screens.eyes[0];
        const char *sides = (const char *)&view->index->sides[cell->side_first];
        const char *vertices = (const char *)&view->index->vertices[cell->vertex_first];
        ENF_PREFETCH(sides);
        ENF_PREFETCH(sides + 64);
        ENF_PREFETCH(sides + 128);
        ENF_PREFETCH(vertices);
        ENF_PREFETCH(vertices + 64);
        ENF_PREFETCH(vertices + 128);
        ENF_PREFETCH(vertices + 192);
        double x = cell->centre[0] - eye[0], y = cell->centre[1] - eye[1], z = cell->centre[2] - eye[2];
        heap_push(view, cell->flags & ENF_VIEW_CELL_LAST ? INFINITY : x * x + y * y + z * z, side->to);
    }
}

/* ---- Visiting a cell ----------------------------------------------------------------------------------------- */
/* Whether some eye lies on the near side of the portal's plane; `slack` metres beyond it still counts. */
static int on_near_side(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, double slack, double *out_distance) {
    const double *v = view->index->vertices[side->vertex_first];
    double best = -INFINITY;
    if (screen->ortho) {
        *out_distance = INFINITY;
        return side->n[0] * screen->look[0] + side->n[1] * screen->look[1] + side->n[2] * screen->look[2] > (slack > 0 ? -1e-6 : 0);
    }
    for (uint32_t e = 0; e < view->screens.eye_count; e++) {
        const double *eye = view->screens.eyes[e];
        double d = side->n[0] * (v[0] - eye[0]) + side->n[1] * (v[1] - eye[1]) + side->n[2] * (v[2] - eye[2]);
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
    int glances; /* windows may be looked through as rectangles: one eye, exact clipping, nothing else that hides */
    /* The opening whose own cell the eye is in, ENF_NONE: none. In the recess of a shut door one sees the room on one's side of
     * the leaf; which side that is nobody said: both. */
    uint32_t recess;
    /* The pending apertures; a snapshot, because a portal may lead back into this cell. */
    EnfAperture pending[ENF_CELL_APERTURES];
    uint32_t first, end; /* of the pending ones: those to carry through the side */
    double rect[4];      /* bounds of these */
    const EnfWall *wall;
} Crossing;

static int over_budget(const EnfView *view) {
    return view->stats.visits >= view->def.visit_budget || enf_work_done(&view->stats) >= view->work_limit;
}

/* Room for one aperture more, so that nothing in arrive() can fail. */
static int make_room(EnfView *view) {
    if (view->corner_count > 0x7FFFFFFFu / 2)
        return 0;
    if (!ENF_VIEW_ROOM(view, apertures, aperture_capacity, view->aperture_count + 1u) ||
        !ENF_VIEW_ROOM(view, corners, corner_capacity, view->corner_count + (uint32_t)(ENF_APERTURE_CORNERS + ENF_POLY_MAX)) ||
        !ENF_VIEW_ROOM(view, heap, heap_capacity, view->heap_count + 1u) ||
        !ENF_VIEW_ROOM(view, passages, passage_capacity, view->passage_count + 1u))
        return 0;
    return view->step_count < view->step_capacity || grow_steps(view, 1);
}

/* Looks into a room from outdoors through a window that aperture `a` holds wholly. 0: that has to be done by apertures. */
static int look_in(Crossing *crossing, const EnfPortalSide *side, const EnfAperture *a) {
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
    if (!make_room(view) || (view->step_count + 2 > view->step_capacity && !grow_steps(view, 2)) || !enf_answer_room(&view->answer, 2, 0)) {
        crossing->state = CROSS_OUT_OF_MEMORY;
        return 1;
    }
    EnfStatus status = ENF_OK;
    uint32_t step = a->step;
    if (window->recess != ENF_NONE) {
        const EnfViewCell *recess = &index->cells[window->recess];
        step = make_step(view, window->recess, side->portal, step);
        enf_answer_cell(view, window->recess, step);
        view->stats.visits++;
        if (recess->objects.item_count && view->def.want_objects) {
            enf_glimpse_planes(view, crossing->screen, window, glimpse.outer, &planes);
            status = enf_collect_through(view, crossing->screen, recess, &planes, step);
        }
    }
    if (glimpse.sees_portals) {
        EnfPoly poly;
        enf_glimpse_polygon(crossing->screen, window, glimpse.inner, &poly);
        arrive(view, crossing->screen, crossing->screen->outset, &index->sides[window->inner_side], &poly, step);
    } else if (glimpse.sees_room) {
        const EnfViewCell *cell = &index->cells[window->room];
        step = make_step(view, window->room, index->sides[window->inner_side].portal, step);
        enf_answer_cell(view, window->room, step);
        view->stats.visits++;
        if (status == ENF_OK && cell->objects.item_count && view->def.want_objects) {
            enf_glimpse_planes(view, crossing->screen, window, glimpse.inner, &planes);
            status = enf_collect_through(view, crossing->screen, cell, &planes, step);
        }
    }
    if (status != ENF_OK)
        crossing->state = CROSS_OUT_OF_MEMORY;
    return 1;
}

/* Looks through one side with the apertures [first, end). */
static void cross_side(Crossing *crossing, const EnfPortalSide *side) {
    EnfView *view = crossing->view;
    const EnfViewIndex *index = view->index;
    const EnfScreen *screen = crossing->screen;
    const int box = view->def.method == ENF_VIEW_BOX;
    const EnfCellState *target = &view->states[side->to];
    if (crossing->state != CROSS_GOES_ON)
        return;
    /* A single cell may have a million portals. */
    if ((++view->stats.portals_tested & 1023) == 0 && over_budget(view)) {
        crossing->state = CROSS_OUT_OF_BUDGET;
        return;
    }
    if (target->stamp == view->stamp && (target->flags & ENF_CELL_START))
        return; /* has the whole screen already */
    double distance, slack = side->slack;
    if (crossing->start)
        slack += fmax(index->tolerance, view->def.start_tolerance);
    if (!on_near_side(view, screen, side, slack, &distance) || (crossing->limited && too_far(view, screen, side)))
        return;
    /* Near its plane the winding of a projection isn't certain: take its hull. */
    int hull = slack > 0 && (side->slack > 0 || distance < index->tolerance);
    EnfPoly base, copy, other;
    double error;
    int kind = enf_project_side(view, screen, side, hull, crossing->rect, &base, &error);
    if (kind == ENF_PROJECT_OUT)
        return;
    view->stats.portals_projected++;
    if (side->opening != ENF_NONE && side->opening != crossing->recess && index->scene->openings[side->opening].state == ENF_STATE_CLOSED)
        return;
    double base_rect[4];
    if (kind == ENF_PROJECT_WHOLE) {
        view->stats.portals_unclipped++;
        memcpy(base_rect, crossing->rect, sizeof base_rect);
    } else
        enf_poly_rect(&base, base_rect);
    for (uint32_t k = crossing->first; k < crossing->end && side->glance != ENF_NONE && crossing->glances; k++) {
        const EnfAperture *a = &crossing->pending[k];
        if (kind == ENF_PROJECT_POLYGON && poly_within(&base, view->corners + a->first, a->count)) {
            if (look_in(crossing, side, a))
                return;
            break;
        }
    }
    for (uint32_t k = crossing->first; k < crossing->end; k++) {
        const EnfAperture *a = &crossing->pending[k];
        double overlap[4] = {fmax(a->rect[0], base_rect[0]), fmax(a->rect[1], base_rect[1]), fmin(a->rect[2], base_rect[2]),
                             fmin(a->rect[3], base_rect[3])};
        if (overlap[0] > overlap[2] || overlap[1] > overlap[3])
            continue;
        EnfPoly *clipped;
        if (kind == ENF_PROJECT_WHOLE) {
            copy.n = 0;
            enf_poly_append(&copy, view->corners + a->first, a->count);
            clipped = &copy;
        } else if (box) {
            for (int q = 0; q < 4; q++) /* rectangles widen by the outset as lines do */
                overlap[q] += q < 2 ? -screen->outset : screen->outset;
            enf_poly_from_rect(&copy, overlap);
            clipped = &copy;
        } else if (k + 1 < crossing->end) {
            copy.n = base.n;
            memcpy(copy.x, base.x, sizeof *base.x * base.n);
            memcpy(copy.y, base.y, sizeof *base.y * base.n);
            clipped = enf_poly_clip(&copy, &other, view->corners + a->first, a->count);
        } else
            clipped = enf_poly_clip(&base, &other, view->corners + a->first, a->count);
        if (clipped->n < 3)
            continue;
        double clipped_rect[4];
        enf_poly_rect(clipped, clipped_rect);
        if (enf_poly_is_sliver(clipped, enf_poly_area(clipped), clipped_rect)) {
            view->stats.apertures_sliver++;
            continue;
        }
        if (view->occluding && enf_occlusion_hides_portal(view, screen, side, distance, clipped, clipped_rect))
            continue;
        if (!make_room(view)) {
            crossing->state = CROSS_OUT_OF_MEMORY;
            return;
        }
        arrive(view, screen, fmax(screen->outset, 2 * error), side, clipped, a->step);
    }
}

static void cross_wall_block(void *user, uint32_t block, uint32_t mask) {
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
        }
    for (uint32_t lane = 0; lane < 8; lane++)
        if ((mask >> lane & 1) && block * 8 + lane < crossing->wall->tree.item_count)
            cross_side(crossing, &index->sides[index->wall_sides[crossing->wall->slot_first + block * 8 + lane]]);
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
        enf_aperture_planes(view, crossing->screen, &crossing->pending[k], &planes);
        /* Sight passes a portal before the near plane too: only its sides and the far plane count. */
        enf_planes_drop_near(&planes);
        enf_planes_single(view, &planes, &single);
        crossing->first = k;
        crossing->end = k + 1;
        memcpy(crossing->rect, crossing->pending[k].rect, sizeof crossing->rect);
        for (uint32_t w = 0; w < cell->wall_count; w++) {
            if (away && away[w])
                continue;
            crossing->wall = &index->walls[cell->wall_first + w];
            enf_tree_query(index->wall_blocks, &crossing->wall->tree, &single, test, cross_wall_block, crossing);
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
        if (!ENF_VIEW_ROOM(view, visited, visited_capacity, view->visited_count + 1) || !enf_answer_room(&view->answer, 1, 0))
            return enf_fail_memory();
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
    crossing.glances = cell->flags & ENF_VIEW_CELL_OUTDOORS && view->screens.eye_count == 1 && !screen->ortho && !view->occluding &&
                       !isfinite(view->def.distance_limit) && view->def.method == ENF_VIEW_CLIP;
    crossing.first = crossing.end = 0;
    crossing.rect[0] = crossing.rect[1] = INFINITY;
    crossing.rect[2] = crossing.rect[3] = -INFINITY;
    for (uint32_t i = 0; i < state->live_count; i++) {
        EnfAperture *a = &view->apertures[state->live[i]];
        if (!a->pending)
            continue;
        a->pending = 0;
        crossing.pending[crossing.end++] = *a;
        crossing.rect[0] = fmin(crossing.rect[0], a->rect[0]);
        crossing.rect[1] = fmin(crossing.rect[1], a->rect[1]);
        crossing.rect[2] = fmax(crossing.rect[2], a->rect[2]);
        crossing.rect[3] = fmax(crossing.rect[3], a->rect[3]);
    }
    if (crossing.end == 0)
        return ENF_OK;
    view->stats.visits++;
    if (cell->wall_count)
        cross_walls(&crossing, cell);
    else {
        for (uint32_t s = 0; s < cell->side_count && s < 8; s++)
            ENF_PREFETCH(&view->states[index->sides[cell->side_first + s].to]);
        for (uint32_t s = 0; s < cell->side_count; s++)
            cross_side(&crossing, &index->sides[cell->side_first + s]);
    }
    *out_done = crossing.state == CROSS_GOES_ON;
    return crossing.state == CROSS_OUT_OF_MEMORY ? enf_fail_memory() : ENF_OK;
}

EnfStatus enf_traverse(EnfView *view, const EnfScreen *screen, int *out_done) {
    *out_done = 1;
    view->project = enf_project_corners((int)view->def.use_simd);
    if (++view->stamp == 0) { /* once in 4 billion queries */
        memset(view->states, 0, sizeof *view->states * view->index->scene->cell_count);
        view->stamp = 1;
    }
    view->heap_count = view->passage_count = view->aperture_count = view->corner_count = view->visited_count = view->repeat_visits = 0;
    if (!ENF_VIEW_ROOM(view, apertures, aperture_capacity, 1u) ||
        !ENF_VIEW_ROOM(view, corners, corner_capacity, (uint32_t)ENF_APERTURE_CORNERS + ENF_POLY_MAX) ||
        !ENF_VIEW_ROOM(view, heap, heap_capacity, view->start_count) || !enf_answer_room(&view->answer, view->start_count, 0))
        return enf_fail_memory();
    if (view->step_count + view->start_count > view->step_capacity && !grow_steps(view, view->start_count))
        return enf_fail_memory();
    /* All start cells share the corners of the whole screen; each has its own step. */
    for (uint32_t i = 0; i < view->start_count; i++) {
        uint32_t c = view->start_cells[i];
        EnfCellState *state = touch_state(view, c);
        if (!ENF_VIEW_ROOM(view, apertures, aperture_capacity, view->aperture_count + 1))
            return enf_fail_memory();
        EnfAperture *a = &view->apertures[view->aperture_count];
        if (i == 0) {
            make_aperture(view, screen->outset, &screen->view, ENF_NONE, a);
            view->corner_count += a->count;
        } else
            *a = view->apertures[0];
        a->pending = 1;
        a->step = make_step(view, c, ENF_NONE, ENF_NONE);
        state->flags = ENF_CELL_START | ENF_CELL_IN_HEAP;
        state->live[0] = view->aperture_count++;
        state->live_count = 1;
        heap_push(view, -1, c); /* before all others */
    }
    while (view->heap_count > 0) {
        if (over_budget(view)) {
            *out_done = 0;
            return ENF_OK;
        }
        EnfStatus status = visit(view, screen, heap_pop(view), out_done);
        /* Openings between two cells: nothing is gained by waiting for their turn. */
        while (status == ENF_OK && *out_done && view->passage_count > 0 && !over_budget(view))
            status = visit(view, screen, view->passages[--view->passage_count], out_done);
        if (status != ENF_OK || !*out_done || view->passage_count > 0) {
            *out_done = 0;
            return status;
        }
    }
    view->stats.visit_cap_hit |= view->repeat_visits > view->def.visit_cap;
    return ENF_OK;
}
