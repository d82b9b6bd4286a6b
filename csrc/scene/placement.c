/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which cells an object is drawn in, when nobody said. */
#include "scene/placement.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/point_location.h"
#include "scene/problems.h"

#include <stdlib.h>

static int compare_indices(const void *left, const void *right) {
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return a < b ? -1 : a > b;
}

/* Whether a box lies wholly beyond one of the cell's faces: then it doesn't touch. (The converse may fail near edges:
 * then the box is placed although it doesn't quite touch, the safe direction.) */
static int box_beyond_face(const EnfScene *scene, uint32_t c, const double box[6]) {
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
        const EnfPlane *plane = &scene->face_planes[f];
        double nearest = -plane->d;
        for (int k = 0; k < 3; k++)
            nearest += plane->n[k] * ((plane->n[k] > 0.0 ? box[k] : box[3 + k]) - scene->origin[k]);
        if (nearest > scene->tolerance)
            return 1;
    }
    return 0;
}

/* A cell without geometry of an exterior room: everything outside. */
static int is_everything_outside(const EnfScene *scene, uint32_t c) {
    uint32_t room = scene->cell_rooms[c];
    return room != ENF_NONE && scene->rooms[room].kind == ENF_ROOM_EXTERIOR &&
           scene->cell_vertex_first[c + 1] == scene->cell_vertex_first[c];
}

/* Whether a cell with faces holds the whole box. No contact margin here: thin cladding on the far side of a thin wall would count as
 * shut in, and be missing from outdoors. */
static int cell_holds_box(const EnfScene *scene, uint32_t c, const double box[6]) {
    if (scene->cell_face_first[c + 1] == scene->cell_face_first[c])
        return 0;
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
        const EnfPlane *plane = &scene->face_planes[f];
        double farthest = -plane->d;
        for (int k = 0; k < 3; k++)
            farthest += plane->n[k] * ((plane->n[k] > 0.0 ? box[3 + k] : box[k]) - scene->origin[k]);
        if (farthest > scene->tolerance)
            return 0;
    }
    return 1;
}

EnfStatus enf_scene_place_objects(EnfScene *scene) {
    uint32_t objects = scene->object_count, cells = scene->cell_count;
    scene->placed_first = ENF_NEW(uint32_t, (uint64_t)objects + 1);
    scene->cell_object_first = ENF_NEW(uint32_t, (uint64_t)cells + 1);
    if (!scene->placed_first || !scene->cell_object_first)
        return enf_fail_memory();
    uint32_t first_outside = cells, last_outside = 0; /* there is one as a rule: a span is enough */
    for (uint32_t c = 0; c < cells; c++)
        if (is_everything_outside(scene, c)) {
            first_outside = first_outside < c ? first_outside : c;
            last_outside = c;
        }
    uint64_t total = 0;
    for (uint32_t o = 0; o < objects; o++) {
        const EnfObjectData *object = &scene->objects[o];
        scene->placed_first[o] = (uint32_t)total;
        uint64_t first = total;
        if (object->cell_count) {
            if (!ENF_RESERVE(scene->placed_cells, total + object->cell_count))
                return enf_fail_memory();
            memcpy(scene->placed_cells + total, scene->object_cells + object->cell_first,
                   object->cell_count * sizeof(uint32_t));
            total += object->cell_count;
        } else {
            EnfBoxWalk walk;
            double box[6];
            uint32_t c;
            memcpy(box, object->bounds, sizeof box);
            box_grow(box, ENF_CONTACT_MARGIN_METRES);
            int enclosed = 0;
            /* Cells without faces too (the hull of an opening's body): their box stands in, the safe direction. */
            for (int graph = 0; graph < 2; graph++) {
                enf_box_walk_begin(&walk, graph ? &scene->locator->hulls : &scene->locator->cells, box);
                while ((c = enf_box_walk_next(&walk)) != ENF_NONE) {
                    if (!box_touches_box(scene->cell_bounds[c], box) || box_beyond_face(scene, c, box))
                        continue;
                    enclosed = enclosed || cell_holds_box(scene, c, object->bounds);
                    if (!ENF_RESERVE(scene->placed_cells, total + 1))
                        return enf_fail_memory();
                    scene->placed_cells[total++] = c;
                }
            }
            /* Walls, roofs and what stands in the garden are drawn outdoors too. Who can't be told to be indoors is (safe
             * direction): an inner wall counts as outdoors, which costs only where a view reaches outdoors. */
            for (c = first_outside; !enclosed && c <= last_outside && c < cells; c++) {
                if (!is_everything_outside(scene, c))
                    continue;
                if (!ENF_RESERVE(scene->placed_cells, total + 1))
                    return enf_fail_memory();
                scene->placed_cells[total++] = c;
            }
        }
        if (total >= ENF_NONE)
            return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: the objects touch too many cells for 32-bit indices", o);
        uint32_t *list = scene->placed_cells + first;
        uint64_t kept = 0, count = total - first;
        if (count > 1)
            qsort(list, (size_t)count, sizeof *list, compare_indices);
        for (uint64_t i = 0; i < count; i++)
            if (i == 0 || list[i] != list[i - 1])
                list[kept++] = list[i];
        total = first + kept;
        for (uint64_t i = 0; i < kept; i++)
            scene->cell_object_first[list[i] + 1]++;
        if (kept == 0) {
            if (!ENF_RESERVE(scene->unplaced_objects, (uint64_t)scene->unplaced_count + 1))
                return enf_fail_memory();
            scene->unplaced_objects[scene->unplaced_count++] = o;
            enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_OBJECT, o, ENF_PROBLEM_OBJECT_UNPLACED, object->bounds,
                            "\"%s\" touches no cell; treated as visible from everywhere", object->name);
        }
    }
    scene->placed_first[objects] = (uint32_t)total;
    /* The other way round, by counting: objects come out ascending in each cell. */
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
