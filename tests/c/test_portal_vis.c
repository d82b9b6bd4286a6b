/* SPDX-License-Identifier: GPL-3.0-or-later
 * Views: what the answers promise besides missing nothing: order, reasons, unions, changes, groups, limits, errors. */
#include "memory_kit.h"
#include "view_kit.h"

#include "sight_truth.h"

static void clip_is_within_box_and_box_within_frustum(void **state) {
    (void)state;
    EACH_CAMERA("office:200,windows=0", 200) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        EnfViewDef def = enf_default_view_def();
        Sets s[3];
        for (uint32_t m = 0; m < 3; m++) {
            def.method = m;
            s[m] = query(scene, view, &camera, &def);
        }
        assert_subset(scene, &s[2], &s[1], "clip in box");
        assert_subset(scene, &s[1], &s[0], "box in frustum");
        for (int m = 0; m < 3; m++) {
            for (uint32_t c = 0; c < scene->cell_count; c++)
                assert_true(s[m].cells[c] <= 1);
            for (uint32_t o = 0; o < scene->object_count; o++)
                assert_true(s[m].objects[o] <= 1);
            free_sets(&s[m]);
        }
    }
    END_CAMERAS;
}

static void nothing_hidden_is_kept_without_need(void **state) {
    (void)state;
    uint64_t kept = 0, proven = 0, kept_objects = 0, proven_objects = 0;
    EACH_CAMERA("office:46,windows=0", 200) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        SightTruth *truth = sight_truth_create(scene, walker);
        double eye[3] = {camera.world_from_camera[3], camera.world_from_camera[7], camera.world_from_camera[11]};
        double(*boxes)[6] = malloc(sizeof *boxes * scene->object_count);
        uint32_t start, located;
        for (uint32_t o = 0; o < scene->object_count; o++)
            memcpy(boxes[o], scene->objects[o].bounds, sizeof *boxes);
        assert_int_equal(enf_scene_locate(scene, eye, &start, 1, &located), ENF_OK);
        if (located == 1 && sight_truth_find(truth, start, &camera, (const double(*)[6])boxes, 1000000)) {
            Sets s = query(scene, view, &camera, NULL);
            kept += s.cell_count;
            proven += sight_truth_cells(truth);
            kept_objects += s.object_count;
            proven_objects += sight_truth_objects(truth);
            free_sets(&s);
        }
        free(boxes);
        sight_truth_destroy(truth);
    }
    END_CAMERAS;
    assert_true((double)kept <= 1.01 * (double)proven);
    assert_true((double)kept_objects <= 1.05 * (double)proven_objects);
}

static void same_bits_again_and_without_simd(void **state) {
    (void)state;
    EACH_CAMERA("office:200", 100) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        EnfView *other;
        assert_int_equal(enf_view_create_shared(view, &other), ENF_OK);
        EnfViewDef def = enf_default_view_def();
        EnfViewResult a = enf_default_view_result(), b = enf_default_view_result();
        def.method = k % 2 ? ENF_VIEW_CLIP : ENF_VIEW_BOX;
        assert_int_equal(enf_view_query(view, &camera, &def), ENF_OK);
        def.use_simd = 0;
        assert_int_equal(enf_view_query(other, &camera, &def), ENF_OK);
        assert_int_equal(enf_view_result(view, &a), ENF_OK);
        assert_int_equal(enf_view_result(other, &b), ENF_OK);
        assert_int_equal(a.cell_count, b.cell_count);
        assert_int_equal(a.object_count, b.object_count);
        assert_int_equal(a.step_count, b.step_count);
        assert_memory_equal(a.cells, b.cells, sizeof(uint32_t) * a.cell_count + 0);
        if (a.object_count)
            assert_memory_equal(a.objects, b.objects, sizeof(uint32_t) * a.object_count);
        if (a.object_count)
            assert_memory_equal(a.object_step, b.object_step, sizeof(uint32_t) * a.object_count);
        enf_view_destroy(other);
    }
    END_CAMERAS;
}

/* A random order of 0 .. n - 1: order[new] = old. */
static uint32_t *shuffled(SightRng *rng, uint32_t n) {
    uint32_t *order = malloc(sizeof *order * (n + 1));
    for (uint32_t i = 0; i < n; i++)
        order[i] = i;
    for (uint32_t i = n; i > 1; i--) {
        uint32_t j = (uint32_t)(sight_next(rng) % i), swap = order[i - 1];
        order[i - 1] = order[j];
        order[j] = swap;
    }
    return order;
}

static void the_order_of_input_does_not_matter(void **state) {
    (void)state;
    static const char *const specs[] = {"office:60", "grid:9,objects=2", "columns:7,objects=1", "tower:5"};
    SightRng rng = {17};
    for (size_t f = 0; f < sizeof specs / sizeof *specs; f++) {
        EnfScene *scene = family(specs[f]), *other;
        uint32_t *cells = shuffled(&rng, scene->cell_count), *portals = shuffled(&rng, scene->portal_count);
        uint32_t *objects = shuffled(&rng, scene->object_count), *cell_at = malloc(sizeof *cell_at * scene->cell_count);
        assert_int_equal(enf_scene_create(&other), ENF_OK);
        for (uint32_t i = 0; i < scene->room_count; i++)
            assert_int_equal(enf_scene_add_room(other, "", scene->rooms[i].kind, &(uint32_t){0}), ENF_OK);
        for (uint32_t i = 0; i < scene->opening_count; i++)
            assert_int_equal(enf_scene_add_opening(other, "", scene->openings[i].kind, scene->openings[i].state, &(uint32_t){0}), ENF_OK);
        for (uint32_t i = 0; i < scene->cell_count; i++) {
            uint32_t c = cells[i], first = scene->cell_vertex_first[c], n = scene->cell_vertex_first[c + 1] - first;
            uint32_t face = scene->cell_face_first[c], faces = scene->cell_face_first[c + 1] - face, sizes[32];
            for (uint32_t k = 0; k < faces; k++)
                sizes[k] = scene->face_index_first[face + k + 1] - scene->face_index_first[face + k];
            cell_at[c] = i;
            assert_int_equal(enf_scene_add_cell(other, scene->cell_rooms[c], scene->cell_openings[c],
                                                n ? scene->cell_vertices[first] : NULL, n, 0, sizes, faces,
                                                faces ? scene->face_indices + scene->face_index_first[face] : NULL, &(uint32_t){0}),
                             ENF_OK);
        }
        for (uint32_t i = 0; i < scene->portal_count; i++) {
            uint32_t p = portals[i], first = scene->portal_vertex_first[p], n = scene->portal_vertex_first[p + 1] - first;
            uint32_t turn = (uint32_t)(sight_next(&rng) % n), swap = sight_next(&rng) & 1;
            double polygon[64][3];
            for (uint32_t k = 0; k < n; k++)
                memcpy(polygon[k], scene->portal_vertices[first + (turn + k) % n], sizeof polygon[k]);
            assert_int_equal(enf_scene_add_portal(other, cell_at[scene->portal_cells[p][swap]], cell_at[scene->portal_cells[p][1 - swap]],
                                                  polygon[0], n, 0, scene->portal_openings[p], &(uint32_t){0}),
                             ENF_OK);
        }
        for (uint32_t i = 0; i < scene->object_count; i++) {
            const uint32_t *list;
            uint32_t n, moved[16];
            assert_int_equal(enf_scene_object_cells(scene, objects[i], &list, &n), ENF_OK);
            for (uint32_t k = 0; k < n; k++)
                moved[k] = cell_at[list[k]];
            assert_int_equal(enf_scene_add_object(other, "", scene->objects[objects[i]].bounds, moved, n, 0, &(uint32_t){0}), ENF_OK);
        }
        assert_int_equal(enf_scene_commit(other), ENF_OK);
        SightWalker *walker = sight_walker_create(scene);
        EnfView *a, *b;
        assert_int_equal(enf_view_create(scene, &a), ENF_OK);
        assert_int_equal(enf_view_create(other, &b), ENF_OK);
        for (int k = 0; k < 80; k++) {
            EnfCamera camera = random_camera(scene, walker, &rng);
            EnfViewDef def = enf_default_view_def();
            def.method = (uint32_t)k % 3;
            Sets one = query(scene, a, &camera, &def), two = query(other, b, &camera, &def);
            assert_int_equal(one.cell_count, two.cell_count);
            assert_int_equal(one.object_count, two.object_count);
            for (uint32_t c = 0; c < scene->cell_count; c++)
                assert_int_equal(one.cells[c], two.cells[cell_at[c]]);
            for (uint32_t o = 0; o < scene->object_count; o++)
                assert_int_equal(one.objects[objects[o]], two.objects[o]);
            free_sets(&one);
            free_sets(&two);
        }
        enf_view_destroy(a);
        enf_view_destroy(b);
        sight_walker_destroy(walker);
        enf_scene_destroy(scene);
        enf_scene_destroy(other);
        free(cells);
        free(portals);
        free(objects);
        free(cell_at);
    }
}

static void the_why_is_a_chain_of_open_portals(void **state) {
    (void)state;
    EACH_CAMERA("office:100,closed=0.2", 100) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        EnfViewResult r = enf_default_view_result();
        assert_int_equal(enf_view_query(view, &camera, NULL), ENF_OK);
        assert_int_equal(enf_view_result(view, &r), ENF_OK);
        for (uint32_t i = 0; i < r.cell_count; i++) {
            uint32_t portals[256], n;
            assert_int_equal(enf_view_why_cell(view, r.cells[i], portals, 256, &n), ENF_OK);
            uint32_t at = r.cells[i];
            for (uint32_t p = n; p-- > 0;) { /* back from the cell to the eye */
                const uint32_t *pair = scene->portal_cells[portals[p]];
                assert_true(pair[0] == at || pair[1] == at);
                at = pair[0] == at ? pair[1] : pair[0];
                /* Only who stands in a shut door's recess looks out of it. */
                assert_true(enf_portal_passes(scene, portals[p]) ||
                            (p == 0 && scene->cell_openings[at] == scene->portal_openings[portals[p]]));
            }
            double eye[3] = {camera.world_from_camera[3], camera.world_from_camera[7], camera.world_from_camera[11]};
            uint32_t found[16], located, ok = 0;
            assert_int_equal(enf_scene_locate(scene, eye, found, 16, &located), ENF_OK);
            for (uint32_t j = 0; j < located; j++)
                ok |= found[j] == at || (enf_is_exterior(scene, found[j]) && enf_is_exterior(scene, at)); /* the sweep's outdoors is one */
            assert_true(ok);
        }
        for (uint32_t i = 0; i < r.object_count; i++) {
            uint32_t n, cells;
            const uint32_t *list;
            assert_int_equal(enf_view_why_object(view, r.objects[i], NULL, 0, &n), ENF_OK);
            assert_int_equal(enf_scene_object_cells(scene, r.objects[i], &list, &cells), ENF_OK);
            uint32_t in = 0;
            for (uint32_t j = 0; j < cells; j++)
                in |= list[j] == r.step_cell[r.object_step[i]];
            assert_true(in);
        }
    }
    END_CAMERAS;
}

static void closing_a_door_never_adds(void **state) {
    (void)state;
    EACH_CAMERA("office:46", 60) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        Sets open = query(scene, view, &camera, NULL);
        uint32_t door = (uint32_t)(sight_next(&rng) % scene->opening_count), before = scene->openings[door].state;
        assert_int_equal(enf_scene_set_opening_state(scene, door, ENF_STATE_CLOSED), ENF_OK);
        Sets closed = query(scene, view, &camera, NULL);
        assert_subset(scene, &closed, &open, "closed in open");
        assert_int_equal(enf_scene_set_opening_state(scene, door, before), ENF_OK);
        Sets again = query(scene, view, &camera, NULL);
        assert_subset(scene, &open, &again, "opened again");
        free_sets(&open);
        free_sets(&closed);
        free_sets(&again);
    }
    END_CAMERAS;
}

static void a_near_plane_behind_a_wall_sees_the_next_room(void **state) {
    (void)state;
    EnfScene *scene = family("enfilade:3");
    EnfView *view;
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    double eye[3] = {4.7, 4.5, 2}; /* 5 cm before the wall, beside the door, looking at it */
    EnfCamera camera = camera_at(eye, 0, 0);
    Sets s = query(scene, view, &camera, NULL);
    assert_int_equal(s.cell_count, 1);
    free_sets(&s);
    camera.clip_near = 0.5; /* beyond the wall */
    s = query(scene, view, &camera, NULL);
    assert_true(s.cell_count > 1);
    free_sets(&s);
    camera.clip_near = 0;
    camera.world_from_camera[7] = 1.3; /* in line with the doors */
    s = query(scene, view, &camera, NULL);
    assert_int_equal(s.cell_count, 5);
    free_sets(&s);
    camera.clip_far = 4; /* the third room begins 5.3 m ahead */
    s = query(scene, view, &camera, NULL);
    assert_int_equal(s.cell_count, 3);
    free_sets(&s);
    camera.clip_far = INFINITY;
    EnfViewDef def = enf_default_view_def();
    def.distance_limit = 4;
    s = query(scene, view, &camera, &def);
    assert_int_equal(s.cell_count, 3);
    free_sets(&s);
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

static void a_walk_reuses_its_answer_and_tells_what_changed(void **state) {
    (void)state;
    EnfScene *scene = family("office:46,windows=0");
    EnfView *view, *plain;
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    assert_int_equal(enf_view_create(scene, &plain), ENF_OK);
    EnfViewDef def = enf_default_view_def();
    def.reuse_distance = 1;
    def.reuse_angle = 0.5;
    uint8_t *now = calloc(scene->object_count, 1);
    uint32_t reused = 0, frames = 300;
    for (uint32_t f = 0; f < frames; f++) {
        double eye[3] = {1 + 0.056 * f, 6.2 + 0.3 * sin(0.05 * f), 1.6};
        EnfCamera camera = camera_at(eye, 0.5 * sin(0.02 * f), 0);
        EnfViewStats stats = enf_default_view_stats();
        EnfViewResult r = enf_default_view_result();
        Sets walk = query(scene, view, &camera, &def), exact = query(scene, plain, &camera, NULL);
        assert_subset(scene, &exact, &walk, "frame");
        assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
        reused += stats.reused;
        assert_int_equal(enf_view_result(view, &r), ENF_OK);
        for (uint32_t i = 0; i < r.objects_left_count; i++)
            now[r.objects_left[i]]--;
        for (uint32_t i = 0; i < r.objects_entered_count; i++)
            now[r.objects_entered[i]]++;
        assert_memory_equal(now, walk.objects, scene->object_count);
        free_sets(&walk);
        free_sets(&exact);
    }
    assert_true(reused > frames / 2);
    /* A door that closes ends the reuse. */
    double eye[3] = {1 + 0.056 * (frames - 1), 6.2 + 0.3 * sin(0.05 * (frames - 1)), 1.6};
    EnfCamera camera = camera_at(eye, 0.5 * sin(0.02 * (frames - 1)), 0);
    EnfViewStats stats = enf_default_view_stats();
    assert_int_equal(enf_scene_set_opening_state(scene, 0, ENF_STATE_CLOSED), ENF_OK);
    assert_int_equal(enf_view_query(view, &camera, &def), ENF_OK);
    assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
    assert_int_equal(stats.reused, 0);
    free(now);
    enf_view_destroy(view);
    enf_view_destroy(plain);
    enf_scene_destroy(scene);
}

static void groups_hold_each_object_once_by_mesh(void **state) {
    (void)state;
    EACH_CAMERA("office:46", 20) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        Sets s = query(scene, view, &camera, NULL);
        uint32_t groups;
        const uint32_t *meshes, *first, *objects;
        assert_int_equal(enf_view_groups(view, &groups, &meshes, &first, &objects), ENF_OK);
        assert_int_equal(first[groups], s.object_count);
        for (uint32_t g = 0; g < groups; g++) {
            assert_true(g == 0 || meshes[g] > meshes[g - 1]);
            for (uint32_t i = first[g]; i < first[g + 1]; i++) {
                assert_int_equal(scene->objects[objects[i]].mesh, meshes[g]);
                assert_int_equal(s.objects[objects[i]]--, 1);
            }
        }
        free_sets(&s);
    }
    END_CAMERAS;
}

static void no_query_blows_up(void **state) {
    (void)state;
    EACH_CAMERA("grid:60", 12) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        EnfViewStats stats = enf_default_view_stats();
        assert_int_equal(enf_view_query(view, &camera, NULL), ENF_OK);
        assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
        assert_true(stats.visits <= stats.cells * 1.05 + 2);
        /* Out of budget: the frustum's answer, which holds the exact one. */
        Sets exact = sets_of(scene, view);
        EnfViewDef def = enf_default_view_def();
        def.work_budget = 100;
        Sets rough = query(scene, view, &camera, &def);
        assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
        assert_true(stats.budget_hit || exact.cell_count <= 12);
        assert_subset(scene, &exact, &rough, "out of budget");
        free_sets(&exact);
        free_sets(&rough);
    }
    END_CAMERAS;
}

/* Some beyond 50,000 objects: no tree over all of them is made then, and none is compared when there is no time for that. */
static void many_objects_are_culled_from_cell_to_cell(void **state) {
    (void)state;
    uint32_t culled = 0;
    EACH_CAMERA("grid:52,objects=20", 12) {
        EnfCamera camera = random_camera(scene, walker, &rng);
        EnfViewDef def = enf_default_view_def();
        def.method = ENF_VIEW_FRUSTUM;
        Sets frustum = query(scene, view, &camera, &def);
        def.method = ENF_VIEW_CLIP;
        def.work_budget = 200000; /* the fallback costs some 70,000 */
        Sets some = query(scene, view, &camera, &def);
        if (stats_of(view).budget_hit) {
            assert_int_equal(stats_of(view).budget_hit, 1);
            assert_subset(scene, &frustum, &some, "from cell to cell");
            assert_int_equal(some.object_count, frustum.object_count);
            culled++;
        }
        def.work_budget = 100;
        Sets all = query(scene, view, &camera, &def);
        assert_int_equal(stats_of(view).budget_hit, 2);
        assert_int_equal(all.cell_count, scene->cell_count);
        assert_int_equal(all.object_count, scene->object_count);
        for (uint32_t o = 0; o < scene->object_count; o++)
            assert_int_equal(all.objects[o], 1);
        free_sets(&frustum);
        free_sets(&some);
        free_sets(&all);
    }
    assert_true(scene->object_count > 50000 && culled > 0);
    END_CAMERAS;
}

static void unplaced_objects_are_seen_wherever_the_view_reaches(void **state) {
    (void)state;
    EnfScene *scene;
    EnfView *view;
    assert_int_equal(enf_family_build("enfilade:3", &scene), ENF_OK);
    double far_off[6] = {-50, 1, 1, -49, 2, 2}, ahead[6] = {500, 1, 1, 501, 2, 2};
    uint32_t a, b;
    assert_int_equal(enf_scene_add_object(scene, "behind", far_off, NULL, 0, ENF_NONE, &a), ENF_OK);
    assert_int_equal(enf_scene_add_object(scene, "ahead", ahead, NULL, 0, ENF_NONE, &b), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_int_equal(scene->unplaced_count, 2);
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    double eye[3] = {1, 1.3, 1.6};
    EnfCamera camera = camera_at(eye, 0, 0);
    Sets s = query(scene, view, &camera, NULL);
    EnfViewStats stats = enf_default_view_stats();
    assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
    assert_int_equal(stats.objects_unplaced, 1);
    assert_int_equal(s.objects[a], 0);
    assert_int_equal(s.objects[b], 1);
    free_sets(&s);
    /* An eye outside of everything sees by the frustum. */
    double outside[3] = {-5, 1.3, 1.6};
    camera = camera_at(outside, 0, 0);
    s = query(scene, view, &camera, NULL);
    assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
    assert_int_equal(stats.eye_outside, 1);
    assert_true(s.cell_count >= 5);
    free_sets(&s);
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

static void bad_questions_get_reasons(void **state) {
    (void)state;
    EnfScene *scene;
    EnfView *view;
    assert_int_equal(enf_family_build("enfilade:3", &scene), ENF_OK);
    assert_int_equal(enf_view_create(scene, &view), ENF_ERROR_STATE);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_int_equal(enf_view_create(scene, NULL), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    EnfViewResult r = enf_default_view_result();
    assert_int_equal(enf_view_result(view, &r), ENF_ERROR_STATE);
    double eye[3] = {1, 1.3, 1.6};
    EnfCamera good = camera_at(eye, 0, 0), bad = good;
    bad.world_from_camera[3] = NAN;
    assert_int_equal(enf_view_query(view, &bad, NULL), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "not finite"));
    bad = good;
    bad.world_from_camera[0] = bad.world_from_camera[4] = bad.world_from_camera[8] = 0;
    assert_int_equal(enf_view_query(view, &bad, NULL), ENF_ERROR_BAD_INPUT);
    bad = good;
    bad.angle_x = -1;
    assert_int_equal(enf_view_query(view, &bad, NULL), ENF_ERROR_BAD_INPUT);
    bad = good;
    bad.struct_size = 4;
    assert_int_equal(enf_view_query(view, &bad, NULL), ENF_ERROR_INVALID_ARGUMENT);
    EnfViewDef def = enf_default_view_def();
    def.method = 9;
    assert_int_equal(enf_view_query(view, &good, &def), ENF_ERROR_INVALID_ARGUMENT);
    def = enf_default_view_def();
    def.max_apertures = 0;
    assert_int_equal(enf_view_query(view, &good, &def), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_view_query_union(view, &good, 0, 0, NULL), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_view_query(view, &good, NULL), ENF_OK);
    uint32_t n;
    assert_int_equal(enf_view_why_cell(view, 999, NULL, 0, &n), ENF_ERROR_INVALID_ARGUMENT);
    /* Edited: no answer until it is committed again; then a new one. */
    uint32_t room;
    assert_int_equal(enf_scene_add_room(scene, "late", ENF_ROOM_INTERIOR, &room), ENF_OK);
    assert_int_equal(enf_view_query(view, &good, NULL), ENF_ERROR_STATE);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_int_equal(enf_view_query(view, &good, NULL), ENF_OK);
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clip_is_within_box_and_box_within_frustum),
        cmocka_unit_test(nothing_hidden_is_kept_without_need),
        cmocka_unit_test(same_bits_again_and_without_simd),
        cmocka_unit_test(the_order_of_input_does_not_matter),
        cmocka_unit_test(the_why_is_a_chain_of_open_portals),
        cmocka_unit_test(closing_a_door_never_adds),
        cmocka_unit_test(a_near_plane_behind_a_wall_sees_the_next_room),
        cmocka_unit_test(a_walk_reuses_its_answer_and_tells_what_changed),
        cmocka_unit_test(groups_hold_each_object_once_by_mesh),
        cmocka_unit_test(no_query_blows_up),
        cmocka_unit_test(many_objects_are_culled_from_cell_to_cell),
        cmocka_unit_test(unplaced_objects_are_seen_wherever_the_view_reaches),
        cmocka_unit_test(bad_questions_get_reasons),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
