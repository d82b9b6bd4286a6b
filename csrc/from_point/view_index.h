/* SPDX-License-Identifier: GPL-3.0-or-later
 * A committed scene packed for traversal: what a visited cell needs lies together, so that cost follows what is visible. */
#ifndef ENF_FROM_POINT_VIEW_INDEX_H
#define ENF_FROM_POINT_VIEW_INDEX_H

#include "from_point/block_tree.h"
#include "scene/scene_data.h"

/* One side of a portal: how the cell it belongs to looks out through it. 64 bytes. */
typedef struct EnfPortalSide {
    double n[3];   /* unit, out of the cell */
    double offset; /* n . (p - origin), metres */
    double slack;  /* metres: how far from its plane the portal's surface strays; > 0: take hulls, cross generously */
    uint32_t to, portal, opening;
    uint32_t vertex_first;
    uint32_t vertex_count;
    uint32_t glance; /* into EnfViewIndex.glances: a window seen from outdoors; ENF_NONE: none */
} EnfPortalSide;
typedef struct EnfGlance EnfGlance; /* glance.h */
typedef struct EnfGlanceDoor EnfGlanceDoor;
typedef struct EnfOpenFace EnfOpenFace; /* open_air.h */

/* Portal sides of one cell that lie in one wall: same direction, same plane as nearly as it goes, with a tree over their
 * boxes. wall -> window set -> window -> portal (Johansson & Roupe 2009, section 4.3); a wall seen from behind is one test. */
typedef struct EnfWall {
    double n[3];   /* unit, out of the cell */
    double offset; /* largest n . (p - origin) of its corners, metres */
    double spread; /* largest |n_side - n| */
    double slack;  /* largest slack of its sides, metres */
    EnfBlockTree tree;
    uint32_t slot_first; /* into wall_sides, in the tree's order */
    uint32_t reserved;
} EnfWall;
/* Cells with at least this many portal sides get walls. */
#define ENF_WALL_SIDES 24

enum { ENF_VIEW_CELL_FACES = 1, ENF_VIEW_CELL_LAST = 2, ENF_VIEW_CELL_OUTDOORS = 4, ENF_VIEW_CELL_PASSAGE = 8 };
typedef struct EnfViewCell {
    double centre[3];
    uint32_t flags; /* FACES: has geometry. LAST: an exterior hub, visited when all others are done. OUTDOORS: of an exterior room,
                       seen through many windows at once. PASSAGE: of an opening, with a portal at either end */
    uint32_t side_first, side_count;
    uint32_t vertex_first;           /* corners of its sides lie together, in the sides' order */
    uint32_t wall_first, wall_count; /* 0: few portals, looked at one by one */
    EnfBlockTree objects;
    uint32_t object_first;           /* slots of its objects, in the tree's order */
    uint32_t face_first, face_count; /* into open_faces: outdoors only */
    uint32_t reserved;
} EnfViewCell;

/* Boxes with a tree over them and what they stand for. */
typedef struct EnfBoxSet {
    EnfBoxes8 *blocks;
    EnfBlockTree tree;
    uint32_t *ids; /* [item_count] in the tree's order */
} EnfBoxSet;

typedef struct EnfViewIndex {
    const EnfScene *scene;
    uint64_t commit_serial;
    uint32_t users; /* views that share it; guarded by the lock */
    struct EnfMutex *lock;
    double origin[3];
    double reach;      /* largest coordinate of any box relative to the origin, metres */
    double tolerance;  /* metres */
    double indoors[6]; /* the box round all cells that aren't outdoors */
    EnfViewCell *cells;
    EnfPortalSide *sides;
    double (*vertices)[3]; /* counter-clockwise seen from the cell, in the user's frame */
    EnfWall *walls;
    EnfBoxes8 *wall_blocks;
    uint32_t *wall_sides; /* [slots] index into sides */
    uint32_t wall_count, wall_block_count, wall_slot_count;
    EnfGlance *glances;
    EnfGlanceDoor *glance_doors;
    EnfOpenFace *open_faces;
    uint32_t *open_sources, open_source_count;
    EnfBoxes8 *object_blocks;
    uint32_t *object_ids;     /* [slots] */
    uint32_t *occluder_first; /* [cells + 2] into occluders; the last is for those in no cell. NULL: there are none */
    uint32_t *occluders;      /* index into the scene's */
    EnfBoxSet unplaced;
    EnfBoxSet cell_boxes; /* cells that have bounds */
    uint32_t *boundless_cells;
    uint32_t boundless_count;
    EnfBoxSet all_objects;    /* for answers by the frustum */
    struct EnfVistas *vistas; /* vista.h */
} EnfViewIndex;

EnfStatus enf_view_index_create(const EnfScene *scene, EnfViewIndex **out_index);
void enf_view_index_retain(EnfViewIndex *index);
void enf_view_index_release(EnfViewIndex *index); /* NULL is fine */
/* Boxes of these. */
EnfStatus enf_box_set_of_cells(const EnfViewIndex *index, const uint32_t *cells, uint32_t count, EnfBoxSet *set);
EnfStatus enf_box_set_of_objects(const EnfViewIndex *index, const uint32_t *objects, uint32_t count, EnfBoxSet *set);
void enf_box_set_free(EnfBoxSet *set);

#endif
