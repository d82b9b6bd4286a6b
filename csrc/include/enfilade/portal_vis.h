/* SPDX-License-Identifier: GPL-3.0-or-later
 * What a camera sees through the openings: visible cells, visible objects, and why (DESIGN.md section 5).
 *
 * A view is scratch memory and the last answer, bound to one committed scene. Use one per thread; queries through
 * different views of one scene run concurrently. After the first few queries a view allocates nothing.
 * All lengths in metres, angles in radians. Everything errs towards visible; what was given away is in EnfViewStats. */
#ifndef ENFILADE_PORTAL_VIS_H
#define ENFILADE_PORTAL_VIS_H

#include "enfilade/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnfView EnfView;

enum {
    ENF_VIEW_FRUSTUM = 0, /* no portals: whatever lies in the view volume. The baseline */
    ENF_VIEW_BOX = 1,     /* portals; one screen rectangle a cell */
    ENF_VIEW_CLIP = 2     /* portals; convex screen polygons, clipped exactly */
};

/* Whether objects' occluders (enf_scene_set_occluder) hide what stands behind them: through a software depth buffer, for
 * perspective cameras and panoramas with one eye; elsewhere nothing is hidden. */
enum {
    ENF_OCCLUDERS_OFF = 0,
    ENF_OCCLUDERS_ON = 1,
    ENF_OCCLUDERS_AUTO = 2 /* when the view without them keeps 64 objects or more and they cover a tenth of it */
};

/* How an eye outdoors is answered (method clip, one eye, no occluders, no distance limit; else as EXACT). The sweep takes nothing
 * outdoors to hide anything: all of the outdoors in the view, and through each window in the view what straight lines through it
 * can reach at the angle from which it is seen. It costs less than comparing everything with the frustum, and keeps somewhat more
 * than EXACT does. What it needs is prepared when a view is made; where windows show more than was prepared, the answer is EXACT's (AUTO:
 * the frustum's). The outdoors counts as one place then: of what is there no step tells, as in the frustum's answer, and
 * steps into a building lead from the eye's cell through the first portal indoors. */
enum {
    ENF_OUTDOORS_AUTO = 0,  /* from farther off than a quarter of the building's diagonal in plan by the sweep, or, where there is less
                               to spare than windows to look through, as the frustum does; else exactly */
    ENF_OUTDOORS_EXACT = 1, /* through the portals outdoors too, which hides what buildings hide */
    ENF_OUTDOORS_SWEEP = 2
};

/* Options of a query. Get it from enf_default_view_def(), then change fields. */
typedef struct EnfViewDef {
    uint32_t struct_size;
    uint32_t method;          /* ENF_VIEW_* [default: clip] */
    uint32_t want_objects;    /* 0: cells only [default: 1] */
    uint32_t max_apertures;   /* apertures a cell keeps apart before they merge. [Limit: 1..8, default: 4] */
    uint32_t visit_cap;       /* after so many repeated visits of cells one aperture a cell. [default: 2000] */
    uint32_t work_budget;     /* after so much work, that of comparing all with the frustum included but no more than
                               half, the frustum's answer is given instead, and counted. [Units: some 10 nanoseconds,
                               see EnfViewStats.work; default: 0 = 2100000, some 20 milliseconds] */
    uint32_t use_simd;        /* 0: the scalar twins; the answer has the same bits [default: 1] */
    uint32_t measure_stages;  /* 1: fill the stage times of EnfViewStats, at the cost of reading the clock [default: 0] */
    uint32_t occluders;       /* ENF_OCCLUDERS_* [default: off] */
    uint32_t occluder_pixels; /* width of the depth buffer, three fifths of it high. [Limit: 16..4096, default: 320] */
    uint32_t outdoors;        /* ENF_OUTDOORS_* [default: auto] */
    uint32_t reserved;        /* 0 */
    double distance_limit;    /* fog: nothing farther from the eye is reported. [Units: metres, default: infinity] */
    double start_tolerance;   /* the eye counts as inside of every cell whose portal is this near. [Units: metres,
                               default: 0 = 1e-8 of the scene's extent, and never below the coordinates' rounding] */
    double reuse_distance;    /* walks: an answer may be made for so much of the way that the camera seems to take, and is
                               given again while the camera keeps to it. [Units: metres, default: 0 = off] */
    double reuse_angle;       /* the same for its turning. Both > 0 for a walk. [Units: radians, default: 0] */
} EnfViewDef;
ENF_API EnfViewDef enf_default_view_def(void);

/* What a query did; every conservative step is counted. */
typedef struct EnfViewStats {
    uint32_t struct_size;
    uint32_t method;
    uint32_t cells;          /* visible cells */
    uint32_t objects;        /* visible objects */
    uint32_t start_cells;    /* cells the eye (or the eyes' region, or the near plane) touches */
    uint32_t visits;         /* cells taken from the heap; cells seen once cost one visit */
    uint32_t portals_tested; /* portal sides looked at */
    uint32_t portals_projected;
    uint32_t apertures;           /* made */
    uint32_t apertures_contained; /* dropped: another aperture of the cell contains it */
    uint32_t apertures_sliver;    /* dropped: thinner than 1e-10 of the screen */
    uint32_t merges_exact;        /* neighbours whose hull adds at most 0.1 % of area */
    uint32_t merges_forced;       /* beyond max_apertures: hull with the least growth */
    uint32_t cells_snapped;       /* cells that came down to one aperture on a 1/32 grid */
    uint32_t visit_cap_hit;       /* 0 or 1 */
    uint32_t budget_hit;          /* 1: the answer is the frustum's; 2: all there is, comparing it with the frustum would take as long */
    uint32_t portals_unclipped;   /* crossed with the whole aperture: the eye is too near for a sound projection */
    uint32_t objects_tested;      /* bounds compared with apertures (SIMD lanes in use) */
    uint32_t objects_refined;     /* of these, decided by the exact test */
    uint32_t objects_unplaced;    /* visible though in no cell */
    uint32_t screens;             /* projections the query was split into: 1 a camera, up to 6 for a panorama */
    uint32_t eyes;                /* projection centres: 1, 2 for stereo, up to 8 for a stretch of a walk */
    uint32_t reused;              /* 0 or 1: the last answer was given again */
    uint32_t hulls;               /* of apertures, tried or taken: the costly part of merging */
    uint32_t occluder_polygons;   /* drawn into the depth buffer; 0: it wasn't used */
    uint32_t portals_occluded;    /* not crossed: occluders hide what of them is seen */
    uint32_t objects_occluded;    /* (object, aperture) pairs hidden by occluders */
    uint32_t eye_outside;         /* 0 or 1: no cell holds the eye; for some camera the answer is the frustum's */
    uint32_t near_in_wall;        /* 0 or 1: a near plane reaches into a wall, or rays start in one between two poses; for some camera
                                     the answer is the frustum's */
    uint32_t swept;               /* screens answered as from afar (ENF_OUTDOORS_*) */
    uint32_t windows;             /* looked through by the sweep; 0: the frustum's answer was as good */
    uint64_t work;                /* what all this cost, the same on every machine: some 10 nanoseconds each; see work_budget */
    double microseconds;          /* wall time of the query */
    double microseconds_locate;   /* of it: finding start cells; 0 unless def.measure_stages */
    double microseconds_traverse;
    double microseconds_objects;
} EnfViewStats;

/* The last answer. Arrays are owned by the view and valid until its next query or its end. */
typedef struct EnfViewResult {
    uint32_t struct_size;
    uint32_t cell_count, object_count, step_count;
    const uint32_t *cells;       /* [cell_count] visible cells, in the order in which sight reached them */
    const uint32_t *cell_step;   /* [cell_count] the step by which each was reached first */
    const uint32_t *objects;     /* [object_count] visible objects, each once, by cell of first sight */
    const uint32_t *object_step; /* [object_count] the step through which each is seen; ENF_NONE: unplaced, or frustum */
    /* Steps: a forest. A step says "through `portal` into `cell`, coming from step `parent`". */
    const uint32_t *step_cell;   /* [step_count] */
    const uint32_t *step_portal; /* [step_count] ENF_NONE: the eye is there, no portal was needed */
    const uint32_t *step_parent; /* [step_count] ENF_NONE for start cells */
    /* What changed since this view's answer before, ascending (the first answer: everything entered). */
    uint32_t cells_entered_count, cells_left_count, objects_entered_count, objects_left_count;
    const uint32_t *cells_entered, *cells_left, *objects_entered, *objects_left;
} EnfViewResult;

/* Builds the view of a committed scene: packs portals and objects into flat arrays (linear in the scene's size).
 * The scene must outlive the view. When the scene was edited and committed again, the next query packs anew.
 * ENF_ERROR_STATE: not committed. Safe on different handles. */
ENF_API EnfStatus enf_view_create(const EnfScene *scene, EnfView **out_view);
/* A second view that shares the packed arrays: what another thread should use. Thread-safe. */
ENF_API EnfStatus enf_view_create_shared(const EnfView *view, EnfView **out_view);
ENF_API void enf_view_destroy(EnfView *view); /* NULL is fine */

/* What `camera` sees now (opening states are read at each query). def: NULL = defaults.
 * ENF_ERROR_INVALID_ARGUMENT, ENF_ERROR_BAD_INPUT (a NaN in the camera ...), ENF_ERROR_STATE. Safe on different handles. */
ENF_API EnfStatus enf_view_query(EnfView *view, const EnfCamera *camera, const EnfViewDef *def);
/* What any of 1..16 cameras sees. swept == 0: exactly the union, camera by camera; they may be of any mix of types (a stereo
 * pair, an orthographic plan beside a panorama). swept != 0: also from every pose between consecutive cameras (position on the
 * straight line between them, turning about one axis, lens changing, as motion blur does), in one traversal; then all are of
 * one type. */
ENF_API EnfStatus enf_view_query_union(EnfView *view, const EnfCamera *cameras, uint32_t count, uint32_t swept, const EnfViewDef *def);
/* What is seen from anywhere in a box, looking anywhere (look == NULL) or as `look` does from each point:
 * a conservative in-between of from-point and from-region. bounds: min xyz, max xyz. */
ENF_API EnfStatus enf_view_query_region(EnfView *view, const double bounds[6], const EnfCamera *look, const EnfViewDef *def);

/* The last answer; ENF_ERROR_STATE before the first. Set struct_size of *out_ first (or use the defaults below). */
ENF_API EnfStatus enf_view_result(const EnfView *view, EnfViewResult *out_result);
ENF_API EnfStatus enf_view_stats(const EnfView *view, EnfViewStats *out_stats);
ENF_API EnfViewResult enf_default_view_result(void);
ENF_API EnfViewStats enf_default_view_stats(void);

/* The *why*: the portals from the camera to a visible cell / object, in order. Writes at most `capacity`, gives the
 * whole number. Count 0: the eye is in that cell. ENF_ERROR_INVALID_ARGUMENT: it is not in the last answer. */
ENF_API EnfStatus enf_view_why_cell(const EnfView *view, uint32_t cell, uint32_t *out_portals, uint32_t capacity, uint32_t *out_count);
ENF_API EnfStatus enf_view_why_object(const EnfView *view, uint32_t object, uint32_t *out_portals, uint32_t capacity, uint32_t *out_count);
/* Visible objects grouped by the mesh they share (Johansson 2013), so that a renderer draws a group at once.
 * Groups ascend by mesh number; objects of unknown mesh (ENF_NONE) come last, as one group.
 * Arrays are owned by the view, valid until its next query: meshes[groups], first[groups + 1] into objects[]. */
ENF_API EnfStatus enf_view_groups(EnfView *view, uint32_t *out_group_count, const uint32_t **out_meshes, const uint32_t **out_first,
                                  const uint32_t **out_objects);

#ifdef __cplusplus
}
#endif
#endif
