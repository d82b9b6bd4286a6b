/* SPDX-License-Identifier: GPL-3.0-or-later
 * What tests of views share: cameras, answers as sets, loops over random cameras of a scene. */
#ifndef ENF_TESTS_VIEW_KIT_H
#define ENF_TESTS_VIEW_KIT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "scene/scene_data.h"
#include "level_camera.h"
#include "scene_family.h"
#include "sight_walker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static inline EnfScene *family(const char *spec) {
    EnfScene *scene;
    assert_int_equal(enf_family_build(spec, &scene), ENF_OK);
    if (enf_scene_commit(scene) != ENF_OK)
        fail_msg("%s: %s", spec, enf_last_error());
    return scene;
}

static inline EnfCamera camera_at(const double eye[3], double yaw, double pitch) {
    EnfCamera camera = level_camera(eye, yaw, pitch);
    camera.angle_x = 1.4;
    camera.angle_y = 0.9;
    return camera;
}

static inline EnfCamera random_camera(const EnfScene *scene, const SightWalker *walker, SightRng *rng) {
    double eye[3];
    uint32_t c;
    do
        c = (uint32_t)(sight_next(rng) % scene->cell_count);
    while (scene->cell_vertex_first[c] == scene->cell_vertex_first[c + 1] || !sight_point_in_cell(walker, rng, c, 0, eye));
    return camera_at(eye, 6.283185307 * sight_unit(rng), 0.6 * sight_unit(rng) - 0.3);
}

typedef struct Sets {
    uint8_t *cells, *objects;
    uint32_t cell_count, object_count;
} Sets;

static inline Sets sets_of(const EnfScene *scene, const EnfView *view) {
    EnfViewResult r = enf_default_view_result();
    assert_int_equal(enf_view_result(view, &r), ENF_OK);
    Sets s = {calloc(scene->cell_count + 1, 1), calloc(scene->object_count + 1, 1), r.cell_count, r.object_count};
    for (uint32_t i = 0; i < r.cell_count; i++)
        s.cells[r.cells[i]]++;
    for (uint32_t i = 0; i < r.object_count; i++)
        s.objects[r.objects[i]]++;
    return s;
}

static inline void free_sets(Sets *s) {
    free(s->cells);
    free(s->objects);
}

static inline void assert_subset(const EnfScene *scene, const Sets *part, const Sets *whole, const char *what) {
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (part->cells[c] > whole->cells[c])
            fail_msg("%s: cell %u is missing", what, c);
    for (uint32_t o = 0; o < scene->object_count; o++)
        if (part->objects[o] > whole->objects[o])
            fail_msg("%s: object %u is missing", what, o);
}

static inline Sets query(const EnfScene *scene, EnfView *view, const EnfCamera *camera, const EnfViewDef *def) {
    if (enf_view_query(view, camera, def) != ENF_OK)
        fail_msg("%s", enf_last_error());
    return sets_of(scene, view);
}

/* swept: and from every pose between. */
static inline Sets query_union(const EnfScene *scene, EnfView *view, const EnfCamera *cameras, uint32_t count, uint32_t swept) {
    if (enf_view_query_union(view, cameras, count, swept, NULL) != ENF_OK)
        fail_msg("%s", enf_last_error());
    return sets_of(scene, view);
}

static inline EnfViewStats stats_of(const EnfView *view) {
    EnfViewStats stats = enf_default_view_stats();
    assert_int_equal(enf_view_stats(view, &stats), ENF_OK);
    return stats;
}

static inline void eye_of(const EnfCamera *camera, double eye[3]) {
    for (int c = 0; c < 3; c++)
        eye[c] = camera->world_from_camera[4 * c + 3];
}

/* The point at share s of the way from a to b. */
static inline void between_points(const double a[3], const double b[3], double s, double out[3]) {
    for (int c = 0; c < 3; c++)
        out[c] = a[c] + s * (b[c] - a[c]);
}

/* The whole is exactly what the parts hold together. */
static inline void assert_union(const EnfScene *scene, const Sets *parts, int count, const Sets *whole) {
    for (uint32_t i = 0; i < scene->cell_count + scene->object_count; i++) {
        const int cell = i < scene->cell_count;
        const uint32_t k = cell ? i : i - scene->cell_count;
        uint8_t any = 0;
        for (int p = 0; p < count; p++)
            any |= cell ? parts[p].cells[k] : parts[p].objects[k];
        assert_int_equal(cell ? whole->cells[k] : whole->objects[k], any);
    }
}

#define EACH_CAMERA(spec, count)                                                                                                           \
    EnfScene *scene = family(spec);                                                                                                        \
    SightWalker *walker = sight_walker_create(scene);                                                                                      \
    EnfView *view;                                                                                                                         \
    SightRng rng = {42};                                                                                                                   \
    assert_int_equal(enf_view_create(scene, &view), ENF_OK);                                                                               \
    for (int k = 0; k < (count); k++)

#define END_CAMERAS                                                                                                                        \
    enf_view_destroy(view);                                                                                                                \
    sight_walker_destroy(walker);                                                                                                          \
    enf_scene_destroy(scene)

#endif
