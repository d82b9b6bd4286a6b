/* SPDX-License-Identifier: GPL-3.0-or-later
 * Scenes that make sight fan out: many loops, slits, screens of holes, portals that overlap by halves. Nobody builds so; no query may
 * take long all the same. */
#include "scene_hostile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct Hostile {
    EnfScene *scene;
    EnfStatus status;
    uint32_t room;
    uint64_t random;
} Hostile;

static double unit(Hostile *h) {
    h->random = h->random * 6364136223846793005u + 1442695040888963407u;
    return (double)(h->random >> 11) * 0x1p-53;
}

static const uint32_t prism_sizes[6] = {4, 4, 4, 4, 4, 4};
/* Corners 0..3 below, counter-clockwise seen from above, 4..7 above them. */
static const uint32_t prism_faces[24] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};

static uint32_t prism(Hostile *h, const double (*outline)[2], double z0, double z1) {
    double v[8][3];
    uint32_t cell = ENF_NONE;
    for (int i = 0; i < 8; i++) {
        v[i][0] = outline[i % 4][0];
        v[i][1] = outline[i % 4][1];
        v[i][2] = i < 4 ? z0 : z1;
    }
    if (h->status == ENF_OK)
        h->status = enf_scene_add_cell(h->scene, h->room, ENF_NONE, v[0], 8, 0, prism_sizes, 6, prism_faces, &cell);
    return cell;
}

static uint32_t box(Hostile *h, double x0, double y0, double x1, double y1, double height) {
    const double outline[4][2] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    return prism(h, outline, 0, height);
}

/* An upright rectangle from a to b (plan), z0 to z1. */
static void upright(Hostile *h, uint32_t one, uint32_t two, const double a[2], const double b[2], double z0, double z1) {
    const double v[4][3] = {{a[0], a[1], z0}, {b[0], b[1], z0}, {b[0], b[1], z1}, {a[0], a[1], z1}};
    if (h->status == ENF_OK)
        h->status = enf_scene_add_portal(h->scene, one, two, v[0], 4, 0, ENF_NONE, &(uint32_t){0});
}

static void across_x(Hostile *h, uint32_t one, uint32_t two, double x, double y0, double y1, double z0, double z1) {
    const double a[2] = {x, y0}, b[2] = {x, y1};
    upright(h, one, two, a, b, z0, z1);
}
static void across_y(Hostile *h, uint32_t one, uint32_t two, double y, double x0, double x1, double z0, double z1) {
    const double a[2] = {x0, y}, b[2] = {x1, y};
    upright(h, one, two, a, b, z0, z1);
}

/* Rows of open cells, each row shifted by half a cell: no two portals in line. */
static void build_brick(Hostile *h, uint32_t n) {
    uint32_t *row = calloc(2 * (size_t)n, sizeof *row);
    for (uint32_t y = 0; row && y < n; y++)
        for (uint32_t x = 0; x < n; x++) {
            uint32_t *here = row + (y & 1) * n, *below = row + (~y & 1) * n;
            double shift = (y & 1) ? 2 : 0, x0 = 4.0 * x + shift, y0 = 4.0 * y;
            here[x] = box(h, x0, y0, x0 + 4, y0 + 4, 3);
            if (x > 0)
                across_x(h, here[x - 1], here[x], x0, y0, y0 + 4, 0, 3);
            for (uint32_t k = 0; y > 0 && k < 2; k++) { /* the two below overlap by half each */
                int64_t other = (int64_t)x + (int64_t)k - ((y & 1) ? 0 : 1);
                if (other >= 0 && other < n)
                    across_y(h, below[other], here[x], y0, x0 + 2 * k, x0 + 2 * k + 2, 0, 3);
            }
        }
    free(row);
}

/* Rooms with three slits of centimetres in every wall between them. */
static void build_slits(Hostile *h, uint32_t n) {
    for (uint32_t y = 0; y < n; y++)
        for (uint32_t x = 0; x < n; x++) {
            double x0 = 4.0 * x, y0 = 4.0 * y;
            uint32_t cell = box(h, x0, y0, x0 + 4, y0 + 4, 3);
            for (int k = 0; k < 3; k++) {
                double at = 1.3 * k + unit(h), wide = 0.02 + 0.25 * unit(h);
                if (x > 0)
                    across_x(h, cell - 1, cell, x0, y0 + at, y0 + at + wide, 0.5 * unit(h), 2 + unit(h));
                if (y > 0)
                    across_y(h, cell - n, cell, y0, x0 + at, x0 + at + wide, 0.5 * unit(h), 2 + unit(h));
            }
        }
}

/* Halls in a row behind screens of holes x holes openings. */
static void build_screens(Hostile *h, uint32_t n, uint32_t holes) {
    for (uint32_t i = 0; i < n; i++) {
        uint32_t cell = box(h, 3.0 * i, 0, 3.0 * i + 3, 10, 10);
        double pitch = 10.0 / holes;
        for (uint32_t k = 0; i > 0 && k < holes * holes; k++) {
            double y = pitch * (k % holes), z = pitch * (k / holes), jitter = 0.3 * pitch * unit(h);
            across_x(h, cell - 1, cell, 3.0 * i, y + 0.2 * pitch + jitter, y + 0.7 * pitch + jitter, z + 0.2 * pitch, z + 0.8 * pitch);
        }
    }
}

/* Rings of sectors round a solid core, open on all sides: every way leads everywhere. */
static void build_rings(Hostile *h, uint32_t rings, uint32_t sectors) {
    const double turn = 6.283185307179586;
    for (uint32_t r = 0; r < rings; r++)
        for (uint32_t s = 0; s < sectors; s++) {
            double p[4][2];
            for (int k = 0; k < 4; k++) {
                double angle = turn * ((s + (k == 1 || k == 2 ? 1u : 0u)) % sectors) / sectors,
                       radius = 3 + 4.0 * (r + (k == 0 || k == 1 ? 0u : 1u));
                p[k][0] = radius * cos(angle);
                p[k][1] = radius * sin(angle);
            }
            const double outline[4][2] = {{p[0][0], p[0][1]}, {p[3][0], p[3][1]}, {p[2][0], p[2][1]}, {p[1][0], p[1][1]}};
            uint32_t cell = prism(h, outline, 0, 3);
            if (s > 0)
                upright(h, cell - 1, cell, p[0], p[3], 0, 3);
            if (s + 1 == sectors)
                upright(h, cell, cell - s, p[1], p[2], 0, 3);
            if (r > 0)
                upright(h, cell - sectors, cell, p[0], p[1], 0, 3);
        }
}

/* A corridor that winds inwards. */
static void build_spiral(Hostile *h, uint32_t n) {
    double x = 0, y = 0;
    static const int way[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    uint32_t before = ENF_NONE;
    int came = 0;
    for (uint32_t leg = 0; leg < n; leg++) {
        int go = (int)(leg % 4);
        for (uint32_t k = 0; k < (n - leg) / 2 + 1; k++) { /* cells of 2 m, walls of 1 m between the turns */
            uint32_t cell = box(h, x, y, x + 2, y + 2, 3);
            if (before != ENF_NONE) {
                if (way[came][0])
                    across_x(h, before, cell, way[came][0] > 0 ? x : x + 2, y, y + 2, 0, 3);
                else
                    across_y(h, before, cell, way[came][1] > 0 ? y : y + 2, x, x + 2, 0, 3);
            }
            before = cell;
            came = go;
            x += 2 * way[go][0];
            y += 2 * way[go][1];
        }
    }
}

/* A corridor with alcoves on both sides, their backs joined by corridors again: loops without end. */
static void build_comb(Hostile *h, uint32_t n) {
    for (uint32_t i = 0; i < n; i++) {
        double x = 2.0 * i;
        for (int k = 0; k < 5; k++) { /* corridor, alcove, corridor, alcove, corridor */
            double y = 4.0 * k;
            uint32_t cell = box(h, x, y, x + 2, y + 4, 3);
            if (i > 0 && k % 2 == 0)
                across_x(h, cell - 5, cell, x, y, y + 4, 0, 3);
            if (k > 0)
                across_y(h, cell - 1, cell, y, x + 0.3, x + 1.7, 0, 2.5);
        }
    }
}

EnfStatus enf_hostile_build(const char *name, uint32_t n, uint32_t detail, EnfScene *scene) {
    Hostile h = {scene, ENF_OK, 0, 1};
    h.status = enf_scene_add_room(scene, "Folly", ENF_ROOM_INTERIOR, &h.room);
    if (strcmp(name, "brick") == 0)
        build_brick(&h, n);
    else if (strcmp(name, "slits") == 0)
        build_slits(&h, n);
    else if (strcmp(name, "screens") == 0)
        build_screens(&h, n, detail ? detail : 16);
    else if (strcmp(name, "rings") == 0)
        build_rings(&h, n, detail ? detail : 24);
    else if (strcmp(name, "spiral") == 0)
        build_spiral(&h, n);
    else if (strcmp(name, "comb") == 0)
        build_comb(&h, n);
    else
        return ENF_ERROR_INVALID_ARGUMENT;
    return h.status;
}
