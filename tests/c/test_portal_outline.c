/* SPDX-License-Identifier: GPL-3.0-or-later
 * Portals that the engines don't take as they are drawn: many corners become few, bent ones flat. What stands for a portal holds it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "from_point/aperture.h"
#include "from_point/view_index.h"
#include "from_region/region_model.h"
#include "geometry/vec3.h"
#include "scene/scene_data.h"
#include "stress_random.h"

#define PI 3.14159265358979323846

enum { CORNERS_MAX = 200 };

/* Two cells without shapes and the portal between them. */
static EnfScene *scene_with(const double (*corner)[3], uint32_t count) {
    EnfScene *scene = NULL;
    uint32_t room, cell, portal;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "clusters", ENF_ROOM_INTERIOR, &room), ENF_OK);
    for (int i = 0; i < 2; ++i)
        assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &cell), ENF_OK);
    assert_int_equal(enf_scene_add_portal(scene, 0, 1, corner[0], count, 0, ENF_NONE, &portal), ENF_OK);
    if (enf_scene_commit(scene) != ENF_OK)
        fail_msg("%u corners: %s", count, enf_last_error());
    return scene;
}

/* A frame that leans any way, u x v = n. */
static void any_frame(Random *dice, double u[3], double v[3], double n[3]) {
    double aside[3];
    do
        for (int k = 0; k < 3; ++k)
            n[k] = 2 * random_unit(dice) - 1, aside[k] = 2 * random_unit(dice) - 1;
    while (!(vec_normalize(n) > 0.1));
    vec_cross(u, n, aside);
    (void)vec_normalize(u);
    vec_cross(v, n, u);
}

/* Greatest distance by which a point lies outside a polygon that runs counter-clockwise about n; negative inside. */
static double beyond(const double (*polygon)[3], uint32_t count, const double n[3], const double p[3]) {
    double most = -INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
        double edge[3], out[3], r[3];
        vec_sub(edge, polygon[(i + 1) % count], polygon[i]);
        vec_cross(out, edge, n);
        (void)vec_normalize(out);
        vec_sub(r, p, polygon[i]);
        most = fmax(most, vec_dot(r, out));
    }
    return most;
}

/* Ovals of 5 to 200 corners at uneven angles; each tenth has them along the sides of a square, where a
 * kilometre away rounding leaves it convex or not. */
static void many_corners_become_few_outward(void **state) {
    (void)state;
    static double corner[CORNERS_MAX][3];
    Random dice = {31};
    uint32_t reduced = 0, squares = 0;
    for (uint32_t k = 0; k < 400; ++k) {
        uint32_t count = 5 + random_index(&dice, CORNERS_MAX - 4);
        double u[3], v[3], n[3], turn = 0, wide = 0.5 + random_unit(&dice), area[2] = {0, 0};
        any_frame(&dice, u, v, n);
        for (uint32_t i = 0; i < count; ++i, turn += 2 * PI / count) {
            double at = turn + (k % 3 ? 0.9 : 0) * PI / count * random_unit(&dice), x = cos(at), y = sin(at);
            double out = k % 10 == 9 ? fmax(fabs(x), fabs(y)) : 1, away = k % 10 == 9 ? 1000 : 1;
            vec_set(corner[i], 3 * away, -2 * away, 7 * away);
            vec_mad(corner[i], corner[i], wide * x / out, u);
            vec_mad(corner[i], corner[i], y / out, v);
        }
        EnfScene *scene = scene_with((const double(*)[3])corner, count);
        EnfViewIndex *index;
        assert_int_equal(enf_view_index_create(scene, &index), ENF_OK);
        for (uint32_t s = 0; s < 2; ++s) {
            const EnfPortalSide *side = &index->sides[s];
            const double(*given)[3] = (const double(*)[3])(index->vertices + side->vertex_first);
            double towards[3];
            vec_scale(towards, -1, side->n); /* its corners run counter-clockwise seen from the cell */
            assert_true(side->vertex_count <= ENF_PORTAL_CORNERS);
            if (count <= ENF_PORTAL_CORNERS)
                continue;
            reduced += side->vertex_count > 4, squares += side->vertex_count == 4;
            for (uint32_t i = 0; i < count; ++i)
                if (beyond(given, side->vertex_count, towards, corner[i]) > (k % 10 == 9 ? 1e-11 : 1e-12))
                    fail_msg("portal %u: corner %u of %u lies outside of the %u that stand for it", k, i, count, side->vertex_count);
            for (uint32_t i = 1; i + 1 < side->vertex_count; ++i) {
                double a[3], b[3], c[3];
                vec_sub(a, given[i], given[0]), vec_sub(b, given[i + 1], given[0]);
                vec_cross(c, a, b);
                area[0] += 0.5 * vec_length(c);
            }
            area[1] += PI * wide;
        }
        /* Few corners are hardly more than many: 32 of a circle are 0.3 % more. The square is what is left for those not convex. */
        if (k % 10 != 9)
            assert_true(area[0] <= 1.03 * area[1]);
        enf_view_index_release(index);
        enf_scene_destroy(scene);
    }
    assert_true(reduced > 500 && squares > 40);
}

/* Outlines moved outward hold whatever is that near to the portal, also at sharp corners, and little more. */
static void an_outline_moved_outward_holds_what_is_near(void **state) {
    (void)state;
    Random dice = {37};
    uint32_t bevels = 0;
    for (uint32_t k = 0; k < 300; ++k) {
        double corner[8][3], outline[18][3], u[3], v[3], n[3], offset = 0.01 + 0.2 * random_unit(&dice);
        EnfFlatPoint scratch[4 * 18];
        uint32_t count = 3 + random_index(&dice, 5);
        any_frame(&dice, u, v, n);
        for (uint32_t i = 0; i < count; ++i) {
            double at = 2 * PI * (i + 0.4 * random_unit(&dice)) / count;
            vec_set(corner[i], 1, 2, 3);
            vec_mad(corner[i], corner[i], 2 * cos(at), u);
            vec_mad(corner[i], corner[i], (k % 2 ? 0.2 : 2) * sin(at), v); /* flat ones have sharp corners */
        }
        uint32_t size = enf_portal_offset((const double(*)[3])corner, count, n, vec_dot(n, corner[0]), offset, outline, scratch);
        assert_true(size >= count && size <= 2 * count);
        bevels += size - count;
        for (uint32_t i = 0; i < count; ++i)
            for (int at = 0; at < 64; ++at) {
                double p[3];
                vec_mad(p, corner[i], offset * cos(at * PI / 32), u);
                vec_mad(p, p, offset * sin(at * PI / 32), v);
                assert_true(beyond((const double(*)[3])outline, size, n, p) < 1e-12);
            }
        for (uint32_t i = 0; i < size; ++i) {
            double nearest = INFINITY;
            for (uint32_t c = 0; c < count; ++c)
                nearest = fmin(nearest, vec_distance(outline[i], corner[c]));
            assert_true(nearest <= 2.0001 * offset);
        }
    }
    assert_true(bevels > 100);
}

/* A bent portal lets in what passes any of its corners: the search's outline holds all of them. */
static void a_bent_portal_is_let_in_as_far_as_it_strays(void **state) {
    (void)state;
    Random dice = {41};
    for (uint32_t k = 0; k < 100; ++k) {
        double corner[6][3], u[3], v[3], n[3];
        any_frame(&dice, u, v, n);
        for (uint32_t i = 0; i < 6; ++i) {
            vec_set(corner[i], 10, 20, 30);
            vec_mad(corner[i], corner[i], 2 * cos(i * PI / 3), u);
            vec_mad(corner[i], corner[i], 2 * sin(i * PI / 3), v);
            vec_mad(corner[i], corner[i], 0.002 * random_unit(&dice), n);
        }
        EnfScene *scene = scene_with((const double(*)[3])corner, 6);
        EnfRegionModel *m;
        assert_int_equal(enf_region_model_create(scene, NULL, 0, NULL, &m), ENF_OK);
        const double(*outline)[3] = (const double(*)[3])(m->outer.vertices + m->outer.first[0]);
        double nearest = INFINITY;
        for (uint32_t i = 0; i < 6; ++i) {
            double p[3];
            vec_sub(p, corner[i], m->origin);
            vec_scale(p, m->scale, p);
            /* Its plane runs through the corners' middle: towards either side the outline has to be wider by what they stray. */
            double out = beyond(outline, enf_rm_count(&m->outer, 0), m->plane[0], p), back[3];
            vec_scale(back, -1, m->plane[0]);
            out = fmin(out, beyond(outline, enf_rm_count(&m->outer, 0), back, p));
            nearest = fmin(nearest, -out);
        }
        assert_true(scene->portal_deviation[0] > 1e-5);
        assert_true(nearest > 0.9 * (scene->portal_deviation[0] * m->scale - m->touch));
        enf_region_model_destroy(m);
        enf_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_corners_become_few_outward),
        cmocka_unit_test(an_outline_moved_outward_holds_what_is_near),
        cmocka_unit_test(a_bent_portal_is_let_in_as_far_as_it_strays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
