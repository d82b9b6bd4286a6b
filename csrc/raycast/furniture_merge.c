/* SPDX-License-Identifier: GPL-3.0-or-later
 * Merges: a ray asks the furniture with the wall's distance as its limit; one that is stopped is walked again to where it is stopped, so
 * that its cell is the one in which it bounces. */
#include "raycast/furniture_merge.h"
#include "raycast/ray_kernel.h"
#include "raycast/triangle_tree.h"

#include "base/threads.h"
#include "geometry/vec3.h"

#include <math.h>

/* Cells and openings passed by the rays that furniture stopped. */
static void walk_again(const EnfRaycaster *r, const MergeRays *m, const uint32_t *stopped, uint32_t count) {
    RayBlock block;
    const RayKernel *kernel = enf_ray_kernel(ENF_SIMD_BEST);
    for (uint32_t j = 0; j < count; j++) {
        uint32_t i = stopped[j];
        for (int k = 0; k < 3; k++) {
            block.o[k][j] = m->o[k][i];
            block.d[k][j] = m->d[k][i];
        }
        block.limit[j] = m->distance[i];
        block.cell[j] = m->start[i];
    }
    block.count = count;
    block.targets = block.ways = block.aheads = 0;
    kernel->start(r, &block);
    kernel->wave(r, &block);
    kernel->finish(&block);
    for (uint32_t j = 0; j < count; j++) {
        m->cell[stopped[j]] = block.cell[j];
        m->portals[stopped[j]] = block.portals[j];
    }
}

void enf_furniture_merge(const EnfRaycaster *r, const MergeRays *m, int any) {
    uint32_t first_surface = r->face_count + r->scene->portal_count, stopped[RAY_BLOCK], count = 0;
    const EnfTriangles *furniture = r->furniture;
    double moved[3]; /* from the raycaster's origin to the triangles' */
    vec_sub(moved, r->scene->origin, furniture->origin);
    for (uint32_t i = 0; i < m->count; i++) {
        int walled = m->surface[i] != ENF_NONE;
        if (m->start[i] == ENF_NONE || (any && walled))
            continue;
        const double o[3] = {m->o[0][i] + moved[0], m->o[1][i] + moved[1], m->o[2][i] + moved[2]};
        const double d[3] = {m->d[0][i], m->d[1][i], m->d[2][i]};
        double farthest = walled ? m->distance[i] : m->limit ? m->limit[i] : INFINITY;
        if (any) {
            if (enf_tree_blocked(furniture, o, d, 0, farthest, ENF_MEET_OPAQUE))
                m->surface[i] = first_surface; /* which one nobody asks */
            continue;
        }
        TreeHit hit = enf_tree_hit(furniture, o, d, 0, farthest, ENF_MEET_ALL);
        if (hit.triangle == ENF_NONE)
            continue;
        m->distance[i] = (float)hit.distance;
        m->surface[i] = first_surface + hit.triangle;
        stopped[count++] = i;
    }
    if (count && m->cell)
        walk_again(r, m, stopped, count);
}

static void merge_row(void *context, uint64_t y, uint32_t thread) {
    const ImageTask *task = context;
    const Screen *s = task->screen;
    EnfRaycastImage *image = task->image;
    float o[3][RAY_BLOCK], d[3][RAY_BLOCK], distance[RAY_BLOCK];
    uint32_t surface[RAY_BLOCK], cell[RAY_BLOCK], portals[RAY_BLOCK], start[RAY_BLOCK];
    (void)thread;
    for (uint32_t i = 0; i < RAY_BLOCK; i++) {
        start[i] = task->cell;
        for (int k = 0; k < 3; k++)
            o[k][i] = (float)s->eye[k];
    }
    for (uint32_t x = 0; x < image->width; x += RAY_BLOCK) {
        size_t at = (size_t)y * image->width + x;
        MergeRays rays = {image->width - x < RAY_BLOCK ? image->width - x : RAY_BLOCK,
                          {o[0], o[1], o[2]},
                          {d[0], d[1], d[2]},
                          NULL,
                          start,
                          distance,
                          surface,
                          image->cell || image->portals ? cell : NULL,
                          portals};
        for (uint32_t i = 0; i < rays.count; i++) {
            for (int k = 0; k < 3; k++)
                d[k][i] = (float)(s->base[k] + (x + i) * s->across[k] + (double)y * s->down[k]);
            distance[i] = image->depth[at + i];
            surface[i] = distance[i] < INFINITY ? 0 : ENF_NONE; /* a wall, whichever */
        }
        uint32_t first = task->r->face_count + task->r->scene->portal_count;
        enf_furniture_merge(task->r, &rays, 0);
        for (uint32_t i = 0; i < rays.count; i++) {
            if (surface[i] == ENF_NONE || surface[i] < first)
                continue;
            image->depth[at + i] = distance[i];
            if (image->surface)
                image->surface[at + i] = surface[i];
            if (image->cell)
                image->cell[at + i] = cell[i];
            if (image->portals)
                image->portals[at + i] = (uint8_t)(portals[i] < 255 ? portals[i] : 255);
            if (image->normal || image->uv) {
                FrameFill fill = enf_frame_fill(task, surface[i]);
                enf_image_write_frame(task, x + i, (uint32_t)y, 1, &fill);
            }
        }
    }
}

void enf_image_merge_furniture(const ImageTask *task) {
    if (task->cell != ENF_NONE)
        enf_parallel_for(task->image->height, task->image->threads, merge_row, (void *)task);
}
