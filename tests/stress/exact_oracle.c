/* SPDX-License-Identifier: GPL-3.0-or-later
 * The chain's lines as a polyhedral cone in Pluecker space, its extreme rays by cddlib in rationals, and the sign of the
 * Klein quadric on that cone by exact subdivision.
 *
 * Based on: S. Teller, Computing the antipenumbra of an area light source, 1992 (lines through portals are a cone cut by the
 * quadric); S. Bundfuss, M. Duer, Algorithmic copositivity detection by simplicial partition, 2008 (the sign of a quadratic form
 * on a cone given by its rays).
 *
 * Why it decides: let C be the cone of all six-vectors on the inner side of every portal edge and Q(d, m) = d . m. Real lines are
 * the zeros of Q. Q is nondegenerate, so an interior zero has both signs around it; and C's interior is connected, so both strict
 * signs on C give an interior zero. Hence: a strict stabbing line exists iff C is full-dimensional and Q takes both signs on C. */
#define GMPRATIONAL
#include <cddlib/setoper.h>
#include <cddlib/cdd.h>

#include "exact_oracle.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_RAYS = 512, MAX_STEPS = 20000 };

typedef mpq_t Rational;

void oracle_begin(void) {
    dd_set_global_constants();
}
void oracle_end(void) {
    dd_free_global_constants();
}

/* out = a x b for rational triples. */
static void cross(Rational out[3], Rational a[3], Rational b[3]) {
    Rational t;
    mpq_init(t);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        mpq_mul(out[i], a[j], b[k]);
        mpq_mul(t, a[k], b[j]);
        mpq_sub(out[i], out[i], t);
    }
    mpq_clear(t);
}

static void init(Rational *v, int n) {
    for (int i = 0; i < n; i++)
        mpq_init(v[i]);
}
static void clear(Rational *v, int n) {
    for (int i = 0; i < n; i++)
        mpq_clear(v[i]);
}

/* The Pluecker vector (d, m) of the line from p to q, exactly. */
static void line_through(Rational out[6], const double p[3], const double q[3]) {
    Rational a[3], b[3];
    init(a, 3), init(b, 3);
    for (int i = 0; i < 3; i++) {
        mpq_set_d(a[i], p[i]);
        mpq_set_d(b[i], q[i]);
        mpq_sub(out[i], b[i], a[i]);
    }
    cross(out + 3, a, b);
    clear(a, 3), clear(b, 3);
}

/* side(a, b) = d_a . m_b + d_b . m_a */
static void side(Rational out, Rational a[6], Rational b[6]) {
    Rational t;
    mpq_init(t);
    mpq_set_ui(out, 0, 1);
    for (int i = 0; i < 3; i++) {
        mpq_mul(t, a[i], b[3 + i]);
        mpq_add(out, out, t);
        mpq_mul(t, b[i], a[3 + i]);
        mpq_add(out, out, t);
    }
    mpq_clear(t);
}

/* +1 when the corners' winding, as given, makes side(line, edge) positive for lines along `forward`; -1 otherwise. */
static int winding_sign(const ChainPortal *portal) {
    /* A line along `forward` through the centroid has one sign against every edge; the first edge that tells decides. */
    Rational a[6], b[6], s;
    double c[3] = {0, 0, 0}, tip[3];
    for (uint32_t i = 0; i < portal->corner_count; i++)
        for (int k = 0; k < 3; k++)
            c[k] += portal->corners[i][k] / portal->corner_count;
    int votes = 0;
    init(a, 6), init(b, 6);
    mpq_init(s);
    for (int k = 0; k < 3; k++)
        tip[k] = c[k] + portal->forward[k];
    line_through(a, c, tip);
    for (uint32_t i = 0; i < portal->corner_count; i++) {
        line_through(b, portal->corners[i], portal->corners[(i + 1) % portal->corner_count]);
        side(s, a, b);
        votes += mpq_sgn(s);
    }
    clear(a, 6), clear(b, 6);
    mpq_clear(s);
    return votes >= 0 ? 1 : -1;
}

/* B(x, y) with Q(x) = B(x, x) = d . m */
static void form(Rational out, Rational x[6], Rational y[6]) {
    side(out, x, y);
    mpq_div_2exp(out, out, 1);
}

/* Whether some non-negative combination of the rays has sign * Q > 0. Depth-first on simplicial splits of the Gram matrix.
 * 1 yes, 0 proven no, -1 gave up. */
typedef struct Search {
    int count, sign;
    long steps;
} Search;

static int reaches(Search *search, Rational *gram) {
    int n = search->count;
    if (++search->steps > MAX_STEPS)
        return -1;
#define G(i, j) gram[(size_t)(i) * (size_t)n + (size_t)(j)]
    int best_i = -1, best_j = -1;
    double best = 0;
    Rational t, u;
    init(&t, 1), init(&u, 1);
    int found = 0;
    for (int i = 0; i < n && !found; i++)
        found = mpq_sgn(G(i, i)) * search->sign > 0;
    for (int i = 0; i < n && !found; i++)
        for (int j = i + 1; j < n && !found; j++) {
            if (mpq_sgn(G(i, j)) * search->sign <= 0)
                continue;
            mpq_mul(t, G(i, j), G(i, j));
            mpq_mul(u, G(i, i), G(j, j));
            if (mpq_cmp(t, u) > 0) {
                found = 1;
                break;
            }
            /* positive, but not enough on this edge alone: worth splitting */
            double weight = mpq_get_d(t) / (mpq_get_d(u) + 1e-300);
            if (best_i < 0 || weight > best)
                best = weight, best_i = i, best_j = j;
        }
    int answer = found ? 1 : best_i < 0 ? 0 : -2;
    if (answer == -2) {
        /* Split the edge (i, j) at the point of its best value: w = a r_i + b r_j with a, b = |G_jj|, |G_ij| made rational. */
        Rational a, b, *half = malloc(sizeof(Rational) * (size_t)n * (size_t)n);
        init(&a, 1), init(&b, 1);
        mpq_abs(a, G(best_j, best_j));
        mpq_abs(b, G(best_i, best_j));
        if (mpq_sgn(a) == 0)
            mpq_set_ui(a, 1, 1);
        if (mpq_sgn(b) == 0)
            mpq_set_ui(b, 1, 1);
        /* keep the numbers short: the split point need not be optimal, only inside */
        mpq_set_d(a, mpq_get_d(a));
        mpq_set_d(b, mpq_get_d(b));
        answer = 0;
        for (int which = 0; which < 2 && answer != 1; which++) {
            int replaced = which ? best_j : best_i;
            for (size_t k = 0; k < (size_t)n * (size_t)n; k++)
                mpq_init(half[k]), mpq_set(half[k], gram[k]);
            for (int k = 0; k < n; k++) {
                if (k == replaced)
                    continue;
                mpq_mul(t, a, G(best_i, k));
                mpq_mul(u, b, G(best_j, k));
                mpq_add(t, t, u);
                mpq_set(half[(size_t)replaced * (size_t)n + (size_t)k], t);
                mpq_set(half[(size_t)k * (size_t)n + (size_t)replaced], t);
            }
            mpq_mul(t, a, a), mpq_mul(t, t, G(best_i, best_i));
            mpq_mul(u, a, b), mpq_mul(u, u, G(best_i, best_j)), mpq_mul_2exp(u, u, 1);
            mpq_add(t, t, u);
            mpq_mul(u, b, b), mpq_mul(u, u, G(best_j, best_j));
            mpq_add(t, t, u);
            mpq_set(half[(size_t)replaced * (size_t)n + (size_t)replaced], t);
            int r = reaches(search, half);
            if (r == 1 || (r == -1 && answer == 0))
                answer = r;
            for (size_t k = 0; k < (size_t)n * (size_t)n; k++)
                mpq_clear(half[k]);
            if (r == -1)
                break;
        }
        clear(&a, 1), clear(&b, 1);
        free(half);
    }
#undef G
    clear(&t, 1), clear(&u, 1);
    return answer;
}

int oracle_decide(const Chain *chain) {
    long rows = 0;
    for (uint32_t p = 0; p < chain->portal_count; p++)
        rows += chain->portals[p].corner_count;
    dd_MatrixPtr h = dd_CreateMatrix(rows, 7);
    h->representation = dd_Inequality;
    h->numbtype = dd_Rational;
    Rational edge[6];
    init(edge, 6);
    long row = 0;
    for (uint32_t p = 0; p < chain->portal_count; p++) {
        const ChainPortal *portal = &chain->portals[p];
        int sign = winding_sign(portal);
        for (uint32_t i = 0; i < portal->corner_count; i++, row++) {
            line_through(edge, portal->corners[i], portal->corners[(i + 1) % portal->corner_count]);
            for (int k = 0; k < 6; k++) {
                /* side(x, e) = x_d . e_m + x_m . e_d */
                mpq_set(h->matrix[row][1 + k], edge[(k + 3) % 6]);
                if (sign < 0)
                    mpq_neg(h->matrix[row][1 + k], h->matrix[row][1 + k]);
            }
        }
    }
    clear(edge, 6);
    dd_ErrorType error = dd_NoError;
    /* dd_LexMin is cddlib's most reliable insertion order on degenerate input. */
    dd_PolyhedraPtr polyhedron = dd_DDMatrix2Poly2(h, dd_LexMin, &error);
    if (error != dd_NoError) {
        dd_FreeMatrix(h);
        return ORACLE_UNKNOWN;
    }
    dd_MatrixPtr v = dd_CopyGenerators(polyhedron);
    Rational(*rays)[6] = malloc(sizeof(Rational[6]) * MAX_RAYS);
    int count = 0, overflow = 0;
    for (long r = 0; r < v->rowsize; r++) {
        if (mpq_sgn(v->matrix[r][0]) != 0)
            continue; /* the apex */
        int two_way = set_member(r + 1, v->linset) != 0;
        for (int way = 0; way <= two_way; way++) {
            if (count == MAX_RAYS) {
                overflow = 1;
                break;
            }
            init(rays[count], 6);
            for (int k = 0; k < 6; k++) {
                mpq_set(rays[count][k], v->matrix[r][1 + k]);
                if (way)
                    mpq_neg(rays[count][k], rays[count][k]);
            }
            count++;
        }
    }
    int answer = overflow ? ORACLE_UNKNOWN : ORACLE_NONE;
    if (!overflow && count >= 6) {
        /* Full-dimensional iff the sum of all rays is strictly inside every constraint. */
        Rational centre[6], t, u;
        init(centre, 6), init(&t, 1), init(&u, 1);
        for (int i = 0; i < count; i++)
            for (int k = 0; k < 6; k++)
                mpq_add(centre[k], centre[k], rays[i][k]);
        int interior = 1;
        for (long r = 0; r < rows && interior; r++) {
            mpq_set_ui(t, 0, 1);
            for (int k = 0; k < 6; k++) {
                mpq_mul(u, h->matrix[r][1 + k], centre[k]);
                mpq_add(t, t, u);
            }
            interior = mpq_sgn(t) > 0;
        }
        clear(centre, 6), clear(&t, 1), clear(&u, 1);
        if (interior) {
            size_t n = (size_t)count;
            Rational *gram = malloc(sizeof(Rational) * n * n);
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < n; j++) {
                    mpq_init(gram[i * n + j]);
                    form(gram[i * n + j], rays[i], rays[j]);
                }
            Search plus = {count, 1, 0}, minus = {count, -1, 0};
            int p = reaches(&plus, gram), m = p == 0 ? 0 : reaches(&minus, gram);
            answer = p == 1 && m == 1 ? ORACLE_STAB : p == 0 || m == 0 ? ORACLE_NONE : ORACLE_UNKNOWN;
            for (size_t i = 0; i < n * n; i++)
                mpq_clear(gram[i]);
            free(gram);
        }
    }
    for (int i = 0; i < count; i++)
        clear(rays[i], 6);
    free(rays);
    dd_FreeMatrix(v);
    dd_FreePolyhedra(polyhedron);
    dd_FreeMatrix(h);
    return answer;
}

int oracle_segment_passes(const Chain *chain, const double from[3], const double to[3]) {
    Rational line[6], edge[6], s;
    init(line, 6), init(edge, 6);
    mpq_init(s);
    line_through(line, from, to);
    int passes = 1;
    for (uint32_t p = 0; p < chain->portal_count && passes; p++) {
        const ChainPortal *portal = &chain->portals[p];
        int sign = winding_sign(portal);
        for (uint32_t i = 0; i < portal->corner_count && passes; i++) {
            line_through(edge, portal->corners[i], portal->corners[(i + 1) % portal->corner_count]);
            side(s, line, edge);
            passes = mpq_sgn(s) * sign > 0;
        }
    }
    clear(line, 6), clear(edge, 6);
    mpq_clear(s);
    return passes;
}
