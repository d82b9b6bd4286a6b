/* SPDX-License-Identifier: GPL-3.0-or-later
 * The scene as the from-region engine holds it: which portals face against each other, and which cells count as convex. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "from_region/region_model.h"
#include "geometry/vec3.h"
#include "memory_kit.h"
#include "stress_random.h"

/* A model of squares between cells without shapes, square i round `middle` i, facing along `normal` i. */
static EnfRegionModel *model_of(const double (*middle)[3], const double (*normal)[3], uint32_t count, EnfScene **out_scene) {
    EnfScene *scene = NULL;
    EnfRegionModel *model = NULL;
    uint32_t room, cell, portal;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "clusters", ENF_ROOM_INTERIOR, &room), ENF_OK);
    for (uint32_t i = 0; i <= count; ++i)
        assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &cell), ENF_OK);
    for (uint32_t i = 0; i < count; ++i) {
        const double axis[3] = {fabs(normal[i][0]) < 0.5, fabs(normal[i][0]) >= 0.5, 0};
        double u[3], v[3], corner[4][3];
        vec_cross(u, normal[i], axis);
        (void)vec_normalize(u);
        vec_cross(v, normal[i], u);
        for (int k = 0; k < 4; ++k) { /* counter-clockwise seen from the cell before */
            vec_mad(corner[k], middle[i], k == 1 || k == 2 ? -1 : 1, u);
            vec_mad(corner[k], corner[k], k >= 2 ? 1 : -1, v);
        }
        assert_int_equal(enf_scene_add_portal(scene, i, i + 1, corner[0], 4, 0, ENF_NONE, &portal), ENF_OK);
    }
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_int_equal(enf_region_model_create(scene, NULL, 0, NULL, &model), ENF_OK);
    *out_scene = scene;
    return model;
}

/* Numbers that differ in the last bit alone drop a portal from the might-see floods: only opposite normals may have them. */
static void ways_are_opposite_only_where_portals_face_each_other(void **state) {
    (void)state;
    enum { COUNT = 120 };
    static double middle[COUNT][3], normal[COUNT][3];
    Random dice = {5};
    uint32_t opposite = 0, alike = 0;
    for (uint32_t i = 0; i < COUNT; ++i) {
        for (int k = 0; k < 3; ++k)
            middle[i][k] = 40 * random_unit(&dice), normal[i][k] = 2 * random_unit(&dice) - 1;
        if (i % 3 == 0) /* along an axis, either way */
            vec_set(normal[i], 0, 0, 0), normal[i][i / 3 % 3] = i % 2 ? 1 : -1;
        else if (i > 12 && i % 3 == 1) /* as an earlier one, or against it, or by a little not quite */
            vec_scale(normal[i], random_index(&dice, 2) ? 1 : -1, normal[i - 12]),
                normal[i][i % 2] += i % 4 == 1 ? pow(10, -(double)(i % 9)) : 0;
        (void)vec_normalize(normal[i]);
    }
    EnfScene *scene;
    EnfRegionModel *m = model_of((const double(*)[3])middle, (const double(*)[3])normal, COUNT, &scene);
    for (uint32_t a = 0; a < 2 * COUNT; ++a) {
        assert_int_equal(m->way[a] ^ 1, m->way[enf_rm_reverse(a)]);
        for (uint32_t b = 0; b < 2 * COUNT; ++b) {
            double sum[3];
            vec_add(sum, m->plane[a], m->plane[b]);
            if (m->way[a] == (m->way[b] ^ 1)) {
                assert_true(vec_length(sum) < ENF_HIDDEN_SINE_MIN);
                ++opposite;
            } else if (vec_length(sum) == 0)
                fail_msg("portals %u and %u face each other and have the ways %u and %u", a, b, m->way[a], m->way[b]);
            alike += a != b && m->way[a] == m->way[b];
        }
    }
    assert_true(opposite > 4 * COUNT && alike > 2 * COUNT);
    for (uint32_t c = 0; c < m->cell_count; ++c)
        for (uint32_t i = m->out_first[c]; i < m->out_first[c + 1]; ++i)
            assert_int_equal(m->out_way[i], m->way[m->out[i]]);
    enf_region_model_destroy(m);
    enf_scene_destroy(scene);
}

/* Cell i + 1 lies between portals i and i + 1: convex when each portal is behind the plane of the other. */
static void a_cell_is_convex_when_no_portal_reaches_beyond_another(void **state) {
    (void)state;
    const double ahead[3] = {1, 0, 0}, slanted[3] = {0.6, 0.8, 0};
    /* 0 and 1 one behind the other; 2 leans, so that one end of it lies behind 1, and 3 lies before it. */
    const double middle[4][3] = {{0, 0, 0}, {3, 0, 0}, {3.5, 0, 0}, {6, 6, 0}};
    double normal[4][3];
    vec_copy(normal[0], ahead), vec_copy(normal[1], ahead), vec_copy(normal[2], slanted), vec_copy(normal[3], slanted);
    EnfScene *scene;
    EnfRegionModel *m = model_of(middle, (const double(*)[3])normal, 4, &scene);
    const uint8_t convex[5] = {1, 1, 0, 1, 1};
    assert_memory_equal(m->convex, convex, sizeof convex);
    enf_region_model_destroy(m);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ways_are_opposite_only_where_portals_face_each_other),
        cmocka_unit_test(a_cell_is_convex_when_no_portal_reaches_beyond_another),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
