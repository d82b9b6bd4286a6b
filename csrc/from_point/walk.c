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

/* Frames to plan for: doubled while the guesses hold, else as many as the last one held; half as many when that costs too much. */
enum { FEWEST = 4, FEWEST_AHEAD = 6, FIRST_AHEAD = 16, MOST_AHEAD = 64, LONGEST_PAUSE = 64 };
/* A planned answer may cost this much of the plain ones it stands for: below FEWEST frames it hardly can. */
static const double worth = 0.5;
/* Of one plain answer: up to CHEAP twice as long a way may be tried, from DEAR on half of it sees less that others don't, MOST_DEAR is
 * given up. */
#define CHEAP     1.8
#define DEAR      2.2
#define MOST_DEAR 3.5

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

/* Whether the four corners of the camera's view lie within the lines of the screen that was asked for. */
static int views_within(const EnfWalk *walk, const EnfCamera *camera) {
    double axis[3][3], tan_x = tan(0.5 * camera->angle_x), tan_y = tan(0.5 * camera->angle_y);
    if (!axes_of(camera, axis))
        return 0;
    for (int k = 0; k < 4; k++) {
        double u = (((k & 1) ? 1 : -1) + 2 * camera->shift_x) * tan_x, v = (((k & 2) ? 1 : -1) + 2 * camera->shift_y) * tan_y, d[3];
        for (int c = 0; c < 3; c++)
            d[c] = u * axis[0][c] + v * axis[1][c] - axis[2][c];
        double w = row_dot(walk->rows[2], d);
        if (!(w > 1e-3))
            return 0;
        double x = row_dot(walk->rows[0], d) / w, y = row_dot(walk->rows[1], d) / w;
        for (uint32_t i = 0; i < walk->line_count; i++)
            if (!(walk->lines[i].a * x + walk->lines[i].b * y + walk->lines[i].c >= 0))
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
    if (walk->line_count == 0)
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

/* The largest part (0..1) by which the eyes may be drawn towards `eye` and lie in the cell, farther from its faces and portals than
 * their near planes reach: an eye on a portal's plane starts behind it too. Negative: not even `eye` does. */
static double share_within_cell(const EnfView *view, uint32_t cell, const double eye[3], double near_reach, const EnfWiden *widen) {
    const EnfScene *scene = view->index->scene;
    const EnfViewCell *packed = &view->index->cells[cell];
    const double margin = 4 * fmax(view->index->tolerance, view->def.start_tolerance);
    uint32_t faces = scene->cell_face_first[cell + 1] - scene->cell_face_first[cell];
    double share = 1;
    for (uint32_t i = 0; i < faces + packed->side_count; i++) {
        const double *n, *on;
        double depth, reach = 0, point[3];
        if (i < faces) {
            const EnfPlane *plane = &scene->face_planes[scene->cell_face_first[cell] + i];
            n = plane->n;
            vec_mad(point, scene->origin, plane->d, n);
            on = point;
            depth = -margin - near_reach;
        } else {
            const EnfPortalSide *side = &view->index->sides[packed->side_first + i - faces];
            n = side->n;
            on = view->index->vertices[side->vertex_first];
            depth = -margin - near_reach - side->slack;
        }
        for (int c = 0; c < 3; c++)
            depth += n[c] * (on[c] - eye[c]);
        if (!(depth > 0))
            return -1;
        for (uint32_t e = 0; e < widen->eye_count; e++) {
            double apart[3];
            vec_sub(apart, widen->eyes[e], eye);
            reach = fmax(reach, vec_dot(n, apart));
        }
        if (reach > depth)
            share = fmin(share, depth / reach);
    }
    return share;
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

/* What the camera sees on these frames, as view->screens. 0: it turns too far for one screen. */
static int screens_ahead(EnfView *view, const EnfCamera *camera, const double eye[3], double axis[3][3], const double about[3],
                         double frames, EnfWiden *widen) {
    EnfWalk *walk = &view->walk;
    EnfCamera way[2] = {*camera, *camera};
    for (int k = 0; k < 3; k++) {
        double turned[3] = {axis[k][0], axis[k][1], axis[k][2]};
        rotate(turned, about, frames * walk->turn);
        for (int c = 0; c < 3; c++)
            way[1].world_from_camera[4 * c + k] = turned[c];
    }
    eyes_ahead(walk, eye, frames, widen);
    widen->angle = 1e-3 + fmin(1, fmax(0.02 * frames * walk->turn, 0.6 * walk->twist * frames * frames));
    return enf_screens_from_cameras(way, 0, 2, 1, widen, &view->screens) == ENF_OK && view->screens.screen_count == 1;
}

/* Plans don't pay here: plain queries, more of them each time. */
static void wait_longer(EnfWalk *walk) {
    walk->patience = walk->patience ? 2 * walk->patience : 2;
    walk->pause = walk->patience = walk->patience > LONGEST_PAUSE ? LONGEST_PAUSE : walk->patience;
}

int enf_walk_plan(EnfView *view, const EnfCamera *camera) {
    EnfWalk *walk = &view->walk;
    double about[3], eye[3], axis[3][3];
    if (walk->frames) { /* how the last guess did */
        const uint32_t whole = walk->cost < CHEAP ? 2 * walk->frames : walk->cost < DEAR ? walk->frames : walk->frames / 2;
        walk->ahead = walk->held + 2 >= walk->frames ? whole : walk->held + 1;
        walk->ahead = walk->ahead > MOST_AHEAD ? MOST_AHEAD : walk->ahead < FEWEST_AHEAD ? FEWEST_AHEAD : walk->ahead;
        walk->frames = 0;
        if (walk->held < 2)
            wait_longer(walk);
        else
            walk->patience = 0;
    }
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
    double share = share_within_cell(view, cell, eye, enf_near_reach(camera, 0), &widen);
    frames *= 0.999 * share;
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
    view->work_limit = (uint64_t)(fmin(worth * frames, MOST_DEAR) * fmax(walk->plain_work, 200));
    return 1;
}

void enf_walk_answered(EnfView *view, const EnfCamera *camera, int planned) {
    EnfWalk *walk = &view->walk;
    walk->has_answer = 1;
    remember(walk, camera);
    walk->def = view->def;
    walk->door_state = view->index->scene->state_serial;
    walk->line_count = 0;
    if (walk->ahead == 0)
        walk->ahead = FIRST_AHEAD;
    if (!planned) {
        walk->plain_work = (double)view->stats.work;
        walk->pause -= walk->pause > 0;
        return;
    }
    const EnfScreen *screen = &view->screens.screen[0];
    memcpy(walk->rows, screen->rows, sizeof walk->rows);
    walk->line_count = screen->view.n;
    walk->held = 0;
    walk->cost = (double)view->stats.work / fmax(walk->plain_work, 200);
    enf_poly_store(&screen->view, walk->lines);
    enf_corners_outline(walk->lines, walk->line_count, screen->view_rect, 0);
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
