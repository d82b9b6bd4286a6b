/* SPDX-License-Identifier: GPL-3.0-or-later
 * The outdoors cut into convex cells round the building: what one facade hides of another is then known.
 * Based on: Johansson & Roupe 2009, section 4.3 (portals seen from outside); the partition is solid_bsp.c's.
 *
 * The exterior's one cell stays, and its index: it becomes the hub, all that lies outside of a box round everything.
 * What of the box isn't building becomes cells of the same room; openings that led to the hub lead to these. */
#include "base/memory.h"
#include "base/status.h"
#include "base/timer.h"
#include "geometry/vec3.h"
#include "scene/commit.h"
#include "scene/exterior.h"
#include "scene/portal_join.h"
#include "scene/problems.h"

#include <stdlib.h>

EnfExteriorDef enf_default_exterior_def(void) {
    EnfExteriorDef def;
    memset(&def, 0, sizeof def);
    def.struct_size = sizeof def;
    def.max_cells = 4096;
    def.wall_gap = def.slab_gap = -1.0;
    return def;
}

/* ---- How thick walls are ----------------------------------------------------------------------------------------- */
static int compare_doubles(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return a < b ? -1 : a > b;
}

/* Nearly the thickest: one in twenty may be drawn deeper than its wall; and none that is thrice the usual. */
static double usual_thickness(double *values, uint32_t count) {
    if (count == 0)
        return 0.0;
    qsort(values, count, sizeof *values, compare_doubles);
    return 1.02 * fmin(values[(uint32_t)(0.95 * (count - 1) + 0.5)], 3.0 * values[count / 2]);
}

static void reach_along(const EnfScene *scene, uint32_t c, const double n[3], const double from[3], double *low, double *high) {
    *low = DBL_MAX;
    *high = -DBL_MAX;
    for (uint32_t v = scene->cell_vertex_first[c]; v < scene->cell_vertex_first[c + 1]; v++) {
        double local[3];
        vec_sub(local, scene->cell_vertices[v], from);
        *low = fmin(*low, vec_dot(n, local));
        *high = fmax(*high, vec_dot(n, local));
    }
}

/* Where openings go through: the length of an opening's cell, or the space that a portal leaves between two rooms. 0: no
 * memory. */
static int measure_walls(const EnfScene *scene, double *wall, double *slab) {
    double *values[2] = {ENF_NEW(double, scene->portal_count), ENF_NEW(double, scene->portal_count)};
    uint32_t counts[2] = {0, 0};
    int ok = values[0] && values[1];
    for (uint32_t p = 0; p < scene->portal_count && ok; p++) {
        const double *n = scene->portal_planes[p].n;
        int level = fabs(n[2]) > 0.7071;
        double length = 0.0;
        uint32_t deep = ENF_NONE, shaped = 0;
        for (int side = 0; side < 2; side++) {
            uint32_t c = scene->portal_cells[p][side];
            shaped += scene->cell_vertex_first[c] < scene->cell_vertex_first[c + 1];
            if (scene->cell_openings[c] != ENF_NONE && scene->cell_vertex_first[c] < scene->cell_vertex_first[c + 1])
                deep = c;
        }
        if (deep != ENF_NONE) {
            double low, high;
            reach_along(scene, deep, n, scene->portal_centres[p], &low, &high);
            length = high - low;
        } else if (shaped == 2) {
            double behind, before, unused;
            reach_along(scene, scene->portal_cells[p][0], n, scene->portal_centres[p], &unused, &behind);
            reach_along(scene, scene->portal_cells[p][1], n, scene->portal_centres[p], &before, &unused);
            length = fmax(0.0, -behind) + fmax(0.0, before);
        }
        if (length > 8.0 * scene->tolerance)
            values[level][counts[level]++] = length;
    }
    if (ok) {
        *wall = usual_thickness(values[0], counts[0]);
        /* Without a hole through a slab to measure: slabs with what lies on and under them are about twice a wall. */
        *slab = counts[1] ? usual_thickness(values[1], counts[1]) : 2.0 * *wall;
    }
    enf_free(values[0]);
    enf_free(values[1]);
    return ok;
}

/* ---- Portals to the hub ------------------------------------------------------------------------------------------- */
int enf_leads_to(const EnfScene *scene, uint32_t p, uint32_t hub) {
    return scene->portal_cells[p][0] == hub || scene->portal_cells[p][1] == hub;
}

/* The exterior's one cell that openings lead to. */
static uint32_t find_outside(const EnfScene *scene, uint32_t *outcome) {
    uint32_t hub = ENF_NONE;
    *outcome = ENF_EXTERIOR_NONE;
    for (uint32_t p = 0; p < scene->portal_count; p++)
        for (int side = 0; side < 2; side++) {
            uint32_t c = scene->portal_cells[p][side];
            if (c >= scene->cell_count || c == hub || !enf_is_exterior(scene, c) ||
                scene->cell_vertex_first[c] < scene->cell_vertex_first[c + 1])
                continue;
            if (hub != ENF_NONE) {
                *outcome = ENF_EXTERIOR_SEVERAL;
                return ENF_NONE;
            }
            hub = c;
        }
    for (uint32_t c = 0; c < scene->cell_count && hub != ENF_NONE; c++)
        if (c != hub && scene->cell_rooms[c] == scene->cell_rooms[hub]) {
            *outcome = ENF_EXTERIOR_ALREADY;
            return ENF_NONE;
        }
    return hub;
}

/* Joins what led to the hub to the cells it lies in, as new portals. first: [portals before] the first piece of each; ENF_NONE: it stays. */
static EnfStatus join_portals(EnfScene *scene, uint32_t hub, uint32_t *first, EnfExteriorReport *report) {
    const uint32_t before = scene->portal_count, room = scene->cell_rooms[hub];
    double(*polygon)[3] = NULL;
    EnfStatus status = ENF_OK;
    for (uint32_t p = 0; p < before && status == ENF_OK; p++) {
        uint32_t made = 0, v = scene->portal_vertex_first[p], n = scene->portal_vertex_first[p + 1] - v;
        first[p] = ENF_NONE;
        if (!enf_leads_to(scene, p, hub))
            continue;
        uint32_t other = scene->portal_cells[p][0] == hub ? scene->portal_cells[p][1] : scene->portal_cells[p][0];
        if (!ENF_RESERVE(polygon, n)) {
            status = enf_fail_memory();
            break;
        }
        memcpy(polygon, scene->portal_vertices + v, n * sizeof *polygon); /* the array moves as it grows */
        status = enf_join_shaped(scene, other, room, polygon[0], n, scene->portal_openings[p], &first[p], &made);
        report->portals++;
        report->split += made > 1;
    }
    enf_free(polygon);
    return status;
}

/* The scene's portals become those of `order`, and no others. */
static EnfStatus reorder_portals(EnfScene *scene, const uint32_t *order, uint32_t count) {
    const uint32_t total = scene->portal_count;
    uint32_t(*cells)[2] = enf_alloc_array(total, sizeof *cells), *openings = ENF_NEW(uint32_t, total),
    *firsts = ENF_NEW(uint32_t, (uint64_t)total + 1);
    double(*points)[3] = enf_alloc_array(scene->portal_vertex_first[total], sizeof *points);
    int ok = cells && openings && firsts && points;
    for (uint32_t i = 0; i < count && ok; i++) {
        uint32_t p = order[i], v = scene->portal_vertex_first[p], n = scene->portal_vertex_first[p + 1] - v;
        memcpy(cells[i], scene->portal_cells[p], sizeof *cells);
        openings[i] = scene->portal_openings[p];
        memcpy(points + firsts[i], scene->portal_vertices + v, n * sizeof *points);
        firsts[i + 1] = firsts[i] + n;
    }
    if (ok) {
        memcpy(scene->portal_cells, cells, count * sizeof *cells);
        memcpy(scene->portal_openings, openings, count * sizeof *openings);
        memcpy(scene->portal_vertex_first, firsts, ((uint64_t)count + 1) * sizeof *firsts);
        memcpy(scene->portal_vertices, points, (uint64_t)firsts[count] * sizeof *points);
        scene->portal_count = count;
    }
    enf_free(cells);
    enf_free(openings);
    enf_free(firsts);
    enf_free(points);
    return ok ? ENF_OK : enf_fail_memory();
}

/* Gives every portal that led to the hub to the cells it lies in. The first piece keeps the portal's index, further ones
 * come last. */
static EnfStatus move_portals(EnfScene *scene, uint32_t hub, EnfExteriorReport *report) {
    const uint32_t before = scene->portal_count;
    uint32_t *first = ENF_NEW(uint32_t, (uint64_t)before + 1), *order = NULL, count = 0;
    EnfStatus status = first ? join_portals(scene, hub, first, report) : enf_fail_memory();
    if (status == ENF_OK && !(order = ENF_NEW(uint32_t, scene->portal_count)))
        status = enf_fail_memory();
    if (status == ENF_OK) {
        for (uint32_t p = 0; p < before; p++)
            order[count++] = first[p] == ENF_NONE ? p : first[p];
        /* Pieces come in the order of the portals: where one is a portal's first, it has its place already. */
        for (uint32_t at = before, p = 0; at < scene->portal_count; at++) {
            while (p < before && (first[p] == ENF_NONE || first[p] < at))
                p++;
            if (p == before || first[p] != at)
                order[count++] = at;
        }
        status = reorder_portals(scene, order, count);
    }
    enf_free(first);
    enf_free(order);
    return status;
}

/* ---- Writing ------------------------------------------------------------------------------------------------------- */
/* Portals between the hub and the faces of cell `c` that lie in the box's sides. */
static EnfStatus open_to_hub(EnfScene *scene, uint32_t hub, uint32_t c, const double box[6], double tolerance) {
    double(*polygon)[3] = NULL;
    EnfStatus status = ENF_OK;
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1] && status == ENF_OK; f++) {
        uint32_t begin = scene->face_index_first[f], n = scene->face_index_first[f + 1] - begin;
        if (!ENF_RESERVE(polygon, n)) {
            status = enf_fail_memory();
            break;
        }
        for (uint32_t i = 0; i < n; i++)
            vec_copy(polygon[i], scene->cell_vertices[scene->cell_vertex_first[c] + scene->face_indices[begin + i]]);
        for (int side = 0; side < 6 && status == ENF_OK; side++) {
            double most = 0.0;
            for (uint32_t i = 0; i < n; i++)
                most = fmax(most, fabs(polygon[i][side % 3] - box[side]));
            if (most <= tolerance)
                status = enf_scene_add_portal(scene, hub, c, polygon[0], n, 0, ENF_NONE, NULL);
        }
    }
    enf_free(polygon);
    return status;
}

static EnfStatus write_space(EnfScene *scene, uint32_t hub, const EnfDecomposition *d, const double box[6], double tolerance,
                             EnfExteriorReport *report) {
    uint32_t room = scene->cell_rooms[hub], first = scene->cell_count, index = 0;
    EnfStatus status = ENF_OK;
    for (uint32_t c = 0; c < d->cell_count && status == ENF_OK; c++) {
        uint32_t point = d->cell_point_first[c], face = d->cell_face_first[c], faces = d->cell_face_first[c + 1] - face;
        status = enf_scene_add_cell(scene, room, ENF_NONE, d->points[point], d->cell_point_first[c + 1] - point, 0, d->face_sizes + face,
                                    faces, d->face_indices + index, NULL);
        for (uint32_t f = face; f < face + faces; f++)
            index += d->face_sizes[f];
    }
    if (status == ENF_OK)
        status = move_portals(scene, hub, report);
    for (uint32_t i = 0; i < d->seam_count && status == ENF_OK; i++)
        status = enf_scene_add_portal(scene, first + d->seams[i].cells[0], first + d->seams[i].cells[1], d->seam_points[d->seams[i].first],
                                      d->seams[i].count, 0, ENF_NONE, NULL);
    for (uint32_t c = first; c < first + d->cell_count && status == ENF_OK; c++)
        status = open_to_hub(scene, hub, c, box, tolerance);
    report->cells = d->cell_count;
    report->seams = d->seam_count;
    return status;
}

/* Points before the portals that lead to the hub, `beyond` metres out, about the scene's origin. NULL: out of memory. */
static double (*place_seeds(const EnfScene *scene, uint32_t hub, double beyond, uint32_t *out_count))[3] {
    double(*seeds)[3] = enf_alloc_array(scene->portal_count, sizeof *seeds);
    uint32_t count = 0;
    for (uint32_t p = 0; p < scene->portal_count && seeds; p++)
        if (enf_leads_to(scene, p, hub)) {
            double out = scene->portal_cells[p][1] == hub ? 1.0 : -1.0;
            vec_sub(seeds[count], scene->portal_centres[p], scene->origin);
            vec_mad(seeds[count], seeds[count], out * beyond, scene->portal_planes[p].n);
            count++;
        }
    *out_count = count;
    return seeds;
}

/* Cuts what is outdoors within the box. The report says whether it could be done, def what gaps were used. 0: out of memory. */
static int cut_space(const EnfScene *scene, uint32_t hub, EnfExteriorDef *def, const double box[6], EnfSpace *space,
                     EnfExteriorReport *report) {
    double wall = 0.0, slab = 0.0, *depths = NULL, (*seeds)[3] = NULL;
    uint32_t seed_count = 0;
    EnfBodies bodies;
    memset(&bodies, 0, sizeof bodies);
    int ok = measure_walls(scene, &wall, &slab);
    report->wall_gap = def->wall_gap = wall = def->wall_gap >= 0.0 ? def->wall_gap : wall;
    report->slab_gap = def->slab_gap = slab = def->slab_gap >= 0.0 ? def->slab_gap : slab;
    /* A fiftieth of a wall is how exactly buildings are measured; a quarter is plaster and cladding: portals stand that far off. */
    double slit = 0.02 * wall, beyond = 0.25 * wall + 1e-5 * scene->extent;
    ok = ok && (seeds = place_seeds(scene, hub, beyond, &seed_count)) != NULL &&
         (depths = ENF_NEW(double, scene->cell_face_first[scene->cell_count])) != NULL &&
         enf_walls_measure(scene, hub, wall, slab, depths) && enf_bodies_build(scene, hub, def, beyond, depths, &bodies);
    report->bodies = bodies.count;
    report->outcome = bodies.rooms ? ENF_EXTERIOR_DONE : ENF_EXTERIOR_NONE;
    if (ok && report->outcome == ENF_EXTERIOR_DONE) {
        ok = enf_space_build(scene, &bodies, box, seeds, seed_count, slit, space);
        report->leaves = space->leaves;
        if (ok && (space->gave_up || space->cells.cell_count > def->max_cells))
            report->outcome = ENF_EXTERIOR_TOO_COMPLEX;
    }
    enf_bodies_free(&bodies);
    enf_free(seeds);
    enf_free(depths);
    return ok;
}

EnfStatus enf_scene_decompose_exterior(EnfScene *scene, const EnfExteriorDef *given, EnfExteriorReport *out_report) {
    if (!scene)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_decompose_exterior: scene is NULL");
    EnfExteriorDef def = enf_default_exterior_def();
    EnfExteriorReport report;
    EnfSpace space;
    if (given)
        memcpy(&def, given, given->struct_size < sizeof def ? given->struct_size : sizeof def);
    memset(&report, 0, sizeof report);
    memset(&space, 0, sizeof space);
    double begin = enf_wall_seconds(), box[6];
    EnfStatus status = enf_scene_derive(scene);
    if (status != ENF_OK)
        return status;
    uint32_t hub = find_outside(scene, &report.outcome);
    memcpy(box, scene->bounds, sizeof box);
    box_grow(box, def.margin > 0.0 ? def.margin : 0.25 * scene->extent);
    if (hub != ENF_NONE && !cut_space(scene, hub, &def, box, &space, &report))
        status = enf_fail_memory();
    double tolerance = scene->tolerance;
    enf_scene_drop_derived(scene);
    enf_problems_restart(scene); /* what derive found, commit will find again */
    if (status == ENF_OK && hub != ENF_NONE && report.outcome == ENF_EXTERIOR_DONE)
        status = write_space(scene, hub, &space.cells, box, tolerance, &report);
    if (status == ENF_OK && report.outcome == ENF_EXTERIOR_TOO_COMPLEX) {
        enf_problem_add(scene, ENF_SEVERITY_INFO, ENF_ITEM_CELL, hub, ENF_PROBLEM_EXTERIOR_WHOLE, NULL,
                        "the outdoors are too complex to cut into cells (%u parts); they stay one cell: what facades hide of "
                        "each other isn't known",
                        space.leaves);
        enf_problems_keep(scene);
    }
    enf_decomposition_free(&space.cells);
    report.seconds = enf_wall_seconds() - begin;
    if (out_report) {
        uint32_t size = out_report->struct_size;
        report.struct_size = size < sizeof report ? size : (uint32_t)sizeof report;
        memcpy(out_report, &report, report.struct_size);
    }
    return status;
}
