/* SPDX-License-Identifier: GPL-3.0-or-later
 * Libraries opened at run time, so that what doesn't need them runs without. */
#ifndef ENF_BASE_SHARED_LIBRARY_H
#define ENF_BASE_SHARED_LIBRARY_H

typedef struct EnfSharedLibrary EnfSharedLibrary;

/* Opens `name` (a file name, no folder) where this code itself was loaded from, else where the system looks.
 * NULL: not there. It stays for the life of the process, since threads of its own may run in it to the end;
 * opening it again costs next to nothing. */
EnfSharedLibrary *enf_shared_library_open(const char *name);
/* The address of a function or variable; NULL: no such name. */
void *enf_shared_library_symbol(EnfSharedLibrary *library, const char *name);

#endif
