/* SPDX-License-Identifier: GPL-3.0-or-later
 * Adding rooms as people draw them: decomposed into convex cells that seams join. */
#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"
#include "scene/convex_decomposition.h"
#include "scene/problems.h"

static EnfStatus add_cells(EnfScene *scene, uint32_t room, const EnfDecomposition *d, uint32_t *out_first, uint32_t *out_count) {
    uint32_t first = scene->cell_count, index = 0;
    EnfStatus status = ENF_OK;
    for (uint32_t c = 0; c < d->cell_count && status == ENF_OK; c++) {
        uint32_t points = d->cell_point_first[c], face = d->cell_face_first[c], faces = d->cell_face_first[c + 1] - face;
        status = enf_scene_add_cell(scene, room, ENF_NONE, d->points[points], d->cell_point_first[c + 1] - points, 0,
                                    faces ? d->face_sizes + face : NULL, faces, faces ? d->face_indices + index : NULL, NULL);
        for (uint32_t f = face; f < face + faces; f++)
            index += d->face_sizes[f];
    }
    for (uint32_t i = 0; i < d->seam_count && status == ENF_OK; i++)
        status = enf_scene_add_portal(scene, first + d->seams[i].cells[0], first + d->seams[i].cells[1], d->seam_points[d->seams[i].first],
                                      d->seams[i].count, 0, ENF_NONE, NULL);
    if (status != ENF_OK)
        return status;
    const double *where = d->points[0];
    const char *name = room < scene->room_count ? scene->rooms[room].name : "";
    if (d->not_closed)
        enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_ROOM, room, ENF_PROBLEM_ROOM_NOT_CLOSED, where,
                        "\"%.60s\": its shape isn't closed (%u open edges); its convex hull is one cell", name, d->not_closed);
    if (d->not_planar)
        enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_ROOM, room, ENF_PROBLEM_ROOM_NOT_PLANAR, where,
                        "\"%.60s\": %u faces aren't planar; taken as triangles", name, d->not_planar);
    if (d->inside_out)
        enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_ROOM, room, ENF_PROBLEM_CELL_INSIDE_OUT, where,
                        "\"%.60s\": its faces run clockwise seen from outside; taken the other way round", name);
    if (d->gave_up)
        enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_ROOM, room, ENF_PROBLEM_ROOM_DECOMPOSITION, where,
                        "\"%.60s\": its shape crosses itself or is too complex to cut into convex cells; its "
                        "convex hull is one "
                        "cell",
                        name);
    if (d->facets)
        enf_problem_add(scene, ENF_SEVERITY_INFO, ENF_ITEM_ROOM, room, ENF_PROBLEM_ROOM_CURVED, where,
                        "\"%.60s\": %u facets of curved walls are taken together; its cells reach up to %.3f m into them", name, d->facets,
                        d->depth);
    if (d->not_closed || d->not_planar || d->inside_out || d->gave_up || d->facets)
        enf_problems_keep(scene);
    if (out_first)
        *out_first = first;
    if (out_count)
        *out_count = d->cell_count;
    return ENF_OK;
}

EnfStatus enf_scene_add_room_polyhedron(EnfScene *scene, uint32_t room, const double *vertices, uint64_t vertex_count,
                                        uint64_t vertex_stride, const uint32_t *face_sizes, uint64_t face_count,
                                        const uint32_t *face_indices, uint32_t *out_first_cell, uint32_t *out_cell_count) {
    if (!scene || !vertices || (face_count && (!face_sizes || !face_indices)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_room_polyhedron: NULL argument");
    if (vertex_count > 100000000 || face_count > 100000000)
        return enf_fail(ENF_ERROR_BAD_INPUT, "room %u: a shape of %llu vertices and %llu faces is too large", room,
                        (unsigned long long)vertex_count, (unsigned long long)face_count);
    double(*packed)[3] = enf_alloc_array(vertex_count, sizeof *packed);
    if (!packed)
        return enf_fail_memory();
    if (vertex_stride == 0)
        vertex_stride = 3 * sizeof(double);
    for (uint64_t i = 0; i < vertex_count; i++)
        memcpy(packed[i], (const char *)vertices + i * vertex_stride, sizeof packed[i]);
    EnfDecomposition d;
    EnfStatus status;
    if (face_count == 0) {
        /* The hull of the vertices is meant. */
        enf_free(packed);
        uint32_t cell;
        status = enf_scene_add_cell(scene, room, ENF_NONE, vertices, vertex_count, vertex_stride, NULL, 0, NULL, &cell);
        if (status == ENF_OK && out_first_cell)
            *out_first_cell = cell;
        if (status == ENF_OK && out_cell_count)
            *out_cell_count = 1;
        return status;
    }
    status = enf_decompose_polyhedron(&d, packed, (uint32_t)vertex_count, face_sizes, (uint32_t)face_count, face_indices);
    enf_free(packed);
    if (status != ENF_OK)
        return status;
    status = add_cells(scene, room, &d, out_first_cell, out_cell_count);
    enf_decomposition_free(&d);
    return status;
}

EnfStatus enf_scene_add_room_prism(EnfScene *scene, uint32_t room, const double *corners, const uint32_t *ring_sizes, uint64_t ring_count,
                                   double z0, double z1, uint32_t *out_first_cell, uint32_t *out_cell_count) {
    if (!scene || !corners || !ring_sizes || ring_count < 1)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_add_room_prism: NULL argument");
    EnfDecomposition d;
    EnfStatus status = enf_decompose_prism(&d, corners, ring_sizes, ring_count, z0, z1);
    if (status != ENF_OK)
        return status;
    status = add_cells(scene, room, &d, out_first_cell, out_cell_count);
    enf_decomposition_free(&d);
    return status;
}
