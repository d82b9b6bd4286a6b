/* SPDX-License-Identifier: GPL-3.0-or-later
 * Judging what was added. */
#ifndef ENF_SCENE_VALIDATE_H
#define ENF_SCENE_VALIDATE_H

#include "scene/scene_data.h"

/* Values, indices, enums: whatever would make the later steps fall over. Needs nothing derived. */
void enf_validate_values(EnfScene *scene);

#endif
