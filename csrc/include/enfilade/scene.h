/* SPDX-License-Identifier: GPL-3.0-or-later
 * The scene: rooms, convex cells, portals, openings, objects, lights, cameras (DESIGN.md sections 2, 3 and 8).
 *
 * Life: create, add (or load), commit, then any number of concurrent read-only queries; destroy.
 * Adding un-commits. Units: metres, z up, right-handed, double precision.
 * Threads: "safe on different handles" unless said otherwise; queries on one committed scene are thread-safe.
 * Arrays come in as pointer, count (of elements), stride (bytes between elements; 0 = packed). */
#ifndef ENFILADE_SCENE_H
#define ENFILADE_SCENE_H

#include "enfilade/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnfScene EnfScene;

enum { ENF_ROOM_INTERIOR = 0, ENF_ROOM_EXTERIOR = 1 };
enum { ENF_OPENING_DOOR = 0, ENF_OPENING_WINDOW = 1, ENF_OPENING_HOLE = 2, ENF_OPENING_VIRTUAL = 3 };
enum { ENF_STATE_OPEN = 0, ENF_STATE_CLOSED = 1, ENF_STATE_GLASS = 2 }; /* glass is seen through; closed is not */
enum { ENF_CAMERA_PERSP = 0, ENF_CAMERA_ORTHO = 1, ENF_CAMERA_PANO = 2 };

/* An empty scene, to be destroyed by the caller. ENF_ERROR_OUT_OF_MEMORY. */
ENF_API EnfStatus enf_scene_create(EnfScene **out_scene);
ENF_API void enf_scene_destroy(EnfScene *scene); /* NULL is fine */

/* ---- Files ------------------------------------------------------------------------------------------- */
/* Reads *.enf.json or *.prt (PRT1, PRT2), told apart by content. The scene comes back uncommitted: commit it to
 * have it validated. ENF_ERROR_IO, ENF_ERROR_BAD_INPUT (names line or index and reason). */
ENF_API EnfStatus enf_scene_load(const char *path_utf8, EnfScene **out_scene);
ENF_API EnfStatus enf_scene_load_memory(const void *bytes, uint64_t size, EnfScene **out_scene);
/* Writes *.enf.json, unknown keys of a loaded file included; through a temporary file, so never half a file. */
ENF_API EnfStatus enf_scene_save_json(const EnfScene *scene, const char *path_utf8);

/* ---- Adding ------------------------------------------------------------------------------------------ */
ENF_API EnfStatus enf_scene_add_room(EnfScene *scene, const char *name, uint32_t kind, uint32_t *out_room);

/* A convex cell of `room` (ENF_NONE for the cell of a thick opening, then `opening` says which; else ENF_NONE).
 * vertices: double[3] each. faces: face i has face_sizes[i] indices, taken in turn from face_indices,
 * counter-clockwise seen from outside. face_count 0: the convex hull of the vertices is meant. vertex_count 0: a cell
 * without geometry (clusters of portal files; "everything outside" of an exterior room). */
ENF_API EnfStatus enf_scene_add_cell(EnfScene *scene, uint32_t room, uint32_t opening, const double *vertices, uint64_t vertex_count,
                                     uint64_t vertex_stride, const uint32_t *face_sizes, uint64_t face_count, const uint32_t *face_indices,
                                     uint32_t *out_cell);

/* A convex planar polygon (double[3] each, either winding) that joins two cells. opening: ENF_NONE = always open.
 * Between two cells without geometry nothing but the winding tells which way it faces: counter-clockwise seen from cell_a. */
ENF_API EnfStatus enf_scene_add_portal(EnfScene *scene, uint32_t cell_a, uint32_t cell_b, const double *polygon, uint64_t vertex_count,
                                       uint64_t vertex_stride, uint32_t opening, uint32_t *out_portal);
ENF_API EnfStatus enf_scene_add_opening(EnfScene *scene, const char *name, uint32_t kind, uint32_t state, uint32_t *out_opening);
/* bounds: min xyz, max xyz. cells: where it is drawn; cell_count 0: placed at commit (see csrc/scene/placement.c).
 * mesh: any number shared by the instances of one mesh, ENF_NONE when unknown. */
ENF_API EnfStatus enf_scene_add_object(EnfScene *scene, const char *name, const double bounds[6], const uint32_t *cells,
                                       uint64_t cell_count, uint32_t mesh, uint32_t *out_object);
/* `count` objects, placed at commit; all of them or none. names: count strings, each with its ending 0, one after another,
 * names_size bytes in all. bounds: double[6] each, as above. meshes: [count], NULL: unknown. They get consecutive
 * indices from *out_first on. */
ENF_API EnfStatus enf_scene_add_objects(EnfScene *scene, uint64_t count, const char *names, uint64_t names_size, const double *bounds,
                                        uint64_t bounds_stride, const uint32_t *meshes, uint32_t *out_first);
/* What of an object surely blocks sight: convex planar polygons in its solid or on its opaque surface (the sides of a wardrobe,
 * a column's core, a facade's panels). Views may then hide what stands behind (EnfViewDef.occluders). Without thickness and
 * seen from both sides; nothing of glass or with holes. corners: double[3] each, sizes[i] of them (3 to 64) for polygon i; at
 * most 0.1 mm or a millionth of the object's size out of its bounds. count 0: the whole box of the bounds is solid. An
 * object's later occluder replaces its earlier one. Un-commits. ENF_ERROR_INVALID_ARGUMENT, ENF_ERROR_BAD_INPUT. */
ENF_API EnfStatus enf_scene_set_occluder(EnfScene *scene, uint32_t object, const double *corners, uint64_t stride, const uint32_t *sizes,
                                         uint64_t count);
ENF_API EnfStatus enf_scene_add_light(EnfScene *scene, const char *name, const double position[3], uint32_t *out_light);

/* A camera of the file: what `enfilade view --camera NAME` looks through.
 * world_from_camera: row-major, the camera looks along its -z, +y is up (Blender's convention).
 * angle_x, angle_y: full field of view in radians after sensor fit. shift_x, shift_y: as fractions of the view's width and
 * height. ortho_scale: width and height of an orthographic view, metres. clip: near, far, metres. */
typedef struct EnfCamera {
    uint32_t struct_size;
    uint32_t type; /* ENF_CAMERA_* */
    double world_from_camera[16];
    double angle_x, angle_y;
    double shift_x, shift_y;
    double ortho_width, ortho_height;
    double clip_near, clip_far;
} EnfCamera;
ENF_API EnfCamera enf_default_camera(void);
ENF_API EnfStatus enf_scene_add_camera(EnfScene *scene, const char *name, const EnfCamera *camera, uint32_t *out_camera);

/* ---- Building from rooms as people draw them --------------------------------------------------------------- */
/* Decomposes a room into convex cells joined by seams and adds them (csrc/scene/convex_decomposition.c).
 * Polyhedron: closed, faces counter-clockwise from outside, planar within tolerance, any number of corners.
 * A shape that isn't closed falls back to its convex hull as one cell (safe: larger) and is counted as a problem.
 * face_count 0: the convex hull of the vertices is meant.
 * out_first_cell, out_cell_count: the cells added, consecutive. */
ENF_API EnfStatus enf_scene_add_room_polyhedron(EnfScene *scene, uint32_t room, const double *vertices, uint64_t vertex_count,
                                                uint64_t vertex_stride, const uint32_t *face_sizes, uint64_t face_count,
                                                const uint32_t *face_indices, uint32_t *out_first_cell, uint32_t *out_cell_count);
/* Prism: outline and holes as double[2] rings (ring i has ring_sizes[i] corners; ring 0 is the outline), from z0 to z1. */
ENF_API EnfStatus enf_scene_add_room_prism(EnfScene *scene, uint32_t room, const double *corners, const uint32_t *ring_sizes,
                                           uint64_t ring_count, double z0, double z1, uint32_t *out_first_cell, uint32_t *out_cell_count);
/* A portal polygon between two *rooms* (or a room and an opening's cell): split among the cells of each side and
 * added as one or more portals. side_a / side_b: a cell index (ENF_SIDE_CELL) or a room index (ENF_SIDE_ROOM).
 * Nothing is cut away: what lies outside both shapes goes to the nearest cell (safe direction; counted). */
enum { ENF_SIDE_ROOM = 0, ENF_SIDE_CELL = 1 };
ENF_API EnfStatus enf_scene_join(EnfScene *scene, uint32_t side_a_kind, uint32_t side_a, uint32_t side_b_kind, uint32_t side_b,
                                 const double *polygon, uint64_t vertex_count, uint64_t vertex_stride, uint32_t opening,
                                 uint32_t *out_first_portal, uint32_t *out_portal_count);

/* ---- The outdoors ------------------------------------------------------------------------------------------- */
/* Cuts the outdoors into convex cells round the rooms, so that facades hide what lies behind them (csrc/scene/exterior.c).
 * Call it when all rooms and portals are added, before commit. The exterior's one cell without geometry keeps its index and
 * becomes all that lies outside of a box; the new cells, of the same room, come last. Portals that led to it lead to the
 * cells they lie in: a portal that is split keeps its index for the first piece, the others come last.
 * Not outdoors: rooms, and what lies between facing walls (floor and ceiling) of rooms at most `wall_gap` (`slab_gap`)
 * apart. Where that can't be told the outdoors are larger (safe direction).
 * The outcome says what was done; only ENF_EXTERIOR_DONE changes the scene. Errors: what commit finds, out of memory (then
 * the scene is only good to be destroyed). */
enum {
    ENF_EXTERIOR_DONE = 0,
    ENF_EXTERIOR_NONE = 1,       /* no opening leads outdoors, or no room has a shape */
    ENF_EXTERIOR_ALREADY = 2,    /* the exterior has cells with geometry already */
    ENF_EXTERIOR_SEVERAL = 3,    /* more than one exterior cell without geometry: nobody knows which is where */
    ENF_EXTERIOR_TOO_COMPLEX = 4 /* it stays one cell: more than max_cells, or the parts don't add up */
};
typedef struct EnfExteriorDef {
    uint32_t struct_size;
    uint32_t max_cells;
    double wall_gap; /* metres; negative: as thick as the walls that openings go through are */
    double slab_gap; /* metres; negative: the same of slabs; twice the walls when no opening goes through one */
    double margin;   /* metres of outdoors round everything in cells; 0: a quarter of the scene's extent */
    /* room_tops[r], metres: higher up room r's cells may hold outdoor air too (a shape that stands out of its roof), and the outdoors go
     * on there. INFINITY: nowhere. NULL: no room's do; rooms from room_count on don't. Only read during the call. */
    const double *room_tops;
    uint64_t room_count;
} EnfExteriorDef;
ENF_API EnfExteriorDef enf_default_exterior_def(void);
typedef struct EnfExteriorReport {
    uint32_t struct_size;
    uint32_t outcome;          /* ENF_EXTERIOR_* */
    uint32_t cells, seams;     /* made */
    uint32_t portals, split;   /* that led outdoors; of these, in more than one piece now */
    uint32_t bodies, leaves;   /* rooms, walls, slabs; parts before merging */
    double wall_gap, slab_gap; /* as used, metres */
    double seconds;
} EnfExteriorReport;
/* def NULL: the defaults. out_report may be NULL; else its struct_size is set. */
ENF_API EnfStatus enf_scene_decompose_exterior(EnfScene *scene, const EnfExteriorDef *def, EnfExteriorReport *out_report);

/* ---- Commit and problems ------------------------------------------------------------------------------------ */
/* Validates every invariant and builds what queries need. Problems of severity ERROR make it fail with
 * ENF_ERROR_BAD_INPUT (all of them stay listed); WARNINGs don't. */
ENF_API EnfStatus enf_scene_commit(EnfScene *scene);

enum { ENF_SEVERITY_INFO = 0, ENF_SEVERITY_WARNING = 1, ENF_SEVERITY_ERROR = 2 };
enum {
    ENF_ITEM_SCENE = 0,
    ENF_ITEM_ROOM,
    ENF_ITEM_CELL,
    ENF_ITEM_PORTAL,
    ENF_ITEM_OPENING,
    ENF_ITEM_OBJECT,
    ENF_ITEM_LIGHT,
    ENF_ITEM_CAMERA
};
typedef struct EnfProblem {
    uint32_t severity;  /* ENF_SEVERITY_* */
    uint32_t item;      /* ENF_ITEM_* */
    uint32_t index;     /* of the item, ENF_NONE for the whole scene */
    uint32_t code;      /* stable number, see csrc/scene/validate.c */
    double position[3]; /* where, metres; NaN when nowhere in particular */
    char message[232];  /* "portal 17: 3.2 mm out of plane; treated as its planar hull" */
} EnfProblem;
ENF_API uint64_t enf_scene_problem_count(const EnfScene *scene);
ENF_API EnfStatus enf_scene_problem(const EnfScene *scene, uint64_t index, EnfProblem *out_problem);

/* ---- Reading --------------------------------------------------------------------------------------------- */
typedef struct EnfSceneCounts {
    uint32_t struct_size;
    uint32_t rooms, cells, portals, openings, objects, lights, cameras;
    uint32_t seams;          /* portals between two cells of one room */
    uint32_t closed_portals; /* portals of closed openings */
    uint32_t reserved;
} EnfSceneCounts;
ENF_API EnfStatus enf_scene_counts(const EnfScene *scene, EnfSceneCounts *out_counts);
/* Flat views, owned by the scene, valid until it is edited or destroyed. Shapes beside each. */
ENF_API const uint32_t *enf_scene_cell_rooms(const EnfScene *scene);           /* [cells] room or ENF_NONE */
ENF_API const uint32_t *enf_scene_cell_openings(const EnfScene *scene);        /* [cells] opening or ENF_NONE */
ENF_API const uint32_t *enf_scene_portal_cells(const EnfScene *scene);         /* [portals][2] */
ENF_API const uint32_t *enf_scene_portal_openings(const EnfScene *scene);      /* [portals] opening or ENF_NONE */
ENF_API const uint32_t *enf_scene_portal_vertex_first(const EnfScene *scene);  /* [portals + 1] into ...vertices */
ENF_API const double *enf_scene_portal_vertices(const EnfScene *scene);        /* [sum][3] */
ENF_API const uint32_t *enf_scene_cell_vertex_first(const EnfScene *scene);    /* [cells + 1] */
ENF_API const double *enf_scene_cell_vertices(const EnfScene *scene);          /* [sum][3] */
ENF_API const char *enf_scene_room_name(const EnfScene *scene, uint32_t room); /* NULL when out of range */
ENF_API uint32_t enf_scene_room_kind(const EnfScene *scene, uint32_t room);
ENF_API const char *enf_scene_opening_name(const EnfScene *scene, uint32_t opening);
ENF_API EnfStatus enf_scene_opening(const EnfScene *scene, uint32_t opening, uint32_t *out_kind, uint32_t *out_state);
/* Doors change without a new commit; not thread-safe against running queries of the same scene. */
ENF_API EnfStatus enf_scene_set_opening_state(EnfScene *scene, uint32_t opening, uint32_t state);
ENF_API const char *enf_scene_object_name(const EnfScene *scene, uint32_t object);
ENF_API EnfStatus enf_scene_object_cells(const EnfScene *scene, uint32_t object, const uint32_t **out_cells, uint32_t *out_count);
ENF_API const char *enf_scene_camera_name(const EnfScene *scene, uint32_t camera);
ENF_API EnfStatus enf_scene_camera(const EnfScene *scene, uint32_t camera, EnfCamera *out_camera);

/* The cells that hold a point: every cell within the scene's tolerance of it; when none does, the exterior's cells, or those
 * a portal graph can't exclude. Writes at most `capacity` and gives the whole number. Logarithmic in the cell count. */
ENF_API EnfStatus enf_scene_locate(const EnfScene *scene, const double point[3], uint32_t *out_cells, uint32_t capacity,
                                   uint32_t *out_count);

#ifdef __cplusplus
}
#endif
#endif
