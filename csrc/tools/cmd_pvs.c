/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade pvs: which cells see which, from anywhere inside them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/timer.h"
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
    "  --objects FILE              the objects seen from each cell, decided like cells; a line each:\n"
    "                              CELL OBJECT visible|grazing|undecided CELL_OF_OBJECT [x0 y0 z0 x1 y1 z1]\n"
    "  --object NAME               only objects of that name; may stand several times\n"
    "  --json FILE                 counts, counters (- for stdout); \"unsettled\": [i, j, clearance in metres] of each\n"
    "                              grazing pair, null for the clearance of an undecided one\n"
    "  --quiet                     no progress on stderr\n"
    "What a pair is, M being the clearance (told by --json, default 2.5e-7 of the scene's extent):\n"
    "  visible    some line keeps M from every edge; it is the witness\n"
    "  grazing    some line passes, none keeps 1.05 M; it is listed with the best clearance. Counts as visible\n"
    "  undecided  a cap, a time limit or a weaker method left it open. Counts as visible\n"
    "  hidden     no line keeps a touch from every edge: 1e-11 of the extent (a nanometre in 100 m) or, far from the\n"
    "             origin, 8 units in the last place of the largest coordinate. Certified\n"
    "Long bakes:\n"
    "  --state FILE                keeps finished blocks in FILE; started again, also after a crash, goes on from there\n"
    "  --shard I/N                 the I-th of N shares of the work (I from 1); needs --state, a file for each share\n"
    "  --merge FILE,FILE,...       no bake: the result out of these state files\n"
    "  --block N                   cells a block at most: the unit of states and shards (default: with --state a 12th of\n"
    "                              all, at least 512; else one block). Sightlines may depend on it, the matrix doesn't\n"
    "Door states:\n"
    "  --open NAME, --close NAME, --glass NAME\n"
    "                              sets an opening's state first; may stand several times\n"
    "  --states FILE               the same from a file, a line an opening: open|closed|glass NAME\n"
    "  --variant-of FILE,...       the state files of a bake with other door states: asks again only what the doors\n"
    "                              changed since can change; with --state the variant is kept for the next one\n";

typedef struct Options {
    const char *scene, *matrix, *witnesses, *json;
    int quiet;
    double read_s; /* CPU seconds that reading and checking the scene took */
    EnfRegionVisDef def;
    uint32_t *from;
    const char *objects;
    const char *state, *states, *merge, *variant_of;
    const char **doors; /* option and name in turn: --open NAME */
    int door_count;
    const char **object_names;
    int object_name_count;
} Options;

static int parse_number(const char *text, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end != text && !*end;
}

static int parse_from(Options *o, const char *text) {
    uint32_t count = 0;
    o->from = malloc((strlen(text) / 2 + 1) * sizeof *o->from);
    if (!o->from)
        return 0;
    for (const char *at = text;;) {
        char *end;
        unsigned long value = strtoul(at, &end, 10);
        if (end == at || *at < '0' || *at > '9' || value >= ENF_NONE)
            return 0;
        o->from[count++] = (uint32_t)value;
        if (!*end)
            break;
        if (*end != ',')
            return 0;
        at = end + 1;
    }
    o->def.from_cells = o->from, o->def.from_count = count;
    return 1;
}

/* Where an option's value is kept as it was given; NULL: it is none of these. */
static const char **text_option(Options *o, const char *name) {
    const struct {
        const char *name, **to;
    } texts[] = {{"--matrix", &o->matrix}, {"--witnesses", &o->witnesses}, {"--json", &o->json},   {"--objects", &o->objects},
                 {"--state", &o->state},   {"--states", &o->states},       {"--merge", &o->merge}, {"--variant-of", &o->variant_of}};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; ++k)
        if (!strcmp(name, texts[k].name))
            return texts[k].to;
    return NULL;
}

/* -1: go on; otherwise the exit code. So do the three below. */
static int take_number(Options *o, const char *name, const char *value) {
    double number;
    if (!parse_number(value, &number) || number < 0)
        return enf_tool_usage("pvs", "%s wants a number, got \"%s\"", name, value);
    if (!strcmp(name, "--threads")) {
        if (number > 4096 || number != (double)(uint32_t)number)
            return enf_tool_usage("pvs", "--threads wants a whole number up to 4096, got \"%s\"", value);
        o->def.threads = (uint32_t)number;
    } else if (!strcmp(name, "--block")) {
        if (number < 1 || number > 4e9 || number != (double)(uint32_t)number)
            return enf_tool_usage("pvs", "--block wants a whole number from 1 on, got \"%s\"", value);
        o->def.block_cells = (uint32_t)number;
    } else if (!strcmp(name, "--time-limit"))
        o->def.time_limit = number;
    else if (!strcmp(name, "--clearance"))
        o->def.clearance = number;
    else
        o->def.sample_effort = number;
    return -1;
}

static int take_value(Options *o, const char *name, const char *value) {
    if (!strcmp(name, "--object"))
        o->object_names[o->object_name_count++] = value;
    else if (!strcmp(name, "--open") || !strcmp(name, "--close") || !strcmp(name, "--glass"))
        o->doors[o->door_count++] = name, o->doors[o->door_count++] = value;
    else if (!strcmp(name, "--shard")) {
        unsigned index = 0, count = 0;
        char rest = 0;
        if (sscanf(value, "%u/%u%c", &index, &count, &rest) != 2 || !index || index > count)
            return enf_tool_usage("pvs", "--shard wants I/N with I from 1 to N, got \"%s\"", value);
        o->def.shard_index = index - 1, o->def.shard_count = count;
    } else if (!strcmp(name, "--from")) {
        if (!parse_from(o, value))
            return enf_tool_usage("pvs", "--from wants cell indices, got \"%s\"", value);
    } else if (!strcmp(name, "--method")) {
        uint32_t k = 0;
        while (k < 3 && strcmp(value, method_names[k]))
            ++k;
        if (k == 3)
            return enf_tool_usage("pvs", "--method is sample, flow or exact, not \"%s\"", value);
        o->def.method = k;
    } else
        return take_number(o, name, value);
    return -1;
}

/* Whether the options go together. */
static int check(const Options *o) {
    if (!o->scene)
        return enf_tool_usage("pvs", "no scene given");
    if (o->object_name_count && !o->objects)
        return enf_tool_usage("pvs", "--object needs --objects FILE");
    if (o->def.shard_count > 1 && !o->state)
        return enf_tool_usage("pvs", "--shard needs --state: a share alone says nothing");
    if (o->merge && (o->state || o->variant_of || o->from || o->def.shard_count > 1))
        return enf_tool_usage("pvs", "--merge takes no --state, --variant-of, --from or --shard");
    if (o->variant_of && (o->from || o->def.shard_count > 1))
        return enf_tool_usage("pvs", "--variant-of takes no --from or --shard");
    return -1;
}

static int parse(int argc, char **argv, Options *o) {
    static const char *const with_value[] = {"--method", "--from",  "--threads", "--time-limit", "--clearance", "--effort",
                                             "--shard",  "--block", "--open",    "--close",      "--glass",     "--object"};
    for (int i = 1; i < argc; ++i) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (!strcmp(name, "--help") || !strcmp(name, "-h")) {
            fputs(help_text, stdout);
            return ENF_EXIT_OK;
        }
        if (!strcmp(name, "--quiet")) {
            o->quiet = 1;
            continue;
        }
        if (name[0] != '-' || !name[1]) {
            if (o->scene)
                return enf_tool_usage("pvs", "more than one scene");
            o->scene = name;
            continue;
        }
        const char **text = text_option(o, name);
        int known = text != NULL, code = -1;
        for (size_t k = 0; k < sizeof with_value / sizeof *with_value; ++k)
            known |= !strcmp(name, with_value[k]);
        if (!known)
            return enf_tool_usage("pvs", "unknown option %s", name);
        if (!value)
            return enf_tool_usage("pvs", "%s needs a value", name);
        ++i;
        if (text)
            *text = value;
        else
            code = take_value(o, name, value);
        if (code >= 0)
            return code;
    }
    return check(o);
}

static void print_counts(FILE *out, const EnfRegionVisStats *s) {
#define U(name) fprintf(out, ", \"" #name "\": %llu", (unsigned long long)s->name)
#define D(name) fprintf(out, ", \"" #name "\": %.6g", s->name)
    fprintf(out, "{\"method\": \"%s\"", method_names[s->method]);
    U(cells), U(portals), U(visible_pairs), U(proven_pairs), U(grazing_pairs), U(undecided_pairs), U(hidden_certified);
    D(wall_s), D(cpu_s), U(peak_bytes), U(threads), U(interrupted), D(clearance);
    U(might_pairs), U(seed_lines), U(seed_pairs), U(chains), U(clips), U(targets_dropped), U(line_tests), U(line_hits);
    U(cone_tests), U(cone_hidden), U(cone_visible), U(cone_rays), U(cone_signs), U(filter_failures), U(exact_signs);
    U(chain_capped), U(skipped_cells), U(blocks), U(blocks_loaded), U(pairs_kept), U(pairs_reopened), U(partial);
    D(might_s), D(seed_s), D(search_s);
#undef U
#undef D
}

/* Each pair that is neither proven nor hidden, once: [i, j, clearance in metres], null where no line was found. */
static void print_unsettled(FILE *out, const EnfRegionVis *result) {
    const uint64_t *first = enf_region_vis_row_first(result);
    const uint32_t *cells = enf_region_vis_row_cells(result);
    const uint8_t *status = enf_region_vis_row_status(result);
    const char *comma = "";
    fprintf(out, ", \"unsettled\": [");
    for (uint32_t i = 0; i < enf_region_vis_cell_count(result); ++i)
        for (uint64_t k = first[i]; k < first[i + 1]; ++k) {
            double segment[6], clearance;
            uint32_t j = cells[k];
            if (status[k] == ENF_PAIR_VISIBLE || (j < i && first[j + 1] > first[j]))
                continue;
            if (enf_region_vis_witness(result, i, j, segment, NULL, 0, NULL, &clearance) == ENF_OK)
                fprintf(out, "%s[%u, %u, %.6g]", comma, i, j, clearance);
            else
                fprintf(out, "%s[%u, %u, null]", comma, i, j);
            comma = ", ";
        }
    fputc(']', out);
}

static int write_json(const Options *o, const EnfRegionVisStats *stats, const EnfRegionVis *result) {
    const char *path = o->json;
    FILE *file = strcmp(path, "-") ? fopen(path, "wb") : stdout;
    if (!file) {
        fprintf(stderr, "enfilade pvs: %s can't be written\n", path);
        return ENF_EXIT_INTERNAL;
    }
    print_counts(file, stats);
    fprintf(file, ", \"read_s\": %.6g", o->read_s);
    if (stats->method != ENF_REGION_SAMPLE && !stats->partial)
        print_unsettled(file, result);
    fprintf(file, "}\n");
    int bad = ferror(file);
    if (file != stdout)
        bad |= fclose(file);
    return bad ? ENF_EXIT_INTERNAL : ENF_EXIT_OK;
}

/* Sets the state of the openings of that name; they need not be unique. */
static EnfStatus set_state(EnfScene *scene, const char *name, uint32_t state) {
    EnfSceneCounts counts;
    memset(&counts, 0, sizeof counts);
    counts.struct_size = (uint32_t)sizeof counts;
    EnfStatus status = enf_scene_counts(scene, &counts);
    int found = 0;
    for (uint32_t k = 0; k < counts.openings && status == ENF_OK; ++k) {
        if (strcmp(enf_scene_opening_name(scene, k), name) != 0)
            continue;
        found = 1;
        status = enf_scene_set_opening_state(scene, k, state);
    }
    if (status == ENF_OK && !found) {
        fprintf(stderr, "enfilade pvs: the scene has no opening \"%s\"\n", name);
        return ENF_ERROR_BAD_INPUT;
    }
    return status;
}

static EnfStatus read_states(EnfScene *scene, const char *path) {
    static const char *const words[] = {"open", "closed", "glass"};
    static const uint32_t states[] = {ENF_STATE_OPEN, ENF_STATE_CLOSED, ENF_STATE_GLASS};
    FILE *file = fopen(path, "rb");
    char line[1024];
    EnfStatus status = file ? ENF_OK : ENF_ERROR_IO;
    if (!file)
        fprintf(stderr, "enfilade pvs: %s can't be opened\n", path);
    for (int number = 1; status == ENF_OK && fgets(line, sizeof line, file); ++number) {
        line[strcspn(line, "\r\n")] = 0;
        char *name = line + strcspn(line, " \t");
        if (!line[0] || line[0] == '#')
            continue;
        if (*name)
            *name++ = 0;
        name += strspn(name, " \t");
        int k = 0;
        while (k < 3 && strcmp(line, words[k]))
            ++k;
        if (k < 3 && *name)
            status = set_state(scene, name, states[k]);
        else {
            fprintf(stderr, "enfilade pvs: %s, line %d: wants open|closed|glass and a name\n", path, number);
            status = ENF_ERROR_BAD_INPUT;
        }
    }
    if (file)
        fclose(file);
    return status;
}

static EnfStatus set_doors(EnfScene *scene, const Options *o) {
    EnfStatus status = o->states ? read_states(scene, o->states) : ENF_OK;
    for (int k = 0; k < o->door_count && status == ENF_OK; k += 2)
        status = set_state(scene, o->doors[k + 1],
                           !strcmp(o->doors[k], "--open")    ? ENF_STATE_OPEN
                           : !strcmp(o->doors[k], "--close") ? ENF_STATE_CLOSED
                                                             : ENF_STATE_GLASS);
    return status;
}

/* The result out of state files, their names separated by commas. */
static EnfStatus load(const EnfScene *scene, const char *list, EnfRegionVis **out_result) {
    size_t length = strlen(list);
    char *text = malloc(length + 1);
    const char **paths = malloc((length + 1) * sizeof *paths);
    EnfStatus status = text && paths ? ENF_OK : ENF_ERROR_OUT_OF_MEMORY;
    if (status == ENF_OK) {
        uint32_t count = 0;
        memcpy(text, list, length + 1);
        for (char *at = text;; ++at) {
            paths[count++] = at;
            at += strcspn(at, ",");
            if (!*at)
                break;
            *at = 0;
        }
        status = enf_region_vis_load(scene, paths, count, out_result);
    }
    free(text), free(paths);
    return status;
}

static EnfStatus run(const EnfScene *scene, const Options *o, EnfRegionVis **out_result) {
    EnfJob *job = NULL;
    EnfStatus status = enf_region_vis_start(scene, &o->def, &job);
    if (status != ENF_OK)
        return status;
    uint32_t done = 0;
    double shown = 0;
    while (!done) {
        /* Short waits at first keep short bakes short; a bake of hours is told about once a second. */
        status = enf_job_wait(job, o->quiet ? -1 : 1, &done);
        EnfJobProgress progress = enf_default_job_progress();
        if (done || status != ENF_OK || enf_job_progress(job, &progress) != ENF_OK)
            continue;
        if (progress.elapsed_s - shown >= 1) {
            shown = progress.elapsed_s;
            fprintf(stderr, "%5.1f %%  %s, %.0f s\n", 100 * progress.fraction, progress.phase, progress.elapsed_s);
        }
    }
    if (status == ENF_OK)
        status = enf_region_vis_take(job, out_result);
    enf_job_destroy(job);
    return status;
}

/* The objects named; NULL and no names: all. Gives 0 after saying what is wrong. */
static int find_objects(const EnfScene *scene, const Options *o, uint32_t count, uint32_t **out_list, uint32_t *out_count) {
    *out_list = NULL, *out_count = 0;
    if (!o->object_name_count)
        return 1;
    *out_list = malloc(((size_t)count + 1) * sizeof **out_list);
    for (int n = 0; *out_list && n < o->object_name_count; ++n) {
        uint32_t before = *out_count;
        for (uint32_t k = 0; k < count && *out_count < count; ++k)
            if (!strcmp(enf_scene_object_name(scene, k), o->object_names[n]))
                (*out_list)[(*out_count)++] = k;
        if (*out_count != before)
            continue;
        fprintf(stderr, "enfilade pvs: the scene has no object \"%s\"\n", o->object_names[n]);
        return 0;
    }
    return *out_list != NULL;
}

static int write_objects(const EnfScene *scene, const Options *o, const EnfRegionVis *result, uint32_t object_count) {
    static const char *const words[] = {"hidden", "visible", "grazing", "undecided"};
    uint32_t *list, count;
    EnfObjectVis *vis = NULL;
    if (!find_objects(scene, o, object_count, &list, &count)) {
        free(list);
        return ENF_EXIT_BAD_INPUT;
    }
    EnfStatus status = enf_object_vis_run(result, o->from, o->def.from_count, list, count, o->def.threads, &vis);
    free(list);
    if (status != ENF_OK)
        return enf_tool_fail(status);
    FILE *file = strcmp(o->objects, "-") ? fopen(o->objects, "wb") : stdout;
    int bad = !file;
    const uint64_t *first = enf_object_vis_row_first(vis);
    for (uint32_t k = 0; file && k < enf_object_vis_row_count(vis); ++k)
        for (uint64_t e = first[k]; e < first[k + 1]; ++e) {
            double line[6];
            uint8_t seen = enf_object_vis_row_status(vis)[e];
            uint32_t cell = enf_object_vis_row_cells(vis)[e];
            fprintf(file, "%u %u %s", o->from ? o->from[k] : k, enf_object_vis_row_objects(vis)[e], words[seen]);
            if (cell == ENF_NONE)
                fprintf(file, " -");
            else
                fprintf(file, " %u", cell);
            if (seen != ENF_PAIR_UNDECIDED && enf_object_vis_witness(vis, e, line, NULL, 0, NULL) == ENF_OK)
                fprintf(file, " %.17g %.17g %.17g %.17g %.17g %.17g", line[0], line[1], line[2], line[3], line[4], line[5]);
            fputc('\n', file);
        }
    if (file)
        bad = ferror(file);
    if (file && file != stdout)
        bad |= fclose(file) != 0;
    if (bad)
        fprintf(stderr, "enfilade pvs: %s can't be written\n", o->objects);
    enf_object_vis_destroy(vis);
    return bad ? ENF_EXIT_BAD_INPUT : ENF_EXIT_OK;
}

static void print_summary(const EnfRegionVisStats *s, double read_s) {
    printf("cells %llu\nvisible pairs %llu (proven %llu, grazing %llu, undecided %llu)\nhidden, certified %llu\n",
           (unsigned long long)s->cells, (unsigned long long)s->visible_pairs, (unsigned long long)s->proven_pairs,
           (unsigned long long)s->grazing_pairs, (unsigned long long)s->undecided_pairs, (unsigned long long)s->hidden_certified);
    if (s->pairs_kept || s->pairs_reopened)
        printf("kept %llu pairs, asked %llu again\n", (unsigned long long)s->pairs_kept, (unsigned long long)s->pairs_reopened);
    if (s->blocks_loaded)
        printf("%llu of %llu blocks from state files\n", (unsigned long long)s->blocks_loaded, (unsigned long long)s->blocks);
    if (s->partial)
        printf("a share: these are its own pairs only\n");
    if (s->threads)
        printf("%s, %u thread%s: %.3f s, CPU %.3f s (reading the scene: %.3f s), peak %.1f MB, %.1f bytes a visible pair\n",
               method_names[s->method], s->threads, s->threads > 1 ? "s" : "", s->wall_s, s->cpu_s, read_s,
               (double)s->peak_bytes / 1048576.0, (double)s->peak_bytes / (double)(s->visible_pairs ? s->visible_pairs : 1));
    else
        printf("%s, merged\n", method_names[s->method]);
}

/* Everything after the options: gives the exit code. */
static int work(EnfScene *scene, Options *o) {
    EnfSceneCounts counts;
    memset(&counts, 0, sizeof counts);
    counts.struct_size = (uint32_t)sizeof counts;
    EnfRegionVis *result = NULL, *before = NULL;
    EnfRegionVisStats stats = enf_default_region_vis_stats();
    EnfStatus status = enf_scene_counts(scene, &counts);
    for (uint32_t i = 0; status == ENF_OK && i < o->def.from_count; ++i)
        if (o->from[i] >= counts.cells)
            return enf_tool_usage("pvs", "--from %u: the scene has %u cells", o->from[i], counts.cells);
    if (status == ENF_OK && (status = set_doors(scene, o)) != ENF_OK)
        return status == ENF_ERROR_BAD_INPUT || status == ENF_ERROR_IO ? ENF_EXIT_BAD_INPUT : enf_tool_fail(status);
    if (o->merge) {
        if (status == ENF_OK)
            status = load(scene, o->merge, &result);
    } else {
        if (status == ENF_OK && o->variant_of)
            status = load(scene, o->variant_of, &before);
        o->def.variant_of = before;
        if (!before)
            o->def.state_path = o->state;
        if (status == ENF_OK)
            status = run(scene, o, &result);
        if (status == ENF_OK && before && o->state)
            status = enf_region_vis_save(result, o->state);
    }
    if (status == ENF_OK)
        status = enf_region_vis_stats(result, &stats);
    if (status == ENF_OK && stats.partial && (o->matrix || o->witnesses))
        fprintf(stderr, "enfilade pvs: a share of the work: no matrix or witnesses until all are merged\n");
    if (status == ENF_OK && o->matrix && !stats.partial)
        status = enf_region_vis_write_matrix(result, o->matrix);
    if (status == ENF_OK && o->witnesses && !stats.partial)
        status = enf_region_vis_write_witnesses(result, o->witnesses);
    int code = ENF_EXIT_OK;
    if (status == ENF_OK && o->objects && !stats.partial)
        code = write_objects(scene, o, result, counts.objects);
    if (status != ENF_OK)
        code = enf_tool_fail(status);
    else if (code == ENF_EXIT_OK && o->json)
        code = write_json(o, &stats, result);
    else if (code == ENF_EXIT_OK)
        print_summary(&stats, o->read_s);
    enf_region_vis_destroy(result);
    enf_region_vis_destroy(before);
    return code;
}

int enf_cmd_pvs(int argc, char **argv) {
    Options o = {.def = enf_default_region_vis_def()};
    o.doors = malloc(((size_t)argc + 1) * 2 * sizeof *o.doors);
    o.object_names = malloc(((size_t)argc + 1) * sizeof *o.object_names);
    int code = o.doors && o.object_names ? parse(argc, argv, &o) : enf_tool_fail(ENF_ERROR_OUT_OF_MEMORY);
    EnfScene *scene = NULL;
    double begin = enf_cpu_seconds();
    if (code < 0 && enf_tool_load(o.scene, &scene, &code)) {
        o.read_s = enf_cpu_seconds() - begin;
        code = work(scene, &o);
    }
    enf_scene_destroy(scene);
    free(o.from), free(o.doors), free(o.object_names);
    return code;
}
