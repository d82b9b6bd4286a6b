/* SPDX-License-Identifier: GPL-3.0-or-later
 * Portals between decomposed rooms: nothing of the polygon is lost, each piece lies at its cells, cuts are
 * shared. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "memory_kit.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/scene_data.h"

#include <math.h>

/* An L north of the wall y = 0 and a T south of it; the L's cut and the T's cut meet the wall at different
 * places or not at all, depending on the shapes: `mirror` puts the other leg at the wall. */
static EnfScene *two_rooms(double turn, const double by[3]) {
    /* north: a U whose three legs stand on the wall from x = 0 to 9 */
    static const double north[][2] = {{0, 0}, {3, 0}, {3, 2}, {4, 2}, {4, 0}, {9, 0}, {9, 5}, {0, 5}};
    /* south: steps away from the wall, one cell boundary at the wall at x = 5 */
    static const double south[][2] = {{0, 0}, {0, -3}, {5, -3}, {5, -6}, {9, -6}, {9, 0}};
    EnfScene *scene;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    enf_scene_add_room(scene, "north", ENF_ROOM_INTERIOR, NULL);
    enf_scene_add_room(scene, "south", ENF_ROOM_INTERIOR, NULL);
    for (int r = 0; r < 2; r++) {
        double xy[8][2];
        uint32_t n = r ? 6 : 8;
        for (uint32_t i = 0; i < n; i++) {
            double x = r ? south[i][0] : north[i][0], y = r ? south[i][1] : north[i][1];
            xy[i][0] = x * cos(turn) - y * sin(turn) + by[0];
            xy[i][1] = x * sin(turn) + y * cos(turn) + by[1];
        }
        assert_int_equal(enf_scene_add_room_prism(scene, (uint32_t)r, xy[0], &n, 1, by[2], by[2] + 3, NULL, NULL), ENF_OK);
    }
    return scene;
}

static void door(double out[4][3], double x0, double x1, double y, double turn, const double by[3]) {
    const double xs[4] = {x0, x1, x1, x0}, zs[4] = {0, 0, 2.1, 2.1};
    for (int i = 0; i < 4; i++)
        vec_set(out[i], xs[i] * cos(turn) - y * sin(turn) + by[0], xs[i] * sin(turn) + y * cos(turn) + by[1], zs[i] + by[2]);
}

static double pieces_area(const EnfScene *s, uint32_t first, uint32_t count) {
    double sum = 0.0, n[3];
    for (uint32_t p = first; p < first + count; p++)
        sum += enf_polygon_normal(n, s->portal_vertices + s->portal_vertex_first[p],
                                  s->portal_vertex_first[p + 1] - s->portal_vertex_first[p]);
    return sum;
}

/* Every piece's middle, pushed a little to either side, lies in the cell it was given on that side (unless
 * `overhang`). */
static void check_pieces(EnfScene *s, uint32_t first, uint32_t count, double push) {
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    for (uint32_t p = first; p < first + count; p++) {
        double middle[3], probe[3];
        enf_polygon_centroid(middle, s->portal_vertices + s->portal_vertex_first[p],
                             s->portal_vertex_first[p + 1] - s->portal_vertex_first[p]);
        for (int side = 0; side < 2; side++) {
            uint32_t cells[8], found, hit = 0;
            vec_mad(probe, middle, side ? push : -push, s->portal_planes[p].n);
            assert_int_equal(enf_scene_locate(s, probe, cells, 8, &found), ENF_OK);
            for (uint32_t i = 0; i < found && i < 8; i++)
                hit |= cells[i] == s->portal_cells[p][side];
            assert_true(hit);
        }
    }
}

static const double here[3] = {0, 0, 0}, far_away[3] = {1e7, -4e6, 120};

static void a_door_at_one_cell_of_each_room_stays_whole(void **state) {
    (void)state;
    EnfScene *s = two_rooms(0.3, here);
    double polygon[4][3];
    uint32_t first, count;
    door(polygon, 1, 2, 0, 0.3, here);
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 1, polygon[0], 4, 0, ENF_NONE, &first, &count), ENF_OK);
    assert_int_equal(count, 1);
    for (int i = 0; i < 4; i++) /* bit for bit */
        assert_true(vec_equal(s->portal_vertices[s->portal_vertex_first[first] + (uint32_t)i], polygon[i]));
    check_pieces(s, first, count, 1e-3);
    enf_scene_destroy(s);
}

static void a_wide_opening_is_split_and_nothing_is_lost(void **state) {
    (void)state;
    for (int k = 0; k < 24; k++) {
        const double *by = k % 2 ? far_away : here;
        double turn = k % 3 ? 0.1 + 0.25 * k : 0.0, off = (k % 5 - 2) * 0.03; /* up to 6 cm before or behind the wall */
        EnfScene *s = two_rooms(turn, by);
        double polygon[4][3];
        uint32_t first, count;
        door(polygon, 4.2, 8.8, off, turn, by);
        assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 1, polygon[0], 4, 0, ENF_NONE, &first, &count), ENF_OK);
        assert_true(count >= 1 && count <= 4);
        double area = 4.6 * 2.1;
        assert_true(fabs(pieces_area(s, first, count) - area) < (k % 2 ? 1e-7 : 1e-12) * area);
        check_pieces(s, first, count, 0.1);
        enf_scene_destroy(s);
    }
}

static void what_lies_in_no_room_goes_to_the_nearest_cell_and_is_told(void **state) {
    (void)state;
    EnfScene *s = two_rooms(0.0, here);
    double polygon[4][3];
    uint32_t first, count;
    door(polygon, 1, 6, 0, 0.0, here); /* crosses the notch of the U between x = 3 and 4 */
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 1, polygon[0], 4, 0, ENF_NONE, &first, &count), ENF_OK);
    assert_true(fabs(pieces_area(s, first, count) - 5 * 2.1) < 1e-12);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    int told = 0;
    for (uint64_t i = 0; i < enf_scene_problem_count(s); i++) {
        EnfProblem problem;
        enf_scene_problem(s, i, &problem);
        told |= problem.code == 66;
    }
    assert_true(told);
    enf_scene_destroy(s);
}

static void cuts_are_shared_bit_for_bit(void **state) {
    (void)state;
    EnfScene *s = two_rooms(0.7, far_away);
    double polygon[4][3];
    uint32_t first, count;
    door(polygon, 0.5, 8.9, 0, 0.7, far_away);
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 1, polygon[0], 4, 0, ENF_NONE, &first, &count), ENF_OK);
    assert_true(count >= 2);
    /* Upright cuts of an upright rectangle: every corner of a piece is a corner of the rectangle or of
     * another piece too. */
    uint32_t begin = s->portal_vertex_first[first], end = s->portal_vertex_first[first + count];
    for (uint32_t i = begin; i < end; i++) {
        int shared = 0;
        for (int k = 0; k < 4; k++)
            shared |= vec_equal(s->portal_vertices[i], polygon[k]);
        for (uint32_t j = begin; j < end; j++)
            shared |= i != j && vec_equal(s->portal_vertices[i], s->portal_vertices[j]);
        assert_true(shared);
    }
    enf_scene_destroy(s);
}

static void a_cell_side_and_an_exterior_without_geometry_take_all(void **state) {
    (void)state;
    EnfScene *s = two_rooms(0.0, here);
    uint32_t outside, cell, first, count;
    enf_scene_add_room(s, "outside", ENF_ROOM_EXTERIOR, &outside);
    enf_scene_add_cell(s, outside, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &cell);
    double polygon[4][3] = {{9, 1, 1}, {9, 2, 1}, {9, 2, 2}, {9, 1, 2}};
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, outside, polygon[0], 4, 0, ENF_NONE, &first, &count), ENF_OK);
    assert_int_equal(count, 1);
    assert_int_equal(s->portal_cells[first][1], cell);
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_CELL, cell, polygon[0], 4, 0, ENF_NONE, &first, &count), ENF_OK);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    enf_scene_destroy(s);
}

static void bad_joins_are_refused(void **state) {
    (void)state;
    EnfScene *s = two_rooms(0.0, here);
    double polygon[4][3], line[3][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    door(polygon, 1, 2, 0, 0, here);
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 7, polygon[0], 4, 0, ENF_NONE, NULL, NULL), ENF_ERROR_BAD_INPUT);
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 0, polygon[0], 4, 0, ENF_NONE, NULL, NULL), ENF_ERROR_BAD_INPUT);
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 1, line[0], 3, 0, ENF_NONE, NULL, NULL), ENF_ERROR_BAD_INPUT);
    polygon[2][1] = NAN;
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_ROOM, 1, polygon[0], 4, 0, ENF_NONE, NULL, NULL), ENF_ERROR_BAD_INPUT);
    enf_scene_destroy(s);
}

/* A U round a passage that leads east: the portal at its west end lies nearer to the eastern arm, from which no one looks in through it. */
static void cells_beyond_a_portal_take_no_part(void **state) {
    (void)state;
    static const double u[][2] = {{0, 0}, {9, 0}, {9, 5}, {6, 5}, {6, 1}, {3, 1}, {3, 5}, {0, 5}};
    EnfScene *s;
    uint32_t n = 8, first, count, body;
    double corners[8][3], end[4][3];
    assert_int_equal(enf_scene_create(&s), ENF_OK);
    enf_scene_add_room(s, "u", ENF_ROOM_INTERIOR, NULL);
    enf_scene_add_opening(s, "passage", ENF_OPENING_HOLE, ENF_STATE_OPEN, NULL);
    assert_int_equal(enf_scene_add_room_prism(s, 0, u[0], &n, 1, 0.0, 3.0, NULL, NULL), ENF_OK);
    for (int i = 0; i < 8; i++)
        vec_set(corners[i], i & 1 ? 6.5 : 4.8, i & 2 ? 4.9 : 3.9, i & 4 ? 2.0 : 1.0);
    assert_int_equal(enf_scene_add_cell(s, ENF_NONE, 0, corners[0], 8, 0, NULL, 0, NULL, &body), ENF_OK);
    door(end, 0, 1, 0, 0, here);
    for (int i = 0; i < 4; i++)
        vec_set(end[i], 4.8, end[i][0] + 3.9, end[i][2] > 0 ? 2.0 : 1.0);
    assert_int_equal(enf_scene_join(s, ENF_SIDE_ROOM, 0, ENF_SIDE_CELL, body, end[0], 4, 0, 0, &first, &count), ENF_OK);
    assert_int_equal(count, 1);
    uint32_t c = s->portal_cells[first][0];
    double low = DBL_MAX;
    for (uint32_t v = s->cell_vertex_first[c]; v < s->cell_vertex_first[c + 1]; v++)
        low = fmin(low, s->cell_vertices[v][0]);
    assert_true(low < 1.0);
    assert_int_equal(enf_scene_commit(s), ENF_OK);
    enf_scene_destroy(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_door_at_one_cell_of_each_room_stays_whole),
        cmocka_unit_test(a_wide_opening_is_split_and_nothing_is_lost),
        cmocka_unit_test(what_lies_in_no_room_goes_to_the_nearest_cell_and_is_told),
        cmocka_unit_test(cuts_are_shared_bit_for_bit),
        cmocka_unit_test(a_cell_side_and_an_exterior_without_geometry_take_all),
        cmocka_unit_test(cells_beyond_a_portal_take_no_part),
        cmocka_unit_test(bad_joins_are_refused),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
