/* SPDX-License-Identifier: GPL-3.0-or-later
 * Families of scenes made by code, of any size: the same ones for tests, benchmarks and the tool's `generate`.
 *
 * A specification is "NAME:NUMBER[,key=value ...]":
 *   office:R      at least R rooms (46 -> 46, 1768 -> 1768): corridors with rooms on both sides, storeys joined by slab
 *                 openings, doors and windows as thick openings (cells of their own), furniture.
 *                 keys: objects=23 (a room), windows=1, doors=0.2 (share of extra doors between neighbours),
 *                 closed=0 (share of closed doors), seed=1, storeys=0 (0: chosen)
 *   grid:N        N x N modules of 4 m without any wall between them. keys: storeys=1, objects=0, size=4
 *   columns:N     the same with a 0.5 m square column at every crossing. keys: objects=0
 *   ring:N        N rooms in a ring round a solid core, full-height doorways
 *   hub:N         a hall with N closets around, a door each: hundreds of portals in one cell. keys: objects=1
 *   enfilade:N    N rooms in a row, doors in line. keys: objects=6
 *   tower:N       N storeys of four rooms round a shaft, holes above each other. keys: windows=0
 *   court:N       N x N rooms in a square round a court, windows on both sides, trees. keys: storeys=4, objects=23, garden=40
 *   town:N        N houses (L, U, T, courts, combs), each turned its own way. keys: objects=10, turned=1, garden=10N
 *   city:N        streets round N x N solid houses, as objects of one cell: nothing but occluders hides anything
 *   facade:N      N storeys of 2N rooms with a window each on a walled yard
 *   brick slits spiral comb screens rings lace star cuts pile litter: hostile ones, see scene_hostile.h. keys: detail
 * Where there are windows: outdoors=1 cuts the outside into cells, 0 leaves it one.
 * occluders=1 anywhere: objects are solid, and some as high as wardrobes.
 * The scene comes back uncommitted. */
#ifndef ENF_TESTS_SCENE_FAMILY_H
#define ENF_TESTS_SCENE_FAMILY_H

#include "enfilade/scene.h"

EnfStatus enf_family_build(const char *spec, EnfScene **out_scene);
/* The documentation above as text for a tool's help. */
const char *enf_family_help(void);

#endif
