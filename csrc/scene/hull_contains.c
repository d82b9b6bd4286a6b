/* SPDX-License-Identifier: GPL-3.0-or-later
 * Point in convex hull by walking a simplex towards the point.
 * Based on: Gilbert, Johnson & Keerthi 1988, in the form that only asks inside or outside. */
#include "scene/hull_contains.h"

#include "geometry/vec3.h"

/* Which part of the simplex faces the origin: shrinks it, gives the direction to look in next. 1: the origin
 * is inside. */
static int nearest_line(double s[4][3], int *n, double d[3]) {
    double ab[3], ao[3], t[3];
    vec_sub(ab, s[0], s[1]); /* s[n - 1] is the newest */
    vec_scale(ao, -1, s[1]);
    if (vec_dot(ab, ao) > 0) {
        vec_cross(t, ab, ao);
        vec_cross(d, t, ab);
    } else {
        vec_copy(s[0], s[1]);
        *n = 1;
        vec_copy(d, ao);
    }
    return 0;
}

static int nearest_triangle(double s[4][3], int *n, double d[3]) {
    double ab[3], ac[3], ao[3], normal[3], t[3], a[3];
    vec_copy(a, s[2]);
    vec_sub(ab, s[1], a);
    vec_sub(ac, s[0], a);
    vec_scale(ao, -1, a);
    vec_cross(normal, ab, ac);
    vec_cross(t, normal, ac);
    if (vec_dot(t, ao) > 0 && vec_dot(ac, ao) > 0) {
        vec_copy(s[1], a);
        *n = 2;
        vec_cross(t, ac, ao);
        vec_cross(d, t, ac);
        return 0;
    }
    vec_cross(t, ab, normal);
    if (vec_dot(t, ao) > 0) {
        vec_copy(s[0], s[1]);
        vec_copy(s[1], a);
        *n = 2;
        return nearest_line(s, n, d);
    }
    if (vec_dot(normal, ao) > 0)
        vec_copy(d, normal);
    else { /* keep the triangle counter-clockwise as seen from where we look */
        vec_copy(t, s[0]);
        vec_copy(s[0], s[1]);
        vec_copy(s[1], t);
        vec_scale(d, -1, normal);
    }
    return 0;
}

static int nearest_tetrahedron(double s[4][3], int *n, double d[3]) {
    static const int faces[3][2] = {{2, 1}, {1, 0}, {0, 2}}; /* with the newest, 3: each face and its outward turn */
    double a[3], ao[3];
    vec_copy(a, s[3]);
    vec_scale(ao, -1, a);
    for (int f = 0; f < 3; f++) {
        double ab[3], ac[3], normal[3];
        vec_sub(ab, s[faces[f][0]], a);
        vec_sub(ac, s[faces[f][1]], a);
        vec_cross(normal, ab, ac);
        if (vec_dot(normal, ao) > 0) {
            double b[3], c[3];
            vec_copy(b, s[faces[f][0]]);
            vec_copy(c, s[faces[f][1]]);
            vec_copy(s[0], c);
            vec_copy(s[1], b);
            vec_copy(s[2], a);
            *n = 3;
            return nearest_triangle(s, n, d);
        }
    }
    return 1;
}

/* Sign-safe: the origin is on the inner side of all four faces by more than rounding. */
static int strictly_inside(double s[4][3]) {
    for (int i = 0; i < 4; i++) {
        const double *a = s[(i + 1) % 4], *b = s[(i + 2) % 4], *c = s[(i + 3) % 4];
        double ab[3], ac[3], ad[3], normal[3];
        vec_sub(ab, b, a);
        vec_sub(ac, c, a);
        vec_sub(ad, s[i], a);
        vec_cross(normal, ab, ac);
        double towards = vec_dot(normal, ad), origin = -vec_dot(normal, a);
        double size = vec_length(normal) * (vec_length(a) + vec_length(ad));
        if (!(fabs(towards) > 1e-12 * size) || !(fabs(origin) > 1e-12 * size) || (towards > 0) != (origin > 0))
            return 0;
    }
    return 1;
}

int enf_hull_contains(uint32_t count, void (*point)(const void *user, uint32_t i, double out[3]), const void *user, const double at[3]) {
    double s[4][3], d[3] = {1, 0, 0};
    int n = 0;
    if (count < 4)
        return 0;
    for (int round = 0; round < 64; round++) {
        double best = -INFINITY, found[3] = {0, 0, 0};
        for (uint32_t i = 0; i < count; i++) {
            double p[3];
            point(user, i, p);
            vec_sub(p, p, at);
            double reach = vec_dot(p, d);
            if (reach > best) {
                best = reach;
                vec_copy(found, p);
            }
        }
        if (!(best > 0))
            return 0; /* every point lies on one side */
        for (int i = 0; i < n; i++)
            if (vec_equal(s[i], found))
                return 0; /* no progress: on the boundary */
        vec_copy(s[n++], found);
        int inside = 0;
        if (n == 1)
            vec_scale(d, -1, s[0]);
        else if (n == 2)
            inside = nearest_line(s, &n, d);
        else if (n == 3)
            inside = nearest_triangle(s, &n, d);
        else
            inside = nearest_tetrahedron(s, &n, d);
        if (inside)
            return strictly_inside(s);
        if (!(vec_dot(d, d) > 0))
            return 0; /* the origin lies on the simplex */
    }
    return 0;
}
