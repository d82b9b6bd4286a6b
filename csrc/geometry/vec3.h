/* SPDX-License-Identifier: GPL-3.0-or-later
 * Vectors, planes and boxes as plain arrays of double. Boxes: min xyz, max xyz; empty when min > max. */
#ifndef ENF_GEOMETRY_VEC3_H
#define ENF_GEOMETRY_VEC3_H

#include <float.h>
#include <math.h>
#include <string.h>

static inline void vec_set(double out[3], double x, double y, double z) {
    out[0] = x;
    out[1] = y;
    out[2] = z;
}
static inline void vec_copy(double out[3], const double a[3]) {
    out[0] = a[0];
    out[1] = a[1];
    out[2] = a[2];
}
static inline void vec_sub(double out[3], const double a[3], const double b[3]) {
    out[0] = a[0] - b[0];
    out[1] = a[1] - b[1];
    out[2] = a[2] - b[2];
}
static inline void vec_add(double out[3], const double a[3], const double b[3]) {
    out[0] = a[0] + b[0];
    out[1] = a[1] + b[1];
    out[2] = a[2] + b[2];
}
/* out = a + s b */
static inline void vec_mad(double out[3], const double a[3], double s, const double b[3]) {
    out[0] = a[0] + s * b[0];
    out[1] = a[1] + s * b[1];
    out[2] = a[2] + s * b[2];
}
static inline void vec_scale(double out[3], double s, const double a[3]) {
    out[0] = s * a[0];
    out[1] = s * a[1];
    out[2] = s * a[2];
}
static inline double vec_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline void vec_cross(double out[3], const double a[3], const double b[3]) {
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    vec_set(out, x, y, z);
}
static inline double vec_length(const double a[3]) {
    return sqrt(vec_dot(a, a));
}
static inline double vec_distance(const double a[3], const double b[3]) {
    double d[3];
    vec_sub(d, a, b);
    return vec_length(d);
}
/* Gives the length; a zero vector stays as it is. */
static inline double vec_normalize(double a[3]) {
    double length = vec_length(a);
    if (length > 0.0)
        vec_scale(a, 1.0 / length, a);
    return length;
}
static inline int vec_finite(const double a[3]) {
    return isfinite(a[0]) && isfinite(a[1]) && isfinite(a[2]);
}
static inline int vec_equal(const double a[3], const double b[3]) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static inline void box_empty(double box[6]) {
    vec_set(box, DBL_MAX, DBL_MAX, DBL_MAX);
    vec_set(box + 3, -DBL_MAX, -DBL_MAX, -DBL_MAX);
}
static inline int box_is_empty(const double box[6]) {
    return !(box[0] <= box[3] && box[1] <= box[4] && box[2] <= box[5]);
}
static inline void box_add_point(double box[6], const double p[3]) {
    for (int k = 0; k < 3; k++) {
        if (p[k] < box[k])
            box[k] = p[k];
        if (p[k] > box[3 + k])
            box[3 + k] = p[k];
    }
}
static inline void box_add_box(double box[6], const double other[6]) {
    for (int k = 0; k < 3; k++) {
        if (other[k] < box[k])
            box[k] = other[k];
        if (other[3 + k] > box[3 + k])
            box[3 + k] = other[3 + k];
    }
}
static inline void box_grow(double box[6], double by) {
    for (int k = 0; k < 3; k++) {
        box[k] -= by;
        box[3 + k] += by;
    }
}
static inline int box_touches_box(const double a[6], const double b[6]) {
    return a[0] <= b[3] && b[0] <= a[3] && a[1] <= b[4] && b[1] <= a[4] && a[2] <= b[5] && b[2] <= a[5];
}
static inline int box_holds_point(const double a[6], const double p[3]) {
    return a[0] <= p[0] && p[0] <= a[3] && a[1] <= p[1] && p[1] <= a[4] && a[2] <= p[2] && p[2] <= a[5];
}
/* Squared; 0 within. */
static inline double box_distance2(const double a[6], const double p[3]) {
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double d = fmax(0, fmax(a[k] - p[k], p[k] - a[3 + k]));
        sum += d * d;
    }
    return sum;
}
static inline double box_diagonal(const double a[6]) {
    return box_is_empty(a) ? 0.0 : vec_distance(a, a + 3);
}
/* Half the surface: what a hierarchy's cost grows with. */
static inline double box_half_area(const double a[6]) {
    double x = a[3] - a[0], y = a[4] - a[1], z = a[5] - a[2];
    return box_is_empty(a) ? 0.0 : x * y + y * z + z * x;
}

#endif
