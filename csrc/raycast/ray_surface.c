/* SPDX-License-Identifier: GPL-3.0-or-later
 * Surfaces by number: faces of cells, leaves of closed portals, triangles of furniture. */
#include "raycast/ray_surface.h"

#include "base/status.h"
#include "geometry/vec3.h"
#include "raycast/triangle_tree.h"

#include <string.h>

/* u level, v climbing; on level surfaces u is the world's x. */
static void span_surface(SurfaceFrame *frame) {
    const double *n = frame->normal;
    vec_set(frame->u, -n[1], n[0], 0);
    if (!(hypot(n[0], n[1]) > 1e-6)) /* less than a micrometre a metre: level for any purpose */
        vec_set(frame->u, 1, 0, 0);
    vec_normalize(frame->u);
    vec_cross(frame->v, n, frame->u);
    vec_normalize(frame->v);
}

static uint32_t cell_of_face(const EnfRaycaster *r, uint32_t face) {
    uint32_t low = 0, high = r->cell_count; /* the last cell that begins at or before the face: empty ones come before it */
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (r->scene->cell_face_first[middle] <= face)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void enf_surface_frame(const EnfRaycaster *r, uint32_t surface, SurfaceFrame *frame) {
    const EnfScene *scene = r->scene;
    if (surface < r->face_count) {
        vec_scale(frame->normal, -1, scene->face_planes[surface].n);
        enf_ray_face_corner(r, cell_of_face(r, surface), surface, 0, frame->point);
    } else if (surface - r->face_count < scene->portal_count) {
        uint32_t p = surface - r->face_count;
        vec_copy(frame->normal, scene->portal_planes[p].n);
        vec_sub(frame->point, scene->portal_vertices[scene->portal_vertex_first[p]], scene->origin);
    } else {
        uint32_t t = surface - r->face_count - scene->portal_count;
        enf_tree_plane_normal(r->furniture, t, frame->normal);
        for (int k = 0; k < 3; k++)
            frame->point[k] = r->furniture->corners[t][0][k] + r->furniture->origin[k] - scene->origin[k];
    }
    span_surface(frame);
}

EnfSurface enf_default_surface(void) {
    EnfSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    surface.cell = surface.portal = surface.opening = surface.object = ENF_NONE;
    return surface;
}

EnfStatus enf_raycaster_surface(const EnfRaycaster *r, uint32_t surface, EnfSurface *out) {
    if (!r || !out || out->struct_size != sizeof *out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycaster_surface: NULL argument or bad struct_size");
    uint64_t leaves = (uint64_t)r->face_count + r->scene->portal_count;
    if (surface >= leaves + (r->furniture ? r->furniture->count : 0))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycaster_surface: no surface %u", surface);
    SurfaceFrame frame;
    enf_surface_frame(r, surface, &frame);
    *out = enf_default_surface();
    if (surface < r->face_count) {
        out->kind = ENF_SURFACE_FACE;
        out->cell = cell_of_face(r, surface);
    } else if (surface < leaves) {
        out->kind = ENF_SURFACE_LEAF;
        out->portal = surface - r->face_count;
        out->opening = r->scene->portal_openings[out->portal];
    } else {
        out->kind = ENF_SURFACE_FURNITURE;
        out->object = r->furniture->triangles[surface - leaves].object;
    }
    vec_copy(out->normal, frame.normal);
    vec_add(out->point, frame.point, r->scene->origin);
    vec_copy(out->u, frame.u);
    vec_copy(out->v, frame.v);
    return ENF_OK;
}
