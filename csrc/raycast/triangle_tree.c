/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rays among triangles: a tree of boxes, four children a node, met nearest first.
 *
 * Based on: Wald, Benthin, Boulos, Getting rid of packets, 2008 (several boxes a ray); Ize, Robust BVH ray traversal, 2013 (why boxes are
 * met a few ulps early and left a few late); Woop, Benthin, Wald, Watertight ray/triangle intersection, 2013 (one sign rule for an edge
 * that two triangles share). It needs no library, so that every platform the add-on runs on draws the same picture. */
#include "raycast/triangle_tree.h"

#include "base/status.h"
#include "geometry/vec3.h"

enum { STACK = 3 * 64 }; /* a node pushes three at most, and the tree is at most 64 deep (triangle_build.c) */

#if defined(__GNUC__)
typedef float Four __attribute__((vector_size(16)));
typedef int32_t Mask __attribute__((vector_size(16)));
#else
#error "the four-wide boxes are written in the vector notation of GCC and Clang"
#endif

typedef struct TreeRay {
    double o[3], d[3];
    Four early[3], late[3], inverse[3]; /* the origin, moved back and forth by what single precision may lose */
    int negative[3];
} TreeRay;

static Four four(float x) { return (Four){x, x, x, x}; }
static Four least(Four a, Four b) {
    Mask m = a < b;
    return (Four)(((Mask)a & m) | ((Mask)b & ~m));
}
static Four most(Four a, Four b) {
    Mask m = a > b;
    return (Four)(((Mask)a & m) | ((Mask)b & ~m));
}

static void start_ray(TreeRay *ray, const EnfTriangles *tree, const double o[3], const double d[3]) {
    for (int k = 0; k < 3; k++) {
        double speed = fabs(d[k]) < 1e-30 ? copysign(1e-30, d[k]) : d[k]; /* no 0 times infinity */
        double lost = 1.2e-7 * fmax(fabs(o[k]), tree->reach);             /* one ulp of the larger: origin and box are rounded */
        ray->o[k] = o[k];
        ray->d[k] = d[k];
        ray->negative[k] = speed < 0;
        ray->inverse[k] = four((float)(1 / speed));
        ray->early[k] = four((float)(o[k] + lost));
        ray->late[k] = four((float)(o[k] - lost));
    }
}

/* Lanes of the node's boxes that the ray meets within (nearest, farthest), and where it enters each. */
static Mask meet_boxes(const TreeNode *node, const TreeRay *ray, float nearest, float farthest, float entered[4]) {
    Four in = four(nearest), out = four(farthest);
    for (int k = 0; k < 3; k++) {
        Four lo, hi;
        memcpy(&lo, node->lo[k], sizeof lo);
        memcpy(&hi, node->hi[k], sizeof hi);
        lo = (lo - ray->early[k]) * ray->inverse[k];
        hi = (hi - ray->late[k]) * ray->inverse[k];
        in = most(in, ray->negative[k] ? hi : lo);
        out = least(out, ray->negative[k] ? lo : hi);
    }
    memcpy(entered, &in, sizeof in);
    return in <= out * four(1.0000005f) + four(1e-30f);
}

/* d . (p x q) of an edge p-q about the ray's origin: the exact negative for the neighbour on that edge, who runs it backwards. */
static double edge(const double d[3], const double p[3], const double q[3]) {
    return d[0] * (p[1] * q[2] - p[2] * q[1]) + d[1] * (p[2] * q[0] - p[0] * q[2]) + d[2] * (p[0] * q[1] - p[1] * q[0]);
}

static int meet_triangle(const TreeTriangle *t, const TreeRay *ray, double nearest, double farthest, TreeHit *hit) {
    double a[3], b[3], c[3], ab[3], ac[3], n[3];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)t->v[0][k] - ray->o[k];
        b[k] = (double)t->v[1][k] - ray->o[k];
        c[k] = (double)t->v[2][k] - ray->o[k];
    }
    double wa = edge(ray->d, b, c), wb = edge(ray->d, c, a), wc = edge(ray->d, a, b);
    /* On an edge counts as in, for both: no ray slips between two triangles. */
    if ((wa < 0 || wb < 0 || wc < 0) && (wa > 0 || wb > 0 || wc > 0))
        return 0;
    double sum = wa + wb + wc;
    if (sum == 0)
        return 0; /* edge-on */
    vec_sub(ab, b, a);
    vec_sub(ac, c, a);
    vec_cross(n, ab, ac);
    double distance = vec_dot(n, a) / vec_dot(n, ray->d);
    if (!(distance > nearest && distance < farthest))
        return 0;
    hit->distance = distance;
    hit->u = wb / sum;
    hit->v = wc / sum;
    return 1;
}

typedef struct Pending {
    uint32_t child;
    float entered;
} Pending;

/* any: stop at the first hit. */
static TreeHit search(const EnfTriangles *tree, const double origin[3], const double direction[3], double nearest, double farthest,
                      uint32_t meet, int any) {
    TreeHit best = {INFINITY, 0, 0, ENF_NONE};
    if (!tree->node_count)
        return best;
    TreeRay ray;
    Pending stack[STACK];
    int height = 0;
    start_ray(&ray, tree, origin, direction);
    stack[height++] = (Pending){0, 0};
    while (height > 0) {
        Pending here = stack[--height];
        if ((double)here.entered > farthest)
            continue;
        if (here.child & ENF_TREE_LEAF) {
            uint32_t first = here.child & ENF_TREE_FIRST, count = ((here.child >> 28) & 7) + 1;
            for (uint32_t i = first; i < first + count; i++) {
                const TreeTriangle *t = &tree->triangles[i];
                TreeHit hit;
                if (!((meet >> tree->materials[t->material].kind) & 1) || !meet_triangle(t, &ray, nearest, farthest * (1 + 1e-15), &hit))
                    continue;
                hit.triangle = i;
                if (any)
                    return hit;
                if (hit.distance == best.distance && t->input > tree->triangles[best.triangle].input)
                    continue;
                if (hit.distance > best.distance)
                    continue;
                best = hit;
                farthest = hit.distance;
            }
            continue;
        }
        const TreeNode *node = &tree->nodes[here.child];
        float entered[4];
        Mask met = meet_boxes(node, &ray, (float)nearest, farthest < 3e38 ? (float)farthest : 3.4e38f, entered);
        int base = height;
        for (int k = 0; k < 4; k++) {
            if (!met[k])
                continue;
            int at = height++; /* the nearest on top */
            for (; at > base && stack[at - 1].entered < entered[k]; at--)
                stack[at] = stack[at - 1];
            stack[at] = (Pending){node->child[k], entered[k] * 0.9999995f};
        }
    }
    return best;
}

TreeHit enf_tree_hit(const EnfTriangles *tree, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet) {
    return search(tree, origin, direction, nearest, farthest, meet, 0);
}

int enf_tree_blocked(const EnfTriangles *tree, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet) {
    return search(tree, origin, direction, nearest, farthest, meet, 1).triangle != ENF_NONE;
}

void enf_tree_plane_normal(const TreeTriangle *t, double out[3]) {
    double ab[3], ac[3];
    for (int k = 0; k < 3; k++) {
        ab[k] = (double)t->v[1][k] - t->v[0][k];
        ac[k] = (double)t->v[2][k] - t->v[0][k];
    }
    vec_cross(out, ab, ac);
    vec_normalize(out);
}

void enf_tree_shading_normal(const EnfTriangles *tree, const TreeHit *hit, double out[3]) {
    const TreeTriangle *t = &tree->triangles[hit->triangle];
    if (tree->normals) {
        const int16_t *n = tree->normals[t->input];
        for (int k = 0; k < 3; k++)
            out[k] = (1 - hit->u - hit->v) * n[k] + hit->u * n[3 + k] + hit->v * n[6 + k];
        if (vec_normalize(out) > 100) /* of 32767: flat meshes are zero */
            return;
    }
    enf_tree_plane_normal(t, out);
}

EnfStatus enf_triangles_hit(const EnfTriangles *triangles, const double *origins, const double *directions, const double *max_distances,
                            uint64_t count, EnfTriangleHit *out_hits) {
    if (!triangles || (count && (!origins || !directions || !out_hits)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_hit: NULL argument");
    if (!triangles->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_triangles_hit: the triangles aren't committed");
    for (uint64_t i = 0; i < count; i++) {
        EnfTriangleHit *out = &out_hits[i];
        double o[3];
        const double *d = directions + 3 * i;
        *out = (EnfTriangleHit){INFINITY, {0, 0, 0}, ENF_NONE, ENF_NONE, ENF_NONE, 0};
        vec_sub(o, origins + 3 * i, triangles->origin);
        if (!vec_finite(o) || !vec_finite(d) || !(vec_length(d) > 0))
            continue;
        TreeHit hit = enf_tree_hit(triangles, o, d, 0, max_distances ? max_distances[i] : INFINITY, ENF_MEET_ALL);
        if (hit.triangle == ENF_NONE)
            continue;
        const TreeTriangle *t = &triangles->triangles[hit.triangle];
        out->distance = hit.distance;
        out->triangle = t->input;
        out->object = t->object;
        out->material = t->material;
        enf_tree_plane_normal(t, out->normal);
    }
    return ENF_OK;
}
