/* SPDX-License-Identifier: GPL-3.0-or-later
 * Judging what was added. What could make an answer unsafe and can't be erred outward is an ERROR; what is
 * made larger or merely costs is a WARNING; what only tells is INFO. Nothing is mended without a problem that
 * says so. */
#ifndef ENF_SCENE_VALIDATE_H
#define ENF_SCENE_VALIDATE_H

#include "scene/scene_data.h"

/* validate.c: values, indices, enums: whatever would make the later steps fall over. Needs nothing derived.
 */
void enf_validate_values(EnfScene *scene);
/* cell_shape.c: closed, convex, right side out? Cells that aren't, and cells without faces, get the faces of
 * their hull. Needs tolerance and extent. 0: out of memory. */
int enf_shape_cells(EnfScene *scene);
/* portal_shape.c: duplicate corners dropped, planar hull where not convex. 0: out of memory. */
int enf_shape_portals(EnfScene *scene);
/* validate_geometry.c: how portals and cells lie to one another. Needs everything derived but placement. 0:
 * out of memory. */
int enf_validate_geometry(EnfScene *scene);

#endif
