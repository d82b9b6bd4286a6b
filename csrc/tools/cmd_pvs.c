/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade pvs: which cells see which, from anywhere inside them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/tool.h"

static const char *const method_names[] = {"sample", "flow", "exact"};

static const char *const help_text =
    "enfilade pvs SCENE [options]\n"
    "  --method sample|flow|exact  sample: a lower bound, each pair with a witness; flow: conservative;\n"
    "                              exact: decides every pair (default exact)\n"
    "  --from I,J,...              only the rows of these cells (default all)\n"
    "  --threads N                 0: one a processor (default 0); the answer is the same for any N\n"
    "  --time-limit S              wall seconds; what isn't decided by then counts as visible (default none)\n"
    "  --clearance M               metres a sightline must keep from every edge (default 2.5e-7 of the extent)\n"
    "  --effort E                  sightlines aimed for a pair not yet proven, method sample (default 1)\n"
    "  --matrix FILE               line i: the cells that cell i sees\n"
    "  --witnesses FILE            i j x0 y0 z0 x1 y1 z1, a line a proven pair\n"
    "  --json FILE                 counts and counters (- for stdout)\n"
    "  --quiet                     no progress on stderr\n";

typedef struct Options {
    const char *scene, *matrix, *witnesses, *json;
    int quiet;
    EnfRegionVisDef def;
    uint32_t *from;
} Options;

static int parse_number(const char *text, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end != text && !*end;
}

static int parse_from(Options *o, const char *text) {
    uint32_t count = 0;
    o->from = malloc((strlen(text) / 2 + 1) * sizeof *o->from);
    if (!o->from) return 0;
    for (const char *at = text;;) {
        char *end;
        unsigned long value = strtoul(at, &end, 10);
        if (end == at || *at < '0' || *at > '9' || value >= ENF_NONE) return 0;
        o->from[count++] = (uint32_t)value;
        if (!*end) break;
        if (*end != ',') return 0;
        at = end + 1;
    }
    o->def.from_cells = o->from, o->def.from_count = count;
    return 1;
}

/* -1: go on; otherwise the exit code. */
static int parse(int argc, char **argv, Options *o) {
    for (int i = 1; i < argc; ++i) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        double number = 0;
        if (!strcmp(name, "--help") || !strcmp(name, "-h")) {
            fputs(help_text, stdout);
            return ENF_EXIT_OK;
        }
        if (!strcmp(name, "--quiet")) {
            o->quiet = 1;
            continue;
        }
        if (name[0] != '-' || !name[1]) {
            if (o->scene) return enf_tool_usage("pvs", "more than one scene");
            o->scene = name;
            continue;
        }
        static const char *const with_value[] = {"--method", "--from", "--threads", "--time-limit", "--clearance",
                                                 "--effort", "--matrix", "--witnesses", "--json"};
        int known = 0;
        for (size_t k = 0; k < sizeof with_value / sizeof *with_value; ++k) known |= !strcmp(name, with_value[k]);
        if (!known) return enf_tool_usage("pvs", "unknown option %s", name);
        if (!value) return enf_tool_usage("pvs", "%s needs a value", name);
        ++i;
        if (!strcmp(name, "--matrix")) o->matrix = value;
        else if (!strcmp(name, "--witnesses")) o->witnesses = value;
        else if (!strcmp(name, "--json")) o->json = value;
        else if (!strcmp(name, "--from")) {
            if (!parse_from(o, value)) return enf_tool_usage("pvs", "--from wants cell indices, got \"%s\"", value);
        } else if (!strcmp(name, "--method")) {
            uint32_t k = 0;
            while (k < 3 && strcmp(value, method_names[k])) ++k;
            if (k == 3) return enf_tool_usage("pvs", "--method is sample, flow or exact, not \"%s\"", value);
            o->def.method = k;
        } else {
            if (!parse_number(value, &number) || number < 0)
                return enf_tool_usage("pvs", "%s wants a number, got \"%s\"", name, value);
            if (!strcmp(name, "--threads")) {
                if (number > 4096 || number != (double)(uint32_t)number)
                    return enf_tool_usage("pvs", "--threads wants a whole number up to 4096, got \"%s\"", value);
                o->def.threads = (uint32_t)number;
            } else if (!strcmp(name, "--time-limit")) o->def.time_limit = number;
            else if (!strcmp(name, "--clearance")) o->def.clearance = number;
            else o->def.sample_effort = number;
        }
    }
    return o->scene ? -1 : enf_tool_usage("pvs", "no scene given");
}

static void print_counts(FILE *out, const EnfRegionVisStats *s) {
#define U(name) fprintf(out, ", \"" #name "\": %llu", (unsigned long long)s->name)
#define D(name) fprintf(out, ", \"" #name "\": %.6g", s->name)
    fprintf(out, "{\"method\": \"%s\"", method_names[s->method]);
    U(cells), U(portals), U(visible_pairs), U(proven_pairs), U(grazing_pairs), U(undecided_pairs), U(hidden_certified);
    D(wall_s), D(cpu_s), U(peak_bytes), U(threads), U(interrupted), D(clearance);
    U(might_pairs), U(seed_lines), U(seed_pairs), U(chains), U(clips), U(targets_dropped), U(line_tests), U(line_hits);
    U(cone_tests), U(cone_hidden), U(cone_visible), U(cone_rays), U(filter_failures), U(exact_signs), U(chain_capped);
    U(skipped_cells), D(might_s), D(seed_s), D(search_s);
    fprintf(out, "}\n");
#undef U
#undef D
}

static int write_json(const char *path, const EnfRegionVisStats *stats) {
    FILE *file = strcmp(path, "-") ? fopen(path, "wb") : stdout;
    if (!file) {
        fprintf(stderr, "enfilade pvs: %s can't be written\n", path);
        return ENF_EXIT_INTERNAL;
    }
    print_counts(file, stats);
    int bad = ferror(file);
    if (file != stdout) bad |= fclose(file);
    return bad ? ENF_EXIT_INTERNAL : ENF_EXIT_OK;
}

static EnfStatus run(const EnfScene *scene, const Options *o, EnfRegionVis **out_result) {
    EnfJob *job = NULL;
    EnfStatus status = enf_region_vis_start(scene, &o->def, &job);
    if (status != ENF_OK) return status;
    uint32_t done = 0;
    double shown = 0;
    while (!done) {
        /* Short waits at first keep short bakes short; a bake of hours is told about once a second. */
        status = enf_job_wait(job, o->quiet ? -1 : 1, &done);
        EnfJobProgress progress = enf_default_job_progress();
        if (done || status != ENF_OK || enf_job_progress(job, &progress) != ENF_OK) continue;
        if (progress.elapsed_s - shown >= 1) {
            shown = progress.elapsed_s;
            fprintf(stderr, "%5.1f %%  %s, %.0f s\n", 100 * progress.fraction, progress.phase, progress.elapsed_s);
        }
    }
    if (status == ENF_OK) status = enf_region_vis_take(job, out_result);
    enf_job_destroy(job);
    return status;
}

int enf_cmd_pvs(int argc, char **argv) {
    Options o = {.def = enf_default_region_vis_def()};
    int code = parse(argc, argv, &o);
    if (code >= 0) {
        free(o.from);
        return code;
    }
    EnfScene *scene = NULL;
    EnfRegionVis *result = NULL;
    EnfRegionVisStats stats = enf_default_region_vis_stats();
    if (!enf_tool_load(o.scene, &scene, &code)) {
        free(o.from);
        return code;
    }
    EnfSceneCounts counts;
    memset(&counts, 0, sizeof counts);
    counts.struct_size = (uint32_t)sizeof counts;
    EnfStatus status = enf_scene_counts(scene, &counts);
    for (uint32_t i = 0; status == ENF_OK && i < o.def.from_count; ++i)
        if (o.from[i] >= counts.cells) {
            code = enf_tool_usage("pvs", "--from %u: the scene has %u cells", o.from[i], counts.cells);
            enf_scene_destroy(scene);
            free(o.from);
            return code;
        }
    if (status == ENF_OK) status = run(scene, &o, &result);
    if (status == ENF_OK) status = enf_region_vis_stats(result, &stats);
    if (status == ENF_OK && o.matrix) status = enf_region_vis_write_matrix(result, o.matrix);
    if (status == ENF_OK && o.witnesses) status = enf_region_vis_write_witnesses(result, o.witnesses);
    code = ENF_EXIT_OK;
    if (status != ENF_OK) code = enf_tool_fail(status);
    else if (o.json) code = write_json(o.json, &stats);
    else
        printf("cells %llu\nvisible pairs %llu (proven %llu, grazing %llu, undecided %llu)\nhidden, certified %llu\n"
               "%s, %u threads: %.3f s, CPU %.3f s, peak %.1f MB\n",
               (unsigned long long)stats.cells, (unsigned long long)stats.visible_pairs,
               (unsigned long long)stats.proven_pairs, (unsigned long long)stats.grazing_pairs,
               (unsigned long long)stats.undecided_pairs, (unsigned long long)stats.hidden_certified,
               method_names[stats.method], stats.threads, stats.wall_s, stats.cpu_s,
               (double)stats.peak_bytes / 1048576.0);
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
    free(o.from);
    return code;
}
