/* SPDX-License-Identifier: GPL-3.0-or-later
 * Takes in materials and meshes, checked. */
#include "raycast/triangle_tree.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

/* Embree numbers corners in 32 bits. */
static const uint32_t triangles_most = 1u << 28;

EnfStatus enf_triangles_create(const double origin[3], EnfTriangles **out_triangles) {
    if (!origin || !out_triangles)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_create: NULL argument");
    if (!vec_finite(origin))
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_triangles_create: the origin isn't finite");
    EnfTriangles *t = ENF_NEW(EnfTriangles, 1);
    const EnfMaterial grey = {ENF_MATERIAL_DIFFUSE, {0.7f, 0.7f, 0.7f}, {0, 0, 0}, 1};
    uint32_t first;
    if (!t)
        return enf_fail_memory();
    vec_copy(t->origin, origin);
    EnfStatus status = enf_triangles_add_material(t, &grey, &first);
    if (status != ENF_OK) {
        enf_triangles_destroy(t);
        return status;
    }
    *out_triangles = t;
    return ENF_OK;
}

void enf_triangles_destroy(EnfTriangles *t) {
    if (!t)
        return;
    enf_triangle_tree_free(&t->tree);
    enf_free(t->materials);
    enf_free(t->triangles);
    enf_free(t->corners);
    enf_free(t->normals);
    enf_free(t);
}

EnfStatus enf_triangles_add_material(EnfTriangles *t, const EnfMaterial *material, uint32_t *out_material) {
    if (!t || !material || !out_material)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_add_material: NULL argument");
    int finite = isfinite(material->ior) && material->ior > 0;
    for (int k = 0; k < 3; k++)
        finite = finite && isfinite(material->colour[k]) && isfinite(material->emission[k]);
    if (!finite || material->kind > ENF_MATERIAL_CLEAR)
        return enf_fail(ENF_ERROR_BAD_INPUT, "material %u: its kind is unknown, or a number isn't finite", t->material_count);
    if (!ENF_RESERVE(t->materials, t->material_count + 1))
        return enf_fail_memory();
    t->materials[t->material_count] = *material;
    *out_material = t->material_count++;
    return ENF_OK;
}

static EnfStatus check_mesh(const EnfTriangles *t, uint32_t object, const char *vertices, uint64_t vertex_count, uint64_t stride,
                            const uint32_t *corners, uint64_t triangle_count, const uint32_t *materials) {
    if (triangle_count > triangles_most - t->count)
        return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: more than %u triangles in all", object, triangles_most);
    for (uint64_t v = 0; v < vertex_count; v++) {
        double p[3];
        memcpy(p, vertices + v * stride, sizeof p);
        vec_sub(p, p, t->origin);
        if (!vec_finite(p) || fmax(fmax(fabs(p[0]), fabs(p[1])), fabs(p[2])) > 1e15)
            return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: vertex %llu isn't finite", object, (unsigned long long)v);
    }
    for (uint64_t i = 0; i < 3 * triangle_count; i++)
        if (corners[i] >= vertex_count)
            return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: triangle %llu names vertex %u of %llu", object, (unsigned long long)(i / 3),
                            corners[i], (unsigned long long)vertex_count);
    for (uint64_t i = 0; materials && i < triangle_count; i++)
        if (materials[i] >= t->material_count)
            return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: triangle %llu has material %u of %u", object, (unsigned long long)i,
                            materials[i], t->material_count);
    return ENF_OK;
}

static int has_area(const float v[3][3]) {
    double ab[3], ac[3], n[3];
    for (int k = 0; k < 3; k++) {
        ab[k] = (double)v[1][k] - v[0][k];
        ac[k] = (double)v[2][k] - v[0][k];
    }
    vec_cross(n, ab, ac);
    return vec_dot(n, n) > 0;
}

static EnfStatus add_normals(EnfTriangles *t, const float *normals) {
    uint64_t had = t->normals ? enf_block_size(t->normals) / sizeof *t->normals : 0;
    if (!t->normals && !normals)
        return ENF_OK;
    if (had < t->count + 1 && !ENF_RESERVE(t->normals, t->count + 1))
        return enf_fail_memory();
    uint64_t has = enf_block_size(t->normals) / sizeof *t->normals;
    memset(t->normals + had, 0, (has - had) * sizeof *t->normals);
    for (int k = 0; normals && k < 9; k++)
        t->normals[t->count][k] = isfinite(normals[k]) ? (int16_t)(32767 * fmaxf(-1, fminf(1, normals[k]))) : 0;
    return ENF_OK;
}

EnfStatus enf_triangles_add_mesh(EnfTriangles *t, uint32_t object, const double *vertices, uint64_t vertex_count, uint64_t vertex_stride,
                                 const uint32_t *corners, uint64_t triangle_count, const uint32_t *materials, const float *normals) {
    if (!t || (triangle_count && (!vertices || !corners)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_add_mesh: NULL argument");
    uint64_t stride = vertex_stride ? vertex_stride : 3 * sizeof(double);
    EnfStatus status = check_mesh(t, object, (const char *)vertices, vertex_count, stride, corners, triangle_count, materials);
    if (status != ENF_OK)
        return status;
    t->committed = 0;
    enf_triangle_tree_free(&t->tree); /* it reads the corners, which may move */
    if (!ENF_RESERVE(t->triangles, t->count + triangle_count) || !ENF_RESERVE(t->corners, t->count + triangle_count + 1))
        return enf_fail_memory();
    for (uint64_t i = 0; i < triangle_count; i++) {
        for (int c = 0; c < 3; c++) {
            double p[3];
            memcpy(p, (const char *)vertices + corners[3 * i + c] * stride, sizeof p);
            for (int k = 0; k < 3; k++)
                t->corners[t->count][c][k] = (float)(p[k] - t->origin[k]);
        }
        t->triangles[t->count] = (TreeTriangle){materials ? materials[i] : 0, object};
        if (!has_area((const float(*)[3])t->corners[t->count])) {
            t->without_area++;
            continue;
        }
        status = add_normals(t, normals ? normals + 9 * i : NULL);
        if (status != ENF_OK)
            return status;
        t->count++;
    }
    return ENF_OK;
}

EnfStatus enf_triangles_commit(EnfTriangles *t) {
    if (!t)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_commit: NULL argument");
    if (t->committed)
        return ENF_OK;
    EnfStatus status = t->count ? enf_triangle_tree_build(t) : ENF_OK;
    t->committed = status == ENF_OK;
    return status;
}

EnfTriangleCounts enf_default_triangle_counts(void) {
    EnfTriangleCounts counts = {.struct_size = sizeof counts};
    return counts;
}

EnfStatus enf_triangles_counts(const EnfTriangles *t, EnfTriangleCounts *out) {
    if (!t || !out || out->struct_size != sizeof *out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_counts: NULL argument or bad struct_size");
    *out = (EnfTriangleCounts){sizeof *out, (uint32_t)t->committed, t->count, t->without_area, 0, t->material_count, 0};
    out->bytes = enf_block_size(t->triangles) + enf_block_size(t->corners) + enf_block_size(t->normals) + enf_block_size(t->materials) +
                 enf_triangle_tree_bytes(&t->tree);
    return ENF_OK;
}
