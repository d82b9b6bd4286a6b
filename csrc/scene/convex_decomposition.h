/* SPDX-License-Identifier: GPL-3.0-or-later
 * A room's shape cut into convex cells and the seams between them. */
#ifndef ENF_SCENE_CONVEX_DECOMPOSITION_H
#define ENF_SCENE_CONVEX_DECOMPOSITION_H

#include "scene/solid_bsp.h"

typedef struct EnfSeam {
    uint32_t cells[2];
    uint32_t first, count; /* into seam_points */
} EnfSeam;

typedef struct EnfDecomposition {
    /* Cell c: vertices points[cell_point_first[c] ...], faces cell_face_first[c] ... with face_sizes[f]
     * indices, relative to the cell's first point, in turn in face_indices. A cell without faces: the hull of
     * its points is meant. */
    uint32_t cell_count;
    uint32_t *cell_point_first, *cell_face_first, *face_sizes, *face_indices;
    double (*points)[3]; /* world, metres */
    EnfSeam *seams;
    uint32_t seam_count;
    double (*seam_points)[3]; /* world, metres; counter-clockwise seen from cells[0] */
    /* What was odd about the shape. */
    uint32_t not_closed; /* edges without a partner: the hull is given instead */
    uint32_t not_planar; /* faces split into triangles */
    uint32_t inside_out; /* 1: faces were clockwise from outside */
    uint32_t gave_up;    /* 1: too complex, or the pieces' volume isn't the shape's: the hull is given instead */
    uint32_t facets;     /* of curved walls taken together (curved_walls.h) */
    double depth;        /* metres that cells reach into those walls at most */
    double volume;       /* of the cells' pieces, m3; 0 for a hull */
    double shape_volume; /* of the given shape, with facets taken together */
} EnfDecomposition;

/* ENF_ERROR_BAD_INPUT: not finite, indices out of range, no faces at all. The result is freed by
 * enf_decomposition_free. */
EnfStatus enf_decompose_polyhedron(EnfDecomposition *out, double (*vertices)[3], uint32_t vertex_count, const uint32_t *face_sizes,
                                   uint32_t face_count, const uint32_t *face_indices);
EnfStatus enf_decompose_prism(EnfDecomposition *out, const double *corners, const uint32_t *ring_sizes, uint64_t ring_count, double z0,
                              double z1);
void enf_decomposition_free(EnfDecomposition *decomposition);

/* room_shape.c: what the two above start with. 0 on success, see ENF_SHAPE_*. coarse: resolution by this
 * factor, 1 as a rule. */
enum { ENF_SHAPE_OK = 0, ENF_SHAPE_NO_MEMORY = 1, ENF_SHAPE_NOT_CLOSED = 2 };
int enf_shape_from_polyhedron(EnfShape *shape, EnfDecomposition *notes, double coarse, double (*vertices)[3], uint32_t vertex_count,
                              const uint32_t *face_sizes, uint32_t face_count, const uint32_t *face_indices);
int enf_shape_from_prism(EnfShape *shape, double coarse, const double *corners, const uint32_t *ring_sizes, uint64_t ring_count, double z0,
                         double z1);
void enf_shape_free(EnfShape *shape);
/* A convex piece of face number `face` in plane number `plane`. 0: no memory. */
int enf_shape_add_fragment(EnfShape *shape, double (*points)[3], uint32_t count, uint32_t plane, uint32_t face);
/* EnfShapePlane.weight from the planes' areas. */
void enf_shape_weigh_directions(EnfShape *shape);

/* Cells and seams from convex pieces of `shape`; corners closer than eps become one. 0: no memory. */
int enf_decomposition_write(EnfDecomposition *d, const EnfShape *shape, const EnfSolidList *solids);
/* Whether all faces of all cells are shape->surface or seams, counted twice. */
int enf_decomposition_balances(const EnfDecomposition *d, const EnfShape *shape);

/* room_seams.c: fills seams and seam_points from the solids; vertex `i` of the pool is given out as world[i].
 * 0: no memory. */
int enf_seams_build(EnfDecomposition *out, const EnfShape *shape, const EnfSolidList *solids, double (*world)[3]);

#endif
