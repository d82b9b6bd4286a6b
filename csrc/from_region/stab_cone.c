/* SPDX-License-Identifier: GPL-3.0-or-later
 * Double description of a stabbing cone with proven bounds, and its meeting with the Klein quadric.
 *
 * Invariant: for each extremal ray of the exact cone there is a computed ray whose bounds hold it. Where a sign is lost in
 * rounding the ray is treated both ways: kept, and combined. Superfluous rays enlarge the cone: the safe direction. */
#include "from_region/stab_cone.h"

#include <string.h>

#include "from_region/pair_table.h"

void enf_cone_begin(EnfStabCone *cone) {
    cone->row_count = cone->ray_count = cone->place_count = 0;
    cone->ambiguous = cone->dropped_rows = 0;
}

void enf_cone_add_edge(EnfStabCone *cone, const double a[3], const double b[3], double plane_error, uint32_t place) {
    if (cone->row_count == ENF_CONE_ROWS || (cone->place_count == ENF_CONE_PLACES && cone->last_place != place)) {
        ++cone->dropped_rows;
        return;
    }
    EnfBoundedLine *row = &cone->rows[cone->row_count];
    double largest = 0;
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        double p = a[i] * b[j], q = a[j] * b[i];
        row->x[k] = p - q;
        row->e[k] = 2 * ENF_ROUNDOFF * (fabs(p) + fabs(q)) + plane_error;
        row->x[k + 3] = b[k] - a[k];
        row->e[k + 3] = ENF_ROUNDOFF * fabs(row->x[k + 3]) + plane_error;
        if (fabs(row->x[k + 3]) > largest) largest = fabs(row->x[k + 3]);
    }
    if (!(largest > 0)) return; /* a doubled corner bounds nothing */
    int exponent;
    (void)frexp(largest, &exponent);
    double scale = ldexp(1.0, -exponent);
    for (int k = 0; k < 6; ++k) row->x[k] *= scale, row->e[k] *= scale;
    if (!cone->place_count || cone->last_place != place) {
        memset(cone->place_rows[cone->place_count++], 0, sizeof *cone->place_rows);
        cone->last_place = place;
    }
    cone->row_portal[cone->row_count] = cone->place_count - 1;
    cone->place_rows[cone->place_count - 1][cone->row_count >> 6] |= (uint64_t)1 << (cone->row_count & 63);
    ++cone->row_count;
}

/* What follows exactly from the rows a ray is known to lie on. The rows of one portal are lines of one plane, and three of
 * them span all lines of it: a six-vector on three lies on all, and is a line of that plane. A line of plane P on two rows
 * of another portal is the line where the two planes meet (the rows meet P in different points: corners are scattered so that
 * none lies in another portal's plane), so it lies on all rows of that portal too. No rounding can blur this.
 * Gives the portals in whose planes the ray lies, and adds their rows among `applied` to `tight`. */
static uint64_t complete_tight(const EnfStabCone *cone, const uint64_t applied[2], uint64_t tight[2]) {
    uint64_t planes = 0;
    for (uint32_t place = 0; place < cone->place_count; ++place) {
        const uint64_t *rows = cone->place_rows[place];
        if (enf_popcount64(tight[0] & rows[0]) + enf_popcount64(tight[1] & rows[1]) >= 3) planes |= (uint64_t)1 << place;
    }
    if (!planes) return 0;
    for (uint32_t place = 0; place < cone->place_count; ++place) {
        const uint64_t *rows = cone->place_rows[place];
        if (!(planes >> place & 1)) {
            if (enf_popcount64(tight[0] & rows[0]) + enf_popcount64(tight[1] & rows[1]) < 2) continue;
            planes |= (uint64_t)1 << place;
        }
        tight[0] |= rows[0] & applied[0], tight[1] |= rows[1] & applied[1];
    }
    return planes;
}

/* Whether a ray with these planes and tight rows lies on row `index` by construction. */
static int lies_on(const EnfStabCone *cone, uint32_t index, uint64_t planes, const uint64_t tight[2]) {
    uint32_t place = cone->row_portal[index];
    const uint64_t *rows = cone->place_rows[place];
    if (planes >> place & 1) return 1;
    int count = enf_popcount64(tight[0] & rows[0]) + enf_popcount64(tight[1] & rows[1]);
    return count >= 3 || (planes && count >= 2);
}

/* Turns a lineality vector into a ray when the row can tell it from zero. Gives 1 when it did. */
static int split_lineality(EnfStabCone *cone, uint32_t index, const EnfBoundedLine *row) {
    double value[6], error[6], best = 0;
    uint32_t pivot = 6;
    for (uint32_t i = 0; i < cone->lineality_count; ++i) {
        value[i] = enf_row_value(row, &cone->lineality[i], &error[i]);
        double margin = fabs(value[i]) - error[i];
        if (margin > best) best = margin, pivot = i;
    }
    if (pivot == 6) return 0;
    EnfBoundedLine l = cone->lineality[pivot];
    double lv = value[pivot], le = error[pivot];
    if (lv < 0) {
        lv = -lv;
        for (int k = 0; k < 6; ++k) l.x[k] = -l.x[k];
    }
    for (uint32_t i = 0; i < cone->lineality_count; ++i)
        if (i != pivot) {
            EnfBoundedLine moved;
            enf_line_combine(lv, le, &cone->lineality[i], -value[i], error[i], &l, &moved);
            cone->lineality[i] = moved;
        }
    cone->lineality[pivot] = cone->lineality[--cone->lineality_count];
    for (uint32_t i = 0; i < cone->ray_count; ++i) {
        EnfConeRay *r = &cone->rays[i];
        double e, v = enf_row_value(row, &r->line, &e);
        EnfBoundedLine moved;
        enf_line_combine(lv, le, &r->line, -v, e, &l, &moved);
        r->line = moved;
        r->tight[index >> 6] |= (uint64_t)1 << (index & 63);
        r->planes = complete_tight(cone, cone->applied, r->tight);
    }
    EnfConeRay *ray = &cone->rays[cone->ray_count++];
    memset(ray, 0, sizeof *ray);
    ray->line = l;
    memcpy(ray->tight, cone->applied, sizeof ray->tight);
    ray->planes = complete_tight(cone, cone->applied, ray->tight);
    ++cone->rays_made;
    return 1;
}

/* Two rays can only be adjacent when enough rows hold both; with all signs certain, when no third ray lies on those rows. */
static int may_be_adjacent(const EnfStabCone *cone, uint32_t a, uint32_t b, int needed, int certain) {
    const EnfConeRay *p = &cone->rays[a], *n = &cone->rays[b];
    uint64_t c0 = (p->tight[0] | p->maybe[0]) & (n->tight[0] | n->maybe[0]);
    uint64_t c1 = (p->tight[1] | p->maybe[1]) & (n->tight[1] | n->maybe[1]);
    if (enf_popcount64(c0) + enf_popcount64(c1) < needed) return 0;
    if (!certain) return 1;
    for (uint32_t k = 0; k < cone->ray_count; ++k)
        if (k != a && k != b && (c0 & ~cone->rays[k].tight[0]) == 0 && (c1 & ~cone->rays[k].tight[1]) == 0) return 0;
    return 1;
}

/* Cuts the cone by one row. Gives 0 when there are too many rays. */
static int cut(EnfStabCone *cone, uint32_t index) {
    const EnfBoundedLine *row = &cone->rows[index];
    uint64_t bit = (uint64_t)1 << (index & 63);
    uint32_t word = index >> 6, count = cone->ray_count, outside = 0;
    int lost = 0;
    for (uint32_t i = 0; i < count; ++i) {
        EnfConeRay *r = &cone->rays[i];
        r->value = enf_row_value(row, &r->line, &r->error);
        if (fabs(r->value) <= r->error && lies_on(cone, index, r->planes, r->tight)) r->value = r->error = 0;
        if (r->value == 0 && r->error == 0) {
            r->tight[word] |= bit;
            r->planes = complete_tight(cone, cone->applied, r->tight);
        }
        else if (fabs(r->value) <= r->error) r->maybe[word] |= bit, ++lost;
        else outside += r->value < 0;
    }
    cone->ambiguous += lost;
    if (!outside && !lost) return 1;
    int needed = (int)(6 - cone->lineality_count) - 2, certain = cone->ambiguous == 0;
    uint32_t made = count;
    for (uint32_t a = 0; a < count; ++a) {
        const EnfConeRay *p = &cone->rays[a];
        if ((p->tight[word] & bit) || p->value < -p->error) continue; /* inside, or maybe */
        for (uint32_t b = 0; b < count; ++b) {
            const EnfConeRay *n = &cone->rays[b];
            if (a == b || (n->tight[word] & bit) || n->value > n->error) continue; /* outside, or maybe */
            cone->ray_count = count;
            if (!may_be_adjacent(cone, a, b, needed, certain)) continue;
            if (made == ENF_CONE_RAYS) return 0;
            EnfConeRay *r = &cone->rays[made++];
            enf_line_combine(p->value, p->error, &n->line, -n->value, n->error, &p->line, &r->line);
            for (int k = 0; k < 2; ++k) {
                r->tight[k] = p->tight[k] & n->tight[k];
                r->maybe[k] = (p->tight[k] | p->maybe[k]) & (n->tight[k] | n->maybe[k]) & ~r->tight[k];
            }
            r->tight[word] |= bit;
            r->planes = complete_tight(cone, cone->applied, r->tight);
            r->maybe[0] &= ~r->tight[0], r->maybe[1] &= ~r->tight[1];
            r->value = 0, r->error = 0;
            ++cone->rays_made;
        }
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < made; ++i) {
        if (i < count && cone->rays[i].value < -cone->rays[i].error) continue;
        if (kept != i) cone->rays[kept] = cone->rays[i];
        ++kept;
    }
    cone->ray_count = kept;
    return 1;
}

/* Whether every positive combination of rays that is a line lies in some portal's plane (or there is none): all products of
 * two rays have one strict sign, but for pairs in a common plane, which are exactly zero. */
static int quadric_missed(const EnfStabCone *cone) {
    int sign = 0;
    for (uint32_t i = 0; i < cone->ray_count; ++i) {
        uint64_t shared = cone->rays[i].planes;
        for (uint32_t k = 0; k < cone->ray_count; ++k) {
            if (cone->rays[i].planes & cone->rays[k].planes) {
                if (k != i) shared &= cone->rays[k].planes; /* all zero partners of a ray must lie in one plane with it */
                continue;
            }
            if (k < i) continue;
            double error, value = enf_line_side(&cone->rays[i].line, &cone->rays[k].line, &error);
            if (fabs(value) <= error) return 0;
            int s = value > 0 ? 1 : -1;
            if (sign && s != sign) return 0;
            sign = s;
        }
        if (cone->rays[i].planes && !shared) return 0;
    }
    return 1;
}

static double product(const double a[6], const double b[6]) {
    return a[0] * b[3] + a[1] * b[4] + a[2] * b[5] + a[3] * b[0] + a[4] * b[1] + a[5] * b[2];
}

/* A point of the quadric on the segment from c (inside the cone) to y, where the two have opposite signs. */
static void meet_quadric(const double c[6], const double y[6], double out[6]) {
    double low = 0, high = 1, sign = product(c, c);
    for (int step = 0; step < 60; ++step) {
        double t = 0.5 * (low + high);
        for (int k = 0; k < 6; ++k) out[k] = (1 - t) * c[k] + t * y[k];
        if ((product(out, out) > 0) == (sign > 0)) low = t;
        else high = t;
    }
}

/* A line in the cone: from the centroid towards a ray, or a pair of rays, beyond the quadric. */
static int find_line(const EnfStabCone *cone, double out[6]) {
    double c[6] = {0, 0, 0, 0, 0, 0};
    for (uint32_t i = 0; i < cone->ray_count; ++i) {
        double size = 0;
        for (int k = 0; k < 6; ++k) size += cone->rays[i].line.x[k] * cone->rays[i].line.x[k];
        if (!(size > 0)) continue;
        for (int k = 0; k < 6; ++k) c[k] += cone->rays[i].line.x[k] / sqrt(size);
    }
    double q = product(c, c), far_value = 0, y[6];
    for (uint32_t i = 0; i < cone->ray_count; ++i)
        for (uint32_t k = i; k < cone->ray_count; ++k) {
            double sum[6];
            for (int j = 0; j < 6; ++j) sum[j] = cone->rays[i].line.x[j] + cone->rays[k].line.x[j];
            double value = product(sum, sum);
            /* The one furthest beyond: the line found then keeps away from the cone's boundary. */
            if ((q > 0 && value < far_value) || (q < 0 && value > far_value)) {
                far_value = value;
                memcpy(y, sum, sizeof y);
            }
        }
    if (far_value == 0) {
        if (q != 0) return 0;
        memcpy(out, c, sizeof c);
        return 1;
    }
    meet_quadric(c, y, out);
    return 1;
}

int enf_cone_solve(EnfStabCone *cone, double out_line[6]) {
    memset(cone->lineality, 0, sizeof cone->lineality);
    cone->lineality_count = 6, cone->ray_count = 0, cone->rays_made = 0;
    cone->applied[0] = cone->applied[1] = 0;
    for (int k = 0; k < 6; ++k) cone->lineality[k].x[k] = 1;
    uint64_t on_planes = 0; /* planes that hold the whole lineality */
    for (uint32_t i = 0; i < cone->row_count; ++i) {
        uint64_t bit = (uint64_t)1 << (i & 63);
        uint64_t on[2] = {cone->applied[0], cone->applied[1]};
        if (cone->lineality_count && !lies_on(cone, i, on_planes, on)) {
            int vague = 0;
            for (uint32_t k = 0; k < cone->lineality_count; ++k) {
                double error, value = enf_row_value(&cone->rows[i], &cone->lineality[k], &error);
                vague |= error > 0 && fabs(value) <= error;
            }
            if (split_lineality(cone, i, &cone->rows[i])) {
                cone->applied[i >> 6] |= bit;
                memcpy(on, cone->applied, sizeof on);
                on_planes = complete_tight(cone, cone->applied, on);
                continue;
            }
            if (vague) { /* can't be told from a direction of the lineality: left out, a larger cone */
                ++cone->dropped_rows;
                continue;
            }
        }
        if (!cut(cone, i)) return ENF_CONE_UNKNOWN;
        cone->applied[i >> 6] |= bit;
        if (!cone->ray_count && !cone->lineality_count) return ENF_CONE_EMPTY;
    }
    if (cone->lineality_count == 1) {
        /* Portals in parallel planes: the lineality is their common line at infinity, m along the normal (here z). Moving along
         * it reaches the quadric from any point with d_z > 0; with d_z <= 0 nothing crosses the portals. */
        const EnfBoundedLine *l = &cone->lineality[0];
        int aligned = 1;
        for (int k = 0; k < 5; ++k) aligned &= l->x[k] == 0 && l->e[k] == 0;
        if (!aligned) return ENF_CONE_UNKNOWN;
        double x[6] = {0, 0, 0, 0, 0, 0};
        int crossing = 0;
        for (uint32_t i = 0; i < cone->ray_count; ++i) {
            const EnfBoundedLine *r = &cone->rays[i].line;
            crossing |= r->x[2] > -r->e[2] && !(r->x[2] == 0 && r->e[2] == 0);
            /* Superfluous rays may point anywhere: only those that certainly go forward make the line. */
            for (int k = 0; k < 6 && r->x[2] > r->e[2]; ++k) x[k] += r->x[k];
        }
        if (!crossing) return ENF_CONE_EMPTY;
        if (!(x[2] > 0)) return ENF_CONE_UNKNOWN;
        x[5] = -(x[0] * x[3] + x[1] * x[4]) / x[2];
        memcpy(out_line, x, sizeof x);
        return ENF_CONE_STABBED;
    }
    if (cone->lineality_count) return ENF_CONE_UNKNOWN;
    if (quadric_missed(cone)) return ENF_CONE_EMPTY;
    return find_line(cone, out_line) ? ENF_CONE_STABBED : ENF_CONE_UNKNOWN;
}
