/* SPDX-License-Identifier: GPL-3.0-or-later
 * Text to number and back, the same in every locale, correctly rounded. */
#ifndef ENF_BASE_NUMBER_H
#define ENF_BASE_NUMBER_H

#include <stdint.h>

/* Reads a decimal number (JSON's grammar; a leading '+' and digits beside a lone '.' too) that starts at
 * `at`, never reading at or beyond `end`. Gives where it ends, or NULL when none starts here. Too large
 * becomes infinite. */
const char *enf_number_parse(const char *at, const char *end, double *out);
/* The shortest text that reads back as the same double; room for 32 characters. Finite numbers only. Gives
 * the length. */
int enf_number_format(char out[32], double value);

#endif
