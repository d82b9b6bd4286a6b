/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whether a point lies in the convex hull of others. */
#ifndef ENF_SCENE_HULL_CONTAINS_H
#define ENF_SCENE_HULL_CONTAINS_H

#include <stdint.h>

/* 1: certainly inside (four of the points span a tetrahedron round it); 0: outside, on the boundary, or not
 * decided. point(user, i, out) gives point i. Time linear in count, some ten rounds at most in practice (64
 * by cap). */
int enf_hull_contains(uint32_t count, void (*point)(const void *user, uint32_t i, double out[3]), const void *user, const double at[3]);

#endif
