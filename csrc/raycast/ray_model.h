/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cells packed for rays: face planes side by side, portals beside the face they lie in. Internal to the core. */
#ifndef ENF_RAYCAST_RAY_MODEL_H
#define ENF_RAYCAST_RAY_MODEL_H

#include "enfilade/raycast.h"
#include "raycast/prism_model.h"
#include "base/threads.h"
#include "scene/scene_data.h"

/* What the scene has is read from there: only what belongs to rays is kept. Sides are numbered as scene->cell_portals, but sorted by the
 * face they lie in. */
typedef struct RayFace {
    uint32_t side_first, side_count; /* into EnfRaycaster.sides */
    uint32_t whole;                  /* 1: its only portal leaves nothing of it */
    float off;                       /* metres: its portals' corners lie no farther from its plane */
} RayFace;

struct EnfRaycaster {
    const EnfScene *scene;
    uint32_t cell_count, face_count;
    RayFace *faces;  /* [faces of the scene] */
    uint32_t *sides; /* [cell portals of the scene] into scene->cell_portals: cell by cell, face by face, those of no face last */
    const EnfTriangles *furniture; /* borrowed; NULL: none */
    PrismModel prisms;
    EnfMutex *lock;        /* while links are set anew */
    uint64_t state_serial; /* of the scene, when they were; read and written atomically */
};

/* Every query begins with it: follows the openings' states. The scene doesn't change while queries run, so only the first one after a
 * change writes, and no other reads links before that. */
void enf_raycaster_follow_states(const EnfRaycaster *raycaster);

/* A portal as its cell's rays meet it: corners counter-clockwise seen from inside the cell, recentred by the scene's origin. */
typedef struct RayPortal {
    uint32_t portal, to;
    uint32_t corner_first, corner_count;
    int reversed;
    double normal[3]; /* out of the cell */
} RayPortal;

static inline RayPortal enf_ray_portal(const EnfRaycaster *r, uint32_t side) {
    const EnfScene *scene = r->scene;
    const EnfCellPortal *of = &scene->cell_portals[r->sides[side]];
    const double *n = scene->portal_planes[of->portal].n, sign = of->side ? -1 : 1;
    uint32_t first = scene->portal_vertex_first[of->portal];
    /* committed corners run counter-clockwise seen from cells[0] */
    RayPortal portal = {of->portal,    of->to,
                        first,         scene->portal_vertex_first[of->portal + 1] - first,
                        of->side != 0, {sign * n[0], sign * n[1], sign * n[2]}};
    return portal;
}

static inline void enf_ray_portal_corner(const EnfRaycaster *r, const RayPortal *portal, uint32_t i, double out[3]) {
    const double *v = r->scene->portal_vertices[portal->corner_first + (portal->reversed ? portal->corner_count - 1 - i : i)];
    for (int k = 0; k < 3; k++)
        out[k] = v[k] - r->scene->origin[k];
}

static inline uint32_t enf_ray_face_corners(const EnfRaycaster *r, uint32_t face) {
    return r->scene->face_index_first[face + 1] - r->scene->face_index_first[face];
}

/* Corner i of a face of `cell`, counter-clockwise seen from outside, recentred. */
static inline void enf_ray_face_corner(const EnfRaycaster *r, uint32_t cell, uint32_t face, uint32_t i, double out[3]) {
    const EnfScene *scene = r->scene;
    const double *v = scene->cell_vertices[scene->cell_vertex_first[cell] + scene->face_indices[scene->face_index_first[face] + i]];
    for (int k = 0; k < 3; k++)
        out[k] = v[k] - scene->origin[k];
}

typedef struct RayStep {
    double at;        /* distance where it leaves the cell */
    uint32_t surface; /* that it hits there; ENF_NONE: none */
    uint32_t portal;  /* that it passes; ENF_NONE: none. Both: it leaves a cell without faces for nothing */
    uint32_t to;      /* the cell behind */
} RayStep;
/* One cell on: where the ray from o (recentred) along d leaves `cell`, not before `at`. */
RayStep enf_ray_step(const EnfRaycaster *raycaster, uint32_t cell, const double o[3], const double d[3], double at);
/* More cells than any walk has: convex ones are met once each, so only wrong geometry (overlapping cells, portals off their faces) could go
 * round. */
static inline uint32_t enf_ray_cell_cap(const EnfRaycaster *r) {
    return 2 * r->cell_count + 64;
}

#endif
