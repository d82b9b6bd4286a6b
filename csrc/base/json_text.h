/* SPDX-License-Identifier: GPL-3.0-or-later
 * A large JSON text, decoded by jansson a piece at a time: the caller walks the outer objects and arrays and has only the items
 * in them built. A scene of any size is read with the memory of the result and of its largest item.
 *
 * The first failure sticks: every later call gives 0, json->status is the reason's. Not thread-safe. */
#ifndef ENF_BASE_JSON_TEXT_H
#define ENF_BASE_JSON_TEXT_H

#include "base/json_arena.h"
#include "enfilade/base.h"

#include <stdio.h>

typedef struct EnfJson {
    const char *begin, *at, *end;
    const char *from;       /* where what was read last begins; it ends at `at` */
    const char *item, *key; /* what is being read, for messages: portal 17: "cells": ...; may be NULL */
    uint32_t index;
    EnfStatus status;
    EnfJsonArena memory;
} EnfJson;

void enf_json_begin(EnfJson *json, const char *text, uint64_t size);
void enf_json_end(EnfJson *json); /* frees the reader's memory, not the text */

/* The next character that is no white space; 0 at the end. */
char enf_json_peek(EnfJson *json);
/* Takes '{' or '['. */
int enf_json_enter(EnfJson *json, char open);
/* 1 when element or key `index` follows; 0 after the last one, when `close` was taken, or on failure. */
int enf_json_next(EnfJson *json, char close, uint64_t index);
/* Decodes the next value; it lives until enf_json_forget. NULL on failure. */
const json_t *enf_json_value(EnfJson *json);
/* The next key, with its colon. */
const char *enf_json_key(EnfJson *json);
/* Skips one value, checked; of an array no more than an element is built. */
int enf_json_skip(EnfJson *json);
void enf_json_forget(EnfJson *json);
/* Nothing but white space may follow. */
int enf_json_finish(EnfJson *json);

/* Fails with "line N: item index: "key": reason", the line being that of json->from. Gives 0. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int enf_json_fail(EnfJson *json, const char *format, ...);

/* Writes a string as JSON, quotes included. */
void enf_json_put_string(FILE *file, const char *text);

#endif
