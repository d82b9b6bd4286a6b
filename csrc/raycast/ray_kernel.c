/* SPDX-License-Identifier: GPL-3.0-or-later
 * Chooses the kernel at run time; and the step by planes that all kernels share. */
#include "raycast/ray_kernel.h"

#include "base/simd.h"

#include <math.h>

uint32_t enf_ray_simd(void) {
    if (enf_ray_kernel_avx512 && enf_processor_avx512())
        return ENF_SIMD_AVX512;
    if (enf_ray_kernel_avx2 && enf_processor_avx2())
        return ENF_SIMD_AVX2;
    return ENF_SIMD_NONE;
}

const RayKernel *enf_ray_kernel(uint32_t simd) {
    uint32_t has = enf_ray_simd();
    if (simd == ENF_SIMD_BEST || simd > has)
        simd = has;
    return simd == ENF_SIMD_AVX512 ? enf_ray_kernel_avx512 : simd == ENF_SIMD_AVX2 ? enf_ray_kernel_avx2 : &enf_ray_kernel_plain;
}

void enf_ray_block_walk(const EnfRaycaster *r, RayBlock *b) {
    const RayKernel *kernel = enf_ray_kernel(ENF_SIMD_BEST);
    kernel->start(r, b);
    (b->count < 4 && !b->ways ? kernel->single : kernel->packets16)(r, b); /* a packet that is nearly empty costs more than its rays */
    kernel->finish(b);
}

/* One more step on the ray's way. What isn't convex (a face with openings, the outdoors between openings) isn't shared by what lies
 * between rays: the ray's own number sets its way apart. */
static void note_step(const EnfRaycaster *r, RayBlock *b, uint32_t i, uint32_t cell, const RayStep *step) {
    int walled = r->scene->cell_face_first[cell] < r->scene->cell_face_first[cell + 1], ends = step->portal == ENF_NONE;
    int convex = walled && !(ends && step->surface < r->face_count && r->faces[step->surface].side_count > 0);
    b->place[i] = PLACES * cell + PLACE_PLANE;
    for (int k = 0; k < 2; k++) {
        if (!ends)
            b->way[k][i] = WAY_STEP(b->way[k][i], PLACES * step->portal + PLACE_PLANE + 1, k);
        if (!convex)
            b->way[k][i] = WAY_STEP(b->way[k][i], PLACES * i + PLACE_PLANE, k);
    }
}

void enf_ray_block_planes(const EnfRaycaster *r, RayBlock *b, uint32_t i, uint32_t *steps) {
    const double o[3] = {b->o[0][i], b->o[1][i], b->o[2][i]}, d[3] = {b->d[0][i], b->d[1][i], b->d[2][i]};
    double at = b->distance[i] > 0 && b->distance[i] < INFINITY ? b->distance[i] : 0;
    uint32_t cell = b->link[i] & LINK_INDEX;
    for (;;) {
        if (*steps == 0) {
            b->link[i] = LINK_NOTHING;
            break;
        }
        (*steps)--;
        RayStep step = enf_ray_step(r, cell, o, d, at);
        at = step.at;
        b->distance[i] = (float)at;
        if (b->ways)
            note_step(r, b, i, cell, &step);
        if (!(b->distance[i] < b->limit[i]) || step.portal == ENF_NONE) {
            b->link[i] = !(b->distance[i] < b->limit[i]) || step.surface == ENF_NONE ? LINK_NOTHING : LINK_END | step.surface;
            break;
        }
        if (r->prisms.way_into[step.to] == (LINK_OUT | step.to)) {
            b->link[i] = r->prisms.way_into[step.to];
            break;
        }
        cell = step.to;
        b->portals[i]++;
        b->link[i] = r->prisms.way_into[cell];
        if (b->targets && b->target[i] == b->link[i])
            b->link[i] = LINK_NOTHING;
        if (!link_asks_planes(b->link[i]))
            break;
    }
    b->cell[i] = cell;
}
