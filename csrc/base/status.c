/* SPDX-License-Identifier: GPL-3.0-or-later
 * Status codes as words, and the sentence of this thread's last failure. */
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

static _Thread_local char last_error[512];

const char *enf_status_string(EnfStatus status) {
    switch (status) {
    case ENF_OK:
        return "ok";
    case ENF_ERROR_INVALID_ARGUMENT:
        return "invalid argument";
    case ENF_ERROR_BAD_INPUT:
        return "bad input";
    case ENF_ERROR_IO:
        return "input/output";
    case ENF_ERROR_OUT_OF_MEMORY:
        return "out of memory";
    case ENF_ERROR_CANCELLED:
        return "cancelled";
    case ENF_ERROR_STATE:
        return "wrong state";
    case ENF_ERROR_INTERNAL:
        return "internal error";
    default:
        return "unknown status";
    }
}

const char *enf_last_error(void) {
    return last_error;
}

EnfStatus enf_fail(EnfStatus status, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(last_error, sizeof last_error, format, args);
    va_end(args);
    return status;
}
