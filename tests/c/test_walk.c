/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walks: what an answer made for the way ahead lacks of what each frame sees, by rays walked one by one. */
#include "moved_scene.h"
#include "portal_file.h"
#include "view_kit.h"

typedef struct Walker {
    double eye[3], speed, heading, climb, yaw, yaw_rate, pitch;
    uint32_t left; /* frames until it does something else */
} Walker;

/* Straight on, in a curve, turning on the spot, standing still, shaking by hand; level or not. */
static EnfCamera next_frame(Walker *at, SightRng *rng) {
    if (at->left-- == 0) {
        const uint32_t kind = (uint32_t)(sight_next(rng) % 5);
        at->left = 5 + (uint32_t)(sight_next(rng) % 60);
        at->speed = kind == 2 || kind == 3 ? 0 : 0.15 * sight_unit(rng);
        at->heading = kind == 1 ? at->yaw : 6.283185307 * sight_unit(rng);
        at->climb = kind == 4 ? 0.2 * sight_unit(rng) - 0.1 : 0;
        at->yaw_rate = kind == 1 || kind == 2 ? 0.12 * sight_unit(rng) - 0.06 : 0;
    }
    const double shake = at->climb != 0 ? 2e-3 : 0;
    at->yaw += at->yaw_rate + shake * (sight_unit(rng) - 0.5);
    at->pitch = fmax(-0.6, fmin(0.6, at->pitch + shake * (sight_unit(rng) - 0.5)));
    at->heading += at->yaw_rate;
    at->eye[0] += at->speed * cos(at->heading) + shake * (sight_unit(rng) - 0.5);
    at->eye[1] += at->speed * sin(at->heading) + shake * (sight_unit(rng) - 0.5);
    at->eye[2] += at->speed * at->climb;
    return camera_at(at->eye, at->yaw, at->pitch);
}

/* Of each scene; ENF_WALKS: more. */
static uint32_t walk_count(void) {
    const char *more = getenv("ENF_WALKS");
    return more ? (uint32_t)strtoul(more, NULL, 10) : 8;
}

typedef struct Counts {
    uint32_t frames, reused, cells, objects;
} Counts;

/* Some direction of the view, or one past the edge of a portal that an earlier ray passed, from a hair to a hand inside. */
static void pick_ray(const EnfScene *scene, SightRng *rng, const EnfCamera *camera, const double eye[3], uint32_t aimed, double d[3]) {
    const double *m = camera->world_from_camera;
    const double tan_x = tan(0.5 * camera->angle_x), tan_y = tan(0.5 * camera->angle_y);
    if (aimed != ENF_NONE) {
        const uint32_t first = scene->portal_vertex_first[aimed], n = scene->portal_vertex_first[aimed + 1] - first;
        const double(*v)[3] = (const double(*)[3])(scene->portal_vertices + first);
        const uint32_t a = (uint32_t)(sight_next(rng) % n);
        const double s = sight_unit(rng), h = pow(10, -10 * sight_unit(rng));
        double across[3] = {0, 0, 0};
        for (int c = 0; c < 3; c++)
            d[c] = (1 - h) * ((1 - s) * v[a][c] + s * v[(a + 1) % n][c]) + h * v[(a + 2) % n][c] - eye[c];
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++)
                across[k] += d[c] * m[4 * c + k];
        if (across[2] < 0 && fabs(across[0]) < -0.9999 * tan_x * across[2] && fabs(across[1]) < -0.9999 * tan_y * across[2])
            return;
    }
    const double x = (2 * sight_unit(rng) - 1) * tan_x, y = (2 * sight_unit(rng) - 1) * tan_y;
    for (int c = 0; c < 3; c++)
        d[c] = x * m[4 * c] + y * m[4 * c + 1] - m[4 * c + 2];
}

static void frame_sees(const EnfScene *scene, const SightWalker *walker, SightRng *rng, const EnfCamera *camera, const Sets *s,
                       const char *what, Counts *counts) {
    double eye[3];
    uint32_t cell, located = 0, aimed = ENF_NONE;
    eye_of(camera, eye);
    if (enf_scene_locate(scene, eye, &cell, 1, &located) != ENF_OK || located != 1)
        return; /* in a wall */
    for (int i = 0; i < 12; i++) {
        static SightWalk ray;
        double d[3];
        pick_ray(scene, rng, camera, eye, i % 2 ? aimed : ENF_NONE, d);
        const double depth =
            -(d[0] * camera->world_from_camera[2] + d[1] * camera->world_from_camera[6] + d[2] * camera->world_from_camera[10]);
        const double near_at = camera->clip_near / depth; /* what is nearer isn't drawn */
        sight_walk(walker, cell, eye, d, INFINITY, &ray);
        if (ray.cell_count > 1)
            aimed = ray.portals[sight_next(rng) % (ray.cell_count - 1)];
        for (uint32_t w = 0; w < ray.cell_count && ray.clearance_at[w] > 2e-10; w++, counts->cells++) {
            const uint32_t c = ray.cells[w];
            const double leave = w + 1 < ray.cell_count ? ray.t_enter[w + 1] : INFINITY;
            if (!s->cells[c])
                fail_msg("%s, frame %u: cell %u is missed", what, counts->frames, c);
            for (uint32_t o = scene->cell_object_first[c]; o < scene->cell_object_first[c + 1]; o++) {
                const uint32_t object = scene->cell_object_list[o];
                if (!sight_meets_box(eye, d, fmax(ray.t_enter[w], near_at), leave, scene->objects[object].bounds))
                    continue;
                counts->objects++;
                if (!s->objects[object])
                    fail_msg("%s, frame %u: object %u in cell %u is missed", what, counts->frames, object, c);
            }
        }
    }
}

static void walks_through(EnfScene *scene, const char *what, uint32_t walks, double size, Counts *counts) {
    SightWalker *walker = sight_walker_create(scene);
    EnfView *view;
    SightRng rng = {77};
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    for (uint32_t k = 0; k < walks; k++) {
        EnfViewDef def = enf_default_view_def();
        EnfCamera camera;
        Walker at;
        memset(&at, 0, sizeof at);
        while (!sight_point_in_cell(walker, &rng, (uint32_t)(sight_next(&rng) % scene->cell_count), 0, at.eye))
            ;
        def.reuse_distance = size * 2 * sight_unit(&rng);
        def.reuse_angle = sight_unit(&rng);
        for (uint32_t f = 0; f < 150; f++, counts->frames++) {
            double before[3] = {at.eye[0], at.eye[1], at.eye[2]};
            camera = next_frame(&at, &rng);
            for (int c = 0; c < 3; c++) { /* in the scene's own measure */
                at.eye[c] = before[c] + size * (at.eye[c] - before[c]);
                camera.world_from_camera[4 * c + 3] = at.eye[c];
            }
            camera.clip_near = k % 3 == 0 ? 0.01 * size : 0;
            Sets s = query(scene, view, &camera, &def);
            counts->reused += stats_of(view).reused;
            frame_sees(scene, walker, &rng, &camera, &s, what, counts);
            free_sets(&s);
        }
    }
    enf_view_destroy(view);
    sight_walker_destroy(walker);
    enf_scene_destroy(scene);
}

static const char *const specs[] = {"office:46",   "office:300,windows=0",
                                    "grid:20",     "columns:20",
                                    "ring:40",     "hub:60",
                                    "enfilade:20", "tower:12,windows=1",
                                    "court:5",     "town:6",
                                    "facade:5",    "brick:12",
                                    "slits:10",    "spiral:10",
                                    "comb:20",     "screens:5,detail=6",
                                    "rings:5",     "lace:4",
                                    "star:9",      "cuts:60"};

static void report(const Counts *counts) {
    print_message("%u frames, %u given again, %u cells and %u objects proven\n", counts->frames, counts->reused, counts->cells,
                  counts->objects);
}

static void every_frame_of_a_walk_sees_what_its_rays_meet(void **state) {
    (void)state;
    Counts counts = {0, 0, 0, 0};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; i++)
        walks_through(family(specs[i]), specs[i], walk_count(), 1, &counts);
    report(&counts);
    assert_true(counts.reused > counts.frames / 3);
    assert_true(counts.cells > 200000 && counts.objects > 20000);
}

/* Turned, scaled, and ten thousand kilometres off, where an eye's own coordinates are a nanometre apart. */
static void so_it_does_wherever_the_scene_is(void **state) {
    (void)state;
    Counts counts = {0, 0, 0, 0};
    SightRng rng = {5};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; i++) {
        EnfScene *scene = family(specs[i]), *moved;
        Motion motion = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, i % 3 == 1 ? (i % 2 ? 1e-3 : 1e3) : 1, {0, 0, 0}};
        if (i % 3 != 1)
            random_level_turn(&rng, motion.rotation);
        for (int c = 0; c < 3 && i % 3 == 2; c++)
            motion.offset[c] = 1e7 * (2 * sight_unit(&rng) - 1);
        moved = moved_scene(scene, &motion);
        assert_non_null(moved);
        assert_int_equal(enf_scene_commit(moved), ENF_OK);
        enf_scene_destroy(scene);
        walks_through(moved, specs[i], walk_count() / 4 + 1, motion.scale, &counts);
    }
    report(&counts);
    assert_true(counts.reused > counts.frames / 4);
}

static void so_it_does_in_portal_files(void **state) {
    (void)state;
    static const char *const files[] = {"e1m1", "dm3", "e2m5"};
    Counts counts = {0, 0, 0, 0};
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        walks_through(portal_file(files[f]), files[f], walk_count(), 30, &counts); /* a unit is an inch */
    }
    report(&counts);
    assert_true(counts.reused > counts.frames / 5);
}

/* One walk, both twins: the same answers. */
static void both_twins_plan_alike(void **state) {
    (void)state;
    EnfScene *scene = family("columns:20");
    SightWalker *walker = sight_walker_create(scene);
    EnfView *views[2];
    SightRng rng = {3};
    Walker at;
    uint32_t reused = 0;
    memset(&at, 0, sizeof at);
    assert_true(sight_point_in_cell(walker, &rng, scene->cell_count / 2, 0, at.eye));
    for (int v = 0; v < 2; v++)
        assert_int_equal(enf_view_create(scene, &views[v]), ENF_OK);
    for (uint32_t f = 0; f < 400; f++) {
        const EnfCamera camera = next_frame(&at, &rng);
        Sets s[2];
        for (uint32_t v = 0; v < 2; v++) {
            EnfViewDef def = enf_default_view_def();
            def.reuse_distance = def.reuse_angle = 1;
            def.use_simd = v;
            s[v] = query(scene, views[v], &camera, &def);
        }
        assert_int_equal(stats_of(views[0]).work, stats_of(views[1]).work);
        assert_subset(scene, &s[0], &s[1], "scalar");
        assert_subset(scene, &s[1], &s[0], "simd");
        reused += stats_of(views[0]).reused;
        for (int v = 0; v < 2; v++)
            free_sets(&s[v]);
    }
    assert_true(reused > 100);
    for (int v = 0; v < 2; v++)
        enf_view_destroy(views[v]);
    sight_walker_destroy(walker);
    enf_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_frame_of_a_walk_sees_what_its_rays_meet),
        cmocka_unit_test(so_it_does_wherever_the_scene_is),
        cmocka_unit_test(so_it_does_in_portal_files),
        cmocka_unit_test(both_twins_plan_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
