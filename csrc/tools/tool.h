/* SPDX-License-Identifier: GPL-3.0-or-later
 * What the subcommands of the command line tool share. A subcommand is one file cmd_<name>.c with
 * int enf_cmd_<name>(int argc, char **argv); argv[0] is its name. Results on stdout, log on stderr. */
#ifndef ENF_TOOLS_TOOL_H
#define ENF_TOOLS_TOOL_H

#include "enfilade/enfilade.h"

/* Exit codes (DESIGN.md section 9). */
enum { ENF_EXIT_OK = 0, ENF_EXIT_USAGE = 1, ENF_EXIT_BAD_INPUT = 2, ENF_EXIT_INTERNAL = 3 };

int enf_cmd_info(int argc, char **argv);
int enf_cmd_pvs(int argc, char **argv);
int enf_cmd_view(int argc, char **argv);
int enf_cmd_exterior(int argc, char **argv);
int enf_cmd_generate(int argc, char **argv);
int enf_cmd_bench(int argc, char **argv);

/* Prints enf_last_error() to stderr and gives the exit code that goes with a status. */
int enf_tool_fail(EnfStatus status);
/* Prints a usage error ("enfilade NAME: ...") and gives ENF_EXIT_USAGE. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int enf_tool_usage(const char *command, const char *format, ...);
/* Loads and commits; prints warnings to stderr (at most 20). On failure 0 and *out_exit set. */
int enf_tool_load(const char *path, EnfScene **out_scene, int *out_exit);

#endif
