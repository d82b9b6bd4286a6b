/* SPDX-License-Identifier: GPL-3.0-or-later
 * Where objects are drawn when nobody said. */
#include "enfilade/portal_vis.h"
#include "enfilade/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static uint32_t add_box_cell(EnfScene *scene, uint32_t room, uint32_t opening, const double b[6]) {
    double corners[8][3];
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            corners[i][k] = b[(i >> k) & 1 ? 3 + k : k];
    uint32_t cell = ENF_NONE;
    assert_int_equal(enf_scene_add_cell(scene, room, opening, &corners[0][0], 8, 0, NULL, 0, NULL, &cell), ENF_OK);
    return cell;
}

/* Two rooms, x in [0, 4] and [4.3, 8], with a window of 0.3 m between: the pane hangs in the wall and touches neither room.
 * Bodies of openings come without faces. */
static void an_object_within_the_wall_is_placed_in_the_opening_s_cell(void **state) {
    (void)state;
    EnfScene *scene;
    uint32_t rooms[2], opening, cells[3], object, portal, count;
    const uint32_t *placed;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "A", ENF_ROOM_INTERIOR, &rooms[0]), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "B", ENF_ROOM_INTERIOR, &rooms[1]), ENF_OK);
    assert_int_equal(enf_scene_add_opening(scene, "W", ENF_OPENING_WINDOW, ENF_STATE_GLASS, &opening), ENF_OK);
    cells[0] = add_box_cell(scene, rooms[0], ENF_NONE, (double[]){0, 0, 0, 4, 3, 3});
    cells[1] = add_box_cell(scene, rooms[1], ENF_NONE, (double[]){4.3, 0, 0, 8, 3, 3});
    cells[2] = add_box_cell(scene, ENF_NONE, opening, (double[]){4, 1, 1, 4.3, 2, 2});
    for (int i = 0; i < 2; i++) {
        double x = i ? 4.3 : 4.0, polygon[4][3] = {{x, 1, 1}, {x, 2, 1}, {x, 2, 2}, {x, 1, 2}};
        assert_int_equal(enf_scene_add_portal(scene, cells[i], cells[2], &polygon[0][0], 4, 0, opening, &portal), ENF_OK);
    }
    const double pane[6] = {4.15, 1.05, 1.05, 4.15, 1.95, 1.95};
    assert_int_equal(enf_scene_add_object(scene, "Pane", pane, NULL, 0, ENF_NONE, &object), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_int_equal(enf_scene_object_cells(scene, object, &placed, &count), ENF_OK);
    int found = 0;
    for (uint32_t i = 0; i < count; i++)
        found |= placed[i] == cells[2];
    assert_true(found);
    enf_scene_destroy(scene);
}

/* A house of walls without a thickness: its shell fills the room exactly, and is what one sees of it from outdoors. A table isn't. */
static void a_shell_without_thickness_is_drawn_outdoors_too(void **state) {
    (void)state;
    EnfScene *scene;
    uint32_t rooms[2], outside, objects[3], count;
    const uint32_t *placed;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "Hut", ENF_ROOM_INTERIOR, &rooms[0]), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "Outside", ENF_ROOM_EXTERIOR, &rooms[1]), ENF_OK);
    add_box_cell(scene, rooms[0], ENF_NONE, (double[]){0, 0, 0, 4, 3, 3});
    assert_int_equal(enf_scene_add_cell(scene, rooms[1], ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &outside), ENF_OK);
    const double bounds[3][6] = {{0, 0, 0, 4, 3, 3}, {0, 0, 0, 0, 3, 3}, {1, 1, 0, 2, 2, 0.8}};
    for (int i = 0; i < 3; i++)
        assert_int_equal(enf_scene_add_object(scene, "Thing", bounds[i], NULL, 0, ENF_NONE, &objects[i]), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(enf_scene_object_cells(scene, objects[i], &placed, &count), ENF_OK);
        int found = 0;
        for (uint32_t k = 0; k < count; k++)
            found |= placed[k] == outside;
        assert_int_equal(found, i < 2);
    }
    enf_scene_destroy(scene);
}

/* A wall of 0.6 m, a closed door, its leaf in the middle: farther from both rooms than any contact margin. From room A one
 * sees it in the recess; from the recess one sees the room. */
static void a_closed_door_in_a_thick_wall_is_seen_from_the_rooms(void **state) {
    (void)state;
    EnfScene *scene;
    EnfView *view;
    uint32_t rooms[2], opening, cells[3], objects[2], portal;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "A", ENF_ROOM_INTERIOR, &rooms[0]), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "B", ENF_ROOM_INTERIOR, &rooms[1]), ENF_OK);
    assert_int_equal(enf_scene_add_opening(scene, "D", ENF_OPENING_DOOR, ENF_STATE_CLOSED, &opening), ENF_OK);
    cells[0] = add_box_cell(scene, rooms[0], ENF_NONE, (double[]){0, 0, 0, 4, 4, 3});
    cells[1] = add_box_cell(scene, rooms[1], ENF_NONE, (double[]){4.6, 0, 0, 8, 4, 3});
    cells[2] = add_box_cell(scene, ENF_NONE, opening, (double[]){4, 1, 0, 4.6, 2, 2});
    for (int i = 0; i < 2; i++) {
        double x = i ? 4.6 : 4.0, polygon[4][3] = {{x, 1, 0}, {x, 2, 0}, {x, 2, 2}, {x, 1, 2}};
        assert_int_equal(enf_scene_add_portal(scene, cells[i], cells[2], &polygon[0][0], 4, 0, opening, &portal), ENF_OK);
    }
    assert_int_equal(enf_scene_add_object(scene, "Leaf", (double[]){4.28, 1, 0, 4.32, 2, 2}, NULL, 0, ENF_NONE, &objects[0]), ENF_OK);
    assert_int_equal(enf_scene_add_object(scene, "Lamp", (double[]){0.2, 1.4, 1, 0.4, 1.6, 1.2}, NULL, 0, ENF_NONE, &objects[1]), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    EnfCamera camera = enf_default_camera(); /* at (x, 1.5, 1.1), looking along +x, then along -x */
    for (int back = 0; back < 2; back++)
        for (uint32_t method = ENF_VIEW_BOX; method <= ENF_VIEW_CLIP; method++) {
            double s = back ? -1.0 : 1.0;
            const double matrix[16] = {0, 0, -s, back ? 4.1 : 1.0, -s, 0, 0, 1.5, 0, 1, 0, 1.1, 0, 0, 0, 1};
            for (int i = 0; i < 16; i++)
                camera.world_from_camera[i] = matrix[i];
            EnfViewDef def = enf_default_view_def();
            EnfViewResult result = enf_default_view_result();
            def.method = method;
            assert_int_equal(enf_view_query(view, &camera, &def), ENF_OK);
            assert_int_equal(enf_view_result(view, &result), ENF_OK);
            int found = 0;
            for (uint32_t i = 0; i < result.object_count; i++)
                found |= result.objects[i] == objects[back];
            assert_true(found);
            for (uint32_t i = 0; i < result.cell_count && !back; i++)
                assert_int_not_equal(result.cells[i], cells[1]); /* who must not be seen */
        }
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_object_within_the_wall_is_placed_in_the_opening_s_cell),
        cmocka_unit_test(a_shell_without_thickness_is_drawn_outdoors_too),
        cmocka_unit_test(a_closed_door_in_a_thick_wall_is_seen_from_the_rooms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
