/* SPDX-License-Identifier: GPL-3.0-or-later
 * The scene as the from-region engine computes with it: recentred, scaled to unit size, portals directed and offset.
 *
 * Units: "model units", scene metres times a power of two, so that the scene's extent lies in [0.5, 1). Scaling is exact.
 * Each portal has two polygons in its plane, both shrunk:
 * `inner` by 1.05 delta: the certain answer; a line through it clears the portal by delta.
 * `outer` by half a touch (1e-11 extents by default): the safe answer. What no line passes there is hidden: no line clears
 * every portal by a touch. Why not enlarged, if only by a touch: see ALGORITHMS.md.
 * The half touch that lines of interest keep from outer edges, and the 5 % of delta from inner ones, pay for the rounding of the
 * polygons themselves (1e-15). */
#ifndef ENF_FROM_REGION_REGION_MODEL_H
#define ENF_FROM_REGION_REGION_MODEL_H

#include <math.h>

#include "from_region/separators.h"
#include "geometry/polygon.h"
#include "scene/scene_data.h"

/* A witness crosses every portal's plane at this sine or more. Below it the crossing point's rounding (1e-16 over the sine)
 * would eat up the 5 % of delta that the inner polygons have to spare. */
#define ENF_CROSSING_SINE_MIN 1e-7

/* HIDDEN speaks of lines that cross every portal's plane at this sine or more, and at a touch over the portal's least width. */
#define ENF_HIDDEN_SINE_MIN 1e-9

/* [Deltas] Offset of the inner polygons: the share beyond 1 covers the rounding of everything computed from them. */
#define ENF_INNER_OFFSET 1.05

/* A directed portal is 2 * portal + direction; direction 0 leads from cells[0] to cells[1] of the scene's portal. */
static inline uint32_t enf_rm_reverse(uint32_t directed) {
    return directed ^ 1u;
}

typedef struct EnfRegionPolygons {
    uint32_t *first;       /* [portals + 1] */
    double (*vertices)[3]; /* outer, inner: counter-clockwise about the plane's normal (direction 0) */
} EnfRegionPolygons;

typedef struct EnfRegionModel {
    const EnfScene *scene;
    const EnfSeparatorKernel *kernel;
    uint32_t cell_count, portal_count;
    uint32_t *cell_of, *portal_of; /* of a part: the scene's cells and portals, ascending. NULL: the whole scene, in its numbers */
    uint8_t *rim;                  /* [cells] of a part: some of the cell's portals are left out. NULL: the whole */
    double origin[3];
    double scale, inverse_scale; /* model = (metres - origin) * scale */
    double delta;                /* clearance, model units */
    double touch;                /* model units: a line nearer to an edge than this doesn't pass it */
    double opposite;             /* sums of normals below this face against each other */
    double order_slack;          /* model units: a portal may be crossed this far before another that comes earlier */
    uint8_t *passes;             /* [portals] sight passes, and it joins two different cells */
    uint8_t *dead_end;           /* [cells] a shut opening's own cell: seen into from its sides, and out of, never through */
    double (*plane)[4];          /* [2 * portals] directed: n . x - d, n along the direction */
    EnfRegionPolygons raw, outer,
        inner; /* raw: as the scene has it, clockwise about direction 0's normal. inner may be empty: narrower than 2.1 delta */
    double (*inner_edge)[4]; /* beside inner.vertices: m . x >= c inside edge i, i + 1; m a unit vector in the plane */
    double (*centre)[3];     /* [portals] of the outer polygon */
    double *radius;          /* [portals] */
    float (*box)[6];         /* [portals] of the outer polygon: centre xyz, half size xyz, rounded outward */
    uint32_t *to;            /* [2 * portals] cell a directed portal leads to */
    uint32_t *out_first;     /* [cells + 1] */
    uint32_t *out;           /* directed portals leaving each cell, ascending; passing ones only */
    /* What the first tests of portals read, side by side. */
    uint32_t *out_to;      /* beside out: the cell */
    uint32_t *out_way;     /* beside out: the number of the direction it faces; of the opposite one: ^ 1 */
    uint32_t *way;         /* [2 * portals] the same */
    float (*out_box)[6];   /* beside out: the portal's box */
    EnfPlaneGroup *groups; /* planes of the portals that leave a cell, from group_first[cell] on */
    uint32_t *group_first; /* [cells] */
    float (*cell_box)[6];  /* [cells] as `box`, union over its portals: whoever sees the cell sees one of them */
    uint8_t *convex;       /* [cells] convex as far as its portals tell: no line enters it twice */
} EnfRegionModel;

/* states: [openings] ENF_STATE_* to take instead of the scene's; NULL: the scene's. inside: [cells of the scene] a part: these cells
 * with all their portals, and as its rim the cells these lead to; NULL: the whole. */
EnfStatus enf_region_model_create(const EnfScene *scene, const uint8_t *states, double clearance_metres, const uint8_t *inside,
                                  EnfRegionModel **out_model);
void enf_region_model_destroy(EnfRegionModel *model);
void enf_region_model_clear(EnfRegionModel *model); /* frees what it holds, not itself */
/* The parts of it that need no scene. Scale, clearance and touch, from the extent and the largest coordinate in metres. */
void enf_region_model_scale(EnfRegionModel *model, double extent, double largest, double clearance_metres);
/* Outer and inner polygons, edges, centres, radii, boxes from raw polygons and planes. deviation: [portals] metres. */
EnfStatus enf_region_model_shape_portals(EnfRegionModel *model, const double *deviation);
/* The same in two steps: outer polygons, centres, radii, boxes; then inner polygons and edges. */
EnfStatus enf_region_model_enlarge_portals(EnfRegionModel *model, const double *deviation);
EnfStatus enf_region_model_shrink_portals(EnfRegionModel *model);

/* The portals that leave the cell, at most 64 from the k-th on (a multiple of 64), that touch the region of the planes and can come
 * after portals a and b (sign 1), or, seen from the other side, before (-1). Bit i: the k + i-th. */
static inline uint64_t enf_rm_ways(const EnfRegionModel *model, const EnfHalfspaces *planes, uint32_t cell, uint32_t k, float sign,
                                   uint32_t a, uint32_t b) {
    uint32_t first = model->out_first[cell] + k, count = model->out_first[cell + 1] - first;
    return model->kernel->ways(planes, model->groups + model->group_first[cell] + k / ENF_GROUP,
                               (const float(*)[6])(model->out_box + first), count < 64 ? count : 64, sign, model->box[a >> 1],
                               model->box[b >> 1]);
}

/* Whether two portals face against each other: the sum of their normals is shorter than the two least sines together (chain_test.c), so
 * no line crosses both at these. */
static inline int enf_rm_turns_back(const EnfRegionModel *model, uint32_t a, uint32_t b) {
    const double *m = model->plane[a], *n = model->plane[b];
    return fabs(m[0] + n[0]) + fabs(m[1] + n[1]) + fabs(m[2] + n[2]) < model->opposite;
}

static inline uint32_t enf_rm_from(const EnfRegionModel *model, uint32_t directed) {
    return model->to[enf_rm_reverse(directed)];
}
/* What the scene calls a cell or a directed portal of the model, and back (the portal must be in it). */
static inline uint32_t enf_rm_scene_cell(const EnfRegionModel *model, uint32_t cell) {
    return model->cell_of ? model->cell_of[cell] : cell;
}
static inline uint32_t enf_rm_scene_portal(const EnfRegionModel *model, uint32_t directed) {
    return model->portal_of ? 2 * model->portal_of[directed >> 1] | (directed & 1) : directed;
}
uint32_t enf_rm_own_portal(const EnfRegionModel *model, uint32_t scene_directed);

static inline uint32_t enf_rm_count(const EnfRegionPolygons *polygons, uint32_t portal) {
    return polygons->first[portal + 1] - polygons->first[portal];
}

/* Convex polygon in the plane of unit normal `normal`: hull of the projected points, counter-clockwise about it, shifted
 * outward (offset > 0) or inward (offset < 0). Writes at most 2 * count + 2 corners; 0 when nothing is left. scratch: room for four times
 * as many. */
uint32_t enf_portal_offset(const double (*points)[3], uint32_t count, const double normal[3], double plane_d, double offset,
                           double (*out)[3], EnfFlatPoint *scratch);

#endif
