/* SPDX-License-Identifier: GPL-3.0-or-later
 * Parallax: what many eyes near together see, told by the picture from their middle.
 *
 * Let z be the inverse of a point's depth from the middle, (U, V, W) = rows . (e - middle) for an eye e. A ray from e along direction
 * (x, y, 1) of the screen is seen from the middle at x + (U - W x) z, y + (V - W y) z: straight on in (x, y, z). So a line of the
 * screen that bounds rays where they enter a cell bounds them from there on when it moves outward by |U - W x| for each unit of z
 * that they lose; before any portal, where only their direction is known to lie in the view, for each unit of z they have. Both are
 * half-spaces a x + b y + c - drift z >= 0. */
#ifndef ENF_FROM_POINT_PARALLAX_H
#define ENF_FROM_POINT_PARALLAX_H

#include "from_point/view_data.h"

/* A polygon whose corners have inverse depths; where they are vague all that is known lies between `least` and `most`. */
typedef struct EnfDeepPoly {
    EnfPoly screen;
    double z[ENF_POLY_MAX], least, most;
    int vague;
} EnfDeepPoly;

/* The aperture's lines as half-spaces. z: of its corners; NULL: none is known better than the aperture's nearness. */
void enf_parallax_outline(EnfView *view, uint32_t aperture, const double *z);
/* Whether these points lie in all of them. */
int enf_parallax_holds(const EnfView *view, uint32_t aperture, const EnfPoly *poly, const double *z);
void enf_deep_copy(EnfDeepPoly *to, const EnfDeepPoly *from);
/* The aperture as it was entered. */
void enf_parallax_poly(const EnfView *view, uint32_t aperture, EnfDeepPoly *out);
int enf_parallax_within(const EnfView *view, uint32_t inner, uint32_t outer);
/* What of the portal lies in all of them, behind the aperture's entry; n = 0: nothing. */
void enf_parallax_clip(const EnfView *view, uint32_t aperture, EnfDeepPoly *poly);
/* The half-space of one of its lines: n . (p - eyes[0]) + d >= 0. */
void enf_parallax_plane(const EnfView *view, const EnfScreen *screen, uint32_t aperture, uint32_t line, double n[3], double *d);

#endif
