/* SPDX-License-Identifier: GPL-3.0-or-later
 * Memory for the values that jansson decodes: taken in a few large blocks through the library's hooks, given back all at once. */
#ifndef ENF_BASE_JSON_ARENA_H
#define ENF_BASE_JSON_ARENA_H

#include <jansson.h>
#include <setjmp.h>
#include <stddef.h>

typedef struct EnfJsonArena {
    struct EnfJsonBlock *newest; /* the largest; older ones hang on it */
    size_t used;                 /* bytes of it */
    int exhausted;               /* the last decoding ended for want of memory */
    jmp_buf out;
} EnfJsonArena;

/* Decodes one value of any kind, which may be followed by more text: error->position says where it ends. Numbers are reals, keys
 * stand once, strings hold no NUL. It is read only (no json_decref) and lives until the arena is reset. NULL: *error or
 * arena->exhausted say why. Safe on different arenas. */
json_t *enf_json_arena_load(EnfJsonArena *arena, const char *text, size_t size, json_error_t *error);
/* Forgets all values; the largest block is kept for the next ones. */
void enf_json_arena_reset(EnfJsonArena *arena);
void enf_json_arena_free(EnfJsonArena *arena);

#endif
