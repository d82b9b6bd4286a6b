/* SPDX-License-Identifier: GPL-3.0-or-later
 * Upright lines by number: corners of outlines that are one within a tolerance get one number and one position. Internal to the core. */
#ifndef ENF_RAYCAST_CORNER_WELD_H
#define ENF_RAYCAST_CORNER_WELD_H

#include <stdint.h>

typedef struct CornerWeld {
    double tolerance;    /* metres */
    double (*points)[2]; /* [count] the first corner that came, for all that are one with it */
    uint32_t count;
    uint32_t *next;    /* [count] the next corner in the same bucket */
    uint32_t *buckets; /* [bucket_count], a power of two */
    uint32_t bucket_count;
} CornerWeld;

/* expected: corners to come, for the table's size. 0: out of memory. */
int enf_corner_weld_init(CornerWeld *weld, double tolerance, uint64_t expected);
/* The corner's number; ENF_NONE: out of memory. */
uint32_t enf_corner_weld_add(CornerWeld *weld, double x, double y);
void enf_corner_weld_free(CornerWeld *weld);

#endif
