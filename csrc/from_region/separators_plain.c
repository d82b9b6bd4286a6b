/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kernel in plain C: what every processor can, and what the others are tested against. */
#include <math.h>

#include "from_region/separators.h"

#define INLINE  static inline __attribute__((always_inline))
#define LANES   4
#define SINGLES 8

typedef double vd __attribute__((vector_size(8 * LANES)));
typedef long long vm __attribute__((vector_size(8 * LANES)));
typedef float vf __attribute__((vector_size(4 * SINGLES)));

INLINE vd vd_load(const double *from) {
    vd v;
    memcpy(&v, from, sizeof v);
    return v;
}
INLINE vd vd_after(const double *from) {
    return vd_load(from + 1);
}
INLINE void vd_store(double *to, vd v) {
    memcpy(to, &v, sizeof v);
}
INLINE vd vd_all(double v) {
    return (vd){v, v, v, v};
}
INLINE vd vd_sqrt(vd v) {
    for (int i = 0; i < LANES; ++i)
        v[i] = sqrt(v[i]);
    return v;
}
INLINE vm vd_below(vd a, vd b) {
    return a < b;
}
INLINE vd vd_choose(vm mask, vd yes, vd no) {
    return (vd)(((vm)yes & mask) | ((vm)no & ~mask));
}
INLINE vd vd_least(vd a, vd b) {
    return vd_choose(a < b, a, b);
}
INLINE vd vd_most(vd a, vd b) {
    return vd_choose(a > b, a, b);
}
INLINE void vd_single(float *to, vd v) {
    for (int i = 0; i < LANES; ++i)
        to[i] = (float)v[i];
}
INLINE vm vm_and(vm a, vm b) {
    return a & b;
}
INLINE uint32_t vm_bits(vm mask) {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < LANES; ++i)
        bits |= (uint32_t)(mask[i] & 1) << i;
    return bits;
}
INLINE vf vf_load(const float *from) {
    vf v;
    memcpy(&v, from, sizeof v);
    return v;
}
INLINE void vf_store(float *to, vf v) {
    memcpy(to, &v, sizeof v);
}
INLINE vf vf_all(float v) {
    return (vf){v, v, v, v, v, v, v, v};
}
INLINE vf vf_size(vf v) {
    for (int i = 0; i < SINGLES; ++i)
        v[i] = fabsf(v[i]);
    return v;
}
INLINE uint32_t vf_below(vf a, vf b) {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < SINGLES; ++i)
        bits |= (uint32_t)(a[i] < b[i]) << i;
    return bits;
}

typedef vf v8;
#define v8_load  vf_load
#define v8_store vf_store
#define v8_all   vf_all
#define v8_size  vf_size
#define v8_below vf_below
INLINE v8 v8_pick(v8 a, v8 b, v8 yes, v8 no) {
    for (int i = 0; i < ENF_GROUP; ++i)
        no[i] = a[i] < b[i] ? yes[i] : no[i];
    return no;
}

#include "from_region/separators_body.h"

const EnfSeparatorKernel enf_separators_plain = SEPARATOR_KERNEL;
