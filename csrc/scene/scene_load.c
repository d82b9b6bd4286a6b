/* SPDX-License-Identifier: GPL-3.0-or-later
 * Loading a scene, the format told apart by content. */
#include "base/file.h"
#include "base/memory.h"
#include "base/status.h"
#include "scene/scene_file.h"

#include <string.h>

EnfStatus enf_scene_load_memory(const void *bytes, uint64_t size, EnfScene **out_scene) {
    if (!out_scene || (size && !bytes))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_load_memory: NULL argument");
    const char *text = bytes;
    uint64_t at = 0;
    if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0)
        at = 3; /* a byte order mark, as some editors write */
    while (at < size && (text[at] == ' ' || text[at] == '\t' || text[at] == '\r' || text[at] == '\n'))
        at++;
    if (at == size)
        return enf_fail(ENF_ERROR_BAD_INPUT, "line 1: the file is empty");
    EnfScene *scene = NULL;
    EnfStatus status = enf_scene_create(&scene);
    if (status != ENF_OK)
        return status;
    if (text[at] == '{')
        status = enf_scene_read_json(scene, text, size);
    else if (size - at >= 3 && memcmp(text + at, "PRT", 3) == 0)
        status = enf_scene_read_prt(scene, text + at, size - at);
    else
        status = enf_fail(ENF_ERROR_BAD_INPUT, "line 1: neither a scene (starts with '{') nor a portal file (starts with PRT)");
    if (status != ENF_OK) {
        enf_scene_destroy(scene);
        return status;
    }
    *out_scene = scene;
    return ENF_OK;
}

EnfStatus enf_scene_load(const char *path_utf8, EnfScene **out_scene) {
    if (!path_utf8 || !out_scene)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_load: NULL argument");
    char *bytes = NULL;
    uint64_t size = 0;
    EnfStatus status = enf_file_read(path_utf8, &bytes, &size);
    if (status != ENF_OK)
        return status;
    status = enf_scene_load_memory(bytes, size, out_scene);
    enf_free(bytes);
    if (status == ENF_ERROR_BAD_INPUT) {
        char reason[400];
        strncpy(reason, enf_last_error(), sizeof reason - 1);
        reason[sizeof reason - 1] = 0;
        return enf_fail(status, "%.100s: %s", path_utf8, reason);
    }
    return status;
}
