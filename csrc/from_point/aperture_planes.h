/* SPDX-License-Identifier: GPL-3.0-or-later
 * Apertures as half-spaces: what boxes of objects, walls and window sets are compared with. */
#ifndef ENF_FROM_POINT_APERTURE_PLANES_H
#define ENF_FROM_POINT_APERTURE_PLANES_H

#include "from_point/view_data.h"

/* An aperture as half-spaces n . (p - eye) + d >= 0 in double, and its corners as directions from the eye. */
typedef struct EnfAperturePlanes {
    uint32_t count;
    uint32_t near_plane; /* which of them is the near plane; ENF_NONE: none */
    double n[ENF_PLANES_MAX][3], d[ENF_PLANES_MAX];
    double direction[ENF_APERTURE_CORNERS + 1][3];
    uint32_t direction_count; /* 0: there is no one eye */
    uint32_t views;           /* bits of the axes along which a box is worth a look (box_cone.h): the planes tell all about the others */
    uint32_t aperture;        /* whose directions enf_aperture_directions is to find yet; ENF_NONE: they are there */
} EnfAperturePlanes;

/* The half-space of screen line (a, b, c); for several eyes the most generous of them. d is relative to eye 0. */
void enf_line_plane(const EnfView *view, const EnfScreen *screen, double a, double b, double c, double n[3], double *d);
void enf_add_plane(EnfAperturePlanes *planes, const double n[3], double d);
/* Near and far plane. */
void enf_add_depth_planes(const EnfView *view, const EnfScreen *screen, EnfAperturePlanes *planes);
/* Sides, near and far of an aperture. */
void enf_aperture_planes(EnfView *view, const EnfScreen *screen, uint32_t aperture, EnfAperturePlanes *out);
/* Finds the directions, unless they are there. */
void enf_aperture_directions(const EnfView *view, const EnfScreen *screen, EnfAperturePlanes *planes);
/* Takes the near plane out: half-spaces for portals instead of for objects. */
void enf_planes_drop_near(EnfAperturePlanes *planes);
/* The same in single precision for blocks of boxes, relative to the index's origin. */
void enf_planes_single(const EnfView *view, const EnfAperturePlanes *planes, EnfPlanes *out);

/* frustum.c: the whole screen's. Without the near plane for cells and portals: the eye's own cell counts as seen. */
void enf_screen_planes(const EnfView *view, const EnfScreen *screen, EnfPlanes *for_objects, EnfPlanes *for_cells);

#endif
