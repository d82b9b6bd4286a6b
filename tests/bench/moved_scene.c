/* SPDX-License-Identifier: GPL-3.0-or-later
 * The same scene elsewhere. */
#include "moved_scene.h"
#include "scene/scene_data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void move_point(const Motion *m, const double p[3], double out[3]) {
    for (int r = 0; r < 3; r++)
        out[r] = m->scale * (m->rotation[r][0] * p[0] + m->rotation[r][1] * p[1] + m->rotation[r][2] * p[2]) + m->offset[r];
}

void random_turn(SightRng *rng, double out[3][3]) {
    double q[4], norm = 0;
    for (int i = 0; i < 4; i++) {
        q[i] = 2 * sight_unit(rng) - 1;
        norm += q[i] * q[i];
    }
    norm = sqrt(norm);
    for (int i = 0; i < 4; i++)
        q[i] /= norm;
    double w = q[0], x = q[1], y = q[2], z = q[3];
    double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                      {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                      {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    memcpy(out, m, sizeof m);
}

EnfScene *moved_scene(const EnfScene *scene, const Motion *m) {
    EnfScene *out;
    int ok = 1;
    if (enf_scene_create(&out) != ENF_OK)
        return NULL;
    for (uint32_t i = 0; i < scene->room_count; i++)
        ok &= enf_scene_add_room(out, scene->rooms[i].name, scene->rooms[i].kind, &(uint32_t){0}) == ENF_OK;
    for (uint32_t i = 0; i < scene->opening_count; i++)
        ok &= enf_scene_add_opening(out, scene->openings[i].name, scene->openings[i].kind, scene->openings[i].state, &(uint32_t){0}) ==
              ENF_OK;
    double(*points)[3] = malloc(sizeof *points * 100000);
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        uint32_t first = scene->cell_vertex_first[c], n = scene->cell_vertex_first[c + 1] - first;
        for (uint32_t i = 0; i < n; i++)
            move_point(m, scene->cell_vertices[first + i], points[i]);
        uint32_t f = scene->cell_face_first[c], faces = scene->cell_face_first[c + 1] - f, sizes[64];
        ok &= faces <= 64;
        for (uint32_t i = 0; i < faces && ok; i++)
            sizes[i] = scene->face_index_first[f + i + 1] - scene->face_index_first[f + i];
        ok &= enf_scene_add_cell(out, scene->cell_rooms[c], scene->cell_openings[c], n ? points[0] : NULL, n, 0, sizes, faces,
                                 faces ? scene->face_indices + scene->face_index_first[f] : NULL, &(uint32_t){0}) == ENF_OK;
    }
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        uint32_t first = scene->portal_vertex_first[p], n = scene->portal_vertex_first[p + 1] - first;
        for (uint32_t i = 0; i < n; i++)
            move_point(m, scene->portal_vertices[first + i], points[i]);
        ok &= enf_scene_add_portal(out, scene->portal_cells[p][0], scene->portal_cells[p][1], points[0], n, 0, scene->portal_openings[p],
                                   &(uint32_t){0}) == ENF_OK;
    }
    for (uint32_t o = 0; o < scene->object_count; o++) {
        const double *b = scene->objects[o].bounds;
        double bounds[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
        for (int k = 0; k < 8; k++) {
            double corner[3] = {b[(k & 1) ? 3 : 0], b[(k & 2) ? 4 : 1], b[(k & 4) ? 5 : 2]}, q[3];
            move_point(m, corner, q);
            for (int c = 0; c < 3; c++) {
                bounds[c] = fmin(bounds[c], q[c]);
                bounds[3 + c] = fmax(bounds[3 + c], q[c]);
            }
        }
        const uint32_t *cells;
        uint32_t n;
        ok &= enf_scene_object_cells(scene, o, &cells, &n) == ENF_OK;
        ok &= enf_scene_add_object(out, "", bounds, cells, n, scene->objects[o].mesh, &(uint32_t){0}) == ENF_OK;
    }
    free(points);
    if (ok)
        return out;
    enf_scene_destroy(out);
    return NULL;
}

void random_level_turn(SightRng *rng, double out[3][3]) {
    double angle = 6.283185307179586 * sight_unit(rng);
    double m[3][3] = {{cos(angle), -sin(angle), 0}, {sin(angle), cos(angle), 0}, {0, 0, 1}};
    memcpy(out, m, sizeof m);
}
