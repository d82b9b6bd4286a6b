/* SPDX-License-Identifier: GPL-3.0-or-later
 * Convex polyhedra that are cut by planes: face loops over a pool of vertices which the pieces share, so that
 * a vertex cut once has the same bits in every piece. */
#ifndef ENF_GEOMETRY_CONVEX_SOLID_H
#define ENF_GEOMETRY_CONVEX_SOLID_H

#include "enfilade/base.h"

typedef struct EnfVertexPool {
    double (*points)[3];
    uint32_t count;
} EnfVertexPool;

/* `plane` is 2 p + side: the face lies in plane p of the caller's list; side 0: the solid is behind it (n.x
 * <= d), its outward normal is n; side 1: the solid is in front. ENF_NONE: a face of the first box. */
typedef struct EnfSolidFace {
    uint32_t first, count, plane;
} EnfSolidFace;

typedef struct EnfSolid {
    EnfSolidFace *faces;
    uint32_t *indices; /* counter-clockwise seen from outside */
    uint32_t face_count, index_count;
} EnfSolid;

void enf_solid_free(EnfSolid *solid);
int enf_solid_add_face(EnfSolid *solid, const uint32_t *loop, uint32_t count, uint32_t plane); /* 0: out of memory */
int enf_solid_box(EnfSolid *solid, EnfVertexPool *pool, const double box[6]);                  /* 0: out of memory */

/* Cuts by plane number p, n.x = d; vertices within eps count as on it. Fills *back (n.x <= d) and *front; one
 * of them stays empty (face_count 0) when the solid doesn't reach that side. 0: out of memory. */
int enf_solid_cut(const EnfSolid *solid, EnfVertexPool *pool, uint32_t p, const double n[3], double d, double eps, EnfSolid *back,
                  EnfSolid *front);

double enf_solid_volume(const EnfSolid *solid, const EnfVertexPool *pool);
void enf_solid_bounds(const EnfSolid *solid, const EnfVertexPool *pool, double box[6]);
/* Mean of the corners, each counted once a face: inside. */
void enf_solid_centre(const EnfSolid *solid, const EnfVertexPool *pool, double centre[3]);

#endif
