/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rows and rays of the stabbing cone as whole numbers (GMP), all in memory the cone has from the beginning: GMP ends the process when
 * memory ends, so it is never let ask for any. */
#include "from_region/stab_exact.h"

#include <gmp.h>
#include <string.h>

#include "base/memory.h"

/* A ray without a common factor has minors of at most five rows for numbers. A row's are below 2^91 (corners within +-2 in steps of
 * 2^-44), five factors and 120 terms make 5 * 91 + 7 = 462 bits. A ray that is longer all the same is refused. */
#define RAY_LIMBS (512 / GMP_NUMB_BITS)
/* In between: a product of two sides, each of six products of two rays, is the longest, and GMP wants one limb to spare. */
#define WIDE_LIMBS (4 * RAY_LIMBS + 8)

/* Six whole numbers; a number's sign is that of its size, as in GMP. */
typedef struct WholeLine {
    mp_limb_t limbs[6][RAY_LIMBS];
    int sizes[6];
} WholeLine;

struct EnfExactLines {
    WholeLine rows[ENF_CONE_ROWS], rays[ENF_CONE_RAYS];
    mpz_t sum, term, a, b, line[6]; /* for what is being worked out; over `wide` */
    mp_limb_t wide[10][WIDE_LIMBS];
};

/* A number that GMP writes to in the place given, which it has no reason to leave: nothing grows beyond WIDE_LIMBS. */
static void place(mpz_t number, mp_limb_t limbs[WIDE_LIMBS]) {
    number->_mp_d = limbs, number->_mp_alloc = WIDE_LIMBS, number->_mp_size = 0;
}

EnfExactLines *enf_exact_create(void) {
    EnfExactLines *x = ENF_NEW(EnfExactLines, 1); /* zeroes of the system: most of it is never touched */
    if (!x)
        return NULL;
    mpz_ptr numbers[4] = {x->sum, x->term, x->a, x->b};
    for (int k = 0; k < 4; ++k)
        place(numbers[k], x->wide[k]);
    for (int k = 0; k < 6; ++k)
        place(x->line[k], x->wide[4 + k]);
    return x;
}

void enf_exact_destroy(EnfExactLines *exact) {
    enf_free(exact);
}

/* Keeps the numbers of `line`. Too long: the cone is told, and they are zero. */
static void keep(EnfStabCone *cone, WholeLine *out) {
    for (int k = 0; k < 6; ++k) {
        mpz_srcptr from = cone->exact->line[k];
        size_t limbs = mpz_size(from);
        if (limbs > RAY_LIMBS)
            cone->too_long = 1, limbs = 0;
        memcpy(out->limbs[k], mpz_limbs_read(from), limbs * sizeof(mp_limb_t));
        out->sizes[k] = mpz_sgn(from) * (int)limbs;
    }
}

static void view(const WholeLine *line, mpz_t out[6]) {
    for (int k = 0; k < 6; ++k)
        mpz_roinit_n(out[k], line->limbs[k], line->sizes[k]);
}

static void row_of(EnfStabCone *cone, uint32_t index, mpz_t out[6]) {
    EnfExactLines *x = cone->exact;
    EnfConeRow *row = &cone->rows[index];
    if (!row->exact_known) {
        const double *p = row->whole, *q = row->whole + 3;
        for (int k = 0; k < 6 && !row->is_edge; ++k)
            mpz_set_d(x->line[k], row->whole[k]);
        for (int k = 0; k < 3 && row->is_edge; ++k) { /* m = p x q, then d = q - p in the same unit: one more step length */
            int i = (k + 1) % 3, j = (k + 2) % 3;
            mpz_set_d(x->a, p[i]), mpz_set_d(x->b, q[j]);
            mpz_mul(x->line[k], x->a, x->b);
            mpz_set_d(x->a, p[j]), mpz_set_d(x->b, q[i]);
            mpz_submul(x->line[k], x->a, x->b);
            mpz_set_d(x->line[k + 3], q[k] - p[k]);
            mpz_mul_2exp(x->line[k + 3], x->line[k + 3], ENF_CONE_CORNER_BITS);
        }
        keep(cone, &x->rows[index]);
        row->exact_known = 1;
    }
    view(&x->rows[index], out);
}

static void dot(mpz_t out, mpz_t row[6], mpz_t line[6]) {
    mpz_mul(out, row[0], line[0]);
    for (int k = 1; k < 6; ++k)
        mpz_addmul(out, row[k], line[k]);
}

/* side(a, b) */
static void side(mpz_t out, mpz_t a[6], mpz_t b[6]) {
    mpz_mul(out, a[0], b[3]);
    for (int k = 1; k < 6; ++k)
        mpz_addmul(out, a[k], b[k < 3 ? k + 3 : k - 3]);
}

/* The ray's bounded line anew: the exact numbers, rounded once. */
static void refresh(EnfStabCone *cone, uint32_t index) {
    EnfConeRay *ray = &cone->rays[index];
    mpz_t v[6];
    view(&cone->exact->rays[index], v);
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

/* line = value(p) n - value(n) p, on a row, without a common factor */
static void combine(EnfExactLines *x, mpz_t row[6], mpz_t p[6], mpz_t n[6]) {
    dot(x->a, row, p);
    dot(x->b, row, n);
    mpz_set_ui(x->sum, 0);
    for (int k = 0; k < 6; ++k) {
        mpz_mul(x->line[k], x->a, n[k]);
        mpz_submul(x->line[k], x->b, p[k]);
        mpz_gcd(x->sum, x->sum, x->line[k]);
    }
    if (mpz_cmp_ui(x->sum, 1) > 0)
        for (int k = 0; k < 6; ++k)
            mpz_divexact(x->line[k], x->line[k], x->sum);
}

static void ray_of(EnfStabCone *cone, uint32_t index, mpz_t out[6]) {
    EnfExactLines *x = cone->exact;
    EnfConeRay *ray = &cone->rays[index];
    if (!ray->exact_known) { /* parents were made before: no circle */
        mpz_t p[6], n[6], row[6];
        if (ray->row != ENF_CONE_ROWS) {
            ray_of(cone, ray->positive, p), ray_of(cone, ray->negative, n), row_of(cone, ray->row, row);
            combine(x, row, p, n);
        } else if (ray->negative != ENF_NONE) {
            ray_of(cone, ray->negative, n);
            for (int k = 0; k < 6; ++k)
                mpz_neg(x->line[k], n[k]);
        } else
            for (int k = 0; k < 6; ++k)
                mpz_set_ui(x->line[k], (unsigned)k == ray->positive);
        keep(cone, &x->rays[index]);
        ray->exact_known = 1;
        refresh(cone, index);
    }
    view(&x->rays[index], out);
}

int enf_exact_row_sign(EnfStabCone *cone, uint32_t row, uint32_t ray, double *value, double *error) {
    EnfExactLines *x = cone->exact;
    mpz_t line[6], function[6];
    ray_of(cone, ray, line), row_of(cone, row, function);
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
    mpz_t p[6], q[6];
    ray_of(cone, a, p), ray_of(cone, b, q);
    side(cone->exact->sum, p, q);
    return mpz_sgn(cone->exact->sum);
}

int enf_exact_changes_between(EnfStabCone *cone, uint32_t a, uint32_t b) {
    mpz_t p[6], q[6];
    ray_of(cone, a, p), ray_of(cone, b, q);
    EnfExactLines *x = cone->exact;
    side(x->sum, p, p);
    side(x->term, q, q);
    mpz_mul(x->term, x->term, x->sum);
    side(x->sum, p, q);
    mpz_mul(x->sum, x->sum, x->sum);
    return mpz_cmp(x->sum, x->term) > 0;
}
