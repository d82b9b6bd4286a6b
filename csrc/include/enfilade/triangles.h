/* SPDX-License-Identifier: GPL-3.0-or-later
 * What is drawn, as triangles: furniture, and walls as they are drawn, with what each surface does to a ray.
 *
 * Life: create, add the meshes of the objects that a question needs (visible ones: nothing else has to be loaded), commit, then any
 * number of concurrent queries. Vertices are kept in single precision about an origin of the caller's choice; arrays are copied.
 * Threads: "safe on different handles"; queries on committed triangles are thread-safe, while nobody adds to them.
 * Errors of all calls: ENF_ERROR_INVALID_ARGUMENT for a NULL, ENF_ERROR_OUT_OF_MEMORY; others beside the call. */
#ifndef ENFILADE_TRIANGLES_H
#define ENFILADE_TRIANGLES_H

#include "enfilade/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnfTriangles EnfTriangles;

enum {
    ENF_MATERIAL_DIFFUSE = 0,
    ENF_MATERIAL_MIRROR = 1, /* reflects all it doesn't absorb */
    ENF_MATERIAL_GLASS = 2,  /* reflects by Fresnel, refracts the rest; lets light through to what lies behind */
    ENF_MATERIAL_CLEAR = 3   /* drawn, but not there for any ray: alpha below one half */
};

typedef struct EnfMaterial {
    uint32_t kind;     /* ENF_MATERIAL_* */
    float colour[3];   /* linear, 0 .. 1: what a diffuse surface gives back, a mirror reflects, glass lets through */
    float emission[3]; /* linear radiance */
    float ior;         /* of glass; 1: panes that don't bend */
} EnfMaterial;

/* origin: what coordinates are taken relative to, metres; the middle of the scene keeps the digits. The caller destroys what is made.
 * ENF_ERROR_BAD_INPUT: it isn't finite. */
ENF_API EnfStatus enf_triangles_create(const double origin[3], EnfTriangles **out_triangles);
ENF_API void enf_triangles_destroy(EnfTriangles *triangles); /* NULL is fine */

/* Gives its number: 1 and on; 0 is a grey that is always there. ENF_ERROR_BAD_INPUT: a number that isn't finite, an unknown kind. */
ENF_API EnfStatus enf_triangles_add_material(EnfTriangles *triangles, const EnfMaterial *material, uint32_t *out_material);

/* vertices: double[3] each, world metres. corners: three vertex numbers a triangle. materials: [triangle_count] from add_surface, NULL:
 * material 0 of a grey everybody has. normals: float[9] a triangle, its corners' shading normals, NULL: flat.
 * object: any number, given back by hits. Triangles without area are left out. ENF_ERROR_BAD_INPUT: a coordinate that isn't finite, a
 * vertex number out of range (names the first). */
ENF_API EnfStatus enf_triangles_add_mesh(EnfTriangles *triangles, uint32_t object, const double *vertices, uint64_t vertex_count,
                                         uint64_t vertex_stride, const uint32_t *corners, uint64_t triangle_count,
                                         const uint32_t *materials, const float *normals);

/* Builds Embree's hierarchy. Adding afterwards un-commits. ENF_ERROR_IO: Embree 3 isn't there (never with no triangle at all). */
ENF_API EnfStatus enf_triangles_commit(EnfTriangles *triangles);

typedef struct EnfTriangleCounts {
    uint32_t struct_size;
    uint32_t committed;
    uint64_t triangles;
    uint64_t without_area; /* left out */
    uint64_t bytes;        /* Embree's among them */
    uint32_t materials;
    uint32_t reserved;
} EnfTriangleCounts;
ENF_API EnfTriangleCounts enf_default_triangle_counts(void);
ENF_API EnfStatus enf_triangles_counts(const EnfTriangles *triangles, EnfTriangleCounts *out_counts);

/* The nearest triangle on a ray. distance: in units of the direction's length; infinity: none. normal: of the triangle's plane, unit
 * length, as wound. Thread-safe. */
typedef struct EnfTriangleHit {
    double distance;
    double normal[3];
    uint32_t triangle; /* ENF_NONE: none */
    uint32_t object;
    uint32_t material;
    uint32_t reserved;
} EnfTriangleHit;
/* origins, directions: double[3] each. max_distances: [count], NULL: none. */
ENF_API EnfStatus enf_triangles_hit(const EnfTriangles *triangles, const double *origins, const double *directions,
                                    const double *max_distances, uint64_t count, EnfTriangleHit *out_hits);

#ifdef __cplusplus
}
#endif
#endif
