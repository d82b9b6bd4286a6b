/* SPDX-License-Identifier: GPL-3.0-or-later
 * Facets of walls that bulge into a room (columns, the outer side of a drum), taken together so that they don't shatter it.
 *
 * Each edge between two such facets costs a cut through the room. A chord over several facets lies behind them, in the wall:
 * the room grows by what is between, never more than ENF_CURVE_DEPTH_METRES. The prism over facets and chord is added to the
 * shape: the facets go, the chord and two caps in floor and ceiling come, so the shape stays closed. Only facets of like
 * length count as a curve: a straight wall keeps its direction. Walls that curve round the room are convex and stay as they
 * are. */
#include "scene/curved_walls.h"
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"

#include <stdlib.h>

/* Radians at one edge: an octagon's corner is a curve's, a square's isn't. */
#define MOST_TURN 0.8
/* Radians between the first and the last facet of a chord: a round column keeps four sides. */
#define MOST_BEND 1.58
/* Facets of one curve are about as long as each other. */
#define LIKE 2.5
/* Which ring lies in which is asked of each pair: beyond, prisms stay as they are. */
enum { MOST_RINGS = 2000 };

/* An open chain of corners in plan, the room's air to the left. */
typedef struct Chain {
    double (*xy)[2];
    uint32_t count;
} Chain;

static double edge_length(const double a[2], const double b[2]) {
    return hypot(b[0] - a[0], b[1] - a[1]);
}

/* The turn at b, positive to the right: into the room. */
static double right_turn(const double a[2], const double b[2], const double c[2]) {
    double x0 = b[0] - a[0], y0 = b[1] - a[1], x1 = c[0] - b[0], y1 = c[1] - b[1];
    return -atan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1);
}

/* Whether the corner b is one of a curve that bulges into the room. */
static int is_curve(const double a[2], const double b[2], const double c[2]) {
    double turn = right_turn(a, b, c), first = edge_length(a, b), second = edge_length(b, c);
    return turn > 1e-6 && turn <= MOST_TURN && first <= LIKE * second && second <= LIKE * first;
}

/* How far the corners between i and k stand off the chord; -1 where they bend too much. */
static double chord_depth(const Chain *c, uint32_t i, uint32_t k) {
    double bend = 0.0, depth = 0.0, length = edge_length(c->xy[i], c->xy[k]);
    if (!(length > 0.0))
        return -1.0;
    for (uint32_t m = i + 1; m < k; m++) {
        double x = c->xy[m][0] - c->xy[i][0], y = c->xy[m][1] - c->xy[i][1];
        bend += right_turn(c->xy[m - 1], c->xy[m], c->xy[m + 1]);
        depth = fmax(depth, fabs((c->xy[k][0] - c->xy[i][0]) * y - (c->xy[k][1] - c->xy[i][1]) * x) / length);
    }
    return bend <= MOST_BEND ? depth : -1.0;
}

static int chord_is_good(const Chain *c, uint32_t i, uint32_t k) {
    double depth = chord_depth(c, i, k);
    return depth >= 0.0 && depth <= ENF_CURVE_DEPTH_METRES;
}

/* ends[0 ..]: the corners that stay, of a chain whose inner corners are all of a curve. As few chords as reaching far gives,
 * then as even as that many can be. Gives their number + 1. */
static uint32_t choose_chords(const Chain *c, uint32_t *ends) {
    uint32_t facets = c->count - 1, chords = 0;
    int even = 1;
    ends[0] = 0;
    while (ends[chords] < facets) {
        uint32_t k = ends[chords] + 1;
        while (k < facets && chord_is_good(c, ends[chords], k + 1))
            k++;
        ends[++chords] = k;
    }
    for (uint32_t i = 0; i < chords && even; i++)
        even = chord_is_good(c, (uint32_t)((uint64_t)facets * i / chords), (uint32_t)((uint64_t)facets * (i + 1) / chords));
    for (uint32_t i = 0; i <= chords && even; i++)
        ends[i] = (uint32_t)((uint64_t)facets * i / chords);
    return chords + 1;
}

/* ---- Polyhedra ---- */

/* An upright facet: a quadrilateral a_low, b_low, b_high, a_high, counter-clockwise from outside: the air is left of a -> b. */
typedef struct WallFacet {
    uint32_t low[2], high[2];
    uint32_t face;
    uint32_t next, previous; /* across the edges at b and a where the wall curves on, ENF_NONE else */
} WallFacet;

static int compare_begins(const void *left, const void *right) {
    const WallFacet *a = left, *b = right;
    if (a->low[0] != b->low[0])
        return a->low[0] < b->low[0] ? -1 : 1;
    if (a->high[0] != b->high[0])
        return a->high[0] < b->high[0] ? -1 : 1;
    return a->face < b->face ? -1 : a->face > b->face;
}

static int goes_up(double (*v)[3], uint32_t a, uint32_t b) {
    return v[b][2] - v[a][2] > 0.0 && hypot(v[b][0] - v[a][0], v[b][1] - v[a][1]) <= 1e-6 * (v[b][2] - v[a][2]);
}

static int as_facet(double (*v)[3], const uint32_t *loop, uint32_t face, WallFacet *out) {
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t a = loop[k], b = loop[(k + 1) % 4], c = loop[(k + 2) % 4], d = loop[(k + 3) % 4];
        if (goes_up(v, b, c) && goes_up(v, a, d)) {
            *out = (WallFacet){{a, b}, {d, c}, face, ENF_NONE, ENF_NONE};
            return 1;
        }
    }
    return 0;
}

static void link_facets(double (*v)[3], WallFacet *facets, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        WallFacet key = {{facets[i].low[1], 0}, {facets[i].high[1], 0}, 0, 0, 0};
        uint32_t low = 0, high = count;
        while (low < high) { /* the first one that isn't before the key */
            uint32_t middle = (low + high) / 2;
            if (compare_begins(&facets[middle], &key) < 0)
                low = middle + 1;
            else
                high = middle;
        }
        if (low == count || facets[low].low[0] != key.low[0] || facets[low].high[0] != key.high[0])
            continue;
        int alone = low + 1 == count || facets[low + 1].low[0] != key.low[0] || facets[low + 1].high[0] != key.high[0];
        if (alone && facets[low].previous == ENF_NONE && is_curve(v[facets[i].low[0]], v[facets[i].low[1]], v[facets[low].low[1]])) {
            facets[i].next = low;
            facets[low].previous = i;
        }
    }
}

/* Whether the corners of a cap lie in one plane. */
static int is_flat(double (*v)[3], const uint32_t *loop, uint32_t count, double (*scratch)[3]) {
    double n[3], d, off = 0.0, size = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        vec_sub(scratch[i], v[loop[i]], v[loop[0]]);
        size = fmax(size, vec_length(scratch[i]));
    }
    if (enf_polygon_normal(n, scratch, count) == 0.0)
        return 0;
    for (uint32_t i = 1; i < count; i++) {
        d = vec_dot(n, scratch[i]);
        off = fmax(off, fabs(d));
    }
    return off <= 10.0 * ENF_TOLERANCE_ROOM * size;
}

typedef struct Work {
    EnfStraightened *out;
    double (*vertices)[3];
    WallFacet *facets;
    uint32_t facet_count, index_count;
    unsigned char *gone; /* [faces] */
    uint32_t *row;       /* facets of one curve */
    double (*xy)[2];
    uint32_t *ends, *cap;
    double (*scratch)[3];
} Work;

static int add_face(Work *w, const uint32_t *loop, uint32_t count) {
    EnfStraightened *out = w->out;
    if (!ENF_RESERVE(out->face_sizes, (uint64_t)out->face_count + 1) || !ENF_RESERVE(out->face_indices, (uint64_t)w->index_count + count))
        return 0;
    out->face_sizes[out->face_count++] = count;
    memcpy(out->face_indices + w->index_count, loop, count * sizeof *loop);
    w->index_count += count;
    return 1;
}

/* Replaces row[i .. k-1] by one facet and two caps, unless floor or ceiling aren't flat there. */
static int add_chord(Work *w, const Chain *chain, uint32_t i, uint32_t k) {
    uint32_t n = k - i + 1;
    for (int high = 0; high < 2; high++) {
        for (uint32_t m = 0; m < n; m++) {
            const WallFacet *f = &w->facets[w->row[i + (m < k - i ? m : m - 1)]];
            w->cap[m] = (high ? f->high : f->low)[m == k - i];
        }
        if (!is_flat(w->vertices, w->cap, n, w->scratch))
            return 1;
    }
    const WallFacet *first = &w->facets[w->row[i]], *last = &w->facets[w->row[k - 1]];
    uint32_t wall[4] = {first->low[0], last->low[1], last->high[1], first->high[0]};
    int ok = add_face(w, wall, 4);
    for (uint32_t m = 0; m < n / 2; m++) { /* cap holds the upper corners: from above they run the other way round */
        uint32_t swap = w->cap[m];
        w->cap[m] = w->cap[n - 1 - m];
        w->cap[n - 1 - m] = swap;
    }
    ok = ok && add_face(w, w->cap, n);
    for (uint32_t m = 0; m < n; m++)
        w->cap[m] = w->facets[w->row[i + (m < k - i ? m : m - 1)]].low[m == k - i];
    ok = ok && add_face(w, w->cap, n);
    for (uint32_t m = i; m < k; m++)
        w->gone[w->facets[w->row[m]].face] = 1;
    w->out->facets += k - i;
    w->out->depth = fmax(w->out->depth, chord_depth(chain, i, k));
    return ok;
}

/* One curve, from a facet that nothing curves into, or all round. */
static int straighten_row(Work *w, uint32_t start) {
    uint32_t count = 0;
    for (uint32_t f = start; f != ENF_NONE; f = w->facets[f].next) {
        w->row[count++] = f;
        if (w->facets[f].next == start)
            break;
    }
    for (uint32_t m = 0; m <= count; m++) {
        const double *v = w->vertices[m < count ? w->facets[w->row[m]].low[0] : w->facets[w->row[m - 1]].low[1]];
        w->xy[m][0] = v[0];
        w->xy[m][1] = v[1];
    }
    for (uint32_t m = 0; m < count; m++) { /* not to be started from again */
        w->facets[w->row[m]].next = ENF_NONE;
        w->facets[w->row[m]].previous = 0;
    }
    Chain chain = {w->xy, count + 1};
    uint32_t ends = choose_chords(&chain, w->ends);
    int ok = 1;
    for (uint32_t e = 0; e + 1 < ends && ok; e++)
        if (w->ends[e + 1] - w->ends[e] > 1)
            ok = add_chord(w, &chain, w->ends[e], w->ends[e + 1]);
    return ok;
}

void enf_straightened_free(EnfStraightened *straightened) {
    enf_free(straightened->face_sizes);
    enf_free(straightened->face_indices);
    memset(straightened, 0, sizeof *straightened);
}

int enf_curves_straighten(EnfStraightened *out, double (*vertices)[3], const uint32_t *face_sizes, uint32_t face_count,
                          const uint32_t *face_indices) {
    Work work = {0}, *w = &work;
    memset(out, 0, sizeof *out);
    w->out = out;
    w->vertices = vertices;
    uint64_t at = 0;
    int ok = 1;
    for (uint32_t f = 0; f < face_count && ok; at += face_sizes[f++]) {
        WallFacet facet;
        if (face_sizes[f] != 4 || !as_facet(vertices, face_indices + at, f, &facet))
            continue;
        ok = ENF_RESERVE(w->facets, (uint64_t)w->facet_count + 1);
        if (ok)
            w->facets[w->facet_count++] = facet;
    }
    if (ok && w->facet_count > 1) {
        uint64_t n = (uint64_t)w->facet_count + 1;
        qsort(w->facets, w->facet_count, sizeof *w->facets, compare_begins);
        link_facets(vertices, w->facets, w->facet_count);
        ok = (w->gone = ENF_NEW(unsigned char, face_count)) && (w->row = ENF_NEW(uint32_t, n)) && (w->ends = ENF_NEW(uint32_t, n)) &&
             (w->cap = ENF_NEW(uint32_t, n)) && (w->xy = enf_alloc_array(n, sizeof *w->xy)) &&
             (w->scratch = enf_alloc_array(n, sizeof *w->scratch));
        for (int closed = 0; closed < 2; closed++) /* curves with ends first; what is linked then goes all round */
            for (uint32_t i = 0; i < w->facet_count && ok; i++)
                if (w->facets[i].next != ENF_NONE && (closed || w->facets[i].previous == ENF_NONE))
                    ok = straighten_row(w, i);
    }
    at = 0;
    if (out->facets)
        for (uint32_t f = 0; f < face_count && ok; at += face_sizes[f++])
            if (!w->gone[f])
                ok = add_face(w, face_indices + at, face_sizes[f]);
    enf_free(w->facets);
    enf_free(w->gone);
    enf_free(w->row);
    enf_free(w->xy);
    enf_free(w->ends);
    enf_free(w->cap);
    enf_free(w->scratch);
    if (!ok)
        enf_straightened_free(out);
    return ok;
}

/* ---- Prisms ---- */

static double signed_area(const double (*xy)[2], uint32_t n) {
    double sum = 0.0;
    for (uint32_t i = 0; i < n; i++) {
        const double *p = xy[i], *q = xy[(i + 1) % n];
        sum += (p[0] - xy[0][0]) * (q[1] - xy[0][1]) - (p[1] - xy[0][1]) * (q[0] - xy[0][0]);
    }
    return 0.5 * sum;
}

static int ring_holds(const double (*xy)[2], uint32_t n, const double p[2]) {
    int inside = 0;
    for (uint32_t i = 0, j = n - 1; i < n; j = i++)
        if ((xy[i][1] > p[1]) != (xy[j][1] > p[1]) && p[0] < xy[j][0] + (xy[i][0] - xy[j][0]) * ((p[1] - xy[j][1]) / (xy[i][1] - xy[j][1])))
            inside = !inside;
    return inside;
}

/* stays[i] for the n corners of a ring with the air to its left (xy). Facets replaced. */
static uint32_t thin_ring(double (*xy)[2], uint32_t n, double (*chain)[2], uint32_t *ends, unsigned char *stays, double *depth) {
    uint32_t start = 0, facets = 0;
    memset(stays, 1, n);
    while (start < n && is_curve(xy[(start + n - 1) % n], xy[start], xy[(start + 1) % n]))
        start++; /* a corner where no curve goes through; n: it goes all round */
    start %= n;
    for (uint32_t i = 0; i < n;) {
        uint32_t count = 1; /* facets from corner start + i on that are one curve */
        while (i + count < n && is_curve(xy[(start + i + count - 1) % n], xy[(start + i + count) % n], xy[(start + i + count + 1) % n]))
            count++;
        for (uint32_t m = 0; m <= count; m++)
            memcpy(chain[m], xy[(start + i + m) % n], sizeof *chain);
        Chain c = {chain, count + 1};
        uint32_t kept = choose_chords(&c, ends);
        for (uint32_t e = 0; e + 1 < kept; e++) {
            if (ends[e + 1] - ends[e] < 2)
                continue;
            facets += ends[e + 1] - ends[e];
            *depth = fmax(*depth, chord_depth(&c, ends[e], ends[e + 1]));
            for (uint32_t m = ends[e] + 1; m < ends[e + 1]; m++)
                stays[(start + i + m) % n] = 0;
        }
        i += count;
    }
    return facets;
}

/* Corners of ring r that stay, as thin_ring has them but in the ring's own order. */
static uint32_t judge_ring(const double (*all)[2], const uint32_t *sizes, uint64_t ring_count, uint64_t r, uint64_t begin, double (*xy)[2],
                           double (*chain)[2], uint32_t *ends, unsigned char *stays, double *depth) {
    uint32_t n = sizes[r];
    uint64_t at = 0;
    int hole = 0;
    for (uint64_t q = 0; q < ring_count; at += sizes[q++])
        hole ^= q != r && ring_holds(all + at, sizes[q], all[begin]);
    int turned = (signed_area(all + begin, n) > 0.0) == hole; /* the air has to be on the left */
    for (uint32_t i = 0; i < n; i++)
        memcpy(xy[i], all[begin + (turned ? n - 1 - i : i)], sizeof *xy);
    uint32_t facets = thin_ring(xy, n, chain, ends, stays, depth);
    for (uint32_t i = 0; i < n / 2 && turned; i++) {
        unsigned char swap = stays[i];
        stays[i] = stays[n - 1 - i];
        stays[n - 1 - i] = swap;
    }
    return facets;
}

int64_t enf_rings_straighten(double (*corners)[2], uint32_t *ring_sizes, uint64_t ring_count, double *out_depth) {
    uint64_t total = 0, begin = 0, write = 0;
    int64_t facets = 0;
    *out_depth = 0.0;
    if (ring_count > MOST_RINGS)
        return 0;
    for (uint64_t r = 0; r < ring_count; r++)
        total += ring_sizes[r];
    double(*xy)[2] = enf_alloc_array(total, sizeof *xy), (*chain)[2] = enf_alloc_array(total + 1, sizeof *chain);
    uint32_t *ends = ENF_NEW(uint32_t, total + 1);
    unsigned char *stays = ENF_NEW(unsigned char, total);
    int ok = xy && chain && ends && stays;
    for (uint64_t r = 0; r < ring_count && ok; begin += ring_sizes[r++])
        facets += judge_ring((const double(*)[2])corners, ring_sizes, ring_count, r, begin, xy, chain, ends, stays + begin, out_depth);
    begin = 0;
    for (uint64_t r = 0; r < ring_count && ok; r++) {
        uint32_t given = ring_sizes[r];
        ring_sizes[r] = 0;
        for (uint32_t i = 0; i < given; i++)
            if (stays[begin + i]) {
                memmove(corners[write++], corners[begin + i], sizeof *corners);
                ring_sizes[r]++;
            }
        begin += given;
    }
    enf_free(xy);
    enf_free(chain);
    enf_free(ends);
    enf_free(stays);
    return ok ? facets : -1;
}
