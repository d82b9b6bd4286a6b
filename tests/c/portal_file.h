/* SPDX-License-Identifier: GPL-3.0-or-later
 * Portal files that tests read where they are there: $ENFILADE_DATA/prt, or the data beside the project. */
#ifndef ENF_TESTS_PORTAL_FILE_H
#define ENF_TESTS_PORTAL_FILE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"

#include <stdio.h>
#include <stdlib.h>

/* Committed; the caller destroys it. Skips the test, saying so, where the file isn't there. */
static inline EnfScene *portal_file(const char *name) {
    const char *data = getenv("ENFILADE_DATA");
    char path[1024];
    EnfScene *scene;
    if (data)
        snprintf(path, sizeof path, "%s/prt/%s.prt", data, name);
    else
        snprintf(path, sizeof path, "%s/../shared/data/prt/%s.prt", ENF_SOURCE_ROOT, name);
    if (enf_scene_load(path, &scene) != ENF_OK) {
        printf("skipped: %s isn't there\n", path);
        skip();
    }
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    return scene;
}

#endif
