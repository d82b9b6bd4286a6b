/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rows and rays of the stabbing cone as whole numbers (GMP). */
#include "from_region/stab_exact.h"

#include <gmp.h>
#include <stdlib.h>

#include "base/memory.h"

typedef mpz_t Whole6[6];

struct EnfExactLines {
    Whole6 rows[ENF_CONE_ROWS], rays[ENF_CONE_RAYS];
    uint8_t row_made[ENF_CONE_ROWS], ray_made[ENF_CONE_RAYS];
    mpz_t sum, term, a, b;
};

/* GMP itself ends the process when memory runs out; the table of numbers is asked for in the same way. */
static EnfExactLines *exact_of(EnfStabCone *cone) {
    if (!cone->exact) {
        cone->exact = ENF_NEW(EnfExactLines, 1);
        if (!cone->exact)
            abort();
        mpz_inits(cone->exact->sum, cone->exact->term, cone->exact->a, cone->exact->b, NULL);
    }
    return cone->exact;
}

void enf_exact_destroy(EnfExactLines *exact) {
    if (!exact)
        return;
    for (uint32_t i = 0; i < ENF_CONE_ROWS; ++i)
        for (int k = 0; k < 6 && exact->row_made[i]; ++k)
            mpz_clear(exact->rows[i][k]);
    for (uint32_t i = 0; i < ENF_CONE_RAYS; ++i)
        for (int k = 0; k < 6 && exact->ray_made[i]; ++k)
            mpz_clear(exact->rays[i][k]);
    mpz_clears(exact->sum, exact->term, exact->a, exact->b, NULL);
    enf_free(exact);
}

static mpz_t *row_of(EnfStabCone *cone, uint32_t index) {
    EnfExactLines *x = exact_of(cone);
    EnfConeRow *row = &cone->rows[index];
    mpz_t *out = x->rows[index];
    if (!x->row_made[index]) {
        for (int k = 0; k < 6; ++k)
            mpz_init(out[k]);
        x->row_made[index] = 1;
    }
    if (row->exact_known)
        return out;
    row->exact_known = 1;
    if (!row->is_edge) {
        for (int k = 0; k < 6; ++k)
            mpz_set_d(out[k], row->whole[k]);
        return out;
    }
    const double *p = row->whole, *q = row->whole + 3;
    for (int k = 0; k < 3; ++k) { /* m = p x q, then d = q - p in the same unit: one more step length */
        int i = (k + 1) % 3, j = (k + 2) % 3;
        mpz_set_d(x->a, p[i]), mpz_set_d(x->b, q[j]);
        mpz_mul(out[k], x->a, x->b);
        mpz_set_d(x->a, p[j]), mpz_set_d(x->b, q[i]);
        mpz_submul(out[k], x->a, x->b);
        mpz_set_d(out[k + 3], q[k] - p[k]);
        mpz_mul_2exp(out[k + 3], out[k + 3], ENF_CONE_CORNER_BITS);
    }
    return out;
}

static void dot(mpz_t out, mpz_t *row, mpz_t *line) {
    mpz_mul(out, row[0], line[0]);
    for (int k = 1; k < 6; ++k)
        mpz_addmul(out, row[k], line[k]);
}

/* side(a, b) */
static void side(mpz_t out, mpz_t *a, mpz_t *b) {
    mpz_mul(out, a[0], b[3]);
    for (int k = 1; k < 6; ++k)
        mpz_addmul(out, a[k], b[k < 3 ? k + 3 : k - 3]);
}

/* The ray's bounded line anew: the exact numbers, rounded once. */
static void refresh(EnfStabCone *cone, uint32_t index) {
    EnfConeRay *ray = &cone->rays[index];
    mpz_t *v = cone->exact->rays[index];
    double mantissa[6];
    long exponent[6], largest = 0;
    int any = 0;
    for (int k = 0; k < 6; ++k) {
        mantissa[k] = mpz_get_d_2exp(&exponent[k], v[k]);
        if (mantissa[k] != 0 && (!any || exponent[k] > largest))
            largest = exponent[k], any = 1;
    }
    for (int k = 0; k < 6; ++k) {
        long shift = exponent[k] - largest;
        double size = ldexp(mantissa[k], shift < -1000 ? -1000 : (int)shift);
        ray->line.x[k] = mantissa[k] == 0 ? 0 : size;
        /* Cut off, not rounded: up to two roundoffs; what is 1000 bits smaller than another is as good as its bound. */
        ray->line.e[k] = mantissa[k] == 0 ? 0 : shift < -1000 ? 2 * fabs(size) : 2 * ENF_ROUNDOFF * fabs(size);
    }
    ray->exponent = (int)largest;
}

static mpz_t *ray_of(EnfStabCone *cone, uint32_t index) {
    EnfExactLines *x = exact_of(cone);
    EnfConeRay *ray = &cone->rays[index];
    mpz_t *out = x->rays[index];
    if (!x->ray_made[index]) {
        for (int k = 0; k < 6; ++k)
            mpz_init(out[k]);
        x->ray_made[index] = 1;
    }
    if (ray->exact_known)
        return out;
    ray->exact_known = 1; /* parents were made before: no circle */
    if (ray->row == ENF_CONE_ROWS) {
        mpz_t *from = ray->negative == ENF_NONE ? NULL : ray_of(cone, ray->negative);
        for (int k = 0; k < 6; ++k)
            if (from)
                mpz_neg(out[k], from[k]);
            else
                mpz_set_ui(out[k], (unsigned)k == ray->positive);
        refresh(cone, index);
        return out;
    }
    mpz_t *p = ray_of(cone, ray->positive), *n = ray_of(cone, ray->negative), *row = row_of(cone, ray->row);
    dot(x->a, row, p);
    dot(x->b, row, n);
    mpz_set_ui(x->sum, 0);
    for (int k = 0; k < 6; ++k) {
        mpz_mul(out[k], x->a, n[k]);
        mpz_submul(out[k], x->b, p[k]);
        mpz_gcd(x->sum, x->sum, out[k]);
    }
    if (mpz_cmp_ui(x->sum, 1) > 0)
        for (int k = 0; k < 6; ++k)
            mpz_divexact(out[k], out[k], x->sum);
    refresh(cone, index);
    return out;
}

int enf_exact_row_sign(EnfStabCone *cone, uint32_t row, uint32_t ray, double *value, double *error) {
    mpz_t *line = ray_of(cone, ray), *function = row_of(cone, row);
    EnfExactLines *x = cone->exact;
    dot(x->sum, function, line);
    long exponent;
    double mantissa = mpz_get_d_2exp(&exponent, x->sum);
    /* In the units of the bounded lines. Never below 2^-1000, which no product of theirs resolves. */
    long shift = exponent - cone->rays[ray].exponent - cone->rows[row].exponent;
    *value = mantissa == 0 ? 0 : ldexp(mantissa, shift < -1000 ? -1000 : (int)shift);
    *error = shift < -1000 ? 0.5 * fabs(*value) : 2 * ENF_ROUNDOFF * fabs(*value);
    return mpz_sgn(x->sum);
}

int enf_exact_side_sign(EnfStabCone *cone, uint32_t a, uint32_t b) {
    mpz_t *p = ray_of(cone, a), *q = ray_of(cone, b);
    side(cone->exact->sum, p, q);
    return mpz_sgn(cone->exact->sum);
}

int enf_exact_changes_between(EnfStabCone *cone, uint32_t a, uint32_t b) {
    mpz_t *p = ray_of(cone, a), *q = ray_of(cone, b);
    EnfExactLines *x = cone->exact;
    side(x->sum, p, p);
    side(x->term, q, q);
    mpz_mul(x->term, x->term, x->sum);
    side(x->sum, p, q);
    mpz_mul(x->sum, x->sum, x->sum);
    return mpz_cmp(x->sum, x->term) > 0;
}
