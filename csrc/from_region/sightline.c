/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walks lines through portals, and checks a walked line again on the scene's own polygons. */
#include "from_region/sightline.h"

#include <float.h>

#include "base/memory.h"
#include "from_region/pair_table.h"
#include "geometry/vec3.h"

/* Whether portal r is the next one: met after t0 (before it, when sign is -1), within its inner polygon, nearer than *best. */
static int is_nearer(const EnfRegionModel *m, uint32_t r, const double p[3], const double d[3], double t0, double sign, double *best) {
    const double *plane = m->plane[r];
    double slope = sign * vec_dot(plane, d), x[3];
    if (slope < ENF_CROSSING_SINE_MIN)
        return 0;
    double along = (plane[3] - vec_dot(plane, p)) / slope; /* distance from p in the walking direction */
    uint32_t e = m->inner.first[r >> 1], end = m->inner.first[(r >> 1) + 1];
    if (along < sign * t0 || along >= *best || e == end)
        return 0;
    vec_mad(x, p, sign * along, d);
    for (; e < end; ++e)
        if (vec_dot(m->inner_edge[e], x) < m->inner_edge[e][3])
            return 0;
    *best = along;
    return 1;
}

/* The portal by which the line leaves `cell` after parameter t0 (sign +1) or had entered it before t0 (sign -1). It leaves a convex
 * cell by the first plane it meets; in clusters that aren't convex the nearest is the next. */
static uint32_t next_portal(const EnfRegionModel *m, uint32_t cell, uint32_t came_by, const double p[3], const double d[3], double t0,
                            double sign, double *out_t) {
    uint32_t found = ENF_NONE, first = m->out_first[cell], count = m->out_first[cell + 1] - first;
    double best = DBL_MAX;
    if (m->convex[cell] && count - 1 < 64) {
        const float at[3] = {(float)p[0], (float)p[1], (float)p[2]}, to[3] = {(float)d[0], (float)d[1], (float)d[2]};
        uint64_t leaving = m->kernel->leaving(m->groups + m->group_first[cell], count, (float)sign, at, to);
        for (; leaving; leaving &= leaving - 1) {
            uint32_t r = m->out[first + enf_lowest_bit64(leaving)];
            if (r != came_by && is_nearer(m, r, p, d, t0, sign, &best))
                found = r;
        }
    } else
        for (uint32_t i = first; i < first + count; ++i)
            if (m->out[i] != came_by && is_nearer(m, m->out[i], p, d, t0, sign, &best))
                found = m->out[i];
    *out_t = sign * best;
    return found;
}

void enf_walk_line(const EnfRegionModel *m, uint32_t portal, const double p[3], const double d[3], int both, EnfWalk *walk) {
    walk->count = 0;
    vec_copy(walk->p, p);
    vec_copy(walk->d, d);
    if (!(vec_normalize(walk->d) > 0))
        return;
    d = walk->d;
    const double *plane = m->plane[portal];
    double slope = vec_dot(plane, d);
    if (slope < ENF_CROSSING_SINE_MIN)
        return;
    double t = (plane[3] - vec_dot(plane, p)) / slope, x[3];
    vec_mad(x, p, t, d);
    uint32_t first = m->inner.first[portal >> 1], end = m->inner.first[(portal >> 1) + 1];
    if (first == end)
        return;
    for (uint32_t e = first; e < end; ++e)
        if (vec_dot(m->inner_edge[e], x) < m->inner_edge[e][3])
            return;
    uint32_t back = 0;
    if (both) { /* found backward, so gathered at the end of the arrays first */
        uint32_t at = portal;
        double t_at = t;
        while (back < ENF_WALK_MAX / 2 && !m->dead_end[enf_rm_from(m, at)]) {
            uint32_t r = next_portal(m, enf_rm_from(m, at), at, p, d, t_at, -1.0, &t_at);
            if (r == ENF_NONE)
                break;
            at = enf_rm_reverse(r);
            ++back;
            walk->portals[ENF_WALK_MAX - back] = at, walk->t[ENF_WALK_MAX - back] = t_at;
        }
        for (uint32_t i = 0; i < back; ++i) {
            walk->portals[i] = walk->portals[ENF_WALK_MAX - back + i];
            walk->t[i] = walk->t[ENF_WALK_MAX - back + i];
        }
    }
    uint32_t count = back;
    walk->portals[count] = portal, walk->t[count] = t;
    ++count;
    while (count < ENF_WALK_MAX) {
        uint32_t at = walk->portals[count - 1];
        double t_at;
        if (m->dead_end[m->to[at]])
            break;
        uint32_t r = next_portal(m, m->to[at], enf_rm_reverse(at), p, d, walk->t[count - 1], 1.0, &t_at);
        if (r == ENF_NONE)
            break;
        walk->portals[count] = r, walk->t[count] = t_at;
        ++count;
    }
    walk->count = count;
}

int enf_portals_chain(const EnfRegionModel *m, const uint32_t *portals, uint32_t count) {
    for (uint32_t i = 0; i + 1 < count; ++i)
        if (m->to[portals[i]] != enf_rm_from(m, portals[i + 1]))
            return 0;
    return 1;
}

double enf_line_clearance(const EnfRegionModel *m, const double p[3], const double d[3], const uint32_t *portals, uint32_t count) {
    double least = DBL_MAX, length = vec_length(d), before = -DBL_MAX;
    if (!(length > 0))
        return -1;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t first = m->raw.first[portals[i] >> 1], size = enf_rm_count(&m->raw, portals[i] >> 1);
        const double *plane = m->plane[portals[i]];
        double slope = vec_dot(plane, d), t = (plane[3] - vec_dot(plane, p)) / slope;
        double sense = portals[i] & 1 ? 1.0 : -1.0; /* scene polygons run clockwise about direction 0 */
        if (!(slope >= 0.5 * ENF_CROSSING_SINE_MIN * length) || t < before)
            return -1;
        before = t;
        /* Moments about the crossing point: that takes the large common part out of both products. */
        double x[3];
        vec_mad(x, p, t, d);
        for (uint32_t k = 0; k < size; ++k) {
            double a[3], b[3], e[3], moment[3];
            vec_sub(a, m->raw.vertices[first + k], x);
            vec_sub(b, m->raw.vertices[first + (k + 1) % size], x);
            vec_sub(e, b, a);
            double edge = vec_length(e);
            if (!(edge > 0))
                continue; /* a doubled corner bounds nothing */
            vec_cross(moment, a, e);
            double clearance = sense * vec_dot(moment, d) / (edge * slope);
            if (clearance < least)
                least = clearance;
        }
    }
    return count ? least : -1;
}

int enf_line_store_add(EnfLineStore *store, const double p[3], const double d[3], const uint32_t *portals, uint32_t count) {
    if (!ENF_RESERVE(store->lines, (uint64_t)store->count + 1) || !ENF_RESERVE(store->portals, (uint64_t)store->portal_total + count))
        return 0;
    EnfLine *line = &store->lines[store->count++];
    vec_copy(line->p, p);
    vec_copy(line->d, d);
    line->portal_first = store->portal_total, line->portal_count = count;
    for (uint32_t i = 0; i < count; ++i)
        store->portals[store->portal_total++] = portals[i];
    return 1;
}

void enf_line_store_free(EnfLineStore *store) {
    enf_free(store->lines);
    enf_free(store->portals);
    memset(store, 0, sizeof *store);
}

void enf_portal_sample(const EnfRegionModel *m, uint32_t portal, uint64_t *state, double out[3]) {
    uint32_t first = m->inner.first[portal], count = enf_rm_count(&m->inner, portal);
    uint32_t triangle = (uint32_t)(enf_mix_unit(state) * (count - 2));
    double s = enf_mix_unit(state), r = enf_mix_unit(state);
    if (s + r > 1)
        s = 1 - s, r = 1 - r;
    const double *a = m->inner.vertices[first], *b = m->inner.vertices[first + triangle + 1], *c = m->inner.vertices[first + triangle + 2];
    for (int k = 0; k < 3; ++k)
        out[k] = a[k] + s * (b[k] - a[k]) + r * (c[k] - a[k]);
}
