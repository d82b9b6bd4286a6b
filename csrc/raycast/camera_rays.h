/* SPDX-License-Identifier: GPL-3.0-or-later
 * Places on a picture as rays of its camera. Internal to the core. */
#ifndef ENF_RAYCAST_CAMERA_RAYS_H
#define ENF_RAYCAST_CAMERA_RAYS_H

#include "enfilade/preview.h"

typedef struct CameraRays {
    EnfCamera camera;
    EnfPanorama panorama;
    double right[3], up[3], forward[3], eye[3]; /* unit axes; the eye about `origin` */
    double half_x, half_y;                      /* tangents, or metres of an orthographic view */
    uint32_t width, height;
} CameraRays;

EnfStatus enf_camera_rays(const EnfCamera *camera, const EnfPanorama *panorama, const double origin[3], uint32_t width, uint32_t height,
                          CameraRays *out_rays);
/* The ray through (x, y) in pixels from the upper left corner: origin, unit direction, metres along it where the camera's near plane
 * and far plane lie, depth a metre along it. 0: the place shows nothing (outside a fisheye's circle). */
typedef struct CameraRay {
    double origin[3], direction[3];
    double nearest, farthest;
    double depth; /* along the view axis, for each metre along the ray; 1 for panoramas */
} CameraRay;
int enf_camera_ray(const CameraRays *rays, double x, double y, CameraRay *out_ray);

#endif
