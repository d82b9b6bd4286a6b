/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cuts the cells of a bake into blocks of neighbours: cuts near the median, across the axis where they part the fewest portals: what
 * leads from block to block is what they can't share. The cells are sorted along each axis once; cuts keep the orders. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "from_region/bake.h"
#include "geometry/sort_keys.h"

typedef struct Cutting {
    const EnfRegionModel *model;
    EnfBakeBlocks *out;
    Ordered *keys[3], *spare; /* [asked cells] by their boxes' middles along each axis; each part of it holds the same cells in all three */
    uint8_t *side;            /* [cells] 0: not among those being cut, else 1, 2 */
    uint32_t largest;
} Cutting;

static void finish_block(Cutting *c, uint32_t first, uint32_t count) {
    EnfBakeBlocks *out = c->out;
    for (uint32_t i = first; i < first + count; ++i)
        out->cells[i] = c->keys[0][i].index;
    qsort(out->cells + first, count, sizeof *out->cells, compare_indices);
    for (uint32_t i = first; i < first + count; ++i)
        out->of[out->cells[i]] = out->count;
    out->first[++out->count] = first + count;
}

/* Where to cut `count` sorted keys: at the step between two coordinates nearest to the middle, within a quarter of it. */
static uint32_t place_of_cut(const Ordered *keys, uint32_t count) {
    uint32_t middle = count / 2;
    for (uint32_t off = 0; off <= count / 4; ++off)
        for (int sign = -1; sign <= 1; sign += 2) {
            uint32_t at = sign < 0 ? middle - off : middle + off;
            if (at > 0 && at < count && keys[at].x > keys[at - 1].x)
                return at;
        }
    return middle;
}

static void mark_sides(Cutting *c, const Ordered *keys, uint32_t count, uint32_t at) {
    for (uint32_t i = 0; i < count; ++i)
        c->side[keys[i].index] = i < at ? 1 : 2;
}

/* Portals from the first `at` cells to the others. */
static uint64_t portals_cut(Cutting *c, const Ordered *keys, uint32_t count, uint32_t at) {
    const EnfRegionModel *m = c->model;
    uint64_t cut = 0;
    mark_sides(c, keys, count, at);
    for (uint32_t i = 0; i < at; ++i)
        for (uint32_t d = m->out_first[keys[i].index]; d < m->out_first[keys[i].index + 1]; ++d)
            cut += c->side[m->to[m->out[d]]] == 2;
    for (uint32_t i = 0; i < count; ++i)
        c->side[keys[i].index] = 0;
    return cut;
}

/* Parts until small enough; each part has at least a quarter. */
static void cut(Cutting *c, uint32_t first, uint32_t count) {
    if (count <= c->largest) {
        finish_block(c, first, count);
        return;
    }
    uint32_t best_at = count / 2, best_axis = 0;
    uint64_t fewest = UINT64_MAX;
    double widest = -1;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const Ordered *keys = c->keys[axis] + first;
        uint32_t at = place_of_cut(keys, count);
        uint64_t portals = portals_cut(c, keys, count, at);
        double extent = keys[count - 1].x - keys[0].x;
        if (portals > fewest || (portals == fewest && extent <= widest))
            continue;
        fewest = portals, widest = extent, best_at = at, best_axis = axis;
    }
    mark_sides(c, c->keys[best_axis] + first, count, best_at);
    for (uint32_t axis = 0; axis < 3; ++axis) {
        Ordered *keys = c->keys[axis] + first;
        uint32_t low = 0, high = best_at;
        for (uint32_t i = 0; i < count; ++i)
            c->spare[c->side[keys[i].index] == 1 ? low++ : high++] = keys[i];
        memcpy(keys, c->spare, count * sizeof *keys);
    }
    for (uint32_t i = 0; i < count; ++i)
        c->side[c->keys[0][first + i].index] = 0;
    cut(c, first, best_at);
    cut(c, first + best_at, count - best_at);
}

EnfStatus enf_bake_blocks(const EnfRegionModel *m, const uint8_t *asked, uint32_t largest, EnfBakeBlocks *out) {
    uint32_t n = m->cell_count, count = 0;
    memset(out, 0, sizeof *out);
    out->first = ENF_NEW(uint32_t, (uint64_t)n + 2);
    out->cells = ENF_NEW(uint32_t, (uint64_t)n + 1);
    out->of = ENF_NEW(uint32_t, (uint64_t)n + 1);
    Cutting c = {.model = m, .out = out, .largest = largest, .spare = ENF_NEW(Ordered, (uint64_t)n + 1)};
    c.side = ENF_NEW(uint8_t, (uint64_t)n + 1);
    int ok = out->first && out->cells && out->of && c.spare && c.side;
    for (int axis = 0; axis < 3; ++axis)
        ok &= (c.keys[axis] = ENF_NEW(Ordered, (uint64_t)n + 1)) != NULL;
    for (uint32_t i = 0; i < n && ok; ++i) {
        out->of[i] = ENF_NONE;
        if (asked && !asked[enf_rm_scene_cell(m, i)])
            continue;
        for (int axis = 0; axis < 3; ++axis)
            c.keys[axis][count] = (Ordered){m->cell_box[i][axis], i};
        ++count;
    }
    for (int axis = 0; axis < 3 && ok && count > largest; ++axis)
        qsort(c.keys[axis], count, sizeof *c.keys[axis], compare_ordered);
    if (ok)
        cut(&c, 0, count);
    enf_free(c.keys[0]), enf_free(c.keys[1]), enf_free(c.keys[2]), enf_free(c.spare), enf_free(c.side);
    if (ok)
        return ENF_OK;
    enf_bake_blocks_free(out);
    return enf_fail_memory();
}

void enf_bake_blocks_free(EnfBakeBlocks *blocks) {
    enf_free(blocks->first), enf_free(blocks->cells), enf_free(blocks->of);
    memset(blocks, 0, sizeof *blocks);
}

uint32_t enf_bake_owner(const EnfRegionModel *m, uint32_t i, uint32_t j) {
    uint32_t portals_i = m->out_first[i + 1] - m->out_first[i], portals_j = m->out_first[j + 1] - m->out_first[j];
    if (portals_i != portals_j)
        return portals_i < portals_j ? i : j;
    return ((i + j) & 1) == (i < j) ? i : j; /* halves the work between equals, whichever is named first */
}
