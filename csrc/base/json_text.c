/* SPDX-License-Identifier: GPL-3.0-or-later
 * A large JSON text, decoded by jansson a piece at a time. */
#include "base/json_text.h"
#include "base/memory.h"
#include "base/status.h"

#include <limits.h>
#include <stdarg.h>
#include <string.h>

void enf_json_begin(EnfJson *json, const char *text, uint64_t size) {
    memset(json, 0, sizeof *json);
    json->begin = json->at = json->from = text;
    json->end = text + size;
    if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0)
        json->at += 3;
}

void enf_json_end(EnfJson *json) {
    enf_json_arena_free(&json->memory);
}

void enf_json_forget(EnfJson *json) {
    enf_json_arena_reset(&json->memory);
}

/* `line` counts from 1 at json->from. */
static int fail_at(EnfJson *json, uint64_t line, const char *reason) {
    char item[64] = "", key[64] = "";
    if (json->status != ENF_OK)
        return 0;
    for (const char *c = json->begin; c < json->from; c++)
        line += *c == '\n';
    if (json->item)
        snprintf(item, sizeof item, "%s %u: ", json->item, json->index);
    if (json->key)
        snprintf(key, sizeof key, "\"%s\": ", json->key);
    json->status = enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: %s%s%s", (unsigned long long)line, item, key, reason);
    return 0;
}

int enf_json_fail(EnfJson *json, const char *format, ...) {
    char reason[256];
    va_list args;
    va_start(args, format);
    vsnprintf(reason, sizeof reason, format, args);
    va_end(args);
    return fail_at(json, 1, reason);
}

char enf_json_peek(EnfJson *json) {
    while (json->at < json->end && (*json->at == ' ' || *json->at == '\n' || *json->at == '\r' || *json->at == '\t'))
        json->at++;
    json->from = json->at;
    return json->at < json->end ? *json->at : 0;
}

static int take(EnfJson *json, char wanted) {
    char found = enf_json_peek(json);
    if (json->status != ENF_OK)
        return 0;
    if (found == wanted) {
        json->at++;
        return 1;
    }
    if (json->at == json->end)
        return enf_json_fail(json, "'%c' expected near end of file", wanted);
    if (found < ' ' || found > '~')
        return enf_json_fail(json, "'%c' expected near byte 0x%02X", wanted, (unsigned char)found);
    return enf_json_fail(json, "'%c' expected near '%c'", wanted, found);
}

int enf_json_enter(EnfJson *json, char open) {
    return take(json, open);
}

int enf_json_next(EnfJson *json, char close, uint64_t index) {
    if (json->status == ENF_OK && enf_json_peek(json) == close) {
        json->at++;
        return 0;
    }
    return json->status == ENF_OK && (index == 0 || take(json, ','));
}

const json_t *enf_json_value(EnfJson *json) {
    json_error_t error;
    enf_json_peek(json);
    if (json->status != ENF_OK)
        return NULL;
    /* error.position is an int: an item of 2 GiB is told to end too soon. */
    size_t size = json->end - json->at > INT_MAX ? INT_MAX : (size_t)(json->end - json->at);
    const json_t *value = enf_json_arena_load(&json->memory, json->at, size, &error);
    if (value) {
        json->at += error.position;
        return value;
    }
    const char *reason = error.text;
    if (json->memory.exhausted)
        json->status = enf_fail_memory();
    else if (json_error_code(&error) == json_error_null_character)
        reason = "a string holds the character NUL";
    else if (json_error_code(&error) == json_error_invalid_utf8)
        reason = "the text isn't UTF-8";
    else if (error.position > 0 && json->at[error.position - 1] == 0)
        reason = "a byte 0 stands in the text"; /* jansson takes it for the end */
    fail_at(json, error.line > 0 ? (uint64_t)error.line : 1, reason);
    return NULL;
}

const char *enf_json_key(EnfJson *json) {
    const json_t *key = enf_json_value(json);
    if (key && !json_is_string(key))
        enf_json_fail(json, "a key should be a string");
    return key && take(json, ':') ? json_string_value(key) : NULL;
}

int enf_json_skip(EnfJson *json) {
    if (enf_json_peek(json) != '[')
        return enf_json_value(json) != NULL;
    const char *from = json->at;
    enf_json_enter(json, '[');
    for (uint64_t i = 0; enf_json_next(json, ']', i); i++) {
        enf_json_value(json);
        enf_json_forget(json);
    }
    json->from = from;
    return json->status == ENF_OK;
}

int enf_json_finish(EnfJson *json) {
    return enf_json_peek(json) || json->at < json->end ? enf_json_fail(json, "end of file expected") : json->status == ENF_OK;
}

void enf_json_put_string(FILE *file, const char *text) {
    fputc('"', file);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (*c == '"' || *c == '\\')
            fprintf(file, "\\%c", *c);
        else if (*c < 0x20)
            fprintf(file, "\\u%04x", *c);
        else
            fputc(*c, file);
    }
    fputc('"', file);
}
