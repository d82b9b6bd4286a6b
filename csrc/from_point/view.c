/* SPDX-License-Identifier: GPL-3.0-or-later
 * Views: the public calls of portal_vis.h around the traversal. */
#include "from_point/view_data.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/timer.h"

#include <math.h>
#include <string.h>

EnfViewDef enf_default_view_def(void) {
    EnfViewDef def;
    memset(&def, 0, sizeof def);
    def.struct_size = sizeof def;
    def.method = ENF_VIEW_CLIP;
    def.want_objects = 1;
    def.max_apertures = 4;
    def.visit_cap = 2000;
    def.use_simd = 1;
    def.distance_limit = INFINITY;
    return def;
}

EnfViewResult enf_default_view_result(void) {
    EnfViewResult result;
    memset(&result, 0, sizeof result);
    result.struct_size = sizeof result;
    return result;
}

EnfViewStats enf_default_view_stats(void) {
    EnfViewStats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = sizeof stats;
    return stats;
}

/* ---- Life ------------------------------------------------------------------------------------------------------- */
static EnfStatus make_view(EnfViewIndex *index, EnfView **out_view) {
    EnfView *view = ENF_NEW(EnfView, 1);
    if (!view) {
        enf_view_index_release(index);
        return enf_fail_memory();
    }
    view->index = index;
    view->states = ENF_NEW(EnfCellState, index->scene->cell_count);
    view->cell_seen = ENF_NEW(uint32_t, index->scene->cell_count);
    view->object_seen = ENF_NEW(uint32_t, index->scene->object_count);
    if (!view->states || !view->cell_seen || !view->object_seen) {
        enf_view_destroy(view);
        return enf_fail_memory();
    }
    *out_view = view;
    return ENF_OK;
}

EnfStatus enf_view_create(const EnfScene *scene, EnfView **out_view) {
    if (!scene || !out_view)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_create: NULL argument");
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_view_create: the scene isn't committed");
    EnfViewIndex *index;
    EnfStatus status = enf_view_index_create(scene, &index);
    return status == ENF_OK ? make_view(index, out_view) : status;
}

EnfStatus enf_view_create_shared(const EnfView *view, EnfView **out_view) {
    if (!view || !out_view)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_create_shared: NULL argument");
    enf_view_index_retain(view->index);
    return make_view(view->index, out_view);
}

static void free_answer(EnfAnswer *answer) {
    enf_free(answer->cells);
    enf_free(answer->cell_step);
    enf_free(answer->objects);
    enf_free(answer->object_step);
}

void enf_view_destroy(EnfView *view) {
    if (!view)
        return;
    void *blocks[] = {view->states,      view->heap,          view->apertures,           view->corners,
                      view->start_cells, view->visited,       view->step_cell,
                      view->step_portal, view->step_parent,   view->cell_seen,           view->object_seen,
                      view->entered_cells, view->left_cells,  view->entered_objects,     view->left_objects,
                      view->group_mesh,  view->group_first,   view->group_objects,       view->change_marks_cells,
                      view->change_marks_objects};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++)
        enf_free(blocks[i]);
    free_answer(&view->answer);
    free_answer(&view->before);
    enf_view_index_release(view->index);
    enf_free(view);
}

int enf_answer_room(EnfAnswer *answer, uint32_t cells, uint32_t objects) {
    if (answer->cell_count + cells > answer->cell_capacity) {
        uint32_t wanted = answer->cell_count + cells + answer->cell_count / 2 + 64;
        if (!ENF_RESERVE(answer->cells, wanted) || !ENF_RESERVE(answer->cell_step, wanted))
            return 0;
        answer->cell_capacity = wanted;
    }
    if (answer->object_count + objects > answer->object_capacity) {
        uint32_t wanted = answer->object_count + objects + answer->object_count / 2 + 64;
        if (!ENF_RESERVE(answer->objects, wanted) || !ENF_RESERVE(answer->object_step, wanted))
            return 0;
        answer->object_capacity = wanted;
    }
    return 1;
}

/* ---- Queries -------------------------------------------------------------------------------------------------------- */
static EnfStatus check_def(const EnfViewDef *given, EnfViewDef *def) {
    *def = enf_default_view_def();
    if (given) {
        if (given->struct_size < sizeof *given)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: struct_size is %u, expected %u", given->struct_size,
                            (uint32_t)sizeof *given);
        *def = *given;
    }
    if (def->method > ENF_VIEW_CLIP)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: unknown method %u", def->method);
    if (def->max_apertures < 1 || def->max_apertures > ENF_MAX_APERTURES_OPTION)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: max_apertures is %u, 1 to %u are possible",
                        def->max_apertures, (unsigned)ENF_MAX_APERTURES_OPTION);
    if (!(def->distance_limit > 0))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: distance_limit is %g", def->distance_limit);
    if (!(def->start_tolerance >= 0) || !isfinite(def->start_tolerance) || !(def->reuse_distance >= 0) ||
        !isfinite(def->reuse_distance) || !(def->reuse_angle >= 0) || !isfinite(def->reuse_angle))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: a tolerance is negative or not finite");
    if (def->visit_budget == 0)
        def->visit_budget = 100000;
    return ENF_OK;
}

/* A scene that was committed again needs new arrays, and scratch of new size. */
static EnfStatus refresh_index(EnfView *view) {
    const EnfScene *scene = view->index->scene;
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "view query: the scene isn't committed");
    if (view->index->commit_serial == scene->commit_serial)
        return ENF_OK;
    EnfViewIndex *index;
    EnfStatus status = enf_view_index_create(scene, &index);
    if (status != ENF_OK)
        return status;
    EnfView *fresh;
    status = make_view(index, &fresh);
    if (status != ENF_OK)
        return status;
    EnfView old = *view;
    *view = *fresh;
    *fresh = old;
    enf_view_destroy(fresh);
    return ENF_OK;
}

static void next_query(EnfView *view) {
    if (++view->query == 0) { /* once in 2 billion queries */
        memset(view->cell_seen, 0, sizeof *view->cell_seen * view->index->scene->cell_count);
        memset(view->object_seen, 0, sizeof *view->object_seen * view->index->scene->object_count);
        view->query = 1;
    }
}

static void clear_answer(EnfView *view) {
    view->answer.cell_count = view->answer.object_count = view->step_count = 0;
    next_query(view);
}

/* view->screens and view->def are set. */
static EnfStatus run_query(EnfView *view, double started) {
    const int stages = view->def.measure_stages != 0;
    EnfViewStats *stats = &view->stats;
    EnfAnswer swap = view->before;
    view->before = view->answer;
    view->answer = swap;
    view->changes_ready = 0;
    view->answered = 0;
    memset(stats, 0, sizeof *stats);
    stats->struct_size = sizeof *stats;
    stats->method = view->def.method;
    stats->screens = view->screens.screen_count;
    stats->eyes = view->screens.eye_count;
    EnfStatus status = enf_find_start_cells(view);
    if (status != ENF_OK)
        return status;
    double located = stages ? enf_wall_seconds() : 0, collecting = 0;
    clear_answer(view);
    /* An eye outside of everything that is known sees everything: nothing says otherwise. */
    int portals = view->def.method != ENF_VIEW_FRUSTUM && view->start_count > 0;
    for (uint32_t s = 0; s < view->screens.screen_count && portals; s++) {
        int done;
        status = enf_traverse(view, &view->screens.screen[s], &done);
        if (status == ENF_OK && !done) {
            stats->budget_hit = 1;
            portals = 0;
            break;
        }
        double before = stages ? enf_wall_seconds() : 0;
        if (status == ENF_OK && view->def.want_objects)
            status = enf_collect_objects(view, &view->screens.screen[s]);
        if (stages)
            collecting += enf_wall_seconds() - before;
        if (status != ENF_OK)
            return status;
    }
    if (!portals) {
        clear_answer(view);
        stats->eye_outside = view->start_count == 0;
        for (uint32_t s = 0; s < view->screens.screen_count && status == ENF_OK; s++)
            status = enf_frustum_cull(view, &view->screens.screen[s]);
        if (status != ENF_OK)
            return status;
    }
    stats->cells = view->answer.cell_count;
    stats->objects = view->answer.object_count;
    view->answered = 1;
    double ended = enf_wall_seconds();
    stats->microseconds = 1e6 * (ended - started);
    if (stages) {
        stats->microseconds_locate = 1e6 * (located - started);
        stats->microseconds_objects = 1e6 * collecting;
        stats->microseconds_traverse = 1e6 * (ended - located - collecting);
    }
    return ENF_OK;
}

static EnfStatus begin_query(EnfView *view, const EnfViewDef *def) {
    EnfStatus status = refresh_index(view);
    view->reuse_ready = 0;
    view->start_hint = ENF_NONE;
    return status == ENF_OK ? check_def(def, &view->def) : status;
}

/* ---- Walks: an answer made for a region is given again while the camera stays in it --------------------------------- */
static int cell_holds(const EnfScene *scene, uint32_t cell, const double eye[3]) {
    for (uint32_t f = scene->cell_face_first[cell]; f < scene->cell_face_first[cell + 1]; f++) {
        double beyond = -scene->face_planes[f].d;
        for (int c = 0; c < 3; c++)
            beyond += scene->face_planes[f].n[c] * (eye[c] - scene->origin[c]);
        if (beyond > 0)
            return 0;
    }
    return 1;
}

/* The eyes an answer shall hold for: a box round the camera, and of it only what lies in the camera's cell, so that rooms
 * behind a thin wall stay out of it. */
static void choose_reuse_region(EnfView *view, const EnfCamera *camera) {
    const EnfScene *scene = view->index->scene;
    double eye[3];
    uint32_t cell, located = 0;
    for (int c = 0; c < 3; c++) {
        eye[c] = camera->world_from_camera[4 * c + 3];
        view->reuse_box[c] = eye[c] - view->def.reuse_distance;
        view->reuse_box[3 + c] = eye[c] + view->def.reuse_distance;
    }
    view->reuse_cell = ENF_NONE;
    if (enf_scene_locate(scene, eye, &cell, 1, &located) != ENF_OK || located != 1 ||
        !(view->index->cells[cell].flags & ENF_VIEW_CELL_FACES) || !cell_holds(scene, cell, eye))
        return;
    view->reuse_cell = cell;
    for (int c = 0; c < 3; c++) {
        view->reuse_box[c] = fmax(view->reuse_box[c], fmin(eye[c], scene->cell_bounds[cell][c]));
        view->reuse_box[3 + c] = fmin(view->reuse_box[3 + c], fmax(eye[c], scene->cell_bounds[cell][3 + c]));
    }
    /* And not up to its portals: eyes on a portal's plane start behind it too, with the whole screen. */
    const EnfViewCell *packed = &view->index->cells[cell];
    for (uint32_t i = 0; i < packed->side_count; i++) {
        const EnfPortalSide *side = &view->index->sides[packed->side_first + i];
        const double *v = view->index->vertices[side->vertex_first];
        double apart = -side->slack, reach = 0;
        for (int c = 0; c < 3; c++) {
            apart += side->n[c] * (v[c] - eye[c]);
            reach += fmax(side->n[c] * (view->reuse_box[c] - eye[c]), side->n[c] * (view->reuse_box[3 + c] - eye[c]));
        }
        double share = 0.6 * fmax(apart, 0);
        if (!(reach > share))
            continue;
        for (int c = 0; c < 3; c++)
            if (fabs(side->n[c]) > 1e-3) {
                view->reuse_box[c] = eye[c] + (view->reuse_box[c] - eye[c]) * share / reach;
                view->reuse_box[3 + c] = eye[c] + (view->reuse_box[3 + c] - eye[c]) * share / reach;
            }
    }
}

static int within_reuse(const EnfView *view, const EnfCamera *camera) {
    const EnfCamera *last = &view->reuse_camera;
    if (camera->struct_size != last->struct_size || camera->type != last->type || camera->angle_x != last->angle_x ||
        camera->angle_y != last->angle_y || camera->shift_x != last->shift_x || camera->shift_y != last->shift_y ||
        camera->clip_near != last->clip_near || camera->clip_far != last->clip_far)
        return 0;
    double trace = 0, eye[3];
    for (int c = 0; c < 3; c++) {
        eye[c] = camera->world_from_camera[4 * c + 3];
        if (!(eye[c] >= view->reuse_box[c] && eye[c] <= view->reuse_box[3 + c]))
            return 0;
        double dot = 0, a = 0, b = 0;
        for (int r = 0; r < 3; r++) {
            double x = camera->world_from_camera[4 * r + c], y = last->world_from_camera[4 * r + c];
            dot += x * y;
            a += x * x;
            b += y * y;
        }
        trace += dot / sqrt(a * b);
    }
    if (view->reuse_cell != ENF_NONE && !cell_holds(view->index->scene, view->reuse_cell, eye))
        return 0;
    /* trace = 1 + 2 cos(angle) */
    return trace >= 1 + 2 * cos(view->def.reuse_angle) - 1e-15;
}

EnfStatus enf_view_query(EnfView *view, const EnfCamera *camera, const EnfViewDef *def) {
    double started = enf_wall_seconds();
    if (!view || !camera)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_query: NULL argument");
    int ready = view->reuse_ready;
    EnfStatus status = begin_query(view, def);
    if (status != ENF_OK)
        return status;
    int reuse = (view->def.reuse_distance > 0 || view->def.reuse_angle > 0) && camera->type != ENF_CAMERA_ORTHO;
    uint64_t doors = view->index->scene->state_serial;
    if (reuse && ready && view->answered && memcmp(&view->reuse_def, &view->def, sizeof view->def) == 0 &&
        view->reuse_door_state == doors && within_reuse(view, camera)) {
        view->reuse_ready = 1;
        view->stats.reused = 1;
        /* Nothing entered, nothing left. */
        view->changes_ready = 1;
        view->entered_cell_count = view->left_cell_count = view->entered_object_count = view->left_object_count = 0;
        view->stats.microseconds = 1e6 * (enf_wall_seconds() - started);
        return ENF_OK;
    }
    if (reuse && isfinite(camera->world_from_camera[3] + camera->world_from_camera[7] + camera->world_from_camera[11]))
        choose_reuse_region(view, camera);
    else
        reuse = 0;
    status = enf_screens_from_cameras(camera, 1, 0, reuse ? view->reuse_box : NULL, reuse ? view->def.reuse_angle : 0,
                                      &view->screens);
    if (reuse)
        view->start_hint = view->reuse_cell;
    if (status == ENF_OK)
        status = run_query(view, started);
    if (status == ENF_OK && reuse) {
        view->reuse_ready = 1;
        view->reuse_camera = *camera;
        view->reuse_def = view->def;
        view->reuse_door_state = doors;
    }
    return status;
}

EnfStatus enf_view_query_union(EnfView *view, const EnfCamera *cameras, uint32_t count, uint32_t swept,
                               const EnfViewDef *def) {
    double started = enf_wall_seconds();
    if (!view || !cameras)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_query_union: NULL argument");
    EnfStatus status = begin_query(view, def);
    if (status == ENF_OK)
        status = enf_screens_from_cameras(cameras, count, swept != 0, NULL, 0, &view->screens);
    return status == ENF_OK ? run_query(view, started) : status;
}

EnfStatus enf_view_query_region(EnfView *view, const double bounds[6], const EnfCamera *look, const EnfViewDef *def) {
    double started = enf_wall_seconds();
    if (!view || !bounds)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_query_region: NULL argument");
    EnfStatus status = begin_query(view, def);
    if (status == ENF_OK)
        status = enf_screens_from_region(bounds, look, &view->screens);
    return status == ENF_OK ? run_query(view, started) : status;
}
