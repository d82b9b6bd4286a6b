/* SPDX-License-Identifier: GPL-3.0-or-later
 * The benchmarks behind `enfilade bench`; argv[0] is the benchmark's name, the return value an exit code of tool.h. */
#ifndef ENF_TOOLS_BENCH_H
#define ENF_TOOLS_BENCH_H

#include "enfilade/enfilade.h"

/* A committed scene: of a family ("office:46,windows=0", see generate) or of a file. On failure 0, told on stderr; `bench` is the name
 * to tell it by. */
int enf_bench_scene(const char *bench, const char *spec, EnfScene **out_scene);

int enf_bench_view(int argc, char **argv);
int enf_bench_pvs(int argc, char **argv);
int enf_bench_chains(int argc, char **argv);
int enf_bench_lights(int argc, char **argv);
int enf_bench_raycast(int argc, char **argv);

#endif
