/* SPDX-License-Identifier: GPL-3.0-or-later
 * Memory that runs out (scarce_memory.h) while scenes are read, cut into cells, committed and written, while the outdoors is cut and
 * looked at from afar, on walks, among occluders, in voxels and in triangles. */
#include "scarce_memory.h"

#include <math.h>
#include <stdio.h>

#include "base/file.h"
#include "base/memory.h"

/* Scenes as text, so that reading them needs no memory that isn't theirs. */
enum { TEXTS_MAX = 8, TEXT_MAX = 1 << 16 };
static struct {
    char bytes[TEXT_MAX];
    uint64_t size;
} texts[TEXTS_MAX];

static void read_texts(void) {
    static const char *const files[TEXTS_MAX] = {"drawn_rooms.enf.json",
                                                 "cameras_of_every_kind.enf.json",
                                                 "window_to_the_exterior.enf.json",
                                                 "l_room_with_a_seam.enf.json",
                                                 "furniture_in_and_between_rooms.enf.json",
                                                 "bad/warn_not_convex_portal.enf.json",
                                                 "stair_hole_through_a_slab.enf.json",
                                                 "bad/ok_prt2.prt"};
    for (int k = 0; k < TEXTS_MAX; ++k) {
        char path[1024], *bytes = NULL;
        snprintf(path, sizeof path, ENF_SOURCE_ROOT "/tests/scenes/%s", files[k]);
        if (enf_file_read(path, &bytes, &texts[k].size) != ENF_OK)
            fail_msg("%s", enf_last_error());
        assert_true(texts[k].size <= TEXT_MAX);
        memcpy(texts[k].bytes, bytes, texts[k].size);
        enf_free(bytes);
    }
}

static void add_counts(Bench *b, const EnfScene *scene) {
    EnfSceneCounts counts;
    memset(&counts, 0, sizeof counts);
    counts.struct_size = (uint32_t)sizeof counts;
    assert_int_equal(enf_scene_counts(scene, &counts), ENF_OK);
    add_hash(b, &counts, sizeof counts);
}

/* Commits; a scene that can't for want of memory does once there is some. */
static EnfStatus commit(EnfScene *scene) {
    EnfStatus status = enf_scene_commit(scene);
    if (status == ENF_ERROR_OUT_OF_MEMORY) {
        left = INT64_MAX;
        assert_int_equal(enf_scene_commit(scene), ENF_OK);
        left = -1; /* something was refused */
    }
    return status;
}

static EnfStatus read_and_commit(Bench *b) {
    EnfStatus status = ENF_OK;
    for (int k = 0; k < TEXTS_MAX && status == ENF_OK; ++k) {
        EnfScene *scene = NULL;
        status = enf_scene_load_memory(texts[k].bytes, texts[k].size, &scene);
        if (status == ENF_OK)
            status = commit(scene);
        else
            assert_null(scene);
        if (status == ENF_OK)
            add_counts(b, scene);
        enf_scene_destroy(scene);
    }
    return status;
}

/* Ends a work that makes a scene: what it holds, if it was made. */
static EnfStatus take_scene(Bench *b, EnfScene *scene, EnfStatus status) {
    if (status == ENF_OK)
        status = commit(scene);
    if (status == ENF_OK)
        add_counts(b, scene);
    enf_scene_destroy(scene);
    return status;
}

/* What is written comes back as it was; what can't be written isn't there, and no part of it. */
#define FILE_NAME "test_scarce_scenes.enf.json"
static EnfStatus write_and_read_back(Bench *b) {
    EnfScene *again = NULL;
    remove(FILE_NAME);
    EnfStatus status = enf_scene_save_json(b->scene, FILE_NAME);
    FILE *written = fopen(FILE_NAME, "rb"), *part = fopen(FILE_NAME ".part", "rb");
    assert_null(part);
    assert_true((written != NULL) == (status == ENF_OK));
    if (written)
        fclose(written);
    if (status == ENF_OK)
        status = enf_scene_load(FILE_NAME, &again);
    status = take_scene(b, again, status);
    remove(FILE_NAME);
    return status;
}

static EnfStatus cut_outdoors(Bench *b) {
    EnfScene *scene = NULL;
    EnfStatus status = enf_scene_load_memory(texts[2].bytes, texts[2].size, &scene);
    if (status == ENF_OK)
        status = enf_scene_decompose_exterior(scene, NULL, NULL);
    return take_scene(b, scene, status);
}

/* A door between two rooms that people drew: cut among the cells of both. */
static EnfStatus draw_rooms(Bench *b) {
    static const double corners[2][6][2] = {{{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 4}, {0, 4}},
                                            {{4, 0}, {8, 0}, {8, 4}, {6, 4}, {6, 2}, {4, 2}}};
    static const double door[4][3] = {{4, 0.5, 0}, {4, 1.5, 0}, {4, 1.5, 2}, {4, 0.5, 2}};
    static const uint32_t ring = 6;
    EnfScene *scene = NULL;
    uint32_t room[2] = {0, 0}, opening, first, count;
    EnfStatus status = enf_scene_create(&scene);
    for (int k = 0; k < 2 && status == ENF_OK; ++k)
        if ((status = enf_scene_add_room(scene, "room", ENF_ROOM_INTERIOR, &room[k])) == ENF_OK)
            status = enf_scene_add_room_prism(scene, room[k], corners[k][0], &ring, 1, 0, 2.5, &first, &count);
    if (status == ENF_OK)
        status = enf_scene_add_opening(scene, "door", ENF_OPENING_DOOR, ENF_STATE_OPEN, &opening);
    if (status == ENF_OK)
        status = enf_scene_join(scene, ENF_SIDE_ROOM, room[0], ENF_SIDE_ROOM, room[1], door[0], 4, 0, opening, &first, &count);
    return take_scene(b, scene, status);
}

/* Level, towards (x, y) from `eye`. */
static EnfCamera towards(const double eye[3], double x, double y) {
    EnfCamera camera = enf_default_camera();
    double way[2] = {x - eye[0], y - eye[1]}, length = hypot(way[0], way[1]);
    const double world[16] = {
        way[1] / length, 0, -way[0] / length, eye[0], -way[0] / length, 0, -way[1] / length, eye[1], 0, 1, 0, eye[2], 0, 0, 0, 1};
    memcpy(camera.world_from_camera, world, sizeof world);
    camera.angle_x = 1.2, camera.angle_y = 0.8;
    return camera;
}

static EnfStatus note(Bench *b, EnfView *view, uint32_t k, uint32_t of) {
    EnfViewResult result = enf_default_view_result();
    EnfStatus status = enf_view_result(view, &result);
    for (uint32_t i = 0; i < result.cell_count && status == ENF_OK; ++i)
        if ((uint64_t)of * result.cells[i] + k < SEEN_MAX / 2)
            b->seen[of * result.cells[i] + k] = 1;
    for (uint32_t i = 0; i < result.object_count && status == ENF_OK; ++i)
        if ((uint64_t)of * result.objects[i] + k < SEEN_MAX / 2)
            b->seen[SEEN_MAX / 2 + of * result.objects[i] + k] = 1;
    const uint32_t *meshes, *first, *objects;
    uint32_t groups;
    return status == ENF_OK ? enf_view_groups(view, &groups, &meshes, &first, &objects) : status;
}

/* From afar and near by, exact, swept and by choice, with occluders and without; boxes of viewers; a second view beside the first. */
static EnfStatus look_from_outdoors(Bench *b) {
    enum { LOOKS = 12 };
    EnfView *views[2] = {NULL, NULL};
    EnfStatus status = enf_view_create(b->scene, &views[0]);
    if (status == ENF_OK)
        status = enf_view_create_shared(views[0], &views[1]);
    for (uint32_t k = 0; k < LOOKS && status == ENF_OK; ++k) {
        EnfView *view = views[k % 2];
        double far = k < 6 ? 60 : 9, eye[3] = {10 + far * cos(0.55 * k), 10 + far * sin(0.55 * k), 2 + k};
        const double box[6] = {eye[0], eye[1], eye[2], eye[0] + 0.3, eye[1] + 0.2, eye[2] + 0.1};
        EnfCamera camera = towards(eye, 10, 10);
        EnfViewDef def = enf_default_view_def();
        def.outdoors = k % 3, def.occluders = k / 3 % 2, def.occluder_pixels = 64;
        status = k % 4 == 3 ? enf_view_query_region(view, box, &camera, &def) : enf_view_query(view, &camera, &def);
        if (status == ENF_OK)
            status = note(b, view, k, LOOKS);
    }
    enf_view_destroy(views[1]), enf_view_destroy(views[0]);
    return status;
}

/* A walk through the door and along: answers made for a stretch, given again, made anew; then a sweep of a shutter and a panorama. */
static EnfStatus walk(Bench *b) {
    enum { STEPS = 20 };
    EnfView *view = NULL;
    EnfStatus status = enf_view_create(b->scene, &view);
    EnfViewDef def = enf_default_view_def();
    def.reuse_distance = 0.5, def.reuse_angle = 0.2;
    for (uint32_t k = 0; k < STEPS + 2 && status == ENF_OK; ++k) {
        double eye[3] = {3 + 0.12 * k, 6, 1.6}, next[3] = {3.1 + 0.12 * k, 6, 1.6};
        EnfCamera cameras[2] = {towards(eye, 30, 6 + 0.4 * k), towards(next, 30, 7 + 0.4 * k)};
        if (k == STEPS + 1)
            cameras[0].type = ENF_CAMERA_PANO;
        status = k == STEPS ? enf_view_query_union(view, cameras, 2, 1, &def) : enf_view_query(view, cameras, &def);
        if (status == ENF_OK)
            status = note(b, view, k, STEPS + 2);
    }
    enf_view_destroy(view);
    return status;
}

static EnfStatus work_on_voxels(Bench *b) {
    enum { SIDE = 12, TOTAL = SIDE * SIDE * SIDE };
    static const uint32_t size[3] = {SIDE, SIDE, SIDE};
    static const double origin[3] = {0, 0, 0}, corners[6][3] = {{0, 5, 0}, {12, 5, 0}, {12, 5, 12}, {0, 5, 12}, {3, 0, 1}, {7, 11, 9}};
    static const uint32_t triangles[3][3] = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}};
    static const uint8_t reach[3] = {1, 0, 2};
    static uint8_t marks[TOTAL], kinds[TOTAL], down[TOTAL], up[TOTAL];
    static uint32_t labels[TOTAL], names[TOTAL + 1], boxes[TOTAL + 1][6];
    uint32_t count = 0;
    memset(marks, 0, sizeof marks), memset(labels, 0, sizeof labels);
    EnfStatus status = enf_voxels_mark(size, origin, 1, corners[0], 6, 0, triangles[0], 3, 1, marks);
    if (status == ENF_OK)
        status = enf_voxels_runs(size, marks, down, up);
    for (uint32_t i = 0; i < TOTAL; ++i)
        kinds[i] = !marks[i];
    if (status == ENF_OK)
        status = enf_voxels_widen(size, reach, marks);
    if (status == ENF_OK)
        status = enf_voxels_label(size, kinds, labels, &count);
    if (status == ENF_OK)
        status = enf_voxels_grow(size, marks, 0, labels);
    for (uint32_t i = 0; i <= count; ++i)
        names[i] = i / 2;
    if (status == ENF_OK)
        status = enf_voxels_rename(size, names, count, labels);
    if (status == ENF_OK)
        status = enf_voxels_boxes(size, labels, count, boxes[0]);
    if (status == ENF_OK)
        add_hash(b, labels, sizeof labels), add_hash(b, boxes, ((size_t)count + 1) * sizeof *boxes), add_hash(b, down, sizeof down);
    return status;
}

/* Furniture in a room, lit and drawn: triangles, a raycaster that knows them, a picture with its edges and its grain evened out. */
static EnfStatus draw_furniture(Bench *b) {
    enum { WIDE = 20, HIGH = 12 };
    static const double corners[4][3] = {{6, 5, 0.2}, {6, 7, 0.2}, {6, 7, 1.8}, {6, 5, 1.8}}, middle[3] = {5, 6, 1};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}}, materials[2] = {1, 0};
    float depth[WIDE * HIGH], normal[3 * WIDE * HIGH], open[WIDE * HIGH], direct[3 * WIDE * HIGH], surroundings[3 * WIDE * HIGH];
    uint32_t object[WIDE * HIGH];
    EnfTriangles *t = NULL;
    EnfRaycaster *raycaster = NULL;
    EnfMaterial mirror = {.kind = ENF_MATERIAL_MIRROR, .colour = {1, 1, 1}, .ior = 1};
    uint32_t number;
    EnfStatus status = enf_triangles_create(middle, &t);
    if (status == ENF_OK)
        status = enf_triangles_add_material(t, &mirror, &number);
    if (status == ENF_OK)
        status = enf_triangles_add_mesh(t, 7, corners[0], 4, 0, triangles[0], 2, materials, NULL);
    if (status == ENF_OK)
        status = enf_triangles_commit(t);
    if (status == ENF_OK)
        status = enf_raycaster_create(b->scene, &raycaster);
    if (status == ENF_OK)
        status = enf_raycaster_furnish(raycaster, t);
    const double eye[3] = {3, 6, 1.5};
    EnfCamera camera = towards(eye, 10, 6);
    EnfPreview p = enf_default_preview();
    p.width = WIDE, p.height = HIGH, p.threads = b->threads, p.raycaster = raycaster, p.triangles = t;
    p.depth = depth, p.normal = normal, p.open = open, p.direct = direct, p.surroundings = surroundings, p.object = object;
    if (status == ENF_OK)
        status = enf_preview(&p, &camera);
    if (status == ENF_OK)
        status = enf_preview_smooth(open, depth, normal, WIDE, HIGH, b->threads);
    if (status == ENF_OK)
        status = enf_preview_edges(&p, &camera);
    if (status == ENF_OK)
        add_hash(b, object, sizeof object), add_hash(b, depth, sizeof depth), add_hash(b, open, sizeof open);
    enf_raycaster_destroy(raycaster);
    enf_triangles_destroy(t);
    return status;
}

static void memory_may_end_anywhere(void **state) {
    (void)state;
    static const struct {
        Work work;
        const char *what;
    } works[] = {{read_and_commit, "reading"}, {write_and_read_back, "writing"},  {cut_outdoors, "outdoors"},
                 {draw_rooms, "drawn rooms"},  {look_from_outdoors, "from afar"}, {walk, "a walk"},
                 {work_on_voxels, "voxels"}};
    static Bench b;
    read_texts();
    begin_scarce(&b, "office:6,objects=2,windows=1,outdoors=1,occluders=1");
    for (uint32_t k = 0; k < sizeof works / sizeof *works; ++k)
        run_out(works[k].work, works[k].what, &b);
    EnfStatus furnished = draw_furniture(&b);
    for (b.threads = 1; b.threads <= 3 && furnished != ENF_ERROR_IO; b.threads += 2) /* Embree isn't on every platform */
        run_out(draw_furniture, "furniture", &b);
    end_scarce(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(memory_may_end_anywhere)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
