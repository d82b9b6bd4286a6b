/* SPDX-License-Identifier: GPL-3.0-or-later
 * The part of the scene that a bake of some rows looks at: around the cells asked for, wider where what they might see reaches its rim.
 *
 * A bake starts with a small part. Where floods from the cells asked for come to its rim, it is widened there and the model made
 * again. Each part is half as large again as the one before, so all together cost three times what the last does. */
#include "base/memory.h"
#include "from_region/bake.h"

/* [Portals] How far a part reaches at least around the cells asked for: what a room of an office might see lies within four (its door's
 * cell, the corridor, another door's cell, another room). And beyond each cell reached at the rim. */
#define FIRST_STEPS 4
#define MORE_STEPS  2

enum { OUTSIDE = 0, INSIDE = 1, REACHED = 2 };

EnfStatus enf_bake_part_begin(EnfBakePart *part, const EnfScene *scene, const uint32_t *cells, uint32_t count) {
    part->inside = ENF_NEW(uint8_t, (uint64_t)scene->cell_count + 1);
    if (!part->inside)
        return enf_fail_memory();
    for (uint32_t i = 0; i < count; ++i)
        enf_bake_part_reach(part, cells[i]);
    return enf_bake_part_widen(part, scene);
}

void enf_bake_part_reach(EnfBakePart *part, uint32_t cell) {
    part->inside[cell] = REACHED;
}

EnfStatus enf_bake_part_widen(EnfBakePart *part, const EnfScene *scene) {
    uint32_t n = scene->cell_count, *list = ENF_NEW(uint32_t, (uint64_t)n + 1), count = 0, at = 0, before = 0;
    uint8_t *inside = part->inside;
    if (!list)
        return enf_fail_memory();
    for (uint32_t c = 0; c < n; ++c) {
        before += inside[c] == INSIDE;
        if (inside[c] == REACHED)
            inside[c] = INSIDE, list[count++] = c;
    }
    uint32_t steps = before ? MORE_STEPS : FIRST_STEPS;
    for (uint32_t step = 0; at < count && (step < steps || count < before / 2); ++step)
        for (uint32_t end = count; at < end; ++at)
            for (uint32_t k = scene->cell_portal_first[list[at]]; k < scene->cell_portal_first[list[at] + 1]; ++k) {
                uint32_t c = scene->cell_portals[k].to;
                if (inside[c] == OUTSIDE)
                    inside[c] = INSIDE, list[count++] = c;
            }
    enf_free(list);
    if (before + count > n / 2) /* hardly cheaper than the whole, and may have to be made again */
        enf_bake_part_free(part);
    return ENF_OK;
}

void enf_bake_part_free(EnfBakePart *part) {
    enf_free(part->inside);
    part->inside = NULL;
}
