/* SPDX-License-Identifier: GPL-3.0-or-later
 * Families of portal chains: doors in line, equal sills, slits, turned walls, n-gons, near-coplanar planes, corners, tiny next to
 * huge. About half of every family can be looked through. */
#include "chain_families.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* A rectangle in the plane x = at, y and z ranges given. */
static void door(Chain *chain, double at, double y0, double y1, double z0, double z1) {
    ChainPortal *p = &chain->portals[chain->portal_count++];
    const double corners[4][3] = {{at, y0, z0}, {at, y1, z0}, {at, y1, z1}, {at, y0, z1}};
    p->corner_count = 4;
    memcpy(p->corners, corners, sizeof corners);
    p->forward[0] = 1, p->forward[1] = 0, p->forward[2] = 0;
}

/* A regular polygon about `centre` in the plane of u and v. */
static void polygon(Chain *chain, uint32_t corners, const double centre[3], const double u[3], const double v[3], double ru, double rv,
                    double phase, const double forward[3]) {
    ChainPortal *p = &chain->portals[chain->portal_count++];
    p->corner_count = corners;
    for (uint32_t i = 0; i < corners; i++) {
        double a = phase + 2 * pi * i / corners;
        for (int k = 0; k < 3; k++)
            p->corners[i][k] = centre[k] + ru * cos(a) * u[k] + rv * sin(a) * v[k];
    }
    memcpy(p->forward, forward, sizeof p->forward);
}

static uint32_t some_walls(Random *random, uint32_t lo, uint32_t hi) {
    return lo + random_index(random, hi - lo + 1);
}

static double slit_width(Random *random) { /* 1 micrometre to 10 cm, evenly in the logarithm; half of them blocked */
    double w = pow(10, random_between(random, -6, -1));
    return random_bits(random) & 1 ? w : -w;
}

static void aligned(Random *random, Chain *out) {
    uint32_t walls = some_walls(random, 3, 10);
    double block = random_bits(random) & 1 ? 0 : 1 + random_unit(random);
    for (uint32_t i = 0; i < walls; i++)
        door(out, 4.0 * i, i == walls / 2 ? block : 0, i == walls / 2 ? 1 + block : 1, 0, 2.125);
}

static void equal_sills(Random *random, Chain *out) {
    uint32_t walls = some_walls(random, 3, 8);
    for (uint32_t i = 0; i < walls; i++) {
        double y = 0.125 * (double)random_index(random, 9);
        door(out, 3.0 * i, y, y + 1, 0, 2);
    }
}

static void symmetric_slit(Random *random, Chain *out) {
    double w = slit_width(random);
    door(out, 0, 0, 1, 0, 2);
    door(out, 1, 1 - w, 2, 0, 2);
    door(out, 2, 0, 1, 0, 2);
    if (random_bits(random) & 1)
        door(out, 3, 1 - w, 2, 0, 2);
}

static void slit_in_height(Random *random, Chain *out) {
    double w = slit_width(random);
    door(out, 0, 0, 1, 0, 2);
    door(out, 2, 0, 1, 2 - w, 4);
    door(out, 4, 0, 1, 0, 2);
}

static void collinear_edges(Random *random, Chain *out) { /* touch in one line, exactly: nothing passes strictly */
    uint32_t walls = some_walls(random, 3, 6);
    for (uint32_t i = 0; i < walls; i++) {
        int other = i & 1;
        if (random_index(random, 8) == 0)
            other = !other;
        door(out, 2.0 * i, other ? 1 : 0, other ? 2 : 1, 0, 2);
    }
}

static void turned_walls(Random *random, Chain *out) {
    uint32_t walls = some_walls(random, 3, 7);
    double y = 0, heading = 0, x = 0;
    for (uint32_t i = 0; i < walls; i++) {
        double turn = heading + random_between(random, -0.7, 0.7), w = random_between(random, 0.3, 1.2);
        double u[3] = {-sin(turn), cos(turn), 0}, v[3] = {0, 0, 1}, f[3] = {cos(turn), sin(turn), 0};
        double c[3] = {x, y, 1.0};
        ChainPortal *p = &out->portals[out->portal_count++];
        p->corner_count = 4;
        const double s[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
        for (int a = 0; a < 4; a++)
            for (int k = 0; k < 3; k++)
                p->corners[a][k] = c[k] + 0.5 * w * s[a][0] * u[k] + s[a][1] * v[k];
        memcpy(p->forward, f, sizeof f);
        heading += random_between(random, -0.25, 0.25);
        x += 3 * cos(heading), y += 3 * sin(heading);
    }
}

static void tilted_polygons(Random *random, Chain *out) {
    uint32_t walls = some_walls(random, 3, 5);
    for (uint32_t i = 0; i < walls; i++) {
        double a = random_between(random, -0.5, 0.5), b = random_between(random, -0.5, 0.5);
        double f[3] = {cos(a) * cos(b), sin(a) * cos(b), sin(b)}, u[3] = {-sin(a), cos(a), 0};
        double v[3] = {-cos(a) * sin(b), -sin(a) * sin(b), cos(b)};
        double c[3] = {3.0 * i, random_between(random, -0.6, 0.6), random_between(random, -0.6, 0.6)};
        polygon(out, 3 + random_index(random, 5), c, u, v, random_between(random, 0.3, 0.9), random_between(random, 0.3, 0.9),
                random_between(random, 0, 6), f);
    }
}

/* Long thin slots at random angles: no pair of them blocks the other, only lines that meet three or four at once decide. */
static void skew_slots(Random *random, Chain *out) {
    uint32_t walls = some_walls(random, 3, 6);
    for (uint32_t i = 0; i < walls; i++) {
        double a = random_between(random, 0, pi), thin = pow(10, random_between(random, -5, -0.7));
        double u[3] = {0, cos(a), sin(a)}, v[3] = {0, -sin(a), cos(a)}, f[3] = {1, 0, 0};
        double c[3] = {1.0 + 2.0 * i, random_between(random, -0.3, 0.3), random_between(random, -0.3, 0.3)};
        polygon(out, 4, c, u, v, 1.0, thin, pi / 4, f);
    }
}

static void near_parallel(Random *random, Chain *out) {
    uint32_t walls = some_walls(random, 3, 5);
    double tilt = pow(10, random_between(random, -9, -3)), w = slit_width(random);
    for (uint32_t i = 0; i < walls; i++) {
        double t = tilt * random_between(random, -1, 1);
        ChainPortal *p;
        door(out, 0.5 * i, i & 1 ? 1 - w : 0, i & 1 ? 2 : 1, 0, 2);
        p = &out->portals[out->portal_count - 1];
        for (int a = 0; a < 4; a++)
            p->corners[a][0] += t * p->corners[a][1];
    }
}

static void near_coplanar(Random *random, Chain *out) { /* walls a hair apart */
    uint32_t walls = some_walls(random, 3, 6);
    double gap = pow(10, random_between(random, -5, -1));
    for (uint32_t i = 0; i < walls; i++) {
        double y = random_between(random, 0, 0.55), z = random_between(random, 0, 0.55);
        door(out, gap * i, y, y + 0.5, z, z + 0.5);
    }
}

static void round_the_corner(Random *random, Chain *out) { /* portals in planes x = 1 and y = 1 share the edge (1, 1, z) */
    double w = slit_width(random);
    const double first[4][3] = {{1, 0, 0}, {1, 1, 0}, {1, 1, 2}, {1, 0, 2}};
    const double second[4][3] = {{2, 1, 0}, {1, 1, 0}, {1, 1, 2}, {2, 1, 2}};
    door(out, 0, 1 - fabs(w) - random_unit(random), w > 0 ? 1 - 0.25 * w : 1 - 2 * fabs(w), 0, 2);
    ChainPortal *p = &out->portals[out->portal_count++];
    p->corner_count = 4;
    memcpy(p->corners, first, sizeof first);
    p->forward[0] = 1, p->forward[1] = p->forward[2] = 0;
    p = &out->portals[out->portal_count++];
    p->corner_count = 4;
    memcpy(p->corners, second, sizeof second);
    p->forward[0] = 0, p->forward[1] = 1, p->forward[2] = 0;
    /* and one more behind it, low or high */
    double z = random_bits(random) & 1 ? 0 : 1.5, x = 1 + random_unit(random);
    const double third[4][3] = {{x + 1, 2, z}, {x, 2, z}, {x, 2, z + 1}, {x + 1, 2, z + 1}};
    p = &out->portals[out->portal_count++];
    p->corner_count = 4;
    memcpy(p->corners, third, sizeof third);
    p->forward[0] = 0, p->forward[1] = 1, p->forward[2] = 0;
}

static void tiny_beside_huge(Random *random, Chain *out) {
    double tiny = pow(10, random_between(random, -4, -2));
    uint32_t walls = some_walls(random, 3, 6);
    for (uint32_t i = 0; i < walls; i++) {
        if (i & 1) {
            door(out, 20.0 * i, -50, 50, 0, 30);
        } else {
            double y = random_between(random, -1, 1) * (i < 3 ? 20 : 2 * tiny), z = random_between(random, 1, 2);
            door(out, 20.0 * i, y, y + tiny, z, z + tiny);
        }
    }
}

static void stairs(Random *random, Chain *out) { /* doors and slab holes in turn */
    double w = slit_width(random);
    const double hole[4][3] = {{2, 0, 3}, {4, 0, 3}, {4, 1, 3}, {2, 1, 3}};
    door(out, 0, 0, 1, 0, 2);
    door(out, 1, 0, 1, 0, 2 + 0.5 * random_unit(random));
    ChainPortal *p = &out->portals[out->portal_count++];
    p->corner_count = 4;
    memcpy(p->corners, hole, sizeof hole);
    p->forward[0] = p->forward[1] = 0, p->forward[2] = 1;
    /* the steepest line rises from (0, 0) over ... to the door above; w moves that door across the limit */
    double top = 3 + (5 - 2) * (3.0 - 0) / (2 - 0);
    door(out, 5, 0, 1, w > 0 ? top - w - 1 : top - w, top - w + 1);
}

static void common_edges(Random *random, Chain *out) { /* a grid: every coordinate from a few numbers, edges meet everywhere */
    uint32_t walls = some_walls(random, 3, 8);
    for (uint32_t i = 0; i < walls; i++) {
        double y = (double)random_index(random, 3), z = (double)random_index(random, 3);
        door(out, (double)i, y, y + 1 + (double)random_index(random, 2), z, z + 1 + (double)random_index(random, 2));
    }
}

const ChainFamily chain_families[] = {
    {"aligned", 1, aligned},
    {"equal-sills", 1, equal_sills},
    {"symmetric-slit", 1, symmetric_slit},
    {"slit-in-height", 1, slit_in_height},
    {"collinear-edges", 1, collinear_edges},
    {"common-edges", 1, common_edges},
    {"round-the-corner", 1, round_the_corner},
    {"near-parallel", 1, near_parallel},
    {"near-coplanar", 1, near_coplanar},
    {"stairs", 1, stairs},
    {"turned-walls", 0, turned_walls},
    {"tilted-polygons", 0, tilted_polygons},
    {"skew-slots", 0, skew_slots},
    {"tiny-beside-huge", 0, tiny_beside_huge},
};
const uint32_t chain_family_count = sizeof chain_families / sizeof *chain_families;

const char *const chain_variant_names[VARIANT_COUNT] = {"rotate", "far", "scale", "reverse", "rewind", "split"};

/* A random rotation from a random quaternion (Shoemake 1992). */
static void random_rotation(Random *random, double m[3][3]) {
    double a = random_unit(random), b = 2 * pi * random_unit(random), c = 2 * pi * random_unit(random);
    double x = sqrt(1 - a) * sin(b), y = sqrt(1 - a) * cos(b), z = sqrt(a) * sin(c), w = sqrt(a) * cos(c);
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    memcpy(m, r, sizeof r);
}

static void turn(double m[3][3], double v[3]) {
    double r[3];
    for (int i = 0; i < 3; i++)
        r[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    memcpy(v, r, sizeof r);
}

int chain_vary(uint32_t variant, Random *random, const Chain *chain, Chain *out) {
    *out = *chain;
    switch (variant) {
    case VARIANT_ROTATE: {
        double m[3][3];
        random_rotation(random, m);
        for (uint32_t p = 0; p < out->portal_count; p++) {
            turn(m, out->portals[p].forward);
            for (uint32_t i = 0; i < out->portals[p].corner_count; i++)
                turn(m, out->portals[p].corners[i]);
        }
        break;
    }
    case VARIANT_FAR: {
        /* whole metres: what moves is the place, not (much of) the shape */
        double by[3] = {floor(random_between(random, -1e7, 1e7)), floor(random_between(random, -1e7, 1e7)), 100};
        for (uint32_t p = 0; p < out->portal_count; p++)
            for (uint32_t i = 0; i < out->portals[p].corner_count; i++)
                for (int k = 0; k < 3; k++)
                    out->portals[p].corners[i][k] += by[k];
        break;
    }
    case VARIANT_SCALE: {
        double by = ldexp(1, (int)(random_bits(random) % 21) - 10); /* a power of two from 1e-3 to 1e3: exact */
        for (uint32_t p = 0; p < out->portal_count; p++)
            for (uint32_t i = 0; i < out->portals[p].corner_count; i++)
                for (int k = 0; k < 3; k++)
                    out->portals[p].corners[i][k] *= by;
        break;
    }
    case VARIANT_REVERSE:
        for (uint32_t p = 0; p < out->portal_count; p++) {
            out->portals[p] = chain->portals[out->portal_count - 1 - p];
            for (int k = 0; k < 3; k++)
                out->portals[p].forward[k] = -out->portals[p].forward[k];
        }
        break;
    case VARIANT_REWIND:
        for (uint32_t p = 0; p < out->portal_count; p++) {
            uint32_t n = out->portals[p].corner_count, start = random_index(random, n);
            int back = random_bits(random) & 1;
            for (uint32_t i = 0; i < n; i++)
                memcpy(out->portals[p].corners[i], chain->portals[p].corners[(back ? start + n - i : start + i) % n], sizeof(double[3]));
        }
        break;
    case VARIANT_SPLIT: {
        if (out->portal_count >= CHAIN_MAX_PORTALS)
            return 0;
        /* a seam as wide as the whole scene, parallel to the first portal, halfway to the second where both are parallel doors */
        const ChainPortal *a = &chain->portals[0], *b = &chain->portals[1];
        if (a->corner_count != 4 || b->corner_count != 4 || a->forward[0] != 1 || b->forward[0] != 1)
            return 0;
        double x0 = -INFINITY, x1 = INFINITY;
        for (int i = 0; i < 4; i++)
            x0 = fmax(x0, a->corners[i][0]), x1 = fmin(x1, b->corners[i][0]);
        if (!(x0 < x1))
            return 0;
        memmove(&out->portals[2], &chain->portals[1], sizeof *a * (chain->portal_count - 1));
        out->portal_count = 1;
        door(out, 0.5 * (x0 + x1), -100, 100, -100, 100);
        out->portal_count = chain->portal_count + 1;
        break;
    }
    default:
        return 0;
    }
    return 1;
}
