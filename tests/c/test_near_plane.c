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
        const EnfViewStats stats = stats_of(view);
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

/* The camera at share t of the way between two level ones: straight on, turning about the upright. */
static EnfCamera between(const EnfCamera *from, double yaw, double pitch, const double way[3], double turn, double t) {
    double eye[3];
    eye_of(from, eye);
    for (int c = 0; c < 3; c++)
        eye[c] += t * way[c];
    EnfCamera camera = camera_at(eye, yaw + t * turn, pitch);
    camera.clip_near = from->clip_near;
    return camera;
}

static void near_planes_between_poses_count_too(void **state) {
    (void)state;
    uint32_t in_walls = 0, between_only = 0, free_ways = 0, false_alarms = 0;
    EACH_CAMERA("office:60,windows=0", 1500) {
        EnfCamera camera = random_camera(scene, walker, &rng), ends[2];
        const double yaw = 6.28 * sight_unit(&rng), pitch = 0.5 * sight_unit(&rng) - 0.25, turn = k % 3 ? 2 * sight_unit(&rng) - 1 : 0;
        double way[3];
        for (int c = 0; c < 3; c++)
            way[c] = (k % 2 ? 1.5 : 0.2) * (sight_unit(&rng) - 0.5);
        camera.clip_near = k % 5 ? 0.3 * sight_unit(&rng) : 0;
        ends[0] = between(&camera, yaw, pitch, way, turn, 0);
        ends[1] = between(&camera, yaw, pitch, way, turn, 1);
        Sets seen = query_union(scene, view, ends, 2, 1);
        const EnfViewStats stats = stats_of(view);
        int at_ends = 1, all = 1;
        for (int i = 0; i <= 16; i++) {
            EnfCamera pose = between(&camera, yaw, pitch, way, turn, i / 16.0);
            int covered = grid_in_cells(scene, &pose);
            all &= covered;
            at_ends &= covered || (i > 0 && i < 16);
        }
        if (!all)
            assert_true(stats.near_in_wall || stats.eye_outside);
        in_walls += !all;
        between_only += !all && at_ends;
        free_ways += all;
        false_alarms += all && stats.near_in_wall;
        if (stats.near_in_wall) {
            EnfCamera pose = between(&camera, yaw, pitch, way, turn, sight_unit(&rng));
            Sets one = query(scene, view, &pose, NULL);
            if (!stats_of(view).near_in_wall && !stats_of(view).eye_outside) /* else one more frustum, of other bounds */
                assert_subset(scene, &one, &seen, "a near plane in a wall between two poses");
            free_sets(&one);
        }
        free_sets(&seen);
    }
    END_CAMERAS;
    assert_true(in_walls >= 100 && between_only >= 5 && free_ways >= 1000);
    if (false_alarms > free_ways / 10)
        fail_msg("%u of %u ways clear of walls count as in them", false_alarms, free_ways);
}

static void near_planes_anywhere_in_a_box_of_viewers_count_too(void **state) {
    (void)state;
    uint32_t in_walls = 0, clear = 0, false_alarms = 0;
    EACH_CAMERA("office:60,windows=0", 400) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        double box[6];
        eye_of(&camera, box);
        for (int c = 0; c < 3; c++)
            box[3 + c] = box[c] + 0.6 * sight_unit(&rng);
        camera.clip_near = 0.2 * sight_unit(&rng);
        assert_int_equal(enf_view_query_region(view, box, &camera, NULL), ENF_OK);
        const EnfViewStats stats = stats_of(view);
        int all = 1;
        for (int i = 0; i < 27 && all; i++) {
            EnfCamera viewer = camera;
            for (int c = 0, digit = i; c < 3; c++, digit /= 3)
                viewer.world_from_camera[4 * c + 3] = box[c] + digit % 3 * 0.5 * (box[3 + c] - box[c]);
            all &= grid_in_cells(scene, &viewer);
        }
        if (!all)
            assert_true(stats.near_in_wall || stats.eye_outside);
        in_walls += !all;
        clear += all;
        false_alarms += all && stats.near_in_wall;
    }
    END_CAMERAS;
    assert_true(in_walls >= 40 && clear >= 100);
    if (false_alarms > clear / 20)
        fail_msg("%u of %u boxes clear of walls count as in them", false_alarms, clear);
}

/* Two rooms of 4 x 4 x 3 m with a wall of 0.2 m between and no door. */
static EnfScene *two_rooms(void) {
    EnfScene *scene = NULL;
    uint32_t room, cell;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    for (int r = 0; r < 2; r++) {
        double corners[8][3];
        for (int v = 0; v < 8; v++)
            corners[v][0] = 4.2 * r + (v & 1 ? 4 : 0), corners[v][1] = v & 2 ? 4 : 0, corners[v][2] = v & 4 ? 3 : 0;
        assert_int_equal(enf_scene_add_room(scene, "room", ENF_ROOM_INTERIOR, &room), ENF_OK);
        assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, corners[0], 8, 0, NULL, 0, NULL, &cell), ENF_OK);
    }
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    return scene;
}

/* A panorama's rays start on a ball: it may reach into the wall, floor or ceiling on any side. */
static void a_panoramas_near_ball_counts_on_every_side(void **state) {
    (void)state;
    EnfScene *scene = two_rooms();
    EnfView *view = NULL;
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    const double size[3] = {4, 4, 3};
    for (int side = 0; side < 7; side++) {
        double eye[3] = {2, 2, 1.5};
        if (side < 6)
            eye[side % 3] = side < 3 ? 0.05 : size[side % 3] - 0.05;
        EnfCamera camera = camera_at(eye, 0.3, 0.1);
        camera.type = ENF_CAMERA_PANO;
        camera.clip_near = 0.1;
        assert_int_equal(enf_view_query(view, &camera, NULL), ENF_OK);
        assert_int_equal(stats_of(view).near_in_wall, side < 6);
        camera.clip_near = 0.01;
        assert_int_equal(enf_view_query(view, &camera, NULL), ENF_OK);
        assert_int_equal(stats_of(view).near_in_wall, 0);
    }
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

/* Of several ways between poses any may lead through a wall. */
static void every_way_between_poses_counts(void **state) {
    (void)state;
    EnfScene *scene = two_rooms();
    EnfView *view = NULL;
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    for (int through = 0; through < 4; through++) { /* 0 .. 2: the way that leads through the wall; 3: none */
        EnfCamera camera[4];
        for (int k = 0; k < 4; k++) {
            const double eye[3] = {1 + 0.1 * k + (k > through ? 4.2 : 0), 2, 1.5};
            camera[k] = camera_at(eye, 0.3, 0.1);
            camera[k].clip_near = 0.1;
        }
        assert_int_equal(enf_view_query_union(view, camera, 4, 1, NULL), ENF_OK);
        assert_int_equal(stats_of(view).near_in_wall, through < 3);
    }
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(near_planes_between_poses_count_too),
        cmocka_unit_test(near_planes_anywhere_in_a_box_of_viewers_count_too),
        cmocka_unit_test(a_near_plane_in_a_wall_gets_the_frustums_answer),
        cmocka_unit_test(a_panoramas_near_ball_counts_on_every_side),
        cmocka_unit_test(every_way_between_poses_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
