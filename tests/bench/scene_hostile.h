/* SPDX-License-Identifier: GPL-3.0-or-later
 * Scenes that make sight fan out; part of scene_family's specifications. */
#ifndef ENF_TESTS_SCENE_HOSTILE_H
#define ENF_TESTS_SCENE_HOSTILE_H

#include "enfilade/scene.h"

/* brick, slits, spiral, comb: n is the size; screens: n halls, `detail` x `detail` holes between them (0: 16); rings: n rings of
 * `detail` sectors (0: 24); lace: n halls, `detail` x `detail` holes of 3 to 16 corners between them (0: 8); star: a hall of n arms
 * of `detail` rooms each (0: 4), two windows between them; cuts: a block in n cells by planes of any slope, no walls; pile: a hall of `detail`
 * cells (0: 1) and n objects that reach through all of them; litter: a room and n objects round it in no cell. Adds to an empty scene;
 * ENF_ERROR_INVALID_ARGUMENT: no such name. */
EnfStatus enf_hostile_build(const char *name, uint32_t n, uint32_t detail, EnfScene *scene);

#endif
