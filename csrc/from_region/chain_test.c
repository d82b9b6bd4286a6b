/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whether a line passes a whole chain of portals: a line guessed first, the stabbing cone when that fails.
 *
 * VISIBLE rests on a line checked against every portal, HIDDEN on the cone of the outer polygons having been certified not to
 * meet the Klein quadric. */
#include <string.h>

#include "base/memory.h"
#include "from_region/search_worker.h"
#include "from_region/stab_cone.h"
#include "geometry/vec3.h"

/* Portals whose normals are this near to a frame axis are taken to be exactly across it: moves no corner by more than this
 * times its distance, within the half touch that lines of interest keep from the outer edges. */
#define ALIGNED 1e-12

struct EnfStabScratch {
    EnfStabCone *cone;
    EnfWindow *windows;
};

EnfStabScratch *enf_stab_scratch_create(void) {
    EnfStabScratch *scratch = ENF_NEW(EnfStabScratch, 1);
    if (!scratch)
        return NULL;
    scratch->cone = enf_cone_create();
    if (scratch->cone)
        return scratch;
    enf_free(scratch);
    return NULL;
}
void enf_stab_scratch_destroy(EnfStabScratch *scratch) {
    if (scratch)
        enf_cone_destroy(scratch->cone), enf_free(scratch->windows);
    enf_free(scratch);
}

static void centroid(const EnfWindow *window, double out[3]) {
    vec_set(out, 0, 0, 0);
    for (uint32_t i = 0; i < window->count; ++i)
        out[0] += window->x[i], out[1] += window->y[i], out[2] += window->z[i];
    vec_scale(out, 1.0 / window->count, out);
}

/* Whether the line clears every portal of the chain, by the inner polygons. */
static int passes_inner(const EnfRegionModel *m, const EnfChain *chain, const double p[3], const double d[3]) {
    for (uint32_t i = 0; i < chain->count; ++i) {
        uint32_t r = chain->portals[i], e = m->inner.first[r >> 1], end = m->inner.first[(r >> 1) + 1];
        const double *plane = m->plane[r];
        double slope = vec_dot(plane, d), x[3];
        if (slope < ENF_CROSSING_SINE_MIN || e == end)
            return 0;
        vec_mad(x, p, (plane[3] - vec_dot(plane, p)) / slope, d);
        for (; e < end; ++e)
            if (vec_dot(m->inner_edge[e], x) < m->inner_edge[e][3])
                return 0;
    }
    return 1;
}

static int is_witness(const EnfRegionModel *m, const EnfChain *chain, const double p[3], double d[3]) {
    return vec_normalize(d) > 0 && passes_inner(m, chain, p, d) && enf_line_clearance(m, p, d, chain->portals, chain->count) >= m->delta;
}

static int clip_to_inner(const EnfRegionModel *m, uint32_t portal, EnfWindow *window) {
    int clipped = 0;
    for (uint32_t e = m->inner.first[portal]; e < m->inner.first[portal + 1]; ++e)
        if (!m->kernel->clip(window, m->inner_edge[e], &clipped))
            return 0;
    return 1;
}

/* What is seen from point x through the inner polygons between, of `window`: exact but for rounding, and a point of it makes
 * a line. forward 0: looking back along the chain. */
static int look_from(const EnfRegionModel *m, const EnfChain *chain, const double x[3], int forward, EnfWindow *window) {
    int clipped = 0;
    for (uint32_t i = 1; i + 1 < chain->count; ++i) {
        uint32_t r = chain->portals[i], first = m->inner.first[r >> 1], count = enf_rm_count(&m->inner, r >> 1);
        int turn = (int)(r & 1) ^ !forward;
        for (uint32_t k = 0; k < count; ++k) {
            double a[3], b[3], plane[4];
            vec_sub(a, m->inner.vertices[first + k], x);
            vec_sub(b, m->inner.vertices[first + (k + 1 < count ? k + 1 : 0)], x);
            if (turn)
                vec_cross(plane, b, a);
            else
                vec_cross(plane, a, b);
            plane[3] = vec_dot(plane, x);
            if (!m->kernel->clip(window, plane, &clipped))
                return 0;
        }
    }
    return 1;
}

/* A few lines that nearly always settle a chain that can be seen through. */
static int guess_line(const EnfRegionModel *m, const EnfChain *chain, const EnfWindow *from_window, const EnfWindow *to_window, double p[3],
                      double d[3]) {
    uint32_t first = chain->portals[0], last = chain->portals[chain->count - 1];
    for (uint32_t i = 0; i < chain->count; ++i)
        if (!enf_rm_count(&m->inner, chain->portals[i] >> 1))
            return 0;
    EnfWindow source, target, seen;
    enf_window_copy(&source, from_window);
    if (!clip_to_inner(m, first >> 1, &source))
        return 0;
    centroid(&source, p);
    if (chain->count == 1) {
        vec_copy(d, m->plane[first]);
        return is_witness(m, chain, p, d);
    }
    enf_window_copy(&target, to_window);
    if (!clip_to_inner(m, last >> 1, &target))
        return 0;
    double x[3], y[3];
    centroid(&target, y);
    vec_sub(d, y, p);
    if (is_witness(m, chain, p, d))
        return 1;
    /* From the middle and the corners of the source (drawn in a little), then the other way. */
    for (int forward = 1; forward >= 0; --forward) {
        const EnfWindow *from = forward ? &source : &target, *to = forward ? &target : &source;
        double middle[3];
        centroid(from, middle);
        for (uint32_t k = 0; k <= 4 && k <= from->count; ++k) {
            if (k) {
                enf_window_corner(from, k - 1, x);
                vec_sub(x, x, middle);
                vec_mad(x, middle, 0.9, x);
            } else
                vec_copy(x, middle);
            enf_window_copy(&seen, to);
            if (!look_from(m, chain, x, forward, &seen))
                continue;
            centroid(&seen, y);
            vec_copy(p, forward ? x : y);
            vec_sub(d, forward ? y : x, p);
            if (is_witness(m, chain, p, d))
                return 1;
        }
    }
    return 0;
}

/* A frame in which the chain's portals lie across the axes as far as they can: z along the first one's normal. */
static void choose_frame(const EnfRegionModel *m, const EnfChain *chain, double frame[3][3]) {
    const double *z = m->plane[chain->portals[0]];
    vec_copy(frame[2], z);
    vec_set(frame[0], 0, 0, 0);
    for (int k = 0; k < 3; ++k)
        if (fabs(z[k]) > 1 - 1e-15) { /* an exact change of axes */
            vec_set(frame[2], 0, 0, 0), vec_set(frame[1], 0, 0, 0);
            frame[2][k] = z[k] > 0 ? 1 : -1;
            frame[0][(k + 1) % 3] = 1;
            frame[1][(k + 2) % 3] = frame[2][k];
            return;
        }
    for (uint32_t i = 1; i < chain->count; ++i) {
        const double *n = m->plane[chain->portals[i]];
        if (fabs(vec_dot(n, z)) < ALIGNED) {
            vec_copy(frame[0], n);
            break;
        }
    }
    if (vec_dot(frame[0], frame[0]) == 0) {
        int k = fabs(z[2]) < 0.7 ? 2 : 0;
        frame[0][k] = 1;
    }
    double along = vec_dot(frame[0], z);
    vec_mad(frame[0], frame[0], -along, z);
    (void)vec_normalize(frame[0]);
    vec_cross(frame[1], z, frame[0]);
}

/* The flattest sine at which HIDDEN speaks of a line through the portal: flatter, it squeezes through less than a touch, the
 * portal's least width seen from the side. Rounding turns a portal's plane by no more. */
static double least_sine(const EnfRegionModel *m, uint32_t portal) {
    const double(*v)[3] = (const double(*)[3])(m->outer.vertices + m->outer.first[portal]);
    uint32_t n = enf_rm_count(&m->outer, portal);
    double width = 2 * m->radius[portal];
    for (uint32_t i = 0; i < n; ++i) {
        double e[3], far_off = 0;
        vec_sub(e, v[(i + 1) % n], v[i]);
        if (!(vec_normalize(e) > 0))
            continue;
        for (uint32_t k = 0; k < n; ++k) {
            double r[3], c[3];
            vec_sub(r, v[k], v[i]);
            vec_cross(c, e, r);
            far_off = fmax(far_off, vec_length(c));
        }
        width = fmin(width, far_off);
    }
    return fmax(ENF_HIDDEN_SINE_MIN, fmin(m->touch / width, ENF_CROSSING_SINE_MIN));
}

/* Portals of which two face against each other: the sum of their normals is too short for both sines. */
static int turns_back(const EnfRegionModel *m, const EnfChain *chain) {
    for (uint32_t i = 0; i < chain->count; ++i)
        for (uint32_t k = i + 1; k < chain->count; ++k) {
            const double *a = m->plane[chain->portals[i]], *b = m->plane[chain->portals[k]];
            double sum = fabs(a[0] + b[0]) + fabs(a[1] + b[1]) + fabs(a[2] + b[2]);
            if (sum < 2 * ENF_CROSSING_SINE_MIN && sum < least_sine(m, chain->portals[i] >> 1) + least_sine(m, chain->portals[k] >> 1))
                return 1;
        }
    return 0;
}

/* Rows of the chain's portals in the frame, about `centre`. Directions first: no line in the plane of a portal is ever among
 * the rays, and normals that turn all the way round end the test at once. sine 0: each portal's least_sine. */
static void fill_cone(const EnfRegionModel *m, const EnfChain *chain, const EnfRegionPolygons *polygons, const double frame[3][3],
                      const double centre[3], double sine, EnfStabCone *cone) {
    double along[3], normal[3], span[3];
    uint32_t n = chain->count;
    enf_cone_begin(cone);
    vec_sub(span, m->centre[chain->portals[n - 1] >> 1], m->centre[chain->portals[0] >> 1]);
    if (!(vec_normalize(span) > 1e-6))
        vec_copy(span, m->plane[chain->portals[0]]);
    for (int k = 0; k < 3; ++k)
        along[k] = vec_dot(frame[k], span);
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t r = chain->portals[i];
        int repeated = 0;
        for (uint32_t k = 0; k < i && !repeated; ++k) {
            const double *a = m->plane[chain->portals[k]], *b = m->plane[r];
            repeated = fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2]) < ALIGNED;
        }
        if (repeated)
            continue;
        /* n . d >= sine |d| >= sine |along . d| */
        for (int k = 0; k < 3; ++k) {
            normal[k] = vec_dot(frame[k], m->plane[r]);
            if (fabs(normal[k]) < ALIGNED)
                normal[k] = 0;
        }
        double least = sine > 0 ? sine : least_sine(m, r >> 1);
        for (int sign = -1; sign <= 1; sign += 2) {
            double row[3];
            vec_mad(row, normal, sign * least, along);
            enf_cone_add_direction(cone, row);
        }
    }
    for (uint32_t step = 0; step < n; ++step) {
        /* The two ends first: they make the cone bounded at once. */
        uint32_t i = step == 0 ? 0 : step == 1 ? n - 1 : step - 1;
        uint32_t r = chain->portals[i], first = polygons->first[r >> 1], count = enf_rm_count(polygons, r >> 1);
        double axis[3], corner[2][3], start[3] = {0, 0, 0}, level = 0;
        int across = -1;
        for (int k = 0; k < 3; ++k)
            axis[k] = vec_dot(frame[k], m->plane[r]);
        for (int k = 0; k < 3; ++k)
            if (fabs(axis[(k + 1) % 3]) < ALIGNED && fabs(axis[(k + 2) % 3]) < ALIGNED)
                across = k;
        for (uint32_t c = 0; c <= count; ++c) {
            double q[3], *at = corner[c & 1];
            if (c == count)
                vec_copy(at, start);
            else {
                vec_sub(q, polygons->vertices[first + (r & 1 ? count - 1 - c : c)], centre);
                for (int k = 0; k < 3; ++k)
                    at[k] = vec_dot(frame[k], q);
                if (c == 0 && across >= 0)
                    level = at[across];
                if (across >= 0)
                    at[across] = level;
                if (c == 0)
                    vec_copy(start, at);
            }
            if (c)
                enf_cone_add_edge(cone, corner[!(c & 1)], at);
        }
    }
}

/* The line found in the frame, as point and direction in the model. */
static int line_to_model(const double x[6], const double frame[3][3], const double centre[3], double p[3], double d[3]) {
    double size = vec_dot(x, x), foot[3];
    if (!(size > 0))
        return 0;
    vec_cross(foot, x, x + 3);
    vec_scale(foot, 1 / size, foot);
    for (int k = 0; k < 3; ++k) {
        d[k] = x[0] * frame[0][k] + x[1] * frame[1][k] + x[2] * frame[2][k];
        p[k] = centre[k] + foot[0] * frame[0][k] + foot[1] * frame[1][k] + foot[2] * frame[2][k];
    }
    return vec_normalize(d) > 0;
}

static int run_cone(EnfStabScratch *scratch, EnfRegionVisStats *stats, double line[6]) {
    EnfStabCone *cone = scratch->cone;
    uint64_t signs = cone->signs, unsure = cone->unsure, rays = cone->rays_made;
    int answer = enf_cone_solve(cone, line);
    stats->cone_signs += cone->signs - signs;
    stats->exact_signs += cone->unsure - unsure;
    stats->filter_failures += cone->unsure - unsure;
    stats->cone_rays += cone->rays_made - rays;
    return answer;
}

/* The chain's windows, contracted, into the scratch. HIDDEN: nothing is left; VISIBLE: something; else UNDECIDED. */
static uint32_t contract(const EnfRegionModel *m, const EnfChain *chain, EnfStabScratch *scratch) {
    uint32_t n = chain->count;
    if (!ENF_RESERVE(scratch->windows, n))
        return ENF_CHAIN_UNDECIDED;
    for (uint32_t i = 1; i + 1 < n; ++i)
        if (!enf_window_load(m, chain->portals[i], &scratch->windows[i]))
            return ENF_CHAIN_UNDECIDED;
    enf_window_copy(&scratch->windows[0], chain->source);
    enf_window_copy(&scratch->windows[n - 1], chain->target);
    return enf_chain_contract(m, chain, scratch->windows) ? ENF_CHAIN_VISIBLE : ENF_CHAIN_HIDDEN;
}

int enf_chain_is_shut(const EnfRegionModel *m, const EnfChain *chain, EnfStabScratch *scratch, double p[3], double d[3]) {
    vec_set(p, 0, 0, 0), vec_set(d, 0, 0, 0);
    uint32_t left = chain->count > 1 && chain->source->count && chain->target->count ? contract(m, chain, scratch) : ENF_CHAIN_UNDECIDED;
    if (left == ENF_CHAIN_VISIBLE) {
        centroid(&scratch->windows[0], p), centroid(&scratch->windows[chain->count - 1], d);
        vec_sub(d, d, p);
    }
    return left == ENF_CHAIN_HIDDEN;
}

uint32_t enf_chain_test(const EnfRegionModel *m, const EnfChain *chain, EnfStabScratch *scratch, EnfRegionVisStats *stats, double p[3],
                        double d[3]) {
    double line[6], frame[3][3], centre[3], inner_p[3], inner_d[3];
    int windows = chain->source->count && (!chain->target || chain->target->count);
    if (windows && guess_line(m, chain, chain->source, chain->target, p, d)) {
        ++stats->line_hits;
        return ENF_CHAIN_VISIBLE;
    }
    if (chain->count == 1) { /* a portal too narrow for the clearance */
        if (!windows)
            return ENF_CHAIN_UNDECIDED;
        centroid(chain->source, p);
        vec_copy(d, m->plane[chain->portals[0]]);
        return ENF_CHAIN_GRAZING;
    }
    if (windows) {
        uint32_t left = contract(m, chain, scratch);
        if (left == ENF_CHAIN_HIDDEN)
            return ENF_CHAIN_HIDDEN;
        if (left == ENF_CHAIN_VISIBLE && guess_line(m, chain, &scratch->windows[0], &scratch->windows[chain->count - 1], p, d)) {
            ++stats->line_hits;
            return ENF_CHAIN_VISIBLE;
        }
        if (left == ENF_CHAIN_VISIBLE && !enf_chain_contract_pairs(m, chain, scratch->windows))
            return ENF_CHAIN_HIDDEN;
    }
    if (turns_back(m, chain))
        return ENF_CHAIN_HIDDEN;
    ++stats->cone_tests;
    choose_frame(m, chain, frame);
    vec_add(centre, m->centre[chain->portals[0] >> 1], m->centre[chain->portals[chain->count - 1] >> 1]);
    vec_scale(centre, 0.5, centre);
    fill_cone(m, chain, &m->outer, (const double(*)[3])frame, centre, 0, scratch->cone);
    int outer = run_cone(scratch, stats, line);
    if (outer == ENF_CONE_EMPTY) {
        ++stats->cone_hidden;
        return ENF_CHAIN_HIDDEN;
    }
    /* A line found out of order (cells that aren't convex) shows nothing. */
    int passes = outer == ENF_CONE_STABBED && line_to_model(line, (const double(*)[3])frame, centre, p, d) &&
                 enf_line_clearance(m, p, d, chain->portals, chain->count) > -m->delta;
    if (passes && is_witness(m, chain, p, d)) {
        ++stats->cone_visible;
        return ENF_CHAIN_VISIBLE;
    }
    for (uint32_t i = 0; i < chain->count; ++i)
        if (!enf_rm_count(&m->inner, chain->portals[i] >> 1))
            return passes ? ENF_CHAIN_GRAZING : ENF_CHAIN_UNDECIDED;
    fill_cone(m, chain, &m->inner, (const double(*)[3])frame, centre, 1.01 * ENF_CROSSING_SINE_MIN, scratch->cone);
    if (run_cone(scratch, stats, line) == ENF_CONE_STABBED && line_to_model(line, (const double(*)[3])frame, centre, inner_p, inner_d) &&
        is_witness(m, chain, inner_p, inner_d)) {
        vec_copy(p, inner_p), vec_copy(d, inner_d);
        ++stats->cone_visible;
        return ENF_CHAIN_VISIBLE;
    }
    return passes ? ENF_CHAIN_GRAZING : ENF_CHAIN_UNDECIDED;
}
