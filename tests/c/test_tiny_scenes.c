/* SPDX-License-Identifier: GPL-3.0-or-later
 * One tiny scene a phenomenon: tests/scenes/EXPECTED.tsv says what each holds, which cells see each other and
 * which don't. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FOLDER ENF_SOURCE_ROOT "/tests/scenes/"

static int failures;
static void expect(const char *scene, const char *what, long found, long wanted) {
    if (found != wanted) {
        print_error("%s: %s: %ld, expected %ld\n", scene, what, found, wanted);
        failures++;
    }
}

/* "0-1 2-3" or "-". */
static void check_pairs(const char *name, const EnfRegionVis *result, const char *pairs, int visible) {
    while (*pairs && strcmp(pairs, "-") != 0) {
        char *end;
        uint32_t a = (uint32_t)strtoul(pairs, &end, 10), b = (uint32_t)strtoul(end + 1, &end, 10), there, back;
        char what[64];
        assert_int_equal(enf_region_vis_pair(result, a, b, &there), ENF_OK);
        assert_int_equal(enf_region_vis_pair(result, b, a, &back), ENF_OK);
        snprintf(what, sizeof what, "pair %u-%u visible", a, b);
        expect(name, what, there != ENF_PAIR_HIDDEN, visible);
        expect(name, what, back != ENF_PAIR_HIDDEN, visible);
        pairs = *end ? end + 1 : end;
    }
}

static void check_scene(const char *name, char **fields) {
    char path[4096];
    EnfScene *scene = NULL;
    EnfSceneCounts counts;
    snprintf(path, sizeof path, FOLDER "%s.enf.json", name);
    if (enf_scene_load(path, &scene) != ENF_OK || enf_scene_commit(scene) != ENF_OK) {
        print_error("%s: %s\n", name, enf_last_error());
        failures++;
        enf_scene_destroy(scene);
        return;
    }
    enf_scene_counts(scene, &counts);
    expect(name, "cells", counts.cells, atol(fields[0]));
    expect(name, "portals", counts.portals, atol(fields[1]));
    expect(name, "seams", counts.seams, atol(fields[2]));
    static const char *const words[] = {"none", "info", "warning", "error"};
    uint32_t worst = 0;
    for (uint64_t i = 0; i < enf_scene_problem_count(scene); i++) {
        EnfProblem problem;
        enf_scene_problem(scene, i, &problem);
        if (problem.severity + 1 > worst)
            worst = problem.severity + 1;
        if (strcmp(fields[3], "none") == 0)
            print_error("%s: %s\n", name, problem.message);
    }
    expect(name, "worst problem is as named", strcmp(words[worst], fields[3]), 0);
    EnfRegionVis *result = NULL;
    EnfRegionVisDef def = enf_default_region_vis_def();
    def.threads = 1;
    assert_int_equal(enf_region_vis_run(scene, &def, &result), ENF_OK);
    check_pairs(name, result, fields[4], 1);
    check_pairs(name, result, fields[5], 0);
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
}

static void each_scene_shows_what_it_is_for(void **state) {
    (void)state;
    FILE *list = fopen(FOLDER "EXPECTED.tsv", "rb");
    assert_non_null(list);
    char line[2048];
    int scenes = 0;
    while (fgets(line, sizeof line, list)) {
        line[strcspn(line, "\r\n")] = 0;
        if (line[0] == '#' || !line[0])
            continue;
        char *fields[6], *at = line;
        for (int i = 0; i < 6; i++) {
            at = strchr(at, '\t');
            assert_non_null(at);
            *at++ = 0;
            fields[i] = at;
        }
        check_scene(line, fields);
        scenes++;
    }
    fclose(list);
    assert_true(scenes >= 15);
    assert_int_equal(failures, 0);
    assert_int_equal(enf_live_bytes(), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_scene_shows_what_it_is_for)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
