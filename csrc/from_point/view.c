/* SPDX-License-Identifier: GPL-3.0-or-later
 * Views: the public calls of portal_vis.h around the traversal. */
#include "from_point/depth_buffer.h"
#include "from_point/occlusion.h"
#include "from_point/view_data.h"
#include "from_point/vista.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/timer.h"
#include "geometry/vec3.h"

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
    def.occluder_pixels = 320;
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
/* Apertures that a new view has room for, one a cell. Beyond, arrays grow as they are needed. */
enum { APERTURES_PREPARED = 40000 };

/* Zeroed and written to: the system hands out a page when it is touched first, which takes two microseconds, and no query should
 * wait for ten thousand of them. */
static void *touched(uint64_t count, size_t size) {
    void *block = enf_alloc_array(count, size);
    if (block)
        memset(block, 0, enf_block_size(block));
    return block;
}

/* Everything that a query may need, so that the first costs what the others do. 0: out of memory. */
static int prepare_memory(EnfView *view) {
    const EnfScene *scene = view->index->scene;
    const uint32_t apertures = (scene->cell_count < APERTURES_PREPARED ? scene->cell_count : APERTURES_PREPARED) + 16;
    uint64_t places = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        places += enf_aperture_places(&view->index->cells[c]);
    /* And one more: the sweep writes before it knows whether it adds. */
    uint32_t **of_cells[] = {&view->start_marks, &view->cell_seen,    &view->visited,
                             &view->cell_step,   &view->answer.cells, &view->before.cells};
    uint32_t **of_objects[] = {&view->object_seen, &view->object_step, &view->answer.objects, &view->before.objects};
    uint32_t **of_steps[] = {&view->step_cell, &view->step_portal, &view->step_parent};
    int ok = (view->states = touched(scene->cell_count, sizeof *view->states)) && (view->live = touched(places, sizeof *view->live)) &&
             (view->apertures = touched(apertures, sizeof *view->apertures)) &&
             (view->corners = touched((uint64_t)apertures * ENF_APERTURE_CORNERS, sizeof *view->corners));
    for (size_t i = 0; i < sizeof of_cells / sizeof *of_cells; i++)
        ok = ok && (*of_cells[i] = touched(scene->cell_count + 1u, sizeof(uint32_t)));
    for (size_t i = 0; i < sizeof of_objects / sizeof *of_objects; i++)
        ok = ok && (*of_objects[i] = touched(scene->object_count + 1u, sizeof(uint32_t)));
    for (size_t i = 0; i < sizeof of_steps / sizeof *of_steps; i++)
        ok = ok && (*of_steps[i] = touched(2 * apertures, sizeof(uint32_t)));
    view->aperture_capacity = apertures;
    view->corner_capacity = apertures * ENF_APERTURE_CORNERS;
    view->step_capacity = 2 * apertures;
    return ok;
}

static EnfStatus make_view(EnfViewIndex *index, EnfView **out_view) {
    EnfView *view = ENF_NEW(EnfView, 1);
    if (!view) {
        enf_view_index_release(index);
        return enf_fail_memory();
    }
    view->index = index;
    if (!prepare_memory(view)) {
        enf_view_destroy(view);
        return enf_fail_memory();
    }
    for (uint32_t c = 0, at = 0; c < index->scene->cell_count; c++) {
        view->states[c].live = view->live + at;
        at += enf_aperture_places(&index->cells[c]);
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

void enf_view_destroy(EnfView *view) {
    if (!view)
        return;
    void *blocks[] = {view->states,
                      view->live,
                      view->passages,
                      view->heap,
                      view->apertures,
                      view->corners,
                      view->deep,
                      view->start_cells,
                      view->visited,
                      view->step_cell,
                      view->step_portal,
                      view->step_parent,
                      view->answer.cells,
                      view->answer.objects,
                      view->before.cells,
                      view->before.objects,
                      view->cell_step,
                      view->object_step,
                      view->cell_seen,
                      view->object_seen,
                      view->entered_cells,
                      view->left_cells,
                      view->entered_objects,
                      view->left_objects,
                      view->group_mesh,
                      view->group_first,
                      view->group_objects,
                      view->change_marks_cells,
                      view->change_marks_objects,
                      view->start_marks,
                      view->occluder_drawn};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++)
        enf_free(blocks[i]);
    enf_depth_buffer_destroy(view->depth);
    enf_view_index_release(view->index);
    enf_free(view);
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
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: max_apertures is %u, 1 to %u are possible", def->max_apertures,
                        (unsigned)ENF_MAX_APERTURES_OPTION);
    if (!(def->distance_limit > 0))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: distance_limit is %g", def->distance_limit);
    if (!(def->start_tolerance >= 0) || !isfinite(def->start_tolerance) || !(def->reuse_distance >= 0) || !isfinite(def->reuse_distance) ||
        !(def->reuse_angle >= 0) || !isfinite(def->reuse_angle))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: a tolerance is negative or not finite");
    if (def->occluders > ENF_OCCLUDERS_AUTO)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: unknown use of occluders %u", def->occluders);
    if (def->occluder_pixels < 16 || def->occluder_pixels > 4096)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: a depth buffer %u pixels wide; 16 to 4096 are possible",
                        def->occluder_pixels);
    if (def->outdoors > ENF_OUTDOORS_SWEEP)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "EnfViewDef: unknown way to look outdoors %u", def->outdoors);
    if (def->work_budget == 0)
        def->work_budget = 2100000;
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

static void clear_answer(EnfView *view) {
    view->answer.cell_count = view->answer.object_count = view->step_count = 0;
    view->fallback_work = 0;
    view->sweep_root = ENF_NONE;
    memset(&view->stats, 0, sizeof view->stats);
    view->stats.struct_size = sizeof view->stats;
    view->stats.method = view->def.method;
    if (++view->query == 0) { /* once in 4 billion queries */
        memset(view->cell_seen, 0, sizeof *view->cell_seen * view->index->scene->cell_count);
        memset(view->object_seen, 0, sizeof *view->object_seen * view->index->scene->object_count);
        view->query = 1;
    }
}

/* Forgets the answer before last and begins a new one. */
static void begin_answer(EnfView *view) {
    EnfAnswer swap = view->before;
    view->before = view->answer;
    view->answer = swap;
    view->changes_ready = view->answered = 0;
    clear_answer(view);
}

static EnfStatus traverse_and_collect(EnfView *view, const EnfScreen *screen, double *collecting, int *out_done) {
    EnfStatus status = enf_traverse(view, screen, out_done);
    double before = view->def.measure_stages ? enf_wall_seconds() : 0;
    if (status == ENF_OK && *out_done && view->def.want_objects)
        enf_collect_objects(view, screen);
    *out_done = *out_done && !enf_over_budget(view); /* or the list may lack some */
    if (view->def.measure_stages)
        *collecting += enf_wall_seconds() - before;
    return status;
}

/* From farther off than a quarter of the plan's diagonal of all that is indoors, whole sides of it are in view: there the exact way
 * costs more than comparing everything with the frustum does. From nearer it costs about as much or less, and spares more. */
static const double afar = 0.25;

static int is_afar(const EnfViewIndex *index, const double eye[3]) {
    const double *box = index->indoors;
    return sqrt(box_distance2(box, eye)) > afar * hypot(box[3] - box[0], box[4] - box[1]);
}

/* EXACT wherever the sweep isn't wanted or isn't as good as any other way but for how tight it is. AUTO: from afar. */
static uint32_t way_outdoors(const EnfView *view, const EnfScreen *screen) {
    if (view->def.method != ENF_VIEW_CLIP || screen->ortho || view->screens.eye_count != 1 || isfinite(view->def.distance_limit))
        return ENF_OUTDOORS_EXACT;
    for (uint32_t i = 0; i < view->start_count; i++)
        if (!(view->index->cells[view->start_cells[i]].flags & ENF_VIEW_CELL_OUTDOORS))
            return ENF_OUTDOORS_EXACT;
    return view->def.outdoors == ENF_OUTDOORS_AUTO && !is_afar(view->index, view->screens.eyes[0]) ? ENF_OUTDOORS_EXACT
                                                                                                   : view->def.outdoors;
}

/* One screen: by the sweep, or through the portals, with occluders where they are wanted. */
static EnfStatus look_through(EnfView *view, const EnfScreen *screen, double *collecting, int *out_done) {
    int occluders = enf_occlusion_possible(view, screen) ? (int)view->def.occluders : ENF_OCCLUDERS_OFF;
    EnfStatus status = ENF_OK;
    view->occluding = 0;
    const uint32_t outdoors = occluders == ENF_OCCLUDERS_OFF ? way_outdoors(view, screen) : ENF_OUTDOORS_EXACT;
    if (outdoors == ENF_OUTDOORS_SWEEP || (outdoors == ENF_OUTDOORS_AUTO && view->index->vistas->pays)) {
        status = enf_sweep(view, screen, out_done);
        if (status != ENF_OK || *out_done || enf_over_budget(view))
            return status;
    }
    if (outdoors == ENF_OUTDOORS_AUTO) {
        view->stats.swept++;
        *out_done = 1;
        enf_fall_back_screen(view, screen);
        return ENF_OK;
    }
    if (occluders == ENF_OCCLUDERS_AUTO) {
        const uint32_t cells = view->answer.cell_count, objects = view->answer.object_count, steps = view->step_count;
        status = traverse_and_collect(view, screen, collecting, out_done);
        if (status != ENF_OK || !*out_done || !enf_occlusion_pays(view, screen, view->answer.object_count - objects))
            return status;
        while (view->answer.cell_count > cells)
            view->cell_seen[view->answer.cells[--view->answer.cell_count]] = 0;
        while (view->answer.object_count > objects)
            view->object_seen[view->answer.objects[--view->answer.object_count]] = 0;
        view->step_count = steps;
    }
    if (occluders != ENF_OCCLUDERS_OFF)
        status = enf_occlusion_begin(view, screen);
    return status == ENF_OK ? traverse_and_collect(view, screen, collecting, out_done) : status;
}

/* What is left for portals: should they be too many, all is to be compared with the frustum. */
static void limit_work(EnfView *view) {
    uint64_t least = view->def.work_budget / 2, fallback = enf_fallback_work(view, view->screens.screen_count);
    view->work_limit = view->def.work_budget - (fallback < least ? fallback : least);
}

/* Adds what view->screens see to the answer. Out of budget it adds the frustum's, or, with `abandon`, nothing sensible. */
static EnfStatus look(EnfView *view, int abandon) {
    const int stages = view->def.measure_stages != 0;
    EnfViewStats *stats = &view->stats;
    double started = stages ? enf_wall_seconds() : 0;
    stats->screens += view->screens.screen_count;
    stats->eyes += view->screens.eye_count;
    if (!abandon)
        limit_work(view);
    EnfStatus status = enf_find_start_cells(view);
    double located = stages ? enf_wall_seconds() : 0, collecting = 0;
    /* What starts outside of everything that is known sees everything: nothing says otherwise. */
    stats->eye_outside |= status == ENF_OK && view->start_count == 0;
    int known = view->start_count > 0;
    if (status == ENF_OK && known && !enf_near_plane_in_cells(view))
        stats->near_in_wall = 1, known = 0;
    int portals = view->def.method != ENF_VIEW_FRUSTUM && known && !enf_over_budget(view);
    for (uint32_t s = 0; s < view->screens.screen_count && portals && status == ENF_OK; s++)
        status = look_through(view, &view->screens.screen[s], &collecting, &portals);
    if (view->def.method == ENF_VIEW_FRUSTUM) {
        for (uint32_t s = 0; s < view->screens.screen_count && status == ENF_OK; s++)
            enf_frustum_cull(view, &view->screens.screen[s]);
    } else if (!portals) {
        if (known && !stats->budget_hit)
            stats->budget_hit = 1;
        if (status == ENF_OK && !abandon)
            enf_fall_back(view);
    }
    if (stages) {
        stats->microseconds_locate += 1e6 * (located - started);
        stats->microseconds_objects += 1e6 * collecting;
        stats->microseconds_traverse += 1e6 * (enf_wall_seconds() - located - collecting);
    }
    return status;
}

static void finish_answer(EnfView *view, double started) {
    view->stats.cells = view->answer.cell_count;
    view->stats.objects = view->answer.object_count;
    view->answered = 1;
    view->stats.microseconds = 1e6 * (enf_wall_seconds() - started);
}

/* view->screens and view->def are set. */
static EnfStatus run_query(EnfView *view, double started) {
    begin_answer(view);
    EnfStatus status = look(view, 0);
    if (status == ENF_OK)
        finish_answer(view, started);
    return status;
}

static EnfStatus begin_query(EnfView *view, const EnfViewDef *def) {
    EnfStatus status = refresh_index(view);
    view->start_hint = ENF_NONE;
    if (status == ENF_OK)
        status = check_def(def, &view->def);
    return status;
}

EnfStatus enf_view_query(EnfView *view, const EnfCamera *camera, const EnfViewDef *def) {
    double started = enf_wall_seconds();
    if (!view || !camera)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_query: NULL argument");
    EnfStatus status = begin_query(view, def);
    if (status != ENF_OK)
        return status;
    const int walks = view->def.reuse_distance > 0 || view->def.reuse_angle > 0;
    if (!walks) {
        view->walk.has_answer = 0;
        view->walk.poses = 0;
    } else if (view->answered && enf_walk_holds(view, camera)) {
        /* Nothing entered, nothing left. */
        view->stats.reused = 1;
        view->changes_ready = 1;
        view->entered_cell_count = view->left_cell_count = view->entered_object_count = view->left_object_count = 0;
        view->stats.microseconds = 1e6 * (enf_wall_seconds() - started);
        return ENF_OK;
    }
    begin_answer(view);
    int planned = walks && enf_walk_plan(view, camera);
    if (planned) {
        status = look(view, 1);
        planned = status == ENF_OK && !view->stats.budget_hit;
        if (!planned) {
            enf_walk_gave_up(view);
            clear_answer(view);
            view->start_hint = ENF_NONE;
        }
    }
    if (status == ENF_OK && !planned) {
        status = enf_screens_from_cameras(camera, 0, 1, 0, NULL, &view->screens);
        if (status == ENF_OK)
            status = look(view, 0);
    }
    if (status == ENF_OK) {
        finish_answer(view, started);
        if (walks)
            enf_walk_answered(view, camera, planned);
    }
    return status;
}

EnfStatus enf_view_query_union(EnfView *view, const EnfCamera *cameras, uint32_t count, uint32_t swept, const EnfViewDef *def) {
    double started = enf_wall_seconds();
    if (!view || !cameras)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_query_union: NULL argument");
    EnfStatus status = begin_query(view, def);
    view->walk.has_answer = 0;
    if (status != ENF_OK)
        return status;
    if (swept || count == 0 || count > ENF_EYES_MAX) { /* the last two to be refused */
        status = enf_screens_from_cameras(cameras, 0, count, 1, NULL, &view->screens);
        return status == ENF_OK ? run_query(view, started) : status;
    }
    /* Camera by camera into one answer: exactly the union, and whatever the cameras are; one traversal over the hull of a
     * stereo pair costs more than two (csrc/ALGORITHMS.md, "Several eyes"). All are checked before the first is asked. */
    for (uint32_t i = count; i-- > 0;)
        if ((status = enf_screens_from_cameras(cameras, i, 1, 0, NULL, &view->screens)) != ENF_OK)
            return status;
    begin_answer(view);
    for (uint32_t i = 0; i < count; i++) {
        if (i > 0)
            enf_screens_from_cameras(cameras, i, 1, 0, NULL, &view->screens);
        status = look(view, 0);
        if (status != ENF_OK)
            return status;
    }
    finish_answer(view, started);
    return ENF_OK;
}

EnfStatus enf_view_query_region(EnfView *view, const double bounds[6], const EnfCamera *look, const EnfViewDef *def) {
    double started = enf_wall_seconds();
    if (!view || !bounds)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_view_query_region: NULL argument");
    EnfStatus status = begin_query(view, def);
    view->walk.has_answer = 0;
    if (status == ENF_OK)
        status = enf_screens_from_region(bounds, look, &view->screens);
    return status == ENF_OK ? run_query(view, started) : status;
}
