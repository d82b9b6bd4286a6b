/* SPDX-License-Identifier: GPL-3.0-or-later
 * The triangles that stand in the rooms, and the hierarchy that finds those a ray meets. Internal to the core. */
#ifndef ENF_RAYCAST_FURNITURE_H
#define ENF_RAYCAST_FURNITURE_H

#include "enfilade/raycast.h"

typedef struct FurnitureMesh {
    uint32_t object, flags;
    uint32_t first_triangle;
    uint32_t reserved;
} FurnitureMesh;

typedef struct FurnitureNode FurnitureNode;
typedef struct FurnitureLeaf FurnitureLeaf;

typedef struct Furniture {
    FurnitureMesh *meshes;
    float (*vertices)[3];     /* relative to the raycaster's origin */
    uint32_t (*triangles)[3]; /* vertex numbers */
    uint32_t mesh_count, vertex_count, triangle_count;
    uint32_t committed; /* triangles in the hierarchy */
    FurnitureNode *nodes;
    uint32_t node_count;
    uint32_t *order; /* triangles, leaf by leaf */
} Furniture;

EnfStatus enf_furniture_add(Furniture *furniture, const double origin[3], uint32_t object, uint32_t flags, const double *vertices,
                            uint64_t vertex_count, uint64_t vertex_stride, const uint32_t *triangles, uint64_t triangle_count,
                            uint32_t *out_first);
EnfStatus enf_furniture_commit(Furniture *furniture);
void enf_furniture_free(Furniture *furniture);
const FurnitureMesh *enf_furniture_mesh_of(const Furniture *furniture, uint32_t triangle);

/* The nearest triangle met before *distance: its number, and *distance becomes its; ENF_NONE when there is none.
 * any: the first one found that casts a shadow will do. */
uint32_t enf_furniture_hit(const Furniture *furniture, const float origin[3], const float direction[3], int any, float *distance);

#endif
