/* SPDX-License-Identifier: GPL-3.0-or-later
 * Arrays of rays: every method and instruction set against each other bit by bit and against the walk in doubles; edges, corners, far and
 * tiny scenes, openings that change, furniture. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "memory_kit.h"
#include "raycast/ray_kernel.h"
#include "moved_scene.h"
#include "scene/scene_data.h"
#include "scene_family.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT = 20000 };

typedef struct Rays {
    float o[3][COUNT], d[3][COUNT], limit[COUNT];
    uint32_t cell[COUNT];
} Rays;

typedef struct Hits {
    float distance[COUNT];
    uint32_t surface[COUNT], cell[COUNT];
    uint8_t portals[COUNT];
    float normal[3 * COUNT], uv[2 * COUNT];
} Hits;

static double unit(uint64_t *state) {
    uint64_t z = (*state += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return (double)((z ^ (z >> 31)) >> 11) * (1.0 / 9007199254740992.0);
}

static const double here[3] = {0, 0, 0};

/* A family's scene, turned, scaled, moved. */
static EnfScene *scene_at(const char *spec, double turn, double scale, const double move[3]) {
    EnfScene *scene = NULL, *copy;
    const Motion motion = {{{cos(turn), -sin(turn), 0}, {sin(turn), cos(turn), 0}, {0, 0, 1}}, scale, {move[0], move[1], move[2]}};
    assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_non_null(copy = moved_scene(scene, &motion));
    assert_int_equal(enf_scene_commit(copy), ENF_OK);
    enf_scene_destroy(scene);
    return copy;
}

static EnfRaycaster *raycaster_of(const EnfScene *scene) {
    EnfRaycaster *r = NULL;
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    return r;
}

static uint32_t random_cell(const EnfScene *scene, uint64_t *rng) {
    uint32_t c;
    do
        c = (uint32_t)(unit(rng) * scene->cell_count);
    while (scene->cell_face_first[c] == scene->cell_face_first[c + 1]);
    return c;
}

static void random_rays(const EnfScene *scene, uint64_t *rng, Rays *rays) {
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t c = random_cell(scene, rng);
        double z = 2 * unit(rng) - 1, a = 6.2831853 * unit(rng), across = sqrt(1 - z * z);
        const double d[3] = {across * cos(a), across * sin(a), z};
        double at[3] = {0, 0, 0}, weights = 0;
        for (uint32_t v = scene->cell_vertex_first[c]; v < scene->cell_vertex_first[c + 1]; v++) {
            double w = 0.05 - log(unit(rng) + 1e-12);
            for (int k = 0; k < 3; k++)
                at[k] += w * (scene->cell_vertices[v][k] - scene->origin[k]);
            weights += w;
        }
        for (int k = 0; k < 3; k++) {
            rays->o[k][i] = (float)(at[k] / weights);
            rays->d[k][i] = (float)d[k];
        }
        rays->limit[i] = unit(rng) < 0.2 ? (float)(0.1 * scene->extent * unit(rng)) : INFINITY;
        rays->cell[i] = c;
    }
}

static EnfRayBatch batch_of(const Rays *rays) {
    EnfRayBatch batch = enf_default_ray_batch();
    batch.count = COUNT;
    batch.origin_x = rays->o[0], batch.origin_y = rays->o[1], batch.origin_z = rays->o[2];
    batch.direction_x = rays->d[0], batch.direction_y = rays->d[1], batch.direction_z = rays->d[2];
    batch.max_distance = rays->limit;
    batch.cell = rays->cell;
    batch.threads = 1;
    return batch;
}

static void shoot(const EnfRaycaster *r, const EnfRayBatch *batch, Hits *out) {
    EnfRayHits hits = enf_default_ray_hits();
    hits.distance = out->distance;
    hits.surface = out->surface;
    hits.cell = out->cell;
    hits.portals = out->portals;
    hits.normal = out->normal;
    hits.uv = out->uv;
    assert_int_equal(enf_raycast_closest(r, batch, &hits), ENF_OK);
}

static EnfRayHit reference(const EnfRaycaster *r, const Rays *rays, uint32_t i) {
    double origin[3];
    enf_raycaster_origin(r, origin);
    EnfRay ray = {{origin[0] + rays->o[0][i], origin[1] + rays->o[1][i], origin[2] + rays->o[2][i]},
                  {rays->d[0][i], rays->d[1][i], rays->d[2][i]},
                  rays->limit[i],
                  rays->cell[i],
                  0};
    EnfRayHit hit;
    assert_int_equal(enf_raycast_rays(r, &ray, 1, &hit), ENF_OK);
    return hit;
}

static const char *const scenes[] = {
    "office:46,objects=0,closed=0.3", "office:200,objects=0,windows=0", "ring:40", "columns:8", "grid:5,storeys=3", "hub:60", "facade:7",
    "town:2,objects=0,garden=0"};
enum { SCENES = sizeof scenes / sizeof *scenes };

/* Far fewer: rays that meet an edge within rounding. */
static void arrays_agree_with_the_walk_in_doubles(void **state) {
    (void)state;
    Rays *rays = malloc(sizeof *rays);
    Hits *hits = malloc(sizeof *hits);
    uint64_t rng = 7;
    for (int s = 0; s < SCENES; s++)
        for (int turned = 0; turned < 2; turned++) {
            EnfScene *scene = scene_at(scenes[s], 0.3 * turned, 1, here);
            EnfRaycaster *r = raycaster_of(scene);
            uint32_t odd = 0;
            random_rays(scene, &rng, rays);
            EnfRayBatch batch = batch_of(rays);
            shoot(r, &batch, hits);
            for (uint32_t i = 0; i < COUNT; i++) {
                EnfRayHit hit = reference(r, rays, i);
                if (hit.surface != hits->surface[i] || hit.cell != hits->cell[i]) {
                    odd++;
                    continue;
                }
                assert_int_equal(hits->portals[i], hit.portals < 255 ? hit.portals : 255);
                if (hit.surface != ENF_NONE)
                    assert_true(fabs(hit.distance - hits->distance[i]) <= 2e-5 * hit.distance + 1e-6 * scene->extent);
                else
                    assert_true(hits->distance[i] == INFINITY);
            }
            assert_true(odd <= 3);
            enf_raycaster_destroy(r);
            enf_scene_destroy(scene);
        }
    free(rays);
    free(hits);
}

static void every_instruction_set_gives_the_same_bits(void **state) {
    (void)state;
    uint32_t has = enf_ray_simd();
    if (has < ENF_SIMD_AVX2)
        print_message("[  NOTE    ] %s no AVX2: not compared\n", enf_ray_kernel_avx2 ? "this processor has" : "built with");
    if (has < ENF_SIMD_AVX512)
        print_message("[  NOTE    ] %s no AVX-512: not compared\n", enf_ray_kernel_avx512 ? "this processor has" : "built with");
    Rays *rays = malloc(sizeof *rays);
    Hits *plain = calloc(1, sizeof *plain), *wide = calloc(1, sizeof *wide);
    uint64_t rng = 11;
    for (int s = 0; s < SCENES; s++) {
        EnfScene *scene = scene_at(scenes[s], 0.3, 1, here);
        EnfRaycaster *r = raycaster_of(scene);
        random_rays(scene, &rng, rays);
        EnfRayBatch batch = batch_of(rays);
        for (batch.method = ENF_RAYS_SINGLE; batch.method <= ENF_RAYS_WAVES; batch.method++)
            for (uint32_t simd = ENF_SIMD_AVX2; simd <= has; simd++) {
                batch.simd = ENF_SIMD_NONE;
                shoot(r, &batch, plain);
                batch.simd = simd;
                shoot(r, &batch, wide);
                assert_memory_equal(plain, wide, sizeof *plain);
            }
        enf_raycaster_destroy(r);
        enf_scene_destroy(scene);
    }
    free(rays);
    free(plain);
    free(wide);
}

static void every_method_and_any_threads_give_the_same_hits(void **state) {
    (void)state;
    Rays *rays = malloc(sizeof *rays);
    Hits *one = calloc(1, sizeof *one), *other = calloc(1, sizeof *other);
    uint64_t rng = 13;
    EnfScene *scene = scene_at(scenes[0], 0.3, 1, here);
    EnfRaycaster *r = raycaster_of(scene);
    random_rays(scene, &rng, rays);
    EnfRayBatch batch = batch_of(rays);
    batch.method = ENF_RAYS_SINGLE;
    shoot(r, &batch, one);
    for (batch.method = ENF_RAYS_AUTO; batch.method <= ENF_RAYS_WAVES; batch.method++) {
        batch.threads = 1 + batch.method;
        batch.coherent = batch.method == ENF_RAYS_AUTO;
        batch.cell = batch.method == ENF_RAYS_WAVES ? NULL : rays->cell; /* found */
        shoot(r, &batch, other);
        assert_memory_equal(one, other, sizeof *one);
    }
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    free(rays);
    free(one);
    free(other);
}

/* 200,000 rays that meet corners and edges to the last bit or nearly: none goes through a wall of a closed building, none goes round. */
static void rays_at_corners_and_edges_find_a_wall(void **state) {
    (void)state;
    Rays *rays = malloc(sizeof *rays);
    Hits *hits = malloc(sizeof *hits);
    uint64_t rng = 17;
    uint32_t odd = 0;
    for (int round = 0; round < 10; round++) {
        EnfScene *scene = scene_at(round % 2 ? "office:60,objects=0,windows=0" : "ring:30", round % 4 < 2 ? 0.3 : 0, 1, here);
        EnfRaycaster *r = raycaster_of(scene);
        random_rays(scene, &rng, rays);
        for (uint32_t i = 0; i < COUNT; i++) { /* aimed at a corner of its own cell, or between two */
            uint32_t c = rays->cell[i], first = scene->cell_vertex_first[c], n = scene->cell_vertex_first[c + 1] - first;
            const double *a = scene->cell_vertices[first + (uint32_t)(unit(&rng) * n)],
                         *b = scene->cell_vertices[first + (uint32_t)(unit(&rng) * n)];
            double t = i % 2 ? unit(&rng) : 0;
            for (int k = 0; k < 3; k++)
                rays->d[k][i] = (float)(a[k] + t * (b[k] - a[k]) - scene->origin[k]) - rays->o[k][i];
            rays->limit[i] = INFINITY;
        }
        EnfRayBatch batch = batch_of(rays);
        batch.method = round % 3 ? ENF_RAYS_WAVES : ENF_RAYS_PACKETS16;
        shoot(r, &batch, hits);
        for (uint32_t i = 0; i < COUNT; i++) {
            assert_int_not_equal(hits->surface[i], ENF_NONE); /* no hole */
            /* it ends where it aims or, past an edge by rounding, beyond; never before */
            odd += hits->distance[i] < 1 - 1e-4;
        }
        enf_raycaster_destroy(r);
        enf_scene_destroy(scene);
    }
    assert_true(odd <= 40);
    free(rays);
    free(hits);
}

static void upright_rays_find_floor_and_ceiling(void **state) {
    (void)state;
    EnfScene *scene = scene_at("office:46,objects=0,windows=0", 0.3, 1, here);
    EnfRaycaster *r = raycaster_of(scene);
    Rays *rays = malloc(sizeof *rays);
    Hits *hits = malloc(sizeof *hits);
    uint64_t rng = 19;
    random_rays(scene, &rng, rays);
    for (uint32_t i = 0; i < COUNT; i++) {
        rays->d[0][i] = rays->d[1][i] = 0;
        rays->d[2][i] = i % 2 ? 1.0f : -1.0f;
        rays->limit[i] = INFINITY;
    }
    EnfRayBatch batch = batch_of(rays);
    for (batch.method = ENF_RAYS_SINGLE; batch.method <= ENF_RAYS_WAVES; batch.method++) {
        shoot(r, &batch, hits);
        for (uint32_t i = 0; i < COUNT; i++) {
            const double *box = scene->cell_bounds[rays->cell[i]];
            double way = i % 2 ? box[5] - scene->origin[2] - rays->o[2][i] : rays->o[2][i] - (box[2] - scene->origin[2]);
            assert_true(fabs(hits->distance[i] - way) < 1e-5);
            assert_true(hits->normal[3 * i + 2] == (i % 2 ? -1.0f : 1.0f));
        }
    }
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    free(rays);
    free(hits);
}

static void bad_rays_hit_nothing_in_no_cell(void **state) {
    (void)state;
    EnfScene *scene = scene_at("ring:8", 0, 1, here);
    EnfRaycaster *r = raycaster_of(scene);
    Rays *rays = calloc(1, sizeof *rays);
    Hits *hits = malloc(sizeof *hits);
    uint64_t rng = 23;
    random_rays(scene, &rng, rays);
    rays->o[0][0] = NAN;
    rays->d[1][1] = NAN;
    rays->d[0][2] = INFINITY;
    rays->d[0][3] = rays->d[1][3] = rays->d[2][3] = 0;
    rays->cell[4] = 1000000;
    rays->limit[5] = NAN;
    EnfRayBatch batch = batch_of(rays);
    for (batch.method = ENF_RAYS_SINGLE; batch.method <= ENF_RAYS_WAVES; batch.method++) {
        shoot(r, &batch, hits);
        for (uint32_t i = 0; i < 6; i++)
            assert_int_equal(hits->surface[i], ENF_NONE);
        for (uint32_t i = 0; i < 5; i++)
            assert_int_equal(hits->cell[i], ENF_NONE);
    }
    batch.struct_size = 3;
    EnfRayHits out = enf_default_ray_hits();
    assert_int_equal(enf_raycast_closest(r, &batch, &out), ENF_ERROR_INVALID_ARGUMENT);
    batch = batch_of(rays);
    batch.origin_y = NULL;
    assert_int_equal(enf_raycast_closest(r, &batch, &out), ENF_ERROR_INVALID_ARGUMENT);
    batch = batch_of(rays);
    batch.method = 77;
    assert_int_equal(enf_raycast_closest(r, &batch, &out), ENF_ERROR_INVALID_ARGUMENT);
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    free(rays);
    free(hits);
}

/* The same building in millimetres, in kilometres, and far from the origin. */
static void size_and_place_change_nothing(void **state) {
    (void)state;
    static const double scales[] = {1e-3, 1e3, 1, 1};
    static const double moves[][3] = {{0, 0, 0}, {0, 0, 0}, {1e7, -1e7, 0}, {5e5, 5e6, 100}};
    Rays *rays = malloc(sizeof *rays), *other = malloc(sizeof *other);
    Hits *one = malloc(sizeof *one), *two = malloc(sizeof *two);
    uint64_t rng = 29;
    EnfScene *scene = scene_at("office:60,objects=0,windows=0", 0.3, 1, here);
    EnfRaycaster *r = raycaster_of(scene);
    random_rays(scene, &rng, rays);
    EnfRayBatch batch = batch_of(rays);
    shoot(r, &batch, one);
    for (int s = 0; s < 4; s++) {
        EnfScene *copy = scene_at("office:60,objects=0,windows=0", 0.3, scales[s], moves[s]);
        EnfRaycaster *far = raycaster_of(copy);
        uint32_t odd = 0;
        memcpy(other, rays, sizeof *rays);
        for (uint32_t i = 0; i < COUNT; i++) {
            for (int k = 0; k < 3; k++)
                other->o[k][i] *= (float)scales[s];
            other->limit[i] *= (float)scales[s];
        }
        batch = batch_of(other);
        shoot(far, &batch, two);
        for (uint32_t i = 0; i < COUNT; i++) {
            double wanted = one->distance[i] * scales[s];
            odd += one->surface[i] != two->surface[i] || one->cell[i] != two->cell[i];
            if (one->surface[i] == two->surface[i] && one->surface[i] != ENF_NONE)
                assert_true(fabs(wanted - two->distance[i]) <= 3e-5 * wanted + 2e-6 * copy->extent);
        }
        assert_true(odd <= 3);
        enf_raycaster_destroy(far);
        enf_scene_destroy(copy);
    }
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    free(rays);
    free(other);
    free(one);
    free(two);
}

static void doors_are_followed_when_they_close(void **state) {
    (void)state;
    EnfScene *scene = scene_at("office:46,objects=0,windows=0", 0.3, 1, here);
    EnfRaycaster *r = raycaster_of(scene);
    Rays *rays = malloc(sizeof *rays);
    Hits *open = malloc(sizeof *open), *shut = malloc(sizeof *shut), *again = malloc(sizeof *again);
    uint64_t rng = 31;
    uint32_t leaves = 0;
    random_rays(scene, &rng, rays);
    EnfRayBatch batch = batch_of(rays);
    shoot(r, &batch, open);
    for (uint32_t o = 0; o < scene->opening_count; o++)
        assert_int_equal(enf_scene_set_opening_state(scene, o, ENF_STATE_CLOSED), ENF_OK);
    shoot(r, &batch, shut);
    for (uint32_t o = 0; o < scene->opening_count; o++)
        assert_int_equal(enf_scene_set_opening_state(scene, o, ENF_STATE_OPEN), ENF_OK);
    shoot(r, &batch, again);
    for (uint32_t i = 0; i < COUNT; i++) {
        assert_int_equal(shut->portals[i], 0);
        leaves += shut->surface[i] != ENF_NONE && shut->surface[i] >= enf_raycaster_face_count(r);
    }
    assert_true(leaves > 100);
    assert_memory_equal(open->surface, again->surface, sizeof open->surface);
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    free(rays);
    free(open);
    free(shut);
    free(again);
}

static void shadows_with_and_without_the_lights_cell_agree(void **state) {
    (void)state;
    EnfScene *scene = scene_at("office:46,objects=0,windows=0", 0.3, 1, here);
    EnfRaycaster *r = raycaster_of(scene);
    Rays *rays = malloc(sizeof *rays);
    uint8_t *with = malloc(COUNT), *without = malloc(COUNT);
    uint32_t *target = malloc(COUNT * sizeof *target);
    uint64_t rng = 37;
    uint32_t lit = 0;
    random_rays(scene, &rng, rays);
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t light = i % 3 ? rays->cell[i] : random_cell(scene, &rng);
        for (int k = 0; k < 3; k++)
            rays->d[k][i] = (float)(scene->cell_centres[light][k] - scene->origin[k]) - rays->o[k][i];
        rays->limit[i] = 1;
        target[i] = light;
    }
    EnfRayBatch batch = batch_of(rays);
    for (batch.method = ENF_RAYS_SINGLE; batch.method <= ENF_RAYS_WAVES; batch.method++) {
        batch.target_cell = NULL;
        assert_int_equal(enf_raycast_any(r, &batch, without), ENF_OK);
        batch.target_cell = target;
        assert_int_equal(enf_raycast_any(r, &batch, with), ENF_OK);
        assert_memory_equal(with, without, COUNT);
    }
    for (uint32_t i = 0; i < COUNT; i++) {
        EnfRayHit hit = reference(r, rays, i);
        assert_int_equal(with[i], hit.surface != ENF_NONE);
        lit += !with[i];
    }
    assert_true(lit > COUNT / 2 && lit < COUNT);
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    free(rays);
    free(with);
    free(without);
    free(target);
}

/* Upright squares across random rays' ways, tested one by one. */
static void furniture_stops_rays_where_it_stands(void **state) {
    (void)state;
    enum { SQUARES = 400 };
    EnfScene *scene = scene_at("office:46,objects=0", 0.3, 1, here);
    EnfRaycaster *r = raycaster_of(scene);
    Rays *rays = malloc(sizeof *rays);
    Hits *walls = malloc(sizeof *walls), *all = malloc(sizeof *all);
    double(*corners)[4][3] = malloc(SQUARES * sizeof *corners);
    uint64_t rng = 41;
    uint32_t stopped = 0, glass;
    EnfTriangles *triangles = NULL;
    const EnfMaterial pane = {ENF_MATERIAL_GLASS, {1, 1, 1}, {0, 0, 0}, 1};
    assert_int_equal(enf_triangles_create(scene->origin, &triangles), ENF_OK);
    assert_int_equal(enf_triangles_add_material(triangles, &pane, &glass), ENF_OK);
    random_rays(scene, &rng, rays);
    EnfRayBatch batch = batch_of(rays);
    shoot(r, &batch, walls);
    for (uint32_t s = 0; s < SQUARES; s++) {
        static const uint32_t two[6] = {0, 1, 2, 0, 2, 3};
        uint32_t c = random_cell(scene, &rng);
        double a = 6.28 * unit(&rng), size = 0.2 + 0.4 * unit(&rng);
        for (int i = 0; i < 4; i++) {
            double u = i == 1 || i == 2 ? size : -size, v = i >= 2 ? size : -size;
            corners[s][i][0] = scene->cell_centres[c][0] + u * cos(a);
            corners[s][i][1] = scene->cell_centres[c][1] + u * sin(a);
            corners[s][i][2] = scene->cell_centres[c][2] + v;
        }
        const uint32_t materials[2] = {s % 2 ? glass : 0, s % 2 ? glass : 0};
        assert_int_equal(enf_triangles_add_mesh(triangles, 1000 + s, corners[s][0], 4, 0, two, 2, materials, NULL), ENF_OK);
    }
    assert_int_equal(enf_raycaster_furnish(r, triangles), ENF_ERROR_STATE);
    if (enf_triangles_commit(triangles) == ENF_ERROR_IO) {
        print_message("[  SKIPPED ] %s\n", enf_last_error());
        goto done;
    }
    assert_int_equal(enf_raycaster_furnish(r, triangles), ENF_OK);
    shoot(r, &batch, all);
    uint8_t *blocked = malloc(COUNT);
    assert_int_equal(enf_raycast_any(r, &batch, blocked), ENF_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        double best = walls->surface[i] != ENF_NONE ? walls->distance[i] : rays->limit[i], shadow = INFINITY;
        uint32_t square = ENF_NONE;
        for (uint32_t s = 0; s < SQUARES; s++) {
            double n[3] = {0}, u[3], v[3], uu = 0, vv = 0, up = 0, speed = 0, ahead = 0;
            for (int k = 0; k < 3; k++) {
                u[k] = corners[s][1][k] - corners[s][0][k];
                v[k] = corners[s][3][k] - corners[s][0][k];
            }
            for (int k = 0; k < 3; k++) {
                n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
                speed += n[k] * rays->d[k][i];
                ahead += n[k] * (corners[s][0][k] - scene->origin[k] - rays->o[k][i]);
            }
            double t = ahead / speed;
            if (!(t > 0 && t < best))
                continue;
            for (int k = 0; k < 3; k++) {
                double p = rays->o[k][i] + t * rays->d[k][i] + scene->origin[k] - corners[s][0][k];
                uu += p * u[k];
                up += p * v[k];
                vv += u[k] * u[k];
            }
            if (uu < 0 || uu > vv || up < 0 || up > vv) /* squares: both sides are as long */
                continue;
            best = t;
            square = s;
            if (s % 2 == 0)
                shadow = t;
        }
        if (square == ENF_NONE) {
            assert_int_equal(all->surface[i], walls->surface[i]);
            assert_int_equal(all->cell[i], walls->cell[i]);
            assert_int_equal(blocked[i], walls->surface[i] != ENF_NONE);
            continue;
        }
        EnfSurface surface = enf_default_surface();
        stopped++;
        assert_int_equal(enf_raycaster_surface(r, all->surface[i], &surface), ENF_OK);
        assert_int_equal(surface.kind, ENF_SURFACE_FURNITURE);
        assert_int_equal(surface.object, 1000 + square);
        assert_true(fabs(all->distance[i] - best) < 1e-4);
        if (walls->surface[i] != ENF_NONE || shadow < INFINITY)
            assert_int_equal(blocked[i], 1);
        /* the cell it bounces in is the one that holds the hit */
        double p[3], around[6];
        for (int k = 0; k < 3; k++) {
            p[k] = rays->o[k][i] + (double)all->distance[i] * rays->d[k][i] + scene->origin[k];
            around[k] = scene->cell_bounds[all->cell[i]][k];
            around[3 + k] = scene->cell_bounds[all->cell[i]][3 + k];
            assert_true(p[k] > around[k] - 1e-3 && p[k] < around[3 + k] + 1e-3);
        }
    }
    assert_true(stopped > 500);
    batch.without_furniture = 1;
    shoot(r, &batch, all);
    assert_memory_equal(all, walls, sizeof *all);
    free(blocked);
done:
    enf_raycaster_destroy(r);
    enf_triangles_destroy(triangles);
    enf_scene_destroy(scene);
    free(rays);
    free(walls);
    free(all);
    free(corners);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_agree_with_the_walk_in_doubles),
        cmocka_unit_test(every_instruction_set_gives_the_same_bits),
        cmocka_unit_test(every_method_and_any_threads_give_the_same_hits),
        cmocka_unit_test(rays_at_corners_and_edges_find_a_wall),
        cmocka_unit_test(upright_rays_find_floor_and_ceiling),
        cmocka_unit_test(bad_rays_hit_nothing_in_no_cell),
        cmocka_unit_test(size_and_place_change_nothing),
        cmocka_unit_test(doors_are_followed_when_they_close),
        cmocka_unit_test(shadows_with_and_without_the_lights_cell_agree),
        cmocka_unit_test(furniture_stops_rays_where_it_stands),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
