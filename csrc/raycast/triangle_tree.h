/* SPDX-License-Identifier: GPL-3.0-or-later
 * The triangles behind enfilade/triangles.h, as the ray engines read them. Internal to the core. */
#ifndef ENF_RAYCAST_TRIANGLE_TREE_H
#define ENF_RAYCAST_TRIANGLE_TREE_H

#include "enfilade/triangles.h"

/* Four children side by side. A child is an inner node, a run of triangles (LEAF), or nothing (a box nobody enters). */
typedef struct TreeNode {
    float lo[3][4], hi[3][4];
    uint32_t child[4];
} TreeNode;

/* A leaf's child word: flag, triangles less one in 3 bits, first triangle in 28. */
#define ENF_TREE_LEAF  0x80000000u
#define ENF_TREE_FIRST 0x0FFFFFFFu

typedef struct TreeTriangle {
    float v[3][3]; /* about the origin */
    uint32_t material;
    uint32_t object;
    uint32_t input; /* number in order of adding */
} TreeTriangle;

struct EnfTriangles {
    double origin[3];
    double reach; /* the largest coordinate, metres about the origin */
    int committed;
    EnfMaterial *materials;
    uint32_t material_count;
    TreeTriangle *triangles; /* after commit in the tree's order */
    uint32_t count;
    int16_t (*normals)[9]; /* [input], as 1/32767; NULL until a mesh brings some */
    uint32_t without_area;
    TreeNode *nodes;
    uint32_t node_count;
};

/* What a ray can meet: bit k: materials of kind k. */
enum {
    ENF_MEET_ALL = (1 << ENF_MATERIAL_DIFFUSE) | (1 << ENF_MATERIAL_MIRROR) | (1 << ENF_MATERIAL_GLASS),
    ENF_MEET_OPAQUE = (1 << ENF_MATERIAL_DIFFUSE) | (1 << ENF_MATERIAL_MIRROR)
};

typedef struct TreeHit {
    double distance;
    double u, v;       /* weights of the second and third corner */
    uint32_t triangle; /* into triangles; ENF_NONE: none */
} TreeHit;

/* The nearest hit within (nearest, farthest); ties go to the triangle that was added first. origin: about the tree's origin. */
TreeHit enf_tree_hit(const EnfTriangles *tree, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet);
/* Whether anything lies within (nearest, farthest). */
int enf_tree_blocked(const EnfTriangles *tree, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet);
void enf_tree_plane_normal(const TreeTriangle *triangle, double out[3]);
/* The shading normal at a hit, unit length; the plane's where the mesh has none. */
void enf_tree_shading_normal(const EnfTriangles *tree, const TreeHit *hit, double out[3]);

#endif
