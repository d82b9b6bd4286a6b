/* SPDX-License-Identifier: GPL-3.0-or-later
 * Bits of words: how many are set, which is the lowest. */
#ifndef ENF_BASE_BITS_H
#define ENF_BASE_BITS_H

#include <stdint.h>

static inline int enf_popcount64(uint64_t word) {
#if defined(__POPCNT__) || (defined(__GNUC__) && !defined(__x86_64__))
    return __builtin_popcountll(word);
#else /* not the compiler's: without the instruction that is a call */
    word -= word >> 1 & 0x5555555555555555u;
    word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
    return (int)(((word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu) * 0x0101010101010101u >> 56);
#endif
}
static inline uint32_t enf_lowest_bit64(uint64_t word) {
#if defined(__GNUC__)
    return (uint32_t)__builtin_ctzll(word);
#else
    uint32_t at = 0;
    while (!(word & 1))
        word >>= 1, ++at;
    return at;
#endif
}

#endif
