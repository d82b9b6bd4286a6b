/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rays through cells: against arithmetic done by hand, against the picture by span portals (another algorithm), and far from the origin. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "level_camera.h"
#include "memory_kit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 96 };

static uint32_t add_box(EnfScene *scene, uint32_t room, const double lo[3], const double hi[3]) {
    double v[8][3];
    uint32_t cell;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            v[i][k] = (i >> k) & 1 ? hi[k] : lo[k];
    assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, v[0], 8, 0, NULL, 0, NULL, &cell), ENF_OK);
    return cell;
}

/* Three rooms in a row along x, 4 m each, a door in each of the two walls between them; the second door can be closed. */
static EnfScene *three_rooms(const double offset[3], uint32_t second_door) {
    EnfScene *scene = NULL;
    uint32_t room, door, portal;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "row", ENF_ROOM_INTERIOR, &room), ENF_OK);
    assert_int_equal(enf_scene_add_opening(scene, "second", ENF_OPENING_DOOR, second_door, &door), ENF_OK);
    for (int i = 0; i < 3; i++)
        add_box(scene, room, (double[3]){offset[0] + 4 * i, offset[1], offset[2]},
                (double[3]){offset[0] + 4 * i + 4, offset[1] + 4, offset[2] + 3});
    for (int i = 0; i < 2; i++) {
        double x = offset[0] + 4 * i + 4, y = offset[1], z = offset[2];
        const double polygon[4][3] = {{x, y + 1, z}, {x, y + 2, z}, {x, y + 2, z + 2}, {x, y + 1, z + 2}};
        assert_int_equal(enf_scene_add_portal(scene, (uint32_t)i, (uint32_t)i + 1, polygon[0], 4, 0, i ? door : ENF_NONE, &portal), ENF_OK);
    }
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    return scene;
}

static const double nowhere[3] = {0, 0, 0};

static EnfRayHit shoot(const EnfScene *scene, const double from[3], const double to[3], double limit) {
    EnfRaycaster *r = NULL;
    EnfRayHit hit;
    EnfRay ray = {{from[0], from[1], from[2]}, {to[0] - from[0], to[1] - from[1], to[2] - from[2]}, limit, ENF_NONE, 0};
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    assert_int_equal(enf_raycast_rays(r, &ray, 1, &hit), ENF_OK);
    enf_raycaster_destroy(r);
    return hit;
}

static void a_ray_goes_through_open_doors_to_the_far_wall(void **state) {
    (void)state;
    EnfScene *scene = three_rooms(nowhere, ENF_STATE_OPEN);
    EnfRayHit hit = shoot(scene, (double[3]){1, 1.5, 1}, (double[3]){2, 1.5, 1}, INFINITY);
    assert_int_equal(hit.cell, 2);
    assert_int_equal(hit.portals, 2);
    assert_true(fabs(hit.distance - 11) < 1e-12);
    enf_scene_destroy(scene);
}

static void a_closed_door_and_a_wall_stop_it(void **state) {
    (void)state;
    EnfScene *scene = three_rooms(nowhere, ENF_STATE_CLOSED);
    EnfRayHit leaf = shoot(scene, (double[3]){1, 1.5, 1}, (double[3]){2, 1.5, 1}, INFINITY);
    EnfRayHit wall = shoot(scene, (double[3]){1, 2.5, 1}, (double[3]){2, 2.5, 1}, INFINITY);
    EnfRayHit lintel = shoot(scene, (double[3]){1, 1.5, 2.1}, (double[3]){2, 1.5, 2.1}, INFINITY);
    assert_true(fabs(leaf.distance - 7) < 1e-12);
    assert_int_equal(leaf.cell, 1);
    assert_int_equal(leaf.surface, 18 + 1); /* six faces a box, then the portals */
    assert_true(fabs(wall.distance - 3) < 1e-12);
    assert_true(fabs(lintel.distance - 3) < 1e-12);
    assert_int_equal(wall.cell, 0);
    enf_scene_destroy(scene);
}

static void a_limit_ends_it_on_the_way(void **state) {
    (void)state;
    EnfScene *scene = three_rooms(nowhere, ENF_STATE_OPEN);
    EnfRayHit hit = shoot(scene, (double[3]){1, 1.5, 1}, (double[3]){2, 1.5, 1}, 5);
    assert_int_equal(hit.cell, 1);
    assert_int_equal(hit.surface, ENF_NONE);
    assert_true(hit.distance == 5);
    enf_scene_destroy(scene);
}

static void bad_rays_hit_nothing(void **state) {
    (void)state;
    EnfScene *scene = three_rooms(nowhere, ENF_STATE_OPEN);
    EnfRayHit nan = shoot(scene, (double[3]){NAN, 1, 1}, (double[3]){2, 1, 1}, INFINITY);
    EnfRayHit zero = shoot(scene, (double[3]){1, 1, 1}, (double[3]){1, 1, 1}, INFINITY);
    EnfRayHit outside = shoot(scene, (double[3]){50, 1, 1}, (double[3]){2, 1, 1}, INFINITY);
    assert_int_equal(nan.surface, ENF_NONE);
    assert_int_equal(zero.surface, ENF_NONE);
    assert_int_equal(outside.cell, ENF_NONE);
    enf_scene_destroy(scene);
}

static EnfCamera camera_at(const double eye[3], double heading, double pitch) {
    EnfCamera camera = level_camera(eye, heading, pitch);
    camera.angle_x = 1.6;
    camera.angle_y = 1.1;
    return camera;
}

typedef struct Picture {
    float depth[HEIGHT * WIDTH];
    uint32_t surface[HEIGHT * WIDTH], cell[HEIGHT * WIDTH];
    uint8_t portals[HEIGHT * WIDTH];
    EnfRaycastImage image;
} Picture;

static Picture *take_picture(const EnfRaycaster *r, const EnfCamera *camera, uint32_t threads) {
    Picture *p = calloc(1, sizeof *p);
    p->image = enf_default_raycast_image();
    p->image.width = WIDTH;
    p->image.height = HEIGHT;
    p->image.threads = threads;
    p->image.depth = p->depth;
    p->image.surface = p->surface;
    p->image.cell = p->cell;
    p->image.portals = p->portals;
    memset(p->surface, 0xEE, sizeof p->surface); /* what isn't written shows */
    assert_int_equal(enf_raycast_image(r, camera, &p->image), ENF_OK);
    return p;
}

static EnfRay pixel_ray(const EnfCamera *camera, int x, int y) {
    const double *m = camera->world_from_camera;
    double w = 2 * tan(camera->angle_x / 2), h = 2 * tan(camera->angle_y / 2);
    double u = w * ((x + 0.5) / WIDTH - 0.5), v = h * (0.5 - (y + 0.5) / HEIGHT);
    EnfRay ray = {{m[3], m[7], m[11]}, {0, 0, 0}, INFINITY, ENF_NONE, 0};
    for (int k = 0; k < 3; k++)
        ray.direction[k] = m[4 * k] * u + m[4 * k + 1] * v - m[4 * k + 2];
    return ray;
}

/* Pictures agree with rays; where they don't, a ray a thousandth of a pixel beside agrees: an edge runs there. */
static void pictures_agree_with_rays_at(const double offset[3], uint32_t door) {
    EnfScene *scene = three_rooms(offset, door);
    EnfRaycaster *r = NULL;
    uint64_t edge_pixels = 0;
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    for (int view = 0; view < 24; view++) {
        const double eye[3] = {offset[0] + 0.5 + 0.45 * view, offset[1] + 0.3 + 0.13 * view, offset[2] + 0.4 + 0.09 * view};
        EnfCamera camera = camera_at(eye, 0.7 * view, 0.3 * sin(view));
        Picture *p = take_picture(r, &camera, 1);
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                EnfRay ray = pixel_ray(&camera, x, y);
                EnfRayHit hit;
                int i = y * WIDTH + x;
                assert_int_equal(enf_raycast_rays(r, &ray, 1, &hit), ENF_OK);
                if (hit.surface != p->surface[i] || hit.cell != p->cell[i]) {
                    edge_pixels++;
                    continue;
                }
                assert_int_equal(hit.portals, p->portals[i]);
                assert_true(fabs(hit.distance - p->depth[i]) <= 2e-6 * hit.distance);
            }
        free(p);
    }
    assert_true(edge_pixels < 24); /* of 368,640: a pixel centre on an edge to the last bit */
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
}

static void pictures_agree_with_rays(void **state) {
    (void)state;
    pictures_agree_with_rays_at(nowhere, ENF_STATE_OPEN);
    pictures_agree_with_rays_at(nowhere, ENF_STATE_CLOSED);
    pictures_agree_with_rays_at((double[3]){5e5, 5e6, 100}, ENF_STATE_OPEN); /* national grid */
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
    (void)state;
    EnfScene *scene = three_rooms(nowhere, ENF_STATE_OPEN);
    EnfRaycaster *r = NULL;
    EnfCamera camera = camera_at((double[3]){0.5, 1.4, 1.5}, 0.1, 0);
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    Picture *one = take_picture(r, &camera, 1), *four = take_picture(r, &camera, 4);
    assert_memory_equal(one->depth, four->depth, sizeof one->depth);
    assert_memory_equal(one->surface, four->surface, sizeof one->surface);
    assert_memory_equal(one->portals, four->portals, sizeof one->portals);
    assert_int_equal(one->image.spans, four->image.spans);
    free(one);
    free(four);
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
}

/* All ways to a picture, all instruction sets: one picture; and normal and place on the surface are what surface and depth say. */
static void every_way_to_a_picture_draws_the_same(void **state) {
    (void)state;
    EnfScene *scene = three_rooms((double[3]){5e5, 5e6, 100}, ENF_STATE_CLOSED);
    EnfRaycaster *r = NULL;
    float *normal = calloc(HEIGHT * WIDTH, 3 * sizeof *normal), *uv = calloc(HEIGHT * WIDTH, 2 * sizeof *uv);
    Picture *first = calloc(1, sizeof *first), *other = calloc(1, sizeof *other);
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    for (int view = 0; view < 6; view++) {
        const double eye[3] = {5e5 + 0.5 + 1.7 * view, 5e6 + 0.6 + 0.4 * view, 100.6 + 0.3 * view};
        EnfCamera camera = camera_at(eye, 1.1 * view, 0.5 * sin(view));
        for (uint32_t method = ENF_IMAGE_SPANS; method <= ENF_IMAGE_PACKETS; method++) {
            uint32_t unlike = 0;
            for (uint32_t simd = ENF_SIMD_NONE; simd <= ENF_SIMD_AVX512; simd++) {
                Picture *p = simd == ENF_SIMD_NONE ? first : other;
                p->image = enf_default_raycast_image();
                p->image.width = WIDTH;
                p->image.height = HEIGHT;
                p->image.depth = p->depth;
                p->image.surface = p->surface;
                p->image.cell = p->cell;
                p->image.portals = p->portals;
                p->image.normal = normal;
                p->image.uv = uv;
                p->image.method = method;
                p->image.simd = simd;
                assert_int_equal(enf_raycast_image(r, &camera, &p->image), ENF_OK);
                if (p == other) {
                    assert_memory_equal(first->depth, other->depth, sizeof first->depth);
                    assert_memory_equal(first->surface, other->surface, sizeof first->surface);
                    assert_memory_equal(first->cell, other->cell, sizeof first->cell);
                    assert_memory_equal(first->portals, other->portals, sizeof first->portals);
                }
            }
            for (int y = 0; y < HEIGHT; y++)
                for (int x = 0; x < WIDTH; x++) {
                    EnfRay ray = pixel_ray(&camera, x, y);
                    EnfSurface surface = enf_default_surface();
                    EnfRayHit hit;
                    int i = y * WIDTH + x;
                    double side = 0, along[2] = {0, 0};
                    assert_int_equal(enf_raycast_rays(r, &ray, 1, &hit), ENF_OK);
                    if (hit.surface != first->surface[i]) {
                        unlike++;
                        continue;
                    }
                    assert_true(fabs(hit.distance - first->depth[i]) <= 4e-6 * hit.distance);
                    assert_int_equal(enf_raycaster_surface(r, first->surface[i], &surface), ENF_OK);
                    for (int k = 0; k < 3; k++) {
                        double to = ray.origin[k] + hit.distance * ray.direction[k] - surface.point[k];
                        side += surface.normal[k] * ray.direction[k];
                        along[0] += to * surface.u[k];
                        along[1] += to * surface.v[k];
                    }
                    for (int k = 0; k < 3; k++)
                        assert_true(fabs(normal[3 * i + k] - (side > 0 ? -1 : 1) * surface.normal[k]) < 1e-6);
                    assert_true(fabs(uv[2 * i] - along[0]) < 1e-4 && fabs(uv[2 * i + 1] - along[1]) < 1e-4);
                }
            assert_true(unlike <= 3);
        }
    }
    free(normal);
    free(uv);
    free(first);
    free(other);
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
}

static void cameras_that_are_none_are_refused(void **state) {
    (void)state;
    EnfScene *scene = three_rooms(nowhere, ENF_STATE_OPEN);
    EnfRaycaster *r = NULL;
    EnfCamera camera = camera_at((double[3]){0.5, 1.4, 1.5}, 0.1, 0);
    EnfRaycastImage image = enf_default_raycast_image();
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    assert_int_equal(enf_raycast_image(r, &camera, &image), ENF_ERROR_INVALID_ARGUMENT); /* no size */
    image.width = image.height = 8;
    camera.world_from_camera[3] = NAN;
    assert_int_equal(enf_raycast_image(r, &camera, &image), ENF_ERROR_BAD_INPUT);
    camera = camera_at((double[3]){0.5, 1.4, 1.5}, 0.1, 0);
    camera.angle_x = 4;
    assert_int_equal(enf_raycast_image(r, &camera, &image), ENF_ERROR_BAD_INPUT);
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
}

/* Spans are written in whole cache lines: whatever the picture's width and wherever the buffers begin, nothing beside them is touched, and
 * the pixels are the same. */
static void spans_keep_to_their_buffers(void **state) {
    (void)state;
    enum { MARGIN = 32, MOST = 64 * 48 };
    EnfScene *scene = three_rooms((double[3]){0, 0, 0}, ENF_STATE_OPEN);
    EnfRaycaster *r = NULL;
    float *depth = malloc((MOST + 2 * MARGIN) * sizeof *depth), *wanted = malloc(MOST * sizeof *wanted);
    uint32_t *surface = malloc((MOST + 2 * MARGIN) * sizeof *surface);
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    EnfCamera camera = camera_at((double[3]){0.5, 0.6, 1.1}, 0.3, 0.1);
    for (uint32_t width = 1; width <= 64; width += width < 20 ? 1 : 11) {
        EnfRaycastImage image = enf_default_raycast_image();
        image.width = width;
        image.height = 48;
        image.simd = ENF_SIMD_NONE;
        image.depth = wanted;
        assert_int_equal(enf_raycast_image(r, &camera, &image), ENF_OK);
        for (image.simd = ENF_SIMD_NONE; image.simd <= ENF_SIMD_AVX512; image.simd++)
            for (uint32_t shift = 0; shift < 17; shift += 4 + image.simd) {
                uint32_t pixels = 48 * width;
                memset(depth, 0xEE, (MOST + 2 * MARGIN) * sizeof *depth);
                memset(surface, 0xEE, (MOST + 2 * MARGIN) * sizeof *surface);
                image.depth = depth + shift;
                image.surface = surface + shift;
                assert_int_equal(enf_raycast_image(r, &camera, &image), ENF_OK);
                assert_memory_equal(depth + shift, wanted, pixels * sizeof *wanted);
                for (uint32_t i = 0; i < MOST + 2 * MARGIN; i++)
                    assert_int_equal(surface[i] != 0xEEEEEEEEu, i >= shift && i < shift + pixels);
                for (uint32_t i = shift + pixels; i < MOST + 2 * MARGIN; i++)
                    assert_memory_equal(&depth[i], "\xEE\xEE\xEE\xEE", 4);
            }
    }
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
    free(depth);
    free(wanted);
    free(surface);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ray_goes_through_open_doors_to_the_far_wall),
        cmocka_unit_test(a_closed_door_and_a_wall_stop_it),
        cmocka_unit_test(a_limit_ends_it_on_the_way),
        cmocka_unit_test(bad_rays_hit_nothing),
        cmocka_unit_test(pictures_agree_with_rays),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
        cmocka_unit_test(spans_keep_to_their_buffers),
        cmocka_unit_test(every_way_to_a_picture_draws_the_same),
        cmocka_unit_test(cameras_that_are_none_are_refused),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
