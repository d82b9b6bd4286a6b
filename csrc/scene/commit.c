/* SPDX-License-Identifier: GPL-3.0-or-later
 * Commit: validates, then derives the flat arrays that queries read (scene_data.h). */
#include "scene/commit.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/polygon.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/cell_side.h"
#include "scene/exterior.h"
#include "scene/placement.h"
#include "scene/point_location.h"
#include "scene/problems.h"
#include "scene/validate.h"

#define DROP(field) (enf_free(scene->field), scene->field = NULL)

void enf_scene_drop_derived(EnfScene *scene) {
    scene->committed = 0;
    DROP(portal_planes);
    DROP(portal_deviation);
    DROP(portal_centres);
    DROP(portal_radii);
    DROP(cell_portal_first);
    DROP(cell_portals);
    DROP(cell_bounds);
    DROP(cell_centres);
    DROP(face_planes);
    DROP(cell_object_first);
    DROP(cell_object_list);
    DROP(placed_first);
    DROP(placed_cells);
    DROP(unplaced_objects);
    scene->unplaced_count = 0;
    scene->hub = ENF_NONE;
    enf_locator_destroy(scene->locator);
    scene->locator = NULL;
}

static void measure(EnfScene *scene) {
    box_empty(scene->bounds);
    for (uint32_t i = 0; i < scene->cell_vertex_first[scene->cell_count]; i++)
        box_add_point(scene->bounds, scene->cell_vertices[i]);
    for (uint32_t i = 0; i < scene->portal_vertex_first[scene->portal_count]; i++)
        box_add_point(scene->bounds, scene->portal_vertices[i]);
    if (box_is_empty(scene->bounds))
        memset(scene->bounds, 0, sizeof scene->bounds);
    double largest = 0.0;
    for (int k = 0; k < 3; k++) {
        scene->origin[k] = 0.5 * (scene->bounds[k] + scene->bounds[3 + k]);
        largest = fmax(largest, fmax(fabs(scene->bounds[k]), fabs(scene->bounds[3 + k])));
    }
    scene->extent = box_diagonal(scene->bounds);
    if (!(scene->extent > 0.0))
        scene->extent = 1.0;
    scene->tolerance = fmax(ENF_TOLERANCE_LOCATE * scene->extent, ENF_TOLERANCE_COORDINATE * largest);
}

static int derive_faces(EnfScene *scene) {
    uint32_t faces = scene->cell_face_first[scene->cell_count];
    scene->face_planes = ENF_NEW(EnfPlane, faces);
    scene->cell_bounds = enf_alloc_array(scene->cell_count, sizeof *scene->cell_bounds);
    scene->cell_centres = enf_alloc_array(scene->cell_count, sizeof *scene->cell_centres);
    if (!scene->face_planes || !scene->cell_bounds || !scene->cell_centres)
        return 0;
    double(*corners)[3] = NULL;
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        double(*vertices)[3] = scene->cell_vertices + scene->cell_vertex_first[c];
        uint32_t count = scene->cell_vertex_first[c + 1] - scene->cell_vertex_first[c];
        box_empty(scene->cell_bounds[c]);
        for (uint32_t i = 0; i < count; i++)
            box_add_point(scene->cell_bounds[c], vertices[i]);
        for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
            uint32_t begin = scene->face_index_first[f], n = scene->face_index_first[f + 1] - begin;
            if (!ENF_RESERVE(corners, n)) {
                enf_free(corners);
                return 0;
            }
            for (uint32_t i = 0; i < n; i++)
                vec_copy(corners[i], vertices[scene->face_indices[begin + i]]);
            EnfPlane *plane = &scene->face_planes[f];
            if (enf_polygon_normal(plane->n, corners, n) == 0.0)
                vec_set(plane->n, 0.0, 0.0, 0.0); /* a face of no area: 0 <= 0 holds for every point */
            /* The outermost vertex carries the plane: rounding never leaves a part of the cell outside. */
            plane->d = -DBL_MAX;
            for (uint32_t i = 0; i < count; i++) {
                double local[3];
                vec_sub(local, vertices[i], scene->origin);
                plane->d = fmax(plane->d, vec_dot(plane->n, local));
            }
        }
    }
    enf_free(corners);
    return 1;
}

static int derive_portals(EnfScene *scene) {
    uint32_t portals = scene->portal_count;
    scene->portal_planes = ENF_NEW(EnfPlane, portals);
    scene->portal_deviation = ENF_NEW(double, portals);
    scene->portal_centres = enf_alloc_array(portals, sizeof *scene->portal_centres);
    scene->portal_radii = ENF_NEW(double, portals);
    scene->cell_portal_first = ENF_NEW(uint32_t, (uint64_t)scene->cell_count + 1);
    scene->cell_portals = ENF_NEW(EnfCellPortal, 2 * (uint64_t)portals);
    uint32_t *next = ENF_NEW(uint32_t, scene->cell_count);
    if (!scene->portal_planes || !scene->portal_deviation || !scene->portal_centres || !scene->portal_radii || !scene->cell_portal_first ||
        !scene->cell_portals || !next) {
        enf_free(next);
        return 0;
    }
    for (uint32_t p = 0; p < portals; p++) {
        scene->cell_portal_first[scene->portal_cells[p][0] + 1]++;
        scene->cell_portal_first[scene->portal_cells[p][1] + 1]++;
        double(*v)[3] = scene->portal_vertices + scene->portal_vertex_first[p];
        uint32_t count = scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p];
        /* The centroid lies in the polygon and in its plane; the middle of the bounds does neither when it is
         * slanted. */
        enf_polygon_centroid(scene->portal_centres[p], v, count);
        for (uint32_t i = 0; i < count; i++) {
            scene->portal_radii[p] = fmax(scene->portal_radii[p], vec_distance(v[i], scene->portal_centres[p]));
            box_add_point(scene->cell_bounds[scene->portal_cells[p][0]], v[i]);
            box_add_point(scene->cell_bounds[scene->portal_cells[p][1]], v[i]);
        }
    }
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        scene->cell_portal_first[c + 1] += scene->cell_portal_first[c];
        next[c] = scene->cell_portal_first[c];
    }
    for (uint32_t p = 0; p < portals; p++)
        for (uint32_t side = 0; side < 2; side++) {
            uint32_t c = scene->portal_cells[p][side];
            scene->cell_portals[next[c]++] = (EnfCellPortal){p, scene->portal_cells[p][1 - side], side};
        }
    enf_free(next);
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        double *centre = scene->cell_centres[c];
        uint32_t first = scene->cell_vertex_first[c], count = scene->cell_vertex_first[c + 1] - first;
        vec_set(centre, 0.0, 0.0, 0.0);
        if (count) {
            for (uint32_t i = 0; i < count; i++)
                vec_mad(centre, centre, 1.0 / count, scene->cell_vertices[first + i]);
        } else if (!box_is_empty(scene->cell_bounds[c])) {
            for (int k = 0; k < 3; k++)
                centre[k] = 0.5 * (scene->cell_bounds[c][k] + scene->cell_bounds[c][3 + k]);
        } else
            vec_copy(centre, scene->origin);
    }
    return 1;
}

/* How plainly a cell lies on one side of a portal, along n: 1 all in front of it, -1 all behind, 0 as much as
 * not. */
static double side_of_cell(const EnfScene *scene, uint32_t p, uint32_t c, const double n[3]) {
    double low, high;
    if (scene->cell_face_first[c] == scene->cell_face_first[c + 1])
        return 0.0;
    enf_cell_reach(scene, c, scene->portal_centres[p], n, 0.0, &low, &high);
    return fmax(high, -low) > scene->tolerance ? enf_plain_side(low, high) : 0.0;
}

/* Sine. A corner seen from the portal's middle at less than this out of the portal's plane tells nothing of its
 * sides: files carry six digits. All portals of a cell that shows only a sloping roof lie in one plane. */
#define PLAIN_SINE 1e-3

/* The same for a cell without geometry, by its other portals: a convex cell has them all on its own side of
 * this one. Says nothing (0) where they don't all agree, of the exterior, which isn't convex, and beyond the
 * first hundred (hostile counts). */
static double side_of_portals(const EnfScene *scene, uint32_t p, uint32_t c, const double n[3]) {
    uint32_t first = scene->cell_portal_first[c], end = scene->cell_portal_first[c + 1];
    double low = DBL_MAX, high = -DBL_MAX, local[3];
    if (scene->cell_face_first[c] < scene->cell_face_first[c + 1] || enf_is_exterior(scene, c))
        return 0.0;
    for (uint32_t i = first; i < end && i < first + 100; i++) {
        uint32_t q = scene->cell_portals[i].portal;
        for (uint32_t v = scene->portal_vertex_first[q]; q != p && v < scene->portal_vertex_first[q + 1]; v++) {
            vec_sub(local, scene->portal_vertices[v], scene->portal_centres[p]);
            double above = vec_dot(n, local);
            if (fabs(above) <= PLAIN_SINE * vec_length(local))
                continue;
            low = fmin(low, above);
            high = fmax(high, above);
        }
    }
    double plain = high > low ? (high + low) / (high - low) : high > 0.0 ? 1.0 : high < 0.0 && high > -DBL_MAX ? -1.0 : 0.0;
    return fabs(plain) > 0.9 ? plain : 0.0;
}

/* Planes, and which way they face. The cell that lies more plainly on one side of the portal decides; without
 * geometry, the other portals; without either, the winding as given: counter-clockwise seen from cells[0]
 * (portal files are turned that way on reading). */
static void orient_portals(EnfScene *scene) {
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        double(*v)[3] = scene->portal_vertices + scene->portal_vertex_first[p];
        uint32_t count = scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p];
        EnfPlane *plane = &scene->portal_planes[p];
        double towards[3], local[3]; /* towards cells[0] if the winding is as it should be */
        enf_polygon_normal(towards, v, count);
        double first = side_of_cell(scene, p, scene->portal_cells[p][0], towards);
        double second = side_of_cell(scene, p, scene->portal_cells[p][1], towards);
        if (first == 0.0 && second == 0.0) {
            first = side_of_portals(scene, p, scene->portal_cells[p][0], towards);
            second = side_of_portals(scene, p, scene->portal_cells[p][1], towards);
            if ((fabs(first) >= fabs(second) ? first : -second) < 0.0)
                enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_ORIENTATION, scene->portal_centres[p],
                                "its winding is the wrong way round: the other portals of its cells lie "
                                "behind it, and are believed");
        }
        if ((fabs(first) >= fabs(second) ? first : -second) < 0.0) {
            for (uint32_t i = 0, j = count - 1; i < j; i++, j--) {
                vec_copy(local, v[i]);
                vec_copy(v[i], v[j]);
                vec_copy(v[j], local);
            }
            vec_scale(towards, -1.0, towards);
        }
        vec_scale(plane->n, -1.0, towards);
        double low = DBL_MAX, high = -DBL_MAX;
        for (uint32_t i = 0; i < count; i++) {
            vec_sub(local, v[i], scene->origin);
            double d = vec_dot(plane->n, local);
            low = fmin(low, d);
            high = fmax(high, d);
        }
        plane->d = 0.5 * (low + high);
        scene->portal_deviation[p] = 0.5 * (high - low);
    }
}

static EnfStatus fail_with_problems(EnfScene *scene) {
    enf_problems_finish(scene);
    for (uint64_t i = 0; i < scene->problems->count; i++)
        if (scene->problems->items[i].severity == ENF_SEVERITY_ERROR) {
            uint64_t others = scene->problems->error_count - 1;
            if (others)
                return enf_fail(ENF_ERROR_BAD_INPUT, "%s (and %llu more)", scene->problems->items[i].message, (unsigned long long)others);
            return enf_fail(ENF_ERROR_BAD_INPUT, "%s", scene->problems->items[i].message);
        }
    return enf_fail(ENF_ERROR_INTERNAL, "commit failed without a problem");
}

static EnfStatus drop(EnfScene *scene, EnfStatus status) {
    enf_scene_drop_derived(scene);
    return status;
}

EnfStatus enf_scene_derive(EnfScene *scene) {
    enf_scene_drop_derived(scene);
    enf_problems_restart(scene);
    if (!scene->problems)
        return enf_fail_memory();
    enf_validate_values(scene);
    if (scene->problems->error_count)
        return fail_with_problems(scene);
    measure(scene);
    if (!enf_shape_cells(scene) || !enf_shape_portals(scene))
        return enf_fail_memory();
    if (scene->problems->error_count)
        return fail_with_problems(scene);
    if (!derive_faces(scene) || !derive_portals(scene))
        return drop(scene, enf_fail_memory());
    orient_portals(scene);
    enf_find_hub(scene);
    if (!enf_locator_build(scene) || !enf_validate_geometry(scene))
        return drop(scene, enf_fail_memory());
    return ENF_OK;
}

EnfStatus enf_scene_commit(EnfScene *scene) {
    if (!scene)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_commit: scene is NULL");
    EnfStatus status = enf_scene_derive(scene);
    if (status == ENF_OK && (status = enf_scene_place_objects(scene)) != ENF_OK)
        enf_scene_drop_derived(scene);
    if (status != ENF_OK)
        return status;
    if (scene->problems->error_count)
        return drop(scene, fail_with_problems(scene));
    enf_problems_finish(scene);
    if (scene->problems->out_of_memory)
        return drop(scene, enf_fail_memory());
    scene->committed = 1;
    scene->commit_serial++;
    return ENF_OK;
}
