/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade info: what a scene file holds and what is wrong with it. */
#include "tools/tool.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const severities[] = {"info", "warning", "error"};
static const char *const items[] = {"scene", "room", "cell", "portal", "opening", "object", "light", "camera"};

static void print_json(const EnfScene *scene, const EnfSceneCounts *counts) {
    printf("{\"rooms\": %u, \"cells\": %u, \"portals\": %u, \"openings\": %u, \"objects\": %u, \"lights\": %u, "
           "\"cameras\": %u, \"seams\": %u, \"closed_portals\": %u,\n \"problems\": [",
           counts->rooms, counts->cells, counts->portals, counts->openings, counts->objects, counts->lights,
           counts->cameras, counts->seams, counts->closed_portals);
    for (uint64_t i = 0; i < enf_scene_problem_count(scene); i++) {
        EnfProblem p;
        enf_scene_problem(scene, i, &p);
        printf("%s\n  {\"severity\": \"%s\", \"item\": \"%s\", \"index\": ", i ? "," : "", severities[p.severity], items[p.item]);
        if (p.index == ENF_NONE)
            printf("null");
        else
            printf("%u", p.index);
        printf(", \"code\": %u, \"position\": ", p.code);
        if (isfinite(p.position[0]))
            printf("[%.9g, %.9g, %.9g]", p.position[0], p.position[1], p.position[2]);
        else
            printf("null");
        printf(", \"message\": ");
        enf_tool_json_string(p.message);
        putchar('}');
    }
    printf("]}\n");
}

static void print_text(const EnfScene *scene, const EnfSceneCounts *c) {
    printf("rooms %u\ncells %u\nportals %u (seams %u, closed %u)\nopenings %u\nobjects %u\nlights %u\ncameras %u\n", c->rooms,
           c->cells, c->portals, c->seams, c->closed_portals, c->openings, c->objects, c->lights, c->cameras);
    uint64_t count = enf_scene_problem_count(scene);
    printf("problems %llu\n", (unsigned long long)count);
    for (uint64_t i = 0; i < count; i++) {
        EnfProblem p;
        enf_scene_problem(scene, i, &p);
        printf("  %-7s [%u] %s\n", severities[p.severity], p.code, p.message);
    }
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
    EnfScene *scene = NULL;
    EnfStatus status = enf_scene_load(path, &scene);
    if (status != ENF_OK)
        return enf_tool_fail(status);
    status = enf_scene_commit(scene);
    EnfSceneCounts counts;
    enf_scene_counts(scene, &counts);
    if (status == ENF_OK || status == ENF_ERROR_BAD_INPUT) {
        if (json)
            print_json(scene, &counts);
        else
            print_text(scene, &counts);
    }
    int code = status == ENF_OK ? ENF_EXIT_OK : enf_tool_fail(status);
    enf_scene_destroy(scene);
    return code;
}
