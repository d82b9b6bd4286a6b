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
            "\"screens\": %u, \"eye_outside\": %u, \"near_in_wall\": %u, \"work\": %llu}}\n",
            s->start_cells, s->visits, s->portals_tested, s->portals_projected, s->apertures, s->apertures_contained, s->apertures_sliver,
            s->merges_exact, s->merges_forced, s->cells_snapped, s->visit_cap_hit, s->budget_hit, s->portals_unclipped, s->objects_tested,
            s->objects_refined, s->objects_unplaced, s->occluder_polygons, s->portals_occluded, s->objects_occluded, s->screens,
            s->eye_outside, s->near_in_wall, (unsigned long long)s->work);
}

static void print_text(const EnfScene *scene, const uint32_t *cells, const uint32_t *objects, const EnfViewStats *s, const char *method) {
    printf("%s: %u cells, %u objects in %.1f microseconds (%u visits, %u start cells)\n", method, s->cells, s->objects, s->microseconds,
           s->visits, s->start_cells);
    if (s->budget_hit || s->eye_outside || s->near_in_wall)
        printf("  %s: the frustum's answer is given\n", s->budget_hit    ? "out of budget"
                                                        : s->eye_outside ? "no cell holds the eye"
                                                                         : "the near plane reaches into a wall");
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

int enf_cmd_view(int argc, char **argv) {
    static const char *const methods[] = {"frustum", "box", "clip"}, *const uses[] = {"off", "on", "auto"};
    const char *path = NULL, *camera_name = NULL, *json = NULL;
    double eye[3], look[3], fov = 90, aspect = 16.0 / 9, distance = INFINITY;
    int have_eye = 0, have_look = 0, whys = 0;
    EnfViewDef def = enf_default_view_def();
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (argv[i][0] != '-') {
            if (path)
                return enf_tool_usage("view", "two scenes: %s and %s", path, argv[i]);
            path = argv[i];
            continue;
        }
        if (strcmp(argv[i], "--why") == 0) {
            whys = 1;
            continue;
        }
        if (!value)
            return enf_tool_usage("view", "%s wants a value", argv[i]);
        int ok = 1;
        if (strcmp(argv[i], "--camera") == 0)
            camera_name = value;
        else if (strcmp(argv[i], "--json") == 0)
            json = value;
        else if (strcmp(argv[i], "--eye") == 0)
            ok = have_eye = read_triple(value, eye);
        else if (strcmp(argv[i], "--look") == 0)
            ok = have_look = read_triple(value, look);
        else if (strcmp(argv[i], "--fov") == 0)
            ok = read_number(value, &fov) && fov > 0 && fov <= 360;
        else if (strcmp(argv[i], "--aspect") == 0)
            ok = read_number(value, &aspect) && aspect > 0;
        else if (strcmp(argv[i], "--distance") == 0)
            ok = read_number(value, &distance) && distance > 0;
        else if (strcmp(argv[i], "--method") == 0) {
            ok = 0;
            for (uint32_t m = 0; m < 3; m++)
                if (strcmp(value, methods[m]) == 0) {
                    def.method = m;
                    ok = 1;
                }
        } else if (strcmp(argv[i], "--occluders") == 0) {
            ok = 0;
            for (uint32_t u = 0; u < 3; u++)
                if (strcmp(value, uses[u]) == 0) {
                    def.occluders = u;
                    ok = 1;
                }
        } else
            return enf_tool_usage("view", "no option %s", argv[i]);
        if (!ok)
            return enf_tool_usage("view", "%s can't be \"%s\"", argv[i], value);
        i++;
    }
    if (!path)
        return enf_tool_usage("view", "no scene given");
    if (!camera_name && !(have_eye && have_look))
        return enf_tool_usage("view", "wants --camera NAME, or --eye X,Y,Z --look X,Y,Z");
    EnfScene *scene;
    EnfView *view = NULL;
    int code;
    if (!enf_tool_load(path, &scene, &code))
        return code;
    EnfCamera camera = enf_default_camera();
    if (camera_name) {
        EnfSceneCounts counts;
        counts.struct_size = sizeof counts;
        enf_scene_counts(scene, &counts);
        uint32_t found = ENF_NONE;
        for (uint32_t i = 0; i < counts.cameras && found == ENF_NONE; i++)
            if (enf_scene_camera_name(scene, i) && strcmp(enf_scene_camera_name(scene, i), camera_name) == 0)
                found = i;
        if (found == ENF_NONE) {
            fprintf(stderr, "enfilade view: %s has no camera \"%s\"; it has %u cameras", path, camera_name, counts.cameras);
            for (uint32_t i = 0; i < counts.cameras && i < 20; i++)
                fprintf(stderr, "%s\"%s\"", i ? ", " : ": ", enf_scene_camera_name(scene, i));
            fprintf(stderr, "\n");
            enf_scene_destroy(scene);
            return ENF_EXIT_BAD_INPUT;
        }
        enf_scene_camera(scene, found, &camera);
    } else if (!aim_camera(&camera, eye, look, fov, aspect)) {
        enf_scene_destroy(scene);
        return enf_tool_usage("view", "--eye and --look are the same point");
    }
    def.distance_limit = distance;
    EnfViewStats stats = enf_default_view_stats();
    EnfViewResult result = enf_default_view_result();
    uint32_t *cells = NULL, *objects = NULL;
    FILE *out = NULL;
    EnfStatus status = enf_view_create(scene, &view);
    if (status == ENF_OK)
        status = enf_view_query(view, &camera, &def);
    /* The first query pays for memory and caches; the time of a second one is what a redraw costs. */
    if (status == ENF_OK)
        status = enf_view_query(view, &camera, &def);
    if (status == ENF_OK)
        status = enf_view_stats(view, &stats);
    if (status == ENF_OK)
        status = enf_view_result(view, &result);
    code = ENF_EXIT_OK;
    if (status != ENF_OK) {
        code = enf_tool_fail(status);
        goto done;
    }
    cells = malloc(sizeof *cells * ((size_t)result.cell_count + 1));
    objects = malloc(sizeof *objects * ((size_t)result.object_count + 1));
    if (!cells || !objects) {
        fprintf(stderr, "enfilade view: out of memory\n");
        code = ENF_EXIT_INTERNAL;
        goto done;
    }
    if (result.cell_count)
        memcpy(cells, result.cells, sizeof *cells * result.cell_count);
    if (result.object_count)
        memcpy(objects, result.objects, sizeof *objects * result.object_count);
    qsort(cells, result.cell_count, sizeof *cells, compare_indices);
    qsort(objects, result.object_count, sizeof *objects, compare_indices);
    if (json) {
        out = strcmp(json, "-") == 0 ? stdout : fopen(json, "w");
        if (!out) {
            fprintf(stderr, "enfilade view: %s can't be written\n", json);
            code = ENF_EXIT_BAD_INPUT;
            goto done;
        }
        print_json(out, view, cells, objects, &stats, methods[def.method], whys);
        if (out != stdout && fclose(out) != 0) {
            fprintf(stderr, "enfilade view: %s can't be written\n", json);
            code = ENF_EXIT_INTERNAL;
        }
    } else
        print_text(scene, cells, objects, &stats, methods[def.method]);
done:
    free(cells);
    free(objects);
    enf_view_destroy(view);
    enf_scene_destroy(scene);
    return code;
}
