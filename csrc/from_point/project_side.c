/* SPDX-License-Identifier: GPL-3.0-or-later
 * A portal onto the screen as a convex polygon: in front of the eye, partly behind it, for several eyes, orthographic.
 *
 * Safe direction: every way out gives a polygon that contains the portal's picture, or says that the whole aperture passes. */
#include "from_point/project_side.h"
#include "from_point/aperture_planes.h"
#include "from_point/project_corners.h"

#include <math.h>
#include <string.h>

/* Clips a homogeneous polygon by f >= 0, f given per vertex. */
static uint32_t clip_homogeneous(double (*in)[3], const double *f, uint32_t n, double (*out)[3]) {
    uint32_t m = 0;
    for (uint32_t i = 0, before = n - 1; i < n; before = i++) {
        if ((f[i] >= 0) != (f[before] >= 0)) {
            uint32_t a = f[i] >= 0 ? i : before, b = f[i] >= 0 ? before : i;
            double t = f[a] / (f[a] - f[b]);
            for (int c = 0; c < 3; c++)
                out[m][c] = in[a][c] + t * (in[b][c] - in[a][c]);
            m++;
        }
        if (f[i] >= 0) {
            memcpy(out[m], in[i], sizeof out[m]);
            m++;
        }
    }
    return m;
}

/* Vertices behind the eye or far off the screen: cut to |U|, |V| <= 4 W first, so that dividing is harmless. A cut carries
 * the rounding of the longest vertex, magnified by 1 / w: *out_error, half screens, by which the polygon's edges may be off. */
static int project_guarded(double (*h)[3], uint32_t n, EnfPoly *out, double *out_error) {
    double buffer[2][ENF_PORTAL_CORNERS + 8][3], f[ENF_PORTAL_CORNERS + 8], largest = 0;
    memcpy(buffer[0], h, sizeof *h * n);
    int at = 0;
    for (uint32_t i = 0; i < n; i++)
        largest = fmax(largest, fmax(fabs(h[i][2]), fmax(fabs(h[i][0]), fabs(h[i][1]))));
    for (int k = 0; k < 4 && n >= 3; k++) {
        uint32_t inside = 0;
        for (uint32_t i = 0; i < n; i++) {
            double u = buffer[at][i][k >> 1];
            f[i] = 4 * buffer[at][i][2] + ((k & 1) ? u : -u);
            inside += f[i] >= 0;
        }
        if (inside == n)
            continue;
        n = clip_homogeneous(buffer[at], f, n, buffer[1 - at]);
        at = 1 - at;
    }
    if (n < 3)
        return ENF_PROJECT_OUT;
    out->n = n;
    for (uint32_t i = 0; i < n; i++) {
        double w = buffer[at][i][2];
        /* 4 roundings of 1.1e-16. Beyond a fifth of ENF_SLIVER (the eye is within some 2e-5 of the portal's size from it)
         * there is no telling: the whole aperture goes on. */
        if (!(w > 2.2e-5 * largest))
            return ENF_PROJECT_WHOLE;
        *out_error = fmax(*out_error, 4.5e-16 * largest / w);
        out->x[i] = buffer[at][i][0] / w;
        out->y[i] = buffer[at][i][1] / w;
    }
    return ENF_PROJECT_POLYGON;
}

static int project_ortho(const EnfScreen *screen, const EnfPortalSide *side, const double (*v)[3], const double eye[3],
                         const double rect[4], EnfPoly *out) {
    double h[ENF_PORTAL_CORNERS + 8][3], cut[ENF_PORTAL_CORNERS + 8][3], f[ENF_PORTAL_CORNERS + 8];
    uint32_t n = side->vertex_count, behind = 0;
    for (uint32_t i = 0; i < n; i++) {
        double q[3] = {v[i][0] - eye[0], v[i][1] - eye[1], v[i][2] - eye[2]};
        for (int r = 0; r < 3; r++)
            h[i][r] = screen->rows[r][0] * q[0] + screen->rows[r][1] * q[1] + screen->rows[r][2] * q[2];
        h[i][0] += screen->offset[0];
        h[i][1] += screen->offset[1];
        f[i] = h[i][2]; /* sight starts at depth 0 */
        behind += f[i] < 0;
    }
    double(*from)[3] = h;
    if (behind == n)
        return ENF_PROJECT_OUT;
    if (behind) {
        n = clip_homogeneous(h, f, n, cut);
        from = cut;
    }
    if (n < 3)
        return ENF_PROJECT_OUT;
    out->n = n;
    uint32_t codes = 15;
    for (uint32_t i = 0; i < n; i++) {
        double x = out->x[i] = from[i][0], y = out->y[i] = from[i][1];
        codes &= (uint32_t)(x > rect[2]) | (uint32_t)(x < rect[0]) << 1 | (uint32_t)(y > rect[3]) << 2 | (uint32_t)(y < rect[1]) << 3;
    }
    return codes ? ENF_PROJECT_OUT : ENF_PROJECT_POLYGON;
}

/* A portal that isn't flat (far from the origin no slanted one is): where its surface runs between the corners isn't known
 * better than its deviation. Widens the projection by four times that, as the nearest corner (depth `nearest`) shows it. */
static void grow_bent(const EnfScreen *screen, const EnfPortalSide *side, double nearest, EnfPoly *out) {
    double farthest = 0, rect[4];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            farthest = fmax(farthest, fabs(screen->rows[r][c]));
    enf_poly_rect(out, rect);
    double aside = fmax(fmax(fabs(rect[0]), fabs(rect[2])), fmax(fabs(rect[1]), fabs(rect[3])));
    enf_poly_grow(out, 4 * side->slack * 1.7320508076 * farthest * (1 + aside) / nearest);
}

/* What a corner behind some eye leaves unknown is bounded by a rectangle of directions: u <= x holds for a cone of directions
 * exactly when it holds for all its generators p - e. */
static int project_bounds(const EnfScreen *screen, const EnfPortalSide *side, const double (*v)[3], const double (*eyes)[3],
                          uint32_t eye_count, const double rect[4], EnfPoly *out) {
    double lo[2] = {-INFINITY, -INFINITY}, hi[2] = {INFINITY, INFINITY};      /* limits from generators behind */
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY}; /* reach of generators in front */
    for (uint32_t e = 0; e < eye_count; e++)
        for (uint32_t i = 0; i < side->vertex_count; i++) {
            double q[3] = {v[i][0] - eyes[e][0], v[i][1] - eyes[e][1], v[i][2] - eyes[e][2]}, h[3];
            for (int r = 0; r < 3; r++)
                h[r] = screen->rows[r][0] * q[0] + screen->rows[r][1] * q[1] + screen->rows[r][2] * q[2];
            for (int k = 0; k < 2; k++) {
                double ratio = h[k] / h[2];
                if (h[2] > 0) {
                    least[k] = fmin(least[k], ratio);
                    most[k] = fmax(most[k], ratio);
                } else if (h[2] < 0) { /* u <= x requires x <= ratio; u >= x requires x >= ratio */
                    hi[k] = fmin(hi[k], ratio);
                    lo[k] = fmax(lo[k], ratio);
                } else {
                    if (h[k] >= 0)
                        hi[k] = -INFINITY;
                    if (h[k] <= 0)
                        lo[k] = INFINITY;
                }
            }
        }
    /* Bent portals: no measure of how near they are; a millionth of the screen. */
    const double widen = side->slack > 0 ? 1e-6 : 1e-9;
    double box[4];
    for (int k = 0; k < 2; k++) {
        /* A bound that both kinds of generator respect. */
        box[k] = least[k] >= lo[k] ? fmax(rect[k], least[k] - widen) : rect[k];
        box[2 + k] = most[k] <= hi[k] ? fmin(rect[2 + k], most[k] + widen) : rect[2 + k];
        if (box[k] >= box[2 + k])
            return ENF_PROJECT_OUT;
    }
    enf_poly_from_rect(out, box);
    return ENF_PROJECT_POLYGON;
}

/* Several eyes: the hull of their projections. */
static int project_hull(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, const double (*v)[3],
                        const double (*eyes)[3], uint32_t eye_count, const double rect[4], EnfPoly *out) {
    const uint32_t n = side->vertex_count;
    uint32_t codes = 15 | ENF_CORNERS_PLAIN;
    double nearest = INFINITY;
    out->n = 0;
    for (uint32_t e = 0; e < eye_count; e++) {
        EnfHomogeneous h;
        /* Projected in fours: past the corners in use there is room. */
        if (out->n + n + ENF_CORNER_SPARE > ENF_POLY_MAX)
            enf_poly_hull(out);
        if (out->n + n + ENF_CORNER_SPARE > ENF_POLY_MAX)
            return ENF_PROJECT_WHOLE;
        double *x = out->x + out->n, *y = out->y + out->n;
        uint32_t seen = view->project(v, n, eyes[e], (const double(*)[3])screen->rows, rect, &h, x, y);
        codes &= seen;
        if (!(codes & ENF_CORNERS_PLAIN))
            continue;
        for (uint32_t i = 0; i < n && seen != ENF_CORNERS_PLAIN; i++) { /* beside rect for this eye: not divided yet */
            x[i] = h.u[i] / h.w[i];
            y[i] = h.v[i] / h.w[i];
        }
        for (uint32_t i = 0; i < n && side->slack > 0; i++)
            nearest = fmin(nearest, h.w[i]);
        out->n += n;
    }
    if (codes & 15)
        return ENF_PROJECT_OUT;
    if (!(codes & ENF_CORNERS_PLAIN))
        return project_bounds(screen, side, v, eyes, eye_count, rect, out);
    enf_poly_hull(out);
    if (out->n >= 3 && side->slack > 0)
        grow_bent(screen, side, nearest, out);
    return out->n >= 3 ? ENF_PROJECT_POLYGON : ENF_PROJECT_OUT;
}

/* What eyes at most screens.spread from their middle see a corner at: a rectangle. 0: some eye may not have it in front. */
static int corner_box(const EnfHomogeneous *h, uint32_t i, const double spread[3], double box[4]) {
    const double near_w = h->w[i] - spread[2], far_w = h->w[i] + spread[2], at[2] = {h->u[i], h->v[i]};
    if (!(near_w > 1e-3 * far_w))
        return 0;
    for (int k = 0; k < 2; k++) {
        double least = at[k] - spread[k], most = at[k] + spread[k];
        box[k] = least / (least > 0 ? far_w : near_w) - ENF_LINE_OUTSET;
        box[2 + k] = most / (most > 0 ? near_w : far_w) + ENF_LINE_OUTSET;
    }
    return 1;
}

/* The corners where each line meets the next. 0: they don't all, or far out of `around`, or a line lies beyond where its
 * neighbours meet; what the lines bound is another polygon then. */
static int meet_in_turn(const EnfCorner *lines, uint32_t n, const double around[4], EnfPoly *out) {
    const double beyond[2] = {0.1 * (around[2] - around[0]), 0.1 * (around[3] - around[1])};
    if (n > 6)
        return 0;
    for (uint32_t k = 0; k < n; k++) {
        const EnfCorner *p = &lines[k], *q = &lines[k + 1 < n ? k + 1 : 0];
        const double turn = p->a * q->b - q->a * p->b, x = (p->b * q->c - q->b * p->c) / turn, y = (q->a * p->c - p->a * q->c) / turn;
        /* Flatter than a twentieth, rounding moves the corner by more than lines are moved outward. */
        const double sizes = (p->a * p->a + p->b * p->b) * (q->a * q->a + q->b * q->b);
        if (!(turn > 0 && turn * turn > 0.0025 * sizes && x >= around[0] - beyond[0] && x <= around[2] + beyond[0] &&
              y >= around[1] - beyond[1] && y <= around[3] + beyond[1]))
            return 0;
        for (uint32_t i = 0; i < n; i++)
            if (&lines[i] != p && &lines[i] != q && lines[i].a * x + lines[i].b * y + lines[i].c < 0)
                return 0;
        out->x[k] = x;
        out->y[k] = y;
    }
    out->n = n;
    return 1;
}

/* The same for many eyes in a small box, at the cost of one: the picture from their middle, its edges moved outward until every
 * corner's rectangle lies within. Any edges would do: all that is asked of them is to hold the rectangles. */
static int project_spread(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, const double (*v)[3],
                          const double rect[4], EnfPoly *out) {
    const EnfScreens *screens = &view->screens;
    const uint32_t n = side->vertex_count;
    double boxes[ENF_PORTAL_CORNERS + ENF_CORNER_SPARE][4], around[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    EnfHomogeneous h;
    uint32_t codes = view->project(v, n, screens->middle, (const double(*)[3])screen->rows, rect, &h, out->x, out->y);
    if (!(codes & ENF_CORNERS_PLAIN))
        return project_bounds(screen, side, v, (const double(*)[3])screens->eyes, screens->eye_count, rect, out);
    for (uint32_t i = 0; i < n; i++) {
        if (!corner_box(&h, i, screens->spread, boxes[i]))
            return project_bounds(screen, side, v, (const double(*)[3])screens->eyes, screens->eye_count, rect, out);
        for (int k = 0; k < 2; k++) {
            around[k] = enf_lesser(around[k], boxes[i][k]);
            around[2 + k] = enf_greater(around[2 + k], boxes[i][2 + k]);
        }
    }
    if (around[0] > rect[2] || around[2] < rect[0] || around[1] > rect[3] || around[3] < rect[1])
        return ENF_PROJECT_OUT;
    EnfCorner lines[ENF_PORTAL_CORNERS];
    for (uint32_t k = 0; k < n; k++) {
        const uint32_t j = k + 1 < n ? k + 1 : 0;
        const double xk = h.u[k] / h.w[k], yk = h.v[k] / h.w[k], a = yk - h.v[j] / h.w[j], b = h.u[j] / h.w[j] - xk;
        double least = INFINITY;
        for (uint32_t i = 0; i < n; i++)
            least = enf_lesser(least, a * boxes[i][a > 0 ? 0 : 2] + b * boxes[i][b > 0 ? 1 : 3]);
        lines[k] = (EnfCorner){0, 0, a, b, ENF_LINE_OUTSET * (fabs(a) + fabs(b)) - least};
    }
    if (!meet_in_turn(lines, n, around, out)) {
        EnfPoly other, from;
        enf_poly_from_rect(&from, around);
        const EnfPoly *cut = enf_poly_clip(&from, &other, lines, n < 32 ? (1u << n) - 1 : UINT32_MAX);
        out->n = cut->n;
        memcpy(out->x, cut->x, sizeof *cut->x * cut->n);
        memcpy(out->y, cut->y, sizeof *cut->y * cut->n);
    }
    if (side->slack > 0) {
        double nearest = INFINITY;
        for (uint32_t i = 0; i < n; i++)
            nearest = fmin(nearest, h.w[i] - screens->spread[2]);
        grow_bent(screen, side, nearest, out);
    }
    return out->n >= 3 ? ENF_PROJECT_POLYGON : ENF_PROJECT_OUT;
}

int enf_project_side(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, int hull, const double rect[4], EnfPoly *out,
                     double *out_error) {
    *out_error = 0;
    const double(*v)[3] = (const double(*)[3])(view->index->vertices + side->vertex_first);
    const double *eye = view->screens.eyes[0];
    const uint32_t n = side->vertex_count;
    if (screen->ortho) {
        int kind = project_ortho(screen, side, v, eye, rect, out);
        if (kind == ENF_PROJECT_POLYGON && hull)
            enf_poly_hull(out);
        return kind;
    }
    if (view->screens.from_middle)
        return project_spread(view, screen, side, v, rect, out);
    if (view->screens.eye_count > 1)
        return project_hull(view, screen, side, v, (const double(*)[3])view->screens.eyes, view->screens.eye_count, rect, out);
    EnfHomogeneous h;
    uint32_t codes = view->project(v, n, eye, (const double(*)[3])screen->rows, rect, &h, out->x, out->y);
    if (codes & 15)
        return ENF_PROJECT_OUT;
    if (!(codes & ENF_CORNERS_PLAIN)) {
        if (hull) /* a bent portal partly behind the eye: its hull isn't the hull of the clipped corners */
            return project_hull(view, screen, side, v, (const double(*)[3])view->screens.eyes, 1, rect, out);
        double corners[ENF_PORTAL_CORNERS][3];
        for (uint32_t i = 0; i < n; i++) {
            corners[i][0] = h.u[i];
            corners[i][1] = h.v[i];
            corners[i][2] = h.w[i];
        }
        return project_guarded(corners, n, out, out_error);
    }
    out->n = n;
    if (hull)
        enf_poly_hull(out);
    if (side->slack > 0) {
        double nearest = INFINITY;
        for (uint32_t i = 0; i < n; i++)
            nearest = fmin(nearest, h.w[i]);
        grow_bent(screen, side, nearest, out);
    }
    return ENF_PROJECT_POLYGON;
}
