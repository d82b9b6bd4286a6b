/* SPDX-License-Identifier: GPL-3.0-or-later
 * What a pixel shows: the first object on a line, all objects being solid boxes. Brute force along a walked line; shares no code
 * with the engines. For tests and benchmarks of occluders. */
#ifndef ENF_TESTS_SIGHT_PIXELS_H
#define ENF_TESTS_SIGHT_PIXELS_H

#include "sight_walker.h"

typedef struct SightPixels SightPixels;

/* boxes: double[6] an object. NULL: out of memory. */
SightPixels *sight_pixels_create(const EnfScene *scene, const SightWalker *walker, const double (*boxes)[6]);
void sight_pixels_destroy(SightPixels *pixels);

/* The first object that the line from eye (in cell `start`) along `direction` meets in a cell that holds it; ENF_NONE: nothing, or
 * nothing certain (the line passes an edge too closely, or meets a box outside of its cells). out_cell: where. */
uint32_t sight_first_object(SightPixels *pixels, uint32_t start, const double eye[3], const double direction[3], uint32_t *out_cell);

/* The first object on the line whatever lies between; slow. Where the outside has no shape a walked line may pass through a house. */
uint32_t sight_nearest_box(const SightPixels *pixels, const double eye[3], const double direction[3]);

#endif
