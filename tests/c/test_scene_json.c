/* SPDX-License-Identifier: GPL-3.0-or-later
 * Scene files: what is kept, numbers to the bit, errors with line and item, memory and threads while reading. Files that must be
 * refused are in test_bad_files.c. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/threads.h"
#include "scene/scene_data.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD "{\"format\": \"enfilade-scene\", \"version\": 1, "

static EnfScene *load(const char *text) {
    EnfScene *scene = NULL;
    if (enf_scene_load_memory(text, strlen(text), &scene) != ENF_OK)
        print_error("%s\n", enf_last_error());
    assert_non_null(scene);
    return scene;
}

static void unknown_keys_are_kept_at_every_level_as_the_text_they_were(void **state) {
    (void)state;
    static const char path[] = "test_scene_json.enf.json";
    static const char *const kept[] = {"\"a\\u0062\\\"\" : {\"x\": [1, 12345678901234567890123, {}]}",
                                       "\"list\": [1e0, [ ], \"\\ud83d\\ude00\"]",
                                       "\"colour\": [-0.0, 0.10]",
                                       "\"source\": \"drawn\"",
                                       "\"why\": null",
                                       "\"layer\":true"};
    char text[2048], *saved;
    uint64_t size;
    snprintf(
        text, sizeof text,
        HEAD
        "%s, %s, \"rooms\": [{%s, \"name\": \"A\", \"prism\": {\"z\": [0, 3], \"holes\": [], %s, \"outline\": [[0,0],[1,0],[1,1],[0,1]]}},"
        "{\"name\": \"B\", \"mesh\": {\"vertices\": [[1,0,0],[2,0,0],[1,1,0],[1,0,3]]}}],"
        "\"cells\": [], \"portals\": [{\"polygon\": [[1,0,0],[1,1,0],[1,0,3]], \"sides\": [{\"room\": 0, %s}, {\"room\": 1}], %s}]}",
        kept[0], kept[1], kept[2], kept[3], kept[4], kept[5]);
    EnfScene *scene = load(text);
    assert_int_equal(enf_scene_save_json(scene, path), ENF_OK);
    enf_scene_destroy(scene);
    assert_int_equal(enf_file_read(path, &saved, &size), ENF_OK);
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++) {
        if (!strstr(saved, kept[i]))
            print_error("lost: %s\n", kept[i]);
        assert_non_null(strstr(saved, kept[i]));
    }
    enf_free(saved);
    remove(path);
    assert_int_equal(enf_live_bytes(), 0);
}

static const char *const numbers_text =
    HEAD "\"lights\": [{\"position\": [-0.0, -0, 0.1]}, {\"position\": [10000000000000000000000, 9007199254740993, 4.9e-324]},"
         "{\"position\": [5, 5.0e0, 0.5000000000000000277555756156289135105907917022705078125]}], \"rooms\": [], \"cells\": []}";

static void check_numbers(void) {
    static const double wanted[3][3] = {{-0.0, -0.0, 0.1}, {1e22, 9007199254740992.0, 4.9406564584124654e-324}, {5.0, 5.0, 0.5}};
    EnfScene *scene = load(numbers_text);
    for (int i = 0; i < 3; i++)
        assert_memory_equal(scene->lights[i].position, wanted[i], sizeof wanted[i]);
    enf_scene_destroy(scene);
}

static void numbers_are_read_to_the_bit(void **state) {
    (void)state;
    check_numbers();
}

static void a_decimal_comma_of_the_locale_does_not_matter(void **state) {
    (void)state;
    if (!setlocale(LC_NUMERIC, "de_DE.UTF-8") && !setlocale(LC_NUMERIC, "German")) {
        print_message("no locale with a decimal comma here: skipped\n");
        skip();
    }
    check_numbers();
    setlocale(LC_NUMERIC, "C");
}

static void errors_name_line_item_and_key(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {HEAD "\"rooms\": [\n{\"name\": \"A\"},\n{\"name\": \"B\",\n \"kind\" \"interior\"}]}", "line 4: room 1: ':' expected"},
        {HEAD "\"rooms\": [\n{\"name\": \"A\"},\n{\"name\": \"B\",\n \"kind\": 3}]}", "line 3: room 1: \"kind\": a string expected"},
        {HEAD "\n\"cells\": [{}\n{}]}", "line 3: cell 0: ',' expected near '{'"},
        {HEAD "\n\"cells\": [\n5]}", "line 3: cell 0: an object expected"},
        {HEAD "\"cells\": [],\n\"cells\": []}", "line 2: the key \"cells\" stands twice"},
        {HEAD "\"x\": {\"a\": 1,\n\"a\": 2}}", "line 2: duplicate object key"},
        {HEAD "\"cells\": [{}], 5: 6}", "a key should be a string"},
        {HEAD "\"cells\": \"no\"}", "\"cells\": '[' expected near '\"'"},
        {"{\"format\": 7}", "\"format\": a string expected"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        EnfScene *scene = NULL;
        assert_int_equal(enf_scene_load_memory(cases[i][0], strlen(cases[i][0]), &scene), ENF_ERROR_BAD_INPUT);
        if (!strstr(enf_last_error(), cases[i][1]))
            print_error("wanted \"%s\", said \"%s\"\n", cases[i][1], enf_last_error());
        assert_non_null(strstr(enf_last_error(), cases[i][1]));
    }
    assert_int_equal(enf_live_bytes(), 0);
}

/* Hooks that know the most bytes that were alive at once. */
static uint64_t live, most;
static void *watched_alloc(void *user, size_t size) {
    (void)user;
    live += size;
    most = live > most ? live : most;
    return malloc(size);
}
static void watched_free(void *user, void *pointer, size_t size) {
    (void)user;
    live -= size;
    free(pointer);
}

static void a_large_file_is_never_held_as_a_tree(void **state) {
    (void)state;
    enum { COUNT = 40000 };
    char *text = malloc(COUNT * 80 + 200), *at = text + sprintf(text, HEAD "\"mine\": [");
    for (int i = 0; i < COUNT; i++)
        at += sprintf(at, "%s{\"k\": [%d, 2, 3]}", i ? "," : "", i);
    at += sprintf(at, "], \"objects\": [");
    for (int i = 0; i < COUNT; i++)
        at += sprintf(at, "%s{\"bounds\": [[%d, 2, 3], [%d, 3, 4]]}", i ? "," : "", i, i + 1);
    at += sprintf(at, "]}");
    assert_int_equal(enf_set_allocator(watched_alloc, watched_free, NULL), ENF_OK);
    live = most = 0;
    EnfScene *scene = NULL;
    assert_int_equal(enf_scene_load_memory(text, (uint64_t)(at - text), &scene), ENF_OK);
    assert_int_equal(scene->object_count, COUNT);
    /* What is kept, and an array that is being moved to a larger place. A tree of either list alone is more. */
    print_message("%.1f MB of text: %.1f MB at most, %.1f MB kept\n", (double)(at - text) * 1e-6, (double)most * 1e-6, (double)live * 1e-6);
    assert_true(most < 2 * live + 1000000);
    enf_scene_destroy(scene);
    assert_int_equal(enf_set_allocator(NULL, NULL, NULL), ENF_OK);
    free(text);
}

static void load_one(void *context, uint64_t task, uint32_t thread) {
    EnfScene *scene = NULL;
    const char *text = task & 1 ? numbers_text : HEAD "\"cells\": [{}, 3]}";
    (void)thread;
    EnfStatus status = enf_scene_load_memory(text, strlen(text), &scene);
    ((int *)context)[task] = task & 1 ? status == ENF_OK && scene->lights[0].position[2] == 0.1
                                      : status == ENF_ERROR_BAD_INPUT && strstr(enf_last_error(), "cell 1: an object expected");
    enf_scene_destroy(scene);
}

static void threads_read_files_side_by_side(void **state) {
    (void)state;
    enum { TASKS = 400 };
    int right[TASKS] = {0};
    enf_parallel_for(TASKS, 4, load_one, right);
    for (int i = 0; i < TASKS; i++)
        assert_true(right[i]);
    assert_int_equal(enf_live_bytes(), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unknown_keys_are_kept_at_every_level_as_the_text_they_were),
        cmocka_unit_test(numbers_are_read_to_the_bit),
        cmocka_unit_test(a_decimal_comma_of_the_locale_does_not_matter),
        cmocka_unit_test(errors_name_line_item_and_key),
        cmocka_unit_test(a_large_file_is_never_held_as_a_tree),
        cmocka_unit_test(threads_read_files_side_by_side),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
