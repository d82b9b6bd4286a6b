/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench: finds the benchmark and hands over, and the scenes they take. One line a benchmark; each lives in bench_<name>.c. */
#include "tools/bench.h"
#include "tools/tool.h"

#include "scene_family.h"

#include <stdio.h>
#include <string.h>

typedef struct Benchmark {
    const char *name;
    int (*run)(int argc, char **argv); /* argv[0] is the benchmark's name */
    const char *help;
} Benchmark;

static const Benchmark benchmarks[] = {
    {"view", enf_bench_view,
     "view [SCENE|FAMILY:N ...] [--usual] [--outdoors] [--queries N] [--truths N] [--csv FILE]   camera to cells and objects"},
    {"pvs", enf_bench_pvs, "pvs SCENE ... [--peer NAME=COMMAND] [--csv FILE]       cells that see cells: time against error"},
    {"chains", enf_bench_chains, "chains [--count N] [--peer NAME=COMMAND] [--csv FILE]   one chain of portals at a time"},
    {"lights", enf_bench_lights, "lights [--size N] [--pictures N] [--threads N] [--csv FILE]  direct light with and without light sets"},
    {"raycast", enf_bench_raycast,
     "raycast [SCENE|FAMILY:N ...] [--aligned|--turned] [--size PIXELS] [--cameras N] [--repeats N] [--csv FILE]\n"
     "                                                         rays and pictures beside a general ray tracer;\n"
     "                                                         IFC models through tests/bench/ifc_scene.py; portal files without it"},
};
enum { BENCHMARK_COUNT = sizeof benchmarks / sizeof *benchmarks };

int enf_bench_scene(const char *bench, const char *spec, EnfScene **out_scene) {
    int code;
    if (!strchr(spec, ':') || strstr(spec, ".json") || strstr(spec, ".prt"))
        return enf_tool_load(spec, out_scene, &code);
    if (enf_family_build(spec, out_scene) != ENF_OK || enf_scene_commit(*out_scene) != ENF_OK) {
        fprintf(stderr, "enfilade bench %s: %s: %s\n", bench, spec, enf_last_error());
        return 0;
    }
    return 1;
}

int enf_cmd_bench(int argc, char **argv) {
    for (int i = 0; argc > 1 && i < BENCHMARK_COUNT; i++)
        if (strcmp(argv[1], benchmarks[i].name) == 0)
            return benchmarks[i].run(argc - 1, argv + 1);
    int asked = argc > 1 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0);
    FILE *out = asked ? stdout : stderr;
    for (int i = 0; i < BENCHMARK_COUNT; i++)
        fprintf(out, "  enfilade bench %s\n", benchmarks[i].help);
    return asked ? ENF_EXIT_OK : ENF_EXIT_USAGE;
}
