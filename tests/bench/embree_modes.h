/* SPDX-License-Identifier: GPL-3.0-or-later
 * Embree as the anchor of the ray benchmarks: one thread, robust, every way it offers to ask. Loaded at run time, so that the tool
 * itself needs no such library. */
#ifndef ENF_TESTS_EMBREE_MODES_H
#define ENF_TESTS_EMBREE_MODES_H

#include "wall_triangles.h"

enum { EMBREE_1 = 0, EMBREE_4, EMBREE_8, EMBREE_16, EMBREE_N, EMBREE_MODES };
extern const char *const embree_mode_names[EMBREE_MODES];

typedef struct EmbreeScene EmbreeScene;
/* Why it isn't there; NULL when it is. */
const char *embree_missing(void);
EmbreeScene *embree_scene_create(const WallTriangles *walls, int high_quality); /* NULL: not there */
void embree_scene_destroy(EmbreeScene *scene);
double embree_build_seconds(const EmbreeScene *scene);
uint64_t embree_bytes(const EmbreeScene *scene); /* hierarchy and triangle buffers */

typedef struct EmbreeRays {
    uint64_t count;
    const float *ox, *oy, *oz, *dx, *dy, *dz;
    const float *limit; /* NULL: infinity */
} EmbreeRays;
/* Nearest hits: distance (infinity: none) and triangle (ENF_NONE: none). */
void embree_closest(const EmbreeScene *scene, int mode, int coherent, const EmbreeRays *rays, float *distance, uint32_t *triangle);
/* 1: something before the limit. */
void embree_any(const EmbreeScene *scene, int mode, int coherent, const EmbreeRays *rays, uint8_t *blocked);

#endif
