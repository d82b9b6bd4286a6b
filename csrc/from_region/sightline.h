/* SPDX-License-Identifier: GPL-3.0-or-later
 * Sightlines: straight lines walked through the portals of convex cells, kept as witnesses. */
#ifndef ENF_FROM_REGION_SIGHTLINE_H
#define ENF_FROM_REGION_SIGHTLINE_H

#include "from_region/region_model.h"

/* A line crosses at most this many portals; longer walks are cut (fewer pairs proven by it: never wrong). */
#define ENF_WALK_MAX 256

/* Portals passed in order, with the line's parameters there. Cells: from(portals[0]), to(portals[0]), to(portals[1]) ... */
typedef struct EnfWalk {
    double p[3], d[3]; /* d of length 1; p at the first portal */
    uint32_t count;
    uint32_t portals[ENF_WALK_MAX];
    double t[ENF_WALK_MAX];
} EnfWalk;

/* The line through p (near the plane of `portal`) along d: walks forward from there, and backward too when `both` is set,
 * passing inner polygons only. count is 0 when the first portal isn't passed. d is normalised here. */
void enf_walk_line(const EnfRegionModel *model, uint32_t portal, const double p[3], const double d[3], int both, EnfWalk *walk);

/* The least clearance of the line over these portals, measured on the scene's own polygons by side products: what decides
 * whether a witness counts, sharing nothing with the walk. Negative when a portal is missed or crossed the wrong way or order;
 * -1 when it isn't crossed at all. Model units. */
double enf_line_clearance(const EnfRegionModel *model, const double p[3], const double d[3], const uint32_t *portals, uint32_t count);

/* Whether the portals follow one another from cell to cell. */
int enf_portals_chain(const EnfRegionModel *model, const uint32_t *portals, uint32_t count);

/* A growing list of lines with their portals. */
typedef struct EnfLine {
    double p[3], d[3];
    uint32_t portal_first, portal_count;
} EnfLine;
typedef struct EnfLineStore {
    EnfLine *lines;
    uint32_t *portals;
    uint32_t count;
    uint32_t portal_total;
} EnfLineStore;
/* Gives 0 when memory runs out. */
int enf_line_store_add(EnfLineStore *store, const double p[3], const double d[3], const uint32_t *portals, uint32_t count);
void enf_line_store_free(EnfLineStore *store);

/* Deterministic numbers: the same for the same key and counter on every machine. */
static inline uint64_t enf_mix64(uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}
static inline double enf_mix_unit(uint64_t *state) { /* [0, 1) */
    *state += 1;
    return (double)(enf_mix64(*state) >> 11) * 0x1p-53;
}
/* A point of the portal's inner polygon, uniform over a fan of triangles chosen evenly. The polygon must not be empty. */
void enf_portal_sample(const EnfRegionModel *model, uint32_t portal, uint64_t *state, double out[3]);

#endif
