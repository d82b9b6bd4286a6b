/* SPDX-License-Identifier: GPL-3.0-or-later
 * Proven visibility by plain recursion in space; written apart from the engines. */
#include "sight_truth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CORNERS 96

typedef struct Polygon3 {
    uint32_t n;
    double v[CORNERS][3]; /* relative to the eye */
} Polygon3;

struct SightTruth {
    const EnfScene *scene;
    const SightWalker *walker;
    EnfSceneCounts counts;
    uint32_t *portal_first, *portal_list; /* of cells */
    uint32_t *object_first, *object_list;
    double (*middle)[3];
    uint32_t *cell_stamp, *object_stamp, *on_path, stamp;
    uint32_t cells, objects;
    uint64_t visits, max_visits;
    double eye[3];
    uint32_t start;
    const double (*boxes)[6];
    double view[4][3]; /* unit planes of the view, inward */
    SightWalk walk;
};

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

SightTruth *sight_truth_create(const EnfScene *scene, const SightWalker *walker) {
    SightTruth *t = calloc(1, sizeof *t);
    if (!t)
        return NULL;
    t->scene = scene;
    t->walker = walker;
    t->counts.struct_size = sizeof t->counts;
    enf_scene_counts(scene, &t->counts);
    uint32_t cells = t->counts.cells, portals = t->counts.portals, objects = t->counts.objects;
    t->portal_first = calloc((size_t)cells + 2, sizeof *t->portal_first);
    t->portal_list = calloc(2 * (size_t)portals + 1, sizeof *t->portal_list);
    t->object_first = calloc((size_t)cells + 2, sizeof *t->object_first);
    t->middle = calloc((size_t)cells + 1, sizeof *t->middle);
    t->cell_stamp = calloc((size_t)cells + 1, sizeof *t->cell_stamp);
    t->on_path = calloc((size_t)cells + 1, sizeof *t->on_path);
    t->object_stamp = calloc((size_t)objects + 1, sizeof *t->object_stamp);
    if (!t->portal_first || !t->portal_list || !t->object_first || !t->middle || !t->cell_stamp || !t->on_path || !t->object_stamp) {
        sight_truth_destroy(t);
        return NULL;
    }
    const uint32_t *pairs = enf_scene_portal_cells(scene);
    for (uint32_t i = 0; i < 2 * portals; i++)
        t->portal_first[pairs[i] + 2]++;
    for (uint32_t c = 0; c < cells; c++)
        t->portal_first[c + 2] += t->portal_first[c + 1];
    for (uint32_t i = 0; i < 2 * portals; i++)
        t->portal_list[t->portal_first[pairs[i] + 1]++] = i / 2;
    uint64_t places = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t o = 0; o < objects; o++) {
            const uint32_t *list;
            uint32_t n;
            if (enf_scene_object_cells(scene, o, &list, &n) != ENF_OK)
                continue;
            for (uint32_t i = 0; i < n; i++)
                if (pass == 0) {
                    t->object_first[list[i] + 2]++;
                    places++;
                } else
                    t->object_list[t->object_first[list[i] + 1]++] = o;
        }
        if (pass == 0) {
            for (uint32_t c = 0; c < cells; c++)
                t->object_first[c + 2] += t->object_first[c + 1];
            t->object_list = calloc(places + 1, sizeof *t->object_list);
            if (!t->object_list) {
                sight_truth_destroy(t);
                return NULL;
            }
        }
    }
    const uint32_t *first = enf_scene_cell_vertex_first(scene);
    const double *v = enf_scene_cell_vertices(scene);
    for (uint32_t c = 0; c < cells; c++)
        for (int k = 0; k < 3; k++) {
            double sum = 0;
            uint32_t n = first[c + 1] - first[c];
            for (uint32_t i = 0; i < n; i++)
                sum += v[3 * (size_t)(first[c] + i) + k] / n;
            t->middle[c][k] = n ? sum : NAN;
        }
    return t;
}

void sight_truth_destroy(SightTruth *t) {
    if (!t)
        return;
    free(t->portal_first);
    free(t->portal_list);
    free(t->object_first);
    free(t->object_list);
    free(t->middle);
    free(t->cell_stamp);
    free(t->on_path);
    free(t->object_stamp);
    free(t);
}

/* Keeps n . v >= 0. */
static void cut(Polygon3 *p, const double n[3]) {
    Polygon3 out;
    out.n = 0;
    for (uint32_t i = 0, before = p->n - 1; i < p->n; before = i++) {
        double a = dot(n, p->v[before]), b = dot(n, p->v[i]);
        if ((a >= 0) != (b >= 0) && out.n < CORNERS) {
            double s = a / (a - b);
            for (int k = 0; k < 3; k++)
                out.v[out.n][k] = p->v[before][k] + s * (p->v[i][k] - p->v[before][k]);
            out.n++;
        }
        if (b >= 0 && out.n < CORNERS) {
            memcpy(out.v[out.n], p->v[i], sizeof out.v[0]);
            out.n++;
        }
    }
    p->n = out.n;
    memcpy(p->v, out.v, sizeof out.v[0] * out.n);
}

/* A cone: planes through the eye. */
typedef struct Cone {
    uint32_t n;
    double plane[CORNERS][3];
} Cone;

static void middle_of(const Polygon3 *p, double out[3]) {
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < p->n; i++)
        for (int k = 0; k < 3; k++)
            out[k] += p->v[i][k] / p->n;
}

static void cone_of(const Polygon3 *p, Cone *cone) {
    double middle[3];
    middle_of(p, middle);
    cone->n = 0;
    for (uint32_t i = 0; i < p->n; i++) {
        const double *a = p->v[i], *b = p->v[(i + 1) % p->n];
        double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
        double size = sqrt(dot(n, n));
        if (!(size > 1e-14 * sqrt(dot(a, a) * dot(b, b))))
            continue;
        double sign = dot(n, middle) < 0 ? -1 / size : 1 / size;
        for (int k = 0; k < 3; k++)
            cone->plane[cone->n][k] = sign * n[k];
        cone->n++;
    }
}

/* A proof must lie in the view by more than rounding, whatever found it. */
static int in_view(const SightTruth *t, const double direction[3]) {
    double length = sqrt(dot(direction, direction));
    for (int k = 0; k < 4; k++)
        if (!(dot(t->view[k], direction) > 1e-10 * length))
            return 0;
    return 1;
}

static void prove_cell(SightTruth *t, uint32_t cell, const double direction[3]) {
    if (t->cell_stamp[cell] == t->stamp || !in_view(t, direction))
        return;
    sight_walk(t->walker, t->start, t->eye, direction, INFINITY, &t->walk);
    /* The whole line is proof for all it passes. */
    for (uint32_t i = 0; i < t->walk.cell_count; i++)
        if (t->cell_stamp[t->walk.cells[i]] != t->stamp && t->walk.clearance_at[i] > 2e-10) {
            t->cell_stamp[t->walk.cells[i]] = t->stamp;
            t->cells++;
        }
}

static void prove_object(SightTruth *t, uint32_t object, uint32_t cell, const double at[3]) {
    if (t->object_stamp[object] == t->stamp || !in_view(t, at))
        return;
    sight_walk(t->walker, t->start, t->eye, at, 1 + 1e-9, &t->walk);
    for (uint32_t i = 0; i < t->walk.cell_count; i++)
        if (t->walk.cells[i] == cell && t->walk.t_enter[i] <= 1 + 1e-9) {
            t->object_stamp[object] = t->stamp;
            t->objects++;
            return;
        }
}

static void look_at_objects(SightTruth *t, uint32_t cell, const Cone *cone) {
    static const int faces[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};
    for (uint32_t i = t->object_first[cell]; i < t->object_first[cell + 1]; i++) {
        uint32_t object = t->object_list[i];
        const double *b = t->boxes[object];
        if (t->object_stamp[object] == t->stamp)
            continue;
        int inside = 1;
        for (int k = 0; k < 3; k++)
            inside &= b[k] <= t->eye[k] && t->eye[k] <= b[3 + k];
        if (inside && cell == t->start) {
            t->object_stamp[object] = t->stamp;
            t->objects++;
            continue;
        }
        for (int f = 0; f < 6 && t->object_stamp[object] != t->stamp; f++) {
            Polygon3 p;
            p.n = 4;
            for (int c = 0; c < 4; c++)
                for (int k = 0; k < 3; k++)
                    p.v[c][k] = b[(faces[f][c] >> k & 1) ? 3 + k : k] - t->eye[k];
            for (uint32_t k = 0; k < cone->n && p.n >= 3; k++)
                cut(&p, cone->plane[k]);
            if (p.n < 3)
                continue;
            double at[3];
            middle_of(&p, at);
            prove_object(t, object, cell, at);
        }
    }
}

static void recurse(SightTruth *t, uint32_t cell, uint32_t entered, const Cone *cone, uint32_t depth) {
    const uint32_t *pairs = enf_scene_portal_cells(t->scene), *openings = enf_scene_portal_openings(t->scene);
    const uint32_t *vertex_first = enf_scene_portal_vertex_first(t->scene);
    const double *vertices = enf_scene_portal_vertices(t->scene);
    if (++t->visits > t->max_visits || depth > 400)
        return;
    if (t->boxes)
        look_at_objects(t, cell, cone);
    for (uint32_t i = t->portal_first[cell]; i < t->portal_first[cell + 1]; i++) {
        uint32_t p = t->portal_list[i], to = pairs[2 * p] == cell ? pairs[2 * p + 1] : pairs[2 * p];
        /* A convex cell is never entered twice by one line; only cells without geometry may be. */
        if (p == entered || (t->on_path[to] && !isnan(t->middle[to][0])))
            continue;
        uint32_t kind, state = ENF_STATE_OPEN;
        if (openings[p] != ENF_NONE && enf_scene_opening(t->scene, openings[p], &kind, &state) == ENF_OK && state == ENF_STATE_CLOSED)
            continue;
        Polygon3 polygon;
        polygon.n = vertex_first[p + 1] - vertex_first[p];
        if (polygon.n > CORNERS / 2)
            continue;
        for (uint32_t k = 0; k < polygon.n; k++)
            for (int c = 0; c < 3; c++)
                polygon.v[k][c] = vertices[3 * (size_t)(vertex_first[p] + k) + c] - t->eye[c];
        for (uint32_t k = 0; k < cone->n && polygon.n >= 3; k++)
            cut(&polygon, cone->plane[k]);
        if (polygon.n < 3)
            continue;
        double middle[3];
        middle_of(&polygon, middle);
        /* Forward only: the cell behind lies on the far side of the portal as seen from the eye. */
        if (!isnan(t->middle[to][0])) {
            const double *v = polygon.v[0];
            double a[3], b[3], n[3], ahead[3];
            for (int k = 0; k < 3; k++) {
                const double *q = vertices + 3 * (size_t)vertex_first[p];
                a[k] = q[3 + k] - q[k];
                b[k] = q[6 + k] - q[k];
                ahead[k] = t->middle[to][k] - t->eye[k] - v[k];
            }
            n[0] = a[1] * b[2] - a[2] * b[1];
            n[1] = a[2] * b[0] - a[0] * b[2];
            n[2] = a[0] * b[1] - a[1] * b[0];
            if (dot(n, ahead) * dot(n, middle) < 0)
                continue;
        }
        prove_cell(t, to, middle);
        Cone next;
        cone_of(&polygon, &next);
        if (next.n < 3)
            continue;
        t->on_path[to]++;
        recurse(t, to, p, &next, depth + 1);
        t->on_path[to]--;
    }
}

int sight_truth_find(SightTruth *t, uint32_t start, const EnfCamera *camera, const double (*boxes)[6], uint64_t max_visits) {
    const double *m = camera->world_from_camera;
    Polygon3 view;
    Cone cone;
    t->stamp++;
    t->cells = t->objects = 0;
    t->visits = 0;
    t->max_visits = max_visits;
    t->start = start;
    t->boxes = boxes;
    view.n = 4;
    for (int k = 0; k < 4; k++) {
        double x = ((k == 1 || k == 2 ? 1 : -1) + 2 * camera->shift_x) * tan(camera->angle_x / 2);
        double y = ((k >= 2 ? 1 : -1) + 2 * camera->shift_y) * tan(camera->angle_y / 2);
        for (int r = 0; r < 3; r++)
            view.v[k][r] = x * m[4 * r] + y * m[4 * r + 1] - m[4 * r + 2];
    }
    for (int r = 0; r < 3; r++)
        t->eye[r] = m[4 * r + 3];
    cone_of(&view, &cone);
    memset(t->view, 0, sizeof t->view);
    for (uint32_t k = 0; k < cone.n && k < 4; k++)
        memcpy(t->view[k], cone.plane[k], sizeof t->view[k]);
    t->cell_stamp[start] = t->stamp;
    t->cells = 1;
    t->on_path[start]++;
    recurse(t, start, ENF_NONE, &cone, 0);
    t->on_path[start]--;
    return t->visits <= max_visits;
}

int sight_truth_cell(const SightTruth *t, uint32_t cell) {
    return t->cell_stamp[cell] == t->stamp;
}
int sight_truth_object(const SightTruth *t, uint32_t object) {
    return t->object_stamp[object] == t->stamp;
}
uint32_t sight_truth_cells(const SightTruth *t) {
    return t->cells;
}
uint32_t sight_truth_objects(const SightTruth *t) {
    return t->objects;
}
uint64_t sight_truth_visits(const SightTruth *t) {
    return t->visits;
}
