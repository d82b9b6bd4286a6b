/* SPDX-License-Identifier: GPL-3.0-or-later
 * The proven truth for one camera: a plain recursion (no ordering, merging or tolerance; clipping polygons in space by planes
 * through the eye) finds candidates, and a walked line proves each. Slow; for benchmarks and tests of tightness. */
#ifndef ENF_TESTS_SIGHT_TRUTH_H
#define ENF_TESTS_SIGHT_TRUTH_H

#include "sight_walker.h"

typedef struct SightTruth SightTruth;

SightTruth *sight_truth_create(const EnfScene *scene, const SightWalker *walker);
void sight_truth_destroy(SightTruth *truth);

/* Perspective cameras, eye in cell `start`. Gives 0 when more than max_visits were needed: then the sets are a lower bound.
 * boxes: double[6] a object (min xyz, max xyz), NULL: no objects. */
int sight_truth_find(SightTruth *truth, uint32_t start, const EnfCamera *camera, const double (*boxes)[6], uint64_t max_visits);
/* Of the last camera. */
int sight_truth_cell(const SightTruth *truth, uint32_t cell);
int sight_truth_object(const SightTruth *truth, uint32_t object);
uint32_t sight_truth_cells(const SightTruth *truth);
uint32_t sight_truth_objects(const SightTruth *truth);
uint64_t sight_truth_visits(const SightTruth *truth);

#endif
