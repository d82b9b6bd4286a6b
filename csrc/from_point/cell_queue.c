/* SPDX-License-Identifier: GPL-3.0-or-later
 * The order of the traversal: cells by squared distance from the eye to their centre, outdoors in the order of sight. */
#include "from_point/cell_queue.h"
#include "from_point/open_air.h"

#include <math.h>

/* Equal distances are ordered by the centres themselves, so that the input's order of cells doesn't matter. */
static int entry_before(const EnfView *view, const EnfHeapEntry *a, const EnfHeapEntry *b) {
    if (a->key != b->key)
        return a->key < b->key;
    const double *ca = view->index->cells[a->cell].centre, *cb = view->index->cells[b->cell].centre;
    for (int i = 0; i < 3; i++)
        if (ca[i] != cb[i])
            return ca[i] < cb[i];
    return a->cell < b->cell;
}

void enf_queue_push(EnfView *view, double key, uint32_t cell) {
    EnfHeapEntry entry = {key, cell};
    uint32_t i = view->heap_count++;
    while (i > 0 && entry_before(view, &entry, &view->heap[(i - 1) / 2])) {
        view->heap[i] = view->heap[(i - 1) / 2];
        i = (i - 1) / 2;
    }
    view->heap[i] = entry;
}

static uint32_t heap_pop(EnfView *view) {
    uint32_t cell = view->heap[0].cell, n = --view->heap_count, i = 0;
    EnfHeapEntry last = view->heap[n];
    for (;;) {
        uint32_t child = 2 * i + 1;
        if (child >= n)
            break;
        if (child + 1 < n && entry_before(view, &view->heap[child + 1], &view->heap[child]))
            child++;
        if (!entry_before(view, &view->heap[child], &last))
            break;
        view->heap[i] = view->heap[child];
        i = child;
    }
    view->heap[i] = last;
    return cell;
}

/* Cells outdoors by their rank: before all rooms when sight starts there, else, and when they are reached again through rooms,
 * after what is seen indoors. */
static double outdoor_key(EnfView *view, uint32_t c) {
    const EnfCellState *state = enf_open_air(view, c);
    double rank = state->rank * (1.0 / 131072);
    return view->starts_outdoors && !(state->flags & ENF_CELL_VISITED) ? -1 + rank : 1e30 * (1 + rank);
}

void enf_queue_add(EnfView *view, uint32_t c) {
    const EnfViewCell *cell = &view->index->cells[c];
    if (cell->flags & ENF_VIEW_CELL_PASSAGE) {
        view->passages[view->passage_count++] = c;
        return;
    }
    const double *eye = view->screens.middle;
    const uint32_t sides = cell->side_count < 6 ? cell->side_count : 6;
    for (uint32_t i = 0; i < sides; i++)
        ENF_PREFETCH(&view->index->sides[cell->side_first + i]);
    for (uint32_t i = 0; i < 4 * sides; i += 2) /* of four corners each, most */
        ENF_PREFETCH(view->index->vertices[cell->vertex_first + i]);
    double x = cell->centre[0] - eye[0], y = cell->centre[1] - eye[1], z = cell->centre[2] - eye[2];
    double key = x * x + y * y + z * z;
    if (cell->flags & ENF_VIEW_CELL_LAST)
        key = INFINITY;
    else if (cell->face_count && view->one_middle)
        key = outdoor_key(view, c);
    enf_queue_push(view, key, c);
}

void enf_queue_prefetch(const EnfView *view, uint32_t c) {
    const EnfViewCell *cell = &view->index->cells[c];
    const EnfPortalSide *sides = &view->index->sides[cell->side_first];
    for (uint32_t i = 0; i < cell->side_count && i < 8; i++) {
        ENF_PREFETCH(&view->states[sides[i].to]);
        ENF_PREFETCH(&view->index->cells[sides[i].to]);
    }
}

uint32_t enf_queue_next(EnfView *view) {
    /* Openings between two cells: nothing is gained by waiting for their turn. */
    if (view->passage_count > 0)
        return view->passages[--view->passage_count];
    return view->heap_count > 0 ? heap_pop(view) : ENF_NONE;
}
