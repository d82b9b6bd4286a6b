/* SPDX-License-Identifier: GPL-3.0-or-later
 * Reflection and refraction: the law of Snell and the equations of Fresnel. */
#include "raycast/bounce.h"

#include "geometry/vec3.h"

void enf_reflect(const double direction[3], const double normal[3], double out[3]) {
    vec_mad(out, direction, -2 * vec_dot(direction, normal), normal);
    vec_normalize(out);
}

double enf_fresnel(const double direction[3], const double normal[3], double ior, double reflected[3], double refracted[3]) {
    double n[3], cos_in = -vec_dot(direction, normal), eta = 1 / ior;
    vec_copy(n, normal);
    if (cos_in < 0) { /* from within */
        vec_scale(n, -1, n);
        cos_in = -cos_in;
        eta = ior;
    }
    enf_reflect(direction, n, reflected);
    double sin2 = eta * eta * (1 - cos_in * cos_in);
    if (sin2 >= 1)
        return 1; /* total */
    double cos_out = sqrt(1 - sin2);
    for (int k = 0; k < 3; k++)
        refracted[k] = eta * direction[k] + (eta * cos_in - cos_out) * n[k];
    vec_normalize(refracted);
    double across = (eta * cos_in - cos_out) / (eta * cos_in + cos_out), along = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    return 0.5 * (across * across + along * along);
}
