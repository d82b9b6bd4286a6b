/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernels' source, compiled once an instruction set. Before it stand find_exit() and the lanes (ray_kernel_*.c).
 *
 * Which section a ray leaves by: the first one whose first corner lies right of the ray and whose second doesn't. One sign a corner and a
 * ray, the same in every cell that has the corner (strict on one side): no ray slips between two sections, none comes back through the one
 * it came by. Distances are n . (v - o) / n . d, never through n . o, which loses digits far from the origin. */

#include <math.h>
#include <string.h>

#define SELDOM(condition) __builtin_expect(!!(condition), 0)

/* Memory is slower than a packet's walk: what the next block needs comes while this one goes, a little with every packet. */
static inline __attribute__((always_inline)) void call_ahead(const RayBlock *b, uint32_t first) {
    for (uint32_t k = 0; k < b->aheads; k++)
        __builtin_prefetch((const uint32_t *)b->ahead[k] + first);
}

/* The section by which a ray leaves the cell of *node, looked for in all nodes of that cell; *node: the one that has it. Gives 0 where none
 * has, *node being the last. */
static inline __attribute__((always_inline)) int find_section(const PrismNode *nodes, const PrismNode **node, float ox, float oy, float dx,
                                                              float dy, uint32_t *k) {
    int leaves;
    while (SELDOM(!(leaves = find_exit(*node, ox, oy, dx, dy, k))) && (*node)->next < LINK_END)
        *node = &nodes[(*node)->next];
    return leaves;
}

/* Ray i to its end. `steps` are left for all rays of the block. */
static inline __attribute__((always_inline)) void run_ray(const EnfRaycaster *r, RayBlock *b, uint32_t i, int targets, uint32_t *steps) {
    const PrismNode *const nodes = r->prisms.nodes;
    const PrismSection *const sections = r->prisms.sections;
    const float ox = b->o[0][i], oy = b->o[1][i], oz = b->o[2][i], dx = b->d[0][i], dy = b->d[1][i], dz = b->d[2][i];
    const uint32_t up = dz > 0;
    uint32_t link = b->link[i];
    for (;;) {
        const PrismNode *node = &nodes[link];
        uint32_t k;
        const int leaves = find_section(nodes, &node, ox, oy, dx, dy, &k);
        b->cell[i] = node->cell;
        if (SELDOM(!leaves)) { /* straight up: the planes of the same cell, no distance yet */
            b->link[i] = node->next;
            return;
        }
        const PrismSection *s = &sections[node->section_first + k];
        const float t = (s->nx * (node->x[k] - ox) + s->ny * (node->y[k] - oy)) / (s->nx * dx + s->ny * dy);
        const float z = oz + t * dz, cap_z = node->z[up];
        float distance = t;
        /* by masks: whether it is the cap no predictor can know */
        const uint32_t capped = take_cap((z - cap_z) * dz, (cap_z - oz) / dz, &distance);
        link = (node->cap_link[up] & capped) | (s->link[band_at(s, z)] & ~capped);
        if (SELDOM(link >= LINK_PLANES)) {
            while (link >= LINK_TALL) {
                s = &sections[link & LINK_SECTION];
                link = s->link[band_at(s, z)];
            }
            if (link == (LINK_PLANES | node->cell)) { /* openings of all shapes: likewise */
                b->link[i] = link;
                return;
            }
        }
        b->distance[i] = distance;
        if (!(distance < b->limit[i]))
            link = LINK_NOTHING;
        if ((link & LINK_PLANES) == LINK_END)
            break;
        b->portals[i]++;
        if (targets && b->target[i] == link)
            link = LINK_NOTHING;
        if (SELDOM(link >= LINK_END) || SELDOM(--*steps == 0))
            break;
    }
    b->link[i] = link;
}

static inline __attribute__((always_inline)) void run_rays(const EnfRaycaster *r, RayBlock *b, int targets) {
    for (uint32_t i = 0; i < b->count; i++) {
        uint32_t steps = enf_ray_step_cap(r);
        if (i % 16 == 0)
            call_ahead(b, i);
        while (b->link[i] < LINK_END || SELDOM(b->link[i] >= LINK_PLANES)) {
            if (SELDOM(b->link[i] >= LINK_PLANES))
                enf_ray_block_planes(r, b, i, &steps);
            else
                run_ray(r, b, i, targets, &steps);
            if (SELDOM(steps == 0))
                b->link[i] = LINK_NOTHING;
        }
    }
}

static void run_single(const EnfRaycaster *r, RayBlock *b) {
    if (b->targets)
        run_rays(r, b, 1);
    else
        run_rays(r, b, 0);
}

/* Lanes [from, to) of 16. */
static inline __attribute__((always_inline)) uint32_t lane_range(int32_t from, int32_t to) {
    return (0xFFFFu << (from > 0 ? from : 0)) & (to < 16 ? (1u << to) - 1 : 0xFFFFu);
}

/* 1 / inverse; infinity where a plane passes behind the eye: pixels that rounding left to a face seen edge-on. */
static inline __attribute__((always_inline)) vf16 depths_of(vf16 inverse) {
    const vf16 none = lanes_all16(0.0f);
    return 1.0f / lanes_pick16(lanes_lt16(none, inverse), inverse, none);
}

/* Memory is what a picture by spans waits for, and whole lines go there twice as fast as vectors that lie across two: all but a span's
 * first and last vectors begin where a line does. Dividing hides behind it. */
static void fill(float *depth, uint32_t *index, uint32_t count, float base, float slope, uint32_t value) {
    const vf16 iota = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const vu16 values = lanes_all_index16(value);
    int32_t end = (int32_t)count, at;
    if (index) {
        for (at = -(int32_t)((uintptr_t)index / 4 % 16); at < 0; at += 16)
            lanes_put_index16(index + at, lane_range(-at, end - at), values);
        for (; at + 16 <= end; at += 16)
            memcpy(index + at, &values, sizeof values);
        if (at < end)
            lanes_put_index16(index + at, lane_range(0, end - at), values);
    }
    if (depth) {
        for (at = -(int32_t)((uintptr_t)depth / 4 % 16); at < 0; at += 16)
            lanes_put16(depth + at, lane_range(-at, end - at), depths_of(base + slope * ((float)at + iota)));
        for (; at + 16 <= end; at += 16) {
            vf16 v = depths_of(base + slope * ((float)at + iota));
            memcpy(depth + at, &v, sizeof v);
        }
        if (at < end)
            lanes_put16(depth + at, lane_range(0, end - at), depths_of(base + slope * ((float)at + iota)));
    }
}

#if WIDE_DOUBLES > 1
typedef double vd __attribute__((vector_size(8 * WIDE_DOUBLES)));
typedef int64_t vl __attribute__((vector_size(8 * WIDE_DOUBLES)));
typedef int32_t vi __attribute__((vector_size(4 * WIDE_DOUBLES)));

/* enf_first_pixel of a register full. */
static inline __attribute__((always_inline)) vi first_pixels(vd x) {
    const vd zero = {0}, least = zero - 1e9, most = zero + 1e9, one = zero + 1;
    vd c = x - 0.5;
    vl inside = c > least;
    c = (vd)(((vl)c & inside) | ((vl)least & ~inside));
    inside = c < most;
    c = (vd)(((vl)c & inside) | ((vl)most & ~inside));
    vd whole = __builtin_convertvector(__builtin_convertvector(c, vi), vd);
    return __builtin_convertvector(whole + (vd)((vl)one & (whole < c)), vi);
}
#endif

static void edge(int32_t *restrict lo, int32_t *restrict hi, int32_t from, uint32_t count, const double start[2], double slope) {
    const double x = start[0], y = start[1];
    uint32_t i = 0;
#if WIDE_DOUBLES > 1
    vd rows;
    for (uint32_t k = 0; k < WIDE_DOUBLES; k++)
        rows[k] = k;
    for (; count >= WIDE_DOUBLES && i < count; i += WIDE_DOUBLES) {
        i = i + WIDE_DOUBLES <= count ? i : count - WIDE_DOUBLES; /* the last ones again: stretching twice changes nothing */
        vi pixel = first_pixels(x + ((double)(from + (int32_t)i) + 0.5 + rows - y) * slope), l, h, m;
        memcpy(&l, lo + i, sizeof l);
        memcpy(&h, hi + i, sizeof h);
        m = pixel < l;
        l = (pixel & m) | (l & ~m);
        m = pixel > h;
        h = (pixel & m) | (h & ~m);
        memcpy(lo + i, &l, sizeof l);
        memcpy(hi + i, &h, sizeof h);
    }
#endif
    for (; i < count; i++) {
        int32_t pixel = enf_first_pixel(x + ((double)(from + (int32_t)i) + 0.5 - y) * slope);
        lo[i] = pixel < lo[i] ? pixel : lo[i];
        hi[i] = pixel > hi[i] ? pixel : hi[i];
    }
}

static uint32_t clip(int32_t *restrict lo, int32_t *restrict hi, const int32_t *restrict outer_lo, const int32_t *restrict outer_hi,
                     uint32_t count) {
    uint32_t filled = 0;
    for (uint32_t i = 0; i < count; i++) {
        lo[i] = lo[i] > outer_lo[i] ? lo[i] : outer_lo[i];
        hi[i] = hi[i] < outer_hi[i] ? hi[i] : outer_hi[i];
        filled += lo[i] < hi[i];
    }
    return filled;
}

static void fill_three(float *restrict out, uint32_t count, const float value[3]) {
    float pattern[48]; /* sixteen pixels */
    uint32_t i = 0;
    for (uint32_t k = 0; k < 48; k++)
        pattern[k] = value[k % 3];
    for (; i + 16 <= count; i += 16)
        memcpy(out + 3 * i, pattern, sizeof pattern);
    for (uint32_t k = 3 * i; k < 3 * count; k++)
        out[k] = pattern[k - 3 * i];
}

static void fill_places(float *restrict uv, uint32_t count, const float inverse[2], const float line[6]) {
    const vf16 iota = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    for (uint32_t i = 0; i < count; i += 16) {
        vf16 step = (float)(int32_t)i + iota, depth = 1.0f / (inverse[0] + inverse[1] * step);
        vf16 u = line[0] + depth * (line[1] + line[2] * step), v = line[3] + depth * (line[4] + line[5] * step);
        int32_t left = 2 * (int32_t)(count - i);
        lanes_put16(uv + 2 * (size_t)i, lane_range(0, left),
                    __builtin_shufflevector(u, v, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23));
        if (left > 16)
            lanes_put16(uv + 2 * (size_t)i + 16, lane_range(0, left - 16),
                        __builtin_shufflevector(u, v, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31));
    }
}

static void copy(void *to, const void *from, uint32_t words) {
    uint32_t *out = to;
    const uint32_t *in = from;
    vu16 v;
    uint32_t i = 0;
    for (; i + 16 <= words; i += 16) {
        memcpy(&v, in + i, sizeof v);
        memcpy(out + i, &v, sizeof v);
    }
    for (; i < words; i++)
        out[i] = in[i];
}

static void finish(RayBlock *b) {
    const uint32_t count = b->count;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t to = b->link[i], nothing = to >= LINK_OUT, out = nothing & (to != LINK_NOTHING);
        float t = b->distance[i] < 0 ? 0 : b->distance[i];
        b->distance[i] = nothing ? INFINITY : t;
        b->cell[i] = out ? to & LINK_SURFACE : b->cell[i];
        b->portals[i] += out;
        b->link[i] = nothing ? ENF_NONE : to & LINK_SURFACE;
    }
}

static void start(const EnfRaycaster *r, RayBlock *b) {
    const uint32_t *node_of_cell = r->prisms.node_of_cell;
    const uint32_t cells = r->cell_count, count = b->count;
    for (uint32_t i = 0; i < count; i++) {
        float finite = 0; /* 0 times anything finite is 0, times infinity NaN */
        for (int k = 0; k < 3; k++)
            finite += 0 * b->o[k][i] + 0 * b->d[k][i];
        int good = (finite == 0) & ((b->d[0][i] != 0) | (b->d[1][i] != 0) | (b->d[2][i] != 0)) & (b->cell[i] < cells);
        b->link[i] = good ? 0 : LINK_NOTHING;
        b->cell[i] = good ? b->cell[i] : ENF_NONE;
        b->distance[i] = 0;
        b->portals[i] = 0;
    }
    for (uint32_t i = 0; i < count && cells > 0; i++) {
        uint32_t node = node_of_cell[b->link[i] ? 0 : b->cell[i]];
        b->link[i] = b->link[i] ? LINK_NOTHING : node;
    }
}

#define LANES       8
#define PACKET_NAME run_packets8
#define PACKET_EYE  0
#include "raycast/ray_packet_body.h"
#undef LANES
#undef PACKET_NAME
#define LANES       16
#define PACKET_NAME run_packets16
#include "raycast/ray_packet_body.h"
#undef PACKET_NAME
#undef PACKET_EYE
#define PACKET_NAME run_eye_packets
#define PACKET_EYE  1
#include "raycast/ray_packet_body.h"
#undef LANES
#undef PACKET_NAME
#undef PACKET_EYE

/* Without fast gathers one ray after another is as good. */
#ifndef RUN_WAVE
#define RUN_WAVE run_single
#endif

#define RAY_KERNEL_TABLE                                                                                                                   \
    { run_single, RUN_WAVE, run_packets8, run_packets16, run_eye_packets, fill, edge, clip, fill_three, fill_places, copy, finish, start }
