/* SPDX-License-Identifier: GPL-3.0-or-later
 * What mirrors and glass do to a ray. Internal to the core. */
#ifndef ENF_RAYCAST_BOUNCE_H
#define ENF_RAYCAST_BOUNCE_H

/* direction, normal: unit; normal as the surface is wound (outwards for a body of glass). ior: inside over outside.
 * Gives the share that is reflected (Fresnel, unpolarised; 1: all of it); *refracted is only set below 1. */
double enf_fresnel(const double direction[3], const double normal[3], double ior, double reflected[3], double refracted[3]);
void enf_reflect(const double direction[3], const double normal[3], double out[3]);

#endif
