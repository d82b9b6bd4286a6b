/* SPDX-License-Identifier: GPL-3.0-or-later
 * Merged windows: a worklist over portals, each with one convex window that holds every window it is reached by.
 *
 * Safe direction: a merged window contains the windows of all chains, so its separating planes hold for all of them; growth
 * goes on to a fixpoint, and a portal that keeps growing is given its whole polygon, the whole source and every target. */
#include "from_region/search_worker.h"

#include <math.h>
#include <stddef.h>

#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

/* Times a portal's windows may grow before they are given up for the whole portal. */
#define GROWTH_MAX 4

/* [Model units] A point counts as inside a merged window this far outside: some roundings, far less than the reserve. */
#define INSIDE 4e-15

typedef struct State {
    uint32_t portal, growths;
    uint8_t queued, whole;
    double key; /* distance of the portal from where the flood starts: nearer ones first, so that windows meet early */
    EnfWindow source, pass;
} State;

typedef struct Edge {
    uint32_t from, to;
} Edge;

struct EnfWindowFlood {
    uint32_t *state_of, *stamp_of, stamp; /* [2 * portals] */
    State *states;
    uint64_t *targets, *led_to; /* [states * words] */
    uint32_t state_count, words;
    Edge *edges;
    uint32_t edge_count;
};

void enf_window_flood_destroy(EnfWindowFlood *flood) {
    if (!flood)
        return;
    enf_free(flood->state_of), enf_free(flood->stamp_of), enf_free(flood->states), enf_free(flood->targets);
    enf_free(flood->led_to), enf_free(flood->edges);
    enf_free(flood);
}

/* Whether `part` lies in `window` (both counter-clockwise about `normal`, in one plane). */
static int holds(const EnfWindow *window, const double normal[3], const EnfWindow *part) {
    for (uint32_t i = 0; i < window->count; ++i) {
        double a[3], b[3], e[3], inward[3];
        enf_window_corner(window, i, a), enf_window_corner(window, i + 1, b);
        vec_sub(e, b, a);
        vec_cross(inward, normal, e);
        double tolerance = INSIDE * vec_length(inward);
        for (uint32_t k = 0; k < part->count; ++k) {
            double r[3];
            enf_window_corner(part, k, r);
            vec_sub(r, r, a);
            if (vec_dot(inward, r) < -tolerance)
                return 0;
        }
    }
    return 1;
}

/* window := hull of both. 0 when it would have too many corners. */
static int merge_window(EnfWindow *window, const double normal[3], const EnfWindow *part) {
    EnfFlatPoint points[2 * ENF_WINDOW_MAX], hull[2 * ENF_WINDOW_MAX + 1];
    double corners[2 * ENF_WINDOW_MAX][3];
    int drop =
        fabs(normal[0]) > fabs(normal[1]) ? (fabs(normal[0]) > fabs(normal[2]) ? 0 : 2) : (fabs(normal[1]) > fabs(normal[2]) ? 1 : 2);
    int x = (drop + 1) % 3, y = (drop + 2) % 3;
    if (normal[drop] < 0) {
        int k = x;
        x = y, y = k;
    }
    uint32_t count = window->count + part->count;
    for (uint32_t i = 0; i < count; ++i) {
        if (i < window->count)
            enf_window_corner(window, i, corners[i]);
        else
            enf_window_corner(part, i - window->count, corners[i]);
        points[i] = (EnfFlatPoint){corners[i][x], corners[i][y], i};
    }
    uint32_t size = enf_flat_hull(points, count, hull);
    if (size < 3 || size > ENF_WINDOW_MAX - 6)
        return 0;
    window->count = size, window->own = ((uint32_t)1 << size) - 1;
    for (uint32_t i = 0; i < size; ++i)
        enf_window_put(window, i, corners[hull[i].index]);
    enf_window_wrap(window);
    return 1;
}

/* Gives up the windows of a portal: everything the flood's start allows. */
static void make_whole(EnfSearchWorker *w, EnfWindowFlood *flood, uint32_t at, const EnfSearchFrame *start) {
    State *s = &flood->states[at];
    s->whole = 1;
    if (!enf_window_load(w->m, s->portal, &s->pass))
        s->pass.count = 0;
    enf_window_copy(&s->source, &w->frames[start->beam]->source);
    uint64_t *targets = flood->targets + (size_t)at * flood->words;
    enf_targets_unpack(w, &start->targets, targets);
    enf_targets_mask(w, s->portal, targets);
}

static EnfWindowFlood *flood_at(EnfSearchWorker *w, uint32_t level) {
    if (level >= w->flood_capacity) {
        if (!ENF_RESERVE(w->floods, (uint64_t)level + 1))
            return NULL;
        while (w->flood_capacity <= level)
            w->floods[w->flood_capacity++] = NULL;
    }
    EnfWindowFlood *flood = w->floods[level];
    if (!flood) {
        flood = ENF_NEW(EnfWindowFlood, 1);
        if (!flood)
            return NULL;
        w->floods[level] = flood;
        flood->state_of = ENF_NEW(uint32_t, 2 * (uint64_t)w->m->portal_count + 1);
        flood->stamp_of = ENF_NEW(uint32_t, 2 * (uint64_t)w->m->portal_count + 1);
        if (!flood->state_of || !flood->stamp_of)
            return NULL;
    }
    ++flood->stamp;
    flood->state_count = 0, flood->edge_count = 0, flood->words = w->words;
    return flood;
}

static int add_state(EnfWindowFlood *flood, uint32_t portal) {
    uint64_t words = ((uint64_t)flood->state_count + 1) * flood->words;
    if (!ENF_RESERVE(flood->states, (uint64_t)flood->state_count + 1) || !ENF_RESERVE(flood->targets, words) ||
        !ENF_RESERVE(flood->led_to, words))
        return 0;
    flood->stamp_of[portal] = flood->stamp, flood->state_of[portal] = flood->state_count;
    memset(&flood->states[flood->state_count], 0, offsetof(State, source));
    flood->states[flood->state_count].portal = portal;
    ++flood->state_count;
    return 1;
}

/* From one portal to the next, the k-th that leaves its cell; grows the next one's windows. Gives 0 when memory runs out. */
static int spread_to(EnfSearchWorker *w, EnfWindowFlood *flood, uint32_t at, uint32_t r, uint32_t k, uint32_t first_portal,
                     const EnfHalfspaces *planes, const EnfTargets *before, EnfTargets *after, uint32_t depth) {
    const EnfRegionModel *m = w->m;
    const EnfSearchFrame *start = w->frames[depth];
    if (!enf_targets_through(w, flood->states[at].portal, k, r, before, after))
        return 1;
    uint64_t cutting;
    if (!m->kernel->touches(planes, m->box[r >> 1], &cutting) || enf_turns_back(w, depth, r))
        return 1;
    int known = flood->stamp_of[r] == flood->stamp;
    EnfWindow source, pass;
    if (known && flood->states[flood->state_of[r]].whole)
        source.count = pass.count = 0;
    else {
        int step = enf_window_step(w, first_portal, flood->states[at].portal, &flood->states[at].source, &flood->states[at].pass, planes,
                                   cutting, r, &source, &pass);
        if (step == ENF_STEP_EMPTY)
            return 1;
        if (step == ENF_STEP_SAME)
            enf_window_copy(&source, &flood->states[at].source);
    }
    if (!known && !add_state(flood, r))
        return 0;
    uint32_t next = flood->state_of[r];
    State *s = &flood->states[next];
    uint64_t *targets = flood->targets + (size_t)next * flood->words;
    int grown = !known;
    if (!known) {
        enf_window_copy(&s->source, &source);
        enf_window_copy(&s->pass, &pass);
        enf_targets_unpack(w, after, targets);
        s->key = vec_distance(m->centre[r >> 1], m->centre[first_portal >> 1]);
    } else if (!s->whole) {
        for (uint32_t i = 0; i < after->count; ++i) {
            grown |= (after->list[i].bits & ~targets[after->list[i].word]) != 0;
            targets[after->list[i].word] |= after->list[i].bits;
        }
        int lost = !source.count || !pass.count || !s->source.count || !s->pass.count;
        if (!lost && !holds(&s->pass, m->plane[r], &pass)) {
            grown = 1;
            lost = !merge_window(&s->pass, m->plane[r], &pass);
        }
        if (!lost && !holds(&s->source, m->plane[first_portal], &source)) {
            grown = 1;
            lost = !merge_window(&s->source, m->plane[first_portal], &source);
        }
        if (lost || (grown && ++s->growths > GROWTH_MAX)) {
            make_whole(w, flood, next, start);
            grown = 1;
        }
    }
    s->queued |= (uint8_t)grown;
    if (!ENF_RESERVE(flood->edges, (uint64_t)flood->edge_count + 1))
        return 0;
    flood->edges[flood->edge_count++] = (Edge){at, next};
    return 1;
}

/* Which targets each portal leads to: backward along the edges, to a fixpoint. */
static void lead_back(EnfSearchWorker *w, EnfWindowFlood *flood) {
    const EnfRegionModel *m = w->m;
    uint32_t words = flood->words;
    memset(flood->led_to, 0, (size_t)flood->state_count * words * sizeof *flood->led_to);
    for (uint32_t i = 0; i < flood->state_count; ++i) {
        uint32_t cell = m->to[flood->states[i].portal], k = w->local[cell >> 6];
        if (k != ENF_NONE && i > 0)
            flood->led_to[(size_t)i * words + k] |= flood->targets[(size_t)i * words + k] & ((uint64_t)1 << (cell & 63)) & w->open[k];
    }
    for (int changed = 1; changed;) {
        changed = 0;
        for (uint32_t e = flood->edge_count; e-- > 0;) {
            uint64_t *to = flood->led_to + (size_t)flood->edges[e].from * words;
            const uint64_t *from = flood->led_to + (size_t)flood->edges[e].to * words;
            const uint64_t *mask = flood->targets + (size_t)flood->edges[e].from * words;
            for (uint32_t k = 0; k < words; ++k) {
                uint64_t more = from[k] & mask[k] & ~to[k];
                if (more)
                    to[k] |= more, changed = 1;
            }
        }
    }
}

EnfWindowFlood *enf_window_flood(EnfSearchWorker *w, uint32_t level, uint32_t depth) {
    EnfSearchFrame *frame = w->frames[depth];
    uint32_t first_portal = w->chain[0], last = w->chain[depth];
    const EnfRegionModel *m = w->m;
    EnfWindowFlood *flood = flood_at(w, level);
    EnfTargets before = {0, ENF_NEW(EnfTargetWord, w->words)}, after = {0, ENF_NEW(EnfTargetWord, w->words)};
    EnfHalfspaces *planes = ENF_NEW(EnfHalfspaces, 1);
    int ok = flood && before.list && after.list && planes && add_state(flood, last);
    if (ok) {
        enf_window_copy(&flood->states[0].source, &w->frames[frame->beam]->source);
        enf_window_copy(&flood->states[0].pass, &frame->pass);
        enf_targets_unpack(w, &frame->targets, flood->targets);
        flood->states[0].queued = 1;
    }
    while (ok) {
        uint32_t at = ENF_NONE;
        for (uint32_t i = 0; i < flood->state_count; ++i)
            if (flood->states[i].queued && (at == ENF_NONE || flood->states[i].key < flood->states[at].key))
                at = i;
        if (at == ENF_NONE)
            break;
        State *s = &flood->states[at];
        s->queued = 0;
        uint32_t portal = s->portal, cell = m->to[portal];
        if (m->dead_end[cell])
            continue;
        enf_window_planes(w, first_portal, portal, &s->source, &s->pass, planes);
        enf_targets_pack(w, portal, flood->targets + (size_t)at * flood->words, &before);
        if (!s->whole) {
            uint32_t left = enf_targets_drop(w, planes, first_portal, portal, &before);
            enf_targets_unpack(w, &before, flood->targets + (size_t)at * flood->words);
            if (!left)
                continue;
        }
        for (uint32_t i = m->out_first[cell]; i < m->out_first[cell + 1] && ok; ++i) {
            uint32_t r = m->out[i], next = m->to[r];
            if (r == enf_rm_reverse(portal))
                continue;
            if (m->convex[next] ? w->on_chain[next] : w->on_chain[m->cell_count + (r >> 1)])
                continue;
            ok = spread_to(w, flood, at, r, i - m->out_first[cell], first_portal, planes, &before, &after, depth);
        }
    }
    if (ok) {
        lead_back(w, flood);
        (void)enf_targets_keep(&frame->targets, flood->led_to);
    }
    enf_free(before.list), enf_free(after.list), enf_free(planes);
    return ok ? flood : NULL;
}

const uint64_t *enf_window_flood_targets(const EnfWindowFlood *flood, uint32_t r) {
    return flood->stamp_of[r] == flood->stamp ? flood->led_to + (size_t)flood->state_of[r] * flood->words : NULL;
}
