/* SPDX-License-Identifier: GPL-3.0-or-later
 * Convex decomposition of any polygon on a small grid, as a prism and as a polyhedron: what isn't given up
 * has the shape's volume, and its cells are convex. */
#include "fuzz_common.h"

#include "scene/convex_decomposition.h"

#include <string.h>

static void check(const EnfDecomposition *d) {
    const uint32_t *index = d->face_indices;
    double volume = 0.0;
    for (uint32_t c = 0; c < d->cell_count; c++) {
        double(*p)[3] = d->points + d->cell_point_first[c];
        uint32_t count = d->cell_point_first[c + 1] - d->cell_point_first[c];
        for (uint32_t f = d->cell_face_first[c]; f < d->cell_face_first[c + 1]; index += d->face_sizes[f++])
            for (uint32_t i = 1; i + 1 < d->face_sizes[f]; i++) {
                double a[3], b[3], n[3], local[3];
                vec_sub(a, p[index[i]], p[index[0]]);
                vec_sub(b, p[index[i + 1]], p[index[0]]);
                vec_cross(n, a, b);
                volume += vec_dot(n, p[index[0]]) / 6.0;
                if (vec_normalize(n) > 1e-2) /* slivers have no normal to speak of */
                    for (uint32_t k = 0; k < count; k++) {
                        vec_sub(local, p[k], p[index[0]]);
                        FUZZ_CHECK(vec_dot(n, local) < 1e-2);
                    }
            }
    }
    if (d->cell_count && d->cell_face_first[d->cell_count] && !d->gave_up && !d->not_closed)
        FUZZ_CHECK(fabs(volume - d->shape_volume) < 1e-2 * (1.0 + d->shape_volume));
    for (uint32_t i = 0; i < d->seam_count; i++)
        FUZZ_CHECK(d->seams[i].cells[0] < d->cell_count && d->seams[i].cells[1] < d->cell_count && d->seams[i].count >= 3);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FuzzBytes b = {data, data + size};
    enum { MOST = 40 };
    double xy[2 * MOST][2], v[2 * MOST][3];
    uint32_t n = 3 + fuzz_byte(&b) % (MOST - 3), mode = fuzz_byte(&b), hole = mode & 1 ? 3 + fuzz_byte(&b) % 4 : 0;
    uint32_t sizes[2] = {n, hole};
    for (uint32_t i = 0; i < n + hole; i++)
        for (int k = 0; k < 2; k++) {
            uint32_t byte = fuzz_byte(&b);
            xy[i][k] = byte < 224 ? (double)(byte % 14) : (byte - 224) * 0.37;
        }
    EnfDecomposition d;
    if (enf_decompose_prism(&d, xy[0], sizes, hole ? 2 : 1, 0.0, 3.0) == ENF_OK) {
        check(&d);
        enf_decomposition_free(&d);
    }
    /* The outline as a polyhedron; heights may differ (a sloped or crumpled roof), a face may be missing. */
    uint32_t face_sizes[MOST + 2], indices[6 * MOST], faces = 0, count = 0;
    for (uint32_t i = 0; i < n; i++) {
        vec_set(v[2 * i], xy[i][0], xy[i][1], 0.0);
        vec_set(v[2 * i + 1], xy[i][0], xy[i][1], mode & 2 ? 3.0 + 0.25 * xy[i][0] : mode & 4 ? 1.0 + fuzz_byte(&b) % 3 : 3.0);
    }
    for (uint32_t i = 0; i < n; i++)
        indices[count++] = 2 * (n - 1 - i);
    face_sizes[faces++] = n;
    for (uint32_t i = 0; i < n; i++)
        indices[count++] = 2 * i + 1;
    face_sizes[faces++] = n;
    for (uint32_t i = 0; i < n; i++) {
        uint32_t j = (i + 1) % n, quad[4] = {2 * i, 2 * j, 2 * j + 1, 2 * i + 1};
        memcpy(indices + count, quad, sizeof quad);
        count += 4;
        face_sizes[faces++] = 4;
    }
    if (mode & 8)
        faces--;
    if (enf_decompose_polyhedron(&d, v, 2 * n, face_sizes, faces, indices) == ENF_OK) {
        check(&d);
        enf_decomposition_free(&d);
    }
    FUZZ_CHECK(enf_live_bytes() == 0);
    return 0;
}
