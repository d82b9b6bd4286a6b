/* SPDX-License-Identifier: GPL-3.0-or-later
 * Every tolerance of scene building, with its unit, its reason and its safe direction. None is absolute but the last
 * two: lengths scale with the scene's extent (the diagonal of all geometry's bounds), so that a model in millimetres
 * and one in kilometres behave alike. */
#ifndef ENF_GEOMETRY_TOLERANCE_H
#define ENF_GEOMETRY_TOLERANCE_H

#include <float.h>

/* Point location. [Unit: extents] A camera this close to a cell counts as inside: it then starts in both neighbours, which
 * only adds to what is seen. Far above rounding (1e-16), far below a door leaf (1e-4 of a 100 m house is 1 cm). */
#define ENF_TOLERANCE_LOCATE 1e-7

/* Validation. [Unit: extents] Vertices closer than this coincide, corners this far out of a plane are in it. Authoring tools
 * write single precision or six digits: 1e-7 relative. */
#define ENF_TOLERANCE_COINCIDE 1e-7

/* A coordinate far from the origin can't be more exact than its own rounding. [Unit: largest absolute coordinate] A few
 * operations' worth; matters at national grid offsets (1e7 m: 2e-9 m x 16 = 3e-8 m). */
#define ENF_TOLERANCE_COORDINATE (16.0 * DBL_EPSILON)

/* Convex decomposition. [Unit: the room's diagonal] Corners closer than this are one, corners this far out of a face's plane
 * are in it. Single-precision meshes are off by 1e-7 of their coordinates, and a room's diagonal may be a tenth of those;
 * 2e-6 of a 10 m room is 20 micrometres. Cells then deviate from the drawn room by so much, which is far less than objects'
 * contact margin; seams narrower than that are none. */
#define ENF_TOLERANCE_ROOM 2e-6

/* Object placement. [Unit: metres] Drawn surfaces lie on or somewhat beyond a cell's boundary: plaster, skirting boards, door
 * leaves in the wall. An object whose bounds come this close to a cell is drawn in it: more objects, never fewer. */
#define ENF_CONTACT_MARGIN_METRES 0.1

/* Curved walls that bulge into a room. [Unit: metres] Facets of them are taken together where the room grows by no more than
 * this: cells are larger, so nothing seen is lost. Half of the contact margin, so that what is drawn on the wall is in the room
 * still, and thinner than walls are, so that cells don't reach through. */
#define ENF_CURVE_DEPTH_METRES 0.05

/* A cell lies on one side of a portal when its middle is that far from the portal's plane. Below 1, so that a room that
 * overlaps its opening by a twentieth still counts. [Unit: half the cell's depth across the portal] */
#define ENF_ONE_SIDE 0.9

#endif
