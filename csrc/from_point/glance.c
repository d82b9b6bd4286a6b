/* SPDX-License-Identifier: GPL-3.0-or-later
 * Windows seen from outdoors. Both rectangles of a recess have sides along two common directions, so what an eye sees through
 * both is a rectangle again, in slopes against the wall's normal: no polygon is clipped, and a room whose other portals lie
 * beside it needs no aperture at all.
 * Based on: Johansson & Roupe 2009, section 4.3 (window -> portal); Luebke & Georges 1995 (rectangles).
 *
 * Safe direction: rectangles bound the portals, slopes are widened by their rounding. */
#include "from_point/glance.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

#include <math.h>
#include <string.h>

/* A portal that fills less of its rectangle goes the exact way. */
#define FILLS 0.999
/* Behind a window with more portals there is no room. */
#define MOST_DOORS 32

static const double (*corners_of(const EnfViewIndex *index, const EnfPortalSide *side))[3] {
    return (const double(*)[3])(index->vertices + side->vertex_first);
}

/* Twice the area of a polygon in the plane of u and v. */
static double area_in(const double (*p)[3], uint32_t count, const double u[3], const double v[3]) {
    double sum = 0;
    for (uint32_t i = 1; i + 1 < count; i++) {
        double a[3], b[3];
        vec_sub(a, p[i], p[0]);
        vec_sub(b, p[i + 1], p[0]);
        sum += vec_dot(a, u) * vec_dot(b, v) - vec_dot(a, v) * vec_dot(b, u);
    }
    return fabs(sum);
}

/* Bounds of the side's corners in the window's frame; 0 when it isn't such a rectangle at one depth. */
static int frame_bounds(const EnfViewIndex *index, const EnfPortalSide *side, const EnfGlance *g, double out[6]) {
    const double(*p)[3] = corners_of(index, side);
    box_empty(out);
    for (uint32_t i = 0; i < side->vertex_count; i++) {
        double local[3];
        vec_sub(local, p[i], g->corner);
        double q[3] = {vec_dot(local, g->u), vec_dot(local, g->v), vec_dot(local, g->n)};
        box_add_point(out, q);
    }
    double area = (out[3] - out[0]) * (out[4] - out[1]);
    return out[5] - out[2] <= 1e-12 * index->scene->extent && 0.5 * area_in(p, side->vertex_count, g->u, g->v) >= FILLS * area && area > 0;
}

static int make_glance(const EnfViewIndex *index, const EnfPortalSide *side, EnfGlance *g) {
    const EnfScene *scene = index->scene;
    const EnfViewCell *behind = &index->cells[side->to];
    const double(*p)[3] = corners_of(index, side);
    double longest = 0, edge[3], box[6];
    if (side->slack != 0)
        return 0;
    for (uint32_t i = 0; i < side->vertex_count; i++) {
        vec_sub(edge, p[(i + 1) % side->vertex_count], p[i]);
        if (vec_length(edge) > longest) {
            longest = vec_length(edge);
            vec_copy(g->u, edge);
        }
    }
    if (!(vec_normalize(g->u) > 0))
        return 0;
    vec_copy(g->n, side->n);
    vec_cross(g->v, g->n, g->u);
    vec_copy(g->corner, p[0]);
    if (!frame_bounds(index, side, g, box))
        return 0;
    for (int k = 0; k < 3; k++)
        g->corner[k] += box[0] * g->u[k] + box[1] * g->v[k];
    g->outer[0] = box[3] - box[0];
    g->outer[1] = box[4] - box[1];
    g->recess = ENF_NONE;
    g->inner_side = (uint32_t)(side - index->sides);
    g->room = side->to;
    g->depth = 0;
    if (behind->flags & ENF_VIEW_CELL_PASSAGE) {
        const EnfPortalSide *inner = &index->sides[behind->side_first];
        inner += inner->portal == side->portal;
        if (inner->slack != 0 || inner->opening != side->opening || inner->to == side->to || !(vec_dot(inner->n, g->n) > 1 - 1e-12) ||
            !frame_bounds(index, inner, g, box) || !(box[2] > 0))
            return 0;
        g->recess = side->to;
        g->inner_side = (uint32_t)(inner - index->sides);
        g->room = inner->to;
        g->depth = box[2];
        memcpy(g->inner, (const double[4]){box[0], box[1], box[3], box[4]}, sizeof g->inner);
    } else
        memcpy(g->inner, (const double[4]){0, 0, g->outer[0], g->outer[1]}, sizeof g->inner);
    g->views = 7;
    for (uint32_t k = 0; k < 3; k++)
        if (fabs(g->n[k]) > 1 - 1e-14 && fmax(fabs(g->u[(k + 1) % 3]), fabs(g->u[(k + 2) % 3])) > 1 - 1e-14)
            g->views = 1u << k;
    /* A room that is outdoors itself, or an opening's cell of some other kind, isn't what this is for. */
    return !enf_is_exterior(scene, g->room) && scene->cell_openings[g->room] == ENF_NONE;
}

/* The room's portals but the one looked through. Far from single precision's range: 0. */
static int make_doors(const EnfViewIndex *index, const EnfGlance *g, EnfGlanceDoor *doors, uint32_t *count) {
    const EnfViewCell *room = &index->cells[g->room];
    *count = 0;
    for (uint32_t s = 0; s < room->side_count; s++) {
        const EnfPortalSide *side = &index->sides[room->side_first + s];
        const double(*p)[3] = corners_of(index, side);
        double box[6], n[3] = {vec_dot(side->n, g->u), vec_dot(side->n, g->v), vec_dot(side->n, g->n)}, d = -DBL_MAX, size = 0;
        if (side->portal == index->sides[g->inner_side].portal)
            continue;
        box_empty(box);
        for (uint32_t i = 0; i < side->vertex_count; i++) {
            double local[3];
            vec_sub(local, p[i], g->corner);
            d = fmax(d, vec_dot(side->n, local));
            double q[3] = {vec_dot(local, g->u), vec_dot(local, g->v), vec_dot(local, g->n)};
            box_add_point(box, q);
        }
        /* Portals bent by so much stay within this; 1e-6: roundings to single precision here and below. */
        for (int k = 0; k < 6; k++)
            size = fmax(size, fabs(box[k]));
        box_grow(box, 2 * side->slack + 1e-6 * size);
        EnfGlanceDoor *door = &doors[(*count)++];
        for (int k = 0; k < 6; k++)
            door->box[k] = (float)box[k];
        for (int k = 0; k < 3; k++)
            door->n[k] = (float)-n[k];
        door->d = (float)(d + side->slack + 1e-6 * size);
        door->opening = side->opening;
        if (!(size < 1e30))
            return 0;
    }
    return 1;
}

EnfStatus enf_build_glances(EnfViewIndex *index) {
    uint32_t count = 0;
    uint64_t doors = 0, door_room = 0;
    for (uint32_t c = 0; c < index->scene->cell_count; c++)
        if (index->cells[c].flags & ENF_VIEW_CELL_OUTDOORS)
            count += index->cells[c].side_count;
    for (uint32_t s = 0; s < index->scene->cell_portal_first[index->scene->cell_count]; s++)
        index->sides[s].glance = ENF_NONE;
    if (!(index->glances = ENF_NEW(EnfGlance, count)))
        return enf_fail_memory();
    count = 0;
    for (uint32_t c = 0; c < index->scene->cell_count; c++)
        for (uint32_t i = 0; i < index->cells[c].side_count && index->cells[c].flags & ENF_VIEW_CELL_OUTDOORS; i++) {
            EnfPortalSide *side = &index->sides[index->cells[c].side_first + i];
            EnfGlance *g = &index->glances[count];
            if (!make_glance(index, side, g) || index->cells[g->room].side_count > MOST_DOORS)
                continue;
            if (doors + MOST_DOORS > door_room && !ENF_RESERVE(index->glance_doors, door_room = 2 * doors + MOST_DOORS))
                return enf_fail_memory();
            g->door_first = (uint32_t)doors;
            if (!make_doors(index, g, index->glance_doors + doors, &g->door_count))
                continue;
            doors += g->door_count;
            side->glance = count++;
        }
    return ENF_OK;
}

/* Slopes of the rectangle at distance `away`, from the eye's foot in the wall. */
static void slopes_of(const double lo[2], const double hi[2], double away, double rounding, double out[4]) {
    for (int k = 0; k < 2; k++) {
        out[k] = lo[k] / away;
        out[2 + k] = hi[k] / away;
        /* Roundings of the division and of the sums in the frame. */
        out[k] -= 1e-12 * (1 + fabs(out[k])) + rounding;
        out[2 + k] += 1e-12 * (1 + fabs(out[2 + k])) + rounding;
    }
}

/* Whether some other portal of the room may be seen between these slopes by an eye at (-x, -y, -away). */
static int sees_portals(const EnfViewIndex *index, const EnfGlance *g, double x, double y, double away, const double slopes[4]) {
    const EnfGlanceDoor *doors = index->glance_doors + g->door_first;
    /* Metres: roundings of the sums below, four of 6e-8 each, of what is added to coordinates in the room. */
    const float slack = (float)(1e-6 * (fabs(x) + fabs(y) + away));
    const float a0 = (float)slopes[0], b0 = (float)slopes[1], a1 = (float)slopes[2], b1 = (float)slopes[3];
    const float ex = (float)x, ey = (float)y, ez = (float)away;
    for (uint32_t i = 0; i < g->door_count; i++) {
        const EnfGlanceDoor *door = &doors[i];
        float z0 = door->box[2] + ez, z1 = door->box[5] + ez, x0 = door->box[0] + ex, x1 = door->box[3] + ex;
        float y0 = door->box[1] + ey, y1 = door->box[4] + ey;
        float facing = door->n[0] * -ex + door->n[1] * -ey + door->n[2] * -ez + door->d + slack;
        /* Some of it before the eye's plane: no telling. */
        int beside = (x1 + slack < a0 * (a0 > 0 ? z0 : z1)) | (y1 + slack < b0 * (b0 > 0 ? z0 : z1)) |
                     (x0 - slack > a1 * (a1 > 0 ? z1 : z0)) | (y0 - slack > b1 * (b1 > 0 ? z1 : z0));
        if (facing > 0 && !(beside & (z0 > 0)) &&
            (door->opening == ENF_NONE || index->scene->openings[door->opening].state != ENF_STATE_CLOSED))
            return 1;
    }
    return 0;
}

int enf_glance(const EnfView *view, const EnfGlance *g, EnfGlimpse *out) {
    double q[3];
    vec_sub(q, g->corner, view->screens.eyes[0]);
    double x = vec_dot(g->u, q), y = vec_dot(g->v, q), away = vec_dot(g->n, q);
    const double extent = view->index->scene->extent;
    if (!(away > 1e-4 * extent) || !(away > g->depth))
        return 0;
    /* Coordinates of the frame are sums of three products, each below an extent or so. */
    double rounding = 1e-15 * extent / away;
    slopes_of((const double[2]){x, y}, (const double[2]){x + g->outer[0], y + g->outer[1]}, away, rounding, out->outer);
    memcpy(out->inner, out->outer, sizeof out->inner);
    if (g->recess != ENF_NONE) {
        double inner[4];
        slopes_of((const double[2]){x + g->inner[0], y + g->inner[1]}, (const double[2]){x + g->inner[2], y + g->inner[3]}, away + g->depth,
                  rounding, inner);
        for (int k = 0; k < 2; k++) {
            out->inner[k] = fmax(out->inner[k], inner[k]);
            out->inner[2 + k] = fmin(out->inner[2 + k], inner[2 + k]);
        }
    }
    out->sees_room = out->inner[0] < out->inner[2] && out->inner[1] < out->inner[3];
    out->sees_portals = out->sees_room && sees_portals(view->index, g, x, y, away, out->inner);
    return 1;
}

void enf_glimpse_planes(const EnfView *view, const EnfScreen *screen, const EnfGlance *g, const double slopes[4], EnfAperturePlanes *out) {
    out->count = out->direction_count = 4;
    out->aperture = ENF_NONE;
    for (int k = 0; k < 3; k++) {
        out->n[0][k] = g->u[k] - slopes[0] * g->n[k];
        out->n[1][k] = slopes[2] * g->n[k] - g->u[k];
        out->n[2][k] = g->v[k] - slopes[1] * g->n[k];
        out->n[3][k] = slopes[3] * g->n[k] - g->v[k];
        for (int i = 0; i < 4; i++)
            out->direction[i][k] = g->n[k] + slopes[i == 0 || i == 3 ? 0 : 2] * g->u[k] + slopes[i < 2 ? 1 : 3] * g->v[k];
    }
    for (int i = 0; i < 4; i++)
        out->d[i] = 0;
    out->near_plane = ENF_NONE;
    out->views = g->views;
    if (isfinite(view->screens.far_depth)) /* the near plane: as if it weren't there, who sees a window from before it is far off */
        enf_add_depth_planes(view, screen, out);
}

void enf_glimpse_polygon(const EnfScreen *screen, const EnfGlance *g, const double slopes[4], EnfPoly *out) {
    out->n = 4;
    for (int i = 0; i < 4; i++) {
        double a = slopes[i == 0 || i == 3 ? 0 : 2], b = slopes[i < 2 ? 1 : 3], h[3];
        for (int r = 0; r < 3; r++)
            h[r] = vec_dot(screen->rows[r], g->n) + a * vec_dot(screen->rows[r], g->u) + b * vec_dot(screen->rows[r], g->v);
        out->x[i] = h[0] / h[2];
        out->y[i] = h[1] / h[2];
    }
    if (enf_poly_area(out) < 0)
        for (int i = 0; i < 2; i++) {
            double x = out->x[i], y = out->y[i];
            out->x[i] = out->x[3 - i];
            out->y[i] = out->y[3 - i];
            out->x[3 - i] = x;
            out->y[3 - i] = y;
        }
}
