/* SPDX-License-Identifier: GPL-3.0-or-later
 * Memory for the values that jansson decodes.
 *
 * A jump leads out of jansson when memory ends: its reader doesn't check every growing buffer (2.14: strbuffer_append_byte in
 * lex_save), so it must never be told that there is none. The jump is safe, as all it holds lies in the arena. jansson is linked
 * statically and hidden: a host that uses jansson has another copy with hooks of its own. */
#include "base/json_arena.h"
#include "base/memory.h"

enum { ALIGNMENT = 16, FIRST_BLOCK = 1 << 14 };

typedef struct EnfJsonBlock {
    _Alignas(ALIGNMENT) struct EnfJsonBlock *older;
} EnfJsonBlock;

static _Thread_local EnfJsonArena *loading; /* the arena of the decoding this thread is in */

static void *take(size_t size) {
    EnfJsonArena *arena = loading;
    if (!arena || size > SIZE_MAX / 4)
        return NULL;
    size = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    size_t held = enf_block_size(arena->newest);
    if (size > held - arena->used) {
        size_t wanted = 2 * held > FIRST_BLOCK ? 2 * held : FIRST_BLOCK;
        EnfJsonBlock *block = enf_alloc(wanted > size + sizeof *block ? wanted : size + sizeof *block);
        if (!block)
            longjmp(arena->out, 1);
        block->older = arena->newest;
        arena->newest = block;
        arena->used = sizeof *block;
    }
    char *taken = (char *)arena->newest + arena->used;
    arena->used += size;
    return taken;
}

static void give_back(void *pointer) {
    (void)pointer; /* with the arena */
}

/* While the library is loaded, before any thread can decode. */
__attribute__((constructor)) static void set_hooks(void) {
    json_set_alloc_funcs(take, give_back);
}

json_t *enf_json_arena_load(EnfJsonArena *arena, const char *text, size_t size, json_error_t *error) {
    static const size_t flags = JSON_DECODE_ANY | JSON_DISABLE_EOF_CHECK | JSON_DECODE_INT_AS_REAL | JSON_REJECT_DUPLICATES;
    loading = arena;
    arena->exhausted = 0;
    if (setjmp(arena->out)) {
        loading = NULL;
        arena->exhausted = 1;
        return NULL;
    }
    json_t *value = json_loadb(text, size, flags, error);
    loading = NULL;
    return value;
}

static void free_blocks(EnfJsonBlock *block) {
    while (block) {
        EnfJsonBlock *older = block->older;
        enf_free(block);
        block = older;
    }
}

void enf_json_arena_reset(EnfJsonArena *arena) {
    if (!arena->newest)
        return;
    free_blocks(arena->newest->older);
    arena->newest->older = NULL;
    arena->used = sizeof *arena->newest;
}

void enf_json_arena_free(EnfJsonArena *arena) {
    free_blocks(arena->newest);
    arena->newest = NULL;
    arena->used = 0;
}

/* json_loadf, which nobody calls, compares with stdin by an address that code in a shared library can't have (Debian's static
 * libjansson isn't built for one): the linker is told to take this for it (--wrap, CMakeLists.txt). */
void *__wrap_stdin;
