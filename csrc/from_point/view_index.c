/* SPDX-License-Identifier: GPL-3.0-or-later
 * Packs a committed scene into the arrays of view_index.h. Everything is ordered by geometry, never by the order of input,
 * so that permuting cells, portals or vertices doesn't change an answer. */
#include "from_point/view_index.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "from_point/aperture.h"
#include "from_point/occlusion.h"
#include "from_point/open_air.h"
#include "from_point/project_corners.h"
#include "from_point/glance.h"
#include "from_point/vista.h"
#include "from_point/walls.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_points(const double a[3], const double b[3]) {
    for (int c = 0; c < 3; c++)
        if (a[c] != b[c])
            return a[c] < b[c] ? -1 : 1;
    return 0;
}

/* Edges of a many-cornered portal are taken away, each time the one that adds least, in the portal's plane: outward. */
static uint32_t reduce_corners(double (*v)[3], uint32_t n, const double normal[3]) {
    while (n > ENF_PORTAL_CORNERS) {
        double best = INFINITY, best_point[3] = {0, 0, 0};
        uint32_t best_i = n;
        for (uint32_t i = 0; i < n; i++) {
            uint32_t a = (i + n - 1) % n, b = (i + 1) % n, c = (i + 2) % n;
            double d1[3], d2[3], e[3], t[3];
            vec_sub(d1, v[i], v[a]);
            vec_sub(d2, v[b], v[c]);
            vec_sub(e, v[b], v[i]);
            vec_cross(t, d1, d2);
            double cross = vec_dot(t, normal);
            vec_cross(t, e, d2);
            double s = vec_dot(t, normal) / cross;
            vec_cross(t, e, d1);
            double r = vec_dot(t, normal) / cross;
            if (!(s >= 0 && r >= 0 && s < 1e3 && r < 1e3))
                continue;
            double p[3], u[3];
            vec_mad(p, v[i], s, d1);
            vec_sub(u, p, v[i]);
            vec_cross(t, e, u);
            if (vec_length(t) < best) {
                best = vec_length(t);
                best_i = i;
                vec_copy(best_point, p);
            }
        }
        if (best_i == n)
            return 0;
        vec_copy(v[best_i], best_point);
        uint32_t b = (best_i + 1) % n;
        memmove(v + b, v + b + 1, sizeof *v * (n - b - 1));
        n--;
    }
    return n;
}

/* A square in the portal's plane round all its corners: the fallback of reduce_corners. */
static uint32_t bounding_square(double (*v)[3], const double normal[3], const double centre[3], double radius) {
    double a[3] = {fabs(normal[0]) < 0.6, fabs(normal[0]) >= 0.6, 0}, u[3], w[3];
    vec_cross(u, normal, a);
    vec_normalize(u);
    vec_cross(w, normal, u);
    radius *= 1.0 + 1e-9;
    for (int i = 0; i < 4; i++) {
        vec_mad(v[i], centre, (i == 1 || i == 2) ? radius : -radius, u);
        vec_mad(v[i], v[i], i >= 2 ? radius : -radius, w);
    }
    return 4;
}

/* Whether every corner turns the right way round `towards` (the normal that points to the viewer). */
static int is_convex(double (*v)[3], uint32_t n, const double towards[3]) {
    for (uint32_t i = 0; i < n; i++) {
        double a[3], b[3], t[3];
        vec_sub(a, v[(i + 1) % n], v[i]);
        vec_sub(b, v[(i + 2) % n], v[(i + 1) % n]);
        vec_cross(t, a, b);
        /* 1e-12 of the edges' product: collinear corners of a straight edge are harmless. */
        if (vec_dot(t, towards) < -1e-12 * vec_length(a) * vec_length(b))
            return 0;
    }
    return 1;
}

typedef struct SideKey {
    double centre[3];
    double first[3];
    uint32_t from;
    EnfCellPortal portal;
} SideKey;

static int compare_sides(const void *pa, const void *pb) {
    const SideKey *a = pa, *b = pb;
    int order = compare_points(a->centre, b->centre);
    if (order == 0)
        order = compare_points(a->first, b->first);
    return order ? order : a->portal.portal < b->portal.portal ? -1 : a->portal.portal > b->portal.portal;
}

/* One side with its corners, which are put to the index's vertices from `vertex_at` on. corners: scratch, room for those of the portal. */
static void pack_side(EnfViewIndex *index, const EnfCellPortal *portal, uint32_t vertex_at, double (*corners)[3], EnfPortalSide *side) {
    const EnfScene *scene = index->scene;
    uint32_t p = portal->portal, count = scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p];
    double(*v)[3] = scene->portal_vertices + scene->portal_vertex_first[p], towards[3];
    double sign = portal->side ? -1 : 1;
    vec_scale(side->n, sign, scene->portal_planes[p].n);
    vec_scale(towards, -1, side->n);
    side->to = portal->to;
    side->portal = p;
    side->opening = scene->portal_openings[p];
    side->slack = scene->portal_deviation[p];
    /* 1e-14 of the extent: rounding of the plane itself, not a bent portal; a hundredth of ENF_LINE_OUTSET at a
     * hundredth of the extent. Far from the origin corners are rounded by more, and slanted portals are bent. */
    if (side->slack <= 1e-14 * scene->extent)
        side->slack = 0;
    /* Start at the smallest corner: the same arithmetic whichever corner came first. */
    uint32_t start = 0;
    for (uint32_t k = 1; k < count; k++)
        if (compare_points(v[k], v[start]) < 0)
            start = k;
    for (uint32_t k = 0; k < count; k++)
        vec_copy(corners[k], v[portal->side ? (start + count - k) % count : (start + k) % count]);
    int convex = is_convex(corners, count, towards);
    if (!convex && side->slack == 0)
        side->slack = 1e-14 * scene->extent; /* not bent, but its hull is wanted */
    if (count > ENF_PORTAL_CORNERS) {
        count = convex ? reduce_corners(corners, count, towards) : 0;
        if (count == 0)
            count = bounding_square(corners, towards, scene->portal_centres[p], scene->portal_radii[p] + scene->portal_deviation[p]);
    }
    side->vertex_first = vertex_at;
    side->vertex_count = count;
    vec_sub(towards, corners[0], index->origin);
    side->offset = vec_dot(side->n, towards);
    memcpy(index->vertices + vertex_at, corners, sizeof *corners * count);
}

static EnfStatus pack_sides(EnfViewIndex *index) {
    const EnfScene *scene = index->scene;
    uint64_t sides = scene->cell_portal_first[scene->cell_count], vertices = 0;
    uint32_t most = 1, most_corners = 4;
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        uint32_t n = scene->cell_portal_first[c + 1] - scene->cell_portal_first[c];
        most = n > most ? n : most;
    }
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        uint32_t n = scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p];
        vertices += 2 * (uint64_t)(n > 4 ? n : 4);
        most_corners = n > most_corners ? n : most_corners;
    }
    if (vertices > 0xFFFFFFF0u)
        return enf_fail(ENF_ERROR_BAD_INPUT, "too many portal corners for one view: %llu", (unsigned long long)vertices);
    index->sides = ENF_NEW(EnfPortalSide, sides);
    index->vertices = enf_alloc_array(vertices + ENF_CORNER_SPARE, sizeof *index->vertices);
    SideKey *keys = ENF_NEW(SideKey, most);
    double(*corners)[3] = enf_alloc_array(most_corners, sizeof *corners);
    int ok = index->sides && index->vertices && keys && corners;
    uint32_t side_at = 0, vertex_at = 0;
    for (uint32_t c = 0; c < scene->cell_count && ok; c++) {
        EnfViewCell *cell = &index->cells[c];
        uint32_t first = scene->cell_portal_first[c], n = scene->cell_portal_first[c + 1] - first;
        for (uint32_t i = 0; i < n; i++) {
            keys[i].portal = scene->cell_portals[first + i];
            vec_copy(keys[i].centre, scene->portal_centres[keys[i].portal.portal]);
            vec_copy(keys[i].first, scene->cell_centres[keys[i].portal.to]);
        }
        qsort(keys, n, sizeof *keys, compare_sides);
        cell->side_first = side_at;
        cell->side_count = n;
        cell->vertex_first = vertex_at;
        for (uint32_t i = 0; i < n; i++) {
            EnfPortalSide *side = &index->sides[side_at++];
            pack_side(index, &keys[i].portal, vertex_at, corners, side);
            vertex_at += side->vertex_count;
        }
    }
    enf_free(keys);
    enf_free(corners);
    return ok ? ENF_OK : enf_fail_memory();
}

static void relative_box(const EnfViewIndex *index, const double bounds[6], double out[6]) {
    for (int c = 0; c < 6; c++)
        out[c] = bounds[c] - index->origin[c % 3];
}

static void stretch_reach(EnfViewIndex *index, const double box[6]) {
    for (int c = 0; c < 6; c++)
        index->reach = fmax(index->reach, fabs(box[c]));
}

void enf_box_set_free(EnfBoxSet *set) {
    enf_free(set->blocks);
    enf_free(set->ids);
}

/* bounds_of: of item i. */
static EnfStatus build_set(const EnfViewIndex *index, const double *(*bounds_of)(const EnfScene *, uint32_t), const uint32_t *ids,
                           uint32_t count, EnfBoxSet *set) {
    double(*boxes)[6] = enf_alloc_array(count, sizeof *boxes);
    EnfTreeItem *order = ENF_NEW(EnfTreeItem, count);
    set->blocks = ENF_NEW(EnfBoxes8, enf_tree_blocks(count));
    set->ids = ENF_NEW(uint32_t, count);
    set->tree.first_block = 0;
    set->tree.item_count = count;
    const int ok = boxes && order && set->blocks && set->ids;
    for (uint32_t i = 0; i < count && ok; i++)
        relative_box(index, bounds_of(index->scene, ids[i]), boxes[i]);
    if (ok)
        enf_tree_build((const double(*)[6])boxes, count, order, set->blocks);
    for (uint32_t i = 0; i < count && ok; i++)
        set->ids[i] = ids[order[i].at];
    enf_free(boxes);
    enf_free(order);
    if (ok)
        return ENF_OK;
    enf_box_set_free(set);
    memset(set, 0, sizeof *set);
    return enf_fail_memory();
}

static const double *cell_bounds(const EnfScene *scene, uint32_t cell) {
    return scene->cell_bounds[cell];
}
static const double *object_bounds(const EnfScene *scene, uint32_t object) {
    return scene->objects[object].bounds;
}

EnfStatus enf_box_set_of_cells(const EnfViewIndex *index, const uint32_t *cells, uint32_t count, EnfBoxSet *set) {
    return build_set(index, cell_bounds, cells, count, set);
}

EnfStatus enf_box_set_of_objects(const EnfViewIndex *index, const uint32_t *objects, uint32_t count, EnfBoxSet *set) {
    return build_set(index, object_bounds, objects, count, set);
}

static EnfStatus pack_objects(EnfViewIndex *index) {
    const EnfScene *scene = index->scene;
    uint64_t slots = scene->cell_object_first[scene->cell_count], blocks = 0;
    uint32_t most = 1;
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        uint32_t n = scene->cell_object_first[c + 1] - scene->cell_object_first[c];
        blocks += n ? enf_tree_blocks(n) : 0;
        most = n > most ? n : most;
    }
    if (blocks > 0xFFFFFFF0u || slots > 0xFFFFFFF0u)
        return enf_fail(ENF_ERROR_BAD_INPUT, "too many object places for one view: %llu", (unsigned long long)slots);
    index->object_blocks = ENF_NEW(EnfBoxes8, blocks);
    index->object_ids = ENF_NEW(uint32_t, slots);
    double(*boxes)[6] = enf_alloc_array(most, sizeof *boxes);
    EnfTreeItem *order = ENF_NEW(EnfTreeItem, most);
    EnfStatus status = ENF_OK;
    if (!index->object_blocks || !index->object_ids || !boxes || !order)
        status = enf_fail_memory();
    uint32_t block_at = 0, slot_at = 0;
    for (uint32_t c = 0; c < scene->cell_count && status == ENF_OK; c++) {
        EnfViewCell *cell = &index->cells[c];
        uint32_t first = scene->cell_object_first[c], n = scene->cell_object_first[c + 1] - first;
        cell->object_first = slot_at;
        cell->objects.first_block = block_at;
        cell->objects.item_count = n;
        if (n == 0)
            continue;
        for (uint32_t i = 0; i < n; i++) {
            relative_box(index, scene->objects[scene->cell_object_list[first + i]].bounds, boxes[i]);
            stretch_reach(index, boxes[i]);
        }
        enf_tree_build((const double(*)[6])boxes, n, order, index->object_blocks + block_at);
        for (uint32_t i = 0; i < n; i++)
            index->object_ids[slot_at + i] = scene->cell_object_list[first + order[i].at];
        slot_at += n;
        block_at += enf_tree_blocks(n);
    }
    if (status == ENF_OK && scene->unplaced_count) {
        for (uint32_t i = 0; i < scene->unplaced_count; i++) {
            relative_box(index, scene->objects[scene->unplaced_objects[i]].bounds, boxes[0]);
            stretch_reach(index, boxes[0]);
        }
        status = enf_box_set_of_objects(index, scene->unplaced_objects, scene->unplaced_count, &index->unplaced);
    }
    enf_free(boxes);
    enf_free(order);
    return status;
}

static EnfStatus pack_cell_boxes(EnfViewIndex *index) {
    const EnfScene *scene = index->scene;
    uint32_t *ids = ENF_NEW(uint32_t, scene->cell_count), count = 0;
    index->boundless_cells = ENF_NEW(uint32_t, scene->cell_count);
    EnfStatus status = ids && index->boundless_cells ? ENF_OK : enf_fail_memory();
    for (uint32_t c = 0; c < scene->cell_count && status == ENF_OK; c++) {
        double box[6];
        /* The outside without geometry reaches farther than its portals tell. */
        if (box_is_empty(scene->cell_bounds[c]) || index->cells[c].flags & ENF_VIEW_CELL_LAST) {
            index->boundless_cells[index->boundless_count++] = c;
            continue;
        }
        relative_box(index, scene->cell_bounds[c], box);
        stretch_reach(index, box);
        ids[count++] = c;
    }
    if (status == ENF_OK)
        status = enf_box_set_of_cells(index, ids, count, &index->cell_boxes);
    enf_free(ids);
    return status;
}

static EnfStatus pack_all_objects(EnfViewIndex *index) {
    const uint32_t count = index->scene->object_count;
    uint32_t *ids = ENF_NEW(uint32_t, count);
    for (uint32_t i = 0; i < count && ids; i++)
        ids[i] = i;
    EnfStatus status = ids ? enf_box_set_of_objects(index, ids, count, &index->all_objects) : enf_fail_memory();
    enf_free(ids);
    return status;
}

EnfStatus enf_view_index_create(const EnfScene *scene, EnfViewIndex **out_index) {
    EnfViewIndex *index = ENF_NEW(EnfViewIndex, 1);
    if (!index)
        return enf_fail_memory();
    index->scene = scene;
    index->commit_serial = scene->commit_serial;
    index->users = 1;
    index->lock = enf_mutex_create();
    index->cells = ENF_NEW(EnfViewCell, scene->cell_count);
    vec_copy(index->origin, scene->origin);
    /* Rounding of coordinates and planes; the locator's tolerance has the same reason but is coarser, because a start
     * cell too many costs more than a lookup. */
    double largest = 0;
    for (int c = 0; c < 6; c++)
        largest = fmax(largest, fabs(scene->bounds[c]));
    index->tolerance = fmax(1e-8 * scene->extent, 16 * DBL_EPSILON * largest);
    box_empty(index->indoors);
    EnfStatus status = index->lock && index->cells ? ENF_OK : enf_fail_memory();
    for (uint32_t c = 0; c < scene->cell_count && status == ENF_OK; c++) {
        vec_copy(index->cells[c].centre, scene->cell_centres[c]);
        if (scene->cell_face_first[c] < scene->cell_face_first[c + 1])
            index->cells[c].flags |= ENF_VIEW_CELL_FACES;
        if (enf_is_exterior(scene, c))
            index->cells[c].flags |= ENF_VIEW_CELL_OUTDOORS;
        else
            box_add_box(index->indoors, scene->cell_bounds[c]);
        if (scene->cell_openings[c] != ENF_NONE && scene->cell_portal_first[c + 1] - scene->cell_portal_first[c] == 2)
            index->cells[c].flags |= ENF_VIEW_CELL_PASSAGE;
        if (enf_is_exterior(scene, c) && scene->cell_vertex_first[c] == scene->cell_vertex_first[c + 1])
            index->cells[c].flags |= ENF_VIEW_CELL_LAST;
    }
    if (status == ENF_OK)
        status = pack_sides(index);
    if (status == ENF_OK)
        status = enf_build_walls(index);
    if (status == ENF_OK)
        status = enf_build_glances(index);
    if (status == ENF_OK)
        status = enf_build_open_faces(index);
    if (status == ENF_OK)
        status = pack_objects(index);
    if (status == ENF_OK)
        status = pack_cell_boxes(index);
    if (status == ENF_OK)
        status = pack_all_objects(index);
    if (status == ENF_OK)
        status = enf_occlusion_pack(index);
    if (status == ENF_OK)
        status = enf_build_vistas(index);
    if (status != ENF_OK) {
        enf_view_index_release(index);
        return status;
    }
    *out_index = index;
    return ENF_OK;
}

void enf_view_index_retain(EnfViewIndex *index) {
    enf_mutex_lock(index->lock);
    index->users++;
    enf_mutex_unlock(index->lock);
}

void enf_view_index_release(EnfViewIndex *index) {
    if (!index)
        return;
    uint32_t left = 0;
    if (index->lock) {
        enf_mutex_lock(index->lock);
        left = --index->users;
        enf_mutex_unlock(index->lock);
    }
    if (left)
        return;
    enf_mutex_destroy(index->lock);
    enf_free(index->cells);
    enf_free(index->sides);
    enf_free(index->vertices);
    enf_free(index->walls);
    enf_free(index->glances);
    enf_free(index->glance_doors);
    enf_free(index->open_faces);
    enf_free(index->open_sources);
    enf_free(index->wall_blocks);
    enf_free(index->wall_sides);
    enf_free(index->object_blocks);
    enf_free(index->object_ids);
    enf_free(index->occluder_first);
    enf_free(index->occluders);
    enf_box_set_free(&index->unplaced);
    enf_box_set_free(&index->cell_boxes);
    enf_free(index->boundless_cells);
    enf_box_set_free(&index->all_objects);
    enf_vistas_destroy(index->vistas);
    enf_free(index);
}
