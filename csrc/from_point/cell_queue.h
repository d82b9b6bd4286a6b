/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cells that wait for their visit: a heap by distance, and openings between two cells, which don't wait. */
#ifndef ENF_FROM_POINT_CELL_QUEUE_H
#define ENF_FROM_POINT_CELL_QUEUE_H

#include "from_point/view_data.h"

/* Adds a cell at a key of one's own, or where it belongs. Room for one more is made. */
void enf_queue_push(EnfView *view, double key, uint32_t cell);
void enf_queue_add(EnfView *view, uint32_t cell);
/* Fetches what lies behind the portals of a cell that will be visited. */
void enf_queue_prefetch(const EnfView *view, uint32_t cell);
/* The cell to visit next; ENF_NONE: none is left. */
uint32_t enf_queue_next(EnfView *view);

#endif
