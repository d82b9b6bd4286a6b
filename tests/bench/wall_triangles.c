/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cuts openings out of faces in the plane, puts every corner that lies on an edge into that edge, then cuts ears. */
#include "wall_triangles.h"

#include "geometry/box_tree.h"
#include "geometry/vec3.h"
#include "scene/scene_data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CORNERS = 128, PIECES = 8192 }; /* of one piece; of one face */

typedef struct Piece {
    double v[CORNERS][2];
    uint32_t count;
} Piece;

/* A polygon of welded vertices. */
typedef struct Outline {
    uint32_t first, count, surface;
} Outline;

typedef struct Maker {
    const EnfScene *scene;
    double tolerance;
    double (*points)[3];
    uint32_t point_count, point_room;
    uint32_t *bucket, bucket_count, *chain;
    uint32_t *corners;
    uint32_t corner_count, corner_room;
    Outline *outlines;
    uint32_t outline_count, outline_room;
    Piece *pieces, *next; /* [PIECES] */
    int failed;
    WallTriangles *out;
    uint32_t triangle_room;
} Maker;

static void *grown(void *array, uint32_t *room, uint32_t count, size_t size, int *failed) {
    if (count < *room)
        return array;
    uint32_t wanted = 2 * *room + 1024;
    void *more = realloc(array, wanted * size);
    if (!more) {
        *failed = 1;
        return array;
    }
    *room = wanted;
    return more;
}

static uint32_t slot(const Maker *m, int64_t x, int64_t y, int64_t z) {
    uint64_t h = (uint64_t)x * 0x9E3779B97F4A7C15ull ^ (uint64_t)y * 0xC2B2AE3D27D4EB4Full ^ (uint64_t)z * 0x165667B19E3779F9ull;
    return (uint32_t)((h ^ h >> 31) % m->bucket_count);
}

static uint32_t weld(Maker *m, const double p[3]) {
    double size = 8 * m->tolerance;
    int64_t lo[3], hi[3], at[3];
    for (int k = 0; k < 3; k++) {
        lo[k] = (int64_t)floor((p[k] - m->tolerance) / size);
        hi[k] = (int64_t)floor((p[k] + m->tolerance) / size);
    }
    for (at[0] = lo[0]; at[0] <= hi[0]; at[0]++)
        for (at[1] = lo[1]; at[1] <= hi[1]; at[1]++)
            for (at[2] = lo[2]; at[2] <= hi[2]; at[2]++)
                for (uint32_t i = m->bucket[slot(m, at[0], at[1], at[2])]; i != ENF_NONE; i = m->chain[i])
                    if (fabs(m->points[i][0] - p[0]) <= m->tolerance && fabs(m->points[i][1] - p[1]) <= m->tolerance &&
                        fabs(m->points[i][2] - p[2]) <= m->tolerance)
                        return i;
    uint32_t room = m->point_room;
    m->points = grown(m->points, &m->point_room, m->point_count, sizeof *m->points, &m->failed);
    m->chain = grown(m->chain, &room, m->point_count, sizeof *m->chain, &m->failed);
    if (m->failed)
        return 0;
    uint32_t *head = &m->bucket[slot(m, (int64_t)floor(p[0] / size), (int64_t)floor(p[1] / size), (int64_t)floor(p[2] / size))];
    vec_copy(m->points[m->point_count], p);
    m->chain[m->point_count] = *head;
    return *head = m->point_count++;
}

/* What of `in` lies on the side of a-b where side * cross > 0. Corners within the tolerance of the line are on it. */
static void cut(const Piece *in, const double a[2], const double b[2], double side, double tolerance, Piece *out) {
    double ex = b[0] - a[0], ey = b[1] - a[1], length = hypot(ex, ey), before = 0, at[CORNERS];
    out->count = 0;
    for (uint32_t i = 0; i < in->count; i++) {
        at[i] = side * (ex * (in->v[i][1] - a[1]) - ey * (in->v[i][0] - a[0])) / length;
        if (fabs(at[i]) <= tolerance)
            at[i] = 0;
    }
    before = in->count ? at[in->count - 1] : 0;
    for (uint32_t i = 0; i < in->count && out->count + 2 < CORNERS; i++) {
        const double *p = in->v[i], *q = in->v[i ? i - 1 : in->count - 1];
        if (at[i] * before < 0) {
            double t = before / (before - at[i]);
            out->v[out->count][0] = q[0] + t * (p[0] - q[0]);
            out->v[out->count++][1] = q[1] + t * (p[1] - q[1]);
        }
        if (at[i] >= 0) {
            out->v[out->count][0] = p[0];
            out->v[out->count++][1] = p[1];
        }
        before = at[i];
    }
}

static double area(const Piece *p) {
    double sum = 0;
    for (uint32_t i = 0; i < p->count; i++) {
        const double *a = p->v[i], *b = p->v[(i + 1) % p->count];
        sum += (a[0] - p->v[0][0]) * (b[1] - p->v[0][1]) - (a[1] - p->v[0][1]) * (b[0] - p->v[0][0]);
    }
    return 0.5 * sum;
}

static void add_outline(Maker *m, const double (*points)[3], uint32_t count, uint32_t surface) {
    m->outlines = grown(m->outlines, &m->outline_room, m->outline_count, sizeof *m->outlines, &m->failed);
    if (m->failed)
        return;
    Outline *o = &m->outlines[m->outline_count++];
    *o = (Outline){m->corner_count, 0, surface};
    for (uint32_t i = 0; i < count; i++) {
        uint32_t v = weld(m, points[i]);
        m->corners = grown(m->corners, &m->corner_room, m->corner_count, sizeof *m->corners, &m->failed);
        if (m->failed)
            return;
        if (o->count && (m->corners[m->corner_count - 1] == v || (i + 1 == count && m->corners[o->first] == v)))
            continue;
        m->corners[m->corner_count++] = v;
        o->count++;
    }
}

/* A face without its openings. */
static void add_face(Maker *m, uint32_t c, uint32_t f) {
    const EnfScene *scene = m->scene;
    const EnfPlane *plane = &scene->face_planes[f];
    const double *n = plane->n;
    double u[3] = {-n[1], n[0], 0}, v[3], base[3], p[3];
    if (hypot(n[0], n[1]) < 1e-6)
        vec_set(u, 1, 0, 0);
    vec_normalize(u);
    vec_cross(v, n, u);
    uint32_t first = scene->face_index_first[f], end = scene->face_index_first[f + 1], pieces = 1;
    vec_sub(base, scene->cell_vertices[scene->cell_vertex_first[c] + scene->face_indices[first]], scene->origin);
    m->pieces[0].count = 0;
    for (uint32_t i = first; i < end && m->pieces[0].count < CORNERS; i++) {
        vec_sub(p, scene->cell_vertices[scene->cell_vertex_first[c] + scene->face_indices[i]], scene->origin);
        vec_sub(p, p, base);
        double *to = m->pieces[0].v[m->pieces[0].count++];
        to[0] = vec_dot(p, u);
        to[1] = vec_dot(p, v);
    }
    for (uint32_t s = scene->cell_portal_first[c]; s < scene->cell_portal_first[c + 1]; s++) {
        uint32_t portal = scene->cell_portals[s].portal, corner = scene->portal_vertex_first[portal],
                 count = scene->portal_vertex_first[portal + 1] - corner;
        Piece hole = {.count = 0};
        double off = 0, along = vec_dot(scene->portal_planes[portal].n, n) * (scene->cell_portals[s].side ? -1 : 1);
        for (uint32_t i = 0; i < count && i < CORNERS; i++) {
            vec_sub(p, scene->portal_vertices[corner + i], scene->origin);
            off = fmax(off, fabs(vec_dot(n, p) - plane->d));
            vec_sub(p, p, base);
            double *to = hole.v[hole.count++];
            to[0] = vec_dot(p, u);
            to[1] = vec_dot(p, v);
        }
        if (along < 0.5 || off > 1e-3) /* a millimetre: in another face */
            continue;
        if (area(&hole) < 0) /* counter-clockwise */
            for (uint32_t i = 0; i < hole.count / 2; i++)
                for (int k = 0; k < 2; k++) {
                    double t = hole.v[i][k];
                    hole.v[i][k] = hole.v[hole.count - 1 - i][k];
                    hole.v[hole.count - 1 - i][k] = t;
                }
        uint32_t made = 0;
        double smallest = m->tolerance * m->tolerance;
        for (uint32_t i = 0; i < pieces; i++) {
            Piece rest = m->pieces[i], outside;
            uint32_t before = made;
            for (uint32_t e = 0; e < hole.count && rest.count >= 3 && made < PIECES - 1; e++) {
                const double *a = hole.v[e], *b = hole.v[(e + 1) % hole.count];
                cut(&rest, a, b, -1, m->tolerance, &outside);
                if (outside.count >= 3 && area(&outside) > smallest)
                    m->next[made++] = outside;
                Piece inside;
                cut(&rest, a, b, 1, m->tolerance, &inside);
                rest = inside;
            }
            if (rest.count < 3 || area(&rest) <= smallest) { /* the hole lies beside this piece */
                made = before;
                if (made < PIECES - 1)
                    m->next[made++] = m->pieces[i];
            }
        }
        pieces = made;
        Piece *done = m->pieces;
        m->pieces = m->next;
        m->next = done;
    }
    for (uint32_t i = 0; i < pieces; i++) {
        double points[CORNERS][3];
        for (uint32_t k = 0; k < m->pieces[i].count; k++) {
            vec_mad(points[k], base, m->pieces[i].v[k][0], u);
            vec_mad(points[k], points[k], m->pieces[i].v[k][1], v);
        }
        add_outline(m, (const double(*)[3])points, m->pieces[i].count, f);
    }
}

static int compare_places(const void *left, const void *right) {
    const double *a = left, *b = right;
    return a[0] < b[0] ? -1 : a[0] > b[0];
}

/* The outline with every vertex that lies on one of its edges. */
static uint32_t with_vertices_on_edges(Maker *m, const EnfBoxTree *tree, const Outline *o, uint32_t *out, uint32_t room) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < o->count; i++) {
        uint32_t a = m->corners[o->first + i], b = m->corners[o->first + (i + 1) % o->count], found = 0;
        double box[6], e[3], places[CORNERS][2], length2;
        box_empty(box);
        box_add_point(box, m->points[a]);
        box_add_point(box, m->points[b]);
        box_grow(box, 2 * m->tolerance);
        vec_sub(e, m->points[b], m->points[a]);
        length2 = vec_dot(e, e);
        EnfBoxWalk walk;
        enf_box_walk_begin(&walk, tree, box);
        for (uint32_t k; (k = enf_box_walk_next(&walk)) != ENF_NONE;) {
            double to[3], off[3];
            if (k == a || k == b || found == CORNERS)
                continue;
            vec_sub(to, m->points[k], m->points[a]);
            double t = vec_dot(to, e) / length2;
            vec_mad(off, to, -t, e);
            if (t > 0 && t < 1 && vec_length(off) <= 2 * m->tolerance) {
                places[found][0] = t;
                places[found++][1] = k;
            }
        }
        qsort(places, found, sizeof *places, compare_places);
        if (count < room)
            out[count++] = a;
        for (uint32_t k = 0; k < found && count < room; k++)
            out[count++] = (uint32_t)places[k][1];
    }
    return count;
}

/* Height of the triangle over its longest edge; 0 when it has no area. */
static double slimness(const Maker *m, uint32_t a, uint32_t b, uint32_t c) {
    double p[3], q[3], r[3], n[3];
    vec_sub(p, m->points[b], m->points[a]);
    vec_sub(q, m->points[c], m->points[a]);
    vec_sub(r, m->points[c], m->points[b]);
    vec_cross(n, p, q);
    double longest = fmax(vec_length(p), fmax(vec_length(q), vec_length(r)));
    return vec_length(n) / longest;
}

static void cut_ears(Maker *m, uint32_t *v, uint32_t count, uint32_t surface) {
    while (count >= 3 && !m->failed) {
        uint32_t best = 0;
        double most = -1;
        for (uint32_t i = 0; i < count; i++) {
            double s = slimness(m, v[i ? i - 1 : count - 1], v[i], v[i + 1 < count ? i + 1 : 0]);
            /* what remains must have area: not the only corner off a line */
            if (s > most)
                most = s, best = i;
        }
        if (count > 3) { /* never leave a sliver: an ear whose removal makes all the rest collinear is put off */
            double kept = -1;
            for (uint32_t i = 0; i < count; i++) {
                uint32_t a = v[i ? i - 1 : count - 1], b = v[i], c = v[i + 1 < count ? i + 1 : 0];
                uint32_t before = v[(i + count - 2) % count], after = v[(i + 2) % count];
                double s = slimness(m, a, b, c);
                if (s <= 2 * m->tolerance)
                    continue;
                double around = fmax(slimness(m, before, a, c), slimness(m, a, c, after));
                double worth = fmin(s, around);
                if (worth > kept)
                    kept = worth, best = i, most = s;
            }
        }
        if (most > 2 * m->tolerance) {
            WallTriangles *w = m->out;
            uint32_t room = m->triangle_room;
            w->triangles = grown(w->triangles, &m->triangle_room, w->triangle_count, sizeof *w->triangles, &m->failed);
            w->surfaces = grown(w->surfaces, &room, w->triangle_count, sizeof *w->surfaces, &m->failed);
            if (m->failed)
                return;
            uint32_t *t = w->triangles[w->triangle_count];
            t[0] = v[best ? best - 1 : count - 1];
            t[1] = v[best];
            t[2] = v[best + 1 < count ? best + 1 : 0];
            w->surfaces[w->triangle_count++] = surface;
        }
        memmove(v + best, v + best + 1, (count - 1 - best) * sizeof *v);
        count--;
    }
}

int wall_triangles_make(const EnfScene *scene, const double origin[3], WallTriangles *out) {
    Maker *m = calloc(1, sizeof *m);
    memset(out, 0, sizeof *out);
    if (!m)
        return 0;
    vec_copy(out->origin, origin);
    m->scene = scene;
    m->out = out;
    m->tolerance = fmax(scene->tolerance, 1.5e-7 * scene->extent);
    m->bucket_count = 4 * scene->cell_vertex_first[scene->cell_count] + 1024;
    m->bucket = malloc(sizeof *m->bucket * m->bucket_count);
    if (m->bucket)
        memset(m->bucket, 0xFF, sizeof *m->bucket * m->bucket_count);
    m->pieces = malloc(PIECES * sizeof *m->pieces);
    m->next = malloc(PIECES * sizeof *m->next);
    m->failed = !m->bucket || !m->pieces || !m->next;
    for (uint32_t c = 0; c < scene->cell_count && !m->failed; c++)
        for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++)
            add_face(m, c, f);
    uint32_t faces = scene->cell_face_first[scene->cell_count];
    for (uint32_t p = 0; p < scene->portal_count && !m->failed; p++) {
        uint32_t first = scene->portal_vertex_first[p], count = scene->portal_vertex_first[p + 1] - first;
        double points[CORNERS][3];
        if (enf_portal_passes(scene, p) || count > CORNERS)
            continue;
        for (uint32_t i = 0; i < count; i++)
            vec_sub(points[i], scene->portal_vertices[first + i], scene->origin);
        add_outline(m, (const double(*)[3])points, count, faces + p);
    }
    double(*boxes)[6] = malloc(sizeof *boxes * ((size_t)m->point_count + 1));
    uint32_t *around = malloc(sizeof *around * 65536);
    EnfBoxTree tree = {0};
    m->failed |= !boxes || !around;
    for (uint32_t i = 0; i < m->point_count && !m->failed; i++) {
        vec_copy(boxes[i], m->points[i]);
        vec_copy(boxes[i] + 3, m->points[i]);
    }
    m->failed = m->failed || !enf_box_tree_build(&tree, (const double(*)[6])boxes, m->point_count);
    for (uint32_t i = 0; i < m->outline_count && !m->failed; i++) {
        uint32_t count = with_vertices_on_edges(m, &tree, &m->outlines[i], around, 65536);
        cut_ears(m, around, count, m->outlines[i].surface);
    }
    enf_box_tree_free(&tree);
    free(boxes);
    free(around);
    out->vertices = malloc(sizeof *out->vertices * ((size_t)m->point_count + 1));
    m->failed |= !out->vertices;
    out->vertex_count = m->point_count;
    for (uint32_t i = 0; i < m->point_count && !m->failed; i++)
        for (int k = 0; k < 3; k++)
            out->vertices[i][k] = (float)(m->points[i][k] + (scene->origin[k] - origin[k]));
    int ok = !m->failed;
    free(m->points);
    free(m->chain);
    free(m->bucket);
    free(m->pieces);
    free(m->next);
    free(m->corners);
    free(m->outlines);
    free(m);
    if (!ok)
        wall_triangles_free(out);
    return ok;
}

void wall_triangles_free(WallTriangles *walls) {
    free(walls->vertices);
    free(walls->triangles);
    free(walls->surfaces);
    memset(walls, 0, sizeof *walls);
}
