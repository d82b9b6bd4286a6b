/* SPDX-License-Identifier: GPL-3.0-or-later
 * Walks: what an answer made for the way ahead lacks of what each frame sees, by rays walked one by one. */
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
    uint32_t frames, reused, proven;
} Counts;

static void frame_sees(const EnfScene *scene, const SightWalker *walker, SightRng *rng, const EnfCamera *camera, const Sets *s,
                       const char *what, Counts *counts) {
    const double *m = camera->world_from_camera;
    double eye[3];
    uint32_t cell, located = 0;
    eye_of(camera, eye);
    if (enf_scene_locate(scene, eye, &cell, 1, &located) != ENF_OK || located != 1)
        return; /* in a wall */
    for (int i = 0; i < 12; i++) {
        static SightWalk ray;
        double d[3], x = (2 * sight_unit(rng) - 1) * tan(0.5 * camera->angle_x), y = (2 * sight_unit(rng) - 1) * tan(0.5 * camera->angle_y);
        for (int c = 0; c < 3; c++)
            d[c] = x * m[4 * c] + y * m[4 * c + 1] - m[4 * c + 2];
        sight_walk(walker, cell, eye, d, INFINITY, &ray);
        for (uint32_t w = 0; w < ray.cell_count && ray.clearance_at[w] > 2e-10; w++, counts->proven++)
            if (!s->cells[ray.cells[w]])
                fail_msg("%s, frame %u: cell %u is missed", what, counts->frames, ray.cells[w]);
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

static void every_frame_of_a_walk_sees_what_its_rays_meet(void **state) {
    (void)state;
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
    Counts counts = {0, 0, 0};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; i++)
        walks_through(family(specs[i]), specs[i], walk_count(), 1, &counts);
    print_message("%u frames, %u given again, %u cells proven\n", counts.frames, counts.reused, counts.proven);
    assert_true(counts.reused > counts.frames / 3);
    assert_true(counts.proven > 200000);
}

static void so_it_does_in_portal_files(void **state) {
    (void)state;
    static const char *const files[] = {"e1m1", "dm3", "e2m5"};
    Counts counts = {0, 0, 0};
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        walks_through(portal_file(files[f]), files[f], walk_count(), 30, &counts); /* a unit is an inch */
    }
    print_message("%u frames, %u given again, %u cells proven\n", counts.frames, counts.reused, counts.proven);
    assert_true(counts.reused > counts.frames / 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_frame_of_a_walk_sees_what_its_rays_meet),
        cmocka_unit_test(so_it_does_in_portal_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
