/* SPDX-License-Identifier: GPL-3.0-or-later
 * Per cell the lights that may reach it: a beam from each light through the portals, by the camera engine; for lights with a size and on
 * demand also by the from-region engine.
 *
 * Safe direction: a beam covers every straight line from any point of the light (the camera engine errs towards visible); what is dropped
 * afterwards lies wholly outside the light's half space, cone or reach, with the scene's tolerance to spare. A light in no cell counts
 * everywhere. Based on: Maria, Horna, Aveneau 2014, section 5.3. */
#include "raycast/light.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "base/timer.h"
#include "enfilade/portal_vis.h"
#include "enfilade/region_vis.h"
#include "geometry/vec3.h"
#include "scene/scene_data.h"

#include <stdlib.h>

typedef struct Row {
    uint32_t *cells; /* ascending */
    uint32_t count;
    int everywhere;
    uint64_t behind;
} Row;

typedef struct Work {
    const EnfScene *scene;
    const EnfLight *lights;
    EnfView **views; /* one a thread */
    Row *rows;       /* one a light */
    EnfStatus *status;
} Work;

static EnfCamera looking(const double eye[3], const double direction[3]) {
    EnfCamera camera = enf_default_camera();
    double back[3], right[3], up[3], helper[3] = {0, 0, 0};
    vec_scale(back, -1, direction);
    vec_normalize(back);
    helper[fabs(back[2]) < 0.9 ? 2 : 1] = 1;
    vec_cross(right, helper, back);
    vec_normalize(right);
    vec_cross(up, back, right);
    for (int k = 0; k < 3; k++) {
        camera.world_from_camera[4 * k] = right[k];
        camera.world_from_camera[4 * k + 1] = up[k];
        camera.world_from_camera[4 * k + 2] = back[k];
        camera.world_from_camera[4 * k + 3] = eye[k];
    }
    camera.clip_near = 0;
    camera.clip_far = INFINITY;
    return camera;
}

/* The box of all points of a light; 0: it is a point. */
static int box_of(const EnfLight *l, double box[6]) {
    for (int k = 0; k < 3; k++) {
        double reach = l->kind == ENF_LIGHT_AREA ? fabs(l->side[0][k]) + fabs(l->side[1][k]) : l->radius;
        box[k] = l->position[k] - reach;
        box[3 + k] = l->position[k] + reach;
    }
    return enf_light_is_soft(l);
}

static EnfStatus sun_beam(EnfView *view, const EnfScene *scene, const EnfLight *l, const EnfViewDef *def) {
    double eye[3], radius = 0.51 * scene->extent, axis[3];
    vec_copy(axis, l->direction);
    vec_normalize(axis);
    if (l->radius > 0) {
        /* A far ball that holds every parallel of every ray of the sun that meets the scene. */
        double away = 8 * scene->extent, box[6];
        vec_mad(eye, scene->origin, -away, axis);
        double reach = 1.01 * (radius + (away + radius) * tan(l->radius));
        for (int k = 0; k < 3; k++) {
            box[k] = eye[k] - reach;
            box[3 + k] = eye[k] + reach;
        }
        return enf_view_query_region(view, box, NULL, def);
    }
    vec_mad(eye, scene->origin, -4 * scene->extent, axis);
    EnfCamera camera = looking(eye, axis);
    camera.type = ENF_CAMERA_ORTHO;
    camera.ortho_width = camera.ortho_height = 2.1 * radius;
    return enf_view_query(view, &camera, def);
}

static EnfStatus beam(EnfView *view, const EnfScene *scene, const EnfLight *l) {
    EnfViewDef def = enf_default_view_def();
    double box[6];
    def.want_objects = 0;
    if (isfinite(l->reach) && l->kind != ENF_LIGHT_SUN)
        def.distance_limit = l->reach + (l->kind == ENF_LIGHT_AREA ? vec_length(l->side[0]) + vec_length(l->side[1]) : l->radius);
    if (l->kind == ENF_LIGHT_SUN)
        return sun_beam(view, scene, l, &def);
    if (box_of(l, box))
        return enf_view_query_region(view, box, NULL, &def);
    EnfCamera camera = looking(l->position, l->kind == ENF_LIGHT_POINT ? (const double[3]){0, 0, -1} : l->direction);
    if (l->kind == ENF_LIGHT_SPOT && l->spot_angle < 2.6) { /* the square round the cone; wider cones look everywhere */
        camera.angle_x = camera.angle_y = l->spot_angle + 1e-6;
    } else {
        camera.type = ENF_CAMERA_PANO;
        camera.angle_x = 6.283185307179586;
        camera.angle_y = 3.141592653589793;
    }
    return enf_view_query(view, &camera, &def);
}

/* Whether the whole cell lies where the light doesn't shine: behind an area, outside a cone, out of reach. */
static int outside(const EnfScene *scene, const EnfLight *l, uint32_t cell) {
    uint32_t first = scene->cell_vertex_first[cell], end = scene->cell_vertex_first[cell + 1];
    if (first == end || l->kind == ENF_LIGHT_SUN)
        return 0;
    double axis[3], to[3], spare = 1e-6 * scene->extent, widest = 0, centre[3];
    double size = l->kind == ENF_LIGHT_AREA ? vec_length(l->side[0]) + vec_length(l->side[1]) : l->radius;
    int before = 0;
    vec_copy(axis, l->direction);
    vec_normalize(axis);
    vec_copy(centre, scene->cell_centres[cell]);
    for (uint32_t v = first; v < end; v++) {
        vec_sub(to, scene->cell_vertices[v], l->position);
        before |= vec_dot(to, axis) > -spare;
        widest = fmax(widest, vec_distance(scene->cell_vertices[v], centre));
    }
    vec_sub(to, centre, l->position);
    double away = vec_length(to);
    if (away - widest - size > l->reach + spare)
        return 1;
    if (l->kind == ENF_LIGHT_AREA)
        return !before;
    if (l->kind == ENF_LIGHT_SPOT && away > widest + spare) {
        double seen = asin(fmin(1, (widest + size + spare) / away)), turned = acos(fmax(-1, fmin(1, vec_dot(to, axis) / away)));
        return turned - seen > 0.5 * l->spot_angle + 1e-6;
    }
    return 0;
}

uint32_t enf_light_cell(const EnfScene *scene, const EnfLight *l) {
    uint32_t cell = ENF_NONE, found = 0, c;
    double box[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
    if (l->kind == ENF_LIGHT_SUN || enf_scene_locate(scene, l->position, &cell, 1, &found) != ENF_OK || !found)
        return ENF_NONE;
    if (scene->cell_vertex_first[cell] != scene->cell_vertex_first[cell + 1])
        return cell;
    for (c = 0; c < scene->cell_vertex_first[scene->cell_count]; c++)
        for (int k = 0; k < 3; k++) {
            box[k] = fmin(box[k], scene->cell_vertices[c][k]);
            box[3 + k] = fmax(box[3 + k], scene->cell_vertices[c][k]);
        }
    for (int k = 0; k < 3; k++)
        if (l->position[k] < box[k] || l->position[k] > box[3 + k])
            return cell;
    return ENF_NONE;
}

static int ascending(const void *a, const void *b) {
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void one_light(void *context, uint64_t task, uint32_t thread) {
    Work *work = context;
    const EnfLight *l = &work->lights[task];
    const EnfScene *scene = work->scene;
    Row *row = &work->rows[task];
    EnfViewResult result = enf_default_view_result();
    EnfView *view = work->views[thread];
    EnfStatus status = beam(view, scene, l);
    if (status == ENF_OK)
        status = enf_view_result(view, &result);
    work->status[task] = status;
    if (status != ENF_OK)
        return;
    row->everywhere = l->kind != ENF_LIGHT_SUN && enf_light_cell(scene, l) == ENF_NONE;
    uint32_t most = row->everywhere ? scene->cell_count : result.cell_count;
    row->cells = ENF_NEW(uint32_t, most);
    if (!row->cells) {
        work->status[task] = ENF_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (uint32_t i = 0; i < most; i++) {
        uint32_t cell = row->everywhere ? i : result.cells[i];
        if (outside(scene, l, cell))
            row->behind++;
        else
            row->cells[row->count++] = cell;
    }
    qsort(row->cells, row->count, sizeof *row->cells, ascending);
}

/* Drops from each soft light's row the cells that none of the cells it lies in sees. */
static EnfStatus tighten(Work *work, uint32_t count, uint32_t threads, uint64_t *dropped) {
    const EnfScene *scene = work->scene;
    uint32_t *starts = NULL, *wanted = NULL, *start_first = ENF_NEW(uint32_t, (uint64_t)count + 1), total = 0, wanted_count = 0;
    uint8_t *mark = ENF_NEW(uint8_t, scene->cell_count);
    EnfStatus status = start_first && mark ? ENF_OK : ENF_ERROR_OUT_OF_MEMORY;
    EnfRegionVis *seen = NULL;
    for (uint32_t i = 0; i < count && status == ENF_OK; i++) {
        double box[6];
        start_first[i] = start_first[i + 1] = total;
        if (work->rows[i].everywhere || work->lights[i].kind == ENF_LIGHT_SUN || !box_of(&work->lights[i], box))
            continue;
        for (uint32_t c = 0; c < scene->cell_count; c++) { /* every cell the light's box touches; none without shape */
            const double *b = scene->cell_bounds[c];
            if (scene->cell_vertex_first[c] == scene->cell_vertex_first[c + 1] && scene->cell_vertex_first[scene->cell_count]) {
                if (scene->cell_rooms[c] == ENF_NONE || scene->rooms[scene->cell_rooms[c]].kind != ENF_ROOM_EXTERIOR)
                    continue;
            } else if (b[0] > box[3] + scene->tolerance || b[1] > box[4] + scene->tolerance || b[2] > box[5] + scene->tolerance ||
                       b[3] < box[0] - scene->tolerance || b[4] < box[1] - scene->tolerance || b[5] < box[2] - scene->tolerance)
                continue;
            if (!ENF_RESERVE(starts, total + 1) || !ENF_RESERVE(wanted, wanted_count + 1)) {
                status = ENF_ERROR_OUT_OF_MEMORY;
                break;
            }
            starts[total++] = c;
            if (!mark[c])
                wanted[wanted_count++] = c;
            mark[c] = 1;
        }
        start_first[i + 1] = total;
    }
    if (status == ENF_OK && wanted_count) {
        EnfRegionVisDef def = enf_default_region_vis_def();
        def.threads = threads;
        def.from_cells = wanted;
        def.from_count = wanted_count;
        status = enf_region_vis_run(scene, &def, &seen);
    }
    for (uint32_t i = 0; i < count && status == ENF_OK && seen; i++) {
        Row *row = &work->rows[i];
        uint32_t kept = 0;
        if (start_first[i] == start_first[i + 1])
            continue;
        memset(mark, 0, scene->cell_count);
        for (uint32_t s = start_first[i]; s < start_first[i + 1]; s++)
            for (uint64_t k = enf_region_vis_row_first(seen)[starts[s]]; k < enf_region_vis_row_first(seen)[starts[s] + 1]; k++)
                mark[enf_region_vis_row_cells(seen)[k]] = 1;
        for (uint32_t k = 0; k < row->count; k++)
            if (mark[row->cells[k]])
                row->cells[kept++] = row->cells[k];
        *dropped += row->count - kept;
        row->count = kept;
    }
    enf_region_vis_destroy(seen);
    enf_free(starts);
    enf_free(wanted);
    enf_free(start_first);
    enf_free(mark);
    return status == ENF_ERROR_OUT_OF_MEMORY ? enf_fail_memory() : status;
}

/* Rows by light to rows by cell. */
static EnfStatus transpose(EnfLightSets *sets, const Row *rows, uint32_t count) {
    uint64_t total = 0;
    sets->first = ENF_NEW(uint64_t, (uint64_t)sets->cell_count + 1);
    if (!sets->first)
        return enf_fail_memory();
    for (uint32_t i = 0; i < count; i++) {
        total += rows[i].count;
        for (uint32_t k = 0; k < rows[i].count; k++)
            sets->first[rows[i].cells[k] + 1]++;
    }
    for (uint32_t c = 0; c < sets->cell_count; c++)
        sets->first[c + 1] += sets->first[c];
    sets->lights = ENF_NEW(uint32_t, total);
    uint64_t *at = ENF_NEW(uint64_t, (uint64_t)sets->cell_count + 1);
    if (!sets->lights || !at) {
        enf_free(at);
        return enf_fail_memory();
    }
    memcpy(at, sets->first, sizeof *at * sets->cell_count);
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < rows[i].count; k++)
            sets->lights[at[rows[i].cells[k]]++] = i;
    enf_free(at);
    return ENF_OK;
}

EnfLightSetsStats enf_default_light_sets_stats(void) {
    EnfLightSetsStats stats = {.struct_size = sizeof stats};
    return stats;
}

EnfStatus enf_light_sets_create(const EnfScene *scene, const EnfLight *lights, uint32_t count, uint32_t method, uint32_t threads,
                                EnfLightSets **out_sets) {
    if (!scene || !out_sets || (count && !lights) || method > ENF_LIGHT_SETS_REGION)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_light_sets_create: NULL argument or unknown method");
    if (!scene->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_light_sets_create: the scene isn't committed");
    for (uint32_t i = 0; i < count; i++) {
        EnfStatus good = enf_light_check(&lights[i], i);
        if (good != ENF_OK)
            return good;
    }
    double begin = enf_wall_seconds();
    uint32_t views = threads ? threads : enf_processor_count();
    views = views > count ? count : views;
    EnfLightSets *sets = ENF_NEW(EnfLightSets, 1);
    Work work = {scene, lights, ENF_NEW(EnfView *, views), ENF_NEW(Row, count), ENF_NEW(EnfStatus, count)};
    EnfStatus status = sets && work.views && work.rows && work.status ? ENF_OK : enf_fail_memory();
    if (status == ENF_OK)
        sets->cell_count = scene->cell_count;
    for (uint32_t i = 0; i < views && status == ENF_OK; i++)
        status = i == 0 ? enf_view_create(scene, &work.views[0]) : enf_view_create_shared(work.views[0], &work.views[i]);
    if (status == ENF_OK && count)
        enf_parallel_for(count, views, one_light, &work);
    for (uint32_t i = 0; i < count && status == ENF_OK; i++)
        if (work.status[i] != ENF_OK)
            status = enf_fail(work.status[i], "light %u: its beam failed", i);
    uint64_t dropped = 0;
    if (status == ENF_OK && method == ENF_LIGHT_SETS_REGION)
        status = tighten(&work, count, threads, &dropped);
    if (status == ENF_OK)
        status = transpose(sets, work.rows, count);
    if (status == ENF_OK) {
        sets->stats = enf_default_light_sets_stats();
        sets->stats.method = method;
        sets->stats.dropped_region = dropped;
        for (uint32_t i = 0; i < count; i++) {
            sets->stats.pairs += work.rows[i].count;
            sets->stats.lights += work.rows[i].count > 0;
            sets->stats.everywhere += (uint32_t)work.rows[i].everywhere;
            sets->stats.dropped_behind += work.rows[i].behind;
        }
        sets->stats.bytes = enf_block_size(sets->first) + enf_block_size(sets->lights);
        sets->stats.wall_s = enf_wall_seconds() - begin;
        *out_sets = sets;
    } else {
        enf_light_sets_destroy(sets);
    }
    for (uint32_t i = 0; work.rows && i < count; i++)
        enf_free(work.rows[i].cells);
    for (uint32_t i = views; work.views && i > 0; i--)
        enf_view_destroy(work.views[i - 1]);
    enf_free(work.views);
    enf_free(work.rows);
    enf_free(work.status);
    return status;
}

void enf_light_sets_destroy(EnfLightSets *sets) {
    if (!sets)
        return;
    enf_free(sets->first);
    enf_free(sets->lights);
    enf_free(sets);
}

const uint64_t *enf_light_sets_first(const EnfLightSets *sets) {
    return sets ? sets->first : NULL;
}
const uint32_t *enf_light_sets_lights(const EnfLightSets *sets) {
    return sets ? sets->lights : NULL;
}

EnfStatus enf_light_sets_stats(const EnfLightSets *sets, EnfLightSetsStats *out_stats) {
    if (!sets || !out_stats || out_stats->struct_size != sizeof *out_stats)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_light_sets_stats: NULL argument or bad struct_size");
    *out_stats = sets->stats;
    return ENF_OK;
}
