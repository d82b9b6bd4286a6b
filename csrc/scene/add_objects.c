/* SPDX-License-Identifier: GPL-3.0-or-later
 * Many objects in one call: what a Blender file with tens of thousands of them needs. */
#include "base/memory.h"
#include "base/status.h"
#include "scene/scene_data.h"

#include <string.h>

EnfStatus enf_scene_add_objects(EnfScene *scene, uint64_t count, const char *names, uint64_t names_size, const double *bounds,
                                uint64_t bounds_stride, const uint32_t *meshes, uint32_t *out_first) {
    if (!scene || (count && (!names || !bounds)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_objects: NULL argument");
    if (bounds_stride == 0)
        bounds_stride = 6 * sizeof(double);
    uint32_t first = scene->object_count;
    const char *name = names, *end = names + names_size;
    EnfStatus status = ENF_OK;
    for (uint64_t i = 0; i < count && status == ENF_OK; i++) {
        const char *stop = name < end ? memchr(name, 0, (size_t)(end - name)) : NULL;
        if (!stop) {
            status = enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_objects: %llu names for %llu objects", (unsigned long long)i,
                              (unsigned long long)count);
            break;
        }
        double box[6]; /* a stride needn't be a multiple of 8 */
        memcpy(box, (const char *)bounds + i * bounds_stride, sizeof box);
        status = enf_scene_add_object(scene, name, box, NULL, 0, meshes ? meshes[i] : ENF_NONE, NULL);
        name = stop + 1;
    }
    if (status != ENF_OK) { /* all or none */
        while (scene->object_count > first)
            enf_free(scene->objects[--scene->object_count].name);
        return status;
    }
    if (out_first)
        *out_first = first;
    return ENF_OK;
}
