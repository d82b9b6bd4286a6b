/* SPDX-License-Identifier: GPL-3.0-or-later
 * Near planes that reach into walls: what a renderer's rays start in there isn't known, so nothing may be called hidden. */
#include "view_kit.h"

/* Whether every point of a fine grid over the near rectangle, edges left out, lies in some cell. */
static int grid_in_cells(const EnfScene *scene, const EnfCamera *camera) {
    const double *m = camera->world_from_camera, tan_x = tan(0.5 * camera->angle_x), tan_y = tan(0.5 * camera->angle_y);
    for (int i = 0; i < 400; i++) {
        double u = ((i % 20 + 0.5) / 10 - 1) * tan_x, v = ((i / 20 + 0.5) / 10 - 1) * tan_y, p[3];
        uint32_t cell, count = 0;
        for (int c = 0; c < 3; c++)
            p[c] = m[4 * c + 3] + camera->clip_near * (u * m[4 * c] + v * m[4 * c + 1] - m[4 * c + 2]);
        assert_int_equal(enf_scene_locate(scene, p, &cell, 1, &count), ENF_OK);
        if (count == 0)
            return 0;
    }
    return 1;
}

static void a_near_plane_in_a_wall_gets_the_frustums_answer(void **state) {
    (void)state;
    uint32_t in_walls = 0, at_doors = 0, grazing = 0;
    EACH_CAMERA("office:60,windows=0", 400) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        camera.type = k % 8 == 7 ? ENF_CAMERA_PANO : ENF_CAMERA_PERSP;
        camera.clip_near = 0.6 * sight_unit(&rng);
        Sets seen = query(scene, view, &camera, NULL);
        EnfViewStats stats = enf_default_view_stats();
        assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
        if (camera.type == ENF_CAMERA_PERSP && !stats.eye_outside) {
            int covered = grid_in_cells(scene, &camera);
            if (!covered)
                assert_true(stats.near_in_wall);
            grazing += covered && stats.near_in_wall; /* a corner between the grid's points */
            in_walls += !covered;
            at_doors += covered && stats.start_cells > 1;
        }
        if (stats.near_in_wall) {
            EnfViewDef frustum = enf_default_view_def();
            frustum.method = ENF_VIEW_FRUSTUM;
            Sets all = query(scene, view, &camera, &frustum);
            assert_subset(scene, &all, &seen, "near plane in a wall");
            free_sets(&all);
        }
        free_sets(&seen);
    }
    END_CAMERAS;
    assert_true(in_walls >= 40 && at_doors >= 5 && grazing <= in_walls / 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_near_plane_in_a_wall_gets_the_frustums_answer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
