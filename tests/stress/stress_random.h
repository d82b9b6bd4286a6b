/* SPDX-License-Identifier: GPL-3.0-or-later
 * Random numbers of the stress programs: the same for the same seed on every machine. portal_sampler has its own: it shares nothing. */
#ifndef ENF_TESTS_STRESS_RANDOM_H
#define ENF_TESTS_STRESS_RANDOM_H

#include <stdint.h>

typedef struct Random {
    uint64_t state;
} Random;

static inline uint64_t random_bits(Random *random) { /* splitmix64, Steele et al. 2014 */
    uint64_t z = (random->state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}
static inline double random_unit(Random *random) { /* [0, 1) */
    return (double)(random_bits(random) >> 11) * 0x1p-53;
}
static inline double random_between(Random *random, double lo, double hi) { /* [lo, hi) */
    return lo + (hi - lo) * random_unit(random);
}
static inline uint32_t random_index(Random *random, uint32_t count) { /* 0 .. count - 1 */
    return (uint32_t)(random_bits(random) % count);
}

#endif
