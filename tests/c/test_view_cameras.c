/* SPDX-License-Identifier: GPL-3.0-or-later
 * Views of more than one pinhole: stereo, shutters, viewers in a box, panoramas, orthographic cameras, any of them united. */
#include "from_point/view_screen.h"
#include "view_kit.h"

static void stereo_is_exactly_what_either_eye_sees(void **state) {
    (void)state;
    EACH_CAMERA("office:100,windows=0", 100) {
        EnfCamera mid = random_camera(scene, walker, &rng), eyes[2];
        double toe = k % 2 ? 0.03 : 0; /* parallel, or toed in */
        double yaw = atan2(-mid.world_from_camera[6], -mid.world_from_camera[2]);
        for (int e = 0; e < 2; e++) {
            double eye[3];
            eye_of(&mid, eye);
            for (int c = 0; c < 3; c++)
                eye[c] += (e ? 0.0325 : -0.0325) * mid.world_from_camera[4 * c];
            eyes[e] = camera_at(eye, yaw + (e ? toe : -toe), 0.1);
            if (k % 3 == 0)
                eyes[e].shift_x = e ? -0.05 : 0.05; /* off-axis */
        }
        Sets one[2];
        for (int e = 0; e < 2; e++)
            one[e] = query(scene, view, &eyes[e], NULL);
        Sets both = query_union(scene, view, eyes, 2, 0);
        assert_union(scene, one, 2, &both);
        free_sets(&one[0]);
        free_sets(&one[1]);
        free_sets(&both);
    }
    END_CAMERAS;
}

static void a_shutter_interval_holds_every_moment(void **state) {
    (void)state;
    EACH_CAMERA("office:100,windows=0", 60) {
        EnfCamera mid = random_camera(scene, walker, &rng), ends[2], moment;
        double yaw = 6.28 * sight_unit(&rng), turn = 0.4 * sight_unit(&rng), step = 0.3 * sight_unit(&rng);
        double eye[3], other[3];
        eye_of(&mid, eye);
        for (int c = 0; c < 3; c++)
            other[c] = eye[c] + (c == 2 ? 0 : step * (sight_unit(&rng) - 0.5));
        ends[0] = camera_at(eye, yaw, 0.2);
        ends[1] = camera_at(other, yaw + turn, 0.2);
        Sets whole = query_union(scene, view, ends, 2, 1);
        for (int i = 0; i <= 4; i++) {
            double s = i / 4.0, at[3];
            between_points(eye, other, s, at);
            moment = camera_at(at, yaw + s * turn, 0.2);
            Sets now = query(scene, view, &moment, NULL);
            assert_subset(scene, &now, &whole, "moment");
            free_sets(&now);
        }
        free_sets(&whole);
    }
    END_CAMERAS;
}

static void a_viewer_region_holds_every_viewer_in_it(void **state) {
    (void)state;
    EACH_CAMERA("office:60,windows=0", 40) {
        EnfCamera mid = random_camera(scene, walker, &rng);
        double box[6], eye[3];
        eye_of(&mid, eye);
        for (int c = 0; c < 3; c++) {
            double size = 0.5 * sight_unit(&rng);
            box[c] = eye[c] - size;
            box[3 + c] = eye[c] + size;
        }
        if (enf_view_query_region(view, box, k % 2 ? &mid : NULL, NULL) != ENF_OK)
            fail_msg("%s", enf_last_error());
        Sets whole = sets_of(scene, view);
        for (int i = 0; i < 8; i++) {
            EnfCamera camera = k % 2 ? mid : random_camera(scene, walker, &rng);
            for (int c = 0; c < 3; c++)
                camera.world_from_camera[4 * c + 3] = box[c] + sight_unit(&rng) * (box[3 + c] - box[c]);
            Sets one = query(scene, view, &camera, NULL);
            if (!stats_of(view).eye_outside) /* an eye inside of a wall sees by the frustum */
                assert_subset(scene, &one, &whole, "viewer");
            free_sets(&one);
        }
        free_sets(&whole);
    }
    END_CAMERAS;
}

static void a_panorama_holds_every_direction(void **state) {
    (void)state;
    EACH_CAMERA("office:60,windows=0", 40) {
        EnfCamera camera = random_camera(scene, walker, &rng), pano = camera;
        pano.type = ENF_CAMERA_PANO;
        pano.angle_x = 6.283185307179586;
        pano.angle_y = 3.141592653589793;
        Sets all = query(scene, view, &pano, NULL);
        assert_int_equal(stats_of(view).screens, 6);
        double eye[3];
        eye_of(&camera, eye);
        for (int i = 0; i < 6; i++) {
            EnfCamera one = camera_at(eye, 6.28 * sight_unit(&rng), 3 * sight_unit(&rng) - 1.5);
            Sets s = query(scene, view, &one, NULL);
            assert_subset(scene, &s, &all, "direction");
            free_sets(&s);
        }
        /* A lens of 180 degrees and more sees what a narrower one sees. */
        pano.type = ENF_CAMERA_PERSP;
        pano.angle_x = 3.2;
        Sets wide = query(scene, view, &pano, NULL), narrow = query(scene, view, &camera, NULL);
        assert_subset(scene, &narrow, &wide, "wide lens");
        free_sets(&wide);
        free_sets(&narrow);
        free_sets(&all);
    }
    END_CAMERAS;
}

static void an_orthographic_view_sees_through_holes_only(void **state) {
    (void)state;
    EnfScene *scene = family("tower:6");
    EnfView *view;
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    /* In the top shaft, looking straight down through the holes, 2 m wide: all shafts, no flat. */
    double eye[3] = {2.5, 2.5, 5 * 3.2 + 2.0};
    EnfCamera camera = camera_at(eye, 0, -1.5707963267948966);
    camera.type = ENF_CAMERA_ORTHO;
    camera.ortho_width = camera.ortho_height = 2;
    Sets s = query(scene, view, &camera, NULL);
    uint32_t shafts = 0, flats = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (s.cells[c] && scene->cell_rooms[c] != ENF_NONE) {
            int shaft = strncmp(scene->rooms[scene->cell_rooms[c]].name, "Shaft", 5) == 0;
            shafts += (uint32_t)shaft;
            flats += (uint32_t)!shaft;
        }
    assert_int_equal(shafts, 6);
    assert_int_equal(flats, 0);
    free_sets(&s);
    /* The near plane cuts the slabs away: from above everything, started beside the holes too. */
    eye[2] = 30;
    camera = camera_at(eye, 0, -1.5707963267948966);
    camera.type = ENF_CAMERA_ORTHO;
    camera.ortho_width = camera.ortho_height = 20;
    camera.clip_near = 30 - (5 * 3.2 + 1.0); /* at 1 m over the top floor */
    s = query(scene, view, &camera, NULL);
    flats = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        flats += s.cells[c] && scene->cell_rooms[c] != ENF_NONE && strncmp(scene->rooms[scene->cell_rooms[c]].name, "Flat 5", 6) == 0;
    assert_int_equal(flats, 4);
    free_sets(&s);
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

static void cameras_of_every_kind_are_united(void **state) {
    (void)state;
    EACH_CAMERA("office:60,windows=0", 40) {
        EnfCamera cameras[4];
        Sets one[4];
        for (int i = 0; i < 4; i++)
            cameras[i] = random_camera(scene, walker, &rng);
        cameras[1].type = ENF_CAMERA_ORTHO;
        cameras[1].ortho_width = 3;
        cameras[1].ortho_height = 2;
        cameras[2].type = ENF_CAMERA_PANO;
        cameras[2].angle_x = 6.283185307179586;
        cameras[2].angle_y = 3.141592653589793;
        cameras[3].shift_x = 0.3;
        for (int i = 0; i < 4; i++)
            one[i] = query(scene, view, &cameras[i], NULL);
        Sets all = query_union(scene, view, cameras, 4, 0);
        assert_int_equal(stats_of(view).eyes, 4);
        assert_int_equal(stats_of(view).screens, 9);
        assert_union(scene, one, 4, &all);
        /* Every cell of the answer has its way from some camera. */
        for (uint32_t c = 0; c < scene->cell_count; c++) {
            uint32_t n;
            assert_int_equal(enf_view_why_cell(view, c, NULL, 0, &n), all.cells[c] ? ENF_OK : ENF_ERROR_INVALID_ARGUMENT);
        }
        free_sets(&all);
        for (int i = 0; i < 4; i++)
            free_sets(&one[i]);
    }
    END_CAMERAS;
}

/* Rays of an orthographic camera start on its near rectangle, each in the cell that lies there. */
static void an_orthographic_view_misses_no_ray(void **state) {
    (void)state;
    uint32_t proven = 0;
    EACH_CAMERA("office:60", 60) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        camera.type = ENF_CAMERA_ORTHO;
        camera.ortho_width = 0.5 + 3 * sight_unit(&rng);
        camera.ortho_height = 0.5 + 2 * sight_unit(&rng);
        camera.shift_x = 0.2 * sight_unit(&rng);
        camera.clip_near = k % 2 ? 0.3 * sight_unit(&rng) : 0;
        Sets s = query(scene, view, &camera, NULL);
        const double *m = camera.world_from_camera;
        for (int i = 0; i < 60; i++) {
            static SightWalk walk;
            double from[3], d[3], x = 0.49 * (2 * sight_unit(&rng) - 1) + camera.shift_x, y = 0.49 * (2 * sight_unit(&rng) - 1);
            for (int c = 0; c < 3; c++) {
                d[c] = -m[4 * c + 2];
                from[c] =
                    m[4 * c + 3] + x * camera.ortho_width * m[4 * c] + y * camera.ortho_height * m[4 * c + 1] + camera.clip_near * d[c];
            }
            uint32_t cell, located = 0;
            if (enf_scene_locate(scene, from, &cell, 1, &located) != ENF_OK || located != 1)
                continue;
            sight_walk(walker, cell, from, d, INFINITY, &walk);
            for (uint32_t w = 0; w < walk.cell_count && walk.clearance_at[w] > 2e-10; w++, proven++)
                if (!s.cells[walk.cells[w]])
                    fail_msg("camera %u, ray %d: cell %u is missed", k, i, walk.cells[w]);
        }
        free_sets(&s);
    }
    END_CAMERAS;
    assert_true(proven > 2000);
}

/* A moving orthographic camera: sideways, nearer, zooming (one direction of sight), or turning. */
static void an_orthographic_sweep_holds_every_moment(void **state) {
    (void)state;
    EACH_CAMERA("office:60,windows=0", 60) {
        EnfCamera ends[2] = {random_camera(scene, walker, &rng), random_camera(scene, walker, &rng)};
        double yaw = 6.28 * sight_unit(&rng), turn = k % 2 ? 0.3 * sight_unit(&rng) : 0, eyes[2][3];
        eye_of(&ends[0], eyes[0]);
        for (int c = 0; c < 3; c++)
            eyes[1][c] = eyes[0][c] + 0.8 * (sight_unit(&rng) - 0.5);
        for (int e = 0; e < 2; e++) {
            ends[e] = camera_at(eyes[e], yaw + e * turn, 0.1);
            ends[e].type = ENF_CAMERA_ORTHO;
            ends[e].ortho_width = 1 + 0.5 * sight_unit(&rng);
            ends[e].ortho_height = 1;
            ends[e].shift_x = 0.1;
        }
        Sets whole = query_union(scene, view, ends, 2, 1);
        for (int i = 0; i <= 4; i++) {
            double s = i / 4.0, at[3];
            between_points(eyes[0], eyes[1], s, at);
            EnfCamera moment = camera_at(at, yaw + s * turn, 0.1);
            moment.type = ENF_CAMERA_ORTHO;
            moment.ortho_width = ends[0].ortho_width + s * (ends[1].ortho_width - ends[0].ortho_width);
            moment.ortho_height = 1;
            moment.shift_x = 0.1;
            Sets now = query(scene, view, &moment, NULL);
            if (!stats_of(view).eye_outside) /* an eye inside of a wall sees by the frustum */
                assert_subset(scene, &now, &whole, "moment");
            free_sets(&now);
        }
        free_sets(&whole);
        EnfCamera mixed[2] = {ends[0], random_camera(scene, walker, &rng)};
        assert_int_equal(enf_view_query_union(view, mixed, 2, 1, NULL), ENF_ERROR_BAD_INPUT);
    }
    END_CAMERAS;
}

/* Sixteen rolling poses: their corners, and all that lies within a quarter of the square of a turn from these, are more points than a
 * polygon has room for. */
static void a_screen_of_many_rolling_poses_holds_the_corners_of_each(void **state) {
    (void)state;
    const double eye[3] = {1, 2, 3};
    static EnfScreens screens;
    for (uint32_t k = 0; k < 60; k++) {
        const uint32_t count = 2 + k % 15;
        const double roll = 0.004 * k, bulge = 0.25 * roll * roll;
        EnfCamera poses[16];
        for (uint32_t i = 0; i < count; i++) {
            poses[i] = camera_at(eye, 0.4, 0.1);
            double *m = poses[i].world_from_camera, c = cos(roll * i), s = sin(roll * i);
            for (int row = 0; row < 3; row++) {
                const double right = m[4 * row], up = m[4 * row + 1];
                m[4 * row] = c * right + s * up;
                m[4 * row + 1] = c * up - s * right;
            }
        }
        assert_int_equal(enf_screens_from_cameras(poses, 0, count, 1, NULL, &screens), ENF_OK);
        for (uint32_t i = 0; i < 32 * count && screens.screen_count == 1; i++) {
            const EnfScreen *screen = &screens.screen[0];
            const double *m = poses[i / 32].world_from_camera, aside = 0.7853981634 * (i / 4 % 8);
            const double x = (i & 1 ? 1 : -1) * tan(0.7), y = (i & 2 ? 1 : -1) * tan(0.45), far = sqrt(1 + x * x + y * y);
            const double across = hypot(1, x), u[3] = {1 / across, 0, x / across};
            const double v[3] = {-x * y / (across * far), across / far, y / (across * far)}; /* both unit, and square to the corner */
            double d[3], p[3];
            for (int c = 0; c < 3; c++) {
                double own[3] = {x / far, y / far, -1 / far};
                for (int a = 0; a < 3; a++)
                    own[a] += bulge * (cos(aside) * u[a] + sin(aside) * v[a]);
                d[c] = own[0] * m[4 * c] + own[1] * m[4 * c + 1] + own[2] * m[4 * c + 2];
            }
            for (int r = 0; r < 3; r++)
                p[r] = screen->rows[r][0] * d[0] + screen->rows[r][1] * d[1] + screen->rows[r][2] * d[2];
            for (uint32_t e = 0; e < screen->view.n; e++) {
                const uint32_t f = (e + 1) % screen->view.n;
                const double ex = screen->view.x[f] - screen->view.x[e], ey = screen->view.y[f] - screen->view.y[e];
                if (ex * (p[1] / p[2] - screen->view.y[e]) - ey * (p[0] / p[2] - screen->view.x[e]) < -1e-13)
                    fail_msg("of %u poses that roll by %g, what lies about corner %u of pose %u is cut off", count, roll, i % 4, i / 32);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stereo_is_exactly_what_either_eye_sees),
        cmocka_unit_test(a_shutter_interval_holds_every_moment),
        cmocka_unit_test(a_viewer_region_holds_every_viewer_in_it),
        cmocka_unit_test(a_panorama_holds_every_direction),
        cmocka_unit_test(an_orthographic_view_sees_through_holes_only),
        cmocka_unit_test(an_orthographic_view_misses_no_ray),
        cmocka_unit_test(cameras_of_every_kind_are_united),
        cmocka_unit_test(an_orthographic_sweep_holds_every_moment),
        cmocka_unit_test(a_screen_of_many_rolling_poses_holds_the_corners_of_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
