/* SPDX-License-Identifier: GPL-3.0-or-later
 * Writes one interval of a row of a picture. Internal to the core. */
#ifndef ENF_RAYCAST_ROW_FILL_H
#define ENF_RAYCAST_ROW_FILL_H

#include <stdint.h>

/* depth[i] = 1 / (base + slope * i) for i < count, one rounding an operation: the scalar and the SIMD twin give equal bits. */
typedef void (*EnfFillDepth)(float *depth, uint32_t count, float base, float slope);
EnfFillDepth enf_fill_depth(int use_simd);

#endif
