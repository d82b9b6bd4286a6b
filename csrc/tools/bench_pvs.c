/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench pvs: run time against error of the from-region methods, with a peer beside them when one is given. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/timer.h"
#include "tools/bench.h"
#include "tools/tool.h"

static const char *const help_text =
    "enfilade bench pvs SCENE ... [--peer NAME=COMMAND] [--threads N] [--csv FILE]\n"
    "  Methods sample (several efforts), flow and exact on each scene; missed and surplus are ordered pairs against what\n"
    "  exact proved and left. {} in COMMAND stands for the scene; the peer's time is its wall clock.\n";

typedef struct Row {
    const char *scene, *method;
    double effort;
    EnfRegionVisStats stats;
    uint64_t missed, surplus;
} Row;

typedef struct Method {
    uint32_t method;
    const char *name;
    double effort;
} Method;

static const Method methods[] = {
    {ENF_REGION_EXACT, "exact", 0},   {ENF_REGION_FLOW, "flow", 0},     {ENF_REGION_SAMPLE, "sample", 0.25},
    {ENF_REGION_SAMPLE, "sample", 1}, {ENF_REGION_SAMPLE, "sample", 4}, {ENF_REGION_SAMPLE, "sample", 16},
};
enum { METHOD_COUNT = sizeof methods / sizeof *methods };

/* Ordered pairs in the rows of a but not of b; with proven set, only those a proved. */
static uint64_t pairs_without(const EnfRegionVis *a, const EnfRegionVis *b, int proven) {
    const uint64_t *fa = enf_region_vis_row_first(a), *fb = enf_region_vis_row_first(b);
    const uint32_t *ca = enf_region_vis_row_cells(a), *cb = enf_region_vis_row_cells(b);
    const uint8_t *sa = enf_region_vis_row_status(a);
    uint64_t count = 0;
    for (uint32_t i = 0; i < enf_region_vis_cell_count(a); i++) {
        uint64_t k = fb[i];
        for (uint64_t j = fa[i]; j < fa[i + 1]; j++) {
            while (k < fb[i + 1] && cb[k] < ca[j])
                k++;
            count += !(k < fb[i + 1] && cb[k] == ca[j]) && (!proven || sa[j] == ENF_PAIR_VISIBLE);
        }
    }
    return count;
}

static void print_row(FILE *out, const Row *r, int csv) {
    const EnfRegionVisStats *s = &r->stats;
    fprintf(out,
            csv ? "%s,%s,%g,%.6f,%.6f,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu\n"
                : "%-24s %-7s %6g %9.4f %9.4f %10llu %10llu %6llu %6llu %7llu %7llu %10llu %9llu %8llu\n",
            r->scene, r->method, r->effort, s->wall_s, s->cpu_s, (unsigned long long)s->visible_pairs, (unsigned long long)s->proven_pairs,
            (unsigned long long)s->grazing_pairs, (unsigned long long)s->undecided_pairs, (unsigned long long)r->missed,
            (unsigned long long)r->surplus, (unsigned long long)s->peak_bytes, (unsigned long long)s->chains,
            (unsigned long long)s->line_tests);
}

static void run_peer(const char *peer, const char *scene, FILE *csv) {
    const char *command = strchr(peer, '='), *hole = command ? strstr(command, "{}") : NULL;
    if (!command)
        return;
    command++;
    char *line = malloc(strlen(command) + strlen(scene) + 8);
    if (!line)
        return;
    if (hole)
        sprintf(line, "%.*s%s%s", (int)(hole - command), command, scene, hole + 2);
    else
        sprintf(line, "%s %s", command, scene);
    fflush(stdout);
    double start = enf_wall_seconds();
    int code = system(line);
    double wall = enf_wall_seconds() - start;
    printf("%-24s %-7.*s %6s %9.4f %9s (exit code %d)\n", scene, (int)(command - 1 - peer), peer, "", wall, "", code);
    if (csv)
        fprintf(csv, "%s,%.*s,,%.6f,,,,,,,,,,\n", scene, (int)(command - 1 - peer), peer, wall);
    free(line);
}

static int bench_scene(const char *path, uint32_t threads, FILE *csv) {
    EnfScene *scene = NULL;
    EnfRegionVis *exact = NULL;
    int code = ENF_EXIT_OK;
    if (!enf_tool_load(path, &scene, &code))
        return code;
    for (int k = 0; k < METHOD_COUNT && code == ENF_EXIT_OK; k++) {
        EnfRegionVisDef def = enf_default_region_vis_def();
        EnfRegionVis *result = NULL;
        Row row = {.scene = path, .method = methods[k].name, .effort = methods[k].effort};
        const char *slash = strrchr(path, '/');
        if (slash)
            row.scene = slash + 1;
        def.method = methods[k].method, def.threads = threads;
        if (methods[k].effort > 0)
            def.sample_effort = methods[k].effort;
        row.stats = enf_default_region_vis_stats();
        EnfStatus status = enf_region_vis_run(scene, &def, &result);
        if (status == ENF_OK)
            status = enf_region_vis_stats(result, &row.stats);
        if (status != ENF_OK) {
            code = enf_tool_fail(status);
            break;
        }
        if (!exact)
            exact = result;
        row.missed = pairs_without(exact, result, 1), row.surplus = pairs_without(result, exact, 0);
        print_row(stdout, &row, 0);
        if (csv)
            print_row(csv, &row, 1);
        if (result != exact)
            enf_region_vis_destroy(result);
    }
    enf_region_vis_destroy(exact);
    enf_scene_destroy(scene);
    return code;
}

int enf_bench_pvs(int argc, char **argv) {
    const char *peer = NULL, *csv_path = NULL;
    uint32_t threads = 1;
    int scenes = 0, code = ENF_EXIT_OK;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h")) {
            fputs(help_text, stdout);
            return ENF_EXIT_OK;
        }
        if (argv[i][0] != '-') {
            argv[1 + scenes++] = argv[i];
            continue;
        }
        if (i + 1 >= argc)
            return enf_tool_usage("bench pvs", "%s needs a value", argv[i]);
        if (!strcmp(argv[i], "--peer"))
            peer = argv[++i];
        else if (!strcmp(argv[i], "--csv"))
            csv_path = argv[++i];
        else if (!strcmp(argv[i], "--threads"))
            threads = (uint32_t)strtoul(argv[++i], NULL, 10);
        else
            return enf_tool_usage("bench pvs", "unknown option %s", argv[i]);
    }
    if (!scenes)
        return enf_tool_usage("bench pvs", "no scene given");
    if (peer && !strchr(peer, '='))
        return enf_tool_usage("bench pvs", "--peer wants NAME=COMMAND, got \"%s\"", peer);
    FILE *csv = csv_path ? fopen(csv_path, "wb") : NULL;
    if (csv_path && !csv)
        return enf_tool_usage("bench pvs", "%s can't be written", csv_path);
    printf("%-24s %-7s %6s %9s %9s %10s %10s %6s %6s %7s %7s %10s %9s %8s\n", "scene", "method", "effort", "wall s", "cpu s", "visible",
           "proven", "graz", "undec", "missed", "surplus", "peak B", "chains", "tests");
    if (csv)
        fprintf(csv, "scene,method,effort,wall_s,cpu_s,visible,proven,grazing,undecided,missed,surplus,peak_bytes,"
                     "chains,line_tests\n");
    for (int i = 1; i <= scenes && code == ENF_EXIT_OK; i++) {
        code = bench_scene(argv[i], threads, csv);
        if (peer && code == ENF_EXIT_OK)
            run_peer(peer, argv[i], csv);
    }
    if (csv && fclose(csv) != 0)
        code = ENF_EXIT_INTERNAL;
    return code;
}
