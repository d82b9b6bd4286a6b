/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cutting the outdoors into cells hides nothing: straight lines through open air, from windows, facades and gardens to
 * windows and trees, prove what must be in the answer. The judge knows rooms and windows alone: a line is clear when it
 * stays away from every room (grown by half a wall, because gaps of a wall's thickness are walls; where it has windows, as far as
 * these reach out). It shares no code with the decomposition or the engine. ENF_WITNESS_CAMERAS sets the number of cameras a scene (default 150). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "moved_scene.h"
#include "scene/scene_data.h"
#include "scene_family.h"
#include "sight_walker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Tally {
    uint64_t cameras, clear, from_inside, across, degenerate, trees, furniture, swept, missed;
} Tally;

/* What the judge knows of a scene. */
typedef struct Judge {
    const EnfScene *scene;
    double wall;                     /* metres that count as wall between rooms */
    uint32_t *rooms, room_count;     /* cells of rooms, not outdoors, not in openings */
    uint32_t *windows, window_count; /* portals between an opening's cell and the outdoors */
    uint32_t *trees, tree_count;     /* objects outdoors */
    double *walls;                   /* [faces] metres of wall before it */
} Judge;

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int is_outdoors(const EnfScene *s, uint32_t c) {
    return s->cell_rooms[c] != ENF_NONE && s->rooms[s->cell_rooms[c]].kind == ENF_ROOM_EXTERIOR;
}

/* The wall before the face of a room that the window's recess begins at: the window lies in its outer side. */
static void measure_wall(Judge *j, uint32_t window) {
    const EnfScene *s = j->scene;
    int inner = is_outdoors(s, s->portal_cells[window][0]);
    uint32_t recess = s->portal_cells[window][inner];
    double out[3], middle[3];
    for (int k = 0; k < 3; k++) {
        out[k] = s->portal_planes[window].n[k] * (inner ? -1 : 1);
        middle[k] = s->portal_centres[window][k] - s->origin[k];
    }
    for (uint32_t i = s->cell_portal_first[recess]; i < s->cell_portal_first[recess + 1]; i++) {
        uint32_t room = s->cell_portals[i].to;
        for (uint32_t f = s->cell_face_first[room]; f < s->cell_face_first[room + 1] && !is_outdoors(s, room); f++)
            if (dot(s->face_planes[f].n, out) > 0.999)
                j->walls[f] = fmax(j->walls[f], 0.999 * (dot(s->face_planes[f].n, middle) - s->face_planes[f].d));
    }
}

static Judge judge_of(const EnfScene *s, double wall) {
    Judge j = {s, wall, calloc(s->cell_count + 1, 4), 0, calloc(s->portal_count + 1, 4), 0, calloc(s->object_count + 1, 4), 0, NULL};
    uint32_t faces = s->cell_face_first[s->cell_count];
    j.walls = calloc(faces + 1, sizeof *j.walls);
    for (uint32_t f = 0; f < faces; f++)
        j.walls[f] = 0.505 * wall;
    for (uint32_t c = 0; c < s->cell_count; c++)
        if (s->cell_openings[c] == ENF_NONE && !is_outdoors(s, c))
            j.rooms[j.room_count++] = c;
    for (uint32_t p = 0; p < s->portal_count; p++)
        if (is_outdoors(s, s->portal_cells[p][0]) != is_outdoors(s, s->portal_cells[p][1]))
            j.windows[j.window_count++] = p;
    for (uint32_t i = 0; i < j.window_count; i++)
        measure_wall(&j, j.windows[i]);
    for (uint32_t o = 0; o < s->object_count; o++) {
        int outdoors = s->objects[o].cell_count == 0; /* or said to be: trees that stand in a house are its own */
        for (uint32_t i = 0; i < s->objects[o].cell_count; i++)
            outdoors |= is_outdoors(s, s->object_cells[s->objects[o].cell_first + i]);
        if (s->objects[o].mesh == 100 && outdoors) /* the garden's */
            j.trees[j.tree_count++] = o;
    }
    return j;
}

static void free_judge(Judge *j) {
    free(j->rooms);
    free(j->windows);
    free(j->trees);
    free(j->walls);
}

/* Whether the segment from a to b meets the room's cell or its walls: clipped by its faces' planes, computed anew. */
static int meets_room(const Judge *j, uint32_t c, const double a[3], const double b[3]) {
    const EnfScene *s = j->scene;
    double t0 = 0, t1 = 1;
    const double(*v)[3] = (const double(*)[3])(s->cell_vertices + s->cell_vertex_first[c]);
    for (uint32_t f = s->cell_face_first[c]; f < s->cell_face_first[c + 1] && t0 < t1; f++) {
        const uint32_t *loop = s->face_indices + s->face_index_first[f];
        uint32_t n = s->face_index_first[f + 1] - s->face_index_first[f];
        double normal[3] = {0, 0, 0};
        for (uint32_t i = 1; i + 1 < n; i++)
            for (int k = 0; k < 3; k++) {
                int x = (k + 1) % 3, y = (k + 2) % 3;
                const double *o = v[loop[0]], *p = v[loop[i]], *q = v[loop[i + 1]];
                normal[k] += (p[x] - o[x]) * (q[y] - o[y]) - (p[y] - o[y]) * (q[x] - o[x]);
            }
        double size = sqrt(dot(normal, normal)), da = 0, db = 0;
        for (int k = 0; k < 3; k++) {
            da += normal[k] / size * (a[k] - v[loop[0]][k]);
            db += normal[k] / size * (b[k] - v[loop[0]][k]);
        }
        da -= j->walls[f];
        db -= j->walls[f];
        if (da > 0 && db > 0)
            return 0;
        if (da > 0)
            t0 = fmax(t0, da / (da - db));
        else if (db > 0)
            t1 = fmin(t1, da / (da - db));
    }
    return t0 < t1;
}

static int is_clear(const Judge *j, const double a[3], const double b[3]) {
    for (uint32_t i = 0; i < j->room_count; i++) {
        uint32_t c = j->rooms[i];
        /* In the box first: there are thousands of rooms. Corners of walls reach out by a diagonal. */
        const double *box = j->scene->cell_bounds[c], corner = 1.5 * j->wall;
        int apart = 0;
        for (int k = 0; k < 3 && !apart; k++)
            apart = fmax(a[k], b[k]) < box[k] - corner || fmin(a[k], b[k]) > box[3 + k] + corner;
        if (!apart && meets_room(j, c, a, b))
            return 0;
    }
    return 1;
}

/* A point in portal p: inside, near an edge (a tenth), or anywhere between. */
static void point_in_portal(const EnfScene *s, SightRng *rng, uint32_t p, double out[3]) {
    uint32_t n = s->portal_vertex_first[p + 1] - s->portal_vertex_first[p];
    const double(*v)[3] = (const double(*)[3])(s->portal_vertices + s->portal_vertex_first[p]);
    double weight[64], sum = 0;
    int near = sight_next(rng) % 10 == 0;
    for (uint32_t i = 0; i < n && i < 64; i++)
        sum += weight[i] = (near && i > 1 ? 1e-5 : 1) * -log(1 - sight_unit(rng));
    for (int k = 0; k < 3; k++) {
        out[k] = v[0][k];
        for (uint32_t i = 0; i < n && i < 64; i++)
            out[k] += weight[i] / sum * (v[i][k] - v[0][k]);
    }
}

static EnfCamera camera_towards(SightRng *rng, const double eye[3], const double target[3]) {
    EnfCamera camera = enf_default_camera();
    double back[3], right[3], size;
    for (int k = 0; k < 3; k++)
        back[k] = eye[k] - target[k];
    size = sqrt(dot(back, back));
    for (int k = 0; k < 3; k++) /* looking somewhat aside */
        back[k] = back[k] / size + 0.3 * (2 * sight_unit(rng) - 1);
    size = sqrt(dot(back, back));
    for (int k = 0; k < 3; k++)
        back[k] /= size;
    int across = fabs(back[0]) < 0.6 ? 0 : 1;
    double axis[3] = {across == 0, across == 1, 0};
    for (int k = 0; k < 3; k++)
        right[k] = axis[(k + 1) % 3] * back[(k + 2) % 3] - axis[(k + 2) % 3] * back[(k + 1) % 3];
    size = sqrt(dot(right, right));
    for (int k = 0; k < 3; k++)
        right[k] /= size;
    for (int k = 0; k < 3; k++) {
        camera.world_from_camera[4 * k] = right[k];
        camera.world_from_camera[4 * k + 1] = back[(k + 1) % 3] * right[(k + 2) % 3] - back[(k + 2) % 3] * right[(k + 1) % 3];
        camera.world_from_camera[4 * k + 2] = back[k];
        camera.world_from_camera[4 * k + 3] = eye[k];
    }
    camera.angle_x = 1.4 + sight_unit(rng);
    camera.angle_y = 1.2 + 0.8 * sight_unit(rng);
    camera.clip_near = 0;
    camera.clip_far = INFINITY;
    return camera;
}

/* Ways to ask: through portals exactly, as rectangles, by the sweep, and whichever pays. */
enum { WAYS = 4 };
static const struct {
    const char *name;
    uint32_t method, outdoors;
} ways[WAYS] = {{"clip", ENF_VIEW_CLIP, ENF_OUTDOORS_EXACT},
                {"box", ENF_VIEW_BOX, ENF_OUTDOORS_AUTO},
                {"sweep", ENF_VIEW_CLIP, ENF_OUTDOORS_SWEEP},
                {"auto", ENF_VIEW_CLIP, ENF_OUTDOORS_AUTO}};

typedef struct Asked {
    EnfView *view;
    const char *name;
    Tally *tally;
    double eye[3];
    uint8_t *cells[WAYS], *objects[WAYS]; /* what each keeps for the present camera */
} Asked;

static void must_see(Asked *asked, const EnfScene *scene, uint32_t cell, uint32_t object, const char *why) {
    for (int m = 0; m < WAYS; m++) {
        int seen = cell != ENF_NONE ? asked->cells[m][cell] : asked->objects[m][object];
        if (!seen && asked->tally->missed++ < 8) {
            uint32_t found[8], located = 0;
            enf_scene_locate(scene, asked->eye, found, 8, &located);
            printf("%s: %s hides %s %u (%s); eye %.17g %.17g %.17g in %u cells, first %u\n", asked->name, ways[m].name,
                   cell != ENF_NONE ? "cell" : "object", cell != ENF_NONE ? cell : object, why, asked->eye[0], asked->eye[1], asked->eye[2],
                   located, located ? found[0] : 0);
        }
    }
}

static void ask(Asked *asked, const EnfScene *scene, const EnfCamera *camera) {
    for (int m = 0; m < WAYS; m++) {
        EnfViewDef def = enf_default_view_def();
        EnfViewResult result = enf_default_view_result();
        EnfViewStats stats = enf_default_view_stats();
        def.method = ways[m].method;
        def.outdoors = ways[m].outdoors;
        if (enf_view_query(asked->view, camera, &def) != ENF_OK)
            fail_msg("%s: %s", asked->name, enf_last_error());
        assert_int_equal(enf_view_result(asked->view, &result), ENF_OK);
        assert_int_equal(enf_view_stats(asked->view, &stats), ENF_OK);
        asked->tally->swept += stats.swept;
        memset(asked->cells[m], 0, scene->cell_count);
        memset(asked->objects[m], 0, scene->object_count);
        for (uint32_t i = 0; i < result.cell_count; i++)
            asked->cells[m][result.cells[i]] = 1;
        for (uint32_t i = 0; i < result.object_count; i++)
            asked->objects[m][result.objects[i]] = 1;
    }
    asked->tally->cameras++;
}

/* Whether the line from `from` along d meets the box between t0 and t1, by more than a grazing touch. */
static int meets_box(const double bounds[6], const double from[3], const double d[3], double t0, double t1) {
    for (int k = 0; k < 3; k++) {
        double inside = 1e-6 * (bounds[3 + k] - bounds[k]), a = bounds[k] + inside - from[k], b = bounds[3 + k] - inside - from[k];
        if (fabs(d[k]) < 1e-12) {
            if (a > 0 || b < 0)
                return 0;
            continue;
        }
        t0 = fmax(t0, fmin(a / d[k], b / d[k]));
        t1 = fmin(t1, fmax(a / d[k], b / d[k]));
    }
    return t0 < t1;
}

/* Furniture that the walked line meets in the cells it passes. */
static void must_see_furniture(Asked *asked, const EnfScene *s, const SightWalk *walk, const double from[3], const double d[3]) {
    for (uint32_t i = 0; i + 1 < walk->cell_count && walk->clearance_at[i] > 1e-7; i++)
        for (uint32_t k = s->cell_object_first[walk->cells[i]]; k < s->cell_object_first[walk->cells[i] + 1]; k++) {
            uint32_t object = s->cell_object_list[k];
            if (meets_box(s->objects[object].bounds, from, d, walk->t_enter[i], walk->t_enter[i + 1])) {
                asked->tally->furniture++;
                must_see(asked, s, ENF_NONE, object, "in a room behind a window");
            }
        }
}

/* Whether a line that arrives at `at` along d enters the window: it comes from outdoors. */
static int enters(const EnfScene *s, uint32_t p, const double d[3]) {
    double into = is_outdoors(s, s->portal_cells[p][0]) ? 1 : -1; /* the plane's normal points into cells[1] */
    return into * dot(s->portal_planes[p].n, d) > 1e-6 * sqrt(dot(d, d));
}

static int in_view(const EnfCamera *camera, const double point[3]) {
    const double *m = camera->world_from_camera;
    double c[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        for (int r = 0; r < 3; r++)
            c[k] += m[4 * r + k] * (point[r] - m[4 * r + 3]);
    return c[2] < 0 && fabs(c[0] / -c[2]) < 0.9999 * tan(camera->angle_x / 2) && fabs(c[1] / -c[2]) < 0.9999 * tan(camera->angle_y / 2);
}

static void point_outdoors(const EnfScene *s, SightRng *rng, double out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = s->bounds[k] + (s->bounds[3 + k] - s->bounds[k]) * (1.4 * sight_unit(rng) - 0.2);
}

static void check_scene(const EnfScene *scene, const char *name, double wall, uint64_t cameras, uint64_t seed, Tally *tally) {
    static SightWalk walk;
    SightRng rng = {seed};
    Judge judge = judge_of(scene, wall);
    SightWalker *walker = sight_walker_create(scene);
    Asked asked = {.name = name, .tally = tally};
    assert_non_null(walker);
    assert_true(judge.window_count > 0);
    assert_int_equal(enf_view_create(scene, &asked.view), ENF_OK);
    for (int m = 0; m < WAYS; m++) {
        asked.cells[m] = calloc(scene->cell_count + 1, 1);
        asked.objects[m] = calloc(scene->object_count + 1, 1);
    }
    for (uint64_t k = 0, tries = 0; k < cameras && tries < 200 * cameras; tries++) {
        /* From: a garden, a facade or corner of one, or a window that the line leaves a room by. */
        uint32_t from = judge.windows[sight_next(&rng) % judge.window_count], to = judge.windows[sight_next(&rng) % judge.window_count];
        int kind = (int)(sight_next(&rng) % 5);
        double a[3], b[3], d[3], *eye = asked.eye;
        point_in_portal(scene, &rng, to, b);
        if (kind <= 1)
            point_in_portal(scene, &rng, from, a);
        else if (kind == 2) { /* on the facade: from a window's corner along its plane, or straight up from it */
            uint32_t first = scene->portal_vertex_first[from], n = scene->portal_vertex_first[from + 1] - first;
            const double *v = scene->portal_vertices[first + sight_next(&rng) % n],
                         *w = scene->portal_vertices[first + sight_next(&rng) % n];
            double s = 3 * sight_unit(&rng) - 1;
            for (int i = 0; i < 3; i++)
                a[i] = v[i] + s * (w[i] - v[i]);
        } else
            point_outdoors(scene, &rng, a);
        for (int i = 0; i < 3; i++)
            d[i] = b[i] - a[i];
        if (!enters(scene, to, d) || !is_clear(&judge, a, b))
            continue;
        memcpy(eye, a, sizeof a);
        if (kind <= 1) {
            /* Back through the window, into the room, some way. */
            double back[3] = {-d[0], -d[1], -d[2]};
            uint32_t recess =
                is_outdoors(scene, scene->portal_cells[from][0]) ? scene->portal_cells[from][1] : scene->portal_cells[from][0];
            if (!enters(scene, from, back))
                continue;
            sight_walk(walker, recess, a, back, INFINITY, &walk);
            uint32_t last = kind == 0 ? (walk.cell_count > 1) : (uint32_t)(sight_next(&rng) % walk.cell_count);
            double until = last + 1 < walk.cell_count ? walk.t_enter[last + 1] : walk.t_enter[last];
            double t = walk.t_enter[last] + sight_unit(&rng) * (until - walk.t_enter[last]);
            if (!(walk.clearance_at[last] > 1e-7))
                continue;
            for (int i = 0; i < 3; i++)
                eye[i] = a[i] + t * back[i];
            tally->from_inside++;
        }
        k++;
        EnfCamera camera = camera_towards(&rng, eye, b);
        if (!in_view(&camera, b)) {
            continue;
        }
        ask(&asked, scene, &camera);
        tally->clear++;
        tally->across += kind <= 1;
        tally->degenerate += kind == 2;
        uint32_t behind = is_outdoors(scene, scene->portal_cells[to][0]) ? scene->portal_cells[to][1] : scene->portal_cells[to][0];
        must_see(&asked, scene, behind, ENF_NONE, kind <= 1 ? "out of a window and in by another" : "in by a window");
        sight_walk(walker, behind, b, d, INFINITY, &walk);
        for (uint32_t i = 1; i < walk.cell_count && walk.clearance_at[i] > 1e-7; i++)
            must_see(&asked, scene, walk.cells[i], ENF_NONE, "behind a window");
        must_see_furniture(&asked, scene, &walk, b, d);
        /* Trees, and further windows, from the same eye when it stands outdoors. */
        for (int more = 0; more < 6 && kind > 1; more++) {
            if (judge.tree_count && more % 2) {
                uint32_t tree = judge.trees[sight_next(&rng) % judge.tree_count];
                for (int i = 0; i < 3; i++)
                    b[i] = scene->objects[tree].bounds[i] +
                           sight_unit(&rng) * (scene->objects[tree].bounds[3 + i] - scene->objects[tree].bounds[i]);
                if (in_view(&camera, b) && is_clear(&judge, eye, b)) {
                    tally->trees++;
                    must_see(&asked, scene, ENF_NONE, tree, "in the open");
                }
            } else {
                to = judge.windows[sight_next(&rng) % judge.window_count];
                point_in_portal(scene, &rng, to, b);
                for (int i = 0; i < 3; i++)
                    d[i] = b[i] - eye[i];
                if (enters(scene, to, d) && in_view(&camera, b) && is_clear(&judge, eye, b))
                    must_see(&asked, scene,
                             is_outdoors(scene, scene->portal_cells[to][0]) ? scene->portal_cells[to][1] : scene->portal_cells[to][0],
                             ENF_NONE, "in by another window");
            }
        }
    }
    for (int m = 0; m < WAYS; m++) {
        free(asked.cells[m]);
        free(asked.objects[m]);
    }
    enf_view_destroy(asked.view);
    sight_walker_destroy(walker);
    free_judge(&judge);
}

static uint64_t camera_count(void) {
    const char *text = getenv("ENF_WITNESS_CAMERAS");
    return text ? strtoull(text, NULL, 10) : 150;
}

static void report(const Tally *t) {
    printf("%llu cameras, %llu clear lines: %llu across from inside, %llu from facades, %llu to trees, %llu to furniture, %llu swept: %llu "
           "missed\n",
           (unsigned long long)t->cameras, (unsigned long long)t->clear, (unsigned long long)t->across, (unsigned long long)t->degenerate,
           (unsigned long long)t->trees, (unsigned long long)t->furniture, (unsigned long long)t->swept, (unsigned long long)t->missed);
    assert_true(t->across > t->cameras / 20 && t->swept > t->cameras / 2 && t->furniture > t->cameras / 60);
    assert_int_equal(t->missed, 0);
}

static const struct {
    const char *spec;
    double wall;
} scenes[] = {{"court:4,storeys=2,objects=12", 0.3},   {"town:7,objects=8", 0.3},     {"town:9,objects=4,turned=0", 0.3},
              {"office:46,objects=9,closed=0.3", 0.3}, {"office:270,objects=5", 0.3}, {"tower:4,windows=1", 0.3}};

static void nothing_outdoors_is_hidden(void **state) {
    (void)state;
    Tally tally = {0};
    for (size_t f = 0; f < sizeof scenes / sizeof *scenes; f++) {
        EnfScene *scene;
        assert_int_equal(enf_family_build(scenes[f].spec, &scene), ENF_OK);
        if (enf_scene_commit(scene) != ENF_OK)
            fail_msg("%s: %s", scenes[f].spec, enf_last_error());
        assert_true(scene->hub != ENF_NONE); /* or there is nothing to test */
        check_scene(scene, scenes[f].spec, scenes[f].wall, camera_count(), 1 + f, &tally);
        enf_scene_destroy(scene);
    }
    report(&tally);
}

static void nothing_outdoors_is_hidden_when_the_scene_is_moved(void **state) {
    (void)state;
    Tally tally = {0};
    SightRng rng = {17};
    for (size_t f = 0; f < sizeof scenes / sizeof *scenes; f++)
        for (int k = 0; k < 4; k++) {
            EnfScene *scene, *moved;
            Motion motion = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1, {0, 0, 0}};
            char spec[96];
            snprintf(spec, sizeof spec, "%s,outdoors=0", scenes[f].spec);
            if (k == 0 || k == 3)
                random_level_turn(&rng, motion.rotation);
            if (k == 1)
                motion.scale = f % 2 ? 1e-3 : 1e3;
            if (k == 2 && f % 2)
                random_turn(&rng, motion.rotation);
            if (k >= 2)
                for (int c = 0; c < 3; c++)
                    motion.offset[c] = 1e7 * (2 * sight_unit(&rng) - 1);
            assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
            assert_int_equal(enf_scene_commit(scene), ENF_OK);
            moved = moved_scene(scene, &motion);
            assert_non_null(moved);
            enf_scene_destroy(scene);
            EnfExteriorReport done = {sizeof done};
            assert_int_equal(enf_scene_decompose_exterior(moved, NULL, &done), ENF_OK);
            assert_int_equal(done.outcome, ENF_EXTERIOR_DONE);
            if (enf_scene_commit(moved) != ENF_OK)
                fail_msg("%s, %d: %s", spec, k, enf_last_error());
            assert_true(moved->hub != ENF_NONE);
            check_scene(moved, spec, scenes[f].wall * motion.scale, camera_count() / 4 + 1, 1000 + 10 * f + (uint64_t)k, &tally);
            enf_scene_destroy(moved);
        }
    report(&tally);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_outdoors_is_hidden),
        cmocka_unit_test(nothing_outdoors_is_hidden_when_the_scene_is_moved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
