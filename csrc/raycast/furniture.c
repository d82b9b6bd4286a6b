/* SPDX-License-Identifier: GPL-3.0-or-later
 * Triangles as they are given, and which mesh each belongs to. */
#include "raycast/furniture.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

EnfStatus enf_furniture_add(Furniture *f, const double origin[3], uint32_t object, uint32_t flags, const double *vertices,
                            uint64_t vertex_count, uint64_t vertex_stride, const uint32_t *triangles, uint64_t triangle_count,
                            uint32_t *out_first) {
    if ((vertex_count && !vertices) || (triangle_count && !triangles) || flags > ENF_FURNITURE_NO_SHADOW)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycaster_add_mesh: NULL argument or unknown flags %u", flags);
    /* surfaces are 32-bit numbers that faces and portals share, and the hierarchy marks leaves by the top bit */
    if (vertex_count + f->vertex_count > 1u << 30 || triangle_count + f->triangle_count > 1u << 30)
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_raycaster_add_mesh: more than 2^30 vertices or triangles");
    for (uint64_t i = 0; i < 3 * triangle_count; i++)
        if (triangles[i] >= vertex_count)
            return enf_fail(ENF_ERROR_BAD_INPUT, "enf_raycaster_add_mesh: triangle %llu has vertex %u of %llu", (unsigned long long)(i / 3),
                            triangles[i], (unsigned long long)vertex_count);
    size_t stride = vertex_stride ? (size_t)vertex_stride : 3 * sizeof(double);
    for (uint64_t v = 0; v < vertex_count; v++)
        if (!vec_finite((const double *)((const char *)vertices + v * stride)))
            return enf_fail(ENF_ERROR_BAD_INPUT, "enf_raycaster_add_mesh: vertex %llu isn't finite", (unsigned long long)v);
    if (!ENF_RESERVE(f->meshes, (uint64_t)f->mesh_count + 1) || !ENF_RESERVE(f->vertices, f->vertex_count + vertex_count) ||
        !ENF_RESERVE(f->triangles, f->triangle_count + triangle_count))
        return enf_fail_memory();
    for (uint64_t v = 0; v < vertex_count; v++) {
        const double *from = (const double *)((const char *)vertices + v * stride);
        for (int k = 0; k < 3; k++)
            f->vertices[f->vertex_count + v][k] = (float)(from[k] - origin[k]);
    }
    for (uint64_t t = 0; t < triangle_count; t++)
        for (int k = 0; k < 3; k++)
            f->triangles[f->triangle_count + t][k] = f->vertex_count + triangles[3 * t + (uint64_t)k];
    f->meshes[f->mesh_count++] = (FurnitureMesh){object, flags, f->triangle_count, 0};
    if (out_first)
        *out_first = f->triangle_count;
    f->vertex_count += (uint32_t)vertex_count;
    f->triangle_count += (uint32_t)triangle_count;
    return ENF_OK;
}

void enf_furniture_free(Furniture *f) {
    enf_free(f->meshes);
    enf_free(f->vertices);
    enf_free(f->triangles);
    enf_free(f->nodes);
    enf_free(f->order);
}

const FurnitureMesh *enf_furniture_mesh_of(const Furniture *f, uint32_t triangle) {
    uint32_t low = 0, high = f->mesh_count; /* the last mesh that begins at or before the triangle */
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (f->meshes[middle].first_triangle <= triangle)
            low = middle;
        else
            high = middle;
    }
    return &f->meshes[low];
}
