/* SPDX-License-Identifier: GPL-3.0-or-later
 * Any sequence of scene calls, with arguments made of small whole numbers, some of them hostile. */
#include "fuzz_common.h"

static void add_cell(EnfScene *scene, FuzzBytes *b) {
    double v[12][3];
    uint32_t n = fuzz_byte(b) % 12, sizes[6], indices[36], faces = fuzz_byte(b) % 6, count = 0;
    for (uint32_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            v[i][k] = fuzz_number(b);
    for (uint32_t f = 0; f < faces; f++) {
        sizes[f] = fuzz_byte(b) % 6;
        for (uint32_t i = 0; i < sizes[f]; i++)
            indices[count++] = fuzz_byte(b) % 13;
    }
    enf_scene_add_cell(scene, fuzz_byte(b) % 4 ? fuzz_byte(b) % 3 : ENF_NONE, fuzz_byte(b) % 4 ? ENF_NONE : fuzz_byte(b) % 3, v[0], n, 0,
                       sizes, faces, indices, NULL);
}

static void add_box(EnfScene *scene, FuzzBytes *b) {
    double low[3], high[3], v[8][3];
    for (int k = 0; k < 3; k++) {
        low[k] = fuzz_number(b);
        high[k] = low[k] + 1 + fuzz_byte(b) % 4;
    }
    for (int i = 0; i < 8; i++)
        vec_set(v[i], i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
    enf_scene_add_cell(scene, fuzz_byte(b) % 3, ENF_NONE, v[0], 8, 0, NULL, 0, NULL, NULL);
}

static uint32_t polygon(FuzzBytes *b, double v[8][3]) {
    uint32_t n = fuzz_byte(b) % 8, flat = fuzz_byte(b) % 4;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < 3; k++)
            v[i][k] = k == flat ? 1.0 : fuzz_number(b);
    return n;
}

static void one_call(EnfScene *scene, FuzzBytes *b) {
    double v[8][3], bounds[6];
    uint32_t n, kind = fuzz_byte(b);
    const uint32_t *cells;
    switch (kind % 14) {
    case 0:
        enf_scene_add_room(scene, kind & 16 ? "room" : NULL, fuzz_byte(b) % 3, NULL);
        break;
    case 1:
        add_cell(scene, b);
        break;
    case 2:
    case 3:
        add_box(scene, b);
        break;
    case 4:
        n = polygon(b, v);
        enf_scene_add_portal(scene, fuzz_byte(b) % 5, fuzz_byte(b) % 5, v[0], n, 0, kind & 16 ? ENF_NONE : fuzz_byte(b) % 3, NULL);
        break;
    case 5:
        enf_scene_add_opening(scene, "opening", fuzz_byte(b) % 5, fuzz_byte(b) % 4, NULL);
        break;
    case 6:
        for (int k = 0; k < 6; k++)
            bounds[k] = fuzz_number(b);
        n = fuzz_byte(b) % 4;
        enf_scene_add_object(scene, "object", bounds, (const uint32_t[]){0, 1, 7}, n < 3 ? n : 0, ENF_NONE, NULL);
        break;
    case 7:
        n = polygon(b, v);
        enf_scene_join(scene, fuzz_byte(b) % 3, fuzz_byte(b) % 4, fuzz_byte(b) % 3, fuzz_byte(b) % 4, v[0], n, 0, ENF_NONE, NULL, NULL);
        break;
    case 8: {
        double xy[16][2];
        uint32_t sizes[2] = {3 + fuzz_byte(b) % 9, 2 + fuzz_byte(b) % 3};
        for (uint32_t i = 0; i < sizes[0] + sizes[1]; i++)
            for (int k = 0; k < 2; k++)
                xy[i][k] = fuzz_number(b);
        enf_scene_add_room_prism(scene, fuzz_byte(b) % 3, xy[0], sizes, 1 + fuzz_byte(b) % 2, 0, fuzz_number(b), NULL, NULL);
        break;
    }
    case 9:
        fuzz_commit(scene);
        break;
    case 10:
        enf_scene_set_opening_state(scene, fuzz_byte(b) % 3, fuzz_byte(b) % 4);
        break;
    case 11:
        for (int k = 0; k < 3; k++)
            v[0][k] = fuzz_number(b);
        enf_scene_locate(scene, v[0], &n, 1, &kind);
        break;
    case 12:
        enf_scene_object_cells(scene, fuzz_byte(b) % 3, &cells, &n);
        break;
    default: {
        EnfCamera camera = enf_default_camera();
        camera.type = fuzz_byte(b) % 4;
        camera.angle_x = fuzz_number(b);
        camera.clip_far = fuzz_number(b);
        enf_scene_add_camera(scene, "camera", &camera, NULL);
    }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FuzzBytes bytes = {data, data + size};
    EnfScene *scene;
    FUZZ_CHECK(enf_scene_create(&scene) == ENF_OK);
    for (int calls = 0; bytes.at < bytes.end && calls < 64; calls++)
        one_call(scene, &bytes);
    fuzz_commit(scene);
    for (uint64_t i = 0; i < enf_scene_problem_count(scene); i++) {
        EnfProblem problem;
        FUZZ_CHECK(enf_scene_problem(scene, i, &problem) == ENF_OK && problem.message[0] && problem.code);
    }
    enf_scene_destroy(scene);
    FUZZ_CHECK(enf_live_bytes() == 0);
    return 0;
}
