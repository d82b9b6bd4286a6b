/* SPDX-License-Identifier: GPL-3.0-or-later
 * The first solid box on a line, by slabs. */
#include "sight_pixels.h"

#include <math.h>
#include <stdlib.h>

struct SightPixels {
    const EnfScene *scene;
    const SightWalker *walker;
    const double (*boxes)[6];
    uint32_t *first, *list; /* objects of cells */
    uint32_t objects;
    SightWalk walk;
};

SightPixels *sight_pixels_create(const EnfScene *scene, const SightWalker *walker, const double (*boxes)[6]) {
    SightPixels *p = calloc(1, sizeof *p);
    EnfSceneCounts counts;
    counts.struct_size = sizeof counts;
    if (!p || enf_scene_counts(scene, &counts) != ENF_OK) {
        free(p);
        return NULL;
    }
    p->scene = scene;
    p->walker = walker;
    p->boxes = boxes;
    p->objects = counts.objects;
    p->first = calloc((size_t)counts.cells + 2, sizeof *p->first);
    for (int pass = 0; pass < 2 && p->first; pass++) {
        for (uint32_t o = 0; o < counts.objects; o++) {
            const uint32_t *cells;
            uint32_t n = 0;
            enf_scene_object_cells(scene, o, &cells, &n);
            for (uint32_t i = 0; i < n; i++)
                if (pass == 0)
                    p->first[cells[i] + 2]++;
                else
                    p->list[p->first[cells[i] + 1]++] = o;
        }
        if (pass == 0) {
            for (uint32_t c = 0; c < counts.cells; c++)
                p->first[c + 2] += p->first[c + 1];
            p->list = calloc((size_t)p->first[counts.cells + 1] + 1, sizeof *p->list);
            if (!p->list)
                break;
        }
    }
    if (!p->first || !p->list) {
        sight_pixels_destroy(p);
        return NULL;
    }
    return p;
}

void sight_pixels_destroy(SightPixels *p) {
    if (!p)
        return;
    free(p->first);
    free(p->list);
    free(p);
}

/* Where the line enters the box (0 when it starts inside); infinite when it misses. */
static double enter_box(const double b[6], const double eye[3], const double d[3]) {
    double from = 0, to = INFINITY;
    for (int k = 0; k < 3; k++) {
        double a = (b[k] - eye[k]) / d[k], c = (b[3 + k] - eye[k]) / d[k];
        if (d[k] == 0) {
            if (eye[k] < b[k] || eye[k] > b[3 + k])
                return INFINITY;
            continue;
        }
        from = fmax(from, fmin(a, c));
        to = fmin(to, fmax(a, c));
    }
    return from <= to ? from : INFINITY;
}

uint32_t sight_first_object(SightPixels *p, uint32_t start, const double eye[3], const double direction[3], uint32_t *out_cell) {
    sight_walk(p->walker, start, eye, direction, INFINITY, &p->walk);
    uint32_t best = ENF_NONE;
    double best_t = INFINITY;
    for (uint32_t i = 0; i < p->walk.cell_count; i++)
        for (uint32_t k = p->first[p->walk.cells[i]]; k < p->first[p->walk.cells[i] + 1]; k++) {
            double t = enter_box(p->boxes[p->list[k]], eye, direction);
            if (t < best_t) {
                best_t = t;
                best = p->list[k];
            }
        }
    if (best == ENF_NONE)
        return ENF_NONE;
    const uint32_t *cells;
    uint32_t n = 0;
    enf_scene_object_cells(p->scene, best, &cells, &n);
    for (uint32_t i = 0; i < p->walk.cell_count; i++) {
        double leave = i + 1 < p->walk.cell_count ? p->walk.t_enter[i + 1] : INFINITY;
        if (best_t < p->walk.t_enter[i] || best_t > leave || p->walk.clearance_at[i] < 2e-10)
            continue;
        for (uint32_t k = 0; k < n; k++)
            if (cells[k] == p->walk.cells[i]) {
                *out_cell = cells[k];
                return best;
            }
    }
    return ENF_NONE;
}

uint32_t sight_nearest_box(const SightPixels *p, const double eye[3], const double direction[3]) {
    uint32_t best = ENF_NONE;
    double best_t = INFINITY;
    for (uint32_t o = 0; o < p->objects; o++) {
        double t = enter_box(p->boxes[o], eye, direction);
        if (t < best_t) {
            best_t = t;
            best = o;
        }
    }
    return best;
}
