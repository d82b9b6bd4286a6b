/* SPDX-License-Identifier: GPL-3.0-or-later
 * A bake in progress: what its stages share. */
#ifndef ENF_FROM_REGION_BAKE_H
#define ENF_FROM_REGION_BAKE_H

#include "base/job_control.h"
#include "enfilade/region_vis.h"
#include "from_region/pair_table.h"
#include "from_region/region_model.h"
#include "from_region/sightline.h"

typedef struct EnfRegionBake {
    const EnfScene *scene;
    EnfRegionVisDef def;  /* from_cells and state_path are the bake's own copies */
    uint8_t *wanted;      /* [cells] row asked for; NULL: all */
    EnfRegionModel *model;
    EnfPairTable table;
    EnfLineStore lines;
    struct EnfMightSets *might;
    EnfRegionVisStats stats;
    EnfJob *job; /* NULL when run without one */
    double started, deadline; /* wall seconds; deadline 0: none */
} EnfRegionBake;

/* Whether to stop: cancelled, or past the deadline (then stats.interrupted tells which). */
int enf_bake_should_stop(EnfRegionBake *bake);

/* Adds a checked line and marks the open pairs along it visible; a line that proves nothing new isn't kept. Gives the
 * number of unordered pairs it proved, -1 when memory runs out. */
int64_t enf_bake_record_line(EnfRegionBake *bake, const double p[3], const double d[3], const uint32_t *portals,
                             uint32_t count);

/* Sightlines aimed where knowledge ends, from every cell wanted: fills the table with visible pairs. */
EnfStatus enf_seed_sightlines(EnfRegionBake *bake, double effort);

/* The finished result; takes over model and lines. */
EnfStatus enf_region_result_create(EnfRegionBake *bake, EnfRegionVis **out_result);

#endif
