/* SPDX-License-Identifier: GPL-3.0-or-later
 * How far voxels reach: the boxes of regions, free runs up and down each column, and masks widened. */
#include "base/memory.h"
#include "base/status.h"
#include "detect/voxel_size.h"
#include "enfilade/voxels.h"

#include <string.h>

EnfStatus enf_voxels_boxes(const uint32_t size[3], const uint32_t *labels, uint32_t count, uint32_t *boxes) {
    uint64_t total;
    EnfStatus status = voxel_total(__func__, size, labels && boxes, &total);
    if (status != ENF_OK)
        return status;
    for (uint64_t i = 0; i < 6 * ((uint64_t)count + 1); i++)
        boxes[i] = i % 6 < 3 ? ENF_NONE : 0;
    const uint32_t *row = labels;
    for (uint32_t z = 0; z < size[2]; z++)
        for (uint32_t y = 0; y < size[1]; y++, row += size[0])
            for (uint32_t x = 0; x < size[0];) {
                const uint32_t label = row[x], first = x;
                while (x < size[0] && row[x] == label)
                    x++;
                if (label > count)
                    return enf_fail(ENF_ERROR_BAD_INPUT, "voxel %llu: label %u of %u", (unsigned long long)(row - labels) + first, label,
                                    count);
                const uint32_t low[3] = {first, y, z}, high[3] = {x, y + 1, z + 1};
                uint32_t *box = boxes + 6 * (uint64_t)label;
                for (int a = 0; a < 3; a++) {
                    box[a] = low[a] < box[a] ? low[a] : box[a];
                    box[3 + a] = high[a] > box[3 + a] ? high[a] : box[3 + a];
                }
            }
    return ENF_OK;
}

/* One layer of runs from the layer before it: 0 where something is in the way, else one more, 255 at most. */
static void extend_runs(uint64_t plane, const uint8_t *blocked, const uint8_t *before, uint8_t *run) {
    for (uint64_t i = 0; i < plane; i++) {
        uint8_t reach = before ? before[i] : 255;
        run[i] = blocked[i] ? 0 : (uint8_t)(reach + (reach < 255));
    }
}

EnfStatus enf_voxels_runs(const uint32_t size[3], const uint8_t *blocked, uint8_t *down, uint8_t *up) {
    uint64_t total;
    EnfStatus status = voxel_total(__func__, size, blocked && down && up, &total);
    if (status != ENF_OK)
        return status;
    const uint64_t plane = (uint64_t)size[0] * size[1];
    for (uint64_t at = 0; at < total; at += plane)
        extend_runs(plane, blocked + at, at ? down + at - plane : NULL, down + at);
    for (uint64_t at = total; at; at -= plane)
        extend_runs(plane, blocked + at - plane, at < total ? up + at : NULL, up + at - plane);
    return ENF_OK;
}

/* One step of a sweep over `count` voxels side by side: how far back each one's nearest voxel with the bit `set` lies, 255 at most. What lies
 * within reach gets the bit `reached`. */
static void sweep(uint64_t count, uint8_t set, uint8_t reach, uint8_t reached, uint8_t *since, uint8_t *mask) {
    for (uint64_t i = 0; i < count; i++) {
        since[i] = mask[i] & set ? 0 : (uint8_t)(since[i] + (since[i] < 255));
        mask[i] |= since[i] <= reach ? reached : 0;
    }
}

/* The same there and back along x. */
static void sweep_row(uint32_t count, uint8_t set, uint8_t reach, uint8_t reached, uint8_t *row) {
    uint32_t since = 255;
    for (uint32_t i = 0; i < count; i++) {
        since = row[i] & set ? 0 : since + 1;
        row[i] |= since <= reach ? reached : 0;
    }
    since = 255;
    for (uint32_t i = count; i-- > 0;) {
        since = row[i] & set ? 0 : since + 1;
        row[i] |= since <= reach ? reached : 0;
    }
}

EnfStatus enf_voxels_widen(const uint32_t size[3], const uint8_t reach[3], uint8_t *mask) {
    uint64_t total;
    EnfStatus status = voxel_total(__func__, size, reach && mask, &total);
    if (status != ENF_OK)
        return status;
    if (reach[0] == 255 || reach[1] == 255 || reach[2] == 255)
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_voxels_widen: 254 voxels are the most");
    uint8_t *since = NULL, set = 1; /* each axis reads the bit that the one before it wrote */
    const uint64_t plane = (uint64_t)size[0] * size[1];
    if (!ENF_RESERVE(since, plane))
        return enf_fail_memory();
    for (uint64_t i = 0; i < total; i++)
        mask[i] = mask[i] ? set : 0;
    for (uint64_t at = 0; reach[0] && at < total; at += size[0])
        sweep_row(size[0], set, reach[0], 2, mask + at);
    set = reach[0] ? 2 : set;
    for (int a = 1; a < 3; a++) {
        const uint64_t inner = a == 1 ? size[0] : plane, block = inner * size[a];
        const uint8_t reached = (uint8_t)(2 << a);
        for (uint64_t at = 0; reach[a] && at < total; at += block) {
            memset(since, 255, inner);
            for (uint64_t i = 0; i < block; i += inner)
                sweep(inner, set, reach[a], reached, since, mask + at + i);
            memset(since, 255, inner);
            for (uint64_t i = block; i; i -= inner)
                sweep(inner, set, reach[a], reached, since, mask + at + i - inner);
        }
        set = reach[a] ? reached : set;
    }
    for (uint64_t i = 0; i < total; i++)
        mask[i] = mask[i] & set ? 1 : 0;
    enf_free(since);
    return ENF_OK;
}

EnfStatus enf_voxels_rename(const uint32_t size[3], const uint32_t *names, uint32_t count, uint32_t *labels) {
    uint64_t total;
    EnfStatus status = voxel_total(__func__, size, names && labels, &total);
    if (status != ENF_OK)
        return status;
    uint32_t most = 0;
    for (uint64_t v = 0; v < total; v++)
        most = labels[v] > most ? labels[v] : most;
    if (most > count)
        return enf_fail(ENF_ERROR_BAD_INPUT, "a voxel has label %u of %u", most, count);
    for (uint64_t v = 0; v < total; v++)
        labels[v] = names[labels[v]];
    return ENF_OK;
}
