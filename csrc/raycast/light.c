/* SPDX-License-Identifier: GPL-3.0-or-later
 * Lights as Blender has them: point, spot, area, sun; points on them and what arrives from there. */
#include "raycast/light.h"

#include "base/status.h"
#include "geometry/vec3.h"

static const double pi = 3.14159265358979323846;

EnfLight enf_default_light(void) {
    EnfLight light = {.struct_size = sizeof light,
                      .direction = {0, 0, -1},
                      .spot_angle = 0.785398163397448,
                      .spread = pi,
                      .intensity = {1, 1, 1},
                      .reach = INFINITY};
    return light;
}

EnfStatus enf_light_check(const EnfLight *l, uint32_t index) {
    if (l->struct_size != sizeof *l)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "light %u: struct_size is %u, expected %u", index, l->struct_size, (uint32_t)sizeof *l);
    if (l->kind > ENF_LIGHT_SUN)
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: unknown kind %u", index, l->kind);
    if (!vec_finite(l->position) || !vec_finite(l->intensity))
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: its position or intensity isn't finite", index);
    if (l->intensity[0] < 0 || l->intensity[1] < 0 || l->intensity[2] < 0)
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: its intensity is negative", index);
    if (l->kind != ENF_LIGHT_POINT && (!vec_finite(l->direction) || !(vec_length(l->direction) > 0)))
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: its direction is zero or not finite", index);
    if (!(l->radius >= 0) || !isfinite(l->radius) || (l->kind == ENF_LIGHT_SUN && l->radius >= 0.5 * pi))
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: radius %g", index, l->radius);
    if (l->kind == ENF_LIGHT_SPOT && (!(l->spot_angle > 0 && l->spot_angle <= pi) || !(l->spot_blend >= 0 && l->spot_blend <= 1)))
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: cone of %g radians, blend %g", index, l->spot_angle, l->spot_blend);
    if (l->kind == ENF_LIGHT_AREA && (!vec_finite(l->side[0]) || !vec_finite(l->side[1])))
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: its sides aren't finite", index);
    if (l->kind == ENF_LIGHT_AREA && !(l->spread > 0 && l->spread <= pi))
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: spread of %g radians", index, l->spread);
    if (!(l->reach > 0))
        return enf_fail(ENF_ERROR_BAD_INPUT, "light %u: reach %g", index, l->reach);
    return ENF_OK;
}

int enf_light_is_soft(const EnfLight *l) {
    return l->kind == ENF_LIGHT_AREA ? vec_dot(l->side[0], l->side[0]) + vec_dot(l->side[1], l->side[1]) > 0 : l->radius > 0;
}

/* A hash for the start, then the additive recurrence of the plastic number: any run of samples is evenly spread (Roberts, 2018). */
double enf_light_unit(uint32_t seed, uint32_t sample, uint32_t dimension) {
    static const double step[2] = {0.7548776662466927, 0.5698402909980532};
    uint32_t h = seed * 0x9E3779B9u + dimension * 0x85EBCA6Bu;
    h = (h ^ (h >> 16)) * 0x7FEB352Du;
    h = (h ^ (h >> 15)) * 0x846CA68Bu;
    h ^= h >> 16;
    double x = h * (1.0 / 4294967296.0) + sample * step[dimension & 1];
    return x - floor(x);
}

/* Even points of the unit disk. */
static void disk(double u, double v, double out[2]) {
    double r = sqrt(u);
    out[0] = r * cos(2 * pi * v);
    out[1] = r * sin(2 * pi * v);
}

/* Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin: Building an orthonormal basis, revisited, 2017. */
static void across(const double n[3], double x[3], double y[3]) {
    double sign = copysign(1, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
    x[0] = 1 + sign * n[0] * n[0] * a;
    x[1] = sign * b;
    x[2] = -sign * n[0];
    y[0] = b;
    y[1] = sign + n[1] * n[1] * a;
    y[2] = -n[1];
}

/* What a lamp behind a grid sends at `cosine` off its direction, as part of what it would send in the mean: straight in the tangent, nothing
 * beyond half its spread, as Cycles has it. */
static double spread_share(const EnfLight *l, double cosine) {
    if (l->spread >= pi)
        return 1;
    double half = 0.5 * l->spread, widest = tan(half), tangent = sqrt(fmax(0, 1 - cosine * cosine)) / cosine;
    if (!(tangent < widest))
        return 0;
    /* the tangent less its angle cancels for narrow spreads: its series there */
    double gap = half > 0.02 ? widest - half : half * half * half / 3;
    return (widest - tangent) / gap;
}

static double smooth(double x) {
    x = x < 0 ? 0 : x > 1 ? 1 : x;
    return x * x * (3 - 2 * x);
}

/* Moves p, on a line along the unit vector `axis`, to a point of the disk of that radius across it. */
static void move_in_disk(double p[3], const double axis[3], double radius, double u, double v) {
    double x[3], y[3], d[2];
    disk(u, v, d);
    across(axis, x, y);
    vec_mad(p, p, radius * d[0], x);
    vec_mad(p, p, radius * d[1], y);
}

/* The point of an area light at u, v in 0 .. 1; round: of its ellipse. */
static void area_point(const EnfLight *l, double u, double v, int round, double out[3]) {
    double d[2] = {2 * u - 1, 2 * v - 1};
    if (round)
        disk(u, v, d);
    vec_mad(out, l->position, d[0], l->side[0]);
    vec_mad(out, out, d[1], l->side[1]);
}

/* What is left of the strength off the lamp's axis. along: cosine of the angle to it. */
static double fade(const EnfLight *l, double along, double strength) {
    if (l->kind == ENF_LIGHT_AREA) {
        double n[3], area;
        vec_cross(n, l->side[0], l->side[1]);
        area = (l->ellipse ? pi : 4) * vec_length(n);
        return along > 0 ? strength * (along * area * spread_share(l, along)) : 0;
    }
    if (l->kind != ENF_LIGHT_SPOT)
        return strength;
    /* Blender's falloff: the tangent against the cone's, smooth over the blend. */
    double edge = cos(0.5 * l->spot_angle);
    if (!(along > edge))
        return 0;
    if (l->spot_blend > 0)
        strength *= smooth((along - edge) / ((1 - edge) * l->spot_blend));
    return l->cosine ? strength * along : strength;
}

int enf_light_sample(const EnfLight *l, const double point[3], uint32_t sample, uint32_t samples, uint32_t seed, LightSample *out) {
    double axis[3], from[3];
    const int several = samples > 1;
    double u = several ? enf_light_unit(seed, sample, 0) : 0.5, v = several ? enf_light_unit(seed, sample, 1) : 0.5;
    vec_copy(axis, l->direction);
    vec_normalize(axis);
    if (l->kind == ENF_LIGHT_SUN) {
        if (several && l->radius > 0) {
            const double middle[3] = {axis[0], axis[1], axis[2]};
            move_in_disk(axis, middle, tan(l->radius), u, v);
            vec_normalize(axis);
        }
        vec_scale(out->to, -1, axis);
        out->distance = INFINITY;
        vec_copy(out->irradiance, l->intensity);
        return 1;
    }
    vec_copy(from, l->position);
    if (l->kind == ENF_LIGHT_AREA)
        area_point(l, u, v, l->ellipse && several, from);
    else if (several && l->radius > 0) {
        double to[3];
        vec_sub(to, from, point);
        vec_normalize(to);
        move_in_disk(from, to, l->radius, u, v);
    }
    vec_sub(out->to, from, point);
    out->distance = vec_normalize(out->to);
    if (!(out->distance > 0) || out->distance > l->reach)
        return 0;
    double strength = fade(l, -vec_dot(out->to, axis), 1 / (out->distance * out->distance));
    vec_scale(out->irradiance, strength, l->intensity);
    return strength > 0;
}
