/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench view. */
#include "tools/bench.h"
#include "tools/tool.h"

int enf_bench_view(int argc, char **argv) {
    (void)argc;
    (void)argv;
    return enf_tool_usage("bench view", "not there yet");
}
