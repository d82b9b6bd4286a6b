/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cuts the cells of a bake into blocks of neighbours: median cuts across the widest extent of their centres. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "from_region/bake.h"
#include "geometry/sort_keys.h"

typedef struct Cutting {
    const EnfRegionModel *model;
    EnfBakeBlocks *out;
    Ordered *keys; /* [asked cells] */
    uint32_t largest;
} Cutting;

static void finish_block(Cutting *c, uint32_t first, uint32_t count) {
    EnfBakeBlocks *out = c->out;
    qsort(out->cells + first, count, sizeof *out->cells, compare_indices);
    for (uint32_t i = first; i < first + count; ++i) out->of[out->cells[i]] = out->count;
    out->first[++out->count] = first + count;
}

/* Halves until small enough: at most 32 levels deep. */
static void cut(Cutting *c, uint32_t first, uint32_t count) {
    if (count <= c->largest) {
        finish_block(c, first, count);
        return;
    }
    uint32_t *cells = c->out->cells + first;
    int widest = 0;
    float extent = -1;
    for (int k = 0; k < 3; ++k) {
        float low = c->model->cell_box[cells[0]][k], high = low;
        for (uint32_t i = 1; i < count; ++i) {
            float x = c->model->cell_box[cells[i]][k];
            if (x < low) low = x;
            if (x > high) high = x;
        }
        if (high - low > extent) extent = high - low, widest = k;
    }
    for (uint32_t i = 0; i < count; ++i) c->keys[i] = (Ordered){c->model->cell_box[cells[i]][widest], cells[i]};
    qsort(c->keys, count, sizeof *c->keys, compare_ordered);
    for (uint32_t i = 0; i < count; ++i) cells[i] = c->keys[i].index;
    cut(c, first, count / 2);
    cut(c, first + count / 2, count - count / 2);
}

EnfStatus enf_bake_blocks(const EnfRegionModel *m, const uint8_t *asked, uint32_t largest, EnfBakeBlocks *out) {
    uint32_t n = m->cell_count, count = 0;
    memset(out, 0, sizeof *out);
    out->first = ENF_NEW(uint32_t, (uint64_t)n + 2);
    out->cells = ENF_NEW(uint32_t, (uint64_t)n + 1);
    out->of = ENF_NEW(uint32_t, (uint64_t)n + 1);
    Cutting c = {.model = m, .out = out, .largest = largest, .keys = ENF_NEW(Ordered, (uint64_t)n + 1)};
    if (!out->first || !out->cells || !out->of || !c.keys) {
        enf_free(c.keys);
        enf_bake_blocks_free(out);
        return enf_fail_memory();
    }
    for (uint32_t i = 0; i < n; ++i) {
        out->of[i] = ENF_NONE;
        if (!asked || asked[i]) out->cells[count++] = i;
    }
    cut(&c, 0, count);
    enf_free(c.keys);
    return ENF_OK;
}

void enf_bake_blocks_free(EnfBakeBlocks *blocks) {
    enf_free(blocks->first), enf_free(blocks->cells), enf_free(blocks->of);
    memset(blocks, 0, sizeof *blocks);
}

uint32_t enf_bake_owner(const EnfRegionModel *m, uint32_t i, uint32_t j) {
    uint32_t portals_i = m->out_first[i + 1] - m->out_first[i], portals_j = m->out_first[j + 1] - m->out_first[j];
    if (portals_i != portals_j) return portals_i < portals_j ? i : j;
    return ((i + j) & 1) == (i < j) ? i : j; /* halves the work between equals, whichever is named first */
}
