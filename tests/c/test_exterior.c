/* SPDX-License-Identifier: GPL-3.0-or-later
 * The outdoors as cells: few of them, whole, round any footprint; what the calls say when it can't be done.
 * (That nothing is hidden by it: test_exterior_witness.c.) */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "geometry/vec3.h"
#include "moved_scene.h"
#include "raycast/ray_model.h"
#include "scene/scene_data.h"
#include "scene_family.h"
#include "sight_walker.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static EnfScene *built(const char *spec) {
    EnfScene *scene;
    assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
    if (enf_scene_commit(scene) != ENF_OK)
        fail_msg("%s: %s", spec, enf_last_error());
    return scene;
}

static uint32_t outdoor_cells(const EnfScene *scene) {
    uint32_t count = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        count += enf_is_exterior(scene, c) && c != scene->hub;
    return count;
}

static void few_cells_whatever_the_footprint(void **state) {
    (void)state;
    static const struct {
        const char *spec;
        uint32_t most;
    } table[] = {{"office:46", 8},           /* a block: four sides, above, below; beside the hall, whose walls have no windows */
                 {"office:1768", 10},        /* an E: two courts more */
                 {"court:8", 7},             /* a court more */
                 {"tower:20,windows=1", 10}, /* a cross */
                 {"town:24", 260}};          /* 24 houses at odd angles: about ten each */
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        EnfScene *scene = built(table[i].spec);
        assert_true(scene->hub != ENF_NONE);
        assert_in_range(outdoor_cells(scene), 6, table[i].most);
        enf_scene_destroy(scene);
    }
}

/* Outdoors and indoors, every point is where it belongs: asked of the rooms' own boxes. */
static void every_point_is_in_one_or_the_other(void **state) {
    (void)state;
    EnfScene *scene = built("town:6,turned=0,objects=0");
    SightRng rng = {5};
    double box[6];
    for (int k = 0; k < 6; k++) /* its axes are the scene's */
        box[k] = scene->hub_box[k] + scene->origin[k % 3];
    uint32_t outdoors = 0, indoors = 0, far = 0;
    for (int k = 0; k < 20000; k++) {
        double p[3], nearest = INFINITY;
        for (int i = 0; i < 3; i++)
            p[i] = box[i] + (box[3 + i] - box[i]) * (1.2 * sight_unit(&rng) - 0.1);
        uint32_t room = ENF_NONE, found[16], count;
        for (uint32_t c = 0; c < scene->cell_count; c++) {
            double beyond = 0;
            if (enf_is_exterior(scene, c) || scene->cell_openings[c] != ENF_NONE)
                continue;
            for (uint32_t v = scene->cell_vertex_first[c], i = 0; i < 3; i++) { /* upright boxes */
                double lo = INFINITY, hi = -INFINITY;
                for (uint32_t w = v; w < scene->cell_vertex_first[c + 1]; w++) {
                    lo = fmin(lo, scene->cell_vertices[w][i]);
                    hi = fmax(hi, scene->cell_vertices[w][i]);
                }
                beyond = fmax(beyond, fmax(lo - p[i], p[i] - hi));
            }
            if (beyond <= 0)
                room = c;
            nearest = fmin(nearest, beyond);
        }
        assert_int_equal(enf_scene_locate(scene, p, found, 16, &count), ENF_OK);
        if (room != ENF_NONE && count) {
            indoors++;
            for (uint32_t i = 0; i < count; i++)
                assert_false(enf_is_exterior(scene, found[i]) && count == 1);
        } else if (nearest > 0.301) { /* farther off than walls are thick: in the open */
            outdoors++;
            assert_true(count >= 1);
            for (uint32_t i = 0; i < count; i++)
                assert_true(enf_is_exterior(scene, found[i]) || scene->cell_openings[found[i]] != ENF_NONE);
            int outside = 0;
            for (int i = 0; i < 3; i++)
                outside |= p[i] < box[i] - 1e-3 || p[i] > box[3 + i] + 1e-3;
            far += (uint32_t)outside;
            if (outside)
                assert_int_equal(found[0], scene->hub);
        }
    }
    assert_true(indoors > 50 && outdoors > 10000 && far > 1000);
    enf_scene_destroy(scene);
}

/* What rays rest on: a cell outdoors has its portals in its faces, no recess reaches into it, and it is an upright prism. */
static void cells_outdoors_end_at_the_openings(void **state) {
    (void)state;
    static const struct {
        const char *spec;
        double turn;
        uint32_t others; /* cells, with the hub, that aren't prisms */
    } table[] = {{"office:46,objects=0", 0, 1},     {"office:200,objects=0", 0.3, 1}, {"court:5,objects=0", 1.1, 1},
                 {"tower:3,windows=1", 0.7, 1},     {"town:6,objects=0", 0, 3},       {"town:6,turned=0,objects=0", 0.2, 1},
                 {"town:3,turned=0,garden=9", 2, 1}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char spec[96];
        snprintf(spec, sizeof spec, "%s,outdoors=0", table[i].spec);
        EnfScene *given = built(spec);
        const Motion turn = {{{cos(table[i].turn), -sin(table[i].turn), 0}, {sin(table[i].turn), cos(table[i].turn), 0}, {0, 0, 1}},
                             1,
                             {1e5 * table[i].turn, 0, 0}};
        EnfScene *scene = moved_scene(given, &turn);
        assert_int_equal(enf_scene_decompose_exterior(scene, NULL, NULL), ENF_OK);
        assert_int_equal(enf_scene_commit(scene), ENF_OK);
        EnfRaycaster *rays;
        assert_int_equal(enf_raycaster_create(scene, &rays), ENF_OK);
        assert_in_range(scene->cell_count - rays->prisms.prisms, 0, table[i].others);
        enf_raycaster_destroy(rays);
        for (uint32_t c = 0; c < scene->cell_count; c++) {
            if (scene->cell_openings[c] != ENF_NONE) {
                uint32_t found[4], count;
                assert_int_equal(enf_scene_locate(scene, scene->cell_centres[c], found, 4, &count), ENF_OK);
                assert_int_equal(count, 1);
            }
            for (uint32_t k = scene->cell_portal_first[c]; k < scene->cell_portal_first[c + 1] && enf_is_exterior(scene, c); k++) {
                double least = INFINITY;
                uint32_t p = scene->cell_portals[k].portal;
                for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
                    double most = 0;
                    for (uint32_t v = scene->portal_vertex_first[p]; v < scene->portal_vertex_first[p + 1]; v++) {
                        double d = -scene->face_planes[f].d;
                        for (int x = 0; x < 3; x++)
                            d += scene->face_planes[f].n[x] * (scene->portal_vertices[v][x] - scene->origin[x]);
                        most = fmax(most, fabs(d));
                    }
                    least = fmin(least, most);
                }
                assert_true(c == scene->hub || least <= scene->tolerance);
            }
        }
        enf_scene_destroy(scene);
        enf_scene_destroy(given);
    }
}

static double area_of(const EnfScene *scene, uint32_t p) {
    double sum[3] = {0, 0, 0};
    const double(*v)[3] = (const double(*)[3])(scene->portal_vertices + scene->portal_vertex_first[p]);
    for (uint32_t i = 1; i + 1 < scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p]; i++)
        for (int k = 0; k < 3; k++) {
            int x = (k + 1) % 3, y = (k + 2) % 3;
            sum[k] += (v[i][x] - v[0][x]) * (v[i + 1][y] - v[0][y]) - (v[i][y] - v[0][y]) * (v[i + 1][x] - v[0][x]);
        }
    return 0.5 * sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
}

static void openings_keep_their_area_and_their_first_index(void **state) {
    (void)state;
    EnfScene *before = built("town:7,outdoors=0"), *after = built("town:7");
    double sums[2] = {0, 0};
    assert_true(after->portal_count > before->portal_count);
    for (uint32_t p = 0; p < before->portal_count; p++) {
        assert_int_equal(before->portal_openings[p], after->portal_openings[p]);
        sums[0] += area_of(before, p);
    }
    for (uint32_t p = 0; p < after->portal_count; p++)
        if (after->portal_openings[p] != ENF_NONE) {
            sums[1] += area_of(after, p);
            assert_true(after->portal_cells[p][0] != after->hub && after->portal_cells[p][1] != after->hub);
        }
    assert_true(fabs(sums[0] - sums[1]) < 1e-9 * sums[0]);
    enf_scene_destroy(before);
    enf_scene_destroy(after);
}

static void a_saved_scene_still_has_its_hub(void **state) {
    (void)state;
    EnfScene *scene = built("court:4,storeys=1"), *again;
    assert_int_equal(enf_scene_save_json(scene, "test_exterior.enf.json"), ENF_OK);
    assert_int_equal(enf_scene_load("test_exterior.enf.json", &again), ENF_OK);
    assert_int_equal(enf_scene_commit(again), ENF_OK);
    assert_int_equal(again->hub, scene->hub);
    assert_memory_equal(again->hub_box, scene->hub_box, sizeof scene->hub_box);
    EnfExteriorReport report = {sizeof report};
    assert_int_equal(enf_scene_decompose_exterior(again, NULL, &report), ENF_OK);
    assert_int_equal(report.outcome, ENF_EXTERIOR_ALREADY);
    enf_scene_destroy(again);
    enf_scene_destroy(scene);
    remove("test_exterior.enf.json");
}

/* Turned any way after it was cut, the box has its hub, and every point is in it or not as before. */
static void a_turned_scene_keeps_its_hub(void **state) {
    (void)state;
    EnfScene *scene = built("court:4,storeys=1");
    SightRng rng = {3};
    for (int k = 0; k < 6; k++) {
        Motion motion = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, k % 3 == 1 ? 1e-3 : 1, {0, 0, 0}};
        if (k < 3)
            random_level_turn(&rng, motion.rotation);
        else
            random_turn(&rng, motion.rotation);
        for (int i = 0; i < 3; i++)
            motion.offset[i] = k % 3 == 2 ? 1e7 * sight_unit(&rng) : 0;
        EnfScene *turned = moved_scene(scene, &motion);
        assert_int_equal(enf_scene_commit(turned), ENF_OK);
        assert_int_equal(turned->hub, scene->hub);
        uint32_t in_hub = 0, out = 0;
        for (int i = 0; i < 400; i++) {
            double p[3], q[3];
            uint32_t found[2], count[2];
            for (int c = 0; c < 3; c++)
                p[c] = scene->bounds[c] + (scene->bounds[3 + c] - scene->bounds[c]) * (1.4 * sight_unit(&rng) - 0.2);
            move_point(&motion, p, q);
            assert_int_equal(enf_scene_locate(scene, p, &found[0], 1, &count[0]), ENF_OK);
            assert_int_equal(enf_scene_locate(turned, q, &found[1], 1, &count[1]), ENF_OK);
            assert_int_equal(count[0], count[1]);
            if (count[0] == 0)
                continue; /* in a wall */
            assert_int_equal(found[0], found[1]);
            in_hub += found[0] == scene->hub;
            out += found[0] != scene->hub;
        }
        assert_true(in_hub > 50 && out > 50);
        enf_scene_destroy(turned);
    }
    enf_scene_destroy(scene);
}

static void what_cannot_be_cut_stays_as_it_is(void **state) {
    (void)state;
    EnfExteriorReport report = {sizeof report};
    EnfScene *scene;
    assert_int_equal(enf_family_build("enfilade:4", &scene), ENF_OK); /* nothing leads outdoors */
    assert_int_equal(enf_scene_decompose_exterior(scene, NULL, &report), ENF_OK);
    assert_int_equal(report.outcome, ENF_EXTERIOR_NONE);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    enf_scene_destroy(scene);

    assert_int_equal(enf_family_build("court:4,outdoors=0", &scene), ENF_OK);
    uint32_t cells = scene->cell_count, portals = scene->portal_count;
    EnfExteriorDef def = enf_default_exterior_def();
    def.max_cells = 3;
    assert_int_equal(enf_scene_decompose_exterior(scene, &def, &report), ENF_OK);
    assert_int_equal(report.outcome, ENF_EXTERIOR_TOO_COMPLEX);
    assert_int_equal(scene->cell_count, cells);
    assert_int_equal(scene->portal_count, portals);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    assert_true(enf_scene_problem_count(scene) == 1 && scene->hub == ENF_NONE);

    uint32_t room, other, made; /* a second outside: nobody knows which is where */
    assert_int_equal(enf_scene_add_room(scene, "Garden", ENF_ROOM_EXTERIOR, &room), ENF_OK);
    assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &other), ENF_OK);
    double gate[4][3] = {{0, -20, 0}, {1, -20, 0}, {1, -20, 2}, {0, -20, 2}};
    assert_int_equal(enf_scene_add_portal(scene, 1, other, gate[0], 4, 0, ENF_NONE, &made), ENF_OK);
    assert_int_equal(enf_scene_decompose_exterior(scene, NULL, &report), ENF_OK);
    assert_int_equal(report.outcome, ENF_EXTERIOR_SEVERAL);
    enf_scene_destroy(scene);
    assert_int_equal(enf_scene_decompose_exterior(NULL, NULL, NULL), ENF_ERROR_INVALID_ARGUMENT);
}

/* Two blocks of one room, a window each in the walls that face each other. */
static EnfScene *two_blocks(double between) {
    EnfScene *scene;
    uint32_t rooms[3], cells[3], opening, made;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    assert_int_equal(enf_scene_add_room(scene, "Outside", ENF_ROOM_EXTERIOR, &rooms[0]), ENF_OK);
    assert_int_equal(enf_scene_add_cell(scene, rooms[0], ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &cells[0]), ENF_OK);
    for (int i = 1; i <= 2; i++) {
        double x0 = i == 1 ? 0 : 4 + between, v[8][3];
        assert_int_equal(enf_scene_add_room(scene, "Block", ENF_ROOM_INTERIOR, &rooms[i]), ENF_OK);
        for (int k = 0; k < 8; k++) {
            v[k][0] = x0 + (k & 1) * 4;
            v[k][1] = (k >> 1 & 1) * 6;
            v[k][2] = (k >> 2 & 1) * 3;
        }
        assert_int_equal(enf_scene_add_cell(scene, rooms[i], ENF_NONE, v[0], 8, 0, NULL, 0, NULL, &cells[i]), ENF_OK);
        /* A window 0.3 m deep in the south wall: so thick are walls. */
        double w[8][3], in[4][3], out[4][3];
        for (int k = 0; k < 8; k++) {
            w[k][0] = x0 + 1 + (k & 1) * 2;
            w[k][1] = -0.3 * (k >> 1 & 1);
            w[k][2] = 1 + (k >> 2 & 1);
        }
        static const int inner[4] = {0, 1, 5, 4}, outer[4] = {2, 3, 7, 6};
        for (int k = 0; k < 4; k++) {
            memcpy(in[k], w[inner[k]], sizeof in[k]);
            memcpy(out[k], w[outer[k]], sizeof out[k]);
        }
        uint32_t recess;
        assert_int_equal(enf_scene_add_opening(scene, "W", ENF_OPENING_WINDOW, ENF_STATE_GLASS, &opening), ENF_OK);
        assert_int_equal(enf_scene_add_cell(scene, ENF_NONE, opening, w[0], 8, 0, NULL, 0, NULL, &recess), ENF_OK);
        assert_int_equal(enf_scene_add_portal(scene, cells[i], recess, in[0], 4, 0, opening, &made), ENF_OK);
        assert_int_equal(enf_scene_add_portal(scene, recess, cells[0], out[0], 4, 0, opening, &made), ENF_OK);
    }
    return scene;
}

/* How many cells outdoors hold a point that lies in a block, 1.5 m from its walls. */
static int outdoors_at(const EnfScene *scene, double z) {
    const double point[3] = {1.5 - scene->origin[0], 3 - scene->origin[1], z - scene->origin[2]};
    int count = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        uint32_t f = scene->cell_face_first[c], end = scene->cell_face_first[c + 1];
        int holds = enf_is_exterior(scene, c) && f < end;
        for (; f < end; f++)
            holds &= vec_dot(scene->face_planes[f].n, point) <= scene->face_planes[f].d;
        count += holds;
    }
    return count;
}

static void above_its_top_a_room_is_outdoors_as_well(void **state) {
    (void)state;
    const double tops[2] = {INFINITY, 2.2};
    EnfExteriorDef def = enf_default_exterior_def();
    def.room_tops = tops;
    def.room_count = 2; /* the second block isn't in it: its shape is outdoors nowhere */
    for (int k = 0; k < 2; k++) {
        EnfScene *scene = two_blocks(1.0);
        assert_int_equal(enf_scene_decompose_exterior(scene, k ? &def : NULL, NULL), ENF_OK);
        if (enf_scene_commit(scene) != ENF_OK)
            fail_msg("%s", enf_last_error());
        assert_int_equal(outdoors_at(scene, 2.1), 0);
        assert_int_equal(outdoors_at(scene, 2.3), k);
        enf_scene_destroy(scene);
    }
}

static void an_alley_wider_than_a_wall_is_open_and_a_wall_is_not(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        double between = k ? 0.4 : 0.25, middle[3] = {4 + 0.5 * between, 3, 1.5};
        EnfScene *scene = two_blocks(between);
        EnfExteriorReport report = {sizeof report};
        uint32_t found[8], count;
        assert_int_equal(enf_scene_decompose_exterior(scene, NULL, &report), ENF_OK);
        assert_int_equal(report.outcome, ENF_EXTERIOR_DONE);
        assert_true(fabs(report.wall_gap - 0.306) < 1e-9);
        if (enf_scene_commit(scene) != ENF_OK)
            fail_msg("%s", enf_last_error());
        assert_int_equal(enf_scene_locate(scene, middle, found, 8, &count), ENF_OK);
        assert_int_equal(count, k); /* in a wall: nowhere, and an eye there sees by the frustum */
        /* Through the alley, from north to south. */
        EnfView *view;
        EnfViewResult result = enf_default_view_result();
        EnfCamera camera = enf_default_camera();
        double pose[16] = {-1, 0, 0, middle[0], 0, 0, 1, 8, 0, 1, 0, 1.5, 0, 0, 0, 1};
        memcpy(camera.world_from_camera, pose, sizeof pose);
        camera.clip_near = 0;
        camera.angle_x = camera.angle_y = 0.02; /* narrower than the alley */
        double south[3] = {middle[0], -2, 1.5};
        uint32_t there;
        assert_int_equal(enf_scene_locate(scene, south, &there, 1, &count), ENF_OK);
        assert_int_equal(enf_view_create(scene, &view), ENF_OK);
        EnfViewDef def = enf_default_view_def();
        def.outdoors = ENF_OUTDOORS_EXACT;
        assert_int_equal(enf_view_query(view, &camera, &def), ENF_OK);
        assert_int_equal(enf_view_result(view, &result), ENF_OK);
        int seen = 0;
        for (uint32_t i = 0; i < result.cell_count; i++)
            seen |= result.cells[i] == there;
        assert_int_equal(seen, k);
        enf_view_destroy(view);
        enf_scene_destroy(scene);
    }
}

/* A wall that a look from a room goes into is hollow: the outdoors reach in there, and no farther. Not into the room beyond, and not
 * into the room it began in. */
static void outdoors_within_a_hollow_wall_stay_in_it(void **state) {
    (void)state;
    EnfScene *scene = two_blocks(0.25);
    EnfExteriorReport report = {sizeof report};
    double slot[4][3], gap[3] = {4.125, 3, 1.5};
    uint32_t portal, found[8], count, in_gap = 0;
    for (int k = 0; k < 4; k++) {
        slot[k][0] = 4;
        slot[k][1] = k == 1 || k == 2 ? 2.1 : 2;
        slot[k][2] = k < 2 ? 1 : 2;
    }
    /* Cells: 0 outside, 1 and 3 the blocks, 2 and 4 their windows. */
    assert_int_equal(enf_scene_add_portal(scene, 1, 0, slot[0], 4, 0, ENF_NONE, &portal), ENF_OK);
    assert_int_equal(enf_scene_decompose_exterior(scene, NULL, &report), ENF_OK);
    assert_int_equal(report.outcome, ENF_EXTERIOR_DONE);
    if (enf_scene_commit(scene) != ENF_OK)
        fail_msg("%s", enf_last_error());
    assert_int_equal(enf_scene_locate(scene, gap, found, 8, &count), ENF_OK);
    assert_int_equal(count, 1);
    assert_true(enf_is_exterior(scene, found[0]));
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        if (!enf_is_exterior(scene, c) || c == scene->hub)
            continue;
        const double *box = scene->cell_bounds[c];
        for (int i = 0; i < 2; i++) { /* deeper than a fiftieth of a wall into either block */
            double low[3] = {i ? 4.25 : 0, 0, 0}, high[3] = {i ? 8.25 : 4, 6, 3}, deep = INFINITY;
            for (int k = 0; k < 3; k++)
                deep = fmin(deep, fmin(high[k], box[3 + k]) - fmax(low[k], box[k]));
            assert_true(deep < 0.0062);
        }
        in_gap += box[0] > 3.9 && box[3] < 4.35;
    }
    assert_true(in_gap > 0);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_cells_whatever_the_footprint),         cmocka_unit_test(every_point_is_in_one_or_the_other),
        cmocka_unit_test(cells_outdoors_end_at_the_openings),       cmocka_unit_test(openings_keep_their_area_and_their_first_index),
        cmocka_unit_test(a_saved_scene_still_has_its_hub),          cmocka_unit_test(a_turned_scene_keeps_its_hub),
        cmocka_unit_test(what_cannot_be_cut_stays_as_it_is),        cmocka_unit_test(an_alley_wider_than_a_wall_is_open_and_a_wall_is_not),
        cmocka_unit_test(above_its_top_a_room_is_outdoors_as_well), cmocka_unit_test(outdoors_within_a_hollow_wall_stay_in_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
