/* SPDX-License-Identifier: GPL-3.0-or-later
 * Lights as the engines use them. Internal to the core. */
#ifndef ENF_RAYCAST_LIGHT_H
#define ENF_RAYCAST_LIGHT_H

#include "enfilade/lighting.h"

struct EnfLightSets {
    uint32_t cell_count;
    uint64_t *first;
    uint32_t *lights;
    EnfLightSetsStats stats;
};

/* ENF_ERROR_BAD_INPUT with the light's number and the reason. */
EnfStatus enf_light_check(const EnfLight *light, uint32_t index);
double enf_light_unit(uint32_t seed, uint32_t sample, uint32_t dimension); /* 0 .. 1, evenly spread over samples */

/* One point of a light as seen from `point`: where to (unit length), how far (infinity: a sun), and what arrives there on a surface
 * that faces it squarely. 0: nothing. */
typedef struct LightSample {
    double to[3];
    double distance;
    double irradiance[3];
} LightSample;
int enf_light_sample(const EnfLight *light, const double point[3], uint32_t sample, uint32_t samples, uint32_t seed, LightSample *out);
/* Whether the light has a size, so that one sample isn't all of it. */
int enf_light_is_soft(const EnfLight *light);

/* The cell that holds the light. ENF_NONE: walls can't tell what it lights, and it counts everywhere: it is a sun, or sits in a wall or
 * ceiling (in no cell with a shape, yet within the building's bounds), where what is drawn has a recess that the cells don't know. */
uint32_t enf_light_cell(const EnfScene *scene, const EnfLight *light);

typedef struct LightCounts {
    uint64_t shadow_rays, asked, reaching;
} LightCounts;
/* Irradiance at one point. walk_from: the point from which walls are walked (inside point->cell). light_cells: the cell that holds each
 * light, ENF_NONE: none does, and walls don't count for it. Gives how many lights reach it. */
uint32_t enf_light_at(const EnfDirectLight *direct, const uint32_t *light_cells, const EnfLitPoint *point, const double walk_from[3],
                      float out_irradiance[3], LightCounts *counts);
/* [light_count] for enf_light_at, NULL when memory runs out; the caller frees it. */
uint32_t *enf_light_cells(const EnfDirectLight *direct);
EnfStatus enf_direct_light_check(const EnfDirectLight *direct);

#endif
