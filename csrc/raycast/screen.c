/* SPDX-License-Identifier: GPL-3.0-or-later
 * Sets up a camera's screen; writes what all ways to a picture have in common. */
#include "raycast/screen.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"
#include "raycast/furniture_merge.h"
#include "raycast/ray_kernel.h"

EnfStatus enf_screen_make(const EnfRaycaster *r, const EnfCamera *camera, uint32_t width, uint32_t height, Screen *s) {
    const double *m = camera->world_from_camera, pi = 3.14159265358979323846;
    int finite = isfinite(camera->shift_x) && isfinite(camera->shift_y);
    for (int i = 0; i < 12; i++)
        finite = finite && isfinite(m[i]);
    if (!finite || camera->type != ENF_CAMERA_PERSP || !(camera->angle_x > 0 && camera->angle_x < pi) ||
        !(camera->angle_y > 0 && camera->angle_y < pi))
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_raycast_image: not a finite perspective camera with angles between 0 and 180 degrees");
    double wide = 2 * tan(camera->angle_x / 2), high = 2 * tan(camera->angle_y / 2);
    for (int k = 0; k < 3; k++) {
        double axis[3] = {m[k], m[4 + k], m[8 + k]};
        if (!(vec_normalize(axis) > 0))
            return enf_fail(ENF_ERROR_BAD_INPUT, "enf_raycast_image: the camera's matrix has a zero axis");
        vec_copy(s->axes[k], axis);
    }
    const double eye[3] = {m[3], m[7], m[11]};
    vec_sub(s->eye, eye, r->scene->origin);
    s->left = wide * (camera->shift_x - 0.5);
    s->top = high * (camera->shift_y + 0.5);
    s->per_x = width / wide;
    s->per_y = height / high;
    s->near_guard = r->scene->tolerance;
    for (int k = 0; k < 3; k++) {
        s->across[k] = s->axes[0][k] / s->per_x;
        s->down[k] = -s->axes[1][k] / s->per_y;
        s->base[k] = s->axes[0][k] * s->left + s->axes[1][k] * s->top - s->axes[2][k] + 0.5 * s->across[k] + 0.5 * s->down[k];
    }
    return ENF_OK;
}

InverseDepth enf_inverse_depth(const Screen *s, const double normal[3], const double point[3]) {
    double to[3];
    vec_sub(to, point, s->eye);
    double d = vec_dot(normal, to); /* n . (depth * ray) = d */
    InverseDepth f = {vec_dot(normal, s->across) / d, vec_dot(normal, s->down) / d, vec_dot(normal, s->base) / d};
    return f;
}

void enf_image_write_frame(const ImageTask *task, uint32_t x, uint32_t y, uint32_t count, uint32_t surface) {
    const EnfRaycastImage *image = task->image;
    const Screen *s = task->screen;
    size_t at = (size_t)y * image->width + x;
    float *normal = image->normal ? image->normal + 3 * at : NULL, *uv = image->uv ? image->uv + 2 * at : NULL;
    if (surface == ENF_NONE) {
        if (normal)
            memset(normal, 0, 3 * sizeof *normal * count);
        if (uv)
            memset(uv, 0, 2 * sizeof *uv * count);
        return;
    }
    SurfaceFrame frame;
    double to[3], ray[3];
    enf_surface_frame(task->r, surface, &frame);
    vec_sub(to, frame.point, s->eye);
    if (normal) {
        double side = vec_dot(frame.normal, to) > 0 ? -1 : 1;
        float n[3] = {(float)(side * frame.normal[0]), (float)(side * frame.normal[1]), (float)(side * frame.normal[2])};
        for (uint32_t i = 0; i < count; i++) {
            normal[3 * i] = n[0];
            normal[3 * i + 1] = n[1];
            normal[3 * i + 2] = n[2];
        }
    }
    if (!uv)
        return;
    /* point = eye + depth * (base + x across + y down): along u that is linear but for the depth */
    InverseDepth f = enf_inverse_depth(s, frame.normal, frame.point);
    vec_mad(ray, s->base, x, s->across);
    vec_mad(ray, ray, y, s->down);
    float u0 = (float)-vec_dot(to, frame.u), u1 = (float)vec_dot(ray, frame.u), u2 = (float)vec_dot(s->across, frame.u);
    float v0 = (float)-vec_dot(to, frame.v), v1 = (float)vec_dot(ray, frame.v), v2 = (float)vec_dot(s->across, frame.v);
    float base = (float)(f.a * x + f.b * y + f.c), slope = (float)f.a;
    for (uint32_t i = 0; i < count; i++) {
        float step = (float)(int32_t)i, depth = 1.0f / (base + slope * step);
        uv[2 * i] = u0 + depth * (u1 + u2 * step);
        uv[2 * i + 1] = v0 + depth * (v1 + v2 * step);
    }
}

EnfRaycastImage enf_default_raycast_image(void) {
    EnfRaycastImage image;
    memset(&image, 0, sizeof image);
    image.struct_size = sizeof image;
    return image;
}

EnfStatus enf_raycast_image(const EnfRaycaster *r, const EnfCamera *camera, EnfRaycastImage *image) {
    if (!r || !camera || !image || image->struct_size != sizeof *image || camera->struct_size != sizeof *camera)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycast_image: NULL argument or bad struct_size");
    if (image->width < 1 || image->height < 1 || image->width > 16384 || image->height > 16384)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycast_image: %u x %u pixels; 1 to 16384 a side are possible", image->width,
                        image->height);
    if (image->method > ENF_IMAGE_PACKETS || image->simd > ENF_SIMD_AVX512)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_raycast_image: no method %u or no simd %u", image->method, image->simd);
    Screen screen;
    EnfStatus status = enf_screen_make(r, camera, image->width, image->height, &screen);
    if (status != ENF_OK)
        return status;
    const double *m = camera->world_from_camera, eye[3] = {m[3], m[7], m[11]};
    uint32_t cell = ENF_NONE, found = 0;
    status = enf_scene_locate(r->scene, eye, &cell, 1, &found);
    if (status != ENF_OK)
        return status;
    enf_raycaster_follow_states(r);
    image->spans = image->visits = image->patched = 0;
    ImageTask task = {r, &screen, image, enf_ray_kernel(image->simd), found ? cell : ENF_NONE};
    int furniture = r->furniture && !image->without_furniture;
    float *own_depth = NULL;
    if (furniture && !image->depth) { /* who is nearer must be known all the same */
        own_depth = enf_alloc_array((uint64_t)image->width * image->height, sizeof *own_depth);
        if (!own_depth)
            return enf_fail_memory();
        image->depth = own_depth;
    }
    status = image->method == ENF_IMAGE_SPANS ? enf_image_by_spans(&task) : enf_image_by_rays(&task);
    if (status == ENF_OK && furniture)
        enf_image_merge_furniture(&task);
    if (own_depth)
        image->depth = NULL;
    enf_free(own_depth);
    return status;
}
