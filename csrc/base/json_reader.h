/* SPDX-License-Identifier: GPL-3.0-or-later
 * A pull reader for JSON (RFC 8259): the caller asks for what it expects, nothing is built. Scenes of
 * millions of objects are read in one pass with the memory of the result alone, and errors know their line.
 * Why not a library: jansson and json-c build a tree, several times the file's size and no line for what is
 * well-formed but wrong ("portal 17: ..."); yajl streams, but nobody keeps it any more.
 *
 * The first failure sticks: every later call gives 0, and enf_json_status tells it. Not thread-safe. */
#ifndef ENF_BASE_JSON_READER_H
#define ENF_BASE_JSON_READER_H

#include "enfilade/base.h"

/* Nesting beyond this is refused: a file can't make us use unbounded stack. */
enum { ENF_JSON_DEPTH = 64 };

typedef struct EnfJson {
    const char *begin, *at, *end;
    uint32_t depth;
    char first[ENF_JSON_DEPTH + 1]; /* [depth]: no element of this object or array was read yet */
    int failed;
    EnfStatus status;
    char context[96]; /* put before every reason: "portal 17: " */
    char *text;       /* the last string or key read, UTF-8, NUL-terminated */
    uint64_t text_size;
    const char *key_at; /* raw text of the last key, with its quotes */
    uint64_t key_size;
} EnfJson;

void enf_json_begin(EnfJson *json, const char *text, uint64_t size);
void enf_json_end(EnfJson *json); /* frees the reader's own memory, not the text */

/* What comes next: one of { [ " 0 t f n; 0 at the end or at something else. */
char enf_json_peek(EnfJson *json);
int enf_json_enter_object(EnfJson *json);
/* The next key is in json->text; 0 after the last one (the object is then left) or on failure. */
int enf_json_next_key(EnfJson *json);
int enf_json_enter_array(EnfJson *json);
/* 1 when an element follows; 0 after the last one (the array is then left) or on failure. */
int enf_json_next_element(EnfJson *json);
int enf_json_number(EnfJson *json, double *out); /* finite; 1e999 fails */
/* A whole number from 0 to ENF_NONE - 1. */
int enf_json_index(EnfJson *json, uint32_t *out);
int enf_json_string(EnfJson *json); /* into json->text */
int enf_json_null(EnfJson *json);
/* Skips one value of any kind, checked, and gives its raw text. */
int enf_json_skip(EnfJson *json, const char **out_text, uint64_t *out_size);
/* Nothing but white space may follow. */
int enf_json_finish(EnfJson *json);

/* Fails with "line N: context: reason". Gives 0. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int enf_json_fail(EnfJson *json, const char *format, ...);
EnfStatus enf_json_status(const EnfJson *json);

#endif
