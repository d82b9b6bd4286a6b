/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernels' source, compiled once an instruction set. Before it stand first_exit() and the lanes (ray_kernel_*.c).
 *
 * Which section a ray leaves by: the first one whose first corner lies right of the ray and whose second doesn't. One sign a corner and a
 * ray, the same in every cell that has the corner (strict on one side): no ray slips between two sections, none comes back through the one
 * it came by. Distances are n . (v - o) / n . d, never through n . o, which loses digits far from the origin. */

#include <math.h>
#include <string.h>

#define SELDOM(condition) __builtin_expect(!!(condition), 0)

/* Each bit of `yes` where the mask has one. */
static inline __attribute__((always_inline)) float pick_float(uint32_t mask, float yes, float no) {
    uint32_t a, b;
    memcpy(&a, &yes, sizeof a);
    memcpy(&b, &no, sizeof b);
    a = (a & mask) | (b & ~mask);
    memcpy(&yes, &a, sizeof yes);
    return yes;
}

/* Where a ray is on its way. */
typedef struct RayState {
    float distance;
    uint32_t link, cell, portals;
} RayState;

static inline __attribute__((always_inline)) RayState step_ray(const PrismModel *m, RayState ray, float ox, float oy, float oz, float dx,
                                                               float dy, float dz, float limit) {
    const PrismNode *node = &m->nodes[ray.link];
    uint32_t k;
    ray.cell = node->cell;
    while ((k = first_exit(node, ox, oy, dx, dy)) == PRISM_CHUNK - 1) {
        if (SELDOM(node->next >= LINK_END)) { /* straight up: the planes of the same cell, no distance yet */
            ray.link = node->next;
            return ray;
        }
        node = &m->nodes[node->next];
    }
    const PrismSection *s = &m->sections[node->section_first + k];
    float t = (s->nx * (node->x[k] - ox) + s->ny * (node->y[k] - oy)) / (s->nx * dx + s->ny * dy);
    float z = oz + t * dz;
    uint32_t up = dz > 0;
    float cap_z = node->z[up], cap_t = (cap_z - oz) / dz;
    /* explicit masks: left to itself the compiler branches on what no predictor can know */
    uint32_t cap = 0u - ((up & (z > cap_z)) | ((dz < 0) & (z < cap_z)));
    uint32_t link = s->link[band_at(s, z)];
    while (SELDOM(link >= LINK_TALL)) {
        s = &m->sections[link & LINK_SECTION];
        link = s->link[band_at(s, z)];
    }
    link = (node->cap_link[up] & cap) | (link & ~cap);
    if (SELDOM(link == (LINK_PLANES | node->cell))) { /* openings of all shapes: likewise */
        ray.link = link;
        return ray;
    }
    ray.distance = pick_float(cap, cap_t, t);
    if (!(ray.distance < limit))
        link = LINK_NOTHING;
    ray.portals += (link & LINK_PLANES) != LINK_END;
    ray.link = link;
    return ray;
}

/* The arrays of a block; what is only read overlaps nothing that is written. */
#define BLOCK_ARRAYS(b)                                                                                                                    \
    const float *restrict ox = (b)->ox, *restrict oy = (b)->oy, *restrict oz = (b)->oz, *restrict dx = (b)->dx;                            \
    const float *restrict dy = (b)->dy, *restrict dz = (b)->dz, *restrict limit = (b)->limit;                                              \
    const uint32_t *restrict target = (b)->target;                                                                                         \
    uint32_t *link = (b)->link, *cell = (b)->cell, *portals = (b)->portals;                                                                \
    float *distance = (b)->distance

static void run_single(const EnfRaycaster *r, const RayBlock *b) {
    const PrismModel m = r->prisms;
    const uint32_t cap = enf_ray_step_cap(r), count = b->count;
    BLOCK_ARRAYS(b);
    for (uint32_t i = 0; i < count; i++) {
        RayState ray = {distance[i], link[i], cell[i], portals[i]};
        uint32_t steps = cap;
        while (ray.link < LINK_END || ray.link >= LINK_PLANES) {
            if (ray.link >= LINK_PLANES) {
                link[i] = ray.link, distance[i] = ray.distance, portals[i] = ray.portals;
                enf_ray_block_planes(r, b, i, &steps);
                ray = (RayState){distance[i], link[i], cell[i], portals[i]};
                continue;
            }
            ray = step_ray(&m, ray, ox[i], oy[i], oz[i], dx[i], dy[i], dz[i], limit[i]);
            ray.link = steps-- == 0 || (target && target[i] == ray.link) ? LINK_NOTHING : ray.link;
        }
        link[i] = ray.link, distance[i] = ray.distance, cell[i] = ray.cell, portals[i] = ray.portals;
    }
}

/* Lanes [from, to) of 16. */
static inline __attribute__((always_inline)) uint32_t lane_range(int32_t from, int32_t to) {
    return (0xFFFFu << (from > 0 ? from : 0)) & (to < 16 ? (1u << to) - 1 : 0xFFFFu);
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
            lanes_put16(depth + at, lane_range(-at, end - at), 1.0f / (base + slope * ((float)at + iota)));
        for (; at + 16 <= end; at += 16) {
            vf16 v = 1.0f / (base + slope * ((float)at + iota));
            memcpy(depth + at, &v, sizeof v);
        }
        if (at < end)
            lanes_put16(depth + at, lane_range(0, end - at), 1.0f / (base + slope * ((float)at + iota)));
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

static void add(float *restrict out, const float *restrict offset, uint32_t count, float base) {
    for (uint32_t i = 0; i < count; i++)
        out[i] = base + offset[i];
}

/* Counts and pointers are taken out of the block first: what is written might else be they, for all the compiler knows. */
static void finish(const RayBlock *b) {
    uint32_t *restrict link = b->link, *restrict cell = b->cell, *restrict portals = b->portals;
    float *restrict distance = b->distance;
    const uint32_t count = b->count;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t to = link[i], nothing = to >= LINK_OUT, out = nothing & (to != LINK_NOTHING);
        float t = distance[i] < 0 ? 0 : distance[i];
        distance[i] = nothing ? INFINITY : t;
        cell[i] = out ? to & LINK_SURFACE : cell[i];
        portals[i] += out;
        link[i] = nothing ? ENF_NONE : to & LINK_SURFACE;
    }
}

static void start(const EnfRaycaster *r, const RayBlock *b) {
    const uint32_t *restrict node_of_cell = r->prisms.node_of_cell;
    const float *restrict ox = b->ox, *restrict oy = b->oy, *restrict oz = b->oz;
    const float *restrict dx = b->dx, *restrict dy = b->dy, *restrict dz = b->dz;
    uint32_t *restrict link = b->link, *restrict cell = b->cell;
    const uint32_t cells = r->cell_count, count = b->count;
    for (uint32_t i = 0; i < count; i++) {
        /* 0 times anything finite is 0, times infinity NaN */
        float finite = 0 * ox[i] + 0 * oy[i] + 0 * oz[i] + 0 * dx[i] + 0 * dy[i] + 0 * dz[i];
        int good = (finite == 0) & ((dx[i] != 0) | (dy[i] != 0) | (dz[i] != 0));
        link[i] = good ? 0 : LINK_NOTHING;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t known = (link[i] == 0) & (cell[i] < cells), to = node_of_cell[known ? cell[i] : 0];
        cell[i] = known ? cell[i] : ENF_NONE;
        link[i] = known ? to : LINK_NOTHING;
    }
    memset(b->distance, 0, count * sizeof *b->distance);
    memset(b->portals, 0, count * sizeof *b->portals);
}

#define LANES       8
#define PACKET_NAME run_packets8
#include "raycast/ray_packet_body.h"
#undef LANES
#undef PACKET_NAME
#define LANES       16
#define PACKET_NAME run_packets16
#include "raycast/ray_packet_body.h"
#undef LANES
#undef PACKET_NAME

/* Without fast gathers one ray after another is as good. */
#ifndef RUN_WAVE
#define RUN_WAVE run_single
#endif

#define RAY_KERNEL_TABLE                                                                                                                   \
    { run_single, RUN_WAVE, run_packets8, run_packets16, fill, edge, clip, fill_three, fill_places, add, finish, start }
