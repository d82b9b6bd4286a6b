/* SPDX-License-Identifier: GPL-3.0-or-later
 * Numerical stress: door chains through the from-region engine, each answer held against the exact oracle, and again after
 * motions that must not change it.
 *
 *   stress_chains [--direct] [--count N] [--variants N] [--seed S] [--family NAME] [--csv FILE]
 *
 * --direct asks the chain alone (chain_query.h) instead of a bake of cells in a row.
 *
 * A contradiction is: hidden though a line clears every portal by more than a touch (region_vis.h: 1e-11 of the extent or rounding; what passes by
 * less is counted apart, as "touch"); visible though none does; a witness that misses a portal; an answer that
 * a motion turns from visible to hidden or back. Any contradiction makes the exit code 1. "timid" counts answers left grazing or
 * undecided although the chain made wider / narrower by a hundred clearances is plainly visible / hidden: no error, but worth
 * knowing. */
#include "enfilade/enfilade.h"
#include "chain_families.h"
#include "exact_oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { STATUS_ERROR = 99 };

/* The portal's corners so wound that their normal by the right-hand rule points forward. Gives their number. */
static uint32_t wind_forward(const ChainPortal *portal, double (*out)[3]) {
    double normal[3] = {0, 0, 0};
    uint32_t n = portal->corner_count;
    const double *o = portal->corners[0];
    for (uint32_t i = 1; i + 1 < n; i++) {
        double u[3], v[3];
        for (int k = 0; k < 3; k++)
            u[k] = portal->corners[i][k] - o[k], v[k] = portal->corners[i + 1][k] - o[k];
        for (int k = 0; k < 3; k++)
            normal[k] += u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
    int along = normal[0] * portal->forward[0] + normal[1] * portal->forward[1] + normal[2] * portal->forward[2] > 0;
    for (uint32_t i = 0; i < n; i++)
        memcpy(out[i], portal->corners[along ? i : n - 1 - i], sizeof out[i]);
    return n;
}

/* Cells in a row, portal i between cell i and cell i + 1; corners counter-clockwise seen from cell i, as scene.h wants it: where
 * the neighbours' portals are far off in a flat angle the winding alone tells which way a portal faces. */
static EnfScene *scene_of(const Chain *chain) {
    EnfScene *scene = NULL;
    uint32_t room, index;
    if (enf_scene_create(&scene) != ENF_OK || enf_scene_add_room(scene, "row", ENF_ROOM_INTERIOR, &room) != ENF_OK)
        return NULL;
    for (uint32_t i = 0; i <= chain->portal_count; i++)
        if (enf_scene_add_cell(scene, room, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, &index) != ENF_OK)
            goto fail;
    for (uint32_t p = 0; p < chain->portal_count; p++) {
        const ChainPortal *portal = &chain->portals[p];
        double forward[CHAIN_MAX_CORNERS][3], corners[CHAIN_MAX_CORNERS][3];
        uint32_t n = wind_forward(portal, forward);
        for (uint32_t i = 0; i < n; i++)
            memcpy(corners[i], forward[n - 1 - i], sizeof corners[i]);
        if (enf_scene_add_portal(scene, p, p + 1, corners[0], n, 0, ENF_NONE, &index) != ENF_OK)
            goto fail;
    }
    if (enf_scene_commit(scene) != ENF_OK)
        goto fail;
    return scene;
fail:
    fprintf(stderr, "scene: %s\n", enf_last_error());
    enf_scene_destroy(scene);
    return NULL;
}

typedef struct Answer {
    uint32_t status;
    int witness_misses; /* the witness doesn't pass strictly inside every portal, exactly computed */
    double clearance;   /* the engine's delta, metres */
    double seconds;
    uint64_t filter_failures, exact_signs, cone_tests;
} Answer;

static Answer ask(const Chain *chain) {
    Answer answer = {STATUS_ERROR, 0, 0, 0, 0, 0, 0};
    EnfScene *scene = scene_of(chain);
    if (!scene)
        return answer;
    EnfRegionVisDef def = enf_default_region_vis_def();
    EnfRegionVis *result = NULL;
    uint32_t from = 0, to = chain->portal_count, count = 0;
    def.method = ENF_REGION_EXACT;
    def.threads = 1;
    def.from_cells = &from;
    def.from_count = 1;
    struct timespec t0, t1;
    timespec_get(&t0, TIME_UTC);
    EnfStatus status = enf_region_vis_run(scene, &def, &result);
    timespec_get(&t1, TIME_UTC);
    answer.seconds = (double)(t1.tv_sec - t0.tv_sec) + 1e-9 * (double)(t1.tv_nsec - t0.tv_nsec);
    if (status == ENF_OK && enf_region_vis_pair(result, from, to, &answer.status) == ENF_OK) {
        EnfRegionVisStats stats = enf_default_region_vis_stats();
        enf_region_vis_stats(result, &stats);
        answer.clearance = stats.clearance;
        answer.filter_failures = stats.filter_failures;
        answer.exact_signs = stats.exact_signs;
        answer.cone_tests = stats.cone_tests;
        if (answer.status == ENF_PAIR_VISIBLE) {
            double segment[6], clearance;
            if (enf_region_vis_witness(result, from, to, segment, NULL, 0, &count, &clearance) != ENF_OK)
                answer.witness_misses = 1;
            else
                answer.witness_misses = !oracle_segment_passes(chain, segment, segment + 3);
        }
    } else {
        fprintf(stderr, "engine: %s\n", enf_last_error());
    }
    enf_region_vis_destroy(result);
    enf_scene_destroy(scene);
    return answer;
}

/* The same by the chain alone. */
static Answer ask_directly(const Chain *chain) {
    static EnfChainQuery *query; /* one thread, and until the end */
    Answer answer = {STATUS_ERROR, 0, 0, 0, 0, 0, 0};
    double vertices[CHAIN_MAX_PORTALS * CHAIN_MAX_CORNERS][3];
    uint32_t counts[CHAIN_MAX_PORTALS], total = 0;
    if (!query && enf_chain_query_create(&query) != ENF_OK)
        return answer;
    for (uint32_t p = 0; p < chain->portal_count; p++) {
        double wound[CHAIN_MAX_CORNERS][3];
        counts[p] = wind_forward(&chain->portals[p], wound);
        memcpy(vertices[total], wound, counts[p] * sizeof *wound);
        total += counts[p];
    }
    EnfChainAnswer got = enf_default_chain_answer();
    struct timespec t0, t1;
    timespec_get(&t0, TIME_UTC);
    EnfStatus status = enf_chain_query(query, vertices[0], counts, chain->portal_count, 0, &got);
    timespec_get(&t1, TIME_UTC);
    answer.seconds = (double)(t1.tv_sec - t0.tv_sec) + 1e-9 * (double)(t1.tv_nsec - t0.tv_nsec);
    if (status != ENF_OK) {
        fprintf(stderr, "engine: %s\n", enf_last_error());
        return answer;
    }
    answer.status = got.status, answer.clearance = got.delta;
    answer.cone_tests = got.shown_by == ENF_SHOWN_BY_CONE;
    answer.exact_signs = answer.filter_failures = got.exact_signs;
    if (got.status == ENF_PAIR_VISIBLE)
        answer.witness_misses = !oracle_segment_passes(chain, got.segment, got.segment + 3);
    return answer;
}

/* Every portal scaled about its centre so that its edges move by about `by` metres. */
static Chain grown(const Chain *chain, double by) {
    Chain out = *chain;
    for (uint32_t p = 0; p < out.portal_count; p++) {
        ChainPortal *portal = &out.portals[p];
        double c[3] = {0, 0, 0}, radius = INFINITY;
        for (uint32_t i = 0; i < portal->corner_count; i++)
            for (int k = 0; k < 3; k++)
                c[k] += portal->corners[i][k] / portal->corner_count;
        for (uint32_t i = 0; i < portal->corner_count; i++) { /* distance of the centre from each edge */
            const double *a = portal->corners[i], *b = portal->corners[(i + 1) % portal->corner_count];
            double e[3], w[3], x[3];
            for (int k = 0; k < 3; k++)
                e[k] = b[k] - a[k], w[k] = c[k] - a[k];
            for (int k = 0; k < 3; k++)
                x[k] = e[(k + 1) % 3] * w[(k + 2) % 3] - e[(k + 2) % 3] * w[(k + 1) % 3];
            double length = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
            if (length > 0)
                radius = fmin(radius, sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) / length);
        }
        double f = fmax(0.05, 1 + by / radius);
        for (uint32_t i = 0; i < portal->corner_count; i++)
            for (int k = 0; k < 3; k++)
                portal->corners[i][k] = c[k] + f * (portal->corners[i][k] - c[k]);
    }
    return out;
}

typedef struct Tally {
    uint64_t chains, stab, none, unknown, visible, grazing, undecided, hidden, errors;
    uint64_t contradictions, witness_misses, variants, variant_contradictions, timid, touches;
    uint64_t filter_failures, exact_signs, with_exact, with_cone;
    double seconds, worst;
} Tally;

static const char *status_word(uint32_t status) {
    static const char *const words[] = {"hidden", "visible", "grazing", "undecided"};
    return status < 4 ? words[status] : "error";
}

static void contradiction(const char *family, uint64_t seed, const char *variant, const char *oracle, const Answer *answer) {
    printf("CONTRADICTION family %s seed %llu%s%s: oracle %s, engine %s%s\n", family, (unsigned long long)seed,
           variant[0] ? " variant " : "", variant, oracle, status_word(answer->status),
           answer->witness_misses ? " with a witness that misses" : "");
}

static double extent_of(const Chain *chain) {
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, sum = 0;
    for (uint32_t p = 0; p < chain->portal_count; p++)
        for (uint32_t i = 0; i < chain->portals[p].corner_count; i++)
            for (int k = 0; k < 3; k++)
                lo[k] = fmin(lo[k], chain->portals[p].corners[i][k]), hi[k] = fmax(hi[k], chain->portals[p].corners[i][k]);
    for (int k = 0; k < 3; k++)
        sum += (hi[k] - lo[k]) * (hi[k] - lo[k]);
    return sqrt(sum);
}

/* What region_vis.h promises, in metres. */
static double touch_of(const Chain *chain) {
    double largest = 0;
    for (uint32_t p = 0; p < chain->portal_count; p++)
        for (uint32_t i = 0; i < chain->portals[p].corner_count; i++)
            for (int k = 0; k < 3; k++)
                largest = fmax(largest, fabs(chain->portals[p].corners[i][k]));
    return fmax(1e-11 * extent_of(chain), 8 * 0x1p-52 * largest);
}

/* 1: a contradiction; 0: none; *touches counts hidden chains that only a line within the touch passes. */
static int contradicts(const Chain *chain, int oracle, const Answer *answer, uint64_t *touches) {
    if (answer->witness_misses || answer->status == STATUS_ERROR || (oracle == ORACLE_NONE && answer->status == ENF_PAIR_VISIBLE))
        return 1;
    if (oracle != ORACLE_STAB || answer->status != ENF_PAIR_HIDDEN)
        return 0;
    Chain shrunk = grown(chain, -touch_of(chain));
    if (oracle_decide(&shrunk) == ORACLE_STAB)
        return 1;
    ++*touches;
    return 0;
}

/* How a chain is asked: set once, from the arguments. */
static Answer (*ask_engine)(const Chain *chain) = ask;

/* A witness that passes every portal strictly, in rationals, proves the chain stabbed: the slow decision is for all others. */
static int decide(const Chain *chain, const Answer *answer) {
    return answer->status == ENF_PAIR_VISIBLE && !answer->witness_misses ? ORACLE_STAB : oracle_decide(chain);
}

static void run_one(const ChainFamily *family, uint64_t seed, uint32_t variants, Tally *tally) {
    static const char *const oracle_words[] = {"none", "stab", "unknown"};
    Random random = {seed};
    Chain chain = {0};
    family->make(&random, &chain);
    Answer answer = ask_engine(&chain);
    int oracle = decide(&chain, &answer);
    tally->chains++;
    tally->stab += oracle == ORACLE_STAB, tally->none += oracle == ORACLE_NONE, tally->unknown += oracle == ORACLE_UNKNOWN;
    tally->visible += answer.status == ENF_PAIR_VISIBLE, tally->grazing += answer.status == ENF_PAIR_GRAZING;
    tally->undecided += answer.status == ENF_PAIR_UNDECIDED, tally->hidden += answer.status == ENF_PAIR_HIDDEN;
    tally->errors += answer.status == STATUS_ERROR;
    tally->seconds += answer.seconds, tally->worst = fmax(tally->worst, answer.seconds);
    tally->filter_failures += answer.filter_failures, tally->exact_signs += answer.exact_signs;
    tally->with_exact += answer.exact_signs > 0, tally->with_cone += answer.cone_tests > 0;
    tally->witness_misses += (uint64_t)answer.witness_misses;
    if (contradicts(&chain, oracle, &answer, &tally->touches)) {
        tally->contradictions++;
        contradiction(family->name, seed, "", oracle_words[oracle], &answer);
    }
    if (answer.status == ENF_PAIR_GRAZING || answer.status == ENF_PAIR_UNDECIDED) {
        Chain wider = grown(&chain, 100 * answer.clearance), narrower = grown(&chain, -100 * answer.clearance);
        tally->timid += oracle_decide(&wider) == ORACLE_NONE || oracle_decide(&narrower) == ORACLE_STAB;
    }
    for (uint32_t v = 0; v < variants; v++) {
        Chain varied;
        uint32_t kind = v % VARIANT_COUNT;
        if (!chain_vary(kind, &random, &chain, &varied))
            continue;
        Answer again = ask_engine(&varied);
        /* The motion rounds: judge the moved chain by an oracle of its own, and the two answers against each other. */
        int moved = decide(&varied, &again);
        int flips = (answer.status == ENF_PAIR_VISIBLE && again.status == ENF_PAIR_HIDDEN) ||
                    (answer.status == ENF_PAIR_HIDDEN && again.status == ENF_PAIR_VISIBLE);
        tally->variants++;
        if (contradicts(&varied, moved, &again, &tally->touches) || flips) {
            tally->variant_contradictions++;
            contradiction(family->name, seed, chain_variant_names[kind], oracle_words[moved], &again);
        }
    }
}

int main(int argc, char **argv) {
    uint64_t count = 100, seed = 1;
    uint32_t variants = VARIANT_COUNT;
    const char *only = NULL, *csv_path = NULL;
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (!strcmp(argv[i], "--direct"))
            ask_engine = ask_directly;
        else if (value && !strcmp(argv[i], "--count"))
            count = strtoull(value, NULL, 10), i++;
        else if (value && !strcmp(argv[i], "--variants"))
            variants = (uint32_t)strtoul(value, NULL, 10), i++;
        else if (value && !strcmp(argv[i], "--seed"))
            seed = strtoull(value, NULL, 10), i++;
        else if (value && !strcmp(argv[i], "--family"))
            only = value, i++;
        else if (value && !strcmp(argv[i], "--csv"))
            csv_path = value, i++;
        else {
            fprintf(stderr, "usage: %s [--direct] [--count N] [--variants N] [--seed S] [--family NAME] [--csv FILE]\n", argv[0]);
            return 1;
        }
    }
    FILE *csv = csv_path ? fopen(csv_path, "w") : NULL;
    if (csv_path && !csv)
        return perror(csv_path), 1;
    if (csv)
        fprintf(csv, "family,degenerate,chains,stab,none,unknown,visible,grazing,undecided,hidden,contradictions,variants,variant_"
                     "contradictions,timid,filter_failures,exact_signs,mean_us,worst_us\n");
    printf("%-17s %7s %6s %6s %4s | %7s %7s %7s %7s | %4s %8s %4s %5s | %8s %7s | %8s %8s\n", "family", "chains", "stab", "none", "unkn",
           "visible", "grazing", "undec", "hidden", "bad", "variants", "bad", "timid", "unsure", "exact", "mean us", "worst us");
    oracle_begin();
    Tally all = {0};
    uint64_t degenerate = 0;
    for (uint32_t f = 0; f < chain_family_count; f++) {
        const ChainFamily *family = &chain_families[f];
        if (only && strcmp(only, family->name))
            continue;
        Tally t = {0};
        for (uint64_t i = 0; i < count; i++)
            run_one(family, seed * 1000003u + i * 64 + f, variants, &t);
        printf("%-17s %7llu %6llu %6llu %4llu | %7llu %7llu %7llu %7llu | %4llu %8llu %4llu %5llu | %8llu %7llu | %8.1f %8.1f\n",
               family->name, (unsigned long long)t.chains, (unsigned long long)t.stab, (unsigned long long)t.none,
               (unsigned long long)t.unknown, (unsigned long long)t.visible, (unsigned long long)t.grazing, (unsigned long long)t.undecided,
               (unsigned long long)t.hidden, (unsigned long long)t.contradictions, (unsigned long long)t.variants,
               (unsigned long long)t.variant_contradictions, (unsigned long long)t.timid, (unsigned long long)t.filter_failures,
               (unsigned long long)t.exact_signs, 1e6 * t.seconds / (double)t.chains, 1e6 * t.worst);
        fflush(stdout);
        if (csv)
            fprintf(csv, "%s,%d,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%.3f,%.3f\n", family->name,
                    family->degenerate, (unsigned long long)t.chains, (unsigned long long)t.stab, (unsigned long long)t.none,
                    (unsigned long long)t.unknown, (unsigned long long)t.visible, (unsigned long long)t.grazing,
                    (unsigned long long)t.undecided, (unsigned long long)t.hidden, (unsigned long long)t.contradictions,
                    (unsigned long long)t.variants, (unsigned long long)t.variant_contradictions, (unsigned long long)t.timid,
                    (unsigned long long)t.filter_failures, (unsigned long long)t.exact_signs, 1e6 * t.seconds / (double)t.chains,
                    1e6 * t.worst);
        all.chains += t.chains, all.variants += t.variants, all.timid += t.timid, all.unknown += t.unknown, all.with_exact += t.with_exact,
            all.touches += t.touches, all.with_cone += t.with_cone;
        degenerate += family->degenerate ? t.chains : 0;
        all.contradictions += t.contradictions + t.variant_contradictions;
    }
    oracle_end();
    if (csv)
        fclose(csv);
    printf("%llu chains (%llu degenerate) and %llu variants: %llu contradictions; oracle unsure %llu; %llu chains needed exact "
           "arithmetic (%.2f %%; of those that came to the cone %.1f %%); timid %llu; hidden within a touch %llu\n",
           (unsigned long long)all.chains, (unsigned long long)degenerate, (unsigned long long)all.variants,
           (unsigned long long)all.contradictions, (unsigned long long)all.unknown, (unsigned long long)all.with_exact,
           100.0 * (double)all.with_exact / (double)(all.chains ? all.chains : 1),
           100.0 * (double)all.with_exact / (double)(all.with_cone ? all.with_cone : 1), (unsigned long long)all.timid,
           (unsigned long long)all.touches);
    return all.contradictions > 0;
}
