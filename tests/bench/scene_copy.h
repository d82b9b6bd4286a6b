/* SPDX-License-Identifier: GPL-3.0-or-later
 * The same building elsewhere: turned, scaled, moved. For tests and benchmarks. */
#ifndef ENF_TESTS_SCENE_COPY_H
#define ENF_TESTS_SCENE_COPY_H

#include "enfilade/scene.h"

/* Rooms, openings, cells and portals of a committed scene, each point turned about the upright axis, scaled, then moved. The copy is
 * committed too. */
EnfStatus enf_scene_copy(const EnfScene *scene, double turn, double scale, const double move[3], EnfScene **out_scene);

#endif
