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

/* Halls in a row behind walls of holes with many corners, each another. */
static void build_lace(Hostile *h, uint32_t n, uint32_t holes) {
    const double pitch = 10.0 / holes;
    for (uint32_t i = 0; i < n; i++) {
        uint32_t cell = box(h, 3.0 * i, 0, 3.0 * i + 3, 10, 10);
        for (uint32_t k = 0; i > 0 && k < holes * holes && h->status == ENF_OK; k++) {
            uint32_t corners = 3 + (uint32_t)(14 * unit(h));
            double v[16][3], turn = 6.283185307179586 * unit(h), wide = (0.2 + 0.25 * unit(h)) * pitch,
                             high = (0.2 + 0.25 * unit(h)) * pitch;
            for (uint32_t c = 0; c < corners; c++) {
                double angle = turn + 6.283185307179586 * c / corners;
                v[c][0] = 3.0 * i;
                v[c][1] = pitch * (k % holes + 0.5) + wide * cos(angle);
                v[c][2] = pitch * (k / holes + 0.5) + high * sin(angle);
            }
            h->status = enf_scene_add_portal(h->scene, cell - 1, cell, v[0], corners, 0, ENF_NONE, &(uint32_t){0});
        }
    }
}

/* A round hall with arms of rooms, each seen into through all that lie before it. */
static void build_star(Hostile *h, uint32_t arms, uint32_t rooms) {
    const double turn = 6.283185307179586, radius = fmax(3, arms / 3.0);
    double *around = calloc(arms ? 6 * (size_t)arms : 1, sizeof *around);
    uint32_t hall = ENF_NONE;
    if (!around || arms < 3) {
        free(around);
        h->status = ENF_ERROR_INVALID_ARGUMENT;
        return;
    }
    for (uint32_t i = 0; i < 2 * arms; i++) {
        around[3 * i] = radius * cos(turn * (i % arms) / arms);
        around[3 * i + 1] = radius * sin(turn * (i % arms) / arms);
        around[3 * i + 2] = i < arms ? 0 : 4;
    }
    h->status = enf_scene_add_cell(h->scene, h->room, ENF_NONE, around, 2 * arms, 0, NULL, 0, NULL, &hall);
    for (uint32_t i = 0; i < arms && h->status == ENF_OK; i++) {
        const double *a = around + 3 * i, *b = around + 3 * ((i + 1) % arms);
        const double out[2] = {(a[0] + b[0]) / (2 * radius), (a[1] + b[1]) / (2 * radius)};
        uint32_t before = hall;
        for (uint32_t k = 0; k < rooms; k++) {
            const double near_a[2] = {a[0] + 3.0 * k * out[0], a[1] + 3.0 * k * out[1]},
                         near_b[2] = {b[0] + 3.0 * k * out[0], b[1] + 3.0 * k * out[1]};
            const double outline[4][2] = {{near_a[0], near_a[1]},
                                          {near_a[0] + 3 * out[0], near_a[1] + 3 * out[1]},
                                          {near_b[0] + 3 * out[0], near_b[1] + 3 * out[1]},
                                          {near_b[0], near_b[1]}};
            uint32_t cell = prism(h, outline, 0, 4);
            for (int w = 0; w < 2; w++) { /* two windows side by side */
                const double s = 0.1 + 0.45 * w, e = s + 0.35;
                const double p[2] = {near_a[0] + s * (near_b[0] - near_a[0]), near_a[1] + s * (near_b[1] - near_a[1])};
                const double q[2] = {near_a[0] + e * (near_b[0] - near_a[0]), near_a[1] + e * (near_b[1] - near_a[1])};
                upright(h, before, cell, p, q, 0.5 + 0.2 * unit(h), 3 + 0.5 * unit(h));
            }
            before = cell;
        }
    }
    free(around);
}

/* A hall cut into open cells, and n objects that each reach through all of them. */
static void build_pile(Hostile *h, uint32_t n, uint32_t cells) {
    const double side = 2 + sqrt(n), length = 10.0 / cells;
    for (uint32_t i = 0; i < cells; i++) {
        uint32_t cell = box(h, length * i, 0, length * (i + 1), side, 4);
        if (i > 0)
            across_x(h, cell - 1, cell, length * i, 0, side, 0, 4);
    }
    for (uint32_t i = 0; i < n && h->status == ENF_OK; i++) {
        double y = (side - 1) * unit(h), z = 3 * unit(h), near_wall = 0.4 * length;
        double bounds[6] = {near_wall, y, z, 10 - near_wall, y + 0.1 + 0.9 * unit(h), z + 0.1 + 0.9 * unit(h)};
        h->status = enf_scene_add_object(h->scene, "", bounds, NULL, 0, i % 100, &(uint32_t){0});
    }
}

/* A room, and n objects all round it that are in no cell. */
static void build_litter(Hostile *h, uint32_t n) {
    const double side = sqrt(n);
    box(h, 0, 0, 4, 4, 3);
    for (uint32_t i = 0; i < n && h->status == ENF_OK; i++) {
        double x = side * (unit(h) - 0.5), y = 5 + side * unit(h), z = 10 * unit(h);
        double bounds[6] = {x, y, z, x + 0.1 + unit(h), y + 0.1 + unit(h), z + 0.1 + unit(h)};
        h->status = enf_scene_add_object(h->scene, "", bounds, NULL, 0, ENF_NONE, &(uint32_t){0});
    }
}

/* ---- A block cut by planes --------------------------------------------------------------------------------------- */
enum { FACE_CORNERS = 40, PIECE_FACES = 40 };
typedef struct Face {
    uint32_t n, cut; /* which cut made it, twice, plus the side; ENF_NONE: the block's own */
    double v[FACE_CORNERS][3], normal[3], at;
} Face;
typedef struct Piece {
    uint32_t faces;
    Face *face; /* [PIECE_FACES] */
} Piece;

/* What of the face lies where normal . p <= at. */
static void keep_behind(const Face *in, const double normal[3], double at, Face *out) {
    *out = *in;
    out->n = 0;
    for (uint32_t i = 0; i < in->n; i++) {
        const double *a = in->v[i], *b = in->v[(i + 1) % in->n];
        double da = -at, db = -at;
        for (int c = 0; c < 3; c++) {
            da += normal[c] * a[c];
            db += normal[c] * b[c];
        }
        if (da <= 0 && out->n < FACE_CORNERS)
            memcpy(out->v[out->n++], a, sizeof out->v[0]);
        if ((da < -1e-9 && db > 1e-9) || (da > 1e-9 && db < -1e-9)) {
            double t = da / (da - db);
            for (int c = 0; c < 3 && out->n < FACE_CORNERS; c++)
                out->v[out->n][c] = a[c] + t * (b[c] - a[c]);
            out->n += out->n < FACE_CORNERS;
        }
    }
}

static double face_area(const Face *f) {
    double sum[3] = {0, 0, 0};
    for (uint32_t i = 2; i < f->n; i++)
        for (int c = 0; c < 3; c++) {
            int j = (c + 1) % 3, k = (c + 2) % 3;
            sum[c] += (f->v[i - 1][j] - f->v[0][j]) * (f->v[i][k] - f->v[0][k]) - (f->v[i - 1][k] - f->v[0][k]) * (f->v[i][j] - f->v[0][j]);
        }
    return 0.5 * sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
}

/* The square normal . p = at, large. Counter-clockwise about the normal. */
static void plane_square(const double normal[3], double at, Face *out) {
    double u[3], v[3], side[3] = {fabs(normal[0]) < 0.6, fabs(normal[0]) >= 0.6, 0}, length = 0;
    for (int c = 0; c < 3; c++)
        u[c] = normal[(c + 1) % 3] * side[(c + 2) % 3] - normal[(c + 2) % 3] * side[(c + 1) % 3];
    for (int c = 0; c < 3; c++)
        length += u[c] * u[c];
    for (int c = 0; c < 3; c++)
        u[c] /= sqrt(length);
    for (int c = 0; c < 3; c++)
        v[c] = normal[(c + 1) % 3] * u[(c + 2) % 3] - normal[(c + 2) % 3] * u[(c + 1) % 3];
    out->n = 4;
    out->at = at;
    memcpy(out->normal, normal, sizeof out->normal);
    for (int i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++)
            out->v[i][c] = at * normal[c] + (i == 0 || i == 3 ? -1e3 : 1e3) * u[c] + (i < 2 ? -1e3 : 1e3) * v[c];
}

/* The part of the piece behind the plane, with the cut as a face. 0: nothing of any size. */
static int piece_behind(const Piece *piece, const double normal[3], double at, uint32_t cut, Piece *out) {
    Face *square = &out->face[PIECE_FACES - 1];
    plane_square(normal, at, square);
    square->cut = cut;
    out->faces = 0;
    for (uint32_t i = 0; i < piece->faces && out->faces < PIECE_FACES - 2; i++) {
        keep_behind(&piece->face[i], normal, at, &out->face[out->faces]);
        out->faces += out->face[out->faces].n >= 3 && face_area(&out->face[out->faces]) > 1e-3;
    }
    for (uint32_t i = 0; i < piece->faces; i++) {
        Face before = *square;
        keep_behind(&before, piece->face[i].normal, piece->face[i].at, square);
    }
    if (square->n < 3 || face_area(square) < 1e-2 || out->faces < 3)
        return 0;
    out->face[out->faces++] = *square;
    return 1;
}

/* The largest piece yet is cut next, through somewhere near its middle, in any direction; portals are where faces of one cut meet. */
static void build_cuts(Hostile *h, uint32_t n) {
    Piece *pieces = calloc(n, sizeof *pieces);
    Face *all = calloc((size_t)n * PIECE_FACES, sizeof *all), *spare = calloc(2 * PIECE_FACES, sizeof *spare);
    uint32_t count = 1, cuts = 0;
    for (uint32_t i = 0; pieces && all && i < n; i++)
        pieces[i].face = all + (size_t)i * PIECE_FACES;
    if (!pieces || !all || !spare) {
        h->status = ENF_ERROR_OUT_OF_MEMORY;
        goto done;
    }
    pieces[0].faces = 6;
    for (int f = 0; f < 6; f++) { /* a cube of 20 m, each face cut from a large square */
        double normal[3] = {0, 0, 0};
        normal[f / 2] = f % 2 ? 1 : -1;
        plane_square(normal, 10, &pieces[0].face[f]);
        pieces[0].face[f].cut = ENF_NONE;
    }
    for (int f = 0; f < 6; f++)
        for (int g = 0; g < 6; g++)
            if (g != f) {
                Face before = pieces[0].face[f];
                keep_behind(&before, pieces[0].face[g].normal, pieces[0].face[g].at, &pieces[0].face[f]);
            }
    for (uint32_t tries = 0; count < n && tries < 20 * n; tries++) {
        Piece *piece = &pieces[tries % count], back = {0, spare}, front = {0, spare + PIECE_FACES};
        double normal[3], away[3], length = 0, at = 0, corners = 0;
        for (int c = 0; c < 3; c++) {
            normal[c] = 2 * unit(h) - 1;
            length += normal[c] * normal[c];
        }
        for (int c = 0; c < 3; c++) {
            normal[c] /= sqrt(length);
            away[c] = -normal[c];
        }
        for (uint32_t f = 0; f < piece->faces; f++)
            for (uint32_t i = 0; i < piece->face[f].n; i++, corners++)
                for (int c = 0; c < 3; c++)
                    at += normal[c] * piece->face[f].v[i][c];
        at = at / corners + 0.1 * unit(h);
        if (!piece_behind(piece, normal, at, 2 * cuts, &back) || !piece_behind(piece, away, -at, 2 * cuts + 1, &front))
            continue;
        cuts++;
        piece->faces = back.faces;
        memcpy(piece->face, back.face, sizeof *back.face * back.faces);
        pieces[count].faces = front.faces;
        memcpy(pieces[count++].face, front.face, sizeof *front.face * front.faces);
    }
    for (uint32_t p = 0; p < count && h->status == ENF_OK; p++) {
        double corners[PIECE_FACES * FACE_CORNERS][3];
        uint32_t total = 0;
        for (uint32_t f = 0; f < pieces[p].faces; f++)
            for (uint32_t i = 0; i < pieces[p].face[f].n; i++) {
                const double *v = pieces[p].face[f].v[i];
                uint32_t k = 0;
                while (k < total && fabs(corners[k][0] - v[0]) + fabs(corners[k][1] - v[1]) + fabs(corners[k][2] - v[2]) > 1e-7)
                    k++;
                if (k == total)
                    memcpy(corners[total++], v, sizeof corners[0]);
            }
        h->status = enf_scene_add_cell(h->scene, h->room, ENF_NONE, corners[0], total, 0, NULL, 0, NULL, &(uint32_t){0});
    }
    for (uint32_t a = 0; a < count; a++)
        for (uint32_t f = 0; f < pieces[a].faces && h->status == ENF_OK; f++) {
            const Face *one = &pieces[a].face[f];
            if (one->cut == ENF_NONE || one->cut % 2)
                continue;
            for (uint32_t b = 0; b < count; b++)
                for (uint32_t g = 0; g < pieces[b].faces; g++) {
                    if (pieces[b].face[g].cut != one->cut + 1)
                        continue;
                    Face common = *one, before;
                    for (uint32_t k = 0; k < pieces[b].faces && common.n >= 3; k++)
                        if (k != g) {
                            before = common;
                            keep_behind(&before, pieces[b].face[k].normal, pieces[b].face[k].at, &common);
                        }
                    if (common.n >= 3 && face_area(&common) > 1e-3 && h->status == ENF_OK)
                        h->status = enf_scene_add_portal(h->scene, a, b, common.v[0], common.n, 0, ENF_NONE, &(uint32_t){0});
                }
        }
done:
    free(pieces);
    free(all);
    free(spare);
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
    else if (strcmp(name, "lace") == 0)
        build_lace(&h, n, detail ? detail : 8);
    else if (strcmp(name, "star") == 0)
        build_star(&h, n, detail ? detail : 4);
    else if (strcmp(name, "cuts") == 0)
        build_cuts(&h, n);
    else if (strcmp(name, "pile") == 0)
        build_pile(&h, n, detail ? detail : 1);
    else if (strcmp(name, "litter") == 0)
        build_litter(&h, n);
    else
        return ENF_ERROR_INVALID_ARGUMENT;
    return h.status;
}
