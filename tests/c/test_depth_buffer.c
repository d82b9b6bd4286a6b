/* SPDX-License-Identifier: GPL-3.0-or-later
 * The software depth buffer against rays: what a ray reaches may never be called hidden. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "from_point/depth_buffer.h"

#include <math.h>
#include <string.h>

typedef struct Random {
    uint64_t state;
} Random;
static double unit(Random *r) {
    r->state = r->state * 6364136223846793005u + 1442695040888963407u;
    return (double)(r->state >> 11) * 0x1p-53;
}
static double between(Random *r, double lo, double hi) {
    return lo + (hi - lo) * unit(r);
}

static const double screen[4] = {-1.0, 1.0, -0.5625, 0.5625};
static const double wall[4][3] = {{-1, -1, -2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, -2}};

static EnfDepthBuffer *buffer_of(uint32_t w, uint32_t h) {
    EnfDepthBuffer *b = NULL;
    assert_int_equal(enf_depth_buffer_create(w, h, &b), ENF_OK);
    enf_depth_buffer_begin(b, screen, 0, 1);
    return b;
}

static int box_visible(EnfDepthBuffer *b, double x0, double y0, double z0, double x1, double y1, double z1) {
    const double lo[3] = {x0, y0, z0}, hi[3] = {x1, y1, z1};
    double points[8][3];
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            points[i][k] = (i >> k) & 1 ? hi[k] : lo[k];
    return enf_depth_buffer_visible(b, points, 8, NULL);
}

static void a_wall_hides_what_stands_behind_it_and_nothing_else(void **state) {
    (void)state;
    EnfDepthBuffer *b = buffer_of(256, 144);
    enf_depth_buffer_occlude(b, wall, 4);
    assert_false(box_visible(b, -0.5, -0.5, -5, 0.5, 0.5, -4));
    assert_true(box_visible(b, -0.5, -0.5, -1.9, 0.5, 0.5, -1.5));
    assert_true(box_visible(b, 2.2, -0.5, -5, 3.5, 0.5, -4));
    assert_true(box_visible(b, -0.5, -0.5, -3, 0.5, 0.5, -1)); /* it stands through the wall */
    enf_depth_buffer_destroy(b);
}

static void a_surface_does_not_hide_what_lies_in_it(void **state) {
    (void)state;
    EnfDepthBuffer *b = buffer_of(256, 144);
    enf_depth_buffer_occlude(b, wall, 4);
    assert_true(box_visible(b, -0.5, -0.5, -2, 0.5, 0.5, -2));
    enf_depth_buffer_destroy(b);
}

static void a_gap_narrower_than_a_pixel_keeps_things_visible(void **state) {
    (void)state;
    EnfDepthBuffer *b = buffer_of(256, 144);
    const double left[4][3] = {{-4, -4, -2}, {-1e-6, -4, -2}, {-1e-6, 4, -2}, {-4, 4, -2}};
    const double right[4][3] = {{1e-6, -4, -2}, {4, -4, -2}, {4, 4, -2}, {1e-6, 4, -2}};
    enf_depth_buffer_occlude(b, left, 4);
    enf_depth_buffer_occlude(b, right, 4);
    assert_true(box_visible(b, -0.5, -0.5, -5, 0.5, 0.5, -4));
    enf_depth_buffer_destroy(b);
}

static void occluders_around_the_eye_and_bad_numbers_are_harmless(void **state) {
    (void)state;
    EnfDepthBuffer *b = buffer_of(64, 40);
    const double around[4][3] = {{-1, -1, 2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, 2}};
    const double nothing[4][3] = {{NAN, -1, -2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, -2}};
    const double point[3][3] = {{0, 0, -1}, {0, 0, -1}, {0, 0, -1}};
    enf_depth_buffer_occlude(b, nothing, 4);
    enf_depth_buffer_occlude(b, point, 3);
    assert_int_equal(enf_depth_buffer_stats(b).occluders_dropped, 2);
    enf_depth_buffer_occlude(b, around, 4);
    assert_true(box_visible(b, -0.2, -0.2, -0.1, 0.2, 0.2, 0.3));
    assert_true(box_visible(b, -0.2, -INFINITY, -3, 0.2, 0.2, -2));
    enf_depth_buffer_destroy(b);
}

/* Whether the segment from the eye to p is stopped by the triangle (Moeller and Trumbore 1997): an oracle of its own. */
static int ray_blocked(const double t[3][3], const double p[3]) {
    double e1[3], e2[3], q[3], h[3];
    for (int k = 0; k < 3; k++)
        e1[k] = t[1][k] - t[0][k], e2[k] = t[2][k] - t[0][k];
    for (int k = 0; k < 3; k++)
        h[k] = p[(k + 1) % 3] * e2[(k + 2) % 3] - p[(k + 2) % 3] * e2[(k + 1) % 3];
    double det = e1[0] * h[0] + e1[1] * h[1] + e1[2] * h[2];
    if (det == 0)
        return 0;
    double s[3] = {-t[0][0], -t[0][1], -t[0][2]};
    double u = (s[0] * h[0] + s[1] * h[1] + s[2] * h[2]) / det;
    for (int k = 0; k < 3; k++)
        q[k] = s[(k + 1) % 3] * e1[(k + 2) % 3] - s[(k + 2) % 3] * e1[(k + 1) % 3];
    double v = (p[0] * q[0] + p[1] * q[1] + p[2] * q[2]) / det;
    double w = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && w > 0 && w < 1;
}

static void nothing_that_a_ray_reaches_is_called_hidden(void **state) {
    (void)state;
    Random r = {7};
    EnfDepthBuffer *b = buffer_of(160, 90);
    uint64_t hidden = 0, reached = 0;
    for (int round = 0; round < 60; round++) {
        double triangles[40][3][3];
        enf_depth_buffer_begin(b, screen, 0, round & 1);
        for (int i = 0; i < 40; i++) {
            double c[3] = {between(&r, -3, 3), between(&r, -2, 2), between(&r, -6, -0.3)}, size = between(&r, 0.01, 3);
            for (int a = 0; a < 3; a++)
                for (int k = 0; k < 3; k++)
                    triangles[i][a][k] = c[k] + between(&r, -size, size);
            enf_depth_buffer_occlude(b, triangles[i], 3);
        }
        for (int i = 0; i < 200; i++) {
            /* on the screen, so that hidden means behind something */
            double z = between(&r, -9, -0.8), size = between(&r, 0.001, 0.4);
            double c[3] = {between(&r, -0.9, 0.9) * -z, between(&r, -0.5, 0.5) * -z, z}, lo[3], hi[3];
            for (int k = 0; k < 3; k++)
                lo[k] = c[k] - size, hi[k] = c[k] + size;
            if (box_visible(b, lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]))
                continue;
            hidden++;
            for (int ray = 0; ray < 100; ray++) {
                double p[3] = {between(&r, lo[0], hi[0]), between(&r, lo[1], hi[1]), between(&r, lo[2], hi[2])};
                double x = p[0] / -p[2], y = p[1] / -p[2];
                int blocked = x < screen[0] || x > screen[1] || y < screen[2] || y > screen[3];
                for (int k = 0; k < 40 && !blocked; k++)
                    blocked = ray_blocked(triangles[k], p);
                reached += !blocked;
            }
        }
    }
    assert_true(hidden > 1000); /* it does hide */
    assert_int_equal(reached, 0);
    enf_depth_buffer_destroy(b);
}

static void scalar_and_simd_write_equal_bits(void **state) {
    (void)state;
    EnfDepthBuffer *a = buffer_of(333, 77), *b = buffer_of(333, 77);
    uint32_t w, h;
    Random r = {3};
    enf_depth_buffer_begin(b, screen, 0, 0);
    for (int i = 0; i < 500; i++) {
        double t[3][3];
        for (int c = 0; c < 3; c++)
            t[c][0] = between(&r, -3, 3), t[c][1] = between(&r, -2, 2), t[c][2] = between(&r, -6, 0.2);
        enf_depth_buffer_occlude(a, t, 3);
        enf_depth_buffer_occlude(b, t, 3);
    }
    const float *pa = enf_depth_buffer_pixels(a, &w, &h), *pb = enf_depth_buffer_pixels(b, &w, &h);
    assert_memory_equal(pa, pb, sizeof(float) * w * h);
    enf_depth_buffer_destroy(a);
    enf_depth_buffer_destroy(b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wall_hides_what_stands_behind_it_and_nothing_else),
        cmocka_unit_test(a_surface_does_not_hide_what_lies_in_it),
        cmocka_unit_test(a_gap_narrower_than_a_pixel_keeps_things_visible),
        cmocka_unit_test(occluders_around_the_eye_and_bad_numbers_are_harmless),
        cmocka_unit_test(nothing_that_a_ray_reaches_is_called_hidden),
        cmocka_unit_test(scalar_and_simd_write_equal_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
