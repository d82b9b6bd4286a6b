/* SPDX-License-Identifier: GPL-3.0-or-later
 * What fuzz targets share: bytes as small numbers, and what must hold for any scene that commits. */
#ifndef FUZZ_COMMON_H
#define FUZZ_COMMON_H

#include "enfilade/enfilade.h"
#include "geometry/vec3.h"
#include "scene/scene_data.h"

#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define FUZZ_CHECK(condition)                                                                                                              \
    do {                                                                                                                                   \
        if (!(condition)) {                                                                                                                \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                                                                \
            abort();                                                                                                                       \
        }                                                                                                                                  \
    } while (0)

typedef struct FuzzBytes {
    const uint8_t *at, *end;
    uint64_t beyond; /* what goes on behind the end: 0: zeroes, else the state of random bytes */
} FuzzBytes;

/* Bytes that don't end: the given ones seed those that follow, so that a few reach as deep as hundreds. */
static inline FuzzBytes fuzz_endless(const uint8_t *data, size_t size) {
    FuzzBytes b = {data, data + size, 0xCBF29CE484222325u};
    for (size_t i = 0; i < size; i++)
        b.beyond = (b.beyond ^ data[i]) * 0x100000001B3u;
    b.beyond |= 1;
    return b;
}

static inline uint32_t fuzz_byte(FuzzBytes *b) {
    if (b->at < b->end)
        return *b->at++;
    b->beyond *= 6364136223846793005u; /* odd stays odd, and 0 stays 0; Knuth 1998 */
    return (uint32_t)(b->beyond >> 56);
}

/* Mostly small whole numbers, so that things meet; now and then hostile ones. */
static inline double fuzz_number(FuzzBytes *b) {
    static const double odd[] = {1e-9, 0.1, 1e7, -1e300, INFINITY, NAN, 1e-300, 0.30000000000000004};
    uint32_t byte = fuzz_byte(b);
    return byte >= 248 ? odd[byte - 248] : byte >= 200 ? 0.1 * (byte - 200) : (double)(byte % 9) - 4.0;
}

/* Commits, and holds the derived arrays against the given ones. */
static inline void fuzz_commit(EnfScene *scene) {
    if (enf_scene_commit(scene) != ENF_OK) {
        FUZZ_CHECK(enf_last_error()[0]);
        return;
    }
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        const EnfPlane *plane = &scene->portal_planes[p];
        FUZZ_CHECK(fabs(vec_length(plane->n) - 1.0) < 1e-9 && isfinite(plane->d));
        for (uint32_t v = scene->portal_vertex_first[p]; v < scene->portal_vertex_first[p + 1]; v++) {
            double local[3];
            vec_sub(local, scene->portal_vertices[v], scene->origin);
            double off = fabs(vec_dot(plane->n, local) - plane->d), slack = 1e-9 * (scene->extent + fabs(plane->d));
            FUZZ_CHECK(off <= scene->portal_deviation[p] + slack);
        }
    }
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        uint32_t cells[16], count, found = 0, first = scene->cell_vertex_first[c], end = scene->cell_vertex_first[c + 1];
        if (first == end)
            continue;
        /* The mean of a cell's corners lies in it; where rooms hold it too, a cell outdoors steps back (point_location.c). */
        FUZZ_CHECK(enf_scene_locate(scene, scene->cell_centres[c], cells, 16, &count) == ENF_OK);
        for (uint32_t i = 0; i < count && i < 16; i++)
            found |= cells[i] == c || (enf_is_exterior(scene, c) && !enf_is_exterior(scene, cells[i]));
        FUZZ_CHECK(found || count > 16);
    }
    for (uint32_t o = 0; o < scene->object_count; o++) {
        const uint32_t *cells;
        uint32_t count;
        FUZZ_CHECK(enf_scene_object_cells(scene, o, &cells, &count) == ENF_OK);
        for (uint32_t i = 0; i < count; i++)
            FUZZ_CHECK(cells[i] < scene->cell_count && (i == 0 || cells[i] > cells[i - 1]));
    }
}

#endif
