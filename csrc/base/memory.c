/* SPDX-License-Identifier: GPL-3.0-or-later
 * Allocation through the hooks, with live and peak byte counters. */
#include "base/memory.h"
#include "base/status.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Before each block: its size, padded so that the block keeps malloc's 16-byte alignment. */
enum { HEADER = 16 };

static void *default_alloc(void *user, size_t size) {
    (void)user;
    return malloc(size);
}

static void default_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

/* The one pair of process-wide hooks. */
static EnfAllocFn alloc_hook = default_alloc;
static EnfFreeFn free_hook = default_free;
static void *hook_user;
static _Atomic uint64_t live_bytes, peak_bytes;

EnfStatus enf_set_allocator(EnfAllocFn alloc, EnfFreeFn free_fn, void *user) {
    if (!alloc != !free_fn)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_set_allocator: give both hooks or neither");
    if (atomic_load(&live_bytes) != 0)
        return enf_fail(ENF_ERROR_STATE, "enf_set_allocator: blocks of the old allocator are still alive");
    alloc_hook = alloc ? alloc : default_alloc;
    free_hook = alloc ? free_fn : default_free;
    hook_user = alloc ? user : NULL;
    return ENF_OK;
}

uint64_t enf_live_bytes(void) {
    return atomic_load(&live_bytes);
}
uint64_t enf_peak_bytes(void) {
    return atomic_load(&peak_bytes);
}

static void count_more(uint64_t size) {
    uint64_t live = atomic_fetch_add(&live_bytes, size) + size;
    uint64_t peak = atomic_load(&peak_bytes);
    while (live > peak && !atomic_compare_exchange_weak(&peak_bytes, &peak, live)) {
    }
}

/* With its header. Never the header alone: a pointer just behind a block's end holds nothing in the eyes of a leak checker. */
static size_t whole(size_t size) {
    return (size ? size : 1) + HEADER;
}

/* The block behind its header. */
static void *counted(unsigned char *raw, size_t size) {
    if (!raw)
        return NULL;
    memcpy(raw, &size, sizeof size);
    count_more(size);
    return raw + HEADER;
}

void *enf_alloc(size_t size) {
    return size > SIZE_MAX / 2 ? NULL : counted(alloc_hook(hook_user, whole(size)), size);
}

void *enf_alloc_array(uint64_t count, size_t element_size) {
    if (element_size && count > SIZE_MAX / 2 / element_size)
        return NULL;
    size_t size = (size_t)count * element_size;
    /* The system's own zeroes: of a large array only the pages that are used are ever touched. */
    if (alloc_hook == default_alloc)
        return counted(calloc(1, whole(size)), size);
    void *block = enf_alloc(size);
    if (block)
        memset(block, 0, size);
    return block;
}

size_t enf_block_size(const void *pointer) {
    if (!pointer)
        return 0;
    size_t size;
    memcpy(&size, (const unsigned char *)pointer - HEADER, sizeof size);
    return size;
}

void enf_free(void *pointer) {
    if (!pointer)
        return;
    size_t size = enf_block_size(pointer);
    atomic_fetch_sub(&live_bytes, size);
    free_hook(hook_user, (unsigned char *)pointer - HEADER, whole(size));
}

void *enf_realloc(void *pointer, size_t size) {
    void *block = enf_alloc(size);
    if (block && pointer) {
        size_t old = enf_block_size(pointer);
        memcpy(block, pointer, old < size ? old : size);
        enf_free(pointer);
    }
    return block;
}

int enf_reserve(void *array, uint64_t count, size_t element_size) {
    void *old;
    memcpy(&old, array, sizeof old);
    /* No division: this stands in inner loops. */
    if (old && !((count | element_size) >> 31) && count * element_size <= enf_block_size(old))
        return 1;
    if (count > SIZE_MAX / 4 / element_size)
        return 0;
    void *block = enf_realloc(old, (size_t)(count + count / 2 + 4) * element_size);
    if (!block)
        return 0;
    memcpy(array, &block, sizeof block);
    return 1;
}

char *enf_strndup(const char *text, size_t length) {
    if (!text)
        return NULL;
    char *copy = enf_alloc(length + 1);
    if (copy) {
        memcpy(copy, text, length);
        copy[length] = 0;
    }
    return copy;
}

char *enf_strdup(const char *text) {
    return text ? enf_strndup(text, strlen(text)) : NULL;
}

EnfStatus enf_fail_memory(void) {
    return enf_fail(ENF_ERROR_OUT_OF_MEMORY, "out of memory");
}
