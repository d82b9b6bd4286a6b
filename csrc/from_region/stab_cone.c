/* SPDX-License-Identifier: GPL-3.0-or-later
 * Double description of a stabbing cone with exact signs, and its meeting with the Klein quadric.
 *
 * Let C be the closed cone of the rows and Q(x) = side(x, x) / 2. Lines are the zeros of Q. A line strictly inside all rows is an
 * interior point of C, and Q, being nondegenerate, has both signs around it; the other way round C's interior is connected, so
 * both strict signs in C make an interior zero. Hence: stabbed iff C has an interior and Q takes both signs on C. */
#include "from_region/stab_cone.h"

#include <string.h>

#include "base/bits.h"
#include "base/memory.h"
#include "from_region/stab_exact.h"

#define CORNER_BITS ENF_CONE_CORNER_BITS
#define NORMAL_BITS 50 /* grid of plain rows */

/* Halvings of the cone when signs of products don't settle it. */
#define SPLITS_MAX  256
#define SPLIT_DEPTH 60

EnfStabCone *enf_cone_create(void) {
    EnfStabCone *cone = ENF_NEW(EnfStabCone, 1); /* zeroes of the system: most of its rays are never touched */
    if (cone && !(cone->exact = enf_exact_create())) {
        enf_free(cone);
        return NULL;
    }
    return cone;
}

void enf_cone_destroy(EnfStabCone *cone) {
    if (cone)
        enf_exact_destroy(cone->exact);
    enf_free(cone);
}

void enf_cone_begin(EnfStabCone *cone) {
    cone->row_count = cone->dropped_rows = 0;
}

/* Scales the row by a power of two so that its largest coefficient is near 1. */
static void finish_row(EnfStabCone *cone, EnfConeRow *row, int exponent) {
    double largest = 0;
    for (int k = 0; k < 6; ++k)
        largest = fmax(largest, fabs(row->line.x[k]));
    if (!(largest > 0))
        return; /* a doubled corner bounds nothing */
    int shift;
    (void)frexp(largest, &shift);
    double scale = ldexp(1.0, -shift);
    for (int k = 0; k < 6; ++k)
        row->line.x[k] *= scale, row->line.e[k] *= scale;
    row->exponent = exponent + shift;
    row->exact_known = 0;
    ++cone->row_count;
}

void enf_cone_add_direction(EnfStabCone *cone, const double n[3]) {
    if (cone->row_count == ENF_CONE_ROWS) {
        ++cone->dropped_rows;
        return;
    }
    EnfConeRow *row = &cone->rows[cone->row_count];
    memset(row, 0, sizeof *row);
    for (int k = 0; k < 3; ++k) {
        row->whole[k] = nearbyint(ldexp(n[k], NORMAL_BITS));
        row->line.x[k] = ldexp(row->whole[k], -NORMAL_BITS);
    }
    finish_row(cone, row, NORMAL_BITS);
}

void enf_cone_add_edge(EnfStabCone *cone, const double a[3], const double b[3]) {
    if (cone->row_count == ENF_CONE_ROWS) {
        ++cone->dropped_rows;
        return;
    }
    EnfConeRow *row = &cone->rows[cone->row_count];
    double p[3], q[3];
    for (int k = 0; k < 3; ++k) {
        row->whole[k] = nearbyint(ldexp(a[k], CORNER_BITS)), row->whole[k + 3] = nearbyint(ldexp(b[k], CORNER_BITS));
        p[k] = ldexp(row->whole[k], -CORNER_BITS), q[k] = ldexp(row->whole[k + 3], -CORNER_BITS);
    }
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        double s = p[i] * q[j], t = p[j] * q[i];
        row->line.x[k] = s - t;
        /* 46-bit factors: two products and a difference, one rounding each. */
        row->line.e[k] = 2 * ENF_ROUNDOFF * (fabs(s) + fabs(t));
        row->line.x[k + 3] = q[k] - p[k]; /* exact */
        row->line.e[k + 3] = 0;
    }
    row->is_edge = 1;
    finish_row(cone, row, 2 * CORNER_BITS);
}

/* ---- Signs: the filter, then exact ---- */

/* The exact sign of a row at a ray. value, error (of the ray's bounded line) are such that |value| > error unless 0. */
static int row_sign(EnfStabCone *cone, uint32_t row, uint32_t ray, double *value, double *error) {
    EnfConeRay *r = &cone->rays[ray];
    *value = enf_row_value(&cone->rows[row].line, &r->line, error);
    ++cone->signs;
    if (fabs(*value) > *error)
        return *value > 0 ? 1 : -1;
    if (*error == 0)
        return 0;
    ++cone->unsure;
    return enf_exact_row_sign(cone, row, ray, value, error);
}

/* The exact sign of side(a, b). */
static int side_sign(EnfStabCone *cone, uint32_t a, uint32_t b) {
    double error, value = enf_line_side(&cone->rays[a].line, &cone->rays[b].line, &error);
    ++cone->signs;
    if (fabs(value) > error)
        return value > 0 ? 1 : -1;
    if (error == 0)
        return 0;
    ++cone->unsure;
    return enf_exact_side_sign(cone, a, b);
}

/* Whether side(a, b)^2 > side(a, a) side(b, b), where the first has one sign and both factors of the second the other or 0:
 * then Q changes its sign between a and b. */
static int changes_between(EnfStabCone *cone, uint32_t a, uint32_t b) {
    double e_ab, e_aa, e_bb, ab = enf_line_side(&cone->rays[a].line, &cone->rays[b].line, &e_ab);
    double aa = enf_line_side(&cone->rays[a].line, &cone->rays[a].line, &e_aa);
    double bb = enf_line_side(&cone->rays[b].line, &cone->rays[b].line, &e_bb);
    double low = fmax(0, fabs(ab) - e_ab), high = fabs(ab) + e_ab;
    double other_low = fmax(0, fabs(aa) - e_aa) * fmax(0, fabs(bb) - e_bb), other_high = (fabs(aa) + e_aa) * (fabs(bb) + e_bb);
    ++cone->signs;
    if (low * low > other_high * (1 + 8 * ENF_ROUNDOFF))
        return 1;
    if (high * high * (1 + 8 * ENF_ROUNDOFF) < other_low)
        return 0;
    ++cone->unsure;
    return enf_exact_changes_between(cone, a, b);
}

/* ---- Double description ---- */

static uint32_t new_ray(EnfStabCone *cone) {
    if (cone->ray_count == ENF_CONE_RAYS)
        return ENF_NONE;
    EnfConeRay *r = &cone->rays[cone->ray_count];
    memset(r->tight, 0, sizeof r->tight);
    r->exact_known = 0;
    ++cone->rays_made;
    return cone->ray_count++;
}

/* value(p) n - value(n) p, which lies on the row. The values are asked for again: an exact sign elsewhere may have scaled the
 * bounded lines anew since. */
static uint32_t combine(EnfStabCone *cone, uint32_t row, uint32_t p, uint32_t n) {
    uint32_t made = new_ray(cone);
    if (made == ENF_NONE)
        return made;
    EnfConeRay *r = &cone->rays[made];
    double pv, pe, nv, ne;
    (void)row_sign(cone, row, p, &pv, &pe);
    (void)row_sign(cone, row, n, &nv, &ne);
    enf_line_combine(pv, pe, &cone->rays[n].line, -nv, ne, &cone->rays[p].line, &r->line);
    r->positive = p, r->negative = n, r->row = row;
    return made;
}

/* Takes a direction out of the lineality that the row tells from zero. 1: done; 0: the row is zero on the lineality; -1: no room. */
static int split_lineality(EnfStabCone *cone, uint32_t row) {
    double value[6], error[6], best = 0;
    uint32_t pivot = 6;
    for (uint32_t i = 0; i < cone->lineality_count; ++i) {
        int sign = row_sign(cone, row, cone->lineality[i], &value[i], &error[i]);
        if (sign && (pivot == 6 || fabs(value[i]) > best))
            best = fabs(value[i]), pivot = i;
    }
    if (pivot == 6)
        return 0;
    uint32_t l = cone->lineality[pivot];
    if (value[pivot] < 0) {
        uint32_t reversed = new_ray(cone);
        if (reversed == ENF_NONE)
            return -1;
        EnfConeRay *r = &cone->rays[reversed];
        r->line = cone->rays[l].line;
        for (int k = 0; k < 6; ++k)
            r->line.x[k] = -r->line.x[k];
        r->positive = ENF_NONE, r->negative = l, r->row = ENF_CONE_ROWS;
        l = reversed;
    }
    for (uint32_t i = 0; i < cone->lineality_count; ++i)
        if (i != pivot && !(value[i] == 0 && error[i] == 0)) {
            cone->lineality[i] = combine(cone, row, l, cone->lineality[i]);
            if (cone->lineality[i] == ENF_NONE)
                return -1;
        }
    cone->lineality[pivot] = cone->lineality[--cone->lineality_count];
    uint64_t bit = (uint64_t)1 << (row & 63);
    for (uint32_t i = 0; i < cone->active_count; ++i) {
        double v, e;
        uint32_t old = cone->active[i];
        if (row_sign(cone, row, old, &v, &e)) {
            uint32_t moved = combine(cone, row, l, old);
            if (moved == ENF_NONE)
                return -1;
            memcpy(cone->rays[moved].tight, cone->rays[old].tight, sizeof cone->rays[moved].tight);
            cone->active[i] = moved;
        }
        cone->rays[cone->active[i]].tight[row >> 6] |= bit;
    }
    memcpy(cone->rays[l].tight, cone->applied, sizeof cone->applied);
    cone->active[cone->active_count++] = l;
    return 1;
}

/* Adjacent: enough rows hold both, and no third ray lies on all of those. */
static int are_adjacent(const EnfStabCone *cone, const uint32_t *active, uint32_t count, uint32_t a, uint32_t b) {
    const EnfConeRay *p = &cone->rays[a], *n = &cone->rays[b];
    uint64_t common[ENF_CONE_WORDS];
    int rows = 0, words = (int)(cone->row_count + 63) / 64;
    for (int k = 0; k < words; ++k)
        common[k] = p->tight[k] & n->tight[k], rows += enf_popcount64(common[k]);
    if (rows < (int)(6 - cone->lineality_count) - 2)
        return 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (active[i] == a || active[i] == b)
            continue;
        const uint64_t *tight = cone->rays[active[i]].tight;
        uint64_t missing = 0;
        for (int k = 0; k < words; ++k)
            missing |= common[k] & ~tight[k];
        if (!missing)
            return 0;
    }
    return 1;
}

/* Splits a cone by a row: the rays inside (and on it) and outside (and on it); outside may be NULL. Gives 0 when there are too
 * many rays. */
static int split(EnfStabCone *cone, uint32_t row, const uint32_t *active, uint32_t count, uint32_t *inside, uint32_t *inside_count,
                 uint32_t *outside, uint32_t *outside_count) {
    int8_t sign[ENF_CONE_ACTIVE];
    uint32_t kept = 0, out = 0;
    uint64_t bit = (uint64_t)1 << (row & 63);
    for (uint32_t i = 0; i < count; ++i) {
        double value, error;
        sign[i] = (int8_t)row_sign(cone, row, active[i], &value, &error);
        if (!sign[i])
            cone->rays[active[i]].tight[row >> 6] |= bit;
    }
    uint32_t first_made = cone->ray_count;
    for (uint32_t a = 0; a < count; ++a) {
        if (sign[a] <= 0)
            continue;
        for (uint32_t b = 0; b < count; ++b) {
            if (sign[b] >= 0 || !are_adjacent(cone, active, count, active[a], active[b]))
                continue;
            uint32_t made = combine(cone, row, active[a], active[b]);
            if (made == ENF_NONE)
                return 0;
            EnfConeRay *r = &cone->rays[made];
            for (int k = 0; k < ENF_CONE_WORDS; ++k)
                r->tight[k] = cone->rays[active[a]].tight[k] & cone->rays[active[b]].tight[k];
            r->tight[row >> 6] |= bit;
        }
    }
    uint32_t made = cone->ray_count - first_made;
    if (made + count > ENF_CONE_ACTIVE)
        return 0;
    /* `inside` may be the array of `active` itself: it is read before it is written over. */
    for (uint32_t i = 0; i < count; ++i) {
        if (outside && sign[i] <= 0)
            outside[out++] = active[i];
        if (sign[i] >= 0)
            inside[kept++] = active[i];
    }
    for (uint32_t i = 0; i < made; ++i) {
        inside[kept++] = first_made + i;
        if (outside)
            outside[out++] = first_made + i;
    }
    *inside_count = kept;
    if (outside)
        *outside_count = out;
    return 1;
}

/* No interior: all rays lie on one row. */
static int is_flat(const EnfStabCone *cone) {
    for (int k = 0; k < ENF_CONE_WORDS; ++k) {
        uint64_t common = cone->applied[k];
        for (uint32_t i = 0; i < cone->active_count; ++i)
            common &= cone->rays[cone->active[i]].tight[k];
        if (common)
            return 1;
    }
    return cone->active_count == 0;
}

/* ---- The quadric ---- */

typedef struct Meeting {
    EnfStabCone *cone;
    int sign; /* of Q, known to be taken */
    uint32_t splits;
    double beyond[6]; /* a vector of the cone where Q has the other sign */
} Meeting;

static void sum_of(const EnfStabCone *cone, uint32_t a, double fa, uint32_t b, double fb, double out[6]) {
    for (int k = 0; k < 6; ++k)
        out[k] = fa * cone->rays[a].line.x[k] + fb * cone->rays[b].line.x[k];
}

/* Q is known to change its sign between two rays: a vector where it has the other one. Q(s a + t b) is least at
 * s : t = sqrt(bb) : sqrt(aa), up to bounds that 0 needs. */
static void go_beyond(Meeting *meeting, uint32_t ray_a, uint32_t ray_b) {
    const EnfBoundedLine *a = &meeting->cone->rays[ray_a].line, *b = &meeting->cone->rays[ray_b].line;
    double e, ab = fabs(enf_line_side(a, b, &e)), aa = fabs(enf_line_side(a, a, &e)), bb = fabs(enf_line_side(b, b, &e));
    double s = sqrt(bb + 1e-300), t = sqrt(aa + 1e-300);
    if (aa == 0 && bb == 0)
        s = t = 1;
    else if (aa == 0)
        s = bb / ab, t = 1; /* 2 s t ab > t^2 bb */
    else if (bb == 0)
        s = 1, t = aa / ab;
    sum_of(meeting->cone, ray_a, s, ray_b, t, meeting->beyond);
}

/* Adds a row half way between two rays; there must be room for it. */
static uint32_t add_half_way(EnfStabCone *cone, uint32_t a, uint32_t b) {
    uint32_t row = cone->row_count++;
    EnfConeRow *h = &cone->rows[row];
    double size_a = 0, size_b = 0;
    for (int k = 0; k < 6; ++k) {
        size_a += cone->rays[a].line.x[k] * cone->rays[a].line.x[k];
        size_b += cone->rays[b].line.x[k] * cone->rays[b].line.x[k];
    }
    memset(h, 0, sizeof *h);
    for (int k = 0; k < 6; ++k) {
        double c = cone->rays[a].line.x[k] / sqrt(size_a) - cone->rays[b].line.x[k] / sqrt(size_b);
        h->whole[k] = nearbyint(ldexp(c, NORMAL_BITS));
        h->line.x[k] = ldexp(h->whole[k], -NORMAL_BITS);
    }
    h->exponent = NORMAL_BITS;
    return row;
}

/* How much two rays bend Q, whose side has the other sign. */
static double bend(const EnfStabCone *cone, uint32_t ray_a, uint32_t ray_b) {
    const EnfBoundedLine *a = &cone->rays[ray_a].line, *b = &cone->rays[ray_b].line;
    double e, ab = enf_line_side(a, b, &e), aa = fabs(enf_line_side(a, a, &e)), bb = fabs(enf_line_side(b, b, &e));
    return ab * ab / (aa * bb + 1e-300);
}

/* Whether Q takes the other sign on the cone of these rays. 1, 0, or -1: can't tell. */
static int takes_other_sign(Meeting *meeting, const uint32_t *active, uint32_t count, int depth) {
    EnfStabCone *cone = meeting->cone;
    double worst = 0;
    uint32_t worst_a = ENF_NONE, worst_b = ENF_NONE;
    for (uint32_t i = 0; i < count; ++i)
        if (side_sign(cone, active[i], active[i]) == -meeting->sign) {
            memcpy(meeting->beyond, cone->rays[active[i]].line.x, sizeof meeting->beyond);
            return 1;
        }
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t k = i + 1; k < count; ++k) {
            if (side_sign(cone, active[i], active[k]) != -meeting->sign)
                continue;
            if (changes_between(cone, active[i], active[k])) {
                go_beyond(meeting, active[i], active[k]);
                return 1;
            }
            double weight = bend(cone, active[i], active[k]);
            if (weight > worst)
                worst = weight, worst_a = active[i], worst_b = active[k];
        }
    if (worst_a == ENF_NONE)
        return 0;
    if (depth == SPLIT_DEPTH || ++meeting->splits > SPLITS_MAX || cone->row_count == ENF_CONE_ROWS)
        return -1;
    /* Split between the two rays that bend it most. */
    uint32_t row = add_half_way(cone, worst_a, worst_b);
    uint32_t inside[ENF_CONE_ACTIVE], outside[ENF_CONE_ACTIVE], n_in, n_out;
    double value, error;
    if (row_sign(cone, row, worst_a, &value, &error) <= 0 || row_sign(cone, row, worst_b, &value, &error) >= 0 ||
        !split(cone, row, active, count, inside, &n_in, outside, &n_out))
        return -1;
    int first = takes_other_sign(meeting, inside, n_in, depth + 1);
    if (first == 1)
        return 1;
    int second = takes_other_sign(meeting, outside, n_out, depth + 1);
    if (second == 1)
        return 1;
    return first < 0 || second < 0 ? -1 : 0;
}

static double product(const double a[6], const double b[6]) {
    return a[0] * b[3] + a[1] * b[4] + a[2] * b[5] + a[3] * b[0] + a[4] * b[1] + a[5] * b[2];
}

/* A point of the quadric on the segment from c (inside the cone) to y, where the two have opposite signs. */
static void meet_quadric(const double c[6], const double y[6], double out[6]) {
    double low = 0, high = 1, sign = product(c, c);
    for (int step = 0; step < 60; ++step) {
        double t = 0.5 * (low + high);
        for (int k = 0; k < 6; ++k)
            out[k] = (1 - t) * c[k] + t * y[k];
        if ((product(out, out) > 0) == (sign > 0))
            low = t;
        else
            high = t;
    }
}

static void centre_of(const EnfStabCone *cone, double c[6]) {
    memset(c, 0, 6 * sizeof *c);
    for (uint32_t i = 0; i < cone->active_count; ++i) {
        const double *x = cone->rays[cone->active[i]].line.x;
        double size = 0;
        for (int k = 0; k < 6; ++k)
            size += x[k] * x[k];
        for (int k = 0; k < 6 && size > 0; ++k)
            c[k] += x[k] / sqrt(size);
    }
}

/* Both signs are taken: a line of the cone, from its middle towards a vector where Q has the other sign than there. */
static void find_line(const Meeting *meeting, double out[6]) {
    const EnfStabCone *cone = meeting->cone;
    double c[6];
    centre_of(cone, c);
    double q = product(c, c), far_value = 0, y[6];
    memcpy(y, meeting->beyond, sizeof y);
    for (uint32_t i = 0; i < cone->active_count; ++i)
        for (uint32_t k = i; k < cone->active_count; ++k) {
            double sum[6];
            sum_of(cone, cone->active[i], 1, cone->active[k], 1, sum);
            double value = product(sum, sum);
            /* The one furthest beyond: the line found then keeps away from the cone's boundary. */
            if ((q > 0 && value < far_value) || (q < 0 && value > far_value))
                far_value = value, memcpy(y, sum, sizeof y);
        }
    if (q == 0)
        memcpy(out, c, sizeof c);
    else
        meet_quadric(c, y, out);
}

/* With a direction of lineality l: Q(x + t l) goes either way unless l is on the quadric and meets every ray. */
static int meet_lineality(EnfStabCone *cone, double out[6]) {
    uint32_t l = cone->lineality[0];
    if (cone->lineality_count > 1)
        return ENF_CONE_UNKNOWN;
    double c[6];
    const double *direction = cone->rays[l].line.x;
    centre_of(cone, c);
    int sign = 0;
    for (uint32_t i = 0; i < cone->active_count && !sign; ++i)
        sign = side_sign(cone, cone->active[i], l);
    if (!sign || side_sign(cone, l, l))
        return ENF_CONE_UNKNOWN;
    double slope = product(c, direction);
    if (slope == 0)
        return ENF_CONE_UNKNOWN;
    double t = -product(c, c) / (2 * slope);
    for (int k = 0; k < 6; ++k)
        out[k] = c[k] + t * direction[k];
    return ENF_CONE_STABBED;
}

static int solve(EnfStabCone *cone, double out_line[6]) {
    cone->ray_count = cone->active_count = 0;
    cone->lineality_count = 6;
    memset(cone->applied, 0, sizeof cone->applied);
    for (uint32_t k = 0; k < 6; ++k) {
        uint32_t axis = cone->lineality[k] = new_ray(cone);
        EnfConeRay *r = &cone->rays[axis];
        memset(&r->line, 0, sizeof r->line);
        r->line.x[k] = 1;
        r->positive = k, r->negative = ENF_NONE, r->row = ENF_CONE_ROWS;
    }
    for (uint32_t row = 0; row < cone->row_count; ++row) {
        int moved = cone->lineality_count ? split_lineality(cone, row) : 0;
        if (moved < 0)
            return ENF_CONE_UNKNOWN;
        if (!moved && !split(cone, row, cone->active, cone->active_count, cone->active, &cone->active_count, NULL, NULL))
            return ENF_CONE_UNKNOWN;
        cone->applied[row >> 6] |= (uint64_t)1 << (row & 63);
        if (!cone->active_count)
            return ENF_CONE_EMPTY;
    }
    if (is_flat(cone))
        return ENF_CONE_EMPTY;
    int answer = ENF_CONE_UNKNOWN;
    uint32_t rows = cone->row_count;
    if (cone->lineality_count)
        answer = meet_lineality(cone, out_line);
    else {
        Meeting meeting = {.cone = cone};
        for (uint32_t i = 0; i < cone->active_count && !meeting.sign; ++i)
            for (uint32_t k = i; k < cone->active_count && !meeting.sign; ++k)
                if (i == k ||
                    (side_sign(cone, cone->active[i], cone->active[i]) == 0 && side_sign(cone, cone->active[k], cone->active[k]) == 0))
                    meeting.sign = side_sign(cone, cone->active[i], cone->active[k]);
        if (!meeting.sign)
            return ENF_CONE_EMPTY; /* Q is zero on a cone with an interior: it can't be */
        int other = takes_other_sign(&meeting, cone->active, cone->active_count, 0);
        answer = other < 0 ? ENF_CONE_UNKNOWN : other ? ENF_CONE_STABBED : ENF_CONE_EMPTY;
        if (other > 0)
            find_line(&meeting, out_line);
    }
    cone->row_count = rows;
    if (answer == ENF_CONE_STABBED && cone->dropped_rows)
        answer = ENF_CONE_UNKNOWN;
    return answer;
}

int enf_cone_solve(EnfStabCone *cone, double out_line[6]) {
    cone->too_long = 0;
    int answer = solve(cone, out_line);
    return cone->too_long ? ENF_CONE_UNKNOWN : answer;
}
