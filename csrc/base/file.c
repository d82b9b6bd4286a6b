/* SPDX-License-Identifier: GPL-3.0-or-later
 * Whole files, by UTF-8 paths on every system. */
#include "base/file.h"
#include "base/memory.h"
#include "base/status.h"

#include <errno.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>

/* UTF-16 units; Windows opens paths of 260 unless it is told otherwise. No heap: files are closed and deleted when memory ends, too. */
enum { LONGEST_PATH = 4096 };

static int widen(wchar_t wide[LONGEST_PATH], const char *text) {
    int ok = MultiByteToWideChar(CP_UTF8, 0, text, -1, wide, LONGEST_PATH) > 0;
    if (!ok)
        errno = ENAMETOOLONG;
    return ok;
}

FILE *enf_fopen(const char *path_utf8, const char *mode) {
    wchar_t path[LONGEST_PATH], wide_mode[LONGEST_PATH];
    return widen(path, path_utf8) && widen(wide_mode, mode) ? _wfopen(path, wide_mode) : NULL;
}

static int replace_file(const char *from, const char *to) {
    wchar_t a[LONGEST_PATH], b[LONGEST_PATH];
    return widen(a, from) && widen(b, to) && MoveFileExW(a, b, MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH);
}

static void delete_file(const char *path) {
    wchar_t wide[LONGEST_PATH];
    if (widen(wide, path))
        DeleteFileW(wide);
}
#else
FILE *enf_fopen(const char *path_utf8, const char *mode) {
    return fopen(path_utf8, mode);
}
static int replace_file(const char *from, const char *to) {
    return rename(from, to) == 0;
}
static void delete_file(const char *path) {
    remove(path);
}
#endif

EnfStatus enf_file_read(const char *path_utf8, char **out_bytes, uint64_t *out_size) {
    if (!path_utf8 || !out_bytes || !out_size)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_file_read: NULL argument");
    FILE *file = enf_fopen(path_utf8, "rb");
    if (!file)
        return enf_fail(ENF_ERROR_IO, "%s: can't be opened: %s", path_utf8, strerror(errno));
    /* The size is only a first guess: pipes have none, and files grow. Reading goes on until the end. */
    char *bytes = NULL;
    uint64_t size = 0, guess = 0;
    if (fseek(file, 0, SEEK_END) == 0) {
        long end = ftell(file);
        /* a folder claims the largest number there is */
        guess = end > 0 && (uint64_t)end < (uint64_t)1 << 40 ? (uint64_t)end : 0;
        rewind(file);
    }
    clearerr(file);
    if (guess > 65536 && (bytes = enf_alloc((size_t)guess + 2)) == NULL) {
        fclose(file);
        return enf_fail(ENF_ERROR_OUT_OF_MEMORY, "%s: too large for memory", path_utf8);
    }
    for (;;) {
        uint64_t want = guess > size ? guess - size + 1 : size < 65536 ? 65536 : size;
        if (!enf_reserve(&bytes, size + want + 1, 1)) {
            enf_free(bytes);
            fclose(file);
            return enf_fail(ENF_ERROR_OUT_OF_MEMORY, "%s: too large for memory", path_utf8);
        }
        size_t got = fread(bytes + size, 1, (size_t)want, file);
        size += got;
        if (got < want)
            break;
    }
    if (ferror(file)) {
        int reason = errno;
        fclose(file);
        enf_free(bytes);
        return enf_fail(ENF_ERROR_IO, "%s: can't be read: %s", path_utf8, strerror(reason));
    }
    fclose(file);
    bytes[size] = 0;
    *out_bytes = bytes;
    *out_size = size;
    return ENF_OK;
}

EnfStatus enf_file_write_begin(EnfFileWriter *writer, const char *path_utf8) {
    memset(writer, 0, sizeof *writer);
    if (!path_utf8 || !*path_utf8)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "no path to write to");
    size_t length = strlen(path_utf8);
    writer->path = enf_strdup(path_utf8);
    writer->temporary = enf_alloc(length + 6);
    if (!writer->path || !writer->temporary) {
        enf_free(writer->path);
        enf_free(writer->temporary);
        return enf_fail_memory();
    }
    memcpy(writer->temporary, path_utf8, length);
    memcpy(writer->temporary + length, ".part", 6);
    writer->file = enf_fopen(writer->temporary, "wb");
    if (!writer->file) {
        EnfStatus status = enf_fail(ENF_ERROR_IO, "%s: can't be written: %s", writer->temporary, strerror(errno));
        enf_free(writer->path);
        enf_free(writer->temporary);
        memset(writer, 0, sizeof *writer);
        return status;
    }
    return ENF_OK;
}

EnfStatus enf_file_write_end(EnfFileWriter *writer, int ok) {
    EnfStatus status = ENF_OK;
    int bad = fflush(writer->file) != 0 || ferror(writer->file);
    bad |= fclose(writer->file) != 0;
    if (bad && ok)
        status = enf_fail(ENF_ERROR_IO, "%s: can't be written: %s", writer->path, strerror(errno));
    if (ok && !bad && !replace_file(writer->temporary, writer->path)) {
        status = enf_fail(ENF_ERROR_IO, "%s: can't be replaced: %s", writer->path, strerror(errno));
        bad = 1;
    }
    if (!ok || bad)
        delete_file(writer->temporary);
    enf_free(writer->path);
    enf_free(writer->temporary);
    memset(writer, 0, sizeof *writer);
    return status;
}
