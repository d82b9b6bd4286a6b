/* SPDX-License-Identifier: GPL-3.0-or-later
 * Threads: every task runs once, for any number of threads; waiting and waking. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/batches.h"
#include "base/memory.h"
#include "base/status.h"
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

/* Sums that depend on which batches were entered before a task began: the rule makes them one number. */
typedef struct Ledger {
    uint32_t size, ahead;
    uint64_t given[2000], sum[2], total, entered, fail_at;
    int disorder;
} Ledger;

static void earn(void *context, uint64_t task, uint32_t thread) {
    Ledger *l = context;
    uint64_t batch = task / l->size;
    (void)thread;
    l->given[task] = 3 * (l->ahead ? l->sum[batch & 1] : l->total) + task;
}

static EnfStatus book(void *context, uint64_t first, uint64_t end) {
    Ledger *l = context;
    uint64_t batch = first / l->size;
    l->disorder |= first != l->entered || end - first > l->size;
    for (uint64_t k = first; k < end; ++k)
        l->total = l->total * 31 + l->given[k];
    l->sum[batch & 1] = l->total; /* for the batch after the next */
    l->entered = end;
    return batch == l->fail_at ? enf_fail(ENF_ERROR_BAD_INPUT, "batch %u", (unsigned)batch) : ENF_OK;
}

static uint64_t run_ledger(uint64_t count, uint32_t size, uint32_t ahead, uint32_t threads, uint64_t fail_at, EnfStatus expected) {
    static Ledger l;
    l = (Ledger){.size = size, .ahead = ahead, .fail_at = fail_at};
    EnfBatches batches = {count, size, ahead, threads, earn, book, &l};
    assert_int_equal(enf_run_batches(&batches), expected);
    assert_int_equal(l.entered, expected == ENF_OK ? count : (fail_at + 1) * size);
    assert_int_equal(l.disorder, 0);
    return l.total;
}

static void batches_are_entered_in_order_and_see_what_they_may(void **state) {
    (void)state;
    for (uint32_t ahead = 0; ahead <= 1; ++ahead)
        for (uint32_t size = 1; size <= 33; size += 8)
            for (uint64_t count = 0; count <= 2000; count += 400) {
                uint64_t alone = run_ledger(count, size, ahead, 1, UINT64_MAX, ENF_OK);
                for (uint32_t threads = 2; threads <= 8; threads += 3)
                    assert_int_equal(run_ledger(count, size, ahead, threads, UINT64_MAX, ENF_OK), alone);
            }
    assert_int_equal(enf_live_bytes(), 0);
}

static void an_error_ends_the_batches_and_its_reason_is_told(void **state) {
    (void)state;
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        (void)enf_fail(ENF_ERROR_IO, "something else");
        (void)run_ledger(400, 8, 1, threads, 5, ENF_ERROR_BAD_INPUT);
        assert_string_equal(enf_last_error(), "batch 5");
    }
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
        cmocka_unit_test(batches_are_entered_in_order_and_see_what_they_may),
        cmocka_unit_test(an_error_ends_the_batches_and_its_reason_is_told),
        cmocka_unit_test(a_waiting_thread_is_woken),
        cmocka_unit_test(clocks_do_not_go_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
