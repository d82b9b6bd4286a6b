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

typedef struct Batch {
    const EnfRaycaster *r;
    const EnfRayBatch *rays;
    EnfRayHits *hits;
    uint8_t *blocked;
    const RayKernel *kernel;
    void (*walk)(const EnfRaycaster *raycaster, RayBlock *block);
} Batch;

static uint32_t find_cell(const EnfRaycaster *r, const float o[3]) {
    if (!isfinite(o[0] + o[1] + o[2]))
        return ENF_NONE;
    double point[3] = {o[0] + r->scene->origin[0], o[1] + r->scene->origin[1], o[2] + r->scene->origin[2]};
    uint32_t cell, found;
    return enf_scene_locate(r->scene, point, &cell, 1, &found) == ENF_OK && found ? cell : ENF_NONE;
}

enum { SIXTEEN = 16, BLOCK_SIXTEENS = RAY_BLOCK / SIXTEEN };

/* The rays of a block that are walked, sixteen by sixteen: of shadow rays those sixteens stay out whose origins all lie in their targets'
 * cells. Cells are convex: nothing is between. */
typedef struct Taken {
    uint64_t first; /* of the block */
    uint32_t count, sixteens;
    uint32_t sixteen[BLOCK_SIXTEENS]; /* ascending */
} Taken;

static Taken take_rays(const Batch *b, uint64_t first, uint32_t count) {
    const EnfRayBatch *rays = b->rays;
    Taken taken = {first, 0, 0, {0}};
    int targets = rays->target_cell && rays->cell && b->blocked && (!b->r->furniture || rays->without_furniture);
    for (uint32_t i = 0; i < count; i += SIXTEEN) {
        uint32_t end = i + SIXTEEN < count ? i + SIXTEEN : count, known = targets != 0;
        for (uint32_t k = i; k < end && known; k++)
            known = rays->cell[first + k] == rays->target_cell[first + k] && rays->cell[first + k] != ENF_NONE;
        if (known)
            continue;
        taken.sixteen[taken.sixteens++] = i / SIXTEEN;
        taken.count += end - i;
    }
    return taken;
}

/* Words of the rays that are taken. */
static void copy_taken(const Batch *b, const Taken *taken, void *to, const void *from) {
    const uint32_t *words = (const uint32_t *)from + taken->first;
    if (taken->sixteen[taken->sixteens - 1] + 1 == taken->sixteens) { /* none stays out before the last */
        b->kernel->copy(to, words, taken->count);
        return;
    }
    for (uint32_t i = 0; i < taken->sixteens; i++) {
        uint32_t left = taken->count - SIXTEEN * i;
        b->kernel->copy((uint32_t *)to + SIXTEEN * i, words + SIXTEEN * taken->sixteen[i], left < SIXTEEN ? left : SIXTEEN);
    }
}

static void walk_block(const Batch *b, const Taken *taken, RayBlock *block, uint32_t *starts) {
    const EnfRayBatch *rays = b->rays;
    const EnfRaycaster *r = b->r;
    const float *const coordinates[6] = {rays->origin_x,    rays->origin_y,    rays->origin_z,
                                         rays->direction_x, rays->direction_y, rays->direction_z};
    uint64_t next = taken->first + RAY_BLOCK;
    block->count = taken->count;
    block->ways = 0;
    block->aheads = 0;
    for (int k = 0; k < 6; k++) {
        copy_taken(b, taken, k < 3 ? block->o[k] : block->d[k - 3], coordinates[k]);
        block->ahead[block->aheads++] = coordinates[k] + next;
    }
    if (rays->max_distance) {
        copy_taken(b, taken, block->limit, rays->max_distance);
        block->ahead[block->aheads++] = rays->max_distance + next;
    } else
        for (uint32_t i = 0; i < block->count; i++)
            block->limit[i] = INFINITY;
    if (rays->cell) {
        copy_taken(b, taken, block->cell, rays->cell);
        block->ahead[block->aheads++] = rays->cell + next;
    }
    if (next + RAY_BLOCK > rays->count)
        block->aheads = 0;
    for (uint32_t i = 0; i < block->count; i++)
        if (!rays->cell || block->cell[i] == ENF_NONE)
            block->cell[i] = find_cell(r, (const float[3]){block->o[0][i], block->o[1][i], block->o[2][i]});
    b->kernel->start(r, block);
    b->kernel->copy(starts, block->cell, block->count);
    block->targets = rays->target_cell && b->blocked;
    if (block->targets)
        copy_taken(b, taken, block->target, rays->target_cell);
    for (uint32_t i = 0; i < block->count && block->targets; i++) {
        uint32_t wanted = block->target[i];
        block->target[i] = wanted < r->cell_count ? r->prisms.node_of_cell[wanted] : LINK_NOTHING;
        block->link[i] = wanted == block->cell[i] ? LINK_NOTHING : block->link[i];
    }
    b->walk(r, block);
    b->kernel->finish(block);
}

static void write_frames(const Batch *b, uint64_t first, const RayBlock *hits) {
    const EnfRayBatch *rays = b->rays;
    SurfaceFrame frame;
    uint32_t known = ENF_NONE;
    for (uint32_t i = 0; i < hits->count; i++) {
        uint64_t k = first + i;
        float normal[3] = {0, 0, 0}, uv[2] = {0, 0};
        uint32_t surface = hits->link[i];
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
    RayBlock hits;
    (void)thread;
    const EnfRayBatch *rays = b->rays;
    uint32_t start[RAY_BLOCK];
    const Taken taken = take_rays(b, first, count);
    if (b->blocked)
        memset(b->blocked + first, 0, count);
    if (taken.sixteens == 0)
        return;
    walk_block(b, &taken, &hits, start);
    if (b->r->furniture && !rays->without_furniture) { /* then all are taken */
        MergeRays merge = {count,
                           {rays->origin_x + first, rays->origin_y + first, rays->origin_z + first},
                           {rays->direction_x + first, rays->direction_y + first, rays->direction_z + first},
                           rays->max_distance ? rays->max_distance + first : NULL,
                           start,
                           hits.distance,
                           hits.link,
                           b->blocked ? NULL : hits.cell,
                           hits.portals};
        enf_furniture_merge(b->r, &merge, b->blocked != NULL);
    }
    if (b->blocked) {
        for (uint32_t i = 0; i < taken.count; i++)
            b->blocked[first + SIXTEEN * taken.sixteen[i / SIXTEEN] + i % SIXTEEN] = hits.link[i] != ENF_NONE;
        return;
    }
    if (b->hits->distance)
        b->kernel->copy(b->hits->distance + first, hits.distance, count);
    if (b->hits->surface)
        b->kernel->copy(b->hits->surface + first, hits.link, count);
    if (b->hits->cell)
        b->kernel->copy(b->hits->cell + first, hits.cell, count);
    if (b->hits->portals)
        for (uint32_t i = 0; i < count; i++)
            b->hits->portals[first + i] = (uint8_t)(hits.portals[i] < 255 ? hits.portals[i] : 255);
    if (b->hits->normal || b->hits->uv)
        write_frames(b, first, &hits);
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
