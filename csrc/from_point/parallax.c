/* SPDX-License-Identifier: GPL-3.0-or-later
 * Parallax: apertures as eyes near together see through them. Ours; csrc/ALGORITHMS.md, "Walks", has the proof. */
#include "from_point/parallax.h"
#include "from_point/arrival.h"

#include "geometry/vec3.h"

#include <math.h>
#include <string.h>

/* Bounds of |U - W x| and |V - W y| for rays through the aperture. Their direction is (picture - U z) / (1 - W z) where they enter;
 * too near for that to tell anything, it is one of the view's. */
static void drift_of(const EnfScreens *screens, const EnfAperture *aperture, double drift[2]) {
    const double sure = 1 - screens->spread[2] * aperture->nearness;
    for (int k = 0; k < 2; k++) {
        double most = 1;
        if (aperture->nearness > 0 && sure > 0.25)
            most = enf_lesser(1, (enf_greater(-aperture->rect[k], aperture->rect[2 + k]) + screens->spread[k] * aperture->nearness) / sure +
                                     1e-9);
        drift[k] = (screens->spread[k] + screens->spread[2] * most) * (1 + 1e-12);
    }
}

static EnfDeepLine *deep_of(const EnfView *view, uint32_t aperture) {
    return view->deep + (size_t)aperture * ENF_APERTURE_CORNERS;
}

void enf_parallax_outline(EnfView *view, uint32_t aperture, const double *z) {
    const EnfAperture *a = &view->apertures[aperture];
    const EnfCorner *lines = enf_aperture_lines(view, aperture);
    EnfDeepLine *deep = deep_of(view, aperture);
    double drift[2];
    drift_of(&view->screens, a, drift);
    for (uint32_t i = 0; i < a->count; i++)
        deep[i].z = z ? z[i] : a->nearness;
    for (uint32_t i = 0; i < a->count; i++) {
        const double by = fabs(lines[i].a) * drift[0] + fabs(lines[i].b) * drift[1];
        deep[i].c = lines[i].c;
        deep[i].drift = a->nearness > 0 ? by : -by;
        if (a->nearness == 0)
            continue;
        double least = INFINITY;
        for (uint32_t k = 0; k < a->count; k++)
            least = enf_lesser(least, lines[i].a * lines[k].x + lines[i].b * lines[k].y - by * deep[k].z);
        /* The coordinates' rounding, as for other lines. */
        if (lines[i].a != 0 || lines[i].b != 0)
            deep[i].c = a->outset * (fabs(lines[i].a) + fabs(lines[i].b)) - least;
    }
}

int enf_parallax_holds(const EnfView *view, uint32_t aperture, const EnfPoly *poly, const double *z) {
    return view->cut_deep(poly->x, poly->y, z, poly->n, view->corners + (size_t)aperture * ENF_APERTURE_CORNERS, deep_of(view, aperture),
                          view->apertures[aperture].count) == 0;
}

void enf_parallax_poly(const EnfView *view, uint32_t aperture, EnfDeepPoly *out) {
    const EnfDeepLine *deep = deep_of(view, aperture);
    out->screen.n = out->vague = 0;
    enf_poly_append(&out->screen, view->corners + (size_t)aperture * ENF_APERTURE_CORNERS, view->apertures[aperture].count);
    for (uint32_t i = 0; i < out->screen.n; i++)
        out->z[i] = deep[i].z;
}

int enf_parallax_within(const EnfView *view, uint32_t inner, uint32_t outer) {
    EnfDeepPoly poly;
    enf_parallax_poly(view, inner, &poly);
    return enf_parallax_holds(view, outer, &poly.screen, poly.z);
}

void enf_deep_copy(EnfDeepPoly *to, const EnfDeepPoly *from) {
    const uint32_t n = to->screen.n = from->screen.n;
    to->vague = from->vague;
    to->least = from->least;
    to->most = from->most;
    memcpy(to->screen.x, from->screen.x, sizeof *to->z * n);
    memcpy(to->screen.y, from->screen.y, sizeof *to->z * n);
    memcpy(to->z, from->z, sizeof *to->z * n);
}

static void clip_by(EnfDeepPoly *poly, const EnfCorner *line, const EnfDeepLine *deep) {
    EnfPoly *p = &poly->screen;
    const uint32_t n = p->n;
    double d[ENF_POLY_MAX], x[ENF_POLY_MAX], y[ENF_POLY_MAX], z[ENF_POLY_MAX];
    uint32_t m = 0;
    for (uint32_t i = 0; i < n; i++)
        d[i] = (line->a * p->x[i] + line->b * p->y[i]) + (deep->c - deep->drift * poly->z[i]);
    for (uint32_t i = 0, before = n - 1; i < n; before = i++) {
        if ((d[i] >= 0) != (d[before] >= 0) && m < ENF_POLY_MAX) { /* from the inner end, as in enf_poly_clip */
            const uint32_t in = d[i] >= 0 ? i : before, out = d[i] >= 0 ? before : i;
            const double t = d[in] / (d[in] - d[out]);
            x[m] = p->x[in] + t * (p->x[out] - p->x[in]);
            y[m] = p->y[in] + t * (p->y[out] - p->y[in]);
            z[m++] = poly->z[in] + t * (poly->z[out] - poly->z[in]);
        }
        if (d[i] >= 0 && m < ENF_POLY_MAX) {
            x[m] = p->x[i];
            y[m] = p->y[i];
            z[m++] = poly->z[i];
        }
    }
    p->n = m;
    memcpy(p->x, x, sizeof *x * m);
    memcpy(p->y, y, sizeof *y * m);
    memcpy(poly->z, z, sizeof *z * m);
}

void enf_parallax_clip(const EnfView *view, uint32_t aperture, EnfDeepPoly *poly) {
    const EnfAperture *a = &view->apertures[aperture];
    const EnfCorner *lines = view->corners + (size_t)aperture * ENF_APERTURE_CORNERS;
    const EnfDeepLine *deep = deep_of(view, aperture);
    for (uint32_t i = 0; i < poly->screen.n && poly->vague; i++)
        poly->z[i] = a->nearness > 0 ? poly->least : poly->most; /* where the lines are widest */
    uint32_t cut = view->cut_deep(poly->screen.x, poly->screen.y, poly->z, poly->screen.n, lines, deep, a->count);
    if (cut & ENF_CUT_AWAY)
        poly->screen.n = 0;
    for (uint32_t k = 0; cut && poly->screen.n; k++, cut >>= 1)
        if (cut & 1)
            clip_by(poly, &lines[k], &deep[k]);
    for (uint32_t i = 0; i < poly->screen.n && poly->vague; i++)
        poly->z[i] = poly->most;
}

void enf_parallax_plane(const EnfView *view, const EnfScreen *screen, uint32_t aperture, uint32_t line, double n[3], double *d) {
    const EnfCorner *l = &view->corners[(size_t)aperture * ENF_APERTURE_CORNERS + line];
    const EnfDeepLine *deep = &deep_of(view, aperture)[line];
    double from[3];
    for (int i = 0; i < 3; i++) /* times depth */
        n[i] = l->a * screen->rows[0][i] + l->b * screen->rows[1][i] + deep->c * screen->rows[2][i];
    vec_sub(from, view->screens.eyes[0], view->screens.middle);
    *d = vec_dot(n, from) - deep->drift;
}
