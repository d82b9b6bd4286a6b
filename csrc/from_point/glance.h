/* SPDX-License-Identifier: GPL-3.0-or-later
 * Windows seen from outdoors: a recess between two upright or level rectangles in parallel planes, and the room behind it. */
#ifndef ENF_FROM_POINT_GLANCE_H
#define ENF_FROM_POINT_GLANCE_H

#include "from_point/aperture_planes.h"

/* One portal side that looks in from outdoors; corner + x u + y v + z n, x and y along the rectangles' sides, z inwards. */
struct EnfGlance {
    double corner[3], u[3], v[3], n[3];
    double outer[2];     /* the outer rectangle: 0 .. outer[0] by 0 .. outer[1], at z = 0 */
    double inner[4];     /* the inner one at z = depth: min x, min y, max x, max y */
    double depth;        /* metres; 0: no recess, the outer portal leads into the room */
    uint32_t recess;     /* cell; ENF_NONE: none */
    uint32_t inner_side; /* of the cell before the room */
    uint32_t room;
    uint32_t door_first, door_count; /* into EnfViewIndex.glance_doors */
    uint32_t views;                  /* EnfAperturePlanes.views: where its axes are the scene's, the normal's alone */
};

/* Another portal of the room behind, in the window's frame, rounded outward. */
struct EnfGlanceDoor {
    float box[6];
    float n[3], d; /* seen from within the room where n . p + d > 0 */
    uint32_t opening;
};

/* What the eye sees through one of them: directions n + a u + b v with min a, min b, max a, max b. */
typedef struct EnfGlimpse {
    double outer[4], inner[4];
    int sees_room;    /* 0: the recess hides it */
    int sees_portals; /* some other portal of the room may be seen */
} EnfGlimpse;

/* Finds the sides that are such windows: index->glances, EnfPortalSide.glance. */
EnfStatus enf_build_glances(EnfViewIndex *index);
/* 0: the eye is too near to the wall to tell. One eye, no orthographic screen. */
int enf_glance(const EnfView *view, const EnfGlance *window, EnfGlimpse *out);
/* The planes of such a view. */
void enf_glimpse_planes(const EnfView *view, const EnfScreen *screen, const EnfGlance *window, const double slopes[4],
                        EnfAperturePlanes *out);
/* The room's part of the screen, counter-clockwise. The window lies wholly on the screen. */
void enf_glimpse_polygon(const EnfScreen *screen, const EnfGlance *window, const double slopes[4], EnfPoly *out);

/* Asks for what enf_glance will read. */
static inline void enf_glance_prefetch(const EnfGlance *window) {
    const char *record = (const char *)window;
    for (uint32_t line = 0; line < sizeof *window; line += 64)
        ENF_PREFETCH(record + line);
}

#endif
