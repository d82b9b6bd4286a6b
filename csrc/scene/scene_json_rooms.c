/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rooms and portals of a scene file as people draw them. */
#include "scene/scene_json_rooms.h"
#include "base/memory.h"
#include "base/status.h"
#include "scene/extras.h"

#include <string.h>

/* Says which item of the file failed, before the reason. */
static EnfStatus fail_item(EnfStatus status, const char *word, uint32_t index) {
    char reason[400];
    strncpy(reason, enf_last_error(), sizeof reason - 1);
    reason[sizeof reason - 1] = 0;
    return enf_fail(status, "%s %u: %s", word, index, reason);
}

static EnfStatus build_room(EnfDrawn *d, EnfScene *scene, const EnfDrawnRoom *room) {
    const double *numbers = d->numbers + room->number_first;
    if (room->kind == ENF_DRAWN_PRISM)
        return enf_scene_add_room_prism(scene, room->room, numbers, d->sizes + room->size_first, room->size_count, room->z[0], room->z[1],
                                        NULL, NULL);
    if (room->point_count < 4)
        return enf_fail(ENF_ERROR_BAD_INPUT, "\"mesh\" has %llu vertices, at least 4 are needed", (unsigned long long)room->point_count);
    return enf_scene_add_room_polyhedron(scene, room->room, numbers, room->point_count, 0,
                                         room->size_count ? d->sizes + room->size_first : NULL, room->size_count,
                                         room->size_count ? d->indices + room->index_first : NULL, NULL, NULL);
}

EnfStatus enf_drawn_build(EnfDrawn *d, EnfScene *scene) {
    for (uint64_t i = 0; i < d->room_count; i++) {
        EnfStatus status = build_room(d, scene, &d->rooms[i]);
        if (status != ENF_OK)
            return fail_item(status, "room", d->rooms[i].room);
    }
    if (d->portal_count == 0)
        return ENF_OK;
    for (uint64_t i = 0; i < d->portal_count; i++) {
        const EnfDrawnPortal *portal = &d->portals[i];
        uint32_t first, count;
        if (portal->point_count == 0)
            return enf_fail(ENF_ERROR_BAD_INPUT, "portal %u: 0 vertices, at least 3 are needed", portal->index);
        EnfStatus status = enf_scene_join(scene, portal->kinds[0], portal->sides[0], portal->kinds[1], portal->sides[1],
                                          d->numbers + portal->number_first, portal->point_count, 0, portal->opening, &first, &count);
        if (status != ENF_OK)
            return fail_item(status, "portal", portal->index);
        d->portal_index[portal->index] = first;
    }
    /* They came after all others, so unknown keys follow their portals to the new indices (the first piece of
     * each). */
    enf_extras_renumber(scene->extras, ENF_ITEM_PORTAL, d->portal_index, d->file_portal_count);
    return ENF_OK;
}

void enf_drawn_free(EnfDrawn *d) {
    enf_free(d->numbers);
    enf_free(d->sizes);
    enf_free(d->indices);
    enf_free(d->rooms);
    enf_free(d->portals);
    enf_free(d->portal_index);
    memset(d, 0, sizeof *d);
}
