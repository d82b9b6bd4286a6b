/* SPDX-License-Identifier: GPL-3.0-or-later
 * Long work as a job: started, polled for progress, cancelled, waited for; it never calls back.
 *
 * Threads: every call on a job may be made from any thread, but only one thread may wait on and destroy it. */
#ifndef ENFILADE_JOB_H
#define ENFILADE_JOB_H

#include "enfilade/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnfJob EnfJob;

typedef struct EnfJobProgress {
    uint32_t struct_size;
    uint32_t done;    /* 1: the work has ended (well, badly or cancelled); enf_job_wait gives its status at once */
    double fraction;  /* 0 .. 1, never falls */
    double elapsed_s; /* wall clock since the start */
    char phase[48];   /* what it is doing, e.g. "sightlines", "search"; "" before the start */
} EnfJobProgress;

ENF_API EnfJobProgress enf_default_job_progress(void);
/* Never blocks. Thread-safe. */
ENF_API EnfStatus enf_job_progress(const EnfJob *job, EnfJobProgress *out_progress);
/* Asks the work to stop soon; what it has by then is kept where the starting call says so. Thread-safe. */
ENF_API void enf_job_cancel(EnfJob *job);
/* Blocks up to `seconds` (negative: without limit). *out_done: 1 when ended, and then the status returned is the
 * work's own: ENF_OK, ENF_ERROR_CANCELLED, ... with its sentence put into this thread's enf_last_error. */
ENF_API EnfStatus enf_job_wait(EnfJob *job, double seconds, uint32_t *out_done);
/* Cancels, waits and frees, with a result nobody took. NULL is fine. */
ENF_API void enf_job_destroy(EnfJob *job);

#ifdef __cplusplus
}
#endif
#endif
