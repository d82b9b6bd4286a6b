/* SPDX-License-Identifier: GPL-3.0-or-later
 * From a room's shape to convex pieces: a binary space partition by the planes of its faces. */
#ifndef ENF_SCENE_SOLID_BSP_H
#define ENF_SCENE_SOLID_BSP_H

#include "geometry/convex_solid.h"

typedef struct EnfShapePlane {
    double n[3], d;
    double area;   /* of the room's faces in it */
    double weight; /* 0 .. 1: how much of the room's walls runs in this direction */
} EnfShapePlane;

/* A convex piece of a face that still lies inside its part of space. */
typedef struct EnfFragment {
    uint32_t first, count; /* into EnfShape.fragment_points */
    uint32_t plane, face;
} EnfFragment;

/* A room's shape in coordinates about its own middle. */
typedef struct EnfShape {
    EnfVertexPool pool; /* the given corners first, then what cuts add */
    uint32_t given_count;
    double (*given_world)[3]; /* the given corners as they came: given back bit for bit */
    double centre[3];
    EnfShapePlane *planes;
    uint32_t plane_count;
    EnfFragment *fragments;
    uint32_t fragment_count;
    double (*fragment_points)[3];
    uint32_t fragment_point_count;
    uint32_t face_count;
    double box[6];       /* of the corners */
    double size;         /* diagonal of box, metres */
    double eps;          /* metres: see convex_decomposition.c */
    double fragment_eps; /* metres: parts of faces this close before a plane that looks their way count as in it; eps, or more where the
                            caller makes sure of what is inside by other means */
    double fine;         /* eps before it was made coarser: what volumes and surfaces are judged by */
    double volume;       /* signed, of the given faces */
    double surface;
    uint32_t box_codes[6]; /* EnfSolidFace.plane of the first box's faces, in enf_solid_box's order: ENF_NONE unless some of
                              its faces are the shape's */
    int keeps_all;         /* every leaf is given, inside or outside, and `box` bounds them as it is */
    /* Prisms: even-odd test against the rings, and floor and ceiling as planes. */
    int prism;
    double z0, z1; /* about the centre */
    uint32_t z0_plane, z1_plane;
    double (*ring_corners)[2]; /* about the centre */
    const uint32_t *ring_sizes;
    uint64_t ring_count;
    /* Polyhedra: triangles for the winding number. */
    uint32_t (*triangles)[3];
    uint32_t triangle_count;
} EnfShape;

typedef struct EnfSolidList {
    EnfSolid *items;
    uint32_t count;
} EnfSolidList;

void enf_solid_list_free(EnfSolidList *list);

enum { ENF_BSP_OK = 0, ENF_BSP_NO_MEMORY = 1, ENF_BSP_TOO_COMPLEX = 2 };
/* Appends the convex pieces that lie inside the shape. */
int enf_bsp_build(EnfShape *shape, EnfSolidList *inside);
/* Joins pieces whose union is convex, largest shared faces first, until none is left. 0: out of memory. */
int enf_solids_merge(EnfShape *shape, EnfSolidList *list);

#endif
