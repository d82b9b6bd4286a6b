/* SPDX-License-Identifier: GPL-3.0-or-later
 * Convex hull of points in space.
 * Based on: Barber, Dobkin, Huhdanpaa, The Quickhull Algorithm for Convex Hulls, 1996 (farthest point first,
 * horizon by flood); triangles that lie in one plane are merged at the end. */
#include "geometry/convex_hull.h"
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

typedef struct Triangle {
    uint32_t v[3], next[3]; /* next[k]: the triangle across the edge v[k] - v[k + 1] */
    double n[3], d, area;
    uint32_t farthest; /* point that sticks out most, ENF_NONE for none */
    double distance;
    uint32_t outside; /* first of its outside points, linked by Builder.link */
    int dead;
    uint32_t mark;
} Triangle;

typedef struct Edge {
    uint32_t a, b, beyond;
} Edge;

typedef struct Builder {
    double (*points)[3];
    uint32_t count;
    double eps;
    Triangle *triangles;
    uint32_t triangle_count;
    uint32_t *link; /* next outside point of the same triangle */
    Edge *horizon;
    uint32_t *stack;
    uint32_t *start_of; /* per point: new triangle whose edge starts there */
} Builder;

static int add_triangle(Builder *b, uint32_t p, uint32_t q, uint32_t r) {
    if (!ENF_RESERVE(b->triangles, (uint64_t)b->triangle_count + 1))
        return 0;
    Triangle *t = &b->triangles[b->triangle_count++];
    memset(t, 0, sizeof *t);
    t->v[0] = p;
    t->v[1] = q;
    t->v[2] = r;
    double u[3], w[3];
    vec_sub(u, b->points[q], b->points[p]);
    vec_sub(w, b->points[r], b->points[p]);
    vec_cross(t->n, u, w);
    t->area = vec_normalize(t->n);
    t->farthest = t->outside = ENF_NONE;
    return 1;
}

static double height(const Builder *b, const Triangle *t, uint32_t point) {
    double local[3];
    vec_sub(local, b->points[point], b->points[t->v[0]]);
    return vec_dot(t->n, local);
}

/* Gives a point to the first triangle of [from, to) it sticks out of. */
static void assign(Builder *b, uint32_t point, uint32_t from, uint32_t to) {
    for (uint32_t i = from; i < to; i++) {
        Triangle *t = &b->triangles[i];
        double h = t->dead ? 0.0 : height(b, t, point);
        if (h > b->eps) {
            b->link[point] = t->outside;
            t->outside = point;
            if (h > t->distance) {
                t->distance = h;
                t->farthest = point;
            }
            return;
        }
    }
}

/* Four points that span the most: farthest apart, then off their line, then off their plane. */
static int first_simplex(Builder *b, uint32_t corner[4]) {
    double best = -1.0, d[3], line[3], n[3];
    for (int axis = 0; axis < 3; axis++) {
        uint32_t low = 0, high = 0;
        for (uint32_t i = 1; i < b->count; i++) {
            if (b->points[i][axis] < b->points[low][axis])
                low = i;
            if (b->points[i][axis] > b->points[high][axis])
                high = i;
        }
        if (vec_distance(b->points[low], b->points[high]) > best) {
            best = vec_distance(b->points[low], b->points[high]);
            corner[0] = low;
            corner[1] = high;
        }
    }
    if (!(best > b->eps))
        return 0;
    vec_sub(line, b->points[corner[1]], b->points[corner[0]]);
    vec_normalize(line);
    best = 0.0;
    for (uint32_t i = 0; i < b->count; i++) {
        double cross[3];
        vec_sub(d, b->points[i], b->points[corner[0]]);
        vec_cross(cross, line, d);
        if (vec_length(cross) > best) {
            best = vec_length(cross);
            corner[2] = i;
        }
    }
    if (!(best > b->eps))
        return 0;
    vec_sub(d, b->points[corner[2]], b->points[corner[0]]);
    vec_cross(n, line, d);
    vec_normalize(n);
    best = 0.0;
    double sign = 0.0;
    for (uint32_t i = 0; i < b->count; i++) {
        vec_sub(d, b->points[i], b->points[corner[0]]);
        double h = vec_dot(n, d);
        if (fabs(h) > best) {
            best = fabs(h);
            sign = h;
            corner[3] = i;
        }
    }
    if (!(best > b->eps))
        return 0;
    if (sign > 0.0) { /* the fourth point must lie behind 0 1 2 */
        uint32_t t = corner[1];
        corner[1] = corner[2];
        corner[2] = t;
    }
    return 1;
}

static int start(Builder *b) {
    uint32_t c[4] = {0, 0, 0, 0};
    if (!first_simplex(b, c))
        return ENF_HULL_FLAT;
    if (!add_triangle(b, c[0], c[1], c[2]) || !add_triangle(b, c[0], c[2], c[3]) || !add_triangle(b, c[0], c[3], c[1]) ||
        !add_triangle(b, c[1], c[3], c[2]))
        return ENF_HULL_NO_MEMORY;
    for (uint32_t i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            for (uint32_t j = 0; j < 4; j++)
                for (int m = 0; m < 3; m++)
                    if (i != j && b->triangles[i].v[k] == b->triangles[j].v[(m + 1) % 3] &&
                        b->triangles[i].v[(k + 1) % 3] == b->triangles[j].v[m])
                        b->triangles[i].next[k] = j;
    for (uint32_t p = 0; p < b->count; p++)
        assign(b, p, 0, 4);
    return ENF_HULL_OK;
}

/* Marks what the point sees, from `seed` on, as dead. Gives the points that stood outside of those, linked. */
static uint32_t kill_seen(Builder *b, uint32_t seed, uint32_t point, uint32_t round) {
    uint32_t depth = 0, orphans = ENF_NONE;
    b->stack[depth++] = seed;
    b->triangles[seed].mark = round;
    b->triangles[seed].dead = 1;
    while (depth) {
        Triangle *t = &b->triangles[b->stack[--depth]];
        for (uint32_t p = t->outside, after; p != ENF_NONE; p = after) {
            after = b->link[p];
            b->link[p] = orphans;
            orphans = p;
        }
        for (int k = 0; k < 3; k++) {
            Triangle *other = &b->triangles[t->next[k]];
            if (other->mark == round || !(height(b, other, point) > 0.0))
                continue;
            other->mark = round;
            other->dead = 1;
            b->stack[depth++] = t->next[k];
        }
    }
    return orphans;
}

/* The edges round what died this round. Gives their number. */
static uint32_t find_horizon(Builder *b, uint32_t round) {
    uint32_t edges = 0;
    for (uint32_t i = 0; i < b->triangle_count; i++) {
        const Triangle *t = &b->triangles[i];
        if (t->mark != round || !t->dead)
            continue;
        for (int k = 0; k < 3; k++)
            if (!b->triangles[t->next[k]].dead)
                b->horizon[edges++] = (Edge){t->v[k], t->v[(k + 1) % 3], t->next[k]};
    }
    return edges;
}

/* Triangles from the horizon to the point. */
static int add_cone(Builder *b, uint32_t edges, uint32_t point) {
    uint32_t first = b->triangle_count;
    for (uint32_t i = 0; i < edges; i++) {
        if (!add_triangle(b, b->horizon[i].a, b->horizon[i].b, point))
            return 0;
        b->start_of[b->horizon[i].a] = first + i;
    }
    for (uint32_t i = 0; i < edges; i++) {
        Triangle *t = &b->triangles[first + i], *beyond = &b->triangles[b->horizon[i].beyond];
        t->next[0] = b->horizon[i].beyond;
        for (int k = 0; k < 3; k++)
            if (beyond->v[k] == b->horizon[i].b && beyond->v[(k + 1) % 3] == b->horizon[i].a)
                beyond->next[k] = first + i;
        uint32_t successor = b->start_of[b->horizon[i].b];
        /* Rounding can leave a horizon that isn't one loop; then no edge starts here, and any triangle keeps
         * us in bounds (the caller's check of closedness judges the result). */
        if (successor < first || successor >= b->triangle_count)
            successor = first;
        t->next[1] = successor;
        b->triangles[successor].next[2] = first + i;
    }
    return 1;
}

/* Adds the point that sticks out of triangle `seed`: what it sees goes, a cone to the horizon comes. */
static int add_point(Builder *b, uint32_t seed, uint32_t point, uint32_t round) {
    uint32_t first = b->triangle_count;
    if (!ENF_RESERVE(b->stack, (uint64_t)first + 1) || !ENF_RESERVE(b->horizon, 3 * (uint64_t)first))
        return 0;
    uint32_t orphans = kill_seen(b, seed, point, round), edges = find_horizon(b, round);
    if (!add_cone(b, edges, point))
        return 0;
    for (uint32_t p = orphans, after; p != ENF_NONE; p = after) {
        after = b->link[p];
        if (p != point)
            assign(b, p, first, b->triangle_count);
    }
    return 1;
}

/* Drops dead triangles so that the scans above stay short. */
static void compact(Builder *b) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < b->triangle_count; i++)
        b->triangles[i].mark = b->triangles[i].dead ? ENF_NONE : kept++;
    for (uint32_t i = 0, k = 0; i < b->triangle_count; i++) {
        if (b->triangles[i].dead)
            continue;
        for (int e = 0; e < 3; e++)
            b->triangles[i].next[e] = b->triangles[b->triangles[i].next[e]].mark;
        k++;
    }
    kept = 0;
    for (uint32_t i = 0; i < b->triangle_count; i++)
        if (!b->triangles[i].dead)
            b->triangles[kept++] = b->triangles[i];
    for (uint32_t i = 0; i < kept; i++)
        b->triangles[i].mark = 0;
    b->triangle_count = kept;
}

/* Marks the triangles that hang together with the seed and lie in its plane. */
static void grow_patch(Builder *b, uint32_t seed, uint32_t patch) {
    uint32_t stack_size = 0;
    b->stack[stack_size++] = seed;
    b->triangles[seed].mark = patch;
    while (stack_size) {
        const Triangle *t = &b->triangles[b->stack[--stack_size]];
        for (int k = 0; k < 3; k++) {
            Triangle *other = &b->triangles[t->next[k]];
            int flat = !other->mark && (other->area == 0.0 || vec_dot(other->n, b->triangles[seed].n) > 0.0);
            for (int m = 0; m < 3 && flat; m++)
                flat = fabs(height(b, &b->triangles[seed], other->v[m])) <= b->eps;
            if (flat) {
                other->mark = patch;
                b->stack[stack_size++] = t->next[k];
            }
        }
    }
}

/* The rim of a patch as a face. Gives its corners; 0: it isn't one loop. follow: scratch, [points]. */
static uint32_t walk_rim(const Builder *b, uint32_t patch, uint32_t *follow, uint32_t *out) {
    uint32_t begin = ENF_NONE, edges = 0, length = 0;
    for (uint32_t i = 0; i < b->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            if (b->triangles[i].mark == patch && b->triangles[b->triangles[i].next[k]].mark != patch) {
                begin = b->triangles[i].v[k];
                follow[begin] = b->triangles[i].v[(k + 1) % 3];
                edges++;
            }
    for (uint32_t at = begin; edges && length <= edges; at = follow[at]) {
        out[length++] = at;
        if (follow[at] == begin)
            break;
    }
    return length == edges && length >= 3 ? length : 0;
}

/* Grows patches of coplanar triangles, biggest seeds first, and walks round each. */
static int merge(Builder *b, EnfHull *hull) {
    uint32_t n = b->triangle_count, indices = 0;
    hull->face_sizes = ENF_NEW(uint32_t, n);
    hull->face_indices = ENF_NEW(uint32_t, 3 * (uint64_t)n);
    uint32_t *follow = ENF_NEW(uint32_t, b->count);
    if (!hull->face_sizes || !hull->face_indices || !follow || !ENF_RESERVE(b->stack, n)) {
        enf_free(follow);
        return 0;
    }
    for (uint32_t i = 0; i < n; i++)
        b->triangles[i].mark = 0;
    for (uint32_t patch = 1;; patch++) {
        uint32_t seed = ENF_NONE;
        for (uint32_t i = 0; i < n; i++)
            if (!b->triangles[i].mark && (seed == ENF_NONE || b->triangles[i].area > b->triangles[seed].area))
                seed = i;
        if (seed == ENF_NONE)
            break;
        grow_patch(b, seed, patch);
        uint32_t length = walk_rim(b, patch, follow, hull->face_indices + indices);
        if (length) {
            hull->face_sizes[hull->face_count++] = length;
            indices += length;
            continue;
        }
        /* A patch whose rim isn't one loop (slivers at rounding level) stays triangles. */
        for (uint32_t i = 0; i < n; i++)
            if (b->triangles[i].mark == patch) {
                for (int k = 0; k < 3; k++)
                    hull->face_indices[indices++] = b->triangles[i].v[k];
                hull->face_sizes[hull->face_count++] = 3;
            }
    }
    hull->index_count = indices;
    enf_free(follow);
    return 1;
}

int enf_hull_build(EnfHull *hull, double (*points)[3], uint32_t count, double eps) {
    memset(hull, 0, sizeof *hull);
    Builder builder = {points, count, eps, NULL, 0, NULL, NULL, NULL, NULL}, *b = &builder;
    b->link = ENF_NEW(uint32_t, count);
    b->start_of = ENF_NEW(uint32_t, count);
    int status = !b->link || !b->start_of ? ENF_HULL_NO_MEMORY : count < 4 ? ENF_HULL_FLAT : start(b);
    uint32_t round = 1, dead = 0;
    /* Every turn uses up at least one point: at most `count` turns. */
    for (uint32_t turn = 0; status == ENF_HULL_OK && turn < count; turn++) {
        uint32_t seed = ENF_NONE;
        for (uint32_t i = 0; i < b->triangle_count; i++)
            if (!b->triangles[i].dead && b->triangles[i].farthest != ENF_NONE &&
                (seed == ENF_NONE || b->triangles[i].distance > b->triangles[seed].distance))
                seed = i;
        if (seed == ENF_NONE)
            break;
        if (!add_point(b, seed, b->triangles[seed].farthest, round++))
            status = ENF_HULL_NO_MEMORY;
        if (++dead >= 16) {
            compact(b);
            dead = 0;
            round = 1;
        }
    }
    if (status == ENF_HULL_OK) {
        compact(b);
        if (!merge(b, hull))
            status = ENF_HULL_NO_MEMORY;
    }
    enf_free(b->link);
    enf_free(b->start_of);
    enf_free(b->triangles);
    enf_free(b->horizon);
    enf_free(b->stack);
    if (status != ENF_HULL_OK)
        enf_hull_free(hull);
    return status;
}

void enf_hull_free(EnfHull *hull) {
    enf_free(hull->face_sizes);
    enf_free(hull->face_indices);
    memset(hull, 0, sizeof *hull);
}
