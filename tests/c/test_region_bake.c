/* SPDX-License-Identifier: GPL-3.0-or-later
 * Long bakes: blocks, shards, state files cut off anywhere, door states as variants. All against the bake in one piece. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "scene_family.h"

static EnfScene *family(const char *spec) {
    EnfScene *scene = NULL;
    assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
    assert_int_equal(enf_scene_commit(scene), ENF_OK);
    return scene;
}

static EnfRegionVis *bake(const EnfScene *scene, const EnfRegionVisDef *def) {
    EnfRegionVis *result = NULL;
    EnfStatus status = enf_region_vis_run(scene, def, &result);
    if (status != ENF_OK)
        fail_msg("%s", enf_last_error());
    return result;
}

static EnfRegionVisStats stats_of(const EnfRegionVis *result) {
    EnfRegionVisStats stats = enf_default_region_vis_stats();
    assert_int_equal(enf_region_vis_stats(result, &stats), ENF_OK);
    return stats;
}

static char *read_all(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *bytes = NULL;
    *size = 0;
    for (size_t got = 1; got;) {
        bytes = realloc(bytes, *size + 65536);
        assert_non_null(bytes);
        got = fread(bytes + *size, 1, 65536, file);
        *size += got;
    }
    fclose(file);
    return bytes;
}

static void write_all(const char *path, const char *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

/* Same rows, statuses and sightlines, bit for bit. */
static void assert_same_bytes(const EnfRegionVis *a, const EnfRegionVis *b, const char *why) {
    const char *paths[2] = {"test_region_bake_a.txt", "test_region_bake_b.txt"};
    char *text[2];
    size_t size[2];
    for (int what = 0; what < 2; ++what) {
        for (int k = 0; k < 2; ++k) {
            const EnfRegionVis *r = k ? b : a;
            assert_int_equal(what ? enf_region_vis_write_witnesses(r, paths[k]) : enf_region_vis_write_matrix(r, paths[k]), ENF_OK);
            text[k] = read_all(paths[k], &size[k]);
            remove(paths[k]);
        }
        if (size[0] != size[1] || memcmp(text[0], text[1], size[0]) != 0)
            fail_msg("%s: %s differ", why, what ? "witnesses" : "matrices");
        free(text[0]), free(text[1]);
    }
}

/* Same rows and statuses; sightlines may be others. */
static void assert_same_answer(const EnfRegionVis *a, const EnfRegionVis *b, const char *why) {
    const uint64_t *fa = enf_region_vis_row_first(a), *fb = enf_region_vis_row_first(b);
    uint32_t n = enf_region_vis_cell_count(a);
    if (memcmp(fa, fb, (n + 1) * sizeof *fa) != 0 ||
        memcmp(enf_region_vis_row_cells(a), enf_region_vis_row_cells(b), fa[n] * sizeof(uint32_t)) != 0)
        fail_msg("%s: rows differ", why);
    if (memcmp(enf_region_vis_row_status(a), enf_region_vis_row_status(b), fa[n]) != 0)
        fail_msg("%s: statuses differ", why);
}

#define OFFICE "office:60,windows=0,objects=0,closed=0.2,seed=7"
#define STATE  "test_region_bake.state"

static void blocks_give_the_answer_of_one_piece(void **state) {
    (void)state;
    const char *specs[] = {OFFICE, "office:60,objects=0,closed=0.3", "columns:5", "tower:6", "ring:16"};
    for (size_t k = 0; k < sizeof specs / sizeof *specs; ++k) {
        EnfScene *scene = family(specs[k]);
        EnfRegionVisDef def = enf_default_region_vis_def();
        def.threads = 1;
        EnfRegionVis *whole = bake(scene, &def);
        for (uint32_t cells = 1; cells < 14; cells += 6) {
            def.block_cells = cells, def.threads = 1;
            EnfRegionVis *one = bake(scene, &def);
            def.threads = 4;
            EnfRegionVis *four = bake(scene, &def);
            assert_true(stats_of(one).blocks > 1);
            assert_same_answer(whole, one, specs[k]);
            assert_same_bytes(one, four, specs[k]);
            enf_region_vis_destroy(one), enf_region_vis_destroy(four);
        }
        enf_region_vis_destroy(whole);
        enf_scene_destroy(scene);
    }
}

static void shards_merge_to_the_same_bytes(void **state) {
    (void)state;
    EnfScene *scene = family(OFFICE);
    EnfRegionVisDef def = enf_default_region_vis_def();
    const char *paths[5];
    char names[5][32];
    def.block_cells = 16;
    EnfRegionVis *whole = bake(scene, &def), *merged = NULL;
    for (uint32_t count = 2; count <= 5; ++count) {
        for (uint32_t k = 0; k < count; ++k) {
            snprintf(names[k], sizeof names[k], STATE ".%u", k);
            paths[k] = names[k];
            remove(names[k]);
            def.shard_index = k, def.shard_count = count, def.state_path = names[k], def.threads = k % 2 + 1;
            EnfRegionVis *part = bake(scene, &def);
            assert_int_equal(stats_of(part).partial, 1);
            assert_int_equal(enf_region_vis_save(part, "no.state"), ENF_ERROR_STATE);
            enf_region_vis_destroy(part);
        }
        assert_int_equal(enf_region_vis_load(scene, paths, count - 1, &merged), ENF_ERROR_STATE); /* one is missing */
        const char *first = paths[0];
        paths[0] = paths[count - 1], paths[count - 1] = first; /* any order */
        if (enf_region_vis_load(scene, paths, count, &merged) != ENF_OK)
            fail_msg("%s", enf_last_error());
        assert_same_bytes(whole, merged, "merged shards");
        assert_int_equal(stats_of(merged).visible_pairs, stats_of(whole).visible_pairs);
        assert_int_equal(stats_of(merged).hidden_certified, stats_of(whole).hidden_certified);
        enf_region_vis_destroy(merged);
        for (uint32_t k = 0; k < count; ++k)
            remove(names[k]);
    }
    enf_region_vis_destroy(whole);
    enf_scene_destroy(scene);
}

static void assert_load_fails(const EnfScene *scene, const char *a, const char *b, EnfStatus status, const char *why, const char *named) {
    const char *paths[2] = {a, b};
    EnfRegionVis *result = NULL;
    assert_int_equal(enf_region_vis_load(scene, paths, 2, &result), status);
    assert_null(result);
    if (!strstr(enf_last_error(), why) || !strstr(enf_last_error(), named))
        fail_msg("\"%s\" should say %s and name %s", enf_last_error(), why, named);
}

/* Shares that don't belong together, one that is torn, one that is missing: which file, and why. */
static void wrong_shares_are_told_apart(void **state) {
    (void)state;
    EnfScene *scene = family(OFFICE), *other = family("office:60,windows=0,objects=0,closed=0.2,seed=8");
    EnfRegionVisDef def = enf_default_region_vis_def();
    const char *names[] = {STATE ".1", STATE ".2", STATE ".coarse", STATE ".close", STATE ".other", STATE ".torn"};
    def.shard_count = 2, def.threads = 1;
    for (uint32_t k = 0; k < 5; ++k) {
        remove(names[k]);
        def.shard_index = k != 0, def.state_path = names[k];
        def.block_cells = k == 2 ? 40 : 16, def.clearance = k == 3 ? 1e-3 : 0;
        enf_region_vis_destroy(bake(k == 4 ? other : scene, &def));
    }
    size_t size;
    char *bytes = read_all(names[1], &size);
    write_all(names[5], bytes, size - 10);
    assert_load_fails(scene, names[0], names[2], ENF_ERROR_BAD_INPUT, "not of the same bake", names[2]);
    assert_load_fails(scene, names[0], names[3], ENF_ERROR_BAD_INPUT, "clearance", names[3]);
    assert_load_fails(scene, names[0], names[4], ENF_ERROR_BAD_INPUT, "another scene", names[4]);
    assert_load_fails(scene, names[4], names[0], ENF_ERROR_BAD_INPUT, "another scene", names[4]);
    assert_load_fails(scene, names[0], names[5], ENF_ERROR_STATE, "cut short or damaged", names[5]);
    assert_load_fails(scene, names[0], names[0], ENF_ERROR_STATE, "missing", names[0]);
    assert_load_fails(scene, names[0], "nowhere.state", ENF_ERROR_IO, "", "nowhere.state");
    bytes[40] ^= 1; /* in the head */
    write_all(names[5], bytes, size);
    assert_load_fails(scene, names[0], names[5], ENF_ERROR_BAD_INPUT, "head", names[5]);
    bytes[40] ^= 1, bytes[6] = '1';
    write_all(names[5], bytes, size);
    assert_load_fails(scene, names[0], names[5], ENF_ERROR_BAD_INPUT, "another version", names[5]);
    free(bytes);
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k)
        remove(names[k]);
    enf_scene_destroy(scene), enf_scene_destroy(other);
}

static void assert_row_of(const EnfScene *scene, const EnfRegionVis *whole, const EnfRegionVis *part, uint32_t row, const char *why) {
    uint64_t a = enf_region_vis_row_first(whole)[row], b = enf_region_vis_row_first(part)[row];
    uint64_t size = enf_region_vis_row_first(whole)[row + 1] - a;
    if (enf_region_vis_row_first(part)[row + 1] - b != size ||
        memcmp(enf_region_vis_row_cells(whole) + a, enf_region_vis_row_cells(part) + b, size * sizeof(uint32_t)) != 0 ||
        memcmp(enf_region_vis_row_status(whole) + a, enf_region_vis_row_status(part) + b, size) != 0)
        fail_msg("%s: row %u differs from the whole bake's", why, row);
    for (uint64_t k = a; k < a + size; ++k) { /* each pair shown, in the scene's cells and portals */
        uint32_t cell = enf_region_vis_row_cells(whole)[k], portals[256], count = 0;
        double segment[6], clearance;
        if (cell == row || enf_region_vis_row_status(whole)[k] != ENF_PAIR_VISIBLE)
            continue;
        assert_int_equal(enf_region_vis_witness(part, row, cell, segment, portals, 256, &count, &clearance), ENF_OK);
        assert_true(count > 0 && clearance >= 0.999 * stats_of(part).clearance);
        uint32_t at = row;
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t *of = enf_scene_portal_cells(scene) + 2 * (size_t)portals[i];
            assert_true(of[0] == at || of[1] == at);
            at = of[0] == at ? of[1] : of[0];
        }
        assert_int_equal(at, cell);
    }
}

/* Objects need more of the scene than the rows did. */
static void assert_objects_of(const EnfRegionVis *whole, const EnfRegionVis *part, uint32_t row) {
    EnfObjectVis *some = NULL, *all = NULL;
    assert_int_equal(enf_object_vis_run(part, &row, 1, NULL, 0, 1, &some), ENF_OK);
    assert_int_equal(enf_object_vis_run(whole, &row, 1, NULL, 0, 1, &all), ENF_OK);
    uint64_t count = enf_object_vis_row_first(all)[1];
    assert_int_equal(enf_object_vis_row_first(some)[1], count);
    assert_memory_equal(enf_object_vis_row_objects(some), enf_object_vis_row_objects(all), count * sizeof(uint32_t));
    enf_object_vis_destroy(some), enf_object_vis_destroy(all);
}

static void some_rows_are_those_of_the_whole(void **state) {
    (void)state;
    const char *specs[] = {OFFICE, "office:100,objects=1", "office:600,windows=0,objects=0,closed=0.1", "columns:8", "tower:20", "ring:40"};
    for (size_t k = 0; k < sizeof specs / sizeof *specs; ++k) {
        EnfScene *scene = family(specs[k]);
        EnfRegionVisDef def = enf_default_region_vis_def();
        EnfRegionVis *whole = bake(scene, &def);
        uint32_t n = enf_region_vis_cell_count(whole), rows[3];
        for (uint32_t i = 0; i < 12; ++i) {
            def.from_count = 1 + i % 3, def.from_cells = rows;
            for (uint32_t r = 0; r < def.from_count; ++r)
                rows[r] = (i * 7919 + r * 104729 + 13) % n;
            def.block_cells = i % 2; /* a block a row, too */
            EnfRegionVis *part = bake(scene, &def);
            for (uint32_t r = 0; r < def.from_count; ++r)
                assert_row_of(scene, whole, part, rows[r], specs[k]);
            if (i < 2)
                assert_objects_of(whole, part, rows[0]);
            enf_region_vis_destroy(part);
        }
        enf_region_vis_destroy(whole);
        enf_scene_destroy(scene);
    }
}

static void a_state_file_cut_off_anywhere_goes_on_to_the_same_bytes(void **state) {
    (void)state;
    EnfScene *scene = family(OFFICE);
    EnfRegionVisDef def = enf_default_region_vis_def();
    def.block_cells = 16, def.threads = 1;
    EnfRegionVis *whole = bake(scene, &def);
    remove(STATE);
    def.state_path = STATE;
    enf_region_vis_destroy(bake(scene, &def));
    size_t size;
    char *bytes = read_all(STATE, &size);
    uint64_t loaded_some = 0;
    for (size_t cut = 0; cut < size; cut += size / 23 + 1) {
        if (cut && cut < 500)
            continue; /* a damaged head is an error, below */
        write_all(STATE, bytes, cut);
        EnfRegionVis *resumed = bake(scene, &def);
        loaded_some += stats_of(resumed).blocks_loaded > 0 && stats_of(resumed).blocks_loaded < stats_of(resumed).blocks;
        assert_same_bytes(whole, resumed, "resumed");
        enf_region_vis_destroy(resumed);
        EnfRegionVis *again = bake(scene, &def); /* all of it stands there now */
        assert_int_equal(stats_of(again).blocks_loaded, stats_of(again).blocks);
        assert_same_bytes(whole, again, "read back");
        enf_region_vis_destroy(again);
    }
    assert_true(loaded_some > 10);
    /* Bits that flipped: the block is done again. */
    for (size_t at = size / 2; at < size; at += size / 7) {
        bytes[at] ^= 16;
        write_all(STATE, bytes, size);
        bytes[at] ^= 16;
        EnfRegionVis *resumed = bake(scene, &def);
        assert_same_bytes(whole, resumed, "resumed after damage");
        enf_region_vis_destroy(resumed);
    }
    EnfRegionVis *none = NULL;
    write_all(STATE, bytes, 40);
    assert_int_equal(enf_region_vis_run(scene, &def, &none), ENF_ERROR_BAD_INPUT);
    write_all(STATE, "something else entirely", 23);
    assert_int_equal(enf_region_vis_run(scene, &def, &none), ENF_ERROR_BAD_INPUT);
    write_all(STATE, bytes, size);
    def.block_cells = 17; /* another question */
    assert_int_equal(enf_region_vis_run(scene, &def, &none), ENF_ERROR_BAD_INPUT);
    EnfScene *other = family("office:60,windows=0,objects=0,closed=0.2,seed=8");
    def.block_cells = 16;
    assert_int_equal(enf_region_vis_run(other, &def, &none), ENF_ERROR_BAD_INPUT);
    assert_non_null(strstr(enf_last_error(), "another scene"));
    free(bytes);
    remove(STATE);
    enf_region_vis_destroy(whole);
    enf_scene_destroy(scene), enf_scene_destroy(other);
}

static void a_result_saved_comes_back(void **state) {
    (void)state;
    EnfScene *scene = family("office:60,objects=0,closed=0.2");
    EnfRegionVisDef def = enf_default_region_vis_def();
    uint32_t from[3] = {5, 9, 0};
    const char *path = STATE;
    for (int part = 0; part < 2; ++part) {
        if (part)
            def.from_cells = from, def.from_count = 3;
        EnfRegionVis *made = bake(scene, &def), *back = NULL;
        assert_int_equal(enf_region_vis_save(made, STATE), ENF_OK);
        if (enf_region_vis_load(scene, &path, 1, &back) != ENF_OK)
            fail_msg("%s", enf_last_error());
        assert_same_answer(made, back, "saved");
        assert_same_bytes(made, back, "saved");
        enf_region_vis_destroy(made), enf_region_vis_destroy(back);
    }
    remove(STATE);
    enf_scene_destroy(scene);
}

/* Random states again and again: each variant of the one before, each compared with a bake from nothing. */
static void a_variant_is_the_fresh_answer(void **state) {
    (void)state;
    const char *specs[] = {OFFICE, "office:80,objects=0,closed=0.4", "tower:8,closed=0.5", "enfilade:12", "hub:24"};
    uint64_t seed = 12345, kept = 0, asked = 0, fresh_chains = 0, chains = 0;
    for (size_t k = 0; k < sizeof specs / sizeof *specs; ++k) {
        EnfScene *scene = family(specs[k]);
        EnfSceneCounts counts;
        memset(&counts, 0, sizeof counts);
        counts.struct_size = (uint32_t)sizeof counts;
        assert_int_equal(enf_scene_counts(scene, &counts), ENF_OK);
        EnfRegionVisDef def = enf_default_region_vis_def();
        def.threads = 1;
        EnfRegionVis *before = bake(scene, &def);
        for (int round = 0; round < 12; ++round) {
            for (int c = 0; c < 1 + round % 4; ++c) {
                seed = seed * 6364136223846793005u + 1442695040888963407u;
                uint32_t opening = (uint32_t)(seed >> 33) % counts.openings, to = (uint32_t)(seed >> 20) % 3;
                assert_int_equal(enf_scene_set_opening_state(scene, opening, to), ENF_OK);
            }
            def.variant_of = NULL;
            EnfRegionVis *fresh = bake(scene, &def);
            def.variant_of = before;
            EnfRegionVis *variant = bake(scene, &def);
            assert_same_answer(fresh, variant, specs[k]);
            EnfRegionVisStats s = stats_of(variant);
            kept += s.pairs_kept, asked += s.pairs_reopened, chains += s.chains, fresh_chains += stats_of(fresh).chains;
            /* Its sightlines are as good: each pair seen has one, through what is open now. */
            const uint64_t *first = enf_region_vis_row_first(variant);
            for (uint32_t i = 0; i < counts.cells; ++i)
                for (uint64_t e = first[i]; e < first[i + 1]; ++e) {
                    uint32_t j = enf_region_vis_row_cells(variant)[e], count = 0;
                    double segment[6], clearance;
                    if (i == j || enf_region_vis_row_status(variant)[e] != ENF_PAIR_VISIBLE)
                        continue;
                    assert_int_equal(enf_region_vis_witness(variant, i, j, segment, NULL, 0, &count, &clearance), ENF_OK);
                    assert_true(clearance >= s.clearance);
                }
            enf_region_vis_destroy(fresh), enf_region_vis_destroy(before);
            before = variant;
        }
        enf_region_vis_destroy(before);
        enf_scene_destroy(scene);
    }
    assert_true(asked < kept / 2);
    assert_true(chains < fresh_chains / 2);
}

static void nothing_changed_asks_nothing(void **state) {
    (void)state;
    EnfScene *scene = family("office:46,windows=0,objects=0");
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *before = bake(scene, &def);
    def.variant_of = before;
    EnfRegionVis *same = bake(scene, &def);
    EnfRegionVisStats s = stats_of(same);
    assert_int_equal(s.pairs_reopened, 0);
    assert_int_equal(s.chains, 0);
    assert_same_answer(before, same, "unchanged");
    uint32_t from = 0;
    EnfRegionVis *none = NULL;
    def.from_cells = &from, def.from_count = 1;
    assert_int_equal(enf_region_vis_run(scene, &def, &none), ENF_ERROR_INVALID_ARGUMENT);
    def.from_cells = NULL, def.from_count = 0, def.clearance = 0.5;
    assert_int_equal(enf_region_vis_run(scene, &def, &none), ENF_ERROR_INVALID_ARGUMENT);
    enf_region_vis_destroy(before), enf_region_vis_destroy(same);
    enf_scene_destroy(scene);
}

/* The recess of a shut door is seen from its own side and sees that side; nobody looks through it. */
static void a_shut_openings_own_cell_is_a_dead_end(void **state) {
    (void)state;
    EnfScene *scene = family("enfilade:3"); /* salons 0, 1, 3; doors between them: cells 2, 4 */
    const uint32_t *openings = enf_scene_cell_openings(scene);
    assert_int_equal(openings[2], 0);
    assert_int_equal(openings[4], 1);
    assert_int_equal(enf_scene_set_opening_state(scene, 0, ENF_STATE_CLOSED), ENF_OK);
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *r = bake(scene, &def);
    static const uint32_t seen[][3] = {{0, 2, 1}, {2, 0, 1}, {2, 1, 1}, {1, 2, 1}, {2, 3, 1}, {3, 2, 1},
                                       {0, 1, 0}, {0, 3, 0}, {0, 4, 0}, {1, 3, 1}, {2, 4, 1}};
    for (size_t k = 0; k < sizeof seen / sizeof *seen; ++k) {
        uint32_t status;
        assert_int_equal(enf_region_vis_pair(r, seen[k][0], seen[k][1], &status), ENF_OK);
        if ((status != ENF_PAIR_HIDDEN) != (seen[k][2] != 0))
            fail_msg("cells %u, %u: status %u", seen[k][0], seen[k][1], status);
    }
    enf_region_vis_destroy(r);
    enf_scene_destroy(scene);
}

/* A line through the outside may pass a window nearer than the one it is meant for: the pair stands all the same. What the
 * sampling finds must never be hidden. */
static void views_across_the_outside_are_not_lost(void **state) {
    (void)state;
    EnfScene *scene = family("office:150,objects=0,closed=0.5");
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *exact = bake(scene, &def);
    def.method = ENF_REGION_SAMPLE, def.sample_effort = 2;
    EnfRegionVis *sampled = bake(scene, &def);
    const uint64_t *first = enf_region_vis_row_first(sampled);
    for (uint32_t i = 0; i < enf_region_vis_cell_count(sampled); ++i)
        for (uint64_t e = first[i]; e < first[i + 1]; ++e) {
            uint32_t status, j = enf_region_vis_row_cells(sampled)[e];
            assert_int_equal(enf_region_vis_pair(exact, i, j, &status), ENF_OK);
            if (status == ENF_PAIR_HIDDEN)
                fail_msg("cells %u, %u have a sightline and are hidden", i, j);
        }
    enf_region_vis_destroy(exact), enf_region_vis_destroy(sampled);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_give_the_answer_of_one_piece),
        cmocka_unit_test(shards_merge_to_the_same_bytes),
        cmocka_unit_test(wrong_shares_are_told_apart),
        cmocka_unit_test(some_rows_are_those_of_the_whole),
        cmocka_unit_test(a_state_file_cut_off_anywhere_goes_on_to_the_same_bytes),
        cmocka_unit_test(a_result_saved_comes_back),
        cmocka_unit_test(a_variant_is_the_fresh_answer),
        cmocka_unit_test(nothing_changed_asks_nothing),
        cmocka_unit_test(a_shut_openings_own_cell_is_a_dead_end),
        cmocka_unit_test(views_across_the_outside_are_not_lost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
