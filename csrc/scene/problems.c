/* SPDX-License-Identifier: GPL-3.0-or-later
 * The list of problems a scene has. */
#include "scene/problems.h"
#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static EnfProblems *list_of(EnfScene *scene) {
    if (!scene->problems)
        scene->problems = ENF_NEW(EnfProblems, 1);
    return scene->problems;
}

const char *enf_item_word(uint32_t item) {
    static const char *const words[] = {"scene", "room", "cell", "portal", "opening", "object", "light", "camera"};
    return item < sizeof words / sizeof *words ? words[item] : "item";
}

void enf_problem_add(EnfScene *scene, uint32_t severity, uint32_t item, uint32_t index, uint32_t code, const double *position,
                     const char *format, ...) {
    EnfProblems *list = list_of(scene);
    if (!list)
        return;
    if (severity == ENF_SEVERITY_ERROR)
        list->error_count++;
    if (severity == ENF_SEVERITY_WARNING)
        list->warning_count++;
    if (++list->code_counts[code] > ENF_PROBLEMS_LISTED)
        return;
    if (!ENF_RESERVE(list->items, list->count + 1)) {
        list->out_of_memory = 1;
        return;
    }
    EnfProblem *problem = &list->items[list->count++];
    memset(problem, 0, sizeof *problem);
    problem->severity = severity;
    problem->item = item;
    problem->index = index;
    problem->code = code;
    for (int k = 0; k < 3; k++)
        problem->position[k] = position ? position[k] : (double)NAN;
    int used = 0;
    if (index != ENF_NONE)
        used = snprintf(problem->message, sizeof problem->message, "%s %u: ", enf_item_word(item), index);
    else
        used = snprintf(problem->message, sizeof problem->message, "%s: ", enf_item_word(item));
    va_list args;
    va_start(args, format);
    vsnprintf(problem->message + used, sizeof problem->message - (size_t)used, format, args);
    va_end(args);
}

void enf_problems_keep(EnfScene *scene) {
    EnfProblems *list = list_of(scene);
    if (!list)
        return;
    list->kept_count = list->count;
    memcpy(list->kept_code_counts, list->code_counts, sizeof list->code_counts);
}

void enf_problems_restart(EnfScene *scene) {
    EnfProblems *list = list_of(scene);
    if (!list)
        return;
    list->count = list->kept_count;
    memcpy(list->code_counts, list->kept_code_counts, sizeof list->code_counts);
    list->error_count = list->warning_count = 0;
    list->out_of_memory = 0;
    for (uint64_t i = 0; i < list->count; i++) {
        list->error_count += list->items[i].severity == ENF_SEVERITY_ERROR;
        list->warning_count += list->items[i].severity == ENF_SEVERITY_WARNING;
    }
}

void enf_problems_finish(EnfScene *scene) {
    EnfProblems *list = list_of(scene);
    if (!list)
        return;
    for (uint32_t code = 0; code < sizeof list->code_counts / sizeof *list->code_counts; code++)
        if (list->code_counts[code] > ENF_PROBLEMS_LISTED && code != ENF_PROBLEM_MORE)
            enf_problem_add(scene, ENF_SEVERITY_INFO, ENF_ITEM_SCENE, ENF_NONE, ENF_PROBLEM_MORE, NULL,
                            "%llu more problems of code %u aren't listed",
                            (unsigned long long)(list->code_counts[code] - ENF_PROBLEMS_LISTED), code);
}

void enf_problems_destroy(EnfProblems *problems) {
    if (!problems)
        return;
    enf_free(problems->items);
    enf_free(problems);
}

uint64_t enf_scene_problem_count(const EnfScene *scene) {
    return scene && scene->problems ? scene->problems->count : 0;
}

EnfStatus enf_scene_problem(const EnfScene *scene, uint64_t index, EnfProblem *out_problem) {
    if (!scene || !out_problem)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_problem: NULL argument");
    if (index >= enf_scene_problem_count(scene))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_problem: index %llu of %llu", (unsigned long long)index,
                        (unsigned long long)enf_scene_problem_count(scene));
    *out_problem = scene->problems->items[index];
    return ENF_OK;
}
