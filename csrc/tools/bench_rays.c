/* SPDX-License-Identifier: GPL-3.0-or-later
 * Makes the rays: primary, random, bounced, to a light. */
#include "tools/bench_rays.h"

#include "geometry/vec3.h"
#include "raycast/ray_kernel.h"
#include "scene/scene_data.h"

#include <stdlib.h>

static uint64_t next_random(uint64_t *state) {
    uint64_t z = (*state += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
}
static double unit(uint64_t *state) {
    return (double)(next_random(state) >> 11) * (1.0 / 9007199254740992.0);
}

RaySet *ray_set_create(uint64_t room) {
    RaySet *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->room = room;
    float **floats[] = {&s->o[0], &s->o[1], &s->o[2], &s->d[0], &s->d[1], &s->d[2], &s->limit, &s->distance};
    uint32_t **numbers[] = {&s->cell, &s->target, &s->surface, &s->hit_cell};
    int ok = (s->blocked = calloc(room, 1)) != NULL;
    for (size_t i = 0; i < sizeof floats / sizeof *floats; i++)
        ok &= (*floats[i] = calloc(room, sizeof(float))) != NULL;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        ok &= (*numbers[i] = calloc(room, sizeof(uint32_t))) != NULL;
    if (ok)
        return s;
    ray_set_destroy(s);
    return NULL;
}

void ray_set_destroy(RaySet *s) {
    if (!s)
        return;
    for (int k = 0; k < 3; k++) {
        free(s->o[k]);
        free(s->d[k]);
    }
    free(s->limit);
    free(s->distance);
    free(s->cell);
    free(s->target);
    free(s->surface);
    free(s->hit_cell);
    free(s->blocked);
    free(s);
}

EnfRayBatch ray_set_batch(const RaySet *s) {
    EnfRayBatch batch = enf_default_ray_batch();
    batch.threads = 1;
    batch.count = s->count;
    batch.origin_x = s->o[0], batch.origin_y = s->o[1], batch.origin_z = s->o[2];
    batch.direction_x = s->d[0], batch.direction_y = s->d[1], batch.direction_z = s->d[2];
    batch.max_distance = s->limit;
    batch.cell = s->cell;
    batch.target_cell = s->target;
    return batch;
}

static int has_walls(const EnfScene *scene, uint32_t c) {
    return scene->cell_face_first[c] < scene->cell_face_first[c + 1];
}

/* A walled cell of a room; any walled one where there are no rooms, any with portals where there are no walls; or a walled one outdoors. */
static uint32_t random_cell(const EnfScene *scene, uint64_t *rng, int outdoors) {
    for (int attempt = 0; attempt < 10000; attempt++) {
        uint32_t c = (uint32_t)(unit(rng) * scene->cell_count);
        int room = has_walls(scene, c) && scene->cell_rooms[c] != ENF_NONE, last = attempt > 6000 && !outdoors;
        if (enf_is_exterior(scene, c) == outdoors &&
            (room || (has_walls(scene, c) && attempt > 3000) || (last && scene->cell_portal_first[c] < scene->cell_portal_first[c + 1])))
            return c;
    }
    return ENF_NONE;
}

/* Between the cell's centre and a point of its boundary. */
static void random_point(const EnfScene *scene, uint32_t c, uint64_t *rng, double out[3]) {
    double weights = 0;
    vec_set(out, 0, 0, 0);
    for (uint32_t i = scene->cell_vertex_first[c]; i < scene->cell_vertex_first[c + 1]; i++) {
        double w = -log(unit(rng) + 1e-12);
        vec_mad(out, out, w, scene->cell_vertices[i]);
        weights += w;
    }
    for (uint32_t s = scene->cell_portal_first[c]; s < scene->cell_portal_first[c + 1] && !has_walls(scene, c); s++) {
        uint32_t p = scene->cell_portals[s].portal; /* a cluster of a portal file: its shape isn't known, but it is convex */
        for (uint32_t i = scene->portal_vertex_first[p]; i < scene->portal_vertex_first[p + 1]; i++) {
            double w = -log(unit(rng) + 1e-12);
            vec_mad(out, out, w, scene->portal_vertices[i]);
            weights += w;
        }
    }
    vec_scale(out, 1 / weights, out);
    for (int k = 0; k < 3; k++)
        out[k] += 0.02 * (scene->cell_centres[c][k] - out[k]);
}

/* Bounds of all cells indoors; 0: there are none with walls. */
static int building_bounds(const EnfScene *scene, double bounds[6]) {
    for (int k = 0; k < 3; k++) {
        bounds[k] = INFINITY;
        bounds[3 + k] = -INFINITY;
    }
    for (uint32_t c = 0; c < scene->cell_count; c++)
        for (int k = 0; k < 3 && has_walls(scene, c) && !enf_is_exterior(scene, c); k++) {
            bounds[k] = fmin(bounds[k], scene->cell_bounds[c][k]);
            bounds[3 + k] = fmax(bounds[3 + k], scene->cell_bounds[c][3 + k]);
        }
    return bounds[0] < bounds[3];
}

int place_camera(const EnfScene *scene, uint64_t *rng, int outdoors, EnfCamera *camera, uint32_t *out_cell) {
    double eye[3], turn = 6.283185307179586 * unit(rng), pitch = 0.3 * (unit(rng) - 0.5), building[6];
    uint32_t c = random_cell(scene, rng, outdoors);
    if (c == ENF_NONE || (outdoors && !building_bounds(scene, building)))
        return 0;
    random_point(scene, c, rng, eye);
    if (outdoors) { /* where the building's storeys are, towards it */
        for (int attempt = 0; !(eye[2] > building[2] && eye[2] < building[5]); attempt++) {
            if (attempt == 10000 || (c = random_cell(scene, rng, 1)) == ENF_NONE)
                return 0;
            random_point(scene, c, rng, eye);
        }
        turn = atan2(0.5 * (building[1] + building[4]) - eye[1], 0.5 * (building[0] + building[3]) - eye[0]) + 0.3 * (unit(rng) - 0.5);
    }
    *camera = enf_default_camera();
    double cs = cos(turn), sn = sin(turn), cp = cos(pitch), sp = sin(pitch);
    const double forward[3] = {cs * cp, sn * cp, sp}, right[3] = {sn, -cs, 0}, up[3] = {-cs * sp, -sn * sp, cp};
    for (int k = 0; k < 3; k++) {
        camera->world_from_camera[4 * k] = right[k];
        camera->world_from_camera[4 * k + 1] = up[k];
        camera->world_from_camera[4 * k + 2] = -forward[k];
        camera->world_from_camera[4 * k + 3] = eye[k];
    }
    camera->angle_x = camera->angle_y = 1.3;
    uint32_t found; /* where cells overlap, the one that pictures start in too */
    return enf_scene_locate(scene, eye, out_cell, 1, &found) == ENF_OK && found > 0;
}

uint64_t primary_index(uint32_t size, uint32_t x, uint32_t y) {
    return ((uint64_t)(y / 4) * (size / 4) + x / 4) * 16 + (y % 4) * 4 + x % 4;
}

static void set_ray(RaySet *s, uint64_t i, const double o[3], const double d[3], double limit, uint32_t cell, uint32_t target) {
    for (int k = 0; k < 3; k++) {
        s->o[k][i] = (float)o[k];
        s->d[k][i] = (float)d[k];
    }
    s->limit[i] = (float)limit;
    s->cell[i] = cell;
    s->target[i] = target;
}

void primary_rays(const EnfScene *scene, const EnfRaycaster *r, const EnfCamera *camera, uint32_t cell, uint32_t size, RaySet *out) {
    const double *m = camera->world_from_camera;
    double origin[3], o[3], w = 2 * tan(camera->angle_x / 2), h = 2 * tan(camera->angle_y / 2);
    (void)scene;
    enf_raycaster_origin(r, origin);
    for (int k = 0; k < 3; k++)
        o[k] = m[4 * k + 3] - origin[k];
    out->count = (uint64_t)size * size;
    for (uint32_t y = 0; y < size; y++)
        for (uint32_t x = 0; x < size; x++) {
            double u = w * ((x + 0.5) / size - 0.5), v = h * (0.5 - (y + 0.5) / size), d[3];
            for (int k = 0; k < 3; k++)
                d[k] = m[4 * k] * u + m[4 * k + 1] * v - m[4 * k + 2];
            set_ray(out, primary_index(size, x, y), o, d, INFINITY, cell, ENF_NONE);
        }
}

static void random_direction(uint64_t *rng, double d[3]) {
    double z = 2 * unit(rng) - 1, a = 6.283185307179586 * unit(rng), across = sqrt(1 - z * z);
    vec_set(d, across * cos(a), across * sin(a), z);
}

void random_rays(const EnfScene *scene, const EnfRaycaster *r, uint64_t *rng, RaySet *out) {
    double origin[3];
    enf_raycaster_origin(r, origin);
    out->count = out->room;
    for (uint64_t i = 0; i < out->count; i++) {
        double o[3], d[3];
        uint32_t c = random_cell(scene, rng, 0);
        random_point(scene, c, rng, o);
        vec_sub(o, o, origin);
        random_direction(rng, d);
        set_ray(out, i, o, d, INFINITY, c, ENF_NONE);
    }
}

void bounce_rays(const EnfScene *scene, const EnfRaycaster *r, const RaySet *from, uint64_t *rng, RaySet *out) {
    double origin[3];
    uint64_t n = 0;
    enf_raycaster_origin(r, origin);
    for (uint64_t i = 0; i < from->count; i++) {
        EnfSurface surface = enf_default_surface();
        double o[3], d[3], side = 0, inwards[3];
        if (from->surface[i] == ENF_NONE || enf_raycaster_surface(r, from->surface[i], &surface) != ENF_OK)
            continue;
        for (int k = 0; k < 3; k++) {
            side += surface.normal[k] * from->d[k][i];
            inwards[k] = scene->cell_centres[from->hit_cell[i]][k] - origin[k] - from->o[k][i] - (double)from->distance[i] * from->d[k][i];
        }
        vec_normalize(inwards);
        random_direction(rng, d);
        for (int k = 0; k < 3; k++) {
            double normal = side > 0 ? -surface.normal[k] : surface.normal[k];
            /* a millimetre off this wall, and off the next where the hit is in a corner: no tracer starts behind one */
            o[k] = from->o[k][i] + (double)from->distance[i] * from->d[k][i] + 1e-3 * (normal + inwards[k]);
            d[k] += 1.0001 * normal;
        }
        vec_normalize(d);
        set_ray(out, n++, o, d, INFINITY, from->hit_cell[i], ENF_NONE);
    }
    out->count = n;
}

void shadow_rays(const EnfScene *scene, const EnfRaycaster *r, const RaySet *from, uint32_t light, RaySet *out) {
    double origin[3], lamp[3];
    uint64_t n = 0;
    enf_raycaster_origin(r, origin);
    vec_sub(lamp, scene->cell_centres[light], origin);
    lamp[2] += 0.4 * (scene->cell_bounds[light][5] - scene->cell_bounds[light][2]);
    for (uint64_t i = 0; i < from->count; i++) {
        EnfSurface surface = enf_default_surface();
        double o[3], d[3], side = 0;
        if (from->surface[i] == ENF_NONE || enf_raycaster_surface(r, from->surface[i], &surface) != ENF_OK)
            continue;
        for (int k = 0; k < 3; k++)
            side += surface.normal[k] * from->d[k][i];
        for (int k = 0; k < 3; k++)
            o[k] = from->o[k][i] + (double)from->distance[i] * from->d[k][i] + (side > 0 ? -1e-3 : 1e-3) * surface.normal[k];
        vec_sub(d, lamp, o);
        set_ray(out, n++, o, d, 1, from->hit_cell[i], light);
    }
    out->count = n;
}

Picture *picture_create(uint32_t width, uint32_t height) {
    Picture *p = calloc(1, sizeof *p);
    size_t n = (size_t)width * height;
    if (!p)
        return NULL;
    p->width = width;
    p->height = height;
    p->depth = malloc(n * sizeof *p->depth);
    p->surface = malloc(n * sizeof *p->surface);
    p->normal = malloc(3 * n * sizeof *p->normal);
    p->uv = malloc(2 * n * sizeof *p->uv);
    if (p->depth && p->surface && p->normal && p->uv)
        return p;
    picture_destroy(p);
    return NULL;
}

void picture_destroy(Picture *p) {
    if (!p)
        return;
    free(p->depth);
    free(p->surface);
    free(p->normal);
    free(p->uv);
    free(p);
}

EnfRaycastImage picture_request(const Picture *p, uint32_t all_buffers) {
    EnfRaycastImage image = enf_default_raycast_image();
    image.width = p->width;
    image.height = p->height;
    image.threads = 1;
    image.depth = p->depth;
    image.surface = p->surface;
    image.normal = all_buffers ? p->normal : NULL;
    image.uv = all_buffers ? p->uv : NULL;
    return image;
}

void picture_memset(Picture *p) {
    size_t n = (size_t)p->width * p->height;
    memset(p->depth, 0x3F, n * sizeof *p->depth);
    memset(p->surface, 0x3F, n * sizeof *p->surface);
}

uint64_t picture_check(const EnfRaycaster *r, const EnfCamera *camera, const RaySet *rays, Picture *p, uint64_t *unwritten,
                       uint64_t *differing) {
    static const uint32_t methods[] = {ENF_IMAGE_PACKETS, ENF_IMAGE_TILES, ENF_IMAGE_SPANS};
    uint64_t patched = 0;
    for (int k = 0; k < 3; k++) {
        EnfRaycastImage image = picture_request(p, 0);
        image.method = methods[k];
        memset(p->surface, 0xEE, (size_t)p->width * p->height * sizeof *p->surface);
        if (enf_raycast_image(r, camera, &image) != ENF_OK)
            continue;
        patched += image.patched;
        for (uint32_t y = 0; y < p->height; y++)
            for (uint32_t x = 0; x < p->width; x++) {
                size_t i = (size_t)y * p->width + x;
                double a = p->depth[i], b = rays->distance[primary_index(p->width, x, y)];
                *unwritten += p->surface[i] == 0xEEEEEEEEu;
                *differing += !(a == b || fabs(a - b) <= 1e-4 * b + 2e-5);
            }
    }
    return patched;
}

uint32_t bench_simd(void) {
    return enf_ray_simd();
}
