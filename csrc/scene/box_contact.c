/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whether a box touches a convex cell: separating axes.
 * Based on: Gottschalk, Lin, Manocha, OBBTree, 1996, section 5: two convex polyhedra are apart iff a face
 * normal of either or the cross product of an edge of each separates them. Every "apart" needs more than the
 * tolerance: rounding places an object in a cell too many, never in one too few. */
#include "scene/box_contact.h"
#include "geometry/vec3.h"

/* Nearest (sign 1) or farthest (sign -1) the box comes along a plane's normal, from the plane. */
static double along_normal(const EnfScene *scene, const EnfPlane *plane, const double box[6], double sign) {
    double d = -plane->d;
    for (int k = 0; k < 3; k++)
        d += plane->n[k] * ((sign * plane->n[k] > 0.0 ? box[k] : box[3 + k]) - scene->origin[k]);
    return d;
}

/* Edge by edge: is the box beyond the axis (edge x box edge)? Each edge stands in two faces; the ascending
 * way is taken. */
static int apart_by_edges(const EnfScene *scene, uint32_t c, const double box[6]) {
    double(*v)[3] = scene->cell_vertices + scene->cell_vertex_first[c];
    uint32_t count = scene->cell_vertex_first[c + 1] - scene->cell_vertex_first[c];
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
        uint32_t first = scene->face_index_first[f], size = scene->face_index_first[f + 1] - first;
        for (uint32_t i = 0; i < size; i++) {
            uint32_t a = scene->face_indices[first + i], b = scene->face_indices[first + (i + 1) % size];
            double edge[3];
            if (a >= b)
                continue;
            vec_sub(edge, v[b], v[a]);
            double length = vec_length(edge);
            for (int k = 0; k < 3; k++) {
                double unit[3] = {k == 0, k == 1, k == 2}, axis[3];
                vec_cross(axis, edge, unit);
                /* Nearly parallel to the box's edge: the face normals have said it. */
                if (vec_normalize(axis) <= 1e-6 * length)
                    continue;
                double cell_low = DBL_MAX, cell_high = -DBL_MAX, box_low = 0.0, box_high = 0.0, local[3];
                for (uint32_t j = 0; j < count; j++) {
                    vec_sub(local, v[j], v[a]);
                    double d = vec_dot(axis, local);
                    cell_low = fmin(cell_low, d);
                    cell_high = fmax(cell_high, d);
                }
                for (int m = 0; m < 3; m++) {
                    double low = axis[m] * (box[m] - v[a][m]), high = axis[m] * (box[3 + m] - v[a][m]);
                    box_low += fmin(low, high);
                    box_high += fmax(low, high);
                }
                if (box_low > cell_high + scene->tolerance || box_high < cell_low - scene->tolerance)
                    return 1;
            }
        }
    }
    return 0;
}

int enf_cell_touches_box(const EnfScene *scene, uint32_t c, const double box[6]) {
    int slanted = 0;
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
        const EnfPlane *plane = &scene->face_planes[f];
        if (along_normal(scene, plane, box, 1.0) > scene->tolerance)
            return 0;
        slanted |= fabs(plane->n[0]) < 1.0 && fabs(plane->n[1]) < 1.0 && fabs(plane->n[2]) < 1.0;
    }
    /* The box's own faces against the cell's bounds (its portals' corners included: larger, safe). */
    double grown[6];
    memcpy(grown, scene->cell_bounds[c], sizeof grown);
    box_grow(grown, scene->tolerance);
    if (!box_touches_box(grown, box))
        return 0;
    /* Upright boxes have no other axes; most objects lie wholly inside and need none. */
    return !slanted || enf_cell_holds_box(scene, c, box) || !apart_by_edges(scene, c, box);
}

int enf_cell_holds_box(const EnfScene *scene, uint32_t c, const double box[6]) {
    if (scene->cell_face_first[c + 1] == scene->cell_face_first[c])
        return 0;
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++)
        if (along_normal(scene, &scene->face_planes[f], box, -1.0) > scene->tolerance)
            return 0;
    return 1;
}

int enf_portals_allow_box(const EnfScene *scene, uint32_t c, const double box[6]) {
    for (uint32_t i = scene->cell_portal_first[c]; i < scene->cell_portal_first[c + 1]; i++) {
        const EnfCellPortal *side = &scene->cell_portals[i];
        const EnfPlane *plane = &scene->portal_planes[side->portal];
        double slack = scene->tolerance + scene->portal_deviation[side->portal];
        /* The cell lies behind the portal's plane (side 0) or in front of it (side 1). */
        if (side->side ? along_normal(scene, plane, box, -1.0) < -slack : along_normal(scene, plane, box, 1.0) > slack)
            return 0;
    }
    return 1;
}
