/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walks blocks of rays through the prisms, by the instructions the processor has. Internal to the core.
 *
 * The same source (ray_kernel_body.h) is compiled plainly, for AVX2 and for AVX-512; every operation on a ray is one IEEE operation in
 * one order, so all three give the same bits. */
#ifndef ENF_RAYCAST_RAY_KERNEL_H
#define ENF_RAYCAST_RAY_KERNEL_H

#include "raycast/ray_model.h"

enum { RAY_BLOCK = 256 }; /* rays walked together: their state stays in the first-level cache */

typedef struct RayBlock {
    uint32_t count;                           /* at most RAY_BLOCK */
    const float *ox, *oy, *oz, *dx, *dy, *dz; /* [count] */
    const float *limit;                       /* [count] */
    const uint32_t *target;                   /* [count] link of the cell where a ray is done unhindered; NULL: none */
    uint32_t *link;                           /* [count] in: where it starts; out: LINK_END | surface, LINK_OUT | cell, LINK_NOTHING */
    float *distance;                          /* [count] out */
    uint32_t *cell;                           /* [count] out; kept for rays that start ended */
    uint32_t *portals;                        /* [count] grows by those passed */
    uint64_t *way;                            /* [count] NULL, or a number mixed from all sections and bands on the way (packets only) */
} RayBlock;

/* First pixel whose centre is at or right of x. Clamped so that it fits. ceil() would be a call on processors before SSE4.1. */
static inline int32_t enf_first_pixel(double x) {
    double c = x - 0.5;
    c = c > -1e9 ? c : -1e9; /* NaN too */
    c = c < 1e9 ? c : 1e9;
    int32_t whole = (int32_t)c;
    return whole + (whole < c);
}

typedef struct RayKernel {
    void (*single)(const EnfRaycaster *raycaster, const RayBlock *block);
    void (*wave)(const EnfRaycaster *raycaster, const RayBlock *block);
    void (*packets8)(const EnfRaycaster *raycaster, const RayBlock *block);
    void (*packets16)(const EnfRaycaster *raycaster, const RayBlock *block);
    /* depth[i] = 1 / (base + slope * i), index[i] = value; either array may be NULL */
    void (*fill)(float *depth, uint32_t *index, uint32_t count, float base, float slope, uint32_t value);
    /* An edge crosses rows `from` .. from + count - 1: lo[i] and hi[i] are stretched to the first pixel whose centre isn't left of it. */
    void (*edge)(int32_t *lo, int32_t *hi, int32_t from, uint32_t count, const double start[2], double slope);
    /* Cuts intervals to the outer ones; gives how many aren't empty. */
    uint32_t (*clip)(int32_t *lo, int32_t *hi, const int32_t *outer_lo, const int32_t *outer_hi, uint32_t count);
    /* out[3 i + k] = value[k] */
    void (*fill_three)(float *out, uint32_t count, const float value[3]);
    /* uv[2 i + k] = line[3 k] + (line[3 k + 1] + line[3 k + 2] * i) / (inverse[0] + inverse[1] * i) */
    void (*fill_places)(float *uv, uint32_t count, const float inverse[2], const float line[6]);
    /* out[i] = base + offset[i] */
    void (*add)(float *out, const float *offset, uint32_t count, float base);
    /* A block that is done: links become surfaces, ENF_NONE and infinity where nothing is hit. */
    void (*finish)(const RayBlock *block);
    /* A block to start: links from the block's cells (ENF_NONE: not known) and 0 in distance and portals. Rays that are none get
     * LINK_NOTHING and cell ENF_NONE. */
    void (*start)(const EnfRaycaster *raycaster, const RayBlock *block);
} RayKernel;

/* simd: ENF_SIMD_*, at most that; what the processor hasn't falls to the next lower. */
const RayKernel *enf_ray_kernel(uint32_t simd);
/* The highest ENF_SIMD_* that this processor and this build have. */
uint32_t enf_ray_simd(void);

extern const RayKernel enf_ray_kernel_plain;
extern const RayKernel *const enf_ray_kernel_avx2, *const enf_ray_kernel_avx512; /* NULL where not built */

/* A number for a way: sections, bands and cells one after another. Two ways share one by chance with 2^-64. */
static inline uint64_t enf_ray_way(uint64_t way, uint64_t step) {
    uint64_t mixed = (way ^ (step + 1)) * 0x9E3779B97F4A7C15ull;
    return mixed ^ mixed >> 29;
}

/* The slow step for one ray of a block, until it is in a prism again or ended. `steps` left; 0 ends it as hitting nothing. */
void enf_ray_block_planes(const EnfRaycaster *raycaster, const RayBlock *block, uint32_t ray, uint32_t *steps);

/* More steps than any walk has: convex cells are met once each, so only wrong geometry could go round. */
static inline uint32_t enf_ray_step_cap(const EnfRaycaster *r) {
    return 2 * r->cell_count + 2 * r->prisms.node_count + 64;
}

#endif
