/* SPDX-License-Identifier: GPL-3.0-or-later
 * Occluders in a view: what a pixel shows is never hidden, what stands behind is. ENF_OCCLUSION_CAMERAS sets the number of
 * cameras a scene (default 40). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "scene/scene_data.h"
#include "level_camera.h"
#include "scene_family.h"
#include "sight_pixels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static EnfScene *family(const char *spec) {
    EnfScene *scene;
    if (enf_family_build(spec, &scene) != ENF_OK || enf_scene_commit(scene) != ENF_OK)
        fail_msg("%s: %s", spec, enf_last_error());
    return scene;
}

typedef struct Sets {
    uint8_t *cells, *objects;
    uint32_t object_count;
} Sets;

static Sets ask(const EnfScene *scene, EnfView *view, const EnfCamera *camera, uint32_t occluders, uint32_t simd) {
    EnfViewDef def = enf_default_view_def();
    EnfViewResult r = enf_default_view_result();
    def.occluders = occluders;
    def.outdoors = ENF_OUTDOORS_EXACT; /* what occluders are compared with */
    def.use_simd = simd;
    if (enf_view_query(view, camera, &def) != ENF_OK)
        fail_msg("%s", enf_last_error());
    assert_int_equal(enf_view_result(view, &r), ENF_OK);
    Sets s = {calloc(scene->cell_count + 1, 1), calloc(scene->object_count + 1, 1), r.object_count};
    for (uint32_t i = 0; i < r.cell_count; i++)
        s.cells[r.cells[i]] = 1;
    for (uint32_t i = 0; i < r.object_count; i++)
        s.objects[r.objects[i]] = 1;
    return s;
}

static void free_sets(Sets *s) {
    free(s->cells);
    free(s->objects);
}

/* An eye in the street or the room, in no box. */
static uint32_t free_eye(const EnfScene *scene, const SightWalker *walker, SightRng *rng, double eye[3]) {
    for (;;) {
        uint32_t cell = (uint32_t)(sight_next(rng) % scene->cell_count), found, located = 0;
        int inside = 0;
        if (!sight_point_in_cell(walker, rng, cell, 0, eye) || enf_scene_locate(scene, eye, &found, 1, &located) != ENF_OK || located != 1)
            continue;
        if (scene->cell_count == 1)
            eye[2] = 1 + 4 * sight_unit(rng);
        for (uint32_t o = 0; o < scene->object_count && !inside; o++) {
            const double *b = scene->objects[o].bounds;
            inside = eye[0] >= b[0] && eye[0] <= b[3] && eye[1] >= b[1] && eye[1] <= b[4] && eye[2] >= b[2] && eye[2] <= b[5];
        }
        if (!inside)
            return cell;
    }
}

static void judge(const char *spec, double least_hidden) {
    EnfScene *scene = family(spec);
    SightWalker *walker = sight_walker_create(scene);
    double(*boxes)[6] = malloc(sizeof *boxes * (scene->object_count + 1));
    for (uint32_t o = 0; o < scene->object_count; o++)
        memcpy(boxes[o], scene->objects[o].bounds, sizeof boxes[o]);
    SightPixels *pixels = sight_pixels_create(scene, walker, (const double(*)[6])boxes);
    EnfView *view;
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    SightRng rng = {77};
    uint32_t cameras = getenv("ENF_OCCLUSION_CAMERAS") ? (uint32_t)atoi(getenv("ENF_OCCLUSION_CAMERAS")) : 40;
    uint64_t rays = 0, missed = 0, kept_off = 0, kept_on = 0;
    for (uint32_t k = 0; k < cameras; k++) {
        double eye[3];
        uint32_t start = free_eye(scene, walker, &rng, eye);
        EnfCamera camera = level_camera(eye, 6.283185307179586 * sight_unit(&rng), 0.4 * sight_unit(&rng) - 0.2);
        camera.shift_x = k % 3 == 0 ? 0.1 : 0;
        if (k % 5 == 4) {
            camera.type = ENF_CAMERA_PANO;
            camera.angle_x = 6.283185307179586;
            camera.angle_y = 3.141592653589793;
        }
        Sets off = ask(scene, view, &camera, ENF_OCCLUDERS_OFF, 1), on = ask(scene, view, &camera, ENF_OCCLUDERS_ON, 1);
        Sets scalar = ask(scene, view, &camera, ENF_OCCLUDERS_ON, 0), chosen = ask(scene, view, &camera, ENF_OCCLUDERS_AUTO, 1);
        EnfViewStats stats = enf_default_view_stats();
        assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
        assert_memory_equal(on.objects, scalar.objects, scene->object_count);
        assert_memory_equal(on.cells, scalar.cells, scene->cell_count);
        assert_memory_equal(chosen.objects, stats.occluder_polygons ? on.objects : off.objects,
                            camera.type == ENF_CAMERA_PANO ? 0 : scene->object_count);
        for (uint32_t o = 0; o < scene->object_count; o++)
            assert_true(off.objects[o] >= on.objects[o]);
        for (uint32_t c = 0; c < scene->cell_count; c++)
            assert_true(off.cells[c] >= on.cells[c]);
        kept_off += off.object_count;
        kept_on += on.object_count;
        const double *m = camera.world_from_camera;
        for (int i = 0; i < 400; i++) {
            double d[3], x = 1.999 * sight_unit(&rng) - 0.9995, y = 1.999 * sight_unit(&rng) - 0.9995;
            double u = (x + 2 * camera.shift_x) * tan(0.78539816339744831), v = (y + 2 * camera.shift_y) * tan(0.51487212933832725);
            for (int c = 0; c < 3; c++)
                d[c] = camera.type == ENF_CAMERA_PANO ? 2 * sight_unit(&rng) - 1 : u * m[4 * c] + v * m[4 * c + 1] - m[4 * c + 2];
            uint32_t cell = ENF_NONE, object = sight_first_object(pixels, start, eye, d, &cell);
            if (object == ENF_NONE)
                continue;
            rays++;
            if (!on.objects[object] || !on.cells[cell]) {
                missed++;
                print_error("%s: camera %u, ray %d shows object %u in cell %u\n", spec, k, i, object, cell);
            }
        }
        free_sets(&off);
        free_sets(&on);
        free_sets(&scalar);
        free_sets(&chosen);
    }
    print_message("%s: %llu pixels, %llu missed; objects kept %.1f without, %.1f with occluders\n", spec, (unsigned long long)rays,
                  (unsigned long long)missed, (double)kept_off / cameras, (double)kept_on / cameras);
    assert_int_equal(missed, 0);
    assert_true(rays > 100 * cameras);
    assert_true((double)kept_on <= (1 - least_hidden) * (double)kept_off);
    enf_view_destroy(view);
    sight_pixels_destroy(pixels);
    sight_walker_destroy(walker);
    free(boxes);
    enf_scene_destroy(scene);
}

static void houses_hide_the_streets_behind_them(void **state) {
    (void)state;
    judge("city:12", 0.5);
}

static void furniture_hides_doors_and_what_lies_behind(void **state) {
    (void)state;
    judge("office:60,occluders=1,doors=0.6", 0.1);
    judge("hub:60,objects=6,occluders=1", 0.05);
}

/* Two rooms and a door; a wardrobe before the door. */
static void a_wardrobe_before_a_door_closes_it_to_sight(void **state) {
    (void)state;
    EnfScene *scene;
    EnfView *view;
    uint32_t object;
    const double wardrobe[6] = {4.2, 0.2, 0, 4.7, 2.5, 3};
    assert_int_equal(enf_family_build("enfilade:2", &scene), ENF_OK);
    assert_int_equal(enf_scene_add_object(scene, "wardrobe", wardrobe, &(uint32_t){0}, 1, ENF_NONE, &object), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    const double eye[3] = {1, 1.3, 1.6};
    EnfCamera camera = level_camera(eye, 0, 0);
    Sets before = ask(scene, view, &camera, ENF_OCCLUDERS_ON, 1);
    assert_true(before.cells[1]);
    free_sets(&before);
    assert_int_equal(enf_scene_set_occluder(scene, object, NULL, 0, NULL, 0), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    Sets hidden = ask(scene, view, &camera, ENF_OCCLUDERS_ON, 1), off = ask(scene, view, &camera, ENF_OCCLUDERS_OFF, 1);
    EnfViewStats stats = enf_default_view_stats();
    assert_true(off.cells[1]);
    assert_false(hidden.cells[1]);
    assert_true(hidden.objects[object]);
    free_sets(&off);
    free_sets(&hidden);
    /* Nearer than the near plane a renderer doesn't draw it. */
    camera.clip_near = 4;
    Sets clipped = ask(scene, view, &camera, ENF_OCCLUDERS_ON, 1);
    assert_true(clipped.cells[1]);
    assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
    free_sets(&clipped);
    camera.clip_near = 0;
    /* Several eyes see round it; orthographic cameras have no depth buffer: nothing is hidden by occluders. */
    EnfCamera ends[2] = {camera, camera};
    EnfViewDef def = enf_default_view_def();
    def.occluders = ENF_OCCLUDERS_ON;
    ends[1].world_from_camera[7] += 0.1;
    assert_int_equal(enf_view_query_union(view, ends, 2, 1, &def), ENF_OK);
    assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
    assert_int_equal(stats.occluder_polygons, 0);
    assert_int_equal(stats.cells, 3);
    /* A panel, not a box: the same, and it ends where its corners end. */
    const double panel[4][3] = {{4.5, 0.2, 0}, {4.5, 2.5, 0}, {4.5, 2.5, 3}, {4.5, 0.2, 3}};
    const double half[4][3] = {{4.5, 0.2, 0}, {4.5, 1.3, 0}, {4.5, 1.3, 3}, {4.5, 0.2, 3}};
    for (int k = 0; k < 2; k++) {
        assert_int_equal(enf_scene_set_occluder(scene, object, k ? half[0] : panel[0], 0, &(uint32_t){4}, 1), ENF_OK);
        assert_int_equal(enf_scene_commit(scene), ENF_OK);
        Sets s = ask(scene, view, &camera, ENF_OCCLUDERS_ON, 1);
        assert_int_equal(s.cells[1], k);
        free_sets(&s);
    }
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

static void bad_occluders_get_reasons(void **state) {
    (void)state;
    EnfScene *scene;
    const double bounds[6] = {0, 0, 0, 1, 1, 1};
    double panel[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}};
    uint32_t object, four = 4, two = 2, many = 65;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_object(scene, "box", bounds, NULL, 0, ENF_NONE, &object), ENF_OK);
    assert_int_equal(enf_scene_set_occluder(NULL, 0, NULL, 0, NULL, 0), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_scene_set_occluder(scene, 1, NULL, 0, NULL, 0), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_scene_set_occluder(scene, 0, NULL, 0, &four, 1), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_scene_set_occluder(scene, 0, panel[0], 0, &two, 1), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "polygon 0 has 2 corners"));
    assert_int_equal(enf_scene_set_occluder(scene, 0, panel[0], 0, &many, 1), ENF_ERROR_BAD_INPUT);
    panel[1][0] = 1.5;
    assert_int_equal(enf_scene_set_occluder(scene, 0, panel[0], 0, &four, 1), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "leaves the object's bounds"));
    panel[1][0] = NAN;
    assert_int_equal(enf_scene_set_occluder(scene, 0, panel[0], 0, &four, 1), ENF_ERROR_BAD_INPUT);
    enf_scene_destroy(scene);
}

static void occluders_go_through_files(void **state) {
    (void)state;
    static const char text[] =
        "{\"format\": \"enfilade-scene\", \"version\": 1, \"rooms\": [{\"name\": \"A\"}], \"cells\": [{\"room\": 0, \"vertices\": "
        "[[0,0,0],[4,0,0],[4,3,0],[0,3,0],[0,0,2.5],[4,0,2.5],[4,3,2.5],[0,3,2.5]]}], \"objects\": ["
        "{\"occluder\": \"bounds\", \"name\": \"a\", \"bounds\": [[0,0,0],[1,1,1]]},"
        "{\"name\": \"b\", \"bounds\": [[1,0,0],[2,1,1]], \"occluder\": [[[1,0,0],[2,0,0],[2,0,1]], [[1,1,0],[2,1,0],[2,1,1],[1,1,1]]], "
        "\"cells\": [0]}, {\"name\": \"c\", \"bounds\": [[0,0,0],[1,1,1]]}]}";
    const char *path = "test_occlusion.enf.json";
    EnfScene *scene = NULL;
    for (int again = 0; again < 2; again++) {
        EnfStatus status = again ? enf_scene_load(path, &scene) : enf_scene_load_memory(text, sizeof text - 1, &scene);
        if (status != ENF_OK)
            fail_msg("%s", enf_last_error());
        assert_int_equal(scene->occluder_count, 2);
        assert_int_equal(scene->occluders[0].whole, 1);
        assert_int_equal(scene->occluders[0].polygon_count, 6);
        assert_int_equal(scene->occluders[1].polygon_count, 2);
        assert_int_equal(scene->objects[2].occluder, ENF_NONE);
        const uint32_t *first = scene->occluder_corner_first + scene->occluders[1].polygon_first;
        assert_int_equal(first[1] - first[0], 3);
        assert_int_equal(first[2] - first[1], 4);
        assert_true(scene->occluder_corners[first[1]][1] == 1);
        if (!again)
            assert_int_equal(enf_scene_save_json(scene, path), ENF_OK);
        enf_scene_destroy(scene);
    }
    remove(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(houses_hide_the_streets_behind_them),
        cmocka_unit_test(furniture_hides_doors_and_what_lies_behind),
        cmocka_unit_test(a_wardrobe_before_a_door_closes_it_to_sight),
        cmocka_unit_test(bad_occluders_get_reasons),
        cmocka_unit_test(occluders_go_through_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
