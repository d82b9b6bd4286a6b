/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whole files, by UTF-8 paths on every system. */
#ifndef ENF_BASE_FILE_H
#define ENF_BASE_FILE_H

#include "enfilade/base.h"

#include <stdio.h>

/* fopen by a UTF-8 path; NULL on failure (errno tells why). */
FILE *enf_fopen(const char *path_utf8, const char *mode);
/* Reads a whole file; *out_bytes has a NUL after its end and is freed by enf_free. ENF_ERROR_IO,
 * ENF_ERROR_OUT_OF_MEMORY. */
EnfStatus enf_file_read(const char *path_utf8, char **out_bytes, uint64_t *out_size);
/* Writing through a temporary file beside the target, so that a reader never sees half a file: write to
 * writer->file, then end, which renames it (ok = 1, and every write went well: else ENF_ERROR_IO) or deletes it. One sequence a
 * file: not thread-safe on one path. */
typedef struct EnfFileWriter {
    FILE *file;
    char *path, *temporary;
} EnfFileWriter;
EnfStatus enf_file_write_begin(EnfFileWriter *writer, const char *path_utf8);
EnfStatus enf_file_write_end(EnfFileWriter *writer, int ok);

#endif
