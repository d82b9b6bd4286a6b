/* SPDX-License-Identifier: GPL-3.0-or-later
 * Text to number and back: the same bits as the C library in its plain locale, whatever the locale is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/number.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t seed = 1;
static uint64_t random_bits(void) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    uint64_t high = seed >> 32;
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return high << 32 | seed >> 32;
}

static void check(const char *text) {
    double value = -1.0;
    const char *end = enf_number_parse(text, text + strlen(text), &value);
    double wanted = strtod(text, NULL);
    assert_ptr_equal(end, text + strlen(text));
    assert_memory_equal(&value, &wanted, sizeof value);
}

static void numbers_read_as_the_c_library_reads_them(void **state) {
    (void)state;
    static const char *const texts[] = {"0",
                                        "-0",
                                        "0.0",
                                        "1",
                                        "-1",
                                        "1e22",
                                        "1e23",
                                        "123456789012345678",
                                        "9007199254740993",
                                        "9007199254740992.5",
                                        "0.1",
                                        "0.3",
                                        "1e-5",
                                        "2.2250738585072014e-308",
                                        "4.9406564584124654e-324",
                                        "2.4703282292062327e-324",
                                        "1.7976931348623157e308",
                                        "1e309",
                                        "-1e400",
                                        "1e-400",
                                        "0.000001",
                                        "00012.5",
                                        "100000000000000000000000000000000000000",
                                        "8.5e-27",
                                        "3.14159265358979323846264338327950288",
                                        "0.5000000000000000277555756156289135105907917022705078125",
                                        "1e99999999999999999999",
                                        "0e99999999999999999999",
                                        "0.00000000000000000000000000000000000000000000000000001e53"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        check(texts[i]);
    char text[64];
    for (int i = 0; i < 300000; i++) {
        uint64_t bits = random_bits();
        double value;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        snprintf(text, sizeof text, "%.*g", (int)(random_bits() % 20) + 1, value);
        check(text);
        /* coordinates as they are written */
        snprintf(text, sizeof text, "%.*f", (int)(random_bits() % 18), (double)(int64_t)bits * 1e-13);
        check(text);
    }
}

static void formatted_numbers_read_back_bit_for_bit(void **state) {
    (void)state;
    for (int i = 0; i < 200000; i++) {
        uint64_t bits = random_bits();
        double value, back;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        char text[32];
        int length = enf_number_format(text, value);
        assert_true(length > 0 && length < 32);
        assert_ptr_equal(enf_number_parse(text, text + length, &back), text + length);
        assert_memory_equal(&value, &back, sizeof value);
    }
    char text[32];
    enf_number_format(text, 0.1);
    assert_string_equal(text, "0.1");
}

static void what_is_no_number_is_refused_and_the_end_is_kept(void **state) {
    (void)state;
    static const char *const texts[] = {"", "-", "+", ".", "e5", "-.", "x", "nan", "inf"};
    double value;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        assert_null(enf_number_parse(texts[i], texts[i] + strlen(texts[i]), &value));
    const char *text = "12345";
    assert_ptr_equal(enf_number_parse(text, text + 3, &value), text + 3);
    assert_true(value == 123.0);
    text = "7e";
    assert_ptr_equal(enf_number_parse(text, text + 2, &value), text + 1);
}

static void the_locale_does_not_matter(void **state) {
    (void)state;
    if (!setlocale(LC_NUMERIC, "de_DE.UTF-8") && !setlocale(LC_NUMERIC, "German")) {
        print_message("no locale with a decimal comma here: skipped\n");
        skip();
    }
    double value;
    const char *text = "0.50000000000000000000000000000000001";
    enf_number_parse(text, text + strlen(text), &value);
    char out[32];
    enf_number_format(out, 0.25);
    setlocale(LC_NUMERIC, "C");
    assert_true(value == 0.5);
    assert_string_equal(out, "0.25");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_read_as_the_c_library_reads_them),
        cmocka_unit_test(formatted_numbers_read_back_bit_for_bit),
        cmocka_unit_test(what_is_no_number_is_refused_and_the_end_is_kept),
        cmocka_unit_test(the_locale_does_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
