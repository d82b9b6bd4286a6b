/* SPDX-License-Identifier: GPL-3.0-or-later
 * Narrows the windows of one chain against each other, and splits them where that stalls.
 *
 * Each step is a clip by separating planes, so each piece keeps every line of the chain that starts in its part of the first
 * window and ends in its part of the last: when all pieces come out empty, no line passes. As pieces shrink the planes become
 * exact, so a chain hidden by a margin is found hidden after few splits, without the numerics of the cone. */
#include <string.h>

#include "from_region/search_worker.h"
#include "geometry/vec3.h"

/* Sweeps over a chain that narrow a window to less than this share of its area are repeated before splitting. */
#define STALLED 0.7
#define SWEEPS_MAX 4

static double window_area(const EnfWindow *window) {
    double area[3] = {0, 0, 0};
    for (uint32_t i = 1; i + 1 < window->count; ++i) {
        double p[3], q[3], c[3];
        vec_sub(p, window->v[i], window->v[0]);
        vec_sub(q, window->v[i + 1], window->v[0]);
        vec_cross(c, p, q);
        vec_add(area, area, c);
    }
    return vec_length(area);
}

static int clip_all(EnfWindow *window, const double (*planes)[4], uint32_t count) {
    int clipped = 0;
    for (uint32_t i = 0; i < count; ++i)
        if (!enf_window_clip(window, planes[i], &clipped)) return 0;
    return 1;
}

/* One sweep forward and one back. Gives 0 when a window comes out empty. */
static int sweep(const EnfContraction *c, EnfWindow *w) {
    const EnfRegionModel *m = c->model;
    const uint32_t *portals = c->chain->portals;
    uint32_t n = c->chain->count;
    double planes[ENF_SEPARATORS_MAX][4];
    for (uint32_t i = 1; i < n; ++i) {
        const double *first = m->plane[portals[0]], *at = m->plane[portals[i]];
        double front[4] = {first[0], first[1], first[2], first[3] - 1e-14};
        double behind[4] = {-at[0], -at[1], -at[2], -at[3] - 1e-14};
        if (!clip_all(&w[i], (const double(*)[4])front, 1) || !clip_all(&w[0], (const double(*)[4])behind, 1)) return 0;
        if (!enf_window_holds_disc(&w[i], c->reserve) || !enf_window_holds_disc(&w[0], c->reserve)) return 0;
        if (i + 1 < n) {
            uint32_t count = enf_separators(&w[0], first, &w[i], at, planes);
            if (!clip_all(&w[i + 1], (const double(*)[4])planes, count)) return 0;
        }
    }
    for (uint32_t i = n - 1; i-- > 0;) {
        const double *last = m->plane[portals[n - 1]], *at = m->plane[portals[i]];
        double behind[4] = {-last[0], -last[1], -last[2], -last[3] - 1e-14};
        double front[4] = {at[0], at[1], at[2], at[3] - 1e-14};
        if (!clip_all(&w[i], (const double(*)[4])behind, 1) || !clip_all(&w[n - 1], (const double(*)[4])front, 1))
            return 0;
        if (!enf_window_holds_disc(&w[i], c->reserve) || !enf_window_holds_disc(&w[n - 1], c->reserve)) return 0;
        if (i > 0) {
            uint32_t count = enf_separators_back(&w[n - 1], last, &w[i], at, planes);
            if (!clip_all(&w[i - 1], (const double(*)[4])planes, count)) return 0;
        }
    }
    return 1;
}

/* The plane through the middle of the window's longest extent, across it. */
static double longest_extent(const EnfWindow *window, double plane[4]) {
    double best = -1;
    for (uint32_t i = 0; i < window->count; ++i)
        for (uint32_t k = i + 1; k < window->count; ++k) {
            double r[3], middle[3];
            vec_sub(r, window->v[k], window->v[i]);
            double length = vec_dot(r, r);
            if (length <= best) continue;
            best = length;
            vec_add(middle, window->v[k], window->v[i]);
            vec_copy(plane, r);
            (void)vec_normalize(plane);
            plane[3] = 0.5 * vec_dot(plane, middle);
        }
    return best;
}

static uint32_t contract_piece(EnfContraction *c, uint32_t level) {
    uint32_t n = c->chain->count;
    EnfWindow *w = c->windows + (size_t)level * n;
    if (++c->pieces > c->budget || level + 1 >= ENF_CONTRACT_LEVELS) return ENF_CHAIN_UNDECIDED;
    for (int k = 0; k < SWEEPS_MAX; ++k) {
        double before = window_area(&w[0]) * window_area(&w[n - 1]);
        if (!sweep(c, w)) return ENF_CHAIN_HIDDEN;
        if (window_area(&w[0]) * window_area(&w[n - 1]) > STALLED * before) break;
    }
    if (c->try_line(c->context, &w[0], &w[n - 1])) return ENF_CHAIN_VISIBLE;
    double plane[4], other[4];
    uint32_t split = 0;
    if (longest_extent(&w[n - 1], other) > longest_extent(&w[0], plane)) {
        split = n - 1;
        memcpy(plane, other, sizeof plane);
    }
    uint32_t answer = ENF_CHAIN_HIDDEN;
    for (int side = 0; side < 2; ++side) {
        EnfWindow *half = w + n;
        for (uint32_t i = 0; i < n; ++i) enf_window_copy(&half[i], &w[i]);
        /* The halves overlap a little more than rounding and the reserve, so that no line falls between them. */
        double sign = side ? -1 : 1, overlap = 4 * c->reserve;
        double cut[4] = {sign * plane[0], sign * plane[1], sign * plane[2], sign * plane[3] - overlap};
        int clipped = 0;
        if (!enf_window_clip(&half[split], cut, &clipped)) continue;
        uint32_t part = contract_piece(c, level + 1);
        if (part == ENF_CHAIN_VISIBLE) return part;
        if (part == ENF_CHAIN_UNDECIDED) return part; /* the budget is spent */
        if (part != ENF_CHAIN_HIDDEN) answer = part;
    }
    return answer;
}

uint32_t enf_chain_contract(EnfContraction *c) {
    c->pieces = 0;
    return contract_piece(c, 0);
}
