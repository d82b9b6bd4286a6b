/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whether a box touches a cell. */
#ifndef ENF_SCENE_BOX_CONTACT_H
#define ENF_SCENE_BOX_CONTACT_H

#include "scene/scene_data.h"

/* A cell with faces: 0 only when a plane separates them by more than the scene's tolerance. */
int enf_cell_touches_box(const EnfScene *scene, uint32_t c, const double box[6]);
/* A cell with faces: whether it holds the whole box, up to the scene's tolerance. 0 for cells without faces.
 */
int enf_cell_holds_box(const EnfScene *scene, uint32_t c, const double box[6]);
/* A cell without faces: 0 only when the box lies wholly beyond one of its portals. */
int enf_portals_allow_box(const EnfScene *scene, uint32_t c, const double box[6]);

#endif
