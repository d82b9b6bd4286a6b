/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade bench chains: microseconds a chain of portals, asked directly, family by family, with a peer beside it when one is
 * given. Right and wrong are stress_chains' business. */
#define _POSIX_C_SOURCE 200809L /* popen */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/timer.h"
#include "chain_families.h"
#include "tools/bench.h"
#include "tools/tool.h"

#if defined(_WIN32)
#define popen  _popen
#define pclose _pclose
#endif

static const char *const help_text =
    "enfilade bench chains [--count N] [--family NAME] [--peer NAME=COMMAND] [--csv FILE]\n"
    "  Chains of the stress families (default 200 each), each asked by enf_chain_query; the least of three times counts.\n"
    "  {count} and {family} in COMMAND are filled in; of what it prints, the line that begins with the family's name is read, and\n"
    "  in it the two numbers with a decimal point: its median and mean in microseconds. Let it take the least of three times too.\n";

typedef struct Row {
    double median, mean, worst;
    uint32_t visible, hidden, other;
} Row;

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Corners wound so that their normal by the right-hand rule points forward. */
static uint32_t flatten(const Chain *chain, double (*vertices)[3], uint32_t *counts) {
    uint32_t total = 0;
    for (uint32_t p = 0; p < chain->portal_count; ++p) {
        const ChainPortal *portal = &chain->portals[p];
        double normal[3] = {0, 0, 0};
        uint32_t n = counts[p] = portal->corner_count;
        for (uint32_t i = 1; i + 1 < n; ++i) {
            double u[3], v[3];
            for (int k = 0; k < 3; ++k)
                u[k] = portal->corners[i][k] - portal->corners[0][k], v[k] = portal->corners[i + 1][k] - portal->corners[0][k];
            for (int k = 0; k < 3; ++k)
                normal[k] += u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        }
        double along = 0;
        for (int k = 0; k < 3; ++k)
            along += normal[k] * portal->forward[k];
        for (uint32_t i = 0; i < n; ++i)
            memcpy(vertices[total++], portal->corners[along > 0 ? i : n - 1 - i], sizeof *vertices);
    }
    return total;
}

static EnfStatus measure(EnfChainQuery *query, const ChainFamily *family, uint32_t index, uint32_t count, double *times, Row *row) {
    memset(row, 0, sizeof *row);
    for (uint32_t i = 0; i < count; ++i) {
        Random random = {1000003u + (uint64_t)i * 64 + index};
        Chain chain;
        double vertices[CHAIN_MAX_PORTALS * CHAIN_MAX_CORNERS][3];
        uint32_t counts[CHAIN_MAX_PORTALS];
        memset(&chain, 0, sizeof chain);
        family->make(&random, &chain);
        (void)flatten(&chain, vertices, counts);
        EnfChainAnswer answer = enf_default_chain_answer();
        times[i] = 1e300;
        for (int repeat = 0; repeat < 3; ++repeat) {
            double start = enf_wall_seconds();
            EnfStatus status = enf_chain_query(query, vertices[0], counts, chain.portal_count, 0, &answer);
            double time = 1e6 * (enf_wall_seconds() - start);
            if (status != ENF_OK)
                return status;
            if (time < times[i])
                times[i] = time;
        }
        row->visible += answer.status == ENF_PAIR_VISIBLE, row->hidden += answer.status == ENF_PAIR_HIDDEN;
        row->other += answer.status != ENF_PAIR_VISIBLE && answer.status != ENF_PAIR_HIDDEN;
        row->mean += times[i] / count;
    }
    qsort(times, count, sizeof *times, compare_doubles);
    row->median = times[count / 2], row->worst = times[count - 1];
    return ENF_OK;
}

/* Runs the peer on one family. Gives 0 when nothing of the kind expected came back. */
static int run_peer(const char *peer, const char *family, uint32_t count, double *median, double *mean) {
    const char *at = strchr(peer, '=') + 1;
    char line[1024];
    size_t size = 0;
    for (; *at && size + 64 < sizeof line; ++at) {
        if (!strncmp(at, "{family}", 8))
            size += (size_t)snprintf(line + size, 64, "%s", family), at += 7;
        else if (!strncmp(at, "{count}", 7))
            size += (size_t)snprintf(line + size, 64, "%u", count), at += 6;
        else
            line[size++] = *at;
    }
    line[size] = 0;
    fflush(stdout);
    FILE *pipe = popen(line, "r");
    int found = 0;
    while (pipe && fgets(line, sizeof line, pipe)) {
        size_t length = strlen(family);
        if (strncmp(line, family, length) != 0 || line[length] != ' ')
            continue;
        int numbers = 0;
        for (char *word = strtok(line + length, " \t\r\n"); word; word = strtok(NULL, " \t\r\n"))
            if (strchr(word, '.'))
                *(numbers++ ? mean : median) = strtod(word, NULL);
        found = numbers == 2;
    }
    if (pipe)
        pclose(pipe);
    return found;
}

int enf_bench_chains(int argc, char **argv) {
    const char *peer = NULL, *csv_path = NULL, *only = NULL;
    uint32_t count = 200, families = 0;
    for (int i = 1; i < argc; ++i) {
        if (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h")) {
            fputs(help_text, stdout);
            return ENF_EXIT_OK;
        }
        if (i + 1 >= argc)
            return enf_tool_usage("bench chains", "unknown option %s, or it needs a value", argv[i]);
        if (!strcmp(argv[i], "--peer"))
            peer = argv[++i];
        else if (!strcmp(argv[i], "--csv"))
            csv_path = argv[++i];
        else if (!strcmp(argv[i], "--family"))
            only = argv[++i];
        else if (!strcmp(argv[i], "--count"))
            count = (uint32_t)strtoul(argv[++i], NULL, 10);
        else
            return enf_tool_usage("bench chains", "unknown option %s", argv[i]);
    }
    if (!count)
        return enf_tool_usage("bench chains", "--count wants a number from 1 on");
    if (peer && !strchr(peer, '='))
        return enf_tool_usage("bench chains", "--peer wants NAME=COMMAND, got \"%s\"", peer);
    EnfChainQuery *query = NULL;
    EnfStatus status = enf_chain_query_create(&query);
    double *times = malloc(count * sizeof *times), mean = 0, ratios = 1;
    FILE *csv = csv_path ? fopen(csv_path, "wb") : NULL;
    if (csv_path && !csv) {
        enf_chain_query_destroy(query);
        free(times);
        return enf_tool_usage("bench chains", "%s can't be written", csv_path);
    }
    if (csv)
        fprintf(csv, "family,chains,visible,hidden,other,median_us,mean_us,worst_us,peer_median_us,peer_mean_us\n");
    printf("%-17s %7s %7s %7s %6s %9s %9s %9s", "family", "chains", "visible", "hidden", "other", "median us", "mean us", "worst us");
    if (peer)
        printf(" %12.*s %9s %7s", (int)(strchr(peer, '=') - peer), peer, "mean us", "ratio");
    printf("\n");
    for (uint32_t f = 0; f < chain_family_count && status == ENF_OK && times; ++f) {
        Row row;
        double peer_median = 0, peer_mean = 0;
        if (only && strcmp(only, chain_families[f].name) != 0)
            continue;
        status = measure(query, &chain_families[f], f, count, times, &row);
        if (status != ENF_OK)
            break;
        printf("%-17s %7u %7u %7u %6u %9.2f %9.2f %9.2f", chain_families[f].name, count, row.visible, row.hidden, row.other, row.median,
               row.mean, row.worst);
        int has_peer = peer && run_peer(peer, chain_families[f].name, count, &peer_median, &peer_mean);
        if (has_peer)
            printf(" %12.2f %9.2f %7.1f", peer_median, peer_mean, peer_median / row.median);
        printf("\n");
        if (csv)
            fprintf(csv, "%s,%u,%u,%u,%u,%.3f,%.3f,%.3f,%.3f,%.3f\n", chain_families[f].name, count, row.visible, row.hidden, row.other,
                    row.median, row.mean, row.worst, peer_median, peer_mean);
        mean += row.mean, ratios *= has_peer ? peer_median / row.median : 1, ++families;
    }
    if (status == ENF_OK && families)
        printf("mean over families %.2f microseconds\n", mean / families);
    if (status == ENF_OK && families && peer)
        printf("geometric mean of the ratios of medians %.1f\n", pow(ratios, 1.0 / families));
    enf_chain_query_destroy(query);
    free(times);
    if (csv && fclose(csv) != 0)
        return ENF_EXIT_INTERNAL;
    return status == ENF_OK ? ENF_EXIT_OK : enf_tool_fail(status);
}
