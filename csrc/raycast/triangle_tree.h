/* SPDX-License-Identifier: GPL-3.0-or-later
 * The triangles behind enfilade/triangles.h, as the ray engines read them. Internal to the core. */
#ifndef ENF_RAYCAST_TRIANGLE_TREE_H
#define ENF_RAYCAST_TRIANGLE_TREE_H

#include "enfilade/triangles.h"
#include "raycast/embree.h"

/* What a ray can meet. Triangles of clear material are nobody's. */
enum { ENF_MEET_OPAQUE = 1, ENF_MEET_GLASS = 2, ENF_MEET_ALL = 3 };
enum { ENF_TREE_SCENES = 2 }; /* one for each bit above: shadows pass glass without asking triangle by triangle */

typedef struct TreeMemory TreeMemory; /* Embree's count of its bytes */

typedef struct TriangleTree {
    Embree embree;
    RTCDevice device;
    RTCScene scenes[ENF_TREE_SCENES];               /* NULL: no such triangle */
    uint32_t (*corner_numbers[ENF_TREE_SCENES])[3]; /* triangle t's are 3 t, 3 t + 1, 3 t + 2 */
    TreeMemory *memory;
} TriangleTree;

typedef struct TreeTriangle {
    uint32_t material;
    uint32_t object;
} TreeTriangle;

struct EnfTriangles {
    double origin[3];
    int committed;
    EnfMaterial *materials;
    uint32_t material_count;
    uint32_t count;
    uint32_t without_area;
    TreeTriangle *triangles;
    float (*corners)[3][3]; /* about the origin; room for one more at the end: Embree reads 16 bytes at a
                               corner */
    int16_t (*normals)[9];  /* as 1/32767; NULL until a mesh brings some */
    TriangleTree tree;
};

typedef struct TreeHit {
    double distance;
    double u, v;       /* weights of the second and third corner */
    uint32_t triangle; /* ENF_NONE: none */
} TreeHit;

/* ENF_ERROR_IO: no Embree. */
EnfStatus enf_triangle_tree_build(EnfTriangles *triangles);
void enf_triangle_tree_free(TriangleTree *tree); /* zeroed is fine */
uint64_t enf_triangle_tree_bytes(const TriangleTree *tree);

/* The nearest hit within (nearest, farthest) of committed triangles. origin: about theirs. Embree rounds to
 * single precision and leaves no gap between triangles that share an edge (its robust mode); the distance is
 * then taken again from the plane in double. */
TreeHit enf_tree_hit(const EnfTriangles *triangles, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet);
/* The same for rays of neighbouring pixels, met together; origins as given, not about the triangles'. hits: [count] out. */
enum { TREE_RAYS = 16 }; /* at most */
typedef struct TreeRay {
    double origin[3], direction[3]; /* direction: unit length */
    double nearest, farthest;
} TreeRay;
void enf_tree_hits(const EnfTriangles *triangles, const TreeRay *rays, uint32_t count, uint32_t meet, TreeHit *hits);
/* Metres that further rays keep off the surface they start at and shadow rays off the light they end at: above the rounding of
 * single-precision vertices, below what a lamp shade is thick. */
static const double clearance = 1e-4;
/* Whether anything lies within (nearest, farthest). */
int enf_tree_blocked(const EnfTriangles *triangles, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet);
/* The same for many rays, asked in packets as they follow each other. blocked: [count] in: 1, not to be asked; out: 1 also where something
 * opaque lies nearer than farthest. */
typedef struct TreeRays {
    uint32_t count;
    const float *origin[3];    /* [count] each, about the triangles' */
    const float *direction[3]; /* [count] each */
    const float *farthest;     /* [count] */
    uint8_t *blocked;
} TreeRays;
void enf_tree_blocked_rays(const EnfTriangles *triangles, const TreeRays *rays);
void enf_tree_plane_normal(const EnfTriangles *triangles, uint32_t triangle, double out[3]);
/* The shading normal at a hit, unit length; the plane's where the mesh has none. */
void enf_tree_shading_normal(const EnfTriangles *triangles, const TreeHit *hit, double out[3]);

#endif
