/* SPDX-License-Identifier: GPL-3.0-or-later
 * The from-region engine on rooms in a row: who sees whom, who does not, and the invariants of DESIGN.md section 3. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "enfilade/enfilade.h"

/* Walls at y = 0, 1, 2 ...; wall i has one door from x0 to x1, z0 to z1. Cells 0 .. count lie between them. */
typedef struct Door {
    double x0, x1, z0, z1;
} Door;

typedef struct Motion {
    double angle, scale, shift[3];
} Motion;

static void move(const Motion *m, double x, double y, double z, double out[3]) {
    double c = cos(m->angle), s = sin(m->angle);
    out[0] = m->scale * (c * x - s * y) + m->shift[0];
    out[1] = m->scale * (s * x + c * y) + m->shift[1];
    out[2] = m->scale * z + m->shift[2];
}

static EnfScene *rooms_in_a_row(const Door *doors, uint32_t count, const Motion *m, int reversed) {
    EnfScene *scene = NULL;
    uint32_t room, cell, portal;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    for (uint32_t i = 0; i <= count; ++i) {
        uint32_t k = reversed ? count - i : i;
        double box[8][3];
        for (int v = 0; v < 8; ++v)
            move(m, v & 1 ? 10 : -10, k - 1.0 + (v >> 1 & 1), v & 4 ? 3 : 0, box[v]);
        assert_int_equal(enf_scene_add_room(scene, "room", ENF_ROOM_INTERIOR, &room), ENF_OK);
        assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, box[0], 8, 0, NULL, 0, NULL, &cell), ENF_OK);
    }
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t a = reversed ? count - i : i, b = reversed ? count - i - 1 : i + 1;
        double q[4][3];
        move(m, doors[i].x0, i, doors[i].z0, q[0]), move(m, doors[i].x1, i, doors[i].z0, q[1]);
        move(m, doors[i].x1, i, doors[i].z1, q[2]), move(m, doors[i].x0, i, doors[i].z1, q[3]);
        assert_int_equal(enf_scene_add_portal(scene, a, b, q[0], 4, 0, ENF_NONE, &portal), ENF_OK);
    }
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    return scene;
}

static const Motion still = {0, 1, {0, 0, 0}};

static uint32_t first_to_last(const Door *doors, uint32_t count, const Motion *m, int reversed, uint32_t method) {
    EnfScene *scene = rooms_in_a_row(doors, count, m, reversed);
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL;
    uint32_t forth = 9, back = 9;
    def.method = method, def.threads = 1;
    assert_int_equal(enf_region_vis_run(scene, &def, &result), ENF_OK);
    assert_int_equal(enf_region_vis_pair(result, 0, count, &forth), ENF_OK);
    assert_int_equal(enf_region_vis_pair(result, count, 0, &back), ENF_OK);
    assert_int_equal(forth, back);
    if (forth == ENF_PAIR_VISIBLE) {
        double segment[6], clearance;
        uint32_t portals[16], n;
        assert_int_equal(enf_region_vis_witness(result, 0, count, segment, portals, 16, &n, &clearance), ENF_OK);
        assert_int_equal(n, count);
        EnfRegionVisStats stats = enf_default_region_vis_stats();
        assert_int_equal(enf_region_vis_stats(result, &stats), ENF_OK);
        assert_true(clearance >= stats.clearance);
    }
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
    return forth;
}

static void doors_in_line_are_seen_through(void **state) {
    (void)state;
    Door doors[4] = {{0, 1, 0, 2}, {0, 1, 0, 2}, {0, 1, 0, 2}, {0, 1, 0, 2}};
    assert_int_equal(first_to_last(doors, 4, &still, 0, ENF_REGION_EXACT), ENF_PAIR_VISIBLE);
    assert_int_equal(first_to_last(doors, 4, &still, 0, ENF_REGION_SAMPLE), ENF_PAIR_VISIBLE);
}

static void a_door_off_the_line_hides(void **state) {
    (void)state;
    /* From x <= 1 at y = 0 and x in 2..3 at y = 1 a line reaches x >= 3 at y = 2; the door there ends at 2.9. */
    Door hidden[3] = {{0, 1, 0, 2}, {2, 3, 0, 2}, {1, 2.9, 0, 2}}, seen[3] = {{0, 1, 0, 2}, {2, 3, 0, 2}, {1, 3.1, 0, 2}};
    assert_int_equal(first_to_last(hidden, 3, &still, 0, ENF_REGION_EXACT), ENF_PAIR_HIDDEN);
    assert_int_equal(first_to_last(hidden, 3, &still, 0, ENF_REGION_FLOW), ENF_PAIR_HIDDEN);
    assert_int_equal(first_to_last(seen, 3, &still, 0, ENF_REGION_EXACT), ENF_PAIR_VISIBLE);
}

static void lines_that_only_touch_edges_see_nothing(void **state) {
    (void)state;
    /* Door edges at x = 1 from either side: only the plane x = 1 touches all. */
    Door doors[3] = {{0, 1, 0, 2}, {1, 2, 0, 2}, {0, 1, 0, 2}};
    assert_int_equal(first_to_last(doors, 3, &still, 0, ENF_REGION_EXACT), ENF_PAIR_HIDDEN);
}

static void slits_down_to_a_micrometre_are_seen(void **state) {
    (void)state;
    for (double width = 0.1; width > 0.9e-6; width *= 0.1) {
        Door doors[3] = {{0, 1, 0, 2}, {1 - width, 2, 0, 2}, {0, 1, 0, 2}};
        uint32_t status = first_to_last(doors, 3, &still, 0, ENF_REGION_EXACT);
        assert_int_not_equal(status, ENF_PAIR_HIDDEN);
        /* Clears by delta = 2.5e-7 * 20.4 m when the slit is wider than twice that and its margin. */
        if (width > 2e-5)
            assert_int_equal(status, ENF_PAIR_VISIBLE);
    }
}

/* The slit between the middle door and the outer two is w wide: the best line keeps half of it from both edges. */
static void a_grazing_pair_tells_its_best_clearance(void **state) {
    (void)state;
    const double widths[] = {1e-5, 1e-4, 7e-4, 1.9e-3}, turned[] = {0, 0.7};
    for (size_t k = 0; k < 8; ++k) {
        double w = widths[k / 2], segment[6], clearance;
        const Door doors[] = {{0, 1, 0, 2}, {1 - w, 2, 0, 2}, {0, 1, 0, 2}};
        const Motion motion = {turned[k % 2], 1, {k % 2 ? 1000 : 0, 0, 0}};
        EnfScene *scene = rooms_in_a_row(doors, 3, &motion, 0);
        EnfRegionVisDef def = enf_default_region_vis_def();
        EnfRegionVis *result = NULL;
        uint32_t status = 9;
        def.clearance = 1e-3, def.threads = 1;
        assert_int_equal(enf_region_vis_run(scene, &def, &result), ENF_OK);
        assert_int_equal(enf_region_vis_pair(result, 0, 3, &status), ENF_OK);
        assert_int_equal(status, ENF_PAIR_GRAZING);
        assert_int_equal(enf_region_vis_witness(result, 0, 3, segment, NULL, 0, NULL, &clearance), ENF_OK);
        if (!(clearance <= 0.5 * w * (1 + 1e-6)) || !(clearance >= 0.5 * w * 0.98))
            fail_msg("slit of %g m: clearance %g m", w, clearance);
        enf_region_vis_destroy(result);
        enf_scene_destroy(scene);
    }
}

static void heights_and_widths_may_fit_one_by_one_and_not_together(void **state) {
    (void)state;
    /* Three skew slots: any two are stabbed by many lines, all three by a regulus or not at all. */
    Door doors[4] = {{-5, 5, 1.00, 1.01}, {0, 0.01, 0, 3}, {-5, 5, 2.00, 2.01}, {4, 4.01, 0, 3}};
    assert_int_equal(first_to_last(doors, 4, &still, 0, ENF_REGION_EXACT), ENF_PAIR_VISIBLE);
    doors[3] = (Door){4, 4.01, 0, 1.0}; /* the line climbs 0.5 a wall: at 2.5 there */
    assert_int_equal(first_to_last(doors, 4, &still, 0, ENF_REGION_EXACT), ENF_PAIR_HIDDEN);
}

static void motion_scale_and_order_change_nothing(void **state) {
    (void)state;
    uint64_t seed = 12345;
    for (int round = 0; round < 60; ++round) {
        Door doors[5];
        for (int i = 0; i < 5; ++i) {
            double r[4];
            for (int k = 0; k < 4; ++k) {
                seed = seed * 6364136223846793005u + 1442695040888963407u;
                r[k] = (double)(seed >> 40) / (1 << 24);
            }
            doors[i] = (Door){3 * r[0] - 1.5, 3 * r[0] - 1.5 + 0.1 + r[1], r[2], r[2] + 0.1 + r[3]};
        }
        uint32_t expected = first_to_last(doors, 5, &still, 0, ENF_REGION_EXACT);
        const Motion moved[4] = {{0.7, 1, {0, 0, 0}}, {2.1, 1, {1e7, -5e6, 300}}, {0, 1e-3, {0, 0, 0}}, {1, 1e3, {5, 5, 5}}};
        assert_int_equal(first_to_last(doors, 5, &still, 1, ENF_REGION_EXACT), expected);
        for (int k = 0; k < 4; ++k)
            assert_int_equal(first_to_last(doors, 5, &moved[k], 0, ENF_REGION_EXACT), expected);
        if (expected == ENF_PAIR_VISIBLE)
            assert_int_not_equal(first_to_last(doors, 5, &still, 0, ENF_REGION_FLOW), ENF_PAIR_HIDDEN);
        Door wider[5]; /* larger portals never remove visibility */
        for (int i = 0; i < 5; ++i)
            wider[i] = (Door){doors[i].x0 - 0.05, doors[i].x1 + 0.05, doors[i].z0, doors[i].z1 + 0.05};
        if (expected == ENF_PAIR_VISIBLE)
            assert_int_equal(first_to_last(wider, 5, &still, 0, ENF_REGION_EXACT), ENF_PAIR_VISIBLE);
    }
}

static void a_closed_door_hides_what_lies_behind(void **state) {
    (void)state;
    Door doors[2] = {{0, 1, 0, 2}, {0, 1, 0, 2}};
    EnfScene *scene = rooms_in_a_row(doors, 2, &still, 0);
    uint32_t opening, portal, status, from, to;
    double q[4][3] = {{4, 1, 0}, {5, 1, 0}, {5, 1, 2}, {4, 1, 2}};
    assert_int_equal(enf_scene_add_opening(scene, "D", ENF_OPENING_DOOR, ENF_STATE_CLOSED, &opening), ENF_OK);
    assert_int_equal(enf_scene_add_portal(scene, 1, 2, q[0], 4, 0, opening, &portal), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    EnfRegionVis *closed = NULL, *open = NULL;
    EnfRegionVisDef def = enf_default_region_vis_def();
    assert_int_equal(enf_region_vis_run(scene, &def, &closed), ENF_OK);
    assert_int_equal(enf_scene_set_opening_state(scene, opening, ENF_STATE_OPEN), ENF_OK);
    assert_int_equal(enf_region_vis_run(scene, &def, &open), ENF_OK);
    const uint64_t *a = enf_region_vis_row_first(closed), *b = enf_region_vis_row_first(open);
    assert_true(a[3] <= b[3]);
    assert_int_equal(enf_region_vis_rooms(open, 0, 2, &status, &from, &to), ENF_OK);
    assert_int_equal(status, ENF_PAIR_VISIBLE);
    assert_int_equal(from, 0);
    assert_int_equal(to, 2);
    enf_region_vis_destroy(closed), enf_region_vis_destroy(open);
    enf_scene_destroy(scene);
}

static void an_object_is_seen_only_with_its_cell(void **state) {
    (void)state;
    Door doors[3] = {{0, 1, 0, 2}, {2, 3, 0, 2}, {1, 2.9, 0, 2}};
    EnfScene *scene = rooms_in_a_row(doors, 3, &still, 0);
    const double wide[6] = {-9, 1.1, 0, 9, 1.9, 3}, behind[6] = {-9, 2.2, 0, 9, 2.8, 3};
    uint32_t a, b, cells[2] = {2, 3}, status, cell;
    assert_int_equal(enf_scene_add_object(scene, "screen", wide, cells, 1, ENF_NONE, &a), ENF_OK);
    assert_int_equal(enf_scene_add_object(scene, "screen", behind, cells + 1, 1, ENF_NONE, &b), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL;
    assert_int_equal(enf_region_vis_run(scene, &def, &result), ENF_OK);
    assert_int_equal(enf_region_vis_object(result, 0, a, &status, &cell), ENF_OK);
    assert_int_equal(status, ENF_PAIR_VISIBLE); /* it fills the cell behind the second door */
    assert_int_equal(cell, 2);
    assert_int_equal(enf_region_vis_object(result, 0, b, &status, &cell), ENF_OK);
    assert_int_equal(status, ENF_PAIR_HIDDEN);
    assert_int_equal(cell, ENF_NONE);
    assert_int_equal(enf_region_vis_object(result, 3, b, &status, &cell), ENF_OK);
    assert_int_equal(status, ENF_PAIR_VISIBLE);
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
}

static void wrong_calls_are_told_why(void **state) {
    (void)state;
    Door doors[1] = {{0, 1, 0, 2}};
    EnfScene *scene = rooms_in_a_row(doors, 1, &still, 0);
    EnfRegionVis *result = NULL;
    EnfRegionVisDef def = enf_default_region_vis_def(), zero;
    memset(&zero, 0, sizeof zero);
    uint32_t from[1] = {7};
    assert_int_equal(enf_region_vis_run(scene, &zero, &result), ENF_ERROR_INVALID_ARGUMENT);
    def.from_cells = from, def.from_count = 1;
    assert_int_equal(enf_region_vis_run(scene, &def, &result), ENF_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(enf_last_error(), "7"));
    assert_null(result);
    enf_scene_destroy(scene);
}

static void a_cancelled_job_keeps_a_safe_result(void **state) {
    (void)state;
    Door doors[3] = {{0, 1, 0, 2}, {0, 1, 0, 2}, {0, 1, 0, 2}};
    EnfScene *scene = rooms_in_a_row(doors, 3, &still, 0);
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfJob *job = NULL;
    EnfRegionVis *result = NULL;
    uint32_t done = 0, status = 0;
    assert_int_equal(enf_region_vis_start(scene, &def, &job), ENF_OK);
    enf_job_cancel(job);
    EnfStatus ended = enf_job_wait(job, -1, &done);
    assert_true(done && (ended == ENF_OK || ended == ENF_ERROR_CANCELLED));
    assert_int_equal(enf_region_vis_take(job, &result), ENF_OK);
    assert_int_equal(enf_region_vis_pair(result, 0, 3, &status), ENF_OK);
    assert_int_not_equal(status, ENF_PAIR_HIDDEN);
    assert_int_equal(enf_region_vis_take(job, &result), ENF_ERROR_STATE);
    enf_job_destroy(job);
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
}

/* Portal files from elsewhere, when they are at hand: the same rows for any thread count, and rows asked for alone. */
static void threads_and_selected_rows_give_the_same_bits(void **state) {
    (void)state;
    const char *data = getenv("ENFILADE_DATA");
    char path[1024];
    snprintf(path, sizeof path, "%s/prt/e1m7.prt", data ? data : ENF_SOURCE_ROOT "/../shared/data");
    EnfScene *scene = NULL;
    if (enf_scene_load(path, &scene) != ENF_OK) {
        print_message("skipped: %s is not there\n", path);
        skip();
    }
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    EnfRegionVis *all[3], *some = NULL;
    const uint32_t threads[3] = {1, 2, 4}, from[2] = {3, 100};
    EnfRegionVisDef def = enf_default_region_vis_def();
    for (int k = 0; k < 3; ++k) {
        def.threads = threads[k];
        assert_int_equal(enf_region_vis_run(scene, &def, &all[k]), ENF_OK);
    }
    const uint64_t *first = enf_region_vis_row_first(all[0]);
    uint32_t n = enf_region_vis_cell_count(all[0]);
    for (int k = 1; k < 3; ++k) {
        assert_memory_equal(first, enf_region_vis_row_first(all[k]), (n + 1) * sizeof *first);
        assert_memory_equal(enf_region_vis_row_cells(all[0]), enf_region_vis_row_cells(all[k]), first[n] * 4);
        assert_memory_equal(enf_region_vis_row_status(all[0]), enf_region_vis_row_status(all[k]), first[n]);
    }
    for (uint32_t i = 0; i < n; ++i)
        for (uint64_t k = first[i]; k < first[i + 1]; ++k) {
            uint32_t j = enf_region_vis_row_cells(all[0])[k];
            double a[6], b[6];
            if (j == i || enf_region_vis_row_status(all[0])[k] != ENF_PAIR_VISIBLE)
                continue;
            assert_int_equal(enf_region_vis_witness(all[0], i, j, a, NULL, 0, NULL, NULL), ENF_OK);
            assert_int_equal(enf_region_vis_witness(all[2], i, j, b, NULL, 0, NULL, NULL), ENF_OK);
            assert_memory_equal(a, b, sizeof a);
        }
    def.from_cells = from, def.from_count = 2;
    assert_int_equal(enf_region_vis_run(scene, &def, &some), ENF_OK);
    const uint64_t *f = enf_region_vis_row_first(some);
    for (int k = 0; k < 2; ++k) {
        uint32_t i = from[k];
        assert_int_equal(f[i + 1] - f[i], first[i + 1] - first[i]);
        assert_memory_equal(enf_region_vis_row_cells(some) + f[i], enf_region_vis_row_cells(all[0]) + first[i], (f[i + 1] - f[i]) * 4);
    }
    for (int k = 0; k < 3; ++k)
        enf_region_vis_destroy(all[k]);
    enf_region_vis_destroy(some);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(doors_in_line_are_seen_through),          cmocka_unit_test(a_door_off_the_line_hides),
        cmocka_unit_test(lines_that_only_touch_edges_see_nothing), cmocka_unit_test(slits_down_to_a_micrometre_are_seen),
        cmocka_unit_test(a_grazing_pair_tells_its_best_clearance), cmocka_unit_test(heights_and_widths_may_fit_one_by_one_and_not_together),
        cmocka_unit_test(motion_scale_and_order_change_nothing),   cmocka_unit_test(a_closed_door_hides_what_lies_behind),
        cmocka_unit_test(an_object_is_seen_only_with_its_cell),    cmocka_unit_test(wrong_calls_are_told_why),
        cmocka_unit_test(a_cancelled_job_keeps_a_safe_result),     cmocka_unit_test(threads_and_selected_rows_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
