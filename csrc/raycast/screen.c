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

FrameFill enf_frame_fill(const ImageTask *task, uint32_t surface) {
    const Screen *s = task->screen;
    FrameFill fill;
    SurfaceFrame frame;
    double to[3];
    memset(&fill, 0, sizeof fill);
    if (surface == ENF_NONE)
        return fill;
    enf_surface_frame(task->r, surface, &frame);
    vec_sub(to, frame.point, s->eye);
    double side = vec_dot(frame.normal, to) > 0 ? -1 : 1;
    for (int k = 0; k < 3; k++)
        fill.normal[k] = (float)(side * frame.normal[k]);
    fill.inverse = enf_inverse_depth(s, frame.normal, frame.point);
    for (int k = 0; k < 2; k++) { /* point = eye + depth * (base + x across + y down) */
        const double *along = k ? frame.v : frame.u;
        fill.from[k] = -vec_dot(to, along);
        fill.base[k] = vec_dot(s->base, along);
        fill.across[k] = vec_dot(s->across, along);
        fill.down[k] = vec_dot(s->down, along);
    }
    return fill;
}

void enf_image_write_frame(const ImageTask *task, uint32_t x, uint32_t y, uint32_t count, const FrameFill *f) {
    const EnfRaycastImage *image = task->image;
    size_t at = (size_t)y * image->width + x;
    if (image->normal)
        task->kernel->fill_three(image->normal + 3 * at, count, f->normal);
    if (!image->uv)
        return;
    int nothing = f->normal[0] == 0 && f->normal[1] == 0 && f->normal[2] == 0;
    const float inverse[2] = {nothing ? 1 : (float)(f->inverse.a * x + f->inverse.b * y + f->inverse.c), (float)f->inverse.a};
    float line[6];
    for (int k = 0; k < 2; k++) {
        line[3 * k] = (float)f->from[k];
        line[3 * k + 1] = (float)(f->base[k] + x * f->across[k] + y * f->down[k]);
        line[3 * k + 2] = (float)f->across[k];
    }
    task->kernel->fill_places(image->uv + 2 * at, count, inverse, line);
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
