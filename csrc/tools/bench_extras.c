/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench view: what pairs of eyes, walks with reuse, and occluders cost and give. */
#include "tools/bench_extras.h"

#include "level_camera.h"
#include "sight_pixels.h"
#include "scene/scene_data.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- Walks and pairs of eyes: the same cameras with and without ---------------------------------------------------- */
/* A walk at 1.4 m/s and 25 frames a second through openings and room middles, level where the openings let it, looking ahead. */
static uint32_t make_walk(const EnfScene *scene, const BenchCamera *from, uint32_t frames, EnfCamera *out) {
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
                goal[2] = fmin(fmax(at[2], scene->cell_bounds[cell][2] + 0.3),
                               fmax(scene->cell_bounds[cell][5] - 0.3, scene->cell_bounds[cell][2] + 0.3));
                continue;
            }
            uint32_t first = scene->cell_portal_first[cell], n = scene->cell_portal_first[cell + 1] - first;
            if (n == 0 || ++turns > 1000)
                return f;
            const EnfCellPortal *side = &scene->cell_portals[first + sight_next(&rng) % n];
            if (side->portal == came && n > 1)
                continue;
            if (!enf_portal_passes(scene, side->portal) ||
                (scene->cell_rooms[side->to] != ENF_NONE && scene->rooms[scene->cell_rooms[side->to]].kind == ENF_ROOM_EXTERIOR))
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

/* Times of the processor, the best of three: a walk is too long to hope that nobody else is at work meanwhile. */
static void walk_through(EnfView *view, const EnfCamera *cameras, uint32_t frames, double reuse, WalkRow *row) {
    EnfViewDef def = enf_default_view_def();
    EnfViewStats stats = enf_default_view_stats();
    double best = INFINITY;
    for (int k = 0; k < 3; k++) {
        clock_t begin = clock();
        def.reuse_distance = def.reuse_angle = 0;
        enf_view_query(view, &cameras[0], &def); /* forgets the walk before */
        def.reuse_distance = def.reuse_angle = reuse;
        for (uint32_t f = 0; f < frames; f++) {
            enf_view_query(view, &cameras[f], &def);
            enf_view_stats(view, &stats);
            row->objects += stats.objects / 3.0;
            row->reused += stats.reused / 3.0;
        }
        best = fmin(best, 1e6 * (double)(clock() - begin) / CLOCKS_PER_SEC);
    }
    row->microseconds += best;
    row->frames += frames;
}

static int bench_pairs_and_walks(const char *spec, const EnfScene *scene, const BenchCamera *cameras, uint32_t count, EnfView *view) {
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
    printf("%-22.22s stereo: one eye %.2f, both apart %.2f, one traversal %.2f microseconds; objects %.2f, union of both eyes %.2f\n", spec,
           one, two, pair, kept_pair, kept_both);
    double n = (double)walks[0].frames;
    if (n > 0) /* there is somewhere to walk */
        printf("%-22.22s walk:   without reuse %.2f, with %.2f microseconds a frame (%.0f %% of frames reused); objects %.2f, %.2f\n", spec,
               walks[0].microseconds / n, walks[1].microseconds / n, 100 * walks[1].reused / n, walks[0].objects / n, walks[1].objects / n);
    return 1;
}

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Random pixels of each camera against the answers with occluders: a pixel is missed when it shows an object that was culled. */
static int bench_occluders(const char *spec, const EnfScene *scene, const SightWalker *walker, const BenchCamera *cameras, uint32_t count,
                           EnfView *view) {
    static const char *const names[] = {"off", "on", "auto"};
    double(*boxes)[6] = calloc((size_t)scene->object_count + 1, sizeof *boxes);
    uint8_t *kept = calloc((size_t)scene->object_count + 1, 1), *shown = calloc((size_t)scene->object_count + 1, 1);
    double *times = calloc(count, sizeof *times);
    for (uint32_t o = 0; boxes && o < scene->object_count; o++)
        memcpy(boxes[o], scene->objects[o].bounds, sizeof boxes[o]);
    SightPixels *pixels = boxes ? sight_pixels_create(scene, walker, (const double(*)[6])boxes) : NULL;
    int ok = kept && shown && times && pixels;
    for (uint32_t use = ENF_OCCLUDERS_OFF; use <= ENF_OCCLUDERS_AUTO && ok; use++) {
        EnfViewDef def = enf_default_view_def();
        EnfViewStats stats = enf_default_view_stats();
        EnfViewResult result = enf_default_view_result();
        double objects = 0, cells = 0, polygons = 0, seen = 0, mean = 0;
        uint64_t rays = 0, missed = 0;
        SightRng rng = {31};
        def.occluders = use;
        for (uint32_t i = 0; i < count; i++) {
            const EnfCamera *camera = &cameras[i].camera;
            double eye[3];
            times[i] = INFINITY;
            for (int k = 0; k < 3; k++) {
                enf_view_query(view, camera, &def);
                enf_view_stats(view, &stats);
                times[i] = fmin(times[i], stats.microseconds);
            }
            mean += times[i] / count;
            objects += (double)stats.objects / count;
            cells += (double)stats.cells / count;
            polygons += (double)stats.occluder_polygons / count;
            if (enf_view_result(view, &result) != ENF_OK)
                ok = 0;
            for (uint32_t o = 0; o < result.object_count; o++)
                kept[result.objects[o]] = 1;
            for (int c = 0; c < 3; c++)
                eye[c] = camera->world_from_camera[4 * c + 3];
            for (int k = 0; k < 500; k++) {
                double x = (2 * sight_unit(&rng) - 1) * tan(0.5 * camera->angle_x),
                       y = (2 * sight_unit(&rng) - 1) * tan(0.5 * camera->angle_y), d[3];
                for (int c = 0; c < 3; c++)
                    d[c] = x * camera->world_from_camera[4 * c] + y * camera->world_from_camera[4 * c + 1] -
                           camera->world_from_camera[4 * c + 2];
                uint32_t cell, object = sight_first_object(pixels, cameras[i].start, eye, d, &cell);
                rays += object != ENF_NONE;
                missed += object != ENF_NONE && !kept[object] && sight_nearest_box(pixels, eye, d) == object;
                if (object != ENF_NONE && !shown[object]) {
                    shown[object] = 1;
                    seen++;
                }
            }
            memset(kept, 0, scene->object_count);
            memset(shown, 0, scene->object_count);
        }
        qsort(times, count, sizeof *times, compare_doubles);
        printf("%-22.22s occluders %-4s: mean %.1f, median %.1f, p99 %.1f, worst %.1f microseconds; cells %.1f, objects %.1f (%.1f met by "
               "pixels), "
               "polygons %.1f; missed %llu of %llu pixels\n",
               spec, names[use], mean, times[count / 2], times[(uint64_t)count * 99 / 100], times[count - 1], cells, objects, seen / count,
               polygons, (unsigned long long)missed, (unsigned long long)rays);
    }
    sight_pixels_destroy(pixels);
    free(boxes);
    free(kept);
    free(shown);
    free(times);
    return ok;
}

int bench_extras(const char *spec, const EnfScene *scene, const SightWalker *walker, const BenchCamera *cameras, uint32_t count,
                 EnfView *view) {
    if (!bench_pairs_and_walks(spec, scene, cameras, count, view))
        return 0;
    return scene->occluder_count == 0 || bench_occluders(spec, scene, walker, cameras, count < 200 ? count : 200, view);
}
