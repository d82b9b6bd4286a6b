/* SPDX-License-Identifier: GPL-3.0-or-later
 * What of an object surely blocks sight. */
#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"
#include "scene/scene_data.h"

#include <string.h>

enum { MAX_CORNERS = 64 }; /* of a polygon; the depth buffer takes no more */

static const uint8_t box_faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

/* Whether the polygon is usable; says why not. */
static EnfStatus check_polygon(const EnfObjectData *object, uint32_t o, uint64_t p, const double *corners, uint64_t stride, uint32_t size) {
    /* Metres: coordinates pass through single precision on their way here. */
    double slack = fmax(1e-4, 1e-6 * box_diagonal(object->bounds));
    if (size < 3 || size > MAX_CORNERS)
        return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: occluder polygon %llu has %u corners, 3 to %u are possible", o,
                        (unsigned long long)p, size, (unsigned)MAX_CORNERS);
    for (uint32_t i = 0; i < size; i++) {
        double at[3];
        memcpy(at, (const char *)corners + i * stride, sizeof at);
        for (int c = 0; c < 3; c++)
            if (!(at[c] >= object->bounds[c] - slack && at[c] <= object->bounds[3 + c] + slack))
                return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: occluder polygon %llu leaves the object's bounds", o,
                                (unsigned long long)p);
    }
    return ENF_OK;
}

EnfStatus enf_scene_set_occluder(EnfScene *scene, uint32_t object, const double *corners, uint64_t stride, const uint32_t *sizes,
                                 uint64_t count) {
    if (!scene || (count && (!corners || !sizes)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_set_occluder: NULL argument");
    if (object >= scene->object_count)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_set_occluder: object %u doesn't exist (%u objects)", object,
                        scene->object_count);
    EnfObjectData *owner = &scene->objects[object];
    const double *b = owner->bounds;
    if (!vec_finite(b) || !vec_finite(b + 3) || box_is_empty(b))
        return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: no occluder without bounds", object);
    double box[24][3];
    static const uint32_t box_sizes[6] = {4, 4, 4, 4, 4, 4};
    const int whole = count == 0;
    if (whole) {
        for (int f = 0; f < 6; f++)
            for (int k = 0; k < 4; k++)
                for (int c = 0; c < 3; c++)
                    box[4 * f + k][c] = b[(box_faces[f][k] >> c & 1) ? 3 + c : c];
        corners = &box[0][0];
        sizes = box_sizes;
        count = 6;
        stride = 0;
    }
    if (stride == 0)
        stride = 3 * sizeof(double);
    uint64_t total = 0;
    for (uint64_t p = 0; p < count; p++) {
        EnfStatus status = check_polygon(owner, object, p, (const double *)((const char *)corners + total * stride), stride, sizes[p]);
        if (status != ENF_OK)
            return status;
        total += sizes[p];
    }
    uint64_t polygons = scene->occluder_polygon_count, first = polygons ? scene->occluder_corner_first[polygons] : 0;
    if (polygons + count >= ENF_NONE || first + total >= ENF_NONE)
        return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: too many occluder polygons for 32-bit indices", object);
    if (!ENF_RESERVE(scene->occluders, (uint64_t)scene->occluder_count + 1) ||
        !ENF_RESERVE(scene->occluder_corner_first, polygons + count + 1) || !ENF_RESERVE(scene->occluder_corners, first + total))
        return enf_fail_memory();
    scene->committed = 0;
    if (owner->occluder == ENF_NONE) {
        owner->occluder = scene->occluder_count++;
        scene->occluders[owner->occluder].object = object;
    }
    EnfOccluderData *occluder = &scene->occluders[owner->occluder];
    occluder->polygon_first = (uint32_t)polygons; /* what an earlier call gave stays behind, unused */
    occluder->polygon_count = (uint32_t)count;
    occluder->whole = (uint32_t)whole;
    scene->occluder_corner_first[polygons] = (uint32_t)first;
    for (uint64_t i = 0; i < total; i++)
        memcpy(scene->occluder_corners[first + i], (const char *)corners + i * stride, sizeof *scene->occluder_corners);
    for (uint64_t p = 0; p < count; p++)
        scene->occluder_corner_first[polygons + p + 1] = scene->occluder_corner_first[polygons + p] + sizes[p];
    scene->occluder_polygon_count = (uint32_t)(polygons + count);
    return ENF_OK;
}
