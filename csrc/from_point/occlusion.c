/* SPDX-License-Identifier: GPL-3.0-or-later
 * Occluders in a traversal: furniture, columns and facades that stand before portals and objects.
 *
 * Based on: Johansson and Roupe 2009, section 4.3, with depth_buffer.c in place of hardware queries. Cells come nearest first, so
 * an occluder is drawn before what it hides is asked about; objects are asked when all is drawn. The screen's coordinates
 * serve as tangents, the depth along the look as distance.
 *
 * Safe direction: an occluder may always be drawn, it stands there whether or not it is seen; that what it hides stays hidden
 * when it is culled itself follows from whatever hides it lying nearer on the same lines. */
#include "from_point/occlusion.h"

#include "base/memory.h"
#include "base/status.h"
#include "from_point/depth_buffer.h"
#include "geometry/vec3.h"

#include <math.h>
#include <string.h>

/* Polygons a query draws at most, nearest cells first: some milliseconds. What remains hides nothing. */
enum { MOST_POLYGONS = 20000 };
/* ENF_OCCLUDERS_AUTO: so many objects, and so much of the screen (of 4: [-1, 1] x [-1, 1]) behind occluders' bounds. Drawing
 * costs as much as some hundred plain queries of a room; an object saved in rendering, more. */
static const uint32_t worthwhile_objects = 64;
static const double worthwhile_area = 0.4;

EnfStatus enf_occlusion_pack(EnfViewIndex *index) {
    const EnfScene *scene = index->scene;
    if (scene->occluder_count == 0)
        return ENF_OK;
    index->occluder_first = ENF_NEW(uint32_t, (uint64_t)scene->cell_count + 2);
    if (!index->occluder_first)
        return enf_fail_memory();
    /* Occluders in no cell stand for one cell more, the last. */
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t k = 0; k < scene->occluder_count; k++) {
            uint32_t object = scene->occluders[k].object, first = scene->placed_first[object];
            uint32_t count = scene->placed_first[object + 1] - first;
            for (uint32_t i = 0; i < (count ? count : 1); i++) {
                uint32_t cell = count ? scene->placed_cells[first + i] : scene->cell_count;
                if (pass == 0)
                    index->occluder_first[cell + 1]++;
                else
                    index->occluders[index->occluder_first[cell]++] = k;
            }
        }
        if (pass == 0) {
            for (uint32_t c = 0; c <= scene->cell_count; c++)
                index->occluder_first[c + 1] += index->occluder_first[c];
            index->occluders = ENF_NEW(uint32_t, index->occluder_first[scene->cell_count + 1]);
            if (!index->occluders)
                return enf_fail_memory();
        }
    }
    /* Filling moved each start to its end. */
    memmove(index->occluder_first + 1, index->occluder_first, sizeof *index->occluder_first * ((size_t)scene->cell_count + 1));
    index->occluder_first[0] = 0;
    return ENF_OK;
}

int enf_occlusion_possible(const EnfView *view, const EnfScreen *screen) {
    return view->index->occluder_first && view->screens.eye_count == 1 && !screen->ortho;
}

/* As the depth buffer wants it: looking along -z. */
static void to_camera(const EnfView *view, const EnfScreen *screen, const double p[3], double out[3]) {
    double q[3];
    vec_sub(q, p, view->screens.eyes[0]);
    out[0] = vec_dot(screen->rows[0], q);
    out[1] = vec_dot(screen->rows[1], q);
    out[2] = -vec_dot(screen->rows[2], q);
}

static void box_corners(const EnfView *view, const EnfScreen *screen, const double bounds[6], double out[8][3]) {
    for (int k = 0; k < 8; k++) {
        double p[3];
        for (int c = 0; c < 3; c++)
            p[c] = bounds[(k >> c & 1) ? 3 + c : c];
        to_camera(view, screen, p, out[k]);
    }
}

/* Whether the box lies beside the screen or behind the eye. */
static int out_of_view(const double corners[8][3]) {
    uint32_t codes = 31;
    for (int k = 0; k < 8; k++) {
        double u = corners[k][0], v = corners[k][1], w = -corners[k][2];
        codes &= (uint32_t)(u > w) | (uint32_t)(-u > w) << 1 | (uint32_t)(v > w) << 2 | (uint32_t)(-v > w) << 3 | (uint32_t)(w <= 0) << 4;
    }
    return codes != 0;
}

/* How much of the screen the bounds of the box's picture fill, 0 .. 1. */
static double share_of_screen(const double corners[8][3]) {
    double rect[4] = {1, 1, -1, -1};
    for (int k = 0; k < 8; k++) {
        double w = enf_greater(-corners[k][2], 1e-6);
        for (int c = 0; c < 2; c++) {
            rect[c] = enf_lesser(rect[c], corners[k][c] / w);
            rect[2 + c] = enf_greater(rect[2 + c], corners[k][c] / w);
        }
    }
    double wide = enf_lesser(rect[2], 1) - enf_greater(rect[0], -1), high = enf_lesser(rect[3], 1) - enf_greater(rect[1], -1);
    return wide > 0 && high > 0 ? 0.25 * wide * high : 0;
}

static void draw_occluder(EnfView *view, const EnfScreen *screen, const EnfOccluderData *occluder) {
    const EnfScene *scene = view->index->scene;
    double corners[8][3];
    box_corners(view, screen, scene->objects[occluder->object].bounds, corners);
    if (out_of_view((const double(*)[3])corners))
        return;
    const double share = share_of_screen((const double(*)[3])corners);
    for (uint32_t p = occluder->polygon_first; p < occluder->polygon_first + occluder->polygon_count; p++) {
        const double(*v)[3] = (const double(*)[3])(scene->occluder_corners + scene->occluder_corner_first[p]);
        uint32_t n = scene->occluder_corner_first[p + 1] - scene->occluder_corner_first[p];
        double polygon[64][3];
        if (view->stats.occluder_polygons >= MOST_POLYGONS)
            return;
        if (occluder->whole) { /* a box: its back says no more than its front */
            double a[3], b[3], normal[3], to[3];
            vec_sub(a, v[1], v[0]);
            vec_sub(b, v[2], v[0]);
            vec_cross(normal, a, b);
            vec_sub(to, v[0], view->screens.eyes[0]);
            if (vec_dot(normal, to) >= 0)
                continue;
        }
        for (uint32_t i = 0; i < n; i++)
            to_camera(view, screen, v[i], polygon[i]);
        enf_depth_buffer_occlude(view->depth, (const double(*)[3])polygon, n);
        view->stats.occluder_polygons++;
        view->stats.work += (uint64_t)(ENF_WORK_OCCLUDER * (0.05 + share));
    }
}

void enf_occlusion_draw(EnfView *view, const EnfScreen *screen, uint32_t cell) {
    const EnfViewIndex *index = view->index;
    for (uint32_t i = index->occluder_first[cell]; i < index->occluder_first[cell + 1]; i++) {
        uint32_t k = index->occluders[i];
        if (view->occluder_drawn[k] == view->occluder_stamp)
            continue;
        view->occluder_drawn[k] = view->occluder_stamp;
        draw_occluder(view, screen, &index->scene->occluders[k]);
    }
}

EnfStatus enf_occlusion_begin(EnfView *view, const EnfScreen *screen) {
    static const double whole[4] = {-1, 1, -1, 1};
    const EnfViewIndex *index = view->index;
    uint32_t width = view->def.occluder_pixels;
    if (!view->depth || view->depth_pixels != width) {
        enf_depth_buffer_destroy(view->depth);
        view->depth = NULL;
        EnfStatus status = enf_depth_buffer_create(width, width * 3 / 5 < 8 ? 8 : width * 3 / 5, &view->depth);
        if (status != ENF_OK)
            return status;
        view->depth_pixels = width;
    }
    if (!view->occluder_drawn && !(view->occluder_drawn = ENF_NEW(uint32_t, index->scene->occluder_count)))
        return enf_fail_memory();
    if (++view->occluder_stamp == 0) {
        memset(view->occluder_drawn, 0, sizeof *view->occluder_drawn * index->scene->occluder_count);
        view->occluder_stamp = 1;
    }
    enf_depth_buffer_begin(view->depth, whole, view->screens.clip_near, (int)view->def.use_simd);
    view->occluding = 1;
    enf_occlusion_draw(view, screen, index->scene->cell_count); /* those in no cell */
    return ENF_OK;
}

int enf_occlusion_hides_portal(EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, double distance, const EnfPoly *poly,
                               const double rect[4]) {
    const double tangents[4] = {rect[0], rect[2], rect[1], rect[3]};
    double nearest = 0;
    /* Bent, or nearer than a millimetre: its depth isn't certain. */
    if (side->slack > 0 || !(distance > 1e-3))
        return 0;
    for (uint32_t i = 0; i < poly->n; i++) {
        double inverse = 0; /* on a plane inverse depth is affine: largest at a corner */
        for (int c = 0; c < 3; c++)
            inverse += side->n[c] * (poly->x[i] * screen->right[c] + poly->y[i] * screen->up[c] + screen->forward[c]);
        nearest = fmax(nearest, inverse / distance);
    }
    view->stats.work += ENF_WORK_DEPTH;
    int hidden = !enf_depth_buffer_rect_visible(view->depth, tangents, nearest);
    view->stats.portals_occluded += (uint32_t)hidden;
    return hidden;
}

int enf_occlusion_hides_box(EnfView *view, const EnfScreen *screen, const double bounds[6], const double rect[4]) {
    const double tangents[4] = {rect[0], rect[2], rect[1], rect[3]};
    double corners[8][3];
    box_corners(view, screen, bounds, corners);
    view->stats.work += ENF_WORK_DEPTH;
    int hidden = !enf_depth_buffer_visible(view->depth, (const double(*)[3])corners, 8, tangents);
    view->stats.objects_occluded += (uint32_t)hidden;
    return hidden;
}

int enf_occlusion_pays(const EnfView *view, const EnfScreen *screen, uint32_t objects) {
    const EnfViewIndex *index = view->index;
    double area = 0;
    if (objects < worthwhile_objects)
        return 0;
    for (uint32_t i = 0; i < view->visited_count && area < worthwhile_area; i++)
        for (uint32_t k = index->occluder_first[view->visited[i]]; k < index->occluder_first[view->visited[i] + 1]; k++) {
            double corners[8][3];
            const EnfOccluderData *occluder = &index->scene->occluders[index->occluders[k]];
            box_corners(view, screen, index->scene->objects[occluder->object].bounds, corners);
            if (!out_of_view((const double(*)[3])corners))
                area += 4 * share_of_screen((const double(*)[3])corners);
        }
    return area >= worthwhile_area;
}
