/* SPDX-License-Identifier: GPL-3.0-or-later
 * Buildings made by code with their raycasters, each made once a process: an input then costs its rays, not the building. */
#ifndef ENF_TESTS_FUZZ_BUILDING_H
#define ENF_TESTS_FUZZ_BUILDING_H

#include "fuzz_common.h"
#include "scene_family.h"

typedef struct FuzzBuilding {
    EnfScene *scene;
    EnfRaycaster *raycaster;
} FuzzBuilding;

/* One of `count` families by the next byte, its first openings in states by the bytes that follow. */
static inline const FuzzBuilding *fuzz_building(FuzzBytes *bytes, const char *const *families, uint32_t count) {
    static FuzzBuilding made[8];
    uint32_t which = fuzz_byte(bytes) % count;
    FuzzBuilding *b = &made[which];
    if (!b->scene) {
        FUZZ_CHECK(count <= 8 && enf_family_build(families[which], &b->scene) == ENF_OK && enf_scene_commit(b->scene) == ENF_OK);
        FUZZ_CHECK(enf_raycaster_create(b->scene, &b->raycaster) == ENF_OK);
    }
    for (uint32_t o = 0; o < b->scene->opening_count && o < 8; o++)
        FUZZ_CHECK(enf_scene_set_opening_state(b->scene, o, fuzz_byte(bytes) % 3) == ENF_OK);
    return b;
}

#endif
