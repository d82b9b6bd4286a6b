/* SPDX-License-Identifier: GPL-3.0-or-later
 * Families of scenes made by code through the public calls alone. */
#include "scene_family.h"
#include "scene_hostile.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* splitmix64: one multiplication chain, the same on every machine. */
typedef struct Rng {
    uint64_t state;
} Rng;

static uint64_t rng_next(Rng *rng) {
    uint64_t z = (rng->state += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
}

static double rng_unit(Rng *rng) {
    return (double)(rng_next(rng) >> 11) * (1.0 / 9007199254740992.0);
}
static double rng_range(Rng *rng, double lo, double hi) {
    return lo + (hi - lo) * rng_unit(rng);
}

/* The first failure sticks, so that builders read as a list of what they build. */
typedef struct Maker {
    EnfScene *scene;
    EnfStatus status;
    Rng rng;
    double turn[2], at[2]; /* of what is built now: cosine and sine about the z axis, then moved */
    int occluders;         /* objects are solid boxes */
} Maker;

static void place(const Maker *m, double p[3]) {
    double x = p[0], y = p[1];
    p[0] = m->at[0] + m->turn[0] * x - m->turn[1] * y;
    p[1] = m->at[1] + m->turn[1] * x + m->turn[0] * y;
}

static const uint32_t box_face_sizes[6] = {4, 4, 4, 4, 4, 4};
/* Corner i: x from bit 0, y from bit 1, z from bit 2. Counter-clockwise seen from outside. */
static const uint32_t box_face_indices[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};

static uint32_t make_room(Maker *m, const char *name, uint32_t kind) {
    uint32_t room = ENF_NONE;
    if (m->status == ENF_OK)
        m->status = enf_scene_add_room(m->scene, name, kind, &room);
    return room;
}

static uint32_t make_box(Maker *m, uint32_t room, uint32_t opening, double x0, double y0, double z0, double x1, double y1, double z1) {
    double corners[8][3];
    for (int i = 0; i < 8; i++) {
        corners[i][0] = (i & 1) ? x1 : x0;
        corners[i][1] = (i & 2) ? y1 : y0;
        corners[i][2] = (i & 4) ? z1 : z0;
        place(m, corners[i]);
    }
    uint32_t cell = ENF_NONE;
    if (m->status == ENF_OK)
        m->status = enf_scene_add_cell(m->scene, room, opening, &corners[0][0], 8, 0, box_face_sizes, 6, box_face_indices, &cell);
    return cell;
}

/* An axis-aligned rectangle at coordinate `at` of `axis`; lo and hi span the two other axes in ascending order. */
static void make_portal(Maker *m, uint32_t cell_a, uint32_t cell_b, int axis, double at, const double lo[2], const double hi[2],
                        uint32_t opening) {
    int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    double polygon[4][3];
    for (int i = 0; i < 4; i++) {
        polygon[i][axis] = at;
        polygon[i][u] = (i == 1 || i == 2) ? hi[0] : lo[0];
        polygon[i][v] = i >= 2 ? hi[1] : lo[1];
        place(m, polygon[i]);
    }
    uint32_t portal;
    if (m->status == ENF_OK)
        m->status = enf_scene_add_portal(m->scene, cell_a, cell_b, &polygon[0][0], 4, 0, opening, &portal);
}

static uint32_t make_opening(Maker *m, char letter, uint32_t number, uint32_t kind, uint32_t state) {
    char name[24];
    snprintf(name, sizeof name, "%c%u", letter, number);
    uint32_t opening = ENF_NONE;
    if (m->status == ENF_OK)
        m->status = enf_scene_add_opening(m->scene, name, kind, state, &opening);
    return opening;
}

/* A door, window or slab hole through a wall of some thickness: a cell of its own with a portal on both sides. */
static void make_thick_opening(Maker *m, uint32_t cell_a, uint32_t cell_b, int axis, double at_a, double at_b, const double lo[2],
                               const double hi[2], uint32_t opening) {
    int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    double a[3], b[3];
    a[axis] = fmin(at_a, at_b);
    b[axis] = fmax(at_a, at_b);
    a[u] = lo[0];
    b[u] = hi[0];
    a[v] = lo[1];
    b[v] = hi[1];
    uint32_t cell = make_box(m, ENF_NONE, opening, a[0], a[1], a[2], b[0], b[1], b[2]);
    make_portal(m, cell_a, cell, axis, at_a, lo, hi, opening);
    make_portal(m, cell, cell_b, axis, at_b, lo, hi, opening);
}

/* Furniture: boxes that stand on the floor, 0.2 to 1.2 m wide; twelve shared meshes. */
static void make_objects(Maker *m, uint32_t cell, uint32_t count, double x0, double y0, double z0, double x1, double y1, double z1) {
    for (uint32_t i = 0; i < count && m->status == ENF_OK; i++) {
        double w = rng_range(&m->rng, 0.2, fmin(1.2, 0.5 * (x1 - x0)));
        double d = rng_range(&m->rng, 0.2, fmin(1.2, 0.5 * (y1 - y0)));
        double h = rng_range(&m->rng, 0.1, fmin(m->occluders ? 2.2 : 1.1, z1 - z0));
        double x = rng_range(&m->rng, x0, x1 - w), y = rng_range(&m->rng, y0, y1 - d);
        double z = rng_unit(&m->rng) < 0.7 ? z0 : rng_range(&m->rng, z0, z1 - h);
        double bounds[6] = {x, y, z, x + w, y + d, z + h};
        if (m->turn[1] != 0) /* bounds of the turned box; the middle keeps its room */
            for (int c = 0; c < 4; c++) {
                double corner[3] = {x + (c & 1) * w, y + (c >> 1) * d, z};
                place(m, corner);
                for (int k = 0; k < 2; k++) {
                    bounds[k] = c == 0 ? corner[k] : fmin(bounds[k], corner[k]);
                    bounds[3 + k] = c == 0 ? corner[k] : fmax(bounds[3 + k], corner[k]);
                }
            }
        uint32_t object, mesh = (uint32_t)(rng_next(&m->rng) % 12u);
        m->status = enf_scene_add_object(m->scene, "", bounds, &cell, 1, mesh, &object);
        if (m->occluders && m->turn[1] == 0 && m->status == ENF_OK)
            m->status = enf_scene_set_occluder(m->scene, object, NULL, 0, NULL, 0);
    }
}

static uint32_t make_outdoors(Maker *m) {
    uint32_t room = make_room(m, "Outside", ENF_ROOM_EXTERIOR), cell = ENF_NONE;
    if (m->status == ENF_OK)
        m->status = enf_scene_add_cell(m->scene, room, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &cell);
    return cell;
}

/* ---- Reading the specification ----------------------------------------------------------------------------- */
static double spec_value(const char *spec, const char *key, double fallback) {
    size_t length = strlen(key);
    for (const char *at = strchr(spec, ','); at; at = strchr(at + 1, ','))
        if (strncmp(at + 1, key, length) == 0 && at[1 + length] == '=')
            return strtod(at + 2 + length, NULL);
    return fallback;
}

/* ---- Office -------------------------------------------------------------------------------------------------- */
/* A storey: a hall along y; from it `wings` corridors along x, `side` rooms on both sides of each; courts between the
 * wings, so that every room has a window. 46 rooms = 1 storey, 1 wing, 22 rooms a side + corridor + hall;
 * 1,768 = 13 storeys of 3 wings. */
static void build_office(Maker *m, uint32_t rooms, const char *spec) {
    uint32_t objects = (uint32_t)spec_value(spec, "objects", 23);
    int windows = spec_value(spec, "windows", 1) != 0;
    double extra_doors = spec_value(spec, "doors", 0.2), closed = spec_value(spec, "closed", 0);
    uint32_t side = 22, wings = 1, storeys = (uint32_t)spec_value(spec, "storeys", 0);
    if (rooms < 46)
        side = rooms > 6 ? (rooms - 2) / 2 : 2;
    else if (rooms > 46)
        wings = 3;
    if (rooms > 6000) {
        side = 40;
        wings = 10;
    }
    side = (uint32_t)spec_value(spec, "side", side), wings = (uint32_t)spec_value(spec, "wings", wings);
    if (side == 0 || wings == 0)
        side = wings = 1;
    if (storeys == 0)
        storeys = (rooms + wings * (2 * side + 1)) / (wings * (2 * side + 1) + 1);
    if (storeys == 0)
        storeys = 1;

    const double wall = 0.2, slab = 0.3, height = 2.8, room_w = 3.6, room_d = 5.0, corridor_w = 2.2, court = 14.0;
    const double hall_w = 6.0, pitch_x = room_w + wall;
    const double wing_depth = 2 * room_d + corridor_w + 2 * wall, pitch_y = wing_depth + court;
    const double hall_y1 = (wings - 1) * pitch_y + wing_depth;
    uint32_t outside = windows ? make_outdoors(m) : ENF_NONE, number = 0;
    uint32_t hall_below = ENF_NONE;
    for (uint32_t s = 0; s < storeys && m->status == ENF_OK; s++) {
        double z0 = s * (height + slab), z1 = z0 + height;
        char name[64];
        snprintf(name, sizeof name, "Hall %u", s);
        uint32_t hall_room = make_room(m, name, ENF_ROOM_INTERIOR);
        uint32_t hall = make_box(m, hall_room, ENF_NONE, -hall_w - wall, 0, z0, -wall, hall_y1, z1);
        make_objects(m, hall, objects, -hall_w - wall, 0, z0, -wall, hall_y1, z1);
        if (hall_below != ENF_NONE) { /* the stair's hole in the slab */
            double lo[2] = {-hall_w - wall + 0.5, 1.0}, hi[2] = {-hall_w - wall + 2.9, 5.0};
            uint32_t opening = make_opening(m, 'S', number++, ENF_OPENING_HOLE, ENF_STATE_OPEN);
            make_thick_opening(m, hall_below, hall, 2, z0 - slab, z0, lo, hi, opening);
        }
        hall_below = hall;
        for (uint32_t w = 0; w < wings; w++) {
            double base = w * pitch_y, corridor_y0 = base + room_d + wall, corridor_y1 = corridor_y0 + corridor_w;
            double x1 = side * pitch_x - wall;
            snprintf(name, sizeof name, "Corridor %u.%u", s, w);
            uint32_t corridor_room = make_room(m, name, ENF_ROOM_INTERIOR);
            uint32_t corridor = make_box(m, corridor_room, ENF_NONE, 0, corridor_y0, z0, x1, corridor_y1, z1);
            make_objects(m, corridor, objects, 0, corridor_y0, z0, x1, corridor_y1, z1);
            double lo[2] = {corridor_y0 + 0.3, z0}, hi[2] = {corridor_y1 - 0.3, z0 + 2.3};
            uint32_t opening = make_opening(m, 'D', number++, ENF_OPENING_DOOR, ENF_STATE_OPEN);
            make_thick_opening(m, hall, corridor, 0, -wall, 0, lo, hi, opening);
            uint32_t before[2] = {ENF_NONE, ENF_NONE};
            for (uint32_t i = 0; i < side; i++) {
                double rx0 = i * pitch_x, rx1 = rx0 + room_w;
                for (int k = 0; k < 2; k++) {
                    double ry0 = k == 0 ? base : corridor_y1 + wall, ry1 = ry0 + room_d;
                    snprintf(name, sizeof name, "Room %u.%u.%u", s, w, 2 * i + (uint32_t)k);
                    uint32_t room = make_room(m, name, ENF_ROOM_INTERIOR);
                    uint32_t cell = make_box(m, room, ENF_NONE, rx0, ry0, z0, rx1, ry1, z1);
                    make_objects(m, cell, objects, rx0, ry0, z0, rx1, ry1, z1);
                    /* Doors stand at different places along the wall, as in life. */
                    double door = rx0 + rng_range(&m->rng, 0.2, room_w - 1.15);
                    double dlo[2] = {door, z0}, dhi[2] = {door + 0.9, z0 + 2.1};
                    uint32_t state = rng_unit(&m->rng) < closed ? ENF_STATE_CLOSED : ENF_STATE_OPEN;
                    opening = make_opening(m, 'D', number++, ENF_OPENING_DOOR, state);
                    if (k == 0)
                        make_thick_opening(m, cell, corridor, 1, ry1, corridor_y0, dlo, dhi, opening);
                    else
                        make_thick_opening(m, corridor, cell, 1, corridor_y1, ry0, dlo, dhi, opening);
                    if (windows) {
                        double wlo[2] = {rx0 + 0.8, z0 + 0.9}, whi[2] = {rx1 - 0.8, z0 + 2.3};
                        opening = make_opening(m, 'W', number++, ENF_OPENING_WINDOW, ENF_STATE_GLASS);
                        make_thick_opening(m, cell, outside, 1, k == 0 ? ry0 : ry1, k == 0 ? ry0 - wall : ry1 + wall, wlo, whi, opening);
                    }
                    if (before[k] != ENF_NONE && rng_unit(&m->rng) < extra_doors) {
                        double elo[2] = {ry0 + rng_range(&m->rng, 0.2, room_d - 1.15), z0};
                        double ehi[2] = {elo[0] + 0.9, z0 + 2.1};
                        opening = make_opening(m, 'D', number++, ENF_OPENING_DOOR, ENF_STATE_OPEN);
                        make_thick_opening(m, before[k], cell, 0, rx0 - wall, rx0, elo, ehi, opening);
                    }
                    before[k] = cell;
                }
            }
        }
    }
}

/* ---- Open plans ------------------------------------------------------------------------------------------------- */
static void build_grid(Maker *m, uint32_t n, const char *spec) {
    uint32_t storeys = (uint32_t)spec_value(spec, "storeys", 1), objects = (uint32_t)spec_value(spec, "objects", 0);
    double size = spec_value(spec, "size", 4.0), height = 3.0;
    uint32_t room = make_room(m, "Open plan", ENF_ROOM_INTERIOR);
    uint32_t *cells = malloc(sizeof *cells * ((size_t)n * n * storeys + 1));
    if (!cells) {
        m->status = ENF_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (uint32_t s = 0; s < storeys; s++)
        for (uint32_t y = 0; y < n; y++)
            for (uint32_t x = 0; x < n && m->status == ENF_OK; x++) {
                double x0 = x * size, y0 = y * size, z0 = s * height;
                uint32_t cell = make_box(m, room, ENF_NONE, x0, y0, z0, x0 + size, y0 + size, z0 + height);
                cells[((size_t)s * n + y) * n + x] = cell;
                make_objects(m, cell, objects, x0, y0, z0, x0 + size, y0 + size, z0 + height);
                double lo_x[2] = {y0, z0}, hi_x[2] = {y0 + size, z0 + height};
                double lo_y[2] = {x0, z0}, hi_y[2] = {x0 + size, z0 + height};
                double lo_z[2] = {x0, y0}, hi_z[2] = {x0 + size, y0 + size};
                if (x > 0)
                    make_portal(m, cell - 1, cell, 0, x0, lo_x, hi_x, ENF_NONE);
                if (y > 0)
                    make_portal(m, cells[((size_t)s * n + y - 1) * n + x], cell, 1, y0, lo_y, hi_y, ENF_NONE);
                if (s > 0)
                    make_portal(m, cells[((size_t)(s - 1) * n + y) * n + x], cell, 2, z0, lo_z, hi_z, ENF_NONE);
            }
    free(cells);
}

/* A module is a bay of 3.5 x 3.5 m, a strip towards +x and a strip towards +y; the column fills the fourth corner. */
static void build_columns(Maker *m, uint32_t n, const char *spec) {
    uint32_t objects = (uint32_t)spec_value(spec, "objects", 0);
    const double size = 4.0, column = 0.5, bay = size - column, height = 3.0;
    uint32_t room = make_room(m, "Columns", ENF_ROOM_INTERIOR);
    uint32_t *strips_y = calloc((size_t)n + 1, sizeof *strips_y);
    if (!strips_y) {
        m->status = ENF_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (uint32_t y = 0; y < n; y++) {
        uint32_t strip_x = ENF_NONE;
        for (uint32_t x = 0; x < n && m->status == ENF_OK; x++) {
            double x0 = x * size, y0 = y * size, x1 = x0 + bay, y1 = y0 + bay;
            uint32_t cell = make_box(m, room, ENF_NONE, x0, y0, 0, x1, y1, height);
            make_objects(m, cell, objects, x0, y0, 0, x1, y1, height);
            double lo_x[2] = {y0, 0}, hi_x[2] = {y1, height}, lo_y[2] = {x0, 0}, hi_y[2] = {x1, height};
            if (x > 0)
                make_portal(m, strip_x, cell, 0, x0, lo_x, hi_x, ENF_NONE);
            if (y > 0)
                make_portal(m, strips_y[x], cell, 1, y0, lo_y, hi_y, ENF_NONE);
            if (x + 1 < n) {
                strip_x = make_box(m, room, ENF_NONE, x1, y0, 0, x0 + size, y1, height);
                make_portal(m, cell, strip_x, 0, x1, lo_x, hi_x, ENF_NONE);
            }
            if (y + 1 < n) {
                strips_y[x] = make_box(m, room, ENF_NONE, x0, y1, 0, x1, y0 + size, height);
                make_portal(m, cell, strips_y[x], 1, y1, lo_y, hi_y, ENF_NONE);
            }
        }
    }
    free(strips_y);
}

/* ---- Special shapes ------------------------------------------------------------------------------------------------ */
static void build_ring(Maker *m, uint32_t n) {
    if (n < 3)
        n = 3;
    const double inner = 0.7 * n / 6.2831853071795864769 + 2.0, outer = inner + 4.0, height = 3.0;
    uint32_t first = ENF_NONE, before = ENF_NONE;
    for (uint32_t i = 0; i < n && m->status == ENF_OK; i++) {
        char name[24];
        snprintf(name, sizeof name, "Ring %u", i);
        uint32_t room = make_room(m, name, ENF_ROOM_INTERIOR);
        double corners[8][3], polygon[4][3];
        for (int c = 0; c < 8; c++) {
            /* The last room ends on exactly the corners the first one begins with. */
            double angle = 6.2831853071795864769 * (double)((i + ((c & 1) ? 0u : 1u)) % n) / n;
            double radius = (c & 2) ? outer : inner;
            corners[c][0] = radius * cos(angle);
            corners[c][1] = radius * sin(angle);
            corners[c][2] = (c & 4) ? height : 0;
        }
        uint32_t cell = ENF_NONE, portal;
        m->status = enf_scene_add_cell(m->scene, room, ENF_NONE, &corners[0][0], 8, 0, NULL, 0, NULL, &cell);
        static const int start_side[4] = {1, 3, 7, 5}, end_side[4] = {0, 2, 6, 4};
        for (int c = 0; c < 4; c++)
            memcpy(polygon[c], corners[start_side[c]], sizeof polygon[c]);
        if (before != ENF_NONE && m->status == ENF_OK)
            m->status = enf_scene_add_portal(m->scene, before, cell, &polygon[0][0], 4, 0, ENF_NONE, &portal);
        for (int c = 0; c < 4; c++)
            memcpy(polygon[c], corners[end_side[c]], sizeof polygon[c]);
        if (i + 1 == n && m->status == ENF_OK)
            m->status = enf_scene_add_portal(m->scene, cell, first, &polygon[0][0], 4, 0, ENF_NONE, &portal);
        if (i == 0)
            first = cell;
        before = cell;
    }
}

static void build_hub(Maker *m, uint32_t n, const char *spec) {
    uint32_t objects = (uint32_t)spec_value(spec, "objects", 1), side = (n + 3) / 4;
    const double closet = 2.0, depth = 2.0, wall = 0.1, height = 3.0, length = side * (closet + wall);
    uint32_t hall = make_box(m, make_room(m, "Hall", ENF_ROOM_INTERIOR), ENF_NONE, 0, 0, 0, length, length, height);
    make_objects(m, hall, objects, 0, 0, 0, length, length, height);
    for (uint32_t i = 0; i < n && m->status == ENF_OK; i++) {
        uint32_t k = i % 4, j = i / 4;
        int axis = (k & 1) ? 0 : 1;
        double a0 = j * (closet + wall), a1 = a0 + closet;
        double at = k < 2 ? 0 : length, b0 = k < 2 ? -wall - depth : length + wall, b1 = b0 + depth;
        char name[24];
        snprintf(name, sizeof name, "Closet %u", i);
        uint32_t room = make_room(m, name, ENF_ROOM_INTERIOR);
        double x0 = axis == 0 ? b0 : a0, x1 = axis == 0 ? b1 : a1, y0 = axis == 0 ? a0 : b0, y1 = axis == 0 ? a1 : b1;
        uint32_t cell = make_box(m, room, ENF_NONE, x0, y0, 0, x1, y1, height);
        make_objects(m, cell, objects, x0, y0, 0, x1, y1, height);
        uint32_t opening = make_opening(m, 'D', i, ENF_OPENING_DOOR, ENF_STATE_OPEN);
        double lo[2] = {a0 + 0.5, 0}, hi[2] = {a0 + 1.4, 2.1};
        make_thick_opening(m, hall, cell, axis, at, k < 2 ? at - wall : at + wall, lo, hi, opening);
    }
}

static void build_enfilade(Maker *m, uint32_t n, const char *spec) {
    uint32_t objects = (uint32_t)spec_value(spec, "objects", 6);
    uint32_t before = ENF_NONE;
    for (uint32_t i = 0; i < n && m->status == ENF_OK; i++) {
        char name[24];
        snprintf(name, sizeof name, "Salon %u", i);
        uint32_t room = make_room(m, name, ENF_ROOM_INTERIOR);
        uint32_t cell = make_box(m, room, ENF_NONE, i * 5.0, 0, 0, i * 5.0 + 4.75, 6, 4);
        make_objects(m, cell, objects, i * 5.0, 0, 0, i * 5.0 + 4.75, 6, 4);
        if (before != ENF_NONE) {
            double lo[2] = {0.8, 0}, hi[2] = {1.9, 2.4};
            uint32_t opening = make_opening(m, 'D', i, ENF_OPENING_DOOR, ENF_STATE_OPEN);
            make_thick_opening(m, before, cell, 0, i * 5.0 - 0.25, i * 5.0, lo, hi, opening);
        }
        before = cell;
    }
}

static void build_tower(Maker *m, uint32_t n, const char *spec) {
    uint32_t below = ENF_NONE, outside = spec_value(spec, "windows", 0) != 0 ? make_outdoors(m) : ENF_NONE;
    for (uint32_t s = 0; s < n && m->status == ENF_OK; s++) {
        double z0 = s * 3.2, z1 = z0 + 2.9;
        char name[24];
        snprintf(name, sizeof name, "Shaft %u", s);
        uint32_t shaft = make_box(m, make_room(m, name, ENF_ROOM_INTERIOR), ENF_NONE, 0, 0, z0, 5, 5, z1);
        if (below != ENF_NONE) {
            double lo[2] = {1, 1}, hi[2] = {4, 4};
            uint32_t opening = make_opening(m, 'S', s, ENF_OPENING_HOLE, ENF_STATE_OPEN);
            make_thick_opening(m, below, shaft, 2, z0 - 0.3, z0, lo, hi, opening);
        }
        below = shaft;
        for (uint32_t k = 0; k < 4; k++) {
            int axis = (k & 1) ? 0 : 1;
            double at = k < 2 ? 0 : 5, b0 = k < 2 ? -6.2 : 5.2;
            snprintf(name, sizeof name, "Flat %u.%u", s, k);
            uint32_t room = make_room(m, name, ENF_ROOM_INTERIOR);
            double x0 = axis == 0 ? b0 : 0, x1 = axis == 0 ? b0 + 6 : 5, y0 = axis == 0 ? 0 : b0, y1 = axis == 0 ? 5 : b0 + 6;
            uint32_t cell = make_box(m, room, ENF_NONE, x0, y0, z0, x1, y1, z1);
            make_objects(m, cell, 8, x0, y0, z0, x1, y1, z1);
            uint32_t opening = make_opening(m, 'D', 4 * s + k, ENF_OPENING_DOOR, ENF_STATE_OPEN);
            double lo[2] = {2, z0}, hi[2] = {2.9, z0 + 2.1};
            make_thick_opening(m, shaft, cell, axis, at, k < 2 ? at - 0.2 : at + 0.2, lo, hi, opening);
            if (outside != ENF_NONE) {
                double wlo[2] = {0.5, z0 + 0.8}, whi[2] = {4.5, z0 + 2.4}, wall = k < 2 ? b0 : b0 + 6;
                opening = make_opening(m, 'W', 4 * s + k, ENF_OPENING_WINDOW, ENF_STATE_GLASS);
                make_thick_opening(m, cell, outside, axis, wall, k < 2 ? wall - 0.2 : wall + 0.2, wlo, whi, opening);
            }
        }
    }
}

/* ---- Buildings with an outside ------------------------------------------------------------------------------------ */
/* Rooms of 5 x 5 m where `plan` (w x h, row by row) says so, walls of 0.3 m between them; a door to each neighbour but
 * some, a window in each outer wall; a stair's hole in the first room. Numbers of openings go on from *number. */
static void make_building(Maker *m, const uint8_t *plan, int w, int h, uint32_t storeys, uint32_t objects, uint32_t outside,
                          uint32_t *number) {
    const double room = 5.0, wall = 0.3, pitch = room + wall, slab = 0.3, height = 2.8;
    uint32_t *cells = malloc(sizeof *cells * (size_t)(w * h) * 2);
    if (!cells) {
        m->status = ENF_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (uint32_t s = 0; s < storeys; s++) {
        double z0 = s * (height + slab), z1 = z0 + height;
        uint32_t *here = cells + (s & 1 ? w * h : 0), *below = cells + (s & 1 ? 0 : w * h);
        int stair = s == 0;
        for (int i = 0; i < w * h && m->status == ENF_OK; i++) {
            int x = i % w, y = i / w;
            double x0 = x * pitch, y0 = y * pitch;
            char name[32];
            here[i] = ENF_NONE;
            if (!plan[i])
                continue;
            snprintf(name, sizeof name, "Room %u.%d", *number, i);
            here[i] = make_box(m, make_room(m, name, ENF_ROOM_INTERIOR), ENF_NONE, x0, y0, z0, x0 + room, y0 + room, z1);
            make_objects(m, here[i], objects, x0, y0, z0, x0 + room, y0 + room, z1);
            if (!stair) {
                double lo[2] = {x0 + 0.5, y0 + 0.5}, hi[2] = {x0 + 1.6, y0 + 3.5};
                make_thick_opening(m, below[i], here[i], 2, z0 - slab, z0, lo, hi,
                                   make_opening(m, 'S', (*number)++, ENF_OPENING_HOLE, ENF_STATE_OPEN));
                stair = 1;
            }
            for (int axis = 0; axis < 2; axis++)
                for (int side = -1; side <= 1; side += 2) {
                    int nx = x + (axis == 0 ? side : 0), ny = y + (axis == 1 ? side : 0);
                    int inside = nx >= 0 && nx < w && ny >= 0 && ny < h && plan[ny * w + nx];
                    double base = axis == 0 ? y0 : x0, at = (axis == 0 ? x0 : y0) + (side > 0 ? room : 0);
                    if (inside && side < 0) { /* the neighbour is there already */
                        double from = base + rng_range(&m->rng, 0.3, 3.8), lo[2] = {from, z0}, hi[2] = {from + 0.9, z0 + 2.1};
                        if (rng_unit(&m->rng) < 0.85)
                            make_thick_opening(m, here[ny * w + nx], here[i], axis, at - wall, at, lo, hi,
                                               make_opening(m, 'D', (*number)++, ENF_OPENING_DOOR, ENF_STATE_OPEN));
                    } else if (!inside) {
                        double from = base + rng_range(&m->rng, 0.6, 2.2), lo[2] = {from, z0 + 0.8}, hi[2] = {from + 2.0, z0 + 2.2};
                        make_thick_opening(m, here[i], outside, axis, at, at + side * wall, lo, hi,
                                           make_opening(m, 'W', (*number)++, ENF_OPENING_WINDOW, ENF_STATE_GLASS));
                    }
                }
        }
    }
    free(cells);
}

/* Trees and cars: objects that nobody put in a cell. */
static void make_garden(Maker *m, uint32_t count, const double box[4]) {
    for (uint32_t i = 0; i < count && m->status == ENF_OK; i++) {
        double x = rng_range(&m->rng, box[0], box[2]), y = rng_range(&m->rng, box[1], box[3]), size = rng_range(&m->rng, 0.5, 3);
        double bounds[6] = {x, y, 0, x + size, y + size, 2 * size};
        m->status = enf_scene_add_object(m->scene, "", bounds, NULL, 0, 100, &(uint32_t){0});
    }
}

/* N x N rooms in a square round a court. */
static void build_court(Maker *m, uint32_t n, const char *spec) {
    uint32_t storeys = (uint32_t)spec_value(spec, "storeys", 4), objects = (uint32_t)spec_value(spec, "objects", 23), number = 0;
    uint32_t outside = make_outdoors(m);
    uint8_t *plan = n >= 3 && n < 1000 ? malloc((size_t)n * n) : NULL;
    if (!plan) {
        m->status = ENF_ERROR_INVALID_ARGUMENT;
        return;
    }
    for (uint32_t i = 0; i < n * n; i++)
        plan[i] = i % n == 0 || i % n == n - 1 || i / n == 0 || i / n == n - 1;
    make_building(m, plan, (int)n, (int)n, storeys, objects, outside, &number);
    double size = 5.3 * n, box[4] = {-10, -10, size + 10, size + 10};
    make_garden(m, (uint32_t)spec_value(spec, "garden", 40), box);
    free(plan);
}

/* N houses of different plans, each turned its own way. */
static void build_town(Maker *m, uint32_t n, const char *spec) {
    static const uint8_t plans[6][16] = {
        {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0}, /* L */
        {1, 0, 0, 1, 1, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 0}, /* U */
        {1, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 1, 1, 1}, /* round a court */
        {1, 1, 1, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}, /* T */
        {1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, /* a block */
        {1, 0, 1, 0, 1, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0}  /* combs: loggias between */
    };
    uint32_t objects = (uint32_t)spec_value(spec, "objects", 10), number = 0, outside = make_outdoors(m), across = 1;
    double turned = spec_value(spec, "turned", 1);
    while (across * across < n)
        across++;
    for (uint32_t i = 0; i < n && m->status == ENF_OK; i++) {
        double angle = turned * rng_range(&m->rng, 0, 6.283185307179586);
        m->turn[0] = cos(angle);
        m->turn[1] = sin(angle);
        double x = -10.5 * m->turn[0] + 10.5 * m->turn[1], y = -10.5 * m->turn[1] - 10.5 * m->turn[0];
        m->at[0] = 34.0 * (i % across) + x;
        m->at[1] = 34.0 * (i / across) + y;
        make_building(m, plans[i % 6], 4, 4, 2 + i % 3, objects, outside, &number);
    }
    m->turn[0] = 1;
    m->turn[1] = m->at[0] = m->at[1] = 0;
    double box[4] = {-20, -20, 34.0 * across, 34.0 * across};
    make_garden(m, (uint32_t)spec_value(spec, "garden", 10 * n), box);
}

const char *enf_family_help(void) {
    return "office:R[,objects=23,windows=1,doors=0.2,closed=0,seed=1,storeys=0,side=22,wings=3]  grid:N[,storeys=1,objects=0,size=4]\n"
           "columns:N[,objects=0]  ring:N  hub:N[,objects=1]  enfilade:N[,objects=6]  tower:N[,windows=0]\n"
           "court:N[,storeys=4,objects=23,garden=40]  town:N[,objects=10,turned=1,garden=10N]  city:N  facade:N\n"
           "brick:N  slits:N  spiral:N  comb:N  screens:N[,detail=16]  rings:N[,detail=24]\n"
           "lace:N[,detail=8]  star:N[,detail=4]  cuts:N  pile:N[,detail=1]  litter:N   (no building looks so)\n"
           "those with windows: [,outdoors=1] cuts the outside into cells; all: [,occluders=1] solid objects, some high\n";
}

/* ---- Facade ---------------------------------------------------------------------------------------------------- */
/* N storeys of 2N rooms behind one wall, a window each, and a yard in front that is a cell with walls of its own: what is seen from
 * outside, without anything that needs the outdoors cut. */
static void build_facade(Maker *m, uint32_t n) {
    const double room_w = 3.6, wall = 0.2, slab = 0.3, height = 2.8, depth = 5.0, pitch = room_w + wall, storey = height + slab;
    uint32_t yard =
        make_box(m, make_room(m, "Yard", ENF_ROOM_EXTERIOR), ENF_NONE, -10, -20, -0.5, 2 * n * pitch + 10, -wall, n * storey + 3);
    for (uint32_t i = 0; i < 2 * n * n && m->status == ENF_OK; i++) {
        double x0 = (i % (2 * n)) * pitch, z0 = (i / (2 * n)) * storey;
        double lo[2] = {x0 + 0.8, z0 + 0.9}, hi[2] = {x0 + room_w - 0.8, z0 + 2.3};
        char name[32];
        snprintf(name, sizeof name, "Room %u", i);
        uint32_t cell = make_box(m, make_room(m, name, ENF_ROOM_INTERIOR), ENF_NONE, x0, 0, z0, x0 + room_w, depth, z0 + height);
        make_thick_opening(m, cell, yard, 1, 0, -wall, lo, hi, make_opening(m, 'W', i, ENF_OPENING_WINDOW, ENF_STATE_GLASS));
    }
}

/* ---- City ---------------------------------------------------------------------------------------------------- */
/* Streets round N x N blocks of houses, solid, 9 to 40 m high; bicycles, benches and trees in the streets. One cell. */
static void build_city(Maker *m, uint32_t n) {
    const double pitch = 40, street = 12;
    uint32_t room = make_room(m, "Town", ENF_ROOM_INTERIOR);
    uint32_t cell = make_box(m, room, ENF_NONE, -street, -street, 0, n * pitch, n * pitch, 60);
    for (uint32_t i = 0; i < n * n && m->status == ENF_OK; i++) {
        double x = (i % n) * pitch, y = (i / n) * pitch, side = pitch - street;
        double bounds[6] = {x, y, 0, x + side, y + side, rng_range(&m->rng, 9, 40)};
        uint32_t object;
        m->status = enf_scene_add_object(m->scene, "", bounds, &cell, 1, ENF_NONE, &object);
        if (m->status == ENF_OK)
            m->status = enf_scene_set_occluder(m->scene, object, NULL, 0, NULL, 0);
        int solid = m->occluders;
        m->occluders = 0; /* what stands in the streets hides nothing worth it */
        make_objects(m, cell, 15, x, y - street, 0, x + side, y, 4);
        make_objects(m, cell, 15, x - street, y, 0, x, y + side, 4);
        m->occluders = solid;
    }
}

EnfStatus enf_family_build(const char *spec, EnfScene **out_scene) {
    const char *colon = strchr(spec, ':');
    unsigned long n = colon ? strtoul(colon + 1, NULL, 10) : 0;
    if (!colon || n == 0 || n > 10000000ul)
        return ENF_ERROR_INVALID_ARGUMENT;
    size_t length = (size_t)(colon - spec);
    Maker m = {NULL, ENF_OK, {(uint64_t)spec_value(spec, "seed", 1)}, {1, 0}, {0, 0}, 0};
    m.occluders = spec_value(spec, "occluders", 0) != 0;
    int outdoors = spec_value(spec, "outdoors", 1) != 0;
    m.status = enf_scene_create(&m.scene);
    if (m.status != ENF_OK)
        return m.status;
    uint32_t count = (uint32_t)n;
    if (length == 6 && strncmp(spec, "office", 6) == 0)
        build_office(&m, count, spec);
    else if (length == 4 && strncmp(spec, "grid", 4) == 0)
        build_grid(&m, count, spec);
    else if (length == 7 && strncmp(spec, "columns", 7) == 0)
        build_columns(&m, count, spec);
    else if (length == 4 && strncmp(spec, "ring", 4) == 0)
        build_ring(&m, count);
    else if (length == 3 && strncmp(spec, "hub", 3) == 0)
        build_hub(&m, count, spec);
    else if (length == 8 && strncmp(spec, "enfilade", 8) == 0)
        build_enfilade(&m, count, spec);
    else if (length == 5 && strncmp(spec, "tower", 5) == 0)
        build_tower(&m, count, spec);
    else if (length == 5 && strncmp(spec, "court", 5) == 0)
        build_court(&m, count, spec);
    else if (length == 4 && strncmp(spec, "town", 4) == 0)
        build_town(&m, count, spec);
    else if (length == 4 && strncmp(spec, "city", 4) == 0)
        build_city(&m, count);
    else if (length == 6 && strncmp(spec, "facade", 6) == 0) {
        build_facade(&m, count);
        outdoors = 0; /* the yard is all there is of it */
    } else {
        char name[16];
        snprintf(name, sizeof name, "%.*s", (int)(length < 15 ? length : 15), spec);
        m.status = enf_hostile_build(name, count, (uint32_t)spec_value(spec, "detail", 0), m.scene);
    }
    if (m.status == ENF_OK && outdoors)
        m.status = enf_scene_decompose_exterior(m.scene, NULL, NULL);
    if (m.status != ENF_OK) {
        enf_scene_destroy(m.scene);
        return m.status;
    }
    *out_scene = m.scene;
    return ENF_OK;
}
