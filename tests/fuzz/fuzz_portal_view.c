/* SPDX-License-Identifier: GPL-3.0-or-later
 * Small scenes of boxes on a whole-number grid, joined wherever faces meet, doors closed at random; cameras on the same grid,
 * so that eyes lie on planes, edges and corners. Lines walked by independent code prove what must be in the answers. Solid
 * furniture in the cells hides what lies behind it when the query uses occluders, and nothing else. */
#include "fuzz_common.h"
#include "sight_walker.h"

#include <string.h>

static void join_boxes(EnfScene *scene, double (*boxes)[6], uint32_t count, FuzzBytes *b) {
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = i + 1; j < count; j++)
            for (int axis = 0; axis < 3; axis++) {
                double lo[3], hi[3], polygon[4][3];
                int u = (axis + 1) % 3, v = (axis + 2) % 3;
                if (boxes[i][3 + axis] != boxes[j][axis] && boxes[j][3 + axis] != boxes[i][axis])
                    continue;
                for (int k = 0; k < 3; k++) {
                    lo[k] = fmax(boxes[i][k], boxes[j][k]);
                    hi[k] = fmin(boxes[i][3 + k], boxes[j][3 + k]);
                }
                if (!(lo[u] < hi[u] && lo[v] < hi[v]) || lo[axis] != hi[axis])
                    continue;
                if (fuzz_byte(b) & 1) /* a door smaller than the common face */
                    hi[u] = 0.5 * (lo[u] + hi[u]);
                for (int k = 0; k < 4; k++) {
                    polygon[k][axis] = lo[axis];
                    polygon[k][u] = (k == 1 || k == 2) ? hi[u] : lo[u];
                    polygon[k][v] = k >= 2 ? hi[v] : lo[v];
                }
                uint32_t opening = ENF_NONE;
                if (fuzz_byte(b) % 4 == 0)
                    enf_scene_add_opening(scene, "", ENF_OPENING_DOOR, fuzz_byte(b) % 3, &opening);
                enf_scene_add_portal(scene, i, j, polygon[0], 4, 0, opening, NULL);
            }
}

/* A solid box in eighths of the cell; on its faces, too. */
static void furnish(EnfScene *scene, const double cell[6], uint32_t index, double out[6], FuzzBytes *b) {
    for (int k = 0; k < 3; k++) {
        uint32_t from = fuzz_byte(b) % 8, to = from + 1 + fuzz_byte(b) % (8 - from);
        out[k] = cell[k] + (cell[3 + k] - cell[k]) * from / 8.0;
        out[3 + k] = cell[k] + (cell[3 + k] - cell[k]) * to / 8.0;
    }
    uint32_t object = ENF_NONE;
    enf_scene_add_object(scene, "", out, &index, 1, ENF_NONE, &object);
    enf_scene_set_occluder(scene, object, NULL, 0, NULL, 0);
}

/* Where a line enters a box, 0 from inside; infinite when it misses. */
static double enter_box(const double box[6], const double eye[3], const double d[3]) {
    double from = 0, to = INFINITY;
    for (int k = 0; k < 3; k++) {
        if (d[k] == 0) {
            if (eye[k] < box[k] || eye[k] > box[3 + k])
                return INFINITY;
            continue;
        }
        double a = (box[k] - eye[k]) / d[k], c = (box[3 + k] - eye[k]) / d[k];
        from = fmax(from, fmin(a, c));
        to = fmin(to, fmax(a, c));
    }
    return from <= to ? from : INFINITY;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static SightWalk walk;
    FuzzBytes bytes = {data, data + size}, *b = &bytes;
    EnfScene *scene;
    EnfView *view;
    double boxes[16][6], furniture[16][6];
    uint32_t count = 0;
    if (enf_scene_create(&scene) != ENF_OK)
        return 0;
    enf_scene_add_room(scene, "room", ENF_ROOM_INTERIOR, NULL);
    uint32_t wanted = 2 + fuzz_byte(b) % 14;
    for (uint32_t tries = 0; tries < wanted; tries++) {
        double box[6], corners[8][3];
        int clear = 1;
        for (int k = 0; k < 3; k++) {
            box[k] = fuzz_byte(b) % 6;
            box[3 + k] = box[k] + 1 + fuzz_byte(b) % 3;
        }
        for (uint32_t i = 0; i < count; i++) /* cells don't overlap */
            clear &= box[0] >= boxes[i][3] || box[3] <= boxes[i][0] || box[1] >= boxes[i][4] || box[4] <= boxes[i][1] ||
                     box[2] >= boxes[i][5] || box[5] <= boxes[i][2];
        if (!clear)
            continue;
        memcpy(boxes[count++], box, sizeof box);
        for (int i = 0; i < 8; i++)
            vec_set(corners[i], box[(i & 1) ? 3 : 0], box[(i & 2) ? 4 : 1], box[(i & 4) ? 5 : 2]);
        enf_scene_add_cell(scene, 0, ENF_NONE, corners[0], 8, 0, NULL, 0, NULL, NULL);
        enf_scene_add_object(scene, "", box, &(uint32_t){count - 1}, 1, ENF_NONE, NULL);
    }
    for (uint32_t i = 0; i < count; i++)
        furnish(scene, boxes[i], i, furniture[i], b);
    join_boxes(scene, boxes, count, b);
    SightWalker *walker = enf_scene_commit(scene) == ENF_OK ? sight_walker_create(scene) : NULL;
    if (walker && enf_view_create(scene, &view) == ENF_OK) {
        for (int k = 0; k < 4 && count; k++) {
            EnfCamera camera = enf_default_camera();
            EnfViewDef def = enf_default_view_def();
            uint32_t start = fuzz_byte(b) % count;
            double eye[3], *m = camera.world_from_camera;
            for (int c = 0; c < 3; c++) { /* eighths of the box: its faces, edges and corners among them */
                eye[c] = boxes[start][c] + (boxes[start][3 + c] - boxes[start][c]) * (fuzz_byte(b) % 9) / 8.0;
                m[4 * c + 3] = eye[c];
            }
            int axis = (int)(fuzz_byte(b) % 3), sign = fuzz_byte(b) & 1 ? 1 : -1;
            double turn = (fuzz_byte(b) % 16) * 0.39269908169872414; /* sixteenths of a turn */
            double r[3][3] = {{0}};
            r[axis][2] = sign * cos(turn);
            r[(axis + 1) % 3][2] = sin(turn);
            r[axis][0] = -sin(turn);
            r[(axis + 1) % 3][0] = sign * cos(turn);
            r[(axis + 2) % 3][1] = 1;
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < 3; c++)
                    m[4 * i + c] = r[i][c];
            camera.angle_x = 0.1 + 0.1 * (fuzz_byte(b) % 29);
            camera.angle_y = 0.1 + 0.1 * (fuzz_byte(b) % 29);
            camera.clip_near = 0;
            camera.clip_far = INFINITY;
            def.method = fuzz_byte(b) % 3;
            def.max_apertures = 1 + fuzz_byte(b) % 8;
            def.visit_cap = fuzz_byte(b);
            def.occluders = fuzz_byte(b) % 3;
            def.use_simd = fuzz_byte(b) & 1;
            FUZZ_CHECK(enf_view_query(view, &camera, &def) == ENF_OK);
            EnfViewResult result = enf_default_view_result();
            FUZZ_CHECK(enf_view_result(view, &result) == ENF_OK);
            uint64_t seen_cells = 0, seen_objects = 0;
            for (uint32_t i = 0; i < result.cell_count; i++)
                seen_cells |= 1ull << result.cells[i];
            for (uint32_t i = 0; i < result.object_count; i++)
                seen_objects |= 1ull << result.objects[i];
            for (int ray = 0; ray < 8; ray++) {
                double x = (fuzz_byte(b) - 127.5) / 128, y = (fuzz_byte(b) - 127.5) / 128, d[3];
                for (int i = 0; i < 3; i++)
                    d[i] = x * tan(camera.angle_x / 2) * m[4 * i] + y * tan(camera.angle_y / 2) * m[4 * i + 1] - m[4 * i + 2];
                sight_walk(walker, start, eye, d, INFINITY, &walk);
                double blocked = INFINITY;
                for (uint32_t i = 0; i < count && def.occluders; i++)
                    blocked = fmin(blocked, enter_box(furniture[i], eye, d));
                for (uint32_t i = 0; i < walk.cell_count && walk.clearance_at[i] > 2e-10; i++) {
                    if (i > 0 && walk.t_enter[i] > blocked * (1 - 1e-9))
                        break;
                    FUZZ_CHECK(seen_cells >> walk.cells[i] & 1);
                    /* The object fills its cell: seen wherever the line runs inside. */
                    if (i > 0)
                        FUZZ_CHECK(seen_objects >> walk.cells[i] & 1);
                    double met = enter_box(furniture[walk.cells[i]], eye, d);
                    if (met < INFINITY && met > walk.t_enter[i] && met <= blocked &&
                        (i + 1 == walk.cell_count || met < walk.t_enter[i + 1]) && fabs(x) < 0.99 && fabs(y) < 0.99)
                        FUZZ_CHECK(seen_objects >> (count + walk.cells[i]) & 1);
                }
            }
        }
        enf_view_destroy(view);
    }
    sight_walker_destroy(walker);
    enf_scene_destroy(scene);
    return 0;
}
