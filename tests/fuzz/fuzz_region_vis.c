/* SPDX-License-Identifier: GPL-3.0-or-later
 * Fuzz: rooms in a row with doors on a coarse grid (so that edges line up); what a sightline proves no method may hide. */
#include <stdint.h>
#include <stdlib.h>

#include "enfilade/enfilade.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static EnfRegionVis *bake(const EnfScene *scene, uint32_t method) {
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL;
    def.method = method, def.threads = 1;
    if (enf_region_vis_run(scene, &def, &result) != ENF_OK)
        abort();
    return result;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint32_t doors = (uint32_t)(size / 4), room, cell, portal;
    if (doors < 2)
        return 0;
    if (doors > 8)
        doors = 8;
    EnfScene *scene = NULL;
    if (enf_scene_create(&scene) != ENF_OK)
        return 0;
    enf_scene_add_room(scene, "r", ENF_ROOM_INTERIOR, &room);
    for (uint32_t i = 0; i <= doors; ++i) {
        double box[8][3];
        for (int v = 0; v < 8; ++v)
            box[v][0] = v & 1 ? 40 : -1, box[v][1] = 4.0 * i - 4 + (v & 2 ? 4 : 0), box[v][2] = v & 4 ? 40 : -1;
        enf_scene_add_cell(scene, room, ENF_NONE, box[0], 8, 0, NULL, 0, NULL, &cell);
    }
    for (uint32_t i = 0; i < doors; ++i) {
        const uint8_t *b = data + 4 * i;
        double x0 = b[0] % 16, z0 = b[1] % 16, x1 = x0 + 1 + b[2] % 8, z1 = z0 + 1 + b[3] % 8, y = 4.0 * i;
        double tilt = (b[0] >> 4) * 0.1; /* walls that aren't parallel */
        double q[4][3] = {{x0, y, z0}, {x1, y + tilt, z0}, {x1, y + tilt, z1}, {x0, y, z1}};
        enf_scene_add_portal(scene, i, i + 1, q[0], 4, 0, ENF_NONE, &portal);
    }
    if (enf_scene_commit(scene) == ENF_OK) {
        EnfRegionVis *sample = bake(scene, ENF_REGION_SAMPLE), *flow = bake(scene, ENF_REGION_FLOW), *exact = bake(scene, ENF_REGION_EXACT);
        for (uint32_t i = 0; i <= doors; ++i)
            for (uint32_t k = 0; k <= doors; ++k) {
                uint32_t s, f, e, back;
                enf_region_vis_pair(sample, i, k, &s), enf_region_vis_pair(flow, i, k, &f);
                enf_region_vis_pair(exact, i, k, &e), enf_region_vis_pair(exact, k, i, &back);
                if (e != back)
                    abort();
                if (s == ENF_PAIR_VISIBLE && (e == ENF_PAIR_HIDDEN || f == ENF_PAIR_HIDDEN))
                    abort();
                if (e == ENF_PAIR_VISIBLE && f == ENF_PAIR_HIDDEN)
                    abort();
            }
        enf_region_vis_destroy(sample), enf_region_vis_destroy(flow), enf_region_vis_destroy(exact);
    }
    enf_scene_destroy(scene);
    if (enf_live_bytes() != 0)
        abort();
    return 0;
}
