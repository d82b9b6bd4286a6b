/* SPDX-License-Identifier: GPL-3.0-or-later
 * The list of problems a scene has: what enf_scene_problem hands out. */
#ifndef ENF_SCENE_PROBLEMS_H
#define ENF_SCENE_PROBLEMS_H

#include "scene/scene_data.h"

/* Stable codes: numbers are never reused. The comment says the usual severity and why. */
enum {
    /* Values no geometry can be built from: errors. */
    ENF_PROBLEM_NOT_FINITE = 1,
    ENF_PROBLEM_DANGLING_INDEX = 2,
    ENF_PROBLEM_BAD_ENUM = 3,
    ENF_PROBLEM_BAD_BOUNDS = 4,
    ENF_PROBLEM_BAD_CAMERA = 5,
    ENF_PROBLEM_HUGE_COORDINATE = 6,
    /* Portals. */
    ENF_PROBLEM_PORTAL_TOO_FEW_VERTICES = 20, /* error: no polygon */
    ENF_PROBLEM_PORTAL_SELF = 21,             /* error: both sides are one cell: no direction to cross it in */
    ENF_PROBLEM_PORTAL_ZERO_AREA = 22,        /* error: no plane; could hide what a thin slit shows */
    ENF_PROBLEM_PORTAL_DUPLICATE_VERTEX = 23, /* warning: the second one is dropped, same polygon */
    ENF_PROBLEM_PORTAL_NOT_PLANAR = 24,       /* warning while small (deviation is erred outward), error beyond */
    ENF_PROBLEM_PORTAL_NOT_CONVEX = 25,       /* warning: its convex hull is taken, which shows more */
    ENF_PROBLEM_PORTAL_DUPLICATE = 26,        /* info: two portals of the same cells and polygon */
    ENF_PROBLEM_PORTAL_OFF_CELL = 27,         /* warning: doesn't touch its cell; error when far away */
    ENF_PROBLEM_PORTAL_ORIENTATION = 28,      /* error: cells on one side; warning: winding doubted */
    ENF_PROBLEM_PORTAL_IN_CELL = 29,          /* warning: its cell reaches to both sides of it */
    /* Cells. */
    ENF_PROBLEM_CELL_BAD_FACE = 40,        /* error: fewer than 3 corners, or a corner twice in a row */
    ENF_PROBLEM_CELL_OPEN = 41,            /* warning: faces don't close; its convex hull is taken */
    ENF_PROBLEM_CELL_NOT_CONVEX = 42,      /* warning: its convex hull is taken, which holds more */
    ENF_PROBLEM_CELL_FLAT = 43,            /* error: its vertices lie in one plane */
    ENF_PROBLEM_CELL_INSIDE_OUT = 44,      /* warning: faces clockwise from outside; its convex hull is taken */
    ENF_PROBLEM_CELL_OVERLAP = 46,         /* warning: a camera in both starts in both */
    ENF_PROBLEM_CELL_NO_PORTAL = 47,       /* info: nothing is seen from outside of it */
    ENF_PROBLEM_CELL_FACE_NOT_PLANAR = 48, /* warning */
    /* Rooms, openings, objects. */
    ENF_PROBLEM_ROOM_EMPTY = 60,         /* info: no cell */
    ENF_PROBLEM_OPENING_UNUSED = 61,     /* info: no portal and no cell */
    ENF_PROBLEM_OBJECT_UNPLACED = 62,    /* warning: in no cell, treated as always visible */
    ENF_PROBLEM_ROOM_NOT_CLOSED = 63,    /* warning: shape isn't closed; its convex hull is one cell */
    ENF_PROBLEM_ROOM_NOT_PLANAR = 64,    /* warning: a face was split into triangles */
    ENF_PROBLEM_ROOM_DECOMPOSITION = 65, /* warning: gave up; the convex hull is one cell */
    ENF_PROBLEM_JOIN_OUTSIDE = 66,       /* warning: part lies outside its room; to the nearest cell */
    ENF_PROBLEM_EXTERIOR_WHOLE = 67,     /* info: the outdoors couldn't be cut into cells and stay one */
    ENF_PROBLEM_ROOM_CURVED = 68,        /* info: facets of curved walls taken together; cells reach a little into them */
    /* Scene. */
    ENF_PROBLEM_SCENE_EMPTY = 80, /* warning */
    ENF_PROBLEM_MORE = 82         /* info: further problems of a code, counted but not listed */
};

typedef struct EnfProblems {
    EnfProblem *items;
    uint64_t count;
    uint64_t kept_count; /* the first ones, found while adding: a new commit doesn't forget them */
    uint64_t error_count, warning_count;
    uint64_t code_counts[96]; /* found, listed or not; indexed by code */
    uint64_t kept_code_counts[96];
    int out_of_memory;
} EnfProblems;

/* Of one code at most this many are listed; all are counted. */
enum { ENF_PROBLEMS_LISTED = 1000 };

/* position may be NULL. Truncates long messages. */
#if defined(__GNUC__)
__attribute__((format(printf, 7, 8)))
#endif
void enf_problem_add(EnfScene *scene, uint32_t severity, uint32_t item, uint32_t index, uint32_t code,
                     const double *position, const char *format, ...);
/* Forgets all but those found while adding; `keep` first makes the present ones such. */
void enf_problems_restart(EnfScene *scene);
void enf_problems_keep(EnfScene *scene);
void enf_problems_destroy(EnfProblems *problems);
/* Appends "and N more" lines where a code found more than it lists. */
void enf_problems_finish(EnfScene *scene);
const char *enf_item_word(uint32_t item);

#endif
