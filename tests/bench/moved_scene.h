/* SPDX-License-Identifier: GPL-3.0-or-later
 * The same scene elsewhere: turned, scaled, moved. For tests of what must not depend on that. */
#ifndef ENF_TESTS_MOVED_SCENE_H
#define ENF_TESTS_MOVED_SCENE_H

#include "enfilade/scene.h"
#include "sight_walker.h"

typedef struct Motion {
    double rotation[3][3], scale, offset[3];
} Motion;

void random_turn(SightRng *rng, double out[3][3]);
/* About the z axis only: floors stay level. */
void random_level_turn(SightRng *rng, double out[3][3]);
void move_point(const Motion *motion, const double p[3], double out[3]);
/* Uncommitted; objects keep their places. The given scene is committed. NULL: a call failed. */
EnfScene *moved_scene(const EnfScene *scene, const Motion *motion);

#endif
