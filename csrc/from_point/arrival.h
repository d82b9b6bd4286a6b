/* SPDX-License-Identifier: GPL-3.0-or-later
 * What arrives in a cell: few apertures that together cover all that ever did. */
#ifndef ENF_FROM_POINT_ARRIVAL_H
#define ENF_FROM_POINT_ARRIVAL_H

#include "from_point/view_data.h"

/* Room for one aperture more, its cell in the queue, and steps: nothing in enf_arrive (one step) can fail. 0: out of memory. */
int enf_arrival_room(EnfView *view, uint32_t steps);
/* "Through `portal` into `cell`, coming from step `parent`". Room is made. */
uint32_t enf_make_step(EnfView *view, uint32_t cell, uint32_t portal, uint32_t parent);
/* An aperture arrives through `side`: `poly`, of this rect and area, its lines `outset` half screens outward. z: inverse depths
 * of its corners, for walks' plans alone (parallax.h). parent: the step through which it came. poly is spoiled. */
void enf_arrive(EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, EnfPoly *poly, const double rect[4], double area,
                double outset, const double *z, uint32_t parent);
/* The whole screen arrives in a cell where sight starts (portal: ENF_NONE), or that is seen whole through this portal: nothing else
 * need arrive there. Room is made. */
void enf_arrive_whole(EnfView *view, const EnfScreen *screen, uint32_t cell, uint32_t portal, uint32_t parent);
/* The corners of an aperture, with their lines. */
const EnfCorner *enf_aperture_lines(EnfView *view, uint32_t aperture);

#endif
