/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade exterior: cuts the outdoors of a scene into cells round the building, and writes the scene. */
#include "tools/tool.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const outcomes[] = {"done", "no opening leads outdoors", "the exterior has cells already",
                                       "more than one exterior cell without geometry", "too complex: stays one cell"};

int enf_cmd_exterior(int argc, char **argv) {
    const char *paths[2] = {NULL, NULL};
    EnfExteriorDef def = enf_default_exterior_def();
    int count = 0;
    for (int i = 1; i < argc; i++) {
        double *value = strcmp(argv[i], "--wall") == 0     ? &def.wall_gap
                        : strcmp(argv[i], "--slab") == 0   ? &def.slab_gap
                        : strcmp(argv[i], "--margin") == 0 ? &def.margin
                                                           : NULL;
        char *end;
        if (value) {
            if (i + 1 >= argc)
                return enf_tool_usage("exterior", "%s wants metres", argv[i]);
            *value = strtod(argv[++i], &end);
            if (*end || end == argv[i] || !(*value >= 0.0))
                return enf_tool_usage("exterior", "%s wants metres, not %s", argv[i - 1], argv[i]);
        } else if (argv[i][0] == '-' && argv[i][1])
            return enf_tool_usage("exterior", "unknown option %s", argv[i]);
        else if (count == 2)
            return enf_tool_usage("exterior", "more than two files");
        else
            paths[count++] = argv[i];
    }
    if (count != 2)
        return enf_tool_usage("exterior", "wants SCENE and OUT.enf.json");
    EnfScene *scene = NULL;
    EnfExteriorReport report;
    report.struct_size = sizeof report;
    EnfStatus status = enf_scene_load(paths[0], &scene);
    if (status == ENF_OK)
        status = enf_scene_decompose_exterior(scene, &def, &report);
    if (status == ENF_OK)
        status = enf_scene_save_json(scene, paths[1]);
    enf_scene_destroy(scene);
    if (status != ENF_OK)
        return enf_tool_fail(status);
    printf("%s\ncells %u\nseams %u\nportals outdoors %u (split %u)\nwalls up to %.3f m, slabs up to %.3f m\nbodies %u, parts %u\n"
           "%.3f s\n",
           outcomes[report.outcome], report.cells, report.seams, report.portals, report.split, report.wall_gap, report.slab_gap,
           report.bodies, report.leaves, report.seconds);
    return ENF_EXIT_OK;
}
