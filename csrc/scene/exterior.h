/* SPDX-License-Identifier: GPL-3.0-or-later
 * The outdoors as convex cells: what the building is made of (bodies), what is left of a box round it (space),
 * and the cell beyond the box (hub). Coordinates are about the scene's origin unless said otherwise. */
#ifndef ENF_SCENE_EXTERIOR_H
#define ENF_SCENE_EXTERIOR_H

#include "geometry/box_tree.h"
#include "scene/convex_decomposition.h"
#include "scene/scene_data.h"

/* ---- exterior.c ------------------------------------------------------------------------------------------------- */
/* Whether portal p is one to the hub. */
int enf_leads_to(const EnfScene *scene, uint32_t p, uint32_t hub);

/* ---- exterior_walls.c: how far walls reach outwards ------------------------------------------------------------- */
/* Where two walls meet at a sharp corner they are cut off at this many times their thickness. */
#define ENF_MITRE 3.0
/* depths[f], for each face of each cell: metres from a room's face to the outer ends of its openings that lead to `hub`; 0:
 * none does, or the wall isn't of one thickness, or thicker than `wall` (floors and ceilings: `slab`). The scene's arrays are
 * derived. 0: out of memory. */
int enf_walls_measure(const EnfScene *scene, uint32_t hub, double wall, double slab, double *depths);

/* ---- exterior_bodies.c: convex bodies that no sight passes: rooms, and walls and slabs between them ---------- */
typedef struct EnfBodyFace {
    double n[3], d;        /* outward */
    double grown;          /* metres that it was moved out from the rooms' own faces */
    uint32_t first, count; /* corners, into EnfBodies.points */
} EnfBodyFace;

typedef struct EnfBody {
    uint32_t face_first, face_count;
    double box[6];
} EnfBody;

typedef struct EnfBodies {
    EnfBody *items;
    EnfBodyFace *faces;
    double (*points)[3];
    uint32_t count, face_count, point_count;
    uint32_t rooms; /* the first ones are cells of rooms, the others walls and slabs */
    double fine;    /* metres: what is closer than this touches */
    EnfBoxTree tree;
} EnfBodies;

/* Rooms' cells with each face moved out by its depth (enf_walls_measure), up to the rooms' tops; then what lies between two facing walls of
 * rooms no more than def->wall_gap metres apart, or floors and ceilings no more than def->slab_gap, unless a portal to `hub` leads in
 * there; looked for up to `beyond` metres behind the portal. The scene's arrays are derived. 0: out of memory. */
int enf_bodies_build(const EnfScene *scene, uint32_t hub, const EnfExteriorDef *def, double beyond, const double *depths,
                     EnfBodies *bodies);
void enf_bodies_free(EnfBodies *bodies);

/* Polygons in one pool. */
typedef struct EnfPieceSpan {
    uint32_t first, count;
} EnfPieceSpan;
typedef struct EnfPieces {
    EnfPieceSpan *items;
    double (*points)[3];
    uint32_t count, point_count;
} EnfPieces;
/* Scratch of the following; zero before the first call. */
typedef struct EnfCover {
    EnfPieces now, next;
    double (*a)[3], (*b)[3], (*c)[3];
} EnfCover;
/* What of a convex polygon lies in no body, each grown by `grow` metres: cover->now. `but`: a body that doesn't count, or
 * ENF_NONE. 0: out of memory. */
int enf_bodies_uncovered(const EnfBodies *bodies, double (*points)[3], uint32_t count, uint32_t but, double grow, EnfCover *cover);
void enf_cover_free(EnfCover *cover);

/* ---- exterior_space.c: the box less the bodies, as cells and seams --------------------------------------------- */
typedef struct EnfSpace {
    EnfDecomposition cells;   /* world */
    uint32_t leaves, reached; /* parts before merging, and those that sight reaches from outside */
    int gave_up;              /* too complex, or it doesn't add up */
} EnfSpace;
/* box: outer bounds. seeds: points that are outdoors for certain. slit: gaps narrower than this many metres are none, and faces may
 * be moved that far into the bodies to fall together with others. 0: out of memory. */
int enf_space_build(const EnfScene *scene, const EnfBodies *bodies, const double box[6], double (*seeds)[3], uint32_t seed_count,
                    double slit, EnfSpace *space);

/* ---- exterior_hub.c: the cell beyond the box -------------------------------------------------------------------- */
/* Sets scene->hub, hub_axes and hub_box: an exterior cell without geometry whose portals to its room's other cells tile a
 * box's surface is all that lies outside of that box, and nothing inside. */
void enf_find_hub(EnfScene *scene);
/* Whether a point (about the origin) is in the hub, up to the tolerance; whether some of a box (world) may be. There is a hub. */
int enf_hub_holds(const EnfScene *scene, const double local[3]);
int enf_hub_touches(const EnfScene *scene, const double box[6]);

#endif
