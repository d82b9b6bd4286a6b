/* SPDX-License-Identifier: GPL-3.0-or-later
 * Light that arrives straight from lights: for each that may reach the point's cell, what it would give, then a shadow ray.
 *
 * A shadow ray walks from cell to cell, as far as the light: most end at the first wall and never ask the triangles. With or without
 * light sets the same terms are added in the same order, so the sum has the same bits; sets only spare the rays that end in a wall. */
#include "raycast/light.h"
#include "raycast/ray_model.h"
#include "raycast/triangle_tree.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "geometry/vec3.h"

enum { CHUNK = 4096 };

/* Metres that a shadow ray keeps off the surface it starts at and the light it ends at: above the rounding of single-precision vertices,
 * below what a lamp shade is thick. */
static const double clearance = 1e-4;

EnfDirectLight enf_default_direct_light(void) {
    EnfDirectLight direct = {.struct_size = sizeof direct, .samples = 1};
    return direct;
}

EnfStatus enf_direct_light_check(const EnfDirectLight *d) {
    if (d->struct_size != sizeof *d || (d->light_count && !d->lights) || d->samples < 1 || d->samples > 64)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "direct light: bad struct_size, NULL lights, or samples not in 1 .. 64");
    if (d->triangles && !d->triangles->committed)
        return enf_fail(ENF_ERROR_STATE, "direct light: the triangles aren't committed");
    if (d->light_sets && (!d->raycaster || d->light_sets->cell_count != d->raycaster->cell_count))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "direct light: the light sets aren't of the raycaster's scene");
    for (uint32_t i = 0; i < d->light_count; i++) {
        EnfStatus status = enf_light_check(&d->lights[i], i);
        if (status != ENF_OK)
            return status;
    }
    if (d->light_sets && d->light_sets->first[d->light_sets->cell_count])
        for (uint64_t k = 0; k < d->light_sets->first[d->light_sets->cell_count]; k++)
            if (d->light_sets->lights[k] >= d->light_count)
                return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "direct light: the light sets name light %u of %u", d->light_sets->lights[k],
                                d->light_count);
    return ENF_OK;
}

uint32_t *enf_light_cells(const EnfDirectLight *d) {
    uint32_t *cells = ENF_NEW(uint32_t, d->light_count);
    for (uint32_t i = 0; cells && i < d->light_count; i++)
        cells[i] = d->raycaster ? enf_light_cell(d->raycaster->scene, &d->lights[i]) : ENF_NONE;
    return cells;
}

static int in_shadow(const EnfDirectLight *d, const EnfLitPoint *point, const double from[3], int walls, const LightSample *s) {
    if (walls) {
        /* from `from`, a little off the surface, to the same point of the light */
        EnfRay ray = {{from[0], from[1], from[2]}, {s->to[0], s->to[1], s->to[2]}, s->distance, point->cell, 0};
        EnfRayHit hit;
        if (isfinite(s->distance)) {
            double target[3];
            vec_mad(target, point->position, s->distance, s->to);
            vec_sub(ray.direction, target, from);
            ray.max_distance = 1 - 1e-9;
        }
        if (enf_raycast_rays(d->raycaster, &ray, 1, &hit) != ENF_OK || hit.surface != ENF_NONE)
            return 1;
    }
    if (d->triangles) {
        double o[3];
        vec_mad(o, point->position, clearance, point->normal);
        vec_sub(o, o, d->triangles->origin);
        return enf_tree_blocked(d->triangles, o, s->to, 0, s->distance - 2 * clearance, ENF_MEET_OPAQUE);
    }
    return 0;
}

static int add_light(const EnfDirectLight *d, const uint32_t *light_cells, uint32_t index, const EnfLitPoint *point, const double from[3],
                     double sum[3], LightCounts *counts) {
    const EnfLight *light = &d->lights[index];
    uint32_t samples = enf_light_is_soft(light) ? d->samples : 1;
    int walls = d->raycaster && point->cell != ENF_NONE && (light->kind == ENF_LIGHT_SUN || light_cells[index] != ENF_NONE);
    double own[3] = {0, 0, 0};
    int lit = 0;
    counts->asked++;
    for (uint32_t k = 0; k < samples; k++) {
        LightSample s;
        if (!enf_light_sample(light, point->position, k, samples, point->seed, &s))
            continue;
        double facing = vec_dot(s.to, point->normal);
        if (!(facing > 0))
            continue;
        counts->shadow_rays++;
        if (in_shadow(d, point, from, walls, &s))
            continue;
        vec_mad(own, own, facing / samples, s.irradiance);
        lit = 1;
    }
    vec_add(sum, sum, own);
    counts->reaching += (uint64_t)lit;
    return lit;
}

uint32_t enf_light_at(const EnfDirectLight *d, const uint32_t *light_cells, const EnfLitPoint *point, const double walk_from[3],
                      float out_irradiance[3], LightCounts *counts) {
    double sum[3] = {0, 0, 0};
    uint32_t lit = 0;
    if (d->light_sets && point->cell < d->light_sets->cell_count) {
        const uint64_t *first = d->light_sets->first;
        for (uint64_t k = first[point->cell]; k < first[point->cell + 1]; k++)
            lit += (uint32_t)add_light(d, light_cells, d->light_sets->lights[k], point, walk_from, sum, counts);
    } else {
        for (uint32_t i = 0; i < d->light_count; i++)
            lit += (uint32_t)add_light(d, light_cells, i, point, walk_from, sum, counts);
    }
    for (int k = 0; k < 3; k++)
        out_irradiance[k] = (float)sum[k];
    return lit;
}

typedef struct Work {
    EnfDirectLight *direct;
    const uint32_t *light_cells;
    const EnfLitPoint *points;
    uint64_t count;
    float *irradiance;
    uint16_t *counts;
    LightCounts *done; /* one a chunk */
} Work;

static void one_chunk(void *context, uint64_t chunk, uint32_t thread) {
    Work *work = context;
    uint64_t first = chunk * CHUNK, end = first + CHUNK < work->count ? first + CHUNK : work->count;
    (void)thread;
    for (uint64_t i = first; i < end; i++) {
        EnfLitPoint point = work->points[i];
        double from[3];
        uint32_t lit = 0, found = 0;
        float nothing[3] = {0, 0, 0};
        memcpy(work->irradiance + 3 * i, nothing, sizeof nothing);
        if (vec_finite(point.position) && vec_finite(point.normal)) {
            vec_mad(from, point.position, clearance, point.normal);
            if (work->direct->raycaster && point.cell >= work->direct->raycaster->cell_count) {
                uint32_t cell = ENF_NONE;
                if (enf_scene_locate(work->direct->raycaster->scene, from, &cell, 1, &found) == ENF_OK && found)
                    point.cell = cell;
                else
                    point.cell = ENF_NONE;
            }
            lit = enf_light_at(work->direct, work->light_cells, &point, from, work->irradiance + 3 * i, &work->done[chunk]);
        }
        if (work->counts)
            work->counts[i] = (uint16_t)(lit < 65535 ? lit : 65535);
    }
}

EnfStatus enf_direct_light(EnfDirectLight *direct, const EnfLitPoint *points, uint64_t count, float *out_irradiance, uint16_t *out_counts) {
    if (!direct || (count && (!points || !out_irradiance)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_direct_light: NULL argument");
    EnfStatus status = enf_direct_light_check(direct);
    if (status != ENF_OK)
        return status;
    uint64_t chunks = (count + CHUNK - 1) / CHUNK;
    uint32_t *cells = enf_light_cells(direct);
    Work work = {direct, cells, points, count, out_irradiance, out_counts, ENF_NEW(LightCounts, chunks)};
    if (!cells || !work.done) {
        enf_free(cells);
        enf_free(work.done);
        return enf_fail_memory();
    }
    if (count)
        enf_parallel_for(chunks, direct->threads, one_chunk, &work);
    direct->shadow_rays = direct->lights_asked = direct->lights_reaching = 0;
    for (uint64_t c = 0; c < chunks; c++) {
        direct->shadow_rays += work.done[c].shadow_rays;
        direct->lights_asked += work.done[c].asked;
        direct->lights_reaching += work.done[c].reaching;
    }
    enf_free(cells);
    enf_free(work.done);
    return ENF_OK;
}
