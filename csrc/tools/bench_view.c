/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench view: what a camera query costs and how tight it is, method by method, against the proven truth.
 *
 * Every row: warm times (the best of three runs of each camera), what is kept, and for the cameras that the truth was
 * found for: kept over proven, proven but not kept (must be 0). Operation counts are the same on every machine. */
#include "scene_family.h"
#include "sight_truth.h"
#include "sight_walker.h"
#include "base/timer.h"
#include "scene/scene_data.h"
#include "tools/bench.h"
#include "tools/tool.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INSIDE, FACADE, ORBIT };
static const char *const method_names[] = {"frustum", "box", "clip"};

typedef struct Camera {
    EnfCamera camera;
    uint32_t start;
} Camera;

typedef struct Row {
    double *times;
    double mean, median, p99, worst, locate, traverse, collect;
    double cells, objects, visits, portals, refined;
    double repeat; /* visits over cells */
    uint64_t caps, budgets, unclipped;
    /* over the cameras with truth */
    double cell_excess, object_excess;
    uint64_t kept_cells, true_cells, kept_objects, true_objects, missed;
} Row;

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Level, 90 x 59 degrees, looking along `yaw` with a little pitch. */
static EnfCamera level_camera(const double eye[3], double yaw, double pitch) {
    EnfCamera camera = enf_default_camera();
    double right[3] = {sin(yaw), -cos(yaw), 0}, look[3] = {cos(yaw) * cos(pitch), sin(yaw) * cos(pitch), sin(pitch)};
    double up[3] = {right[1] * look[2] - right[2] * look[1], right[2] * look[0] - right[0] * look[2],
                    right[0] * look[1] - right[1] * look[0]};
    for (int r = 0; r < 3; r++) {
        camera.world_from_camera[4 * r] = right[r];
        camera.world_from_camera[4 * r + 1] = up[r];
        camera.world_from_camera[4 * r + 2] = -look[r];
        camera.world_from_camera[4 * r + 3] = eye[r];
    }
    camera.angle_x = 1.5707963267948966;
    camera.angle_y = 59 * 3.14159265358979323846 / 180;
    camera.clip_near = 0;
    camera.clip_far = INFINITY;
    return camera;
}

static uint32_t outside_cell(const EnfScene *scene) {
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (scene->cell_rooms[c] != ENF_NONE && scene->rooms[scene->cell_rooms[c]].kind == ENF_ROOM_EXTERIOR)
            return c;
    return ENF_NONE;
}

/* Cameras in random rooms; or before a facade; or on an orbit round everything. */
static int make_cameras(const EnfScene *scene, const SightWalker *walker, int where, uint32_t count, Camera *out) {
    SightRng rng = {4711};
    uint32_t outside = outside_cell(scene);
    if (where != INSIDE && outside == ENF_NONE)
        return 0;
    const double *b = scene->bounds;
    double cx = 0.5 * (b[0] + b[3]), cy = 0.5 * (b[1] + b[4]), wx = b[3] - b[0], wy = b[4] - b[1];
    for (uint32_t i = 0; i < count; i++) {
        double eye[3], yaw = 6.283185307179586 * sight_unit(&rng), pitch = 0.3 * sight_unit(&rng) - 0.15;
        out[i].start = outside;
        if (where == INSIDE) {
            for (int tries = 0;; tries++) {
                uint32_t c = (uint32_t)(sight_next(&rng) % scene->cell_count);
                if (c == outside || (tries < 1000 && scene->cell_rooms[c] == ENF_NONE && scene->cell_openings[c] != ENF_NONE) ||
                    !sight_point_in_cell(walker, &rng, c, 0, eye)) {
                    if (tries > 100000)
                        return 0;
                    continue;
                }
                /* An eye on a boundary starts in several cells; what it proves isn't what it is asked about. */
                uint32_t found, located = 0;
                if (tries < 1000 && (enf_scene_locate(scene, eye, &found, 1, &located) != ENF_OK || located != 1 || found != c))
                    continue;
                out[i].start = c;
                break;
            }
        } else if (where == FACADE) { /* 3 to 15 m before the south or north side, looking at it */
            double away = 3 + 12 * sight_unit(&rng);
            int north = (int)(sight_next(&rng) & 1);
            eye[0] = b[0] + wx * sight_unit(&rng);
            eye[1] = north ? b[4] + away : b[1] - away;
            eye[2] = b[2] + (b[5] - b[2]) * sight_unit(&rng);
            yaw = (north ? -1.5707963 : 1.5707963) + sight_unit(&rng) - 0.5;
        } else {
            double angle = 6.283185307179586 * i / count, radius = 0.75 * sqrt(wx * wx + wy * wy) + 10;
            eye[0] = cx + radius * cos(angle);
            eye[1] = cy + radius * sin(angle);
            eye[2] = b[5] + 5;
            yaw = angle + 3.14159265358979;
            pitch = -0.2;
        }
        out[i].camera = level_camera(eye, yaw, pitch);
    }
    return 1;
}

static int run_method(EnfView *view, uint32_t method, const Camera *cameras, uint32_t count, Row *row) {
    EnfViewDef def = enf_default_view_def();
    EnfViewStats stats = enf_default_view_stats();
    def.method = method;
    for (uint32_t i = 0; i < count; i++) {
        double t[3];
        for (int k = 0; k < 3; k++) {
            if (enf_view_query(view, &cameras[i].camera, &def) != ENF_OK)
                return 0;
            enf_view_stats(view, &stats);
            t[k] = stats.microseconds;
        }
        qsort(t, 3, sizeof *t, compare_doubles);
        row->times[i] = t[0];
        row->mean += t[0] / count;
        row->cells += (double)stats.cells / count;
        row->objects += (double)stats.objects / count;
        row->visits += (double)stats.visits / count;
        row->portals += (double)stats.portals_projected / count;
        row->refined += (double)stats.objects_refined / count;
        row->caps += stats.visit_cap_hit;
        row->budgets += stats.budget_hit;
        row->unclipped += stats.portals_unclipped;
        if (stats.cells && (double)stats.visits / stats.cells > row->repeat)
            row->repeat = (double)stats.visits / stats.cells;
        if (i % 16 == 0) { /* the share of the stages, on some of them: reading the clock costs */
            def.measure_stages = 1;
            enf_view_query(view, &cameras[i].camera, &def);
            enf_view_stats(view, &stats);
            row->locate += stats.microseconds_locate;
            row->traverse += stats.microseconds_traverse;
            row->collect += stats.microseconds_objects;
            def.measure_stages = 0;
        }
    }
    qsort(row->times, count, sizeof *row->times, compare_doubles);
    row->median = row->times[count / 2];
    row->p99 = row->times[(uint64_t)count * 99 / 100];
    row->worst = row->times[count - 1];
    return 1;
}

/* Kept against proven, for one camera and method. */
static int judge(EnfView *view, uint32_t method, const Camera *camera, const SightTruth *truth, const EnfScene *scene,
                 Row *row) {
    EnfViewDef def = enf_default_view_def();
    EnfViewResult result = enf_default_view_result();
    def.method = method;
    if (enf_view_query(view, &camera->camera, &def) != ENF_OK || enf_view_result(view, &result) != ENF_OK)
        return 0;
    uint32_t met = 0;
    for (uint32_t i = 0; i < result.cell_count; i++)
        met += sight_truth_cell(truth, result.cells[i]) != 0;
    row->missed += sight_truth_cells(truth) - met;
    row->kept_cells += result.cell_count;
    row->true_cells += sight_truth_cells(truth);
    met = 0;
    for (uint32_t i = 0; i < result.object_count; i++)
        met += sight_truth_object(truth, result.objects[i]) != 0;
    row->missed += sight_truth_objects(truth) - met;
    row->kept_objects += result.object_count;
    row->true_objects += sight_truth_objects(truth);
    (void)scene;
    return 1;
}

/* ---- Walks and pairs of eyes: the same cameras with and without ---------------------------------------------------- */
/* A walk at 1.4 m/s and 25 frames a second through openings and room middles, level where the openings let it, looking ahead. */
static uint32_t make_walk(const EnfScene *scene, const Camera *from, uint32_t frames, EnfCamera *out) {
    double at[3], goal[3], yaw = 0;
    uint32_t cell = from->start, came = ENF_NONE, next = ENF_NONE, turns = 0;
    SightRng rng = {from->start + 99};
    for (int c = 0; c < 3; c++)
        goal[c] = at[c] = from->camera.world_from_camera[4 * c + 3];
    for (uint32_t f = 0; f < frames; f++) {
        double left = 0.056, apart;
        while ((apart = sqrt(pow(goal[0] - at[0], 2) + pow(goal[1] - at[1], 2) + pow(goal[2] - at[2], 2))) <= left) {
            memcpy(at, goal, sizeof at);
            left -= apart;
            if (next != ENF_NONE) { /* through the opening, to the middle of what lies behind */
                cell = next;
                next = ENF_NONE;
                for (int c = 0; c < 2; c++)
                    goal[c] = scene->cell_centres[cell][c];
                goal[2] = fmin(fmax(at[2], scene->cell_bounds[cell][2] + 0.3), fmax(scene->cell_bounds[cell][5] - 0.3, scene->cell_bounds[cell][2] + 0.3));
                continue;
            }
            uint32_t first = scene->cell_portal_first[cell], n = scene->cell_portal_first[cell + 1] - first;
            if (n == 0 || ++turns > 1000)
                return f;
            const EnfCellPortal *side = &scene->cell_portals[first + sight_next(&rng) % n];
            if (side->portal == came && n > 1)
                continue;
            if (!enf_portal_passes(scene, side->portal) || (scene->cell_rooms[side->to] != ENF_NONE && scene->rooms[scene->cell_rooms[side->to]].kind == ENF_ROOM_EXTERIOR))
                continue;
            came = side->portal;
            next = side->to;
            memcpy(goal, scene->portal_centres[came], sizeof goal);
            double low = INFINITY, high = -INFINITY;
            for (uint32_t v = scene->portal_vertex_first[came]; v < scene->portal_vertex_first[came + 1]; v++) {
                low = fmin(low, scene->portal_vertices[v][2]);
                high = fmax(high, scene->portal_vertices[v][2]);
            }
            if (at[2] > low && at[2] < high)
                goal[2] = at[2];
        }
        for (int c = 0; c < 3; c++)
            at[c] += goal[c] != at[c] ? (goal[c] - at[c]) * left / apart : 0;
        double wanted = atan2(goal[1] - at[1], goal[0] - at[0]), turn = f ? remainder(wanted - yaw, 6.283185307179586) : wanted;
        yaw += f ? fmax(-0.05, fmin(0.05, turn)) : turn;
        out[f] = level_camera(at, yaw, 0);
    }
    return frames;
}

typedef struct WalkRow {
    double microseconds, objects, reused;
    uint64_t frames;
} WalkRow;

static void walk_through(EnfView *view, const EnfCamera *cameras, uint32_t frames, double reuse, WalkRow *row) {
    EnfViewDef def = enf_default_view_def();
    EnfViewStats stats = enf_default_view_stats();
    def.reuse_distance = reuse;
    def.reuse_angle = reuse;
    for (uint32_t f = 0; f < frames; f++) {
        enf_view_query(view, &cameras[f], &def);
        enf_view_stats(view, &stats);
        row->microseconds += stats.microseconds;
        row->objects += stats.objects;
        row->reused += stats.reused;
        row->frames++;
    }
}

static int bench_extras(const char *spec, const EnfScene *scene, const Camera *cameras, uint32_t count, EnfView *view) {
    double one = 0, pair = 0, two = 0, kept_pair = 0, kept_both = 0;
    enum { FRAMES = 250 };
    WalkRow walks[2] = {{0, 0, 0, 0}, {0, 0, 0, 0}};
    EnfCamera *walk = calloc(FRAMES, sizeof *walk);
    uint8_t *seen = calloc((size_t)scene->object_count + 1, 1);
    if (!seen || !walk) {
        free(seen);
        free(walk);
        return 0;
    }
    if (count > 200)
        count = 200;
    for (uint32_t i = 0; i < count; i++) {
        EnfCamera eyes[2];
        EnfViewStats stats = enf_default_view_stats();
        EnfViewResult result = enf_default_view_result();
        double best[3] = {INFINITY, INFINITY, INFINITY};
        for (int e = 0; e < 2; e++) {
            eyes[e] = cameras[i].camera;
            for (int c = 0; c < 3; c++)
                eyes[e].world_from_camera[4 * c + 3] += (e ? 0.0325 : -0.0325) * eyes[e].world_from_camera[4 * c];
        }
        for (int k = 0; k < 3; k++) {
            double each = 0;
            for (int e = 0; e < 2; e++) {
                enf_view_query(view, &eyes[e], NULL);
                enf_view_stats(view, &stats);
                each += stats.microseconds;
                if (k == 0 && enf_view_result(view, &result) == ENF_OK)
                    for (uint32_t o = 0; o < result.object_count; o++)
                        seen[result.objects[o]] = 1;
            }
            best[1] = fmin(best[1], each);
            best[0] = 0.5 * best[1]; /* the mean of both: one may see more */
            enf_view_query_union(view, eyes, 2, 0, NULL);
            enf_view_stats(view, &stats);
            best[2] = fmin(best[2], stats.microseconds);
        }
        one += best[0] / count;
        two += best[1] / count;
        pair += best[2] / count;
        kept_pair += (double)stats.objects / count;
        for (uint32_t o = 0; o < scene->object_count; o++)
            if (seen[o]) {
                kept_both += 1.0 / count;
                seen[o] = 0;
            }
        uint32_t frames = make_walk(scene, &cameras[i], FRAMES, walk);
        if (i % 10 == 0)
            for (int r = 0; r < 2; r++)
                walk_through(view, walk, frames, r, &walks[r]);
    }
    free(seen);
    free(walk);
    printf("%-22.22s stereo: one eye %.2f, both apart %.2f, one traversal %.2f microseconds; objects %.2f, union of both eyes %.2f\n",
           spec, one, two, pair, kept_pair, kept_both);
    double n = (double)walks[0].frames;
    printf("%-22.22s walk:   without reuse %.2f, with %.2f microseconds a frame (%.0f %% of frames reused); objects %.2f, %.2f\n",
           spec, walks[0].microseconds / n, walks[1].microseconds / n, 100 * walks[1].reused / n, walks[0].objects / n, walks[1].objects / n);
    return 1;
}

static int bench_one(const char *spec, const EnfScene *scene, int where, uint32_t queries, uint32_t truths, FILE *csv) {
    static const char *const places[] = {"inside", "facade", "orbit"};
    SightWalker *walker = sight_walker_create(scene);
    SightTruth *truth = walker ? sight_truth_create(scene, walker) : NULL;
    Camera *cameras = calloc(queries, sizeof *cameras);
    Row rows[3];
    memset(rows, 0, sizeof rows);
    EnfView *view = NULL;
    int ok = truth && cameras && enf_view_create(scene, &view) == ENF_OK;
    for (int m = 0; m < 3 && ok; m++)
        ok = (rows[m].times = calloc(queries, sizeof(double))) != NULL;
    if (!ok || !make_cameras(scene, walker, where, queries, cameras))
        goto done;
    double(*boxes)[6] = calloc((size_t)scene->object_count + 1, sizeof *boxes);
    for (uint32_t o = 0; boxes && o < scene->object_count; o++)
        memcpy(boxes[o], scene->objects[o].bounds, sizeof boxes[o]);
    for (uint32_t m = 0; m < 3 && ok; m++)
        ok = run_method(view, m, cameras, queries, &rows[m]);
    uint32_t found = 0;
    double until = enf_wall_seconds() + 20; /* the truth is slow: no more than this for a scene */
    for (uint32_t i = 0; i < truths && i < queries && ok && boxes && enf_wall_seconds() < until; i++)
        if (sight_truth_find(truth, cameras[i].start, &cameras[i].camera, (const double(*)[6])boxes, 400000)) {
            found++;
            for (uint32_t m = 0; m < 3 && ok; m++)
                ok = judge(view, m, &cameras[i], truth, scene, &rows[m]);
        }
    free(boxes);
    for (uint32_t m = 0; m < 3 && ok; m++) {
        const Row *r = &rows[m];
        double stages = r->locate + r->traverse + r->collect;
        printf("%-22.22s %-7s %-7s %8.1f %8.1f %9.1f %9.1f %8.1f %9.1f %6.3f %6u %7.4f %7.4f %6llu  %2.0f/%2.0f/%2.0f %llu\n", spec,
               places[where], method_names[m], r->mean, r->median, r->p99, r->worst, r->cells, r->objects,
               r->repeat, found, r->true_cells ? (double)r->kept_cells / (double)r->true_cells : NAN,
               r->true_objects ? (double)r->kept_objects / (double)r->true_objects : NAN, (unsigned long long)r->missed,
               100 * r->locate / stages, 100 * r->traverse / stages, 100 * r->collect / stages,
               (unsigned long long)r->budgets);
        if (csv)
            fprintf(csv, "%s,%s,%s,%u,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%u,%llu,%llu,%llu,%llu,%llu,%.4f,%.4f,%.4f,%llu,%llu,%llu,%.6f\n",
                    spec, places[where], method_names[m], queries, r->mean, r->median, r->p99, r->worst, r->cells, r->objects,
                    r->visits, r->portals, r->refined, found, (unsigned long long)r->kept_cells,
                    (unsigned long long)r->true_cells, (unsigned long long)r->kept_objects,
                    (unsigned long long)r->true_objects, (unsigned long long)r->missed, r->locate / stages,
                    r->traverse / stages, r->collect / stages, (unsigned long long)r->caps,
                    (unsigned long long)r->budgets, (unsigned long long)r->unclipped,
                    r->true_cells ? (double)r->kept_cells / (double)r->true_cells - 1 : NAN);
        fflush(stdout);
    }
    if (where == INSIDE && ok)
        ok = bench_extras(spec, scene, cameras, queries, view);
done:
    for (int m = 0; m < 3; m++)
        free(rows[m].times);
    free(cameras);
    enf_view_destroy(view);
    sight_truth_destroy(truth);
    sight_walker_destroy(walker);
    return ok;
}

static int open_scene(const char *spec, EnfScene **out_scene) {
    int code;
    if (!strchr(spec, ':') || strstr(spec, ".json") || strstr(spec, ".prt"))
        return enf_tool_load(spec, out_scene, &code);
    if (enf_family_build(spec, out_scene) != ENF_OK || enf_scene_commit(*out_scene) != ENF_OK) {
        fprintf(stderr, "enfilade bench view: %s: %s\n", spec, enf_last_error());
        return 0;
    }
    return 1;
}

int enf_bench_view(int argc, char **argv) {
    static const char *const usual[] = {"office:46,windows=0", "office:1768,windows=0", "office:100000,windows=0",
                                        "office:1768",         "grid:100",              "grid:300",
                                        "grid:50,storeys=50",  "columns:100",           "ring:200",
                                        "hub:500",             "tower:60",              "enfilade:40"};
    const char *specs[256], *csv_path = NULL;
    uint32_t count = 0, queries = 2000, truths = 300;
    for (int i = 1; i < argc; i++) {
        if (strncmp(argv[i], "--", 2) != 0) {
            if (count < 256)
                specs[count++] = argv[i];
            continue;
        }
        if (i + 1 >= argc)
            return enf_tool_usage("bench view", "%s wants a value", argv[i]);
        if (strcmp(argv[i], "--queries") == 0)
            queries = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--truths") == 0)
            truths = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--csv") == 0)
            csv_path = argv[++i];
        else
            return enf_tool_usage("bench view", "no option %s", argv[i]);
    }
    if (queries == 0)
        return enf_tool_usage("bench view", "--queries wants a number above 0");
    if (count == 0)
        for (; count < sizeof usual / sizeof *usual; count++)
            specs[count] = usual[count];
    FILE *csv = NULL;
    if (csv_path && !(csv = fopen(csv_path, "w"))) {
        fprintf(stderr, "enfilade bench view: %s can't be written\n", csv_path);
        return ENF_EXIT_BAD_INPUT;
    }
    if (csv)
        fprintf(csv, "scene,where,method,queries,mean_us,median_us,p99_us,worst_us,cells,objects,visits,portals_projected,"
                     "objects_refined,truths,kept_cells,true_cells,kept_objects,true_objects,missed,share_locate,"
                     "share_traverse,share_objects,visit_caps,budgets,unclipped,cell_overestimate\n");
    printf("times in microseconds; vis/cel: most visits over cells; true: cameras with proven truth; cells x, obj x: kept over\n"
           "proven; miss: proven but not kept; loc/tra/obj: %% of time by stage; bud: queries that ran out of budget\n"
           "%-22s %-7s %-7s %8s %8s %9s %9s %8s %9s %6s %6s %7s %7s %6s  %s bud\n", "scene", "where", "method", "mean",
           "median", "p99", "worst", "cells", "objects", "vis/cel", "true", "cells x", "obj x", "miss", "loc/tra/obj");
    int ok = 1;
    for (uint32_t i = 0; i < count; i++) {
        EnfScene *scene = NULL;
        if (!open_scene(specs[i], &scene)) {
            ok = 0;
            continue;
        }
        const char *name = strrchr(specs[i], '/') ? strrchr(specs[i], '/') + 1 : specs[i];
        uint32_t few = scene->cell_count > 50000 && strncmp(name, "grid", 4) == 0 ? (queries < 50 ? queries : 50) : queries;
        for (int where = INSIDE; where <= ORBIT; where++)
            ok &= bench_one(name, scene, where, where == INSIDE ? few : (few < 300 ? few : 300), truths, csv);
        enf_scene_destroy(scene);
    }
    if (csv)
        fclose(csv);
    return ok ? ENF_EXIT_OK : ENF_EXIT_INTERNAL;
}
