/* SPDX-License-Identifier: GPL-3.0-or-later
 * Threads, mutexes and condition variables on POSIX and Windows. */
#ifndef ENF_BASE_THREADS_H
#define ENF_BASE_THREADS_H

#include "enfilade/base.h"

typedef struct EnfThread EnfThread;
typedef struct EnfMutex EnfMutex;
typedef struct EnfCondition EnfCondition;

/* NULL when the system refuses. enf_thread_join waits and frees. */
EnfThread *enf_thread_start(void (*run)(void *argument), void *argument);
void enf_thread_join(EnfThread *thread);

EnfMutex *enf_mutex_create(void);
void enf_mutex_destroy(EnfMutex *mutex); /* NULL is fine */
void enf_mutex_lock(EnfMutex *mutex);
void enf_mutex_unlock(EnfMutex *mutex);

EnfCondition *enf_condition_create(void);
void enf_condition_destroy(EnfCondition *condition);
void enf_condition_wait(EnfCondition *condition, EnfMutex *mutex); /* may wake without cause: test in a loop */
void enf_condition_wake_all(EnfCondition *condition);

/* Processors this process may use; at least 1. */
uint32_t enf_processor_count(void);

/* Runs work(context, task, thread) for task 0 .. task_count - 1 on up to thread_count threads (0: one a
 * processor; the caller is thread 0) and waits. Tasks are taken in ascending order; which thread takes which
 * isn't fixed, so results must be kept per task. Runs on fewer threads when the system refuses more. */
void enf_parallel_for(uint64_t task_count, uint32_t thread_count, void (*work)(void *context, uint64_t task, uint32_t thread),
                      void *context);

#endif
