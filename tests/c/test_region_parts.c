/* SPDX-License-Identifier: GPL-3.0-or-later
 * The parts of the from-region engine by themselves: side products, separating planes and clips, the stabbing cone, pair rows. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
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

static double over(const EnfHalfspaces *planes, uint32_t i, const double p[3]) {
    return planes->x[i] * p[0] + planes->y[i] * p[1] + planes->z[i] * p[2] - planes->d[i];
}

static void separating_planes_bound_the_view_beyond(void **state) {
    (void)state;
    const EnfSeparatorKernel *kernel = enf_separator_kernel();
    const double along[3] = {0, 1, 0};
    EnfWindow source = square(0, 0, 0.1, 0), pass = square(0, 0, 0.1, 0.2);
    EnfHalfspaces planes;
    planes.count = 0;
    uint64_t which = kernel->separators(&source, along, &pass, along, 1, &planes);
    assert_int_equal(enf_popcount64(which), 4); /* edges in line: each plane once */
    /* At y = 0.4 the view is the square from -0.1 to 0.2: points of it keep, points outside fall to some plane. */
    double x[4] = {-0.0999, 0.1999, -0.101, 0.201};
    for (int k = 0; k < 4; ++k) {
        double p[3] = {x[k], 0.4, 0.05};
        int outside = 0;
        for (uint32_t i = 0; i < planes.count; ++i)
            outside |= over(&planes, i, p) < 0;
        assert_int_equal(outside, k >= 2);
    }
    /* Looking back through pass, from a window beyond, on the source's plane. */
    EnfWindow beyond = square(0, 0, 0.1, 0.4);
    planes.count = 0;
    which = kernel->separators(&beyond, along, &pass, along, -1, &planes);
    EnfWindow wide = square(-0.5, -0.5, 1, 0);
    int clipped = 0;
    assert_true(kernel->clip_all(&wide, &planes, which, &clipped));
    assert_true(clipped);
    assert_int_equal(wide.count, 4);
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
    EnfHalfspaces planes;
    planes.count = 0;
    (void)enf_separator_kernel()->separators(&source, n0, &pass, n1, 1, &planes);
    const double seen[3] = {0.2, 0.05, 0.05}; /* from (0.05, 0, 0.05) through (0.1, 1 / 60, 0.05) */
    for (uint32_t i = 0; i < planes.count; ++i)
        assert_true(over(&planes, i, seen) >= 0);
}

static void windows_that_cross_give_no_planes_and_a_clip_may_leave_nothing(void **state) {
    (void)state;
    const EnfSeparatorKernel *kernel = enf_separator_kernel();
    const double n0[3] = {0, 1, 0}, n1[3] = {1, 0, 0}, gone[4] = {1, 0, 0, 0.2};
    EnfHalfspaces planes;
    planes.count = 0;
    EnfWindow w = square(0, 0, 0.1, 0);
    EnfWindow through = {4, 15, {0.05, 0.05, 0.05, 0.05}, {-0.1, 0.1, 0.1, -0.1}, {0, 0, 0.1, 0.1}};
    enf_window_wrap(&through);
    assert_int_equal(kernel->separators(&w, n0, &through, n1, 1, &planes), 0);
    int clipped = 0;
    assert_false(kernel->clip(&w, gone, &clipped));
}

/* A convex window of up to `corners` corners in a plane through `at`; its normal in `n`. */
static EnfWindow random_window(uint64_t *random, uint32_t corners, double at, double n[3]) {
    EnfWindow w = {.count = 3 + (uint32_t)(enf_mix_unit(random) * (corners - 2)), .own = 0x5A5A5A5Au};
    double size = 0.02 + 0.2 * enf_mix_unit(random), cx = 0.3 * enf_mix_unit(random), cz = 0.3 * enf_mix_unit(random);
    double slope = enf_mix_unit(random) < 0.5 ? 0 : 0.3 * (enf_mix_unit(random) - 0.5), turn = 6.283 * enf_mix_unit(random);
    if (w.count == 4 && enf_mix_unit(random) < 0.5)
        turn = 0.25 * 3.14159265358979; /* edges along the axes: planes in line */
    for (uint32_t i = 0; i < w.count; ++i) {
        double a = turn - 6.283185307179586 * i / w.count; /* counter-clockwise about +y */
        double x = cx + size * cos(a), z = cz + size * sin(a), corner[3] = {x, at + slope * (x - cx), z};
        enf_window_put(&w, i, corner);
    }
    double length = sqrt(1 + slope * slope);
    n[0] = -slope / length, n[1] = 1 / length, n[2] = 0;
    w.own &= ((uint32_t)1 << w.count) - 1;
    enf_window_wrap(&w);
    return w;
}

static void assert_same_windows(const EnfWindow *a, const EnfWindow *b) {
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->own, b->own);
    size_t bytes = (a->count + 1) * sizeof *a->x;
    assert_memory_equal(a->x, b->x, bytes);
    assert_memory_equal(a->y, b->y, bytes);
    assert_memory_equal(a->z, b->z, bytes);
}

/* The plain kernel against one of the others: equal bits in all they give; and every plane keeps each window on its side. */
static void compare_kernels(const EnfSeparatorKernel *other) {
    const EnfSeparatorKernel *plain = &enf_separators_plain;
    uint64_t random = 3, cuts = 0, kept = 0, gone = 0, left_by = 0;
    for (int round = 0; round < 4000; ++round) {
        double n0[3], n1[3], n2[3];
        uint32_t corners = round & 1 ? 6 : 14;
        EnfWindow source = random_window(&random, corners, 0, n0),
                  pass = random_window(&random, corners, 0.1 + 0.2 * enf_mix_unit(&random), n1);
        EnfWindow far_a = random_window(&random, corners, 0.6, n2), far_b = far_a;
        EnfHalfspaces a, b;
        a.count = b.count = 0;
        enf_halfspaces_add(&a, n1[0], n1[1], n1[2], 0.05), enf_halfspaces_add(&b, n1[0], n1[1], n1[2], 0.05);
        uint64_t which = plain->separators(&source, n0, &pass, n1, 1, &a);
        assert_int_equal(other->separators(&source, n0, &pass, n1, 1, &b), which);
        assert_int_equal(a.count, b.count);
        plain->round(&a, 0), other->round(&b, 0);
        assert_memory_equal(a.x, b.x, a.count * sizeof *a.x);
        assert_memory_equal(a.y, b.y, a.count * sizeof *a.y);
        assert_memory_equal(a.z, b.z, a.count * sizeof *a.z);
        assert_memory_equal(a.d, b.d, a.count * sizeof *a.d);
        for (int k = 0; k < 4; ++k)
            assert_memory_equal(a.single[k], b.single[k], (a.count + ENF_HALFSPACES_NULL) * sizeof **a.single);
        for (uint64_t bits = which; bits; bits &= bits - 1)
            for (uint32_t k = 0; k < pass.count; ++k) {
                const double p[3] = {pass.x[k], pass.y[k], pass.z[k]};
                assert_true(over(&a, enf_lowest_bit64(bits), p) >= 0);
            }
        int clipped_a = 0, clipped_b = 0, left = plain->clip_all(&far_a, &a, which, &clipped_a);
        assert_int_equal(other->clip_all(&far_b, &b, which, &clipped_b), left);
        assert_int_equal(clipped_a, clipped_b);
        cuts += clipped_a && left, gone += !left;
        if (left) {
            assert_same_windows(&far_a, &far_b);
            const double plane[4] = {0.6, 0, 0.8, 0.6 * far_a.x[0] + 0.8 * far_a.z[0] + 0.01};
            left = plain->clip(&far_a, plane, &clipped_a);
            assert_int_equal(other->clip(&far_b, plane, &clipped_b), left);
            if (left)
                assert_same_windows(&far_a, &far_b);
        }
        float boxes[11][6];
        EnfPlaneGroup groups[2] = {0};
        uint32_t places[11];
        for (uint32_t k = 0; k < 11; ++k) {
            for (int c = 0; c < 6; ++c)
                boxes[k][c] = (float)((c < 3 ? 0.6 : 0.1) * enf_mix_unit(&random));
            places[k] = (7 * k) % 11;
            EnfPlaneGroup *g = &groups[k / ENF_GROUP];
            g->x[k % ENF_GROUP] = (float)enf_mix_unit(&random) - 0.5f, g->y[k % ENF_GROUP] = (float)enf_mix_unit(&random) - 0.5f;
            g->z[k % ENF_GROUP] = (float)enf_mix_unit(&random) - 0.5f, g->d[k % ENF_GROUP] = (float)enf_mix_unit(&random) * 0.3f;
        }
        const float at[6] = {0.2f, 0.1f, 0.3f, 0.1f, 0.05f, 0.2f}, to[6] = {0.1f, 0.4f, 0.2f, 0.2f, 0.1f, 0.15f};
        uint64_t ways = plain->ways(&a, groups, (const float(*)[6])boxes, 11, 1, at, to), facing = plain->facing(groups, 11, 1, at, to);
        assert_int_equal(other->ways(&b, groups, (const float(*)[6])boxes, 11, 1, at, to), ways);
        assert_int_equal(other->facing(groups, 11, -1, at, to), plain->facing(groups, 11, -1, at, to));
        uint64_t leaving = plain->leaving(groups, 11, 1, at, to);
        assert_int_equal(other->leaving(groups, 11, 1, at, to), leaving);
        left_by += leaving != 0 && leaving != 0x7FF;
        uint64_t touching = plain->touching(&a, (const float(*)[6])boxes, places, 11);
        assert_int_equal(other->touching(&b, (const float(*)[6])boxes, places, 11), touching);
        for (uint32_t k = 0; k < 11; ++k) {
            uint64_t cuts_a = 0, cuts_b = 0;
            int touches = plain->touches(&a, boxes[places[k]], &cuts_a);
            assert_int_equal(other->touches(&b, boxes[places[k]], &cuts_b), touches);
            assert_int_equal(cuts_a, cuts_b);
            assert_int_equal(touches, touching >> k & 1);
            assert_int_equal(ways >> places[k] & 1, touches & (facing >> places[k] & 1));
        }
        kept += (uint64_t)enf_popcount64(touching);
    }
    assert_true(cuts > 400 && gone > 100 && kept > 4000 && kept < 40000 && left_by > 2000);
}

static void kernels_have_the_same_bits(void **state) {
    (void)state;
    if (enf_separator_kernel() == &enf_separators_plain)
        skip();
    compare_kernels(enf_separator_kernel());
    if (enf_separators_avx2)
        compare_kernels(enf_separators_avx2);
}

static void a_shaft_holds_every_segment_between_two_boxes(void **state) {
    (void)state;
    uint64_t random = 11;
    uint32_t left_out = 0;
    for (int round = 0; round < 200; ++round) {
        double a[6], b[6];
        EnfHalfspaces planes;
        for (int k = 0; k < 3; ++k) {
            a[k] = enf_mix_unit(&random) - 0.5, a[k + 3] = a[k] + (round & 1 ? 0 : 0.2 * enf_mix_unit(&random));
            b[k] = enf_mix_unit(&random) - 0.5, b[k + 3] = b[k] + 0.2 * enf_mix_unit(&random);
        }
        planes.count = 0;
        enf_shaft(a, b, &planes);
        for (int i = 0; i < 50; ++i) {
            double t = enf_mix_unit(&random), p[3], away[3];
            int outside = 0;
            for (int k = 0; k < 3; ++k) {
                double from = a[k] + enf_mix_unit(&random) * (a[k + 3] - a[k]), to = b[k] + enf_mix_unit(&random) * (b[k + 3] - b[k]);
                p[k] = from + t * (to - from), away[k] = enf_mix_unit(&random) - 0.5;
            }
            for (uint32_t n = 0; n < planes.count; ++n) {
                assert_true(over(&planes, n, p) >= 0);
                outside |= over(&planes, n, away) < 0;
            }
            left_out += (uint32_t)outside;
        }
    }
    assert_true(left_out > 8000); /* of 10,000 points of the unit cube */
}

static void boxes_against_planes(void **state) {
    (void)state;
    EnfHalfspaces planes;
    planes.count = 0;
    enf_halfspaces_add(&planes, 1, 0, 0, 0), enf_halfspaces_add(&planes, 0, 1, 0, 0), enf_halfspaces_add(&planes, 0, 0, 1, 0);
    enf_halfspaces_add(&planes, -1, 0, 0, -1), enf_halfspaces_add(&planes, 0, -1, 0, -1);
    const float boxes[4][6] = {{0.5f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f},
                               {-0.1f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f},
                               {-0.2f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f},
                               {0.5f, 1.3f, 0.5f, 0.1f, 0.1f, 0.1f}};
    const uint32_t all[4] = {0, 1, 2, 3};
    const EnfSeparatorKernel *kernel = enf_separator_kernel();
    kernel->round(&planes, 0);
    assert_int_equal(kernel->touching(&planes, boxes, all, 4), 3); /* inside, touching; outside, outside of the fifth */
    uint64_t cuts;
    assert_true(kernel->touches(&planes, boxes[0], &cuts));
    assert_int_equal(cuts, 0);
    assert_true(kernel->touches(&planes, boxes[1], &cuts));
    assert_int_equal(cuts, 1);
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

/* Memory that has ended: GMP would end the process when it asked for some. */
static int refuse;
static void *alloc_or_refuse(void *user, size_t size) {
    (void)user;
    return refuse ? NULL : malloc(size);
}
static void give_back(void *user, void *pointer, size_t size) {
    (void)user, (void)size;
    free(pointer);
}

/* The filter against exact arithmetic: rows and rays of random and of small whole numbers, where many products are 0. */
static void the_filter_never_contradicts_exact_arithmetic(void **state) {
    (void)state;
    assert_int_equal(enf_set_allocator(alloc_or_refuse, give_back, NULL), ENF_OK);
    EnfStabCone *cone = enf_cone_create();
    refuse = 1;
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
            (void)enf_exact_changes_between(cone, a, a + 1);
        }
        assert_false(cone->too_long);
    }
    assert_true(sure > 10000 && zeros > 1000);
    enf_cone_destroy(cone);
    refuse = 0;
    assert_int_equal(enf_set_allocator(NULL, NULL, NULL), ENF_OK);
}

/* Coordinates at the limit of +-2, of as many bits as they can have, keep their places; far beyond it the cone says that it can't tell. */
static void whole_numbers_have_room(void **state) {
    (void)state;
    EnfStabCone *cone = enf_cone_create();
    for (int beyond = 0; beyond < 2; ++beyond) {
        uint64_t random = 3;
        double line[6];
        int most = beyond ? 40 : 2; /* powers of two: all below it, so that numbers have many bits */
        uint32_t refused = 0;
        for (int round = 0; round < 60; ++round) {
            enf_cone_begin(cone);
            for (int i = 0; i < 12; ++i) {
                double a[3], b[3];
                for (int k = 0; k < 3; ++k) {
                    a[k] = ldexp(2 * enf_mix_unit(&random) - 1, (7 * i + 3 * k) % most),
                    b[k] = ldexp(2 * enf_mix_unit(&random) - 1, (5 * i + 11 * k) % most);
                }
                enf_cone_add_edge(cone, a, b);
            }
            int answer = enf_cone_solve(cone, line);
            for (uint32_t row = 0; row < cone->row_count; ++row)
                for (uint32_t ray = 0; ray < cone->ray_count; ++ray) {
                    double v, e;
                    (void)enf_exact_row_sign(cone, row, ray, &v, &e);
                }
            refused += cone->too_long;
            assert_true(beyond || answer != ENF_CONE_UNKNOWN || cone->lineality_count);
        }
        assert_int_equal(refused > 0, beyond);
    }
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
        cmocka_unit_test(kernels_have_the_same_bits),
        cmocka_unit_test(a_shaft_holds_every_segment_between_two_boxes),
        cmocka_unit_test(boxes_against_planes),
        cmocka_unit_test(the_cone_tells_stabbed_from_empty),
        cmocka_unit_test(a_fan_that_turns_back_is_empty),
        cmocka_unit_test(the_filter_never_contradicts_exact_arithmetic),
        cmocka_unit_test(whole_numbers_have_room),
        cmocka_unit_test(pair_states_are_found_in_both_directions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
