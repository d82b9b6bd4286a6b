/* SPDX-License-Identifier: GPL-3.0-or-later
 * Reading a room's shape for decomposition: weld corners, test that it is closed, gather planes, cut faces
 * into convex pieces. */
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/sort_keys.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/convex_decomposition.h"

#include <stdlib.h>

void enf_shape_free(EnfShape *s) {
    enf_free(s->pool.points);
    enf_free(s->given_world);
    enf_free(s->planes);
    enf_free(s->fragments);
    enf_free(s->fragment_points);
    enf_free(s->ring_corners);
    enf_free(s->triangles);
    memset(s, 0, sizeof *s);
}

/* Takes the corners over, about the middle of their bounds. */
static int take_corners(EnfShape *s, double (*vertices)[3], uint32_t count, double coarse) {
    s->given_world = enf_alloc_array(count, sizeof *s->given_world);
    if (!s->given_world || !ENF_RESERVE(s->pool.points, count))
        return 0;
    box_empty(s->box);
    double largest = 0.0;
    int single = 1;
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++)
            single &= (double)(float)vertices[i][k] == vertices[i][k];
        vec_copy(s->given_world[i], vertices[i]);
        box_add_point(s->box, vertices[i]);
    }
    for (int k = 0; k < 3; k++) {
        s->centre[k] = 0.5 * s->box[k] + 0.5 * s->box[3 + k];
        largest = fmax(largest, fmax(fabs(s->box[k]), fabs(s->box[3 + k])));
        s->box[k] -= s->centre[k];
        s->box[3 + k] -= s->centre[k];
    }
    s->size = box_diagonal(s->box);
    s->eps = ENF_TOLERANCE_ROOM * s->size + ENF_TOLERANCE_COORDINATE * largest;
    if (single) /* written in single precision: 2^-24 of the coordinate, a few corners' worth */
        s->eps += 4.0 * 5.96e-8 * largest;
    s->fine = s->eps;
    s->eps *= coarse;
    s->fragment_eps = s->eps;
    for (uint32_t i = 0; i < count; i++)
        vec_sub(s->pool.points[i], vertices[i], s->centre);
    s->pool.count = s->given_count = count;
    for (int f = 0; f < 6; f++)
        s->box_codes[f] = ENF_NONE;
    return 1;
}

/* weld[i]: the smallest index of a corner within eps. */
static int weld_corners(const EnfShape *s, uint32_t *weld) {
    uint32_t n = s->given_count;
    Ordered *order = ENF_NEW(Ordered, n);
    if (!order)
        return 0;
    for (uint32_t i = 0; i < n; i++)
        order[i] = (Ordered){s->pool.points[i][0], i};
    qsort(order, n, sizeof *order, compare_ordered);
    for (uint32_t i = 0; i < n; i++)
        weld[i] = i;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = i + 1; j < n && order[j].x - order[i].x <= s->eps; j++) {
            uint32_t a = order[i].index, b = order[j].index;
            if (vec_distance(s->pool.points[a], s->pool.points[b]) <= s->eps) {
                uint32_t low = weld[a] < weld[b] ? weld[a] : weld[b];
                weld[a] = weld[b] = low;
            }
        }
    for (uint32_t i = 0; i < n; i++)
        while (weld[i] != weld[weld[i]])
            weld[i] = weld[weld[i]];
    enf_free(order);
    return 1;
}

typedef struct Edge {
    uint32_t low, high;
    int direction;
} Edge;

static int compare_edges(const void *left, const void *right) {
    const Edge *a = left, *b = right;
    if (a->low != b->low)
        return a->low < b->low ? -1 : 1;
    return a->high < b->high ? -1 : a->high > b->high;
}

/* Cancels edges that run both ways; keeps the rest at the front, gives their number. */
static uint32_t cancel_edges(Edge *edges, uint32_t count) {
    uint32_t kept = 0;
    if (count)
        qsort(edges, count, sizeof *edges, compare_edges);
    for (uint32_t i = 0; i < count;) {
        uint32_t j = i;
        int sum = 0;
        for (; j < count && edges[j].low == edges[i].low && edges[j].high == edges[i].high; j++)
            sum += edges[j].direction;
        Edge edge = edges[i];
        edge.direction = sum > 0 ? 1 : -1;
        for (int k = 0; k < abs(sum); k++)
            edges[kept++] = edge;
        i = j;
    }
    return kept;
}

static int push_edge(Edge **edges, uint32_t *count, uint32_t a, uint32_t b, int direction) {
    if (a == b)
        return 1;
    if (!ENF_RESERVE(*edges, (uint64_t)*count + 1))
        return 0;
    (*edges)[(*count)++] = a < b ? (Edge){a, b, direction} : (Edge){b, a, -direction};
    return 1;
}

/* One face may hold a corner in the middle of its neighbour's edge: edges are split at the corners of other
 * open edges that lie on them, then matched again. Quadratic, in the open edges only. */
static int split_open_edges(const EnfShape *s, Edge **edges, uint32_t *count) {
    enum { MOST = 4000 };
    Edge *parts = NULL;
    Ordered *on = NULL;
    uint32_t part_count = 0;
    int ok = 1;
    if (*count > MOST)
        return 1;
    for (uint32_t e = 0; e < *count && ok; e++) {
        const double *a = s->pool.points[(*edges)[e].low], *b = s->pool.points[(*edges)[e].high];
        double along[3], to[3], off[3];
        vec_sub(along, b, a);
        double length = vec_normalize(along);
        uint32_t on_count = 0;
        for (uint32_t f = 0; f < 2 * *count && ok; f++) {
            uint32_t v = f & 1 ? (*edges)[f / 2].high : (*edges)[f / 2].low;
            vec_sub(to, s->pool.points[v], a);
            double t = vec_dot(to, along);
            vec_mad(off, to, -t, along);
            if (t <= s->eps || t >= length - s->eps || vec_length(off) > s->eps)
                continue;
            ok = ENF_RESERVE(on, (uint64_t)on_count + 1);
            if (ok)
                on[on_count++] = (Ordered){t, v};
        }
        if (on_count)
            qsort(on, on_count, sizeof *on, compare_ordered);
        uint32_t at = (*edges)[e].low;
        for (uint32_t i = 0; i < on_count && ok; i++) {
            ok = push_edge(&parts, &part_count, at, on[i].index, (*edges)[e].direction);
            at = on[i].index;
        }
        ok = ok && push_edge(&parts, &part_count, at, (*edges)[e].high, (*edges)[e].direction);
    }
    enf_free(on);
    enf_free(*edges);
    *edges = parts;
    *count = cancel_edges(parts, part_count);
    return ok;
}

typedef struct Face {
    uint32_t first, count;
    double area;
} Face;

static int compare_faces(const void *left, const void *right) {
    const Face *a = left, *b = right;
    if (a->area != b->area)
        return a->area > b->area ? -1 : 1;
    return a->first < b->first ? -1 : a->first > b->first;
}

static double out_of_plane(const double n[3], double d, double (*points)[3], uint32_t count) {
    double most = 0.0;
    for (uint32_t i = 0; i < count; i++)
        most = fmax(most, fabs(vec_dot(n, points[i]) - d));
    return most;
}

/* The plane all corners of a polygon lie in, an earlier one (either way round) if there is; ENF_NONE: no
 * memory. */
static uint32_t plane_of(EnfShape *s, double (*points)[3], uint32_t count) {
    double n[3], d = 0.0;
    double area = enf_polygon_normal(n, points, count);
    for (uint32_t p = 0; p < s->plane_count; p++)
        if (out_of_plane(s->planes[p].n, s->planes[p].d, points, count) <= s->eps && fabs(vec_dot(s->planes[p].n, n)) > 0.5) {
            s->planes[p].area += area;
            return p;
        }
    if (!ENF_RESERVE(s->planes, (uint64_t)s->plane_count + 1))
        return ENF_NONE;
    for (uint32_t i = 0; i < count; i++)
        d += vec_dot(n, points[i]) / count;
    /* Axis-parallel walls get exact planes. */
    for (int k = 0; k < 3; k++)
        if (fabs(n[k]) > 1.0 - 1e-14) {
            double sign = n[k] < 0.0 ? -1.0 : 1.0;
            vec_set(n, 0.0, 0.0, 0.0);
            n[k] = sign;
            d = sign * points[0][k];
            for (uint32_t i = 1; i < count; i++)
                if (points[i][k] != points[0][k]) {
                    d = 0.0;
                    for (uint32_t j = 0; j < count; j++)
                        d += sign * points[j][k] / count;
                    break;
                }
        }
    EnfShapePlane *plane = &s->planes[s->plane_count];
    vec_copy(plane->n, n);
    plane->d = d;
    plane->area = area;
    plane->weight = 0.0;
    return s->plane_count++;
}

int enf_shape_add_fragment(EnfShape *s, double (*points)[3], uint32_t count, uint32_t plane, uint32_t face) {
    if (!ENF_RESERVE(s->fragments, (uint64_t)s->fragment_count + 1) ||
        !ENF_RESERVE(s->fragment_points, (uint64_t)s->fragment_point_count + count))
        return 0;
    for (uint32_t i = 0; i < count; i++)
        vec_copy(s->fragment_points[s->fragment_point_count + i], points[i]);
    s->fragments[s->fragment_count++] = (EnfFragment){s->fragment_point_count, count, plane, face};
    s->fragment_point_count += count;
    return 1;
}

/* How much of the room's walls runs in a plane's direction (within a milliradian). */
void enf_shape_weigh_directions(EnfShape *s) {
    double most = 0.0;
    for (uint32_t p = 0; p < s->plane_count; p++) {
        for (uint32_t q = 0; q < s->plane_count; q++)
            if (fabs(vec_dot(s->planes[p].n, s->planes[q].n)) > 1.0 - 5e-7)
                s->planes[p].weight += s->planes[q].area;
        most = fmax(most, s->planes[p].weight);
    }
    for (uint32_t p = 0; p < s->plane_count && most > 0.0; p++)
        s->planes[p].weight /= most;
}

/* Scratch of reading faces. */
typedef struct Faces {
    uint32_t *corners; /* welded, in turn */
    uint32_t corner_count;
    Face *items;
    uint32_t count;
    double (*points)[3];
    uint32_t (*triangles)[3];
} Faces;

static int read_face(EnfShape *s, Faces *faces, const uint32_t *indices, uint32_t size, const uint32_t *weld) {
    uint32_t first = faces->corner_count, count = 0;
    if (!ENF_RESERVE(faces->corners, (uint64_t)first + size) || !ENF_RESERVE(faces->items, (uint64_t)faces->count + 1) ||
        !ENF_RESERVE(faces->points, size))
        return 0;
    for (uint32_t i = 0; i < size; i++) {
        uint32_t v = weld[indices[i]];
        if (count == 0 || faces->corners[first + count - 1] != v)
            faces->corners[first + count++] = v;
    }
    while (count > 1 && faces->corners[first] == faces->corners[first + count - 1])
        count--;
    if (count < 3)
        return 1; /* welded to a line or a point */
    for (uint32_t i = 0; i < count; i++)
        vec_copy(faces->points[i], s->pool.points[faces->corners[first + i]]);
    double n[3];
    faces->items[faces->count++] = (Face){first, count, enf_polygon_normal(n, faces->points, count)};
    faces->corner_count = first + count;
    return 1;
}

static uint32_t open_edges(const EnfShape *s, const Faces *faces, int *ok) {
    Edge *edges = NULL;
    uint32_t count = 0;
    *ok = 1;
    for (uint32_t f = 0; f < faces->count && *ok; f++) {
        const uint32_t *loop = faces->corners + faces->items[f].first;
        for (uint32_t i = 0; i < faces->items[f].count && *ok; i++)
            *ok = push_edge(&edges, &count, loop[i], loop[(i + 1) % faces->items[f].count], 1);
    }
    if (*ok)
        count = cancel_edges(edges, count);
    if (*ok && count)
        *ok = split_open_edges(s, &edges, &count);
    enf_free(edges);
    return count;
}

static int cut_face(EnfShape *s, Faces *faces, EnfDecomposition *notes, uint32_t index) {
    const Face *face = &faces->items[index];
    const uint32_t *loop = faces->corners + face->first;
    double n[3], triangle[3][3], d = 0.0;
    if (!ENF_RESERVE(faces->points, face->count) || !ENF_RESERVE(faces->triangles, face->count) ||
        !ENF_RESERVE(s->triangles, (uint64_t)s->triangle_count + face->count))
        return 0;
    for (uint32_t i = 0; i < face->count; i++)
        vec_copy(faces->points[i], s->pool.points[loop[i]]);
    enf_polygon_normal(n, faces->points, face->count);
    for (uint32_t i = 0; i < face->count; i++)
        d += vec_dot(n, faces->points[i]) / face->count;
    uint32_t count = enf_polygon_triangulate(faces->points, face->count, n, faces->triangles);
    if (count == 0)
        return 0;
    for (uint32_t t = 0; t < count; t++)
        for (int k = 0; k < 3; k++)
            s->triangles[s->triangle_count + t][k] = loop[faces->triangles[t][k]];
    s->triangle_count += count;
    int planar = out_of_plane(n, d, faces->points, face->count) <= s->eps;
    uint32_t plane = planar ? plane_of(s, faces->points, face->count) : 0;
    notes->not_planar += !planar;
    if (plane == ENF_NONE)
        return 0;
    if (planar && enf_polygon_is_convex(faces->points, face->count, n, s->eps))
        return enf_shape_add_fragment(s, faces->points, face->count, plane, index);
    for (uint32_t t = 0; t < count; t++) {
        for (int k = 0; k < 3; k++)
            vec_copy(triangle[k], faces->points[faces->triangles[t][k]]);
        double area = enf_polygon_normal(n, triangle, 3);
        double longest = fmax(vec_distance(triangle[0], triangle[1]),
                              fmax(vec_distance(triangle[1], triangle[2]), vec_distance(triangle[2], triangle[0])));
        if (area <= 0.5 * s->eps * longest)
            continue; /* a sliver of no width: it bounds nothing */
        if (!planar && (plane = plane_of(s, triangle, 3)) == ENF_NONE)
            return 0;
        if (!enf_shape_add_fragment(s, triangle, 3, plane, index))
            return 0;
    }
    return 1;
}

/* The surface is taken from the faces themselves: of a face that crosses itself, triangles may overlap. */
static void measure_volume(EnfShape *s, const Faces *faces) {
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        const uint32_t *t = s->triangles[i];
        double cross[3];
        vec_cross(cross, s->pool.points[t[1]], s->pool.points[t[2]]);
        s->volume += vec_dot(s->pool.points[t[0]], cross) / 6.0;
    }
    for (uint32_t f = 0; f < faces->count; f++)
        s->surface += faces->items[f].area;
}

int enf_shape_from_polyhedron(EnfShape *s, EnfDecomposition *notes, double coarse, double (*vertices)[3], uint32_t vertex_count,
                              const uint32_t *face_sizes, uint32_t face_count, const uint32_t *face_indices) {
    memset(s, 0, sizeof *s);
    Faces faces = {0};
    uint32_t *weld = ENF_NEW(uint32_t, vertex_count);
    int ok = weld && take_corners(s, vertices, vertex_count, coarse) && weld_corners(s, weld);
    for (uint32_t f = 0; f < face_count && ok; face_indices += face_sizes[f++])
        ok = read_face(s, &faces, face_indices, face_sizes[f], weld);
    if (ok && faces.count)
        qsort(faces.items, faces.count, sizeof *faces.items, compare_faces);
    if (ok)
        notes->not_closed = open_edges(s, &faces, &ok);
    if (ok && !faces.count)
        notes->not_closed = 1;
    if (ok && !notes->not_closed) {
        for (uint32_t f = 0; f < faces.count && ok; f++)
            ok = cut_face(s, &faces, notes, f);
        s->face_count = faces.count;
        if (ok) {
            measure_volume(s, &faces);
            enf_shape_weigh_directions(s);
            notes->inside_out = s->volume < 0.0;
            if (notes->inside_out) {
                s->volume = -s->volume;
                for (uint32_t i = 0; i < s->triangle_count; i++) {
                    uint32_t t = s->triangles[i][1];
                    s->triangles[i][1] = s->triangles[i][2];
                    s->triangles[i][2] = t;
                }
            }
        }
    }
    enf_free(weld);
    enf_free(faces.corners);
    enf_free(faces.items);
    enf_free(faces.points);
    enf_free(faces.triangles);
    return !ok ? ENF_SHAPE_NO_MEMORY : notes->not_closed ? ENF_SHAPE_NOT_CLOSED : ENF_SHAPE_OK;
}

int enf_shape_from_prism(EnfShape *s, double coarse, const double *corners, const uint32_t *ring_sizes, uint64_t ring_count, double z0,
                         double z1) {
    memset(s, 0, sizeof *s);
    uint64_t count = 0;
    for (uint64_t r = 0; r < ring_count; r++)
        count += ring_sizes[r];
    double(*vertices)[3] = enf_alloc_array(2 * count, sizeof *vertices);
    s->ring_corners = enf_alloc_array(count, sizeof *s->ring_corners);
    int ok = vertices && s->ring_corners;
    for (uint64_t i = 0; i < count && ok; i++) {
        vec_set(vertices[2 * i], corners[2 * i], corners[2 * i + 1], z0);
        vec_set(vertices[2 * i + 1], corners[2 * i], corners[2 * i + 1], z1);
    }
    ok = ok && take_corners(s, vertices, (uint32_t)(2 * count), coarse);
    enf_free(vertices);
    if (!ok)
        return ENF_SHAPE_NO_MEMORY;
    s->prism = 1;
    s->z0 = z0 - s->centre[2];
    s->z1 = z1 - s->centre[2];
    s->ring_sizes = ring_sizes;
    s->ring_count = ring_count;
    double area = 0.0;
    uint64_t first = 0;
    for (uint64_t r = 0; r < ring_count && ok; first += ring_sizes[r++]) {
        double ring_area = 0.0;
        uint32_t n = ring_sizes[r];
        for (uint32_t i = 0; i < n && ok; i++) {
            uint64_t a = 2 * (first + i), b = 2 * (first + (i + 1) % n);
            double quad[4][3];
            s->ring_corners[first + i][0] = s->pool.points[a][0];
            s->ring_corners[first + i][1] = s->pool.points[a][1];
            vec_copy(quad[0], s->pool.points[a]);
            vec_copy(quad[1], s->pool.points[b]);
            vec_copy(quad[2], s->pool.points[b + 1]);
            vec_copy(quad[3], s->pool.points[a + 1]);
            ring_area += 0.5 * (quad[0][0] * quad[1][1] - quad[0][1] * quad[1][0]);
            s->surface += vec_distance(quad[0], quad[1]) * (z1 - z0);
            if (vec_distance(quad[0], quad[1]) <= s->eps)
                continue;
            uint32_t plane = plane_of(s, quad, 4);
            ok = plane != ENF_NONE && enf_shape_add_fragment(s, quad, 4, plane, s->face_count++);
        }
        area += r == 0 ? fabs(ring_area) : -fabs(ring_area);
    }
    s->volume = area * (z1 - z0);
    s->surface += 2.0 * area;
    enf_shape_weigh_directions(s);
    s->z0_plane = s->plane_count;
    s->z1_plane = s->plane_count + 1;
    ok = ok && ENF_RESERVE(s->planes, (uint64_t)s->plane_count + 2);
    if (ok) {
        s->planes[s->plane_count++] = (EnfShapePlane){{0, 0, 1}, s->z0, 0, 0};
        s->planes[s->plane_count++] = (EnfShapePlane){{0, 0, 1}, s->z1, 0, 0};
        s->box_codes[0] = 2 * s->z0_plane + 1; /* enf_solid_box: the first face is the floor, the second the ceiling */
        s->box_codes[1] = 2 * s->z1_plane;
    }
    return ok ? ENF_SHAPE_OK : ENF_SHAPE_NO_MEMORY;
}
