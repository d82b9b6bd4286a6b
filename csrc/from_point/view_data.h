/* SPDX-License-Identifier: GPL-3.0-or-later
 * The inside of a view: scratch memory that stays from query to query, and the last answer. */
#ifndef ENF_FROM_POINT_VIEW_DATA_H
#define ENF_FROM_POINT_VIEW_DATA_H

#include "from_point/cut_lines.h"
#include "from_point/project_corners.h"
#include "from_point/view_index.h"
#include "from_point/view_screen.h"

/* Apertures that a cell can keep apart: an option's limit for rooms; corridors, and the outside, looked at through many windows, have
 * more. */
#define ENF_CELL_APERTURES       64
#define ENF_CORRIDOR_APERTURES   16
#define ENF_CORRIDOR_SIDES       12
#define ENF_MAX_APERTURES_OPTION 8
static inline uint32_t enf_aperture_places(const EnfViewCell *cell) {
    return cell->flags & ENF_VIEW_CELL_OUTDOORS     ? ENF_CELL_APERTURES
           : cell->side_count >= ENF_CORRIDOR_SIDES ? ENF_CORRIDOR_APERTURES
                                                    : ENF_MAX_APERTURES_OPTION;
}

/* A cell's state during one traversal; valid when `stamp` is the traversal's. */
typedef struct EnfCellState {
    uint32_t stamp;
    uint8_t live_count;
    uint8_t flags;   /* ENF_CELL_* */
    uint8_t merges;  /* that gave something away */
    uint8_t regrown; /* apertures that arrived after the cell's first visit */
    uint16_t rank;   /* outdoors: when it comes (open_air.h) */
    uint8_t care;    /* outdoors: ENF_CARE_*; 0: not known yet */
    uint8_t reserved;
    uint32_t *live; /* apertures, into EnfView.live; together they cover all that ever arrived */
} EnfCellState;
/* WHOLE: it has the whole screen, as start cells do. KNOWN, OPEN: whether it may have (open_air.c). */
enum {
    ENF_CELL_START = 1,
    ENF_CELL_IN_HEAP = 2,
    ENF_CELL_VISITED = 4,
    ENF_CELL_SNAPPED = 8,
    ENF_CELL_WHOLE = 16,
    ENF_CELL_KNOWN = 32,
    ENF_CELL_OPEN = 64
};

enum { ENF_CARE_NONE = 1, ENF_CARE_EXACT = 2 };

/* Its corners are in the pool from ENF_APERTURE_CORNERS times its own index on. */
typedef struct EnfAperture {
    double rect[4];
    double area;
    double outset;   /* of its lines, half screens */
    double nearness; /* parallax.h: the largest inverse depth at which it was entered; 0: the whole view, or one eye */
    uint16_t count;
    uint8_t pending;  /* not yet carried on through its cell's portals */
    uint8_t outlined; /* its corners have their lines */
    uint32_t step;    /* of a free one: the next free */
} EnfAperture;

/* Of 1 / lift: from nearer an eye's picture may lie more than so many half screens beside the middle's; nothing is told apart there. */
#define ENF_PARALLAX_NEAREST 3.0

typedef struct EnfHeapEntry {
    double key; /* squared distance from the eye to the cell's centre */
    uint32_t cell;
} EnfHeapEntry;

/* One answer; arrays have room for the whole scene. */
typedef struct EnfAnswer {
    uint32_t *cells, *objects;
    uint32_t cell_count, object_count;
} EnfAnswer;

/* Walks: what the last answer holds for, and how the camera moves (walk.c). */
typedef struct EnfWalk {
    int has_answer; /* that holds for the region below */
    uint32_t poses; /* known of the two queries before */
    EnfCamera last, before_last;
    EnfViewDef def;
    uint64_t door_state; /* the scene's state_serial */
    int planned;         /* else: for the very camera only */
    /* Eyes: centre +- half along each axis; half 0: exactly the centre's coordinate. Views: within the screen `rows`; the last camera's
     * half extents. */
    double centre[3], axis[3][3], half[3];
    double rows[3][3], tan_x, tan_y;
    double step[3], turn;     /* the last motion, metres and radians a query */
    double swerve, twist;     /* by how much it differed from the one before */
    uint32_t cell;            /* in which the eye must be located; ENF_NONE: in that box is enough */
    int jerked;               /* on the step before */
    double cost;              /* of the last planned answer, in plain ones */
    uint32_t frames, held;    /* how many frames the answer was made for, and has been given in */
    uint32_t ahead;           /* frames to plan for next time */
    uint32_t pause, patience; /* plain queries before the next plan, and how many the pause after it will be */
    double plain_work;        /* of the last plain query */
} EnfWalk;

struct EnfView {
    EnfViewIndex *index;
    EnfScreens screens;
    EnfViewDef def;
    EnfViewStats stats;
    int answered;

    /* ---- one traversal ---- */
    uint32_t stamp;       /* of this screen's traversal */
    EnfCellState *states; /* [cells] */
    uint32_t *live;       /* enf_aperture_places() of each cell */
    EnfHeapEntry *heap;
    uint32_t heap_count, heap_capacity;
    uint32_t *passages; /* cells of openings that wait beside the heap */
    uint32_t passage_count, passage_capacity;
    EnfAperture *apertures;
    uint32_t aperture_count, aperture_capacity, free_aperture;
    EnfCorner *corners; /* [apertures][ENF_APERTURE_CORNERS] */
    EnfDeepLine *deep;  /* the same, for walks' plans alone */
    uint32_t corner_capacity, deep_capacity;
    uint32_t *start_cells;
    int start_enclosed; /* one cell holds eyes and near planes */
    uint32_t start_count, start_capacity;
    uint32_t *start_marks, start_stamp; /* [cells] */
    uint32_t *visited;                  /* [cells] of this traversal in order */
    uint32_t visited_count;
    uint32_t repeat_visits;
    int one_eye;         /* and no orthographic screen */
    int one_middle;      /* the same, or a walk's eyes seen from their middle: enough to order cells by */
    int starts_outdoors; /* some start cell is outdoors */
    EnfProjectCorners project;
    EnfCutLines cut;
    EnfCutDeep cut_deep;
    int occluding; /* this screen's traversal uses the depth buffer */

    /* ---- occluders; made when first used ---- */
    struct EnfDepthBuffer *depth;
    uint32_t depth_pixels;
    uint32_t *occluder_drawn, occluder_stamp; /* [occluders] */

    /* ---- one query ---- */
    uint32_t *step_cell, *step_portal, *step_parent;
    uint32_t step_count, step_capacity;
    uint32_t query;                    /* stamp of cell_seen, object_seen */
    uint32_t *cell_seen;               /* [cells] */
    uint32_t *object_seen;             /* [objects] */
    EnfAnswer answer, before;          /* this one and the one before it */
    uint32_t *cell_step, *object_step; /* of this one's cells and objects; ENF_STEP_SWEPT: the slot of a vista's item (sweep.c) */
    uint32_t sweep_root;               /* the step that leads to those; ENF_NONE: there are none */

    /* ---- what changed, and groups: computed when asked for ---- */
    int changes_ready;
    uint32_t *change_marks_cells, *change_marks_objects, change_stamp;
    uint32_t *entered_cells, *left_cells, *entered_objects, *left_objects;
    uint32_t entered_cell_count, left_cell_count, entered_object_count, left_object_count;
    uint32_t *group_mesh, *group_first, *group_objects;

    EnfWalk walk;
    uint64_t work_limit;    /* of stats.work; from the options, or what a walk's plan is worth */
    uint64_t fallback_work; /* of this query (frustum.c) */
    uint32_t start_hint;    /* all eyes are in this cell; ENF_NONE: not known */
};

/* Capacity fields beside plain pointers: the check in an inner loop is one compare. */
#define ENF_VIEW_ROOM(view, array, capacity, needed)                                                                                       \
    ((needed) <= (view)->capacity || (ENF_RESERVE((view)->array, (uint64_t)(needed) + (needed) / 2 + 16) &&                                \
                                      ((view)->capacity = (uint32_t)((needed) + (needed) / 2 + 16), 1)))

/* Asks for a cache line that will be needed soon: buildings are larger than caches. */
#if defined(__GNUC__)
#define ENF_PREFETCH(address) __builtin_prefetch(address)
#else
#define ENF_PREFETCH(address) ((void)(address))
#endif

/* start_cells.c: fills view->start_cells with every cell that sight may start in. */
EnfStatus enf_find_start_cells(EnfView *view);
/* near_plane.c: whether all that rays start from lies in these; else some start in a wall. */
int enf_near_plane_in_cells(const EnfView *view);
/* traversal.c: one screen; appends to the answer. Gives 0 in *out_done when the budget ran out. */
EnfStatus enf_traverse(EnfView *view, const EnfScreen *screen, int *out_done);
/* What steps of a query cost at most or so, in units of 10 nanoseconds: added to stats.work where they are done. Their sum is
 * the same on every machine, and holds a bound on time. */
enum {
    ENF_WORK_START = 20, /* a cell that sight may start in; and a fifth of it for each of its portals */
    ENF_WORK_VISIT = 10,
    ENF_WORK_PORTAL = 1,  /* looked at */
    ENF_WORK_PROJECT = 5, /* for each eye; of several eyes twice the square of their number more, for the hull */
    ENF_WORK_CLIP = 3,
    ENF_WORK_ARRIVE = 8,
    ENF_WORK_HULL = 12,
    ENF_WORK_PLANES = 10,    /* an aperture as half-spaces */
    ENF_WORK_BLOCK = 2,      /* eight boxes; and 1 for each that is seen */
    ENF_WORK_CONE = 6,       /* eight boxes, exactly */
    ENF_WORK_OCCLUDER = 200, /* a polygon drawn that fills the screen */
    ENF_WORK_WINDOW = 2,     /* swept; and each sixteen of what it shows as eight boxes */
    ENF_WORK_DEPTH = 20      /* asked of the depth buffer */
};
static inline int enf_over_budget(const EnfView *view) {
    return view->stats.work >= view->work_limit;
}
/* frustum.c: the baseline. */
void enf_frustum_cull(EnfView *view, const EnfScreen *screen);
/* frustum.c: the same for all screens where nothing better can be told; beyond half of the budget, all queries' cameras together,
 * everything there is. */
void enf_fall_back(EnfView *view);
void enf_fall_back_screen(EnfView *view, const EnfScreen *screen);
/* What that costs, in units of work. */
uint64_t enf_fallback_work(const EnfView *view, uint32_t screens);
/* frustum.c: whether the box is farther than the distance limit, which is finite, from every eye. */
int enf_beyond_limit(const EnfView *view, const double bounds[6]);
/* visible_objects.c: objects of the visited cells through their apertures, and the unplaced ones. Stops where the budget ends. */
void enf_collect_objects(EnfView *view, const EnfScreen *screen);

/* Objects of one cell within these planes, unless they are in the answer. Not with occluders. */
struct EnfAperturePlanes;
void enf_collect_through(EnfView *view, const EnfScreen *screen, const EnfViewCell *cell, struct EnfAperturePlanes *planes, uint32_t step);

/* walk.c: whether the last answer holds for this camera too (1), and a region along the way to ask for instead (1: view->screens
 * and start_hint are set; 0: ask for the camera itself). */
int enf_walk_holds(EnfView *view, const EnfCamera *camera);
int enf_walk_plan(EnfView *view, const EnfCamera *camera);
/* After a query that enf_walk_plan was asked about. */
void enf_walk_answered(EnfView *view, const EnfCamera *camera, int planned);
/* The plan ran into view->work_limit: it doesn't pay here. */
void enf_walk_gave_up(EnfView *view);

/* A cell's state in this traversal, fresh when it has none. */
static inline EnfCellState *enf_touch_state(EnfView *view, uint32_t cell) {
    EnfCellState *state = &view->states[cell];
    if (state->stamp != view->stamp) {
        state->stamp = view->stamp;
        state->live_count = state->flags = state->merges = state->regrown = state->care = 0;
        state->rank = 0;
    }
    return state;
}

#define ENF_STEP_SWEPT 0x80000000u

/* Adds to the answer; cells unless they are there already. */
static inline void enf_answer_cell(EnfView *view, uint32_t cell, uint32_t step) {
    if (view->cell_seen[cell] == view->query)
        return;
    view->cell_seen[cell] = view->query;
    view->cell_step[view->answer.cell_count] = step;
    view->answer.cells[view->answer.cell_count++] = cell;
}
static inline void enf_answer_object(EnfView *view, uint32_t object, uint32_t step) {
    view->object_seen[object] = view->query;
    view->object_step[view->answer.object_count] = step;
    view->answer.objects[view->answer.object_count++] = object;
}

#endif
