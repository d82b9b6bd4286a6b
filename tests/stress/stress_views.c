/* SPDX-License-Identifier: GPL-3.0-or-later
 * The search for the dearest camera: scenes of every family at random sizes, cameras of every kind in them, and then those that
 * cost most changed a little at a time while they cost more.
 *
 *   stress_views [--scenes N] [--steps N] [--seed S] [--large] [--scene SPEC]
 *
 * Cost is EnfViewStats.work, the same on every machine; it must stay within the budget. Microseconds are printed beside it, to see
 * that they follow. --large: up to a million cells, portals, objects. Exit code 1: some query did more work than the budget and what
 * one step may add. */
#include "enfilade/enfilade.h"
#include "level_camera.h"
#include "scene/scene_data.h"
#include "scene_family.h"
#include "sight_walker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The default budget; what is done between two looks at it is one portal with all its apertures, or one cell's objects. */
enum { BUDGET = 2100000, STEP = 100000 };

/* A query: how it is asked and from where. Kinds: one camera, a stereo pair, a shutter interval of four poses, a box to stand in. */
enum { ALONE, PAIR, SWEPT, REGION, KINDS };
typedef struct Question {
    uint32_t kind, method, occluders, apertures;
    EnfCamera camera;
    double reach; /* metres: from eye to eye, of the way, of the box */
} Question;
typedef struct Seen { /* one of the queries */
    uint64_t work;
    double microseconds;
    Question question;
} Seen;
typedef struct Worst {
    Seen dearest, slowest;
    double first, read, grouped; /* microseconds: on memory that nobody touched before */
    uint32_t asked, over;
} Worst;

static uint32_t below(SightRng *rng, uint32_t n) {
    return (uint32_t)(sight_next(rng) % n);
}
/* As likely small as large. */
static uint32_t any_size(SightRng *rng, double least, double most) {
    return (uint32_t)(least * pow(most / least, sight_unit(rng)));
}

static void any_scene(SightRng *rng, int large, char spec[96]) {
    static const struct {
        const char *form;
        double least, most, largest;
    } families[] = {
        {"grid:%u,objects=%u", 4, 60, 800},
        {"grid:%u,storeys=20", 3, 12, 180},
        {"columns:%u,objects=%u", 4, 40, 300},
        {"ring:%u", 4, 400, 20000},
        {"hub:%u,objects=%u", 4, 1500, 250000},
        {"enfilade:%u", 4, 200, 20000},
        {"tower:%u", 2, 60, 3000},
        {"tower:%u,windows=1", 2, 20, 80},
        {"court:%u", 3, 8, 20},
        {"town:%u,objects=%u", 2, 6, 24},
        {"city:%u,occluders=1", 2, 10, 60},
        {"facade:%u", 2, 12, 150},
        {"office:%u,objects=%u", 20, 300, 6000},
        {"office:%u,windows=0,objects=%u,occluders=1", 20, 300, 100000},
        {"brick:%u", 4, 40, 500},
        {"slits:%u", 4, 40, 400},
        {"spiral:%u", 4, 40, 300},
        {"comb:%u", 4, 300, 50000},
        {"screens:%u,detail=%u", 2, 8, 40},
        {"rings:%u,detail=%u", 2, 20, 300},
        {"lace:%u,detail=%u", 2, 8, 60},
        {"star:%u,detail=%u", 3, 200, 20000},
        {"cuts:%u", 4, 120, 2500},
        {"pile:%u,detail=%u", 100, 20000, 8000000},
        {"litter:%u", 100, 20000, 8000000},
    };
    uint32_t k = below(rng, sizeof families / sizeof *families),
             size = any_size(rng, families[k].least, large ? families[k].largest : families[k].most);
    uint32_t detail = any_size(rng, 2, strstr(families[k].form, "screens") ? (large ? 300 : 40) : large ? 60 : 24);
    if (strstr(families[k].form, "rings"))
        detail += 2;
    snprintf(spec, 96, families[k].form, size, detail);
}

static void any_camera(SightRng *rng, const EnfScene *scene, const SightWalker *walker, Question *q) {
    double eye[3] = {0, 0, 0};
    memset(q, 0, sizeof *q);
    for (int tries = 0; tries < 100; tries++)
        if (sight_point_in_cell(walker, rng, below(rng, 4) ? below(rng, scene->cell_count) : 0, below(rng, 4) == 0, eye))
            break;
    q->camera = level_camera(eye, 6.283185307179586 * sight_unit(rng), 3 * sight_unit(rng) - 1.5);
    q->method = below(rng, 4) ? ENF_VIEW_CLIP : ENF_VIEW_BOX;
    q->kind = below(rng, 2) ? ALONE : below(rng, KINDS);
    q->occluders = scene->occluder_count ? below(rng, 3) : 0;
    q->apertures = 1 + below(rng, 8);
    q->reach = pow(10, 2 * sight_unit(rng) - 2);
    switch (below(rng, 4)) {
    case 0:
        q->camera.type = ENF_CAMERA_PANO;
        q->camera.angle_x = 6.283185307179586;
        q->camera.angle_y = 3.141592653589793;
        break;
    case 1:
        q->camera.type = ENF_CAMERA_ORTHO;
        q->camera.ortho_width = q->camera.ortho_height = scene->extent * sight_unit(rng) + 1e-3;
        break;
    default:
        q->camera.angle_x = pow(10, -2.5 * sight_unit(rng)) * 3;
        q->camera.angle_y = 0.7 * q->camera.angle_x;
    }
    q->camera.clip_near = below(rng, 3) ? 0 : 0.1 + sight_unit(rng);
}

/* A little elsewhere, turned a little, wider or narrower. */
static void change_camera(SightRng *rng, const EnfScene *scene, Question *q) {
    double *m = q->camera.world_from_camera, size = scene->extent * pow(10, -4 * sight_unit(rng) - 0.5), eye[3];
    for (int c = 0; c < 3; c++)
        eye[c] = m[4 * c + 3] + size * (sight_unit(rng) - 0.5);
    double yaw = atan2(-m[6], -m[2]) + 0.5 * (sight_unit(rng) - 0.5),
           pitch = asin(fmax(-1, fmin(1, -m[10]))) + 0.3 * (sight_unit(rng) - 0.5);
    EnfCamera turned = level_camera(eye, yaw, pitch);
    memcpy(m, turned.world_from_camera, sizeof turned.world_from_camera);
    double wider = pow(2, sight_unit(rng) - 0.5);
    if (q->camera.type == ENF_CAMERA_PERSP) {
        q->camera.angle_x = fmin(3, q->camera.angle_x * wider);
        q->camera.angle_y = fmin(3, q->camera.angle_y * wider);
    } else if (q->camera.type == ENF_CAMERA_ORTHO)
        q->camera.ortho_width *= wider;
    q->reach *= wider;
    if (below(rng, 8) == 0)
        q->apertures = 1 + below(rng, 8);
    if (below(rng, 8) == 0)
        q->kind = below(rng, KINDS);
}

static EnfStatus ask(EnfView *view, const Question *q, EnfViewStats *stats) {
    EnfViewDef def = enf_default_view_def();
    EnfCamera poses[4];
    const double *m = q->camera.world_from_camera;
    EnfStatus status;
    def.method = q->method;
    def.occluders = q->occluders;
    def.max_apertures = q->apertures;
    for (int k = 0; k < 4; k++) {
        poses[k] = q->camera;
        for (int c = 0; c < 3; c++)
            poses[k].world_from_camera[4 * c + 3] += (k / 3.0 - 0.5) * q->reach * m[4 * c];
    }
    double box[6] = {m[3] - q->reach, m[7] - q->reach, m[11] - q->reach, m[3] + q->reach, m[7] + q->reach, m[11] + q->reach};
    if (q->kind == PAIR) {
        poses[1] = poses[3];
        status = enf_view_query_union(view, poses, 2, 0, &def);
    } else if (q->kind == SWEPT)
        status = enf_view_query_union(view, poses, 4, 1, &def);
    else if (q->kind == REGION)
        status = enf_view_query_region(view, box, q->camera.type == ENF_CAMERA_PERSP ? &q->camera : NULL, &def);
    else
        status = enf_view_query(view, &q->camera, &def);
    *stats = enf_default_view_stats();
    return status == ENF_OK ? enf_view_stats(view, stats) : status;
}

static double since(clock_t begin) {
    return 1e6 * (double)(clock() - begin) / CLOCKS_PER_SEC;
}

/* Of the processor: others may be at work on the machine. */
static double ask_timed(EnfView *view, const Question *q, EnfViewStats *stats, EnfStatus *out_status) {
    clock_t begin = clock();
    *out_status = ask(view, q, stats);
    return since(begin);
}

/* Two questions of a new view each, and what changed between them and the groups read: the first time memory is made. */
static void ask_anew(const EnfView *view, const Question *q, Worst *worst) {
    EnfView *fresh = NULL;
    EnfViewStats stats;
    EnfStatus status = enf_view_create_shared(view, &fresh);
    Question other = *q;
    other.kind = q->kind == ALONE ? PAIR : ALONE;
    for (int k = 0; k < 2 && status == ENF_OK; k++) {
        EnfViewResult result = enf_default_view_result();
        uint32_t groups;
        const uint32_t *lists[3];
        worst->first = fmax(worst->first, ask_timed(fresh, k ? &other : q, &stats, &status));
        if (status != ENF_OK)
            break;
        clock_t begin = clock();
        status = enf_view_result(fresh, &result);
        worst->read = fmax(worst->read, since(begin));
        begin = clock();
        if (status == ENF_OK)
            status = enf_view_groups(fresh, &groups, &lists[0], &lists[1], &lists[2]);
        worst->grouped = fmax(worst->grouped, since(begin));
    }
    enf_view_destroy(fresh);
}

/* 0: it can't be asked. Asked again when it is slow: others may have been at work. */
static int try_question(EnfView *view, const Question *q, Worst *worst, uint64_t *out_work) {
    EnfViewStats stats;
    EnfStatus status;
    Seen seen = {0, ask_timed(view, q, &stats, &status), *q};
    if (status != ENF_OK)
        return 0;
    for (int again = 0; again < 3 && seen.microseconds > 0.8 * worst->slowest.microseconds; again++)
        seen.microseconds = fmin(seen.microseconds, ask_timed(view, q, &stats, &status));
    worst->asked++;
    worst->over += stats.budget_hit != 0;
    *out_work = seen.work = stats.work;
    if (seen.microseconds > worst->slowest.microseconds)
        worst->slowest = seen;
    if (seen.work > worst->dearest.work)
        worst->dearest = seen;
    return 1;
}

static void print_seen(const char *what, const Seen *seen) {
    static const char *const kinds[] = {"alone", "pair", "swept", "region"}, *const types[] = {"persp", "ortho", "pano"};
    printf("; %s %8llu work, %7.0f us (%s, %s, %s, %u)", what, (unsigned long long)seen->work, seen->microseconds,
           kinds[seen->question.kind], seen->question.method == ENF_VIEW_CLIP ? "clip" : "box", types[seen->question.camera.type],
           seen->question.apertures);
}

static void print_fresh(const Worst *worst) {
    printf("; of a new view: first %.0f, changes %.0f, groups %.0f us", worst->first, worst->read, worst->grouped);
}

static int search(const char *spec, SightRng *rng, uint32_t steps, Worst *most) {
    EnfScene *scene = NULL;
    EnfView *view = NULL;
    Worst worst;
    memset(&worst, 0, sizeof worst);
    if (enf_family_build(spec, &scene) != ENF_OK || enf_scene_commit(scene) != ENF_OK || enf_view_create(scene, &view) != ENF_OK) {
        fprintf(stderr, "stress_views: %s: %s\n", spec, enf_last_error());
        enf_scene_destroy(scene);
        return 0;
    }
    SightWalker *walker = sight_walker_create(scene);
    Question now, next;
    uint64_t cost = 0, work;
    for (uint32_t k = 0; k < steps; k++) { /* a fifth of the way anywhere, then uphill from the dearest, now and then anew */
        int fresh = k < steps / 5 || below(rng, 8) == 0;
        if (fresh)
            any_camera(rng, scene, walker, &next);
        else {
            next = below(rng, 3) ? worst.dearest.question : now;
            change_camera(rng, scene, &next);
        }
        if (try_question(view, &next, &worst, &work) && (work >= cost || k == 0)) {
            cost = work;
            now = next;
        }
    }
    printf("%-44s %8u cells %8u portals %8u objects", spec, scene->cell_count, scene->portal_count, scene->object_count);
    print_seen("dearest", &worst.dearest);
    print_seen("slowest", &worst.slowest);
    ask_anew(view, &worst.dearest.question, &worst);
    ask_anew(view, &worst.slowest.question, &worst);
    print_fresh(&worst);
    printf("; out of budget %u of %u\n", worst.over, worst.asked);
    fflush(stdout);
    most->asked += worst.asked;
    most->over += worst.over;
    most->first = fmax(most->first, worst.first);
    most->read = fmax(most->read, worst.read);
    most->grouped = fmax(most->grouped, worst.grouped);
    if (worst.dearest.work > most->dearest.work)
        most->dearest = worst.dearest;
    if (worst.slowest.microseconds > most->slowest.microseconds)
        most->slowest = worst.slowest;
    sight_walker_destroy(walker);
    enf_view_destroy(view);
    enf_scene_destroy(scene);
    return 1;
}

int main(int argc, char **argv) {
    uint32_t scenes = 60, steps = 150;
    int large = 0, ok = 1;
    const char *only = NULL;
    SightRng rng = {1};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--large") == 0)
            large = 1;
        else if (i + 1 < argc && strcmp(argv[i], "--scenes") == 0)
            scenes = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (i + 1 < argc && strcmp(argv[i], "--steps") == 0)
            steps = (uint32_t)strtoul(argv[++i], NULL, 10);
        else if (i + 1 < argc && strcmp(argv[i], "--seed") == 0)
            rng.state = strtoull(argv[++i], NULL, 10);
        else if (i + 1 < argc && strcmp(argv[i], "--scene") == 0)
            only = argv[++i];
        else {
            fprintf(stderr, "stress_views [--scenes N] [--steps N] [--seed S] [--large] [--scene SPEC]\n");
            return 2;
        }
    }
    Worst most;
    memset(&most, 0, sizeof most);
    for (uint32_t k = 0; k < scenes; k++) {
        char spec[96];
        any_scene(&rng, large, spec);
        ok &= search(only ? only : spec, &rng, steps, &most);
    }
    printf("%u queries, out of budget %u", most.asked, most.over);
    print_seen("dearest", &most.dearest);
    print_seen("slowest", &most.slowest);
    print_fresh(&most);
    printf("\n");
    if (most.dearest.work > BUDGET + STEP) {
        printf("more than the budget of %d\n", BUDGET);
        ok = 0;
    }
    return ok ? 0 : 1;
}
