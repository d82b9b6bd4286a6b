/* SPDX-License-Identifier: GPL-3.0-or-later
 * A perspective camera that stands level. */
#include "level_camera.h"

#include <math.h>

EnfCamera level_camera(const double eye[3], double yaw, double pitch) {
    EnfCamera camera = enf_default_camera();
    double right[3] = {sin(yaw), -cos(yaw), 0}, look[3] = {cos(yaw) * cos(pitch), sin(yaw) * cos(pitch), sin(pitch)};
    double up[3] = {right[1] * look[2] - right[2] * look[1], right[2] * look[0] - right[0] * look[2],
                    right[0] * look[1] - right[1] * look[0]};
    for (int r = 0; r < 3; r++) {
        camera.world_from_camera[4 * r] = right[r];
        camera.world_from_camera[4 * r + 1] = up[r];
        camera.world_from_camera[4 * r + 2] = -look[r];
        camera.world_from_camera[4 * r + 3] = eye[r];
    }
    camera.angle_x = 1.5707963267948966;
    camera.angle_y = 59 * 3.14159265358979323846 / 180;
    camera.clip_near = 0;
    camera.clip_far = INFINITY;
    return camera;
}
