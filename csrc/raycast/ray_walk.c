/* SPDX-License-Identifier: GPL-3.0-or-later
 * Single rays: from cell to cell through the face they leave by.
 *
 * Based on: Maria, Horna, Aveneau 2014 (walk through convex volumes); Woop, Benthin, Wald, Watertight ray/triangle intersection, 2013
 * (one sign rule for an edge that two polygons share). */
#include "raycast/ray_model.h"

#include "base/status.h"
#include "geometry/vec3.h"

/* On which side of the edge a-b the ray passes. Antisymmetric bit by bit: seen from the other polygon on that edge it is the exact
 * negative, so that with ties on one side no ray slips between two neighbours. */
static double edge_side(const double o[3], const double d[3], const double a[3], const double b[3]) {
    double p[3], q[3], n[3];
    vec_sub(p, a, o);
    vec_sub(q, b, o);
    vec_cross(n, p, q);
    return vec_dot(d, n);
}

static int passes(const EnfRaycaster *r, const RayPortal *portal, const double o[3], const double d[3]) {
    double a[3], b[3];
    enf_ray_portal_corner(r, portal, portal->corner_count - 1, a);
    for (uint32_t i = 0; i < portal->corner_count; i++) {
        /* counter-clockwise seen from inside, looking out: inside is negative. On the edge counts as through. */
        enf_ray_portal_corner(r, portal, i, b);
        if (edge_side(o, d, a, b) > 0)
            return 0;
        vec_copy(a, b);
    }
    return 1;
}

static double portal_distance(const EnfRaycaster *r, const RayPortal *portal, const double o[3], const double d[3]) {
    double to[3];
    enf_ray_portal_corner(r, portal, 0, to);
    vec_sub(to, to, o);
    return vec_dot(portal->normal, to) / vec_dot(portal->normal, d);
}

/* Whether the ray comes near the portal at all: where it crosses the face's plane lies the portal, as far off the plane as scenes may
 * be drawn. `slack`: metres along the plane. */
static int comes_near(const EnfScene *scene, uint32_t portal, const double at_face[3], double slack) {
    const double *centre = scene->portal_centres[portal];
    const double reach = scene->portal_radii[portal] + slack;
    const double x = centre[0] - at_face[0], y = centre[1] - at_face[1], z = centre[2] - at_face[2];
    return fabs(x) <= reach && x * x + y * y + z * z <= reach * reach;
}

RayStep enf_ray_step(const EnfRaycaster *r, uint32_t cell, const double o[3], const double d[3], double at) {
    const EnfScene *scene = r->scene;
    double out = INFINITY, out_speed = 1;
    uint32_t face = ENF_NONE;
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; f++) {
        const EnfPlane *plane = &scene->face_planes[f];
        double speed = vec_dot(plane->n, d), way = plane->d - vec_dot(plane->n, o); /* about the scene's origin: digits enough */
        if (speed > 0 && way < out * speed)
            out = way / speed, out_speed = speed, face = f;
    }
    /* The portals of that face; without a face, all, nearest first. */
    uint32_t first = face != ENF_NONE ? r->faces[face].side_first : scene->cell_portal_first[cell];
    uint32_t count = face != ENF_NONE ? r->faces[face].side_count : scene->cell_portal_first[cell + 1] - first;
    double at_face[3], slack = INFINITY, nearest = INFINITY;
    if (face != ENF_NONE && count > 1) {
        for (int k = 0; k < 3; k++)
            at_face[k] = scene->origin[k] + o[k] + out * d[k];
        slack = r->faces[face].off * vec_length(d) / out_speed;
    }
    RayPortal through = {ENF_NONE, ENF_NONE, 0, 0, 0, {0, 0, 0}};
    for (uint32_t s = first; s < first + count; s++) {
        if (slack < INFINITY && !comes_near(scene, scene->cell_portals[r->sides[s]].portal, at_face, slack))
            continue;
        RayPortal portal = enf_ray_portal(r, s);
        if (!(vec_dot(portal.normal, d) > 0) || !passes(r, &portal, o, d))
            continue;
        double t = portal_distance(r, &portal, o, d);
        /* outdoors isn't convex: portals behind the ray's place don't count */
        if (face == ENF_NONE && t < at - scene->tolerance)
            continue;
        if (t < nearest)
            nearest = t, through = portal;
    }
    RayStep step = {fmax(at, nearest < INFINITY ? nearest : out), ENF_NONE, ENF_NONE, ENF_NONE}; /* rounding never walks backwards */
    if (!(nearest < INFINITY))
        step.surface = face;
    else if (!enf_portal_passes(scene, through.portal))
        step.surface = r->face_count + through.portal;
    else {
        step.portal = through.portal;
        step.to = through.to;
    }
    return step;
}

static EnfRayHit walk(const EnfRaycaster *r, const EnfRay *ray, uint32_t cell) {
    const EnfScene *scene = r->scene;
    EnfRayHit hit = {INFINITY, ENF_NONE, cell, 0, 0};
    double o[3], at = 0;
    uint32_t last = ENF_NONE; /* opening passed last: a thick one has two portals and counts once */
    vec_sub(o, ray->origin, scene->origin);
    for (uint32_t left = enf_ray_cell_cap(r); left > 0; left--) {
        RayStep step = enf_ray_step(r, hit.cell, o, ray->direction, at);
        at = step.at;
        if (at >= ray->max_distance) {
            hit.distance = ray->max_distance;
            return hit;
        }
        if (step.portal == ENF_NONE) {
            hit.distance = step.surface != ENF_NONE ? at : INFINITY;
            hit.surface = step.surface;
            return hit;
        }
        hit.cell = step.to;
        hit.portals++;
        uint32_t opening = scene->portal_openings[step.portal];
        if (opening != ENF_NONE && opening != last)
            hit.openings++;
        last = opening;
    }
    return hit; /* the cap: nothing hit, in the last cell */
}

EnfStatus enf_raycast_rays(const EnfRaycaster *raycaster, const EnfRay *rays, uint64_t count, EnfRayHit *out_hits) {
    if (!raycaster || (count && (!rays || !out_hits)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycast_rays: NULL argument");
    for (uint64_t i = 0; i < count; i++) {
        const EnfRay *ray = &rays[i];
        uint32_t cell = ray->cell, found;
        EnfRayHit nothing = {INFINITY, ENF_NONE, ENF_NONE, 0, 0};
        out_hits[i] = nothing;
        if (!vec_finite(ray->origin) || !vec_finite(ray->direction) || !(vec_length(ray->direction) > 0))
            continue;
        if (cell == ENF_NONE && (enf_scene_locate(raycaster->scene, ray->origin, &cell, 1, &found) != ENF_OK || found == 0))
            continue;
        if (cell < raycaster->cell_count)
            out_hits[i] = walk(raycaster, ray, cell);
    }
    return ENF_OK;
}
