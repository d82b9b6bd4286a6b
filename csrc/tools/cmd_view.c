/* SPDX-License-Identifier: GPL-3.0-or-later
 * enfilade view: the cells and objects that a camera sees, and through which openings. */
#include "tools/tool.h"
#include "geometry/sort_keys.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int read_triple(const char *text, double out[3]) {
    char *end;
    for (int i = 0; i < 3; i++) {
        out[i] = strtod(text, &end);
        if (end == text || !isfinite(out[i]) || (i < 2 ? *end != ',' : *end != '\0'))
            return 0;
        text = end + 1;
    }
    return 1;
}

static int read_number(const char *text, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*out);
}

/* A camera at `eye` that looks at `look`, z up. fov: horizontal, degrees; aspect: width / height. */
static int aim_camera(EnfCamera *camera, const double eye[3], const double look[3], double fov, double aspect) {
    double back[3], right[3], up[3], length = 0;
    for (int i = 0; i < 3; i++)
        back[i] = eye[i] - look[i];
    length = sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
    if (!(length > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        back[i] /= length;
    /* right = z x back; straight up or down: +x */
    right[0] = -back[1];
    right[1] = back[0];
    right[2] = 0;
    length = sqrt(right[0] * right[0] + right[1] * right[1]);
    if (length < 1e-12) {
        right[0] = 1;
        right[1] = 0;
        length = 1;
    }
    right[0] /= length;
    right[1] /= length;
    up[0] = back[1] * right[2] - back[2] * right[1];
    up[1] = back[2] * right[0] - back[0] * right[2];
    up[2] = back[0] * right[1] - back[1] * right[0];
    for (int r = 0; r < 3; r++) {
        camera->world_from_camera[4 * r + 0] = right[r];
        camera->world_from_camera[4 * r + 1] = up[r];
        camera->world_from_camera[4 * r + 2] = back[r];
        camera->world_from_camera[4 * r + 3] = eye[r];
    }
    const double pi = 3.14159265358979323846;
    camera->angle_x = fov * pi / 180;
    if (fov < 180)
        camera->angle_y = 2 * atan(tan(0.5 * camera->angle_x) / aspect);
    else
        camera->type = ENF_CAMERA_PANO, camera->angle_y = fmin(2 * pi, camera->angle_x / aspect);
    camera->clip_near = 0; /* an eye, not a lens */
    camera->clip_far = INFINITY;
    return 1;
}

static void print_list(FILE *out, const char *key, const uint32_t *items, uint32_t count) {
    fprintf(out, "\"%s\": [", key);
    for (uint32_t i = 0; i < count; i++)
        fprintf(out, "%s%u", i ? ", " : "", items[i]);
    fprintf(out, "]");
}

/* [[cell, [portals]], ...] in the order of the ascending lists. */
static int print_whys(FILE *out, const EnfView *view, const char *key, const uint32_t *items, uint32_t count, int objects) {
    fprintf(out, "\"%s\": [", key);
    uint32_t *portals = NULL, capacity = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t n = 0;
        EnfStatus (*why)(const EnfView *, uint32_t, uint32_t *, uint32_t, uint32_t *) = objects ? enf_view_why_object : enf_view_why_cell;
        if (why(view, items[i], portals, capacity, &n) != ENF_OK)
            continue;
        if (n > capacity) {
            uint32_t *more = realloc(portals, sizeof *portals * (n + 16));
            if (!more)
                break;
            portals = more;
            capacity = n + 16;
            why(view, items[i], portals, capacity, &n);
        }
        fprintf(out, "%s[", i ? ", " : "");
        for (uint32_t k = 0; k < n; k++)
            fprintf(out, "%s%u", k ? ", " : "", portals[k]);
        fprintf(out, "]");
    }
    fprintf(out, "]");
    free(portals);
    return 1;
}

static void print_json(FILE *out, const EnfView *view, uint32_t *cells, uint32_t *objects, const EnfViewStats *s, const char *method,
                       int whys) {
    fprintf(out, "{");
    print_list(out, "cells", cells, s->cells);
    fprintf(out, ",\n ");
    print_list(out, "objects", objects, s->objects);
    fprintf(out, ",\n \"microseconds\": %.3f, \"method\": \"%s\"", s->microseconds, method);
    if (whys) {
        fprintf(out, ",\n ");
        print_whys(out, view, "cell_portals", cells, s->cells, 0);
        fprintf(out, ",\n ");
        print_whys(out, view, "object_portals", objects, s->objects, 1);
    }
    fprintf(out,
            ",\n \"counters\": {\"start_cells\": %u, \"visits\": %u, \"portals_tested\": %u, \"portals_projected\": %u, "
            "\"apertures\": %u, \"apertures_contained\": %u, \"apertures_sliver\": %u, \"merges_exact\": %u, "
            "\"merges_forced\": %u, \"cells_snapped\": %u, \"visit_cap_hit\": %u, \"budget_hit\": %u, "
            "\"portals_unclipped\": %u, \"objects_tested\": %u, \"objects_refined\": %u, \"objects_unplaced\": %u, "
            "\"occluder_polygons\": %u, \"portals_occluded\": %u, \"objects_occluded\": %u, "
            "\"screens\": %u, \"eye_outside\": %u, \"near_in_wall\": %u, \"swept\": %u, "
            "\"windows\": %u, \"work\": %llu}}\n",
            s->start_cells, s->visits, s->portals_tested, s->portals_projected, s->apertures, s->apertures_contained, s->apertures_sliver,
            s->merges_exact, s->merges_forced, s->cells_snapped, s->visit_cap_hit, s->budget_hit, s->portals_unclipped, s->objects_tested,
            s->objects_refined, s->objects_unplaced, s->occluder_polygons, s->portals_occluded, s->objects_occluded, s->screens,
            s->eye_outside, s->near_in_wall, s->swept, s->windows, (unsigned long long)s->work);
}

static void print_text(const EnfScene *scene, const uint32_t *cells, const uint32_t *objects, const EnfViewStats *s, const char *method) {
    printf("%s: %u cells, %u objects in %.1f microseconds (%u visits, %u start cells)\n", method, s->cells, s->objects, s->microseconds,
           s->visits, s->start_cells);
    if (s->budget_hit || s->eye_outside || s->near_in_wall)
        printf("  %s: %s\n",
               s->budget_hit    ? "out of budget"
               : s->eye_outside ? "no cell holds the eye"
                                : "the near plane reaches into a wall",
               s->budget_hit == 2 ? "all there is is given" : "the frustum's answer is given");
    const uint32_t *rooms = enf_scene_cell_rooms(scene), *openings = enf_scene_cell_openings(scene);
    for (uint32_t i = 0; i < s->cells && i < 200; i++) {
        const char *name =
            rooms[cells[i]] != ENF_NONE ? enf_scene_room_name(scene, rooms[cells[i]]) : enf_scene_opening_name(scene, openings[cells[i]]);
        printf("  cell %u %s\n", cells[i], name ? name : "");
    }
    for (uint32_t i = 0; i < s->objects && i < 200; i++) {
        const char *name = enf_scene_object_name(scene, objects[i]);
        printf("  object %u %s\n", objects[i], name ? name : "");
    }
    if (s->cells > 200 || s->objects > 200)
        printf("  ... all of them with --json\n");
}

/* What was asked for on the command line. */
typedef struct ViewRequest {
    const char *scene, *camera, *json; /* camera, json: NULL: not given */
    double eye[3], look[3], fov, aspect;
    int have_eye, have_look, whys;
    EnfViewDef def;
} ViewRequest;

static const char *const methods[] = {"frustum", "box", "clip"}, *const uses[] = {"off", "on", "auto"},
                         *const outdoors[] = {"auto", "exact", "sweep"};

static int read_choice(const char *text, const char *const names[3], uint32_t *out) {
    for (uint32_t k = 0; k < 3; k++)
        if (strcmp(text, names[k]) == 0) {
            *out = k;
            return 1;
        }
    return 0;
}

/* An option and its value. 0: the value can't be; -1: there is no such option. */
static int read_option(ViewRequest *request, const char *name, const char *value) {
    if (strcmp(name, "--camera") == 0)
        return (request->camera = value) != NULL;
    if (strcmp(name, "--json") == 0)
        return (request->json = value) != NULL;
    if (strcmp(name, "--eye") == 0)
        return request->have_eye = read_triple(value, request->eye);
    if (strcmp(name, "--look") == 0)
        return request->have_look = read_triple(value, request->look);
    if (strcmp(name, "--fov") == 0)
        return read_number(value, &request->fov) && request->fov > 0 && request->fov <= 360;
    if (strcmp(name, "--aspect") == 0)
        return read_number(value, &request->aspect) && request->aspect > 0;
    if (strcmp(name, "--distance") == 0)
        return read_number(value, &request->def.distance_limit) && request->def.distance_limit > 0;
    if (strcmp(name, "--method") == 0)
        return read_choice(value, methods, &request->def.method);
    if (strcmp(name, "--occluders") == 0)
        return read_choice(value, uses, &request->def.occluders);
    if (strcmp(name, "--outdoors") == 0)
        return read_choice(value, outdoors, &request->def.outdoors);
    return -1;
}

static int read_request(int argc, char **argv, ViewRequest *request) {
    for (int i = 1; i < argc; i++) {
        if (argv[i][0] != '-') {
            if (request->scene)
                return enf_tool_usage("view", "two scenes: %s and %s", request->scene, argv[i]);
            request->scene = argv[i];
        } else if (strcmp(argv[i], "--why") == 0)
            request->whys = 1;
        else if (i + 1 >= argc)
            return enf_tool_usage("view", "%s wants a value", argv[i]);
        else {
            int known = read_option(request, argv[i], argv[i + 1]);
            if (known < 0)
                return enf_tool_usage("view", "no option %s", argv[i]);
            if (known == 0)
                return enf_tool_usage("view", "%s can't be \"%s\"", argv[i], argv[i + 1]);
            i++;
        }
    }
    if (!request->scene)
        return enf_tool_usage("view", "no scene given");
    if (!request->camera && !(request->have_eye && request->have_look))
        return enf_tool_usage("view", "wants --camera NAME, or --eye X,Y,Z --look X,Y,Z");
    return ENF_EXIT_OK;
}

/* The camera that was named, or aimed by hand. */
static int find_camera(const ViewRequest *request, const EnfScene *scene, EnfCamera *camera) {
    *camera = enf_default_camera();
    if (!request->camera)
        return aim_camera(camera, request->eye, request->look, request->fov, request->aspect)
                   ? ENF_EXIT_OK
                   : enf_tool_usage("view", "--eye and --look are the same point");
    EnfSceneCounts counts;
    counts.struct_size = sizeof counts;
    enf_scene_counts(scene, &counts);
    for (uint32_t i = 0; i < counts.cameras; i++)
        if (enf_scene_camera_name(scene, i) && strcmp(enf_scene_camera_name(scene, i), request->camera) == 0) {
            enf_scene_camera(scene, i, camera);
            return ENF_EXIT_OK;
        }
    fprintf(stderr, "enfilade view: %s has no camera \"%s\"; it has %u cameras", request->scene, request->camera, counts.cameras);
    for (uint32_t i = 0; i < counts.cameras && i < 20; i++)
        fprintf(stderr, "%s\"%s\"", i ? ", " : ": ", enf_scene_camera_name(scene, i));
    fprintf(stderr, "\n");
    return ENF_EXIT_BAD_INPUT;
}

/* A copy in ascending order; NULL: out of memory. */
static uint32_t *ascending(const uint32_t *items, uint32_t count) {
    uint32_t *sorted = malloc(sizeof *sorted * ((size_t)count + 1));
    if (!sorted)
        return NULL;
    if (count)
        memcpy(sorted, items, sizeof *sorted * count);
    qsort(sorted, count, sizeof *sorted, compare_indices);
    return sorted;
}

/* The answer as text, or to the file that was asked for. */
static int print_answer(const ViewRequest *request, const EnfScene *scene, const EnfView *view) {
    EnfViewStats stats = enf_default_view_stats();
    EnfViewResult result = enf_default_view_result();
    EnfStatus status = enf_view_stats(view, &stats);
    if (status == ENF_OK)
        status = enf_view_result(view, &result);
    if (status != ENF_OK)
        return enf_tool_fail(status);
    const char *method = methods[request->def.method], *json = request->json;
    uint32_t *cells = ascending(result.cells, result.cell_count), *objects = ascending(result.objects, result.object_count);
    FILE *out = json && strcmp(json, "-") != 0 ? fopen(json, "w") : stdout;
    int code = ENF_EXIT_OK;
    if (!cells || !objects) {
        fprintf(stderr, "enfilade view: out of memory\n");
        code = ENF_EXIT_INTERNAL;
    } else if (!out) {
        fprintf(stderr, "enfilade view: %s can't be written\n", json);
        code = ENF_EXIT_BAD_INPUT;
    } else if (json)
        print_json(out, view, cells, objects, &stats, method, request->whys);
    else
        print_text(scene, cells, objects, &stats, method);
    if (out && out != stdout && (ferror(out) | fclose(out)) != 0 && code == ENF_EXIT_OK) {
        fprintf(stderr, "enfilade view: %s can't be written\n", json);
        code = ENF_EXIT_INTERNAL;
    }
    free(cells);
    free(objects);
    return code;
}

int enf_cmd_view(int argc, char **argv) {
    ViewRequest request = {.fov = 90, .aspect = 16.0 / 9, .def = enf_default_view_def()};
    EnfScene *scene;
    EnfView *view = NULL;
    EnfCamera camera;
    int code = read_request(argc, argv, &request);
    if (code != ENF_EXIT_OK || !enf_tool_load(request.scene, &scene, &code))
        return code;
    code = find_camera(&request, scene, &camera);
    if (code == ENF_EXIT_OK) {
        EnfStatus status = enf_view_create(scene, &view);
        /* The first query pays for memory and caches; the time of a second one is what a redraw costs. */
        for (int k = 0; k < 2 && status == ENF_OK; k++)
            status = enf_view_query(view, &camera, &request.def);
        code = status == ENF_OK ? print_answer(&request, scene, view) : enf_tool_fail(status);
    }
    enf_view_destroy(view);
    enf_scene_destroy(scene);
    return code;
}
