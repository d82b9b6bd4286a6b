/* SPDX-License-Identifier: GPL-3.0-or-later
 * Boxes in blocks of eight, flat arrays for SIMD, and an implicit tree of eight children over many of them.
 *
 * A tree is a range of blocks: level 0 holds the items, eight a block, in an order that keeps neighbours together;
 * box k of level L + 1 bounds block k of level L. Levels lie one after the other; there are none above ENF_TREE_TOP blocks. */
#ifndef ENF_FROM_POINT_BLOCK_TREE_H
#define ENF_FROM_POINT_BLOCK_TREE_H

#include <stdint.h>

/* Centres and half extents relative to the index's origin, rounded outward. Unused lanes have hx = -1e30. */
typedef struct EnfBoxes8 {
    float cx[8], cy[8], cz[8], hx[8], hy[8], hz[8];
} EnfBoxes8;

#define ENF_TREE_TOP    4
#define ENF_TREE_LEVELS 12
typedef struct EnfBlockTree {
    uint32_t first_block; /* of level 0 */
    uint32_t item_count;
} EnfBlockTree;

/* Which lane is the first in a mask; not 0. */
static inline uint32_t enf_lowest_bit(uint32_t mask) {
#if defined(__GNUC__)
    return (uint32_t)__builtin_ctz(mask);
#else
    uint32_t bit = 0;
    while (!(mask >> bit & 1))
        bit++;
    return bit;
#endif
}

/* Half-spaces n . p + d >= 0 that a box must touch, all of one set at once. Made so that rounding errs towards touching. */
#define ENF_PLANES_MAX 16
typedef struct EnfPlanes {
    uint32_t count;
    uint32_t loose; /* some half-space isn't among them: no box is surely in all */
    float n[ENF_PLANES_MAX][3];
    float a[ENF_PLANES_MAX][3]; /* |n| */
    float d[ENF_PLANES_MAX];
    float sure[ENF_PLANES_MAX]; /* from here on n . centre + d means that the centre is inside, whatever was rounded */
} EnfPlanes;

/* size: |n| times the largest coordinate of any box, and |d|. */
static inline void enf_planes_put(EnfPlanes *planes, const double n[3], double d, double size) {
    if (planes->count == ENF_PLANES_MAX) {
        planes->loose = 1; /* one constraint fewer: more boxes pass (safe direction) */
        return;
    }
    uint32_t k = planes->count++;
    for (int c = 0; c < 3; c++) {
        planes->n[k][c] = (float)n[c];
        planes->a[k][c] = planes->n[k][c] < 0 ? -planes->n[k][c] : planes->n[k][c];
    }
    /* Single precision sums of six terms, each below |n| reach or |d|: error below 8 roundings of 6e-8 each. */
    planes->d[k] = (float)(d + 1e-6 * size);
    planes->sure[k] = (float)(2e-6 * size);
}
/* Adds a half-space given relative to the index's origin. reach: no box has a coordinate beyond it. [Units: metres] */
void enf_planes_add(EnfPlanes *planes, const double n[3], double d, double reach);

/* Bit i of masks[k]: box i of block k is not fully outside of any half-space. Bit 8 + i: besides, its centre surely lies in all
 * of them. Both twins give equal bits. */
void enf_boxes_test_scalar(const EnfBoxes8 *blocks, uint32_t count, const EnfPlanes *planes, uint16_t *masks);
typedef void (*EnfBoxesTest)(const EnfBoxes8 *blocks, uint32_t count, const EnfPlanes *planes, uint16_t *masks);
/* The fastest twin this processor runs; use_simd = 0: the scalar one. */
EnfBoxesTest enf_boxes_test(int use_simd);

/* Whether a box lies within all half-spaces, so that comparing what is in it is needless. */
static inline int enf_box_within(const EnfPlanes *planes, const float centre[3], const float half[3]) {
    for (uint32_t k = 0; k < planes->count; k++) {
        const float *n = planes->n[k], *a = planes->a[k];
        if (n[0] * centre[0] + n[1] * centre[1] + n[2] * centre[2] + planes->d[k] <
            a[0] * half[0] + a[1] * half[1] + a[2] * half[2] + planes->sure[k])
            return 0;
    }
    return !planes->loose;
}

/* Blocks that `item_count` items need, all levels together. */
uint32_t enf_tree_blocks(uint32_t item_count);
typedef struct EnfTreeItem {
    double centre[3]; /* twice */
    uint32_t at;      /* its number before */
} EnfTreeItem;
/* Orders the items spatially (items[item_count]: any content on entry) and fills the blocks. boxes: min xyz, max xyz of each item
 * relative to the origin. */
void enf_tree_build(const double (*boxes)[6], uint32_t item_count, EnfTreeItem *items, EnfBoxes8 *blocks);

/* Gives how many blocks were compared. Calls back with each level-0 block (its index from the tree's first) and a mask of lanes that pass, as above;
 * stops when that gives 0. */
typedef int (*EnfTreeLeaf)(void *user, uint32_t block, uint32_t mask);
uint32_t enf_tree_query(const EnfBoxes8 *blocks, const EnfBlockTree *tree, const EnfPlanes *planes, EnfBoxesTest test, EnfTreeLeaf leaf,
                        void *user);

#endif
