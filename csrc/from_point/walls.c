/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walls: back-wall culling and the hierarchy over the portals of a cell that has many.
 * Based on: Johansson & Roupe 2009, section 4.3. */
#include "from_point/walls.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct SideKey {
    int direction[3]; /* the normal, in steps */
    double offset;    /* of the plane */
    uint32_t side;
} SideKey;

static int compare_keys(const void *pa, const void *pb) {
    const SideKey *a = pa, *b = pb;
    for (int k = 0; k < 3; k++)
        if (a->direction[k] != b->direction[k])
            return a->direction[k] < b->direction[k] ? -1 : 1;
    if (a->offset != b->offset)
        return a->offset < b->offset ? -1 : 1;
    return a->side < b->side ? -1 : a->side > b->side; /* sides are in geometric order already */
}

static void side_box(const EnfViewIndex *index, const EnfPortalSide *side, double box[6]) {
    for (int c = 0; c < 3; c++) {
        box[c] = INFINITY;
        box[3 + c] = -INFINITY;
        for (uint32_t i = 0; i < side->vertex_count; i++) {
            double p = index->vertices[side->vertex_first + i][c] - index->origin[c];
            box[c] = fmin(box[c], p);
            box[3 + c] = fmax(box[3 + c], p);
        }
    }
}

/* Fills a wall from keys[0 .. n - 1]. */
static void fill_wall(EnfViewIndex *index, EnfWall *wall, const SideKey *keys, uint32_t n, double (*boxes)[6], EnfTreeItem *order) {
    memset(wall, 0, sizeof *wall);
    for (uint32_t i = 0; i < n; i++)
        vec_add(wall->n, wall->n, index->sides[keys[i].side].n);
    if (!(vec_normalize(wall->n) > 0))
        vec_copy(wall->n, index->sides[keys[0].side].n);
    wall->offset = -INFINITY;
    for (uint32_t i = 0; i < n; i++) {
        const EnfPortalSide *side = &index->sides[keys[i].side];
        wall->spread = fmax(wall->spread, vec_distance(side->n, wall->n));
        wall->slack = fmax(wall->slack, side->slack);
        side_box(index, side, boxes[i]);
        for (int c = 0; c < 6; c++)
            index->reach = fmax(index->reach, fabs(boxes[i][c]));
        for (uint32_t k = 0; k < side->vertex_count; k++) {
            double p[3];
            vec_sub(p, index->vertices[side->vertex_first + k], index->origin);
            wall->offset = fmax(wall->offset, vec_dot(wall->n, p));
        }
    }
    wall->tree.first_block = index->wall_block_count;
    wall->tree.item_count = n;
    wall->slot_first = index->wall_slot_count;
    enf_tree_build((const double(*)[6])boxes, n, order, index->wall_blocks + index->wall_block_count);
    for (uint32_t i = 0; i < n; i++)
        index->wall_sides[wall->slot_first + i] = keys[order[i].at].side;
    index->wall_block_count += enf_tree_blocks(n);
    index->wall_slot_count += n;
}

/* Whether the side lies in another wall than the one before it, of those sorted: faces another way, or lies further on. */
static int starts_wall(const SideKey *key, double gap) {
    return memcmp(key->direction, key[-1].direction, sizeof key->direction) != 0 || key->offset - key[-1].offset > gap;
}

/* Sorts the sides of one cell into walls. keys, boxes, order: room for them all. */
static void wall_cell(EnfViewIndex *index, EnfViewCell *cell, SideKey *keys, double (*boxes)[6], EnfTreeItem *order) {
    const uint32_t count = cell->side_count;
    for (uint32_t i = 0; i < count; i++) {
        const EnfPortalSide *side = &index->sides[cell->side_first + i];
        double p[3];
        vec_sub(p, index->vertices[side->vertex_first], index->origin);
        /* An eighth of a turn's sine or so: walls of one building have few directions, and curved ones stay few. */
        for (int k = 0; k < 3; k++)
            keys[i].direction[k] = (int)floor(side->n[k] * 4 + 0.5);
        keys[i].offset = vec_dot(side->n, p);
        keys[i].side = cell->side_first + i;
    }
    qsort(keys, count, sizeof *keys, compare_keys);
    /* A gap of this much between planes starts another wall, unless that makes too many of them. */
    double gap = 2e-3 * index->scene->extent;
    uint32_t walls = 1;
    for (uint32_t i = 1; i < count; i++)
        walls += (uint32_t)starts_wall(&keys[i], gap);
    if (walls > 8 + count / 16)
        gap = INFINITY;
    cell->wall_first = index->wall_count;
    for (uint32_t begin = 0, end = 1; begin < count; begin = end++) {
        while (end < count && !starts_wall(&keys[end], gap))
            end++;
        fill_wall(index, &index->walls[index->wall_count++], keys + begin, end - begin, boxes, order);
    }
    cell->wall_count = index->wall_count - cell->wall_first;
}

EnfStatus enf_build_walls(EnfViewIndex *index) {
    const uint32_t cells = index->scene->cell_count;
    uint64_t slots = 0;
    uint32_t most = 0;
    for (uint32_t c = 0; c < cells; c++)
        if (index->cells[c].side_count >= ENF_WALL_SIDES) {
            slots += index->cells[c].side_count;
            most = index->cells[c].side_count > most ? index->cells[c].side_count : most;
        }
    if (slots == 0)
        return ENF_OK;
    /* At worst each side is a wall of its own, with a block of its own. */
    index->walls = ENF_NEW(EnfWall, slots);
    index->wall_blocks = ENF_NEW(EnfBoxes8, slots + slots / 4 + 64);
    index->wall_sides = ENF_NEW(uint32_t, slots);
    SideKey *keys = ENF_NEW(SideKey, most);
    double(*boxes)[6] = enf_alloc_array(most, sizeof *boxes);
    EnfTreeItem *order = ENF_NEW(EnfTreeItem, most);
    int ok = index->walls && index->wall_blocks && index->wall_sides && keys && boxes && order;
    for (uint32_t c = 0; c < cells && ok; c++)
        if (index->cells[c].side_count >= ENF_WALL_SIDES)
            wall_cell(index, &index->cells[c], keys, boxes, order);
    enf_free(keys);
    enf_free(boxes);
    enf_free(order);
    return ok ? ENF_OK : enf_fail_memory();
}

int enf_wall_faces_away(const EnfViewIndex *index, const EnfWall *wall, const double eye[3], double slack) {
    double from[3];
    vec_sub(from, eye, index->origin);
    /* n_side . (p - eye) <= n . (p - eye) + spread |p - eye|, and |p| <= sqrt 3 reach; 1e-12: rounding. */
    double reach = 1.7320508076 * index->reach + vec_length(from);
    return wall->offset - vec_dot(wall->n, from) + (wall->spread + 1e-12) * reach + wall->slack + slack <= 0;
}
