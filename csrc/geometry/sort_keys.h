/* SPDX-License-Identifier: GPL-3.0-or-later
 * Keys for qsort that several algorithms share; ties go by index, so that an order never depends on the input's. */
#ifndef ENF_GEOMETRY_SORT_KEYS_H
#define ENF_GEOMETRY_SORT_KEYS_H

#include <stdint.h>

/* Something at a coordinate: sweeps along an axis. */
typedef struct Ordered {
    double x;
    uint32_t index;
} Ordered;

static inline int compare_ordered(const void *left, const void *right) {
    const Ordered *a = left, *b = right;
    if (a->x != b->x)
        return a->x < b->x ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* A directed edge between two corners. */
typedef struct Pair {
    uint32_t from, to;
} Pair;

static inline int compare_pairs(const void *left, const void *right) {
    const Pair *a = left, *b = right;
    if (a->from != b->from)
        return a->from < b->from ? -1 : 1;
    return a->to < b->to ? -1 : a->to > b->to;
}

static inline int compare_indices(const void *left, const void *right) {
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return a < b ? -1 : a > b;
}

#endif
