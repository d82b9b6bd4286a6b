/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells an object is drawn in, when nobody said. */
#include "scene/placement.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/sort_keys.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/box_contact.h"
#include "scene/exterior.h"
#include "scene/point_location.h"
#include "scene/problems.h"

#include <stdlib.h>

/* A cell without geometry of an exterior room: everything outside. */
static int is_everything_outside(const EnfScene *scene, uint32_t c) {
    return enf_is_exterior(scene, c) && scene->cell_vertex_first[c + 1] == scene->cell_vertex_first[c];
}

/* Testing every graph cell against every object has an end: then such objects count as unplaced, visible from
 * everywhere. */
#define MOST_GRAPH_TESTS 2e9

typedef struct Placer {
    EnfScene *scene;
    uint64_t total;                       /* entries of placed_cells */
    uint32_t first_outside, last_outside; /* there is one as a rule: a span is enough */
    uint32_t graph_count;                 /* cells without faces, the exterior's apart */
    int give_up;                          /* too many of them to test */
} Placer;

static int put(Placer *p, uint32_t c) {
    if (!ENF_RESERVE(p->scene->placed_cells, p->total + 1))
        return 0;
    p->scene->placed_cells[p->total++] = c;
    return 1;
}

/* What reaches from one side of a room to the other may be its walls themselves, drawn without a thickness: a sheet, a whole shell. These
 * are seen from the other side too. */
static int may_be_wall(const EnfScene *scene, uint32_t c, const double bounds[6]) {
    const double *cell = scene->cell_bounds[c];
    for (int k = 0; k < 3 && scene->cell_openings[c] == ENF_NONE; k++)
        if (bounds[k] <= cell[k] + ENF_CONTACT_MARGIN_METRES && bounds[3 + k] >= cell[3 + k] - ENF_CONTACT_MARGIN_METRES)
            return 1;
    return 0;
}

/* 0: out of memory. */
static int place_by_bounds(Placer *p, const EnfObjectData *object) {
    EnfScene *scene = p->scene;
    EnfBoxWalk walk;
    double box[6];
    uint32_t c;
    uint64_t first = p->total;
    int enclosed = 0;
    memcpy(box, object->bounds, sizeof box);
    box_grow(box, ENF_CONTACT_MARGIN_METRES);
    enf_box_walk_begin(&walk, &scene->locator->cells, box);
    while ((c = enf_box_walk_next(&walk)) != ENF_NONE) {
        if (!enf_cell_touches_box(scene, c, box))
            continue;
        /* No contact margin for being shut in: thin cladding on the far side of a thin wall would count as
         * shut in, and be missing from outdoors. */
        enclosed = enclosed || (enf_cell_holds_box(scene, c, object->bounds) && !may_be_wall(scene, c, object->bounds));
        if (!put(p, c))
            return 0;
    }
    /* Cells without geometry may reach farther than their portals: only a portal's plane excludes them. */
    if (p->give_up && !enclosed) {
        p->total = first;
        return 1;
    }
    for (uint32_t i = 0; p->graph_count && !enclosed && i < scene->locator->graph_count; i++) {
        c = scene->locator->graph_cells[i];
        if (!is_everything_outside(scene, c) && enf_portals_allow_box(scene, c, box) && !put(p, c))
            return 0;
    }
    /* Walls, roofs and what stands in the garden are drawn outdoors too. Who can't be told to be indoors is
     * (safe direction): an inner wall counts as outdoors, which costs only where a view reaches outdoors. */
    for (c = p->first_outside; !enclosed && c <= p->last_outside && c < scene->cell_count; c++)
        if (is_everything_outside(scene, c) && (c != scene->hub || enf_hub_touches(scene, box)) && !put(p, c))
            return 0;
    return 1;
}

/* An object that was said to be in the hub is outdoors: wherever it touches that. */
static int place_outdoors(Placer *p, const EnfObjectData *object) {
    EnfScene *scene = p->scene;
    double box[6];
    uint32_t c;
    EnfBoxWalk walk;
    memcpy(box, object->bounds, sizeof box);
    box_grow(box, ENF_CONTACT_MARGIN_METRES);
    enf_box_walk_begin(&walk, &scene->locator->cells, box);
    while ((c = enf_box_walk_next(&walk)) != ENF_NONE)
        if (enf_is_exterior(scene, c) && enf_cell_touches_box(scene, c, box) && !put(p, c))
            return 0;
    return 1;
}

/* What stands in an opening's own cell is drawn in the cells at its ends too: before a closed door one looks
 * into the recess, at the leaf, though no sight enters the cell. Whatever the state is now: doors change
 * without a commit. */
static int place_at_the_ends(EnfScene *scene, uint64_t first, uint64_t *total) {
    uint64_t end = *total;
    for (uint64_t i = first; i < end; i++) {
        uint32_t c = scene->placed_cells[i];
        if (c >= scene->cell_count || scene->cell_openings[c] == ENF_NONE)
            continue;
        for (uint32_t k = scene->cell_portal_first[c]; k < scene->cell_portal_first[c + 1]; k++) {
            if (!ENF_RESERVE(scene->placed_cells, *total + 1))
                return 0;
            scene->placed_cells[(*total)++] = scene->cell_portals[k].to;
        }
    }
    return 1;
}

/* The cells one object is drawn in, ascending, each once. */
static EnfStatus place(Placer *p, uint32_t o) {
    EnfScene *scene = p->scene;
    const EnfObjectData *object = &scene->objects[o];
    uint64_t first = p->total;
    if (object->cell_count) {
        if (!ENF_RESERVE(scene->placed_cells, p->total + object->cell_count))
            return enf_fail_memory();
        memcpy(scene->placed_cells + p->total, scene->object_cells + object->cell_first, object->cell_count * sizeof(uint32_t));
        p->total += object->cell_count;
        for (uint32_t i = 0; i < object->cell_count && scene->hub != ENF_NONE; i++)
            if (scene->object_cells[object->cell_first + i] == scene->hub && !place_outdoors(p, object))
                return enf_fail_memory();
    } else if (!place_by_bounds(p, object))
        return enf_fail_memory();
    if (!place_at_the_ends(scene, first, &p->total))
        return enf_fail_memory();
    if (p->total >= ENF_NONE)
        return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: the objects touch too many cells for 32-bit indices", o);
    uint32_t *list = scene->placed_cells + first;
    uint64_t kept = 0, count = p->total - first;
    if (count > 1)
        qsort(list, (size_t)count, sizeof *list, compare_indices);
    for (uint64_t i = 0; i < count; i++)
        if (i == 0 || list[i] != list[i - 1])
            list[kept++] = list[i];
    p->total = first + kept;
    if (kept > 0)
        return ENF_OK;
    if (!ENF_RESERVE(scene->unplaced_objects, (uint64_t)scene->unplaced_count + 1))
        return enf_fail_memory();
    scene->unplaced_objects[scene->unplaced_count++] = o;
    enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_OBJECT, o, ENF_PROBLEM_OBJECT_UNPLACED, object->bounds,
                    "\"%s\" touches no cell; treated as visible from everywhere", object->name);
    return ENF_OK;
}

/* The other way round, by counting: objects come out ascending in each cell. */
static EnfStatus list_by_cell(EnfScene *scene) {
    uint32_t objects = scene->object_count, cells = scene->cell_count, total = scene->placed_first[objects];
    for (uint32_t i = 0; i < total; i++)
        scene->cell_object_first[scene->placed_cells[i] + 1]++;
    for (uint32_t c = 0; c < cells; c++)
        scene->cell_object_first[c + 1] += scene->cell_object_first[c];
    scene->cell_object_list = ENF_NEW(uint32_t, total);
    uint32_t *next = ENF_NEW(uint32_t, cells);
    if (!scene->cell_object_list || !next) {
        enf_free(next);
        return enf_fail_memory();
    }
    memcpy(next, scene->cell_object_first, cells * sizeof *next);
    for (uint32_t o = 0; o < objects; o++)
        for (uint32_t i = scene->placed_first[o]; i < scene->placed_first[o + 1]; i++)
            scene->cell_object_list[next[scene->placed_cells[i]]++] = o;
    enf_free(next);
    return ENF_OK;
}

EnfStatus enf_scene_place_objects(EnfScene *scene) {
    uint32_t objects = scene->object_count, cells = scene->cell_count;
    scene->placed_first = ENF_NEW(uint32_t, (uint64_t)objects + 1);
    scene->cell_object_first = ENF_NEW(uint32_t, (uint64_t)cells + 1);
    if (!scene->placed_first || !scene->cell_object_first || !ENF_RESERVE(scene->placed_cells, 1))
        return enf_fail_memory();
    Placer placer = {scene, 0, cells, 0, scene->locator->graph_count, 0}, *p = &placer;
    for (uint32_t c = 0; c < cells; c++)
        if (is_everything_outside(scene, c)) {
            p->first_outside = p->first_outside < c ? p->first_outside : c;
            p->last_outside = c;
            p->graph_count--;
        }
    p->give_up = (double)p->graph_count * objects > MOST_GRAPH_TESTS;
    for (uint32_t o = 0; o < objects; o++) {
        scene->placed_first[o] = (uint32_t)p->total;
        EnfStatus status = place(p, o);
        if (status != ENF_OK)
            return status;
    }
    scene->placed_first[objects] = (uint32_t)p->total;
    return list_by_cell(scene);
}
