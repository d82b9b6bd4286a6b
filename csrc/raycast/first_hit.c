/* SPDX-License-Identifier: GPL-3.0-or-later
 * What the rays of a picture meet: the triangles give the nearest one, then a walk through the cells goes as far as that and tells where it is. */
#include "raycast/first_hit.h"
#include "raycast/ray_kernel.h"

#include "geometry/vec3.h"

/* A drawn surface this far behind the cell's face stands in the thickness of its wall; farther, and the cells don't know the place. */
static const double wall_depth = 0.6; /* metres */
/* Cameras that clip farther than this may stand outside the room they show: the walk starts where the picture does. */
static const double near_walk = 0.25; /* metres */

static const EnfMaterial plain = {ENF_MATERIAL_DIFFUSE, {0.8f, 0.8f, 0.8f}, {0, 0, 0}, 1};

/* How a ray went through the cells. */
typedef struct Walked {
    double wall; /* where it met one; infinity: none so far */
    uint32_t surface, cell, openings;
} Walked;

/* In doubles, from anywhere. */
static void walk_alone(const EnfRaycaster *r, const SightRay *sight, double end, Walked *out) {
    EnfRay ray = {{0, 0, 0}, {sight->ray.direction[0], sight->ray.direction[1], sight->ray.direction[2]}, 0, sight->cell, 0};
    EnfRayHit hit;
    double from = sight->ray.nearest > near_walk ? sight->ray.nearest : 0;
    vec_mad(ray.origin, sight->ray.origin, from, sight->ray.direction);
    ray.cell = from > 0 ? ENF_NONE : sight->cell;
    ray.max_distance = fmin(end, sight->ray.farthest) - from;
    if (enf_raycast_rays(r, &ray, 1, &hit) == ENF_OK)
        *out = (Walked){hit.surface != ENF_NONE ? hit.distance + from : INFINITY, hit.surface, hit.cell, hit.openings};
}

/* Many at once in single precision, as far as the triangles they met: enough to tell the cell there. which: [count] of the rays, all from
 * one known cell. */
static void walk_together(const EnfRaycaster *r, const SightRay *rays, const TreeHit *hits, const uint32_t *which, uint32_t count,
                          int openings, Walked *out) {
    RayBlock block;
    block.count = count;
    block.targets = block.aheads = 0;
    block.ways = openings != 0;
    for (uint32_t i = 0; i < count; i++) {
        const SightRay *sight = &rays[which[i]];
        for (int k = 0; k < 3; k++) {
            block.o[k][i] = (float)(sight->ray.origin[k] - r->scene->origin[k]);
            block.d[k][i] = (float)sight->ray.direction[k];
        }
        block.limit[i] = (float)fmin(hits[which[i]].distance, sight->ray.farthest);
        block.cell[i] = sight->cell;
        block.way[0][i] = block.way[1][i] = block.place[i] = 0;
    }
    enf_ray_block_walk(r, &block);
    for (uint32_t i = 0; i < count; i++) {
        Walked *walked = &out[which[i]];
        *walked = (Walked){block.link[i] != ENF_NONE ? block.distance[i] : INFINITY, block.link[i], block.cell[i], 0};
        if (!openings)
            continue;
        uint32_t same = 0; /* the same portals one after another: through the same openings */
        while (same < i && (block.way[0][same] != block.way[0][i] || block.way[1][same] != block.way[1][i] ||
                            block.cell[same] != block.cell[i] || block.portals[same] != block.portals[i]))
            same++;
        if (same < i)
            walked->openings = out[which[same]].openings;
        else
            walk_alone(r, &rays[which[i]], hits[which[i]].distance, walked);
    }
}

static void walk(const EnfPreview *p, const SightRay *rays, uint32_t count, const TreeHit *hits, int openings, Walked *out) {
    uint32_t together[TREE_RAYS], found = 0;
    for (uint32_t i = 0; i < count; i++) {
        out[i] = (Walked){INFINITY, ENF_NONE, ENF_NONE, 0};
        if (!p->raycaster || !rays[i].known)
            continue;
        if (p->triangles && rays[i].cell != ENF_NONE && rays[i].ray.nearest <= near_walk)
            together[found++] = i;
        else
            walk_alone(p->raycaster, &rays[i], hits[i].distance, &out[i]);
    }
    if (found)
        walk_together(p->raycaster, rays, hits, together, found, openings, out);
}

static void show_face(const EnfPreview *p, uint32_t surface, Seen *out) {
    const EnfScene *scene = p->raycaster->scene;
    uint32_t faces = p->raycaster->face_count;
    vec_copy(out->plane, surface < faces ? scene->face_planes[surface].n : scene->portal_planes[surface - faces].n);
    vec_copy(out->normal, out->plane);
    out->material = p->face_materials ? p->face_materials[surface] : plain;
    out->object = surface;
}

static void show_triangle(const EnfTriangles *tree, const TreeHit *hit, Seen *out) {
    const TreeTriangle *t = &tree->triangles[hit->triangle];
    enf_tree_plane_normal(tree, hit->triangle, out->plane);
    enf_tree_shading_normal(tree, hit, out->normal);
    out->material = tree->materials[t->material];
    out->object = t->object;
}

static void assemble(const EnfPreview *p, const TreeRay *ray, const TreeHit *hit, const Walked *walked, Seen *out) {
    *out = (Seen){.distance = hit->distance, .object = ENF_NONE, .cell = walked->cell, .openings = walked->openings};
    if (hit->triangle != ENF_NONE) {
        show_triangle(p->triangles, hit, out);
        if (out->distance > walked->wall + wall_depth)
            out->cell = ENF_NONE;
    } else if (!p->triangles && walked->wall > ray->nearest) {
        out->distance = walked->wall;
        if (walked->surface != ENF_NONE)
            show_face(p, walked->surface, out);
    }
    if (out->distance == INFINITY)
        return;
    vec_mad(out->position, ray->origin, out->distance, ray->direction);
    vec_mad(out->walk_from, ray->origin, fmin(out->distance, walked->wall) * (1 - 1e-7) - fmin(clearance, 0.5 * out->distance),
            ray->direction);
    if ((vec_dot(out->plane, ray->direction) > 0) == (vec_dot(out->normal, out->plane) > 0))
        vec_scale(out->normal, -1, out->normal);
}

void enf_first_hits(const EnfPreview *p, const SightRay *rays, uint32_t count, int openings, Seen *out) {
    TreeRay aims[TREE_RAYS] = {{{0, 0, 0}, {0, 0, 0}, 0, 0}};
    TreeHit hits[TREE_RAYS];
    Walked walked[TREE_RAYS];
    for (uint32_t i = 0; i < count; i++) {
        aims[i] = rays[i].ray;
        hits[i] = (TreeHit){INFINITY, 0, 0, ENF_NONE};
    }
    if (p->triangles)
        enf_tree_hits(p->triangles, aims, count, ENF_MEET_ALL, hits);
    walk(p, rays, count, hits, openings, walked);
    for (uint32_t i = 0; i < count; i++)
        assemble(p, &rays[i].ray, &hits[i], &walked[i], &out[i]);
}
