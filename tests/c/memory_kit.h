/* SPDX-License-Identifier: GPL-3.0-or-later
 * The last case of a test: all memory is given back. A case and not the group's teardown, whose failure cmocka prints and forgets. */
#ifndef ENF_TESTS_MEMORY_KIT_H
#define ENF_TESTS_MEMORY_KIT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"

static void memory_comes_back(void **state) {
    (void)state;
    assert_int_equal(enf_live_bytes(), 0);
}

#endif
