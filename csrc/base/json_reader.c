/* SPDX-License-Identifier: GPL-3.0-or-later
 * A pull reader for JSON (RFC 8259). */
#include "base/json_reader.h"
#include "base/memory.h"
#include "base/number.h"
#include "base/status.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void enf_json_begin(EnfJson *json, const char *text, uint64_t size) {
    memset(json, 0, sizeof *json);
    json->begin = json->at = text;
    json->end = text + size;
    if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0)
        json->at += 3;
}

void enf_json_end(EnfJson *json) {
    enf_free(json->text);
    json->text = NULL;
}

int enf_json_fail(EnfJson *json, const char *format, ...) {
    if (json->failed)
        return 0;
    json->failed = 1;
    uint64_t line = 1;
    for (const char *c = json->begin; c < json->at && c < json->end; c++)
        line += *c == '\n';
    char reason[256];
    va_list args;
    va_start(args, format);
    vsnprintf(reason, sizeof reason, format, args);
    va_end(args);
    json->status = enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: %s%s", (unsigned long long)line, json->context, reason);
    return 0;
}

static int fail_memory(EnfJson *json) {
    json->failed = 1;
    json->status = enf_fail_memory();
    return 0;
}

EnfStatus enf_json_status(const EnfJson *json) {
    return json->failed ? json->status : ENF_OK;
}

static void skip_space(EnfJson *json) {
    while (json->at < json->end && (*json->at == ' ' || *json->at == '\n' || *json->at == '\r' || *json->at == '\t'))
        json->at++;
}

static int unexpected(EnfJson *json, const char *expected) {
    if (json->at >= json->end)
        return enf_json_fail(json, "the file ends where %s should stand", expected);
    char shown[20];
    size_t n = 0;
    for (const char *c = json->at; c < json->end && n < 16 && (unsigned char)*c >= ' '; c++)
        shown[n++] = (unsigned char)*c < 127 ? *c : '?';
    shown[n] = 0;
    return enf_json_fail(json, "%s should stand at '%s'", expected, shown);
}

char enf_json_peek(EnfJson *json) {
    if (json->failed)
        return 0;
    skip_space(json);
    if (json->at >= json->end)
        return 0;
    char c = *json->at;
    if (c == '-' || (c >= '0' && c <= '9'))
        return '0';
    return strchr("{[\"tfn", c) && c ? c : 0;
}

static int enter(EnfJson *json, char open, const char *expected) {
    if (enf_json_peek(json) != open)
        return json->failed ? 0 : unexpected(json, expected);
    if (json->depth >= ENF_JSON_DEPTH)
        return enf_json_fail(json, "nested deeper than %d levels", ENF_JSON_DEPTH);
    json->at++;
    json->first[++json->depth] = 1;
    return 1;
}

int enf_json_enter_object(EnfJson *json) {
    return enter(json, '{', "an object");
}
int enf_json_enter_array(EnfJson *json) {
    return enter(json, '[', "an array");
}

/* 1: an element follows; 0: the container ended or failed. */
static int next(EnfJson *json, char close) {
    if (json->failed)
        return 0;
    skip_space(json);
    if (json->at < json->end && *json->at == close) {
        json->at++;
        json->depth--;
        return 0;
    }
    if (json->first[json->depth])
        json->first[json->depth] = 0;
    else {
        if (json->at >= json->end || *json->at != ',')
            return unexpected(json, close == '}' ? "',' or '}'" : "',' or ']'");
        json->at++;
        skip_space(json);
        if (json->at < json->end && *json->at == close)
            return unexpected(json, "another element after ','");
    }
    return 1;
}

int enf_json_next_element(EnfJson *json) {
    return next(json, ']');
}

int enf_json_next_key(EnfJson *json) {
    if (!next(json, '}'))
        return 0;
    if (enf_json_peek(json) != '"')
        return json->failed ? 0 : unexpected(json, "a key");
    json->key_at = json->at;
    if (!enf_json_string(json))
        return 0;
    json->key_size = (uint64_t)(json->at - json->key_at);
    skip_space(json);
    if (json->at >= json->end || *json->at != ':')
        return unexpected(json, "':'");
    json->at++;
    return 1;
}

int enf_json_number(EnfJson *json, double *out) {
    if (enf_json_peek(json) != '0')
        return json->failed ? 0 : unexpected(json, "a number");
    /* The number reader takes a little more than JSON allows: no "01", "1." or ".5" here. */
    const char *c = json->at + (*json->at == '-');
    double value;
    const char *after = enf_number_parse(json->at, json->end, &value);
    int digit = c < json->end && *c >= '0' && *c <= '9';
    int zero = digit && *c == '0' && c + 1 < json->end && c[1] >= '0' && c[1] <= '9';
    if (!after || !digit || zero || after[-1] == '.')
        return unexpected(json, "a number");
    for (const char *p = c; p < after; p++)
        if (*p == '.' && !(p + 1 < after && p[1] >= '0' && p[1] <= '9'))
            return unexpected(json, "a number");
    if (!isfinite(value))
        return unexpected(json, "a number a double can hold");
    json->at = after;
    *out = value;
    return 1;
}

int enf_json_index(EnfJson *json, uint32_t *out) {
    double value;
    const char *start = json->at;
    if (!enf_json_number(json, &value))
        return 0;
    if (!(value >= 0.0) || value >= (double)ENF_NONE || value != floor(value)) {
        json->at = start;
        skip_space(json);
        return unexpected(json, "a whole number from 0 to 4294967294");
    }
    *out = (uint32_t)value;
    return 1;
}

static int hex4(EnfJson *json, const char *at, uint32_t *out) {
    uint32_t value = 0;
    if (json->end - at < 4)
        return 0;
    for (int i = 0; i < 4; i++) {
        char c = at[i];
        uint32_t digit;
        if (c >= '0' && c <= '9')
            digit = (uint32_t)(c - '0');
        else if (c >= 'a' && c <= 'f')
            digit = (uint32_t)(c - 'a' + 10);
        else if (c >= 'A' && c <= 'F')
            digit = (uint32_t)(c - 'A' + 10);
        else
            return 0;
        value = value * 16 + digit;
    }
    *out = value;
    return 1;
}

static uint64_t put_utf8(char *to, uint32_t code) {
    if (code < 0x80) {
        to[0] = (char)code;
        return 1;
    }
    if (code < 0x800) {
        to[0] = (char)(0xC0 | code >> 6);
        to[1] = (char)(0x80 | (code & 63));
        return 2;
    }
    if (code < 0x10000) {
        to[0] = (char)(0xE0 | code >> 12);
        to[1] = (char)(0x80 | (code >> 6 & 63));
        to[2] = (char)(0x80 | (code & 63));
        return 3;
    }
    to[0] = (char)(0xF0 | code >> 18);
    to[1] = (char)(0x80 | (code >> 12 & 63));
    to[2] = (char)(0x80 | (code >> 6 & 63));
    to[3] = (char)(0x80 | (code & 63));
    return 4;
}

/* Length of the UTF-8 sequence at `at`, 0 when it is none (overlong, surrogate, cut off). */
static int utf8_length(const char *at, const char *end) {
    const unsigned char *s = (const unsigned char *)at;
    int64_t left = end - at;
    if (s[0] < 0x80)
        return 1;
    if (s[0] >= 0xC2 && s[0] <= 0xDF)
        return left >= 2 && (s[1] & 0xC0) == 0x80 ? 2 : 0;
    if (s[0] >= 0xE0 && s[0] <= 0xEF) {
        if (left < 3 || (s[1] & 0xC0) != 0x80 || (s[2] & 0xC0) != 0x80)
            return 0;
        if ((s[0] == 0xE0 && s[1] < 0xA0) || (s[0] == 0xED && s[1] > 0x9F))
            return 0;
        return 3;
    }
    if (s[0] >= 0xF0 && s[0] <= 0xF4) {
        if (left < 4 || (s[1] & 0xC0) != 0x80 || (s[2] & 0xC0) != 0x80 || (s[3] & 0xC0) != 0x80)
            return 0;
        if ((s[0] == 0xF0 && s[1] < 0x90) || (s[0] == 0xF4 && s[1] > 0x8F))
            return 0;
        return 4;
    }
    return 0;
}

/* `at` stands behind a backslash; writes the character and moves on. */
static int escape(EnfJson *json) {
    static const char from[] = "\"\\/bfnrt", to[] = "\"\\/\b\f\n\r\t";
    if (json->at >= json->end)
        return unexpected(json, "an escape");
    char c = *json->at;
    const char *simple = c ? strchr(from, c) : NULL;
    if (simple) {
        json->text[json->text_size++] = to[simple - from];
        json->at++;
        return 1;
    }
    uint32_t code, low;
    if (c != 'u' || !hex4(json, json->at + 1, &code))
        return unexpected(json, "an escape");
    json->at += 5;
    if (code >= 0xD800 && code < 0xDC00) {
        if (json->end - json->at < 6 || json->at[0] != '\\' || json->at[1] != 'u' || !hex4(json, json->at + 2, &low) || low < 0xDC00 ||
            low > 0xDFFF)
            return unexpected(json, "the second half of a surrogate pair");
        json->at += 6;
        code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
    } else if (code >= 0xDC00 && code <= 0xDFFF)
        return enf_json_fail(json, "a surrogate stands alone");
    if (code == 0)
        return enf_json_fail(json, "a string holds the character NUL");
    json->text_size += put_utf8(json->text + json->text_size, code);
    return 1;
}

int enf_json_string(EnfJson *json) {
    if (enf_json_peek(json) != '"')
        return json->failed ? 0 : unexpected(json, "a string");
    json->at++;
    json->text_size = 0;
    for (;;) {
        if (!ENF_RESERVE(json->text, json->text_size + 8))
            return fail_memory(json);
        if (json->at >= json->end)
            return enf_json_fail(json, "the file ends inside a string");
        unsigned char c = (unsigned char)*json->at;
        if (c == '"')
            break;
        if (c < 0x20)
            return enf_json_fail(json, "a string holds the control character %u unescaped", c);
        if (c == '\\') {
            json->at++;
            if (!escape(json))
                return 0;
            continue;
        }
        int length = utf8_length(json->at, json->end);
        if (!length)
            return enf_json_fail(json, "a string isn't UTF-8 at byte 0x%02X", c);
        memcpy(json->text + json->text_size, json->at, (size_t)length);
        json->text_size += (uint64_t)length;
        json->at += length;
    }
    json->at++;
    json->text[json->text_size] = 0;
    return 1;
}

static int word(EnfJson *json, const char *text) {
    size_t length = strlen(text);
    if ((size_t)(json->end - json->at) < length || memcmp(json->at, text, length) != 0)
        return unexpected(json, "a value");
    json->at += length;
    return 1;
}

int enf_json_null(EnfJson *json) {
    if (enf_json_peek(json) != 'n')
        return json->failed ? 0 : unexpected(json, "null");
    return word(json, "null");
}

int enf_json_skip(EnfJson *json, const char **out_text, uint64_t *out_size) {
    enf_json_peek(json);
    const char *start = json->at;
    uint32_t base = json->depth;
    char kinds[ENF_JSON_DEPTH + 1];
    double number;
    for (;;) {
        int ok = 1, opened = 0;
        switch (enf_json_peek(json)) {
        case '{':
            ok = enf_json_enter_object(json);
            opened = ok;
            kinds[json->depth] = '{';
            break;
        case '[':
            ok = enf_json_enter_array(json);
            opened = ok;
            kinds[json->depth] = '[';
            break;
        case '"':
            ok = enf_json_string(json);
            break;
        case '0':
            ok = enf_json_number(json, &number);
            break;
        case 't':
            ok = word(json, "true");
            break;
        case 'f':
            ok = word(json, "false");
            break;
        case 'n':
            ok = word(json, "null");
            break;
        default:
            ok = json->failed ? 0 : unexpected(json, "a value");
        }
        (void)opened;
        if (!ok)
            return 0;
        /* Leave what ended, until another value follows or all is done. */
        while (json->depth > base) {
            int more = kinds[json->depth] == '{' ? enf_json_next_key(json) : enf_json_next_element(json);
            if (json->failed)
                return 0;
            if (more)
                break;
        }
        if (json->depth == base)
            break;
    }
    if (out_text)
        *out_text = start;
    if (out_size)
        *out_size = (uint64_t)(json->at - start);
    return 1;
}

int enf_json_finish(EnfJson *json) {
    if (json->failed)
        return 0;
    skip_space(json);
    if (json->at < json->end)
        return unexpected(json, "the end of the file");
    return 1;
}
