/* SPDX-License-Identifier: GPL-3.0-or-later
 * Apertures as half-spaces through the eye (or, for several eyes, beside all of them). */
#include "from_point/aperture_planes.h"
#include "from_point/arrival.h"
#include "from_point/parallax.h"

#include <math.h>
#include <string.h>

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The half-space of screen line (a, b, c); for several eyes the most generous of them. d is relative to eye 0. */
void enf_line_plane(const EnfView *view, const EnfScreen *screen, double a, double b, double c, double n[3], double *d) {
    for (int i = 0; i < 3; i++)
        n[i] = a * screen->rows[0][i] + b * screen->rows[1][i] + (screen->ortho ? 0 : c * screen->rows[2][i]);
    *d = screen->ortho ? a * screen->offset[0] + b * screen->offset[1] + c : 0;
    double most = 0;
    for (uint32_t e = 1; e < view->screens.eye_count; e++) {
        double apart[3];
        for (int i = 0; i < 3; i++)
            apart[i] = view->screens.eyes[0][i] - view->screens.eyes[e][i];
        most = fmax(most, dot3(n, apart));
    }
    *d += most;
}

void enf_add_plane(EnfAperturePlanes *planes, const double n[3], double d) {
    if (planes->count == ENF_PLANES_MAX)
        return;
    memcpy(planes->n[planes->count], n, sizeof planes->n[0]);
    planes->d[planes->count++] = d;
}

/* Near and far plane; `spread`: how far the eyes lie apart along the look. Without near clipping it is the
 * eye's own plane: what lies behind the eye, and so near that it touches all the sides, isn't seen. */
void enf_add_depth_planes(const EnfView *view, const EnfScreen *screen, EnfAperturePlanes *planes) {
    double spread_lo = 0, spread_hi = 0, n[3];
    for (uint32_t e = 1; e < view->screens.eye_count; e++) {
        double apart[3];
        for (int i = 0; i < 3; i++)
            apart[i] = view->screens.eyes[e][i] - view->screens.eyes[0][i];
        spread_lo = fmin(spread_lo, dot3(screen->look, apart));
        spread_hi = fmax(spread_hi, dot3(screen->look, apart));
    }
    double near_depth = isfinite(view->screens.near_depth) ? view->screens.near_depth : 0;
    planes->near_plane = planes->count < ENF_PLANES_MAX ? planes->count : ENF_NONE;
    enf_add_plane(planes, screen->look, -near_depth - spread_lo);
    if (isfinite(view->screens.far_depth)) {
        for (int i = 0; i < 3; i++)
            n[i] = -screen->look[i];
        enf_add_plane(planes, n, view->screens.far_depth + spread_hi);
    }
}

void enf_aperture_planes(EnfView *view, const EnfScreen *screen, uint32_t aperture, EnfAperturePlanes *out) {
    const EnfCorner *corners = enf_aperture_lines(view, aperture);
    const uint32_t count = view->apertures[aperture].count;
    out->count = out->direction_count = 0;
    out->views = 7;
    out->aperture = aperture;
    for (uint32_t i = 0; i < count; i++) {
        double n[3], d;
        if (corners[i].a == 0 && corners[i].b == 0)
            continue;
        if (view->apertures[aperture].nearness > 0)
            enf_parallax_plane(view, screen, aperture, i, n, &d);
        else
            enf_line_plane(view, screen, corners[i].a, corners[i].b, corners[i].c, n, &d);
        enf_add_plane(out, n, d);
    }
    enf_add_depth_planes(view, screen, out);
}

void enf_aperture_directions(const EnfView *view, const EnfScreen *screen, EnfAperturePlanes *planes) {
    if (planes->aperture == ENF_NONE)
        return;
    const EnfCorner *corners = view->corners + (size_t)planes->aperture * ENF_APERTURE_CORNERS;
    const uint32_t count = view->apertures[planes->aperture].count;
    planes->direction_count = screen->ortho || view->screens.eye_count > 1 ? 0 : count;
    planes->aperture = ENF_NONE;
    for (uint32_t i = 0; i < planes->direction_count; i++)
        for (int c = 0; c < 3; c++)
            planes->direction[i][c] = corners[i].x * screen->right[c] + corners[i].y * screen->up[c] + screen->forward[c];
}

void enf_planes_drop_near(EnfAperturePlanes *planes) {
    if (planes->near_plane == ENF_NONE)
        return;
    planes->count--;
    for (uint32_t k = planes->near_plane; k < planes->count; k++) {
        memcpy(planes->n[k], planes->n[k + 1], sizeof planes->n[k]);
        planes->d[k] = planes->d[k + 1];
    }
    planes->near_plane = ENF_NONE;
}

void enf_planes_single(const EnfView *view, const EnfAperturePlanes *planes, EnfPlanes *out) {
    const EnfViewIndex *index = view->index;
    double apart[3];
    for (int i = 0; i < 3; i++)
        apart[i] = index->origin[i] - view->screens.eyes[0][i];
    out->count = out->loose = 0;
    for (uint32_t k = 0; k < planes->count; k++) {
        double size = fabs(planes->n[k][0]) + fabs(planes->n[k][1]) + fabs(planes->n[k][2]);
        if (!(size > 1e-30 && size < 1e30)) {
            out->loose = 1; /* out of single precision's range: no constraint */
            continue;
        }
        /* Scaled, so that slivers' tiny lines don't underflow. */
        double scale = 1 / size, n[3] = {planes->n[k][0] * scale, planes->n[k][1] * scale, planes->n[k][2] * scale};
        double d = dot3(n, apart) + planes->d[k] * scale;
        if (fabs(d) < 1e30)
            enf_planes_put(out, n, d, index->reach + fabs(d));
        else
            out->loose = 1;
    }
}
