/* SPDX-License-Identifier: GPL-3.0-or-later
 * Threads: every task runs once, for any number of threads; waiting and waking. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/memory.h"
#include "base/threads.h"
#include "base/timer.h"

static uint32_t runs[1000], bad_thread;

static void count_run(void *context, uint64_t task, uint32_t thread) {
    runs[task]++;
    if (thread >= *(const uint32_t *)context)
        bad_thread = 1;
}

static void every_task_runs_once_on_any_number_of_threads(void **state) {
    (void)state;
    for (uint32_t threads = 1; threads <= 16; threads++) {
        for (int i = 0; i < 1000; i++)
            runs[i] = 0;
        enf_parallel_for(1000, threads, count_run, &threads);
        for (int i = 0; i < 1000; i++)
            assert_int_equal(runs[i], 1);
    }
    uint32_t one = 1;
    enf_parallel_for(0, 4, count_run, &one);
    assert_int_equal(bad_thread, 0);
    assert_true(enf_processor_count() >= 1);
}

typedef struct Meeting {
    EnfMutex *mutex;
    EnfCondition *condition;
    int value;
} Meeting;

static void set_value(void *pointer) {
    Meeting *m = pointer;
    enf_mutex_lock(m->mutex);
    m->value = 42;
    enf_condition_wake_all(m->condition);
    enf_mutex_unlock(m->mutex);
}

static void a_waiting_thread_is_woken(void **state) {
    (void)state;
    Meeting m = {enf_mutex_create(), enf_condition_create(), 0};
    EnfThread *thread = enf_thread_start(set_value, &m);
    assert_non_null(thread);
    enf_mutex_lock(m.mutex);
    while (m.value == 0)
        enf_condition_wait(m.condition, m.mutex);
    enf_mutex_unlock(m.mutex);
    enf_thread_join(thread);
    enf_mutex_destroy(m.mutex);
    enf_condition_destroy(m.condition);
    assert_int_equal(m.value, 42);
    assert_int_equal(enf_live_bytes(), 0);
}

static void clocks_do_not_go_back(void **state) {
    (void)state;
    double wall = enf_wall_seconds(), cpu = enf_cpu_seconds(), own = enf_thread_cpu_seconds();
    for (int i = 0; i < 1000; i++) {
        double w = enf_wall_seconds(), c = enf_cpu_seconds(), o = enf_thread_cpu_seconds();
        assert_true(w >= wall && c >= cpu && o >= own);
        wall = w;
        cpu = c;
        own = o;
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_task_runs_once_on_any_number_of_threads),
        cmocka_unit_test(a_waiting_thread_is_woken),
        cmocka_unit_test(clocks_do_not_go_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
