/* SPDX-License-Identifier: GPL-3.0-or-later
 * No scene makes a query expensive: work counted, in scenes made to make sight fan out. ENF_HOSTILE_FULL=1: the large ones too (a
 * million portals in one cell, a million open cells), some minutes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "scene/scene_data.h"
#include "level_camera.h"
#include "scene_family.h"
#include "sight_walker.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BUDGET = 2100000 }; /* the default */

static EnfCamera random_camera(const EnfScene *scene, const SightWalker *walker, SightRng *rng, uint32_t k) {
    double eye[3], yaw = 6.283185307179586 * sight_unit(rng), pitch = 0.6 * sight_unit(rng) - 0.3;
    uint32_t cell = (uint32_t)(sight_next(rng) % scene->cell_count);
    if (k % 4 == 0) /* one that holds much: the first cell of hubs and screens */
        cell = 0;
    assert_true(sight_point_in_cell(walker, rng, cell, k % 5 == 4, eye));
    EnfCamera camera = level_camera(eye, yaw, pitch);
    camera.clip_near = k % 3 == 0 ? 0.1 : 0;
    if (k % 7 == 6) {
        camera.type = ENF_CAMERA_PANO;
        camera.angle_x = 6.283185307179586;
        camera.angle_y = 3.141592653589793;
    }
    return camera;
}

/* most_repeat: visits over cells that the scene may cost. */
static void bounded(const char *spec, uint32_t cameras, double most_repeat) {
    EnfScene *scene;
    EnfView *view;
    if (enf_family_build(spec, &scene) != ENF_OK || enf_scene_commit(scene) != ENF_OK)
        fail_msg("%s: %s", spec, enf_last_error());
    SightWalker *walker = sight_walker_create(scene);
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    SightRng rng = {5};
    double worst = 0, repeat = 0;
    uint64_t most_work = 0, most_tested = 0;
    uint32_t budgets = 0;
    for (uint32_t k = 0; k < cameras; k++) {
        EnfCamera camera = random_camera(scene, walker, &rng, k);
        for (uint32_t method = ENF_VIEW_BOX; method <= ENF_VIEW_CLIP; method++) {
            EnfViewDef def = enf_default_view_def();
            EnfViewStats s = enf_default_view_stats();
            def.method = method;
            if (enf_view_query(view, &camera, &def) != ENF_OK)
                fail_msg("%s: %s", spec, enf_last_error());
            assert_int_equal(enf_view_stats(view, &s), ENF_OK);
            worst = fmax(worst, s.microseconds);
            most_work = s.work > most_work ? s.work : most_work;
            most_tested = s.portals_tested > most_tested ? s.portals_tested : most_tested;
            budgets += s.budget_hit != 0;
            if (!s.budget_hit && camera.type != ENF_CAMERA_PANO)
                repeat = fmax(repeat, (s.visits - (double)s.start_cells) / s.cells);
            assert_true(s.work <= BUDGET + BUDGET / 50); /* looked at before each portal: some apertures and hulls may follow */
        }
    }
    print_message("%s: %u cells, %u portals; most work %llu, portals tested %llu, visits over cells %.2f, out of budget %u of %u, worst "
                  "%.1f ms\n",
                  spec, scene->cell_count, scene->portal_count, (unsigned long long)most_work, (unsigned long long)most_tested, repeat,
                  budgets, 2 * cameras, worst / 1000);
    assert_true(repeat <= most_repeat);
    enf_view_destroy(view);
    sight_walker_destroy(walker);
    enf_scene_destroy(scene);
}

static void loops_slits_screens_and_shifted_rows_stay_in_bounds(void **state) {
    (void)state;
    bounded("rings:20,detail=60", 20, 1.05);
    bounded("brick:40", 20, 2.2);
    bounded("slits:30", 20, 1.5);
    bounded("screens:12,detail=20", 12, 1.5);
    bounded("screens:3,detail=150", 8, 1.5); /* 22,500 portals between two cells */
    bounded("spiral:40", 20, 1.05);
    bounded("comb:100", 20, 1.5);
    bounded("hub:2000", 12, 1.05);
    bounded("columns:40", 12, 1.3);
    bounded("pile:20000,detail=20", 12, 1.05);
    bounded("litter:20000", 12, 1.05);
}

static void open_plans_cost_a_visit_a_cell_however_large(void **state) {
    (void)state;
    bounded("grid:30", 12, 1.05);
    bounded("grid:120", 8, 1.05);
    bounded("grid:16,storeys=16", 8, 1.05);
}

static void the_largest_run_out_of_budget_and_are_answered(void **state) {
    (void)state;
    bounded("grid:300", 10, 1.05);
    bounded("grid:600", 10, 1.05);
    bounded("grid:100,storeys=100", 10, 1.05); /* a million cells */
    bounded("screens:3,detail=700", 10, 1.5);  /* a million portals between three cells */
    bounded("screens:60,detail=60", 10, 2);
    bounded("hub:200000", 10, 1.05);
    bounded("brick:300", 10, 2.2);
    bounded("slits:300", 10, 1.5);
    bounded("columns:300", 10, 1.5);
    bounded("rings:300,detail=300", 10, 1.05);
    bounded("office:20000", 10, 12);
    bounded("pile:8000000", 10, 1.05); /* objects in one room */
    bounded("pile:100000,detail=100", 10, 1.05);
    bounded("litter:8000000", 10, 1.05); /* in none */
    bounded("enfilade:500000,objects=1", 10, 1.05);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loops_slits_screens_and_shifted_rows_stay_in_bounds),
        cmocka_unit_test(open_plans_cost_a_visit_a_cell_however_large),
    };
    const struct CMUnitTest large[] = {
        cmocka_unit_test(the_largest_run_out_of_budget_and_are_answered),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    if (getenv("ENF_HOSTILE_FULL"))
        failed += cmocka_run_group_tests(large, NULL, NULL);
    return failed;
}
