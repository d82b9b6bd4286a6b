/* SPDX-License-Identifier: GPL-3.0-or-later
 * Evens out the grain that few rays a pixel leave: a mean over the 4 x 4 pixels that share one set of directions, and no farther than the
 * surface goes. */
#include "enfilade/preview.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"

#include <math.h>
#include <string.h>

enum { ROWS = 32 };

typedef struct Smooth {
    const float *from, *depth, *normal;
    float *to;
    uint32_t width, height;
} Smooth;

/* One surface: turned alike, and as far as its slope lets it be at that distance in pixels. */
static int goes_on(const Smooth *s, size_t a, size_t b) {
    const float *na = s->normal + 3 * a, *nb = s->normal + 3 * b;
    float da = s->depth[a], db = s->depth[b];
    return na[0] * nb[0] + na[1] * nb[1] + na[2] * nb[2] > 0.9f && fabsf(da - db) < 0.06f * fminf(da, db);
}

static void smooth_rows(void *context, uint64_t band, uint32_t thread) {
    const Smooth *s = context;
    uint32_t y1 = (uint32_t)(band + 1) * ROWS < s->height ? (uint32_t)(band + 1) * ROWS : s->height;
    (void)thread;
    for (uint32_t y = (uint32_t)band * ROWS; y < y1; y++)
        for (uint32_t x = 0; x < s->width; x++) {
            size_t at = (size_t)y * s->width + x;
            /* 5 x 5 with the rim at half weight: as many of each of the sixteen, and symmetrical */
            float sum = 0, weight = 0;
            if (!(s->depth[at] < INFINITY)) {
                s->to[at] = s->from[at];
                continue;
            }
            for (int dy = -2; dy <= 2; dy++)
                for (int dx = -2; dx <= 2; dx++) {
                    int64_t nx = (int64_t)x + dx, ny = (int64_t)y + dy;
                    if (nx < 0 || ny < 0 || nx >= s->width || ny >= s->height)
                        continue;
                    size_t other = (size_t)ny * s->width + (size_t)nx;
                    float w = (dx == 2 || dx == -2 ? 0.5f : 1) * (dy == 2 || dy == -2 ? 0.5f : 1);
                    if (other != at && !goes_on(s, at, other))
                        continue;
                    sum += w * s->from[other];
                    weight += w;
                }
            s->to[at] = sum / weight;
        }
}

EnfStatus enf_preview_smooth(float *open, const float *depth, const float *normal, uint32_t width, uint32_t height, uint32_t threads) {
    if (!open || !depth || !normal || width < 1 || height < 1 || width > 16384 || height > 16384)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_preview_smooth: NULL argument, or a picture of %u x %u", width, height);
    size_t bytes = (size_t)width * height * sizeof(float);
    float *from = enf_alloc(bytes);
    if (!from)
        return enf_fail_memory();
    memcpy(from, open, bytes);
    Smooth s = {from, depth, normal, open, width, height};
    enf_parallel_for((height + ROWS - 1) / ROWS, threads, smooth_rows, &s);
    enf_free(from);
    return ENF_OK;
}
