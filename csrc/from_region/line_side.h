/* SPDX-License-Identifier: GPL-3.0-or-later
 * Lines in Pluecker coordinates and their side products, with bounds on every rounding.
 *
 * A directed line through p, q: (d, m) = (q - p, p x q). side(a, b) = d_a . m_b + d_b . m_a: which way two lines pass each
 * other, 0 when they meet. A six-vector is a line iff side(x, x) = 0 (the Klein quadric). Based on: Teller 1992, section 2.
 *
 * A bounded vector is a computed value with a bound on its distance from the exact one, component by component: structural
 * zeros keep bound 0, so that what is exactly degenerate is known to be. Bounds assume round to nearest and no underflow of
 * consequence (components are kept near 1). */
#ifndef ENF_FROM_REGION_LINE_SIDE_H
#define ENF_FROM_REGION_LINE_SIDE_H

#include <math.h>

/* Unit roundoff, and the factor by which computed bounds are raised so that their own rounding can't lower them. */
#define ENF_ROUNDOFF    0x1p-53
#define ENF_BOUND_SLACK (1 + 0x1p-40)

typedef struct EnfBoundedLine {
    double x[6]; /* d, m */
    double e[6]; /* |exact - x| <= e */
} EnfBoundedLine;

/* What a row (an edge, as a linear function of lines) says of a line, and a bound on the error. The row holds (m, d) of the
 * edge, so that the product is a plain dot product. n products and sums: gamma_7 covers the six-term dot product. */
static inline double enf_row_value(const EnfBoundedLine *row, const EnfBoundedLine *line, double *out_error) {
    double value = 0, error = 0, size = 0;
    for (int k = 0; k < 6; ++k) {
        double product = row->x[k] * line->x[k];
        value += product;
        size += fabs(product);
        error += fabs(row->x[k]) * line->e[k] + row->e[k] * (fabs(line->x[k]) + line->e[k]);
    }
    *out_error = (error + 7 * ENF_ROUNDOFF * size) * ENF_BOUND_SLACK;
    return value;
}

/* side(a, b) of two bounded lines. */
static inline double enf_line_side(const EnfBoundedLine *a, const EnfBoundedLine *b, double *out_error) {
    double value = 0, error = 0, size = 0;
    for (int k = 0; k < 6; ++k) {
        int o = k < 3 ? k + 3 : k - 3;
        double product = a->x[k] * b->x[o];
        value += product;
        size += fabs(product);
        error += fabs(a->x[k]) * b->e[o] + a->e[k] * (fabs(b->x[o]) + b->e[o]);
    }
    *out_error = (error + 7 * ENF_ROUNDOFF * size) * ENF_BOUND_SLACK;
    return value;
}

/* out = f a + g b for factors known up to ef, eg; scaled by a power of two so that the largest component is near 1. */
static inline void enf_line_combine(double f, double ef, const EnfBoundedLine *a, double g, double eg, const EnfBoundedLine *b,
                                    EnfBoundedLine *out) {
    double largest = 0, af = fabs(f), ag = fabs(g);
    for (int k = 0; k < 6; ++k) {
        double p = f * a->x[k], q = g * b->x[k], value = p + q;
        double error = af * a->e[k] + ef * (fabs(a->x[k]) + a->e[k]) + ag * b->e[k] + eg * (fabs(b->x[k]) + b->e[k]) +
                       3 * ENF_ROUNDOFF * (fabs(p) + fabs(q));
        out->x[k] = value, out->e[k] = error * ENF_BOUND_SLACK;
        if (fabs(value) > largest)
            largest = fabs(value);
    }
    if (!(largest > 0) || !isfinite(largest))
        return;
    int exponent;
    (void)frexp(largest, &exponent);
    double scale = ldexp(1.0, -exponent); /* exact */
    for (int k = 0; k < 6; ++k)
        out->x[k] *= scale, out->e[k] *= scale;
}

#endif
