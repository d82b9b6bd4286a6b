/* SPDX-License-Identifier: GPL-3.0-or-later
 * Short cuts that looking at buildings from outdoors takes: boxes against a cone eight at a time, windows as rectangles, the sweep.
 * They keep what the plain ways keep, the first two next to nothing more. (That nothing is hidden: test_exterior_witness.c.) */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "from_point/box_cone.h"
#include "level_camera.h"
#include "moved_scene.h"
#include "scene/scene_data.h"
#include "scene_family.h"
#include "sight_walker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double between(SightRng *rng, double low, double high) {
    return low + (high - low) * sight_unit(rng);
}

/* Four corners of a cone about `look`, counter-clockwise. */
static void random_cone(SightRng *rng, double d[4][3]) {
    double look[3], u[3], v[3], size = 0;
    for (int k = 0; k < 3; k++) {
        look[k] = between(rng, -1, 1);
        size += look[k] * look[k];
    }
    for (int k = 0; k < 3; k++)
        look[k] /= sqrt(size);
    int a = fabs(look[0]) < 0.6 ? 0 : 1;
    for (int k = 0; k < 3; k++)
        u[k] = (k == a) - look[a] * look[k];
    for (int k = 0; k < 3; k++)
        v[k] = look[(k + 1) % 3] * u[(k + 2) % 3] - look[(k + 2) % 3] * u[(k + 1) % 3];
    double lo = between(rng, -0.5, 0), hi = between(rng, 0, 0.5);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            d[i][k] = look[k] + (i == 0 || i == 3 ? lo : hi) * u[k] + (i < 2 ? lo : hi) * v[k];
}

static int in_cone(double (*d)[3], const double p[3]) {
    for (int i = 0; i < 4; i++) {
        const double *a = d[i], *b = d[(i + 1) % 4];
        double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
        if (n[0] * p[0] + n[1] * p[1] + n[2] * p[2] <= 0)
            return 0;
    }
    return 1;
}

static void boxes_that_meet_a_cone_stay_and_most_others_go(void **state) {
    (void)state;
    SightRng rng = {11};
    uint32_t seen = 0, apart = 0;
    for (int k = 0; k < 20000; k++) {
        double d[4][3], boxes[8][6], eye[3], reach = k % 3 ? 100 : 1e-2;
        EnfTreeItem order[8];
        EnfBoxes8 block;
        EnfCone cone;
        random_cone(&rng, d);
        for (int c = 0; c < 3; c++)
            eye[c] = reach * between(&rng, -1, 1);
        for (int i = 0; i < 8; i++)
            for (int c = 0; c < 3; c++) {
                double at = reach * between(&rng, -1, 1), half = 0.1 * reach * sight_unit(&rng);
                boxes[i][c] = at - half;
                boxes[i][3 + c] = at + half;
            }
        enf_tree_build((const double(*)[6])boxes, 8, order, &block);
        enf_cone_make(&cone, (const double(*)[3])d, 4, 7, eye, 1.2 * reach);
        uint32_t kept = enf_boxes_in_cone(&block, 0xFF, &cone, 1);
        assert_int_equal(kept, enf_boxes_in_cone(&block, 0xFF, &cone, 0));
        for (int i = 0; i < 8; i++) {
            const double *box = boxes[order[i].at];
            int meets = 0;
            for (int t = 0; t < 60 && !meets; t++) {
                double p[3];
                for (int c = 0; c < 3; c++)
                    p[c] = (t < 8 ? box[c + 3 * (t >> c & 1)] : between(&rng, box[c], box[3 + c])) - eye[c];
                meets = in_cone(d, p);
            }
            assert_true(!meets || kept >> i & 1);
            seen += (uint32_t)meets;
            apart += !(kept >> i & 1);
        }
    }
    assert_true(seen > 2000 && apart > 100000);
}

static void take(EnfView *view, const EnfCamera *camera, const EnfViewDef *def, const EnfScene *scene, uint8_t *cells, uint8_t *objects) {
    EnfViewResult result = enf_default_view_result();
    assert_int_equal(enf_view_query(view, camera, def), ENF_OK);
    assert_int_equal(enf_view_result(view, &result), ENF_OK);
    memset(cells, 0, scene->cell_count);
    memset(objects, 0, scene->object_count);
    for (uint32_t i = 0; i < result.cell_count; i++)
        cells[result.cells[i]] = 1;
    for (uint32_t i = 0; i < result.object_count; i++)
        objects[result.objects[i]] = 1;
}

/* What of a scene four ways to ask keep, over many cameras: polygons, windows as rectangles, the sweep, and that without wide
 * instructions. */
enum { POLYGONS, RECTANGLES, SWEEP, SWEEP_PLAIN, FRUSTUM, WAYS };
typedef struct Kept {
    uint64_t polygons, more[WAYS], less[WAYS]; /* than polygons keep; cells and objects */
    uint64_t objects[WAYS], swept;
} Kept;

static EnfViewDef way_to_ask(int way) {
    EnfViewDef def = enf_default_view_def();
    def.outdoors = way >= SWEEP ? ENF_OUTDOORS_SWEEP : ENF_OUTDOORS_EXACT;
    def.distance_limit = way == POLYGONS ? 1e9 : INFINITY; /* any limit: windows go the plain way */
    def.use_simd = way != SWEEP_PLAIN;
    def.method = way == FRUSTUM ? ENF_VIEW_FRUSTUM : ENF_VIEW_CLIP;
    return def;
}

static void compare_ways(const EnfScene *scene, SightRng *rng, Kept *kept) {
    EnfView *view;
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    const uint32_t cells = scene->cell_count, items = cells + scene->object_count;
    uint8_t *seen[WAYS];
    for (int w = 0; w < WAYS; w++)
        seen[w] = calloc(items + 1, 1);
    for (int q = 0; q < 120; q++) {
        double eye[3], size[3];
        for (int c = 0; c < 3; c++) {
            size[c] = scene->bounds[3 + c] - scene->bounds[c];
            eye[c] = scene->bounds[c] + size[c] * sight_unit(rng);
        }
        uint32_t found, count;
        assert_int_equal(enf_scene_locate(scene, eye, &found, 1, &count), ENF_OK);
        if (count == 0 || !enf_is_exterior(scene, found))
            continue;
        double middle[2] = {scene->bounds[0] + 0.5 * size[0] - eye[0], scene->bounds[1] + 0.5 * size[1] - eye[1]};
        EnfCamera camera = level_camera(eye, atan2(middle[1], middle[0]) + between(rng, -0.4, 0.4), between(rng, -0.3, 0.3));
        camera.clip_near = 0;
        camera.clip_far = INFINITY;
        for (int w = 0; w < WAYS; w++) {
            EnfViewDef def = way_to_ask(w);
            EnfViewStats stats = enf_default_view_stats();
            take(view, &camera, &def, scene, seen[w], seen[w] + cells);
            assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
            kept->swept += stats.swept;
            assert_true(w != SWEEP && w != SWEEP_PLAIN ? stats.swept == 0 : stats.swept <= 1);
            kept->objects[w] += stats.objects;
            for (uint32_t i = 0; i < items; i++) {
                kept->more[w] += seen[w][i] && !seen[POLYGONS][i];
                kept->less[w] += seen[POLYGONS][i] && !seen[w][i];
            }
        }
        for (uint32_t i = 0; i < items; i++)
            kept->polygons += seen[POLYGONS][i];
        assert_memory_equal(seen[SWEEP], seen[SWEEP_PLAIN], items);
    }
    for (int w = 0; w < WAYS; w++)
        free(seen[w]);
    enf_view_destroy(view);
}

static void windows_as_rectangles_and_the_sweep_keep_what_polygons_keep(void **state) {
    (void)state;
    static const char *const specs[] = {"office:200,objects=9,outdoors=0", "court:5,storeys=2,outdoors=0", "town:7,objects=5,outdoors=0",
                                        "tower:6,windows=1,outdoors=0"};
    SightRng rng = {5};
    Kept kept = {0};
    for (int f = 0; f < 12; f++) {
        EnfScene *given;
        assert_int_equal(enf_family_build(specs[f % 4], &given), ENF_OK);
        assert_int_equal(enf_scene_commit(given), ENF_OK);
        Motion motion = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, f >= 8 ? 1e-2 : 1, {0, 0, 0}};
        if (f >= 4)
            random_level_turn(&rng, motion.rotation);
        EnfScene *scene = moved_scene(given, &motion);
        enf_scene_destroy(given);
        assert_int_equal(enf_scene_decompose_exterior(scene, NULL, NULL), ENF_OK);
        assert_int_equal(enf_scene_commit(scene), ENF_OK);
        compare_ways(scene, &rng, &kept);
        enf_scene_destroy(scene);
    }
    printf("polygons %llu; rectangles %llu more, %llu less; sweep %llu more, %llu less; objects: frustum %llu, sweep %llu, polygons %llu\n",
           (unsigned long long)kept.polygons, (unsigned long long)kept.more[RECTANGLES], (unsigned long long)kept.less[RECTANGLES],
           (unsigned long long)kept.more[SWEEP], (unsigned long long)kept.less[SWEEP], (unsigned long long)kept.objects[FRUSTUM],
           (unsigned long long)kept.objects[SWEEP], (unsigned long long)kept.objects[POLYGONS]);
    assert_true(kept.polygons > 20000 && kept.swept > 1000);
    /* Less: where merging of what arrives in rooms kept more than is seen. */
    assert_true(kept.more[RECTANGLES] * 200 <= kept.polygons && kept.less[RECTANGLES] * 200 <= kept.polygons);
    assert_true(kept.less[SWEEP] * 200 <= kept.polygons && kept.objects[SWEEP] * 3 <= kept.objects[FRUSTUM]);
}

/* A camera far off the building's south-west corner, looking at its middle. */
static EnfCamera camera_afar(const EnfScene *scene) {
    double eye[3];
    for (int c = 0; c < 3; c++)
        eye[c] = scene->bounds[c] + 0.02 * (scene->bounds[3 + c] - scene->bounds[c]);
    eye[2] = scene->bounds[5] - 0.1;
    EnfCamera camera = level_camera(eye, 0.785, -0.2);
    camera.clip_near = 0;
    camera.clip_far = INFINITY;
    return camera;
}

static EnfScene *family(const char *spec) {
    EnfScene *scene;
    assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    return scene;
}

/* Steps to what was swept are made when they are asked for: rows of open portals from the eye's cell on. */
static void what_is_swept_has_its_reasons(void **state) {
    (void)state;
    EnfScene *scene = family("office:46,closed=0.3");
    EnfCamera camera = camera_afar(scene);
    EnfView *view;
    EnfViewDef def = enf_default_view_def();
    EnfViewStats stats = enf_default_view_stats();
    EnfViewResult r = enf_default_view_result();
    def.outdoors = ENF_OUTDOORS_SWEEP;
    uint32_t shut = 0, rows = 0;
    for (uint32_t o = 0; o < scene->opening_count; o++)
        shut += scene->openings[o].state == ENF_STATE_CLOSED;
    assert_true(shut > 0 && scene->shut_count == shut);
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    assert_int_equal(enf_view_query(view, &camera, &def), ENF_OK);
    assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
    assert_int_equal(enf_view_result(view, &r), ENF_OK);
    assert_true(stats.swept == 1 && stats.windows > 5);
    for (uint32_t s = 0; s < r.step_count; s++) {
        const uint32_t portal = r.step_portal[s], parent = r.step_parent[s];
        if (portal == ENF_NONE)
            continue;
        assert_true(parent < s && (scene->portal_cells[portal][0] == r.step_cell[s] || scene->portal_cells[portal][1] == r.step_cell[s]));
        if (r.step_portal[parent] != ENF_NONE)
            assert_true(scene->portal_cells[portal][0] == r.step_cell[parent] || scene->portal_cells[portal][1] == r.step_cell[parent]);
        if (scene->portal_openings[portal] != ENF_NONE)
            assert_int_not_equal(scene->openings[scene->portal_openings[portal]].state, ENF_STATE_CLOSED);
    }
    for (uint32_t i = 0; i < r.cell_count; i++)
        if (!enf_is_exterior(scene, r.cells[i])) {
            assert_int_equal(r.step_cell[r.cell_step[i]], r.cells[i]);
            rows++;
        }
    for (uint32_t i = 0; i < r.object_count; i++)
        if (r.object_step[i] != ENF_NONE) {
            uint32_t portals, held = 0;
            for (uint32_t k = scene->placed_first[r.objects[i]]; k < scene->placed_first[r.objects[i] + 1]; k++)
                held |= scene->placed_cells[k] == r.step_cell[r.object_step[i]];
            assert_int_equal(held, 1);
            assert_int_equal(enf_view_why_object(view, r.objects[i], NULL, 0, &portals), ENF_OK);
            assert_true(portals > 0);
            rows++;
        }
    assert_true(rows > 40);
    enf_view_destroy(view);
    enf_scene_destroy(scene);
}

/* From afar, of a building with hardly anything in it but windows, and with too little work allowed, the answer is the frustum's. */
static void where_windows_spare_nothing_the_frustum_answers(void **state) {
    (void)state;
    static const struct {
        const char *spec;
        uint32_t budget, hit;
    } cases[] = {{"office:10,objects=0", 0, 0}, {"office:200,objects=9", 3000, 1}};
    for (int k = 0; k < 2; k++) {
        EnfScene *scene = family(cases[k].spec);
        EnfCamera camera = camera_afar(scene);
        EnfView *view;
        EnfViewDef def = enf_default_view_def();
        EnfViewStats stats = enf_default_view_stats(), frustum = stats;
        assert_int_equal(enf_view_create(scene, &view), ENF_OK);
        def.work_budget = cases[k].budget;
        assert_int_equal(enf_view_query(view, &camera, &def), ENF_OK);
        assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
        def.method = ENF_VIEW_FRUSTUM;
        assert_int_equal(enf_view_query(view, &camera, &def), ENF_OK);
        assert_int_equal(enf_view_stats(view, &frustum), ENF_OK);
        assert_int_equal(stats.cells, frustum.cells);
        assert_int_equal(stats.objects, frustum.objects);
        assert_int_equal(stats.budget_hit != 0, cases[k].hit);
        assert_true(cases[k].hit ? stats.work < 2 * cases[k].budget : stats.swept == 1 && stats.windows == 0);
        enf_view_destroy(view);
        enf_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_that_meet_a_cone_stay_and_most_others_go),
        cmocka_unit_test(windows_as_rectangles_and_the_sweep_keep_what_polygons_keep),
        cmocka_unit_test(what_is_swept_has_its_reasons),
        cmocka_unit_test(where_windows_spare_nothing_the_frustum_answers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
