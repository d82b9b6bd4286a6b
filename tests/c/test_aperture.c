/* SPDX-License-Identifier: GPL-3.0-or-later
 * Apertures' polygons: whatever is joined, hulled or tidied contains what went in; both twins of a test give equal bits. */
#include "from_point/aperture.h"
#include "from_point/block_tree.h"
#include "from_point/cut_lines.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static uint64_t state = 7;
static double unit(void) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) * 0x1p-53;
}

/* The hull of some random points. */
static void random_polygon(EnfPoly *poly, uint32_t points) {
    do {
        double size = pow(10, -3 * unit()), x = unit() - 0.5, y = unit() - 0.5;
        poly->n = points;
        for (uint32_t i = 0; i < points; i++) {
            poly->x[i] = x + size * (unit() - 0.5);
            poly->y[i] = y + size * (unit() - 0.5);
        }
        enf_poly_hull(poly);
    } while (poly->n < 3);
}

static uint32_t store(const EnfPoly *poly, EnfCorner *corners) {
    double rect[4];
    enf_poly_rect(poly, rect);
    enf_poly_store(poly, corners);
    enf_corners_outline(corners, poly->n, rect, ENF_LINE_OUTSET);
    return poly->n;
}

/* Whether lines drawn round the polygon leave all the corners in. */
static int holds(const EnfPoly *poly, const EnfCorner *corners, uint32_t count) {
    EnfCorner lines[ENF_POLY_MAX];
    uint32_t n = store(poly, lines);
    for (uint32_t k = 0; k < n; k++)
        for (uint32_t i = 0; i < count; i++)
            if (lines[k].a * corners[i].x + lines[k].b * corners[i].y + lines[k].c < 0)
                return 0;
    return 1;
}

static void insert(EnfPoly *p, uint32_t at, double x, double y) {
    memmove(p->x + at + 1, p->x + at, sizeof *p->x * (p->n - at));
    memmove(p->y + at + 1, p->y + at, sizeof *p->y * (p->n - at));
    p->x[at] = x;
    p->y[at] = y;
    p->n++;
}

static void halve_common_edge(EnfPoly *a, EnfPoly *b, double twice) {
    for (uint32_t i = 0; i < a->n; i++)
        for (uint32_t k = 0; k < b->n; k++) {
            uint32_t next = (i + 1) % a->n, beside = (k + 1) % b->n;
            if (a->x[i] != b->x[beside] || a->y[i] != b->y[beside] || a->x[next] != b->x[k] || a->y[next] != b->y[k])
                continue;
            double x = 0.5 * (a->x[i] + a->x[next]), y = 0.5 * (a->y[i] + a->y[next]);
            if (twice != 0)
                insert(a, i + 1, x + twice * (a->x[i] - x) + twice * (unit() - 0.5), y + twice * (a->y[i] - y));
            insert(a, twice > 0 ? i + 2 : i + 1, x, y);
            insert(b, k + 1, x, y);
            return;
        }
}

/* A polygon cut in two, as portals cut what is seen: corners are the same to the bit, or off by an outset, or doubled. */
static void what_is_joined_contains_both(void **unused) {
    uint32_t joined = 0, spread = 0;
    (void)unused;
    for (uint32_t round = 0; round < 40000; round++) {
        EnfPoly whole, halves[2], other, out;
        EnfCorner corners[2][ENF_POLY_MAX], line;
        uint32_t count[2];
        random_polygon(&whole, 3 + (uint32_t)(6 * unit()));
        double angle = 6.28318530718 * unit(), at = unit();
        double px = whole.x[0] + at * (whole.x[whole.n / 2] - whole.x[0]), py = whole.y[0] + at * (whole.y[whole.n / 2] - whole.y[0]);
        line = (EnfCorner){0, 0, cos(angle), sin(angle), -(cos(angle) * px + sin(angle) * py)};
        int ok = 1;
        for (int h = 0; h < 2; h++) {
            EnfPoly copy = whole;
            halves[h] = *enf_poly_clip(&copy, &other, &line, 1);
            ok &= halves[h].n >= 3 && halves[h].n <= ENF_APERTURE_CORNERS;
            line.a = -line.a;
            line.b = -line.b;
            line.c = -line.c;
        }
        if (!ok)
            continue;
        if (round % 5 == 1 || round % 5 == 2) { /* off by an outset; a facade that bends */
            for (uint32_t i = 0; i < halves[0].n; i++)
                if (unit() < 0.3) {
                    halves[0].x[i] += (round % 5 == 1 ? 1e-12 : 1e-3) * (unit() - 0.5);
                    halves[0].y[i] += (round % 5 == 1 ? 1e-12 : 1e-3) * (unit() - 0.5);
                }
            enf_poly_hull(&halves[0]);
            if (halves[0].n < 3)
                continue;
        }
        if (round % 5 >= 3) /* a corner in the middle of the common edge, in one of them twice */
            halve_common_edge(&halves[0], &halves[1], round % 5 == 4 ? 1e-12 * (unit() - 0.5) : 0);
        for (int h = 0; h < 2; h++)
            count[h] = store(&halves[h], corners[h]);
        enf_corners_hull(corners[0], count[0], corners[1], count[1], &out);
        for (int h = 0; h < 2; h++)
            assert_true(holds(&out, corners[h], count[h]));
        if (!enf_corners_join(corners[0], count[0], corners[1], count[1], &out))
            continue;
        joined++;
        spread += round % 5 == 1 || round % 5 == 2;
        enf_poly_tidy(&out);
        for (int h = 0; h < 2; h++)
            assert_true(holds(&out, corners[h], count[h]));
        double sum = enf_poly_area(&halves[0]) + enf_poly_area(&halves[1]);
        assert_true(enf_poly_area(&out) > sum * (1 - 1e-9) - 1e-12);
    }
    assert_true(joined > 10000 && spread > 1000);
}

static void both_twins_cut_alike(void **unused) {
    EnfCutLines scalar = enf_cut_lines(0), fast = enf_cut_lines(1);
    uint32_t seen[3] = {0, 0, 0};
    (void)unused;
    for (uint32_t round = 0; round < 20000; round++) {
        EnfPoly one, two, copy, other;
        EnfCorner lines[ENF_POLY_MAX];
        random_polygon(&one, 3 + (uint32_t)(12 * unit()));
        random_polygon(&two, 3 + (uint32_t)(8 * unit()));
        enf_poly_tidy(&two);
        uint32_t count = store(&two, lines), cut = scalar(one.x, one.y, one.n, lines, count);
        assert_int_equal(cut, fast(one.x, one.y, one.n, lines, count));
        seen[cut == 0 ? 0 : (cut & ENF_CUT_AWAY) ? 2 : 1]++;
        copy = one;
        EnfPoly *all = enf_poly_clip(&copy, &other, lines, ENF_ALL_LINES(count));
        if (cut & ENF_CUT_AWAY)
            assert_int_equal(all->n, 0);
        else if (cut == 0)
            assert_true(all == &copy && copy.n == one.n);
        else { /* the lines that don't cut add nothing */
            EnfPoly again = one, spare;
            EnfPoly *some = enf_poly_clip(&again, &spare, lines, cut);
            assert_int_equal(some->n, all->n);
        }
    }
    assert_true(seen[0] > 100 && seen[1] > 100 && seen[2] > 100);
}

/* Boxes whose centre is surely inside: both twins, and the half-spaces themselves. */
static void a_sure_centre_is_inside(void **unused) {
    EnfBoxesTest scalar = enf_boxes_test(0), fast = enf_boxes_test(1);
    uint32_t sure = 0, unsure = 0;
    (void)unused;
    for (uint32_t round = 0; round < 5000; round++) {
        double boxes[8][6], n[6][3], d[6], reach = pow(10, 4 * unit());
        EnfTreeItem order[8];
        EnfBoxes8 block;
        EnfPlanes planes;
        planes.count = 0;
        planes.loose = round % 16 == 0;
        for (int k = 0; k < 8; k++)
            for (int c = 0; c < 3; c++) {
                boxes[k][c] = reach * (1.8 * unit() - 0.95);
                boxes[k][3 + c] = boxes[k][c] + 0.05 * reach * unit();
            }
        enf_tree_build((const double(*)[6])boxes, 8, order, &block);
        for (int k = 0; k < 6; k++) {
            double through = unit() < 0.5; /* exactly through a box's middle: neither in nor out */
            for (int c = 0; c < 3; c++)
                n[k][c] = unit() - 0.5;
            d[k] = reach * unit();
            for (int c = 0; c < 3 && through > 0; c++)
                d[k] = (c ? d[k] : 0) - n[k][c] * 0.5 * (boxes[0][c] + boxes[0][3 + c]);
            enf_planes_add(&planes, n[k], d[k], reach);
        }
        uint16_t masks[2];
        scalar(&block, 1, &planes, &masks[0]);
        fast(&block, 1, &planes, &masks[1]);
        assert_int_equal(masks[0], masks[1]);
        for (uint32_t lane = 0; lane < 8; lane++) {
            double least = INFINITY;
            for (int k = 0; k < 6; k++) {
                double s = d[k];
                for (int c = 0; c < 3; c++)
                    s += n[k][c] * 0.5 * (boxes[order[lane].at][c] + boxes[order[lane].at][3 + c]);
                least = fmin(least, s);
            }
            int said = masks[0] >> (8 + lane) & 1;
            assert_true(!said || (masks[0] >> lane & 1));
            assert_true(!said || (least >= 0 && !planes.loose));
            assert_true(least < 0 || (masks[0] >> lane & 1));
            sure += (uint32_t)said;
            unsure += !said && least >= 0 && !planes.loose;
        }
    }
    assert_true(sure > 500 && unsure < sure);
}

/* Ovals of many corners, small and large, some reaching far beyond the view: what of them is in the view stays. */
static void what_is_put_on_the_grid_is_kept(void **state_unused) {
    (void)state_unused;
    uint32_t beyond = 0, few = 0;
    for (uint32_t round = 0; round < 20000; round++) {
        const double view[4] = {-1, round % 2 ? -1 : -0.7, 1, round % 2 ? 1 : 0.3};
        const double middle[2] = {2.4 * unit() - 1.2, 2.4 * unit() - 1.2}, size = pow(10, -2 * unit());
        EnfPoly poly, snapped;
        poly.n = 3 + (uint32_t)(90 * unit());
        for (uint32_t i = 0; i < poly.n; i++) {
            const double turn = 6.283185307 * i / poly.n;
            poly.x[i] = middle[0] + size * cos(turn);
            poly.y[i] = middle[1] + (round % 3 ? 1 : 0.2) * size * sin(turn);
        }
        snapped = poly;
        enf_poly_snap(&snapped, view);
        few += snapped.n > 4 && poly.n > ENF_POLY_MAX / 4;
        for (int k = 0; k < 20; k++) {
            const uint32_t a = (uint32_t)(poly.n * unit()), b = (uint32_t)(poly.n * unit());
            const double t = k ? unit() : 0, x = poly.x[a] + t * (poly.x[b] - poly.x[a]), y = poly.y[a] + t * (poly.y[b] - poly.y[a]);
            beyond += x > view[2];
            if (x < view[0] || y < view[1] || x > view[2] || y > view[3])
                continue;
            for (uint32_t e = 0; e < snapped.n; e++) {
                const uint32_t f = (e + 1) % snapped.n;
                const double ex = snapped.x[f] - snapped.x[e], ey = snapped.y[f] - snapped.y[e];
                assert_true(ex * (y - snapped.y[e]) - ey * (x - snapped.x[e]) > -1e-12);
            }
        }
    }
    assert_true(beyond > 20000 && few > 500);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_joined_contains_both),
        cmocka_unit_test(both_twins_cut_alike),
        cmocka_unit_test(a_sure_centre_is_inside),
        cmocka_unit_test(what_is_put_on_the_grid_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
