/* SPDX-License-Identifier: GPL-3.0-or-later
 * Tasks in batches on several threads, entered in order. */
#include "base/batches.h"

#include <stdio.h>

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"

typedef struct Loop {
    const EnfBatches *batches;
    EnfMutex *mutex; /* guards what follows */
    EnfCondition *moved;
    uint64_t next;       /* task to be taken next */
    uint64_t entered;    /* batches */
    uint32_t unended[2]; /* tasks of even and odd batches */
    int entering;        /* some thread enters the next batch */
    EnfStatus status;
    char message[256];
} Loop;

static uint32_t batch_size(const EnfBatches *b, uint64_t batch) {
    uint64_t first = batch * b->size;
    return first >= b->count ? 0 : b->count - first < b->size ? (uint32_t)(b->count - first) : b->size;
}

/* Enters the next batch; the mutex is held before and after, not meanwhile. */
static void enter_next(Loop *loop) {
    const EnfBatches *b = loop->batches;
    uint64_t batch = loop->entered, first = batch * b->size;
    loop->entering = 1;
    enf_mutex_unlock(loop->mutex);
    EnfStatus status = b->enter(b->context, first, first + batch_size(b, batch));
    enf_mutex_lock(loop->mutex);
    if (status != ENF_OK && loop->status == ENF_OK) {
        loop->status = status;
        snprintf(loop->message, sizeof loop->message, "%s", enf_last_error());
    }
    loop->entering = 0;
    loop->entered = batch + 1;
    loop->unended[batch & 1] = batch_size(b, batch + 2);
    enf_condition_wake_all(loop->moved);
}

static void run_thread(void *context, uint64_t task, uint32_t thread) {
    Loop *loop = context;
    const EnfBatches *b = loop->batches;
    (void)task;
    enf_mutex_lock(loop->mutex);
    while (loop->status == ENF_OK) {
        if (!loop->entering && batch_size(b, loop->entered) && !loop->unended[loop->entered & 1]) {
            enter_next(loop);
            continue;
        }
        if (loop->next >= b->count)
            break; /* who ends the last task, or enters the batch before it, enters what is left */
        uint64_t at = loop->next, batch = at / b->size;
        if (batch > loop->entered + b->ahead) {
            enf_condition_wait(loop->moved, loop->mutex);
            continue;
        }
        ++loop->next;
        enf_mutex_unlock(loop->mutex);
        b->work(b->context, at, thread);
        enf_mutex_lock(loop->mutex);
        --loop->unended[batch & 1];
    }
    enf_mutex_unlock(loop->mutex);
}

EnfStatus enf_run_batches(const EnfBatches *batches) {
    Loop loop = {.batches = batches, .mutex = enf_mutex_create(), .moved = enf_condition_create()};
    loop.unended[0] = batch_size(batches, 0), loop.unended[1] = batch_size(batches, 1);
    uint32_t threads = batches->threads ? batches->threads : 1;
    if (loop.mutex && loop.moved)
        enf_parallel_for(threads, threads, run_thread, &loop);
    else
        loop.status = enf_fail_memory();
    enf_condition_destroy(loop.moved);
    enf_mutex_destroy(loop.mutex);
    return loop.message[0] ? enf_fail(loop.status, "%s", loop.message) : loop.status;
}
