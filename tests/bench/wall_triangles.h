/* SPDX-License-Identifier: GPL-3.0-or-later
 * The walls of a scene as triangles, for a general ray tracer to be compared with: faces of cells without the openings in them, and
 * the leaves of closed openings. Shares no code with csrc/raycast. */
#ifndef ENF_TESTS_WALL_TRIANGLES_H
#define ENF_TESTS_WALL_TRIANGLES_H

#include "enfilade/scene.h"

typedef struct WallTriangles {
    float (*vertices)[4]; /* relative to `origin`; the fourth is padding */
    uint32_t (*triangles)[3];
    uint32_t *surfaces; /* [triangles] numbered as in raycast.h */
    uint32_t vertex_count, triangle_count;
    double origin[3];
} WallTriangles;

/* No corner lies within another triangle's edge: nothing slips through between two. 0: out of memory. */
int wall_triangles_make(const EnfScene *scene, const double origin[3], WallTriangles *out);
void wall_triangles_free(WallTriangles *walls);

#endif
