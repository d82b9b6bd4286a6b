/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench raycast: pictures and rays through cells beside a general ray tracer on the same walls, one thread, equal output checked
 * first. Ratios to the tracer's best mode are what counts; millions a second belong to the machine. */
#include "tools/bench.h"
#include "tools/bench_rays.h"
#include "tools/tool.h"

#include "base/timer.h"
#include "embree_modes.h"
#include "moved_scene.h"
#include "raycast/ray_model.h"
#include "scene_family.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_ROWS = 160, MAX_SPECS = 64 };

typedef struct Options {
    uint32_t size, cameras, repeats;
    int aligned, turned, threads;
    FILE *csv;
} Options;

typedef struct Row {
    const char *kind, *method;
    double seconds, count; /* best of all repeats, summed over cameras */
    double least;          /* this camera's best so far */
    double (*clock)(void); /* this thread's processor time: other work on the machine counts less; with threads, the wall */
} Row;

static const char *const kind_primary = "primary", *const kind_random = "random", *const kind_bounce = "bounce",
                         *const kind_shadow = "shadow", *const kind_threads = "2 threads";

typedef struct Table {
    Row rows[MAX_ROWS];
    uint32_t count;
} Table;

static Row *row_of(Table *table, const char *kind, const char *method) {
    for (uint32_t i = 0; i < table->count; i++)
        if (table->rows[i].kind == kind && strcmp(table->rows[i].method, method) == 0)
            return &table->rows[i];
    Row *row = &table->rows[table->count < MAX_ROWS ? table->count++ : MAX_ROWS - 1];
    *row = (Row){kind, method, 0, 0, INFINITY, kind == kind_threads ? enf_wall_seconds : enf_thread_cpu_seconds};
    return row;
}

#define TIMED(table, kind, method, call)                                                                                                   \
    do {                                                                                                                                   \
        Row *timed_row = row_of(table, kind, method);                                                                                      \
        double timed_begin = timed_row->clock();                                                                                           \
        call;                                                                                                                              \
        double timed = timed_row->clock() - timed_begin;                                                                                   \
        timed_row->least = timed < timed_row->least ? timed : timed_row->least;                                                            \
    } while (0)

static void close_camera(Table *table, const char *kind, double count) {
    for (uint32_t i = 0; i < table->count; i++) {
        Row *row = &table->rows[i];
        if (row->kind != kind || !(row->least < INFINITY))
            continue;
        row->seconds += row->least;
        row->count += count;
        row->least = INFINITY;
    }
}

static const char *const ray_methods[] = {"auto", "single", "packets of 8", "packets of 16", "waves"};
static const char *const simd_names[] = {"best", "plain", "AVX2", "AVX-512"};

/* One kind of rays by all our methods and all the tracer's modes. */
static void time_rays(Table *table, const char *kind, const EnfRaycaster *r, const EmbreeScene *const tracer[2], const RaySet *rays,
                      int any, int coherent, uint32_t repeats, RaySet *scratch) {
    static char names[2][2][EMBREE_MODES][64];
    for (uint32_t repeat = 0; repeat < repeats; repeat++) {
        for (uint32_t method = ENF_RAYS_SINGLE; method <= ENF_RAYS_WAVES; method++) {
            EnfRayBatch batch = ray_set_batch(rays);
            EnfRayHits hits = enf_default_ray_hits();
            batch.method = method;
            hits.distance = scratch->distance;
            hits.surface = scratch->surface;
            if (any)
                TIMED(table, kind, ray_methods[method], enf_raycast_any(r, &batch, scratch->blocked));
            else
                TIMED(table, kind, ray_methods[method], enf_raycast_closest(r, &batch, &hits));
        }
        if (!any) {
            EnfRayBatch batch = ray_set_batch(rays);
            EnfRayHits hits = enf_default_ray_hits();
            batch.method = ENF_RAYS_SINGLE;
            batch.simd = ENF_SIMD_NONE;
            hits.distance = scratch->distance;
            hits.surface = scratch->surface;
            TIMED(table, kind, "single in plain C", enf_raycast_closest(r, &batch, &hits));
        }
        EmbreeRays theirs = {rays->count, rays->o[0], rays->o[1], rays->o[2], rays->d[0], rays->d[1], rays->d[2], rays->limit};
        for (int quality = 0; quality < 2; quality++)
            for (int mode = 0; mode < EMBREE_MODES && tracer[quality]; mode++)
                for (int flag = 0; flag <= coherent; flag++) {
                    char *name = names[quality][flag][mode];
                    snprintf(name, sizeof names[0][0][0], "%s %s%s", embree_mode_names[mode], quality ? "HIGH" : "MEDIUM",
                             flag ? " coherent" : "");
                    if (any)
                        TIMED(table, kind, name, embree_any(tracer[quality], mode, flag, &theirs, scratch->blocked));
                    else
                        TIMED(table, kind, name, embree_closest(tracer[quality], mode, flag, &theirs, scratch->distance, scratch->surface));
                }
    }
    close_camera(table, kind, (double)rays->count);
}

static void time_pictures(Table *table, const EnfRaycaster *r, const EnfCamera *camera, const Options *options, Picture *picture,
                          int threads) {
    static const struct {
        uint32_t method, buffers;
        const char *name;
    } ways[] = {{ENF_IMAGE_PACKETS, 0, "picture by packets"},
                {ENF_IMAGE_TILES, 0, "picture by tiles"},
                {ENF_IMAGE_SPANS, 0, "picture by spans"},
                {ENF_IMAGE_SPANS, 1, "picture by spans with normal and uv"}};
    for (uint32_t repeat = 0; repeat < 2 * options->repeats; repeat++)
        for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
            EnfRaycastImage image = picture_request(picture, ways[i].buffers);
            image.method = ways[i].method;
            TIMED(table, kind_primary, ways[i].name, enf_raycast_image(r, camera, &image));
            if (threads && ways[i].method == ENF_IMAGE_SPANS && !ways[i].buffers) {
                image.threads = 2;
                TIMED(table, kind_threads, ways[i].name, enf_raycast_image(r, camera, &image));
            }
            if (i == 0)
                TIMED(table, kind_primary, "bound: memset of the outputs", picture_memset(picture));
        }
}

/* Theirs against ours. A different distance is a mismatch; it is explained when the ray meets an edge so closely that both answers are
 * found by rays a rounding away, when the reference in doubles sides with us (a crack in the triangles), or when both hit one surface so
 * flatly that the rounding of its corners' coordinates moves the hit so far. */
typedef struct Verdict {
    uint64_t rays, names, mismatches, at_edges, ours, grazing, unexplained;
} Verdict;

static int alike(double a, double b) {
    return a == b || fabs(a - b) <= 1e-4 * fmax(fabs(a), 1e-2) + 2e-5;
}

static int grazes(const EnfRaycaster *r, const RaySet *rays, uint64_t i, uint32_t surface, double apart) {
    EnfSurface s = enf_default_surface();
    double across = 0, largest = 0;
    if (enf_raycaster_surface(r, surface, &s) != ENF_OK)
        return 0;
    for (int k = 0; k < 3; k++) {
        across += s.normal[k] * rays->d[k][i];
        largest = fmax(largest, fabs((double)rays->o[k][i]));
    }
    return fabs(across) * apart <= 4 * 1.2e-7 * largest; /* two corners, each off by a rounding of its size */
}

static void judge(const EnfRaycaster *r, const RaySet *rays, const float *mine, const uint32_t *surface, const float *theirs,
                  const uint32_t *triangle, const WallTriangles *walls, Verdict *v) {
    double origin[3];
    enf_raycaster_origin(r, origin);
    v->rays += rays->count;
    for (uint64_t i = 0; i < rays->count; i++) {
        uint32_t named = triangle[i] == ENF_NONE ? ENF_NONE : walls->surfaces[triangle[i]];
        if (alike(mine[i], theirs[i])) {
            v->names += surface[i] != named;
            continue;
        }
        v->mismatches++;
        int agrees[2] = {0, 0}, reference = 0;
        double length =
            sqrt((double)rays->d[0][i] * rays->d[0][i] + (double)rays->d[1][i] * rays->d[1][i] + (double)rays->d[2][i] * rays->d[2][i]);
        for (int k = 0; k < 27; k++) {
            EnfRay ray = {{0, 0, 0}, {0, 0, 0}, INFINITY, rays->cell[i], 0};
            EnfRayHit hit;
            for (int c = 0, digit = k; c < 3; c++, digit /= 3) {
                ray.origin[c] = origin[c] + rays->o[c][i];
                ray.direction[c] = rays->d[c][i] + (digit % 3 == 0 ? 0 : digit % 3 == 1 ? 2e-6 : -2e-6) * length;
            }
            enf_raycast_rays(r, &ray, 1, &hit);
            agrees[0] |= alike(hit.distance, mine[i]);
            agrees[1] |= alike(hit.distance, theirs[i]);
            reference |= k == 0 && alike(hit.distance, mine[i]);
        }
        if (agrees[0] && agrees[1])
            v->at_edges++;
        else if (surface[i] == named && surface[i] != ENF_NONE && grazes(r, rays, i, surface[i], fabs((double)mine[i] - theirs[i])))
            v->grazing++;
        else if (reference)
            v->ours++;
        else
            v->unexplained++;
    }
}

static double best_of_theirs(const Table *table, const char *kind, const char **name) {
    double best = 0;
    for (uint32_t i = 0; i < table->count; i++) {
        const Row *row = &table->rows[i];
        double rate = row->count / row->seconds;
        if (row->kind == kind && strncmp(row->method, "rtc", 3) == 0 && rate > best)
            best = rate, *name = row->method;
    }
    return best;
}

static void print_kind(const Table *table, const char *kind, const char *scene, FILE *csv) {
    const char *anchor = "";
    double best = best_of_theirs(table, kind, &anchor), one = 0;
    for (uint32_t i = 0; i < table->count; i++)
        if (table->rows[i].kind == kind && strncmp(table->rows[i].method, "rtcIntersect1 ", 14) == 0)
            one = fmax(one, table->rows[i].count / table->rows[i].seconds);
    for (uint32_t i = 0; i < table->count; i++) {
        const Row *row = &table->rows[i];
        if (row->kind != kind || row->seconds == 0)
            continue;
        double rate = row->count / row->seconds;
        int theirs = strncmp(row->method, "rtc", 3) == 0;
        if (csv)
            fprintf(csv, "%s,%s,%s,%.0f,%.6f,%.3f,%.3f,%.3f\n", scene, kind, row->method, row->count, row->seconds, 1e-6 * rate,
                    best > 0 ? rate / best : NAN, one > 0 ? rate / one : NAN);
        if (!theirs || row->method == anchor || (one > 0 && rate == one))
            printf("  %-9s %-36s %10.1f %9.1f %9.1f%s\n", kind, row->method, 1e-6 * rate, best > 0 ? rate / best : NAN,
                   one > 0 ? rate / one : NAN, row->method == anchor ? "  <- anchor" : "");
    }
}

static int bench_scene(const char *name, const EnfScene *scene, const Options *options) {
    uint32_t size = options->size;
    uint64_t pixels = (uint64_t)size * size;
    Table *table = calloc(1, sizeof *table);
    RaySet *primary = ray_set_create(pixels), *other = ray_set_create(pixels), *scratch = ray_set_create(pixels);
    Picture *picture = picture_create(size, size);
    EnfRaycaster *r = NULL;
    WallTriangles walls = {0};
    const EmbreeScene *tracer[2] = {NULL, NULL};
    Verdict verdicts[4] = {{0}};
    uint64_t patched = 0, unwritten = 0, differing = 0;
    uint64_t live = enf_live_bytes();
    double begin = enf_wall_seconds(), ours_seconds;
    int ok = table && primary && other && scratch && picture && enf_raycaster_create(scene, &r) == ENF_OK;
    ours_seconds = enf_wall_seconds() - begin;
    uint64_t ours_bytes = enf_live_bytes() - live;
    double origin[3] = {0, 0, 0};
    enf_raycaster_origin(r, origin);
    if (ok && !embree_missing() && wall_triangles_make(scene, origin, &walls))
        for (int quality = 0; quality < 2; quality++)
            tracer[quality] = embree_scene_create(&walls, quality);
    const EmbreeScene *judge_scene = tracer[1];
    uint64_t rng = 1;
    double hits = 0, portals = 0;
    for (uint32_t c = 0; c < options->cameras && ok; c++) {
        EnfCamera camera;
        uint32_t start;
        if (!place_camera(scene, &rng, &camera, &start))
            break;
        EmbreeRays theirs;
        primary_rays(scene, r, &camera, start, size, primary);
        struct {
            const char *kind;
            RaySet *rays;
        } sets[4] = {{kind_primary, primary}, {kind_random, other}, {kind_bounce, other}, {kind_shadow, other}};
        for (int k = 0; k < 4; k++) {
            if (k == 1)
                random_rays(scene, r, &rng, other);
            else if (k == 2)
                bounce_rays(r, primary, &rng, other);
            else if (k == 3)
                shadow_rays(scene, r, primary, start, other);
            RaySet *rays = sets[k].rays;
            EnfRayBatch batch = ray_set_batch(rays);
            EnfRayHits out = enf_default_ray_hits();
            batch.method = k == 0 ? ENF_RAYS_PACKETS16 : ENF_RAYS_WAVES;
            out.distance = rays->distance;
            out.surface = rays->surface;
            out.cell = rays->hit_cell;
            out.portals = scratch->blocked;
            enf_raycast_closest(r, &batch, &out);
            if (judge_scene) {
                theirs = (EmbreeRays){rays->count, rays->o[0], rays->o[1], rays->o[2], rays->d[0], rays->d[1], rays->d[2], rays->limit};
                embree_closest(judge_scene, EMBREE_16, k == 0, &theirs, scratch->distance, scratch->surface);
                judge(r, rays, rays->distance, rays->surface, scratch->distance, scratch->surface, &walls, &verdicts[k]);
            }
            if (k == 0)
                for (uint64_t i = 0; i < pixels; i++) {
                    hits += rays->surface[i] != ENF_NONE;
                    portals += scratch->blocked[i];
                }
            time_rays(table, sets[k].kind, r, tracer, rays, k == 3, k == 0 || k == 3, options->repeats, scratch);
            if (k == 0) {
                patched += picture_check(r, &camera, primary, picture, &unwritten, &differing);
                time_pictures(table, r, &camera, options, picture, options->threads);
                close_camera(table, kind_primary, (double)pixels);
                close_camera(table, kind_threads, (double)pixels);
            }
        }
    }
    printf("%s: %u cells, %u portals, %u triangles; simd %s; %.1f cells a primary ray, %.1f %% hit\n", name, scene->cell_count,
           scene->portal_count, walls.triangle_count, simd_names[bench_simd()],
           1 + portals / fmax(1, primary ? (double)primary->count * options->cameras : 1),
           100 * hits / fmax(1, primary ? (double)primary->count * options->cameras : 1));
    const PrismModel *prisms = &r->prisms;
    printf("  %u cells are upright prisms, with %u sides and %u caps asked by planes; %u have no walls, %u another shape\n", prisms->prisms,
           prisms->open_sides, prisms->open_caps, prisms->unwalled, r->cell_count - prisms->prisms - prisms->unwalled);
    printf("  memory %.0f KiB, linked in %.2f ms", ours_bytes / 1024.0, 1e3 * ours_seconds);
    for (int quality = 0; quality < 2; quality++)
        if (tracer[quality])
            printf("; Embree %s %.0f KiB (%.2f of it), %.2f ms", quality ? "HIGH" : "MEDIUM", embree_bytes(tracer[quality]) / 1024.0,
                   (double)ours_bytes / (double)embree_bytes(tracer[quality]), 1e3 * embree_build_seconds(tracer[quality]));
    printf("\n  pixels: %llu written twice or not at all, %llu patched, spans differ from rays in %llu of %llu\n",
           (unsigned long long)unwritten, (unsigned long long)patched, (unsigned long long)differing,
           (unsigned long long)(pixels * options->cameras));
    for (int k = 0; k < 4 && judge_scene; k++)
        printf("  %-9s mismatches %llu of %llu: %llu at an edge, %llu flat on one wall, %llu where doubles side with us, %llu\n"
               "            unexplained; same distance, other name %llu\n",
               k == 0   ? kind_primary
               : k == 1 ? kind_random
               : k == 2 ? kind_bounce
                        : kind_shadow,
               (unsigned long long)verdicts[k].mismatches, (unsigned long long)verdicts[k].rays, (unsigned long long)verdicts[k].at_edges,
               (unsigned long long)verdicts[k].grazing, (unsigned long long)verdicts[k].ours, (unsigned long long)verdicts[k].unexplained,
               (unsigned long long)verdicts[k].names);
    printf("  %-9s %-36s %10s %9s %9s\n", "rays", "method", "M a second", "x best", "x one");
    const char *kinds[5] = {kind_primary, kind_random, kind_bounce, kind_shadow, kind_threads};
    for (int k = 0; k < 5 && ok; k++)
        print_kind(table, kinds[k], name, options->csv);
    if (options->csv && ok)
        fprintf(options->csv, "%s,memory,cells,%llu,%.6f,,,\n", name, (unsigned long long)ours_bytes, ours_seconds);
    for (int quality = 0; quality < 2 && options->csv; quality++)
        if (tracer[quality])
            fprintf(options->csv, "%s,memory,Embree %s,%llu,%.6f,,,\n", name, quality ? "HIGH" : "MEDIUM",
                    (unsigned long long)embree_bytes(tracer[quality]), embree_build_seconds(tracer[quality]));
    fflush(stdout);
    for (int quality = 0; quality < 2; quality++)
        embree_scene_destroy((EmbreeScene *)tracer[quality]);
    wall_triangles_free(&walls);
    enf_raycaster_destroy(r);
    ray_set_destroy(primary);
    ray_set_destroy(other);
    ray_set_destroy(scratch);
    picture_destroy(picture);
    free(table);
    return ok;
}

int enf_bench_raycast(int argc, char **argv) {
    static const char *const usual[] = {"office:46,windows=0,objects=0",
                                        "office:135,windows=0,objects=0",
                                        "office:1755,windows=0,objects=0",
                                        "columns:20",
                                        "ring:60",
                                        "facade:6"};
    const char *specs[MAX_SPECS], *csv_path = NULL;
    uint32_t count = 0;
    Options options = {1024, 6, 3, 1, 1, 1, NULL};
    for (int i = 1; i < argc; i++) {
        if (strncmp(argv[i], "--", 2) != 0) {
            if (count < MAX_SPECS)
                specs[count++] = argv[i];
            continue;
        }
        if (strcmp(argv[i], "--aligned") == 0 || strcmp(argv[i], "--turned") == 0) {
            options.aligned = argv[i][2] == 'a';
            options.turned = !options.aligned;
            continue;
        }
        if (i + 1 >= argc)
            return enf_tool_usage("bench raycast", "%s wants a value", argv[i]);
        if (strcmp(argv[i], "--size") == 0)
            options.size = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--cameras") == 0)
            options.cameras = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--repeats") == 0)
            options.repeats = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (strcmp(argv[i], "--csv") == 0)
            csv_path = argv[++i];
        else
            return enf_tool_usage("bench raycast", "no option %s", argv[i]);
    }
    if (options.size < 16 || options.size > 4096 || options.size % 16 || options.cameras == 0 || options.repeats == 0)
        return enf_tool_usage("bench raycast", "--size wants a multiple of 16 up to 4096, --cameras and --repeats more than 0");
    if (count == 0)
        for (; count < sizeof usual / sizeof *usual; count++)
            specs[count] = usual[count];
    if (csv_path && !(options.csv = fopen(csv_path, "w"))) {
        fprintf(stderr, "enfilade bench raycast: %s can't be written\n", csv_path);
        return ENF_EXIT_BAD_INPUT;
    }
    if (options.csv)
        fprintf(options.csv, "scene,rays,method,count,seconds,millions_a_second,times_best,times_one\n");
    if (embree_missing())
        printf("no anchor: %s\n", embree_missing());
    int ok = 1;
    for (uint32_t i = 0; i < count; i++) {
        EnfScene *scene = NULL, *turned = NULL;
        char name[160];
        if (!enf_bench_scene(argv[0], specs[i], &scene)) {
            ok = 0;
            continue;
        }
        const char *base = strrchr(specs[i], '/') ? strrchr(specs[i], '/') + 1 : specs[i];
        snprintf(name, sizeof name, "%.120s", base);
        for (char *at = name; *at; at++)
            *at = *at == ',' ? ' ' : *at; /* CSV */
        if (options.aligned)
            ok &= bench_scene(name, scene, &options);
        if (options.turned) {
            const Motion turn = {{{cos(0.3), -sin(0.3), 0}, {sin(0.3), cos(0.3), 0}, {0, 0, 1}}, 1, {0, 0, 0}};
            if ((turned = moved_scene(scene, &turn)) && enf_scene_commit(turned) == ENF_OK) {
                strcat(name, " turned");
                ok &= bench_scene(name, turned, &options);
            } else {
                fprintf(stderr, "enfilade bench raycast: %s turned: %s\n", specs[i], enf_last_error());
                ok = 0;
            }
        }
        enf_scene_destroy(turned);
        enf_scene_destroy(scene);
    }
    if (options.csv)
        fclose(options.csv);
    return ok ? ENF_EXIT_OK : ENF_EXIT_INTERNAL;
}
