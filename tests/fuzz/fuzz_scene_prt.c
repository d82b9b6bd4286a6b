/* SPDX-License-Identifier: GPL-3.0-or-later
 * Any bytes as a portal file: the first byte says which version's header stands before the rest. Seeds:
 * tests/scenes/bad. */
#include "fuzz_common.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    EnfScene *scene = NULL;
    char *text = malloc(size + 8);
    size_t skip = size ? 1 : 0;
    memcpy(text, size && data[0] & 1 ? "PRT1\n" : "PRT2\n", 5);
    memcpy(text + 5, data + skip, size - skip);
    if (enf_scene_load_memory(text, size - skip + 5, &scene) == ENF_OK)
        fuzz_commit(scene);
    else
        FUZZ_CHECK(!scene && enf_last_error()[0]);
    enf_scene_destroy(scene);
    free(text);
    FUZZ_CHECK(enf_live_bytes() == 0);
    return 0;
}
