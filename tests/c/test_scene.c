/* SPDX-License-Identifier: GPL-3.0-or-later
 * Scenes: adding, committing, orientation, locating, saving; on tiny scenes whose answers are plain to see.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "memory_kit.h"
#include "base/file.h"
#include "base/memory.h"
#include "geometry/convex_hull.h"
#include "geometry/vec3.h"
#include "scene/scene_data.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t seed = 11;
static double random_unit(void) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) / 9007199254740992.0;
}

static uint32_t add_box(EnfScene *s, uint32_t room, double x0, double x1, double y0, double y1) {
    double v[8][3];
    uint32_t cell;
    for (int i = 0; i < 8; i++)
        vec_set(v[i], i & 1 ? x1 : x0, i & 2 ? y1 : y0, i & 4 ? 2.5 : 0.0);
    assert_int_equal(enf_scene_add_cell(s, room, ENF_NONE, v[0], 8, 0, NULL, 0, NULL, &cell), ENF_OK);
    return cell;
}

static uint32_t add_door(EnfScene *s, uint32_t a, uint32_t b, double x, double y0, double y1, int turned) {
    double v[4][3] = {{x, y0, 0}, {x, y1, 0}, {x, y1, 2}, {x, y0, 2}}, t[4][3];
    uint32_t portal;
    for (int i = 0; i < 4; i++)
        vec_copy(t[i], v[turned ? 3 - i : i]);
    assert_int_equal(enf_scene_add_portal(s, a, b, t[0], 4, 0, ENF_NONE, &portal), ENF_OK);
    return portal;
}

static int has_code(const EnfScene *s, uint32_t code) {
    for (uint64_t i = 0; i < enf_scene_problem_count(s); i++) {
        EnfProblem problem;
        enf_scene_problem(s, i, &problem);
        if (problem.code == code)
            return 1;
    }
    return 0;
}

static void portals_face_from_their_first_cell_to_the_second_however_they_wind(void **state) {
    (void)state;
    for (int k = 0; k < 4; k++) {
        EnfScene *s;
        assert_int_equal(enf_scene_create(&s), ENF_OK);
        enf_scene_add_room(s, "A", ENF_ROOM_INTERIOR, NULL);
        uint32_t a = add_box(s, 0, 0, 4, 0, 3), b = add_box(s, 0, 4, 9, 0, 3);
        add_door(s, k & 2 ? b : a, k & 2 ? a : b, 4, 1, 2, k & 1);
        assert_int_equal(enf_scene_commit(s), ENF_OK);
        assert_int_equal(enf_scene_problem_count(s), 0);
        assert_true(fabs(s->portal_planes[0].n[0] - (k & 2 ? -1.0 : 1.0)) < 1e-15);
        assert_true(fabs(s->portal_planes[0].d - s->portal_planes[0].n[0] * (4 - s->origin[0])) < 1e-15);
        /* counter-clockwise seen from cells[0] */
        double u[3], v[3], n[3];
        vec_sub(u, s->portal_vertices[1], s->portal_vertices[0]);
        vec_sub(v, s->portal_vertices[2], s->portal_vertices[1]);
        vec_cross(n, u, v);
        assert_true(vec_dot(n, s->portal_planes[0].n) < 0.0);
        enf_scene_destroy(s);
    }
}

static void portal_files_wind_clockwise_seen_from_the_first_cluster(void **state) {
    (void)state;
    /* The wall x = 0 between cluster 0 (x > 0) and 1 (x < 0): cross(p0 - p1, p2 - p1) = (4, 0, 0) points into
     * cluster 0. */
    static const char text[] = "PRT1\n2\n1\n4 0 1 (0 0 0 ) (0 0 2 ) (0 2 2 ) (0 2 0 )\n";
    EnfScene *s;
    assert_int_equal(enf_scene_load_memory(text, sizeof text - 1, &s), ENF_OK);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    assert_true(s->portal_planes[0].n[0] < -0.99); /* from cells[0] into cells[1] */
    uint32_t cells[4], count;
    assert_int_equal(enf_scene_locate(s, (double[]){1, 1, 1}, cells, 4, &count), ENF_OK);
    assert_int_equal(count, 1);
    assert_int_equal(cells[0], 0);
    enf_scene_locate(s, (double[]){-1, 1, 1}, cells, 4, &count);
    assert_int_equal(count, 1);
    assert_int_equal(cells[0], 1);
    enf_scene_locate(s, (double[]){0, 1, 1}, cells, 4, &count); /* in the portal: both */
    assert_int_equal(count, 2);
    enf_scene_destroy(s);
}

static void cells_without_faces_become_their_hull(void **state) {
    (void)state;
    EnfScene *s;
    enf_scene_create(&s);
    enf_scene_add_room(s, "A", ENF_ROOM_INTERIOR, NULL);
    add_box(s, 0, 0, 4, 0, 3);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    assert_int_equal(s->cell_face_first[1], 6); /* six quads, not twelve triangles */
    assert_int_equal(s->face_index_first[6], 24);
    enf_scene_destroy(s);
}

static void hulls_hold_their_points_and_have_euler_s_number(void **state) {
    (void)state;
    for (int k = 0; k < 300; k++) {
        double p[200][3];
        uint32_t n = 4 + (uint32_t)(196 * random_unit());
        double flat = k % 3 == 0 ? 1e-5 : 1.0, step = k % 2 ? 0.25 : 1e-9; /* on a grid: many coplanar points */
        for (uint32_t i = 0; i < n; i++)
            for (int c = 0; c < 3; c++) {
                p[i][c] = floor((random_unit() - 0.5) * 2.0 / step) * step;
                if (c == 2)
                    p[i][c] *= flat;
            }
        EnfHull hull;
        int status = enf_hull_build(&hull, p, n, 1e-9);
        if (status == ENF_HULL_FLAT)
            continue;
        assert_int_equal(status, ENF_HULL_OK);
        uint32_t at = 0, corners = 0;
        unsigned char seen[200] = {0};
        for (uint32_t f = 0; f < hull.face_count; at += hull.face_sizes[f++]) {
            double normal[3] = {0, 0, 0}, u[3], v[3], c[3];
            const uint32_t *face = hull.face_indices + at;
            for (uint32_t i = 1; i + 1 < hull.face_sizes[f]; i++) {
                vec_sub(u, p[face[i]], p[face[0]]);
                vec_sub(v, p[face[i + 1]], p[face[0]]);
                vec_cross(c, u, v);
                vec_add(normal, normal, c);
            }
            if (vec_normalize(normal) < 1e-12)
                continue;
            for (uint32_t i = 0; i < n; i++) {
                vec_sub(u, p[i], p[face[0]]);
                assert_true(vec_dot(normal, u) < 1e-8);
            }
            for (uint32_t i = 0; i < hull.face_sizes[f]; i++) {
                corners += !seen[face[i]];
                seen[face[i]] = 1;
            }
        }
        assert_int_equal((int)corners - (int)hull.index_count / 2 + (int)hull.face_count, 2);
        enf_hull_free(&hull);
    }
}

static void a_point_is_located_in_its_cell_and_on_a_wall_in_both(void **state) {
    (void)state;
    /* 40 x 30 rooms of 3 m, against plain arithmetic. */
    for (int far_away = 0; far_away < 2; far_away++) {
        double by = far_away ? 1e7 : 0.0;
        EnfScene *s;
        enf_scene_create(&s);
        enf_scene_add_room(s, "A", ENF_ROOM_INTERIOR, NULL);
        for (int y = 0; y < 30; y++)
            for (int x = 0; x < 40; x++)
                add_box(s, 0, by + 3 * x, by + 3 * x + 3, 3 * y, 3 * y + 3);
        assert_int_equal(enf_scene_commit(s), ENF_OK);
        for (int k = 0; k < 3000; k++) {
            double p[3] = {by + 120 * random_unit(), 90 * random_unit(), 0.1 + 2 * random_unit()};
            uint32_t cells[8], count;
            assert_int_equal(enf_scene_locate(s, p, cells, 8, &count), ENF_OK);
            assert_true(count >= 1);
            uint32_t wanted = (uint32_t)((p[0] - by) / 3) + 40 * (uint32_t)(p[1] / 3);
            assert_true(cells[0] == wanted || count > 1);
        }
        uint32_t cells[8], count;
        enf_scene_locate(s, (double[]){by + 6, 4, 1}, cells, 8, &count);
        assert_int_equal(count, 2);
        enf_scene_locate(s, (double[]){by + 6, 6, 1}, cells, 8, &count);
        assert_int_equal(count, 4);
        enf_scene_locate(s, (double[]){by + 6, 6, 1}, cells, 1, &count); /* capacity bounds what is written, not the count */
        assert_int_equal(count, 4);
        enf_scene_locate(s, (double[]){by - 50, 4, 1}, cells, 8, &count);
        assert_int_equal(count, 0);
        enf_scene_destroy(s);
    }
}

static void editing_uncommits_and_doors_do_not(void **state) {
    (void)state;
    EnfScene *s;
    uint32_t count, opening;
    enf_scene_create(&s);
    enf_scene_add_room(s, "A", ENF_ROOM_INTERIOR, NULL);
    assert_int_equal(enf_scene_locate(s, (double[]){0, 0, 0}, NULL, 0, &count), ENF_ERROR_STATE);
    enf_scene_add_opening(s, "door", ENF_OPENING_DOOR, ENF_STATE_OPEN, &opening);
    uint32_t a = add_box(s, 0, 0, 4, 0, 3), b = add_box(s, 0, 4, 9, 0, 3);
    double v[4][3] = {{4, 1, 0}, {4, 2, 0}, {4, 2, 2}, {4, 1, 2}};
    enf_scene_add_portal(s, a, b, v[0], 4, 0, opening, NULL);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    assert_true(enf_portal_passes(s, 0));
    assert_int_equal(enf_scene_set_opening_state(s, opening, ENF_STATE_CLOSED), ENF_OK);
    assert_false(enf_portal_passes(s, 0));
    assert_int_equal(enf_scene_set_opening_state(s, opening, 9), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_scene_locate(s, (double[]){1, 1, 1}, NULL, 0, &count), ENF_OK);
    EnfSceneCounts counts;
    enf_scene_counts(s, &counts);
    assert_int_equal(counts.closed_portals, 1);
    add_box(s, 0, 9, 12, 0, 3);
    assert_int_equal(enf_scene_locate(s, (double[]){1, 1, 1}, NULL, 0, &count), ENF_ERROR_STATE);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    assert_int_equal(enf_scene_commit(s), ENF_OK); /* again, for nothing */
    enf_scene_destroy(s);
}

static void problems_found_while_adding_outlive_commits(void **state) {
    (void)state;
    EnfScene *s;
    enf_scene_create(&s);
    enf_scene_add_room(s, "open", ENF_ROOM_INTERIOR, NULL);
    double v[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    uint32_t sizes[3] = {3, 3, 3}, indices[9] = {0, 2, 1, 0, 1, 3, 1, 2, 3};
    assert_int_equal(enf_scene_add_room_polyhedron(s, 0, v[0], 4, 0, sizes, 3, indices, NULL, NULL), ENF_OK);
    for (int k = 0; k < 3; k++) {
        assert_int_equal(enf_scene_commit(s), ENF_OK);
        assert_true(has_code(s, 63));
        assert_int_equal(enf_scene_problem_count(s), 1);
    }
    enf_scene_destroy(s);
}

static void huge_numbers_of_problems_are_counted_not_listed(void **state) {
    (void)state;
    EnfScene *s;
    enf_scene_create(&s);
    enf_scene_add_room(s, "A", ENF_ROOM_INTERIOR, NULL);
    add_box(s, 0, 0, 4, 0, 3);
    double far_box[6] = {50, 50, 50, 51, 51, 51};
    for (int i = 0; i < 5000; i++)
        enf_scene_add_object(s, "lost", far_box, NULL, 0, ENF_NONE, NULL);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    assert_int_equal(s->unplaced_count, 5000);
    assert_int_equal(enf_scene_problem_count(s), 1001);
    assert_true(has_code(s, 82));
    enf_scene_destroy(s);
}

static void saving_keeps_everything_and_is_a_fixed_point(void **state) {
    (void)state;
    static const char *const files[] = {"two_rooms.enf.json", "drawn_rooms.enf.json"};
    static const char first[] = "test_scene_saved_1.enf.json", second[] = "test_scene_saved_2.enf.json";
    for (int f = 0; f < 2; f++) {
        char path[512], *a, *b;
        uint64_t a_size, b_size;
        EnfScene *s;
        snprintf(path, sizeof path, ENF_SOURCE_ROOT "/tests/scenes/%s", files[f]);
        assert_int_equal(enf_scene_load(path, &s), ENF_OK);
        assert_int_equal(enf_scene_commit(s), ENF_OK); /* turns windings, once */
        assert_int_equal(enf_scene_save_json(s, first), ENF_OK);
        enf_scene_destroy(s);
        assert_int_equal(enf_scene_load(first, &s), ENF_OK);
        assert_int_equal(enf_scene_commit(s), ENF_OK);
        assert_int_equal(enf_scene_save_json(s, second), ENF_OK);
        enf_scene_destroy(s);
        assert_int_equal(enf_file_read(first, &a, &a_size), ENF_OK);
        assert_int_equal(enf_file_read(second, &b, &b_size), ENF_OK);
        assert_int_equal(a_size, b_size);
        assert_memory_equal(a, b, a_size);
        if (f == 0) {
            assert_non_null(strstr(a, "\"note\": {\"author\": \"kept\", \"list\": [1, 2.50, true, null]}"));
            assert_non_null(strstr(a, "\"colour\": \"red\""));
            assert_non_null(strstr(a, "\"tag\": 7"));
            assert_non_null(strstr(a, "\"fire\": \"T30\""));
            assert_non_null(strstr(a, "Chamber \\\"west\\\""));
        }
        enf_free(a);
        enf_free(b);
    }
    remove(first);
    remove(second);
}

static void a_scene_with_nan_is_not_saved_and_the_old_file_stays(void **state) {
    (void)state;
    static const char path[] = "test_scene_nan.enf.json";
    EnfScene *s;
    enf_scene_create(&s);
    assert_int_equal(enf_scene_save_json(s, path), ENF_OK);
    double position[3] = {0, NAN, 0};
    enf_scene_add_light(s, "l", position, NULL);
    assert_int_equal(enf_scene_save_json(s, path), ENF_ERROR_BAD_INPUT);
    assert_int_equal(enf_scene_commit(s), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "light 0"));
    assert_int_equal(enf_scene_save_json(s, "no such folder/x.enf.json"), ENF_ERROR_BAD_INPUT);
    enf_scene_destroy(s);
    assert_int_equal(enf_scene_load(path, &s), ENF_OK);
    assert_int_equal(enf_scene_save_json(s, "no such folder/x.enf.json"), ENF_ERROR_IO);
    enf_scene_destroy(s);
    remove(path);
}

static void null_and_short_structs_are_the_caller_s_fault(void **state) {
    (void)state;
    EnfScene *s;
    EnfCamera camera = enf_default_camera();
    assert_int_equal(enf_scene_create(NULL), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_scene_commit(NULL), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_scene_load(NULL, &s), ENF_ERROR_INVALID_ARGUMENT);
    enf_scene_create(&s);
    camera.struct_size = 4;
    assert_int_equal(enf_scene_add_camera(s, "c", &camera, NULL), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_scene_add_cell(s, 0, 0, NULL, 3, 0, NULL, 0, NULL, NULL), ENF_ERROR_INVALID_ARGUMENT);
    assert_null(enf_scene_room_name(s, 3));
    assert_int_equal(enf_struct_size("EnfCamera"), sizeof(EnfCamera));
    assert_int_equal(enf_struct_size("EnfNothing"), 0);
    enf_scene_destroy(s);
    enf_scene_destroy(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(portals_face_from_their_first_cell_to_the_second_however_they_wind),
        cmocka_unit_test(portal_files_wind_clockwise_seen_from_the_first_cluster),
        cmocka_unit_test(cells_without_faces_become_their_hull),
        cmocka_unit_test(hulls_hold_their_points_and_have_euler_s_number),
        cmocka_unit_test(a_point_is_located_in_its_cell_and_on_a_wall_in_both),
        cmocka_unit_test(editing_uncommits_and_doors_do_not),
        cmocka_unit_test(problems_found_while_adding_outlive_commits),
        cmocka_unit_test(huge_numbers_of_problems_are_counted_not_listed),
        cmocka_unit_test(saving_keeps_everything_and_is_a_fixed_point),
        cmocka_unit_test(a_scene_with_nan_is_not_saved_and_the_old_file_stays),
        cmocka_unit_test(null_and_short_structs_are_the_caller_s_fault),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
