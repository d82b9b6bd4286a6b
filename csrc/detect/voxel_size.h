/* SPDX-License-Identifier: GPL-3.0-or-later
 * How many voxels a grid has, checked: labels and queues count them in 32 bits. */
#ifndef ENF_DETECT_VOXEL_SIZE_H
#define ENF_DETECT_VOXEL_SIZE_H

#include "base/status.h"

/* How every call of voxels begins. given: none of its other arrays is NULL. */
static inline EnfStatus voxel_total(const char *call, const uint32_t size[3], int given, uint64_t *out_total) {
    *out_total = 0;
    if (!size || !given)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "%s: NULL argument", call);
    uint64_t plane = (uint64_t)size[0] * size[1];
    if (plane == 0 || size[2] == 0 || plane > ENF_NONE - 1u || plane * size[2] > ENF_NONE - 1u)
        return enf_fail(ENF_ERROR_BAD_INPUT, "a grid of %u x %u x %u voxels: 1 to %u in all are possible", size[0], size[1], size[2],
                        ENF_NONE - 1u);
    *out_total = plane * size[2];
    return ENF_OK;
}

#endif
