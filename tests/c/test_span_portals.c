/* SPDX-License-Identifier: GPL-3.0-or-later
 * Pictures of windowed buildings: every pixel is written exactly once by spans (counted, not guessed from what stands there at the end),
 * and spans, tiles and packets draw the same, wherever the building stands and however large it is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "geometry/vec3.h"
#include "level_camera.h"
#include "memory_kit.h"
#include "moved_scene.h"
#include "raycast/ray_kernel.h"
#include "raycast/screen.h"
#include "scene/scene_data.h"
#include "scene_family.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 203, HEIGHT = 151, PIXELS = WIDTH * HEIGHT, VIEWS = 12 };

static const char *const scenes[] = {"office:46,objects=0", "columns:6", "ring:24", "facade:2", "court:4,objects=0,garden=0"};
/* scale, offset in metres, turn */
static const double places[][5] = {{1, 0, 0, 0, 0}, {1, 0, 0, 0, 0.3}, {1, 1e7, -1e7, 0, 0}, {1e-3, 0, 0, 0, 0.3}, {1e3, 0, 0, 0, 0}};
enum { SCENES = sizeof scenes / sizeof *scenes, PLACES_TRIED = sizeof places / sizeof *places };

static EnfScene *scene_at(const char *spec, const double place[5]) {
    const double c = cos(place[4]), s = sin(place[4]);
    const Motion motion = {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}, place[0], {place[1], place[2], place[3]}};
    EnfScene *scene = NULL, *copy;
    assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_non_null(copy = moved_scene(scene, &motion));
    assert_int_equal(enf_scene_commit(copy), ENF_OK);
    enf_scene_destroy(scene);
    return copy;
}

/* Somewhere in a walled cell, indoors or out. The same view for every place of one scene. */
static EnfCamera view_of(const EnfScene *scene, uint32_t view, double turn) {
    uint32_t c = view * 2654435761u % scene->cell_count;
    double eye[3];
    while (scene->cell_face_first[c] == scene->cell_face_first[c + 1])
        c = (c + 1) % scene->cell_count;
    const double *corner = scene->cell_vertices[scene->cell_vertex_first[c] + view % 4];
    for (int k = 0; k < 3; k++)
        eye[k] = scene->cell_centres[c][k] + 0.37 * (corner[k] - scene->cell_centres[c][k]);
    EnfCamera camera = level_camera(eye, 0.1 + 1.7 * view + turn, 0.4 * sin(view));
    camera.angle_x = 1.5;
    camera.angle_y = 1.2;
    return camera;
}

static void count_writes(float *depth, uint32_t *index, uint32_t count, float base, float slope, uint32_t value) {
    (void)depth, (void)base, (void)slope, (void)value;
    for (uint32_t i = 0; i < count; i++)
        index[i]++;
}

static void every_pixel_is_written_once(void **state) {
    (void)state;
    uint32_t *surfaces = malloc(PIXELS * sizeof *surfaces), *cells = malloc(PIXELS * sizeof *cells);
    RayKernel counting = *enf_ray_kernel(ENF_SIMD_BEST);
    counting.fill = count_writes;
    for (uint32_t s = 0; s < SCENES; s++)
        for (uint32_t p = 0; p < PLACES_TRIED; p++) {
            EnfScene *scene = scene_at(scenes[s], places[p]);
            EnfRaycaster *r = NULL;
            assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
            for (uint32_t view = 0; view < VIEWS; view++) {
                EnfCamera camera = view_of(scene, view, places[p][4]);
                EnfRaycastImage image = enf_default_raycast_image();
                Screen screen;
                uint32_t cell, found;
                const double eye[3] = {camera.world_from_camera[3], camera.world_from_camera[7], camera.world_from_camera[11]};
                image.width = WIDTH;
                image.height = HEIGHT;
                image.threads = 1 + view % 2;
                image.surface = surfaces;
                image.cell = cells;
                memset(surfaces, 0, PIXELS * sizeof *surfaces);
                memset(cells, 0, PIXELS * sizeof *cells);
                assert_int_equal(enf_screen_make(r, &camera, WIDTH, HEIGHT, &screen), ENF_OK);
                assert_int_equal(enf_scene_locate(scene, eye, &cell, 1, &found), ENF_OK);
                const ImageTask task = {r, &screen, &image, &counting, found ? cell : ENF_NONE};
                assert_int_equal(enf_image_by_spans(&task), ENF_OK);
                for (uint32_t i = 0; i < PIXELS; i++) {
                    assert_int_equal(surfaces[i], 1);
                    assert_int_equal(cells[i], 1);
                }
            }
            enf_raycaster_destroy(r);
            enf_scene_destroy(scene);
        }
    free(surfaces);
    free(cells);
}

/* Distances agree where names do; names differ only where an edge runs through a pixel's centre. */
static void all_ways_draw_the_same_wherever_the_building_stands(void **state) {
    (void)state;
    float *depth[3];
    uint32_t *surface[3];
    for (int m = 0; m < 3; m++) {
        depth[m] = malloc(PIXELS * sizeof *depth[m]);
        surface[m] = malloc(PIXELS * sizeof *surface[m]);
    }
    for (uint32_t s = 0; s < SCENES; s++)
        for (uint32_t p = 0; p < PLACES_TRIED; p++) {
            EnfScene *scene = scene_at(scenes[s], places[p]);
            EnfRaycaster *r = NULL;
            uint32_t others = 0;
            assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
            for (uint32_t view = 0; view < VIEWS; view++) {
                EnfCamera camera = view_of(scene, view, places[p][4]);
                for (uint32_t m = 0; m < 3; m++) {
                    EnfRaycastImage image = enf_default_raycast_image();
                    image.width = WIDTH;
                    image.height = HEIGHT;
                    image.method = m;
                    image.depth = depth[m];
                    image.surface = surface[m];
                    memset(surface[m], 0xEE, PIXELS * sizeof *surface[m]); /* what isn't written shows */
                    assert_int_equal(enf_raycast_image(r, &camera, &image), ENF_OK);
                }
                for (uint32_t i = 0; i < PIXELS; i++)
                    for (int m = 1; m < 3; m++) {
                        float a = depth[0][i], b = depth[m][i];
                        if (surface[m][i] != surface[0][i])
                            others++;
                        else
                            assert_true(a == b || fabsf(a - b) <= 1e-4f * fabsf(b) + 4e-6f * (float)scene->extent);
                    }
            }
            assert_in_range(others, 0, 2 * VIEWS * PIXELS / 20000); /* one in 20,000: single precision at the edges */
            enf_raycaster_destroy(r);
            enf_scene_destroy(scene);
        }
    for (int m = 0; m < 3; m++) {
        free(depth[m]);
        free(surface[m]);
    }
}

/* An eye on the corner of a cell: faces seen edge-on get what rounding leaves over, and nothing lies behind the eye. */
static void an_eye_in_planes_of_walls_sees_nothing_behind_it(void **state) {
    (void)state;
    enum { SIDE = 20 };
    float depth[SIDE * SIDE];
    EnfScene *scene = scene_at("facade:2", places[0]);
    EnfRaycaster *r = NULL;
    assert_int_equal(enf_raycaster_create(scene, &r), ENF_OK);
    for (uint32_t view = 0; view < 64; view++)
        for (uint32_t method = ENF_IMAGE_SPANS; method <= ENF_IMAGE_PACKETS; method++) {
            const double eye[3] = {0, 0, 2.75};
            EnfCamera camera = level_camera(eye, 0.1 * view, 0);
            EnfRaycastImage image = enf_default_raycast_image();
            camera.angle_x = camera.angle_y = 1.92;
            image.width = image.height = SIDE;
            image.method = method;
            image.depth = depth;
            assert_int_equal(enf_raycast_image(r, &camera, &image), ENF_OK);
            for (uint32_t i = 0; i < SIDE * SIDE; i++)
                assert_true(depth[i] >= 0);
        }
    enf_raycaster_destroy(r);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_is_written_once),
        cmocka_unit_test(all_ways_draw_the_same_wherever_the_building_stands),
        cmocka_unit_test(an_eye_in_planes_of_walls_sees_nothing_behind_it),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
