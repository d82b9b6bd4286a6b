/* SPDX-License-Identifier: GPL-3.0-or-later
 * The seams of a decomposed room: where two cells share a piece of a cutting plane, the polygon both faces
 * have in common. */
#include "base/memory.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/convex_decomposition.h"

#include <stdlib.h>

typedef struct Facet {
    uint32_t code, cell, face;
} Facet;

static int compare_facets(const void *left, const void *right) {
    const Facet *a = left, *b = right;
    if (a->code != b->code)
        return a->code < b->code ? -1 : 1;
    return a->cell < b->cell ? -1 : a->cell > b->cell;
}

typedef struct Scratch {
    double (*a)[3], (*b)[3], (*spare)[3];
} Scratch;

/* Corners of the faces win over cut points that are the same but for rounding: seams share corners with their
 * cells bit for bit. A corner that welding moved off the cutting plane is left where the plane has it: a
 * narrow seam would tilt by it, and sight along it would be judged from the wrong side. */
static int snap(const EnfShape *s, const EnfSolid *solid, uint32_t face, double point[3], double (*world)[3]) {
    const EnfSolidFace *f = &solid->faces[face];
    const EnfShapePlane *plane = &s->planes[f->plane / 2];
    for (uint32_t i = 0; i < f->count; i++) {
        uint32_t v = solid->indices[f->first + i];
        double local[3];
        if (vec_distance(s->pool.points[v], point) > 1e-6 * s->eps)
            continue;
        vec_sub(local, world[v], s->centre);
        if (fabs(vec_dot(plane->n, local) - plane->d) <= 1e-12 * s->size + 1e-3 * s->eps) {
            vec_copy(point, world[v]);
            return 1;
        }
    }
    return 0;
}

static int make_seam(EnfDecomposition *out, const EnfShape *s, const EnfSolidList *solids, const Facet *fa, const Facet *fb,
                     double (*world)[3], Scratch *scratch) {
    const EnfSolid *a = &solids->items[fa->cell], *b = &solids->items[fb->cell];
    const EnfSolidFace *face_a = &a->faces[fa->face], *face_b = &b->faces[fb->face];
    uint64_t room = (uint64_t)face_a->count + face_b->count + 2;
    if (!ENF_RESERVE(scratch->a, room) || !ENF_RESERVE(scratch->b, room) || !ENF_RESERVE(scratch->spare, room))
        return 0;
    uint32_t count = face_a->count, none;
    double nb[3];
    /* The face of b looks against the plane's normal (its code is odd). */
    vec_scale(nb, -1.0, s->planes[fb->code / 2].n);
    for (uint32_t i = 0; i < count; i++)
        vec_copy(scratch->a[i], s->pool.points[a->indices[face_a->first + i]]);
    for (uint32_t i = 0; i < face_b->count && count >= 3; i++) {
        const double *p = s->pool.points[b->indices[face_b->first + i]];
        const double *q = s->pool.points[b->indices[face_b->first + (i + 1) % face_b->count]];
        double edge[3], outward[3];
        vec_sub(edge, q, p);
        vec_cross(outward, edge, nb);
        if (vec_normalize(outward) == 0.0)
            continue;
        enf_polygon_split(scratch->a, count, outward, vec_dot(outward, p), s->eps, scratch->b, &count, scratch->spare, &none);
        double(*t)[3] = scratch->a;
        scratch->a = scratch->b;
        scratch->b = t;
    }
    if (count < 3)
        return 1;
    double n[3], longest = 0.0;
    double area = enf_polygon_normal(n, scratch->a, count);
    for (uint32_t i = 0; i < count; i++)
        longest = fmax(longest, vec_distance(scratch->a[i], scratch->a[(i + 1) % count]));
    /* Two faces that only share an edge overlap by rounding: what is narrower than the decomposition's own
     * resolution isn't an opening (tolerance.h: corners that close together are one corner). */
    if (area <= 2.0 * s->eps * longest)
        return 1;
    if (!ENF_RESERVE(out->seams, (uint64_t)out->seam_count + 1))
        return 0;
    EnfSeam *seam = &out->seams[out->seam_count];
    seam->cells[0] = fa->cell;
    seam->cells[1] = fb->cell;
    seam->first = out->seam_count ? out->seams[out->seam_count - 1].first + out->seams[out->seam_count - 1].count : 0;
    seam->count = 0;
    if (!ENF_RESERVE(out->seam_points, (uint64_t)seam->first + count))
        return 0;
    for (uint32_t i = count; i-- > 0;) { /* turned: a's face is counter-clockwise from outside of a */
        double point[3];
        vec_copy(point, scratch->a[i]);
        if (!snap(s, a, fa->face, point, world) && !snap(s, b, fb->face, point, world)) {
            const EnfShapePlane *plane = &s->planes[fa->code / 2];
            vec_mad(point, point, plane->d - vec_dot(plane->n, point), plane->n);
            vec_add(point, point, s->centre);
        }
        if (seam->count && vec_equal(out->seam_points[seam->first + seam->count - 1], point))
            continue;
        vec_copy(out->seam_points[seam->first + seam->count++], point);
    }
    if (seam->count > 1 && vec_equal(out->seam_points[seam->first], out->seam_points[seam->first + seam->count - 1]))
        seam->count--;
    if (seam->count >= 3)
        out->seam_count++;
    return 1;
}

int enf_seams_build(EnfDecomposition *out, const EnfShape *s, const EnfSolidList *solids, double (*world)[3]) {
    Facet *facets = NULL;
    Scratch scratch = {NULL, NULL, NULL};
    double(*boxes)[6] = enf_alloc_array(solids->count, sizeof *boxes);
    uint32_t count = 0;
    int ok = boxes != NULL;
    for (uint32_t c = 0; c < solids->count && ok; c++) {
        enf_solid_bounds(&solids->items[c], &s->pool, boxes[c]);
        box_grow(boxes[c], s->eps);
        for (uint32_t f = 0; f < solids->items[c].face_count && ok; f++)
            if (solids->items[c].faces[f].plane != ENF_NONE && (ok = ENF_RESERVE(facets, (uint64_t)count + 1)))
                facets[count++] = (Facet){solids->items[c].faces[f].plane, c, f};
    }
    if (ok && count)
        qsort(facets, count, sizeof *facets, compare_facets);
    for (uint32_t low = 0; ok && low < count;) {
        uint32_t plane = facets[low].code / 2, middle = low, high;
        while (middle < count && facets[middle].code == 2 * plane)
            middle++;
        for (high = middle; high < count && facets[high].code == 2 * plane + 1;)
            high++;
        for (uint32_t i = low; i < middle && ok; i++)
            for (uint32_t j = middle; j < high && ok; j++)
                if (box_touches_box(boxes[facets[i].cell], boxes[facets[j].cell]))
                    ok = make_seam(out, s, solids, &facets[i], &facets[j], world, &scratch);
        low = high;
    }
    enf_free(facets);
    enf_free(boxes);
    enf_free(scratch.a);
    enf_free(scratch.b);
    enf_free(scratch.spare);
    return ok;
}
