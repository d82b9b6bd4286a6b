/* SPDX-License-Identifier: GPL-3.0-or-later
 * Threads, mutexes and condition variables on POSIX and Windows. */
#if !defined(_WIN32)
#define _GNU_SOURCE /* sched_getaffinity: containers and farms give fewer processors than the machine has */
#endif
#include "base/threads.h"
#include "base/memory.h"

#include <stdatomic.h>

#if defined(_WIN32)
#include <windows.h>
struct EnfThread {
    HANDLE handle;
    void (*run)(void *);
    void *argument;
};
struct EnfMutex {
    SRWLOCK lock;
};
struct EnfCondition {
    CONDITION_VARIABLE variable;
};
static DWORD WINAPI thread_main(LPVOID pointer) {
    EnfThread *thread = pointer;
    thread->run(thread->argument);
    return 0;
}
#else
#include <pthread.h>
#include <sched.h>
#include <unistd.h>
struct EnfThread {
    pthread_t handle;
    void (*run)(void *);
    void *argument;
};
struct EnfMutex {
    pthread_mutex_t lock;
};
struct EnfCondition {
    pthread_cond_t variable;
};
static void *thread_main(void *pointer) {
    EnfThread *thread = pointer;
    thread->run(thread->argument);
    return NULL;
}
#endif

EnfThread *enf_thread_start(void (*run)(void *), void *argument) {
    EnfThread *thread = ENF_NEW(EnfThread, 1);
    if (!thread)
        return NULL;
    thread->run = run;
    thread->argument = argument;
#if defined(_WIN32)
    thread->handle = CreateThread(NULL, 0, thread_main, thread, 0, NULL);
    int started = thread->handle != NULL;
#else
    int started = pthread_create(&thread->handle, NULL, thread_main, thread) == 0;
#endif
    if (!started) {
        enf_free(thread);
        return NULL;
    }
    return thread;
}

void enf_thread_join(EnfThread *thread) {
    if (!thread)
        return;
#if defined(_WIN32)
    WaitForSingleObject(thread->handle, INFINITE);
    CloseHandle(thread->handle);
#else
    pthread_join(thread->handle, NULL);
#endif
    enf_free(thread);
}

EnfMutex *enf_mutex_create(void) {
    EnfMutex *mutex = ENF_NEW(EnfMutex, 1);
    if (mutex) {
#if defined(_WIN32)
        InitializeSRWLock(&mutex->lock);
#else
        pthread_mutex_init(&mutex->lock, NULL);
#endif
    }
    return mutex;
}

void enf_mutex_destroy(EnfMutex *mutex) {
    if (!mutex)
        return;
#if !defined(_WIN32)
    pthread_mutex_destroy(&mutex->lock);
#endif
    enf_free(mutex);
}

void enf_mutex_lock(EnfMutex *mutex) {
#if defined(_WIN32)
    AcquireSRWLockExclusive(&mutex->lock);
#else
    pthread_mutex_lock(&mutex->lock);
#endif
}

void enf_mutex_unlock(EnfMutex *mutex) {
#if defined(_WIN32)
    ReleaseSRWLockExclusive(&mutex->lock);
#else
    pthread_mutex_unlock(&mutex->lock);
#endif
}

EnfCondition *enf_condition_create(void) {
    EnfCondition *condition = ENF_NEW(EnfCondition, 1);
    if (condition) {
#if defined(_WIN32)
        InitializeConditionVariable(&condition->variable);
#else
        pthread_cond_init(&condition->variable, NULL);
#endif
    }
    return condition;
}

void enf_condition_destroy(EnfCondition *condition) {
    if (!condition)
        return;
#if !defined(_WIN32)
    pthread_cond_destroy(&condition->variable);
#endif
    enf_free(condition);
}

void enf_condition_wait(EnfCondition *condition, EnfMutex *mutex) {
#if defined(_WIN32)
    SleepConditionVariableSRW(&condition->variable, &mutex->lock, INFINITE, 0);
#else
    pthread_cond_wait(&condition->variable, &mutex->lock);
#endif
}

void enf_condition_wake_all(EnfCondition *condition) {
#if defined(_WIN32)
    WakeAllConditionVariable(&condition->variable);
#else
    pthread_cond_broadcast(&condition->variable);
#endif
}

uint32_t enf_processor_count(void) {
#if defined(_WIN32)
    SYSTEM_INFO info;
    GetSystemInfo(&info);
    return info.dwNumberOfProcessors ? (uint32_t)info.dwNumberOfProcessors : 1;
#else
#if defined(__linux__)
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return (uint32_t)CPU_COUNT(&set);
#endif
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count > 0 ? (uint32_t)count : 1;
#endif
}

typedef struct Loop {
    _Atomic uint64_t next;
    uint64_t count;
    void (*work)(void *, uint64_t, uint32_t);
    void *context;
} Loop;

typedef struct LoopThread {
    Loop *loop;
    uint32_t index;
} LoopThread;

static void loop_run(void *pointer) {
    LoopThread *self = pointer;
    for (;;) {
        uint64_t task = atomic_fetch_add(&self->loop->next, 1);
        if (task >= self->loop->count)
            return;
        self->loop->work(self->loop->context, task, self->index);
    }
}

void enf_parallel_for(uint64_t task_count, uint32_t thread_count, void (*work)(void *, uint64_t, uint32_t), void *context) {
    enum { MOST = 256 };
    EnfThread *threads[MOST];
    LoopThread selves[MOST];
    Loop loop = {0, task_count, work, context};
    if (thread_count == 0)
        thread_count = enf_processor_count();
    if (thread_count > MOST)
        thread_count = MOST;
    if (thread_count > task_count)
        thread_count = task_count ? (uint32_t)task_count : 1;
    for (uint32_t i = 0; i < thread_count; i++)
        selves[i] = (LoopThread){&loop, i};
    for (uint32_t i = 1; i < thread_count; i++)
        threads[i] = enf_thread_start(loop_run, &selves[i]);
    loop_run(&selves[0]);
    for (uint32_t i = 1; i < thread_count; i++)
        enf_thread_join(threads[i]);
}
