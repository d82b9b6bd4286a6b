/* SPDX-License-Identifier: GPL-3.0-or-later
 * Span portals: a picture by scan conversion of cell faces inside apertures, an aperture being one interval of whole pixels a row.
 *
 * Based on: Luebke and Georges, Portals and mirrors, 1995 (recursion through apertures); Maria, Horna, Aveneau 2014 (faces bound the
 * rays of a cell). Why each pixel is written once: seen from inside, the faces of a convex cell tile every direction; an edge is
 * evaluated from its two projected ends in one order, so both faces on it round to the same pixel; and within a row a cursor hands out
 * each pixel once, whatever rounding did to slivers. */
#include "raycast/ray_kernel.h"
#include "raycast/screen.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "geometry/vec3.h"

#include <string.h>

enum { BAND_ROWS = 64, MAX_DEPTH = 255, MAX_CORNERS = 128 };

typedef struct Interval {
    int32_t lo, hi; /* pixels lo .. hi - 1; empty when lo >= hi */
} Interval;

/* A convex polygon's or an aperture's pixels: rows y0 .. y1 - 1, intervals in Painter.intervals from `first` on. */
typedef struct Rows {
    int32_t y0, y1;
    size_t first;
} Rows;

typedef struct Painter {
    const ImageTask *task;
    const EnfRaycaster *r;
    const Screen *screen;
    EnfRaycastImage *image;
    Interval *intervals; /* a stack */
    size_t top;
    Rows *rows; /* a stack: of faces and children being looked at */
    size_t rows_top;
    uint64_t spans, visits, patched;
    EnfStatus status;
} Painter;

static int reserve(Painter *p, size_t intervals, size_t rows) {
    if (ENF_RESERVE(p->intervals, p->top + intervals) && ENF_RESERVE(p->rows, p->rows_top + rows))
        return 1;
    p->status = ENF_ERROR_OUT_OF_MEMORY;
    return 0;
}

static void to_camera(const Screen *s, const double point[3], double out[3]) {
    double v[3];
    vec_sub(v, point, s->eye);
    for (int k = 0; k < 3; k++)
        out[k] = vec_dot(s->axes[k], v);
}

/* Projects a polygon given in camera space; cuts off what lies nearer than the guard. The new corner on a cut edge is computed from
 * its far end, in whichever direction the edge runs. */
static uint32_t project(const Screen *s, const double (*in)[3], uint32_t count, double (*out)[2]) {
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double *a = in[i], *b = in[i + 1 < count ? i + 1 : 0];
        double da = -a[2] - s->near_guard, db = -b[2] - s->near_guard;
        if (da >= 0) {
            out[n][0] = (a[0] / -a[2] - s->left) * s->per_x;
            out[n++][1] = (s->top - a[1] / -a[2]) * s->per_y;
        }
        if ((da < 0) != (db < 0)) {
            const double *far_end = da < 0 ? b : a, *near_end = da < 0 ? a : b;
            double df = da < 0 ? db : da, dn = da < 0 ? da : db, t = df / (df - dn);
            double x = far_end[0] + t * (near_end[0] - far_end[0]), y = far_end[1] + t * (near_end[1] - far_end[1]);
            out[n][0] = (x / s->near_guard - s->left) * s->per_x;
            out[n++][1] = (s->top - y / s->near_guard) * s->per_y;
        }
    }
    return n;
}

/* First pixel whose centre is at or right of x. Clamped so that it fits. ceil() is a call on processors before SSE4.1. */
static inline int32_t first_pixel(double x) {
    double c = x - 0.5;
    c = c > -1e9 ? c : -1e9; /* NaN too */
    c = c < 1e9 ? c : 1e9;
    int32_t whole = (int32_t)c;
    return whole + (whole < c);
}

/* Scan-converts a projected convex polygon within rows y0 .. y1 - 1. Pushes intervals; gives the rows it has. */
static Rows scan(Painter *p, const double (*v)[2], uint32_t n, int32_t y0, int32_t y1) {
    Rows rows = {y1, y0, p->top};
    double top = INFINITY, bottom = -INFINITY;
    for (uint32_t i = 0; i < n; i++) {
        top = fmin(top, v[i][1]);
        bottom = fmax(bottom, v[i][1]);
    }
    int32_t a = first_pixel(top), b = first_pixel(bottom);
    rows.y0 = a > y0 ? a : y0;
    rows.y1 = b < y1 ? b : y1;
    if (n < 3 || rows.y0 >= rows.y1 || !reserve(p, (size_t)(rows.y1 - rows.y0), 0)) {
        rows.y1 = rows.y0;
        return rows;
    }
    Interval *out = p->intervals + rows.first;
    for (int32_t y = rows.y0; y < rows.y1; y++)
        out[y - rows.y0] = (Interval){INT32_MAX, INT32_MIN};
    p->top += (size_t)(rows.y1 - rows.y0);
    for (uint32_t i = 0; i < n; i++) {
        const double *s = v[i], *e = v[i + 1 < n ? i + 1 : 0];
        if (s[1] > e[1] || (s[1] == e[1] && s[0] > e[0])) { /* one order for both polygons on the edge */
            const double *t = s;
            s = e;
            e = t;
        }
        int32_t from = first_pixel(s[1]), until = first_pixel(e[1]);
        from = from > rows.y0 ? from : rows.y0;
        until = until < rows.y1 ? until : rows.y1;
        double slope = (e[0] - s[0]) / (e[1] - s[1]);
        for (int32_t y = from; y < until; y++) {
            int32_t x = first_pixel(s[0] + (y + 0.5 - s[1]) * slope);
            Interval *row = &out[y - rows.y0];
            row->lo = x < row->lo ? x : row->lo;
            row->hi = x > row->hi ? x : row->hi;
        }
    }
    return rows;
}

static Interval row_of(const Painter *p, const Rows *rows, int32_t y) {
    return y < rows->y0 || y >= rows->y1 ? (Interval){0, 0} : p->intervals[rows->first + (size_t)(y - rows->y0)];
}

static const FrameFill nothing; /* inverse depth 0: infinitely far */

/* normal, point: of the surface's plane. */
static FrameFill fill_of(const Painter *p, uint32_t surface, const double normal[3], const double point[3]) {
    FrameFill fill = nothing;
    if (p->image->normal || p->image->uv)
        return enf_frame_fill(p->task, surface);
    fill.inverse = enf_inverse_depth(p->screen, normal, point);
    return fill;
}

static void write_span(Painter *p, int32_t y, int32_t lo, int32_t hi, const FrameFill *f, uint32_t surface, uint32_t cell,
                       uint32_t portals) {
    EnfRaycastImage *image = p->image;
    size_t at = (size_t)y * image->width + (size_t)lo;
    uint32_t count = (uint32_t)(hi - lo);
    p->spans++;
    InverseDepth plane = f->inverse;
    p->task->kernel->fill(image->depth ? image->depth + at : NULL, image->surface ? image->surface + at : NULL, count,
                          (float)(plane.a * lo + plane.b * y + plane.c), (float)plane.a, surface);
    if (image->cell)
        p->task->kernel->fill(NULL, image->cell + at, count, 0, 0, cell);
    if (image->portals)
        memset(image->portals + at, (int)(portals < 255 ? portals : 255), count);
    if (image->normal || image->uv)
        enf_image_write_frame(p->task, (uint32_t)lo, (uint32_t)y, count, f);
}

/* A piece of a row and what fills it. */
typedef struct Piece {
    int32_t lo, hi;
    uint32_t what;
} Piece;

static uint32_t insert_piece(Piece *pieces, uint32_t count, Piece piece) {
    uint32_t i = count;
    for (; i > 0 && pieces[i - 1].lo > piece.lo; i--)
        pieces[i] = pieces[i - 1];
    pieces[i] = piece;
    return count + 1;
}

typedef struct Child {
    RayPortal portal;
    Rows rows;
    int closed;
} Child;

enum { MAX_PIECES = 64 };

/* Takes from the child's interval what an earlier child of the row has: children of a convex cell don't overlap but by rounding; those of
 * the outdoors may, and then the nearer one (it comes first) keeps the pixels. */
static void keep_apart(Painter *p, Child *children, uint32_t count, int32_t y) {
    for (uint32_t i = 1; i < count; i++) {
        if (y < children[i].rows.y0 || y >= children[i].rows.y1)
            continue;
        Interval *mine = &p->intervals[children[i].rows.first + (size_t)(y - children[i].rows.y0)];
        for (uint32_t j = 0; j < i && mine->lo < mine->hi; j++) {
            Interval other = row_of(p, &children[j].rows, y);
            if (other.lo >= other.hi || other.hi <= mine->lo || other.lo >= mine->hi)
                continue;
            if (other.lo <= mine->lo)
                mine->lo = other.hi;
            else
                mine->hi = other.lo; /* what lies right of the other is given up: background */
        }
    }
}

static void paint(Painter *p, uint32_t cell_index, Rows aperture, uint32_t portals);

/* Children: portals that the aperture shows, nearest first where the cell has no faces to keep them apart. */
static uint32_t find_children(Painter *p, uint32_t cell, const Rows *aperture, Child *children, uint32_t capacity) {
    const EnfRaycaster *r = p->r;
    uint32_t count = 0;
    for (uint32_t side = r->scene->cell_portal_first[cell]; side < r->scene->cell_portal_first[cell + 1]; side++) {
        RayPortal portal = enf_ray_portal(r, side);
        double to[3], corners[MAX_CORNERS][3], flat[MAX_CORNERS + 2][2];
        enf_ray_portal_corner(r, &portal, 0, to);
        vec_sub(to, to, p->screen->eye);
        if (!(vec_dot(portal.normal, to) > 0) || portal.corner_count > MAX_CORNERS)
            continue;
        for (uint32_t k = 0; k < portal.corner_count; k++) {
            enf_ray_portal_corner(r, &portal, k, to);
            to_camera(p->screen, to, corners[k]);
        }
        uint32_t n = project(p->screen, (const double(*)[3])corners, portal.corner_count, flat);
        size_t before = p->top;
        Rows rows = scan(p, (const double(*)[2])flat, n, aperture->y0, aperture->y1);
        int any = 0;
        for (int32_t y = rows.y0; y < rows.y1; y++) {
            Interval *row = &p->intervals[rows.first + (size_t)(y - rows.y0)], outer = row_of(p, aperture, y);
            row->lo = row->lo > outer.lo ? row->lo : outer.lo;
            row->hi = row->hi < outer.hi ? row->hi : outer.hi;
            any |= row->lo < row->hi;
        }
        if (!any || count == capacity) {
            p->top = before;
            continue;
        }
        children[count++] = (Child){portal, rows, !enf_portal_passes(r->scene, portal.portal)};
    }
    return count;
}

/* The parts of [lo, hi) that no child has, as the surface's spans. */
static void write_free(Painter *p, int32_t y, int32_t lo, int32_t hi, const Piece *holes, uint32_t hole_count, const FrameFill *f,
                       uint32_t surface, uint32_t cell, uint32_t portals) {
    for (uint32_t h = 0; h < hole_count && lo < hi; h++) {
        if (holes[h].hi <= lo)
            continue;
        if (holes[h].lo >= hi)
            break;
        if (holes[h].lo > lo)
            write_span(p, y, lo, holes[h].lo, f, surface, cell, portals);
        lo = holes[h].hi;
    }
    if (lo < hi)
        write_span(p, y, lo, hi, f, surface, cell, portals);
}

static void paint_faces(Painter *p, uint32_t cell_index, const Rows *aperture, const Child *children, uint32_t child_count,
                        uint32_t portals) {
    const EnfRaycaster *r = p->r;
    uint32_t face_first = r->scene->cell_face_first[cell_index], face_count = r->scene->cell_face_first[cell_index + 1] - face_first;
    size_t rows_before = p->rows_top;
    if (!reserve(p, 0, face_count))
        return;
    FrameFill *fills = ENF_NEW(FrameFill, face_count);
    if (!fills) {
        p->status = ENF_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (uint32_t f = 0; f < face_count; f++) {
        const double *normal = r->scene->face_planes[face_first + f].n;
        uint32_t corner_count = enf_ray_face_corners(r, face_first + f);
        double corners[MAX_CORNERS][3], flat[MAX_CORNERS + 2][2];
        Rows none = {aperture->y0, aperture->y0, p->top};
        p->rows[rows_before + f] = none;
        double to[3], point[3];
        enf_ray_face_corner(r, cell_index, face_first + f, 0, point);
        vec_sub(to, point, p->screen->eye);
        if (!(vec_dot(normal, to) > 0) || corner_count > MAX_CORNERS)
            continue; /* the eye is beyond it or in it: edge-on */
        for (uint32_t k = 0; k < corner_count; k++) {
            enf_ray_face_corner(r, cell_index, face_first + f, k, to);
            to_camera(p->screen, to, corners[k]);
        }
        uint32_t n = project(p->screen, (const double(*)[3])corners, corner_count, flat);
        p->rows[rows_before + f] = scan(p, (const double(*)[2])flat, n, aperture->y0, aperture->y1);
        fills[f] = fill_of(p, face_first + f, normal, point);
    }
    p->rows_top += face_count;
    for (int32_t y = aperture->y0; y < aperture->y1 && p->status == ENF_OK; y++) {
        Interval outer = row_of(p, aperture, y);
        Piece faces[MAX_PIECES], holes[MAX_PIECES];
        uint32_t face_pieces = 0, hole_count = 0;
        if (outer.lo >= outer.hi)
            continue;
        for (uint32_t i = 0; i < child_count && hole_count < MAX_PIECES; i++) {
            Interval row = row_of(p, &children[i].rows, y);
            if (row.lo < row.hi)
                hole_count = insert_piece(holes, hole_count, (Piece){row.lo, row.hi, i});
        }
        for (uint32_t f = 0; f < face_count && face_pieces < MAX_PIECES; f++) {
            Interval row = row_of(p, &p->rows[rows_before + f], y);
            if (row.lo < row.hi && row.lo < outer.hi && row.hi > outer.lo)
                face_pieces = insert_piece(faces, face_pieces, (Piece){row.lo, row.hi, f});
        }
        int32_t cursor = outer.lo;
        for (uint32_t i = 0; i < face_pieces && cursor < outer.hi; i++) {
            int32_t end = i + 1 == face_pieces ? outer.hi : faces[i].hi < outer.hi ? faces[i].hi : outer.hi;
            if (end <= cursor)
                continue;
            p->patched +=
                (uint64_t)(faces[i].lo > cursor ? faces[i].lo - cursor : 0) + (uint64_t)(end > faces[i].hi ? end - faces[i].hi : 0);
            write_free(p, y, cursor, end, holes, hole_count, &fills[faces[i].what], face_first + faces[i].what, cell_index, portals);
            cursor = end;
        }
        if (cursor < outer.hi)
            write_free(p, y, cursor, outer.hi, holes, hole_count, &nothing, ENF_NONE, cell_index, portals);
    }
    enf_free(fills);
    p->rows_top = rows_before;
}

static void paint(Painter *p, uint32_t cell_index, Rows aperture, uint32_t portals) {
    const EnfRaycaster *r = p->r;
    uint32_t portal_count = r->scene->cell_portal_first[cell_index + 1] - r->scene->cell_portal_first[cell_index];
    size_t top = p->top;
    Child *children = ENF_NEW(Child, (uint64_t)portal_count + 1);
    p->visits++;
    if (!children) {
        p->status = ENF_ERROR_OUT_OF_MEMORY;
        return;
    }
    uint32_t count = portals < MAX_DEPTH ? find_children(p, cell_index, &aperture, children, portal_count) : 0;
    for (int32_t y = aperture.y0; y < aperture.y1; y++)
        keep_apart(p, children, count, y);
    size_t faces_top = p->top;
    paint_faces(p, cell_index, &aperture, children, count, portals);
    p->top = faces_top;
    for (uint32_t i = 0; i < count && p->status == ENF_OK; i++) {
        const Child *child = &children[i];
        if (!child->closed) {
            paint(p, child->portal.to, child->rows, portals + 1);
            continue;
        }
        double corner[3];
        enf_ray_portal_corner(r, &child->portal, 0, corner);
        FrameFill f = fill_of(p, r->face_count + child->portal.portal, child->portal.normal, corner);
        for (int32_t y = child->rows.y0; y < child->rows.y1; y++) {
            Interval row = row_of(p, &child->rows, y);
            if (row.lo < row.hi)
                write_span(p, y, row.lo, row.hi, &f, r->face_count + child->portal.portal, cell_index, portals);
        }
    }
    p->top = top;
    enf_free(children);
}

typedef struct Bands {
    const ImageTask *task;
    Painter *painters; /* one a band, for its counters and status */
} Bands;

static void paint_band(void *context, uint64_t band, uint32_t thread) {
    Bands *bands = context;
    Painter *p = &bands->painters[band];
    (void)thread;
    p->task = bands->task;
    p->r = p->task->r;
    p->screen = p->task->screen;
    p->image = p->task->image;
    Rows whole = {(int32_t)band * BAND_ROWS, ((int32_t)band + 1) * BAND_ROWS, 0};
    if (whole.y1 > (int32_t)p->image->height)
        whole.y1 = (int32_t)p->image->height;
    if (reserve(p, BAND_ROWS, 0)) {
        for (int32_t y = whole.y0; y < whole.y1; y++)
            p->intervals[p->top++] = (Interval){0, (int32_t)p->image->width};
        if (p->task->cell == ENF_NONE)
            for (int32_t y = whole.y0; y < whole.y1; y++)
                write_span(p, y, 0, (int32_t)p->image->width, &nothing, ENF_NONE, ENF_NONE, 0);
        else
            paint(p, p->task->cell, whole, 0);
    }
    enf_free(p->intervals);
    enf_free(p->rows);
}

EnfStatus enf_image_by_spans(const ImageTask *task) {
    EnfRaycastImage *image = task->image;
    uint32_t band_count = (image->height + BAND_ROWS - 1) / BAND_ROWS;
    EnfStatus status = ENF_OK;
    Bands bands = {task, ENF_NEW(Painter, band_count)};
    if (!bands.painters)
        return enf_fail_memory();
    enf_parallel_for(band_count, image->threads, paint_band, &bands);
    for (uint32_t b = 0; b < band_count; b++) {
        image->spans += bands.painters[b].spans;
        image->visits += bands.painters[b].visits;
        image->patched += bands.painters[b].patched;
        if (bands.painters[b].status != ENF_OK)
            status = bands.painters[b].status;
    }
    enf_free(bands.painters);
    return status == ENF_OK ? ENF_OK : enf_fail_memory();
}
