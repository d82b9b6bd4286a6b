/* SPDX-License-Identifier: GPL-3.0-or-later
 * A portal split among a room's cells, for those who build scenes inside of the core. */
#ifndef ENF_SCENE_PORTAL_JOIN_H
#define ENF_SCENE_PORTAL_JOIN_H

#include "scene/scene_data.h"

/* enf_scene_join of a cell and a room of whose cells only those with geometry take part. */
EnfStatus enf_join_shaped(EnfScene *scene, uint32_t cell, uint32_t room, const double *polygon, uint64_t vertex_count, uint32_t opening,
                          uint32_t *out_first_portal, uint32_t *out_portal_count);

#endif
