/* SPDX-License-Identifier: GPL-3.0-or-later
 * One chain of portals as a model of its own, without scene and search: straight to the stabbing tests. */
#include "enfilade/chain_query.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "from_region/chain_search.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

/* As scene building has it (portal_shape.c): farther out of plane than this part of its size, a polygon has no plane. */
#define NOT_A_PLANE 0.02

struct EnfChainQuery {
    EnfRegionModel model;
    double *deviation; /* [portals] metres */
    uint32_t *chain, *hull;
    double (*local)[3]; /* corners of one portal, about the origin */
    EnfStabScratch *stab;
};

EnfChainAnswer enf_default_chain_answer(void) {
    EnfChainAnswer answer;
    memset(&answer, 0, sizeof answer);
    answer.struct_size = (uint32_t)sizeof answer;
    return answer;
}

EnfStatus enf_chain_query_create(EnfChainQuery **out_query) {
    if (!out_query)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: out_query is NULL");
    EnfChainQuery *q = ENF_NEW(EnfChainQuery, 1);
    if (q)
        q->stab = enf_stab_scratch_create();
    if (!q || !q->stab) {
        enf_free(q);
        return enf_fail_memory();
    }
    *out_query = q;
    return ENF_OK;
}

void enf_chain_query_destroy(EnfChainQuery *q) {
    if (!q)
        return;
    enf_region_model_clear(&q->model);
    enf_stab_scratch_destroy(q->stab);
    enf_free(q->deviation), enf_free(q->chain), enf_free(q->hull), enf_free(q->local);
    enf_free(q);
}

static int reserve(EnfChainQuery *q, uint64_t portals, uint64_t corners) {
    EnfRegionModel *m = &q->model;
    return ENF_RESERVE(m->raw.first, portals + 1) && ENF_RESERVE(m->outer.first, portals + 1) && ENF_RESERVE(m->inner.first, portals + 1) &&
           ENF_RESERVE(m->raw.vertices, corners) && ENF_RESERVE(m->plane, 2 * portals) && ENF_RESERVE(m->centre, portals) &&
           ENF_RESERVE(m->radius, portals) && ENF_RESERVE(m->box, portals) && ENF_RESERVE(m->passes, portals) &&
           ENF_RESERVE(m->to, 2 * portals) && ENF_RESERVE(q->deviation, portals) && ENF_RESERVE(q->chain, portals) &&
           ENF_RESERVE(q->hull, corners) && ENF_RESERVE(q->local, corners);
}

/* Plane, deviation and corners of one portal, its corners given about the origin, metres. */
static EnfStatus shape(EnfChainQuery *q, uint32_t p, double (*v)[3], uint32_t count, double rounding) {
    EnfRegionModel *m = &q->model;
    double n[3], low = DBL_MAX, high = -DBL_MAX, size = 0;
    for (uint32_t i = 1; i < count; ++i)
        size = fmax(size, vec_distance(v[i], v[0]));
    double area = enf_polygon_normal(n, v, count);
    if (!(area > 2 * rounding * size))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: portal %u has no area (%.3g m2)", p, area);
    for (uint32_t i = 0; i < count; ++i) {
        double h = vec_dot(n, v[i]);
        low = fmin(low, h), high = fmax(high, h);
    }
    q->deviation[p] = 0.5 * (high - low);
    if (q->deviation[p] > NOT_A_PLANE * size)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: portal %u is %.3g m out of plane", p, q->deviation[p]);
    double *forward = m->plane[2 * p], *back = m->plane[2 * p + 1];
    vec_copy(forward, n);
    forward[3] = 0.5 * (low + high) * m->scale;
    for (int k = 0; k < 4; ++k)
        back[k] = -forward[k];
    uint32_t first = m->raw.first[p], kept = count;
    int whole = enf_polygon_is_convex(v, count, n, 1e-12 * size + rounding);
    if (!whole && !(kept = enf_planar_hull(v, count, n, 0, q->hull)))
        return enf_fail_memory();
    for (uint32_t i = 0; i < kept; ++i) /* raw polygons run clockwise about direction 0 */
        vec_scale(m->raw.vertices[first + i], m->scale, v[whole ? kept - 1 - i : q->hull[kept - 1 - i]]);
    m->raw.first[p + 1] = first + kept;
    m->passes[p] = 1;
    m->to[2 * p] = p + 1, m->to[2 * p + 1] = p;
    q->chain[p] = 2 * p;
    return ENF_OK;
}

static EnfStatus load(EnfChainQuery *q, const double *vertices, const uint32_t *counts, uint32_t portals, double clearance) {
    EnfRegionModel *m = &q->model;
    double bounds[6], largest = 0, extent = 0;
    uint64_t corners = 0;
    box_empty(bounds);
    for (uint32_t p = 0; p < portals; ++p) {
        if (counts[p] < 3)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: portal %u has %u corners", p, counts[p]);
        for (uint64_t i = corners; i < corners + counts[p]; ++i) {
            const double *v = vertices + 3 * i;
            if (!isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2]))
                return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: a corner of portal %u isn't finite", p);
            box_add_point(bounds, v);
        }
        corners += counts[p];
    }
    if (!reserve(q, portals, corners))
        return enf_fail_memory();
    for (int k = 0; k < 3; ++k) {
        m->origin[k] = 0.5 * (bounds[k] + bounds[k + 3]);
        extent += (bounds[k + 3] - bounds[k]) * (bounds[k + 3] - bounds[k]);
        largest = fmax(largest, fmax(fabs(bounds[k]), fabs(bounds[k + 3])));
    }
    extent = sqrt(extent);
    if (!(extent > 0) || !isfinite(extent))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: the portals' extent is %g m", extent);
    enf_region_model_scale(m, extent, largest, clearance);
    m->portal_count = portals, m->cell_count = portals + 1;
    m->raw.first[0] = 0;
    const double *at = vertices;
    for (uint32_t p = 0; p < portals; ++p) {
        for (uint32_t i = 0; i < counts[p]; ++i, at += 3)
            vec_sub(q->local[i], at, m->origin);
        EnfStatus status = shape(q, p, q->local, counts[p], 4 * DBL_EPSILON * largest);
        if (status != ENF_OK)
            return status;
    }
    return ENF_OK;
}

static void middle(const EnfRegionModel *m, uint32_t portal, double out[3]) {
    uint32_t count = enf_rm_count(&m->raw, portal);
    vec_set(out, 0, 0, 0);
    for (uint32_t i = 0; i < count; ++i)
        vec_mad(out, out, 1.0 / count, m->raw.vertices[m->raw.first[portal] + i]);
}

/* Whether the line is a witness, asked what the inner polygons would ask of it, without them. Makes d a unit vector. */
static int passes(const EnfRegionModel *m, const uint32_t *chain, uint32_t portals, const double p[3], double d[3]) {
    if (!(vec_normalize(d) > 0))
        return 0;
    for (uint32_t i = 0; i < portals; ++i)
        if (vec_dot(m->plane[chain[i]], d) < ENF_CROSSING_SINE_MIN)
            return 0;
    return enf_line_clearance(m, p, d, chain, portals) >= ENF_INNER_OFFSET * m->delta;
}

/* What asks for least first: the line through the middles, then the outer polygons, then the inner ones too. */
static EnfStatus decide(EnfChainQuery *q, uint32_t portals, EnfRegionVisStats *stats, uint32_t *out_state, double p[3], double d[3]) {
    EnfRegionModel *m = &q->model;
    EnfWindow source, target;
    middle(m, 0, p), middle(m, portals - 1, d);
    vec_sub(d, d, p);
    if (passes(m, q->chain, portals, p, d)) {
        *out_state = ENF_CHAIN_VISIBLE;
        return ENF_OK;
    }
    EnfStatus status = enf_region_model_enlarge_portals(m, q->deviation);
    if (status != ENF_OK)
        return status;
    for (uint32_t i = 0; i < portals; ++i)
        if (!m->passes[i])
            return ENF_OK;
    if (!enf_window_load(m, 0, &source))
        source.count = 0;
    if (!enf_window_load(m, 2 * (portals - 1), &target))
        target.count = 0;
    EnfChain chain = {q->chain, portals, &source, portals > 1 ? &target : NULL};
    if (enf_chain_is_shut(m, &chain, q->stab, p, d))
        *out_state = ENF_CHAIN_HIDDEN;
    else if (passes(m, q->chain, portals, p, d))
        *out_state = ENF_CHAIN_VISIBLE;
    else if ((status = enf_region_model_shrink_portals(m)) == ENF_OK)
        *out_state = enf_chain_test(m, &chain, q->stab, stats, p, d);
    return status;
}

EnfStatus enf_chain_query(EnfChainQuery *q, const double *vertices, const uint32_t *counts, uint32_t portals, double clearance,
                          EnfChainAnswer *out) {
    if (!q || !vertices || !counts || !out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: query, vertices, corner_counts or out_answer is NULL");
    if (out->struct_size != sizeof *out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: struct_size is %u, expected %u", out->struct_size, (unsigned)sizeof *out);
    if (!portals || portals > ENF_CHAIN_MAX)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "chain query: %u portals, expected 1 to %u", portals, ENF_CHAIN_MAX);
    EnfStatus status = load(q, vertices, counts, portals, clearance);
    if (status != ENF_OK)
        return status;
    const EnfRegionModel *m = &q->model;
    EnfRegionVisStats stats;
    memset(&stats, 0, sizeof stats);
    uint32_t last = portals - 1, state = ENF_CHAIN_UNDECIDED;
    double p[3], d[3];
    if ((status = decide(q, portals, &stats, &state, p, d)) != ENF_OK)
        return status;
    *out = enf_default_chain_answer();
    out->delta = m->delta * m->inverse_scale;
    static const uint32_t statuses[] = {ENF_PAIR_HIDDEN, ENF_PAIR_VISIBLE, ENF_PAIR_GRAZING, ENF_PAIR_UNDECIDED};
    out->status = statuses[state];
    out->exact_signs = (uint32_t)stats.exact_signs;
    out->shown_by = state == ENF_CHAIN_UNDECIDED ? ENF_SHOWN_BY_NOTHING
                    : stats.cone_tests           ? ENF_SHOWN_BY_CONE
                    : state == ENF_CHAIN_HIDDEN  ? ENF_SHOWN_BY_WINDOWS
                                                 : ENF_SHOWN_BY_LINE;
    if (state != ENF_CHAIN_VISIBLE && state != ENF_CHAIN_GRAZING)
        return ENF_OK;
    (void)vec_normalize(d);
    for (int end = 0; end < 2; ++end) {
        const double *plane = m->plane[end ? 2 * last : 0];
        double slope = vec_dot(plane, d), t = (plane[3] - vec_dot(plane, p)) / slope;
        t += (end ? 0.01 : -0.01) * m->delta / slope;
        for (int k = 0; k < 3; ++k)
            out->segment[3 * end + k] = (p[k] + t * d[k]) * m->inverse_scale + m->origin[k];
    }
    out->clearance = enf_line_clearance(m, p, d, q->chain, portals) * m->inverse_scale;
    return ENF_OK;
}
