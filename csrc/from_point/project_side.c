/* SPDX-License-Identifier: GPL-3.0-or-later
 * A portal onto the screen as a convex polygon: in front of the eye, partly behind it, for several eyes, orthographic.
 *
 * Safe direction: every way out gives a polygon that contains the portal's picture, or says that the whole aperture passes. */
#include "from_point/project_side.h"
#include "from_point/aperture_planes.h"
#include "from_point/project_corners.h"

#include "geometry/vec3.h"

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

/* Vertices behind the eye or far off the screen: cut to |U|, |V| <= guard W + lift first, so that dividing is harmless. A cut carries
 * the rounding of the longest vertex, magnified by 1 / w: *out_error, half screens, by which the polygon's edges may be off. */
static int project_guarded(double (*h)[3], uint32_t n, double guard, double lift, EnfPoly *out, double *z, double *out_error) {
    double buffer[2][ENF_PORTAL_CORNERS + 8][3], f[ENF_PORTAL_CORNERS + 8], largest = 0;
    memcpy(buffer[0], h, sizeof *h * n);
    int at = 0;
    for (uint32_t i = 0; i < n; i++)
        largest = fmax(largest, fmax(fabs(h[i][2]), fmax(fabs(h[i][0]), fabs(h[i][1]))));
    for (int k = 0; k < 4 && n >= 3; k++) {
        uint32_t inside = 0;
        for (uint32_t i = 0; i < n; i++) {
            double u = buffer[at][i][k >> 1];
            f[i] = guard * buffer[at][i][2] + lift + ((k & 1) ? u : -u);
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
        if (!(w > 2.2e-5 * largest && ENF_PARALLAX_NEAREST * w > lift))
            return ENF_PROJECT_WHOLE;
        *out_error = fmax(*out_error, 4.5e-16 * largest / w);
        out->x[i] = buffer[at][i][0] / w;
        out->y[i] = buffer[at][i][1] / w;
        if (z)
            z[i] = 1 / w;
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

/* From the other side than the middle sees it. */
static void turn_over(EnfDeepPoly *poly) {
    EnfPoly *p = &poly->screen;
    for (uint32_t i = 0, k = p->n - 1; i < k; i++, k--) {
        const double x = p->x[i], y = p->y[i], z = poly->z[i];
        p->x[i] = p->x[k];
        p->y[i] = p->y[k];
        poly->z[i] = poly->z[k];
        p->x[k] = x;
        p->y[k] = y;
        poly->z[k] = z;
    }
}

/* Where the middle sees it edge on, or its surface strays from its plane: an outline that holds it, at no certain depth. */
static int project_vaguely(const EnfScreen *screen, const EnfPortalSide *side, double lift, EnfDeepPoly *poly) {
    double rect[4], nearest, strays = side->slack * sqrt(vec_dot(screen->rows[2], screen->rows[2]));
    nearest = 1 / poly->most - strays;
    if (!(ENF_PARALLAX_NEAREST * nearest > lift))
        return ENF_PROJECT_WHOLE;
    poly->vague = 1;
    poly->most = 1 / nearest;
    poly->least = 1 / (1 / poly->least + strays);
    enf_poly_rect(&poly->screen, rect);
    enf_poly_hull(&poly->screen);
    if (poly->screen.n < 3) {
        enf_poly_from_rect(&poly->screen, rect);
        enf_poly_grow(&poly->screen, 1e-9);
    }
    if (side->slack > 0)
        grow_bent(screen, side, nearest, &poly->screen);
    return ENF_PROJECT_POLYGON;
}

int enf_project_parallax(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, EnfDeepPoly *poly, double *out_error) {
    static const double whole[4] = {-1, -1, 1, 1};
    const EnfScreens *screens = &view->screens;
    const double(*v)[3] = (const double(*)[3])(view->index->vertices + side->vertex_first);
    const uint32_t n = side->vertex_count;
    EnfPoly *out = &poly->screen;
    EnfHomogeneous h;
    int plain = 1;
    *out_error = 0;
    poly->vague = 0;
    if (view->project(v, n, screens->behind, (const double(*)[3])screen->rows, whole, &h, out->x, out->y) & 15)
        return ENF_PROJECT_OUT;
    out->n = n;
    for (uint32_t i = 0; i < n; i++) {
        const double w = h.w[i] -= screens->lift;
        plain &= ENF_PARALLAX_NEAREST * w > screens->lift && fabs(h.u[i]) <= 256 * w && fabs(h.v[i]) <= 256 * w;
        poly->z[i] = 1 / w;
        out->x[i] = h.u[i] * poly->z[i];
        out->y[i] = h.v[i] * poly->z[i];
    }
    if (!plain) {
        double corners[ENF_PORTAL_CORNERS][3];
        for (uint32_t i = 0; i < n; i++) {
            corners[i][0] = h.u[i];
            corners[i][1] = h.v[i];
            corners[i][2] = h.w[i];
        }
        const int kind = side->slack > 0 ? ENF_PROJECT_WHOLE : project_guarded(corners, n, 1, screens->lift, out, poly->z, out_error);
        if (kind != ENF_PROJECT_POLYGON)
            return kind;
    }
    poly->least = INFINITY;
    poly->most = 0;
    for (uint32_t i = 0; i < out->n; i++) {
        poly->least = enf_lesser(poly->least, poly->z[i]);
        poly->most = enf_greater(poly->most, poly->z[i]);
    }
    double before = 0;
    for (int c = 0; c < 3; c++)
        before += side->n[c] * (v[0][c] - screens->middle[c]);
    if (side->slack > 0 || fabs(before) <= view->index->tolerance)
        return project_vaguely(screen, side, screens->lift, poly);
    if (before < 0)
        turn_over(poly);
    return ENF_PROJECT_POLYGON;
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
        return project_guarded(corners, n, 4, 0, out, NULL, out_error);
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
