/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walks: an answer made for the way that the camera seems to take is given again while the camera keeps to it.
 *
 * Safe direction: the last answer is given again only for a camera whose eye lies in the region that was asked for and whose
 * whole view lies within the directions that were asked for; both are checked, however the region was guessed. */
#include "from_point/view_data.h"

#include "geometry/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Frames to plan for, as long as they are cheap; half as many when they cost too much. */
enum { FEWEST = 4, FEWEST_AHEAD = 6, FIRST_AHEAD = 16, MOST_AHEAD = 64, LONGEST_PAUSE = 8 };
/* A planned answer may cost this much of the plain ones it stands for; what those ahead will cost only the last one tells. */
static const double worth = 0.7;
/* Of the last plain answer: below CHEAP twice as long a way may be tried, from DEAR on half of it, MOST_DEAR is given up. */
#define CHEAP     2.5
#define DEAR      6
#define MOST_DEAR 12
/* Of the budget of one query: a plan that is given up is followed by a plain one, and both together stay below a tenth of a second. */
#define MOST_BUDGET 2.5
/* A view that reaches farther aside than so many times its depth is planned in parts. */
#define WIDEST 4
/* Portals that a way may lead through: what lies beyond costs a screen each. */
enum { MOST_PASSED = 4 };

static double row_dot(const double row[3], const double d[3]) {
    return row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
}

static void eye_of(const EnfCamera *camera, double eye[3]) {
    for (int c = 0; c < 3; c++)
        eye[c] = camera->world_from_camera[4 * c + 3];
}

/* Right, up, back as unit columns; 0: not a pose. */
static int axes_of(const EnfCamera *camera, double axis[3][3]) {
    for (int k = 0; k < 3; k++) {
        for (int c = 0; c < 3; c++)
            axis[k][c] = camera->world_from_camera[4 * c + k];
        if (!(vec_normalize(axis[k]) > 0))
            return 0;
    }
    return 1;
}

static int same_lens(const EnfCamera *a, const EnfCamera *b) {
    return a->struct_size == b->struct_size && a->type == b->type && a->angle_x == b->angle_x && a->angle_y == b->angle_y &&
           a->shift_x == b->shift_x && a->shift_y == b->shift_y && a->ortho_width == b->ortho_width && a->ortho_height == b->ortho_height &&
           a->clip_near == b->clip_near && a->clip_far == b->clip_far;
}

static int same_pose(const EnfCamera *a, const EnfCamera *b) {
    return memcmp(a->world_from_camera, b->world_from_camera, sizeof a->world_from_camera) == 0;
}

/* The direction towards a corner (0..3) of the camera's view, of depth 1. */
static void corner_of(const EnfCamera *camera, double axis[3][3], double tan_x, double tan_y, int k, double d[3]) {
    const double u = (((k & 1) ? 1 : -1) + 2 * camera->shift_x) * tan_x, v = (((k & 2) ? 1 : -1) + 2 * camera->shift_y) * tan_y;
    for (int c = 0; c < 3; c++)
        d[c] = u * axis[0][c] + v * axis[1][c] - axis[2][c];
}

/* Whether the four corners of the camera's view lie within the view that was asked for. */
static int views_within(const EnfWalk *walk, const EnfCamera *camera) {
    double axis[3][3];
    if (!axes_of(camera, axis))
        return 0;
    for (int k = 0; k < 4; k++) {
        double d[3];
        corner_of(camera, axis, walk->tan_x, walk->tan_y, k, d);
        const double w = row_dot(walk->rows[2], d);
        if (!(fabs(row_dot(walk->rows[0], d)) <= w && fabs(row_dot(walk->rows[1], d)) <= w))
            return 0;
    }
    return 1;
}

static void remember(EnfWalk *walk, const EnfCamera *camera) {
    walk->before_last = walk->last;
    walk->last = *camera;
    walk->poses += walk->poses < 2;
}

int enf_walk_holds(EnfView *view, const EnfCamera *camera) {
    EnfWalk *walk = &view->walk;
    if (!walk->has_answer || walk->door_state != view->index->scene->state_serial ||
        memcmp(&walk->def, &view->def, sizeof view->def) != 0 || !same_lens(&walk->last, camera))
        return 0;
    if (!walk->planned)
        return same_pose(&walk->last, camera);
    double q[3], eye[3];
    eye_of(camera, eye);
    vec_sub(q, eye, walk->centre);
    /* Within by more than the rounding of coordinates; without extent it's the same number or it isn't. */
    double rounding = 8 * DBL_EPSILON * (fabs(eye[0]) + fabs(eye[1]) + fabs(eye[2]));
    for (int k = 0; k < 3; k++)
        if (!(fabs(vec_dot(q, walk->axis[k])) <= fmax(walk->half[k] - rounding, 0)))
            return 0;
    uint32_t cell, located;
    if (!views_within(walk, camera) ||
        (walk->cell != ENF_NONE &&
         (enf_scene_locate(view->index->scene, eye, &cell, 1, &located) != ENF_OK || located != 1 || cell != walk->cell)))
        return 0;
    walk->held++;
    remember(walk, camera);
    return 1;
}

/* Rotation that took the axes `from` to `to`, as an axis of rotation; gives the angle. */
static double turn_between(double from[3][3], double to[3][3], double about[3]) {
    double trace = 0;
    vec_set(about, 0, 0, 0);
    for (int k = 0; k < 3; k++) {
        double cross[3];
        trace += vec_dot(from[k], to[k]);
        vec_cross(cross, from[k], to[k]);
        vec_add(about, about, cross); /* the sum is 2 sin(angle) times the axis */
    }
    return vec_normalize(about) > 0 ? acos(fmax(-1.0, fmin(1.0, 0.5 * (trace - 1)))) : 0;
}

/* Rodrigues. */
static void rotate(double v[3], const double about[3], double angle) {
    double cross[3], along = vec_dot(about, v), s = sin(angle), c = cos(angle);
    vec_cross(cross, about, v);
    for (int k = 0; k < 3; k++)
        v[k] = c * v[k] + s * cross[k] + (1 - c) * along * about[k];
}

/* Where the eyes may go: from `eye` towards `widen`, staying farther from what bounds a cell than their near planes reach, for an eye on
 * a portal's plane starts behind it too. */
typedef struct Way {
    const EnfView *view;
    const double *eye;
    const EnfWiden *widen;
    double apart;
    uint32_t left; /* bits of the eyes that lie behind all portals passed */
} Way;

static double beyond(const double n[3], const double on[3], const double p[3]) {
    double q[3];
    vec_sub(q, p, on);
    return vec_dot(n, q);
}

static const double *point_of(const Way *way, const EnfPortalSide *side) {
    return way->view->index->vertices[side->vertex_first];
}

static int in_plane_of(const Way *way, const EnfPortalSide *side, const double n[3], const double on[3]) {
    return side && fabs(vec_dot(n, side->n)) > 0.999 && fabs(beyond(n, on, point_of(way, side))) <= 8 * way->view->index->tolerance;
}

/* Plane i of a cell: its faces, then its portals' planes. Gives by how much more than way->apart eyes must stay behind it. */
static double plane_of(const Way *way, uint32_t cell, uint32_t i, const double **n, double on[3]) {
    const EnfScene *scene = way->view->index->scene;
    const uint32_t first = scene->cell_face_first[cell], faces = scene->cell_face_first[cell + 1] - first;
    if (i < faces) {
        *n = scene->face_planes[first + i].n;
        vec_mad(on, scene->origin, scene->face_planes[first + i].d, *n);
        return 0;
    }
    const EnfPortalSide *side = &way->view->index->sides[way->view->index->cells[cell].side_first + i - faces];
    *n = side->n;
    vec_copy(on, point_of(way, side));
    return side->slack;
}

/* The part of the way (0..1) on which these eyes stay in the cell, whatever lies in the planes of `entry` and `exit`; which plane ends
 * it. Negative: not even `eye` does. */
static double share_within(const Way *way, uint32_t cell, uint32_t eyes, const EnfPortalSide *entry, const EnfPortalSide *exit,
                           uint32_t *out_plane) {
    const EnfScene *scene = way->view->index->scene;
    const uint32_t planes = scene->cell_face_first[cell + 1] - scene->cell_face_first[cell] + way->view->index->cells[cell].side_count;
    double share = 1;
    for (uint32_t i = 0; i < planes; i++) {
        const double *n;
        double on[3], reach = 0, depth = -way->apart - plane_of(way, cell, i, &n, on);
        if (in_plane_of(way, entry, n, on) || in_plane_of(way, exit, n, on))
            continue;
        depth -= beyond(n, on, way->eye);
        if (!(depth > 0))
            return -1;
        for (uint32_t left = eyes; left; left &= left - 1)
            reach = fmax(reach, beyond(n, way->eye, way->widen->eyes[enf_lowest_bit(left)]));
        if (depth < share * reach) {
            share = depth / reach;
            *out_plane = i;
        }
    }
    return share;
}

/* The eyes behind the portal's plane, if all of the eyes' hull that lies in the plane lies within the portal, so far that near planes do
 * too at up to 70 degrees: lines from eyes before it to eyes behind it pass there. 0: not so. */
static uint32_t eyes_through(const Way *way, const EnfPortalSide *side) {
    const double(*v)[3] = (const double(*)[3])point_of(way, side);
    uint32_t behind = 0;
    double past[8];
    for (uint32_t e = 0; e < way->widen->eye_count; e++) {
        past[e] = beyond(side->n, v[0], way->widen->eyes[e]);
        behind |= (uint32_t)(past[e] > 0) << e;
    }
    for (uint32_t i = 0; i < side->vertex_count; i++) {
        double edge[3], outward[3];
        vec_sub(edge, v[i + 1 < side->vertex_count ? i + 1 : 0], v[i]);
        vec_cross(outward, side->n, edge); /* clockwise round n (start_cells.c) */
        if (!(vec_normalize(outward) > 0))
            continue;
        for (uint32_t e = 0; e < way->widen->eye_count; e++)
            for (uint32_t f = 0; f < way->widen->eye_count; f++) {
                double p[3];
                if (behind >> e & 1 || !(behind >> f & 1))
                    continue;
                vec_sub(p, way->widen->eyes[f], way->widen->eyes[e]);
                if (past[f] - past[e] < vec_length(p) / 3)
                    return 0;
                vec_mad(p, way->widen->eyes[e], past[e] / (past[e] - past[f]), p);
                if (!(beyond(outward, v[i], p) < -3 * way->apart))
                    return 0;
            }
    }
    return behind;
}

/* The portal in this plane of the cell through which the way goes on; NULL: none. */
static const EnfPortalSide *way_out(const Way *way, uint32_t cell, uint32_t plane, uint32_t *out_eyes) {
    const EnfViewIndex *index = way->view->index;
    const double *n;
    double on[3];
    plane_of(way, cell, plane, &n, on);
    for (uint32_t s = index->cells[cell].side_first; s < index->cells[cell].side_first + index->cells[cell].side_count; s++) {
        const EnfPortalSide *side = &index->sides[s];
        if (in_plane_of(way, side, n, on) && side->slack == 0 && index->cells[side->to].flags & ENF_VIEW_CELL_FACES &&
            enf_portal_passes(index->scene, side->portal) && (*out_eyes = eyes_through(way, side)) != 0)
            return side;
    }
    return NULL;
}

/* The part of the way on which the eyes stay in the cell, or in those that it leads into through portals. What lies between the
 * portals that the eyes' hull passes is in the cell between them, because that is convex. */
static double share_of_way(Way *way, uint32_t cell) {
    const EnfPortalSide *entry = NULL;
    double sure = -1;
    for (int passed = 0; passed <= MOST_PASSED; passed++) {
        uint32_t plane = 0, further, unused;
        const double share = share_within(way, cell, way->left, entry, NULL, &plane);
        sure = fmax(sure, share);
        if (!(share > 0) || share >= 1 || !(way->view->index->cells[cell].flags & ENF_VIEW_CELL_FACES))
            break;
        const EnfPortalSide *side = way_out(way, cell, plane, &further);
        if (!side || share_within(way, cell, way->left & ~further, entry, side, &unused) < 1)
            break;
        way->left &= further;
        entry = side;
        cell = side->to;
    }
    return sure;
}

/* The eyes of the next `frames` frames if the camera goes on as it does: a box along the way, as slim as the last steps were
 * straight. A level way stays level to the bit, and a camera that only turns has one eye. */
static void eyes_ahead(EnfWalk *walk, const double eye[3], double frames, EnfWiden *widen) {
    double length = vec_length(walk->step), way = frames * length;
    const double up[3] = {0, 0, 1};
    int level = walk->step[2] == 0;
    vec_copy(walk->centre, eye);
    memset(walk->half, 0, sizeof walk->half);
    memset(walk->axis, 0, sizeof walk->axis);
    for (int k = 0; k < 3; k++)
        walk->axis[k][k] = 1;
    if (length > 0) {
        vec_scale(walk->axis[0], 1 / length, walk->step);
        vec_cross(walk->axis[1], up, walk->axis[0]);
        if (level || vec_normalize(walk->axis[1]) > 1e-6) {
            vec_normalize(walk->axis[1]);
            vec_cross(walk->axis[2], walk->axis[0], walk->axis[1]);
        } else { /* straight up or down */
            vec_set(walk->axis[1], 1, 0, 0);
            vec_cross(walk->axis[2], walk->axis[0], walk->axis[1]);
            vec_normalize(walk->axis[2]);
            vec_cross(walk->axis[1], walk->axis[2], walk->axis[0]);
        }
        if (level)
            vec_copy(walk->axis[2], up);
        double aside = fmin(way, fmax(2e-3 * way, 0.6 * walk->swerve * frames * frames));
        walk->half[0] = 0.5 * way * 1.01;
        walk->half[1] = aside;
        walk->half[2] = level ? 0 : aside;
        vec_mad(walk->centre, eye, 0.5 * way, walk->axis[0]);
        if (level)
            walk->centre[2] = eye[2];
    }
    widen->eye_count = 0;
    for (int k = 0; k < 8; k++) {
        double at[3] = {walk->centre[0], walk->centre[1], walk->centre[2]};
        int extra = 0;
        for (int c = 0; c < 3; c++) {
            extra |= (k >> c & 1) && walk->half[c] == 0;
            vec_mad(at, at, (k >> c & 1) ? walk->half[c] : -walk->half[c], walk->axis[c]);
        }
        if (!extra)
            vec_copy(widen->eyes[widen->eye_count++], at);
    }
}

/* How the camera moved since the query before, and how much that differed from the move before. 0: nothing to go by. */
static int watch_motion(EnfWalk *walk, const EnfCamera *camera, double about[3]) {
    const EnfCamera *poses[3] = {&walk->before_last, &walk->last, camera};
    double axes[3][3][3], eyes[3][3], before[3], turn_before;
    if (walk->poses < 2 || !same_lens(&walk->last, camera) || !same_lens(&walk->before_last, camera))
        return 0;
    for (int i = 0; i < 3; i++) {
        eye_of(poses[i], eyes[i]);
        if (!axes_of(poses[i], axes[i]) || !vec_finite(eyes[i]))
            return 0;
    }
    vec_sub(before, eyes[1], eyes[0]);
    vec_sub(walk->step, eyes[2], eyes[1]);
    turn_before = turn_between(axes[0], axes[1], about);
    walk->turn = turn_between(axes[1], axes[2], about);
    walk->swerve = vec_distance(walk->step, before);
    walk->twist = fabs(walk->turn - turn_before);
    /* A start, a stop, a corner: it may go on as it does on the step after. */
    const int jerk = walk->swerve > 0.25 * vec_length(walk->step) || walk->twist > 0.25 * walk->turn + 2e-3;
    const int first = jerk && !walk->jerked;
    walk->jerked = first;
    if (jerk)
        walk->swerve = walk->twist = 0;
    return !first;
}

/* What the camera sees on these frames, as view->screens: a rectangle about where it looks half way. 0: it turns too far for one screen. */
static int screens_ahead(EnfView *view, const EnfCamera *camera, const double eye[3], double axis[3][3], const double about[3],
                         double frames, EnfWiden *widen) {
    EnfWalk *walk = &view->walk;
    EnfCamera way = *camera;
    const double tan_x = tan(0.5 * camera->angle_x), tan_y = tan(0.5 * camera->angle_y);
    const double margin = 1e-3 + fmin(1, fmax(0.02 * frames * walk->turn, 0.6 * walk->twist * frames * frames));
    double mean[3][3], reach[2] = {0, 0};
    for (int k = 0; k < 3; k++) {
        vec_copy(mean[k], axis[k]);
        rotate(mean[k], about, 0.5 * frames * walk->turn);
        for (int c = 0; c < 3; c++)
            way.world_from_camera[4 * c + k] = mean[k][c];
    }
    for (int k = 0; k < 8; k++) {
        double d[3];
        corner_of(camera, axis, tan_x, tan_y, k, d);
        if (k >= 4)
            rotate(d, about, frames * walk->turn);
        const double depth = -vec_dot(d, mean[2]);
        for (int i = 0; i < 2; i++) {
            const double at = fabs(vec_dot(d, mean[i])) / depth;
            reach[i] = fmax(reach[i], at + margin * (1 + at * at));
        }
        if (!(depth > 0 && reach[0] < WIDEST && reach[1] < WIDEST))
            return 0;
    }
    way.angle_x = 2 * atan(reach[0]);
    way.angle_y = 2 * atan(reach[1]);
    way.shift_x = way.shift_y = 0;
    eyes_ahead(walk, eye, frames, widen);
    widen->near_reach = enf_near_reach(camera, 0);
    return enf_screens_from_cameras(&way, 0, 1, 0, widen, &view->screens) == ENF_OK;
}

/* Plans don't pay here: plain queries, more of them each time. */
static void wait_longer(EnfWalk *walk) {
    walk->patience = walk->patience ? 2 * walk->patience : 2;
    walk->pause = walk->patience = walk->patience > LONGEST_PAUSE ? LONGEST_PAUSE : walk->patience;
}

/* How the last guess did, and how far to look ahead next time. */
static void judge_last(EnfWalk *walk) {
    walk->ahead = walk->cost >= DEAR ? walk->ahead / 2 : walk->cost < CHEAP ? 2 * walk->ahead : walk->ahead;
    walk->ahead = walk->ahead > MOST_AHEAD ? MOST_AHEAD : walk->ahead < FIRST_AHEAD ? FIRST_AHEAD : walk->ahead;
    walk->frames = 0;
    if (walk->cost < worth * (walk->held + 1))
        walk->patience = 0;
    else
        wait_longer(walk);
}

int enf_walk_plan(EnfView *view, const EnfCamera *camera) {
    EnfWalk *walk = &view->walk;
    double about[3], eye[3], axis[3][3];
    if (walk->frames)
        judge_last(walk);
    walk->has_answer = 0;
    if (!watch_motion(walk, camera, about) || walk->pause > 0 || camera->type != ENF_CAMERA_PERSP)
        return 0;
    double length = vec_length(walk->step);
    double frames = fmin(walk->ahead, fmin(length > 0 ? view->def.reuse_distance / length : INFINITY,
                                           walk->turn > 0 ? view->def.reuse_angle / walk->turn : INFINITY));
    uint32_t cell, located = 0;
    eye_of(camera, eye);
    if (!(frames >= FEWEST) || !axes_of(camera, axis) || enf_scene_locate(view->index->scene, eye, &cell, 1, &located) != ENF_OK ||
        located != 1)
        return 0;
    EnfWiden widen;
    eyes_ahead(walk, eye, frames, &widen);
    Way way = {view, eye, &widen, 4 * fmax(view->index->tolerance, view->def.start_tolerance) + enf_near_reach(camera, 0),
               (1u << widen.eye_count) - 1};
    frames *= 0.999 * share_of_way(&way, cell);
    if (!(frames >= FEWEST))
        return 0;
    while (!screens_ahead(view, camera, eye, axis, about, frames, &widen))
        if (!((frames *= 0.5) >= FEWEST))
            return 0;
    if (view->def.occluders != ENF_OCCLUDERS_OFF && view->index->occluder_first && view->screens.eye_count > 1)
        return 0; /* several eyes see behind occluders */
    view->start_hint = cell;
    /* Whether an eye is in a cell without faces its locator alone can tell. */
    walk->cell = view->index->cells[cell].flags & ENF_VIEW_CELL_FACES ? ENF_NONE : cell;
    walk->frames = (uint32_t)frames;
    view->work_limit = (uint64_t)fmin(fmin(worth * frames, MOST_DEAR) * fmax(walk->plain_work, 200), MOST_BUDGET * view->def.work_budget);
    return 1;
}

void enf_walk_answered(EnfView *view, const EnfCamera *camera, int planned) {
    EnfWalk *walk = &view->walk;
    walk->has_answer = 1;
    remember(walk, camera);
    walk->def = view->def;
    walk->door_state = view->index->scene->state_serial;
    walk->planned = planned;
    if (walk->ahead == 0)
        walk->ahead = FIRST_AHEAD;
    if (!planned) {
        walk->plain_work = (double)view->stats.work;
        walk->pause -= walk->pause > 0;
        return;
    }
    memcpy(walk->rows, view->screens.screen[0].rows, sizeof walk->rows);
    walk->tan_x = tan(0.5 * camera->angle_x);
    walk->tan_y = tan(0.5 * camera->angle_y);
    walk->held = 0;
    walk->cost = (double)view->stats.work / fmax(walk->plain_work, 200);
}

void enf_walk_gave_up(EnfView *view) {
    EnfWalk *walk = &view->walk;
    walk->ahead = walk->frames / 2;
    if (walk->ahead < FEWEST_AHEAD) {
        walk->ahead = FEWEST_AHEAD;
        wait_longer(walk);
    }
    walk->frames = 0;
}
