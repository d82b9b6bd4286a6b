/* SPDX-License-Identifier: GPL-3.0-or-later
 * What commit derives and validates; every function leaves the derived arrays consistent for
 * enf_scene_drop_derived. */
#ifndef ENF_SCENE_COMMIT_H
#define ENF_SCENE_COMMIT_H

#include "scene/scene_data.h"

void enf_scene_drop_derived(EnfScene *scene);
/* All of commit but the objects' places: validates and fills the derived arrays, without marking the scene as committed. On
 * failure they are dropped again. */
EnfStatus enf_scene_derive(EnfScene *scene);

#endif
