/* SPDX-License-Identifier: GPL-3.0-or-later
 * Prepares a committed scene for the from-region engine. */
#include "from_region/region_model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "geometry/sort_keys.h"
#include "geometry/vec3.h"

/* [Model units] A clearance below this drowns in the rounding of coordinates: it is raised, and reported as raised. */
#define CLEARANCE_MIN 4e-9

/* [Extents] A line that comes this near to an edge touches it and passes nothing: a nanometre in a building of 100 m. What
 * separates lines that pass from lines that only touch must be more than rounding makes of aligned edges, hence also at least
 * TOUCH_ULPS units in the last place of the scene's largest coordinate (1e7 m from the origin: 1.5e-8 m). */
#define TOUCH      1e-11
#define TOUCH_ULPS 8

/* [Model units] A portal may be crossed this far before an earlier one, by rounding. */
#define ORDER_ROUNDING 1e-14

/* [Model units] A portal may stick out of its cell's other portal planes by this and the cell still counts as convex: files carry
 * six digits. A line could then enter the cell twice only within that distance of a portal's plane. */
#define CONVEX_TOLERANCE 1e-7

/* Centre and half size in single precision, the half size enlarged so that the box holds what it held. */
static void round_box(const double bounds[6], float out[6]) {
    for (int k = 0; k < 3; ++k) {
        float centre = (float)(0.5 * (bounds[k] + bounds[k + 3]));
        double half = fmax(bounds[k + 3] - (double)centre, (double)centre - bounds[k]);
        out[k] = centre;
        out[k + 3] = half > 0 ? nextafterf((float)half, FLT_MAX) : 0;
    }
}

void enf_region_model_clear(EnfRegionModel *m) {
    EnfRegionPolygons *all[3] = {&m->raw, &m->outer, &m->inner};
    for (int k = 0; k < 3; ++k)
        enf_free(all[k]->first), enf_free(all[k]->vertices);
    enf_free(m->inner_edge), enf_free(m->convex), enf_free(m->dead_end), enf_free(m->passes), enf_free(m->plane), enf_free(m->centre),
        enf_free(m->radius), enf_free(m->box);
    enf_free(m->to), enf_free(m->out_first), enf_free(m->out), enf_free(m->cell_box);
    enf_free(m->cell_of), enf_free(m->portal_of), enf_free(m->rim);
    enf_free(m->groups), enf_free(m->group_first), enf_free(m->out_to), enf_free(m->out_box);
    enf_free(m->way), enf_free(m->out_way);
}

void enf_region_model_destroy(EnfRegionModel *m) {
    if (!m)
        return;
    enf_region_model_clear(m);
    enf_free(m);
}

/* deviation NULL: the inner polygons, else the outer ones. */
static EnfStatus offset_portals(EnfRegionModel *m, const double *deviation) {
    EnfRegionPolygons *target = deviation ? &m->outer : &m->inner;
    uint32_t largest = 3;
    for (uint32_t p = 0; p < m->portal_count; ++p)
        if (enf_rm_count(&m->raw, p) > largest)
            largest = enf_rm_count(&m->raw, p);
    uint32_t room = 2 * largest + 2;
    EnfFlatPoint few[4 * 34];
    double few_corners[34][3]; /* enough for most portals */
    EnfFlatPoint *scratch = room <= 34 ? few : enf_alloc_array(4 * (uint64_t)room, sizeof *scratch);
    double(*polygon)[3] = room <= 34 ? few_corners : enf_alloc_array(room, sizeof *polygon);
    EnfStatus status = scratch && polygon ? ENF_OK : enf_fail_memory();
    uint64_t total = 0;
    for (uint32_t p = 0; p < m->portal_count && status == ENF_OK; ++p) {
        uint32_t first = m->raw.first[p], count = enf_rm_count(&m->raw, p);
        /* A portal out of its plane is let in as far as it strays: enlarged by the deviation, never shrunk by it. */
        double offset = deviation ? deviation[p] * m->scale - 0.5 * m->touch : -ENF_INNER_OFFSET * m->delta;
        const double(*corners)[3] = (const double(*)[3])(m->raw.vertices + first);
        const double *plane = m->plane[2 * p];
        uint32_t size = 0;
        if (m->passes[p])
            size = enf_portal_offset(corners, count, plane, plane[3], offset, polygon, scratch);
        if (m->passes[p] && deviation && !size) /* narrower than a touch: taken as it is */
            size = enf_portal_offset(corners, count, plane, plane[3], 0, polygon, scratch);
        target->first[p] = (uint32_t)total;
        if (!ENF_RESERVE(target->vertices, total + size + 1))
            status = enf_fail_memory();
        else
            memcpy(target->vertices + total, polygon, size * sizeof *polygon);
        total += size;
        if (deviation && !size)
            m->passes[p] = 0; /* fewer than three corners apart: commit reports such portals */
    }
    target->first[m->portal_count] = (uint32_t)total;
    if (scratch != few)
        enf_free(scratch);
    if (polygon != few_corners)
        enf_free(polygon);
    return status;
}

static EnfStatus plane_inner_edges(EnfRegionModel *m) {
    if (!ENF_RESERVE(m->inner_edge, (uint64_t)m->inner.first[m->portal_count] + 1))
        return enf_fail_memory();
    for (uint32_t p = 0; p < m->portal_count; ++p) {
        uint32_t first = m->inner.first[p], count = enf_rm_count(&m->inner, p);
        for (uint32_t i = 0; i < count; ++i) {
            const double *a = m->inner.vertices[first + i], *b = m->inner.vertices[first + (i + 1) % count];
            double e[3], *out = m->inner_edge[first + i];
            vec_sub(e, b, a);
            vec_cross(out, m->plane[2 * p], e);
            (void)vec_normalize(out);
            out[3] = vec_dot(out, a);
        }
    }
    return ENF_OK;
}

static void bound_portals(EnfRegionModel *m) {
    for (uint32_t p = 0; p < m->portal_count; ++p) {
        uint32_t first = m->outer.first[p], count = enf_rm_count(&m->outer, p);
        if (!count)
            continue;
        double bounds[6];
        box_empty(bounds);
        for (uint32_t i = 0; i < count; ++i)
            box_add_point(bounds, m->outer.vertices[first + i]);
        for (int k = 0; k < 3; ++k)
            m->centre[p][k] = 0.5 * (bounds[k] + bounds[k + 3]);
        m->radius[p] = 0;
        for (uint32_t i = 0; i < count; ++i)
            m->radius[p] = fmax(m->radius[p], vec_distance(m->outer.vertices[first + i], m->centre[p]) * (1 + 1e-12));
        round_box(bounds, m->box[p]);
    }
}

static EnfStatus bound_cells(EnfRegionModel *m) {
    double(*cells)[6] = enf_alloc_array((uint64_t)m->cell_count + 1, sizeof *cells);
    if (!cells)
        return enf_fail_memory();
    for (uint32_t c = 0; c < m->cell_count; ++c)
        box_empty(cells[c]);
    for (uint32_t p = 0; p < m->portal_count; ++p)
        for (uint32_t i = m->outer.first[p]; i < m->outer.first[p + 1]; ++i) {
            box_add_point(cells[m->to[2 * p]], m->outer.vertices[i]);
            box_add_point(cells[m->to[2 * p + 1]], m->outer.vertices[i]);
        }
    for (uint32_t c = 0; c < m->cell_count; ++c)
        if (!box_is_empty(cells[c]))
            round_box(cells[c], m->cell_box[c]);
    enf_free(cells);
    return ENF_OK;
}

EnfStatus enf_region_model_enlarge_portals(EnfRegionModel *m, const double *deviation) {
    EnfStatus status = offset_portals(m, deviation);
    if (status == ENF_OK)
        bound_portals(m);
    return status;
}

EnfStatus enf_region_model_shrink_portals(EnfRegionModel *m) {
    EnfStatus status = offset_portals(m, NULL);
    return status == ENF_OK ? plane_inner_edges(m) : status;
}

EnfStatus enf_region_model_shape_portals(EnfRegionModel *m, const double *deviation) {
    EnfStatus status = enf_region_model_enlarge_portals(m, deviation);
    return status == ENF_OK ? enf_region_model_shrink_portals(m) : status;
}

void enf_region_model_scale(EnfRegionModel *m, double extent, double largest, double clearance_metres) {
    m->kernel = enf_separator_kernel();
    int exponent;
    (void)frexp(extent, &exponent);
    m->scale = ldexp(1.0, -exponent), m->inverse_scale = ldexp(1.0, exponent);
    m->delta = (clearance_metres > 0 ? clearance_metres : 2.5e-7 * extent) * m->scale;
    if (m->delta < CLEARANCE_MIN)
        m->delta = CLEARANCE_MIN;
    m->touch = fmax(TOUCH * extent, TOUCH_ULPS * DBL_EPSILON * largest) * m->scale;
    m->opposite = fmax(ENF_HIDDEN_SINE_MIN, fmin(m->touch, ENF_CROSSING_SINE_MIN));
    m->order_slack = ORDER_ROUNDING;
}

static void link_cells(EnfRegionModel *m) {
    for (uint32_t d = 0; d < 2 * m->portal_count; ++d)
        if (m->passes[d >> 1])
            ++m->out_first[enf_rm_from(m, d) + 1];
    for (uint32_t c = 0; c < m->cell_count; ++c)
        m->out_first[c + 1] += m->out_first[c];
    for (uint32_t d = 0; d < 2 * m->portal_count; ++d)
        if (m->passes[d >> 1])
            m->out[m->out_first[enf_rm_from(m, d)]++] = d;
    for (uint32_t c = m->cell_count; c > 0; --c)
        m->out_first[c] = m->out_first[c - 1];
    m->out_first[0] = 0;
}

/* Normals on a grid this fine: of one place there they are less than ENF_HIDDEN_SINE_MIN apart. */
#define WAY_GRID 0x1p33

typedef struct Normal {
    int64_t n[3]; /* the first of them that isn't 0 is positive */
    uint32_t portal;
} Normal;

static int compare_normals(const void *a, const void *b) {
    const Normal *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p->n[k] != q->n[k])
            return p->n[k] < q->n[k] ? -1 : 1;
    return 0;
}

/* Numbers the directions portals face: what faces against each other gets numbers that differ in the last bit. */
static EnfStatus number_ways(EnfRegionModel *m) {
    Normal *normals = ENF_NEW(Normal, (uint64_t)m->portal_count + 1);
    m->way = ENF_NEW(uint32_t, 2 * (uint64_t)m->portal_count + 1);
    if (!normals || !m->way) {
        enf_free(normals);
        return enf_fail_memory();
    }
    for (uint32_t p = 0; p < m->portal_count; ++p) {
        const double *n = m->plane[2 * p];
        int64_t *on_grid = normals[p].n;
        for (int k = 0; k < 3; ++k)
            on_grid[k] = (int64_t)rint(n[k] * WAY_GRID);
        uint32_t turned = (on_grid[0] ? on_grid[0] : on_grid[1] ? on_grid[1] : on_grid[2]) < 0;
        for (int k = 0; k < 3; ++k)
            on_grid[k] = turned ? -on_grid[k] : on_grid[k];
        normals[p].portal = p;
        m->way[2 * p] = turned;
    }
    qsort(normals, m->portal_count, sizeof *normals, compare_normals);
    for (uint32_t i = 0, count = 0; i < m->portal_count; ++i) {
        count += i && compare_normals(&normals[i], &normals[i - 1]) != 0;
        uint32_t directed = 2 * normals[i].portal;
        m->way[directed] |= 2 * count;
        m->way[enf_rm_reverse(directed)] = m->way[directed] ^ 1;
    }
    enf_free(normals);
    return ENF_OK;
}

/* What the first tests of portals read: planes by the group, and boxes. */
static EnfStatus group_planes(EnfRegionModel *m) {
    uint64_t groups = 0;
    m->group_first = ENF_NEW(uint32_t, (uint64_t)m->cell_count + 1);
    m->out_to = ENF_NEW(uint32_t, 2 * (uint64_t)m->portal_count + 1);
    m->out_box = enf_alloc_array(2 * (uint64_t)m->portal_count + 1, sizeof *m->out_box);
    m->out_way = ENF_NEW(uint32_t, 2 * (uint64_t)m->portal_count + 1);
    if (!m->group_first || !m->out_to || !m->out_box || !m->out_way)
        return enf_fail_memory();
    EnfStatus status = number_ways(m);
    if (status != ENF_OK)
        return status;
    for (uint32_t c = 0; c < m->cell_count; ++c) {
        m->group_first[c] = (uint32_t)groups;
        groups += (m->out_first[c + 1] - m->out_first[c] + ENF_GROUP - 1) / ENF_GROUP;
    }
    if (!(m->groups = enf_alloc_array(groups + 1, sizeof *m->groups)))
        return enf_fail_memory();
    for (uint32_t c = 0; c < m->cell_count; ++c)
        for (uint32_t k = 0; k < m->out_first[c + 1] - m->out_first[c]; ++k) {
            EnfPlaneGroup *group = &m->groups[m->group_first[c] + k / ENF_GROUP];
            uint32_t i = m->out_first[c] + k;
            const double *plane = m->plane[m->out[i]];
            m->out_to[i] = m->to[m->out[i]], m->out_way[i] = m->way[m->out[i]];
            memcpy(m->out_box[i], m->box[m->out[i] >> 1], sizeof *m->out_box);
            group->x[k % ENF_GROUP] = (float)plane[0], group->y[k % ENF_GROUP] = (float)plane[1];
            group->z[k % ENF_GROUP] = (float)plane[2], group->d[k % ENF_GROUP] = (float)plane[3];
        }
    return ENF_OK;
}

/* A cell that lies behind the plane of each of its portals is convex for lines that use its portals. Clusters of portal files
 * need not be, nor "everything outside"; of those nothing is taken for granted. */
static void check_convexity(EnfRegionModel *m) {
    for (uint32_t c = 0; c < m->cell_count; ++c) {
        m->convex[c] = !m->rim || !m->rim[c];
        for (uint32_t i = m->out_first[c]; i < m->out_first[c + 1] && m->convex[c]; ++i)
            for (uint32_t k = m->out_first[c]; k < m->out_first[c + 1] && m->convex[c]; ++k) {
                const double *plane = m->plane[m->out[i]];
                uint32_t portal = m->out[k] >> 1;
                if (vec_dot(plane, m->centre[portal]) - plane[3] + m->radius[portal] <= CONVEX_TOLERANCE)
                    continue;
                for (uint32_t v = m->raw.first[portal]; v < m->raw.first[portal + 1]; ++v)
                    if (vec_dot(plane, m->raw.vertices[v]) - plane[3] > CONVEX_TOLERANCE)
                        m->convex[c] = 0;
            }
    }
}

/* Portals of a shut opening let nothing pass. When the opening has a cell of its own (it is as thick as its wall) the leaf stands
 * somewhere in there: what is before it is seen from its side, so both portals lead into the cell, and none through it. */
static void judge_openings(EnfRegionModel *m, const uint8_t *states) {
    const EnfScene *scene = m->scene;
    for (uint32_t c = 0; c < m->cell_count; ++c) {
        uint32_t opening = scene->cell_openings[enf_rm_scene_cell(m, c)];
        if (opening == ENF_NONE)
            continue;
        m->dead_end[c] = (states ? states[opening] : scene->openings[opening].state) == ENF_STATE_CLOSED;
    }
    for (uint32_t p = 0; p < m->portal_count; ++p) {
        uint32_t portal = enf_rm_scene_portal(m, 2 * p) >> 1, opening = scene->portal_openings[portal];
        const uint32_t *cells = scene->portal_cells[portal];
        int shut = opening != ENF_NONE && (states ? states[opening] : scene->openings[opening].state) == ENF_STATE_CLOSED;
        if (shut && (scene->cell_openings[cells[0]] == opening) != (scene->cell_openings[cells[1]] == opening))
            shut = 0;
        m->passes[p] = (uint8_t)(!shut && cells[0] != cells[1]);
    }
}

uint32_t enf_rm_own_portal(const EnfRegionModel *m, uint32_t directed) {
    if (!m->portal_of)
        return directed;
    uint32_t low = 0, high = m->portal_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (m->portal_of[middle] <= directed >> 1)
            low = middle;
        else
            high = middle;
    }
    return 2 * low | (directed & 1);
}

/* Numbers the cells and portals of a part; looks at nothing else of the scene. own: [cells of the scene], zeroed; gets what each cell
 * becomes, for those in the part. */
static EnfStatus choose_part(EnfRegionModel *m, const uint8_t *inside, uint32_t *own) {
    const EnfScene *scene = m->scene;
    m->cell_count = m->portal_count = 0;
    for (uint32_t c = 0; c < scene->cell_count; ++c) {
        if (!inside[c])
            continue;
        uint32_t first = scene->cell_portal_first[c], count = scene->cell_portal_first[c + 1] - first;
        if (!ENF_RESERVE(m->portal_of, (uint64_t)m->portal_count + count) || !ENF_RESERVE(m->cell_of, (uint64_t)m->cell_count + count + 1))
            return enf_fail_memory();
        m->cell_of[m->cell_count++] = c;
        for (uint32_t k = first; k < first + count; ++k) {
            const EnfCellPortal *side = &scene->cell_portals[k];
            if (!inside[side->to] && !own[side->to])
                own[side->to] = 1, m->cell_of[m->cell_count++] = side->to;
            if (!inside[side->to] || side->side == 0) /* each once */
                m->portal_of[m->portal_count++] = side->portal;
        }
    }
    m->rim = ENF_NEW(uint8_t, (uint64_t)m->cell_count + 1);
    if (!m->rim)
        return enf_fail_memory();
    qsort(m->portal_of, m->portal_count, sizeof *m->portal_of, compare_indices);
    qsort(m->cell_of, m->cell_count, sizeof *m->cell_of, compare_indices);
    for (uint32_t k = 0; k < m->cell_count; ++k)
        own[m->cell_of[k]] = k, m->rim[k] = !inside[m->cell_of[k]];
    return ENF_OK;
}

static EnfStatus reserve(EnfRegionModel *m, uint64_t corners) {
    uint64_t portals = m->portal_count, cells = m->cell_count;
    m->passes = ENF_NEW(uint8_t, portals + 1);
    m->plane = enf_alloc_array(2 * portals + 1, sizeof *m->plane);
    m->centre = enf_alloc_array(portals + 1, sizeof *m->centre);
    m->radius = ENF_NEW(double, portals + 1);
    m->box = enf_alloc_array(portals + 1, sizeof *m->box);
    m->to = ENF_NEW(uint32_t, 2 * portals + 1);
    m->out_first = ENF_NEW(uint32_t, cells + 2);
    m->out = ENF_NEW(uint32_t, 2 * portals + 1);
    m->cell_box = enf_alloc_array(cells + 1, sizeof *m->cell_box);
    m->raw.first = ENF_NEW(uint32_t, portals + 1);
    m->outer.first = ENF_NEW(uint32_t, portals + 1);
    m->inner.first = ENF_NEW(uint32_t, portals + 1);
    m->convex = ENF_NEW(uint8_t, cells + 1);
    m->dead_end = ENF_NEW(uint8_t, cells + 1);
    m->raw.vertices = enf_alloc_array(corners + 1, sizeof *m->raw.vertices);
    if (!m->passes || !m->plane || !m->centre || !m->radius || !m->box || !m->to || !m->out_first || !m->out || !m->cell_box ||
        !m->convex || !m->dead_end || !m->raw.first || !m->outer.first || !m->inner.first || !m->raw.vertices)
        return enf_fail_memory();
    return ENF_OK;
}

/* Corners, planes and cells of the portals as the scene has them. own: as in choose_part; NULL: the whole. */
static void take_portals(EnfRegionModel *m, const uint32_t *own, double *deviation) {
    const EnfScene *scene = m->scene;
    uint32_t corner = 0;
    for (uint32_t p = 0; p < m->portal_count; ++p) {
        uint32_t portal = enf_rm_scene_portal(m, 2 * p) >> 1;
        m->raw.first[p] = corner;
        for (uint32_t v = scene->portal_vertex_first[portal]; v < scene->portal_vertex_first[portal + 1]; ++v, ++corner)
            for (int k = 0; k < 3; ++k)
                m->raw.vertices[corner][k] = (scene->portal_vertices[v][k] - m->origin[k]) * m->scale;
        for (int side = 0; side < 2; ++side) {
            uint32_t cell = scene->portal_cells[portal][1 - side];
            m->to[2 * p + side] = own ? own[cell] : cell;
        }
        const EnfPlane *plane = &scene->portal_planes[portal];
        for (int k = 0; k < 4; ++k) {
            m->plane[2 * p][k] = k < 3 ? plane->n[k] : plane->d * m->scale;
            m->plane[2 * p + 1][k] = -m->plane[2 * p][k];
        }
        deviation[p] = scene->portal_deviation[portal];
    }
    m->raw.first[m->portal_count] = corner;
}

EnfStatus enf_region_model_create(const EnfScene *scene, const uint8_t *states, double clearance_metres, const uint8_t *inside,
                                  EnfRegionModel **out_model) {
    EnfRegionModel *m = ENF_NEW(EnfRegionModel, 1);
    uint32_t *own = inside ? enf_alloc_array((uint64_t)scene->cell_count + 1, sizeof *own) : NULL;
    if (!m || (inside && !own)) {
        enf_free(m), enf_free(own);
        return enf_fail_memory();
    }
    m->scene = scene, m->cell_count = scene->cell_count, m->portal_count = scene->portal_count;
    memcpy(m->origin, scene->origin, sizeof m->origin);
    double largest = 0;
    for (int k = 0; k < 6; ++k)
        largest = fmax(largest, fabs(scene->bounds[k]));
    enf_region_model_scale(m, scene->extent, largest, clearance_metres);
    EnfStatus status = inside ? choose_part(m, inside, own) : ENF_OK;
    uint64_t corners = 0;
    for (uint32_t p = 0; p < m->portal_count && status == ENF_OK; ++p) {
        uint32_t portal = enf_rm_scene_portal(m, 2 * p) >> 1;
        corners += scene->portal_vertex_first[portal + 1] - scene->portal_vertex_first[portal];
    }
    double *deviation = ENF_NEW(double, (uint64_t)m->portal_count + 1);
    if (status == ENF_OK)
        status = deviation ? reserve(m, corners) : enf_fail_memory();
    if (status == ENF_OK) {
        take_portals(m, own, deviation);
        judge_openings(m, states);
        status = enf_region_model_shape_portals(m, deviation);
    }
    if (status == ENF_OK)
        status = bound_cells(m);
    enf_free(own), enf_free(deviation);
    if (status != ENF_OK) {
        enf_region_model_destroy(m);
        return status;
    }
    link_cells(m);
    check_convexity(m);
    status = group_planes(m);
    if (status != ENF_OK) {
        enf_region_model_destroy(m);
        return status;
    }
    *out_model = m;
    return ENF_OK;
}
