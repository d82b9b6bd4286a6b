/* SPDX-License-Identifier: GPL-3.0-or-later
 * Text to number and back. Most numbers take Clinger's fast path (How to Read Floating Point Numbers
 * Accurately, 1990): a mantissa and a power of ten that are both exact need one rounding only. The rest goes
 * to strtod. */
#include "base/number.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int is_digit(char c) {
    return c >= '0' && c <= '9';
}

static double slow_parse(const char *at, size_t length) {
    /* Beyond 800 digits nothing changes a double's rounding but "not zero": those are cut. */
    char text[1100];
    size_t n = 0, digits = 0;
    const char *exponent = NULL;
    long dropped = 0;
    int after_point = 0;
    const struct lconv *locale = localeconv();
    const char *point = locale && locale->decimal_point && *locale->decimal_point ? locale->decimal_point : ".";
    for (size_t i = 0; i < length; i++) {
        char c = at[i];
        if (c == 'e' || c == 'E') {
            exponent = at + i + 1;
            break;
        }
        if (c == '.') {
            after_point = 1;
            size_t size = strlen(point);
            if (size > 8)
                size = 8;
            memcpy(text + n, point, size);
            n += size;
        } else if (is_digit(c)) {
            if (digits >= 800) {
                dropped += !after_point;
                continue;
            }
            digits += digits || c != '0';
            if (!digits && !after_point)
                continue;
            if (n < sizeof text - 64)
                text[n++] = c;
        } else
            text[n++] = c;
    }
    long power = 0, sign = 1;
    if (exponent) {
        const char *end = at + length;
        if (exponent < end && (*exponent == '+' || *exponent == '-'))
            sign = *exponent++ == '-' ? -1 : 1;
        for (; exponent < end && power < 100000000; exponent++)
            power = power * 10 + (*exponent - '0');
    }
    snprintf(text + n, sizeof text - n, "e%ld", sign * power + dropped);
    /* A number that began with zeros only needs one to stay a number. */
    char *from = text;
    char padded[1104];
    size_t signs = text[0] == '-' || text[0] == '+';
    if (!is_digit(text[signs])) {
        snprintf(padded, sizeof padded, "%.*s0%s", (int)signs, text, text + signs);
        from = padded;
    }
    return strtod(from, NULL);
}

const char *enf_number_parse(const char *at, const char *end, double *out) {
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *start = at;
    int negative = 0, digits = 0, seen = 0, scale = 0, exact = 1;
    uint64_t mantissa = 0;
    if (at < end && (*at == '-' || *at == '+'))
        negative = *at++ == '-';
    for (int point = 0; at < end; at++) {
        if (*at == '.' && !point) {
            point = 1;
            continue;
        }
        if (!is_digit(*at))
            break;
        seen = 1;
        if (digits == 0 && *at == '0') {
            scale -= point;
            continue;
        }
        if (digits < 19) {
            mantissa = mantissa * 10 + (uint64_t)(*at - '0');
            scale -= point;
            digits++;
        } else
            exact = 0;
    }
    if (!seen)
        return NULL;
    if (at < end && (*at == 'e' || *at == 'E')) {
        const char *e = at + 1;
        int down = 0, power = 0;
        if (e < end && (*e == '+' || *e == '-'))
            down = *e++ == '-';
        if (e < end && is_digit(*e)) {
            for (; e < end && is_digit(*e); e++)
                if (power < 100000)
                    power = power * 10 + (*e - '0');
            scale += down ? -power : power;
            at = e;
        }
    }
    double value;
    if (exact && mantissa == 0)
        value = 0.0;
    else if (exact && mantissa < ((uint64_t)1 << 53) && scale >= -22 && scale <= 22)
        value = scale < 0 ? (double)mantissa / powers[-scale] : (double)mantissa * powers[scale];
    else {
        *out = slow_parse(start, (size_t)(at - start));
        return at;
    }
    *out = negative ? -value : value;
    return at;
}

int enf_number_format(char out[32], double value) {
    int length = 0;
    for (int digits = 15; digits <= 17; digits++) {
        length = snprintf(out, 32, "%.*g", digits, value);
        for (int i = 0; i < length; i++)
            if (!is_digit(out[i]) && !strchr("+-eE.", out[i]))
                out[i] = '.'; /* the locale's decimal comma */
        double back;
        if (enf_number_parse(out, out + length, &back) && back == value)
            break;
    }
    return length;
}
