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

static void sort_sides(EnfRaycaster *r, uint32_t c, uint32_t *face_of) {
    const EnfScene *scene = r->scene;
    uint32_t first = scene->cell_portal_first[c], end = scene->cell_portal_first[c + 1], at = first;
    for (uint32_t s = first; s < end; s++)
        face_of[s - first] = face_of_portal(scene, c, &scene->cell_portals[s]);
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
        r->faces[f].side_first = at;
        for (uint32_t s = first; s < end; s++)
            if (face_of[s - first] == f) {
                double off = portal_off_face(scene, &scene->cell_portals[s], &scene->face_planes[f]) + scene->tolerance;
                r->faces[f].off = fmaxf(r->faces[f].off, 1.0001f * (float)off);
                r->sides[at++] = s;
            }
        r->faces[f].side_count = at - r->faces[f].side_first;
    }
    for (uint32_t s = first; s < end; s++)
        if (face_of[s - first] == ENF_NONE)
            r->sides[at++] = s;
}

/* Twice the area of a fan of corners, added up one after another. */
typedef struct Fan {
    double first[3], last[3], area[3];
    uint32_t count;
} Fan;
static void add_corner(Fan *fan, const double p[3]) {
    double now[3], cross[3];
    if (fan->count++ == 0)
        vec_copy(fan->first, p);
    vec_sub(now, p, fan->first);
    if (fan->count > 2) {
        vec_cross(cross, fan->last, now);
        vec_add(fan->area, fan->area, cross);
    }
    vec_copy(fan->last, now);
}

static int is_whole(const EnfRaycaster *r, uint32_t cell, uint32_t face) {
    Fan of_face = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0}, of_portal = of_face;
    double p[3];
    if (r->faces[face].side_count != 1)
        return 0;
    RayPortal portal = enf_ray_portal(r, r->faces[face].side_first);
    for (uint32_t i = 0; i < enf_ray_face_corners(r, face); i++) {
        enf_ray_face_corner(r, cell, face, i, p);
        add_corner(&of_face, p);
    }
    for (uint32_t i = 0; i < portal.corner_count; i++) {
        enf_ray_portal_corner(r, &portal, i, p);
        add_corner(&of_portal, p);
    }
    /* a millionth of it: no gap that anyone drew; the scene's own tolerance: in its plane */
    return vec_length(of_portal.area) >= (1 - 1e-6) * vec_length(of_face.area) &&
           portal_off_face(r->scene, &r->scene->cell_portals[r->sides[r->faces[face].side_first]], &r->scene->face_planes[face]) <=
               2 * r->scene->tolerance;
}

EnfStatus enf_raycaster_create(const EnfScene *scene, EnfRaycaster **out_raycaster) {
    if (!scene || !out_raycaster)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycaster_create: NULL argument");
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_raycaster_create: the scene isn't committed");
    EnfRaycaster *r = ENF_NEW(EnfRaycaster, 1);
    if (!r)
        return enf_fail_memory();
    uint32_t cells = scene->cell_count, most = 0;
    r->scene = scene;
    r->cell_count = cells;
    r->face_count = scene->cell_face_first[cells];
    for (uint32_t c = 0; c < cells; c++) {
        uint32_t sides = scene->cell_portal_first[c + 1] - scene->cell_portal_first[c];
        most = sides > most ? sides : most;
    }
    r->faces = ENF_NEW(RayFace, r->face_count);
    r->sides = ENF_NEW(uint32_t, scene->cell_portal_first[cells]);
    uint32_t *face_of = ENF_NEW(uint32_t, most);
    if (!r->faces || !r->sides || !face_of) {
        enf_free(face_of);
        enf_raycaster_destroy(r);
        return enf_fail_memory();
    }
    for (uint32_t c = 0; c < cells; c++) {
        sort_sides(r, c, face_of);
        for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++)
            r->faces[f].whole = (uint32_t)is_whole(r, c, f);
    }
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
    enf_free(r->faces);
    enf_free(r->sides);
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

uint32_t enf_raycaster_face_count(const EnfRaycaster *r) {
    return r ? r->face_count : 0;
}
