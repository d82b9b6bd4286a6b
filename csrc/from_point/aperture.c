/* SPDX-License-Identifier: GPL-3.0-or-later
 * Convex screen polygons: clipping, hulls, containment, outward simplification.
 * Based on: Sutherland & Hodgman 1974 (clipping), Andrew 1979 (monotone chain). */
#include "from_point/aperture.h"

#include <math.h>

EnfPoly *enf_poly_clip(EnfPoly *poly, EnfPoly *other, const EnfCorner *corners, uint32_t lines) {
    double d[ENF_POLY_MAX];
    for (const EnfCorner *line = corners; lines; line++, lines >>= 1) {
        if (!(lines & 1))
            continue;
        const uint32_t n = poly->n;
        uint32_t inside = 0;
        /* A line without direction (a = b = 0, c = 0) gives 0: inside. */
        for (uint32_t i = 0; i < n; i++) {
            d[i] = line->a * poly->x[i] + line->b * poly->y[i] + line->c;
            inside += d[i] >= 0;
        }
        if (inside == n)
            continue;
        if (inside == 0) {
            poly->n = 0;
            return poly;
        }
        uint32_t m = 0;
        for (uint32_t i = 0, before = n - 1; i < n; before = i++) {
            if ((d[i] >= 0) != (d[before] >= 0) && m < ENF_POLY_MAX) {
                /* From the inner end, so that the new corner errs by a rounding of the inner coordinates. */
                uint32_t in = d[i] >= 0 ? i : before, out = d[i] >= 0 ? before : i;
                double t = d[in] / (d[in] - d[out]);
                other->x[m] = poly->x[in] + t * (poly->x[out] - poly->x[in]);
                other->y[m] = poly->y[in] + t * (poly->y[out] - poly->y[in]);
                m++;
            }
            if (d[i] >= 0 && m < ENF_POLY_MAX) {
                other->x[m] = poly->x[i];
                other->y[m] = poly->y[i];
                m++;
            }
        }
        other->n = m;
        EnfPoly *swap = poly;
        poly = other;
        other = swap;
    }
    return poly;
}

void enf_poly_hull(EnfPoly *poly) {
    const uint32_t n = poly->n;
    double x[ENF_POLY_MAX], y[ENF_POLY_MAX], hx[ENF_POLY_MAX * 2], hy[ENF_POLY_MAX * 2];
    if (n < 3)
        return;
    for (uint32_t i = 0; i < n; i++) { /* insertion sort: few points, often nearly sorted */
        double px = poly->x[i], py = poly->y[i];
        uint32_t j = i;
        while (j > 0 && (x[j - 1] > px || (x[j - 1] == px && y[j - 1] > py))) {
            x[j] = x[j - 1];
            y[j] = y[j - 1];
            j--;
        }
        x[j] = px;
        y[j] = py;
    }
    uint32_t m = 0;
    for (uint32_t i = 0; i < n; i++) {
        while (m >= 2 && (hx[m - 1] - hx[m - 2]) * (y[i] - hy[m - 2]) - (hy[m - 1] - hy[m - 2]) * (x[i] - hx[m - 2]) <= 0)
            m--;
        hx[m] = x[i];
        hy[m++] = y[i];
    }
    uint32_t lower = m + 1;
    for (uint32_t i = n - 1; i-- > 0;) {
        while (m >= lower && (hx[m - 1] - hx[m - 2]) * (y[i] - hy[m - 2]) - (hy[m - 1] - hy[m - 2]) * (x[i] - hx[m - 2]) <= 0)
            m--;
        hx[m] = x[i];
        hy[m++] = y[i];
    }
    m--; /* the last is the first again */
    for (uint32_t i = 0; i < m; i++) {
        poly->x[i] = hx[i];
        poly->y[i] = hy[i];
    }
    poly->n = m;
}

/* First and last corner in the order by x, then y. */
static void ends_of(const EnfCorner *c, uint32_t n, uint32_t *first, uint32_t *last) {
    *first = *last = 0;
    for (uint32_t i = 1; i < n; i++) {
        if (c[i].x < c[*first].x || (c[i].x == c[*first].x && c[i].y < c[*first].y))
            *first = i;
        if (c[i].x > c[*last].x || (c[i].x == c[*last].x && c[i].y > c[*last].y))
            *last = i;
    }
}

/* One half of the hull: both polygons' chains from corner i to corner end, merged by x (ascending, or descending for the
 * upper half), keeping left turns. Gives the number of corners, 0 when a chain isn't sorted: rounding can leave it so by a hair,
 * which a search for left turns takes for a corner that the hull must have. */
static uint32_t hull_half(const EnfCorner *a, uint32_t na, uint32_t ia, uint32_t ea, const EnfCorner *b, uint32_t nb, uint32_t ib,
                          uint32_t eb, double sign, double *hx, double *hy) {
    uint32_t m = 0;
    int more_a = 1, more_b = 1;
    double last_x = 0, last_y = 0;
    while (more_a || more_b) {
        int take_a = more_a;
        if (more_a && more_b) {
            double d = sign * (a[ia].x - b[ib].x);
            take_a = d != 0 ? d < 0 : sign * (a[ia].y - b[ib].y) < 0;
        }
        double x, y;
        if (take_a) {
            x = a[ia].x;
            y = a[ia].y;
            more_a = ia != ea;
            ia = ia + 1 < na ? ia + 1 : 0;
        } else {
            x = b[ib].x;
            y = b[ib].y;
            more_b = ib != eb;
            ib = ib + 1 < nb ? ib + 1 : 0;
        }
        if (m > 0 && (sign * (x - last_x) < 0 || (x == last_x && sign * (y - last_y) < 0)))
            return 0;
        last_x = x;
        last_y = y;
        while (m >= 2 && (hx[m - 1] - hx[m - 2]) * (y - hy[m - 2]) - (hy[m - 1] - hy[m - 2]) * (x - hx[m - 2]) <= 0)
            m--;
        if (m == 1 && hx[0] == x && hy[0] == y)
            continue;
        hx[m] = x;
        hy[m++] = y;
    }
    return m;
}

void enf_corners_hull(const EnfCorner *a, uint32_t na, const EnfCorner *b, uint32_t nb, EnfPoly *out) {
    uint32_t a0, a1, b0, b1;
    ends_of(a, na, &a0, &a1);
    ends_of(b, nb, &b0, &b1);
    /* Lower half from left to right, then the upper one back; each ends where the other begins. */
    uint32_t lower = hull_half(a, na, a0, a1, b, nb, b0, b1, 1, out->x, out->y);
    uint32_t n = lower > 1 ? lower - 1 : lower, upper = hull_half(a, na, a1, a0, b, nb, b1, b0, -1, out->x + n, out->y + n);
    out->n = n + upper;
    if (out->n > 1)
        out->n--;
    if (lower == 0 || upper == 0) {
        out->n = 0;
        enf_poly_append(out, a, na);
        enf_poly_append(out, b, nb);
        enf_poly_hull(out);
    }
}

/* Shorter edges have no sure direction: clipping may be off by 1e-12 at either end. */
static const double sure_edge = 1e-6;
enum { TURNS_LEFT, TURNS_RIGHT, TURNS_NOBODY_KNOWS };

/* How the outline turns at corner i; unknown also where it turns back onto itself. */
static int turn_at(const EnfPoly *poly, uint32_t i) {
    const uint32_t n = poly->n, a = (i + n - 1) % n, b = (i + 1) % n;
    double ax = poly->x[i] - poly->x[a], ay = poly->y[i] - poly->y[a], bx = poly->x[b] - poly->x[i], by = poly->y[b] - poly->y[i];
    double along = ax * bx + ay * by, aside = ax * by - ay * bx;
    if (fabs(ax) + fabs(ay) < sure_edge || fabs(bx) + fabs(by) < sure_edge || (along <= 0 && fabs(aside) <= -1e-5 * along))
        return TURNS_NOBODY_KNOWS;
    return aside > 0 ? TURNS_LEFT : TURNS_RIGHT;
}

/* Takes corner i out when the outline turns inward there; 0: that doesn't mend it. */
static int mend_turn(EnfPoly *poly, uint32_t i) {
    int turn = turn_at(poly, i);
    if (turn != TURNS_RIGHT || poly->n < 4)
        return turn == TURNS_LEFT;
    poly->n--;
    for (uint32_t k = i; k < poly->n; k++) {
        poly->x[k] = poly->x[k + 1];
        poly->y[k] = poly->y[k + 1];
    }
    return turn_at(poly, (i + poly->n - 1) % poly->n) == TURNS_LEFT && turn_at(poly, i % poly->n) == TURNS_LEFT;
}

int enf_corners_join(const EnfCorner *a, uint32_t na, const EnfCorner *b, uint32_t nb, EnfPoly *out) {
    for (uint32_t i = 0; i < na; i++)
        for (uint32_t k = 0; k < nb; k++) {
            const uint32_t next = i + 1 < na ? i + 1 : 0, before = k > 0 ? k - 1 : nb - 1;
            if (a[i].x != b[k].x || a[i].y != b[k].y || a[next].x != b[before].x || a[next].y != b[before].y ||
                fabs(a[i].x - a[next].x) + fabs(a[i].y - a[next].y) < sure_edge)
                continue;
            /* Both wind the same way, so they lie on two sides of the edge. Round a from the edge's far end to its near one, then
             * round b back. */
            uint32_t n = 0;
            for (uint32_t j = 0, at = next; j < na; j++, at = at + 1 < na ? at + 1 : 0, n++) {
                out->x[n] = a[at].x;
                out->y[n] = a[at].y;
            }
            for (uint32_t j = 2, at = k + 1 < nb ? k + 1 : 0; j < nb; j++, at = at + 1 < nb ? at + 1 : 0, n++) {
                out->x[n] = b[at].x;
                out->y[n] = b[at].y;
            }
            out->n = n;
            return mend_turn(out, na - 1) && mend_turn(out, 0);
        }
    return 0;
}

double enf_poly_area(const EnfPoly *poly) {
    double sum = 0;
    for (uint32_t i = 2; i < poly->n; i++)
        sum += (poly->x[i - 1] - poly->x[0]) * (poly->y[i] - poly->y[0]) - (poly->x[i] - poly->x[0]) * (poly->y[i - 1] - poly->y[0]);
    return 0.5 * sum;
}

void enf_poly_rect(const EnfPoly *poly, double rect[4]) {
    double x0 = poly->x[0], x1 = x0, y0 = poly->y[0], y1 = y0;
    for (uint32_t i = 1; i < poly->n; i++) {
        x0 = enf_lesser(x0, poly->x[i]);
        x1 = enf_greater(x1, poly->x[i]);
        y0 = enf_lesser(y0, poly->y[i]);
        y1 = enf_greater(y1, poly->y[i]);
    }
    rect[0] = x0;
    rect[1] = y0;
    rect[2] = x1;
    rect[3] = y1;
}

int enf_poly_is_sliver(const EnfPoly *poly, double area, const double rect[4]) {
    if (poly->n < 3)
        return 1;
    double length = (rect[2] - rect[0]) + (rect[3] - rect[1]);
    /* length is the rectangle's, at most 1.42 times the polygon's: drops a little less than ENF_SLIVER says
     * for diagonal ones would drop more, so the constant is halved. */
    return !(area > 0.5 * ENF_SLIVER * length);
}

/* Where the edges beside edge i (from corner i to i + 1) meet when extended over it; 0 when they don't meet nearby. */
static int edge_removal(const EnfPoly *poly, uint32_t i, double *x, double *y, double *added) {
    const uint32_t n = poly->n, a = (i + n - 1) % n, b = (i + 1) % n, c = (i + 2) % n;
    double d1x = poly->x[i] - poly->x[a], d1y = poly->y[i] - poly->y[a];
    double d2x = poly->x[b] - poly->x[c], d2y = poly->y[b] - poly->y[c];
    double ex = poly->x[b] - poly->x[i], ey = poly->y[b] - poly->y[i];
    double cross = d1x * d2y - d1y * d2x;
    /* Counter-clockwise and convex: the extensions meet outside when they turn by less than half a turn. */
    double scale = (fabs(d1x) + fabs(d1y)) * (fabs(d2x) + fabs(d2y));
    if (!(cross < 0 ? -cross > 1e-3 * scale : cross > 1e-3 * scale))
        return 0;
    double s = (ex * d2y - ey * d2x) / cross, t = (ex * d1y - ey * d1x) / cross;
    if (!(s >= 0 && t >= 0))
        return 0;
    *x = poly->x[i] + s * d1x;
    *y = poly->y[i] + s * d1y;
    *added = 0.5 * fabs(ex * (*y - poly->y[i]) - ey * (*x - poly->x[i]));
    return 1;
}

static void remove_edge(EnfPoly *poly, uint32_t i, double x, double y) {
    uint32_t b = (i + 1) % poly->n;
    poly->x[i] = x;
    poly->y[i] = y;
    for (uint32_t k = b; k + 1 < poly->n; k++) {
        poly->x[k] = poly->x[k + 1];
        poly->y[k] = poly->y[k + 1];
    }
    poly->n--;
}

void enf_poly_tidy(EnfPoly *poly) {
    double x, y, added;
    if (poly->n > 4)
        for (uint32_t i = 0; i < poly->n && poly->n > 4;) {
            uint32_t b = (i + 1) % poly->n;
            double length = fabs(poly->x[b] - poly->x[i]) + fabs(poly->y[b] - poly->y[i]);
            /* Corners pulled apart by outset lines: an edge of 1e-12 says nothing. The new corner lies within 1e-6 of
             * the old ones (cross > 1e-3), outside. */
            if (length < 1e-9 && edge_removal(poly, i, &x, &y, &added))
                remove_edge(poly, i, x, y);
            else
                i++;
        }
    while (poly->n > ENF_APERTURE_CORNERS) {
        double best = INFINITY, best_x = 0, best_y = 0;
        uint32_t best_i = ENF_POLY_MAX;
        for (uint32_t i = 0; i < poly->n; i++)
            if (edge_removal(poly, i, &x, &y, &added) && added < best) {
                best = added;
                best_i = i;
                best_x = x;
                best_y = y;
            }
        if (best_i == ENF_POLY_MAX) {
            double rect[4];
            enf_poly_rect(poly, rect);
            enf_poly_from_rect(poly, rect);
            return;
        }
        remove_edge(poly, best_i, best_x, best_y);
    }
}

void enf_poly_store(const EnfPoly *poly, EnfCorner *corners) {
    for (uint32_t i = 0; i < poly->n; i++) {
        corners[i].x = poly->x[i];
        corners[i].y = poly->y[i];
    }
}

void enf_corners_outline(EnfCorner *corners, uint32_t n, const double rect[4], double outset) {
    const double diameter = (rect[2] - rect[0]) + (rect[3] - rect[1]);
    int short_edges = 0;
    for (uint32_t i = 0; i < n; i++) {
        EnfCorner *corner = &corners[i];
        const EnfCorner *next = &corners[i + 1 < n ? i + 1 : 0];
        double a = corner->y - next->y, b = next->x - corner->x, length = fabs(a) + fabs(b);
        short_edges |= length < 1e-3 * diameter;
        if (!(length > 1e-14)) { /* shorter than its own rounding: no direction, hence no constraint */
            corner->a = corner->b = corner->c = 0;
            continue;
        }
        corner->a = a;
        corner->b = b;
        corner->c = outset * length - (a * corner->x + b * corner->y);
    }
    /* The direction of a short edge is uncertain, and so is on which side of it its neighbours turn: then lines move out until
     * they support the polygon, by 4 roundings of the corners and the outset more. */
    for (uint32_t i = 0; i < n && short_edges; i++) {
        double lowest = INFINITY, a = corners[i].a, b = corners[i].b;
        for (uint32_t k = 0; k < n; k++)
            lowest = enf_lesser(lowest, a * corners[k].x + b * corners[k].y);
        corners[i].c = enf_greater(corners[i].c, outset * (fabs(a) + fabs(b)) + 1e-15 * diameter - lowest);
        if (a == 0 && b == 0)
            corners[i].c = 0;
    }
}

/* [Half screens] Outset lines may carry a corner out of the view by a hair; so much is left to it. */
#define SNAP_BEYOND 1e-11

/* On the grid, within the view. */
static double snap(double at, double lowest, double highest, int up) {
    double snapped = (up ? ceil(at * 32) : floor(at * 32)) / 32;
    return enf_lesser(enf_greater(snapped, lowest - SNAP_BEYOND), highest + SNAP_BEYOND);
}

void enf_poly_snap(EnfPoly *poly, const double view[4]) {
    EnfPoly grid, other;
    double rect[4];
    uint32_t i;
    /* Edges that were tidied away may leave corners far beyond the view: put onto its rim, they would take what lies beside them along. */
    const EnfCorner rim[4] = {{.a = 1, .c = SNAP_BEYOND - view[0]},
                              {.b = 1, .c = SNAP_BEYOND - view[1]},
                              {.a = -1, .c = SNAP_BEYOND + view[2]},
                              {.b = -1, .c = SNAP_BEYOND + view[3]}};
    const EnfPoly *seen = enf_poly_clip(poly, &other, rim, ENF_ALL_LINES(4));
    if (seen->n < 3) { /* nothing to go by */
        enf_poly_from_rect(poly, view);
        return;
    }
    grid.n = 0;
    for (i = 0; i < seen->n; i++) {
        if (grid.n + 4 > ENF_POLY_MAX)
            enf_poly_hull(&grid);
        if (grid.n + 4 > ENF_POLY_MAX)
            break;
        double x0 = snap(seen->x[i], view[0], view[2], 0), x1 = snap(seen->x[i], view[0], view[2], 1);
        double y0 = snap(seen->y[i], view[1], view[3], 0), y1 = snap(seen->y[i], view[1], view[3], 1);
        for (int k = 0; k < 4; k++) {
            grid.x[grid.n] = (k & 1) ? x1 : x0;
            grid.y[grid.n++] = (k & 2) ? y1 : y0;
        }
    }
    enf_poly_hull(&grid);
    if (i == seen->n && grid.n >= 3 && grid.n <= ENF_APERTURE_CORNERS) {
        poly->n = 0;
        for (i = 0; i < grid.n; i++, poly->n++) {
            poly->x[i] = grid.x[i];
            poly->y[i] = grid.y[i];
        }
        return;
    }
    /* Removing edges would leave the grid and with it the bound on the number of steps: take the rectangle. */
    enf_poly_rect(seen, rect);
    for (int k = 0; k < 4; k++)
        rect[k] = snap(rect[k], view[k % 2], view[2 + k % 2], k >= 2);
    for (int k = 0; k < 2; k++)
        if (rect[k] == rect[k + 2])
            rect[k + 2] += 1.0 / 32;
    enf_poly_from_rect(poly, rect);
}

void enf_poly_grow(EnfPoly *poly, double by) {
    EnfPoly grown;
    grown.n = 0;
    if (poly->n * 4 > ENF_POLY_MAX) {
        double rect[4];
        enf_poly_rect(poly, rect);
        for (int k = 0; k < 4; k++)
            rect[k] += k < 2 ? -by : by;
        enf_poly_from_rect(poly, rect);
        return;
    }
    for (uint32_t i = 0; i < poly->n; i++)
        for (int k = 0; k < 4; k++) {
            grown.x[grown.n] = poly->x[i] + ((k & 1) ? by : -by);
            grown.y[grown.n++] = poly->y[i] + ((k & 2) ? by : -by);
        }
    enf_poly_hull(&grown);
    poly->n = grown.n;
    for (uint32_t i = 0; i < grown.n; i++) {
        poly->x[i] = grown.x[i];
        poly->y[i] = grown.y[i];
    }
}

void enf_poly_from_rect(EnfPoly *poly, const double rect[4]) {
    poly->n = 4;
    poly->x[0] = poly->x[3] = rect[0];
    poly->x[1] = poly->x[2] = rect[2];
    poly->y[0] = poly->y[1] = rect[1];
    poly->y[2] = poly->y[3] = rect[3];
}

void enf_poly_append(EnfPoly *poly, const EnfCorner *corners, uint32_t count) {
    for (uint32_t i = 0; i < count && poly->n < ENF_POLY_MAX; i++) {
        poly->x[poly->n] = corners[i].x;
        poly->y[poly->n] = corners[i].y;
        poly->n++;
    }
}
