/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench lights: direct light with and without light sets: shadow rays, milliseconds, and that no bit differs.
 *
 * Offices of 46, 135 and 1,755 rooms with 55, 199 and 2,557 lamps under the ceilings (the numbers of lights of Maria, Horna and Aveneau
 * 2014, section 6), pictures from random places in random rooms. Shadow rays are counts, the same on every machine. */
#include "scene_family.h"
#include "base/timer.h"
#include "scene/scene_data.h"
#include "tools/bench.h"
#include "tools/tool.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Row {
    const char *spec;
    uint32_t lights;
} Row;

typedef struct Picture {
    float *direct;
    uint16_t *lit;
    EnfPreview preview;
    double seconds;
} Picture;

static double unit(uint64_t *state) {
    *state = *state * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* Rooms that a lamp can hang in: cells of interior rooms, largest first would favour halls; in turn is fair. */
static uint32_t lit_cells(const EnfScene *scene, uint32_t *out) {
    uint32_t count = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (scene->cell_rooms[c] != ENF_NONE && scene->rooms[scene->cell_rooms[c]].kind == ENF_ROOM_INTERIOR &&
            scene->cell_vertex_first[c] != scene->cell_vertex_first[c + 1])
            out[count++] = c;
    return count;
}

static void hang_lamps(const EnfScene *scene, const uint32_t *cells, uint32_t cell_count, EnfLight *lights, uint32_t count) {
    uint64_t seed = 99;
    for (uint32_t i = 0; i < count; i++) {
        const double *b = scene->cell_bounds[cells[(uint64_t)i * cell_count / count]];
        lights[i] = enf_default_light();
        for (int k = 0; k < 2; k++)
            lights[i].position[k] = b[k] + (0.2 + 0.6 * unit(&seed)) * (b[3 + k] - b[k]);
        lights[i].position[2] = b[5] - 0.25;
        for (int k = 0; k < 3; k++)
            lights[i].intensity[k] = 20 + 10 * unit(&seed);
    }
}

static EnfCamera random_camera(const EnfScene *scene, const uint32_t *cells, uint32_t cell_count, uint64_t *seed) {
    const double *b = scene->cell_bounds[cells[(uint32_t)(unit(seed) * cell_count)]];
    double yaw = 6.283185307179586 * unit(seed), eye[3];
    EnfCamera c = enf_default_camera();
    for (int k = 0; k < 2; k++)
        eye[k] = b[k] + (0.2 + 0.6 * unit(seed)) * (b[3 + k] - b[k]);
    eye[2] = b[2] + 1.5;
    const double m[12] = {sin(yaw), 0, -cos(yaw), eye[0], -cos(yaw), 0, -sin(yaw), eye[1], 0, 1, 0, eye[2]};
    memcpy(c.world_from_camera, m, sizeof m);
    c.angle_x = 1.3;
    c.angle_y = 1.3;
    c.clip_near = 0;
    c.clip_far = INFINITY;
    return c;
}

static EnfStatus shoot(Picture *p, const EnfCamera *camera, const EnfLightSets *sets) {
    p->preview.light_sets = sets;
    double begin = enf_wall_seconds();
    EnfStatus status = enf_preview(&p->preview, camera);
    p->seconds += enf_wall_seconds() - begin;
    return status;
}

static EnfStatus measure(const Row *row, uint32_t size, uint32_t pictures, uint32_t threads, FILE *csv) {
    EnfScene *scene = NULL;
    EnfRaycaster *r = NULL;
    EnfLightSets *sets[2] = {NULL, NULL};
    Picture with[2], without;
    uint64_t seed = 4711, pixels = (uint64_t)size * size;
    memset(with, 0, sizeof with);
    memset(&without, 0, sizeof without);
    EnfStatus status = enf_family_build(row->spec, &scene);
    if (status == ENF_OK)
        status = enf_scene_commit(scene);
    if (status == ENF_OK)
        status = enf_raycaster_create(scene, &r);
    if (status != ENF_OK) {
        enf_scene_destroy(scene);
        return status;
    }
    uint32_t *cells = malloc(sizeof *cells * scene->cell_count), cell_count = cells ? lit_cells(scene, cells) : 0;
    EnfLight *lights = malloc(sizeof *lights * row->lights);
    Picture *all[3] = {&with[0], &with[1], &without};
    int memory = cells && lights && cell_count;
    for (int i = 0; i < 3 && memory; i++) {
        all[i]->direct = malloc(3 * sizeof(float) * pixels);
        all[i]->lit = malloc(sizeof(uint16_t) * pixels);
        memory = all[i]->direct && all[i]->lit;
    }
    status = memory ? ENF_OK : ENF_ERROR_OUT_OF_MEMORY;
    if (status == ENF_OK)
        hang_lamps(scene, cells, cell_count, lights, row->lights);
    for (uint32_t m = 0; m < 2 && status == ENF_OK; m++)
        status = enf_light_sets_create(scene, lights, row->lights, m, threads, &sets[m]);
    for (int i = 0; i < 3 && status == ENF_OK; i++) {
        EnfPreview *p = &all[i]->preview;
        *p = enf_default_preview();
        p->width = p->height = size;
        p->threads = threads;
        p->raycaster = r;
        p->lights = lights;
        p->light_count = row->lights;
        p->ambient_samples = 0;
        p->direct = all[i]->direct;
        p->lit = all[i]->lit;
    }
    uint64_t different = 0;
    for (uint32_t k = 0; k < pictures && status == ENF_OK; k++) {
        EnfCamera camera = random_camera(scene, cells, cell_count, &seed);
        status = shoot(&without, &camera, NULL);
        for (uint32_t m = 0; m < 2 && status == ENF_OK; m++) {
            status = shoot(&with[m], &camera, sets[m]);
            if (m == 0)
                for (uint64_t i = 0; i < pixels; i++)
                    different += memcmp(with[0].direct + 3 * i, without.direct + 3 * i, 3 * sizeof(float)) != 0;
            else
                different += memcmp(with[1].direct, without.direct, 3 * sizeof(float) * pixels) != 0;
        }
    }
    if (status == ENF_OK) {
        EnfLightSetsStats stats = enf_default_light_sets_stats(), region = stats;
        enf_light_sets_stats(sets[0], &stats);
        enf_light_sets_stats(sets[1], &region);
        double ratio = (double)without.preview.shadow_rays / (double)(with[0].preview.shadow_rays ? with[0].preview.shadow_rays : 1);
        printf("%-34s %5u  %8.1f  %9.2f  %9.1f  %9.1f  %6.1f  %9.0f  %9.0f  %6.1f  %llu\n", row->spec, row->lights,
               (double)stats.pairs / scene->cell_count, 1e3 * stats.wall_s,
               (double)without.preview.shadow_rays / (double)(pixels * pictures),
               (double)with[0].preview.shadow_rays / (double)(pixels * pictures), ratio, 1e3 * without.seconds / pictures,
               1e3 * with[0].seconds / pictures, without.seconds / with[0].seconds, (unsigned long long)different);
        if (csv)
            fprintf(csv, "%s,%u,%u,%llu,%llu,%.6f,%.6f,%llu,%llu,%.4f,%.6f,%.6f,%llu\n", row->spec, row->lights, scene->cell_count,
                    (unsigned long long)stats.pairs, (unsigned long long)region.pairs, stats.wall_s, region.wall_s,
                    (unsigned long long)without.preview.shadow_rays, (unsigned long long)with[0].preview.shadow_rays, ratio,
                    without.seconds / pictures, with[0].seconds / pictures, (unsigned long long)different);
        if (different)
            status = ENF_ERROR_INTERNAL;
    }
    for (int i = 0; i < 3; i++) {
        free(all[i]->direct);
        free(all[i]->lit);
    }
    free(cells);
    free(lights);
    enf_light_sets_destroy(sets[0]);
    enf_light_sets_destroy(sets[1]);
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    return status;
}

int enf_bench_lights(int argc, char **argv) {
    /* scene_family's offices: 46 rooms of one storey, a storey of 136, 13 of them */
    static const Row rows[] = {
        {"office:46,objects=0,windows=0", 55}, {"office:136,objects=0,windows=0", 199}, {"office:1755,objects=0,windows=0", 2557},
        {"office:46,objects=0", 55},           {"office:136,objects=0", 199},           {"office:1755,objects=0", 2557}};
    uint32_t size = 128, pictures = 8, threads = 1;
    FILE *csv = NULL;
    for (int i = 1; i < argc; i++) {
        if (i + 1 < argc && strcmp(argv[i], "--size") == 0)
            size = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (i + 1 < argc && strcmp(argv[i], "--pictures") == 0)
            pictures = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (i + 1 < argc && strcmp(argv[i], "--threads") == 0)
            threads = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (i + 1 < argc && strcmp(argv[i], "--csv") == 0) {
            csv = fopen(argv[++i], "w");
            if (!csv) {
                fprintf(stderr, "enfilade bench lights: %s can't be written\n", argv[i]);
                return ENF_EXIT_BAD_INPUT;
            }
        } else
            return enf_tool_usage("bench lights", "unknown option '%s'", argv[i]);
    }
    if (size < 1 || size > 4096 || pictures < 1)
        return enf_tool_usage("bench lights", "--size 1 to 4096, --pictures 1 or more");
    if (csv)
        fprintf(csv, "scene,lights,cells,pairs_beams,pairs_region,sets_s,sets_region_s,shadow_rays_all,shadow_rays_sets,ratio,all_s,sets_"
                     "image_s,different\n");
    printf("direct light, %u pictures of %u x %u, %u thread%s\n", pictures, size, size, threads, threads == 1 ? "" : "s");
    printf("%-34s %5s  %8s  %9s  %9s  %9s  %6s  %9s  %9s  %6s  %s\n", "scene", "lamps", "per cell", "sets ms", "rays/px", "with sets",
           "fewer", "ms", "with sets", "faster", "pixels that differ");
    EnfStatus status = ENF_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && status == ENF_OK; i++)
        status = measure(&rows[i], size, pictures, threads, csv);
    if (csv)
        fclose(csv);
    return status == ENF_OK ? ENF_EXIT_OK : enf_tool_fail(status);
}
