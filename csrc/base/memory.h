/* SPDX-License-Identifier: GPL-3.0-or-later
 * Allocation through the hooks, with live and peak byte counters. NULL means out of memory: callers return
 * enf_fail_memory(). Every block knows its size, so enf_free needs none and arrays grow without a capacity
 * field. */
#ifndef ENF_BASE_MEMORY_H
#define ENF_BASE_MEMORY_H

#include "enfilade/base.h"

/* Uninitialised block, aligned to 16 bytes. size 0 gives a valid unique pointer. Thread-safe. */
void *enf_alloc(size_t size);
/* Zeroed array; NULL also when count * element_size overflows. Thread-safe. */
void *enf_alloc_array(uint64_t count, size_t element_size);
/* As realloc: pointer NULL allocates; on failure NULL and the old block stays. Thread-safe on different
 * blocks. */
void *enf_realloc(void *pointer, size_t size);
void enf_free(void *pointer); /* NULL is fine */
/* Bytes asked for when the block was made; 0 for NULL. */
size_t enf_block_size(const void *pointer);

/* Makes *array (of element_size) hold at least `count` elements, growing by half more than it needs; new
 * elements aren't initialised. Gives 0 and leaves *array alone when memory runs out. `array` is the address
 * of a pointer of any type. */
int enf_reserve(void *array, uint64_t count, size_t element_size);
char *enf_strdup(const char *text); /* NULL stays NULL */
char *enf_strndup(const char *text, size_t length);

EnfStatus enf_fail_memory(void);

#define ENF_NEW(type, count)      ((type *)enf_alloc_array((count), sizeof(type)))
#define ENF_RESERVE(array, count) enf_reserve(&(array), (count), sizeof *(array))

#endif
