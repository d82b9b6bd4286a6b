/* SPDX-License-Identifier: GPL-3.0-or-later
 * Reserves for rounding of separating planes, shafts and boxes; the argument is in ALGORITHMS.md. */
#ifndef ENF_FROM_REGION_SEPARATORS_SLACK_H
#define ENF_FROM_REGION_SEPARATORS_SLACK_H

/* [Model units] A plane counts as separating when the corners of both windows keep to their sides within this: some ten
 * roundings of coordinates below 1. */
#define ENF_ON_PLANE 1e-15

/* [Model units] A plane that is this near to a second corner holds that edge, too. */
#define ENF_SAME_PLANE 1e-14

/* [Model units] Windows nearer to each other than this give no planes: what rounding does to a plane grows with the distance from
 * them over their gap. */
#define ENF_GAP_MIN 1e-6

/* [Model units] Room for the rounding of a shaft's planes and of corners cut. */
#define ENF_SHAFT_SLACK 1e-13

/* [Model units] Room for single precision: eight terms of at most 1, each within 2^-24. */
#define ENF_SINGLE_SLACK 1e-6

#endif
