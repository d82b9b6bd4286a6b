/* SPDX-License-Identifier: GPL-3.0-or-later
 * Allocation hooks, counters, and memory that runs out: at whatever call it does, loading and committing fail
 * with the status for it, leak nothing, and leave a scene that still commits. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "base/file.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

static void blocks_are_counted_and_keep_their_size(void **state) {
    (void)state;
    uint64_t before = enf_live_bytes();
    char *a = enf_alloc(100);
    assert_int_equal(enf_live_bytes(), before + 100);
    assert_int_equal((uintptr_t)a % 16, 0);
    memset(a, 7, 100);
    a = enf_realloc(a, 1000);
    assert_int_equal(enf_block_size(a), 1000);
    assert_int_equal(a[99], 7);
    assert_true(enf_peak_bytes() >= before + 1000);
    enf_free(a);
    enf_free(NULL);
    assert_int_equal(enf_live_bytes(), before);
}

static void sizes_that_overflow_are_refused(void **state) {
    (void)state;
    uint64_t *array = NULL;
    assert_null(enf_alloc_array(UINT64_MAX / 4, 8));
    assert_null(enf_alloc(SIZE_MAX - 4));
    assert_false(ENF_RESERVE(array, UINT64_MAX / 8));
    assert_null(array);
    assert_true(ENF_RESERVE(array, 3));
    array[2] = 42;
    assert_true(ENF_RESERVE(array, 300));
    assert_int_equal(array[2], 42);
    enf_free(array);
}

/* A hook that gives out `left` more blocks. */
static int64_t left;
static void *scarce_alloc(void *user, size_t size) {
    (void)user;
    if (left == 0)
        return NULL;
    left--;
    return malloc(size);
}
static void scarce_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

static void running_out_anywhere_is_a_status_and_leaks_nothing(void **state) {
    (void)state;
    static const char *const files[] = {"drawn_rooms.enf.json", "two_rooms.enf.json", "bad/warn_not_convex_portal.enf.json"};
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        char path[512], *text;
        uint64_t size;
        snprintf(path, sizeof path, ENF_SOURCE_ROOT "/tests/scenes/%s", files[f]);
        assert_int_equal(enf_file_read(path, &text, &size), ENF_OK);
        char *copy = malloc(size);
        memcpy(copy, text, size);
        enf_free(text);
        assert_int_equal(enf_set_allocator(scarce_alloc, scarce_free, NULL), ENF_OK);
        int64_t allowed = 0;
        for (;; allowed++) {
            EnfScene *scene = NULL;
            left = allowed;
            EnfStatus status = enf_scene_load_memory(copy, size, &scene);
            if (status == ENF_OK) {
                status = enf_scene_commit(scene);
                if (status != ENF_OK) { /* with memory again it commits */
                    assert_int_equal(status, ENF_ERROR_OUT_OF_MEMORY);
                    left = -1;
                    assert_int_equal(enf_scene_commit(scene), ENF_OK);
                }
            } else
                assert_null(scene);
            enf_scene_destroy(scene);
            assert_int_equal(enf_live_bytes(), 0);
            if (status == ENF_OK)
                break;
            assert_int_equal(status, ENF_ERROR_OUT_OF_MEMORY);
        }
        assert_true(allowed > 50);
        assert_int_equal(enf_set_allocator(NULL, NULL, NULL), ENF_OK);
        free(copy);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_counted_and_keep_their_size),
        cmocka_unit_test(sizes_that_overflow_are_refused),
        cmocka_unit_test(running_out_anywhere_is_a_status_and_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
