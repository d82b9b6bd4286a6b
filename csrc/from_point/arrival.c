/* SPDX-License-Identifier: GPL-3.0-or-later
 * Arrival of apertures in a cell: containment, merging, and the bounds that make the traversal end.
 *
 * Safe direction: the union of a cell's live apertures covers all that ever arrived (csrc/ALGORITHMS.md, "From a point"). */
#include "from_point/arrival.h"
#include "from_point/cell_queue.h"
#include "from_point/open_air.h"
#include "from_point/parallax.h"

#include "base/memory.h"

#include <math.h>

/* Merging may add this much area and still count as exact. Outdoors, cut along the planes of many facades, what arrives is
 * cut the same way and rejoins badly: thirty times as much, which costs 0.4 % more cells in a town and halves its time. */
#define MERGE_GROWTH          1e-3
#define MERGE_GROWTH_OUTDOORS 3e-2
/* Hulls of everything a cell has are tried with no more apertures than this: the try is quadratic. */
#define MERGE_ALL_MOST 4
/* After so many lossy merges, or so many apertures after its first visit, a cell has one aperture on a coarse grid: it
 * can grow only finitely often. */
#define MERGES_BEFORE_SNAP           12
#define REGROWN_BEFORE_SNAP          48
#define REGROWN_BEFORE_SNAP_OUTDOORS 200

/* ---- The pool ------------------------------------------------------------------------------------------------ */
static EnfCorner *corners_of(const EnfView *view, uint32_t aperture) {
    return view->corners + (size_t)aperture * ENF_APERTURE_CORNERS;
}

const EnfCorner *enf_aperture_lines(EnfView *view, uint32_t aperture) {
    EnfAperture *a = &view->apertures[aperture];
    EnfCorner *corners = corners_of(view, aperture);
    if (!a->outlined) {
        enf_corners_outline(corners, a->count, a->rect, a->outset);
        a->outlined = 1;
    }
    return corners;
}

static uint32_t take_aperture(EnfView *view, double nearness) {
    uint32_t aperture = view->free_aperture;
    if (aperture == ENF_NONE)
        aperture = view->aperture_count++;
    else
        view->free_aperture = view->apertures[aperture].step;
    view->apertures[aperture].nearness = nearness;
    return aperture;
}

static void free_aperture(EnfView *view, uint32_t aperture) {
    view->apertures[aperture].step = view->free_aperture;
    view->free_aperture = aperture;
}

/* z: for walks' plans, of the corners; NULL: no larger than the aperture's nearness. */
static void set_aperture(EnfView *view, uint32_t aperture, const EnfPoly *poly, const double *z, const double rect[4], double area,
                         double outset) {
    EnfAperture *a = &view->apertures[aperture];
    for (int k = 0; k < 4; k++)
        a->rect[k] = rect[k];
    a->area = area;
    a->outset = outset;
    a->count = (uint16_t)poly->n;
    a->pending = 1;
    a->outlined = 0;
    enf_poly_store(poly, corners_of(view, aperture));
    if (view->screens.from_middle)
        enf_parallax_outline(view, aperture, z);
}

static void measure_aperture(EnfView *view, uint32_t aperture, const EnfPoly *poly, double outset) {
    double rect[4];
    enf_poly_rect(poly, rect);
    set_aperture(view, aperture, poly, NULL, rect, enf_poly_area(poly), outset);
}

static int grow_steps(EnfView *view, uint32_t more) {
    uint32_t wanted = view->step_count + more + (view->step_count + more) / 2 + 16;
    if (!ENF_RESERVE(view->step_cell, wanted) || !ENF_RESERVE(view->step_portal, wanted) || !ENF_RESERVE(view->step_parent, wanted))
        return 0;
    view->step_capacity = wanted;
    return 1;
}

uint32_t enf_make_step(EnfView *view, uint32_t cell, uint32_t portal, uint32_t parent) {
    view->step_cell[view->step_count] = cell;
    view->step_portal[view->step_count] = portal;
    view->step_parent[view->step_count] = parent;
    return view->step_count++;
}

int enf_arrival_room(EnfView *view, uint32_t steps) {
    const uint32_t apertures = view->aperture_count + 1u;
    if (apertures > 0x7FFFFFFFu / ENF_APERTURE_CORNERS)
        return 0;
    return ENF_VIEW_ROOM(view, apertures, aperture_capacity, apertures) &&
           ENF_VIEW_ROOM(view, corners, corner_capacity, apertures * ENF_APERTURE_CORNERS) &&
           (!view->screens.from_middle || ENF_VIEW_ROOM(view, deep, deep_capacity, apertures * ENF_APERTURE_CORNERS)) &&
           ENF_VIEW_ROOM(view, heap, heap_capacity, view->heap_count + 1u) &&
           ENF_VIEW_ROOM(view, passages, passage_capacity, view->passage_count + 1u) &&
           (view->step_count + steps <= view->step_capacity || grow_steps(view, steps));
}

/* ---- Apertures of a cell ------------------------------------------------------------------------------------- */
/* What nobody has looked through yet can be used anew. */
static void drop_live(EnfView *view, EnfCellState *state, uint32_t i) {
    if (view->apertures[state->live[i]].pending)
        free_aperture(view, state->live[i]);
    state->live[i] = state->live[--state->live_count];
}

static int apart(const double a[4], const double b[4], double tolerance) {
    return b[0] - a[2] > tolerance || a[0] - b[2] > tolerance || b[1] - a[3] > tolerance || a[1] - b[3] > tolerance;
}

static int rect_within(const double a[4], const double b[4], double tolerance) {
    return a[0] >= b[0] - tolerance && a[1] >= b[1] - tolerance && a[2] <= b[2] + tolerance && a[3] <= b[3] + tolerance;
}

static int poly_within(EnfView *view, const EnfPoly *poly, const double *z, const double rect[4], double nearness, uint32_t outer) {
    const EnfAperture *b = &view->apertures[outer];
    if (nearness > b->nearness || !rect_within(rect, b->rect, 2 * b->outset))
        return 0;
    return z ? enf_parallax_holds(view, outer, poly, z)
             : view->cut(poly->x, poly->y, poly->n, enf_aperture_lines(view, outer), b->count) == 0;
}

static int aperture_within(EnfView *view, uint32_t inner, uint32_t outer) {
    const EnfAperture *a = &view->apertures[inner], *b = &view->apertures[outer];
    EnfPoly poly;
    if (a->nearness > b->nearness || !rect_within(a->rect, b->rect, 2 * b->outset))
        return 0;
    if (a->nearness > 0)
        return enf_parallax_within(view, inner, outer);
    poly.n = 0;
    enf_poly_append(&poly, corners_of(view, inner), a->count);
    return view->cut(poly.x, poly.y, poly.n, enf_aperture_lines(view, outer), b->count) == 0;
}

static void drop_contained(EnfView *view, EnfCellState *state, uint32_t outer) {
    for (uint32_t i = 0; i < state->live_count;)
        if (aperture_within(view, state->live[i], outer))
            drop_live(view, state, i);
        else
            i++;
}

static double common_area(EnfView *view, uint32_t one, uint32_t two) {
    EnfPoly poly, other;
    view->stats.work += ENF_WORK_HULL / 2;
    poly.n = 0;
    enf_poly_append(&poly, corners_of(view, one), view->apertures[one].count);
    EnfPoly *common = enf_poly_clip(&poly, &other, enf_aperture_lines(view, two), ENF_ALL_LINES(view->apertures[two].count));
    return common->n >= 3 ? enf_poly_area(common) : 0;
}

/* The hull of two apertures; gives how much area it adds over their union (an upper bound). */
static double merged_hull(EnfView *view, uint32_t ia, uint32_t ib, EnfPoly *hull, int exact) {
    const EnfAperture *a = &view->apertures[ia], *b = &view->apertures[ib];
    view->stats.hulls++;
    view->stats.work += ENF_WORK_HULL;
    if (exact && enf_corners_join(corners_of(view, ia), a->count, corners_of(view, ib), b->count, hull))
        return enf_greater(0, enf_poly_area(hull) - a->area - b->area);
    enf_corners_hull(corners_of(view, ia), a->count, corners_of(view, ib), b->count, hull);
    double area = enf_poly_area(hull), both = a->area + b->area;
    double w = enf_lesser(a->rect[2], b->rect[2]) - enf_greater(a->rect[0], b->rect[0]);
    double h = enf_lesser(a->rect[3], b->rect[3]) - enf_greater(a->rect[1], b->rect[1]);
    if (w > 0 && h > 0 && exact) {
        if (area - both <= MERGE_GROWTH * area && area - both + w * h > MERGE_GROWTH * area)
            both -= common_area(view, ia, ib); /* they may overlap by so much that the sum of areas hides what the hull adds */
        else
            both -= enf_lesser(w * h, enf_lesser(a->area, b->area));
    }
    return area - both;
}

/* Whether the hull of all the cell has and `a` adds next to nothing: three faces of a box seen from outside make no convex
 * pair, but together its outline. Fills `hull`. */
static int merge_all(EnfView *view, const EnfCellState *state, uint32_t arrived, EnfPoly *hull) {
    uint32_t all[MERGE_ALL_MOST + 1], count = state->live_count, corners = 0;
    double rect[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY}, sum = 0;
    for (uint32_t i = 0; i <= count; i++) {
        all[i] = i < count ? state->live[i] : arrived;
        const EnfAperture *one = &view->apertures[all[i]];
        for (int k = 0; k < 2; k++) {
            rect[k] = enf_lesser(rect[k], one->rect[k]);
            rect[2 + k] = enf_greater(rect[2 + k], one->rect[2 + k]);
        }
        sum += one->area;
        corners += one->count;
    }
    if (sum < 0.499 * (rect[2] - rect[0]) * (rect[3] - rect[1]) || corners > ENF_POLY_MAX)
        return 0;
    hull->n = 0;
    for (uint32_t i = 0; i <= count; i++)
        enf_poly_append(hull, corners_of(view, all[i]), view->apertures[all[i]].count);
    view->stats.hulls++;
    view->stats.work += ENF_WORK_HULL * count;
    enf_poly_hull(hull);
    double area = enf_poly_area(hull);
    /* The union is at least the sum less what pairs have in common. */
    for (uint32_t i = 0; i <= count && area - sum <= MERGE_GROWTH * area; i++)
        for (uint32_t j = 0; j < i; j++)
            if (!apart(view->apertures[all[i]].rect, view->apertures[all[j]].rect, 0))
                sum -= common_area(view, all[i], all[j]);
    if (area - sum > MERGE_GROWTH * area)
        return 0;
    enf_poly_tidy(hull);
    return 1;
}

/* Everything the cell has, and `poly`, as one aperture on the grid. */
static void collapse(EnfView *view, const EnfScreen *screen, EnfCellState *state, uint32_t arrived, EnfPoly *poly) {
    static const double wide[4] = {-4, -4, 4, 4}; /* pictures from the middle of several eyes (parallax.h) */
    EnfAperture *a = &view->apertures[arrived];
    while (state->live_count > 0) {
        uint32_t live = state->live[state->live_count - 1], count = view->apertures[live].count;
        a->nearness = enf_greater(a->nearness, view->apertures[live].nearness);
        if (poly->n + count > ENF_POLY_MAX) {
            enf_poly_hull(poly);
            enf_poly_tidy(poly);
        }
        enf_poly_append(poly, corners_of(view, live), count);
        drop_live(view, state, state->live_count - 1);
    }
    enf_poly_hull(poly);
    enf_poly_snap(poly, view->screens.from_middle ? wide : screen->view_rect);
    if (!(state->flags & ENF_CELL_SNAPPED)) {
        state->flags |= ENF_CELL_SNAPPED;
        view->stats.cells_snapped++;
    }
}

/* Merges `arrived` with every live aperture whose hull with it adds at most `growth`. */
static void merge_exactly(EnfView *view, EnfCellState *state, uint32_t arrived, double growth) {
    EnfPoly hull;
    EnfAperture *a = &view->apertures[arrived];
    for (uint32_t i = 0; i < state->live_count;) {
        const EnfAperture *live = &view->apertures[state->live[i]];
        double wide = enf_greater(live->rect[2], a->rect[2]) - enf_lesser(live->rect[0], a->rect[0]);
        double high = enf_greater(live->rect[3], a->rect[3]) - enf_lesser(live->rect[1], a->rect[1]);
        /* Apart by more than the rounding of a common edge: the hull adds what lies between. And what fills less than half of its
         * bounding rectangle has a hull that adds much, but for slivers along a diagonal, which stay apart. */
        if (apart(live->rect, a->rect, 1e-6) || a->area + live->area < 0.499 * wide * high ||
            !(merged_hull(view, arrived, state->live[i], &hull, 1) <= growth * (a->area + live->area))) {
            i++;
            continue;
        }
        view->stats.merges_exact++;
        if (live->area > a->area) { /* the why of the larger part */
            view->step_parent[a->step] = view->step_parent[live->step];
            view->step_portal[a->step] = view->step_portal[live->step];
        }
        double outset = enf_greater(a->outset, live->outset);
        a->nearness = enf_greater(a->nearness, live->nearness);
        enf_poly_tidy(&hull);
        drop_live(view, state, i);
        measure_aperture(view, arrived, &hull, outset);
        i = 0; /* the larger one may now merge with, or contain, others */
    }
    if (state->live_count >= 2 && state->live_count <= MERGE_ALL_MOST && merge_all(view, state, arrived, &hull)) {
        double outset = a->outset;
        view->stats.merges_exact += state->live_count;
        while (state->live_count > 0) {
            const EnfAperture *live = &view->apertures[state->live[state->live_count - 1]];
            outset = enf_greater(outset, live->outset);
            a->nearness = enf_greater(a->nearness, live->nearness);
            drop_live(view, state, state->live_count - 1);
        }
        measure_aperture(view, arrived, &hull, outset);
    }
}

/* Merges until the cell keeps fewer than `most` beside `arrived`: with the one whose hull adds least; rectangles as such. */
static void merge_forced(EnfView *view, const EnfScreen *screen, EnfCellState *state, uint32_t arrived, uint32_t most, int box) {
    EnfPoly hulls[2], *hull = &hulls[0], *trial = &hulls[1];
    EnfAperture *a = &view->apertures[arrived];
    while (state->live_count >= most) {
        uint32_t best = 0;
        double least = INFINITY;
        for (uint32_t i = 0; i < state->live_count && !box; i++) {
            double added = merged_hull(view, arrived, state->live[i], trial, 0);
            if (added < least) {
                EnfPoly *swap = hull;
                hull = trial;
                trial = swap;
                least = added;
                best = i;
            }
        }
        const EnfAperture *live = &view->apertures[state->live[best]];
        double outset = enf_greater(a->outset, live->outset);
        a->nearness = enf_greater(a->nearness, live->nearness);
        if (box) {
            double rect[4] = {enf_lesser(a->rect[0], live->rect[0]), enf_lesser(a->rect[1], live->rect[1]),
                              enf_greater(a->rect[2], live->rect[2]), enf_greater(a->rect[3], live->rect[3])};
            enf_poly_from_rect(hull, rect);
        } else
            enf_poly_tidy(hull);
        drop_live(view, state, best);
        view->stats.merges_forced++;
        if (++state->merges >= MERGES_BEFORE_SNAP)
            collapse(view, screen, state, arrived, hull);
        measure_aperture(view, arrived, hull, outset);
        drop_contained(view, state, arrived);
    }
}

void enf_arrive(EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, EnfPoly *poly, const double rect[4], double area,
                double outset, const double *z, uint32_t parent) {
    const int box = view->def.method == ENF_VIEW_BOX;
    EnfCellState *state = enf_touch_state(view, side->to);
    double nearness = 0;
    for (uint32_t i = 0; i < poly->n && z; i++)
        nearness = enf_greater(nearness, z[i]);
    view->stats.work += ENF_WORK_ARRIVE + 2 * (uint32_t)state->live_count; /* compared with each */
    for (uint32_t i = 0; i < state->live_count; i++)
        if (poly_within(view, poly, z, rect, nearness, state->live[i])) {
            view->stats.apertures_contained++;
            return;
        }
    const uint32_t arrived = take_aperture(view, nearness), corners = poly->n;
    if (corners > 4)
        enf_poly_tidy(poly);
    if (poly->n == corners)
        set_aperture(view, arrived, poly, z, rect, area, outset);
    else
        measure_aperture(view, arrived, poly, outset);
    EnfAperture *a = &view->apertures[arrived];
    drop_contained(view, state, arrived);
    a->step = enf_make_step(view, side->to, side->portal, parent);
    const int outdoors = view->index->cells[side->to].flags & ENF_VIEW_CELL_OUTDOORS;
    if (state->flags & ENF_CELL_VISITED && state->regrown < 255 &&
        ++state->regrown > (outdoors ? REGROWN_BEFORE_SNAP_OUTDOORS : REGROWN_BEFORE_SNAP))
        state->merges = MERGES_BEFORE_SNAP;
    if (state->merges >= MERGES_BEFORE_SNAP) {
        collapse(view, screen, state, arrived, poly);
        measure_aperture(view, arrived, poly, outset);
    } else if (state->live_count > 0) {
        /* Where exactness is for nothing one rectangle does. */
        const int coarse = box || (outdoors && view->one_middle && !enf_needs_care(view, side->to));
        /* From outdoors a corridor is seen through many rooms' windows at once: merging makes more work than it spares. */
        const EnfViewCell *cell = &view->index->cells[side->to];
        const uint32_t most = outdoors || view->starts_outdoors ? enf_aperture_places(cell) : view->def.max_apertures;
        if (!coarse)
            merge_exactly(view, state, arrived, outdoors ? MERGE_GROWTH_OUTDOORS : MERGE_GROWTH);
        merge_forced(view, screen, state, arrived, coarse || view->repeat_visits > view->def.visit_cap ? 1 : most, coarse);
    }
    view->stats.apertures++;
    state->live[state->live_count++] = arrived;
    if (!(state->flags & ENF_CELL_IN_HEAP)) {
        state->flags |= ENF_CELL_IN_HEAP;
        enf_queue_add(view, side->to);
    } else /* an open plan: by now its sides have come from memory, and its turn is a while off */
        enf_queue_prefetch(view, side->to);
}

void enf_arrive_whole(EnfView *view, const EnfScreen *screen, uint32_t cell, uint32_t portal, uint32_t parent) {
    EnfCellState *state = enf_touch_state(view, cell);
    uint32_t arrived = take_aperture(view, 0);
    measure_aperture(view, arrived, &screen->view, screen->outset);
    view->apertures[arrived].step = enf_make_step(view, cell, portal, parent);
    view->stats.apertures += portal != ENF_NONE;
    state->live[0] = arrived;
    state->live_count = 1;
    if (portal == ENF_NONE) {
        state->flags = ENF_CELL_START;
        if (view->index->cells[cell].flags & ENF_VIEW_CELL_OUTDOORS) {
            state->flags |= ENF_CELL_KNOWN | ENF_CELL_OPEN;
            view->starts_outdoors = 1;
        }
        enf_queue_push(view, -1, cell); /* before all others */
    } else if (!(state->flags & ENF_CELL_IN_HEAP))
        enf_queue_add(view, cell);
    state->flags |= ENF_CELL_WHOLE | ENF_CELL_IN_HEAP;
}
