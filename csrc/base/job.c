/* SPDX-License-Identifier: GPL-3.0-or-later
 * Jobs: a thread, its progress, its end. */
#include "enfilade/job.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "base/job_control.h"
#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "base/timer.h"

struct EnfJob {
    EnfThread *thread;
    EnfMutex *mutex; /* guards what follows it, but for the flag */
    EnfCondition *ended;
    const char *phase;
    double fraction, started, elapsed;
    int done;
    EnfStatus status;
    char message[512];
    void *result;
    void (*destroy_result)(void *result);
    EnfStatus (*work)(EnfJob *job, void *context);
    void *context;
    void (*destroy_context)(void *context);
    atomic_int cancel;
};

static void job_main(void *argument) {
    EnfJob *job = argument;
    EnfStatus status = job->work(job, job->context);
    enf_mutex_lock(job->mutex);
    job->status = status;
    if (status != ENF_OK)
        snprintf(job->message, sizeof job->message, "%s", enf_last_error());
    job->elapsed = enf_wall_seconds() - job->started;
    if (status == ENF_OK)
        job->fraction = 1;
    job->done = 1;
    enf_condition_wake_all(job->ended);
    enf_mutex_unlock(job->mutex);
}

static void job_free(EnfJob *job) {
    if (job->result && job->destroy_result)
        job->destroy_result(job->result);
    if (job->context && job->destroy_context)
        job->destroy_context(job->context);
    enf_condition_destroy(job->ended);
    enf_mutex_destroy(job->mutex);
    enf_free(job);
}

EnfStatus enf_job_start(EnfStatus (*work)(EnfJob *job, void *context), void *context, void (*destroy_context)(void *context),
                        EnfJob **out_job) {
    EnfJob *job = ENF_NEW(EnfJob, 1);
    if (!job)
        return enf_fail_memory();
    job->work = work, job->phase = "", job->started = enf_wall_seconds();
    atomic_init(&job->cancel, 0);
    job->mutex = enf_mutex_create();
    job->ended = enf_condition_create();
    if (!job->mutex || !job->ended) {
        job_free(job);
        return enf_fail_memory();
    }
    job->context = context;
    job->thread = enf_thread_start(job_main, job);
    if (!job->thread) {
        job_free(job); /* destroy_context isn't set yet: a failed start leaves the context to the caller */
        return enf_fail(ENF_ERROR_INTERNAL, "job: the system gives no thread");
    }
    /* Only read by enf_job_destroy, after the join. */
    job->destroy_context = destroy_context;
    *out_job = job;
    return ENF_OK;
}

void enf_job_report(EnfJob *job, const char *phase, double fraction) {
    if (!job)
        return;
    enf_mutex_lock(job->mutex);
    job->phase = phase;
    if (fraction > job->fraction)
        job->fraction = fraction > 1 ? 1 : fraction;
    enf_mutex_unlock(job->mutex);
}

int enf_job_cancelled(const EnfJob *job) {
    return job && atomic_load_explicit(&((EnfJob *)job)->cancel, memory_order_relaxed);
}

void enf_job_set_result(EnfJob *job, void *result, void (*destroy_result)(void *result)) {
    enf_mutex_lock(job->mutex);
    job->result = result, job->destroy_result = destroy_result;
    enf_mutex_unlock(job->mutex);
}

void *enf_job_take_result(EnfJob *job, void (*destroy_result)(void *result)) {
    void *result = NULL;
    enf_mutex_lock(job->mutex);
    if (job->done && job->destroy_result == destroy_result)
        result = job->result, job->result = NULL;
    enf_mutex_unlock(job->mutex);
    return result;
}

int enf_job_ended(const EnfJob *job) {
    enf_mutex_lock(job->mutex);
    int done = job->done;
    enf_mutex_unlock(job->mutex);
    return done;
}

EnfJobProgress enf_default_job_progress(void) {
    EnfJobProgress progress;
    memset(&progress, 0, sizeof progress);
    progress.struct_size = (uint32_t)sizeof progress;
    return progress;
}

EnfStatus enf_job_progress(const EnfJob *job, EnfJobProgress *out) {
    if (!job || !out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "job progress: job or out_progress is NULL");
    if (out->struct_size != sizeof *out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "job progress: struct_size is %u, expected %u", out->struct_size,
                        (unsigned)sizeof *out);
    enf_mutex_lock(job->mutex);
    out->done = (uint32_t)job->done;
    out->fraction = job->fraction;
    out->elapsed_s = job->done ? job->elapsed : enf_wall_seconds() - job->started;
    snprintf(out->phase, sizeof out->phase, "%s", job->phase);
    enf_mutex_unlock(job->mutex);
    return ENF_OK;
}

void enf_job_cancel(EnfJob *job) {
    if (job)
        atomic_store_explicit(&job->cancel, 1, memory_order_relaxed);
}

EnfStatus enf_job_wait(EnfJob *job, double seconds, uint32_t *out_done) {
    if (!job || !out_done)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "job wait: job or out_done is NULL");
    enf_mutex_lock(job->mutex);
    double until = enf_wall_seconds() + seconds;
    while (!job->done) {
        if (seconds < 0)
            enf_condition_wait(job->ended, job->mutex);
        else {
            double left = until - enf_wall_seconds();
            if (left <= 0)
                break;
            enf_mutex_unlock(job->mutex);
            enf_sleep_seconds(left < 0.005 ? left : 0.005);
            enf_mutex_lock(job->mutex);
        }
    }
    *out_done = (uint32_t)job->done;
    EnfStatus status = job->done ? job->status : ENF_OK;
    enf_mutex_unlock(job->mutex);
    return status == ENF_OK ? ENF_OK : enf_fail(status, "%s", job->message);
}

void enf_job_destroy(EnfJob *job) {
    if (!job)
        return;
    enf_job_cancel(job);
    enf_thread_join(job->thread);
    job_free(job);
}
