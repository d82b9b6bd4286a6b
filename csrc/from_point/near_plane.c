/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whether a camera's rays start in cells: a renderer's begin on the near rectangle, and that may reach into a wall, where nothing
 * is known about what they meet (csrc/ALGORITHMS.md, "Where sight starts"). */
#include "from_point/view_data.h"

#include "base/memory.h"
#include "geometry/convex_solid.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

#include <string.h>

/* Pieces of a near rectangle that no cell has covered yet, and corners of each. Beyond, it counts as reaching into a wall. */
enum { PIECES_MAX = 32, CORNERS_MAX = 24 };

typedef struct Piece {
    double corners[CORNERS_MAX][3]; /* relative to the scene's origin, as the planes of faces are */
    uint32_t count;
} Piece;

/* Takes the cell out of a piece: what lies beyond each of its faces is put to `rest`, what is left lies in the cell. Slivers
 * thinner than `margin` are taken along. 0: too many pieces or corners. */
static int take_out(const EnfScene *scene, uint32_t cell, double margin, Piece *piece, Piece *rest, uint32_t *rest_count) {
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1] && piece->count > 0; f++) {
        if (*rest_count == PIECES_MAX || piece->count + 1 > CORNERS_MAX)
            return 0;
        Piece back, *front = &rest[*rest_count];
        enf_polygon_split(piece->corners, piece->count, scene->face_planes[f].n, scene->face_planes[f].d, margin, back.corners, &back.count,
                          front->corners, &front->count);
        *rest_count += front->count > 0;
        if (front->count > 0 || back.count == 0)
            *piece = back;
    }
    return 1;
}

/* Whether a rectangle lies in the start cells; its corners in order round it. */
static int covered(const EnfView *view, const double *const corners[4], double margin) {
    const EnfScene *scene = view->index->scene;
    Piece lists[2][PIECES_MAX], *open = lists[0], *rest = lists[1];
    uint32_t open_count = 1;
    for (int k = 0; k < 4; k++)
        vec_sub(open[0].corners[k], corners[k], scene->origin);
    open[0].count = 4;
    for (uint32_t i = 0; i < view->start_count && open_count > 0; i++) {
        uint32_t rest_count = 0;
        for (uint32_t p = 0; p < open_count; p++)
            if (!take_out(scene, view->start_cells[i], margin, &open[p], rest, &rest_count))
                return 0;
        Piece *swap = open;
        open = rest;
        rest = swap;
        open_count = rest_count;
    }
    return open_count == 0;
}

/* A panorama's rays start on a ball: the cube round it is asked. */
static int cube_covered(const EnfView *view, const double eye[3], double half, double margin) {
    for (int face = 0; face < 6; face++) {
        double corners[4][3];
        const double *ring[4] = {corners[0], corners[1], corners[2], corners[3]};
        int along = face % 3, u = (along + 1) % 3, v = (along + 2) % 3;
        for (int k = 0; k < 4; k++) {
            corners[k][along] = eye[along] + (face < 3 ? half : -half);
            corners[k][u] = eye[u] + (k == 1 || k == 2 ? half : -half);
            corners[k][v] = eye[v] + (k >= 2 ? half : -half);
        }
        if (!covered(view, ring, margin))
            return 0;
    }
    return 1;
}

/* ---- Between poses ---------------------------------------------------------------------------------------------------- */
/* Beyond so many cuts, or cells one in the other, what is left counts as wall. */
enum { CUTS_MAX = 2000, DEPTH_MAX = 64 };

typedef struct Sweep {
    const EnfView *view;
    EnfVertexPool pool; /* relative to the scene's origin */
    double margin;      /* metres: thinner is nothing */
    uint32_t cuts;
} Sweep;

static int solid_covered(Sweep *sweep, EnfSolid *solid, uint32_t first, uint32_t depth);

enum { CELL_HOLDS, CELL_BESIDE, WALL_REACHED };

/* Leaves of the solid what the start cell may hold; the rest has to lie in later ones. */
static int keep_in_cell(Sweep *sweep, EnfSolid *solid, uint32_t number, uint32_t depth) {
    const EnfScene *scene = sweep->view->index->scene;
    const uint32_t cell = sweep->view->start_cells[number];
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; f++) {
        EnfSolid back = {0}, front = {0};
        const EnfPlane *plane = &scene->face_planes[f];
        if (++sweep->cuts > CUTS_MAX || !enf_solid_cut(solid, &sweep->pool, 0, plane->n, plane->d, 2 * sweep->margin, &back, &front))
            return WALL_REACHED;
        if (back.face_count == 0) {
            enf_solid_free(&back);
            enf_solid_free(&front);
            return CELL_BESIDE;
        }
        enf_solid_free(solid);
        *solid = back;
        int held = !front.face_count || solid_covered(sweep, &front, number + 1, depth + 1);
        enf_solid_free(&front);
        if (!held)
            return WALL_REACHED;
    }
    return CELL_HOLDS;
}

/* Whether a solid lies in the start cells from number `first` on. The solid is used up. */
static int solid_covered(Sweep *sweep, EnfSolid *solid, uint32_t first, uint32_t depth) {
    int found = depth < DEPTH_MAX ? CELL_BESIDE : WALL_REACHED;
    for (uint32_t i = first; i < sweep->view->start_count && found == CELL_BESIDE; i++)
        found = keep_in_cell(sweep, solid, i, depth);
    enf_solid_free(solid);
    return found == CELL_HOLDS;
}

/* What the start points [first, end) of poses hull, in a box along the screen's axes and one along the scene's. */
static int hull_of_poses(Sweep *sweep, uint32_t first, uint32_t end, EnfSolid *out) {
    const EnfScreens *screens = &sweep->view->screens;
    const double grown = screens->start_grown + sweep->margin;
    double box[6], along[6], unit[3][3];
    box_empty(box);
    box_empty(along);
    vec_copy(unit[0], screens->screen[0].right);
    vec_copy(unit[1], screens->screen[0].up);
    vec_normalize(unit[0]);
    vec_normalize(unit[1]);
    vec_cross(unit[2], unit[0], unit[1]);
    for (uint32_t pose = first; pose < end; pose++) {
        /* Rays start at the eye, or on the near rectangle behind it in the list. */
        const uint32_t eye = screens->pose_first[pose], behind = screens->pose_first[pose + 1];
        for (uint32_t k = behind > eye + 1 ? eye + 1 : eye; k < behind; k++) {
            double p[3];
            vec_sub(p, screens->start_points[k], sweep->view->index->scene->origin);
            box_add_point(box, p);
            double q[3] = {vec_dot(unit[0], p), vec_dot(unit[1], p), vec_dot(unit[2], p)};
            box_add_point(along, q);
        }
    }
    box_grow(box, grown);
    if (!enf_solid_box(out, &sweep->pool, box))
        return 0;
    for (int k = 0; k < 6 && screens->near_radius == 0; k++) {
        EnfSolid back, front;
        double n[3];
        vec_scale(n, k < 3 ? -1 : 1, unit[k % 3]);
        if (!enf_solid_cut(out, &sweep->pool, 0, n, (k < 3 ? -along[k] : along[k]) + grown, 1e-3 * sweep->margin, &back, &front))
            return 0;
        enf_solid_free(&front);
        enf_solid_free(out);
        *out = back;
    }
    return 1;
}

/* Whether all that rays start from while the camera goes from pose to pose lies in the start cells. */
static int sweeps_covered(const EnfView *view, double margin) {
    const EnfScreens *screens = &view->screens;
    const uint32_t step = screens->between == ENF_BETWEEN_PAIRS ? 1 : screens->eye_count - 1;
    Sweep sweep = {view, {NULL, 0}, margin, 0};
    int held = 1;
    for (uint32_t i = 0; i + step < screens->eye_count && held; i += step) {
        EnfSolid solid = {0};
        held = hull_of_poses(&sweep, i, i + step + 1, &solid) && solid_covered(&sweep, &solid, 0, 0);
        enf_solid_free(&solid);
    }
    enf_free(sweep.pool.points);
    return held;
}

int enf_near_plane_in_cells(const EnfView *view) {
    const EnfScreens *screens = &view->screens;
    const double margin = view->def.start_tolerance > 0 ? view->def.start_tolerance : view->index->tolerance;
    if (view->start_enclosed)
        return 1;
    for (uint32_t i = 0; i < view->start_count; i++)
        if (!(view->index->cells[view->start_cells[i]].flags & ENF_VIEW_CELL_FACES))
            return 1; /* how far such a cell reaches isn't known: it may hold all of them */
    for (uint32_t k = 0; k < screens->near_count; k++) {
        const double(*p)[3] = screens->start_points + screens->near_first[k]; /* u before v: round it is 0, 1, 3, 2 */
        const double *ring[4] = {p[0], p[1], p[3], p[2]};
        if (screens->near_radius > 0 ? !cube_covered(view, p[-1], screens->near_radius, margin) : !covered(view, ring, margin))
            return 0;
    }
    return screens->between == ENF_BETWEEN_NONE || sweeps_covered(view, margin);
}
