/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernels in plain C: what every processor can, and what the others are tested against. */
#include "raycast/ray_kernel.h"

#include <string.h>

#define LANE_TYPE_(name, lanes) name##lanes
#define LANE_TYPE(name, lanes)  LANE_TYPE_(name, lanes)
#define INLINE                  static inline __attribute__((always_inline))
#define WIDE_DOUBLES            1

INLINE int find_exit(const PrismNode *node, float ox, float oy, float dx, float dy, uint32_t *k) {
    int before = dx * (node->y[0] - oy) - dy * (node->x[0] - ox) < 0;
    for (*k = 0; *k < node->sections; ++*k) {
        int after = dx * (node->y[*k + 1] - oy) - dy * (node->x[*k + 1] - ox) < 0;
        if (before & !after)
            return 1;
        before = after;
    }
    return 0;
}

/* By masks: left to itself the compiler branches on what no predictor can know. */
INLINE uint32_t take_cap(float beyond, float cap_distance, float *distance) {
    const uint32_t mask = 0u - (uint32_t)(beyond > 0);
    uint32_t at, cap;
    memcpy(&at, distance, sizeof at);
    memcpy(&cap, &cap_distance, sizeof cap);
    at = (cap & mask) | (at & ~mask);
    memcpy(distance, &at, sizeof at);
    return mask;
}

INLINE uint32_t band_at(const PrismSection *s, float z) {
    return (uint32_t) !(z < s->height[0]) + (uint32_t) !(z < s->height[1]) + (uint32_t) !(z < s->height[2]);
}

#define PLAIN_LANES(n)                                                                                                                     \
    typedef float vf##n __attribute__((vector_size(4 * n)));                                                                               \
    typedef uint32_t vu##n __attribute__((vector_size(4 * n)));                                                                            \
    INLINE uint32_t lanes_lt##n(vf##n a, vf##n b) {                                                                                        \
        uint32_t lanes = 0;                                                                                                                \
        for (uint32_t i = 0; i < n; i++)                                                                                                   \
            lanes |= (uint32_t)(a[i] < b[i]) << i;                                                                                         \
        return lanes;                                                                                                                      \
    }                                                                                                                                      \
    INLINE uint32_t lanes_eq##n(vu##n a, vu##n b) {                                                                                        \
        uint32_t lanes = 0;                                                                                                                \
        for (uint32_t i = 0; i < n; i++)                                                                                                   \
            lanes |= (uint32_t)(a[i] == b[i]) << i;                                                                                        \
        return lanes;                                                                                                                      \
    }                                                                                                                                      \
    INLINE vu##n lanes_get_index##n(const uint32_t *from) {                                                                                \
        vu##n v;                                                                                                                           \
        memcpy(&v, from, sizeof v);                                                                                                        \
        return v;                                                                                                                          \
    }                                                                                                                                      \
    INLINE vu##n lanes_all_index##n(uint32_t value) {                                                                                      \
        vu##n v = {0};                                                                                                                     \
        return v + value;                                                                                                                  \
    }                                                                                                                                      \
    INLINE vu##n lanes_pick_index##n(uint32_t lanes, vu##n yes, vu##n no) {                                                                \
        for (uint32_t i = 0; i < n; i++)                                                                                                   \
            no[i] = lanes >> i & 1 ? yes[i] : no[i];                                                                                       \
        return no;                                                                                                                         \
    }                                                                                                                                      \
    INLINE vf##n lanes_get##n(const float *from) {                                                                                         \
        vf##n v;                                                                                                                           \
        memcpy(&v, from, sizeof v);                                                                                                        \
        return v;                                                                                                                          \
    }                                                                                                                                      \
    INLINE vf##n lanes_all##n(float value) {                                                                                               \
        vf##n v = {0};                                                                                                                     \
        return v + value;                                                                                                                  \
    }                                                                                                                                      \
    INLINE vf##n lanes_pick##n(uint32_t lanes, vf##n yes, vf##n no) {                                                                      \
        for (uint32_t i = 0; i < n; i++)                                                                                                   \
            no[i] = lanes >> i & 1 ? yes[i] : no[i];                                                                                       \
        return no;                                                                                                                         \
    }
PLAIN_LANES(8)
PLAIN_LANES(16)

INLINE void lanes_put16(float *to, uint32_t lanes, vf16 v) {
    for (uint32_t i = 0; i < 16; i++)
        if (lanes >> i & 1)
            to[i] = v[i];
}

INLINE void lanes_put_index16(uint32_t *to, uint32_t lanes, vu16 v) {
    for (uint32_t i = 0; i < 16; i++)
        if (lanes >> i & 1)
            to[i] = v[i];
}

#include "raycast/ray_kernel_body.h"

const RayKernel enf_ray_kernel_plain = RAY_KERNEL_TABLE;
