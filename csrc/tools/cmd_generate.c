/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade generate: writes a scene of one of the families that tests and benchmarks use. */
#include "scene_family.h"
#include "tools/tool.h"

#include <stdio.h>
#include <string.h>

int enf_cmd_generate(int argc, char **argv) {
    if (argc == 2 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)) {
        fputs(enf_family_help(), stdout);
        return ENF_EXIT_OK;
    }
    if (argc != 3)
        return enf_tool_usage("generate", "wants FAMILY:N and a file; enfilade generate --help lists the families");
    EnfScene *scene;
    EnfStatus status = enf_family_build(argv[1], &scene);
    if (status == ENF_ERROR_INVALID_ARGUMENT)
        return enf_tool_usage("generate", "no family \"%s\"; they are\n%s", argv[1], enf_family_help());
    if (status != ENF_OK)
        return enf_tool_fail(status);
    status = enf_scene_save_json(scene, argv[2]);
    enf_scene_destroy(scene);
    return status == ENF_OK ? ENF_EXIT_OK : enf_tool_fail(status);
}
