/* SPDX-License-Identifier: GPL-3.0-or-later
 * Any bytes as a scene file. Seeds: tests/scenes, tests/scenes/bad; dictionary: fuzz_scene_json.dict. */
#include "fuzz_common.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    EnfScene *scene = NULL;
    if (enf_scene_load_memory(data, size, &scene) == ENF_OK)
        fuzz_commit(scene);
    else
        FUZZ_CHECK(!scene && enf_last_error()[0]);
    enf_scene_destroy(scene);
    FUZZ_CHECK(enf_live_bytes() == 0);
    return 0;
}
