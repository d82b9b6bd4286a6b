/* SPDX-License-Identifier: GPL-3.0-or-later
 * Packs a scene for rays and finds the face that each portal lies in. */
#include "raycast/ray_model.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"
#include "raycast/triangle_tree.h"

/* How far the portal's corners lie from the face's plane, at most; infinity when the portal doesn't face that way. */
static double portal_off_face(const EnfScene *scene, const EnfCellPortal *side, const EnfPlane *face) {
    const EnfPlane *plane = &scene->portal_planes[side->portal];
    double along = vec_dot(plane->n, face->n) * (side->side ? -1 : 1), worst = 0;
    if (along <= 0.5)
        return INFINITY;
    for (uint32_t v = scene->portal_vertex_first[side->portal]; v < scene->portal_vertex_first[side->portal + 1]; v++) {
        double local[3];
        vec_sub(local, scene->portal_vertices[v], scene->origin);
        worst = fmax(worst, fabs(vec_dot(face->n, local) - face->d));
    }
    return worst;
}

/* The face that the portal lies in; ENF_NONE when the cell has none that faces its way. A portal somewhat off its face (a gap of a
 * centimetre between a room and the hole in its wall) belongs to the nearest. */
static uint32_t face_of_portal(const EnfScene *scene, uint32_t cell, const EnfCellPortal *side) {
    uint32_t best = ENF_NONE;
    double least = INFINITY;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; f++) {
        double off = portal_off_face(scene, side, &scene->face_planes[f]);
        if (off < least)
            least = off, best = f;
    }
    return best;
}

static void pack_portal(EnfRaycaster *r, RayPortal *out, uint32_t *corner_at, const EnfCellPortal *side) {
    const EnfScene *scene = r->scene;
    uint32_t first = scene->portal_vertex_first[side->portal], end = scene->portal_vertex_first[side->portal + 1];
    out->portal = side->portal;
    out->to = side->to;
    out->corner_first = *corner_at;
    out->corner_count = end - first;
    vec_scale(out->normal, side->side ? -1 : 1, scene->portal_planes[side->portal].n);
    /* committed corners run counter-clockwise seen from cells[0] */
    for (uint32_t i = 0; i < end - first; i++) {
        uint32_t v = side->side ? end - 1 - i : first + i;
        vec_sub(r->corners[(*corner_at)++], scene->portal_vertices[v], scene->origin);
    }
}

static void pack_cell(EnfRaycaster *r, uint32_t c, uint32_t *face_of, uint32_t *portal_at, uint32_t *corner_at) {
    const EnfScene *scene = r->scene;
    RayCell *cell = &r->cells[c];
    uint32_t side_first = scene->cell_portal_first[c], side_end = scene->cell_portal_first[c + 1];
    cell->face_first = scene->cell_face_first[c];
    cell->face_count = scene->cell_face_first[c + 1] - cell->face_first;
    cell->portal_first = *portal_at;
    cell->portal_count = side_end - side_first;
    for (uint32_t s = side_first; s < side_end; s++)
        face_of[s - side_first] = face_of_portal(scene, c, &scene->cell_portals[s]);
    for (uint32_t f = cell->face_first; f < cell->face_first + cell->face_count; f++) {
        RayFace *face = &r->faces[f];
        face->corner_first = scene->face_index_first[f];
        face->corner_count = scene->face_index_first[f + 1] - face->corner_first;
        vec_copy(face->normal, scene->face_planes[f].n);
        for (uint32_t i = face->corner_first; i < face->corner_first + face->corner_count; i++)
            r->face_corners[i] = scene->cell_vertex_first[c] + scene->face_indices[i];
        vec_copy(face->point, r->vertices[r->face_corners[face->corner_first]]);
        face->portal_first = *portal_at;
        for (uint32_t s = side_first; s < side_end; s++)
            if (face_of[s - side_first] == f)
                pack_portal(r, &r->portals[(*portal_at)++], corner_at, &scene->cell_portals[s]);
        face->portal_count = *portal_at - face->portal_first;
    }
    for (uint32_t s = side_first; s < side_end; s++)
        if (face_of[s - side_first] == ENF_NONE)
            pack_portal(r, &r->portals[(*portal_at)++], corner_at, &scene->cell_portals[s]);
}

EnfStatus enf_raycaster_create(const EnfScene *scene, EnfRaycaster **out_raycaster) {
    if (!scene || !out_raycaster)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycaster_create: NULL argument");
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_raycaster_create: the scene isn't committed");
    EnfRaycaster *r = ENF_NEW(EnfRaycaster, 1);
    if (!r)
        return enf_fail_memory();
    uint32_t cells = scene->cell_count, vertices = scene->cell_vertex_first[cells], most = 0;
    uint64_t corners = 0;
    r->scene = scene;
    r->cell_count = cells;
    r->face_count = scene->cell_face_first[cells];
    for (uint32_t p = 0; p < scene->portal_count; p++)
        corners += 2 * (uint64_t)(scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p]);
    for (uint32_t c = 0; c < cells; c++) {
        uint32_t sides = scene->cell_portal_first[c + 1] - scene->cell_portal_first[c];
        most = sides > most ? sides : most;
    }
    r->cells = ENF_NEW(RayCell, cells);
    r->faces = ENF_NEW(RayFace, r->face_count);
    r->portals = ENF_NEW(RayPortal, 2 * (uint64_t)scene->portal_count);
    r->corners = enf_alloc_array(corners, sizeof *r->corners);
    r->face_corners = ENF_NEW(uint32_t, scene->face_index_first[r->face_count]);
    r->vertices = enf_alloc_array(vertices, sizeof *r->vertices);
    uint32_t *face_of = ENF_NEW(uint32_t, most), portal_at = 0, corner_at = 0;
    if (!r->cells || !r->faces || !r->portals || !r->corners || !r->face_corners || !r->vertices || !face_of) {
        enf_free(face_of);
        enf_raycaster_destroy(r);
        return enf_fail_memory();
    }
    for (uint32_t v = 0; v < vertices; v++)
        vec_sub(r->vertices[v], scene->cell_vertices[v], scene->origin);
    for (uint32_t c = 0; c < cells; c++)
        pack_cell(r, c, face_of, &portal_at, &corner_at);
    enf_free(face_of);
    r->lock = enf_mutex_create();
    r->state_serial = scene->state_serial;
    EnfStatus status = r->lock ? enf_prism_model_build(&r->prisms, r) : enf_fail_memory();
    if (status != ENF_OK) {
        enf_raycaster_destroy(r);
        return status;
    }
    *out_raycaster = r;
    return ENF_OK;
}

void enf_raycaster_destroy(EnfRaycaster *r) {
    if (!r)
        return;
    enf_free(r->cells);
    enf_free(r->faces);
    enf_free(r->portals);
    enf_free(r->corners);
    enf_free(r->face_corners);
    enf_free(r->vertices);
    enf_prism_model_free(&r->prisms);
    enf_mutex_destroy(r->lock);
    enf_free(r);
}

EnfStatus enf_raycaster_furnish(EnfRaycaster *r, const EnfTriangles *triangles) {
    if (!r)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycaster_furnish: NULL argument");
    if (triangles && !triangles->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_raycaster_furnish: the triangles aren't committed");
    r->furniture = triangles;
    return ENF_OK;
}

void enf_raycaster_follow_states(const EnfRaycaster *r) {
    if (__atomic_load_n(&r->state_serial, __ATOMIC_ACQUIRE) == r->scene->state_serial)
        return;
    EnfRaycaster *changing = (EnfRaycaster *)r; /* made by enf_raycaster_create, never const in itself */
    enf_mutex_lock(r->lock);
    if (r->state_serial != r->scene->state_serial) {
        enf_prism_model_set_doors(&changing->prisms, r);
        __atomic_store_n(&changing->state_serial, r->scene->state_serial, __ATOMIC_RELEASE);
    }
    enf_mutex_unlock(r->lock);
}

void enf_raycaster_origin(const EnfRaycaster *r, double out_origin[3]) {
    for (int k = 0; k < 3; k++)
        out_origin[k] = r ? r->scene->origin[k] : 0;
}

uint32_t enf_raycaster_face_count(const EnfRaycaster *r) { return r ? r->face_count : 0; }
