/* SPDX-License-Identifier: GPL-3.0-or-later
 * Light that arrives straight from lights: for each that may reach the point's cell, what it would give, then a shadow ray.
 *
 * A shadow ray walks from cell to cell, as far as the light: most end at the first wall and never ask the triangles. With or without
 * light sets the same terms are added in the same order, so the sum has the same bits; sets only spare the rays that end in a wall. */
#include "raycast/light.h"
#include "raycast/ray_kernel.h"
#include "raycast/triangle_tree.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "geometry/vec3.h"

enum { CHUNK = 4096, SHADOWS = 128 /* rays of a point asked together; twice a light's most samples */ };

/* Share of its length that a walk through the cells stops short of the light: above the rounding of single precision over a building. */
static const float light_end = 4e-6f;

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
    if (d->raycaster)
        enf_raycaster_follow_states(d->raycaster);
    for (uint32_t i = 0; cells && i < d->light_count; i++)
        cells[i] = d->raycaster ? enf_light_cell(d->raycaster->scene, &d->lights[i]) : ENF_NONE;
    return cells;
}

/* Shadow rays of one point, asked together. */
typedef struct Shadows {
    uint32_t count;
    uint32_t light[SHADOWS];
    double share[SHADOWS]; /* of its irradiance that the surface takes */
    LightSample sample[SHADOWS];
    uint8_t walls[SHADOWS], blocked[SHADOWS];
} Shadows;

/* Rays through the cells from `from`, a little off the surface, to the same points of the lights. */
static void walk_walls(const EnfDirectLight *d, const EnfLitPoint *point, const double from[3], Shadows *s) {
    RayBlock block;
    uint32_t ray[SHADOWS], count = 0;
    for (uint32_t i = 0; i < s->count; i++) {
        if (!s->walls[i])
            continue;
        double along[3];
        vec_copy(along, s->sample[i].to);
        block.limit[count] = INFINITY;
        if (isfinite(s->sample[i].distance)) {
            double target[3];
            vec_mad(target, point->position, s->sample[i].distance, along);
            vec_sub(along, target, from);
            block.limit[count] = 1 - light_end;
        }
        for (int k = 0; k < 3; k++) {
            block.o[k][count] = (float)(from[k] - d->raycaster->scene->origin[k]);
            block.d[k][count] = (float)along[k];
        }
        block.cell[count] = point->cell;
        ray[count++] = i;
    }
    if (!count)
        return;
    block.count = count;
    block.targets = block.ways = block.aheads = 0;
    enf_ray_block_walk(d->raycaster, &block);
    for (uint32_t k = 0; k < count; k++)
        s->blocked[ray[k]] = block.link[k] != ENF_NONE;
}

static void ask_triangles(const EnfDirectLight *d, const EnfLitPoint *point, Shadows *s) {
    float from[3][SHADOWS], way[3][SHADOWS], farthest[SHADOWS];
    TreeRays rays = {s->count, {from[0], from[1], from[2]}, {way[0], way[1], way[2]}, farthest, s->blocked};
    double origin[3];
    vec_mad(origin, point->position, clearance, point->normal);
    vec_sub(origin, origin, d->triangles->origin);
    for (uint32_t i = 0; i < s->count; i++) {
        for (int k = 0; k < 3; k++) {
            from[k][i] = (float)origin[k];
            way[k][i] = (float)s->sample[i].to[k];
        }
        farthest[i] = (float)fmin(s->sample[i].distance - 2 * clearance, INFINITY);
    }
    enf_tree_blocked_rays(d->triangles, &rays);
}

/* Adds what isn't in shadow, light by light as they came, and begins anew. Gives how many lights reach the point. */
static uint32_t settle(const EnfDirectLight *d, const EnfLitPoint *point, const double from[3], Shadows *s, double sum[3]) {
    uint32_t reaching = 0;
    memset(s->blocked, 0, s->count);
    if (d->raycaster && point->cell != ENF_NONE)
        walk_walls(d, point, from, s);
    if (d->triangles)
        ask_triangles(d, point, s);
    for (uint32_t i = 0; i < s->count;) {
        uint32_t light = s->light[i], lit = 0;
        double own[3] = {0, 0, 0};
        for (; i < s->count && s->light[i] == light; i++) {
            if (s->blocked[i])
                continue;
            vec_mad(own, own, s->share[i], s->sample[i].irradiance);
            lit = 1;
        }
        vec_add(sum, sum, own);
        reaching += lit;
    }
    s->count = 0;
    return reaching;
}

/* Room for the light's samples is there. */
static void aim(const EnfDirectLight *d, const uint32_t *light_cells, uint32_t index, const EnfLitPoint *point, Shadows *s) {
    const EnfLight *light = &d->lights[index];
    uint32_t samples = enf_light_is_soft(light) ? d->samples : 1;
    for (uint32_t k = 0; k < samples; k++) {
        LightSample *sample = &s->sample[s->count];
        if (!enf_light_sample(light, point->position, k, samples, point->seed, sample))
            continue;
        double facing = vec_dot(sample->to, point->normal);
        if (!(facing > 0))
            continue;
        s->light[s->count] = index;
        s->share[s->count] = facing / samples;
        s->walls[s->count++] = light->kind == ENF_LIGHT_SUN || light_cells[index] != ENF_NONE;
    }
}

uint32_t enf_light_at(const EnfDirectLight *d, const uint32_t *light_cells, const EnfLitPoint *point, const double walk_from[3],
                      float out_irradiance[3], LightCounts *counts) {
    int sets = d->light_sets && point->cell < d->light_sets->cell_count;
    uint64_t first = sets ? d->light_sets->first[point->cell] : 0, end = sets ? d->light_sets->first[point->cell + 1] : d->light_count;
    double sum[3] = {0, 0, 0};
    uint32_t lit = 0;
    Shadows shadows;
    shadows.count = 0;
    for (uint64_t k = first; k < end; k++) {
        uint32_t before = shadows.count;
        aim(d, light_cells, sets ? d->light_sets->lights[k] : (uint32_t)k, point, &shadows);
        counts->shadow_rays += shadows.count - before;
        if (shadows.count + d->samples > SHADOWS)
            lit += settle(d, point, walk_from, &shadows, sum);
    }
    lit += settle(d, point, walk_from, &shadows, sum);
    counts->asked += end - first;
    counts->reaching += lit;
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
