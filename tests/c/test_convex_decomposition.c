/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rooms cut into convex cells. Oracles: volumes and areas by formula, random points by an even-odd test of
 * the outline, and the balance "all faces of all cells = the room's surface + twice the seams". */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "memory_kit.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/convex_decomposition.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static uint64_t seed;
static double random_unit(void) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) / 9007199254740992.0;
}

enum { MOST = 400 };
typedef struct Outline {
    double xy[MOST][2];
    uint32_t sizes[16];
    uint32_t rings, total;
} Outline;

static void ring(Outline *o, const double (*xy)[2], uint32_t n) {
    memcpy(o->xy + o->total, xy, n * sizeof *xy);
    o->sizes[o->rings++] = n;
    o->total += n;
}

static double outline_area(const Outline *o) {
    double area = 0.0;
    uint32_t first = 0;
    for (uint32_t r = 0; r < o->rings; first += o->sizes[r++]) {
        double a = 0.0;
        for (uint32_t i = 0; i < o->sizes[r]; i++) {
            const double *p = o->xy[first + i], *q = o->xy[first + (i + 1) % o->sizes[r]];
            a += 0.5 * (p[0] * q[1] - p[1] * q[0]);
        }
        area += r == 0 ? fabs(a) : -fabs(a);
    }
    return area;
}

static double outline_length(const Outline *o) {
    double length = 0.0;
    uint32_t first = 0;
    for (uint32_t r = 0; r < o->rings; first += o->sizes[r++])
        for (uint32_t i = 0; i < o->sizes[r]; i++) {
            const double *p = o->xy[first + i], *q = o->xy[first + (i + 1) % o->sizes[r]];
            length += hypot(q[0] - p[0], q[1] - p[1]);
        }
    return length;
}

static int outline_holds(const Outline *o, double x, double y) {
    int inside = 0;
    uint32_t first = 0;
    for (uint32_t r = 0; r < o->rings; first += o->sizes[r++])
        for (uint32_t i = 0, j = o->sizes[r] - 1; i < o->sizes[r]; j = i++) {
            const double *p = o->xy[first + i], *q = o->xy[first + j];
            if ((p[1] > y) != (q[1] > y) && x < q[0] + (p[0] - q[0]) * (y - q[1]) / (p[1] - q[1]))
                inside = !inside;
        }
    return inside;
}

static double outline_distance(const Outline *o, double x, double y) {
    double best = DBL_MAX;
    uint32_t first = 0;
    for (uint32_t r = 0; r < o->rings; first += o->sizes[r++])
        for (uint32_t i = 0; i < o->sizes[r]; i++) {
            const double *p = o->xy[first + i], *q = o->xy[first + (i + 1) % o->sizes[r]];
            double dx = q[0] - p[0], dy = q[1] - p[1], t = ((x - p[0]) * dx + (y - p[1]) * dy) / fmax(dx * dx + dy * dy, 1e-300);
            t = fmin(1.0, fmax(0.0, t));
            best = fmin(best, hypot(x - p[0] - t * dx, y - p[1] - t * dy));
        }
    return best;
}

typedef struct Measure {
    double volume, face_area, seam_area;
    int convex;
} Measure;

static double polygon_area(const double (*p)[3], const uint32_t *index, uint32_t n, double normal[3]) {
    double sum[3] = {0, 0, 0};
    for (uint32_t i = 1; i + 1 < n; i++) {
        double a[3], b[3], c[3];
        vec_sub(a, p[index ? index[i] : i], p[index ? index[0] : 0]);
        vec_sub(b, p[index ? index[i + 1] : i + 1], p[index ? index[0] : 0]);
        vec_cross(c, a, b);
        vec_add(sum, sum, c);
    }
    vec_copy(normal, sum);
    return 0.5 * vec_normalize(normal);
}

static Measure measure(const EnfDecomposition *d) {
    Measure m = {0, 0, 0, 1};
    const uint32_t *index = d->face_indices;
    for (uint32_t c = 0; c < d->cell_count; c++) {
        const double(*p)[3] = (const double(*)[3])(d->points + d->cell_point_first[c]);
        uint32_t points = d->cell_point_first[c + 1] - d->cell_point_first[c];
        for (uint32_t f = d->cell_face_first[c]; f < d->cell_face_first[c + 1]; index += d->face_sizes[f++]) {
            double n[3], local[3];
            double area = polygon_area(p, index, d->face_sizes[f], n);
            m.face_area += area;
            vec_sub(local, p[index[0]], p[0]);
            m.volume += area * vec_dot(n, local) / 3.0;
            for (uint32_t i = 0; i < points; i++) {
                vec_sub(local, p[i], p[index[0]]);
                if (vec_dot(n, local) > 1e-5)
                    m.convex = 0;
            }
        }
    }
    for (uint32_t i = 0; i < d->seam_count; i++) {
        double n[3];
        m.seam_area += polygon_area((const double(*)[3])(d->seam_points + d->seams[i].first), NULL, d->seams[i].count, n);
    }
    return m;
}

/* How many cells hold a point, `margin` metres inside of all faces. */
static uint32_t cells_holding(const EnfDecomposition *d, const double point[3], double margin) {
    uint32_t count = 0;
    const uint32_t *index = d->face_indices;
    for (uint32_t c = 0; c < d->cell_count; c++) {
        const double(*p)[3] = (const double(*)[3])(d->points + d->cell_point_first[c]);
        int inside = 1;
        for (uint32_t f = d->cell_face_first[c]; f < d->cell_face_first[c + 1]; index += d->face_sizes[f++]) {
            double n[3], local[3];
            polygon_area(p, index, d->face_sizes[f], n);
            vec_sub(local, point, p[index[0]]);
            inside &= vec_dot(n, local) < -margin;
        }
        count += (uint32_t)inside;
    }
    return count;
}

/* Every seam lies on the boundary of both its cells, and they lie on different sides of it. */
static void check_seams(const EnfDecomposition *d, double tolerance) {
    for (uint32_t i = 0; i < d->seam_count; i++) {
        const EnfSeam *seam = &d->seams[i];
        const double(*s)[3] = (const double(*)[3])(d->seam_points + seam->first);
        double n[3];
        assert_true(polygon_area(s, NULL, seam->count, n) > 0.0);
        for (int side = 0; side < 2; side++) {
            uint32_t c = seam->cells[side], first = d->cell_point_first[c];
            double low = 1e300, high = -1e300;
            for (uint32_t v = first; v < d->cell_point_first[c + 1]; v++) {
                double local[3];
                vec_sub(local, d->points[v], s[0]);
                low = fmin(low, vec_dot(n, local));
                high = fmax(high, vec_dot(n, local));
            }
            /* counter-clockwise seen from cells[0]: the normal points into it */
            if (side == 0)
                assert_true(low > -tolerance && high > tolerance);
            else
                assert_true(high < tolerance && low < -tolerance);
        }
    }
}

static double cell_volume(const EnfDecomposition *d, uint32_t cell) {
    const uint32_t *index = d->face_indices;
    double volume = 0.0;
    for (uint32_t f = 0; f < d->cell_face_first[cell + 1]; index += d->face_sizes[f++]) {
        if (f < d->cell_face_first[cell])
            continue;
        const double(*p)[3] = (const double(*)[3])(d->points + d->cell_point_first[cell]);
        double n[3], local[3], area = polygon_area(p, index, d->face_sizes[f], n);
        vec_sub(local, p[index[0]], p[0]);
        volume += area * vec_dot(n, local) / 3.0;
    }
    return volume;
}

/* All cells hang together by seams, but slivers of a volume below `sliver` m3. */
static void check_connected(const EnfDecomposition *d, double sliver) {
    uint32_t *group = calloc(d->cell_count, sizeof *group), root = UINT32_MAX;
    for (uint32_t c = 0; c < d->cell_count; c++)
        group[c] = c;
    for (uint32_t round = 0; round < d->cell_count; round++)
        for (uint32_t i = 0; i < d->seam_count; i++) {
            uint32_t a = d->seams[i].cells[0], b = d->seams[i].cells[1];
            group[a] = group[b] = group[a] < group[b] ? group[a] : group[b];
        }
    for (uint32_t c = 0; c < d->cell_count; c++) {
        if (sliver > 0.0 && cell_volume(d, c) < sliver)
            continue;
        if (root == UINT32_MAX)
            root = group[c];
        assert_int_equal(group[c], root);
    }
    free(group);
}

/* Decomposes as a prism, checks everything, gives the number of cells. */
static uint32_t check_prism(const Outline *o, double z0, double z1) {
    EnfDecomposition d;
    assert_int_equal(enf_decompose_prism(&d, o->xy[0], o->sizes, o->rings, z0, z1), ENF_OK);
    assert_int_equal(d.gave_up, 0);
    double volume = outline_area(o) * (z1 - z0), surface = 2.0 * outline_area(o) + outline_length(o) * (z1 - z0);
    Measure m = measure(&d);
    assert_true(m.convex);
    if (d.facets) { /* the room grew, and no deeper than it says */
        assert_true(d.depth > 0.0 && d.depth <= ENF_CURVE_DEPTH_METRES);
        assert_true(m.volume > volume && m.volume <= volume + d.depth * outline_length(o) * (z1 - z0));
    } else {
        assert_true(fabs(m.volume - volume) <= 1e-9 * volume);
        assert_true(fabs(m.face_area - surface - 2.0 * m.seam_area) <= 1e-7 * surface);
    }
    check_seams(&d, 1e-6);
    check_connected(&d, 0.0);
    for (int k = 0; k < 500; k++) {
        double box[4] = {1e300, 1e300, -1e300, -1e300};
        for (uint32_t i = 0; i < o->total; i++) {
            box[0] = fmin(box[0], o->xy[i][0]);
            box[1] = fmin(box[1], o->xy[i][1]);
            box[2] = fmax(box[2], o->xy[i][0]);
            box[3] = fmax(box[3], o->xy[i][1]);
        }
        double p[3] = {box[0] + random_unit() * (box[2] - box[0]), box[1] + random_unit() * (box[3] - box[1]),
                       z0 + (0.01 + 0.98 * random_unit()) * (z1 - z0)};
        uint32_t strict = cells_holding(&d, p, 1e-6), loose = cells_holding(&d, p, -1e-6);
        if (outline_holds(o, p[0], p[1])) {
            assert_true(strict <= 1);
            assert_true(loose >= 1);
        } else if (outline_distance(o, p[0], p[1]) > d.depth)
            assert_int_equal(strict, 0);
    }
    uint32_t cells = d.cell_count;
    enf_decomposition_free(&d);
    return cells;
}

static const double square[4][2] = {{0, 0}, {8, 0}, {8, 6}, {0, 6}};

static void a_convex_room_stays_one_cell(void **state) {
    (void)state;
    Outline o = {0};
    ring(&o, square, 4);
    assert_int_equal(check_prism(&o, 0, 2.5), 1);
    Outline round = {0};
    double xy[32][2];
    for (int i = 0; i < 32; i++) {
        xy[i][0] = 5 * cos(2 * PI * i / 32);
        xy[i][1] = 5 * sin(2 * PI * i / 32);
    }
    ring(&round, (const double(*)[2])xy, 32);
    assert_int_equal(check_prism(&round, 0, 3), 1);
}

static void l_u_t_and_plus_shapes_give_the_fewest_cells(void **state) {
    (void)state;
    static const double l[6][2] = {{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 5}, {0, 5}};
    static const double u[8][2] = {{0, 0}, {6, 0}, {6, 4}, {4, 4}, {4, 1}, {2, 1}, {2, 4}, {0, 4}};
    static const double t[8][2] = {{0, 4}, {6, 4}, {6, 6}, {0, 6}, {0, 4}, {0, 4}, {0, 4}, {0, 4}};
    static const double tee[8][2] = {{2, 0}, {4, 0}, {4, 4}, {6, 4}, {6, 6}, {0, 6}, {0, 4}, {2, 4}};
    static const double plus[12][2] = {{2, 0}, {4, 0}, {4, 2}, {6, 2}, {6, 4}, {4, 4}, {4, 6}, {2, 6}, {2, 4}, {0, 4}, {0, 2}, {2, 2}};
    Outline a = {0}, b = {0}, c = {0}, d = {0}, e = {0};
    ring(&a, l, 6);
    ring(&b, u, 8);
    ring(&c, tee, 8);
    ring(&d, plus, 12);
    ring(&e, t, 8); /* corners that repeat */
    assert_int_equal(check_prism(&a, 0, 2.5), 2);
    assert_int_equal(check_prism(&b, 0, 2.5), 3);
    assert_int_equal(check_prism(&c, 0, 2.5), 2);
    assert_int_equal(check_prism(&d, 0, 2.5), 3);
    assert_int_equal(check_prism(&e, 0, 2.5), 1);
}

static void a_ring_room_round_a_column_gives_four_cells(void **state) {
    (void)state;
    static const double column[4][2] = {{3, 2}, {5, 2}, {5, 4}, {3, 4}};
    Outline o = {0};
    ring(&o, square, 4);
    ring(&o, column, 4);
    assert_int_equal(check_prism(&o, 0, 2.5), 4);
}

static void a_round_column_costs_a_few_cells(void **state) {
    (void)state;
    /* radius, facets, cells at most: as many as chords that are 5 cm deep; the last is square, its corners stay */
    static const struct {
        double radius;
        int facets;
        uint32_t cells;
    } columns[] = {{1.0, 32, 11}, {0.3, 32, 7}, {0.15, 24, 4}, {1.0, 9, 9}, {0.15, 8, 4}, {0.02, 4, 4}};
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
        for (int turned = 0; turned < 2; turned++) { /* rings wind either way */
            Outline o = {0};
            double xy[32][2];
            int n = columns[k].facets;
            ring(&o, square, 4);
            for (int i = 0; i < n; i++) {
                double angle = (turned ? -2 : 2) * PI * (i + 0.3) / n;
                xy[i][0] = 4 + columns[k].radius * cos(angle);
                xy[i][1] = 3 + columns[k].radius * sin(angle);
            }
            ring(&o, (const double(*)[2])xy, (uint32_t)n);
            uint32_t cells = check_prism(&o, 0, 2.5);
            printf("column of radius %g with %d facets: %u cells\n", columns[k].radius, n, cells);
            assert_true(cells <= columns[k].cells);
        }
}

/* A wall bulging into the room with 32 facets, and an L at the far end. Gives the number of corners. */
static uint32_t bulge(double (*xy)[2]) {
    uint32_t n = 0;
    static const double rest[][2] = {{12, 0}, {12, 8}, {6, 8}, {6, 6}, {0, 6}, {0, 0}};
    for (int i = 0; i <= 32; i++) {
        double a = PI - PI * i / 32;
        xy[n][0] = 4 + 2 * cos(a);
        xy[n++][1] = 2 * sin(a) * 0.9;
    }
    for (int i = 0; i < 6; i++, n++)
        memcpy(xy[n], rest[i], sizeof *xy);
    return n;
}

static void a_curved_wall_does_not_shatter_the_rest(void **state) {
    (void)state;
    Outline o = {0};
    double xy[40][2];
    ring(&o, (const double(*)[2])xy, bulge(xy));
    uint32_t cells = check_prism(&o, 0, 3);
    printf("bulge of 32 facets and an L: %u cells\n", cells);
    assert_true(cells <= 13);
}

/* A staircase outline up and down; `step` scales how much the stairs differ. Gives the number of corners. */
static uint32_t random_outline(double (*xy)[2], uint32_t steps, double step) {
    uint32_t n = 0;
    double x = 0;
    xy[n][0] = 0;
    xy[n++][1] = 0;
    for (uint32_t i = 0; i < steps; i++) {
        double y = 3 + floor(6 * random_unit()) * step;
        xy[n][0] = x;
        xy[n++][1] = -y;
        x += 1 + floor(3 * random_unit()) * step;
        xy[n][0] = x;
        xy[n++][1] = -y;
    }
    for (uint32_t i = 0; i < steps; i++) {
        double y = 3 + floor(6 * random_unit()) * step;
        xy[n][0] = x;
        xy[n++][1] = y;
        x = i + 1 == steps ? 0 : x - (x > (double)(steps - i) ? 1 : 0.5);
        xy[n][0] = x;
        xy[n++][1] = y;
    }
    return n;
}

static void random_rectilinear_rooms_keep_their_volume(void **state) {
    (void)state;
    seed = 5;
    uint32_t most = 0;
    for (int round = 0; round < 200; round++) {
        Outline o = {0};
        double xy[MOST][2];
        uint32_t steps = 1 + (uint32_t)(8 * random_unit()), n = random_outline(xy, steps, 1.0);
        double turn = round % 3 ? 2 * PI * random_unit() : 0.0;
        for (uint32_t i = 0; i < n; i++) {
            double px = xy[i][0], py = xy[i][1];
            xy[i][0] = px * cos(turn) - py * sin(turn);
            xy[i][1] = px * sin(turn) + py * cos(turn);
        }
        ring(&o, (const double(*)[2])xy, n);
        uint32_t cells = check_prism(&o, 0, 3);
        if (cells > most)
            most = cells;
        assert_true(cells <= 3 * steps + 2);
    }
    printf("random rectilinear rooms: at most %u cells\n", most);
}

/* A prism as a polyhedron: bottom and top as one (non-convex) polygon each; moved and turned. */
typedef struct Solid {
    double v[2 * MOST][3];
    uint32_t sizes[MOST + 2], indices[8 * MOST];
    uint32_t vertices, faces, count;
} Solid;

static void face(Solid *s, uint32_t n, const uint32_t *index) {
    s->sizes[s->faces++] = n;
    memcpy(s->indices + s->count, index, n * sizeof *index);
    s->count += n;
}

static void extrude(Solid *s, const double (*xy)[2], uint32_t n, const double (*z)[2]) {
    uint32_t bottom[MOST], top[MOST];
    memset(s, 0, sizeof *s);
    for (uint32_t i = 0; i < n; i++) {
        vec_set(s->v[2 * i], xy[i][0], xy[i][1], z[i][0]);
        vec_set(s->v[2 * i + 1], xy[i][0], xy[i][1], z[i][1]);
        bottom[i] = 2 * (n - 1 - i);
        top[i] = 2 * i + 1;
    }
    s->vertices = 2 * n;
    face(s, n, bottom);
    face(s, n, top);
    for (uint32_t i = 0; i < n; i++) {
        uint32_t j = (i + 1) % n, quad[4] = {2 * i, 2 * j, 2 * j + 1, 2 * i + 1};
        face(s, 4, quad);
    }
}

static void move(Solid *s, double angle, double tilt, const double by[3], double scale) {
    for (uint32_t i = 0; i < s->vertices; i++) {
        double *p = s->v[i], x = p[0] * cos(angle) - p[1] * sin(angle), y = p[0] * sin(angle) + p[1] * cos(angle);
        double z = y * sin(tilt) + p[2] * cos(tilt);
        y = y * cos(tilt) - p[2] * sin(tilt);
        vec_set(p, scale * x + by[0], scale * y + by[1], scale * z + by[2]);
    }
}

static uint32_t check_solid(Solid *s, double volume, double tolerance) {
    EnfDecomposition d;
    assert_int_equal(enf_decompose_polyhedron(&d, s->v, s->vertices, s->sizes, s->faces, s->indices), ENF_OK);
    assert_int_equal(d.not_closed, 0);
    assert_int_equal(d.gave_up, 0);
    Measure m = measure(&d);
    assert_true(m.convex);
    assert_true(fabs(m.volume - volume) <= tolerance * volume);
    double surface = 0.0, n[3];
    const uint32_t *index = s->indices;
    for (uint32_t f = 0; f < s->faces; index += s->sizes[f++])
        surface += polygon_area((const double(*)[3])s->v, index, s->sizes[f], n);
    assert_true(fabs(m.face_area - surface - 2.0 * m.seam_area) <= 1e-6 * surface);
    check_connected(&d, 0.0);
    uint32_t cells = d.cell_count;
    enf_decomposition_free(&d);
    return cells;
}

static void polyhedra_far_away_turned_and_scaled_give_the_same_cells(void **state) {
    (void)state;
    static const double u[8][2] = {{0, 0}, {6, 0}, {6, 4}, {4, 4}, {4, 1}, {2, 1}, {2, 4}, {0, 4}};
    static const double z[8][2] = {{0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}};
    static const double moves[][3] = {{0, 0, 0}, {1e4, -2e4, 50}, {1e7, 5e6, 300}};
    seed = 9;
    for (int k = 0; k < 60; k++) {
        Solid s;
        double scale = k % 4 == 0 ? 1e-3 : k % 4 == 1 ? 1e3 : 1.0;
        const double *by = moves[k % 3];
        /* A millimetre house 10,000 km away has no digits left to be judged by. */
        if (scale < 1.0 && by[0] > 1e5)
            continue;
        extrude(&s, u, 8, z);
        move(&s, 2 * PI * random_unit(), k % 5 ? 0.0 : random_unit(), by, scale);
        assert_int_equal(check_solid(&s, (24.0 - 6.0) * 3.0 * scale * scale * scale, by[0] > 1e5 ? 1e-7 : 1e-9), 3);
    }
}

static void a_sloped_roof_over_an_l_is_followed(void **state) {
    (void)state;
    /* The roof z = 3 + x / 4 is one plane over the whole L. */
    static const double l[6][2] = {{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 5}, {0, 5}};
    double z[6][2];
    for (int i = 0; i < 6; i++) {
        z[i][0] = 0;
        z[i][1] = 3 + l[i][0] / 4;
    }
    Solid s;
    extrude(&s, l, 6, (const double(*)[2])z);
    /* 4 x 2 at mean x 2 and 2 x 3 at mean x 1 */
    assert_int_equal(check_solid(&s, 8 * 3.5 + 6 * 3.25, 1e-9), 2);
}

static void a_curved_wall_below_a_slope_is_straightened_too(void **state) {
    (void)state;
    double xy[40][2], z[40][2], area[2] = {0, 0};
    uint32_t n = bulge(xy);
    for (int wavy = 0; wavy < 2; wavy++) {
        for (uint32_t i = 0; i < n; i++) {
            z[i][0] = 0;
            z[i][1] = 3 + 0.1 * xy[i][0] + 0.2 * xy[i][1] + (wavy ? 0.02 * (i % 2) : 0.0); /* a ceiling that isn't flat there */
        }
        Solid s;
        EnfDecomposition d;
        extrude(&s, (const double(*)[2])xy, n, (const double(*)[2])z);
        move(&s, 0.7, 0.0, (const double[3]){5e5, 5e6, 0}, 1.0);
        assert_int_equal(enf_decompose_polyhedron(&d, s.v, s.vertices, s.sizes, s.faces, s.indices), ENF_OK);
        assert_int_equal(d.not_closed + d.gave_up, 0);
        Measure m = measure(&d);
        assert_true(m.convex && (wavy ? d.facets == 0 : d.facets >= 30 && d.cell_count <= 13));
        area[wavy] = m.volume;
        check_connected(&d, 0.0);
        enf_decomposition_free(&d);
    }
    assert_true(area[0] > 0.0 && area[1] > 0.0);
}

static void a_wall_thinner_than_a_chord_is_deep_stays_as_it_is(void **state) {
    (void)state;
    /* A curved screen of 2 cm in the middle of a room: a chord on its hollow side's back would cross its front. */
    double xy[2 * 9 + 6][2];
    uint32_t n = 0;
    Outline o = {0};
    ring(&o, square, 4);
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < 9; i++) {
            double angle = PI * (side ? 8 - i : i) / 16, radius = side ? 0.98 : 1.0;
            xy[n][0] = 3 + radius * cos(angle);
            xy[n++][1] = 2 + radius * sin(angle);
        }
    ring(&o, (const double(*)[2])xy, n);
    EnfDecomposition d;
    assert_int_equal(enf_decompose_prism(&d, o.xy[0], o.sizes, o.rings, 0, 3), ENF_OK);
    assert_int_equal(d.gave_up, 0);
    assert_int_equal(d.facets, 0);
    enf_decomposition_free(&d);
}

static void a_stepped_ceiling_gives_two_cells(void **state) {
    (void)state;
    /* The section is an L, drawn as a prism lying on its side. */
    static const double l[6][2] = {{0, 0}, {6, 0}, {6, 2.5}, {3, 2.5}, {3, 4}, {0, 4}};
    static const double z[6][2] = {{0, 5}, {0, 5}, {0, 5}, {0, 5}, {0, 5}, {0, 5}};
    Solid s;
    double zero[3] = {0, 0, 0};
    extrude(&s, l, 6, z);
    move(&s, 0.0, PI / 2, zero, 1.0);
    assert_int_equal(check_solid(&s, (15 + 4.5) * 5, 1e-9), 2);
}

static void single_precision_and_split_edges_do_not_matter(void **state) {
    (void)state;
    static const double l[6][2] = {{0.1, 0.1}, {4.3, 0.1}, {4.3, 2.7}, {2.2, 2.7}, {2.2, 5.9}, {0.1, 5.9}};
    static const double z[6][2] = {{0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}};
    seed = 3;
    for (int k = 0; k < 40; k++) {
        Solid s;
        double by[3] = {50 * random_unit(), 50 * random_unit(), 10};
        extrude(&s, l, 6, z);
        /* The floor polygon alone knows a corner in the middle of one of its edges. */
        vec_set(s.v[12], 1.7, 0.1, 0);
        s.vertices = 13;
        memmove(s.indices + 6, s.indices + 5, (s.count - 5) * sizeof *s.indices);
        s.indices[5] = 12; /* bottom: 10 8 6 4 2 [12] 0 */
        s.sizes[0] = 7;
        s.count++;
        move(&s, 2 * PI * random_unit(), 0.0, by, 1.0);
        for (uint32_t i = 0; i < s.vertices; i++)
            for (int c = 0; c < 3; c++)
                s.v[i][c] = (float)s.v[i][c];
        assert_int_equal(check_solid(&s, (4.2 * 2.6 + 2.1 * 3.2) * 3, 1e-5), 2);
    }
}

static void noise_of_single_precision_and_stairs_of_its_size_keep_the_volume(void **state) {
    (void)state;
    /* Rounded to float at up to 1 km from the origin (60 micrometres), and stairs of 20 micrometres in 10 m
     * rooms: at and below the decomposition's resolution, where pieces are slivers. */
    static const double offsets[] = {20.0, 1000.0, 20.0}, steps_of[] = {1.0, 1.0, 2e-5};
    seed = 77;
    for (int k = 0; k < 300; k++) {
        Solid s;
        double xy[MOST][2], z[MOST][2];
        double off = offsets[k % 3], by[3] = {off * random_unit(), off * random_unit(), 10};
        uint32_t n = random_outline(xy, 1 + (uint32_t)(8 * random_unit()), steps_of[k % 3]);
        for (uint32_t i = 0; i < n; i++) {
            z[i][0] = 0;
            z[i][1] = 3;
        }
        extrude(&s, (const double(*)[2])xy, n, (const double(*)[2])z);
        move(&s, 2 * PI * random_unit(), k % 2 ? random_unit() : 0.0, by, 1.0);
        for (uint32_t i = 0; i < s.vertices; i++)
            for (int c = 0; c < 3; c++)
                s.v[i][c] = (float)s.v[i][c];
        EnfDecomposition d;
        assert_int_equal(enf_decompose_polyhedron(&d, s.v, s.vertices, s.sizes, s.faces, s.indices), ENF_OK);
        assert_int_equal(d.not_closed, 0);
        assert_int_equal(d.gave_up, 0);
        /* as written, corners welded: within the resolution times the walls */
        assert_true(fabs(measure(&d).volume - d.shape_volume) < 1e-3 * d.shape_volume);
        assert_true(fabs(d.volume - d.shape_volume) < 1e-4 * d.shape_volume);
        check_connected(&d, 2e-3);
        enf_decomposition_free(&d);
    }
}

static void an_open_or_crossing_shape_becomes_its_hull(void **state) {
    (void)state;
    static const double l[6][2] = {{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 5}, {0, 5}};
    static const double z[6][2] = {{0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3}};
    Solid s;
    extrude(&s, l, 6, z);
    s.faces--; /* one wall is missing */
    EnfDecomposition d;
    assert_int_equal(enf_decompose_polyhedron(&d, s.v, s.vertices, s.sizes, s.faces, s.indices), ENF_OK);
    assert_int_equal(d.cell_count, 1);
    assert_int_equal(d.not_closed, 4);
    enf_decomposition_free(&d);
    static const double bow[4][2] = {{0, 0}, {4, 4}, {4, 0}, {0, 4}};
    uint32_t four = 4;
    assert_int_equal(enf_decompose_prism(&d, bow[0], &four, 1, 0, 1), ENF_OK);
    assert_int_equal(d.cell_count, 1);
    assert_int_equal(d.gave_up, 1);
    enf_decomposition_free(&d);
    /* Crossing by 1 % of its area: not to be waved through at a coarser resolution. */
    static const double slight[4][2] = {{12, 12}, {12, 11.47}, {4, 10}, {0, 0}};
    assert_int_equal(enf_decompose_prism(&d, slight[0], &four, 1, 0, 3), ENF_OK);
    assert_int_equal(d.cell_count, 1);
    assert_int_equal(d.gave_up, 1);
    enf_decomposition_free(&d);
}

static void bad_shapes_are_refused(void **state) {
    (void)state;
    EnfDecomposition d;
    double corners[6] = {0, 0, 1, 0, NAN, 1};
    uint32_t three = 3, two = 2;
    assert_int_equal(enf_decompose_prism(&d, corners, &three, 1, 0, 1), ENF_ERROR_BAD_INPUT);
    corners[4] = 1;
    assert_int_equal(enf_decompose_prism(&d, corners, &three, 1, 1, 1), ENF_ERROR_BAD_INPUT);
    assert_int_equal(enf_decompose_prism(&d, corners, &two, 1, 0, 1), ENF_ERROR_BAD_INPUT);
    double v[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, INFINITY}};
    uint32_t index[3] = {0, 1, 9};
    assert_int_equal(enf_decompose_polyhedron(&d, v, 4, &three, 1, index), ENF_ERROR_BAD_INPUT);
    v[3][2] = 1;
    assert_int_equal(enf_decompose_polyhedron(&d, v, 4, &three, 1, index), ENF_ERROR_BAD_INPUT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_convex_room_stays_one_cell),
        cmocka_unit_test(l_u_t_and_plus_shapes_give_the_fewest_cells),
        cmocka_unit_test(a_ring_room_round_a_column_gives_four_cells),
        cmocka_unit_test(a_round_column_costs_a_few_cells),
        cmocka_unit_test(a_curved_wall_does_not_shatter_the_rest),
        cmocka_unit_test(random_rectilinear_rooms_keep_their_volume),
        cmocka_unit_test(polyhedra_far_away_turned_and_scaled_give_the_same_cells),
        cmocka_unit_test(a_sloped_roof_over_an_l_is_followed),
        cmocka_unit_test(a_curved_wall_below_a_slope_is_straightened_too),
        cmocka_unit_test(a_wall_thinner_than_a_chord_is_deep_stays_as_it_is),
        cmocka_unit_test(a_stepped_ceiling_gives_two_cells),
        cmocka_unit_test(single_precision_and_split_edges_do_not_matter),
        cmocka_unit_test(noise_of_single_precision_and_stairs_of_its_size_keep_the_volume),
        cmocka_unit_test(an_open_or_crossing_shape_becomes_its_hull),
        cmocka_unit_test(bad_shapes_are_refused),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
