/* SPDX-License-Identifier: GPL-3.0-or-later
 * The rays and pictures that `enfilade bench raycast` measures. */
#ifndef ENF_TOOLS_BENCH_RAYS_H
#define ENF_TOOLS_BENCH_RAYS_H

#include "enfilade/raycast.h"

typedef struct RaySet {
    uint64_t count, room;
    float *o[3], *d[3], *limit;
    uint32_t *cell, *target;
    /* results */
    float *distance;
    uint32_t *surface, *hit_cell;
    uint8_t *blocked;
} RaySet;
RaySet *ray_set_create(uint64_t room); /* NULL: out of memory */
void ray_set_destroy(RaySet *rays);
EnfRayBatch ray_set_batch(const RaySet *rays); /* one thread */

/* In a random cell of a room (not of an opening); or outdoors, before the building. 0: there is none. */
int place_camera(const EnfScene *scene, uint64_t *rng, int outdoors, EnfCamera *out_camera, uint32_t *out_cell);
/* Through pixel centres, 4 x 4 pixels after each other; directions reach one metre deep. */
void primary_rays(const EnfScene *scene, const EnfRaycaster *r, const EnfCamera *camera, uint32_t cell, uint32_t size, RaySet *out);
/* From anywhere in any room, anywhere. */
void random_rays(const EnfScene *scene, const EnfRaycaster *r, uint64_t *rng, RaySet *out);
/* From what the rays hit, into the room, cosine-weighted. */
void bounce_rays(const EnfScene *scene, const EnfRaycaster *r, const RaySet *from, uint64_t *rng, RaySet *out);
/* From what the rays hit to a light under the ceiling of the cell `light`. */
void shadow_rays(const EnfScene *scene, const EnfRaycaster *r, const RaySet *from, uint32_t light, RaySet *out);
uint64_t primary_index(uint32_t size, uint32_t x, uint32_t y); /* where a pixel's ray stands */

typedef struct Picture {
    uint32_t width, height;
    float *depth, *normal, *uv;
    uint32_t *surface;
} Picture;
Picture *picture_create(uint32_t width, uint32_t height);
void picture_destroy(Picture *picture);
EnfRaycastImage picture_request(const Picture *picture, uint32_t all_buffers); /* one thread; depth and surface, or normal and uv too */
void picture_memset(Picture *picture);
/* The picture by spans against the rays' hits: pixels not written once, pixels that differ in distance. Gives the patched ones. */
uint64_t picture_check(const EnfRaycaster *r, const EnfCamera *camera, const RaySet *rays, Picture *picture, uint64_t *unwritten,
                       uint64_t *differing);
uint32_t bench_simd(void);

#endif
