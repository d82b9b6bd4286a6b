/* SPDX-License-Identifier: GPL-3.0-or-later
 * Copies a scene through the public calls. */
#include "scene_copy.h"

#include "scene/scene_data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct Motion {
    double c, s, scale;
    const double *move;
} Motion;

/* Points anew in `out`, which must hold 3 * count. */
static void apply(const Motion *m, const double (*points)[3], uint32_t count, double *out) {
    for (uint32_t i = 0; i < count; i++) {
        const double *p = points[i];
        out[3 * i] = m->scale * (m->c * p[0] - m->s * p[1]) + m->move[0];
        out[3 * i + 1] = m->scale * (m->s * p[0] + m->c * p[1]) + m->move[1];
        out[3 * i + 2] = m->scale * p[2] + m->move[2];
    }
}

EnfStatus enf_scene_copy(const EnfScene *scene, double turn, double scale, const double move[3], EnfScene **out_scene) {
    EnfScene *copy = NULL;
    Motion motion = {cos(turn), sin(turn), scale, move};
    uint32_t index, most = 1, most_faces = 1;
    EnfStatus status = enf_scene_create(&copy);
    if (turn == 0)
        motion.c = 1, motion.s = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        uint32_t v = scene->cell_vertex_first[c + 1] - scene->cell_vertex_first[c], f = scene->cell_face_first[c + 1] - scene->cell_face_first[c];
        most = v > most ? v : most;
        most_faces = f > most_faces ? f : most_faces;
    }
    for (uint32_t p = 0; p < scene->portal_count; p++) {
        uint32_t v = scene->portal_vertex_first[p + 1] - scene->portal_vertex_first[p];
        most = v > most ? v : most;
    }
    double *points = malloc(sizeof *points * 3 * most);
    uint32_t *sizes = malloc(sizeof *sizes * most_faces);
    if (!points || !sizes)
        status = ENF_ERROR_OUT_OF_MEMORY;
    for (uint32_t i = 0; i < scene->room_count && status == ENF_OK; i++)
        status = enf_scene_add_room(copy, scene->rooms[i].name, scene->rooms[i].kind, &index);
    for (uint32_t i = 0; i < scene->opening_count && status == ENF_OK; i++)
        status = enf_scene_add_opening(copy, scene->openings[i].name, scene->openings[i].kind, scene->openings[i].state, &index);
    for (uint32_t c = 0; c < scene->cell_count && status == ENF_OK; c++) {
        uint32_t first = scene->cell_vertex_first[c], count = scene->cell_vertex_first[c + 1] - first;
        uint32_t face = scene->cell_face_first[c], faces = scene->cell_face_first[c + 1] - face;
        for (uint32_t f = 0; f < faces; f++)
            sizes[f] = scene->face_index_first[face + f + 1] - scene->face_index_first[face + f];
        apply(&motion, (const double(*)[3])scene->cell_vertices + first, count, points);
        status = enf_scene_add_cell(copy, scene->cell_rooms[c], scene->cell_openings[c], points, count, 0, sizes, faces,
                                    faces ? scene->face_indices + scene->face_index_first[face] : NULL, &index);
    }
    for (uint32_t p = 0; p < scene->portal_count && status == ENF_OK; p++) {
        uint32_t first = scene->portal_vertex_first[p], count = scene->portal_vertex_first[p + 1] - first;
        apply(&motion, (const double(*)[3])scene->portal_vertices + first, count, points);
        status = enf_scene_add_portal(copy, scene->portal_cells[p][0], scene->portal_cells[p][1], points, count, 0, scene->portal_openings[p], &index);
    }
    free(points);
    free(sizes);
    if (status == ENF_OK)
        status = enf_scene_commit(copy);
    if (status != ENF_OK) {
        enf_scene_destroy(copy);
        return status;
    }
    *out_scene = copy;
    return ENF_OK;
}
