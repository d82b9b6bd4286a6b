/* SPDX-License-Identifier: GPL-3.0-or-later
 * Screens: cameras turned into projections that the traversal understands.
 *
 * One camera is one screen; a panorama, or cameras that look everywhere, are up to six (the faces of a cube).
 * Several eyes may share a screen: an aperture is then a set of *directions*, and what any eye on the hull of the eyes
 * sees through a portal lies in the hull of the eyes' projections of it (csrc/ALGORITHMS.md, "Several eyes"). */
#ifndef ENF_FROM_POINT_VIEW_SCREEN_H
#define ENF_FROM_POINT_VIEW_SCREEN_H

#include "enfilade/portal_vis.h"
#include "from_point/aperture.h"

#define ENF_EYES_MAX    16
#define ENF_SCREENS_MAX 6

typedef struct EnfScreen {
    int ortho;
    /* Perspective: U, V, W = rows . (p - eye). Orthographic: U, V = rows . (p - eye) + offset, W = 1. */
    double rows[3][3];
    double offset[2];
    /* The direction in which the viewer looks through screen point (u, v): u right + v up + forward. Orthographic: sight
     * lines start at eye + u right + v up + centre and run along forward. */
    double right[3], up[3], forward[3], centre[3];
    double look[3]; /* unit: depth of p is look . (p - eye) */
    double outset;  /* of clip lines, half screens */
    EnfPoly view;   /* the part of the screen that is seen: within [-1, 1] x [-1, 1] */
    double view_rect[4];
} EnfScreen;

typedef struct EnfScreens {
    uint32_t eye_count, screen_count;
    double eyes[ENF_EYES_MAX][3];
    /* Sight starts at the near plane: eyes and corners of the near rectangles; bounds of all of them. */
    double start_points[ENF_EYES_MAX * 5][3];
    uint32_t start_point_count;
    double start_bounds[6];
    uint32_t near_first[ENF_EYES_MAX], near_count; /* first of the four corners of each camera's near rectangle, behind its eye */
    double near_radius;                            /* panoramas: of the ball their rays start on; 0: rectangles. [Units: metres] */
    double start_grown; /* metres by which a walk's widening, or what turns between poses, reaches beyond the points; bounds include it */
    /* Start points of each pose: pose_first[i] .. pose_first[i + 1]; and which hulls of them (and start_grown round these) rays
     * start in besides: none, those of every two consecutive poses, the one of all. */
    uint32_t pose_first[ENF_EYES_MAX + 1];
    enum { ENF_BETWEEN_NONE, ENF_BETWEEN_PAIRS, ENF_BETWEEN_ALL } between;
    double clip_near;             /* of the first camera, along or nearer than along any screen's look. [Units: metres] */
    double far_depth, near_depth; /* [Units: metres] along `look` of each screen; infinite for panoramas */
    /* Walks: what is projected is seen from the eyes' middle (else the first eye); how far they lie from it as `rows` of the one screen
     * measure it. */
    int from_middle;
    double middle[3], spread[3];
    /* From `behind`, which is `lift` deeper in homogeneous depth, the whole view holds what any eye sees. */
    double behind[3], lift;
    EnfScreen screen[ENF_SCREENS_MAX];
} EnfScreens;

/* Walks: eyes on the hull of these instead of the camera's own, with rays that start no farther from them. */
typedef struct EnfWiden {
    double eyes[8][3];
    uint32_t eye_count;
    double near_reach; /* [Units: metres] */
} EnfWiden;

/* all[first .. first + count - 1] as screens that share their eyes. swept: poses between consecutive ones count too; then all
 * are of one type. Errors name the camera by its index in `all`. widen: NULL, or for one perspective camera. */
EnfStatus enf_screens_from_cameras(const EnfCamera *all, uint32_t first, uint32_t count, int swept, const EnfWiden *widen, EnfScreens *out);
/* How far from the eye rays start at most, whichever way the camera is turned. wide: its lens is shown as a cube. [Units: metres] */
double enf_near_reach(const EnfCamera *camera, int wide);
/* Every eye in a box; look may be NULL: all directions. */
EnfStatus enf_screens_from_region(const double bounds[6], const EnfCamera *look, EnfScreens *out);

#endif
