/* SPDX-License-Identifier: GPL-3.0-or-later
 * Regions of voxels: labelled by faces, and grown.
 *
 * Labelling: Rosenfeld and Pfaltz 1966 in three dimensions, run by run along x, with a union-find forest (the root is the lowest number, so that numbers come
 * out in the order of first voxels). Growing: breadth first; a front is an array of voxels, each step makes the next. */
#include "base/memory.h"
#include "base/status.h"
#include "detect/voxel_size.h"
#include "enfilade/voxels.h"

#include <string.h>

static uint32_t root_of(uint32_t *parent, uint32_t i) {
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static uint32_t unite(uint32_t *parent, uint32_t a, uint32_t b) {
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
    return a < b ? a : b;
}

/* The label of a run x..end of one kind, joined with the regions that it touches in the row beside it. */
static uint32_t join_run(uint32_t *parent, uint8_t kind, uint32_t label, const uint8_t *row, const uint32_t *labels, uint32_t x,
                         uint32_t end) {
    uint32_t last = 0; /* most neighbours have the label of the one before */
    for (; x < end; x++)
        if (row[x] == kind && labels[x] != last) {
            last = labels[x];
            label = !label || label == last ? last : unite(parent, label, last);
        }
    return label;
}

EnfStatus enf_voxels_label(const uint32_t size[3], const uint8_t *kinds, uint32_t *labels, uint32_t *out_count) {
    uint64_t total;
    EnfStatus status = voxel_total(__func__, size, kinds && labels && out_count, &total);
    if (status != ENF_OK)
        return status;
    const uint64_t plane = (uint64_t)size[0] * size[1];
    uint32_t *parent = NULL, count = 1;
    if (!ENF_RESERVE(parent, 1024))
        return enf_fail_memory();
    parent[0] = 0;
    const uint8_t *row = kinds;
    uint32_t *own = labels;
    for (uint32_t z = 0; z < size[2]; z++)
        for (uint32_t y = 0; y < size[1]; y++, row += size[0], own += size[0])
            for (uint32_t x = 0, end = 0; x < size[0]; x = end) {
                const uint8_t kind = row[x];
                while (end < size[0] && row[end] == kind)
                    end++;
                uint32_t label = 0;
                if (kind && y)
                    label = join_run(parent, kind, label, row - size[0], own - size[0], x, end);
                if (kind && z)
                    label = join_run(parent, kind, label, row - plane, own - plane, x, end);
                if (kind && !label) {
                    if (!ENF_RESERVE(parent, (uint64_t)count + 1)) {
                        enf_free(parent);
                        return enf_fail_memory();
                    }
                    label = count++;
                    parent[label] = label;
                }
                for (uint32_t i = x; i < end; i++)
                    own[i] = label;
            }
    uint32_t next = 1; /* parents come before their children: one pass renumbers all */
    for (uint32_t i = 1; i < count; i++)
        parent[i] = parent[i] == i ? next++ : parent[parent[i]];
    for (uint64_t v = 0; v < total; v++)
        labels[v] = parent[labels[v]];
    enf_free(parent);
    *out_count = next - 1;
    return ENF_OK;
}

typedef struct Front {
    uint32_t *voxels;
    uint64_t count;
} Front;

/* Labels the passable neighbours of the front that have none, and puts them into `next`. */
static int advance(const uint32_t size[3], const uint8_t *passable, uint32_t *labels, const Front *front, Front *next) {
    const uint64_t plane = (uint64_t)size[0] * size[1];
    next->count = 0;
    for (uint64_t i = 0; i < front->count; i++) {
        uint32_t v = front->voxels[i], x = v % size[0], y = v / size[0] % size[1], z = (uint32_t)(v / plane);
        const uint64_t around[6] = {v - 1u, v + 1u, v - (uint64_t)size[0], v + (uint64_t)size[0], v - plane, v + plane};
        const int there[6] = {x > 0, x + 1 < size[0], y > 0, y + 1 < size[1], z > 0, z + 1 < size[2]};
        for (int k = 0; k < 6; k++) {
            if (!there[k] || !passable[around[k]] || labels[around[k]])
                continue;
            if (!ENF_RESERVE(next->voxels, next->count + 1)) {
                for (uint64_t taken = 0; taken < next->count; taken++)
                    labels[next->voxels[taken]] = 0;
                return 0;
            }
            labels[around[k]] = ENF_NONE; /* taken; who has it is settled below, when all of this step is known */
            next->voxels[next->count++] = (uint32_t)around[k];
        }
    }
    for (uint64_t i = 0; i < next->count; i++) {
        uint32_t v = next->voxels[i], x = v % size[0], y = v / size[0] % size[1], z = (uint32_t)(v / plane);
        const uint64_t around[6] = {v - 1u, v + 1u, v - (uint64_t)size[0], v + (uint64_t)size[0], v - plane, v + plane};
        const int there[6] = {x > 0, x + 1 < size[0], y > 0, y + 1 < size[1], z > 0, z + 1 < size[2]};
        uint32_t lowest = ENF_NONE;
        for (int k = 0; k < 6; k++)
            if (there[k] && labels[around[k]] && !(labels[around[k]] & 0x80000000u) && labels[around[k]] < lowest)
                lowest = labels[around[k]];
        labels[v] = lowest | 0x80000000u; /* marked as of this step, so that neighbours of the same step don't take it up */
    }
    for (uint64_t i = 0; i < next->count; i++)
        labels[next->voxels[i]] &= 0x7FFFFFFFu;
    return 1;
}

EnfStatus enf_voxels_grow(const uint32_t size[3], const uint8_t *passable, uint32_t steps, uint32_t *labels) {
    uint64_t total;
    EnfStatus status = voxel_total(__func__, size, passable && labels, &total);
    if (status != ENF_OK)
        return status;
    Front front = {NULL, 0}, next = {NULL, 0};
    const uint64_t plane = (uint64_t)size[0] * size[1];
    int fine = 1;
    uint64_t v = 0;
    for (uint32_t z = 0; z < size[2] && fine; z++)
        for (uint32_t y = 0; y < size[1] && fine; y++)
            for (uint32_t x = 0; x < size[0] && fine; x++, v++) {
                if (!labels[v])
                    continue;
                if (labels[v] & 0x80000000u) {
                    status = enf_fail(ENF_ERROR_BAD_INPUT, "voxel %llu: label %u, the largest possible is 2147483647",
                                      (unsigned long long)v, labels[v]);
                    fine = 0;
                } else if ((x > 0 && !labels[v - 1] && passable[v - 1]) || (x + 1 < size[0] && !labels[v + 1] && passable[v + 1]) ||
                           (y > 0 && !labels[v - size[0]] && passable[v - size[0]]) ||
                           (y + 1 < size[1] && !labels[v + size[0]] && passable[v + size[0]]) ||
                           (z > 0 && !labels[v - plane] && passable[v - plane]) ||
                           (z + 1 < size[2] && !labels[v + plane] && passable[v + plane])) {
                    fine = ENF_RESERVE(front.voxels, front.count + 1);
                    if (fine)
                        front.voxels[front.count++] = (uint32_t)v;
                }
            }
    for (uint32_t s = 0; fine && front.count && (steps == 0 || s < steps); s++) {
        fine = advance(size, passable, labels, &front, &next);
        Front swap = front;
        front = next;
        next = swap;
    }
    enf_free(front.voxels);
    enf_free(next.voxels);
    return !fine && status == ENF_OK ? enf_fail_memory() : status;
}
