/* SPDX-License-Identifier: GPL-3.0-or-later
 * Everything Enfilade's C core offers. */
#ifndef ENFILADE_ENFILADE_H
#define ENFILADE_ENFILADE_H

#include "enfilade/base.h"
#include "enfilade/chain_query.h"
#include "enfilade/job.h"
#include "enfilade/lighting.h"
#include "enfilade/portal_vis.h"
#include "enfilade/preview.h"
#include "enfilade/raycast.h"
#include "enfilade/region_vis.h"
#include "enfilade/scene.h"
#include "enfilade/triangles.h"
#include "enfilade/voxels.h"

#endif
