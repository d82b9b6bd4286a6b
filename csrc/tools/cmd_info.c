/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade info: what a scene file holds, how degenerate it is, and what is wrong with it. */
#include "base/json_text.h"
#include "base/memory.h"
#include "base/timer.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/problems.h"
#include "scene/scene_data.h"
#include "tools/tool.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const severities[] = {"info", "warning", "error"};

/* What makes a scene hard for exact methods. */
typedef struct Shape {
    uint32_t components, largest, isolated; /* parts of the cell graph; its biggest, in cells; cells without portals */
    uint32_t most_portals;                  /* of one cell */
    double smallest_area, narrowest;        /* of a portal: m2, m */
    double worst_deviation;                 /* out of plane, m */
    uint32_t shared_planes;                 /* portals that lie in another's plane: doors in line, sills at one height */
} Shape;

static uint32_t find(uint32_t *parent, uint32_t c) {
    while (parent[c] != c)
        c = parent[c] = parent[parent[c]];
    return c;
}

static int measure_graph(const EnfScene *s, Shape *shape) {
    uint32_t *parent = ENF_NEW(uint32_t, s->cell_count), *size = ENF_NEW(uint32_t, s->cell_count);
    int ok = parent && size;
    for (uint32_t c = 0; c < s->cell_count && ok; c++)
        parent[c] = c;
    for (uint32_t p = 0; p < s->portal_count && ok; p++) {
        uint32_t a = find(parent, s->portal_cells[p][0]), b = find(parent, s->portal_cells[p][1]);
        parent[a > b ? a : b] = a > b ? b : a;
    }
    for (uint32_t c = 0; c < s->cell_count && ok; c++) {
        uint32_t portals = s->cell_portal_first[c + 1] - s->cell_portal_first[c], root = find(parent, c);
        shape->components += root == c;
        shape->isolated += portals == 0;
        shape->most_portals = portals > shape->most_portals ? portals : shape->most_portals;
        if (++size[root] > shape->largest)
            shape->largest = size[root];
    }
    enf_free(parent);
    enf_free(size);
    return ok;
}

static void measure_portals(const EnfScene *s, Shape *shape) {
    shape->smallest_area = shape->narrowest = INFINITY;
    for (uint32_t p = 0; p < s->portal_count; p++) {
        double(*v)[3] = s->portal_vertices + s->portal_vertex_first[p], n[3];
        uint32_t count = s->portal_vertex_first[p + 1] - s->portal_vertex_first[p];
        double area = enf_polygon_normal(n, v, count);
        shape->smallest_area = fmin(shape->smallest_area, area);
        shape->narrowest = fmin(shape->narrowest, area / (2.0 * s->portal_radii[p]));
        shape->worst_deviation = fmax(shape->worst_deviation, s->portal_deviation[p]);
    }
    /* In the plane of a portal of a neighbouring cell: the usual degeneracy, cheap to count. */
    for (uint32_t p = 0; p < s->portal_count; p++) {
        int shared = 0;
        for (int side = 0; side < 2 && !shared; side++) {
            uint32_t c = s->portal_cells[p][side], first = s->cell_portal_first[c], end = s->cell_portal_first[c + 1];
            if (end - first > 64)
                continue;
            for (uint32_t i = first; i < end && !shared; i++) {
                uint32_t q = s->cell_portals[i].portal;
                const EnfPlane *a = &s->portal_planes[p], *b = &s->portal_planes[q];
                double cosine = vec_dot(a->n, b->n);
                shared = q != p && fabs(cosine) > 1.0 - 1e-12 && fabs(a->d - (cosine > 0.0 ? b->d : -b->d)) <= s->tolerance;
            }
        }
        shape->shared_planes += (uint32_t)shared;
    }
}

static void print_json_problems(const EnfScene *scene) {
    printf("\"errors\": %llu, \"warnings\": %llu,\n \"problems\": [",
           (unsigned long long)(scene->problems ? scene->problems->error_count : 0),
           (unsigned long long)(scene->problems ? scene->problems->warning_count : 0));
    for (uint64_t i = 0; i < enf_scene_problem_count(scene); i++) {
        EnfProblem p;
        enf_scene_problem(scene, i, &p);
        printf("%s\n  {\"severity\": \"%s\", \"item\": \"%s\", \"index\": ", i ? "," : "", severities[p.severity], enf_item_word(p.item));
        if (p.index == ENF_NONE)
            printf("null");
        else
            printf("%u", p.index);
        printf(", \"code\": %u, \"position\": ", p.code);
        if (vec_finite(p.position))
            printf("[%.17g, %.17g, %.17g]", p.position[0], p.position[1], p.position[2]);
        else
            printf("null");
        printf(", \"message\": ");
        enf_json_put_string(stdout, p.message);
        putchar('}');
    }
    printf("]}\n");
}

static void print_json(const EnfScene *scene, const EnfSceneCounts *c, const Shape *shape, double seconds) {
    printf("{\"rooms\": %u, \"cells\": %u, \"portals\": %u, \"openings\": %u, \"objects\": %u, \"lights\": %u, "
           "\"cameras\": %u, \"seams\": %u, \"closed_portals\": %u,\n ",
           c->rooms, c->cells, c->portals, c->openings, c->objects, c->lights, c->cameras, c->seams, c->closed_portals);
    if (shape) {
        printf("\"extent\": %.17g, \"bounds\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g]], "
               "\"tolerance\": %.9g,\n "
               "\"components\": %u, \"largest_component\": %u, \"cells_without_portals\": %u, "
               "\"most_portals_of_a_cell\": %u, "
               "\"unplaced_objects\": %u,\n ",
               scene->extent, scene->bounds[0], scene->bounds[1], scene->bounds[2], scene->bounds[3], scene->bounds[4], scene->bounds[5],
               scene->tolerance, shape->components, shape->largest, shape->isolated, shape->most_portals, scene->unplaced_count);
        if (scene->portal_count)
            printf("\"smallest_portal_area\": %.9g, \"narrowest_portal\": %.9g, \"worst_deviation\": %.9g, "
                   "\"portals_in_a_shared_plane\": %u,\n ",
                   shape->smallest_area, shape->narrowest, shape->worst_deviation, shape->shared_planes);
    }
    printf("\"valid\": %s, \"seconds\": %.3f, \"peak_bytes\": %llu, ", shape ? "true" : "false", seconds,
           (unsigned long long)enf_peak_bytes());
    print_json_problems(scene);
}

static void print_text(const EnfScene *scene, const EnfSceneCounts *c, const Shape *shape, double seconds) {
    printf("rooms %u\ncells %u\nportals %u (seams %u, closed %u)\nopenings %u\nobjects %u\nlights "
           "%u\ncameras %u\n",
           c->rooms, c->cells, c->portals, c->seams, c->closed_portals, c->openings, c->objects, c->lights, c->cameras);
    if (shape) {
        printf("extent %.6g m, from (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g)\n", scene->extent, scene->bounds[0], scene->bounds[1],
               scene->bounds[2], scene->bounds[3], scene->bounds[4], scene->bounds[5]);
        printf("components %u (largest %u cells; %u cells without portals); at most %u portals a cell\n", shape->components, shape->largest,
               shape->isolated, shape->most_portals);
        if (scene->portal_count)
            printf("smallest portal %.4g m2, narrowest %.4g m, worst out of plane %.3g m; %u portals in a "
                   "neighbour's plane\n",
                   shape->smallest_area, shape->narrowest, shape->worst_deviation, shape->shared_planes);
        if (scene->object_count)
            printf("unplaced objects %u\n", scene->unplaced_count);
    }
    uint64_t count = enf_scene_problem_count(scene);
    printf("problems %llu (errors %llu, warnings %llu)\n", (unsigned long long)count,
           (unsigned long long)(scene->problems ? scene->problems->error_count : 0),
           (unsigned long long)(scene->problems ? scene->problems->warning_count : 0));
    for (uint64_t i = 0; i < count; i++) {
        EnfProblem p;
        enf_scene_problem(scene, i, &p);
        printf("  %-7s [%u] %s\n", severities[p.severity], p.code, p.message);
    }
    printf("read and checked in %.3f s, peak %.1f MB\n", seconds, (double)enf_peak_bytes() / 1e6);
}

int enf_cmd_info(int argc, char **argv) {
    const char *path = NULL;
    int json = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--json") == 0)
            json = 1;
        else if (argv[i][0] == '-' && argv[i][1])
            return enf_tool_usage("info", "unknown option %s", argv[i]);
        else if (path)
            return enf_tool_usage("info", "more than one scene");
        else
            path = argv[i];
    }
    if (!path)
        return enf_tool_usage("info", "no scene given");
    double start = enf_wall_seconds();
    EnfScene *scene = NULL;
    EnfStatus status = enf_scene_load(path, &scene);
    if (status != ENF_OK)
        return enf_tool_fail(status);
    status = enf_scene_commit(scene);
    double seconds = enf_wall_seconds() - start;
    EnfSceneCounts counts;
    enf_scene_counts(scene, &counts);
    Shape shape = {0}, *known = NULL;
    if (status == ENF_OK && measure_graph(scene, &shape)) {
        measure_portals(scene, &shape);
        known = &shape;
    }
    if (status == ENF_OK || status == ENF_ERROR_BAD_INPUT) {
        if (json)
            print_json(scene, &counts, known, seconds);
        else
            print_text(scene, &counts, known, seconds);
    }
    int code = status == ENF_OK ? ENF_EXIT_OK : enf_tool_fail(status);
    enf_scene_destroy(scene);
    return code;
}
