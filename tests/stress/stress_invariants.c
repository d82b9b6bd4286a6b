/* SPDX-License-Identifier: GPL-3.0-or-later
 * The invariants of from-region visibility on random buildings: what must not change an answer, doesn't.
 *
 *   stress_invariants [--count N] [--seed S]
 *
 * A building is a box cut into box-shaped cells by planes of a coarse grid, with doors in the walls between them: sills, heads and
 * jambs line up everywhere. Each building is baked once; then its variants:
 *   permute   cells, portals and corners in another order, portals the other way round
 *   move      turned by any angles and moved up to 1e7 m
 *   scale     1e-3 to 1e3
 *   threads   2 and 4 instead of 1
 *   split     a cell cut by a plane: what its parts see together is what it saw
 *   grow      a door made larger: nothing that was seen is hidden
 *   close     a door taken away: nothing that was hidden is seen
 * and lines walked through the doors by a walker of its own must be in the answer. "changed" counts ordered pairs that break
 * a rule, seen or not (grazing and undecided count as seen); any makes the exit code 1. */
#include "enfilade/enfilade.h"
#include "stress_random.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_CELLS = 40, MAX_PORTALS = 200, LINES = 200 };
enum { PERMUTE, MOVE, SCALE, THREADS, SPLIT, GROW, CLOSE, VARIANTS };
static const char *const names[] = {"permute", "move", "scale", "threads", "split", "grow", "close"};

typedef struct Box {
    double low[3], high[3];
} Box;
typedef struct Door { /* a rectangle across `axis`; a below b */
    int axis, a, b;
    Box box;
} Door;
typedef struct Building {
    int cells, doors;
    Box cell[MAX_CELLS];
    Door door[MAX_PORTALS];
} Building;
typedef uint8_t Matrix[MAX_CELLS][MAX_CELLS];

static Random dice; /* of the building at hand */
static double unit(void) {
    return random_unit(&dice);
}
static int below(int n) {
    return (int)random_index(&dice, (uint32_t)n);
}

/* ---- Buildings ---------------------------------------------------------------------------------------------- */
static void cut(Building *b, Box box, int depth) {
    int axis = below(3) ? (box.high[0] - box.low[0] >= box.high[1] - box.low[1] ? 0 : 1) : below(3);
    double size = box.high[axis] - box.low[axis];
    if (depth == 0 || size < 2 || b->cells > MAX_CELLS - 12) {
        b->cell[b->cells++] = box;
        return;
    }
    double at = box.low[axis] + 1 + below((int)size - 1);
    Box lower = box, upper = box;
    lower.high[axis] = upper.low[axis] = at;
    cut(b, lower, depth - 1);
    cut(b, upper, depth - 1);
}

/* The common wall of two cells, low one first; 0 when they have none. */
static int wall(const Building *b, int i, int j, Door *out) {
    for (int axis = 0; axis < 3; ++axis) {
        if (b->cell[i].high[axis] != b->cell[j].low[axis])
            continue;
        Door door = {axis, i, j, {{0, 0, 0}, {0, 0, 0}}};
        int open = 1;
        for (int k = 0; k < 3; ++k) {
            door.box.low[k] = fmax(b->cell[i].low[k], b->cell[j].low[k]);
            door.box.high[k] = fmin(b->cell[i].high[k], b->cell[j].high[k]);
            open &= k == axis || door.box.low[k] < door.box.high[k];
        }
        if (open)
            return *out = door, 1;
    }
    return 0;
}

static Building make_building(void) {
    Building b = {0, 0, {{{0}, {0}}}, {{0}}};
    Box all = {{0, 0, 0}, {6 + below(10), 6 + below(10), 3 + below(4)}};
    cut(&b, all, 3 + below(2));
    for (int i = 0; i < b.cells; ++i)
        for (int j = 0; j < b.cells; ++j) {
            Door door;
            if (i == j || !wall(&b, i, j, &door) || b.doors == MAX_PORTALS / 2 || below(10) > 6)
                continue;
            for (int k = 0; k < 3; ++k) {
                double size = door.box.high[k] - door.box.low[k];
                if (k == door.axis || below(4) == 0)
                    continue; /* as wide as the wall */
                int steps = (int)(4 * size), from = below(steps), to = from + 1 + below(steps - from);
                door.box.high[k] = door.box.low[k] + 0.25 * to, door.box.low[k] += 0.25 * from;
            }
            b.door[b.doors++] = door;
        }
    return b;
}

/* One cell cut by a plane; its doors too; a seam between the halves. owner: the cell each belonged to. */
static Building split_building(const Building *b, int *owner) {
    Building out = *b;
    int c = below(b->cells), axis = below(3), half = out.cells++;
    double at = b->cell[c].low[axis] + (0.1 + 0.8 * unit()) * (b->cell[c].high[axis] - b->cell[c].low[axis]);
    if (below(2))
        at = floor(4 * at) / 4; /* in line with jambs */
    if (at <= b->cell[c].low[axis])
        at = 0.5 * (b->cell[c].low[axis] + b->cell[c].high[axis]);
    for (int i = 0; i < b->cells; ++i)
        owner[i] = i;
    owner[half] = c;
    out.cell[half] = b->cell[c];
    out.cell[c].high[axis] = out.cell[half].low[axis] = at;
    for (int d = 0; d < b->doors; ++d) {
        Door *door = &out.door[d];
        if (door->a != c && door->b != c)
            continue;
        int *side = door->a == c ? &door->a : &door->b;
        if (door->axis == axis) { /* the wall itself went to one half */
            if (side == &door->a)
                *side = half;
            continue;
        }
        if (door->box.low[axis] >= at)
            *side = half;
        else if (door->box.high[axis] > at && out.doors < MAX_PORTALS - 1) {
            Door *upper = &out.door[out.doors++];
            *upper = *door;
            door->box.high[axis] = upper->box.low[axis] = at;
            *(side == &door->a ? &upper->a : &upper->b) = half;
        }
    }
    Door seam = {axis, c, half, out.cell[c]};
    seam.box.low[axis] = seam.box.high[axis] = at;
    out.door[out.doors++] = seam;
    return out;
}

/* ---- The engine's answer ------------------------------------------------------------------------------------- */
typedef struct Motion {
    double turn[3][3], move[3], scale;
} Motion;

/* order: the place of each cell, of each portal; NULL: as they stand. */
static int bake(const Building *b, const Motion *motion, int shuffled, uint32_t threads, Matrix out) {
    EnfScene *scene = NULL;
    EnfRegionVis *result = NULL;
    uint32_t room, index, place[MAX_CELLS], cell_at[MAX_CELLS], portal_at[MAX_PORTALS];
    for (int i = 0; i < b->cells; ++i)
        cell_at[i] = (uint32_t)i;
    for (int i = 0; i < b->doors; ++i)
        portal_at[i] = (uint32_t)i;
    for (int i = b->cells - 1; i > 0 && shuffled; --i) {
        int k = below(i + 1);
        uint32_t t = cell_at[i];
        cell_at[i] = cell_at[k], cell_at[k] = t;
    }
    for (int i = b->doors - 1; i > 0 && shuffled; --i) {
        int k = below(i + 1);
        uint32_t t = portal_at[i];
        portal_at[i] = portal_at[k], portal_at[k] = t;
    }
    for (int i = 0; i < b->cells; ++i)
        place[cell_at[i]] = (uint32_t)i;
    int ok = enf_scene_create(&scene) == ENF_OK && enf_scene_add_room(scene, "all", ENF_ROOM_INTERIOR, &room) == ENF_OK;
    for (int i = 0; i < b->cells && ok; ++i)
        ok = enf_scene_add_cell(scene, room, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &index) == ENF_OK;
    for (int i = 0; i < b->doors && ok; ++i) {
        const Door *d = &b->door[portal_at[i]];
        int u = (d->axis + 1) % 3, v = (d->axis + 2) % 3, first = shuffled ? below(4) : 0, turned = shuffled && below(2);
        double corners[4][3];
        for (int c = 0; c < 4; ++c) { /* counter-clockwise about the axis: from a to b, so clockwise seen from a */
            int n = (first + (turned ? 4 - c : c)) % 4;
            double p[3], q[3];
            p[d->axis] = d->box.low[d->axis];
            p[u] = n == 1 || n == 2 ? d->box.high[u] : d->box.low[u];
            p[v] = n >= 2 ? d->box.high[v] : d->box.low[v];
            for (int k = 0; k < 3; ++k)
                q[k] = motion ? motion->scale * ((motion->turn[k][0] * p[0] + motion->turn[k][1] * p[1]) + motion->turn[k][2] * p[2]) +
                                    motion->move[k]
                              : p[k];
            memcpy(corners[3 - c], q, sizeof q); /* so it is counter-clockwise seen from a */
        }
        uint32_t a = place[d->a], e = place[d->b];
        ok = enf_scene_add_portal(scene, turned ? e : a, turned ? a : e, corners[0], 4, 0, ENF_NONE, &index) == ENF_OK;
    }
    EnfRegionVisDef def = enf_default_region_vis_def();
    def.threads = threads;
    ok = ok && enf_scene_commit(scene) == ENF_OK && enf_region_vis_run(scene, &def, &result) == ENF_OK;
    if (!ok)
        fprintf(stderr, "engine: %s\n", enf_last_error());
    memset(out, 0, sizeof(Matrix));
    for (int i = 0; i < b->cells && ok; ++i)
        for (int j = 0; j < b->cells && ok; ++j) {
            uint32_t status;
            ok = enf_region_vis_pair(result, place[i], place[j], &status) == ENF_OK;
            out[i][j] = (uint8_t)(status != ENF_PAIR_HIDDEN);
        }
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
    return ok;
}

/* ---- Lines, walked through boxes ----------------------------------------------------------------------------- */
static uint64_t lines_missing(const Building *b, Matrix seen, uint64_t *crossed) {
    uint64_t missing = 0;
    for (int n = 0; n < LINES; ++n) {
        int start = below(b->cells), at = start;
        double p[3], d[3];
        for (int k = 0; k < 3; ++k)
            p[k] = b->cell[start].low[k] + unit() * (b->cell[start].high[k] - b->cell[start].low[k]), d[k] = unit() - 0.5;
        if (b->doors && below(4)) { /* aimed at a door */
            const Door *door = &b->door[below(b->doors)];
            for (int k = 0; k < 3; ++k)
                d[k] = door->box.low[k] + unit() * (door->box.high[k] - door->box.low[k]) - p[k];
        }
        for (int steps = 0; steps < 100; ++steps) {
            double t = INFINITY, x[3];
            int axis = 0, next = -1;
            for (int k = 0; k < 3; ++k) {
                double along = d[k] > 0 ? (b->cell[at].high[k] - p[k]) / d[k] : d[k] < 0 ? (b->cell[at].low[k] - p[k]) / d[k] : INFINITY;
                if (along < t)
                    t = along, axis = k;
            }
            for (int k = 0; k < 3; ++k)
                x[k] = p[k] + t * d[k];
            for (int i = 0; i < b->doors && next < 0; ++i) {
                const Door *door = &b->door[i];
                if (door->axis != axis || (d[axis] > 0 ? door->a : door->b) != at)
                    continue;
                int in = 1;
                for (int k = 0; k < 3; ++k)
                    in &= k == axis || (x[k] > door->box.low[k] + 1e-6 && x[k] < door->box.high[k] - 1e-6);
                if (in)
                    next = d[axis] > 0 ? door->b : door->a;
            }
            if (next < 0)
                break;
            at = next;
            ++*crossed;
            missing += !seen[start][at] + (uint64_t)!seen[at][start];
        }
    }
    return missing;
}

static Motion random_motion(void) { /* rotation from a random quaternion (Shoemake 1992) */
    double a = unit(), b = 6.283185307179586 * unit(), c = 6.283185307179586 * unit(), reach = pow(10, 7 * unit());
    double x = sqrt(1 - a) * sin(b), y = sqrt(1 - a) * cos(b), z = sqrt(a) * sin(c), w = sqrt(a) * cos(c);
    Motion m = {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                 {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                 {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}},
                {reach * (2 * unit() - 1), reach * (2 * unit() - 1), 0.01 * reach * unit()},
                1};
    return m;
}

/* Ordered pairs that break the variant's rule. owner: the building's cell of each of the variant's. */
static uint64_t changed_pairs(int kind, const Building *b, Matrix base, const Building *v, Matrix found, const int *owner) {
    Matrix joined;
    uint64_t changed = 0;
    memset(joined, 0, sizeof joined);
    for (int i = 0; i < v->cells; ++i)
        for (int j = 0; j < v->cells; ++j) {
            joined[owner[i]][owner[j]] |= found[i][j];
            changed += found[i][j] != found[j][i];
        }
    for (int i = 0; i < b->cells; ++i)
        for (int j = 0; j < b->cells; ++j)
            if (joined[i][j] != base[i][j] && !(kind == GROW && joined[i][j]) && !(kind == CLOSE && base[i][j]))
                ++changed;
    return changed;
}

int main(int argc, char **argv) {
    uint64_t count = 100, seed = 1, total = 0, pairs = 0, changed = 0, missing = 0, crossed = 0, failed = 0, by_kind[VARIANTS] = {0},
             bad[VARIANTS] = {0};
    for (int i = 1; i < argc; ++i) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (value && !strcmp(argv[i], "--count"))
            count = strtoull(value, NULL, 10), ++i;
        else if (value && !strcmp(argv[i], "--seed"))
            seed = strtoull(value, NULL, 10), ++i;
        else
            return fprintf(stderr, "usage: %s [--count VARIANTS] [--seed S]\n", argv[0]), 1;
    }
    for (uint64_t n = 0; total < count; ++n) {
        dice.state = seed * 1000003u + n * 7919u;
        Building b = make_building();
        Matrix base, found;
        if (!bake(&b, NULL, 0, 1, base))
            return 1;
        missing += lines_missing(&b, base, &crossed);
        for (int kind = 0; kind < VARIANTS && total < count; ++kind) {
            Building v = b;
            Motion motion = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, 1};
            int owner[MAX_CELLS], door = b.doors ? below(b.doors) : 0;
            for (int i = 0; i < MAX_CELLS; ++i)
                owner[i] = i;
            if (!b.doors)
                break;
            if (kind == MOVE)
                motion = random_motion();
            if (kind == SCALE)
                motion.scale = pow(10, 6 * unit() - 3);
            if (kind == SPLIT)
                v = split_building(&b, owner);
            if (kind == CLOSE)
                v.door[door] = v.door[--v.doors];
            if (kind == GROW) {
                Door whole;
                if (!wall(&b, b.door[door].a, b.door[door].b, &whole))
                    return 1;
                for (int k = 0; k < 3; ++k) {
                    double f = below(2) ? 1 : unit();
                    v.door[door].box.low[k] += f * (whole.box.low[k] - v.door[door].box.low[k]);
                    v.door[door].box.high[k] += f * (whole.box.high[k] - v.door[door].box.high[k]);
                }
            }
            if (!bake(&v, &motion, kind == PERMUTE, kind == THREADS ? 2 + 2 * (uint32_t)below(2) : 1, found)) {
                ++failed;
                continue;
            }
            uint64_t wrong = changed_pairs(kind, &b, base, &v, found, owner);
            if (wrong)
                printf("CHANGED building %llu %s: %llu pairs\n", (unsigned long long)n, names[kind], (unsigned long long)wrong);
            ++total, ++by_kind[kind], bad[kind] += wrong, changed += wrong;
            pairs += (uint64_t)b.cells * (uint64_t)b.cells;
        }
    }
    for (int kind = 0; kind < VARIANTS; ++kind)
        printf("%-8s %7llu variants, pairs changed %llu\n", names[kind], (unsigned long long)by_kind[kind], (unsigned long long)bad[kind]);
    printf("%llu variants, %llu ordered pairs: changed %llu; %llu doors walked through, to what wasn't seen %llu; failed %llu\n",
           (unsigned long long)total, (unsigned long long)pairs, (unsigned long long)changed, (unsigned long long)crossed,
           (unsigned long long)missing, (unsigned long long)failed);
    return changed || missing || failed;
}
