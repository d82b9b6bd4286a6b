/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cells packed for rays: face planes side by side, portals beside the face they lie in. Internal to the core. */
#ifndef ENF_RAYCAST_RAY_MODEL_H
#define ENF_RAYCAST_RAY_MODEL_H

#include "enfilade/raycast.h"
#include "raycast/prism_model.h"
#include "base/threads.h"
#include "scene/scene_data.h"

/* A portal as its cell's rays meet it. Corners run counter-clockwise seen from inside the cell, recentred by the scene's origin. */
typedef struct RayPortal {
    uint32_t portal;
    uint32_t to;
    uint32_t corner_first, corner_count; /* into EnfRaycaster.corners */
    double normal[3];                    /* out of the cell */
} RayPortal;

typedef struct RayFace {
    double normal[3]; /* out of the cell */
    double point[3];  /* on the face, recentred: n . (p - o) keeps the digits that d - n . o loses */
    uint32_t portal_first, portal_count; /* into EnfRaycaster.portals */
    uint32_t corner_first, corner_count; /* into EnfRaycaster.face_corners: vertex numbers */
} RayFace;

typedef struct RayCell {
    uint32_t face_first, face_count;     /* faces of the scene */
    uint32_t portal_first, portal_count; /* all its portals, face by face; those of no face last */
} RayCell;

struct EnfRaycaster {
    const EnfScene *scene;
    uint32_t cell_count, face_count;
    RayCell *cells;
    RayFace *faces;
    RayPortal *portals;
    double (*corners)[3];
    uint32_t *face_corners; /* global vertex numbers, counter-clockwise seen from outside */
    double (*vertices)[3];  /* recentred, all cells' */
    const EnfTriangles *furniture; /* borrowed; NULL: none */
    PrismModel prisms;
    EnfMutex *lock;           /* while links are set anew */
    uint64_t state_serial;    /* of the scene, when they were; read and written atomically */
};

/* Every query begins with it: follows the openings' states. The scene doesn't change while queries run, so only the first one after a
 * change writes, and no other reads links before that. */
void enf_raycaster_follow_states(const EnfRaycaster *raycaster);

typedef struct RayStep {
    double at;        /* distance where it leaves the cell */
    uint32_t surface; /* that it hits there; ENF_NONE: none */
    uint32_t portal;  /* that it passes; ENF_NONE: none. Both: it leaves a cell without faces for nothing */
    uint32_t to;      /* the cell behind */
} RayStep;
/* One cell on: where the ray from o (recentred) along d leaves `cell`, not before `at`. */
RayStep enf_ray_step(const EnfRaycaster *raycaster, uint32_t cell, const double o[3], const double d[3], double at);

#endif
