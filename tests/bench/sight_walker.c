/* SPDX-License-Identifier: GPL-3.0-or-later
 * An oracle that walks lines through portal polygons; written apart from the engines. */
#include "sight_walker.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct SightWalker {
    const EnfScene *scene;
    uint32_t cell_count, portal_count;
    uint32_t *first, *list; /* portals of each cell */
    double (*normal)[3];    /* unit, of either sense */
    double (*middle)[3];    /* of each cell's own vertices; NaN without */
};

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

SightWalker *sight_walker_create(const EnfScene *scene) {
    EnfSceneCounts counts;
    memset(&counts, 0, sizeof counts);
    counts.struct_size = sizeof counts;
    if (enf_scene_counts(scene, &counts) != ENF_OK)
        return NULL;
    SightWalker *w = calloc(1, sizeof *w);
    if (!w)
        return NULL;
    const uint32_t *pairs = enf_scene_portal_cells(scene), *vertex_first = enf_scene_portal_vertex_first(scene);
    const double *vertices = enf_scene_portal_vertices(scene);
    w->scene = scene;
    w->cell_count = counts.cells;
    w->portal_count = counts.portals;
    w->first = calloc((size_t)counts.cells + 2, sizeof *w->first);
    w->list = calloc(2 * (size_t)counts.portals + 1, sizeof *w->list);
    w->normal = calloc((size_t)counts.portals + 1, sizeof *w->normal);
    w->middle = calloc((size_t)counts.cells + 1, sizeof *w->middle);
    if (!w->first || !w->list || !w->normal || !w->middle) {
        sight_walker_destroy(w);
        return NULL;
    }
    for (uint32_t p = 0; p < counts.portals; p++)
        for (int s = 0; s < 2; s++)
            w->first[pairs[2 * p + s] + 2]++;
    for (uint32_t c = 0; c < counts.cells; c++)
        w->first[c + 2] += w->first[c + 1];
    for (uint32_t p = 0; p < counts.portals; p++)
        for (int s = 0; s < 2; s++)
            w->list[w->first[pairs[2 * p + s] + 1]++] = p;
    const uint32_t *cell_first = enf_scene_cell_vertex_first(scene);
    const double *cell_vertices = enf_scene_cell_vertices(scene);
    for (uint32_t c = 0; c < counts.cells; c++) {
        uint32_t n = cell_first[c + 1] - cell_first[c];
        for (int k = 0; k < 3; k++) {
            const double *v = cell_vertices + 3 * (size_t)cell_first[c];
            double sum = 0;
            for (uint32_t i = 0; i < n; i++)
                sum += v[3 * i + k] - v[k];
            w->middle[c][k] = n ? v[k] + sum / n : NAN;
        }
    }
    for (uint32_t p = 0; p < counts.portals; p++) {
        /* The largest triangle of the polygon gives the plane. */
        double most = -1;
        uint32_t a = vertex_first[p], n = vertex_first[p + 1] - a;
        for (uint32_t i = 1; i + 1 < n; i++) {
            const double *o = vertices + 3 * (size_t)a, *u = o + 3 * (size_t)i, *v = u + 3;
            double x[3] = {u[0] - o[0], u[1] - o[1], u[2] - o[2]}, y[3] = {v[0] - o[0], v[1] - o[1], v[2] - o[2]};
            double c[3] = {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
            double size = sqrt(dot(c, c));
            if (size > most) {
                most = size;
                for (int k = 0; k < 3; k++)
                    w->normal[p][k] = size > 0 ? c[k] / size : 0;
            }
        }
    }
    return w;
}

void sight_walker_destroy(SightWalker *w) {
    if (!w)
        return;
    free(w->first);
    free(w->list);
    free(w->normal);
    free(w->middle);
    free(w);
}

/* Where the line meets the portal's plane, and the least distance inside of its edges (negative: outside). */
static int hit_portal(const SightWalker *w, uint32_t p, const double eye[3], const double d[3], double *t, double *inside) {
    const uint32_t *vertex_first = enf_scene_portal_vertex_first(w->scene);
    const double *v = enf_scene_portal_vertices(w->scene) + 3 * (size_t)vertex_first[p];
    uint32_t n = vertex_first[p + 1] - vertex_first[p];
    const double *normal = w->normal[p];
    double rate = dot(normal, d), from[3] = {v[0] - eye[0], v[1] - eye[1], v[2] - eye[2]};
    if (fabs(rate) < 1e-14 * sqrt(dot(d, d)))
        return 0;
    *t = dot(normal, from) / rate;
    double at[3] = {eye[0] + *t * d[0], eye[1] + *t * d[1], eye[2] + *t * d[2]}, least = INFINITY, most = INFINITY;
    for (uint32_t i = 0; i < n; i++) {
        const double *a = v + 3 * (size_t)i, *b = v + 3 * (size_t)((i + 1) % n);
        double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, q[3] = {at[0] - a[0], at[1] - a[1], at[2] - a[2]};
        double c[3] = {e[1] * q[2] - e[2] * q[1], e[2] * q[0] - e[0] * q[2], e[0] * q[1] - e[1] * q[0]};
        double length = sqrt(dot(e, e));
        if (!(length > 0))
            continue;
        double distance = dot(c, normal) / length;
        least = fmin(least, distance);
        most = fmin(most, -distance);
    }
    *inside = fmax(least, most); /* either winding */
    return 1;
}

void sight_walk(const SightWalker *w, uint32_t start, const double eye[3], const double d[3], double t_max, SightWalk *out) {
    const uint32_t *pairs = enf_scene_portal_cells(w->scene), *openings = enf_scene_portal_openings(w->scene);
    double length = sqrt(dot(d, d)), t = 0;
    uint32_t cell = start, entered = ENF_NONE;
    out->cell_count = 1;
    out->cells[0] = start;
    out->clearance = out->clearance_at[0] = INFINITY;
    out->t_enter[0] = 0;
    while (out->cell_count < 512) {
        double best_t = INFINITY, best_inside = -1;
        uint32_t best = ENF_NONE;
        for (uint32_t i = w->first[cell]; i < w->first[cell + 1]; i++) {
            uint32_t p = w->list[i];
            double at, inside;
            if (p == entered || !hit_portal(w, p, eye, d, &at, &inside) || inside < 0 || at < t || at > t_max)
                continue;
            /* Out of the cell, into the other: a line that has left a hub through a wall may meet a window from within. */
            uint32_t to = pairs[2 * p] == cell ? pairs[2 * p + 1] : pairs[2 * p];
            double ahead[3], sense = 0;
            for (int k = 0; k < 3; k++)
                ahead[k] = w->middle[to][k] - (eye[k] + at * d[k]);
            sense = dot(w->normal[p], ahead) * dot(w->normal[p], d);
            if (sense < 0)
                continue;
            if (at < best_t) {
                best_t = at;
                best = p;
                best_inside = inside;
            }
        }
        if (best == ENF_NONE)
            return;
        if (openings[best] != ENF_NONE) {
            uint32_t kind, state;
            if (enf_scene_opening(w->scene, openings[best], &kind, &state) != ENF_OK || state == ENF_STATE_CLOSED)
                return;
        }
        t = best_t;
        /* Foreshortened: what the edge's distance in the plane means as an angle. */
        double slant = fabs(dot(w->normal[best], d)) / length;
        double angle = t > 0 ? best_inside * slant / (t * length) : INFINITY;
        out->clearance = fmin(out->clearance, angle);
        cell = pairs[2 * best] == cell ? pairs[2 * best + 1] : pairs[2 * best];
        entered = best;
        out->portals[out->cell_count - 1] = best;
        out->cells[out->cell_count] = cell;
        out->clearance_at[out->cell_count] = out->clearance;
        out->t_enter[out->cell_count++] = t;
    }
}

uint64_t sight_next(SightRng *rng) {
    uint64_t z = (rng->state += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
}

double sight_unit(SightRng *rng) {
    return (double)(sight_next(rng) >> 11) * (1.0 / 9007199254740992.0);
}

static void combine(SightRng *rng, const double *vertices, uint32_t count, uint32_t used, double out[3]) {
    double sum = 0, at[3] = {0, 0, 0};
    const double *origin = vertices; /* differences first: far from the origin sums would round */
    for (uint32_t i = 0; i < used; i++) {
        const double *v = used == count ? vertices + 3 * (size_t)i : vertices + 3 * (size_t)(sight_next(rng) % count);
        double weight = -log(1 - sight_unit(rng));
        sum += weight;
        for (int k = 0; k < 3; k++)
            at[k] += weight * (v[k] - origin[k]);
    }
    for (int k = 0; k < 3; k++)
        out[k] = origin[k] + (sum > 0 ? at[k] / sum : 0);
}

int sight_point_in_cell(const SightWalker *w, SightRng *rng, uint32_t cell, int degenerate, double out[3]) {
    const uint32_t *cell_first = enf_scene_cell_vertex_first(w->scene);
    const uint32_t *portal_first = enf_scene_portal_vertex_first(w->scene);
    const double *cell_vertices = enf_scene_cell_vertices(w->scene), *portal_vertices = enf_scene_portal_vertices(w->scene);
    uint32_t n = cell_first[cell + 1] - cell_first[cell], portals = w->first[cell + 1] - w->first[cell];
    if (degenerate && portals && (n == 0 || sight_unit(rng) < 0.7)) {
        uint32_t p = w->list[w->first[cell] + sight_next(rng) % portals], count = portal_first[p + 1] - portal_first[p];
        const double *v = portal_vertices + 3 * (size_t)portal_first[p];
        switch (sight_next(rng) % 4) {
        case 0:
            combine(rng, v, count, count, out);
            break; /* on the portal */
        case 1:
            memcpy(out, v + 3 * (sight_next(rng) % count), 3 * sizeof *out);
            break; /* its corner */
        default: { /* on an edge */
            uint32_t a = (uint32_t)(sight_next(rng) % count), b = (a + 1) % count;
            double s = sight_unit(rng);
            for (int k = 0; k < 3; k++)
                out[k] = v[3 * a + k] + s * (v[3 * b + k] - v[3 * a + k]);
        }
        }
        return 1;
    }
    if (n) {
        const double *v = cell_vertices + 3 * (size_t)cell_first[cell];
        if (degenerate)
            combine(rng, v, n, 1 + (uint32_t)(sight_next(rng) % 3), out); /* corner, edge or diagonal, face */
        else
            combine(rng, v, n, n, out);
        return 1;
    }
    if (!portals)
        return 0;
    /* Any mixture of the portals' corners. */
    double sum = 0, at[3] = {0, 0, 0};
    const double *origin = portal_vertices + 3 * (size_t)portal_first[w->list[w->first[cell]]];
    for (uint32_t i = w->first[cell]; i < w->first[cell + 1]; i++)
        for (uint32_t k = portal_first[w->list[i]]; k < portal_first[w->list[i] + 1]; k++) {
            double weight = -log(1 - sight_unit(rng));
            sum += weight;
            for (int c = 0; c < 3; c++)
                at[c] += weight * (portal_vertices[3 * (size_t)k + c] - origin[c]);
        }
    for (int c = 0; c < 3; c++)
        out[c] = origin[c] + at[c] / sum;
    return 1;
}

int sight_meets_box(const double eye[3], const double d[3], double t0, double t1, const double b[6]) {
    for (int c = 0; c < 3; c++) {
        double slack = 1e-9 * (b[3 + c] - b[c]) + 1e-12 * fabs(b[c]), lo = b[c] + slack, hi = b[3 + c] - slack;
        if (lo > hi)
            return 0;
        if (d[c] == 0) {
            if (eye[c] < lo || eye[c] > hi)
                return 0;
            continue;
        }
        double a = (lo - eye[c]) / d[c], e = (hi - eye[c]) / d[c];
        t0 = fmax(t0, fmin(a, e));
        t1 = fmin(t1, fmax(a, e));
    }
    return t0 < t1;
}
