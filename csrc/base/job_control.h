/* SPDX-License-Identifier: GPL-3.0-or-later
 * The working side of a job: starting one, reporting progress, asking whether to stop, handing over a result. */
#ifndef ENF_BASE_JOB_CONTROL_H
#define ENF_BASE_JOB_CONTROL_H

#include "enfilade/job.h"

/* Runs `work` on a thread of its own. `context` belongs to the job: destroy_context frees it at the end of the job's life.
 * `work` leaves what it made with enf_job_set_result. */
EnfStatus enf_job_start(EnfStatus (*work)(EnfJob *job, void *context), void *context, void (*destroy_context)(void *context),
                        EnfJob **out_job);

/* Called by the work. `phase` must be a string constant. Thread-safe. */
void enf_job_report(EnfJob *job, const char *phase, double fraction);
int enf_job_cancelled(const EnfJob *job); /* NULL: never */
void enf_job_set_result(EnfJob *job, void *result, void (*destroy_result)(void *result));

/* Takes the result of an ended job, NULL when there is none. `destroy_result` tells the kinds of results apart: one of
 * another kind isn't given. */
void *enf_job_take_result(EnfJob *job, void (*destroy_result)(void *result));
int enf_job_ended(const EnfJob *job);

#endif
