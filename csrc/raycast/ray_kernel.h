/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walks blocks of rays through the prisms, by the instructions the processor has. Internal to the core.
 *
 * The same source (ray_kernel_body.h) is compiled plainly, for AVX2 and for AVX-512; every operation on a ray is one IEEE operation in
 * one order, so all three give the same bits. */
#ifndef ENF_RAYCAST_RAY_KERNEL_H
#define ENF_RAYCAST_RAY_KERNEL_H

#include "raycast/ray_model.h"

enum { RAY_BLOCK = 256 }; /* rays walked together: their state stays in the first-level cache */

/* Arrays at hand and not pointers to them: one register finds them all, and every packet lies in whole cache lines. */
typedef struct RayBlock {
    _Alignas(64) float o[3][RAY_BLOCK];
    float d[3][RAY_BLOCK], limit[RAY_BLOCK];
    uint32_t target[RAY_BLOCK];  /* link of the cell where a ray is done unhindered */
    uint32_t link[RAY_BLOCK];    /* in: where it starts; out: LINK_END | surface, LINK_OUT | cell, LINK_NOTHING */
    float distance[RAY_BLOCK];   /* out */
    uint32_t cell[RAY_BLOCK];    /* out; kept for rays that start ended */
    uint32_t portals[RAY_BLOCK]; /* grows by those passed */
    uint32_t way[2][RAY_BLOCK];  /* numbers mixed from all openings on the way (packets only) */
    uint32_t place[RAY_BLOCK];   /* where it ended (packets only): PLACES * section + band, or what PLACE_* says */
    const void *ahead[8];        /* [aheads] what the next block will be read from, as many words each: called for from memory on the way */
    uint32_t count;
    uint32_t aheads;
    uint32_t targets, ways; /* 1: there are such; 0: neither read nor written */
} RayBlock;

/* First pixel whose centre is at or right of x. Clamped so that it fits. ceil() would be a call on processors before SSE4.1. */
static inline int32_t enf_first_pixel(double x) {
    double c = x - 0.5;
    c = c > -1e9 ? c : -1e9; /* NaN too */
    c = c < 1e9 ? c : 1e9;
    int32_t whole = (int32_t)c;
    return whole + (whole < c);
}

/* Rays that all begin at one eye: direction k of ray i is base[k] + offset[k * stride + i]. */
typedef struct EyeRays {
    float base[3];
    uint32_t stride;
    const float *offset; /* to be read in whole sixteens */
    uint32_t link, cell; /* of the eye */
} EyeRays;

typedef struct RayKernel {
    void (*single)(const EnfRaycaster *raycaster, RayBlock *block);
    void (*wave)(const EnfRaycaster *raycaster, RayBlock *block);
    void (*packets8)(const EnfRaycaster *raycaster, RayBlock *block);
    void (*packets16)(const EnfRaycaster *raycaster, RayBlock *block);
    /* 16 at a time from start to finish. Of the block stand `o` and `limit` (the same for all), count and ways; the rest is set. */
    void (*eye_packets)(const EnfRaycaster *raycaster, RayBlock *block, const EyeRays *rays);
    /* depth[i] = 1 / (base + slope * i), infinity where that is negative; index[i] = value; either array may be NULL */
    void (*fill)(float *depth, uint32_t *index, uint32_t count, float base, float slope, uint32_t value);
    /* An edge crosses rows `from` .. from + count - 1: lo[i] and hi[i] are stretched to the first pixel whose centre isn't left of it. */
    void (*edge)(int32_t *lo, int32_t *hi, int32_t from, uint32_t count, const double start[2], double slope);
    /* Cuts intervals to the outer ones; gives how many aren't empty. */
    uint32_t (*clip)(int32_t *lo, int32_t *hi, const int32_t *outer_lo, const int32_t *outer_hi, uint32_t count);
    /* out[3 i + k] = value[k] */
    void (*fill_three)(float *out, uint32_t count, const float value[3]);
    /* uv[2 i + k] = line[3 k] + (line[3 k + 1] + line[3 k + 2] * i) / (inverse[0] + inverse[1] * i) */
    void (*fill_places)(float *uv, uint32_t count, const float inverse[2], const float line[6]);
    /* copies 32-bit words: for a kilobyte the compiler's own way takes longer to begin than to end */
    void (*copy)(void *to, const void *from, uint32_t words);
    /* A block that is done: links become surfaces, ENF_NONE and infinity where nothing is hit. */
    void (*finish)(RayBlock *block);
    /* A block to start: links from the block's cells (ENF_NONE: not known) and 0 in distance and portals. Rays that are none get
     * LINK_NOTHING and cell ENF_NONE. */
    void (*start)(const EnfRaycaster *raycaster, RayBlock *block);
} RayKernel;

/* simd: ENF_SIMD_*, at most that; what the processor hasn't falls to the next lower. */
const RayKernel *enf_ray_kernel(uint32_t simd);
/* The highest ENF_SIMD_* that this processor and this build have. */
uint32_t enf_ray_simd(void);

extern const RayKernel enf_ray_kernel_plain;
extern const RayKernel *const enf_ray_kernel_avx2, *const enf_ray_kernel_avx512; /* NULL where not built */

/* Places that a ray leaves a cell by, numbered: section and band, or else. */
enum {
    PLACES = 16,
    PLACE_CAP = 4,   /* PLACES * cell + this: its floor; 1 more: its ceiling */
    PLACE_PLANE = 6, /* PLACES * cell + this: a face that planes found; PLACES * portal and 1 more: the portal they did */
    PLACE_TALL = 8   /* PLACES * section + this + band: of a section that bands of another lead to */
};

/* Two numbers for a way: places one after another. Two ways share both by chance with 2^-64. Of numbers or vectors. */
#define WAY_MIX(mixed, which) ((mixed) ^ (mixed) >> ((which) ? 13 : 15))
#define WAY_STEP(way, place, which)                                                                                                        \
    WAY_MIX((((which) ? (way) + (place) : (way) ^ (place)) + 1) * ((which) ? 0x85EBCA6Bu : 0x9E3779B1u), which)

/* The slow step for one ray of a block, until it is in a prism again or ended. `steps` left; 0 ends it as hitting nothing. */
void enf_ray_block_planes(const EnfRaycaster *raycaster, RayBlock *block, uint32_t ray, uint32_t *steps);

/* More steps than any walk of a block's ray has. */
static inline uint32_t enf_ray_step_cap(const EnfRaycaster *r) {
    return enf_ray_cell_cap(r) + 2 * r->prisms.node_count;
}

/* Rays that go alike, few or many, from the block's cells to what they hit, by the best kernel. */
void enf_ray_block_walk(const EnfRaycaster *raycaster, RayBlock *block);

#endif
