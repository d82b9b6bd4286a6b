/* SPDX-License-Identifier: GPL-3.0-or-later
 * The search along chains of portals for what is still open in the table. */
#ifndef ENF_FROM_REGION_CHAIN_SEARCH_H
#define ENF_FROM_REGION_CHAIN_SEARCH_H

#include "from_region/bake.h"

/* Decides the open pairs of the table: methods FLOW and EXACT. */
EnfStatus enf_chain_search(EnfRegionBake *bake);

#endif
