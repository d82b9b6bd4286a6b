/* SPDX-License-Identifier: GPL-3.0-or-later
 * Separating planes, window clipping, and boxes against planes. */
#include "from_region/separators.h"

#include <math.h>
#include <string.h>

#include "from_region/pair_table.h"
#include "geometry/vec3.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/* [Model units] A plane counts as separating when the corners of both windows keep to their sides within this: some ten
 * roundings of coordinates below 1. */
#define ON_PLANE 1e-15

/* [Model units] Windows nearer to each other than this give no planes: what rounding does to a plane grows with the distance from
 * them over their gap. */
#define GAP_MIN 1e-6

/* [Model units] Room for the rounding of a shaft's planes and of corners cut. */
#define SHAFT_SLACK 1e-13

/* [Model units] Room for single precision: eight terms of at most 1, each within 2^-24. */
#define SINGLE_SLACK 1e-6

/* Four lanes of doubles. The functions below are compiled twice, for AVX2 and for the base machine: the same operations in the
 * same order, so the same bits. */
typedef double Four __attribute__((vector_size(32)));
typedef long long Mask __attribute__((vector_size(32)));
#define LANES              ENF_WINDOW_WRAP
#define LOAD(v, from)      memcpy(&(v), (from), sizeof(Four))
#define CHOOSE(mask, a, b) ((Four)(((Mask)(a) & (mask)) | ((Mask)(b) & ~(mask))))
#define ALL(value)         ((Four){(value), (value), (value), (value)})
#define ANY(mask)          ((((mask)[0] | (mask)[1]) | ((mask)[2] | (mask)[3])) != 0)

/* Heights of a window's corners over a plane, times sign; the least of them. */
static inline __attribute__((always_inline)) double heights(const EnfWindow *window, const double n[3], double level, double sign,
                                                            double *out) {
    Four least = ALL(1.0);
    for (uint32_t i = 0; i < window->count; i += LANES) {
        Four x, y, z;
        LOAD(x, window->x + i), LOAD(y, window->y + i), LOAD(z, window->z + i);
        Four h = sign * (((n[0] * x + n[1] * y) + n[2] * z) - level);
        memcpy(out + i, &h, sizeof h);
        least = CHOOSE(h < least, h, least); /* what stands behind the last corner are corners too */
    }
    double a = least[0] < least[1] ? least[0] : least[1], b = least[2] < least[3] ? least[2] : least[3];
    return a < b ? a : b;
}

/* For each edge of `s` the plane through it that touches `p` with the two on opposite sides: n . x >= d on p's, turned round when
 * sign is -1. height: of p's corners over the plane of s, towards p. `normal`: s runs counter-clockwise about it; facing: 1 when p lies in front of it, -1 behind. */
static inline __attribute__((always_inline)) uint32_t edge_planes(const EnfWindow *s, const double normal[3], double facing,
                                                                  const EnfWindow *p, const double *height, double sign, double slack,
                                                                  double (*planes)[4]) {
    uint32_t written = 0, n = s->count, count = p->count;
    for (uint32_t i = 0; i < n; i += LANES) {
        Four ax, ay, az, ex, ey, ez;
        LOAD(ax, s->x + i), LOAD(ay, s->y + i), LOAD(az, s->z + i);
        LOAD(ex, s->x + i + 1), LOAD(ey, s->y + i + 1), LOAD(ez, s->z + i + 1);
        ex -= ax, ey -= ay, ez -= az;
        /* u: in the plane of s, perpendicular to the edge, pointing into s; not a unit vector. */
        Four ux = normal[1] * ez - normal[2] * ey, uy = normal[2] * ex - normal[0] * ez, uz = normal[0] * ey - normal[1] * ex;
        /* The corner of p at the smallest angle from the plane of s: the plane that turns into p first. */
        Four rx = p->x[0] - ax, ry = p->y[0] - ay, rz = p->z[0] - az;
        Four best_u = (rx * ux + ry * uy) + rz * uz, best_h = ALL(height[0]);
        for (uint32_t k = 1; k < count; ++k) {
            Four qx = p->x[k] - ax, qy = p->y[k] - ay, qz = p->z[k] - az, h = ALL(height[k]);
            Four angle = (qx * ux + qy * uy) + qz * uz;
            Mask better = angle * best_h - h * best_u > 0;
            rx = CHOOSE(better, qx, rx), ry = CHOOSE(better, qy, ry), rz = CHOOSE(better, qz, rz);
            best_u = CHOOSE(better, angle, best_u), best_h = CHOOSE(better, h, best_h);
        }
        Four nx = ey * rz - ez * ry, ny = ez * rx - ex * rz, nz = ex * ry - ey * rx;
        Four size2 = (nx * nx + ny * ny) + nz * nz, length;
        for (int l = 0; l < LANES; ++l)
            length[l] = sqrt(size2[l]);
        Four f = facing / length; /* e x r has p on its positive side when p lies in front of s */
        nx *= f, ny *= f, nz *= f;
        Four d = (nx * ax + ny * ay) + nz * az;
        /* The computed plane, whatever rounding did to it, has to separate the windows as they are stored. */
        Four least = (nx * p->x[0] + ny * p->y[0]) + nz * p->z[0], most = d;
        for (uint32_t k = 1; k < count; ++k) {
            Four h = (nx * p->x[k] + ny * p->y[k]) + nz * p->z[k];
            least = CHOOSE(h < least, h, least);
        }
        for (uint32_t k = 0; k < n; ++k) {
            Four h = (nx * s->x[k] + ny * s->y[k]) + nz * s->z[k];
            most = CHOOSE(h > most, h, most);
        }
        /* Too short an edge or lever carries no direction; p reaching behind the plane of s leaves no plane through the edge. */
        Mask good = (size2 > 1e-30) & (best_h > 0) & (least - d >= -ON_PLANE) & (most - d <= ON_PLANE);
        nx *= sign, ny *= sign, nz *= sign;
        d = sign * d - slack;
        for (uint32_t l = 0; l < LANES && i + l < n; ++l)
            if (good[l]) {
                double *plane = planes[written++];
                plane[0] = nx[l], plane[1] = ny[l], plane[2] = nz[l], plane[3] = d[l];
            }
    }
    return written;
}

/* How far planes are moved outward; 0: no planes. A line leaves s at n . x <= d + ON_PLANE and passes p at >= d - ON_PLANE, at least
 * `gap` further on; over the scene's extent (below 1) it falls by no more than 2 ON_PLANE / gap. */
static double slack_of(double gap) {
    return gap > GAP_MIN ? ON_PLANE * (2 + 3 / gap) : 0;
}

/* forward 1: pass lies in front of source; -1: behind. */
static inline __attribute__((always_inline)) uint32_t separators(const EnfWindow *source, const double source_normal[3],
                                                                 const EnfWindow *pass, const double pass_normal[3], double forward,
                                                                 double (*planes)[4]) {
    double over_source[ENF_WINDOW_ROOM], over_pass[ENF_WINDOW_ROOM], first[3];
    enf_window_corner(pass, 0, first);
    double before = heights(source, pass_normal, vec_dot(pass_normal, first), -forward, over_pass);
    enf_window_corner(source, 0, first);
    double beyond = heights(pass, source_normal, vec_dot(source_normal, first), forward, over_source);
    double slack = slack_of(before > beyond ? before : beyond);
    if (!(slack > 0))
        return 0;
    uint32_t count = edge_planes(source, source_normal, forward, pass, over_source, 1, slack, planes);
    return count + edge_planes(pass, pass_normal, -forward, source, over_pass, -1, slack, planes + count);
}

static inline __attribute__((always_inline)) int clip_all(EnfWindow *window, const double (*planes)[4], uint64_t which, int *clipped) {
    for (; which; which &= which - 1) {
        const double *plane = planes[enf_lowest_bit64(which)];
        double h[ENF_WINDOW_ROOM];
        uint32_t n = window->count, outside = 0, crossings = 0;
        Mask below = {0, 0, 0, 0};
        for (uint32_t i = 0; i < n; i += LANES) {
            Four x, y, z;
            LOAD(x, window->x + i), LOAD(y, window->y + i), LOAD(z, window->z + i);
            Four height = ((plane[0] * x + plane[1] * y) + plane[2] * z) - plane[3];
            memcpy(h + i, &height, sizeof height);
            below |= height < 0;
        }
        if (!ANY(below))
            continue;
        for (uint32_t i = 0; i < n; ++i)
            outside += h[i] < 0;
        *clipped = 1;
        if (outside == n)
            return 0;
        h[n] = h[0];
        for (uint32_t i = 0; i < n; ++i)
            crossings += (h[i] < 0) != (h[i + 1] < 0);
        /* More than two: corners so close to the plane that rounding mixes their sides. Left as it is. */
        if (n - outside + 2 > ENF_WINDOW_MAX || crossings > 2)
            continue;
        /* One run of corners stays, from the one after the way in to the one before the way out: those, and two new ones. */
        uint32_t in = 0;
        while (!(h[in] < 0 && h[in + 1] >= 0))
            ++in; /* in: outside, in + 1: inside */
        uint32_t out = in + 1 < n ? in + 1 : 0;
        while (h[out + 1] >= 0)
            out = out + 1 < n ? out + 1 : 0; /* out: inside, out + 1: outside */
        EnfWindow old;
        enf_window_copy(&old, window);
        double t = h[in] / (h[in] - h[in + 1]);
        window->x[0] = old.x[in] + t * (old.x[in + 1] - old.x[in]);
        window->y[0] = old.y[in] + t * (old.y[in + 1] - old.y[in]);
        window->z[0] = old.z[in] + t * (old.z[in + 1] - old.z[in]);
        uint32_t kept = n - outside, own = old.own >> in & 1;
        for (uint32_t k = 0, i = in + 1 < n ? in + 1 : 0; k < kept; ++k, i = i + 1 < n ? i + 1 : 0) {
            window->x[1 + k] = old.x[i], window->y[1 + k] = old.y[i], window->z[1 + k] = old.z[i];
            own |= (old.own >> i & 1) << (1 + k);
        }
        t = h[out] / (h[out] - h[out + 1]);
        window->x[1 + kept] = old.x[out] + t * (old.x[out + 1] - old.x[out]);
        window->y[1 + kept] = old.y[out] + t * (old.y[out + 1] - old.y[out]);
        window->z[1 + kept] = old.z[out] + t * (old.z[out + 1] - old.z[out]);
        window->count = kept + 2, window->own = own;
        enf_window_wrap(window);
    }
    return 1;
}

static uint32_t separators_plain(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                                 double forward, double (*planes)[4]) {
    return separators(source, source_normal, pass, pass_normal, forward, planes);
}
static int clip_plain(EnfWindow *window, const double (*planes)[4], uint64_t which, int *clipped) {
    return clip_all(window, planes, which, clipped);
}

/* Not on Windows: its stack is aligned to 16 bytes only, and gcc keeps 32-byte vectors there as if it were not (gcc bug 54412). */
#if defined(__x86_64__) && !defined(_WIN32)
__attribute__((target("avx2"))) static uint32_t separators_avx2(const EnfWindow *source, const double source_normal[3],
                                                                const EnfWindow *pass, const double pass_normal[3], double forward,
                                                                double (*planes)[4]) {
    return separators(source, source_normal, pass, pass_normal, forward, planes);
}
__attribute__((target("avx2"))) static int clip_avx2(EnfWindow *window, const double (*planes)[4], uint64_t which, int *clipped) {
    return clip_all(window, planes, which, clipped);
}
static int have_avx2(void) {
    return __builtin_cpu_supports("avx2");
}
#else
#define separators_avx2 separators_plain
#define clip_avx2       clip_plain
static int have_avx2(void) {
    return 0;
}
#endif

uint32_t enf_separators(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                        double (*planes)[4]) {
    return (have_avx2() ? separators_avx2 : separators_plain)(source, source_normal, pass, pass_normal, 1, planes);
}

uint32_t enf_separators_back(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                             double (*planes)[4]) {
    return (have_avx2() ? separators_avx2 : separators_plain)(source, source_normal, pass, pass_normal, -1, planes);
}

int enf_window_clip_all(EnfWindow *window, const double (*planes)[4], uint64_t which, int *clipped) {
    return (have_avx2() ? clip_avx2 : clip_plain)(window, planes, which, clipped);
}

int enf_window_clip(EnfWindow *window, const double plane[4], int *clipped) {
    return enf_window_clip_all(window, (const double(*)[4])plane, 1, clipped); /* plane 0 */
}

uint32_t enf_separators_twin(int simd, const EnfWindow *source, const double source_normal[3], const EnfWindow *pass,
                             const double pass_normal[3], double (*planes)[4]) {
    return (simd && have_avx2() ? separators_avx2 : separators_plain)(source, source_normal, pass, pass_normal, 1, planes);
}

uint32_t enf_shaft(const double from[6], const double to[6], uint32_t room, double (*planes)[4]) {
    uint32_t count = 0;
    for (int k = 0; k < 3 && count + 2 <= room; ++k) { /* the box of both */
        double low = from[k] < to[k] ? from[k] : to[k], high = from[k + 3] > to[k + 3] ? from[k + 3] : to[k + 3];
        double *plane = planes[count++];
        plane[0] = plane[1] = plane[2] = 0, plane[k] = 1, plane[3] = low - SHAFT_SLACK;
        plane = planes[count++];
        plane[0] = plane[1] = plane[2] = 0, plane[k] = -1, plane[3] = -high - SHAFT_SLACK;
    }
    /* Seen along each axis: the hull of two rectangles has slanted edges between corners of the same name, where neither
     * rectangle's corner is further out both ways. */
    for (int k = 0; k < 3; ++k) {
        int u = (k + 1) % 3, v = (k + 2) % 3;
        for (int corner = 0; corner < 4 && count < room; ++corner) {
            int cu = corner & 1 ? u + 3 : u, cv = corner & 2 ? v + 3 : v;
            double du = to[cu] - from[cu], dv = to[cv] - from[cv], su = corner & 1 ? 1 : -1, sv = corner & 2 ? 1 : -1;
            if (!(su * du * (sv * dv) < 0))
                continue;
            double size = fabs(du) > fabs(dv) ? fabs(du) : fabs(dv);
            double nu = su * fabs(dv) / size, nv = sv * fabs(du) / size; /* outward */
            double *plane = planes[count++];
            plane[k] = 0, plane[u] = -nu, plane[v] = -nv;
            double a = nu * from[cu] + nv * from[cv], b = nu * to[cu] + nv * to[cv];
            plane[3] = -(a > b ? a : b) - SHAFT_SLACK;
        }
    }
    return count;
}

void enf_plane_pack(EnfPlanePack *pack, const double (*planes)[4], uint32_t first, uint32_t count) {
    pack->groups = (count + 3) / 4;
    for (uint32_t i = first; i < 4 * pack->groups; ++i) {
        float(*group)[4] = pack->f[i >> 2];
        for (int k = 0; k < 3; ++k) {
            float n = i < count ? (float)planes[i][k] : 0; /* padding: 0 >= -1 */
            group[k][i & 3] = n;
            group[k + 3][i & 3] = fabsf(n);
        }
        group[6][i & 3] = i < count ? (float)(planes[i][3] - SINGLE_SLACK) : -1;
    }
}

/* 1 when the box lies beyond a plane. out_cuts: as in enf_pack_cuts_box; NULL, known where this is inlined: nobody asks. */
static inline int misses_box(const EnfPlanePack *pack, const float box[6], uint64_t *out_cuts) {
    uint64_t cuts = 0;
#if defined(__SSE2__)
    __m128 cx = _mm_set1_ps(box[0]), cy = _mm_set1_ps(box[1]), cz = _mm_set1_ps(box[2]);
    __m128 hx = _mm_set1_ps(box[3]), hy = _mm_set1_ps(box[4]), hz = _mm_set1_ps(box[5]);
    for (uint32_t g = 0; g < pack->groups; ++g) {
        const float(*f)[4] = pack->f[g];
        __m128 s = _mm_add_ps(_mm_add_ps(_mm_mul_ps(_mm_loadu_ps(f[0]), cx), _mm_mul_ps(_mm_loadu_ps(f[1]), cy)),
                              _mm_mul_ps(_mm_loadu_ps(f[2]), cz));
        __m128 r = _mm_add_ps(_mm_add_ps(_mm_mul_ps(_mm_loadu_ps(f[3]), hx), _mm_mul_ps(_mm_loadu_ps(f[4]), hy)),
                              _mm_mul_ps(_mm_loadu_ps(f[5]), hz)),
               d = _mm_loadu_ps(f[6]);
        if (_mm_movemask_ps(_mm_cmplt_ps(_mm_add_ps(s, r), d)))
            return 1;
        if (!out_cuts)
            continue;
        d = _mm_add_ps(d, _mm_set1_ps((float)(2 * SINGLE_SLACK)));
        cuts |= (uint64_t)_mm_movemask_ps(_mm_cmplt_ps(_mm_sub_ps(s, r), d)) << 4 * g;
    }
#else
    for (uint32_t g = 0; g < pack->groups; ++g)
        for (int i = 0; i < 4; ++i) {
            const float(*f)[4] = pack->f[g];
            float s = (f[0][i] * box[0] + f[1][i] * box[1]) + f[2][i] * box[2];
            float r = (f[3][i] * box[3] + f[4][i] * box[4]) + f[5][i] * box[5];
            if (s + r < f[6][i])
                return 1;
            if (!out_cuts)
                continue;
            cuts |= (uint64_t)(s - r < f[6][i] + (float)(2 * SINGLE_SLACK)) << (4 * g + (uint32_t)i);
        }
#endif
    if (out_cuts)
        *out_cuts = cuts;
    return 0;
}

int enf_pack_cuts_box(const EnfPlanePack *pack, const float box[6], uint64_t *out_cuts) {
    return misses_box(pack, box, out_cuts);
}

int enf_pack_misses_box(const EnfPlanePack *pack, const float box[6]) {
    return misses_box(pack, box, NULL);
}
