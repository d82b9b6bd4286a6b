/* SPDX-License-Identifier: GPL-3.0-or-later
 * Embree 3, opened when the first triangle question is asked. */
#include "raycast/embree.h"

#include "base/shared_library.h"
#include "base/status.h"

#include <string.h>

#if defined(_WIN32)
static const char *const tasks = "tbb12.dll", *const kernels = "embree3.dll";
#elif defined(__APPLE__)
static const char *const tasks = "libtbb.12.dylib", *const kernels = "libembree3.3.dylib";
#else
static const char *const tasks = "libtbb.so.12", *const kernels = "libembree3.so.3";
#endif

EnfStatus enf_embree_open(Embree *embree) {
    /* Bundled, both lie in one folder, where the system's own search for what Embree needs would not look. */
    enf_shared_library_open(tasks);
    EnfSharedLibrary *library = enf_shared_library_open(kernels);
    if (!library)
        return enf_fail(ENF_ERROR_IO, "%s wasn't found, and triangles are met by Embree 3: install it (Debian: libembree3-3)", kernels);
    const char *missing = NULL;
    void *address;
#define ENF_EMBREE_FIND(name)                                                                                                              \
    address = enf_shared_library_symbol(library, #name);                                                                                   \
    memcpy(&embree->name, &address, sizeof address);                                                                                       \
    missing = address ? missing : #name;
    ENF_EMBREE_CALLS(ENF_EMBREE_FIND)
#undef ENF_EMBREE_FIND
    return !missing ? ENF_OK : enf_fail(ENF_ERROR_IO, "%s has no %s: it isn't Embree 3.13 or newer", kernels, missing);
}
