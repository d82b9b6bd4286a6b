/* SPDX-License-Identifier: GPL-3.0-or-later
 * Lines found by threads beside each other, and how they are entered. */
#include "base/memory.h"
#include "from_region/bake.h"

int enf_found_lines_add(EnfFoundLines *found, const EnfRegionBake *bake, const uint32_t *slots, const double p[3], const double d[3],
                        const uint32_t *portals, uint32_t count) {
    const EnfRegionModel *m = bake->model;
    uint32_t at = found->store.count;
    uint64_t total = at ? found->ends[at - 1] : 0;
    if (!ENF_RESERVE(found->ends, (uint64_t)at + 1) || !ENF_RESERVE(found->places, total + (uint64_t)count * (count + 1) / 2) ||
        !enf_line_store_add(&found->store, p, d, portals, count))
        return 0;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t from = enf_rm_from(m, portals[i]);
        for (uint32_t k = i; k < count; ++k) {
            const uint32_t *slot = enf_pair_slot(&bake->table, from, m->to[portals[k]]);
            if (!slot)
                continue;
            uint64_t place = (uint64_t)(slot - bake->table.slots);
            if (slots[place] != ENF_SLOT_FOREIGN && !enf_slot_is_visible(slots[place]))
                found->places[total++] = place;
        }
    }
    found->ends[at] = total;
    return 1;
}

int64_t enf_found_line_enter(const EnfFoundLines *found, uint32_t at, EnfRegionBake *bake) {
    const EnfLine *line = &found->store.lines[at];
    int64_t pairs = 0;
    for (uint64_t k = at ? found->ends[at - 1] : 0; k < found->ends[at]; ++k) {
        uint32_t *slot = &bake->table.slots[found->places[k]];
        if (enf_slot_is_visible(*slot))
            continue;
        if (!pairs && !enf_line_store_add(&bake->lines, line->p, line->d, found->store.portals + line->portal_first, line->portal_count))
            return -1;
        enf_pair_set(&bake->table, slot, bake->lines.count); /* index + 1 */
        ++pairs;
    }
    return pairs;
}

void enf_found_lines_clear(EnfFoundLines *found) {
    found->store.count = 0, found->store.portal_total = 0;
}

void enf_found_lines_free(EnfFoundLines *found) {
    enf_line_store_free(&found->store);
    enf_free(found->places), enf_free(found->ends);
}
