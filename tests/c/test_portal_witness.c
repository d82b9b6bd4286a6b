/* SPDX-License-Identifier: GPL-3.0-or-later
 * Nothing visible is hidden: lines walked through portals by independent code prove cells and objects visible; each must be
 * in the answers of `frustum`, `box` and `clip`, the last with the outdoors exact and swept.
 * ENF_WITNESS_CAMERAS sets the number of cameras a scene (default 150). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "moved_scene.h"
#include "portal_file.h"
#include "scene/scene_data.h"
#include "scene_family.h"
#include "sight_walker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Witnesses narrower than this (radians; a half screen is about one) prove nothing to doubles. */
#define LEAST_CLEARANCE 2e-10

typedef struct Tally {
    uint64_t cameras, rays, cells_proven, objects_proven, missed;
} Tally;

/* The direction through (x, y) of the screen in [-1, 1]: the camera's definition, spelled out anew. */
static void screen_direction(const EnfCamera *camera, double x, double y, double out[3]) {
    const double *m = camera->world_from_camera;
    double u = (x + 2 * camera->shift_x) * tan(camera->angle_x / 2), v = (y + 2 * camera->shift_y) * tan(camera->angle_y / 2);
    for (int r = 0; r < 3; r++)
        out[r] = u * m[4 * r] + v * m[4 * r + 1] - m[4 * r + 2];
}

static int on_screen(const EnfCamera *camera, const double d[3]) {
    const double *m = camera->world_from_camera;
    double c[3];
    for (int k = 0; k < 3; k++)
        c[k] = m[k] * d[0] + m[4 + k] * d[1] + m[8 + k] * d[2];
    if (!(c[2] < 0))
        return 0;
    double x = c[0] / -c[2] / tan(camera->angle_x / 2) - 2 * camera->shift_x;
    double y = c[1] / -c[2] / tan(camera->angle_y / 2) - 2 * camera->shift_y;
    return fabs(x) < 1 - 1e-9 && fabs(y) < 1 - 1e-9;
}

static EnfCamera random_camera(SightRng *rng, const double eye[3]) {
    EnfCamera camera = enf_default_camera();
    double r[3][3];
    random_turn(rng, r);
    if (sight_next(rng) % 3 == 0) { /* looking along an axis: portals edge-on */
        int k = (int)(sight_next(rng) % 3), s = (sight_next(rng) & 1) ? 1 : -1;
        memset(r, 0, sizeof r);
        r[k][2] = s;
        r[(k + 1) % 3][0] = s;
        r[(k + 2) % 3][1] = 1;
    }
    for (int i = 0; i < 3; i++) {
        for (int c = 0; c < 3; c++)
            camera.world_from_camera[4 * i + c] = r[i][c];
        camera.world_from_camera[4 * i + 3] = eye[i];
    }
    camera.angle_x = 0.2 + 2.2 * sight_unit(rng);
    camera.angle_y = 0.2 + 1.6 * sight_unit(rng);
    camera.shift_x = sight_next(rng) % 4 ? 0 : sight_unit(rng) - 0.5;
    camera.shift_y = sight_next(rng) % 4 ? 0 : sight_unit(rng) - 0.5;
    camera.clip_near = 0;
    camera.clip_far = INFINITY;
    return camera;
}

/* An eye for which an edge of a portal of its cell and an edge of a portal behind it are in line but for `*hair` (a share of
 * their distance): what lies behind is seen through a gap as thin as that, or not at all. 0 when no such eye was found. */
static int hair_eye(const EnfScene *scene, SightRng *rng, uint32_t *start, double eye[3], double target[3], double *hair) {
    for (int tries = 0; tries < 20; tries++) {
        uint32_t c = (uint32_t)(sight_next(rng) % scene->cell_count), first = scene->cell_portal_first[c];
        uint32_t n = scene->cell_portal_first[c + 1] - first;
        if (n == 0)
            continue;
        const EnfCellPortal *one = &scene->cell_portals[first + sight_next(rng) % n];
        uint32_t behind = scene->cell_portal_first[one->to], m = scene->cell_portal_first[one->to + 1] - behind;
        const EnfCellPortal *two = &scene->cell_portals[behind + sight_next(rng) % m];
        if (two->portal == one->portal)
            continue;
        double ends[2][3];
        for (int e = 0; e < 2; e++) {
            uint32_t p = e ? two->portal : one->portal, count = scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p];
            const double(*v)[3] = (const double(*)[3])(scene->portal_vertices + scene->portal_vertex_first[p]);
            uint32_t i = (uint32_t)(sight_next(rng) % count), j = (i + 1) % count;
            double s = sight_unit(rng);
            for (int k = 0; k < 3; k++)
                ends[e][k] = v[i][k] + s * (v[j][k] - v[i][k]);
        }
        *hair = pow(10, -2 - 7.5 * sight_unit(rng));
        double back = 0.05 + sight_unit(rng), apart = 0;
        for (int k = 0; k < 3; k++)
            apart += fabs(ends[0][k] - ends[1][k]);
        for (int k = 0; k < 3; k++)
            eye[k] = ends[0][k] + back * (ends[0][k] - ends[1][k]) + *hair * apart * (2 * sight_unit(rng) - 1);
        uint32_t found[8], located;
        if (enf_scene_locate(scene, eye, found, 8, &located) != ENF_OK || located != 1 || found[0] != c)
            continue;
        *start = c;
        memcpy(target, ends[1], sizeof ends[1]);
        return 1;
    }
    return 0;
}

/* Ways to ask. */
enum { WAYS = 4 };
static const struct {
    const char *name;
    uint32_t method, outdoors;
} ways[WAYS] = {{"frustum", ENF_VIEW_FRUSTUM, ENF_OUTDOORS_AUTO},
                {"box", ENF_VIEW_BOX, ENF_OUTDOORS_AUTO},
                {"clip", ENF_VIEW_CLIP, ENF_OUTDOORS_EXACT},
                {"sweep", ENF_VIEW_CLIP, ENF_OUTDOORS_SWEEP}};

/* What was seen, per query: stamps. */
typedef struct Seen {
    uint32_t *cells, *objects, stamp;
} Seen;

static void mark_answer(const EnfView *view, Seen *seen) {
    EnfViewResult result = enf_default_view_result();
    assert_int_equal(enf_view_result(view, &result), ENF_OK);
    seen->stamp++;
    for (uint32_t i = 0; i < result.cell_count; i++)
        seen->cells[result.cells[i]] = seen->stamp;
    for (uint32_t i = 0; i < result.object_count; i++)
        seen->objects[result.objects[i]] = seen->stamp;
}

static void check_scene(const EnfScene *scene, const char *name, uint64_t cameras, uint64_t seed, Tally *tally) {
    static SightWalk walk;
    SightRng rng = {seed};
    SightWalker *walker = sight_walker_create(scene);
    EnfView *view;
    assert_non_null(walker);
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);
    Seen seen[WAYS];
    for (int m = 0; m < WAYS; m++) {
        seen[m].cells = calloc(scene->cell_count + 1, sizeof(uint32_t));
        seen[m].objects = calloc(scene->object_count + 1, sizeof(uint32_t));
        seen[m].stamp = 0;
    }
    for (uint64_t k = 0; k < cameras; k++) {
        uint32_t start = (uint32_t)(sight_next(&rng) % scene->cell_count);
        double eye[3], target[3], hair = 0;
        int degenerate = sight_next(&rng) % 10 == 0, thin = sight_next(&rng) % 2 == 0;
        if (scene->cell_rooms[start] != ENF_NONE && scene->rooms[scene->cell_rooms[start]].kind == ENF_ROOM_EXTERIOR &&
            scene->cell_vertex_first[start] == scene->cell_vertex_first[start + 1])
            continue; /* a mixture of its portals' corners is indoors */
        if (!thin && !sight_point_in_cell(walker, &rng, start, degenerate, eye))
            continue;
        if (thin && !hair_eye(scene, &rng, &start, eye, target, &hair))
            continue;
        /* Cells outdoors may reach into recesses: an eye that the recess holds isn't in them. */
        uint32_t held[32], holders = 0, own = 0;
        assert_int_equal(enf_scene_locate(scene, eye, held, 32, &holders), ENF_OK);
        for (uint32_t i = 0; i < holders && i < 32; i++)
            own |= held[i] == start;
        if (!own && scene->cell_rooms[start] != ENF_NONE && scene->rooms[scene->cell_rooms[start]].kind == ENF_ROOM_EXTERIOR)
            continue;
        EnfCamera camera = random_camera(&rng, eye);
        double apart = 0;
        for (int c = 0; thin && c < 3; c++)
            apart += fabs(target[c] - eye[c]);
        if (thin) { /* looking at it, somewhat aside */
            double back[3], right[3], up[3], size;
            for (int c = 0; c < 3; c++)
                back[c] = eye[c] - target[c] + 0.1 * apart * (2 * sight_unit(&rng) - 1);
            size = sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
            for (int c = 0; c < 3; c++)
                back[c] /= size;
            int across = fabs(back[0]) < 0.6 ? 0 : 1;
            double axis[3] = {across == 0, across == 1, 0};
            for (int c = 0; c < 3; c++)
                right[c] = axis[(c + 1) % 3] * back[(c + 2) % 3] - axis[(c + 2) % 3] * back[(c + 1) % 3];
            size = sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
            for (int c = 0; c < 3; c++)
                right[c] /= size;
            for (int c = 0; c < 3; c++)
                up[c] = back[(c + 1) % 3] * right[(c + 2) % 3] - back[(c + 2) % 3] * right[(c + 1) % 3];
            for (int c = 0; c < 3; c++) {
                camera.world_from_camera[4 * c] = right[c];
                camera.world_from_camera[4 * c + 1] = up[c];
                camera.world_from_camera[4 * c + 2] = back[c];
            }
        }
        for (uint32_t m = 0; m < WAYS; m++) {
            EnfViewDef def = enf_default_view_def();
            def.method = ways[m].method;
            def.outdoors = ways[m].outdoors;
            if (enf_view_query(view, &camera, &def) != ENF_OK)
                fail_msg("%s: %s", name, enf_last_error());
            mark_answer(view, &seen[m]);
        }
        tally->cameras++;
        const uint32_t *portal_first = enf_scene_portal_vertex_first(scene);
        uint32_t aimed = ENF_NONE;
        for (int ray = 0; ray < 24; ray++) {
            double d[3];
            screen_direction(&camera, 1.9998 * sight_unit(&rng) - 0.9999, 1.9998 * sight_unit(&rng) - 0.9999, d);
            if (aimed != ENF_NONE && ray % 2) {
                /* At an edge of a portal that an earlier line passed, from a hair to a hand inside. */
                uint32_t n = portal_first[aimed + 1] - portal_first[aimed];
                const double(*v)[3] = (const double(*)[3])(scene->portal_vertices + portal_first[aimed]);
                uint32_t a = (uint32_t)(sight_next(&rng) % n), b = (a + 1) % n, c = (a + 2) % n;
                double s = sight_unit(&rng), h = pow(10, -10 * sight_unit(&rng));
                for (int i = 0; i < 3; i++)
                    d[i] = (1 - h) * ((1 - s) * v[a][i] + s * v[b][i]) + h * v[c][i] - eye[i];
                if (!on_screen(&camera, d))
                    continue;
            }
            if (thin && ray % 4) { /* into the gap, if there is one */
                double spread = hair * apart * pow(10, 1 - 2 * sight_unit(&rng));
                for (int i = 0; i < 3; i++)
                    d[i] = target[i] - eye[i] + spread * (2 * sight_unit(&rng) - 1);
                if (!on_screen(&camera, d))
                    continue;
            }
            sight_walk(walker, start, eye, d, INFINITY, &walk);
            tally->rays++;
            if (walk.cell_count > 1)
                aimed = walk.portals[sight_next(&rng) % (walk.cell_count - 1)];
            for (uint32_t i = 0; i < walk.cell_count && walk.clearance_at[i] > LEAST_CLEARANCE; i++) {
                uint32_t c = walk.cells[i];
                double t1 = i + 1 < walk.cell_count ? walk.t_enter[i + 1] : INFINITY;
                tally->cells_proven++;
                for (uint32_t m = 0; m < WAYS; m++)
                    if (seen[m].cells[c] != seen[m].stamp && tally->missed++ < 5)
                        printf("%s, camera %llu: %s hides cell %u (start %u, %u portals, clearance %.3g, degenerate %d, eye %.17g "
                               "%.17g %.17g, fov %g %g)\n",
                               name, (unsigned long long)k, ways[m].name, c, start, i, walk.clearance_at[i], degenerate, eye[0], eye[1],
                               eye[2], camera.angle_x, camera.angle_y);
                for (uint32_t o = scene->cell_object_first[c]; o < scene->cell_object_first[c + 1]; o++) {
                    uint32_t object = scene->cell_object_list[o];
                    if (!sight_meets_box(eye, d, walk.t_enter[i], t1, scene->objects[object].bounds))
                        continue;
                    tally->objects_proven++;
                    for (uint32_t m = 0; m < WAYS; m++)
                        if (seen[m].objects[object] != seen[m].stamp && tally->missed++ < 5)
                            printf("%s, camera %llu: %s hides object %u in cell %u (clearance %.3g)\n", name, (unsigned long long)k,
                                   ways[m].name, object, c, walk.clearance_at[i]);
                }
            }
        }
    }
    for (int m = 0; m < WAYS; m++) {
        free(seen[m].cells);
        free(seen[m].objects);
    }
    enf_view_destroy(view);
    sight_walker_destroy(walker);
}

static uint64_t camera_count(void) {
    const char *text = getenv("ENF_WITNESS_CAMERAS");
    return text ? strtoull(text, NULL, 10) : 150;
}

static void report(const Tally *t) {
    printf("%llu cameras, %llu lines, %llu cells and %llu objects proven visible: %llu missed\n", (unsigned long long)t->cameras,
           (unsigned long long)t->rays, (unsigned long long)t->cells_proven, (unsigned long long)t->objects_proven,
           (unsigned long long)t->missed);
    assert_true(t->cells_proven > t->cameras);
    assert_int_equal(t->missed, 0);
}

static const char *const families[] = {
    "office:46",        "office:46,outdoors=0", "office:200,closed=0.3", "court:5", "town:6", "tower:4,windows=1",
    "grid:9,objects=2", "grid:5,storeys=4",     "columns:7,objects=1",   "ring:24", "hub:60", "enfilade:20",
    "tower:6"};

static void nothing_visible_is_hidden(void **state) {
    (void)state;
    Tally tally = {0};
    for (size_t f = 0; f < sizeof families / sizeof *families; f++) {
        EnfScene *scene;
        assert_int_equal(enf_family_build(families[f], &scene), ENF_OK);
        if (enf_scene_commit(scene) != ENF_OK)
            fail_msg("%s: %s", families[f], enf_last_error());
        check_scene(scene, families[f], camera_count(), 1 + f, &tally);
        enf_scene_destroy(scene);
    }
    report(&tally);
}

static void nothing_visible_is_hidden_when_moved_turned_or_scaled(void **state) {
    (void)state;
    Tally tally = {0};
    SightRng rng = {99};
    for (size_t f = 0; f < sizeof families / sizeof *families; f++)
        for (int k = 0; k < 4; k++) {
            EnfScene *scene, *moved;
            Motion motion = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1, {0, 0, 0}};
            if (k == 0 || k == 3)
                random_turn(&rng, motion.rotation);
            if (k == 1)
                motion.scale = f % 2 ? 1e-3 : 1e3;
            if (k >= 2)
                for (int c = 0; c < 3; c++)
                    motion.offset[c] = 1e7 * (2 * sight_unit(&rng) - 1);
            assert_int_equal(enf_family_build(families[f], &scene), ENF_OK);
            assert_int_equal(enf_scene_commit(scene), ENF_OK);
            moved = moved_scene(scene, &motion);
            assert_non_null(moved);
            if (enf_scene_commit(moved) != ENF_OK)
                fail_msg("%s", enf_last_error());
            check_scene(moved, families[f], camera_count() / 8 + 1, 1000 + 10 * f + (uint64_t)k, &tally);
            enf_scene_destroy(moved);
            enf_scene_destroy(scene);
        }
    report(&tally);
}

static void nothing_visible_is_hidden_in_portal_files(void **state) {
    (void)state;
    static const char *const files[] = {"e1m1", "dm3", "e1m7"};
    Tally tally = {0};
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        EnfScene *scene = portal_file(files[f]);
        check_scene(scene, files[f], camera_count(), 7000 + f, &tally);
        enf_scene_destroy(scene);
    }
    report(&tally);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_visible_is_hidden),
        cmocka_unit_test(nothing_visible_is_hidden_when_moved_turned_or_scaled),
        cmocka_unit_test(nothing_visible_is_hidden_in_portal_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
