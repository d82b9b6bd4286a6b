/* SPDX-License-Identifier: GPL-3.0-or-later
 * Judges a PVS matrix of a portal file by sightlines: nothing that a walked line joins may be missing.
 *
 *   portal_sampler MAP.prt MATRIX [--lines N | --seconds S] [--seed N] [--witnesses FILE]
 *
 * It has a reader and a walker of its own and shares nothing with the core. Lines are aimed: through points of two portals a few steps
 * apart, half of the points at an edge or a corner, where slits are. A line counts only for portals that it passes strictly inside, by
 * more than rounding. Witnesses (lines "i j x0 y0 z0 x1 y1 z1") are walked too: each must lead from cell i to cell j.
 * Exit code 1 when a pair is missing or a witness doesn't hold; each is printed with its line and clearance. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct Portal {
    int cells[2], count;
    double (*corners)[3];
    double normal[3], offset; /* into cells[1] */
    double (*edges)[4];       /* inward in the plane: n . p + d >= 0 */
} Portal;

static Portal *portals;
static int portal_count, cell_count;
static int *first, *list; /* portals of each cell */
static uint8_t *matrix, *proven;
static uint64_t state = 1;

static double unit(void) { /* xorshift64*, Vigna 2016 */
    state ^= state >> 12, state ^= state << 25, state ^= state >> 27;
    return (double)((state * 2685821657736338717u) >> 11) * 0x1p-53;
}
static int below(int n) {
    return (int)(unit() * n);
}

static void fail(const char *what) {
    fprintf(stderr, "portal_sampler: %s\n", what);
    exit(2);
}

static void read_portals(const char *path) {
    FILE *f = fopen(path, "r");
    char magic[8];
    int leafs;
    if (!f || fscanf(f, "%7s", magic) != 1)
        fail("can't read the portal file");
    if (!strcmp(magic, "PRT2")) {
        if (fscanf(f, "%d %d %d", &leafs, &cell_count, &portal_count) != 3)
            fail("bad header");
    } else if (strcmp(magic, "PRT1") || fscanf(f, "%d %d", &cell_count, &portal_count) != 2)
        fail("bad header");
    portals = calloc((size_t)portal_count, sizeof *portals);
    first = calloc((size_t)cell_count + 2, sizeof *first);
    list = calloc((size_t)portal_count * 2, sizeof *list);
    for (int i = 0; i < portal_count; i++) {
        Portal *p = &portals[i];
        if (fscanf(f, "%d %d %d", &p->count, &p->cells[0], &p->cells[1]) != 3)
            fail("bad portal");
        p->corners = calloc((size_t)p->count, sizeof *p->corners);
        p->edges = calloc((size_t)p->count, sizeof *p->edges);
        for (int k = 0; k < p->count; k++)
            if (fscanf(f, " (%lf %lf %lf )", &p->corners[k][0], &p->corners[k][1], &p->corners[k][2]) != 3)
                fail("bad corner");
        double n[3] = {0, 0, 0}, c[3] = {0, 0, 0};
        for (int k = 0; k < p->count; k++) {
            const double *a = p->corners[k], *b = p->corners[(k + 1) % p->count];
            n[0] += (a[1] - b[1]) * (a[2] + b[2]), n[1] += (a[2] - b[2]) * (a[0] + b[0]), n[2] += (a[0] - b[0]) * (a[1] + b[1]);
            for (int x = 0; x < 3; x++)
                c[x] += a[x] / p->count;
        }
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        /* clockwise seen from cells[0]: the right-hand normal points away from it, into cells[1] */
        for (int x = 0; x < 3; x++)
            p->normal[x] = n[x] / length;
        p->offset = p->normal[0] * c[0] + p->normal[1] * c[1] + p->normal[2] * c[2];
        for (int k = 0; k < p->count; k++) {
            const double *a = p->corners[k], *b = p->corners[(k + 1) % p->count];
            double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, *w = p->edges[k];
            for (int x = 0; x < 3; x++)
                w[x] = p->normal[(x + 1) % 3] * e[(x + 2) % 3] - p->normal[(x + 2) % 3] * e[(x + 1) % 3];
            double m = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
            for (int x = 0; x < 3; x++)
                w[x] /= m;
            w[3] = -(w[0] * a[0] + w[1] * a[1] + w[2] * a[2]);
        }
        first[p->cells[0] + 2]++, first[p->cells[1] + 2]++;
    }
    fclose(f);
    for (int c = 0; c < cell_count; c++)
        first[c + 2] += first[c + 1];
    for (int i = 0; i < portal_count; i++)
        for (int s = 0; s < 2; s++)
            list[first[portals[i].cells[s] + 1]++] = i;
}

static void read_matrix(const char *path) {
    FILE *f = fopen(path, "r");
    if (!f)
        fail("can't read the matrix");
    matrix = calloc((size_t)cell_count * (size_t)cell_count, 1);
    int row = 0, value = 0, digits = 0, ch;
    while ((ch = fgetc(f)) != EOF) {
        if (ch >= '0' && ch <= '9') {
            value = value * 10 + ch - '0', digits++;
            continue;
        }
        if (digits) {
            if (row >= cell_count || value >= cell_count)
                fail("the matrix has an index out of range");
            matrix[(size_t)row * (size_t)cell_count + (size_t)value] = 1;
        }
        value = digits = 0;
        if (ch == '\n')
            row++;
    }
    fclose(f);
    if (row != cell_count)
        fail("the matrix has another number of rows than the file has cells");
}

/* The portal by which the line leaves the cell, strictly inside; -1 none. *at: parameter along the line, *clear: clearance. */
static int leave(int cell, const double o[3], const double d[3], double from, int skip, double *at, double *clear) {
    for (int k = first[cell]; k < first[cell + 1]; k++) {
        const Portal *p = &portals[list[k]];
        if (list[k] == skip)
            continue;
        double out = p->cells[0] == cell ? 1 : -1;
        double speed = out * (p->normal[0] * d[0] + p->normal[1] * d[1] + p->normal[2] * d[2]);
        if (speed <= 1e-12)
            continue;
        double t = out * (p->offset - (p->normal[0] * o[0] + p->normal[1] * o[1] + p->normal[2] * o[2])) / speed;
        if (t < from)
            continue;
        double least = INFINITY;
        for (int e = 0; e < p->count && least > 1e-9; e++) {
            const double *w = p->edges[e];
            least = fmin(least, w[0] * (o[0] + t * d[0]) + w[1] * (o[1] + t * d[1]) + w[2] * (o[2] + t * d[2]) + w[3]);
        }
        if (least > 1e-9)
            return *at = t, *clear = least, list[k]; /* rounding here is some 1e-12 units */
    }
    return -1;
}

enum { MAX_WALK = 512 };

/* The cells along the line, from the one behind `portal` on; clears[i] = the least clearance up to cells[i]. */
static int walk(int cell, int portal, const double o[3], const double d[3], double from, double until, int *cells, double *clears) {
    int n = 0;
    double clear = INFINITY, c;
    cells[n] = cell, clears[n++] = clear;
    while (n < MAX_WALK) {
        int next = leave(cell, o, d, from, portal, &from, &c);
        if (next < 0 || from > until)
            break;
        clear = fmin(clear, c);
        cell = portals[next].cells[portals[next].cells[0] == cell];
        portal = next;
        cells[n] = cell, clears[n++] = clear;
    }
    return n;
}

static void random_point(const Portal *p, double out[3]) {
    double sum = 0, w[64];
    int n = p->count < 64 ? p->count : 64;
    double kind = unit();
    int corner = below(n);
    for (int i = 0; i < n; i++)
        w[i] = -log(1e-300 + unit()) * 1.0;
    if (kind < 0.25) { /* at a corner */
        double near = pow(10, -1 - 5 * unit());
        for (int i = 0; i < n; i++)
            w[i] = i == corner ? 1 : near * unit();
    } else if (kind < 0.5) { /* at an edge */
        double near = pow(10, -1 - 5 * unit()), t = unit();
        for (int i = 0; i < n; i++)
            w[i] = i == corner ? t : i == (corner + 1) % n ? 1 - t : near * unit();
    }
    for (int i = 0; i < n; i++)
        sum += w[i];
    for (int x = 0; x < 3; x++) {
        out[x] = 0;
        for (int i = 0; i < n; i++)
            out[x] += w[i] / sum * p->corners[i][x];
    }
}

int main(int argc, char **argv) {
    double seconds = 5;
    uint64_t wanted = 0; /* lines; 0: as many as the seconds of CPU allow */
    const char *witness_path = NULL;
    if (argc < 3)
        fail("usage: portal_sampler MAP.prt MATRIX [--lines N | --seconds S] [--seed N] [--witnesses FILE]");
    for (int i = 3; i + 1 < argc; i += 2) {
        if (!strcmp(argv[i], "--seconds"))
            seconds = atof(argv[i + 1]);
        else if (!strcmp(argv[i], "--lines"))
            wanted = strtoull(argv[i + 1], NULL, 10);
        else if (!strcmp(argv[i], "--seed"))
            state = strtoull(argv[i + 1], NULL, 10) * 0x9E3779B97F4A7C15u + 1;
        else if (!strcmp(argv[i], "--witnesses"))
            witness_path = argv[i + 1];
    }
    read_portals(argv[1]);
    read_matrix(argv[2]);
    size_t n = (size_t)cell_count;
    proven = calloc(n * n, 1);
    uint64_t lines = 0, pairs = 0, missing = 0, bad_witnesses = 0, witnesses = 0, marked = 0, oneway = 0;
    static int ahead[MAX_WALK], behind[MAX_WALK], cells[2 * MAX_WALK];
    static double ahead_clear[MAX_WALK], behind_clear[MAX_WALK], clears[2 * MAX_WALK];
    clock_t end = clock() + (clock_t)(seconds * CLOCKS_PER_SEC);
    while (wanted ? lines < wanted : (lines & 1023) || clock() < end) {
        lines++;
        const Portal *p = &portals[below(portal_count)];
        int index = (int)(p - portals), cell = p->cells[below(2)], steps = 1 + below(12);
        const Portal *q = p;
        for (int s = 0; s < steps; s++) { /* a random walk through the graph finds the portal to aim at */
            int k = first[cell] + below(first[cell + 1] - first[cell]);
            q = &portals[list[k]];
            cell = q->cells[q->cells[0] == cell];
        }
        if (q == p)
            continue;
        double a[3], b[3], d[3], back[3];
        random_point(p, a), random_point(q, b);
        double length = 0;
        for (int x = 0; x < 3; x++)
            d[x] = b[x] - a[x], length += d[x] * d[x];
        length = sqrt(length);
        if (length < 1e-6)
            continue;
        for (int x = 0; x < 3; x++)
            d[x] /= length, back[x] = -d[x];
        double along = p->normal[0] * d[0] + p->normal[1] * d[1] + p->normal[2] * d[2], here = INFINITY;
        if (fabs(along) < 1e-9)
            continue;
        for (int e = 0; e < p->count; e++)
            here = fmin(here, p->edges[e][0] * a[0] + p->edges[e][1] * a[1] + p->edges[e][2] * a[2] + p->edges[e][3]);
        if (here <= 1e-9)
            continue;
        int fore = walk(p->cells[along > 0], index, a, d, 0, INFINITY, ahead, ahead_clear);
        int rear = walk(p->cells[along < 0], index, a, back, 0, INFINITY, behind, behind_clear);
        int count = 0;
        for (int i = rear - 1; i >= 0; i--)
            cells[count] = behind[i], clears[count++] = fmin(here, behind_clear[i]);
        for (int i = 0; i < fore; i++)
            cells[count] = ahead[i], clears[count++] = fmin(here, ahead_clear[i]);
        for (int i = 0; i < rear; i++)
            for (int j = rear; j < count; j++) {
                size_t ij = (size_t)cells[i] * n + (size_t)cells[j], ji = (size_t)cells[j] * n + (size_t)cells[i];
                if (proven[ij])
                    continue;
                proven[ij] = proven[ji] = 1;
                pairs += ij == ji ? 1 : 2;
                for (int way = 0; way < 2; way++)
                    if (!matrix[way ? ji : ij]) {
                        missing++;
                        printf("MISSING %d %d clearance %.3g from %.17g %.17g %.17g towards %.17g %.17g %.17g\n", cells[way ? j : i],
                               cells[way ? i : j], fmin(clears[i], clears[j]), a[0], a[1], a[2], b[0], b[1], b[2]);
                    }
            }
    }
    if (witness_path) {
        FILE *f = fopen(witness_path, "r");
        int i, j;
        double a[3], b[3], d[3];
        if (!f)
            fail("can't read the witnesses");
        while (fscanf(f, "%d %d %lf %lf %lf %lf %lf %lf", &i, &j, &a[0], &a[1], &a[2], &b[0], &b[1], &b[2]) == 8) {
            witnesses++;
            if (i < 0 || j < 0 || i >= cell_count || j >= cell_count)
                fail("a witness has an index out of range");
            for (int x = 0; x < 3; x++)
                d[x] = b[x] - a[x];
            int count = walk(i, -1, a, d, -1e-9, 1 + 1e-9, cells, clears), reached = 0;
            for (int k = 0; k < count; k++)
                reached |= cells[k] == j;
            if (!reached) {
                if (bad_witnesses++ < 20)
                    printf("BAD WITNESS %d %d: the walk from %d ends in %d after %d cells\n", i, j, i, cells[count - 1], count);
            }
        }
        fclose(f);
    }
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            marked += matrix[i * n + j], oneway += matrix[i * n + j] != matrix[j * n + i];
    printf("%s: %llu lines, %llu ordered pairs proven of %llu in the matrix; missing %llu; one-way pairs %llu; witnesses %llu, bad %llu\n",
           argv[1], (unsigned long long)lines, (unsigned long long)pairs, (unsigned long long)marked, (unsigned long long)missing,
           (unsigned long long)oneway, (unsigned long long)witnesses, (unsigned long long)bad_witnesses);
    return missing || bad_witnesses;
}
