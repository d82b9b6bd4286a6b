/* SPDX-License-Identifier: GPL-3.0-or-later
 * What the subcommands share. */
#include "tools/tool.h"

#include <stdarg.h>
#include <stdio.h>

int enf_tool_fail(EnfStatus status) {
    fprintf(stderr, "enfilade: %s: %s\n", enf_status_string(status), enf_last_error());
    return status == ENF_ERROR_BAD_INPUT || status == ENF_ERROR_IO ? ENF_EXIT_BAD_INPUT
           : status == ENF_ERROR_INVALID_ARGUMENT                  ? ENF_EXIT_USAGE
                                                                   : ENF_EXIT_INTERNAL;
}

int enf_tool_usage(const char *command, const char *format, ...) {
    va_list args;
    fprintf(stderr, "enfilade %s: ", command);
    va_start(args, format);
    vfprintf(stderr, format, args);
    va_end(args);
    fprintf(stderr, " (enfilade --help)\n");
    return ENF_EXIT_USAGE;
}

int enf_tool_load(const char *path, EnfScene **out_scene, int *out_exit) {
    EnfScene *scene = NULL;
    EnfStatus status = enf_scene_load(path, &scene);
    if (status == ENF_OK)
        status = enf_scene_commit(scene);
    if (status != ENF_OK) {
        *out_exit = enf_tool_fail(status);
        enf_scene_destroy(scene);
        return 0;
    }
    uint64_t shown = 0, warnings = 0;
    for (uint64_t i = 0; i < enf_scene_problem_count(scene); i++) {
        EnfProblem problem;
        if (enf_scene_problem(scene, i, &problem) != ENF_OK || problem.severity < ENF_SEVERITY_WARNING)
            continue;
        warnings++;
        if (shown < 20) {
            fprintf(stderr, "enfilade: warning: %s\n", problem.message);
            shown++;
        }
    }
    if (warnings > shown)
        fprintf(stderr, "enfilade: %llu more warnings: see enfilade info\n", (unsigned long long)(warnings - shown));
    *out_scene = scene;
    return 1;
}
