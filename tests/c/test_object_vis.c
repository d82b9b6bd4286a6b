/* SPDX-License-Identifier: GPL-3.0-or-later
 * Objects seen from cells: every answer against lines walked by an oracle of its own, every sightline walked again. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "scene/scene_data.h"
#include "scene_family.h"
#include "sight_walker.h"

static uint8_t status_of(const EnfObjectVis *vis, uint32_t row, uint32_t object) {
    const uint64_t *first = enf_object_vis_row_first(vis);
    for (uint64_t e = first[row]; e < first[row + 1]; ++e)
        if (enf_object_vis_row_objects(vis)[e] == object)
            return enf_object_vis_row_status(vis)[e];
    return ENF_PAIR_HIDDEN;
}

/* Where the line meets the box between t0 and t1; NAN: nowhere. */
static double meets(const double box[6], const double p[3], const double d[3], double t0, double t1) {
    for (int k = 0; k < 3; ++k) {
        double a = (box[k] - p[k]) / d[k], b = (box[k + 3] - p[k]) / d[k];
        t0 = fmax(t0, fmin(a, b)), t1 = fmin(t1, fmax(a, b));
    }
    return t0 < t1 ? t0 : NAN;
}

/* Cells of the families tested are boxes. */
static void cell_box(const EnfScene *scene, uint32_t cell, double box[6]) {
    const uint32_t *first = enf_scene_cell_vertex_first(scene);
    const double *v = enf_scene_cell_vertices(scene);
    for (int k = 0; k < 3; ++k)
        box[k] = INFINITY, box[k + 3] = -INFINITY;
    for (uint32_t i = first[cell]; i < first[cell + 1]; ++i)
        for (int k = 0; k < 3; ++k)
            box[k] = fmin(box[k], v[3 * i + k]), box[k + 3] = fmax(box[k + 3], v[3 * i + k]);
}

static void check_family(const char *spec, int lines, double most_undecided) {
    EnfScene *scene = NULL;
    assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *cells = NULL;
    EnfObjectVis *one = NULL, *vis = NULL;
    assert_int_equal(enf_region_vis_run(scene, &def, &cells), ENF_OK);
    if (enf_object_vis_run(cells, NULL, 0, NULL, 0, 1, &one) != ENF_OK)
        fail_msg("%s", enf_last_error());
    assert_int_equal(enf_object_vis_run(cells, NULL, 0, NULL, 0, 3, &vis), ENF_OK);
    EnfSceneCounts counts;
    memset(&counts, 0, sizeof counts);
    counts.struct_size = (uint32_t)sizeof counts;
    assert_int_equal(enf_scene_counts(scene, &counts), ENF_OK);
    const uint64_t *first = enf_object_vis_row_first(vis);
    assert_memory_equal(first, enf_object_vis_row_first(one), (counts.cells + 1) * sizeof *first);
    assert_memory_equal(enf_object_vis_row_status(vis), enf_object_vis_row_status(one), first[counts.cells]);
    SightWalker *walker = sight_walker_create(scene);
    assert_non_null(walker);
    SightWalk *walk = malloc(sizeof *walk);
    SightRng rng = {7};
    uint64_t by_status[4] = {0, 0, 0, 0}, hits = 0, missed = 0, bad = 0;
    /* Whatever a random line meets is seen. */
    for (uint32_t s = 0; s < counts.cells; ++s)
        for (int i = 0; i < lines; ++i) {
            double eye[3], d[3];
            if (!sight_point_in_cell(walker, &rng, s, 0, eye))
                continue;
            for (int k = 0; k < 3; ++k)
                d[k] = 2 * sight_unit(&rng) - 1;
            d[2] *= 0.2;
            sight_walk(walker, s, eye, d, 1e4, walk);
            for (uint32_t c = 0; c < walk->cell_count; ++c) {
                double box[6], end = 1e9;
                uint32_t cell = walk->cells[c];
                if (walk->clearance_at[c] < 1e-6)
                    break;
                cell_box(scene, cell, box);
                for (int k = 0; k < 3; ++k)
                    end = fmin(end, fmax((box[k] - eye[k]) / d[k], (box[k + 3] - eye[k]) / d[k]));
                for (uint32_t o = scene->cell_object_first[cell]; o < scene->cell_object_first[cell + 1]; ++o) {
                    uint32_t object = scene->cell_object_list[o];
                    if (isnan(meets(scene->objects[object].bounds, eye, d, walk->t_enter[c], end)))
                        continue;
                    ++hits;
                    if (status_of(vis, s, object) == ENF_PAIR_HIDDEN && !missed++)
                        print_message("%s: object %u is met from cell %u and hidden\n", spec, object, s);
                }
            }
        }
    /* Every sightline passes its portals, in the oracle's eyes too, and ends on the bounds. */
    for (uint32_t s = 0; s < counts.cells; ++s)
        for (uint64_t e = first[s]; e < first[s + 1]; ++e) {
            uint32_t portals[64], count = 0;
            double segment[6], d[3];
            const double *bounds = scene->objects[enf_object_vis_row_objects(vis)[e]].bounds;
            uint8_t status = enf_object_vis_row_status(vis)[e];
            ++by_status[status];
            if (status != ENF_PAIR_VISIBLE)
                continue;
            assert_int_equal(enf_object_vis_witness(vis, e, segment, portals, 64, &count), ENF_OK);
            int shut = 0; /* into or out of a shut opening's own cell: the oracle doesn't walk there */
            for (uint32_t k = 0; k < count; ++k)
                shut |= !enf_portal_passes(scene, portals[k]);
            if (!count || shut)
                continue; /* in the same cell */
            for (int k = 0; k < 3; ++k) {
                d[k] = segment[k + 3] - segment[k];
                bad += segment[k + 3] < bounds[k] - 1e-6 || segment[k + 3] > bounds[k + 3] + 1e-6;
            }
            sight_walk(walker, s, segment, d, 1.0, walk);
            int same = walk->cell_count == count + 1;
            for (uint32_t k = 0; same && k < count; ++k)
                same = walk->portals[k] == portals[k];
            bad += !same || walk->cells[walk->cell_count - 1] != enf_object_vis_row_cells(vis)[e];
        }
    uint64_t seen = first[counts.cells];
    print_message("%s: %llu cells x objects: %llu visible, %llu grazing, %llu undecided; %llu random hits\n", spec,
                  (unsigned long long)counts.cells * counts.objects, (unsigned long long)by_status[1], (unsigned long long)by_status[2],
                  (unsigned long long)by_status[3], (unsigned long long)hits);
    assert_true(hits > 0);
    assert_int_equal(missed, 0);
    assert_int_equal(bad, 0);
    assert_true((double)(by_status[2] + by_status[3]) <= most_undecided * (double)seen);
    free(walk);
    sight_walker_destroy(walker);
    enf_object_vis_destroy(one), enf_object_vis_destroy(vis);
    enf_region_vis_destroy(cells);
    enf_scene_destroy(scene);
}

static void offices(void **state) {
    (void)state;
    check_family("office:20,windows=0,objects=4", 400, 0.02);
    check_family("office:46,windows=0,objects=3,closed=0.2,seed=3", 200, 0.02);
}
static void shafts_and_suites(void **state) {
    (void)state;
    check_family("tower:4", 400, 0.02);
    check_family("enfilade:6", 1000, 0.02);
    check_family("hub:12,objects=3", 400, 0.02);
}

/* A chair round the corner: its room is seen, it isn't. */
static void an_object_round_the_corner_is_hidden(void **state) {
    (void)state;
    EnfScene *scene = NULL;
    uint32_t index, room;
    /* A room, a door as thick as its wall (0.5 m), a long room behind it. */
    static const double shape[3][6] = {{0, 0, 0, 4, 2, 3}, {4, 1, 0, 4.5, 1.2, 2}, {4.5, 0, 0, 8, 30, 3}};
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    for (int i = 0; i < 3; ++i) {
        double box[8][3];
        for (int v = 0; v < 8; ++v)
            for (int k = 0; k < 3; ++k)
                box[v][k] = shape[i][k + 3 * (v >> k & 1)];
        assert_int_equal(enf_scene_add_room(scene, "R", ENF_ROOM_INTERIOR, &room), ENF_OK);
        assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, box[0], 8, 0, NULL, 0, NULL, &index), ENF_OK);
    }
    for (int i = 0; i < 2; ++i) {
        double x = i ? 4.5 : 4, door[4][3] = {{x, 1, 0}, {x, 1.2, 0}, {x, 1.2, 2}, {x, 1, 2}};
        assert_int_equal(enf_scene_add_portal(scene, i, i + 1, door[0], 4, 0, ENF_NONE, &index), ENF_OK);
    }
    double seen[6] = {6, 0.5, 0.2, 7, 1.5, 1}, aside[6] = {4.7, 20, 0.2, 5.6, 25, 1}, flat[6] = {6, 1, 0.2, 6, 2, 1};
    assert_int_equal(enf_scene_add_object(scene, "seen", seen, NULL, 0, 0, &index), ENF_OK);
    assert_int_equal(enf_scene_add_object(scene, "aside", aside, NULL, 0, 0, &index), ENF_OK);
    assert_int_equal(enf_scene_add_object(scene, "flat", flat, NULL, 0, 0, &index), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *cells = NULL;
    EnfObjectVis *vis = NULL;
    uint32_t from = 0, quick;
    assert_int_equal(enf_region_vis_run(scene, &def, &cells), ENF_OK);
    assert_int_equal(enf_object_vis_run(cells, &from, 1, NULL, 0, 0, &vis), ENF_OK);
    assert_int_equal(status_of(vis, 0, 0), ENF_PAIR_VISIBLE);
    assert_int_equal(status_of(vis, 0, 1), ENF_PAIR_HIDDEN);
    assert_int_equal(status_of(vis, 0, 2), ENF_PAIR_VISIBLE);
    assert_int_equal(enf_region_vis_object(cells, 0, 1, &quick, NULL), ENF_OK);
    assert_int_equal(quick, ENF_PAIR_UNDECIDED); /* the quick answer can't tell */
    enf_object_vis_destroy(vis);
    uint32_t none = 99;
    assert_int_equal(enf_object_vis_run(cells, &none, 1, NULL, 0, 0, &vis), ENF_ERROR_INVALID_ARGUMENT);
    assert_int_equal(enf_object_vis_run(cells, &from, 1, &none, 1, 0, &vis), ENF_ERROR_INVALID_ARGUMENT);
    enf_region_vis_destroy(cells);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_object_round_the_corner_is_hidden),
        cmocka_unit_test(offices),
        cmocka_unit_test(shafts_and_suites),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
