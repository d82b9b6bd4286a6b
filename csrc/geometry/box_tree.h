/* SPDX-License-Identifier: GPL-3.0-or-later
 * A binary hierarchy over boxes: what touches this point or box, in time logarithmic in the number of boxes.
 */
#ifndef ENF_GEOMETRY_BOX_TREE_H
#define ENF_GEOMETRY_BOX_TREE_H

#include <stdint.h>

typedef struct EnfBoxNode {
    double box[6];
    uint32_t first; /* leaf: first of `count` items; inner: index of the right child, the left one follows the
                       node */
    uint32_t count; /* 0: inner */
} EnfBoxNode;

typedef struct EnfBoxTree {
    EnfBoxNode *nodes;
    uint32_t *items;
    uint32_t node_count, item_count;
} EnfBoxTree;

/* Halves by median of centres along the longest side: depth is log2(count) whatever the boxes are. Empty
 * boxes are left out. `boxes` is only read here; queries report items by their index in it. Gives 0 when
 * memory runs out. */
int enf_box_tree_build(EnfBoxTree *tree, const double (*boxes)[6], uint32_t count);
void enf_box_tree_free(EnfBoxTree *tree);

/* Walk: begin, then next until it gives ENF_NONE: items of leaves whose box touches the query (the item's own
 * box may not). No allocation; the median build bounds the depth. */
typedef struct EnfBoxWalk {
    const EnfBoxTree *tree;
    double query[6];
    uint32_t stack[64];
    uint32_t depth, at, end;
} EnfBoxWalk;
void enf_box_walk_begin(EnfBoxWalk *walk, const EnfBoxTree *tree, const double query[6]);
uint32_t enf_box_walk_next(EnfBoxWalk *walk);

#endif
