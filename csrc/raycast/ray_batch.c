/* SPDX-License-Identifier: GPL-3.0-or-later
 * Arrays of rays: shared out over threads, walked in blocks, merged with furniture, written as asked for. */
#include "raycast/furniture_merge.h"
#include "raycast/ray_kernel.h"
#include "raycast/ray_surface.h"

#include "base/status.h"
#include "base/threads.h"
#include "geometry/vec3.h"

#include <math.h>
#include <string.h>

/* What the walk finds for the rays of one block. */
typedef struct BlockHits {
    float distance[RAY_BLOCK];
    uint32_t surface[RAY_BLOCK]; /* a link until the walk is done */
    uint32_t cell[RAY_BLOCK], portals[RAY_BLOCK];
} BlockHits;

typedef struct Batch {
    const EnfRaycaster *r;
    const EnfRayBatch *rays;
    EnfRayHits *hits;
    uint8_t *blocked;
    const RayKernel *kernel;
    void (*walk)(const EnfRaycaster *raycaster, const RayBlock *block);
} Batch;

static uint32_t find_cell(const EnfRaycaster *r, const float o[3]) {
    if (!isfinite(o[0] + o[1] + o[2]))
        return ENF_NONE;
    double point[3] = {o[0] + r->scene->origin[0], o[1] + r->scene->origin[1], o[2] + r->scene->origin[2]};
    uint32_t cell, found;
    return enf_scene_locate(r->scene, point, &cell, 1, &found) == ENF_OK && found ? cell : ENF_NONE;
}

static void walk_block(const Batch *b, uint64_t first, uint32_t count, BlockHits *out, uint32_t *starts) {
    const EnfRayBatch *rays = b->rays;
    const EnfRaycaster *r = b->r;
    float limit[RAY_BLOCK];
    uint32_t target[RAY_BLOCK];
    RayBlock block = {count,
                      rays->origin_x + first,
                      rays->origin_y + first,
                      rays->origin_z + first,
                      rays->direction_x + first,
                      rays->direction_y + first,
                      rays->direction_z + first,
                      rays->max_distance ? rays->max_distance + first : limit,
                      NULL,
                      out->surface,
                      out->distance,
                      out->cell,
                      out->portals,
                      NULL};
    int targets = rays->target_cell && b->blocked;
    if (rays->cell)
        memcpy(out->cell, rays->cell + first, count * sizeof *out->cell);
    if (!rays->max_distance)
        for (uint32_t i = 0; i < count; i++)
            limit[i] = INFINITY;
    for (uint32_t i = 0; i < count; i++)
        if (!rays->cell || out->cell[i] == ENF_NONE)
            out->cell[i] = find_cell(r, (const float[3]){block.ox[i], block.oy[i], block.oz[i]});
    b->kernel->start(r, &block);
    memcpy(starts, out->cell, count * sizeof *starts);
    for (uint32_t i = 0; i < count && targets; i++) {
        uint32_t wanted = rays->target_cell[first + i];
        target[i] = wanted < r->cell_count ? r->prisms.node_of_cell[wanted] : LINK_NOTHING;
        out->surface[i] = wanted == out->cell[i] ? LINK_NOTHING : out->surface[i];
    }
    block.target = targets ? target : NULL;
    b->walk(r, &block);
    b->kernel->finish(&block);
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
    uint64_t first = block * RAY_BLOCK;
    uint32_t count = b->rays->count - first < RAY_BLOCK ? (uint32_t)(b->rays->count - first) : RAY_BLOCK;
    BlockHits hits;
    (void)thread;
    const EnfRayBatch *rays = b->rays;
    uint32_t start[RAY_BLOCK];
    walk_block(b, first, count, &hits, start);
    if (b->r->furniture && !rays->without_furniture) {
        MergeRays merge = {count,
                           {rays->origin_x + first, rays->origin_y + first, rays->origin_z + first},
                           {rays->direction_x + first, rays->direction_y + first, rays->direction_z + first},
                           rays->max_distance ? rays->max_distance + first : NULL,
                           start,
                           hits.distance,
                           hits.surface,
                           b->blocked ? NULL : hits.cell,
                           hits.portals};
        enf_furniture_merge(b->r, &merge, b->blocked != NULL);
    }
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
        for (uint32_t i = 0; i < count; i++)
            b->hits->portals[first + i] = (uint8_t)(hits.portals[i] < 255 ? hits.portals[i] : 255);
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
    enf_raycaster_follow_states(r);
    const RayKernel *kernel = enf_ray_kernel(rays->simd);
    uint32_t method = rays->method != ENF_RAYS_AUTO ? rays->method : rays->coherent ? ENF_RAYS_PACKETS16 : ENF_RAYS_WAVES;
    Batch batch = {r,
                   rays,
                   hits,
                   blocked,
                   kernel,
                   method == ENF_RAYS_SINGLE      ? kernel->single
                   : method == ENF_RAYS_PACKETS8  ? kernel->packets8
                   : method == ENF_RAYS_PACKETS16 ? kernel->packets16
                                                  : kernel->wave};
    enf_parallel_for((rays->count + RAY_BLOCK - 1) / RAY_BLOCK, rays->threads, run_block, &batch);
    return ENF_OK;
}

EnfStatus enf_raycast_closest(const EnfRaycaster *raycaster, const EnfRayBatch *batch, EnfRayHits *hits) {
    return run_batch("enf_raycast_closest", raycaster, batch, hits, NULL);
}

EnfStatus enf_raycast_any(const EnfRaycaster *raycaster, const EnfRayBatch *batch, uint8_t *out_blocked) {
    return run_batch("enf_raycast_any", raycaster, batch, NULL, out_blocked);
}
