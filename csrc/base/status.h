/* SPDX-License-Identifier: GPL-3.0-or-later
 * Failing with a reason. */
#ifndef ENF_BASE_STATUS_H
#define ENF_BASE_STATUS_H

#include "enfilade/base.h"

/* Keeps the sentence for enf_last_error and gives the status back: return enf_fail(ENF_ERROR_BAD_INPUT, "portal %u: ...", i); */
EnfStatus enf_fail(EnfStatus status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

#endif
