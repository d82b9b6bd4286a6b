/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cameras (lens, shift, sensor fit resolved by the caller; perspective, orthographic, panoramic; one or several) as screens. */
#include "from_point/view_screen.h"

#include "base/status.h"

#include <float.h>
#include <math.h>
#include <string.h>

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross3(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static int normalise3(double v[3]) {
    double length = sqrt(dot3(v, v));
    if (!(length > 1e-300) || !isfinite(length))
        return 0;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return 1;
}

/* The camera's axes as world vectors (columns of the matrix, scale removed as Blender does), and the inverse's rows. */
typedef struct Pose {
    double axis[3][3];    /* right, up, back */
    double inverse[3][3]; /* camera coordinate i of a world vector: inverse[i] . v */
    double eye[3];
    int mirrored;
} Pose;

static EnfStatus read_pose(const EnfCamera *camera, uint32_t index, Pose *pose) {
    const double *m = camera->world_from_camera;
    for (int i = 0; i < 16; i++)
        if (!isfinite(m[i]))
            return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: world_from_camera[%d] is not finite", index, i);
    for (int c = 0; c < 3; c++) {
        for (int r = 0; r < 3; r++)
            pose->axis[c][r] = m[4 * r + c];
        if (!normalise3(pose->axis[c]))
            return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: column %d of world_from_camera is zero", index, c);
        pose->eye[c] = m[4 * c + 3];
    }
    double volume;
    cross3(pose->axis[1], pose->axis[2], pose->inverse[0]);
    cross3(pose->axis[2], pose->axis[0], pose->inverse[1]);
    cross3(pose->axis[0], pose->axis[1], pose->inverse[2]);
    volume = dot3(pose->axis[0], pose->inverse[0]);
    if (!(fabs(volume) > 1e-6))
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: world_from_camera is singular", index);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            pose->inverse[r][c] /= volume;
    pose->mirrored = volume < 0;
    if (pose->mirrored) /* a negative scale: flip the screen, so that windings stay; shift_x flips with it */
        for (int c = 0; c < 3; c++) {
            pose->axis[0][c] = -pose->axis[0][c];
            pose->inverse[0][c] = -pose->inverse[0][c];
        }
    return ENF_OK;
}

static EnfStatus check_camera(const EnfCamera *camera, uint32_t index) {
    if (camera->struct_size < sizeof(EnfCamera))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "camera %u: struct_size is %u, expected %u", index, camera->struct_size,
                        (uint32_t)sizeof(EnfCamera));
    if (camera->type > ENF_CAMERA_PANO)
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: unknown type %u", index, camera->type);
    if (!isfinite(camera->shift_x) || !isfinite(camera->shift_y))
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: shift is not finite", index);
    if (camera->type == ENF_CAMERA_ORTHO) {
        if (!(camera->ortho_width > 0) || !(camera->ortho_height > 0) || !isfinite(camera->ortho_width) || !isfinite(camera->ortho_height))
            return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: orthographic size %g x %g", index, camera->ortho_width, camera->ortho_height);
    } else if (!(camera->angle_x > 0) || !(camera->angle_y > 0) || !isfinite(camera->angle_x) || !isfinite(camera->angle_y))
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: field of view %g x %g", index, camera->angle_x, camera->angle_y);
    if (isnan(camera->clip_near) || isnan(camera->clip_far) || camera->clip_near < 0)
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u: clip range %g .. %g", index, camera->clip_near, camera->clip_far);
    return ENF_OK;
}

static void finish_view(EnfScreen *screen) {
    enf_poly_rect(&screen->view, screen->view_rect);
}

static void full_view(EnfScreen *screen) {
    static const double whole[4] = {-1, -1, 1, 1};
    enf_poly_from_rect(&screen->view, whole);
    finish_view(screen);
}

/* A perspective screen from camera axes: half extents tan_x, tan_y at depth 1, centre moved by (shift) half extents. */
static void perspective(EnfScreen *screen, const Pose *pose, double tan_x, double tan_y, double shift_x, double shift_y) {
    screen->ortho = 0;
    double largest = 0;
    for (int c = 0; c < 3; c++) {
        double depth = -pose->inverse[2][c];
        screen->rows[0][c] = pose->inverse[0][c] / tan_x - shift_x * depth;
        screen->rows[1][c] = pose->inverse[1][c] / tan_y - shift_y * depth;
        screen->rows[2][c] = depth;
        screen->right[c] = tan_x * pose->axis[0][c];
        screen->up[c] = tan_y * pose->axis[1][c];
        screen->forward[c] = shift_x * screen->right[c] + shift_y * screen->up[c] - pose->axis[2][c];
        screen->look[c] = depth;
        screen->centre[c] = 0;
    }
    normalise3(screen->look); /* |inverse[2]| is 1 but for sheared cameras */
    screen->offset[0] = screen->offset[1] = 0;
    for (int r = 0; r < 2; r++)
        largest = fmax(largest, sqrt(dot3(screen->rows[r], screen->rows[r])));
    /* Long lenses and large shifts magnify the rounding of p - eye. */
    screen->outset = ENF_LINE_OUTSET * fmax(1.0, 0.05 * largest);
    full_view(screen);
}

static void orthographic(EnfScreen *screen, const Pose *pose, const EnfCamera *camera) {
    screen->ortho = 1;
    double half_x = 0.5 * camera->ortho_width, half_y = 0.5 * camera->ortho_height;
    double shift_x = (pose->mirrored ? -2 : 2) * camera->shift_x, shift_y = 2 * camera->shift_y;
    for (int c = 0; c < 3; c++) {
        screen->rows[0][c] = pose->inverse[0][c] / half_x;
        screen->rows[1][c] = pose->inverse[1][c] / half_y;
        screen->rows[2][c] = -pose->inverse[2][c];
        screen->right[c] = half_x * pose->axis[0][c];
        screen->up[c] = half_y * pose->axis[1][c];
        screen->centre[c] = shift_x * screen->right[c] + shift_y * screen->up[c];
        screen->forward[c] = -pose->axis[2][c];
        screen->look[c] = screen->rows[2][c];
    }
    normalise3(screen->look);
    screen->offset[0] = -shift_x;
    screen->offset[1] = -shift_y;
    screen->outset = ENF_LINE_OUTSET;
    full_view(screen);
}

static void add_start_point(EnfScreens *out, const double p[3]) {
    memcpy(out->start_points[out->start_point_count++], p, sizeof out->start_points[0]);
}

static void finish_start(EnfScreens *out) {
    for (int i = 0; i < 3; i++) {
        out->start_bounds[i] = INFINITY;
        out->start_bounds[3 + i] = -INFINITY;
        for (uint32_t k = 0; k < out->start_point_count; k++) {
            out->start_bounds[i] = fmin(out->start_bounds[i], out->start_points[k][i]);
            out->start_bounds[3 + i] = fmax(out->start_bounds[3 + i], out->start_points[k][i]);
        }
    }
}

static void grow_start(EnfScreens *out, double by) {
    out->start_grown = by;
    for (int c = 0; c < 3; c++) {
        out->start_bounds[c] -= by;
        out->start_bounds[3 + c] += by;
    }
}

/* How far the eyes lie from a point, less `depth` along the look, as the screen's rows measure it. */
static void spread_about(const EnfScreens *out, const double point[3], double depth, double spread[3]) {
    for (int r = 0; r < 3; r++)
        spread[r] = 0;
    for (uint32_t e = 0; e < out->eye_count; e++)
        for (int r = 0; r < 3; r++) {
            const double apart[3] = {out->eyes[e][0] - point[0], out->eyes[e][1] - point[1], out->eyes[e][2] - point[2]};
            spread[r] = fmax(spread[r], fabs(dot3(out->screen[0].rows[r], apart) - (r == 2 ? depth : 0)) * (1 + 1e-9));
        }
}

/* What walks see is found from the middle of their eyes: where `behind` and `lift` say that it is, which far from the origin isn't quite
 * where its own coordinates do. */
static void measure_spread(EnfScreens *out) {
    double rounding = 0, row_size = 0;
    out->from_middle = out->eye_count > 1;
    for (int c = 0; c < 3; c++) {
        out->middle[c] = 0.5 * (out->start_bounds[c] + out->start_bounds[3 + c]);
        rounding += 16 * DBL_EPSILON * fabs(out->middle[c]);
        for (int r = 0; r < 3; r++)
            row_size = fmax(row_size, fabs(out->screen[0].rows[r][c]));
    }
    spread_about(out, out->middle, 0, out->spread);
    out->lift = (fmax(out->spread[0], out->spread[1]) + out->spread[2]) * (1 + 1e-6) + 2 * row_size * rounding;
    for (int c = 0; c < 3; c++)
        out->behind[c] = out->middle[c] - out->lift * out->screen[0].forward[c];
    spread_about(out, out->behind, out->lift, out->spread);
}

/* The eye and, with a near plane, the corners where the view's edges meet it: rays of a renderer start in between. */
static void add_camera_start(EnfScreens *out, const EnfScreen *screen, const double eye[3], double near_depth) {
    if (!screen->ortho) {
        add_start_point(out, eye);
        if (!(near_depth > 0))
            return;
        out->near_first[out->near_count++] = out->start_point_count;
    }
    for (int k = 0; k < 4; k++) {
        double p[3], u = (k & 1) ? 1 : -1, v = (k & 2) ? 1 : -1;
        for (int c = 0; c < 3; c++) {
            double across = u * screen->right[c] + v * screen->up[c];
            /* Orthographic rays start on the near plane; with perspective `across` grows with depth. */
            p[c] = screen->ortho ? eye[c] + across + screen->centre[c] + near_depth * screen->forward[c]
                                 : eye[c] + near_depth * (across + screen->forward[c]);
        }
        add_start_point(out, p);
    }
}

/* The six faces of a cube round the eye, along the axes of `pose`. half_cone: only directions this far from where the
 * camera looks are wanted. [Units: radians] */
static void cube_screens(EnfScreens *out, const Pose *pose, double half_cone) {
    static const int order[6][3] = {{0, 1, 2}, {2, 1, 0}, {0, 2, 1}, {0, 1, 2}, {2, 1, 0}, {0, 2, 1}};
    const double half_diagonal = 0.9554; /* radians: from a face's middle to its corner, atan(sqrt 2), rounded up */
    out->screen_count = 0;
    for (int f = 0; f < 6; f++) {
        double sign = f < 3 ? 1 : -1;
        /* Face 0 looks along -back, i.e. forward; 3 backward; the others sideways. */
        double away = f == 0 ? 0 : f == 3 ? 3.14159265358979 : 1.5707963267949;
        if (away - half_diagonal > half_cone)
            continue;
        Pose face = *pose;
        for (int c = 0; c < 3; c++) {
            face.axis[0][c] = pose->axis[order[f][0]][c];
            face.axis[1][c] = pose->axis[order[f][1]][c];
            face.axis[2][c] = sign * pose->axis[order[f][2]][c];
        }
        double volume;
        cross3(face.axis[1], face.axis[2], face.inverse[0]);
        cross3(face.axis[2], face.axis[0], face.inverse[1]);
        cross3(face.axis[0], face.axis[1], face.inverse[2]);
        volume = dot3(face.axis[0], face.inverse[0]);
        if (volume < 0) { /* keep the screen's winding: mirror it */
            for (int c = 0; c < 3; c++)
                face.axis[0][c] = -face.axis[0][c];
            for (int r = 1; r < 3; r++)
                for (int c = 0; c < 3; c++)
                    face.inverse[r][c] = -face.inverse[r][c];
            volume = -volume;
        }
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                face.inverse[r][c] /= volume;
        /* A little over 45 degrees, so that neighbouring faces overlap rather than leave a seam. */
        perspective(&out->screen[out->screen_count++], &face, 1.0 + 1e-9, 1.0 + 1e-9, 0, 0);
    }
}

static int wide_angle(const EnfCamera *camera) {
    /* From 175 degrees on a plane screen wastes all its precision on its edges. */
    return camera->type == ENF_CAMERA_PANO || (camera->type == ENF_CAMERA_PERSP && (camera->angle_x > 3.054 || camera->angle_y > 3.054));
}

static double half_cone_of(const EnfCamera *camera) {
    if (camera->type == ENF_CAMERA_PERSP) /* beyond any plane: everything, direction left to the caller's angles */
        return 3.15;
    return fmin(3.15, 0.5 * (camera->angle_x + camera->angle_y));
}

static int same_lens(const EnfCamera *a, const EnfCamera *b) {
    return a->angle_x == b->angle_x && a->angle_y == b->angle_y && a->shift_x == b->shift_x && a->shift_y == b->shift_y &&
           a->clip_near == b->clip_near;
}

static int same_screen(const EnfCamera *a, const EnfCamera *b) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            if (a->world_from_camera[4 * r + c] != b->world_from_camera[4 * r + c])
                return 0;
    return a->angle_x == b->angle_x && a->angle_y == b->angle_y && a->shift_x == b->shift_x && a->shift_y == b->shift_y;
}

/* The first pose, turned to look along the mean of where the screens look. 0: there is no mean. */
static int mean_pose(const Pose *first, const EnfScreen *own, uint32_t count, Pose *mean) {
    double back[3] = {0, 0, 0}, up[3], right[3];
    for (uint32_t i = 0; i < count; i++) {
        double f[3] = {own[i].forward[0], own[i].forward[1], own[i].forward[2]};
        if (!normalise3(f))
            return 0;
        for (int c = 0; c < 3; c++)
            back[c] -= f[c];
    }
    if (!normalise3(back))
        return 0;
    cross3(first->axis[1], back, right);
    if (!normalise3(right)) {
        cross3(first->axis[0], back, up);
        if (!normalise3(up))
            return 0;
        cross3(up, back, right);
    }
    cross3(back, right, up);
    *mean = *first;
    for (int c = 0; c < 3; c++) {
        mean->axis[0][c] = mean->inverse[0][c] = right[c];
        mean->axis[1][c] = mean->inverse[1][c] = up[c];
        mean->axis[2][c] = mean->inverse[2][c] = back[c];
    }
    return 1;
}

/* Puts a direction, and with it all within `margin` radians, onto the plane that the pose looks at. 0: they are too far aside, or have no
 * room. */
static int add_direction(const Pose *pose, const double d[3], double margin, EnfPoly *hull) {
    double depth = -dot3(pose->axis[2], d);
    if (!(depth > 0.1) || margin > 0.2 * depth)
        return 0;
    double x = dot3(pose->axis[0], d) / depth, y = dot3(pose->axis[1], d) / depth;
    /* An angle is magnified by at most 1 / depth^2 on the plane; the corner moves into a square of that size. */
    double slack = margin > 0 ? 1.1 * margin / (depth * depth) + 2e-12 : 0;
    const uint32_t points = margin > 0 ? 4 : 1;
    if (hull->n + points > ENF_POLY_MAX)
        enf_poly_hull(hull);
    if (hull->n + points > ENF_POLY_MAX)
        return 0;
    for (uint32_t q = 0; q < points; q++, hull->n++) {
        hull->x[hull->n] = x + ((q & 1) ? slack : -slack);
        hull->y[hull->n] = y + ((q & 2) ? slack : -slack);
    }
    return 1;
}

/* Several differently turned cameras on one screen that looks along their mean: the view is the hull of their corners,
 * widened by `margin` radians. Returns 0 when their directions spread too far for one plane. */
static int common_screen(const Pose *poses, const EnfScreen *own, uint32_t count, double margin, EnfScreen *out) {
    Pose mean;
    EnfPoly hull;
    double rect[4];
    if (!mean_pose(&poses[0], own, count, &mean))
        return 0;
    hull.n = 0;
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 4; k++) {
            double d[3], u = (k & 1) ? 1 : -1, v = (k & 2) ? 1 : -1;
            for (int c = 0; c < 3; c++)
                d[c] = u * own[i].right[c] + v * own[i].up[c] + own[i].forward[c];
            if (!normalise3(d) || !add_direction(&mean, d, margin, &hull))
                return 0;
        }
    enf_poly_rect(&hull, rect);
    const double reach_x = fmax(-rect[0], rect[2]) * (1 + 1e-12), reach_y = fmax(-rect[1], rect[3]) * (1 + 1e-12);
    perspective(out, &mean, reach_x, reach_y, 0, 0);
    for (uint32_t i = 0; i < hull.n; i++) {
        hull.x[i] /= reach_x;
        hull.y[i] /= reach_y;
    }
    enf_poly_hull(&hull);
    if (hull.n < 3)
        return 0;
    enf_poly_tidy(&hull);
    out->view = hull;
    finish_view(out);
    return 1;
}

static double angle_between(const Pose *a, const Pose *b) {
    double trace = 0;
    for (int k = 0; k < 3; k++)
        trace += dot3(a->axis[k], b->axis[k]);
    return acos(fmax(-1.0, fmin(1.0, 0.5 * (trace - 1))));
}

/* Orthographic poses that only move and zoom see along one direction: one screen whose view is the hull of theirs. */
static void sweep_parallel(const EnfCamera *cameras, const Pose *poses, const EnfScreen *own, uint32_t count, EnfScreens *out) {
    EnfCamera wide = cameras[0];
    EnfPoly hull;
    double hindmost = 0, foremost = 0, reach[2] = {0, 0};
    hull.n = 0;
    wide.shift_x = wide.shift_y = 0;
    for (uint32_t i = 0; i < count; i++) {
        double apart[3];
        for (int c = 0; c < 3; c++)
            apart[c] = poses[i].eye[c] - poses[0].eye[c];
        hindmost = fmin(hindmost, dot3(own[0].look, apart));
        foremost = fmax(foremost, dot3(own[0].look, apart));
        for (int k = 0; k < 4; k++, hull.n++) {
            double q[3], u = (k & 1) ? 1 : -1, v = (k & 2) ? 1 : -1;
            for (int c = 0; c < 3; c++)
                q[c] = apart[c] + u * own[i].right[c] + v * own[i].up[c] + own[i].centre[c];
            hull.x[hull.n] = dot3(poses[0].inverse[0], q);
            hull.y[hull.n] = dot3(poses[0].inverse[1], q);
            reach[0] = fmax(reach[0], fabs(hull.x[hull.n]));
            reach[1] = fmax(reach[1], fabs(hull.y[hull.n]));
        }
    }
    wide.ortho_width = 2 * reach[0] * (1 + 1e-12);
    wide.ortho_height = 2 * reach[1] * (1 + 1e-12);
    Pose behind = poses[0]; /* sight starts where the hindmost camera stands */
    for (int c = 0; c < 3; c++)
        behind.eye[c] += hindmost * own[0].look[c];
    orthographic(&out->screen[0], &behind, &wide);
    for (uint32_t i = 0; i < hull.n; i++) {
        hull.x[i] /= 0.5 * wide.ortho_width;
        hull.y[i] /= 0.5 * wide.ortho_height;
    }
    enf_poly_hull(&hull);
    enf_poly_tidy(&hull);
    out->screen[0].view = hull;
    finish_view(&out->screen[0]);
    memcpy(out->eyes[0], behind.eye, sizeof out->eyes[0]);
    out->eye_count = out->screen_count = 1;
    out->far_depth += foremost - hindmost;
    out->near_depth = 0;
}

/* Orthographic poses that turn: eyes anywhere in a box round all that sight starts from, looking anywhere within the turn. */
static void sweep_turning(const Pose *poses, const EnfScreen *own, uint32_t count, double turn, EnfScreens *out) {
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, radius = 0, half_cone = 0;
    for (uint32_t k = 0; k < out->start_point_count; k++) {
        const double *p = out->start_points[k];
        double far2 = INFINITY;
        for (uint32_t i = 0; i < count; i++) {
            double q[3] = {p[0] - poses[i].eye[0], p[1] - poses[i].eye[1], p[2] - poses[i].eye[2]};
            far2 = fmin(far2, dot3(q, q));
        }
        radius = fmax(radius, sqrt(far2));
        for (int c = 0; c < 3; c++) {
            lo[c] = fmin(lo[c], p[c]);
            hi[c] = fmax(hi[c], p[c]);
        }
    }
    /* Between two poses a point leaves the straight way by at most radius turn^2 / 8; doubled. */
    double bulge = 0.25 * radius * turn * turn;
    for (uint32_t i = 1; i < count; i++)
        half_cone = fmax(half_cone, acos(fmax(-1.0, fmin(1.0, dot3(own[0].look, own[i].look)))));
    half_cone += 0.25 * turn * turn + 1e-9;
    out->eye_count = 8;
    out->start_point_count = 0;
    for (int k = 0; k < 8; k++) {
        for (int c = 0; c < 3; c++)
            out->eyes[k][c] = ((k >> c) & 1) ? hi[c] + bulge : lo[c] - bulge;
        add_start_point(out, out->eyes[k]);
    }
    if (half_cone < 1.2) {
        perspective(&out->screen[0], &poses[0], tan(half_cone), tan(half_cone), 0, 0);
        out->screen_count = 1;
    } else
        cube_screens(out, &poses[0], 3.15);
    out->far_depth = INFINITY;
    out->near_depth = 0;
}

double enf_near_reach(const EnfCamera *camera, int wide) {
    double tan_x = wide ? 1 : tan(0.5 * camera->angle_x), tan_y = wide ? 1 : tan(0.5 * camera->angle_y);
    double u = tan_x * (1 + 2 * fabs(camera->shift_x)), v = tan_y * (1 + 2 * fabs(camera->shift_y));
    return camera->clip_near > 0 ? camera->clip_near * sqrt(1 + u * u + v * v) : 0;
}

EnfStatus enf_screens_from_cameras(const EnfCamera *all, uint32_t first, uint32_t count, int swept, const EnfWiden *widen,
                                   EnfScreens *out) {
    const EnfCamera *cameras = all + first;
    Pose poses[ENF_EYES_MAX];
    EnfScreen own[ENF_EYES_MAX];
    if (count == 0 || count > ENF_EYES_MAX)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "%u cameras in one query; 1 to %u are possible", count, (unsigned)ENF_EYES_MAX);
    out->start_point_count = out->screen_count = out->near_count = 0;
    out->start_grown = out->near_radius = 0;
    out->from_middle = 0;
    out->between = swept && count > 1 ? ENF_BETWEEN_PAIRS : ENF_BETWEEN_NONE;
    out->clip_near = cameras[0].clip_near;
    out->far_depth = 0;
    out->near_depth = INFINITY;
    int wide = 0, same = 1, zooms = 0;
    double half_cone = 0, turn = 0, reach = 0;
    for (uint32_t i = 0; i < count; i++) {
        EnfStatus status = check_camera(&cameras[i], first + i);
        if (status == ENF_OK)
            status = read_pose(&cameras[i], first + i, &poses[i]);
        if (status != ENF_OK)
            return status;
        if (cameras[i].type != cameras[0].type)
            return enf_fail(ENF_ERROR_BAD_INPUT, "camera %u is of another type than camera %u: no motion leads from one to the other",
                            first + i, first);
        wide |= wide_angle(&cameras[i]);
        same &= i == 0 || same_screen(&cameras[0], &cameras[i]);
        half_cone = fmax(half_cone, half_cone_of(&cameras[i]));
        /* clip_far 0 in a zeroed camera means none was given. */
        out->far_depth = fmax(out->far_depth, cameras[i].clip_far > 0 ? cameras[i].clip_far : INFINITY);
        out->near_depth = fmin(out->near_depth, cameras[i].clip_near);
        if (i > 0) {
            double angle = angle_between(&poses[i - 1], &poses[i]);
            turn = fmax(turn, angle);
            half_cone += angle;
            zooms |= !same_lens(&cameras[0], &cameras[i]);
        }
        memcpy(out->eyes[i], poses[i].eye, sizeof out->eyes[i]);
    }
    out->eye_count = count;
    if (cameras[0].type == ENF_CAMERA_ORTHO) {
        out->between = ENF_BETWEEN_NONE; /* sections may cut walls */
        int parallel = 1;
        for (uint32_t i = 0; i < count; i++) {
            orthographic(&own[i], &poses[i], &cameras[i]);
            add_camera_start(out, &own[i], poses[i].eye, 0);
            add_camera_start(out, &own[i], poses[i].eye, cameras[i].clip_near);
            parallel &= memcmp(poses[i].inverse, poses[0].inverse, sizeof poses[0].inverse) == 0;
        }
        if (count == 1) {
            out->screen[0] = own[0];
            out->screen_count = 1;
        } else if (parallel)
            sweep_parallel(cameras, poses, own, count, out);
        else
            sweep_turning(poses, own, count, turn, out);
        finish_start(out);
        memcpy(out->middle, out->eyes[0], sizeof out->middle);
        return ENF_OK;
    }
    if (!wide)
        for (uint32_t i = 0; i < count; i++)
            perspective(&own[i], &poses[i], tan(0.5 * cameras[i].angle_x), tan(0.5 * cameras[i].angle_y),
                        (poses[i].mirrored ? -2 : 2) * cameras[i].shift_x, 2 * cameras[i].shift_y);
    /* Turning about one axis, a corner leaves the great circle between its ends by at most turn^2 / 8; doubled. */
    double margin = swept ? 0.25 * turn * turn : 0;
    if (!wide && same) {
        out->screen[0] = own[0];
        out->screen_count = 1;
    } else if (!wide && common_screen(poses, own, count, margin, &out->screen[0])) {
        out->screen_count = 1;
    } else {
        cube_screens(out, &poses[0], wide && cameras[0].type == ENF_CAMERA_PANO ? half_cone : 3.15);
        out->far_depth = INFINITY; /* depth along each face isn't the camera's */
    }
    for (uint32_t i = 0; i < count; i++) {
        out->pose_first[i] = out->start_point_count;
        reach = fmax(reach, enf_near_reach(&cameras[i], wide));
        if (!wide)
            add_camera_start(out, &own[i], poses[i].eye, cameras[i].clip_near);
        else {
            add_start_point(out, poses[i].eye);
            if (cameras[i].clip_near > 0) {
                out->near_first[out->near_count++] = out->start_point_count;
                out->near_radius = fmax(out->near_radius, cameras[i].clip_near);
            }
            if (cameras[i].clip_near > 0)
                for (int k = 0; k < 4; k++) { /* a ball of the near distance, as two corners of its box (twice) */
                    double p[3];
                    for (int c = 0; c < 3; c++)
                        p[c] = poses[i].eye[c] + ((k & 1) ? 1 : -1) * cameras[i].clip_near;
                    add_start_point(out, p);
                }
        }
    }
    out->pose_first[count] = out->start_point_count;
    if (!same || wide)
        out->near_depth = 0;
    if (widen) { /* any eye of a region: its corners hull them all. Near rectangles are left to start_grown */
        out->near_count = 0;
        out->eye_count = widen->eye_count;
        out->start_point_count = 0;
        memcpy(out->eyes, widen->eyes, sizeof *out->eyes * widen->eye_count);
        for (uint32_t k = 0; k < widen->eye_count; k++)
            add_start_point(out, out->eyes[k]);
        out->near_depth = 0;
        out->far_depth = INFINITY;
    }
    finish_start(out);
    memcpy(out->middle, out->eyes[0], sizeof out->middle);
    if (widen) {
        measure_spread(out);
        grow_start(out, widen->near_reach);
    } else if (swept) /* corners of near rectangles turn as those of the view do; zooming, they go anywhere no farther from the eye */
        grow_start(out, 0.25 * turn * turn * reach + (zooms ? reach : 0));
    return ENF_OK;
}

EnfStatus enf_screens_from_region(const double bounds[6], const EnfCamera *look, EnfScreens *out) {
    for (int c = 0; c < 3; c++)
        if (!isfinite(bounds[c]) || !isfinite(bounds[3 + c]) || bounds[c] > bounds[3 + c])
            return enf_fail(ENF_ERROR_BAD_INPUT, "viewer region: axis %d runs from %g to %g", c, bounds[c], bounds[3 + c]);
    EnfCamera cameras[8];
    EnfCamera camera;
    memset(&camera, 0, sizeof camera);
    if (look)
        camera = *look;
    else {
        camera.struct_size = sizeof camera;
        camera.type = ENF_CAMERA_PANO;
        camera.angle_x = camera.angle_y = 6.283185307179586;
        camera.clip_far = INFINITY;
        for (int i = 0; i < 4; i++)
            camera.world_from_camera[5 * i] = 1;
    }
    if (camera.struct_size < sizeof camera)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "camera: struct_size is %u", camera.struct_size);
    for (int k = 0; k < 8; k++) {
        cameras[k] = camera;
        for (int c = 0; c < 3; c++)
            cameras[k].world_from_camera[4 * c + 3] = ((k >> c) & 1) ? bounds[3 + c] : bounds[c];
    }
    EnfStatus status = enf_screens_from_cameras(cameras, 0, 8, 0, NULL, out);
    /* Viewers stand in the box where it isn't wall; their near planes may reach into one wherever they stand. */
    if (status == ENF_OK && camera.clip_near > 0 && camera.type != ENF_CAMERA_ORTHO)
        out->between = ENF_BETWEEN_ALL;
    return status;
}
