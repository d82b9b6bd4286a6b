/* SPDX-License-Identifier: GPL-3.0-or-later
 * Voxels against slow oracles that share nothing with them: marks by clipping each triangle to each cube, labels by flooding from
 * every voxel, growth by relaxing until nothing changes; and what they refuse. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 9, TOTAL = SIDE * SIDE * SIDE };
static const uint32_t size[3] = {SIDE, SIDE, SIDE};

static uint32_t seed = 1;
static double random_number(double low, double high) {
    seed = seed * 1664525u + 1013904223u;
    return low + (high - low) * (double)(seed >> 8) / 16777216.0;
}

/* Whether a triangle has a point in the cube of side 1 + 2 margin about voxel (x, y, z), by clipping it to the six sides. */
static int triangle_meets(const double t[9], const uint32_t at[3], double margin) {
    double ring[2][12][3];
    int count = 3, from = 0;
    memcpy(ring[0], t, 9 * sizeof(double));
    for (int side = 0; side < 6 && count; side++) {
        int axis = side / 2, kept = 0;
        double sign = side % 2 ? 1 : -1, limit = side % 2 ? at[axis] + 1 + margin : -((double)at[axis] - margin);
        for (int i = 0; i < count; i++) {
            const double *a = ring[from][i], *b = ring[from][(i + 1) % count];
            double da = sign * a[axis] - limit, db = sign * b[axis] - limit;
            if (da <= 0)
                memcpy(ring[1 - from][kept++], a, sizeof ring[0][0]);
            if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
                for (int k = 0; k < 3; k++)
                    ring[1 - from][kept][k] = a[k] + (b[k] - a[k]) * da / (da - db);
                kept++;
            }
        }
        count = kept;
        from = 1 - from;
    }
    return count > 0;
}

static void marks_are_the_cubes_that_triangles_touch(void **state) {
    (void)state;
    const double origin[3] = {0, 0, 0};
    const uint32_t corners[3] = {0, 1, 2};
    for (int round = 0; round < 400; round++) {
        double t[9];
        uint8_t voxels[TOTAL] = {0};
        int whole = round % 4 == 0, flat = round % 4 == 1, thin = round % 8 == 2; /* on cubes' corners; level; slivers */
        for (int i = 0; i < 9; i++)
            t[i] = whole ? floor(random_number(-2, SIDE + 2)) : random_number(-3, SIDE + 3);
        if (flat)
            t[2] = t[5] = t[8] = round % 8 == 1 ? 4.0 : 4.3;
        if (thin)
            for (int k = 0; k < 3; k++)
                t[6 + k] = t[k] + 0.5 * (t[3 + k] - t[k]);
        assert_int_equal(enf_voxels_mark(size, origin, 1.0, t, 3, 0, corners, 1, 4, voxels), ENF_OK);
        for (uint32_t v = 0; v < TOTAL; v++) {
            const uint32_t at[3] = {v % SIDE, v / SIDE % SIDE, v / (SIDE * SIDE)};
            if (voxels[v])
                assert_true(triangle_meets(t, at, 1e-6)); /* nothing beyond rounding is marked */
            else
                assert_false(triangle_meets(t, at, 0.0)); /* nothing touched is left out */
        }
    }
}

static void marks_keep_other_bits_and_follow_origin_step_and_stride(void **state) {
    (void)state;
    const double origin[3] = {100, -50, 7};
    const double vertices[3][4] = {{100.3, -49.7, 7.3, 9}, {100.3, -49.4, 7.3, 9}, {100.4, -49.7, 7.3, 9}};
    const uint32_t corners[3] = {0, 1, 2};
    uint8_t voxels[TOTAL];
    memset(voxels, 1, sizeof voxels);
    assert_int_equal(enf_voxels_mark(size, origin, 0.2, &vertices[0][0], 3, sizeof vertices[0], corners, 1, 6, voxels), ENF_OK);
    assert_int_equal(voxels[1 + SIDE * (1 + SIDE * 1)], 7);
    assert_int_equal(voxels[0], 1);
    assert_int_equal(voxels[5 + SIDE * (1 + SIDE * 1)], 1);
}

static void far_and_huge_triangles_leave_no_gap(void **state) {
    (void)state;
    const double origin[3] = {0, 0, 0};
    const uint32_t corners[3] = {0, 1, 2};
    for (double far = 1e3; far <= 1e300; far *= 1e11) { /* a wall through the middle, whose corners lie far away */
        double wall[9] = {-far, 4.5, -far, far, 4.5, -far, 0, 4.5, far};
        uint8_t voxels[TOTAL] = {0};
        assert_int_equal(enf_voxels_mark(size, origin, 1.0, wall, 3, 0, corners, 1, 1, voxels), ENF_OK);
        for (uint32_t v = 0; v < TOTAL; v++)
            if (v / SIDE % SIDE == 4)
                assert_int_equal(voxels[v], 1);
    }
}

/* Three corners on one line but for rounding: the normal is noise, and may not decide which voxels are asked. */
static void slivers_leave_no_gap(void **state) {
    (void)state;
    const double origin[3] = {0, 0, 0};
    const uint32_t corners[3] = {0, 1, 2};
    for (int round = 0; round < 4000; round++) {
        double t[9], share = random_number(-1, 2);
        uint8_t voxels[TOTAL] = {0};
        for (int k = 0; k < 3; k++) {
            double reach = round % 2 ? 1000 : 10;
            t[k] = random_number(-reach, reach);
            t[3 + k] = SIDE * random_number(0, 1) * 2 - t[k]; /* half way it is in the grid */
            t[6 + k] = t[k] + share * (t[3 + k] - t[k]);
        }
        assert_int_equal(enf_voxels_mark(size, origin, 1.0, t, 3, 0, corners, 1, 1, voxels), ENF_OK);
        for (int i = 0; i <= 2000; i++) {
            uint32_t at[3];
            int inside = 1;
            for (int k = 0; k < 3; k++) {
                double x = t[k] + (t[3 + k] - t[k]) * i / 2000;
                inside &= x > 1e-9 && x < SIDE && fabs(x - nearbyint(x)) > 1e-9;
                at[k] = inside ? (uint32_t)x : 0;
            }
            if (inside && !voxels[at[0] + SIDE * (at[1] + SIDE * at[2])])
                fail_msg("round %d: a point of the triangle lies in voxel (%u, %u, %u), which isn't marked", round, at[0], at[1], at[2]);
        }
    }
}

static void a_closed_house_turned_anyhow_lets_nothing_out(void **state) {
    (void)state;
    static const uint32_t faces[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                       2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    const double origin[3] = {0, 0, 0};
    for (int turn = 0; turn < 90; turn++) {
        double corners[24], c = cos(turn * 0.0349), s = sin(turn * 0.0349);
        uint8_t voxels[TOTAL] = {0}, air[TOTAL];
        uint32_t labels[TOTAL], count = 0;
        for (int i = 0; i < 8; i++) {
            double x = i & 1 ? 2.4 : -2.4, y = i & 2 ? 2.2 : -2.2, z = i & 4 ? 2.0 : -2.0;
            double u = c * x - s * y, w = s * x + c * y;
            corners[3 * i] = 4.5 + u;
            corners[3 * i + 1] = 4.5 + c * w - s * z * 0.5;
            corners[3 * i + 2] = 4.5 + s * 0.5 * w + c * z * 0.5 + z * 0.3;
        }
        assert_int_equal(enf_voxels_mark(size, origin, 1.0, corners, 8, 0, faces, 12, 1, voxels), ENF_OK);
        for (uint32_t v = 0; v < TOTAL; v++)
            air[v] = !voxels[v];
        assert_int_equal(enf_voxels_label(size, air, labels, &count), ENF_OK);
        uint32_t middle = labels[4 + SIDE * (4 + SIDE * 4)];
        if (middle)
            for (uint32_t v = 0; v < TOTAL; v++) {
                const uint32_t at[3] = {v % SIDE, v / SIDE % SIDE, v / (SIDE * SIDE)};
                for (int a = 0; a < 3; a++)
                    if (at[a] == 0 || at[a] == SIDE - 1)
                        assert_int_not_equal(labels[v], middle);
            }
    }
}

/* Neighbours by faces; gives how many. */
static int around(uint32_t v, uint32_t out[6]) {
    const uint32_t at[3] = {v % SIDE, v / SIDE % SIDE, v / (SIDE * SIDE)}, stride[3] = {1, SIDE, SIDE * SIDE};
    int count = 0;
    for (int a = 0; a < 3; a++) {
        if (at[a] > 0)
            out[count++] = v - stride[a];
        if (at[a] + 1 < SIDE)
            out[count++] = v + stride[a];
    }
    return count;
}

static void labels_are_what_flooding_gives(void **state) {
    (void)state;
    for (int round = 0; round < 60; round++) {
        uint8_t kinds[TOTAL];
        uint32_t labels[TOTAL], expected[TOTAL] = {0}, stack[TOTAL], beside[6], count = 0, regions = 0;
        for (uint32_t v = 0; v < TOTAL; v++)
            kinds[v] = (uint8_t)random_number(0, 1.6 + round % 3);
        for (uint32_t v = 0; v < TOTAL; v++) {
            uint32_t height = 0;
            if (!kinds[v] || expected[v])
                continue;
            expected[v] = ++regions;
            stack[height++] = v;
            while (height) {
                uint32_t w = stack[--height];
                for (int i = around(w, beside); i-- > 0;)
                    if (kinds[beside[i]] == kinds[v] && !expected[beside[i]]) {
                        expected[beside[i]] = regions;
                        stack[height++] = beside[i];
                    }
            }
        }
        assert_int_equal(enf_voxels_label(size, kinds, labels, &count), ENF_OK);
        assert_int_equal(count, regions);
        assert_memory_equal(labels, expected, sizeof labels);
    }
}

static void growth_is_what_relaxing_gives(void **state) {
    (void)state;
    for (int round = 0; round < 60; round++) {
        uint8_t passable[TOTAL];
        uint32_t labels[TOTAL], expected[TOTAL], beside[6], steps = (uint32_t)round % 5;
        for (uint32_t v = 0; v < TOTAL; v++) {
            passable[v] = random_number(0, 1) < 0.7;
            expected[v] = labels[v] = random_number(0, 1) < 0.02 ? 1 + (uint32_t)random_number(0, 5) : 0;
        }
        for (uint32_t s = 0, changed = 1; changed && (!steps || s < steps); s++) {
            uint32_t before[TOTAL];
            memcpy(before, expected, sizeof before);
            changed = 0;
            for (uint32_t v = 0; v < TOTAL; v++)
                for (int i = before[v] || !passable[v] ? 0 : around(v, beside); i-- > 0;)
                    if (before[beside[i]] && (!expected[v] || before[beside[i]] < expected[v]))
                        expected[v] = before[beside[i]], changed = 1;
        }
        assert_int_equal(enf_voxels_grow(size, passable, steps, labels), ENF_OK);
        assert_memory_equal(labels, expected, sizeof labels);
    }
}

static void boxes_are_what_looking_at_each_voxel_gives(void **state) {
    (void)state;
    enum { LABELS = 7 };
    for (int round = 0; round < 60; round++) {
        uint32_t labels[TOTAL], expected[LABELS + 1][6], boxes[LABELS + 1][6];
        for (int l = 0; l <= LABELS; l++)
            for (int a = 0; a < 6; a++)
                expected[l][a] = a < 3 ? ENF_NONE : 0;
        for (uint32_t v = 0; v < TOTAL; v++) {
            labels[v] = random_number(0, 1) < 0.01 * round ? (uint32_t)random_number(0, LABELS) : 0; /* the last stands nowhere */
            const uint32_t at[3] = {v % SIDE, v / SIDE % SIDE, v / (SIDE * SIDE)};
            for (int a = 0; a < 3; a++) {
                uint32_t *box = expected[labels[v]];
                box[a] = at[a] < box[a] ? at[a] : box[a];
                box[3 + a] = at[a] >= box[3 + a] ? at[a] + 1 : box[3 + a];
            }
        }
        assert_int_equal(enf_voxels_boxes(size, labels, LABELS, &boxes[0][0]), ENF_OK);
        assert_memory_equal(boxes, expected, sizeof boxes);
    }
}

static void runs_and_widened_masks_are_what_walking_gives(void **state) {
    (void)state;
    const uint32_t tall[3] = {1, 2, 300};
    static uint8_t shaft[600], below[600], over[600];
    for (int round = 0; round < 60; round++) {
        uint8_t blocked[TOTAL], mask[TOTAL], down[TOTAL], up[TOTAL], reach[3];
        for (int a = 0; a < 3; a++)
            reach[a] = (uint8_t)random_number(0, a + 2.5);
        for (uint32_t v = 0; v < TOTAL; v++)
            mask[v] = blocked[v] = random_number(0, 1) < 0.02 * (round % 8) ? 4 : 0;
        assert_int_equal(enf_voxels_runs(size, blocked, down, up), ENF_OK);
        assert_int_equal(enf_voxels_widen(size, reach, mask), ENF_OK);
        for (int v = 0; v < TOTAL; v++) {
            const int x = v % SIDE, y = v / SIDE % SIDE, z = v / (SIDE * SIDE);
            int under = 0, above = 0, near = 0;
            for (int k = z; k >= 0 && !blocked[v - (z - k) * SIDE * SIDE]; k--)
                under = k ? under + 1 : 255;
            for (int k = z; k < SIDE && !blocked[v + (k - z) * SIDE * SIDE]; k++)
                above = k < SIDE - 1 ? above + 1 : 255;
            for (int w = 0; w < TOTAL; w++)
                near |= blocked[w] && abs(w % SIDE - x) <= reach[0] && abs(w / SIDE % SIDE - y) <= reach[1] &&
                        abs(w / (SIDE * SIDE) - z) <= reach[2];
            assert_int_equal(down[v], under);
            assert_int_equal(up[v], above);
            assert_int_equal(mask[v], near);
        }
    }
    shaft[0] = shaft[598] = 1; /* one column shut below, one above: 255 is the most that is counted */
    assert_int_equal(enf_voxels_runs(tall, shaft, below, over), ENF_OK);
    assert_true(below[2] == 1 && below[2 * 200] == 200 && below[2 * 290] == 255 && over[2 * 290] == 9);
    assert_true(below[1] == 255 && over[1] == 255 && below[599] == 255);
}

static void labels_get_new_names_or_stay(void **state) {
    (void)state;
    uint32_t labels[TOTAL], expected[TOTAL];
    const uint32_t names[4] = {9, 0, 5, 5};
    for (uint32_t v = 0; v < TOTAL; v++) {
        labels[v] = v % 4;
        expected[v] = names[v % 4];
    }
    assert_int_equal(enf_voxels_rename(size, names, 3, labels), ENF_OK);
    assert_memory_equal(labels, expected, sizeof labels);
    assert_int_equal(enf_voxels_rename(size, names, 3, labels), ENF_ERROR_BAD_INPUT); /* 9 is no label of 0..3 */
    assert_memory_equal(labels, expected, sizeof labels);
}

static void bad_input_is_refused_with_the_reason(void **state) {
    (void)state;
    const double origin[3] = {0, 0, 0}, nowhere[3] = {0, NAN, 0};
    double t[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t corners[3] = {0, 1, 2}, beyond[3] = {0, 1, 3};
    const uint32_t none[3] = {4, 0, 4}, too_many[3] = {4000, 4000, 4000}, wraps[3] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    uint8_t voxels[TOTAL] = {0};
    uint32_t labels[TOTAL] = {0}, boxes[6], count = 77;
    assert_int_equal(enf_voxels_mark(size, origin, 1, t, 3, 0, corners, 0, 1, voxels), ENF_OK); /* zero triangles mark nothing */
    assert_int_equal(enf_voxels_mark(size, origin, 1, NULL, 0, 0, NULL, 0, 1, voxels), ENF_OK);
    for (uint32_t v = 0; v < TOTAL; v++)
        assert_int_equal(voxels[v], 0);
    assert_int_equal(enf_voxels_mark(size, origin, 1, t, 3, 0, corners, 1, 1, NULL), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_voxels_mark(size, origin, 1, NULL, 3, 0, corners, 1, 1, voxels), ENF_ERROR_INVALID_ARGUMENT);
    for (const uint32_t *const *bad = (const uint32_t *const[]){none, too_many, wraps, NULL}; *bad; bad++) {
        assert_int_equal(enf_voxels_mark(*bad, origin, 1, t, 3, 0, corners, 1, 1, voxels), ENF_ERROR_BAD_INPUT);
        assert_non_null(strstr(enf_last_error(), "voxels"));
        assert_int_equal(enf_voxels_label(*bad, voxels, labels, &count), ENF_ERROR_BAD_INPUT);
        assert_int_equal(enf_voxels_grow(*bad, voxels, 0, labels), ENF_ERROR_BAD_INPUT);
        assert_int_equal(enf_voxels_boxes(*bad, labels, 0, boxes), ENF_ERROR_BAD_INPUT);
        assert_int_equal(enf_voxels_runs(*bad, voxels, voxels, voxels), ENF_ERROR_BAD_INPUT);
        assert_int_equal(enf_voxels_widen(*bad, (const uint8_t[3]){1, 1, 1}, voxels), ENF_ERROR_BAD_INPUT);
        assert_int_equal(enf_voxels_rename(*bad, boxes, 0, labels), ENF_ERROR_BAD_INPUT);
    }
    assert_int_equal(count, 77);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(enf_voxels_mark(size, origin, (double[]){0, -1, NAN, INFINITY}[i], t, 3, 0, corners, 1, 1, voxels),
                         ENF_ERROR_BAD_INPUT);
        assert_non_null(strstr(enf_last_error(), "step"));
    }
    assert_int_equal(enf_voxels_mark(size, nowhere, 1, t, 3, 0, corners, 1, 1, voxels), ENF_ERROR_BAD_INPUT);
    assert_int_equal(enf_voxels_mark(size, origin, 1, t, 3, 0, beyond, 1, 1, voxels), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "triangle 0"));
    for (int i = 0; i < 3; i++) {
        t[4] = (double[]){NAN, INFINITY, -1e308}[i];
        assert_int_equal(enf_voxels_mark(size, origin, 1e-3, t, 3, 0, corners, 1, 1, voxels), ENF_ERROR_BAD_INPUT);
        assert_non_null(strstr(enf_last_error(), "vertex 1"));
    }
    assert_int_equal(enf_voxels_widen(size, (const uint8_t[3]){1, 255, 1}, voxels), ENF_ERROR_BAD_INPUT);
    labels[5] = 0x80000000u;
    assert_int_equal(enf_voxels_boxes(size, labels, 0, boxes), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "voxel 5"));
    assert_int_equal(enf_voxels_grow(size, voxels, 0, labels), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "voxel 5"));
}

/* A hook that gives out `left` more blocks. */
static int64_t left;
static void *scarce_alloc(void *user, size_t bytes) {
    (void)user;
    return left-- > 0 ? malloc(bytes) : NULL;
}
static void scarce_free(void *user, void *pointer, size_t bytes) {
    (void)user;
    (void)bytes;
    free(pointer);
}

static void memory_that_runs_out_is_told_and_leaves_whole_labels(void **state) {
    (void)state;
    const uint32_t wide[3] = {100, 100, 3};
    static uint8_t kinds[30000];
    static uint32_t labels[30000];
    uint64_t before = enf_live_bytes();
    for (uint32_t v = 0; v < 30000; v++) /* a checkerboard: as many regions as there can be */
        kinds[v] = (v + v / 100 + v / 10000) % 2;
    assert_int_equal(enf_set_allocator(scarce_alloc, scarce_free, NULL), ENF_OK);
    int failures = 0;
    for (int64_t blocks = 0; blocks < 30; blocks++) {
        uint32_t count;
        left = blocks;
        EnfStatus status = enf_voxels_label(wide, kinds, labels, &count);
        if (status == ENF_OK)
            break;
        assert_int_equal(status, ENF_ERROR_OUT_OF_MEMORY);
        failures++;
    }
    assert_true(failures > 2);
    left = 0;
    const uint8_t reach[3] = {1, 1, 1}, first = kinds[0], second = kinds[1];
    assert_int_equal(enf_voxels_widen(wide, reach, kinds), ENF_ERROR_OUT_OF_MEMORY);
    assert_true(kinds[0] == first && kinds[1] == second);
    memset(kinds, 1, sizeof kinds);
    for (int64_t blocks = 0; blocks < 30; blocks++) {
        memset(labels, 0, sizeof labels);
        labels[5050] = 3;
        left = blocks;
        EnfStatus status = enf_voxels_grow(wide, kinds, 0, labels);
        for (uint32_t v = 0; v < 30000; v++)
            assert_true(labels[v] == 3 || (status != ENF_OK && labels[v] == 0));
        if (status == ENF_OK)
            break;
        assert_int_equal(status, ENF_ERROR_OUT_OF_MEMORY);
    }
    assert_int_equal(enf_set_allocator(NULL, NULL, NULL), ENF_OK);
    assert_int_equal(enf_live_bytes(), before);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(marks_are_the_cubes_that_triangles_touch),
        cmocka_unit_test(marks_keep_other_bits_and_follow_origin_step_and_stride),
        cmocka_unit_test(far_and_huge_triangles_leave_no_gap),
        cmocka_unit_test(slivers_leave_no_gap),
        cmocka_unit_test(a_closed_house_turned_anyhow_lets_nothing_out),
        cmocka_unit_test(labels_are_what_flooding_gives),
        cmocka_unit_test(growth_is_what_relaxing_gives),
        cmocka_unit_test(boxes_are_what_looking_at_each_voxel_gives),
        cmocka_unit_test(runs_and_widened_masks_are_what_walking_gives),
        cmocka_unit_test(labels_get_new_names_or_stay),
        cmocka_unit_test(bad_input_is_refused_with_the_reason),
        cmocka_unit_test(memory_that_runs_out_is_told_and_leaves_whole_labels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
