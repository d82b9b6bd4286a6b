/* SPDX-License-Identifier: GPL-3.0-or-later
 * GMP's memory through the library's hooks: counted, and given back by enf_free.
 *
 * These functions stand in for the objects of the static libgmp that would otherwise be linked for them. Those take memory from
 * malloc, and write to stderr when there is none: code that can't be part of a shared library as distributions compile it.
 * GMP has no way to go on without memory: like there, the process would end. So it is never let ask for any (from_region/stab_exact.c):
 * numbers lie in places made for them, and what it needs in between is far below what it takes from the stack (64 KiB). */
#include <gmp.h>
#include <stdlib.h>

#include "base/memory.h"

void *__gmp_default_allocate(size_t size);
void *__gmp_default_reallocate(void *pointer, size_t old_size, size_t size);
void __gmp_default_free(void *pointer, size_t size);

void *__gmp_default_allocate(size_t size) {
    void *pointer = enf_alloc(size);
    if (!pointer)
        abort();
    return pointer;
}

void *__gmp_default_reallocate(void *pointer, size_t old_size, size_t size) {
    (void)old_size;
    pointer = enf_realloc(pointer, size);
    if (!pointer)
        abort();
    return pointer;
}

void __gmp_default_free(void *pointer, size_t size) {
    (void)size;
    enf_free(pointer);
}

void *(*__gmp_allocate_func)(size_t) = __gmp_default_allocate;
void *(*__gmp_reallocate_func)(void *, size_t, size_t) = __gmp_default_reallocate;
void (*__gmp_free_func)(void *, size_t) = __gmp_default_free;

void *_mpz_realloc(mpz_ptr number, mp_size_t limbs) {
    if (limbs < 1)
        limbs = 1;
    number->_mp_d = number->_mp_alloc ? __gmp_default_reallocate(number->_mp_d, 0, (size_t)limbs * sizeof(mp_limb_t))
                                      : __gmp_default_allocate((size_t)limbs * sizeof(mp_limb_t));
    number->_mp_alloc = (int)limbs;
    if (abs(number->_mp_size) > limbs)
        number->_mp_size = 0;
    return number->_mp_d;
}

void __gmp_assert_header(const char *file, int line);
void __gmp_assert_fail(const char *file, int line, const char *what);

void __gmp_assert_header(const char *file, int line) {
    (void)file, (void)line;
}
void __gmp_assert_fail(const char *file, int line, const char *what) {
    (void)file, (void)line, (void)what;
    abort();
}
