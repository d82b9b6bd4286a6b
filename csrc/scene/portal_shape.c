/* SPDX-License-Identifier: GPL-3.0-or-later
 * Each portal's polygon: planar, convex, without repeated corners? Repeated corners are dropped (the same
 * polygon), what isn't convex becomes its planar hull (a larger opening), a little out of plane is kept and
 * erred outward (portal_deviation). */
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/problems.h"
#include "scene/validate.h"

/* Farther out of plane than this part of its radius, a polygon has no plane worth the name, and engines that
 * look along the sheet would err by whole walls: an error. */
#define NOT_A_PLANE 0.02
/* Below this part of the radius, being bent or dented is how files are written (six digits), not a defect to
 * tell of. */
#define WRITTEN_SO 1e-6

static uint32_t drop_repeated(EnfScene *scene, uint32_t p, double (*v)[3], uint32_t count, double tolerance) {
    uint32_t kept = 0, dropped = ENF_NONE;
    for (uint32_t i = 0; i < count; i++) {
        if (kept && vec_distance(v[kept - 1], v[i]) <= tolerance)
            dropped = i;
        else
            vec_copy(v[kept++], v[i]);
    }
    while (kept > 1 && vec_distance(v[0], v[kept - 1]) <= tolerance) {
        dropped = count - 1;
        kept--;
    }
    if (kept < count)
        enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_DUPLICATE_VERTEX, v[0],
                        "vertex %u repeats its neighbour; %u dropped", dropped, count - kept);
    return kept;
}

/* Gives the number of corners left; 0 after an error; ENF_NONE: no memory. */
static uint32_t shape_portal(EnfScene *scene, uint32_t p, double (*v)[3], uint32_t count, double rounding, double (*local)[3],
                             uint32_t *hull) {
    count = drop_repeated(scene, p, v, count, rounding);
    double n[3], centre[3], longest = 0.0, radius = 0.0, low = DBL_MAX, high = -DBL_MAX;
    vec_copy(centre, v[0]);
    for (uint32_t i = 0; i < count; i++) {
        vec_sub(local[i], v[i], centre);
        longest = fmax(longest, vec_length(local[i]));
    }
    double area = count >= 3 ? enf_polygon_normal(n, local, count) : 0.0;
    if (!(area > 2.0 * rounding * longest)) {
        enf_problem_add(scene, ENF_SEVERITY_ERROR, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_ZERO_AREA, v[0],
                        "its polygon has no area (%.3g m2)", area);
        return 0;
    }
    enf_polygon_centroid(centre, local, count);
    for (uint32_t i = 0; i < count; i++) {
        radius = fmax(radius, vec_distance(local[i], centre));
        low = fmin(low, vec_dot(n, local[i]));
        high = fmax(high, vec_dot(n, local[i]));
    }
    double deviation = 0.5 * (high - low);
    if (deviation > NOT_A_PLANE * radius) {
        enf_problem_add(scene, ENF_SEVERITY_ERROR, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_NOT_PLANAR, v[0],
                        "its polygon is %.3g m out of plane, more than %.0f %% of its size: split it into planar portals", deviation,
                        100.0 * NOT_A_PLANE);
        return 0;
    }
    if (deviation > WRITTEN_SO * radius + rounding)
        enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_NOT_PLANAR, v[0],
                        "its polygon is %.3g m out of plane; taken as that much larger", deviation);
    if (enf_polygon_is_convex(local, count, n, 1e-12 * radius + rounding))
        return count;
    uint32_t size = enf_planar_hull(local, count, n, 0.0, hull);
    if (size == 0)
        return ENF_NONE;
    int plainly = !enf_polygon_is_convex(local, count, n, WRITTEN_SO * radius + rounding);
    enf_problem_add(scene, plainly ? ENF_SEVERITY_WARNING : ENF_SEVERITY_INFO, ENF_ITEM_PORTAL, p, ENF_PROBLEM_PORTAL_NOT_CONVEX, v[0],
                    "its polygon isn't convex; its convex hull is taken");
    for (uint32_t i = 0; i < count; i++)
        vec_copy(local[i], v[i]);
    for (uint32_t i = 0; i < size; i++)
        vec_copy(v[i], local[hull[i]]);
    return size;
}

int enf_shape_portals(EnfScene *scene) {
    double(*local)[3] = NULL;
    uint32_t *hull = NULL, write = 0, read = 0;
    double largest = 0.0;
    for (int k = 0; k < 6; k++)
        largest = fmax(largest, fabs(scene->bounds[k]));
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        uint32_t count = scene->portal_vertex_first[p + 1] - read;
        double(*v)[3] = scene->portal_vertices + read;
        read += count;
        if (!ENF_RESERVE(local, count) || !ENF_RESERVE(hull, count)) {
            /* Leave the arrays consistent: nothing was moved yet beyond `write`. */
            memmove(scene->portal_vertices + write, v,
                    (size_t)(scene->portal_vertex_first[scene->portal_count] - (read - count)) * sizeof *v);
            for (uint32_t q = p; q < scene->portal_count; q++)
                scene->portal_vertex_first[q + 1] -= read - count - write;
            enf_free(local);
            enf_free(hull);
            return 0;
        }
        uint32_t kept = shape_portal(scene, p, v, count, ENF_TOLERANCE_COORDINATE * largest, local, hull);
        if (kept == ENF_NONE || kept == 0)
            kept = count; /* an error was listed; the polygon stays to be looked at */
        if (write != read - count)
            memmove(scene->portal_vertices + write, v, kept * sizeof *v);
        write += kept;
        scene->portal_vertex_first[p + 1] = write;
    }
    enf_free(local);
    enf_free(hull);
    return 1;
}
