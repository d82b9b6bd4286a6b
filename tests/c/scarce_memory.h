/* SPDX-License-Identifier: GPL-3.0-or-later
 * Memory that runs out in the middle of some work, at any of its calls, for good or once: a status or a safe answer, and nothing is left
 * behind. */
#ifndef ENF_TESTS_SCARCE_MEMORY_H
#define ENF_TESTS_SCARCE_MEMORY_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "enfilade/enfilade.h"
#include "scene_family.h"

/* A hook that refuses the block after `left` more: that one alone, or all from there on. */
static _Atomic int64_t left;
static int once;
static void *scarce_alloc(void *user, size_t size) {
    (void)user;
    int64_t at = left < INT64_MAX ? atomic_fetch_sub(&left, 1) : 1;
    return at == 0 || (at < 0 && !once) ? NULL : malloc(size);
}
static void scarce_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

/* What an engine's work has to work on, made while there was memory, and what it has shown: seen[k] is 0 or 1, `hash` of an answer that is
 * always the same. */
enum { SEEN_MAX = 1 << 16 };
typedef struct Bench {
    EnfScene *scene;
    EnfRegionVis *whole;
    uint32_t opening, threads;
    uint8_t seen[SEEN_MAX];
    uint64_t hash;
} Bench;

static void add_hash(Bench *b, const void *bytes, size_t size) {
    for (size_t i = 0; i < size; ++i)
        b->hash = (b->hash ^ ((const uint8_t *)bytes)[i]) * 0x100000001B3u;
}

/* Before the first work, and after the last: the scene that all of it stands on, made and given back while there is memory. */
static void begin_scarce(Bench *b, const char *family) {
    left = INT64_MAX;
    assert_int_equal(enf_set_allocator(scarce_alloc, scarce_free, NULL), ENF_OK);
    assert_int_equal(enf_family_build(family, &b->scene), ENF_OK);
    assert_int_equal(enf_scene_commit(b->scene), ENF_OK);
}
static void end_scarce(Bench *b) {
    enf_scene_destroy(b->scene);
    assert_int_equal(enf_live_bytes(), 0);
    assert_int_equal(enf_set_allocator(NULL, NULL, NULL), ENF_OK);
}

typedef EnfStatus (*Work)(Bench *bench);

/* Lets memory run out at call after call: each of the first ones, then at growing distance. */
static void run_out(Work work, const char *what, Bench *b) {
    static uint8_t whole[SEEN_MAX];
    uint64_t before = enf_live_bytes(), hash, failed = 0;
    memset(b->seen, 0, sizeof b->seen), b->hash = 0;
    if (work(b) != ENF_OK)
        fail_msg("%s: %s", what, enf_last_error());
    memcpy(whole, b->seen, sizeof whole), hash = b->hash;
    assert_int_equal(enf_live_bytes(), before);
    for (once = 0; once < 2; ++once)
        for (int64_t allowed = 0, in_a_row = 0; in_a_row < 3; allowed += 1 + allowed / 32) {
            memset(b->seen, 0, sizeof b->seen), b->hash = 0;
            left = allowed;
            EnfStatus status = work(b);
            in_a_row = left > 0 ? in_a_row + 1 : 0; /* nothing was refused */
            left = INT64_MAX;
            if (enf_live_bytes() != before)
                fail_msg("%s: %lld bytes are left when memory ends after %lld blocks%s", what, (long long)(enf_live_bytes() - before),
                         (long long)allowed, once ? " for one" : "");
            if (status != ENF_OK && status != ENF_ERROR_INTERNAL) /* a thread that can't be started */
                assert_int_equal(status, ENF_ERROR_OUT_OF_MEMORY);
            failed += status != ENF_OK;
            for (uint32_t k = 0; k < SEEN_MAX && status == ENF_OK; ++k)
                if (whole[k] && !b->seen[k])
                    fail_msg("%s: %u is hidden when memory ends after %lld blocks%s", what, k, (long long)allowed, once ? " for one" : "");
            if (status == ENF_OK)
                assert_true(b->hash == hash);
        }
    assert_true(failed > 4);
}

#endif
