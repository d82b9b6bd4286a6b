/* SPDX-License-Identifier: GPL-3.0-or-later
 * Where objects are drawn when nobody said. */
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_object_within_the_wall_is_placed_in_the_opening_s_cell),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
