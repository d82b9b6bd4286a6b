/* SPDX-License-Identifier: GPL-3.0-or-later
 * Every file of tests/scenes/bad gives the exit code and the reason that EXPECTED.tsv beside it names:
 * through the library, as `enfilade info` does (which turns the status into the code). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FOLDER ENF_SOURCE_ROOT "/tests/scenes/bad/"

/* Whether the last error or a listed problem holds the text; "problems 0" means that there are none. */
static int is_told(const EnfScene *scene, EnfStatus status, const char *text) {
    if (strcmp(text, "problems 0") == 0)
        return enf_scene_problem_count(scene) == 0;
    int told = status != ENF_OK && strstr(enf_last_error(), text);
    for (uint64_t i = 0; i < enf_scene_problem_count(scene); i++) {
        EnfProblem problem;
        assert_int_equal(enf_scene_problem(scene, i, &problem), ENF_OK);
        told |= strstr(problem.message, text) != NULL;
    }
    return told;
}

static void each_bad_file_is_refused_or_warned_of_with_index_and_reason(void **state) {
    (void)state;
    FILE *list = fopen(FOLDER "EXPECTED.tsv", "rb");
    assert_non_null(list);
    char line[512], path[1024];
    int files = 0, failures = 0;
    while (fgets(line, sizeof line, list)) {
        line[strcspn(line, "\r\n")] = 0;
        if (line[0] == '#' || !line[0])
            continue;
        char *code = strchr(line, '\t'), *text = code ? strchr(code + 1, '\t') : NULL;
        assert_non_null(text);
        *code++ = 0;
        *text++ = 0;
        snprintf(path, sizeof path, FOLDER "%s", line);
        EnfScene *scene = NULL;
        EnfStatus status = enf_scene_load(path, &scene);
        if (status == ENF_OK)
            status = enf_scene_commit(scene);
        EnfStatus wanted = atoi(code) == 2 ? ENF_ERROR_BAD_INPUT : ENF_OK;
        if (status != wanted || !is_told(scene, status, text)) {
            print_error("%s: status %d, wanted %d saying \"%s\"; said \"%s\"\n", line, status, wanted, text,
                        status == ENF_OK ? "" : enf_last_error());
            failures++;
        }
        enf_scene_destroy(scene);
        files++;
    }
    fclose(list);
    assert_true(files >= 60);
    assert_int_equal(failures, 0);
    assert_int_equal(enf_live_bytes(), 0);
}

static void a_missing_file_is_an_io_error_that_names_it(void **state) {
    (void)state;
    EnfScene *scene = NULL;
    assert_int_equal(enf_scene_load(FOLDER "no such file", &scene), ENF_ERROR_IO);
    assert_non_null(strstr(enf_last_error(), "no such file"));
    assert_null(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_bad_file_is_refused_or_warned_of_with_index_and_reason),
        cmocka_unit_test(a_missing_file_is_an_io_error_that_names_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
