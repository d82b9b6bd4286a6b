/* SPDX-License-Identifier: GPL-3.0-or-later
 * Tasks in batches on several threads, with what they gave taken in by one thread at a time, in order. */
#ifndef ENF_BASE_BATCHES_H
#define ENF_BASE_BATCHES_H

#include "enfilade/base.h"

/* A batch is entered once all of its tasks have ended and all batches before it were entered. A task of batch b starts when batch
 * b - ahead - 1 has been entered, never earlier: tasks may read what those batches left, but for what entering the batches since
 * may change. So the answer is the same for any number of threads, while nobody waits for one long task. */
typedef struct EnfBatches {
    uint64_t count; /* tasks */
    uint32_t size;  /* tasks a batch; the last one may have fewer */
    uint32_t ahead; /* 0: tasks wait for the batch before; 1: two batches are under way, and entering runs beside them */
    uint32_t threads;
    void (*work)(void *context, uint64_t task, uint32_t thread);
    /* The tasks first .. end - 1; an error ends the loop: no further task starts, no further batch is entered. */
    EnfStatus (*enter)(void *context, uint64_t first, uint64_t end);
    void *context;
} EnfBatches;
/* Gives the first error of `enter`, whose message then belongs to the calling thread. */
EnfStatus enf_run_batches(const EnfBatches *batches);

#endif
