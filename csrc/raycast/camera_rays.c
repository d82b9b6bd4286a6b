/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cameras of every type as rays: perspective and orthographic with shift, Blender's panoramas.
 *
 * The formulas of the panoramas are those of Blender's manual (Cycles, panoramic cameras) in our words; tests/blender holds them against
 * Cycles' own depth pass. */
#include "raycast/camera_rays.h"

#include "base/status.h"
#include "geometry/vec3.h"

static const double pi = 3.14159265358979323846;

EnfPanorama enf_default_panorama(void) {
    EnfPanorama p = {.kind = ENF_PANORAMA_EQUIRECTANGULAR,
                     .longitude = {-3.14159265358979323846, 3.14159265358979323846},
                     .latitude = {-1.57079632679489661923, 1.57079632679489661923},
                     .field = 3.14159265358979323846,
                     .lens = 10.5,
                     .sensor_width = 36,
                     .sensor_height = 24};
    return p;
}

EnfStatus enf_camera_rays(const EnfCamera *camera, const EnfPanorama *panorama, const double origin[3], uint32_t width, uint32_t height,
                          CameraRays *out) {
    const double *m = camera->world_from_camera;
    int finite = isfinite(camera->shift_x) && isfinite(camera->shift_y) && !isnan(camera->clip_near) && !isnan(camera->clip_far);
    for (int i = 0; i < 12; i++)
        finite = finite && isfinite(m[i]);
    if (camera->struct_size != sizeof *camera)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "camera: bad struct_size");
    if (!finite)
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera: a number isn't finite");
    if (width < 1 || height < 1 || width > 16384 || height > 16384)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "a picture of %u x %u pixels; 1 to 16384 a side are possible", width, height);
    out->camera = *camera;
    out->panorama = *panorama;
    out->width = width;
    out->height = height;
    for (int k = 0; k < 3; k++) {
        out->right[k] = m[4 * k];
        out->up[k] = m[4 * k + 1];
        out->forward[k] = -m[4 * k + 2];
        out->eye[k] = m[4 * k + 3] - origin[k];
    }
    if (!(vec_normalize(out->right) > 0) || !(vec_normalize(out->up) > 0) || !(vec_normalize(out->forward) > 0))
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera: its matrix has a zero axis");
    if (camera->type == ENF_CAMERA_PERSP) {
        if (!(camera->angle_x > 0 && camera->angle_x < pi) || !(camera->angle_y > 0 && camera->angle_y < pi))
            return enf_fail(ENF_ERROR_BAD_INPUT, "camera: field of %g x %g radians; above 0 and below pi is possible", camera->angle_x,
                            camera->angle_y);
        out->half_x = tan(0.5 * camera->angle_x);
        out->half_y = tan(0.5 * camera->angle_y);
    } else if (camera->type == ENF_CAMERA_ORTHO) {
        if (!(camera->ortho_width > 0) || !(camera->ortho_height > 0) || !isfinite(camera->ortho_width) || !isfinite(camera->ortho_height))
            return enf_fail(ENF_ERROR_BAD_INPUT, "camera: orthographic size %g x %g", camera->ortho_width, camera->ortho_height);
        out->half_x = 0.5 * camera->ortho_width;
        out->half_y = 0.5 * camera->ortho_height;
    } else if (camera->type != ENF_CAMERA_PANO || panorama->kind > ENF_PANORAMA_CYLINDER) {
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera: unknown type %u, panorama %u", camera->type, panorama->kind);
    } else if (!isfinite(panorama->longitude[0]) || !isfinite(panorama->longitude[1]) || !isfinite(panorama->latitude[0]) ||
               !isfinite(panorama->latitude[1]) ||
               !isfinite(panorama->polynomial[0] + panorama->polynomial[1] + panorama->polynomial[2] + panorama->polynomial[3] +
                         panorama->polynomial[4]) ||
               !(panorama->field > 0) || !(panorama->lens > 0) || !(panorama->sensor_width > 0) || !(panorama->sensor_height > 0)) {
        return enf_fail(ENF_ERROR_BAD_INPUT, "camera: the panorama's numbers make no sense");
    }
    return ENF_OK;
}

/* u, v: 0 .. 1 from the lower left. In the camera's frame: x right, y up, z forward. */
static int fisheye_direction(const EnfPanorama *p, double u, double v, double d[3]) {
    const int circle = p->kind == ENF_PANORAMA_FISHEYE_EQUIDISTANT; /* else on the sensor, in millimetres */
    const double x = circle ? 2 * u - 1 : (u - 0.5) * p->sensor_width, y = circle ? 2 * v - 1 : (v - 0.5) * p->sensor_height;
    const double r = sqrt(x * x + y * y);
    double theta = 0;
    if (circle) {
        theta = 0.5 * r * p->field;
        if (r > 1)
            return 0;
    } else if (p->kind == ENF_PANORAMA_FISHEYE_POLYNOMIAL) {
        for (int k = 4; k >= 0; k--)
            theta = theta * r - p->polynomial[k];
        if (!(fabs(theta) <= 0.5 * p->field))
            return 0;
    } else {
        double rim = 2 * p->lens * sin(0.25 * p->field);
        if (r > rim)
            return 0;
        theta = 2 * asin(fmin(1, r / (2 * p->lens)));
    }
    if (r > 0)
        vec_set(d, sin(theta) * x / r, sin(theta) * y / r, cos(theta));
    else
        vec_set(d, 0, 0, 1);
    return 1;
}

static int panorama_direction(const EnfPanorama *p, double u, double v, double d[3]) {
    if (p->kind == ENF_PANORAMA_EQUIRECTANGULAR) {
        double longitude = p->longitude[0] + u * (p->longitude[1] - p->longitude[0]);
        double latitude = p->latitude[0] + v * (p->latitude[1] - p->latitude[0]);
        vec_set(d, sin(longitude) * cos(latitude), sin(latitude), cos(longitude) * cos(latitude));
        return 1;
    }
    if (p->kind == ENF_PANORAMA_MIRROR_BALL) {
        double x = 2 * u - 1, y = 2 * v - 1, r2 = x * x + y * y;
        if (r2 > 1)
            return 0;
        /* The view reflected in a ball that somebody before the camera looks at from afar: its middle shows what the camera looks at. */
        double z = sqrt(1 - r2);
        vec_set(d, 2 * z * x, 2 * z * y, 2 * z * z - 1);
        return 1;
    }
    if (p->kind == ENF_PANORAMA_CUBE_FACE) {
        vec_set(d, tan(0.5 * pi * (u - 0.5)), tan(0.5 * pi * (v - 0.5)), 1);
        return 1;
    }
    if (p->kind == ENF_PANORAMA_CYLINDER) {
        double longitude = p->longitude[0] + u * (p->longitude[1] - p->longitude[0]);
        vec_set(d, sin(longitude), p->latitude[0] + v * (p->latitude[1] - p->latitude[0]), cos(longitude));
        return 1;
    }
    return fisheye_direction(p, u, v, d);
}

int enf_camera_ray(const CameraRays *c, double x, double y, CameraRay *out) {
    double u = x / c->width, v = 1 - y / c->height, local[3] = {0, 0, 1};
    double sx = (2 * (u - 0.5) + 2 * c->camera.shift_x) * c->half_x, sy = (2 * (v - 0.5) + 2 * c->camera.shift_y) * c->half_y;
    vec_copy(out->origin, c->eye);
    if (c->camera.type == ENF_CAMERA_PANO) {
        if (!panorama_direction(&c->panorama, u, v, local))
            return 0;
    } else if (c->camera.type == ENF_CAMERA_ORTHO) {
        vec_mad(out->origin, out->origin, sx, c->right);
        vec_mad(out->origin, out->origin, sy, c->up);
    } else {
        vec_set(local, sx, sy, 1);
    }
    vec_normalize(local);
    vec_scale(out->direction, local[0], c->right);
    vec_mad(out->direction, out->direction, local[1], c->up);
    vec_mad(out->direction, out->direction, local[2], c->forward);
    out->depth = c->camera.type == ENF_CAMERA_PANO ? 1 : local[2];
    out->nearest = c->camera.clip_near / out->depth;
    out->farthest = c->camera.clip_far / out->depth;
    return 1;
}
