/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench view: what a camera query costs and how tight it is, method by method, against the proven truth.
 *
 * Every row: warm times (the best of three runs of each camera), what is kept, and for the cameras that the truth was
 * found for: kept over proven, proven but not kept (must be 0). Operation counts are the same on every machine. */
#include "level_camera.h"
#include "scene_family.h"
#include "sight_truth.h"
#include "sight_walker.h"
#include "base/timer.h"
#include "scene/scene_data.h"
#include "tools/bench.h"
#include "tools/bench_extras.h"
#include "tools/tool.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INSIDE, FACADE, COURT, ORBIT, PLACES };
static const char *const method_names[] = {"frustum", "box", "clip"};

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

static uint32_t outside_cell(const EnfScene *scene) {
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (enf_is_exterior(scene, c))
            return c;
    return ENF_NONE;
}

/* What is indoors, without the outdoors round it. */
static void building_box(const EnfScene *scene, double box[6]) {
    for (int k = 0; k < 6; k++)
        box[k] = k < 3 ? INFINITY : -INFINITY;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        for (int k = 0; k < 3 && !enf_is_exterior(scene, c); k++) {
            box[k] = fmin(box[k], scene->cell_bounds[c][k]);
            box[3 + k] = fmax(box[3 + k], scene->cell_bounds[c][3 + k]);
        }
}

/* The outdoor cell that holds a point and no other does; ENF_NONE: indoors, in a wall, or in between. */
static uint32_t outdoors_at(const EnfScene *scene, const double point[3]) {
    uint32_t found, located = 0;
    if (enf_scene_locate(scene, point, &found, 1, &located) != ENF_OK || located != 1 || !enf_is_exterior(scene, found))
        return ENF_NONE;
    return found;
}

/* Cameras in random rooms; or before a facade; or between the building's parts; or on an orbit round everything. */
static int make_cameras(const EnfScene *scene, const SightWalker *walker, int where, uint32_t count, BenchCamera *out) {
    SightRng rng = {4711};
    uint32_t outside = outside_cell(scene);
    if (where != INSIDE && outside == ENF_NONE)
        return 0;
    double b[6];
    building_box(scene, b);
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
            if ((out[i].start = outdoors_at(scene, eye)) == ENF_NONE) {
                i--;
                continue;
            }
        } else if (where == COURT) { /* outdoors within the building's own bounds: courts, streets; looking up a little */
            int tries = 0;
            do
                for (int k = 0; k < 3; k++)
                    eye[k] = b[k] + (k == 2 ? 1.6 : (b[3 + k] - b[k]) * sight_unit(&rng));
            while ((out[i].start = outdoors_at(scene, eye)) == ENF_NONE && ++tries < 10000);
            if (out[i].start == ENF_NONE)
                return 0;
            pitch += 0.15;
        } else {
            double angle = 6.283185307179586 * i / count, radius = 0.75 * sqrt(wx * wx + wy * wy) + 10;
            eye[0] = cx + radius * cos(angle);
            eye[1] = cy + radius * sin(angle);
            eye[2] = b[5] + 5;
            yaw = angle + 3.14159265358979;
            pitch = -0.2;
            out[i].start = outdoors_at(scene, eye);
            if (out[i].start == ENF_NONE)
                return 0;
        }
        out[i].camera = level_camera(eye, yaw, pitch);
    }
    return 1;
}

static int run_method(EnfView *view, uint32_t method, const BenchCamera *cameras, uint32_t count, Row *row) {
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
        row->budgets += stats.budget_hit != 0;
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
static int judge(EnfView *view, uint32_t method, const BenchCamera *camera, const SightTruth *truth, const EnfScene *scene, Row *row) {
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

/* What the objects that are spared must cost to draw for the time to be won back. */
static void print_worth(const char *spec, const Row *frustum, const Row *clip) {
    double more = clip->mean - frustum->mean, fewer = frustum->objects - clip->objects;
    printf("%-22.22s orbit:  %.2f times the frustum's time, %.1f times fewer objects", spec, clip->mean / frustum->mean,
           frustum->objects / clip->objects);
    if (more > 0 && fewer > 0)
        printf("; pays where drawing one costs more than %.0f nanoseconds", 1000 * more / fewer);
    printf("\n");
}

static int bench_one(const char *spec, const EnfScene *scene, int where, uint32_t queries, uint32_t truths, FILE *csv) {
    static const char *const places[] = {"inside", "facade", "court", "orbit"};
    SightWalker *walker = sight_walker_create(scene);
    SightTruth *truth = walker ? sight_truth_create(scene, walker) : NULL;
    BenchCamera *cameras = calloc(queries, sizeof *cameras);
    Row rows[3];
    memset(rows, 0, sizeof rows);
    EnfView *view = NULL;
    int ok = truth && cameras && enf_view_create(scene, &view) == ENF_OK;
    for (int m = 0; m < 3 && ok; m++)
        ok = (rows[m].times = calloc(queries, sizeof(double))) != NULL;
    if (!ok || !make_cameras(scene, walker, where, queries, cameras))
        goto done; /* nothing of the kind is there: no row */
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
               places[where], method_names[m], r->mean, r->median, r->p99, r->worst, r->cells, r->objects, r->repeat, found,
               r->true_cells ? (double)r->kept_cells / (double)r->true_cells : NAN,
               r->true_objects ? (double)r->kept_objects / (double)r->true_objects : NAN, (unsigned long long)r->missed,
               100 * r->locate / stages, 100 * r->traverse / stages, 100 * r->collect / stages, (unsigned long long)r->budgets);
        if (csv)
            fprintf(
                csv,
                "%s,%s,%s,%u,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%u,%llu,%llu,%llu,%llu,%llu,%.4f,%.4f,%.4f,%llu,%llu,%llu,%.6f\n",
                spec, places[where], method_names[m], queries, r->mean, r->median, r->p99, r->worst, r->cells, r->objects, r->visits,
                r->portals, r->refined, found, (unsigned long long)r->kept_cells, (unsigned long long)r->true_cells,
                (unsigned long long)r->kept_objects, (unsigned long long)r->true_objects, (unsigned long long)r->missed, r->locate / stages,
                r->traverse / stages, r->collect / stages, (unsigned long long)r->caps, (unsigned long long)r->budgets,
                (unsigned long long)r->unclipped, r->true_cells ? (double)r->kept_cells / (double)r->true_cells - 1 : NAN);
        fflush(stdout);
    }
    if (where == ORBIT && ok)
        print_worth(spec, &rows[ENF_VIEW_FRUSTUM], &rows[ENF_VIEW_CLIP]);
    if (where == INSIDE && ok)
        ok = bench_extras(spec, scene, walker, cameras, queries, view);
done:
    for (int m = 0; m < 3; m++)
        free(rows[m].times);
    free(cameras);
    enf_view_destroy(view);
    sight_truth_destroy(truth);
    sight_walker_destroy(walker);
    return ok;
}

int enf_bench_view(int argc, char **argv) {
    static const char *const usual[] = {"office:46,windows=0",
                                        "office:1768,windows=0",
                                        "office:100000,windows=0",
                                        "office:1768",
                                        "grid:100",
                                        "grid:300",
                                        "grid:50,storeys=50",
                                        "columns:100",
                                        "ring:200",
                                        "hub:500",
                                        "tower:60",
                                        "enfilade:40",
                                        "city:12",
                                        "office:1768,windows=0,occluders=1",
                                        "screens:20",
                                        "brick:100",
                                        "court:20",
                                        "town:24",
                                        "tower:60,windows=1"};
    /* From outside, from inside to outside, across courts; and with the outside as one cell, to compare. */
    static const char *const outdoors[] = {
        "office:46", "office:1768", "office:1768,outdoors=0", "court:20", "town:24", "tower:60,windows=1", "office:10", "office:300",
        "court:8",   "town:8",      "town:24,seed=2",         "town:60"};
    const char *specs[256], *csv_path = NULL;
    uint32_t count = 0, queries = 2000, truths = 300;
    for (int i = 1; i < argc; i++) {
        if (strncmp(argv[i], "--", 2) != 0) {
            if (count < 256)
                specs[count++] = argv[i];
            continue;
        }
        if (strcmp(argv[i], "--usual") == 0) { /* what is measured without any name, beside files that are named */
            for (uint32_t k = 0; k < sizeof usual / sizeof *usual && count < 256; k++)
                specs[count++] = usual[k];
            continue;
        }
        if (strcmp(argv[i], "--outdoors") == 0) {
            for (uint32_t k = 0; k < sizeof outdoors / sizeof *outdoors && count < 256; k++)
                specs[count++] = outdoors[k];
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
           "%-22s %-7s %-7s %8s %8s %9s %9s %8s %9s %6s %6s %7s %7s %6s  %s bud\n",
           "scene", "where", "method", "mean", "median", "p99", "worst", "cells", "objects", "vis/cel", "true", "cells x", "obj x", "miss",
           "loc/tra/obj");
    int ok = 1;
    for (uint32_t i = 0; i < count; i++) {
        EnfScene *scene = NULL;
        if (!enf_bench_scene(argv[0], specs[i], &scene)) {
            ok = 0;
            continue;
        }
        const char *name = strrchr(specs[i], '/') ? strrchr(specs[i], '/') + 1 : specs[i];
        uint32_t few = scene->cell_count > 50000 && strncmp(name, "grid", 4) == 0 ? (queries < 50 ? queries : 50) : queries;
        for (int where = INSIDE; where < PLACES; where++)
            ok &= bench_one(name, scene, where, where == INSIDE ? few : (few < 300 ? few : 300), truths, csv);
        enf_scene_destroy(scene);
    }
    if (csv)
        fclose(csv);
    return ok ? ENF_EXIT_OK : ENF_EXIT_INTERNAL;
}
