/* SPDX-License-Identifier: GPL-3.0-or-later
 * Libraries opened at run time, on POSIX and Windows. The handle is the system's own. */
#if !defined(_WIN32)
#define _GNU_SOURCE /* dladdr */
#endif
#include "base/shared_library.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* An address within this code, to ask the system which file it came from. */
static const char here[] = "/\\";

#if defined(_WIN32)
#include <windows.h>

static int own_file(char *path, size_t size) {
    HMODULE self;
    if (!GetModuleHandleExA(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT, here, &self))
        return 0;
    DWORD length = GetModuleFileNameA(self, path, (DWORD)size);
    return length > 0 && length < size;
}

static void *open_path(const char *path) {
    return (void *)LoadLibraryA(path);
}
#else
#include <dlfcn.h>

static int own_file(char *path, size_t size) {
    Dl_info info;
    if (!dladdr(here, &info) || !info.dli_fname)
        return 0;
    int length = snprintf(path, size, "%s", info.dli_fname);
    return length > 0 && (size_t)length < size;
}

/* Local: its names must not meet those of another copy in the same process. */
static void *open_path(const char *path) {
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}
#endif

EnfSharedLibrary *enf_shared_library_open(const char *name) {
    char path[4096];
    void *library = NULL;
    if (own_file(path, sizeof path)) {
        size_t folder = 0;
        for (size_t i = 0; path[i]; i++)
            if (strchr(here, path[i]))
                folder = i + 1;
        if (folder > 0 && folder + strlen(name) < sizeof path) {
            strcpy(path + folder, name);
            library = open_path(path);
        }
    }
    return library ? library : open_path(name);
}

void *enf_shared_library_symbol(EnfSharedLibrary *library, const char *name) {
#if defined(_WIN32)
    return (void *)(uintptr_t)GetProcAddress((HMODULE)(void *)library, name);
#else
    return dlsym(library, name);
#endif
}
