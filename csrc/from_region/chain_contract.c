/* SPDX-License-Identifier: GPL-3.0-or-later
 * Narrows the windows of one chain against each other, forward and back, as long as that pays.
 *
 * Each step is a clip by separating planes, so every line of the chain stays within the windows: when one comes out empty, no
 * line passes. Cheaper than the stabbing cone, and settles nearly all chains it would find empty. */
#include "from_region/search_worker.h"
#include "geometry/vec3.h"

/* A sweep that leaves more than this share of the end windows' areas isn't repeated. */
#define STALLED    0.7
#define SWEEPS_MAX 4

/* Narrowing by all pairs: longer chains aren't asked, for it goes with the cube; and [model units] how far planes are moved out beyond
 * their own reserve. An edge is cut anew some thousand times at most (rounds, planes, windows before), each time within 2e-16. */
#define PAIRS_CHAIN_MAX 64
#define PAIRS_ROUNDS    2
#define PAIRS_SLACK     1e-12

static double window_area(const EnfWindow *window) {
    double area[3] = {0, 0, 0}, first[3];
    enf_window_corner(window, 0, first);
    for (uint32_t i = 1; i + 1 < window->count; ++i) {
        double p[3], q[3], c[3];
        enf_window_corner(window, i, p), enf_window_corner(window, i + 1, q);
        vec_sub(p, p, first);
        vec_sub(q, q, first);
        vec_cross(c, p, q);
        vec_add(area, area, c);
    }
    return vec_length(area);
}

/* Keeps what lies in front of the portal's plane (sign 1) or behind it (-1). */
static int clip_side(const EnfRegionModel *m, EnfWindow *window, const double plane[4], double sign) {
    double side[4] = {sign * plane[0], sign * plane[1], sign * plane[2], sign * plane[3] - m->order_slack};
    int clipped = 0;
    return m->kernel->clip(window, side, &clipped);
}

/* One sweep forward and one back. Gives 0 when a window comes out empty. */
static int sweep(const EnfRegionModel *m, const EnfChain *chain, EnfWindow *w) {
    const uint32_t *portals = chain->portals;
    uint32_t n = chain->count;
    const double *first = m->plane[portals[0]], *last = m->plane[portals[n - 1]];
    EnfHalfspaces planes;
    int clipped = 0;
    for (uint32_t i = 1; i < n; ++i) {
        const double *at = m->plane[portals[i]];
        if (!clip_side(m, &w[i], first, 1) || !clip_side(m, &w[0], at, -1))
            return 0;
        if (i + 1 < n) {
            planes.count = 0;
            if (!m->kernel->clip_all(&w[i + 1], &planes, m->kernel->separators(&w[0], first, &w[i], at, 1, &planes), &clipped))
                return 0;
        }
    }
    for (uint32_t i = n - 1; i-- > 0;) {
        const double *at = m->plane[portals[i]];
        if (!clip_side(m, &w[i], last, -1) || !clip_side(m, &w[n - 1], at, 1))
            return 0;
        if (i > 0) {
            planes.count = 0;
            if (!m->kernel->clip_all(&w[i - 1], &planes, m->kernel->separators(&w[n - 1], last, &w[i], at, -1, &planes), &clipped))
                return 0;
        }
    }
    return 1;
}

/* Clips window i by the planes of windows j and k, which are passed in this order before it (sign 1), or after it, k first (-1). */
static int clip_by_pair(const EnfRegionModel *m, const EnfChain *chain, EnfWindow *w, uint32_t j, uint32_t k, uint32_t i, int sign) {
    EnfHalfspaces planes;
    int clipped = 0;
    planes.count = 0;
    uint64_t which = m->kernel->separators(&w[j], m->plane[chain->portals[j]], &w[k], m->plane[chain->portals[k]], sign, &planes);
    for (uint32_t p = 0; p < planes.count; ++p)
        planes.d[p] -= PAIRS_SLACK;
    return m->kernel->clip_all(&w[i], &planes, which, &clipped);
}

int enf_chain_contract_pairs(const EnfRegionModel *m, const EnfChain *chain, EnfWindow *w) {
    uint32_t n = chain->count;
    if (n > PAIRS_CHAIN_MAX)
        return 1;
    for (uint32_t i = 0; i < n; ++i)
        if (!enf_window_load(m, chain->portals[i], &w[i]))
            return 1;
    for (int round = 0; round < PAIRS_ROUNDS; ++round) {
        for (uint32_t i = 2; i < n; ++i)
            for (uint32_t j = 0; j + 1 < i; ++j)
                if (!clip_by_pair(m, chain, w, j, i - 1, i, 1))
                    return 0;
        for (uint32_t i = n - 2; i-- > 0;)
            for (uint32_t j = n - 1; j > i + 1; --j)
                if (!clip_by_pair(m, chain, w, j, i + 1, i, -1))
                    return 0;
    }
    return 1;
}

int enf_chain_contract(const EnfRegionModel *m, const EnfChain *chain, EnfWindow *windows) {
    EnfWindow *last = &windows[chain->count - 1];
    double area = window_area(&windows[0]) * window_area(last);
    for (int k = 0; k < SWEEPS_MAX; ++k) {
        double before = area;
        if (!sweep(m, chain, windows))
            return 0;
        area = window_area(&windows[0]) * window_area(last);
        if (area > STALLED * before)
            break;
    }
    return 1;
}
