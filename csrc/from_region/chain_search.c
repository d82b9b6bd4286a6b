/* SPDX-License-Identifier: GPL-3.0-or-later
 * The search along chains of portals. */
#include "from_region/chain_search.h"
EnfStatus enf_chain_search(EnfRegionBake *bake) { (void)bake; return ENF_OK; }
