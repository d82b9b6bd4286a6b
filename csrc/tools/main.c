/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade: the command line tool. Finds the subcommand and hands over. */
#include "tools/tool.h"

#include <stdio.h>
#include <string.h>

typedef struct Command {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *help;
} Command;

/* One line a subcommand; each lives in cmd_<name>.c and is declared in tool.h. */
static const Command commands[] = {
    {"info", enf_cmd_info, "info SCENE [--json]             counts, and problems with their index"},
    {"pvs", enf_cmd_pvs, "pvs SCENE [options]             which cells see which, from anywhere inside them"},
    {"view", enf_cmd_view,
     "view SCENE (--camera NAME | --eye X,Y,Z --look X,Y,Z --fov DEG --aspect A)\n"
     "                [--method frustum|box|clip] [--occluders off|on|auto] [--outdoors auto|exact|sweep] [--json FILE]\n"
     "                                                            what a camera sees"},
    {"exterior", enf_cmd_exterior,
     "exterior SCENE OUT.enf.json [--wall M] [--slab M] [--margin M]  the outdoors cut into cells round the building"},
    {"generate", enf_cmd_generate, "generate FAMILY:N[,key=value ...] FILE.enf.json  a scene made by code"},
    {"bench", enf_cmd_bench, "bench NAME ...                the benchmarks, as tables and CSV"},
};
enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

static void help(FILE *out) {
    fprintf(out, "enfilade %s: what can be seen through the doors and windows of a building\n\n", enf_version());
    for (int i = 0; i < COMMAND_COUNT; i++)
        fprintf(out, "  enfilade %s\n", commands[i].help);
    fprintf(out, "\nSCENE: *.enf.json, or *.prt (PRT1, PRT2). Results on stdout, log on stderr.\n"
                 "Exit codes: 0 done, 1 usage, 2 bad input, 3 internal.\n");
}

int main(int argc, char **argv) {
    if (argc < 2) {
        help(stderr);
        return ENF_EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0) {
        help(stdout);
        return ENF_EXIT_OK;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("enfilade %s (ABI %u)\n", enf_version(), enf_abi_version());
        return ENF_EXIT_OK;
    }
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(argv[1], commands[i].name) == 0) {
            int code = commands[i].run(argc - 1, argv + 1);
            if ((fflush(stdout) != 0 || ferror(stdout)) && code == ENF_EXIT_OK) {
                fprintf(stderr, "enfilade: the result can't be written\n");
                code = ENF_EXIT_INTERNAL;
            }
            return code;
        }
    fprintf(stderr, "enfilade: no command \"%s\"\n\n", argv[1]);
    help(stderr);
    return ENF_EXIT_USAGE;
}
