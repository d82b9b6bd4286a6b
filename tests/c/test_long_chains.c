/* SPDX-License-Identifier: GPL-3.0-or-later
 * Long chains of portals, each built round a line known to pass: whatever narrows windows or drops cells must leave that line alone.
 * And chains shut in their middle, which only pairs of portals there can tell. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "from_region/chain_search.h"
#include "geometry/vec3.h"
#include "memory_kit.h"
#include "stress_random.h"

enum { PORTALS_MAX = 256, CORNERS_MAX = 23 };

#define PI 3.14159265358979

/* Portals between cells without shapes. */
typedef struct Chain {
    uint32_t count, corners[PORTALS_MAX];
    uint32_t cell[PORTALS_MAX + 1];             /* before, between and behind them: 0, 1, 2 ..., where no test says otherwise */
    double corner[PORTALS_MAX][CORNERS_MAX][3]; /* counter-clockwise about the way */
    double crossing[PORTALS_MAX][3];            /* of the line */
} Chain;

static void any_direction(Random *dice, double out[3]) {
    do
        for (int k = 0; k < 3; ++k)
            out[k] = 2 * random_unit(dice) - 1;
    while (vec_dot(out, out) > 1 || !(vec_normalize(out) > 0));
}

/* What a chain is made of. Its portals are up to 4 m wide, and the line keeps `margin` from one edge of each. */
typedef struct Kind {
    double margin;    /* metres; < 0: half a metre from all edges */
    double lean;      /* tangent of the normals' angle with the line, at most */
    uint32_t corners; /* 4, or a circle's */
    int touching;     /* every third portal stands at the one before, but for rounding; else they are a metre apart */
} Kind;

static Chain chain_round_a_line(Random *dice, uint32_t count, Kind kind) {
    Chain chain = {.count = count};
    double way[3], start[3], at = 0;
    any_direction(dice, way), any_direction(dice, start);
    for (uint32_t i = 0; i <= count; ++i)
        chain.cell[i] = i;
    for (uint32_t i = 0; i < count; ++i) {
        double n[3], u[3], v[3], aside[3];
        any_direction(dice, aside);
        vec_mad(aside, aside, -vec_dot(aside, way), way);
        (void)vec_normalize(aside);
        vec_mad(n, way, kind.lean * random_unit(dice), aside);
        (void)vec_normalize(n);
        vec_cross(u, n, aside);
        (void)vec_normalize(u);
        vec_cross(v, n, u);
        at += kind.touching && i % 3 == 2 ? 0 : 0.7 + 0.5 * random_unit(dice);
        vec_mad(chain.crossing[i], start, at, way);
        chain.corners[i] = kind.corners;
        double room[4]; /* from the line to the sides */
        for (int k = 0; k < 4; ++k)
            room[k] = 0.5 + 1.5 * random_unit(dice);
        if (kind.margin >= 0)
            room[random_index(dice, 4)] = kind.margin;
        const double square[4][2] = {{-room[0], -room[1]}, {room[2], -room[1]}, {room[2], room[3]}, {-room[0], room[3]}};
        for (uint32_t c = 0; c < kind.corners; ++c) {
            double turn = 2 * PI * c / kind.corners, radius = room[0] / cos(PI / kind.corners), x = square[c & 3][0], y = square[c & 3][1];
            if (kind.corners != 4)
                x = radius * cos(turn) + room[0] - fmax(kind.margin, 0), y = radius * sin(turn);
            vec_mad(chain.corner[i][c], chain.crossing[i], x, u);
            vec_mad(chain.corner[i][c], chain.corner[i][c], y, v);
        }
    }
    return chain;
}

static EnfScene *scene_of(const Chain *chain) {
    EnfScene *scene = NULL;
    uint32_t room, cell, portal;
    assert_int_equal(enf_scene_create(&scene), ENF_OK);
    /* Outdoors nothing but their winding tells which way portals face, however they lie. */
    assert_int_equal(enf_scene_add_room(scene, "outdoors", ENF_ROOM_EXTERIOR, &room), ENF_OK);
    for (uint32_t i = 0; i <= chain->count; ++i)
        assert_int_equal(enf_scene_add_cell(scene, room, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &cell), ENF_OK);
    for (uint32_t i = 0; i < chain->count; ++i) {
        double seen_from_before[CORNERS_MAX][3];
        for (uint32_t c = 0; c < chain->corners[i]; ++c)
            vec_copy(seen_from_before[c], chain->corner[i][chain->corners[i] - 1 - c]);
        assert_int_equal(
            enf_scene_add_portal(scene, chain->cell[i], chain->cell[i + 1], seen_from_before[0], chain->corners[i], 0, ENF_NONE, &portal),
            ENF_OK);
    }
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    return scene;
}

/* The chain in a model, forward or back; windows: [count] whole. */
typedef struct Loaded {
    EnfScene *scene;
    EnfRegionModel *model;
    uint32_t portals[PORTALS_MAX];
    EnfWindow windows[PORTALS_MAX];
    EnfChain chain;
} Loaded;

static void load(Loaded *l, const Chain *chain, int back) {
    uint32_t n = chain->count;
    l->scene = scene_of(chain);
    assert_int_equal(enf_region_model_create(l->scene, NULL, 0, NULL, &l->model), ENF_OK);
    for (uint32_t i = 0; i < n; ++i) {
        l->portals[i] = back ? 2 * (n - 1 - i) + 1 : 2 * i;
        if (!enf_window_load(l->model, l->portals[i], &l->windows[i]))
            l->windows[i].count = 0;
    }
    l->chain = (EnfChain){l->portals, n, &l->windows[0], &l->windows[n - 1]};
}

static void unload(Loaded *l) {
    enf_region_model_destroy(l->model);
    enf_scene_destroy(l->scene);
}

/* The line's crossing of each portal lies in what is left of its window. */
static void assert_line_kept(const Loaded *l, const Chain *chain, const char *why) {
    const EnfRegionModel *m = l->model;
    for (uint32_t i = 0; i < chain->count; ++i) {
        const EnfWindow *w = &l->windows[i];
        double x[3];
        vec_sub(x, chain->crossing[l->portals[i] >> 1], m->origin);
        vec_scale(x, m->scale, x);
        for (uint32_t c = 0; c < w->count; ++c) {
            double a[3], b[3], e[3], r[3], inward[3];
            enf_window_corner(w, c, a), enf_window_corner(w, c + 1, b);
            vec_sub(e, b, a), vec_sub(r, x, a);
            vec_cross(inward, m->plane[l->portals[i]], e);
            if (vec_dot(inward, r) < -1e-15) /* of edges cut to nothing the direction is rounding */
                fail_msg("%s: portal %u of %u lost the line by %g", why, i, chain->count, vec_dot(inward, r) / vec_length(inward));
        }
    }
}

static void narrowing_keeps_every_line_that_passes(void **state) {
    (void)state;
    static Loaded l;
    Random dice = {20261};
    for (uint32_t k = 0; k < 300; ++k) {
        uint32_t count = 2 + random_index(&dice, k % 20 ? 14 : 60);
        double extent = count + 4, margin = extent * pow(10, -10 + 8 * random_unit(&dice));
        Chain chain = chain_round_a_line(&dice, count, (Kind){margin, k % 3 ? 0.8 : 0, 4, k % 4 == 1});
        load(&l, &chain, k % 2);
        if (!enf_chain_contract(l.model, &l.chain, l.windows))
            fail_msg("chain %u of %u portals: narrowed to nothing, and a line passes by %g m", k, count, margin);
        assert_line_kept(&l, &chain, "from the ends");
        if (!enf_chain_contract_pairs(l.model, &l.chain, l.windows))
            fail_msg("chain %u of %u portals: pairs say shut, and a line passes by %g m", k, count, margin);
        assert_line_kept(&l, &chain, "by pairs");
        unload(&l);
    }
}

/* Four portals that no line passes, among wide ones. */
static void pairs_see_that_the_middle_is_shut(void **state) {
    (void)state;
    static Loaded l;
    Random dice = {7};
    for (uint32_t k = 0; k < 60; ++k) {
        uint32_t count = 8 + random_index(&dice, 8), first = 2 + random_index(&dice, count - 7);
        Chain chain = chain_round_a_line(&dice, count, (Kind){-1, 0.1, 4, 0});
        for (uint32_t i = first; i < first + 4; ++i) /* narrow, the last of them aside by its own width and more */
            for (uint32_t c = 0; c < 4; ++c) {
                double *v = chain.corner[i][c], aside[3];
                vec_sub(v, v, chain.crossing[i]);
                vec_mad(v, chain.crossing[i], 0.02, v);
                vec_sub(aside, chain.corner[first][1], chain.corner[first][0]);
                if (i == first + 3)
                    vec_mad(v, v, 0.8 / vec_length(aside), aside);
            }
        load(&l, &chain, k % 2);
        assert_false(enf_chain_contract_pairs(l.model, &l.chain, l.windows));
        unload(&l);
    }
}

/* What is too long or has too many corners for narrowing by pairs isn't said to be shut. */
static void what_pairs_are_not_asked_about_stays_open(void **state) {
    (void)state;
    static Loaded l;
    Random dice = {3};
    Chain chain = chain_round_a_line(&dice, 80, (Kind){1e-3, 0.5, 4, 0});
    load(&l, &chain, 0);
    assert_true(enf_chain_contract_pairs(l.model, &l.chain, l.windows));
    unload(&l);
    chain = chain_round_a_line(&dice, 6, (Kind){1e-3, 0.5, CORNERS_MAX, 0});
    load(&l, &chain, 0);
    assert_int_equal(l.windows[3].count, 0);
    assert_true(enf_chain_contract_pairs(l.model, &l.chain, l.windows));
    unload(&l);
}

typedef struct Ask {
    uint32_t threads, only_first_row;
    uint64_t chain_cap;
    int undecided_too;
} Ask;

/* Every cell of the chain sees every other one. */
static EnfRegionVisStats bake_sees_all(const Chain *chain, Ask ask) {
    EnfScene *scene = scene_of(chain);
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVisStats stats = enf_default_region_vis_stats();
    EnfRegionVis *result = NULL;
    const uint32_t first = 0;
    def.threads = ask.threads, def.chain_cap = ask.chain_cap;
    if (ask.only_first_row)
        def.from_cells = &first, def.from_count = 1;
    assert_int_equal(enf_region_vis_run(scene, &def, &result), ENF_OK);
    for (uint32_t i = 0; i <= (ask.only_first_row ? 0 : chain->count); ++i)
        for (uint32_t j = 0; j <= chain->count; ++j) {
            uint32_t seen = 9;
            assert_int_equal(enf_region_vis_pair(result, chain->cell[i], chain->cell[j], &seen), ENF_OK);
            if (seen == ENF_PAIR_HIDDEN || (seen != ENF_PAIR_VISIBLE && !ask.undecided_too))
                fail_msg("of %u cells, %u and %u see each other, and are said to be %u", chain->count + 1, chain->cell[i], chain->cell[j],
                         seen);
        }
    assert_int_equal(enf_region_vis_stats(result, &stats), ENF_OK);
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
    return stats;
}

/* Lines that pass many rooms by a few millionths of the scene: no sightline guessed finds them, the search does; and from ten portals on
 * it goes by the window half way, too. */
static void the_search_finds_threads_of_lines_through_many_rooms(void **state) {
    (void)state;
    Random dice = {11};
    uint64_t chains = 0;
    for (uint32_t k = 0; k < 60; ++k) {
        uint32_t count = 4 + random_index(&dice, 26);
        Chain chain = chain_round_a_line(&dice, count, (Kind){(count + 4) * 1e-6, k % 3 * 0.4, 4, k % 4 == 3});
        /* Which of two portals that cross each other comes first may stay open. */
        chains += bake_sees_all(&chain, (Ask){.threads = 1 + k % 2, .undecided_too = k % 4 == 3}).chains;
    }
    assert_true(chains > 1000);
}

/* What is outdoors isn't convex: a line leaves it, passes a building and comes out into it again. */
static void a_cell_that_isnt_convex_is_entered_again(void **state) {
    (void)state;
    Random dice = {23};
    for (uint32_t k = 0; k < 40; ++k) {
        uint32_t count = 5 + random_index(&dice, 8), outdoors = 1 + random_index(&dice, 2);
        Chain chain = chain_round_a_line(&dice, count, (Kind){(count + 4) * 1e-6, 0.4, 4, 0});
        for (uint32_t i = outdoors + 2; i < count; i += 2 + k % 2)
            chain.cell[i] = outdoors;
        (void)bake_sees_all(&chain, (Ask){.threads = 1, .undecided_too = 0});
    }
}

/* More corners than windows have: nothing is clipped, and the cone has more edges than it takes. */
static void round_portals_are_never_said_to_hide(void **state) {
    (void)state;
    Random dice = {13};
    for (uint32_t k = 0; k < 16; ++k) {
        uint32_t count = 3 + random_index(&dice, 14);
        Chain chain = chain_round_a_line(&dice, count, (Kind){(count + 4) * 1e-6, 0.3, k % 2 ? CORNERS_MAX : 19, 0});
        (void)bake_sees_all(&chain, (Ask){.threads = 1, .undecided_too = 1});
    }
}

/* Lines that cross portals at angles of a hundredth to a millionth, so that portals next to each other nearly face each other. */
static void flat_lines_are_seen(void **state) {
    (void)state;
    Random dice = {17};
    for (uint32_t k = 0; k < 40; ++k) {
        Chain chain = chain_round_a_line(&dice, 2 + random_index(&dice, 8), (Kind){-1, pow(10, 2 + k % 5), 4, 0});
        (void)bake_sees_all(&chain, (Ask){.threads = 1, .undecided_too = 1});
    }
}

/* Chains that are cut off are undecided, never hidden: after so many of them from one cell, and those of more than 250 portals. */
static void what_the_search_leaves_is_undecided(void **state) {
    (void)state;
    static Chain chain;
    Random dice = {19};
    uint64_t capped = 0;
    for (uint32_t cap = 1; cap <= 64; cap *= 4)
        for (uint32_t k = 0; k < 6; ++k) {
            chain = chain_round_a_line(&dice, 12, (Kind){16e-6, 0.4, 4, 0});
            capped += bake_sees_all(&chain, (Ask){.threads = 1, .chain_cap = cap, .undecided_too = 1}).chain_capped;
        }
    assert_true(capped > 100);
    chain = chain_round_a_line(&dice, PORTALS_MAX, (Kind){260e-6, 0.4, 4, 0});
    (void)bake_sees_all(&chain, (Ask){.threads = 1, .only_first_row = 1, .undecided_too = 1});
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(narrowing_keeps_every_line_that_passes),
        cmocka_unit_test(pairs_see_that_the_middle_is_shut),
        cmocka_unit_test(what_pairs_are_not_asked_about_stays_open),
        cmocka_unit_test(the_search_finds_threads_of_lines_through_many_rooms),
        cmocka_unit_test(a_cell_that_isnt_convex_is_entered_again),
        cmocka_unit_test(round_portals_are_never_said_to_hide),
        cmocka_unit_test(flat_lines_are_seen),
        cmocka_unit_test(what_the_search_leaves_is_undecided),
        cmocka_unit_test(memory_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
