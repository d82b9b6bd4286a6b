/* SPDX-License-Identifier: GPL-3.0-or-later
 * Memory that runs out in the middle of an engine's work, at any of its calls, for good or once: a status or a safe answer, and nothing
 * is left behind. */
#include "scarce_memory.h"

#include <math.h>
#include <stdio.h>

#include "chain_families.h"

static EnfStatus take_rows(Bench *b, EnfRegionVis *result) {
    const uint64_t *first = enf_region_vis_row_first(result);
    uint32_t n = enf_region_vis_cell_count(result);
    assert_true((uint64_t)n * n <= SEEN_MAX);
    for (uint32_t i = 0; i < n; ++i)
        for (uint64_t k = first[i]; k < first[i + 1]; ++k)
            b->seen[i * n + enf_region_vis_row_cells(result)[k]] = 1;
    enf_region_vis_destroy(result);
    return ENF_OK;
}

static EnfStatus bake(Bench *b) {
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL;
    def.threads = b->threads;
    EnfStatus status = enf_region_vis_run(b->scene, &def, &result);
    return status == ENF_OK ? take_rows(b, result) : status;
}

#define STATE "test_scarce_memory.state"
static EnfStatus bake_in_blocks_and_load(Bench *b) {
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL, *loaded = NULL;
    const char *path = STATE;
    remove(STATE);
    def.threads = b->threads, def.block_cells = 9, def.state_path = STATE;
    EnfStatus status = enf_region_vis_run(b->scene, &def, &result);
    if (status == ENF_OK)
        status = enf_region_vis_load(b->scene, &path, 1, &loaded);
    if (status == ENF_OK)
        status = enf_region_vis_save(loaded, STATE);
    enf_region_vis_destroy(result);
    remove(STATE);
    if (status != ENF_OK)
        enf_region_vis_destroy(loaded);
    return status == ENF_OK ? take_rows(b, loaded) : status;
}

static EnfStatus bake_a_variant(Bench *b) {
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL;
    def.threads = b->threads, def.variant_of = b->whole;
    assert_int_equal(enf_scene_set_opening_state(b->scene, b->opening, ENF_STATE_CLOSED), ENF_OK);
    EnfStatus status = enf_region_vis_run(b->scene, &def, &result);
    assert_int_equal(enf_scene_set_opening_state(b->scene, b->opening, ENF_STATE_OPEN), ENF_OK);
    return status == ENF_OK ? take_rows(b, result) : status;
}

/* The rows of one cell, by a part of the scene that grows. */
static EnfStatus bake_a_row(Bench *b) {
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL;
    const uint32_t from = 3;
    def.threads = b->threads, def.from_cells = &from, def.from_count = 1;
    EnfStatus status = enf_region_vis_run(b->scene, &def, &result);
    return status == ENF_OK ? take_rows(b, result) : status;
}

/* Time that is up is no lack of memory: a result comes all the same. */
static EnfStatus bake_and_cancel(Bench *b) {
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfJob *job = NULL;
    EnfRegionVis *result = NULL;
    uint32_t done = 0;
    def.threads = b->threads;
    EnfStatus status = enf_region_vis_start(b->scene, &def, &job);
    if (status != ENF_OK)
        return status;
    enf_job_cancel(job);
    status = enf_job_wait(job, -1, &done);
    if (status == ENF_ERROR_CANCELLED)
        status = enf_region_vis_take(job, &result);
    enf_job_destroy(job);
    enf_region_vis_destroy(result);
    return status;
}

static EnfStatus see_objects(Bench *b) {
    const uint32_t from[2] = {0, 5};
    EnfObjectVis *objects = NULL;
    EnfStatus status = enf_object_vis_run(b->whole, from, 2, NULL, 0, b->threads, &objects);
    if (status != ENF_OK)
        return status;
    const uint64_t *first = enf_object_vis_row_first(objects);
    for (uint32_t row = 0; row < 2; ++row)
        for (uint64_t k = first[row]; k < first[row + 1]; ++k)
            b->seen[2 * enf_object_vis_row_objects(objects)[k] + row] = 1;
    enf_object_vis_destroy(objects);
    return ENF_OK;
}

static EnfCamera camera_at(double x, double y, double turn) {
    EnfCamera camera = enf_default_camera();
    const double world[16] = {turn, 0, 1, x, 1, 0, -turn, y, 0, 1, 0, 1.5, 0, 0, 0, 1};
    memcpy(camera.world_from_camera, world, sizeof world);
    double *m = camera.world_from_camera, size = 1 / sqrt(1 + turn * turn);
    for (int k = 0; k < 8; ++k)
        m[k] *= k % 4 < 3 ? size : 1;
    camera.angle_x = 1.5, camera.angle_y = 1;
    return camera;
}

static EnfStatus look(Bench *b) {
    EnfView *view = NULL;
    EnfStatus status = enf_view_create(b->scene, &view);
    for (uint32_t k = 0; k < 6 && status == ENF_OK; ++k) {
        EnfViewDef def = enf_default_view_def();
        EnfCamera camera[2] = {camera_at(3 + k, 6, 0.2 * k), camera_at(3.3 + k, 6, 0.25 * k)};
        def.method = k % 3, def.occluders = k % 2, def.reuse_distance = k == 3 ? 0.5 : 0, def.reuse_angle = k == 3 ? 0.2 : 0;
        status = k == 4 ? enf_view_query_union(view, camera, 2, 1, &def) : enf_view_query(view, camera, &def);
        EnfViewResult result = enf_default_view_result();
        if (status == ENF_OK && (status = enf_view_result(view, &result)) == ENF_OK) {
            for (uint32_t i = 0; i < result.cell_count; ++i)
                b->seen[6 * result.cells[i] + k] = 1;
            for (uint32_t i = 0; i < result.object_count; ++i)
                b->seen[SEEN_MAX / 2 + 6 * result.objects[i] + k] = 1;
        }
    }
    enf_view_destroy(view);
    return status;
}

static EnfStatus cast_rays(Bench *b) {
    enum { WIDE = 40, HIGH = 24 };
    EnfRaycaster *raycaster = NULL;
    EnfLightSets *sets = NULL;
    float depth[WIDE * HIGH];
    uint32_t surface[WIDE * HIGH];
    EnfCamera camera = camera_at(4, 6, 0.3);
    EnfLight light = enf_default_light();
    light.position[0] = 4, light.position[1] = 6, light.position[2] = 2, light.radius = 0.1;
    EnfStatus status = enf_raycaster_create(b->scene, &raycaster);
    for (uint32_t k = 0; k < 3 && status == ENF_OK; ++k) {
        EnfRaycastImage image = enf_default_raycast_image();
        image.width = WIDE, image.height = HIGH, image.method = k, image.depth = depth, image.surface = surface, image.threads = b->threads;
        status = enf_raycast_image(raycaster, &camera, &image);
        add_hash(b, depth, sizeof depth), add_hash(b, surface, sizeof surface);
    }
    if (status == ENF_OK)
        status = enf_light_sets_create(b->scene, &light, 1, ENF_LIGHT_SETS_REGION, b->threads, &sets);
    if (status == ENF_OK)
        add_hash(b, enf_light_sets_first(sets), sizeof(uint64_t));
    EnfPreview preview = enf_default_preview();
    preview.width = WIDE, preview.height = HIGH, preview.threads = b->threads, preview.raycaster = raycaster, preview.lights = &light;
    preview.light_count = 1, preview.light_sets = sets, preview.depth = depth;
    if (status == ENF_OK)
        status = enf_preview(&preview, &camera);
    add_hash(b, depth, sizeof depth);
    enf_light_sets_destroy(sets);
    enf_raycaster_destroy(raycaster);
    return status;
}

/* Chains with coincidences on purpose, of those whose answer takes exact arithmetic. */
enum { CHAINS = 24 };
static struct {
    double vertices[CHAIN_MAX_PORTALS * CHAIN_MAX_CORNERS][3];
    uint32_t counts[CHAIN_MAX_PORTALS], portal_count;
} chains[CHAINS];

/* The portal's corners, counter-clockwise about the way the chain goes. */
static uint32_t wind(const ChainPortal *portal, double (*out)[3]) {
    double along = 0;
    uint32_t n = portal->corner_count;
    for (uint32_t i = 1; i + 1 < n; ++i)
        for (int k = 0; k < 3; ++k) {
            int u = (k + 1) % 3, v = (k + 2) % 3;
            const double *o = portal->corners[0], *a = portal->corners[i], *c = portal->corners[i + 1];
            along += portal->forward[k] * ((a[u] - o[u]) * (c[v] - o[v]) - (a[v] - o[v]) * (c[u] - o[u]));
        }
    for (uint32_t i = 0; i < n; ++i)
        memcpy(out[i], portal->corners[along > 0 ? i : n - 1 - i], sizeof *out);
    return n;
}

static void find_exact_chains(void) {
    EnfChainQuery *query = NULL;
    Random dice = {1};
    uint32_t found = 0;
    assert_int_equal(enf_chain_query_create(&query), ENF_OK);
    for (uint32_t tries = 0; tries < 100000 && found < CHAINS; ++tries) {
        const ChainFamily *family = &chain_families[tries % chain_family_count];
        Chain chain = {0};
        EnfChainAnswer answer = enf_default_chain_answer();
        uint32_t corners = 0;
        family->make(&dice, &chain);
        chains[found].portal_count = chain.portal_count;
        for (uint32_t p = 0; p < chain.portal_count; ++p)
            corners += chains[found].counts[p] = wind(&chain.portals[p], &chains[found].vertices[corners]);
        if (enf_chain_query(query, chains[found].vertices[0], chains[found].counts, chain.portal_count, 0, &answer) == ENF_OK)
            found += answer.exact_signs > 0;
    }
    assert_int_equal(found, CHAINS);
    enf_chain_query_destroy(query);
}

static EnfStatus ask_chains(Bench *b) {
    EnfChainQuery *query = NULL;
    EnfChainAnswer answer = enf_default_chain_answer();
    EnfStatus status = enf_chain_query_create(&query);
    for (uint32_t k = 0; k < CHAINS && status == ENF_OK; ++k)
        if ((status = enf_chain_query(query, chains[k].vertices[0], chains[k].counts, chains[k].portal_count, 0, &answer)) == ENF_OK)
            b->seen[k] = answer.status != ENF_PAIR_HIDDEN;
    enf_chain_query_destroy(query);
    return status;
}

static void memory_may_end_anywhere(void **state) {
    (void)state;
    static const struct {
        Work work;
        const char *what;
    } works[] = {{bake, "bake"},
                 {bake_in_blocks_and_load, "blocks and state file"},
                 {bake_a_variant, "variant"},
                 {bake_a_row, "one row"},
                 {bake_and_cancel, "cancelled bake"},
                 {see_objects, "objects"},
                 {look, "views"},
                 {cast_rays, "rays"},
                 {ask_chains, "chains"}};
    static Bench b;
    begin_scarce(&b, "office:6,objects=2,windows=1,occluders=1");
    find_exact_chains();
    EnfRegionVisDef def = enf_default_region_vis_def();
    assert_int_equal(enf_region_vis_run(b.scene, &def, &b.whole), ENF_OK);
    for (uint32_t k = 0; k < sizeof works / sizeof *works; ++k)
        for (b.threads = 1; b.threads <= 3; b.threads += 2)
            run_out(works[k].work, works[k].what, &b);
    enf_region_vis_destroy(b.whole);
    end_scarce(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(memory_may_end_anywhere)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
