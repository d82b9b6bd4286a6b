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
static void fill_wall(EnfViewIndex *index, EnfWall *wall, const SideKey *keys, uint32_t n, double (*boxes)[6], uint32_t *order) {
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
        index->wall_sides[wall->slot_first + i] = keys[order[i]].side;
    index->wall_block_count += enf_tree_blocks(n);
    index->wall_slot_count += n;
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
    uint32_t *order = ENF_NEW(uint32_t, most);
    if (!index->walls || !index->wall_blocks || !index->wall_sides || !keys || !boxes || !order) {
        enf_free(keys);
        enf_free(boxes);
        enf_free(order);
        return enf_fail_memory();
    }
    for (uint32_t c = 0; c < cells; c++) {
        EnfViewCell *cell = &index->cells[c];
        if (cell->side_count < ENF_WALL_SIDES)
            continue;
        for (uint32_t i = 0; i < cell->side_count; i++) {
            const EnfPortalSide *side = &index->sides[cell->side_first + i];
            double p[3];
            vec_sub(p, index->vertices[side->vertex_first], index->origin);
            /* An eighth of a turn's sine or so: walls of one building have few directions, and curved ones stay few. */
            for (int k = 0; k < 3; k++)
                keys[i].direction[k] = (int)floor(side->n[k] * 4 + 0.5);
            keys[i].offset = vec_dot(side->n, p);
            keys[i].side = cell->side_first + i;
        }
        qsort(keys, cell->side_count, sizeof *keys, compare_keys);
        cell->wall_first = index->wall_count;
        /* A gap of this much between planes starts another wall, unless that makes too many of them. */
        double gap = 2e-3 * index->scene->extent;
        for (uint32_t pass = 0; pass < 2; pass++) {
            uint32_t walls = 0;
            for (uint32_t i = 0; i < cell->side_count; i++)
                walls += i == 0 || memcmp(keys[i].direction, keys[i - 1].direction, sizeof keys[i].direction) != 0 ||
                         keys[i].offset - keys[i - 1].offset > gap;
            if (walls <= 8 + cell->side_count / 16)
                break;
            gap = INFINITY;
        }
        for (uint32_t i = 0, begin = 0; i < cell->side_count; i++)
            if (i + 1 == cell->side_count || memcmp(keys[i].direction, keys[i + 1].direction, sizeof keys[i].direction) != 0 ||
                keys[i + 1].offset - keys[i].offset > gap) {
                fill_wall(index, &index->walls[index->wall_count++], keys + begin, i + 1 - begin, boxes, order);
                begin = i + 1;
            }
        cell->wall_count = index->wall_count - cell->wall_first;
    }
    enf_free(keys);
    enf_free(boxes);
    enf_free(order);
    return ENF_OK;
}

int enf_wall_faces_away(const EnfViewIndex *index, const EnfWall *wall, const double eye[3], double slack) {
    double from[3];
    vec_sub(from, eye, index->origin);
    /* n_side . (p - eye) <= n . (p - eye) + spread |p - eye|, and |p| <= sqrt 3 reach; 1e-12: rounding. */
    double reach = 1.7320508076 * index->reach + vec_length(from);
    return wall->offset - vec_dot(wall->n, from) + (wall->spread + 1e-12) * reach + wall->slack + slack <= 0;
}
