/* SPDX-License-Identifier: GPL-3.0-or-later
 * Allocation: counters, sizes that overflow. (Memory that runs out: scarce_memory.h.) */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_counted_and_keep_their_size),
        cmocka_unit_test(sizes_that_overflow_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
