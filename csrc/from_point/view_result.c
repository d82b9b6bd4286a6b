/* SPDX-License-Identifier: GPL-3.0-or-later
 * Reading a view's answer: arrays, what changed, the why, groups of instances. */
#include "from_point/view_data.h"
#include "from_point/vista.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/sort_keys.h"

#include <stdlib.h>
#include <string.h>

/* The items of a list whose mark is `what`, ascending: sorted, or where they are many, found by looking at all marks. */
static uint32_t list_marked(const uint32_t *marks, uint32_t size, uint32_t what, const uint32_t *list, uint32_t count, uint32_t *out) {
    uint32_t found = 0;
    if (count > size / 64) {
        for (uint32_t i = 0; i < size; i++)
            if (marks[i] == what)
                out[found++] = i;
        return found;
    }
    for (uint32_t i = 0; i < count; i++)
        if (marks[list[i]] == what)
            out[found++] = list[i];
    qsort(out, found, sizeof *out, compare_indices);
    return found;
}

/* Marks what was there before, and what is now: both, or now alone. */
enum { MARK_BEFORE, MARK_BOTH, MARK_NOW, MARKS };
static int find_changes(uint32_t **marks, uint32_t stamp, uint32_t size, const uint32_t *before, uint32_t before_count, const uint32_t *now,
                        uint32_t now_count, uint32_t **entered, uint32_t *entered_count, uint32_t **left, uint32_t *left_count) {
    if (!*marks && !(*marks = ENF_NEW(uint32_t, size)))
        return 0;
    if (!ENF_RESERVE(*entered, now_count + 1u) || !ENF_RESERVE(*left, before_count + 1u))
        return 0;
    for (uint32_t i = 0; i < before_count; i++)
        (*marks)[before[i]] = stamp + MARK_BEFORE;
    for (uint32_t i = 0; i < now_count; i++)
        (*marks)[now[i]] = stamp + ((*marks)[now[i]] == stamp + MARK_BEFORE ? MARK_BOTH : MARK_NOW);
    *entered_count = list_marked(*marks, size, stamp + MARK_NOW, now, now_count, *entered);
    *left_count = list_marked(*marks, size, stamp + MARK_BEFORE, before, before_count, *left);
    return 1;
}

static EnfStatus need_changes(EnfView *view) {
    const EnfScene *scene = view->index->scene;
    if (view->changes_ready)
        return ENF_OK;
    view->change_stamp += MARKS;
    if (view->change_stamp < MARKS || view->change_stamp > UINT32_MAX - MARKS) { /* wrapped round */
        if (view->change_marks_cells)
            memset(view->change_marks_cells, 0, sizeof(uint32_t) * scene->cell_count);
        if (view->change_marks_objects)
            memset(view->change_marks_objects, 0, sizeof(uint32_t) * scene->object_count);
        view->change_stamp = MARKS;
    }
    if (!find_changes(&view->change_marks_cells, view->change_stamp, scene->cell_count, view->before.cells, view->before.cell_count,
                      view->answer.cells, view->answer.cell_count, &view->entered_cells, &view->entered_cell_count, &view->left_cells,
                      &view->left_cell_count) ||
        !find_changes(&view->change_marks_objects, view->change_stamp, scene->object_count, view->before.objects, view->before.object_count,
                      view->answer.objects, view->answer.object_count, &view->entered_objects, &view->entered_object_count,
                      &view->left_objects, &view->left_object_count))
        return enf_fail_memory();
    view->changes_ready = 1;
    return ENF_OK;
}

static EnfStatus need_answer(const EnfView *view, const char *call) {
    if (!view)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "%s: view is NULL", call);
    if (!view->answered)
        return enf_fail(ENF_ERROR_STATE, "%s: no query has been answered yet", call);
    return ENF_OK;
}

EnfStatus enf_view_result(const EnfView *view, EnfViewResult *out_result) {
    EnfStatus status = need_answer(view, "enf_view_result");
    if (status != ENF_OK)
        return status;
    if (!out_result || out_result->struct_size < sizeof *out_result)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_result: struct_size isn't set");
    /* Steps and what changed are worked out on demand and kept: the answer itself stays as it is. */
    status = enf_sweep_steps((EnfView *)view);
    if (status == ENF_OK)
        status = need_changes((EnfView *)view);
    if (status != ENF_OK)
        return status;
    out_result->cell_count = view->answer.cell_count;
    out_result->object_count = view->answer.object_count;
    out_result->step_count = view->step_count;
    out_result->cells = view->answer.cells;
    out_result->cell_step = view->cell_step;
    out_result->objects = view->answer.objects;
    out_result->object_step = view->object_step;
    out_result->step_cell = view->step_cell;
    out_result->step_portal = view->step_portal;
    out_result->step_parent = view->step_parent;
    out_result->cells_entered_count = view->entered_cell_count;
    out_result->cells_left_count = view->left_cell_count;
    out_result->objects_entered_count = view->entered_object_count;
    out_result->objects_left_count = view->left_object_count;
    out_result->cells_entered = view->entered_cells;
    out_result->cells_left = view->left_cells;
    out_result->objects_entered = view->entered_objects;
    out_result->objects_left = view->left_objects;
    return ENF_OK;
}

EnfStatus enf_view_stats(const EnfView *view, EnfViewStats *out_stats) {
    EnfStatus status = need_answer(view, "enf_view_stats");
    if (status != ENF_OK)
        return status;
    if (!out_stats || out_stats->struct_size < sizeof *out_stats)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_stats: struct_size isn't set");
    *out_stats = view->stats;
    return ENF_OK;
}

static EnfStatus why(const EnfView *view, uint32_t step, uint32_t *out_portals, uint32_t capacity, uint32_t *out_count) {
    uint32_t count = 0;
    for (uint32_t at = step; at != ENF_NONE && view->step_portal[at] != ENF_NONE; at = view->step_parent[at])
        count++;
    uint32_t i = count;
    for (uint32_t at = step; at != ENF_NONE && view->step_portal[at] != ENF_NONE; at = view->step_parent[at])
        if (--i < capacity)
            out_portals[i] = view->step_portal[at];
    *out_count = count;
    return ENF_OK;
}

EnfStatus enf_view_why_cell(const EnfView *view, uint32_t cell, uint32_t *out_portals, uint32_t capacity, uint32_t *out_count) {
    EnfStatus status = need_answer(view, "enf_view_why_cell");
    if (status == ENF_OK)
        status = enf_sweep_steps((EnfView *)view);
    if (status != ENF_OK)
        return status;
    if (!out_count || (capacity && !out_portals))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_why_cell: NULL argument");
    for (uint32_t i = 0; i < view->answer.cell_count; i++)
        if (view->answer.cells[i] == cell)
            return why(view, view->cell_step[i], out_portals, capacity, out_count);
    return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "cell %u isn't in the last answer", cell);
}

EnfStatus enf_view_why_object(const EnfView *view, uint32_t object, uint32_t *out_portals, uint32_t capacity, uint32_t *out_count) {
    EnfStatus status = need_answer(view, "enf_view_why_object");
    if (status == ENF_OK)
        status = enf_sweep_steps((EnfView *)view);
    if (status != ENF_OK)
        return status;
    if (!out_count || (capacity && !out_portals))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_why_object: NULL argument");
    for (uint32_t i = 0; i < view->answer.object_count; i++)
        if (view->answer.objects[i] == object)
            return why(view, view->object_step[i], out_portals, capacity, out_count);
    return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "object %u isn't in the last answer", object);
}

/* ---- Instances ------------------------------------------------------------------------------------------------------ */
typedef struct MeshObject {
    uint32_t mesh, object;
} MeshObject;

/* By mesh, stable: digits of eleven bits from the lowest on, in `spare` and back. Gives where the sorted ones are. */
static MeshObject *sort_by_mesh(MeshObject *items, MeshObject *spare, uint32_t n, uint32_t most) {
    enum { DIGIT = 11, VALUES = 1 << DIGIT };
    for (uint32_t shift = 0; shift < 32 && most >> shift; shift += DIGIT) {
        uint32_t first[VALUES + 1] = {0};
        for (uint32_t i = 0; i < n; i++)
            first[(items[i].mesh >> shift) % VALUES + 1]++;
        for (uint32_t v = 0; v < VALUES; v++)
            first[v + 1] += first[v];
        for (uint32_t i = 0; i < n; i++)
            spare[first[(items[i].mesh >> shift) % VALUES]++] = items[i];
        MeshObject *swap = items;
        items = spare;
        spare = swap;
    }
    return items;
}

EnfStatus enf_view_groups(EnfView *view, uint32_t *out_group_count, const uint32_t **out_meshes, const uint32_t **out_first,
                          const uint32_t **out_objects) {
    EnfStatus status = need_answer(view, "enf_view_groups");
    if (status != ENF_OK)
        return status;
    if (!out_group_count || !out_meshes || !out_first || !out_objects)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_groups: NULL argument");
    const EnfScene *scene = view->index->scene;
    uint32_t n = view->answer.object_count, groups = 0, most = 0;
    MeshObject *items = ENF_NEW(MeshObject, 2 * (uint64_t)n);
    if (!items || !ENF_RESERVE(view->group_mesh, n + 1u) || !ENF_RESERVE(view->group_first, n + 2u) ||
        !ENF_RESERVE(view->group_objects, n + 1u)) {
        enf_free(items);
        return enf_fail_memory();
    }
    list_marked(view->object_seen, scene->object_count, view->query, view->answer.objects, n, view->group_objects);
    for (uint32_t i = 0; i < n; i++) {
        items[i].object = view->group_objects[i];
        items[i].mesh = scene->objects[items[i].object].mesh; /* ENF_NONE is the largest: comes last */
        most = items[i].mesh > most ? items[i].mesh : most;
    }
    const MeshObject *sorted = sort_by_mesh(items, items + n, n, most);
    for (uint32_t i = 0; i < n; i++) {
        if (i == 0 || sorted[i].mesh != sorted[i - 1].mesh) {
            view->group_mesh[groups] = sorted[i].mesh;
            view->group_first[groups++] = i;
        }
        view->group_objects[i] = sorted[i].object;
    }
    view->group_first[groups] = n;
    enf_free(items);
    *out_group_count = groups;
    *out_meshes = view->group_mesh;
    *out_first = view->group_first;
    *out_objects = view->group_objects;
    return ENF_OK;
}
