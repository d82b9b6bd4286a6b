/* SPDX-License-Identifier: GPL-3.0-or-later
 * Exact signs for the stabbing cone, in whole numbers of any length: for what the filter can't decide.
 *
 * Rows are whole numbers by construction; a ray is made exact when it is first asked for, from the two rays it came from.
 * A number that outgrows its place (coordinates beyond what the cone allows) sets cone->too_long; signs mean nothing from then on. */
#ifndef ENF_FROM_REGION_STAB_EXACT_H
#define ENF_FROM_REGION_STAB_EXACT_H

#include "from_region/stab_cone.h"

/* The sign of a row at a ray; value and error are set to bounds that agree with it (0, 0 for zero). */
int enf_exact_row_sign(EnfStabCone *cone, uint32_t row, uint32_t ray, double *value, double *error);
/* The sign of side(a, b). */
int enf_exact_side_sign(EnfStabCone *cone, uint32_t a, uint32_t b);
/* Whether side(a, b)^2 > side(a, a) side(b, b). */
int enf_exact_changes_between(EnfStabCone *cone, uint32_t a, uint32_t b);

EnfExactLines *enf_exact_create(void); /* NULL: no memory */
void enf_exact_destroy(EnfExactLines *exact);

#endif
