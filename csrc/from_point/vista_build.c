/* SPDX-License-Identifier: GPL-3.0-or-later
 * Vistas prepared: for each window the rows of portals that straight lines from outdoors can pass, and the slopes of these lines.
 *
 * In the window's frame a line is x = t + s z, for y likewise. What passes a box [a0, a1] x [za0, za1] and later [b0, b1] x
 * [zb0, zb1] has (b0 - a1) / dz <= s <= (b1 - a0) / dz: each two portals of a row narrow s, in x and y apart (Teller's (1992)
 * stabbing of boxes, one dimension at a time). Ours: the lookup by slope.
 *
 * Safe direction: boxes bound portals and objects; closed openings count as open here; rows that are cut short go on by the traversal. */
#include "from_point/vista.h"
#include "from_point/aperture.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Work on all windows: pairs of boxes, some 15 ns each, and so many more for each window. What isn't prepared then isn't swept. */
#define MOST_TRIED        1500000
#define MOST_TRIED_WINDOW 500
/* The sweep looks at half of all windows or so, at each for as long as the frustum's test takes for this many items; likewise a facade. */
#define WINDOW_PAYS 2
#define FACADE_PAYS 8
/* A window's surface may stray by this much of the scene's extent from a plane of its facade. */
#define MOST_BENT 1e-5

/* Slopes in x and y: lo, hi of each. */
typedef struct Slopes {
    double lo[2], hi[2];
} Slopes;

/* A stage being prepared: the portal it is entered by, as a box in the window's frame. */
typedef struct Way {
    Slopes slopes;
    double box[6];
    uint32_t cell, portal, opening, parent;
    uint32_t slot; /* once it is among the vista's cells */
} Way;

typedef struct Window {
    double u[3], n[3], corner[3];
    uint32_t side;
} Window;

/* What passes box a, then box b. */
static void narrow(Slopes *s, const double a[6], const double b[6]) {
    const double dz_least = b[2] - a[5], dz_most = b[5] - a[2];
    if (!(dz_most > 0)) {
        s->lo[0] = INFINITY;
        s->hi[0] = -INFINITY;
        return;
    }
    for (int k = 0; k < 2; k++) {
        double least = b[k] - a[3 + k], most = b[3 + k] - a[k];
        double hi = most > 0 ? (dz_least > 0 ? most / dz_least : INFINITY) : most / dz_most;
        double lo = least < 0 ? (dz_least > 0 ? least / dz_least : -INFINITY) : least / dz_most;
        s->hi[k] = enf_lesser(s->hi[k], hi);
        s->lo[k] = enf_greater(s->lo[k], lo);
    }
}

/* Portals are crossed from their near side: n . (sx, sy, 1) > 0, n in the window's frame. 1e-6: roundings, generously. */
static void narrow_facing(Slopes *s, const double n[3]) {
    for (int k = 0; k < 2; k++) {
        const double other = n[1 - k] > 0 ? s->hi[1 - k] : s->lo[1 - k];
        const double rest = n[2] + (n[1 - k] != 0 ? n[1 - k] * other : 0);
        if (!isfinite(rest))
            continue;
        if (fabs(n[k]) < 1e-6) {
            if (fabs(n[1 - k]) < 1e-6 && n[2] < -1e-6)
                s->hi[k] = -INFINITY;
            continue;
        }
        double bound = -rest / n[k], wide = 1e-6 * (1 + fabs(bound));
        if (n[k] > 0)
            s->lo[k] = enf_greater(s->lo[k], bound - wide);
        else
            s->hi[k] = enf_lesser(s->hi[k], bound + wide);
    }
}

static int is_empty(const Slopes *s) {
    return !(s->lo[0] <= s->hi[0] && s->lo[1] <= s->hi[1]);
}

/* ---- The window's frame --------------------------------------------------------------------------------------------------------- */
static void in_frame(const EnfFacade *f, const double p[3], double out[3]) {
    double q[3];
    vec_sub(q, p, f->corner);
    vec_set(out, vec_dot(f->u, q), vec_dot(f->v, q), vec_dot(f->n, q));
}

/* Bounds of a portal's surface, with all rounding. */
static void side_bounds(const EnfViewIndex *index, const EnfFacade *f, const EnfPortalSide *side, double box[6]) {
    box_empty(box);
    for (uint32_t i = 0; i < side->vertex_count; i++) {
        double q[3];
        in_frame(f, index->vertices[side->vertex_first + i], q);
        box_add_point(box, q);
    }
    box_grow(box, side->slack + 1e-9 * index->scene->extent);
}

static void object_bounds(const EnfViewIndex *index, const EnfFacade *f, const double bounds[6], double box[6]) {
    const double *axes[3] = {f->u, f->v, f->n};
    double centre[3], half[3], q[3];
    for (int k = 0; k < 3; k++) {
        centre[k] = 0.5 * (bounds[k] + bounds[3 + k]);
        half[k] = 0.5 * (bounds[3 + k] - bounds[k]);
    }
    in_frame(f, centre, q);
    for (int k = 0; k < 3; k++) {
        double about = fabs(axes[k][0]) * half[0] + fabs(axes[k][1]) * half[1] + fabs(axes[k][2]) * half[2];
        box[k] = q[k] - about;
        box[3 + k] = q[k] + about;
    }
    box_grow(box, 1e-9 * index->scene->extent);
}

/* Whether an object is in some cell outdoors: it is seen from there whatever windows show. */
static int is_outdoors(const EnfViewIndex *index, uint32_t object) {
    const EnfScene *scene = index->scene;
    for (uint32_t i = scene->placed_first[object]; i < scene->placed_first[object + 1]; i++)
        if (index->cells[scene->placed_cells[i]].flags & ENF_VIEW_CELL_OUTDOORS)
            return 1;
    return 0;
}

/* ---- One window ------------------------------------------------------------------------------------------------------------------- */
static void put_slopes(EnfSlopes16 *block, uint32_t lane, const Slopes *s) {
    for (int k = 0; k < 2; k++) {
        block->lo[k][lane] = enf_slope_key((float)s->lo[k]);
        block->hi[k][lane] = enf_slope_key((float)s->hi[k]);
    }
}

static void empty_block(EnfSlopes16 *block) {
    for (uint32_t lane = 0; lane < ENF_SLOPE_LANES; lane++)
        for (int k = 0; k < 2; k++) {
            block->lo[k][lane] = INT16_MAX;
            block->hi[k][lane] = INT16_MIN;
        }
}

/* Narrows by all portals of a row and what comes behind it. */
static int narrow_row(const Way *ways, uint32_t last, const double box[6], Slopes *s, uint64_t *tried) {
    *s = ways[last].slopes;
    for (uint32_t i = last;; i = ways[i].parent) {
        ++*tried;
        narrow(s, ways[i].box, box);
        if (is_empty(s))
            return 0;
        if (i == 0)
            return 1;
    }
}

static int on_row(const Way *ways, uint32_t last, uint32_t cell) {
    for (uint32_t i = last;; i = ways[i].parent) {
        if (ways[i].cell == cell)
            return 1;
        if (i == 0)
            return 0;
    }
}

/* Rows of portals from way 0 on, nearest first. 0: there are more than a vista may have. */
static uint32_t find_ways(const EnfViewIndex *index, const EnfFacade *f, Way *ways, uint64_t *tried) {
    uint32_t count = 1;
    for (uint32_t i = 0; i < count; i++) {
        const EnfViewCell *cell = &index->cells[ways[i].cell];
        for (uint32_t k = 0; k < cell->side_count; k++) {
            const EnfPortalSide *side = &index->sides[cell->side_first + k];
            Way next;
            if (side->portal == ways[i].portal || index->cells[side->to].flags & ENF_VIEW_CELL_OUTDOORS || on_row(ways, i, side->to))
                continue;
            side_bounds(index, f, side, next.box);
            if (!narrow_row(ways, i, next.box, &next.slopes, tried))
                continue;
            if (side->slack == 0) {
                double n[3] = {vec_dot(side->n, f->u), vec_dot(side->n, f->v), vec_dot(side->n, f->n)};
                narrow_facing(&next.slopes, n);
                if (is_empty(&next.slopes))
                    continue;
            }
            if (count == ENF_VISTA_STAGES)
                return 0;
            next.cell = side->to;
            next.portal = side->portal;
            next.opening = side->opening;
            next.parent = i;
            ways[count++] = next;
        }
    }
    return count;
}

/* The same for a box that is turned against the frame: by its corners. narrow_row found nothing against it. */
static int narrow_corners(const EnfFacade *f, const Way *ways, uint32_t last, const double bounds[6], double slack, Slopes *s) {
    double q[8][3], nearest = INFINITY;
    for (int i = 0; i < 8; i++) {
        in_frame(f, (const double[3]){bounds[i & 1 ? 3 : 0], bounds[i & 2 ? 4 : 1], bounds[i & 4 ? 5 : 2]}, q[i]);
        nearest = enf_lesser(nearest, q[i][2]);
    }
    for (uint32_t i = last;; i = ways[i].parent) {
        const double *a = ways[i].box;
        double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
        for (int c = 0; c < 8 && nearest - slack > a[5]; c++) { /* else narrow_row's are as good as any */
            const double least = 1 / (q[c][2] - slack - a[5]), most = 1 / (q[c][2] + slack - a[2]);
            for (int k = 0; k < 2; k++) {
                double right = q[c][k] + slack - a[k], left = q[c][k] - slack - a[3 + k];
                hi[k] = enf_greater(hi[k], right * (right > 0 ? least : most));
                lo[k] = enf_lesser(lo[k], left * (left < 0 ? least : most));
            }
        }
        for (int k = 0; k < 2 && nearest - slack > a[5]; k++) {
            s->lo[k] = enf_greater(s->lo[k], lo[k]);
            s->hi[k] = enf_lesser(s->hi[k], hi[k]);
        }
        if (i == 0)
            return !is_empty(s);
    }
}

/* Item `lane` of the window whose items begin with block `first`. 0: out of memory. */
static int put_item(EnfVistaItems *list, uint32_t first, uint32_t lane, const Slopes *slopes, uint32_t id, uint32_t stage) {
    const uint32_t block = first + lane / ENF_SLOPE_LANES, slot = first * ENF_SLOPE_LANES + lane;
    if (block == list->block_count) {
        const uint64_t slots = (block + 1ull) * ENF_SLOPE_LANES;
        if (!ENF_RESERVE(list->slopes, block + 1ull) || !ENF_RESERVE(list->ids, slots) || !ENF_RESERVE(list->stages, slots))
            return 0;
        empty_block(&list->slopes[list->block_count++]);
    }
    put_slopes(&list->slopes[block], lane % ENF_SLOPE_LANES, slopes);
    list->ids[slot] = id;
    list->stages[slot] = stage;
    return 1;
}

/* What of way `at` is seen, unless it is outdoors as well: those are compared with the view in any case. */
static int add_objects(const EnfViewIndex *index, struct EnfVistas *v, const EnfFacade *f, const Way *ways, uint32_t at, EnfVista *vista) {
    const EnfScene *scene = index->scene;
    const EnfViewCell *cell = &index->cells[ways[at].cell];
    for (uint32_t i = 0; i < cell->objects.item_count; i++) {
        const uint32_t object = index->object_ids[cell->object_first + i];
        double box[6];
        Slopes s;
        if (is_outdoors(index, object))
            continue;
        object_bounds(index, f, scene->objects[object].bounds, box);
        if (!narrow_row(ways, at, box, &s, &v->tried) ||
            (f->turned && !narrow_corners(f, ways, at, scene->objects[object].bounds, 1e-9 * scene->extent, &s)))
            continue;
        if (!put_item(&v->objects, vista->object_block, vista->object_count++, &s, object, ways[at].slot))
            return 0;
    }
    return 1;
}

/* The stages behind way 0, and objects in them. */
static int add_stages(const EnfViewIndex *index, struct EnfVistas *v, const EnfFacade *f, Way *ways, EnfVista *vista) {
    for (uint32_t i = 0; i < vista->cell_count; i++) {
        Way *way = &ways[i];
        way->slot = vista->cell_block * ENF_SLOPE_LANES + i;
        if (!put_item(&v->cells, vista->cell_block, i, &way->slopes, way->cell, ways[way->parent].slot) ||
            !ENF_RESERVE(v->portals, way->slot + 1ull) || !ENF_RESERVE(v->openings, way->slot + 1ull))
            return 0;
        v->portals[way->slot] = way->portal;
        v->openings[way->slot] = way->opening;
        if (!add_objects(index, v, f, ways, i, vista))
            return 0;
    }
    return 1;
}

/* box: of its portal; 0: out of memory. */
static int add_vista(const EnfViewIndex *index, struct EnfVistas *v, const EnfFacade *f, const EnfPortalSide *side, const double box[6],
                     EnfVista *vista) {
    Way ways[ENF_VISTA_STAGES];
    ways[0] =
        (Way){.slopes = {{-INFINITY, -INFINITY}, {INFINITY, INFINITY}}, .cell = side->to, .portal = side->portal, .opening = side->opening};
    memcpy(ways[0].box, box, sizeof ways[0].box);
    *vista = (EnfVista){.cell_block = v->cells.block_count, .object_block = v->objects.block_count};
    if (v->tried < MOST_TRIED + (uint64_t)MOST_TRIED_WINDOW * v->vista_count && box[5] - box[2] <= MOST_BENT * index->scene->extent)
        vista->cell_count = find_ways(index, f, ways, &v->tried);
    vista->complete = vista->cell_count > 0;
    int ok = add_stages(index, v, f, ways, vista);
    vista->work =
        ENF_WORK_WINDOW + 2 * ENF_WORK_BLOCK * (v->cells.block_count - vista->cell_block + v->objects.block_count - vista->object_block);
    return ok;
}

/* ---- All windows -------------------------------------------------------------------------------------------------------------------- */
/* u: level where the window isn't; else along its longest edge, turned into the first quarter. */
static void window_axis(const EnfViewIndex *index, const EnfPortalSide *side, double u[3]) {
    const double(*p)[3] = (const double(*)[3])(index->vertices + side->vertex_first);
    double longest = 0, edge[3], quarter[3];
    vec_set(u, -side->n[1], side->n[0], 0);
    if (vec_normalize(u) > 1e-3)
        return;
    for (uint32_t i = 0; i < side->vertex_count; i++) {
        vec_sub(edge, p[(i + 1) % side->vertex_count], p[i]);
        if (vec_length(edge) > longest) {
            longest = vec_length(edge);
            vec_copy(u, edge);
        }
    }
    vec_mad(u, u, -vec_dot(u, side->n), side->n);
    if (!(vec_normalize(u) > 0))
        vec_set(u, 1, 0, 0);
    for (int turn = 0; turn < 3 && !(u[0] > 1e-9 && u[1] >= -1e-9); turn++) {
        vec_cross(quarter, side->n, u);
        vec_copy(u, quarter);
    }
}

/* Directions that differ by less are one. */
static const double same_direction = 1e-9;

static int compare_windows(const void *pa, const void *pb) {
    const Window *a = pa, *b = pb;
    for (int part = 0; part < 2; part++)
        for (int k = 0; k < 3; k++) {
            double x = part ? a->u[k] : a->n[k], y = part ? b->u[k] : b->n[k];
            x = floor(x / same_direction + 0.5);
            y = floor(y / same_direction + 0.5);
            if (x != y)
                return x < y ? -1 : 1;
        }
    for (int k = 0; k < 3; k++)
        if (a->corner[k] != b->corner[k])
            return a->corner[k] < b->corner[k] ? -1 : 1;
    return a->side < b->side ? -1 : a->side > b->side;
}

static Window *list_windows(const EnfViewIndex *index, uint32_t *count) {
    uint64_t most = 0;
    for (uint32_t c = 0; c < index->scene->cell_count; c++)
        most += index->cells[c].flags & ENF_VIEW_CELL_OUTDOORS ? index->cells[c].side_count : 0;
    Window *windows = ENF_NEW(Window, most);
    *count = 0;
    for (uint32_t c = 0; c < index->scene->cell_count && windows; c++)
        for (uint32_t i = 0; i < index->cells[c].side_count && index->cells[c].flags & ENF_VIEW_CELL_OUTDOORS; i++) {
            const EnfPortalSide *side = &index->sides[index->cells[c].side_first + i];
            if (index->cells[side->to].flags & ENF_VIEW_CELL_OUTDOORS)
                continue;
            Window *window = &windows[(*count)++];
            window->side = index->cells[c].side_first + i;
            vec_copy(window->n, side->n);
            window_axis(index, side, window->u);
            vec_copy(window->corner, index->vertices[side->vertex_first]);
        }
    if (windows)
        qsort(windows, *count, sizeof *windows, compare_windows);
    return windows;
}

static int same_facade(const Window *a, const Window *b) {
    return vec_distance(a->n, b->n) < same_direction && vec_distance(a->u, b->u) < same_direction;
}

/* The facade of windows[0 .. n - 1]; boxes, order: room for as many. */
static int add_facade(EnfViewIndex *index, struct EnfVistas *v, const Window *windows, uint32_t n, double (*boxes)[6], EnfTreeItem *order) {
    EnfFacade *f = &v->facades[v->facade_count++];
    const uint32_t lanes = (n + 7) / 8 * 8;
    double all[6];
    box_empty(all);
    vec_copy(f->n, windows[0].n);
    vec_copy(f->u, windows[0].u);
    vec_cross(f->v, f->n, f->u);
    vec_copy(f->corner, windows[0].corner);
    f->farthest = -INFINITY;
    for (int k = 0; k < 3; k++)
        f->turned |= fabs(f->n[k]) > 1e-9 && fabs(f->n[k]) < 1 - 1e-9;
    f->tree.item_count = n;
    f->tree.first_block = v->box_count;
    f->vista_first = v->vista_count;
    v->box_count += enf_tree_blocks(n);
    v->vista_count += lanes;
    if (!ENF_RESERVE(v->boxes, v->box_count) || !ENF_RESERVE(v->vistas, v->vista_count) || !ENF_RESERVE(v->windows, v->vista_count / 8))
        return 0;
    for (uint32_t i = 0; i < n; i++) {
        const EnfPortalSide *side = &index->sides[windows[i].side];
        box_empty(boxes[i]);
        for (uint32_t k = 0; k < side->vertex_count; k++) {
            double p[3];
            vec_sub(p, index->vertices[side->vertex_first + k], index->origin);
            box_add_point(boxes[i], p);
        }
        box_grow(boxes[i], side->slack);
        box_add_box(all, boxes[i]);
    }
    for (int k = 0; k < 3; k++) {
        f->centre[k] = (float)(0.5 * (all[k] + all[3 + k]));
        f->half[k] = (float)(0.5 * (all[3 + k] - all[k]));
    }
    enf_tree_build((const double(*)[6])boxes, n, order, v->boxes + f->tree.first_block);
    for (uint32_t i = 0; i < lanes; i++) {
        EnfWindows8 *eight = &v->windows[(f->vista_first + i) / 8];
        const uint32_t lane = i % 8;
        if (i >= n) { /* behind every eye */
            eight->x0[lane] = eight->x1[lane] = eight->y0[lane] = eight->y1[lane] = 0;
            eight->z[lane] = -INFINITY;
            continue;
        }
        const EnfPortalSide *side = &index->sides[windows[order[i].at].side];
        EnfVista *vista = &v->vistas[f->vista_first + i];
        double box[6];
        side_bounds(index, f, side, box);
        f->slack = enf_greater(f->slack, box[5] - box[2]);
        for (int k = 0; k < 6; k++)
            f->reach = enf_greater(f->reach, fabs(box[k]));
        f->farthest = enf_greater(f->farthest, box[5]);
        eight->x0[lane] = (float)box[0];
        eight->y0[lane] = (float)box[1];
        eight->x1[lane] = (float)box[3];
        eight->y1[lane] = (float)box[4];
        eight->z[lane] = (float)(0.5 * (box[2] + box[5]));
        if (!add_vista(index, v, f, side, box, vista))
            return 0;
    }
    return 1;
}

static EnfStatus add_facades(EnfViewIndex *index, struct EnfVistas *v) {
    uint32_t count;
    Window *windows = list_windows(index, &count);
    double(*boxes)[6] = enf_alloc_array(count, sizeof *boxes);
    EnfTreeItem *order = ENF_NEW(EnfTreeItem, count);
    v->facades = ENF_NEW(EnfFacade, count);
    int ok = windows && boxes && order && v->facades;
    for (uint32_t i = 0, begin = 0; i < count && ok; i++)
        if (i + 1 == count || !same_facade(&windows[begin], &windows[i + 1])) {
            ok = add_facade(index, v, windows + begin, i + 1 - begin, boxes, order);
            begin = i + 1;
        }
    enf_free(windows);
    enf_free(boxes);
    enf_free(order);
    return ok ? ENF_OK : enf_fail_memory();
}

/* ---- The open ------------------------------------------------------------------------------------------------------------------------ */
static EnfStatus pack_outdoors(EnfViewIndex *index, struct EnfVistas *v) {
    const EnfScene *scene = index->scene;
    uint32_t cells = 0, objects = 0;
    uint32_t *ids = ENF_NEW(uint32_t, scene->cell_count), *object_ids = ENF_NEW(uint32_t, scene->object_count);
    v->boundless = ENF_NEW(uint32_t, scene->cell_count);
    EnfStatus status = ids && object_ids && v->boundless ? ENF_OK : enf_fail_memory();
    for (uint32_t c = 0; c < scene->cell_count && status == ENF_OK; c++)
        if (index->cells[c].flags & ENF_VIEW_CELL_OUTDOORS) {
            if (index->cells[c].flags & ENF_VIEW_CELL_LAST || box_is_empty(scene->cell_bounds[c]))
                v->boundless[v->boundless_count++] = c;
            else
                ids[cells++] = c;
        }
    for (uint32_t o = 0; o < scene->object_count && status == ENF_OK; o++)
        if (is_outdoors(index, o))
            object_ids[objects++] = o;
    if (status == ENF_OK)
        status = enf_box_set_of_cells(index, ids, cells, &v->outdoors);
    if (status == ENF_OK)
        status = enf_box_set_of_objects(index, object_ids, objects, &v->outdoor_objects);
    enf_free(ids);
    enf_free(object_ids);
    return status;
}

/* ---- Life ---------------------------------------------------------------------------------------------------------------------------- */
void enf_vistas_destroy(struct EnfVistas *v) {
    if (!v)
        return;
    void *blocks[] = {v->facades,        v->boxes,       v->windows,        v->vistas,  v->cells.slopes, v->cells.ids, v->cells.stages,
                      v->objects.slopes, v->objects.ids, v->objects.stages, v->portals, v->openings,     v->boundless};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++)
        enf_free(blocks[i]);
    enf_box_set_free(&v->outdoors);
    enf_box_set_free(&v->outdoor_objects);
    enf_free(v);
}

EnfStatus enf_build_vistas(EnfViewIndex *index) {
    struct EnfVistas *v = index->vistas = ENF_NEW(struct EnfVistas, 1);
    EnfStatus status = v ? pack_outdoors(index, v) : enf_fail_memory();
    if (status == ENF_OK)
        status = add_facades(index, v);
    if (status == ENF_OK) {
        const uint32_t indoors = index->scene->cell_count - v->outdoors.tree.item_count - v->boundless_count + index->scene->object_count -
                                 v->outdoor_objects.tree.item_count - index->unplaced.tree.item_count;
        v->pays = indoors > WINDOW_PAYS * v->vista_count + FACADE_PAYS * v->facade_count;
    }
    return status;
}
