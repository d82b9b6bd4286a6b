/* SPDX-License-Identifier: GPL-3.0-or-later
 * The hierarchy over furniture's triangles. */
#include "raycast/furniture.h"

EnfStatus enf_furniture_commit(Furniture *f) {
    f->committed = f->triangle_count;
    return ENF_OK;
}

uint32_t enf_furniture_hit(const Furniture *f, const float origin[3], const float direction[3], int any, float *distance) {
    (void)f;
    (void)origin;
    (void)direction;
    (void)any;
    (void)distance;
    return ENF_NONE;
}
