/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench raycast: pictures and rays through cells beside a general ray tracer on the same walls, one thread, equal output checked
 * first. Ratios to the tracer's best mode are what counts; millions a second belong to the machine. */
#include "tools/bench.h"
#include "tools/bench_rays.h"
#include "tools/tool.h"

#include "base/timer.h"
#include "embree_modes.h"
#include "geometry/vec3.h"
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
    int aligned, turned;
    FILE *csv;
} Options;

typedef struct Row {
    const char *kind, *method;
    double seconds, count; /* best of all repeats, summed over cameras */
    double least;          /* this camera's best so far */
    double (*clock)(void); /* this thread's processor time: other work on the machine counts less; with threads, the wall */
} Row;

enum { KIND_PRIMARY, KIND_FACADE, KIND_RANDOM, KIND_BOUNCE, KIND_SHADOW, KINDS };
static const char *const kinds[KINDS] = {"primary", "facade", "random", "bounce", "shadow"};
static const char *const kind_threads = "threads", *const one_thread = "picture by spans, twice as wide and high",
                         *const two_threads = "by two threads";

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

/* By the wall's clock: needs two processors that nobody else uses. */
static void time_threads(Table *table, const EnfRaycaster *r, const EnfCamera *camera, const Options *options, Picture *large) {
    for (uint32_t repeat = 0; repeat < 8 * options->repeats; repeat++)
        for (uint32_t threads = 1; threads <= 2; threads++) {
            EnfRaycastImage image = picture_request(large, 0);
            image.threads = threads;
            TIMED(table, kind_threads, threads == 1 ? one_thread : two_threads, enf_raycast_image(r, camera, &image));
        }
    close_camera(table, kind_threads, (double)large->width * large->height);
}

static void time_pictures(Table *table, const char *kind, const EnfRaycaster *r, const EnfCamera *camera, const Options *options,
                          Picture *picture) {
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
            TIMED(table, kind, ways[i].name, enf_raycast_image(r, camera, &image));
            if (i == 0)
                TIMED(table, kind, "bound: memset of the outputs", picture_memset(picture));
        }
}

/* Theirs against ours. A different distance is a mismatch, unless both hit one surface so flatly that the rounding of its corners'
 * coordinates moves the hit so far. It is explained when the ray meets an edge so closely that both answers are found by rays a rounding
 * away; when theirs lies inside of another cell (cells overlap there: what is drawn into a room isn't its wall), or is the wall of a cell
 * that the ray never enters (cells overlap, or one ends in the plane of an open portal between two others); when the ray passes a portal
 * that lies off its cell; or when the reference in doubles sides with us (a crack in the triangles). Another name for the same distance is
 * explained when it is the back of the same wall: one without thickness has two faces, and ours is the one towards the ray. */
typedef struct Verdict {
    uint64_t rays, flat, mismatches, at_edges, overlaps, strangers, off_portals, ours, unexplained;
    uint64_t backs, names;
} Verdict;

static int alike(double a, double b) {
    return a == b || fabs(a - b) <= 1e-4 * fmax(fabs(a), 1e-2) + 2e-5;
}

static double speed_across(const EnfSurface *s, const RaySet *rays, uint64_t i) {
    return s->normal[0] * rays->d[0][i] + s->normal[1] * rays->d[1][i] + s->normal[2] * rays->d[2][i];
}

static int grazes(const EnfRaycaster *r, const RaySet *rays, uint64_t i, uint32_t surface, double apart) {
    EnfSurface s = enf_default_surface();
    double largest = 0;
    if (enf_raycaster_surface(r, surface, &s) != ENF_OK)
        return 0;
    for (int k = 0; k < 3; k++)
        largest = fmax(largest, fabs((double)rays->o[k][i]));
    return fabs(speed_across(&s, rays, i)) * apart <= 4 * 1.2e-7 * largest; /* two corners, each off by a rounding of its size */
}

/* Whether their hit is the back of ours. */
static int is_back(const EnfRaycaster *r, const RaySet *rays, uint64_t i, uint32_t named) {
    EnfSurface s = enf_default_surface();
    return named != ENF_NONE && enf_raycaster_surface(r, named, &s) == ENF_OK && s.kind == ENF_SURFACE_FACE &&
           speed_across(&s, rays, i) > 0;
}

/* Whether the point at `distance` lies well inside of a cell other than the one whose face is there. */
static int in_another_cell(const EnfRaycaster *r, const RaySet *rays, uint64_t i, double distance, uint32_t named) {
    const EnfScene *scene = r->scene;
    EnfSurface s = enf_default_surface();
    double at[3], local[3];
    uint32_t cells[32], count = 0;
    if (!(distance < INFINITY) || enf_raycaster_surface(r, named, &s) != ENF_OK)
        return 0;
    for (int k = 0; k < 3; k++) {
        local[k] = rays->o[k][i] + distance * rays->d[k][i];
        at[k] = local[k] + scene->origin[k];
    }
    if (enf_scene_locate(scene, at, cells, 32, &count) != ENF_OK)
        return 0;
    for (uint32_t c = 0; c < count && c < 32; c++) {
        double nearest = -INFINITY;
        for (uint32_t f = scene->cell_face_first[cells[c]]; f < scene->cell_face_first[cells[c] + 1]; f++)
            nearest = fmax(nearest, vec_dot(scene->face_planes[f].n, local) - scene->face_planes[f].d);
        if (cells[c] != s.cell && nearest < -1e-3)
            return 1;
    }
    return 0;
}

/* Whether the ray's way through the cells, in doubles, leads through the one that has this face; *off: whether it leaves a cell where it
 * came in, or before: the portal it came by lies off that cell. */
static int enters_cell_of(const EnfRaycaster *r, const RaySet *rays, uint64_t i, uint32_t named, int *off) {
    const double o[3] = {rays->o[0][i], rays->o[1][i], rays->o[2][i]}, d[3] = {rays->d[0][i], rays->d[1][i], rays->d[2][i]};
    EnfSurface s = enf_default_surface();
    int face = named != ENF_NONE && enf_raycaster_surface(r, named, &s) == ENF_OK && s.kind == ENF_SURFACE_FACE, enters = !face;
    double at = 0;
    *off = 0;
    for (uint32_t cell = rays->cell[i], left = enf_ray_cell_cap(r); cell < r->cell_count && left > 0; left--) {
        RayStep step = enf_ray_step(r, cell, o, d, at);
        enters |= face && cell == s.cell;
        *off |= at > 0 && step.at <= at;
        at = step.at;
        cell = step.to;
    }
    return enters;
}

static void judge(const EnfRaycaster *r, const RaySet *rays, const float *mine, const uint32_t *surface, const float *theirs,
                  const uint32_t *triangle, const WallTriangles *walls, Verdict *v) {
    double origin[3];
    enf_raycaster_origin(r, origin);
    v->rays += rays->count;
    for (uint64_t i = 0; i < rays->count; i++) {
        uint32_t named = triangle[i] == ENF_NONE ? ENF_NONE : walls->surfaces[triangle[i]];
        if (alike(mine[i], theirs[i])) {
            int back = surface[i] != named && is_back(r, rays, i, named);
            v->backs += back;
            v->names += surface[i] != named && !back;
            continue;
        }
        if (surface[i] == named && surface[i] != ENF_NONE && grazes(r, rays, i, surface[i], fabs((double)mine[i] - theirs[i]))) {
            v->flat++;
            continue;
        }
        v->mismatches++;
        int agrees[2] = {0, 0}, reference = 0, off;
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
        else if (in_another_cell(r, rays, i, theirs[i], named))
            v->overlaps++;
        else if (!enters_cell_of(r, rays, i, named, &off) && reference)
            v->strangers++;
        else if (off)
            v->off_portals++;
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
        if (row->kind == kind && (strncmp(row->method, "rtc", 3) == 0 || row->method == one_thread) && rate > best)
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

/* The scene in both tracers, and what is measured of it. */
typedef struct Bench {
    const EnfScene *scene;
    const Options *options;
    EnfRaycaster *r;
    WallTriangles walls;
    const EmbreeScene *tracer[2]; /* MEDIUM, HIGH; NULL: without */
    Table table;
    Verdict verdicts[KINDS];
    RaySet *primary, *other, *scratch;
    Picture *picture, *large;
    uint64_t patched, unwritten, differing, pictures;
    uint64_t walked, walked_apart;       /* rays asked of the reference in doubles too; those that end elsewhere there */
    uint64_t bytes, rays, hits, portals; /* of primary rays */
    double seconds;                      /* to link */
} Bench;

/* Every 61st ray by the reference: the same distance, and the same cell where it ends in nothing. */
static void compare_with_doubles(Bench *b, const RaySet *rays) {
    double origin[3];
    enf_raycaster_origin(b->r, origin);
    for (uint64_t i = 0; i < rays->count; i += 61) {
        EnfRay ray = {{0, 0, 0}, {rays->d[0][i], rays->d[1][i], rays->d[2][i]}, INFINITY, rays->cell[i], 0};
        EnfRayHit hit;
        for (int k = 0; k < 3; k++)
            ray.origin[k] = origin[k] + rays->o[k][i];
        enf_raycast_rays(b->r, &ray, 1, &hit);
        b->walked++;
        b->walked_apart += !alike(hit.distance, rays->distance[i]) ||
                           (hit.surface == ENF_NONE && rays->surface[i] == ENF_NONE && hit.cell != rays->hit_cell[i]);
    }
}

/* One kind of rays: compared, then timed. */
static void bench_rays(Bench *b, int kind, RaySet *rays) {
    int coherent = kind <= KIND_FACADE, any = kind == KIND_SHADOW;
    EnfRayBatch batch = ray_set_batch(rays);
    EnfRayHits out = enf_default_ray_hits();
    batch.method = coherent ? ENF_RAYS_PACKETS16 : ENF_RAYS_WAVES;
    out.distance = rays->distance;
    out.surface = rays->surface;
    out.cell = rays->hit_cell;
    out.portals = b->scratch->blocked;
    enf_raycast_closest(b->r, &batch, &out);
    if (coherent)
        for (uint64_t i = 0; i < rays->count; i++) {
            b->rays++;
            b->hits += rays->surface[i] != ENF_NONE;
            b->portals += b->scratch->blocked[i];
        }
    if (!any)
        compare_with_doubles(b, rays);
    if (b->tracer[1]) {
        EmbreeRays theirs = {rays->count, rays->o[0], rays->o[1], rays->o[2], rays->d[0], rays->d[1], rays->d[2], rays->limit};
        embree_closest(b->tracer[1], EMBREE_16, coherent, &theirs, b->scratch->distance, b->scratch->surface);
        judge(b->r, rays, rays->distance, rays->surface, b->scratch->distance, b->scratch->surface, &b->walls, &b->verdicts[kind]);
    }
    time_rays(&b->table, kinds[kind], b->r, b->tracer, rays, any, coherent || any, b->options->repeats, b->scratch);
}

/* What a camera sees, and what starts from there. 0: there is no place for it. */
static int bench_camera(Bench *b, int kind, uint64_t *rng) {
    const Options *options = b->options;
    EnfCamera camera;
    uint32_t start;
    if (!place_camera(b->scene, rng, kind == KIND_FACADE, &camera, &start))
        return 0;
    primary_rays(b->scene, b->r, &camera, start, options->size, b->primary);
    bench_rays(b, kind, b->primary);
    b->patched += picture_check(b->r, &camera, b->primary, b->picture, &b->unwritten, &b->differing);
    b->pictures++;
    time_pictures(&b->table, kinds[kind], b->r, &camera, options, b->picture);
    close_camera(&b->table, kinds[kind], (double)b->primary->count);
    if (kind == KIND_PRIMARY)
        time_threads(&b->table, b->r, &camera, options, b->large);
    if (kind == KIND_FACADE)
        return 1;
    random_rays(b->scene, b->r, rng, b->other);
    bench_rays(b, KIND_RANDOM, b->other);
    bounce_rays(b->scene, b->r, b->primary, rng, b->other);
    bench_rays(b, KIND_BOUNCE, b->other);
    shadow_rays(b->scene, b->r, b->primary, start, b->other);
    bench_rays(b, KIND_SHADOW, b->other);
    return 1;
}

static void print_scene(const Bench *b, const char *name) {
    const PrismModel *prisms = &b->r->prisms;
    double rays = fmax(1, (double)b->rays);
    printf("%s: %u cells, %u portals, %u triangles; simd %s; %.1f cells a primary ray, %.1f %% hit\n", name, b->scene->cell_count,
           b->scene->portal_count, b->walls.triangle_count, simd_names[bench_simd()], 1 + (double)b->portals / rays,
           100 * (double)b->hits / rays);
    printf("  %u cells are upright prisms, with %u sides and %u caps asked by planes; %u have no walls, %u another shape\n", prisms->prisms,
           prisms->open_sides, prisms->open_caps, prisms->unwalled, b->r->cell_count - prisms->prisms - prisms->unwalled);
    printf("  memory %.0f KiB, linked in %.2f ms", (double)b->bytes / 1024.0, 1e3 * b->seconds);
    for (int quality = 0; quality < 2; quality++)
        if (b->tracer[quality])
            printf("; Embree %s %.0f KiB (%.2f of it), %.2f ms", quality ? "HIGH" : "MEDIUM",
                   (double)embree_bytes(b->tracer[quality]) / 1024.0, (double)b->bytes / (double)embree_bytes(b->tracer[quality]),
                   1e3 * embree_build_seconds(b->tracer[quality]));
    printf("\n  pixels: %llu not written, %llu patched, pictures differ from rays in %llu of %llu\n", (unsigned long long)b->unwritten,
           (unsigned long long)b->patched, (unsigned long long)b->differing,
           (unsigned long long)(3 * b->pictures * b->options->size * b->options->size));
    printf("  %llu of %llu rays end elsewhere by the reference in doubles\n", (unsigned long long)b->walked_apart,
           (unsigned long long)b->walked);
    for (int k = 0; k < KINDS && b->tracer[1]; k++) {
        const Verdict *v = &b->verdicts[k];
        if (v->rays == 0)
            continue;
        printf("  %-9s mismatches %llu of %llu: %llu at an edge, %llu where cells overlap, %llu at walls of cells the ray never enters,\n"
               "            %llu through portals off their cells, %llu where doubles side with us, %llu unexplained; %llu moved along\n"
               "            one wall by rounding; same distance, other name: %llu the wall's back, %llu not\n",
               kinds[k], (unsigned long long)v->mismatches, (unsigned long long)v->rays, (unsigned long long)v->at_edges,
               (unsigned long long)v->overlaps, (unsigned long long)v->strangers, (unsigned long long)v->off_portals,
               (unsigned long long)v->ours, (unsigned long long)v->unexplained, (unsigned long long)v->flat, (unsigned long long)v->backs,
               (unsigned long long)v->names);
    }
}

static int bench_scene(const char *name, const EnfScene *scene, const Options *options) {
    uint64_t pixels = (uint64_t)options->size * options->size, rng = 1;
    Bench *b = calloc(1, sizeof *b);
    if (!b)
        return 0;
    b->scene = scene;
    b->options = options;
    b->primary = ray_set_create(pixels);
    b->other = ray_set_create(pixels);
    b->scratch = ray_set_create(pixels);
    b->picture = picture_create(options->size, options->size);
    b->large = picture_create(2 * options->size, 2 * options->size);
    uint64_t live = enf_live_bytes();
    double begin = enf_wall_seconds(), origin[3] = {0, 0, 0};
    int ok = b->primary && b->other && b->scratch && b->picture && b->large && enf_raycaster_create(scene, &b->r) == ENF_OK;
    b->seconds = enf_wall_seconds() - begin;
    b->bytes = enf_live_bytes() - live;
    enf_raycaster_origin(b->r, origin);
    if (ok && !embree_missing() && wall_triangles_make(scene, origin, &b->walls) && b->walls.triangle_count > 0)
        for (int quality = 0; quality < 2; quality++)
            b->tracer[quality] = embree_scene_create(&b->walls, quality);
    for (uint32_t c = 0; c < options->cameras && ok; c++) {
        int any = bench_camera(b, KIND_PRIMARY, &rng);
        if (!(any | bench_camera(b, KIND_FACADE, &rng)))
            break;
    }
    if (ok) {
        print_scene(b, name);
        printf("  %-9s %-36s %10s %9s %9s\n", "rays", "method", "M a second", "x best", "x one");
        for (int k = 0; k < KINDS; k++)
            print_kind(&b->table, kinds[k], name, options->csv);
        print_kind(&b->table, kind_threads, name, options->csv);
    }
    if (options->csv && ok)
        fprintf(options->csv, "%s,memory,cells,%llu,%.6f,,,\n", name, (unsigned long long)b->bytes, b->seconds);
    for (int quality = 0; quality < 2; quality++) {
        if (options->csv && b->tracer[quality])
            fprintf(options->csv, "%s,memory,Embree %s,%llu,%.6f,,,\n", name, quality ? "HIGH" : "MEDIUM",
                    (unsigned long long)embree_bytes(b->tracer[quality]), embree_build_seconds(b->tracer[quality]));
        embree_scene_destroy((EmbreeScene *)b->tracer[quality]);
    }
    fflush(stdout);
    wall_triangles_free(&b->walls);
    enf_raycaster_destroy(b->r);
    ray_set_destroy(b->primary);
    ray_set_destroy(b->other);
    ray_set_destroy(b->scratch);
    picture_destroy(b->picture);
    picture_destroy(b->large);
    free(b);
    return ok;
}

int enf_bench_raycast(int argc, char **argv) {
    static const char *const usual[] = {"office:46,windows=0,objects=0",
                                        "office:135,windows=0,objects=0",
                                        "office:1755,windows=0,objects=0",
                                        "office:46,objects=0",
                                        "office:1755,objects=0",
                                        "columns:20",
                                        "ring:60",
                                        "facade:6"};
    const char *specs[MAX_SPECS], *csv_path = NULL;
    uint32_t count = 0;
    Options options = {1024, 6, 3, 1, 1, NULL};
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
