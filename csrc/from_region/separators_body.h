/* SPDX-License-Identifier: GPL-3.0-or-later
 * Separating planes, window clipping, and boxes against planes: the source of all three kernels.
 *
 * The including file gives the vectors: `vd`, LANES doubles, and `vf`, SINGLES floats (vector types of the compiler, so that + - * /
 * are theirs), `vm`, a mask of doubles, and vd_load, vd_after (one place further on), vd_store, vd_all, vd_sqrt, vd_least
 * (a < b ? a : b), vd_most (a > b ? a : b), vd_below (the lanes of a < b), vd_choose, vd_single (stores in single precision), vm_and, vm_bits; vf_load, vf_store, vf_all, vf_size, vf_below
 * (bits); and v8, 8 floats, with v8_load, v8_store, v8_all, v8_size, v8_below and
 * v8_pick(a, b, yes, no): a < b ? yes : no. */
#include "from_region/separators_slack.h"

static const double lane_numbers[ENF_WINDOW_MAX + 8] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
                                                        16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31};

/* Heights of a window's corners over a plane, times sign; the least of them. */
INLINE double heights(const EnfWindow *window, const double n[3], double level, double sign, double *out) {
    vd least = vd_all(1.0), nx = vd_all(n[0]), ny = vd_all(n[1]), nz = vd_all(n[2]), l = vd_all(level), s = vd_all(sign);
    for (uint32_t i = 0; i < window->count; i += LANES) {
        vd h = s * (((nx * vd_load(window->x + i) + ny * vd_load(window->y + i)) + nz * vd_load(window->z + i)) - l);
        vd_store(out + i, h);
        least = vd_least(h, least); /* what stands behind the last corner are corners too */
    }
    double lanes[LANES], low = 1.0;
    vd_store(lanes, least);
    for (int i = 0; i < LANES; ++i)
        low = lanes[i] < low ? lanes[i] : low;
    return low;
}

/* For each edge of `s` the plane through it that touches `p` with the two on opposite sides: n . x >= d on p's, turned round when
 * sign is -1. height: of p's corners over the plane of s, towards p. `normal`: s runs counter-clockwise about it; facing: 1 when p
 * lies in front of it, -1 behind. again: planes that hold an edge of p, too, are left out (they were found through that edge). */
INLINE uint64_t edge_planes(const EnfWindow *s, const double normal[3], double facing, const EnfWindow *p, const double *height,
                            double sign, double slack, int again, EnfHalfspaces *planes) {
    uint32_t n = s->count, count = p->count, first = planes->count;
    uint64_t written = 0;
    const vd zero = vd_all(0), ahead = vd_all(normal[0]), side = vd_all(normal[1]), up = vd_all(normal[2]);
    for (uint32_t i = 0; i < n; i += LANES) {
        vd ax = vd_load(s->x + i), ay = vd_load(s->y + i), az = vd_load(s->z + i);
        vd ex = vd_after(s->x + i) - ax, ey = vd_after(s->y + i) - ay, ez = vd_after(s->z + i) - az;
        /* u: in the plane of s, perpendicular to the edge, pointing into s; not a unit vector. */
        vd ux = side * ez - up * ey, uy = up * ex - ahead * ez, uz = ahead * ey - side * ex;
        /* The corner of p at the smallest angle from the plane of s: the plane that turns into p first. */
        vd rx = vd_all(p->x[0]) - ax, ry = vd_all(p->y[0]) - ay, rz = vd_all(p->z[0]) - az;
        vd best_u = (rx * ux + ry * uy) + rz * uz, best_h = vd_all(height[0]);
        for (uint32_t k = 1; k < count; ++k) {
            vd qx = vd_all(p->x[k]) - ax, qy = vd_all(p->y[k]) - ay, qz = vd_all(p->z[k]) - az, h = vd_all(height[k]);
            vd angle = (qx * ux + qy * uy) + qz * uz;
            vm better = vd_below(h * best_u, angle * best_h);
            rx = vd_choose(better, qx, rx), ry = vd_choose(better, qy, ry), rz = vd_choose(better, qz, rz);
            best_u = vd_choose(better, angle, best_u), best_h = vd_choose(better, h, best_h);
        }
        vd nx = ey * rz - ez * ry, ny = ez * rx - ex * rz, nz = ex * ry - ey * rx;
        vd size2 = (nx * nx + ny * ny) + nz * nz;
        vd f = vd_all(facing) / vd_sqrt(size2); /* e x r has p on its positive side when p lies in front of s */
        nx *= f, ny *= f, nz *= f;
        vd d = (nx * ax + ny * ay) + nz * az;
        /* The computed plane, whatever rounding did to it, has to separate the windows as they are stored. */
        vd least = (nx * vd_all(p->x[0]) + ny * vd_all(p->y[0])) + nz * vd_all(p->z[0]), next = vd_all(4.0), most = d;
        for (uint32_t k = 1; k < count; ++k) {
            vd h = (nx * vd_all(p->x[k]) + ny * vd_all(p->y[k])) + nz * vd_all(p->z[k]);
            if (again)
                next = vd_least(vd_most(h, least), next);
            least = vd_least(h, least);
        }
        for (uint32_t k = 0; k < n; ++k)
            most = vd_most((nx * vd_all(s->x[k]) + ny * vd_all(s->y[k])) + nz * vd_all(s->z[k]), most);
        /* Too short an edge or lever carries no direction; p reaching behind the plane of s leaves no plane through the edge. */
        vm good = vm_and(vd_below(vd_all(1e-30), size2), vd_below(zero, best_h));
        good = vm_and(good, vm_and(vd_below(vd_all(-ENF_ON_PLANE), least - d), vd_below(most - d, vd_all(ENF_ON_PLANE))));
        good = vm_and(good, vd_below(vd_load(lane_numbers + i), vd_all(n)));
        if (again)
            good = vm_and(good, vd_below(d + vd_all(ENF_SAME_PLANE), next));
        vd turned = vd_all(sign), level = turned * d - vd_all(slack);
        nx = vd_choose(good, turned * nx, zero), ny = vd_choose(good, turned * ny, zero), nz = vd_choose(good, turned * nz, zero);
        level = vd_choose(good, level, vd_all(-1.0));
        uint32_t at = first + i;
        vd_store(planes->x + at, nx), vd_store(planes->y + at, ny), vd_store(planes->z + at, nz), vd_store(planes->d + at, level);
        written |= (uint64_t)vm_bits(good) << at;
    }
    if (written)
        planes->count = first + n;
    return written;
}

/* How far planes are moved outward; 0: no planes. A line leaves s at n . x <= d + ON_PLANE and passes p at >= d - ON_PLANE, at least
 * `gap` further on; over the scene's extent (below 1) it falls by no more than 2 ON_PLANE / gap. */
INLINE double slack_of(double gap) {
    return gap > ENF_GAP_MIN ? ENF_ON_PLANE * (2 + 3 / gap) : 0;
}

static uint64_t separators(const EnfWindow *source, const double source_normal[3], const EnfWindow *pass, const double pass_normal[3],
                           double forward, EnfHalfspaces *planes) {
    double over_source[ENF_WINDOW_ROOM], over_pass[ENF_WINDOW_ROOM];
    double level = (pass_normal[0] * pass->x[0] + pass_normal[1] * pass->y[0]) + pass_normal[2] * pass->z[0];
    double before = heights(source, pass_normal, level, -forward, over_pass);
    level = (source_normal[0] * source->x[0] + source_normal[1] * source->y[0]) + source_normal[2] * source->z[0];
    double beyond = heights(pass, source_normal, level, forward, over_source);
    double slack = slack_of(before > beyond ? before : beyond);
    if (!(slack > 0))
        return 0;
    uint64_t written = edge_planes(source, source_normal, forward, pass, over_source, 1, slack, 0, planes);
    written |= edge_planes(pass, pass_normal, -forward, source, over_pass, -1, slack, 1, planes);
    return written;
}

static void round_planes(EnfHalfspaces *planes, uint32_t first) {
    for (uint32_t i = first; i < planes->count; i += LANES) {
        vd_single(planes->single[0] + i, vd_load(planes->x + i)), vd_single(planes->single[1] + i, vd_load(planes->y + i));
        vd_single(planes->single[2] + i, vd_load(planes->z + i));
        vd_single(planes->single[3] + i, vd_load(planes->d + i) - vd_all(ENF_SINGLE_SLACK));
    }
    for (int k = 0; k < 4; ++k)
        for (uint32_t i = 0; i < ENF_HALFSPACES_NULL; i += SINGLES)
            vf_store(planes->single[k] + planes->count + i, vf_all(k < 3 ? 0 : -1));
}

/* One coordinate of a window cut: the crossing after corner `in`, the run, the crossing after `out`. */
INLINE void cut(double *c, uint32_t n, EnfRun run, double t_in, double t_out) {
    double old[ENF_WINDOW_ROOM];
    for (uint32_t i = 0; i < n + ENF_WINDOW_WRAP; i += LANES)
        vd_store(old + i, vd_load(c + i));
    for (uint32_t k = 0, i = run.in + 1; k < run.kept; k += LANES, i += LANES) {
        i = i < n ? i : i - n;
        vd_store(c + 1 + k, vd_load(old + i));
    }
    c[0] = old[run.in] + t_in * (old[run.in + 1] - old[run.in]);
    c[1 + run.kept] = old[run.out] + t_out * (old[run.out + 1] - old[run.out]);
    for (uint32_t k = 0; k < ENF_WINDOW_WRAP; ++k)
        c[run.kept + 2 + k] = c[k];
}

INLINE int clip_by(EnfWindow *window, double a, double b, double c, double d, int *clipped) {
    double h[ENF_WINDOW_ROOM];
    uint32_t n = window->count, all = ((uint32_t)1 << n) - 1, below = 0;
    vd nx = vd_all(a), ny = vd_all(b), nz = vd_all(c), level = vd_all(d);
    for (uint32_t i = 0; i < n; i += LANES) {
        vd height = ((nx * vd_load(window->x + i) + ny * vd_load(window->y + i)) + nz * vd_load(window->z + i)) - level;
        vd_store(h + i, height);
        below |= vm_bits(vd_below(height, vd_all(0))) << i;
    }
    below &= all;
    if (!below)
        return 1;
    *clipped = 1;
    if (below == all)
        return 0;
    const EnfRun run = enf_window_run(below, n);
    if (run.kept + 2 > ENF_WINDOW_MAX || run.torn)
        return 1;
    uint32_t next = run.in + 1 < n ? run.in + 1 : 0, beyond = run.out + 1 < n ? run.out + 1 : 0;
    double t_in = h[run.in] / (h[run.in] - h[next]), t_out = h[run.out] / (h[run.out] - h[beyond]);
    cut(window->x, n, run, t_in, t_out);
    cut(window->y, n, run, t_in, t_out);
    cut(window->z, n, run, t_in, t_out);
    window->count = run.kept + 2, window->own = enf_run_own(window->own, n, run);
    return 1;
}

static int clip(EnfWindow *window, const double plane[4], int *clipped) {
#ifdef CLIP_IN_REGISTERS
    uint64_t which = 1;
    if (!clip_in_registers(window, plane, plane + 1, plane + 2, plane + 3, &which, clipped))
        return 0;
    if (!which)
        return 1;
#endif
    return clip_by(window, plane[0], plane[1], plane[2], plane[3], clipped);
}

static int clip_all(EnfWindow *window, const EnfHalfspaces *planes, uint64_t which, int *clipped) {
#ifdef CLIP_IN_REGISTERS
    if (!clip_in_registers(window, planes->x, planes->y, planes->z, planes->d, &which, clipped))
        return 0;
#endif
    for (; which; which &= which - 1) {
        uint32_t k = enf_lowest_bit64(which);
        if (!clip_by(window, planes->x[k], planes->y[k], planes->z[k], planes->d[k], clipped))
            return 0;
    }
    return 1;
}

/* SINGLES planes of a set, in registers. */
typedef struct Pack {
    vf x, y, z, d, size_x, size_y, size_z;
} Pack;

INLINE Pack pack_at(const EnfHalfspaces *planes, uint32_t g) {
    Pack p = {.x = vf_load(planes->single[0] + g), .y = vf_load(planes->single[1] + g), .z = vf_load(planes->single[2] + g)};
    p.d = vf_load(planes->single[3] + g), p.size_x = vf_size(p.x), p.size_y = vf_size(p.y), p.size_z = vf_size(p.z);
    return p;
}

/* Bits: the planes outside of which the box lies wholly; those it isn't wholly inside of. */
INLINE uint32_t outside(const Pack *p, const float box[6], uint32_t *out_cuts) {
    vf s = (p->x * vf_all(box[0]) + p->y * vf_all(box[1])) + p->z * vf_all(box[2]);
    vf r = (p->size_x * vf_all(box[3]) + p->size_y * vf_all(box[4])) + p->size_z * vf_all(box[5]);
    *out_cuts = vf_below(s - r, p->d + vf_all((float)(2 * ENF_SINGLE_SLACK)));
    return vf_below(s + r, p->d);
}

static int touches(const EnfHalfspaces *planes, const float box[6], uint64_t *out_cuts) {
    uint64_t cuts = 0;
    for (uint32_t g = 0; g < planes->count; g += SINGLES) {
        uint32_t some;
        Pack p = pack_at(planes, g);
        if (outside(&p, box, &some))
            return 0;
        cuts |= (uint64_t)some << g;
    }
    *out_cuts = cuts;
    return 1;
}

/* How far a box reaches along planes' normals of the sizes given. */
INLINE v8 reach_of(v8 size_x, v8 size_y, v8 size_z, const float box[6]) {
    return (size_x * v8_all(box[3]) + size_y * v8_all(box[4])) + (size_z * v8_all(box[5]) + v8_all((float)ENF_SINGLE_SLACK));
}

static uint64_t facing(const EnfPlaneGroup *groups, uint32_t count, float sign, const float a[6], const float b[6]) {
    uint64_t which = 0;
    v8 s = v8_all(sign);
    for (uint32_t k = 0; k < count; k += ENF_GROUP, ++groups) {
        v8 x = v8_load(groups->x), y = v8_load(groups->y), z = v8_load(groups->z), d = v8_load(groups->d);
        v8 size_x = v8_size(x), size_y = v8_size(y), size_z = v8_size(z);
        v8 over_a = s * (((x * v8_all(a[0]) + y * v8_all(a[1])) + z * v8_all(a[2])) - d);
        v8 over_b = s * (((x * v8_all(b[0]) + y * v8_all(b[1])) + z * v8_all(b[2])) - d);
        v8 reach_a = reach_of(size_x, size_y, size_z, a), reach_b = reach_of(size_x, size_y, size_z, b);
        which |= (uint64_t)(~(v8_below(reach_a, over_a) | v8_below(reach_b, over_b)) & 0xFFu) << k;
    }
    return count < 64 ? which & (((uint64_t)1 << count) - 1) : which;
}

static uint64_t leaving(const EnfPlaneGroup *groups, uint32_t count, float sign, const float p[3], const float d[3]) {
    const v8 unsure = v8_all((float)ENF_SINGLE_SLACK), never = v8_all(8), always = v8_all(-8);
    v8 latest = v8_all(4); /* nothing is that far */
    float early[64], lanes[ENF_GROUP], late = 4;
    uint64_t which = 0;
    for (uint32_t k = 0; k < count; k += ENF_GROUP) {
        const EnfPlaneGroup *g = groups + k / ENF_GROUP;
        v8 x = v8_load(g->x), y = v8_load(g->y), z = v8_load(g->z);
        v8 slope = v8_all(sign) * ((x * v8_all(d[0]) + y * v8_all(d[1])) + z * v8_all(d[2]));
        v8 room = v8_load(g->d) - ((x * v8_all(p[0]) + y * v8_all(p[1])) + z * v8_all(p[2]));
        /* A plane whose slope may be 0 may be crossed anywhere, or nowhere. */
        v8 flat = v8_pick(slope, -unsure, never, always);
        v8_store(early + k, v8_pick(unsure, slope, (room - unsure) / slope, flat));
        v8 last = v8_pick(unsure, slope, (room + unsure) / slope, never);
        latest = v8_pick(last, latest, last, latest);
    }
    v8_store(lanes, latest);
    for (uint32_t i = 0; i < ENF_GROUP; ++i)
        late = lanes[i] < late ? lanes[i] : late;
    for (uint32_t k = 0; k < count; k += ENF_GROUP)
        which |= (uint64_t)(~v8_below(v8_all(late), v8_load(early + k)) & 0xFFu) << k;
    return count < 64 ? which & (((uint64_t)1 << count) - 1) : which;
}

/* at NULL, known where this is inlined: 0, 1, 2, ... */
INLINE uint64_t touching_of(const EnfHalfspaces *planes, const float (*box)[6], const uint32_t *at, uint32_t count, uint64_t which) {
    for (uint32_t g = 0; g < planes->count && which; g += SINGLES) {
        uint64_t missed = 0;
        uint32_t cuts;
        Pack p = pack_at(planes, g);
        for (uint32_t k = 0; k < count; ++k) /* no branch on the answer: nobody can foretell it */
            missed |= (uint64_t)(outside(&p, box[at ? at[k] : k], &cuts) != 0) << k;
        which &= ~missed;
    }
    return which;
}

static uint64_t touching(const EnfHalfspaces *planes, const float (*box)[6], const uint32_t *at, uint32_t count) {
    return touching_of(planes, box, at, count, count < 64 ? ((uint64_t)1 << count) - 1 : ~(uint64_t)0);
}

static uint64_t ways(const EnfHalfspaces *planes, const EnfPlaneGroup *groups, const float (*box)[6], uint32_t count, float sign,
                     const float a[6], const float b[6]) {
    return touching_of(planes, box, NULL, count, facing(groups, count, sign, a, b));
}

#define SEPARATOR_KERNEL                                                                                                                   \
    { separators, clip_all, clip, round_planes, touches, facing, leaving, touching, ways }
