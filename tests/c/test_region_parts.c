/* SPDX-License-Identifier: GPL-3.0-or-later
 * The parts of the from-region engine by themselves: side products, separating planes and clips, the stabbing cone, pair rows. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/memory.h"
#include "from_region/pair_table.h"
#include "from_region/separators.h"
#include "from_region/sightline.h"
#include "from_region/stab_cone.h"
#include "from_region/stab_exact.h"

static EnfWindow square(double x, double z, double size, double y) {
    /* Counter-clockwise about +y. */
    EnfWindow w = {4, 15, {x, x, x + size, x + size}, {y, y, y, y}, {z, z + size, z + size, z}};
    enf_window_wrap(&w);
    return w;
}

static void separating_planes_bound_the_view_beyond(void **state) {
    (void)state;
    const double along[3] = {0, 1, 0};
    EnfWindow source = square(0, 0, 0.1, 0), pass = square(0, 0, 0.1, 0.2);
    double planes[ENF_SEPARATORS_MAX][4];
    uint32_t count = enf_separators(&source, along, &pass, along, planes);
    assert_true(count >= 4);
    /* At y = 0.4 the view is the square from -0.1 to 0.2: points of it keep, points outside fall to some plane. */
    double x[4] = {-0.0999, 0.1999, -0.101, 0.201};
    for (int k = 0; k < 4; ++k) {
        double p[3] = {x[k], 0.4, 0.05};
        int outside = 0;
        for (uint32_t i = 0; i < count; ++i)
            outside |= planes[i][0] * p[0] + planes[i][1] * p[1] + planes[i][2] * p[2] < planes[i][3];
        assert_int_equal(outside, k >= 2);
    }
    /* Looking back through pass, from a window beyond, on the source's plane. */
    EnfWindow beyond = square(0, 0, 0.1, 0.4);
    count = enf_separators_back(&beyond, along, &pass, along, planes);
    EnfWindow wide = square(-0.5, -0.5, 1, 0);
    int clipped = 0;
    for (uint32_t i = 0; i < count; ++i)
        assert_true(enf_window_clip(&wide, planes[i], &clipped));
    assert_true(clipped);
    for (uint32_t i = 0; i < wide.count; ++i)
        assert_true(wide.x[i] > -0.1001 && wide.x[i] < 0.2001 && wide.z[i] > -0.1001 && wide.z[i] < 0.2001);
}

static void windows_that_touch_give_no_wrong_plane(void **state) {
    (void)state;
    /* Two windows that share an edge at a right angle: lines through both fill the whole quarter space. */
    const double n0[3] = {0, 1, 0}, n1[3] = {1, 0, 0};
    EnfWindow source = square(0, 0, 0.1, 0);
    EnfWindow pass = {4, 15, {0.1, 0.1, 0.1, 0.1}, {0, 0.1, 0.1, 0}, {0, 0, 0.1, 0.1}};
    enf_window_wrap(&pass);
    double planes[ENF_SEPARATORS_MAX][4];
    uint32_t count = enf_separators(&source, n0, &pass, n1, planes);
    const double seen[3] = {0.2, 0.05, 0.05}; /* from (0.05, 0, 0.05) through (0.1, 1 / 60, 0.05) */
    for (uint32_t i = 0; i < count; ++i)
        assert_true(planes[i][0] * seen[0] + planes[i][1] * seen[1] + planes[i][2] * seen[2] >= planes[i][3]);
}

static void windows_that_cross_give_no_planes_and_a_clip_may_leave_nothing(void **state) {
    (void)state;
    const double n0[3] = {0, 1, 0}, n1[3] = {1, 0, 0}, gone[4] = {1, 0, 0, 0.2};
    double planes[ENF_SEPARATORS_MAX][4];
    EnfWindow w = square(0, 0, 0.1, 0);
    EnfWindow through = {4, 15, {0.05, 0.05, 0.05, 0.05}, {-0.1, 0.1, 0.1, -0.1}, {0, 0, 0.1, 0.1}};
    enf_window_wrap(&through);
    assert_int_equal(enf_separators(&w, n0, &through, n1, planes), 0);
    int clipped = 0;
    assert_false(enf_window_clip(&w, gone, &clipped));
}

/* The SIMD kernel and its twin: equal bits; and every plane keeps each window on its side. */
static void separators_have_the_same_bits_in_both_kernels(void **state) {
    (void)state;
    const double along[3] = {0, 1, 0};
    uint64_t random = 3;
    for (int round = 0; round < 500; ++round) {
        EnfWindow source = square(enf_mix_unit(&random) * 0.3, enf_mix_unit(&random) * 0.3, 0.01 + 0.2 * enf_mix_unit(&random), 0);
        EnfWindow pass = square(enf_mix_unit(&random) * 0.3, enf_mix_unit(&random) * 0.3, 0.01 + 0.2 * enf_mix_unit(&random), 0.1);
        const double corner[4] = {-0.6, 0, -0.8, -0.8 * source.x[0] - 0.9 * source.z[3] - 0.05};
        int clipped = 0;
        (void)enf_window_clip(&source, corner, &clipped);
        double a[ENF_SEPARATORS_MAX][4], b[ENF_SEPARATORS_MAX][4];
        uint32_t count = enf_separators_twin(0, &source, along, &pass, along, a);
        assert_int_equal(enf_separators_twin(1, &source, along, &pass, along, b), count);
        assert_memory_equal(a, b, count * sizeof *a);
        for (uint32_t i = 0; i < count; ++i)
            for (uint32_t k = 0; k < pass.count; ++k)
                assert_true((a[i][0] * pass.x[k] + a[i][1] * pass.y[k]) + a[i][2] * pass.z[k] >= a[i][3]);
    }
}

static void a_shaft_holds_every_segment_between_two_boxes(void **state) {
    (void)state;
    uint64_t random = 11;
    uint32_t left_out = 0;
    for (int round = 0; round < 200; ++round) {
        double a[6], b[6], planes[ENF_SHAFT_MAX][4];
        for (int k = 0; k < 3; ++k) {
            a[k] = enf_mix_unit(&random) - 0.5, a[k + 3] = a[k] + (round & 1 ? 0 : 0.2 * enf_mix_unit(&random));
            b[k] = enf_mix_unit(&random) - 0.5, b[k + 3] = b[k] + 0.2 * enf_mix_unit(&random);
        }
        uint32_t count = enf_shaft(a, b, ENF_SHAFT_MAX, planes);
        for (int i = 0; i < 50; ++i) {
            double t = enf_mix_unit(&random), p[3], away[3];
            int outside = 0;
            for (int k = 0; k < 3; ++k) {
                double from = a[k] + enf_mix_unit(&random) * (a[k + 3] - a[k]), to = b[k] + enf_mix_unit(&random) * (b[k + 3] - b[k]);
                p[k] = from + t * (to - from), away[k] = enf_mix_unit(&random) - 0.5;
            }
            for (uint32_t n = 0; n < count; ++n) {
                assert_true(planes[n][0] * p[0] + planes[n][1] * p[1] + planes[n][2] * p[2] >= planes[n][3]);
                outside |= planes[n][0] * away[0] + planes[n][1] * away[1] + planes[n][2] * away[2] < planes[n][3];
            }
            left_out += (uint32_t)outside;
        }
    }
    assert_true(left_out > 8000); /* of 10,000 points of the unit cube */
}

static void boxes_against_packed_planes(void **state) {
    (void)state;
    const double planes[5][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {-1, 0, 0, -1}, {0, -1, 0, -1}};
    EnfPlanePack pack;
    enf_plane_pack(&pack, planes, 0, 5);
    const float inside[6] = {0.5f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f}, touching[6] = {-0.1f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f},
                outside[6] = {-0.2f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f}, fifth[6] = {0.5f, 1.3f, 0.5f, 0.1f, 0.1f, 0.1f};
    assert_false(enf_pack_misses_box(&pack, inside));
    assert_false(enf_pack_misses_box(&pack, touching));
    assert_true(enf_pack_misses_box(&pack, outside));
    assert_true(enf_pack_misses_box(&pack, fifth));
}

/* Squares in the planes z = 0, 0.1, 0.2 (parallel: a direction of lineality) or with the middle one tilted; `uneven` takes
 * the corners out of line. */
static int stab(double middle, double last, double tilt, double uneven) {
    EnfStabCone *cone = enf_cone_create();
    assert_non_null(cone);
    double line[6], x[3] = {0, middle, last};
    enf_cone_begin(cone);
    for (uint32_t p = 0; p < 3; ++p) {
        double z = 0.1 * p, t = p == 1 ? tilt : 0, u = uneven * (p + 1);
        double v[4][3] = {{x[p], u, z}, {x[p] + 0.1, -u / 3, z + t}, {x[p] + 0.1, 0.1 + u, z + t}, {x[p] - u, 0.1, z}};
        if (p == 1 && tilt != 0) /* keep the corners in the plane z = 0.1 + tilt (x - middle) / 0.1 */
            for (int i = 0; i < 4; ++i)
                v[i][2] = z + tilt * (v[i][0] - middle) / 0.1;
        const double n[3] = {-10 * t, 0, 1};
        enf_cone_add_direction(cone, n);
        for (uint32_t i = 0; i < 4; ++i)
            enf_cone_add_edge(cone, v[i], v[(i + 1) % 4]);
    }
    int answer = enf_cone_solve(cone, line);
    if (answer == ENF_CONE_STABBED)
        assert_true(fabs(line[0] * line[3] + line[1] * line[4] + line[2] * line[5]) < 1e-12);
    enf_cone_destroy(cone);
    return answer;
}

static void the_cone_tells_stabbed_from_empty(void **state) {
    (void)state;
    assert_int_equal(stab(0.05, 0.1, 0, 0.001), ENF_CONE_STABBED);
    assert_int_equal(stab(0.05, 0.1, 0.03, 0.001), ENF_CONE_STABBED);
    assert_int_equal(stab(0.3, 0.2, 0, 0.001), ENF_CONE_EMPTY); /* out and back: no straight line */
    /* All edges in line: the degenerate case is the normal case. */
    assert_int_equal(stab(0.05, 0.1, 0, 0), ENF_CONE_STABBED);
    assert_int_equal(stab(0, 0, 0, 0), ENF_CONE_STABBED);
    assert_int_equal(stab(0, 0, 0.03, 0), ENF_CONE_STABBED);
    assert_int_equal(stab(0.5, 1.0, 0, 0), ENF_CONE_STABBED);
    assert_int_equal(stab(0.5, 0.75, 0, 0), ENF_CONE_EMPTY);
}

/* A fan of portals about the edge x = y = 0 that turns by more than half a circle: only lines along the edge have no negative
 * direction row, and those cross nothing. */
static void a_fan_that_turns_back_is_empty(void **state) {
    (void)state;
    EnfStabCone *cone = enf_cone_create();
    double line[6];
    enf_cone_begin(cone);
    for (int i = 0; i < 4; ++i) {
        double a = 1.1 * i, c = cos(a), s = sin(a);
        const double n[3] = {-s, c, 0}, v[4][3] = {{0, 0, 0}, {0.5 * c, 0.5 * s, 0}, {0.5 * c, 0.5 * s, 1}, {0, 0, 1}};
        enf_cone_add_direction(cone, n);
        for (int k = 0; k < 4; ++k)
            enf_cone_add_edge(cone, v[k == 0 ? 0 : 4 - k], v[3 - k]);
    }
    assert_int_equal(enf_cone_solve(cone, line), ENF_CONE_EMPTY);
    enf_cone_destroy(cone);
}

/* The filter against exact arithmetic: rows and rays of random and of small whole numbers, where many products are 0. */
static void the_filter_never_contradicts_exact_arithmetic(void **state) {
    (void)state;
    EnfStabCone *cone = enf_cone_create();
    uint64_t random = 7, sure = 0, zeros = 0;
    for (int round = 0; round < 2000; ++round) {
        double line[6];
        int coarse = round & 1;
        enf_cone_begin(cone);
        for (int i = 0; i < 14; ++i) {
            double a[3], b[3];
            for (int k = 0; k < 3; ++k) {
                a[k] = 2 * enf_mix_unit(&random) - 1, b[k] = 2 * enf_mix_unit(&random) - 1;
                if (coarse)
                    a[k] = nearbyint(4 * a[k]) / 8, b[k] = nearbyint(4 * b[k]) / 8;
            }
            enf_cone_add_edge(cone, a, b);
        }
        (void)enf_cone_solve(cone, line);
        for (uint32_t row = 0; row < cone->row_count; ++row)
            for (uint32_t ray = 0; ray < cone->ray_count; ray += 1 + cone->ray_count / 16) {
                double error, value = enf_row_value(&cone->rows[row].line, &cone->rays[ray].line, &error), v, e;
                int exact = enf_exact_row_sign(cone, row, ray, &v, &e);
                assert_true(exact == 0 ? v == 0 && e == 0 : (v > 0) == (exact > 0) && fabs(v) > e);
                zeros += exact == 0;
                if (fabs(value) <= error)
                    continue;
                ++sure;
                assert_int_equal(value > 0 ? 1 : -1, exact);
            }
        for (uint32_t a = 0; a + 1 < cone->ray_count; a += 1 + cone->ray_count / 8) {
            double error, value = enf_line_side(&cone->rays[a].line, &cone->rays[a + 1].line, &error);
            if (fabs(value) > error)
                assert_int_equal(value > 0 ? 1 : -1, enf_exact_side_sign(cone, a, a + 1));
        }
    }
    assert_true(sure > 10000 && zeros > 1000);
    enf_cone_destroy(cone);
}

static void pair_states_are_found_in_both_directions(void **state) {
    (void)state;
    EnfPairTable table;
    memset(&table, 0, sizeof table);
    assert_true(enf_pair_table_all(&table, 130));
    assert_null(enf_pair_slot(&table, 5, 5));
    uint32_t value = 0;
    for (uint32_t i = 0; i < 130; ++i)
        for (uint32_t j = i + 1; j < 130; ++j) {
            assert_ptr_equal(enf_pair_slot(&table, i, j), enf_pair_slot(&table, j, i));
            *enf_pair_slot(&table, i, j) = ++value;
        }
    value = 0; /* no two pairs share a state */
    for (uint32_t i = 0; i < 130; ++i)
        for (uint32_t j = i + 1; j < 130; ++j)
            assert_int_equal(*enf_pair_slot(&table, j, i), ++value);
    enf_pair_table_free(&table);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(separating_planes_bound_the_view_beyond),
        cmocka_unit_test(windows_that_touch_give_no_wrong_plane),
        cmocka_unit_test(windows_that_cross_give_no_planes_and_a_clip_may_leave_nothing),
        cmocka_unit_test(separators_have_the_same_bits_in_both_kernels),
        cmocka_unit_test(a_shaft_holds_every_segment_between_two_boxes),
        cmocka_unit_test(boxes_against_packed_planes),
        cmocka_unit_test(the_cone_tells_stabbed_from_empty),
        cmocka_unit_test(a_fan_that_turns_back_is_empty),
        cmocka_unit_test(the_filter_never_contradicts_exact_arithmetic),
        cmocka_unit_test(pair_states_are_found_in_both_directions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
