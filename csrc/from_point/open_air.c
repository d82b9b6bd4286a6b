/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cells outdoors, before anything is clipped: which an eye sees whole, in which order they come, and where exactness pays.
 *
 * A straight way from the eye into a convex cell enters it by a face that looks at the eye; when all of these lead to cells that
 * are seen whole themselves, so is this one: of a building seen from outside only what it stands before needs apertures. The
 * same faces tell an order in which each cell has all its apertures by the time it is visited. And where nothing is that could
 * be hidden, neither in the cell nor behind it, one coarse aperture does.
 * Ours; the culling of back walls that remains is Johansson & Roupe's (2009, section 4.3). */
#include "from_point/open_air.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

/* Ways through more cells than this are left to apertures: recursion ends. */
#define DEEPEST 200

/* Portals to other cells outdoors in the face's plane: their area. Lists the cells behind them. */
static double open_area(EnfViewIndex *index, uint32_t c, uint32_t f, uint32_t *count) {
    const EnfScene *scene = index->scene;
    const EnfPlane *plane = &scene->face_planes[f];
    double area = 0, n[3];
    for (uint32_t i = scene->cell_portal_first[c]; i < scene->cell_portal_first[c + 1]; i++) {
        const EnfCellPortal *side = &scene->cell_portals[i];
        uint32_t first = scene->portal_vertex_first[side->portal], corners = scene->portal_vertex_first[side->portal + 1] - first;
        double along = vec_dot(scene->portal_planes[side->portal].n, plane->n) * (side->side ? -1 : 1), local[3];
        vec_sub(local, scene->portal_centres[side->portal], scene->origin);
        if (scene->portal_openings[side->portal] != ENF_NONE || !enf_is_exterior(scene, side->to) || !(along > 0.999) ||
            fabs(vec_dot(plane->n, local) - plane->d) > 4 * scene->tolerance)
            continue;
        area += enf_polygon_normal(n, scene->portal_vertices + first, corners);
        index->open_sources[index->open_source_count + (*count)++] = side->to;
    }
    return area;
}

static double face_area(const EnfScene *scene, uint32_t c, uint32_t f) {
    double sum[3] = {0, 0, 0};
    const double(*v)[3] = (const double(*)[3])(scene->cell_vertices + scene->cell_vertex_first[c]);
    const uint32_t *loop = scene->face_indices + scene->face_index_first[f];
    for (uint32_t i = 1; i + 1 < scene->face_index_first[f + 1] - scene->face_index_first[f]; i++) {
        double a[3], b[3], cross[3];
        vec_sub(a, v[loop[i]], v[loop[0]]);
        vec_sub(b, v[loop[i + 1]], v[loop[0]]);
        vec_cross(cross, a, b);
        vec_add(sum, sum, cross);
    }
    return 0.5 * vec_length(sum);
}

EnfStatus enf_build_open_faces(EnfViewIndex *index) {
    const EnfScene *scene = index->scene;
    uint64_t faces = 0, sources = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++)
        if (enf_is_exterior(scene, c)) {
            faces += scene->cell_face_first[c + 1] - scene->cell_face_first[c];
            sources += scene->cell_portal_first[c + 1] - scene->cell_portal_first[c];
        }
    index->open_faces = ENF_NEW(EnfOpenFace, faces);
    index->open_sources = ENF_NEW(uint32_t, 2 * sources); /* near-parallel faces may share portals */
    if (!index->open_faces || !index->open_sources)
        return enf_fail_memory();
    uint32_t at = 0;
    for (uint32_t c = 0; c < scene->cell_count; c++) {
        EnfViewCell *cell = &index->cells[c];
        cell->face_first = at;
        cell->face_count = 0;
        if (!enf_is_exterior(scene, c))
            continue;
        for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
            EnfOpenFace *face = &index->open_faces[at++];
            uint32_t count = 0;
            double area = index->open_source_count + scene->cell_portal_first[c + 1] - scene->cell_portal_first[c] <= 2 * sources
                              ? open_area(index, c, f, &count)
                              : 0;
            vec_copy(face->n, scene->face_planes[f].n);
            face->d = scene->face_planes[f].d;
            face->source_first = index->open_source_count;
            /* A millionth of it: no gap that anyone drew. */
            face->is_open = area >= (1 - 1e-6) * face_area(scene, c, f);
            face->source_count = count;
            index->open_source_count += count;
            cell->face_count++;
        }
    }
    return ENF_OK;
}

static EnfCellState *look_at(EnfView *view, uint32_t c, const double eye[3], int depth) {
    const EnfViewIndex *index = view->index;
    const EnfViewCell *cell = &index->cells[c];
    EnfCellState *state = enf_touch_state(view, c);
    if (state->flags & ENF_CELL_KNOWN || depth > DEEPEST)
        return state;
    state->flags |= ENF_CELL_KNOWN; /* and not seen whole, should a ring of cells come back to it */
    int open = cell->face_count > 0;
    uint32_t rank = 0;
    for (uint32_t f = cell->face_first; f < cell->face_first + cell->face_count; f++) {
        const EnfOpenFace *face = &index->open_faces[f];
        if (vec_dot(face->n, eye) - face->d <= 0)
            continue;
        open &= face->is_open;
        for (uint32_t i = 0; i < face->source_count; i++) {
            const EnfCellState *source = look_at(view, index->open_sources[face->source_first + i], eye, depth + 1);
            open &= (source->flags & ENF_CELL_OPEN) != 0;
            rank = source->rank > rank ? source->rank : rank;
        }
    }
    state->rank = (uint16_t)(rank < UINT16_MAX ? rank + 1 : rank);
    if (open)
        state->flags |= ENF_CELL_OPEN;
    return state;
}

const EnfCellState *enf_open_air(EnfView *view, uint32_t c) {
    double eye[3];
    vec_sub(eye, view->screens.middle, view->index->origin);
    return look_at(view, c, eye, 0);
}

static int needs_care(EnfView *view, uint32_t c, int depth) {
    const EnfViewIndex *index = view->index;
    const EnfViewCell *cell = &index->cells[c];
    EnfCellState *state = enf_touch_state(view, c);
    const double *eye = view->screens.middle;
    if (state->care || depth > DEEPEST)
        return state->care != ENF_CARE_NONE;
    state->care = ENF_CARE_NONE; /* should a ring of cells come back to it */
    int care = cell->objects.item_count > 0 && view->def.want_objects;
    for (uint32_t s = cell->side_first; s < cell->side_first + cell->side_count && !care; s++) {
        const EnfPortalSide *side = &index->sides[s];
        double q[3];
        vec_sub(q, index->vertices[side->vertex_first], eye);
        if (vec_dot(side->n, q) + side->slack > 0)
            care = index->cells[side->to].flags & ENF_VIEW_CELL_OUTDOORS ? needs_care(view, side->to, depth + 1) : 1;
    }
    state->care = care ? ENF_CARE_EXACT : ENF_CARE_NONE;
    return care;
}

int enf_needs_care(EnfView *view, uint32_t c) {
    return needs_care(view, c, 0);
}
