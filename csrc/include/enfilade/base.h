/* SPDX-License-Identifier: GPL-3.0-or-later
 * What every Enfilade call shares: export, status codes, the last error, memory hooks, versions. */
#ifndef ENFILADE_BASE_H
#define ENFILADE_BASE_H

#include <stddef.h>
#include <stdint.h>

#if defined(ENF_STATIC)
#define ENF_API
#elif defined(_WIN32)
#if defined(ENF_BUILD)
#define ENF_API __declspec(dllexport)
#else
#define ENF_API __declspec(dllimport)
#endif
#else
#define ENF_API __attribute__((visibility("default")))
#endif

/* Bumped on any change of a public struct or signature; the shim refuses to work with another number. */
#define ENF_ABI_VERSION 6u

/* "No index": an absent room, opening, cell ... [Type: uint32_t] */
#define ENF_NONE 0xFFFFFFFFu

#ifdef __cplusplus
extern "C" {
#endif

/* What every fallible call returns. Results go through out-pointers, which stay untouched on failure. */
typedef int32_t EnfStatus;
enum {
    ENF_OK = 0,
    ENF_ERROR_INVALID_ARGUMENT = 1, /* a NULL, a bad struct_size, an index out of range: the caller's code is wrong */
    ENF_ERROR_BAD_INPUT = 2,        /* the data is wrong: NaN, dangling reference, truncated file ... */
    ENF_ERROR_IO = 3,               /* a file can't be opened, read or written */
    ENF_ERROR_OUT_OF_MEMORY = 4,
    ENF_ERROR_CANCELLED = 5, /* the job was cancelled; what it had is kept where its documentation says so */
    ENF_ERROR_STATE = 6,     /* a query before enf_scene_commit, an edit that needs an uncommitted scene ... */
    ENF_ERROR_INTERNAL = 7
};

/* A fixed word for a status, e.g. "bad input". Never NULL. Thread-safe. */
ENF_API const char *enf_status_string(EnfStatus status);

/* The sentence of this thread's last failure, with names, indices and values ("portal 17: vertex 3 is NaN").
 * Owned by the library, valid until this thread's next failing call; "" when there was none. Thread-safe. */
ENF_API const char *enf_last_error(void);

/* "MAJOR.MINOR.PATCH" from the file VERSION. Thread-safe. */
ENF_API const char *enf_version(void);
/* ENF_ABI_VERSION as the library was built. Thread-safe. */
ENF_API uint32_t enf_abi_version(void);
/* sizeof of a public struct by its C name ("EnfCamera"), 0 when unknown: for the shim's handshake. Thread-safe. */
ENF_API uint64_t enf_struct_size(const char *struct_name);

/* Memory hooks. Set both before any other call, or neither. Not thread-safe. */
typedef void *(*EnfAllocFn)(void *user, size_t size);
typedef void (*EnfFreeFn)(void *user, void *pointer, size_t size);
ENF_API EnfStatus enf_set_allocator(EnfAllocFn alloc, EnfFreeFn free, void *user);
/* Bytes the library holds now / held at most since the start. Thread-safe. */
ENF_API uint64_t enf_live_bytes(void);
ENF_API uint64_t enf_peak_bytes(void);

#ifdef __cplusplus
}
#endif
#endif
