/* SPDX-License-Identifier: GPL-3.0-or-later
 * Bytes -> a small grid, triangles (hostile ones too) and labels: points of a triangle lie in marked voxels, regions differ from their
 * neighbours, growth ends where it must. */
#include "fuzz_common.h"

#include <math.h>
#include <string.h>

enum { MOST = 10 * 10 * 10 };

static int neighbours(const uint32_t size[3], uint32_t v, uint32_t out[6]) {
    const uint32_t at[3] = {v % size[0], v / size[0] % size[1], v / (size[0] * size[1])}, stride[3] = {1, size[0], size[0] * size[1]};
    int count = 0;
    for (int a = 0; a < 3; a++) {
        if (at[a] > 0)
            out[count++] = v - stride[a];
        if (at[a] + 1 < size[a])
            out[count++] = v + stride[a];
    }
    return count;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t length) {
    FuzzBytes bytes = {data, data + length};
    static uint8_t kinds[MOST], passable[MOST];
    static uint32_t labels[MOST], before[MOST], regions[MOST];
    uint32_t size[3], beside[6], count = 0;
    double vertices[12][3], origin[3], step = fuzz_byte(&bytes) % 8 ? 0.5 : fuzz_number(&bytes);
    for (int a = 0; a < 3; a++) {
        size[a] = fuzz_byte(&bytes) % 11;
        origin[a] = -2.0 + 0.01 * fuzz_byte(&bytes);
    }
    const uint32_t total = size[0] * size[1] * size[2];
    memset(kinds, 0, sizeof kinds);
    for (int i = 0; i < 12; i++)
        for (int a = 0; a < 3; a++)
            vertices[i][a] = fuzz_number(&bytes);
    for (int t = 0; t < 6; t++) {
        uint32_t corners[3] = {fuzz_byte(&bytes) % 13, fuzz_byte(&bytes) % 12, fuzz_byte(&bytes) % 12};
        EnfStatus status = enf_voxels_mark(size, origin, step, &vertices[0][0], 12, 0, corners, 1, (uint8_t)(1 << (t & 1)), kinds);
        if (status != ENF_OK) {
            FUZZ_CHECK(enf_last_error()[0]);
            continue;
        }
        const double *a = vertices[corners[0]], *b = vertices[corners[1]], *c = vertices[corners[2]];
        for (int i = 0; i <= 8; i++)
            for (int j = 0; i + j <= 8; j++) {
                uint32_t v = 0, stride = 1;
                int inside = 1;
                for (int k = 0; k < 3; k++) {
                    double x = (a[k] + (b[k] - a[k]) * i / 8 + (c[k] - a[k]) * j / 8 - origin[k]) / step;
                    /* What is rounded here may fall to the next voxel; only points well within one are asked. */
                    double reach = 1e-6 + 1e-12 * (fabs(a[k]) + fabs(b[k]) + fabs(c[k])) / step;
                    inside &= x > 0 && x < size[k] && x - floor(x) > reach && ceil(x) - x > reach;
                    v += inside ? stride * (uint32_t)x : 0;
                    stride *= size[k];
                }
                FUZZ_CHECK(!inside || (kinds[v] & (1 << (t & 1))));
            }
    }
    EnfStatus status = enf_voxels_label(size, kinds, labels, &count);
    FUZZ_CHECK((status == ENF_OK) == (total > 0));
    if (status != ENF_OK)
        return 0;
    uint32_t next = 1;
    memcpy(regions, labels, sizeof regions);
    for (uint32_t v = 0; v < total; v++) {
        FUZZ_CHECK((labels[v] != 0) == (kinds[v] != 0) && labels[v] <= next && labels[v] <= count);
        next += labels[v] == next;
        for (int i = neighbours(size, v, beside); i-- > 0;)
            FUZZ_CHECK((labels[v] == labels[beside[i]]) == (kinds[v] == kinds[beside[i]]) || !labels[v] || !labels[beside[i]]);
        passable[v] = fuzz_byte(&bytes) % 4 > 0;
        before[v] = labels[v] % 3 == 1 ? labels[v] : 0;
        labels[v] = before[v];
    }
    FUZZ_CHECK(next == count + 1);
    static uint32_t boxes[MOST + 1][6];
    static uint8_t down[MOST], up[MOST], wide[MOST];
    const uint8_t reach[3] = {fuzz_byte(&bytes) % 4, fuzz_byte(&bytes) % 4, fuzz_byte(&bytes) % 4};
    memcpy(wide, kinds, sizeof wide);
    FUZZ_CHECK(enf_voxels_boxes(size, regions, count, &boxes[0][0]) == ENF_OK);
    FUZZ_CHECK(enf_voxels_runs(size, kinds, down, up) == ENF_OK && enf_voxels_widen(size, reach, wide) == ENF_OK);
    for (uint32_t v = 0; v < total; v++) {
        const uint32_t at[3] = {v % size[0], v / size[0] % size[1], v / (size[0] * size[1])}, *box = boxes[regions[v]];
        for (int a = 0; a < 3; a++)
            FUZZ_CHECK(box[a] <= at[a] && at[a] < box[3 + a]);
        FUZZ_CHECK((down[v] == 0) == (kinds[v] != 0) && (up[v] == 0) == (kinds[v] != 0) && wide[v] >= (kinds[v] != 0));
    }
    uint32_t steps = fuzz_byte(&bytes) % 4;
    FUZZ_CHECK(enf_voxels_grow(size, passable, steps, labels) == ENF_OK);
    for (uint32_t v = 0; v < total; v++) {
        int beside_same = 0, beside_any = 0;
        for (int i = neighbours(size, v, beside); i-- > 0;) {
            beside_same |= labels[beside[i]] == labels[v];
            beside_any |= labels[beside[i]] != 0;
        }
        FUZZ_CHECK(!before[v] || labels[v] == before[v]);
        FUZZ_CHECK(before[v] || !labels[v] || (passable[v] && beside_same));
        FUZZ_CHECK(steps || labels[v] || !passable[v] || !beside_any);
    }
    return 0;
}
