/* SPDX-License-Identifier: GPL-3.0-or-later
 * Lights: which of them may reach which cell, and the light that arrives straight from them.
 *
 * A light set is safe: a light that isn't in a cell's set sends no straight line to any point of that cell, so that leaving it out changes
 * no bit of a picture. Opening states are those at the time of the call: after a door moves, make the sets anew.
 * Threads: what is read (scene, raycaster, triangles, sets) may be read by others at the same time; safe on different outputs.
 * Based on: Maria, Horna, Aveneau, Efficient ray traversal of constrained Delaunay tetrahedralization and convex volumes, 2014, section
 * 5.3 (beams from lights through portals). */
#ifndef ENFILADE_LIGHTING_H
#define ENFILADE_LIGHTING_H

#include "enfilade/raycast.h"
#include "enfilade/triangles.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { ENF_LIGHT_POINT = 0, ENF_LIGHT_SPOT = 1, ENF_LIGHT_AREA = 2, ENF_LIGHT_SUN = 3 };

typedef struct EnfLight {
    uint32_t struct_size;
    uint32_t kind;       /* ENF_LIGHT_* */
    double position[3];  /* metres; a sun's doesn't matter */
    double direction[3]; /* the way a spot, a sun, the lit side of an area shines; any length > 0 */
    double side[2][3];   /* area: from its middle to the middles of two edges, metres */
    double radius;       /* point, spot: of the glowing ball, metres. sun: half its angular diameter, radians */
    double spot_angle;   /* the whole cone, radians, 0 .. pi */
    double spot_blend;   /* 0 .. 1: the part of the cone over which it fades to nothing */
    double spread;       /* area: of its light about its direction, radians, above 0 up to pi; pi: a plain diffuse lamp */
    double intensity[3]; /* point, spot: watts a steradian; area: watts a square metre and steradian; sun: watts a square metre */
    double reach;        /* metres, beyond it gives nothing; infinity: none */
    uint32_t ellipse;    /* area: 1 an ellipse, 0 a rectangle */
    uint32_t cosine;     /* spot: 1: fainter by the cosine off its axis too, as Cycles had it before Blender 4.0 */
} EnfLight;
ENF_API EnfLight enf_default_light(void); /* a point light of 1 W/sr at the origin */

/* ---- Light sets ------------------------------------------------------------------------------------------------- */
typedef struct EnfLightSets EnfLightSets;

enum {
    ENF_LIGHT_SETS_BEAMS = 0, /* beams from each light through the portals */
    ENF_LIGHT_SETS_REGION = 1 /* for lights with a size also only cells seen from anywhere in the lights' cells: tighter, slower */
};
typedef struct EnfLightSetsStats {
    uint32_t struct_size;
    uint32_t method;
    uint64_t pairs;          /* a cell and a light that may reach it */
    uint32_t lights;         /* of these reaching any cell */
    uint32_t everywhere;     /* lights that count for all cells, since nothing better could be said: no cell holds them */
    uint64_t dropped_behind; /* pairs dropped: the cell lies outside the light's half space, cone or reach */
    uint64_t dropped_region; /* pairs dropped: no line runs from the light's cells to the cell */
    double wall_s;
    uint64_t bytes;
} EnfLightSetsStats;
ENF_API EnfLightSetsStats enf_default_light_sets_stats(void);

/* ENF_ERROR_BAD_INPUT names the first light whose numbers aren't finite or make no sense. The scene must be committed; it may go
 * before the sets do. Safe on different handles. */
ENF_API EnfStatus enf_light_sets_create(const EnfScene *scene, const EnfLight *lights, uint32_t count, uint32_t method, uint32_t threads,
                                        EnfLightSets **out_sets);
ENF_API void enf_light_sets_destroy(EnfLightSets *sets); /* NULL is fine */
/* first: [cells + 1] into lights; lights ascend in each cell. Owned by the sets. */
ENF_API const uint64_t *enf_light_sets_first(const EnfLightSets *sets);
ENF_API const uint32_t *enf_light_sets_lights(const EnfLightSets *sets);
ENF_API EnfStatus enf_light_sets_stats(const EnfLightSets *sets, EnfLightSetsStats *out_stats);

/* ---- Direct light ------------------------------------------------------------------------------------------------ */
typedef struct EnfLitPoint {
    double position[3]; /* on a surface */
    double normal[3];   /* unit length, to the side that is looked at */
    uint32_t cell;      /* that holds it; ENF_NONE: found, and where no cell does only triangles cast shadows */
    uint32_t seed;      /* which points of lights with a size are taken; any number */
} EnfLitPoint;

typedef struct EnfDirectLight {
    uint32_t struct_size;
    uint32_t threads;              /* 0: one a core; the same bits for any number */
    const EnfRaycaster *raycaster; /* walls; may be NULL */
    const EnfTriangles *triangles; /* what is drawn, committed; may be NULL */
    const EnfLight *lights;
    const EnfLightSets *light_sets; /* NULL: every light is asked about */
    uint32_t light_count;
    uint32_t samples;         /* points taken of a light with a size, 1 .. 64 */
    uint64_t shadow_rays;     /* out */
    uint64_t lights_asked;    /* out: pairs of point and light looked at */
    uint64_t lights_reaching; /* out: of these, giving light */
} EnfDirectLight;
ENF_API EnfDirectLight enf_default_direct_light(void);
/* irradiance: float[3] a point, watts a square metre; counts: lights that give some, may be NULL. */
ENF_API EnfStatus enf_direct_light(EnfDirectLight *direct, const EnfLitPoint *points, uint64_t count, float *out_irradiance,
                                   uint16_t *out_counts);

#ifdef __cplusplus
}
#endif
#endif
