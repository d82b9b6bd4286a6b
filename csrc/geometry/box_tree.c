/* SPDX-License-Identifier: GPL-3.0-or-later
 * A binary hierarchy over boxes. */
#include "geometry/box_tree.h"
#include "base/memory.h"
#include "geometry/vec3.h"

enum { LEAF = 4 };

/* Halves first: the sum of two huge coordinates would overflow. */
static double centre(const double box[6], int axis) {
    return 0.5 * box[axis] + 0.5 * box[3 + axis];
}

/* Ties by index: the tree doesn't depend on the selection's path. */
static int before(const double (*boxes)[6], int axis, uint32_t a, uint32_t b) {
    double x = centre(boxes[a], axis), y = centre(boxes[b], axis);
    return x < y || (x == y && a < b);
}

/* Hoare's selection with a median of three: items[k] gets its sorted place. */
static void select_nth(const double (*boxes)[6], int axis, uint32_t *items, uint32_t count, uint32_t k) {
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t a = items[low], b = items[low + (high - low) / 2], c = items[high], pivot;
        if (before(boxes, axis, a, b))
            pivot = before(boxes, axis, b, c) ? b : before(boxes, axis, a, c) ? c : a;
        else
            pivot = before(boxes, axis, a, c) ? a : before(boxes, axis, b, c) ? c : b;
        uint32_t i = low, j = high;
        for (;;) {
            while (before(boxes, axis, items[i], pivot))
                i++;
            while (before(boxes, axis, pivot, items[j]))
                j--;
            if (i >= j)
                break;
            uint32_t t = items[i];
            items[i++] = items[j];
            items[j--] = t;
        }
        if (k <= j)
            high = j;
        else
            low = j + 1;
    }
}

int enf_box_tree_build(EnfBoxTree *tree, const double (*boxes)[6], uint32_t count) {
    memset(tree, 0, sizeof *tree);
    tree->items = ENF_NEW(uint32_t, count);
    if (!tree->items)
        return 0;
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i++)
        if (!box_is_empty(boxes[i]))
            tree->items[n++] = i;
    tree->item_count = n;
    if (n == 0)
        return 1;
    tree->nodes = ENF_NEW(EnfBoxNode, 2 * (uint64_t)n);
    if (!tree->nodes)
        return 0;
    struct {
        uint32_t first, count, parent;
    } stack[64];
    uint32_t depth = 0;
    stack[depth].first = 0;
    stack[depth].count = n;
    stack[depth++].parent = ENF_NONE; /* whose right child this is */
    while (depth) {
        depth--;
        uint32_t first = stack[depth].first, m = stack[depth].count, parent = stack[depth].parent;
        uint32_t index = tree->node_count++;
        if (parent != ENF_NONE)
            tree->nodes[parent].first = index;
        EnfBoxNode *node = &tree->nodes[index];
        double centres[6];
        box_empty(node->box);
        box_empty(centres);
        for (uint32_t i = first; i < first + m; i++) {
            const double *box = boxes[tree->items[i]];
            double c[3] = {centre(box, 0), centre(box, 1), centre(box, 2)};
            box_add_box(node->box, box);
            box_add_point(centres, c);
        }
        if (m <= LEAF) {
            node->first = first;
            node->count = m;
            continue;
        }
        int axis = 0;
        for (int k = 1; k < 3; k++)
            if (centres[3 + k] - centres[k] > centres[3 + axis] - centres[axis])
                axis = k;
        uint32_t half = m / 2;
        select_nth(boxes, axis, tree->items + first, m, half);
        /* The right half waits; the left one is taken next and so follows its parent. */
        stack[depth].first = first + half;
        stack[depth].count = m - half;
        stack[depth++].parent = index;
        stack[depth].first = first;
        stack[depth].count = half;
        stack[depth++].parent = ENF_NONE;
    }
    return 1;
}

void enf_box_tree_free(EnfBoxTree *tree) {
    enf_free(tree->nodes);
    enf_free(tree->items);
    memset(tree, 0, sizeof *tree);
}

void enf_box_walk_begin(EnfBoxWalk *walk, const EnfBoxTree *tree, const double query[6]) {
    walk->tree = tree;
    memcpy(walk->query, query, sizeof walk->query);
    walk->at = walk->end = 0;
    walk->depth = 0;
    if (tree->node_count)
        walk->stack[walk->depth++] = 0;
}

uint32_t enf_box_walk_next(EnfBoxWalk *walk) {
    while (walk->at == walk->end) {
        if (walk->depth == 0)
            return ENF_NONE;
        uint32_t index = walk->stack[--walk->depth];
        const EnfBoxNode *node = &walk->tree->nodes[index];
        if (!box_touches_box(node->box, walk->query))
            continue;
        if (node->count) {
            walk->at = node->first;
            walk->end = node->first + node->count;
        } else {
            walk->stack[walk->depth++] = node->first;
            walk->stack[walk->depth++] = index + 1;
        }
    }
    return walk->tree->items[walk->at++];
}
