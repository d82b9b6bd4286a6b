/* SPDX-License-Identifier: GPL-3.0-or-later
 * The committed scene as the engines read it: flat arrays, no pointers to chase. Internal to the core.
 *
 * Everything below "derived at commit" is valid only while `committed` is set. Coordinates stay in the user's frame
 * (metres); engines recentre by `origin` before they multiply (DESIGN.md section 6, numeric policy). */
#ifndef ENF_SCENE_SCENE_DATA_H
#define ENF_SCENE_SCENE_DATA_H

#include "enfilade/scene.h"

typedef struct EnfPlane {
    double n[3]; /* unit normal */
    double d;    /* n . (p - scene->origin) = d on the plane */
} EnfPlane;

typedef struct EnfRoomData {
    char *name;
    uint32_t kind;
    uint32_t reserved;
} EnfRoomData;

typedef struct EnfOpeningData {
    char *name;
    uint32_t kind, state;
} EnfOpeningData;

typedef struct EnfObjectData {
    char *name;
    double bounds[6];
    uint32_t cell_first, cell_count; /* into object_cells, as given; 0: placed at commit */
    uint32_t mesh;
    uint32_t occluder; /* into occluders; ENF_NONE: blocks nothing that we know of */
} EnfObjectData;

/* The polygons of one object that block sight. */
typedef struct EnfOccluderData {
    uint32_t object;
    uint32_t polygon_first, polygon_count; /* polygon p's corners: occluder_corner_first[p] .. [p + 1] - 1 */
    uint32_t whole;                        /* they are the box of the object's bounds */
} EnfOccluderData;

typedef struct EnfLightData {
    char *name;
    double position[3];
} EnfLightData;

typedef struct EnfCameraData {
    char *name;
    EnfCamera camera;
} EnfCameraData;

/* One side of a portal, as a cell sees it. */
typedef struct EnfCellPortal {
    uint32_t portal;
    uint32_t to;   /* the cell behind it */
    uint32_t side; /* 0: we are cells[0] of the portal (its normal points away from us); 1: we are cells[1] */
} EnfCellPortal;

struct EnfScene {
    int committed;
    uint64_t state_serial;  /* grows with every change of an opening's state */
    uint64_t commit_serial; /* grows with every commit: tells what was built from an earlier one */

    /* ---- as given ---- */
    uint32_t room_count, cell_count, portal_count, opening_count, object_count, light_count, camera_count;
    EnfRoomData *rooms;
    EnfOpeningData *openings;
    uint8_t *opening_shut; /* [openings] whether its state is closed, side by side for queries that ask of many */
    uint32_t shut_count;   /* how many are */
    EnfObjectData *objects;
    uint32_t *object_cells;
    uint32_t object_cell_count;
    EnfOccluderData *occluders;
    uint32_t occluder_count, occluder_polygon_count;
    uint32_t *occluder_corner_first; /* [polygons + 1] */
    double (*occluder_corners)[3];
    EnfLightData *lights;
    EnfCameraData *cameras;
    uint32_t *cell_rooms;        /* [cells] */
    uint32_t *cell_openings;     /* [cells] */
    uint32_t *cell_vertex_first; /* [cells + 1] */
    double (*cell_vertices)[3];
    uint32_t *cell_face_first;  /* [cells + 1]: faces of cell c are cell_face_first[c] .. [c + 1] - 1 */
    uint32_t *face_index_first; /* [faces + 1]: corners of face f in face_indices (relative to the cell's first vertex) */
    uint32_t *face_indices;
    uint32_t (*portal_cells)[2];
    uint32_t *portal_openings;
    uint32_t *portal_vertex_first; /* [portals + 1] */
    double (*portal_vertices)[3];  /* after commit: counter-clockwise seen from cells[0], i.e. the Newell normal of the
                                      winding points from cells[1] to cells[0] */

    /* ---- derived at commit ---- */
    double origin[3]; /* centre of the bounds of all geometry */
    double extent;    /* length of the diagonal of those bounds, metres; > 0 */
    double bounds[6];
    double tolerance;            /* metres: points closer than this can't be told apart, see geometry/tolerance.h */
    EnfPlane *portal_planes;     /* [portals]; n points from cells[0] into cells[1] */
    double *portal_deviation;    /* [portals] largest distance of a vertex from its plane, metres: err outward by this */
    double (*portal_centres)[3]; /* area centroid: inside the polygon */
    double *portal_radii;        /* bounding sphere about the centre */
    uint32_t *cell_portal_first; /* [cells + 1] */
    EnfCellPortal *cell_portals; /* closed openings included; see enf_portal_passes */
    double (*cell_bounds)[6];    /* of vertices and portals; a cell without both: min > max */
    double (*cell_centres)[3];
    EnfPlane *face_planes;       /* [faces], outward */
    uint32_t *cell_object_first; /* [cells + 1] */
    uint32_t *cell_object_list;  /* object indices, ascending in each cell */
    uint32_t *placed_first;      /* [objects + 1] into placed_cells: as given, or as placement.c found */
    uint32_t *placed_cells;      /* cell indices, ascending in each object */
    uint32_t *unplaced_objects;  /* in no cell: treated as visible wherever the view reaches */
    uint32_t unplaced_count;

    uint32_t hub;                      /* the exterior cell that is all outside of hub_box, ENF_NONE: there is none (exterior_hub.c) */
    double hub_axes[3][3], hub_box[6]; /* the box along its own axes, about the origin */

    struct EnfLocator *locator;   /* csrc/scene/point_location.c */
    struct EnfProblems *problems; /* csrc/scene/problems.c */
    struct EnfExtras *extras;     /* unknown keys of a loaded file, kept for saving */
    struct EnfRoomShapes *shapes; /* decomposition trees, for enf_scene_join */
};

static inline int enf_is_exterior(const EnfScene *scene, uint32_t cell) {
    uint32_t room = scene->cell_rooms[cell];
    return room != ENF_NONE && scene->rooms[room].kind == ENF_ROOM_EXTERIOR;
}

/* Whether sight passes portal p now: open or glass openings, and portals without opening. */
static inline int enf_portal_passes(const EnfScene *scene, uint32_t p) {
    uint32_t opening = scene->portal_openings[p];
    return opening == ENF_NONE || scene->openings[opening].state != ENF_STATE_CLOSED;
}

#endif
