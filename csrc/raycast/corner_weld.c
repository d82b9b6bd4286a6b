/* SPDX-License-Identifier: GPL-3.0-or-later
 * Welds corners through a hash of squares: a corner is looked for in the squares its tolerance reaches. */
#include "raycast/corner_weld.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

int enf_corner_weld_init(CornerWeld *w, double tolerance, uint64_t expected) {
    memset(w, 0, sizeof *w);
    w->tolerance = tolerance;
    for (w->bucket_count = 64; w->bucket_count < expected && w->bucket_count < 1u << 30;)
        w->bucket_count *= 2;
    w->buckets = enf_alloc(sizeof *w->buckets * (size_t)w->bucket_count);
    if (w->buckets)
        memset(w->buckets, 0xFF, sizeof *w->buckets * (size_t)w->bucket_count);
    return w->buckets != NULL;
}

void enf_corner_weld_free(CornerWeld *w) {
    enf_free(w->points);
    enf_free(w->next);
    enf_free(w->buckets);
}

/* Squares eight tolerances wide: most corners reach into one only. */
static int64_t square(const CornerWeld *w, double x) {
    return (int64_t)floor(x / (8 * w->tolerance));
}

static uint32_t bucket_of(const CornerWeld *w, int64_t i, int64_t j) {
    uint64_t h = (uint64_t)i * 0x9E3779B97F4A7C15ull ^ (uint64_t)j * 0xC2B2AE3D27D4EB4Full;
    return (uint32_t)((h ^ (h >> 29) ^ (h >> 47)) & (w->bucket_count - 1));
}

uint32_t enf_corner_weld_add(CornerWeld *w, double x, double y) {
    int64_t i0 = square(w, x - w->tolerance), i1 = square(w, x + w->tolerance);
    int64_t j0 = square(w, y - w->tolerance), j1 = square(w, y + w->tolerance);
    for (int64_t i = i0; i <= i1; i++)
        for (int64_t j = j0; j <= j1; j++)
            for (uint32_t k = w->buckets[bucket_of(w, i, j)]; k != UINT32_MAX; k = w->next[k])
                if (fabs(w->points[k][0] - x) <= w->tolerance && fabs(w->points[k][1] - y) <= w->tolerance)
                    return k;
    if (!ENF_RESERVE(w->points, (uint64_t)w->count + 1) || !ENF_RESERVE(w->next, (uint64_t)w->count + 1))
        return UINT32_MAX;
    uint32_t *bucket = &w->buckets[bucket_of(w, square(w, x), square(w, y))];
    w->points[w->count][0] = x;
    w->points[w->count][1] = y;
    w->next[w->count] = *bucket;
    return *bucket = w->count++;
}
