/* SPDX-License-Identifier: GPL-3.0-or-later
 * Arrays of rays: shared out over threads, walked in blocks, merged with furniture, written as asked for. */
#include "raycast/ray_model.h"
#include "raycast/ray_surface.h"
#include "raycast/triangle_tree.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "geometry/vec3.h"

#include <string.h>

enum { BLOCK = 256 }; /* rays walked together: their state stays in the first-level cache */

/* What the walk finds for the rays of one block. */
typedef struct BlockHits {
    float distance[BLOCK];
    uint32_t surface[BLOCK], cell[BLOCK];
    uint8_t portals[BLOCK];
} BlockHits;

typedef struct Batch {
    const EnfRaycaster *r;
    const EnfRayBatch *rays;
    EnfRayHits *hits;
    uint8_t *blocked;
} Batch;

static void walk_block(const Batch *b, uint64_t first, uint32_t count, BlockHits *out) {
    const EnfRayBatch *rays = b->rays;
    const double *origin = b->r->scene->origin;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t k = first + i;
        EnfRay ray = {{origin[0] + rays->origin_x[k], origin[1] + rays->origin_y[k], origin[2] + rays->origin_z[k]},
                      {rays->direction_x[k], rays->direction_y[k], rays->direction_z[k]},
                      rays->max_distance ? rays->max_distance[k] : INFINITY,
                      rays->cell ? rays->cell[k] : ENF_NONE,
                      0};
        EnfRayHit hit;
        enf_raycast_rays(b->r, &ray, 1, &hit);
        out->distance[i] = hit.surface == ENF_NONE ? INFINITY : (float)hit.distance;
        out->surface[i] = hit.surface;
        out->cell[i] = hit.cell;
        out->portals[i] = (uint8_t)(hit.portals < 255 ? hit.portals : 255);
    }
}

static void merge_furniture(const Batch *b, uint64_t first, uint32_t count, int any, BlockHits *hits) {
    const EnfRayBatch *rays = b->rays;
    const EnfTriangles *furniture = b->r->furniture;
    uint32_t first_surface = b->r->face_count + b->r->scene->portal_count;
    double moved[3]; /* from the raycaster's origin to the triangles' */
    vec_sub(moved, b->r->scene->origin, furniture->origin);
    for (uint32_t i = 0; i < count; i++) {
        uint64_t k = first + i;
        const double o[3] = {rays->origin_x[k] + moved[0], rays->origin_y[k] + moved[1], rays->origin_z[k] + moved[2]};
        const double d[3] = {rays->direction_x[k], rays->direction_y[k], rays->direction_z[k]};
        if (hits->cell[i] == ENF_NONE || (any && hits->surface[i] != ENF_NONE))
            continue;
        double farthest = hits->surface[i] != ENF_NONE ? hits->distance[i] : rays->max_distance ? rays->max_distance[k] : INFINITY;
        if (any) {
            if (enf_tree_blocked(furniture, o, d, 0, farthest, ENF_MEET_OPAQUE))
                hits->surface[i] = first_surface; /* which one nobody asks */
            continue;
        }
        TreeHit hit = enf_tree_hit(furniture, o, d, 0, farthest, ENF_MEET_ALL);
        if (hit.triangle == ENF_NONE)
            continue;
        hits->distance[i] = (float)hit.distance;
        hits->surface[i] = first_surface + hit.triangle;
    }
}

static void write_frames(const Batch *b, uint64_t first, uint32_t count, const BlockHits *hits) {
    const EnfRayBatch *rays = b->rays;
    SurfaceFrame frame;
    uint32_t known = ENF_NONE;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t k = first + i;
        float normal[3] = {0, 0, 0}, uv[2] = {0, 0};
        uint32_t surface = hits->surface[i];
        if (surface != ENF_NONE) {
            if (surface != known)
                enf_surface_frame(b->r, surface, &frame);
            known = surface;
            const double d[3] = {rays->direction_x[k], rays->direction_y[k], rays->direction_z[k]};
            const double o[3] = {rays->origin_x[k], rays->origin_y[k], rays->origin_z[k]};
            double side = vec_dot(frame.normal, d) > 0 ? -1 : 1, p[3];
            vec_mad(p, o, hits->distance[i], d);
            vec_sub(p, p, frame.point);
            for (int c = 0; c < 3; c++)
                normal[c] = (float)(side * frame.normal[c]);
            uv[0] = (float)vec_dot(p, frame.u);
            uv[1] = (float)vec_dot(p, frame.v);
        }
        if (b->hits->normal)
            memcpy(b->hits->normal + 3 * k, normal, sizeof normal);
        if (b->hits->uv)
            memcpy(b->hits->uv + 2 * k, uv, sizeof uv);
    }
}

static void run_block(void *context, uint64_t block, uint32_t thread) {
    const Batch *b = context;
    uint64_t first = block * BLOCK;
    uint32_t count = b->rays->count - first < BLOCK ? (uint32_t)(b->rays->count - first) : BLOCK;
    BlockHits hits;
    (void)thread;
    walk_block(b, first, count, &hits);
    if (b->r->furniture && !b->rays->without_furniture)
        merge_furniture(b, first, count, b->blocked != NULL, &hits);
    if (b->blocked) {
        for (uint32_t i = 0; i < count; i++)
            b->blocked[first + i] = hits.surface[i] != ENF_NONE;
        return;
    }
    if (b->hits->distance)
        memcpy(b->hits->distance + first, hits.distance, count * sizeof *hits.distance);
    if (b->hits->surface)
        memcpy(b->hits->surface + first, hits.surface, count * sizeof *hits.surface);
    if (b->hits->cell)
        memcpy(b->hits->cell + first, hits.cell, count * sizeof *hits.cell);
    if (b->hits->portals)
        memcpy(b->hits->portals + first, hits.portals, count * sizeof *hits.portals);
    if (b->hits->normal || b->hits->uv)
        write_frames(b, first, count, &hits);
}

EnfRayBatch enf_default_ray_batch(void) {
    EnfRayBatch batch;
    memset(&batch, 0, sizeof batch);
    batch.struct_size = sizeof batch;
    return batch;
}

EnfRayHits enf_default_ray_hits(void) {
    EnfRayHits hits;
    memset(&hits, 0, sizeof hits);
    hits.struct_size = sizeof hits;
    return hits;
}

static EnfStatus run_batch(const char *caller, const EnfRaycaster *r, const EnfRayBatch *rays, EnfRayHits *hits, uint8_t *blocked) {
    if (!r || !rays || rays->struct_size != sizeof *rays || (hits && hits->struct_size != sizeof *hits))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "%s: NULL argument or bad struct_size", caller);
    if (rays->method > ENF_RAYS_WAVES || rays->simd > ENF_SIMD_AVX512)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "%s: no method %u or no simd %u", caller, rays->method, rays->simd);
    if (rays->count == 0)
        return ENF_OK;
    if ((!hits && !blocked) || !rays->origin_x || !rays->origin_y || !rays->origin_z || !rays->direction_x || !rays->direction_y ||
        !rays->direction_z)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "%s: NULL among the arrays", caller);
    Batch batch = {r, rays, hits, blocked};
    enf_parallel_for((rays->count + BLOCK - 1) / BLOCK, rays->threads, run_block, &batch);
    return ENF_OK;
}

EnfStatus enf_raycast_closest(const EnfRaycaster *raycaster, const EnfRayBatch *batch, EnfRayHits *hits) {
    return run_batch("enf_raycast_closest", raycaster, batch, hits, NULL);
}

EnfStatus enf_raycast_any(const EnfRaycaster *raycaster, const EnfRayBatch *batch, uint8_t *out_blocked) {
    return run_batch("enf_raycast_any", raycaster, batch, NULL, out_blocked);
}
