/* SPDX-License-Identifier: GPL-3.0-or-later
 * Inner-conservative spans of convex polygons into a buffer of inverse depths, with a coarse level of tile minima.
 *
 * Why inverse depth: 1/z of a plane is affine in screen coordinates (Blinn 1992), so a row is base + slope * i. */
#include "from_point/depth_buffer.h"

#include "base/memory.h"
#include "base/simd.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum { TILE = 8, MAX_CORNERS = 64, MAX_CLIPPED = MAX_CORNERS + 1 };

/* The least near distance. Metres; a guard against division for cameras without near plane. */
static const double near_guard = 1e-4;
/* Occluders shrink, bodies grow by this much on the screen: a thousandth of a pixel, a million times the rounding of the
 * projection, and too little to cost anything. Pixels. */
static const double edge_margin = 1e-3;
/* Occluders move away by this fraction of their inverse depth: 8 units in the last place of a float, against 3 of error in
 * base + slope * i. */
static const double depth_margin = 1e-6;

struct EnfDepthBuffer {
    uint32_t width, height, tiles_x, tiles_y;
    float *pixels;                     /* [height][width] inverse depth of the farthest that is surely covered; 0: nothing */
    float *tile_min;                   /* [tiles_y][tiles_x] */
    uint8_t *tile_stale;               /* tile_min must be taken anew */
    uint8_t *row_used;                 /* [tiles_y] something was drawn there since the beginning */
    double near;                       /* metres: nearer than this nothing occludes and everything is visible */
    double left, bottom, per_x, per_y; /* pixel = (tangent - left) * per_x */
    int use_simd;
    EnfDepthBufferStats stats;
};

EnfStatus enf_depth_buffer_create(uint32_t width, uint32_t height, EnfDepthBuffer **out_buffer) {
    if (!out_buffer || width < 8 || height < 8 || width > 4096 || height > 4096)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "depth buffer of %u x %u pixels: 8 to 4096 a side are possible", width, height);
    EnfDepthBuffer *b = ENF_NEW(EnfDepthBuffer, 1);
    if (!b)
        return enf_fail_memory();
    b->width = (width + TILE - 1) / TILE * TILE;
    b->height = (height + TILE - 1) / TILE * TILE;
    b->tiles_x = b->width / TILE;
    b->tiles_y = b->height / TILE;
    b->pixels = ENF_NEW(float, (uint64_t)b->width * b->height);
    b->tile_min = ENF_NEW(float, (uint64_t)b->tiles_x * b->tiles_y);
    b->tile_stale = ENF_NEW(uint8_t, (uint64_t)b->tiles_x * b->tiles_y);
    b->row_used = ENF_NEW(uint8_t, b->tiles_y);
    if (!b->pixels || !b->tile_min || !b->tile_stale || !b->row_used) {
        enf_depth_buffer_destroy(b);
        return enf_fail_memory();
    }
    const double whole[4] = {-1, 1, -1, 1};
    enf_depth_buffer_begin(b, whole, 0, 1);
    *out_buffer = b;
    return ENF_OK;
}

void enf_depth_buffer_destroy(EnfDepthBuffer *b) {
    if (!b)
        return;
    enf_free(b->pixels);
    enf_free(b->tile_min);
    enf_free(b->tile_stale);
    enf_free(b->row_used);
    enf_free(b);
}

void enf_depth_buffer_begin(EnfDepthBuffer *b, const double tangents[4], double near, int use_simd) {
    for (uint32_t row = 0; row < b->tiles_y; row++)
        if (b->row_used[row]) {
            memset(b->pixels + (size_t)row * TILE * b->width, 0, sizeof(float) * TILE * b->width);
            memset(b->tile_min + (size_t)row * b->tiles_x, 0, sizeof(float) * b->tiles_x);
            memset(b->tile_stale + (size_t)row * b->tiles_x, 0, b->tiles_x);
            b->row_used[row] = 0;
        }
    memset(&b->stats, 0, sizeof b->stats);
    b->near = fmax(near_guard, near);
    b->left = tangents[0];
    b->bottom = tangents[2];
    b->per_x = b->width / (tangents[1] - tangents[0]);
    b->per_y = b->height / (tangents[3] - tangents[2]);
    b->use_simd = use_simd && enf_processor_avx2();
}

/* row[i] = max(row[i], base + slope * i): the same operations, one rounding each, in both twins. */
static void raise_scalar(float *row, uint32_t count, float base, float slope) {
    for (uint32_t i = 0; i < count; i++) {
        float v = base + slope * (float)i;
        row[i] = v > row[i] ? v : row[i];
    }
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2"))) static void raise_avx2(float *row, uint32_t count, float base, float slope) {
    const __m256 b = _mm256_set1_ps(base), s = _mm256_set1_ps(slope);
    __m256i index = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    uint32_t i = 0;
    for (; i + 8 <= count; i += 8) {
        __m256 v = _mm256_add_ps(b, _mm256_mul_ps(s, _mm256_cvtepi32_ps(index)));
        _mm256_storeu_ps(row + i, _mm256_max_ps(v, _mm256_loadu_ps(row + i)));
        index = _mm256_add_epi32(index, _mm256_set1_epi32(8));
    }
    for (; i < count; i++) {
        float v = base + slope * (float)i;
        row[i] = v > row[i] ? v : row[i];
    }
}
#endif

/* Cuts away what lies nearer than `near`: less occluder, the safe direction. */
static uint32_t clip_near(const double (*in)[3], uint32_t count, double near, double (*out)[3]) {
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double *a = in[i], *b = in[(i + 1) % count];
        double da = -a[2] - near, db = -b[2] - near;
        if (da >= 0)
            memcpy(out[n++], a, sizeof out[0]);
        if ((da < 0) != (db < 0)) {
            double t = da / (da - db);
            for (int k = 0; k < 3; k++)
                out[n][k] = a[k] + t * (b[k] - a[k]);
            out[n][2] = fmin(out[n][2], -near); /* rounding must not leave it in front */
            n++;
        }
    }
    return n;
}

static int finite3(const double p[3]) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

typedef struct Edge {
    double a, b, need; /* inside: a x + b y >= need */
} Edge;

/* A convex polygon as it is drawn: in pixels, inverse depth at_zero + slope_x x + slope_y y. */
typedef struct Drawn {
    double at_zero, slope_x, slope_y;
    double screen[MAX_CLIPPED + 1][2];
    double ymin, ymax;
    double back; /* inverse depth by which it is moved away */
    Edge edges[MAX_CLIPPED + 1];
    uint32_t edge_count;
} Drawn;

/* Plane by Newell; inverse depth on it: (n . (u, v, -1)) / d for tangents u, v. 0: seen edge-on, covers no pixel. */
static int take_plane(const EnfDepthBuffer *buf, const double (*corners)[3], uint32_t n, Drawn *out) {
    double normal[3] = {0, 0, 0}, centre[3] = {0, 0, 0};
    for (uint32_t i = 0; i < n; i++) {
        const double *p = corners[i], *q = corners[(i + 1) % n];
        normal[0] += (p[1] - q[1]) * (p[2] + q[2]);
        normal[1] += (p[2] - q[2]) * (p[0] + q[0]);
        normal[2] += (p[0] - q[0]) * (p[1] + q[1]);
        for (int k = 0; k < 3; k++)
            centre[k] += p[k] / n;
    }
    double d = normal[0] * centre[0] + normal[1] * centre[1] + normal[2] * centre[2];
    if (!(fabs(d) > 0))
        return 0;
    out->slope_x = normal[0] / d / buf->per_x;
    out->slope_y = normal[1] / d / buf->per_y;
    out->at_zero = (normal[0] * buf->left + normal[1] * buf->bottom - normal[2]) / d;
    return 1;
}

/* Corners and edges on the screen. 0: too small to draw. */
static int take_outline(const EnfDepthBuffer *buf, const double (*corners)[3], uint32_t n, Drawn *out) {
    double(*screen)[2] = out->screen, area = 0, off_plane = 0, nearest = 0;
    out->ymin = INFINITY, out->ymax = -INFINITY, out->edge_count = 0;
    for (uint32_t i = 0; i < n; i++) {
        double inverse = -1 / corners[i][2];
        screen[i][0] = (corners[i][0] * inverse - buf->left) * buf->per_x;
        screen[i][1] = (corners[i][1] * inverse - buf->bottom) * buf->per_y;
        out->ymin = fmin(out->ymin, screen[i][1]);
        out->ymax = fmax(out->ymax, screen[i][1]);
        nearest = fmax(nearest, inverse);
        /* corners off the plane: the whole polygon moves back by the worst of them */
        off_plane = fmax(off_plane, fabs(out->at_zero + out->slope_x * screen[i][0] + out->slope_y * screen[i][1] - inverse));
    }
    out->back = off_plane + depth_margin * nearest;
    for (uint32_t i = 0; i < n; i++) {
        const double *p = screen[i], *q = screen[(i + 1) % n];
        area += p[0] * q[1] - p[1] * q[0];
    }
    if (!(fabs(area) > 1))
        return 0; /* under half a pixel */
    double turn = area > 0 ? 1 : -1;
    for (uint32_t i = 0; i < n; i++) {
        const double *p = screen[i], *q = screen[(i + 1) % n];
        double ex = q[0] - p[0], ey = q[1] - p[1], length = sqrt(ex * ex + ey * ey);
        if (!(length > 0))
            continue;
        double a = -turn * ey / length, b = turn * ex / length;
        out->edges[out->edge_count++] = (Edge){a, b, a * p[0] + b * p[1] + edge_margin};
    }
    return 1;
}

/* The pixels of row y that lie wholly inside: *x0 to *x1 - 1. */
static void span_of_row(const EnfDepthBuffer *buf, const Drawn *drawn, int64_t y, int64_t *x0, int64_t *x1) {
    double lo = 0, hi = buf->width;
    for (uint32_t e = 0; e < drawn->edge_count; e++) {
        const Edge *edge = &drawn->edges[e];
        double rest = edge->need - edge->b * (double)(edge->b > 0 ? y : y + 1); /* the row's worse side */
        if (edge->a > 0)
            lo = fmax(lo, rest / edge->a);
        else if (edge->a < 0)
            hi = fmin(hi, rest / edge->a);
        else if (rest > 0)
            hi = -1;
    }
    *x0 = (int64_t)ceil(lo);
    *x1 = hi < lo ? *x0 : (int64_t)floor(hi);
}

/* Gives how many pixels it covers. */
static uint64_t draw_rows(EnfDepthBuffer *buf, const Drawn *drawn) {
    int64_t y0 = (int64_t)fmax(0, ceil(drawn->ymin)), y1 = (int64_t)fmin((double)buf->height, floor(drawn->ymax)), x0, x1;
    /* the pixel's corner of least inverse depth */
    double farthest_x = drawn->slope_x < 0 ? 1 : 0, farthest_y = drawn->slope_y < 0 ? 1 : 0;
    uint64_t written = 0;
    for (int64_t y = y0; y < y1; y++) {
        span_of_row(buf, drawn, y, &x0, &x1);
        if (x0 >= x1)
            continue;
        double base = drawn->at_zero + drawn->slope_x * ((double)x0 + farthest_x) + drawn->slope_y * ((double)y + farthest_y) - drawn->back;
        float *row = buf->pixels + (size_t)y * buf->width + (size_t)x0;
#ifdef ENF_HAVE_AVX2
        if (buf->use_simd)
            raise_avx2(row, (uint32_t)(x1 - x0), (float)base, (float)drawn->slope_x);
        else
#endif
            raise_scalar(row, (uint32_t)(x1 - x0), (float)base, (float)drawn->slope_x);
        uint8_t *stale = buf->tile_stale + (size_t)(y / TILE) * buf->tiles_x;
        buf->row_used[y / TILE] = 1;
        memset(stale + x0 / TILE, 1, (size_t)((x1 - 1) / TILE - x0 / TILE + 1));
        written += (uint64_t)(x1 - x0);
    }
    return written;
}

void enf_depth_buffer_occlude(EnfDepthBuffer *buf, const double (*corners)[3], uint32_t count) {
    double clipped[MAX_CLIPPED + 1][3];
    Drawn drawn;
    buf->stats.occluders++;
    buf->stats.occluders_dropped++; /* taken back when something is drawn */
    if (count < 3 || count > MAX_CORNERS)
        return;
    for (uint32_t i = 0; i < count; i++)
        if (!finite3(corners[i]))
            return;
    uint32_t n = clip_near(corners, count, buf->near, clipped);
    if (n < 3 || !take_plane(buf, (const double(*)[3])clipped, n, &drawn) || !take_outline(buf, (const double(*)[3])clipped, n, &drawn))
        return;
    uint64_t written = draw_rows(buf, &drawn);
    buf->stats.pixels_written += written;
    if (written)
        buf->stats.occluders_dropped--;
}

static float tile_minimum(EnfDepthBuffer *buf, uint32_t tx, uint32_t ty) {
    size_t tile = (size_t)ty * buf->tiles_x + tx;
    buf->stats.tiles_read++;
    if (buf->tile_stale[tile]) {
        const float *p = buf->pixels + (size_t)ty * TILE * buf->width + (size_t)tx * TILE;
        float least = p[0];
        for (int y = 0; y < TILE; y++, p += buf->width)
            for (int x = 0; x < TILE; x++)
                least = p[x] < least ? p[x] : least;
        buf->tile_min[tile] = least;
        buf->tile_stale[tile] = 0;
    }
    return buf->tile_min[tile];
}

/* In pixels. */
static int rect_visible(EnfDepthBuffer *buf, double x0, double y0, double x1, double y1, double nearest) {
    x0 -= edge_margin, y0 -= edge_margin, x1 += edge_margin, y1 += edge_margin;
    if (x1 < 0 || y1 < 0 || x0 >= buf->width || y0 >= buf->height) {
        buf->stats.hidden++;
        return 0;
    }
    uint32_t px0 = (uint32_t)fmax(0, floor(x0)), px1 = (uint32_t)fmin(buf->width - 1.0, floor(x1));
    uint32_t py0 = (uint32_t)fmax(0, floor(y0)), py1 = (uint32_t)fmin(buf->height - 1.0, floor(y1));
    float limit = (float)(nearest * (1 + depth_margin)); /* covered means strictly nearer than this */
    for (uint32_t ty = py0 / TILE; ty <= py1 / TILE; ty++)
        for (uint32_t tx = px0 / TILE; tx <= px1 / TILE; tx++) {
            if (tile_minimum(buf, tx, ty) > limit)
                continue; /* the whole tile covers it */
            uint32_t ax = tx * TILE > px0 ? tx * TILE : px0, bx = tx * TILE + TILE - 1 < px1 ? tx * TILE + TILE - 1 : px1;
            uint32_t ay = ty * TILE > py0 ? ty * TILE : py0, by = ty * TILE + TILE - 1 < py1 ? ty * TILE + TILE - 1 : py1;
            for (uint32_t y = ay; y <= by; y++)
                for (uint32_t x = ax; x <= bx; x++)
                    if (!(buf->pixels[(size_t)y * buf->width + x] > limit))
                        return 1;
        }
    buf->stats.hidden++;
    return 0;
}

int enf_depth_buffer_visible(EnfDepthBuffer *buf, const double (*points)[3], uint32_t count, const double within[4]) {
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY, nearest = 0;
    buf->stats.tests++;
    if (count == 0)
        return 1;
    for (uint32_t i = 0; i < count; i++) {
        const double *p = points[i];
        if (!finite3(p) || -p[2] < buf->near)
            return 1;
        double inverse = -1 / p[2];
        double x = p[0] * inverse, y = p[1] * inverse;
        x0 = fmin(x0, x), x1 = fmax(x1, x), y0 = fmin(y0, y), y1 = fmax(y1, y);
        nearest = fmax(nearest, inverse);
    }
    if (within) {
        x0 = fmax(x0, within[0]), x1 = fmin(x1, within[1]), y0 = fmax(y0, within[2]), y1 = fmin(y1, within[3]);
        if (x0 > x1 || y0 > y1)
            return 1; /* they touch but for rounding */
    }
    return rect_visible(buf, (x0 - buf->left) * buf->per_x, (y0 - buf->bottom) * buf->per_y, (x1 - buf->left) * buf->per_x,
                        (y1 - buf->bottom) * buf->per_y, nearest);
}

int enf_depth_buffer_rect_visible(EnfDepthBuffer *buf, const double rect[4], double nearest) {
    buf->stats.tests++;
    if (!(nearest > 0 && nearest * buf->near <= 1))
        return 1;
    return rect_visible(buf, (rect[0] - buf->left) * buf->per_x, (rect[2] - buf->bottom) * buf->per_y, (rect[1] - buf->left) * buf->per_x,
                        (rect[3] - buf->bottom) * buf->per_y, nearest);
}

EnfDepthBufferStats enf_depth_buffer_stats(const EnfDepthBuffer *buf) {
    return buf->stats;
}

const float *enf_depth_buffer_pixels(const EnfDepthBuffer *buf, uint32_t *out_width, uint32_t *out_height) {
    *out_width = buf->width;
    *out_height = buf->height;
    return buf->pixels;
}
