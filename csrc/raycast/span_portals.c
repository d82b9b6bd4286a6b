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

enum { BAND_ROWS = 128, MAX_DEPTH = 255 };

/* A polygon's or an aperture's pixels: in rows y0 .. y1 - 1 an interval each, Painter.lo and hi from `first` on; empty where lo >= hi. */
typedef struct Rows {
    int32_t y0, y1;
    size_t first;
} Rows;

/* A portal that the aperture shows. */
typedef struct Child {
    RayPortal portal;
    Rows rows;
    uint32_t front; /* that it lies in */
} Child;

/* A face that the aperture shows; of a cell without faces, all that its portals leave. */
typedef struct Front {
    Rows rows;
    FrameFill fill;
    uint32_t surface;
} Front;

/* A piece of a row and what fills it. */
typedef struct Piece {
    int32_t lo, hi;
    uint32_t what;
} Piece;

/* One a thread, for all of its bands. */
typedef struct Painter {
    const ImageTask *task;
    const EnfRaycaster *r;
    const Screen *screen;
    EnfRaycastImage *image;
    int32_t *lo, *hi; /* stacks */
    size_t top;
    Child *children; /* a stack */
    uint32_t child_top;
    /* of the cell or polygon at hand */
    Front *fronts;
    Piece *front_pieces, *child_pieces;
    double (*polygon)[3], (*flat)[2];
    uint64_t spans, visits, patched;
    EnfStatus status;
    char apart[64]; /* what two threads count lies in no cache line together */
} Painter;

static int had(Painter *p, int memory) {
    if (!memory)
        p->status = ENF_ERROR_OUT_OF_MEMORY;
    return memory;
}

static void to_camera(const Screen *s, const double point[3], double out[3]) {
    double v[3];
    vec_sub(v, point, s->eye);
    for (int k = 0; k < 3; k++)
        out[k] = vec_dot(s->axes[k], v);
}

/* Projects a polygon given in camera space; cuts off what lies nearer than the guard. The new corner on a cut edge is computed from
 * its far end, in whichever direction the edge runs. Gives the corners in `out`, at most one more. */
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

static Rows no_rows(const Painter *p, const Rows *aperture) {
    return (Rows){aperture->y0, aperture->y0, p->top};
}

/* Scan-converts p->polygon within the aperture. Pushes intervals; gives the rows that have any. */
static Rows scan(Painter *p, uint32_t corner_count, const Rows *aperture) {
    Rows rows = no_rows(p, aperture);
    double top = INFINITY, bottom = -INFINITY;
    if (!had(p, ENF_RESERVE(p->flat, 2 * (uint64_t)corner_count)))
        return rows;
    uint32_t n = project(p->screen, (const double(*)[3])p->polygon, corner_count, p->flat);
    const double(*v)[2] = (const double(*)[2])p->flat;
    for (uint32_t i = 0; i < n; i++) {
        top = v[i][1] < top ? v[i][1] : top;
        bottom = v[i][1] > bottom ? v[i][1] : bottom;
    }
    int32_t y0 = enf_first_pixel(top), y1 = enf_first_pixel(bottom);
    y0 = y0 > aperture->y0 ? y0 : aperture->y0;
    y1 = y1 < aperture->y1 ? y1 : aperture->y1;
    if (n < 3 || y0 >= y1)
        return rows;
    size_t height = (size_t)(y1 - y0);
    if (!had(p, ENF_RESERVE(p->lo, p->top + height) && ENF_RESERVE(p->hi, p->top + height)))
        return rows;
    int32_t *lo = p->lo + p->top, *hi = p->hi + p->top;
    for (size_t i = 0; i < height; i++) {
        lo[i] = INT32_MAX;
        hi[i] = INT32_MIN;
    }
    for (uint32_t i = 0; i < n; i++) {
        const double *s = v[i], *e = v[i + 1 < n ? i + 1 : 0];
        if (s[1] > e[1] || (s[1] == e[1] && s[0] > e[0])) { /* one order for both polygons on the edge */
            const double *t = s;
            s = e;
            e = t;
        }
        int32_t from = enf_first_pixel(s[1]), until = enf_first_pixel(e[1]);
        from = from > y0 ? from : y0;
        until = until < y1 ? until : y1;
        if (from < until)
            p->task->kernel->edge(lo + (from - y0), hi + (from - y0), from, (uint32_t)(until - from), s, (e[0] - s[0]) / (e[1] - s[1]));
    }
    size_t outer = aperture->first + (size_t)(y0 - aperture->y0), first = 0;
    if (p->task->kernel->clip(lo, hi, p->lo + outer, p->hi + outer, (uint32_t)height) == 0)
        return rows;
    while (lo[first] >= hi[first])
        first++;
    while (lo[height - 1] >= hi[height - 1])
        height--;
    rows = (Rows){y0 + (int32_t)first, y0 + (int32_t)height, p->top + first};
    p->top += height;
    return rows;
}

static Rows scan_portal(Painter *p, const RayPortal *portal, const Rows *aperture) {
    double to[3];
    enf_ray_portal_corner(p->r, portal, 0, to);
    vec_sub(to, to, p->screen->eye);
    if (!(vec_dot(portal->normal, to) > 0) || !had(p, ENF_RESERVE(p->polygon, portal->corner_count)))
        return no_rows(p, aperture);
    for (uint32_t k = 0; k < portal->corner_count; k++) {
        enf_ray_portal_corner(p->r, portal, k, to);
        to_camera(p->screen, to, p->polygon[k]);
    }
    return scan(p, portal->corner_count, aperture);
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

/* Adds the row's interval, if it has one, to pieces sorted by where they begin. */
static uint32_t insert_piece(const Painter *p, Piece *pieces, uint32_t count, const Rows *rows, int32_t y, uint32_t what) {
    if (y < rows->y0 || y >= rows->y1)
        return count;
    size_t at = rows->first + (size_t)(y - rows->y0);
    Piece piece = {p->lo[at], p->hi[at], what};
    if (piece.lo >= piece.hi)
        return count;
    uint32_t i = count;
    for (; i > 0 && pieces[i - 1].lo > piece.lo; i--)
        pieces[i] = pieces[i - 1];
    pieces[i] = piece;
    return count + 1;
}

static double nearness(const Painter *p, uint32_t child, int32_t x, int32_t y) {
    const RayPortal *portal = &p->children[child].portal;
    double point[3];
    enf_ray_portal_corner(p->r, portal, 0, point);
    InverseDepth f = enf_inverse_depth(p->screen, portal->normal, point);
    return f.a * x + f.b * y + f.c;
}

/* Pixels that two children of a row have both go to the nearer one. Those of a convex cell share none but by rounding, or where portals lie on
 * each other; outdoors they may, and what a nearer one cuts off right of itself is given up. */
static uint32_t keep_apart(const Painter *p, Piece *pieces, uint32_t count, int32_t y) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        Piece piece = pieces[i];
        while (kept > 0 && pieces[kept - 1].hi > piece.lo && piece.lo < piece.hi) {
            Piece *last = &pieces[kept - 1];
            if (nearness(p, piece.what, piece.lo, y) > nearness(p, last->what, piece.lo, y)) {
                last->hi = piece.lo;
                kept -= last->lo >= last->hi;
            } else
                piece.lo = last->hi;
        }
        if (piece.lo < piece.hi)
            pieces[kept++] = piece;
    }
    return kept;
}

/* Pixels lo .. hi - 1 of the row belong to this front: its children keep what they have of them, the rest is written. */
static void paint_piece(Painter *p, uint32_t front_index, int32_t y, int32_t lo, int32_t hi, uint32_t hole_count, uint32_t cell,
                        uint32_t portals) {
    const Front *front = &p->fronts[front_index];
    for (uint32_t h = 0; h < hole_count && p->child_pieces[h].lo < hi; h++) {
        const Piece *hole = &p->child_pieces[h];
        Child *child = &p->children[hole->what];
        int32_t from = hole->lo > lo ? hole->lo : lo, until = hole->hi < hi ? hole->hi : hi;
        if (child->front != front_index || from >= until)
            continue;
        if (from > lo)
            write_span(p, y, lo, from, &front->fill, front->surface, cell, portals);
        size_t at = child->rows.first + (size_t)(y - child->rows.y0);
        p->lo[at] = from;
        p->hi[at] = until;
        lo = until;
    }
    if (lo < hi)
        write_span(p, y, lo, hi, &front->fill, front->surface, cell, portals);
}

/* Row by row: every pixel of the aperture goes to one front, and there to a child or to the picture. Children's intervals become what
 * they got. */
static void paint_rows(Painter *p, const Rows *aperture, uint32_t front_count, uint32_t child_first, uint32_t cell, uint32_t portals) {
    for (int32_t y = aperture->y0; y < aperture->y1; y++) {
        size_t at = aperture->first + (size_t)(y - aperture->y0);
        int32_t cursor = p->lo[at], right = p->hi[at];
        if (cursor >= right)
            continue;
        uint32_t piece_count = 0, hole_count = 0;
        for (uint32_t f = 0; f < front_count; f++)
            piece_count = insert_piece(p, p->front_pieces, piece_count, &p->fronts[f].rows, y, f);
        for (uint32_t i = child_first; i < p->child_top; i++) {
            const Rows *rows = &p->children[i].rows;
            hole_count = insert_piece(p, p->child_pieces, hole_count, rows, y, i);
            if (y >= rows->y0 && y < rows->y1)
                p->lo[rows->first + (size_t)(y - rows->y0)] = INT32_MAX;
        }
        if (hole_count > 1)
            hole_count = keep_apart(p, p->child_pieces, hole_count, y);
        for (uint32_t i = 0; i < piece_count && cursor < right; i++) {
            const Piece *piece = &p->front_pieces[i];
            int32_t end = i + 1 == piece_count ? right : piece->hi;
            if (end <= cursor)
                continue;
            p->patched += (uint64_t)(piece->lo > cursor ? piece->lo - cursor : 0) + (uint64_t)(end > piece->hi ? end - piece->hi : 0);
            paint_piece(p, piece->what, y, cursor, end, hole_count, cell, portals);
            cursor = end;
        }
        if (cursor < right)
            write_span(p, y, cursor, right, &nothing, ENF_NONE, cell, portals);
    }
}

/* Pushes the portals of a front that the aperture shows; one that is all of it shares its intervals. */
static void push_children(Painter *p, uint32_t front, uint32_t side_first, uint32_t side_count, int whole, const Rows *aperture) {
    for (uint32_t side = side_first; side < side_first + side_count; side++) {
        Child child = {enf_ray_portal(p->r, side), {0, 0, 0}, front};
        child.rows = whole ? p->fronts[front].rows : scan_portal(p, &child.portal, aperture);
        if (child.rows.y0 >= child.rows.y1)
            continue;
        if (!had(p, ENF_RESERVE(p->children, (uint64_t)p->child_top + 1)))
            return;
        p->children[p->child_top++] = child;
    }
}

/* The faces that the aperture shows, with their portals. */
static uint32_t find_fronts(Painter *p, uint32_t cell, const Rows *aperture, int with_children) {
    const EnfRaycaster *r = p->r;
    uint32_t face_first = r->scene->cell_face_first[cell], face_count = r->scene->cell_face_first[cell + 1] - face_first, count = 0;
    uint32_t side_first = r->scene->cell_portal_first[cell], side_count = r->scene->cell_portal_first[cell + 1] - side_first;
    if (!had(p, ENF_RESERVE(p->fronts, (uint64_t)face_count + 1)))
        return 0;
    if (face_count == 0) {
        p->fronts[0] = (Front){*aperture, nothing, ENF_NONE};
        if (with_children)
            push_children(p, 0, side_first, side_count, 0, aperture);
        return 1;
    }
    for (uint32_t f = face_first; f < face_first + face_count; f++) {
        const double *normal = r->scene->face_planes[f].n;
        uint32_t corner_count = enf_ray_face_corners(r, f);
        double to[3], point[3];
        enf_ray_face_corner(r, cell, f, 0, point);
        vec_sub(to, point, p->screen->eye);
        if (!(vec_dot(normal, to) > 0)) /* the eye is beyond it or in it: edge-on */
            continue;
        if (!had(p, ENF_RESERVE(p->polygon, corner_count)))
            return 0;
        for (uint32_t k = 0; k < corner_count; k++) {
            enf_ray_face_corner(r, cell, f, k, to);
            to_camera(p->screen, to, p->polygon[k]);
        }
        Rows rows = scan(p, corner_count, aperture);
        if (rows.y0 >= rows.y1)
            continue;
        p->fronts[count] = (Front){rows, fill_of(p, f, normal, point), f};
        if (with_children)
            push_children(p, count, r->faces[f].side_first, r->faces[f].side_count, (int)r->faces[f].whole, aperture);
        count++;
    }
    return count;
}

static void paint_leaf(Painter *p, const Child *child, uint32_t cell, uint32_t portals) {
    double corner[3];
    uint32_t surface = p->r->face_count + child->portal.portal;
    enf_ray_portal_corner(p->r, &child->portal, 0, corner);
    FrameFill f = fill_of(p, surface, child->portal.normal, corner);
    for (int32_t y = child->rows.y0; y < child->rows.y1; y++) {
        size_t at = child->rows.first + (size_t)(y - child->rows.y0);
        if (p->lo[at] < p->hi[at])
            write_span(p, y, p->lo[at], p->hi[at], &f, surface, cell, portals);
    }
}

/* Rows without pixels at both ends go. */
static Rows trim(const Painter *p, Rows rows) {
    for (; rows.y0 < rows.y1 && p->lo[rows.first] >= p->hi[rows.first]; rows.y0++)
        rows.first++;
    while (rows.y0 < rows.y1 && p->lo[rows.first + (size_t)(rows.y1 - rows.y0) - 1] >= p->hi[rows.first + (size_t)(rows.y1 - rows.y0) - 1])
        rows.y1--;
    return rows;
}

static void paint(Painter *p, uint32_t cell, Rows aperture, uint32_t portals) {
    size_t top = p->top;
    uint32_t child_first = p->child_top, front_count = find_fronts(p, cell, &aperture, portals < MAX_DEPTH), child_end = p->child_top;
    p->visits++;
    if (p->status != ENF_OK || !had(p, ENF_RESERVE(p->front_pieces, front_count) && ENF_RESERVE(p->child_pieces, child_end - child_first)))
        return;
    paint_rows(p, &aperture, front_count, child_first, cell, portals);
    for (uint32_t i = child_first; i < child_end && p->status == ENF_OK; i++) {
        Child child = p->children[i];
        child.rows = trim(p, child.rows);
        if (child.rows.y0 >= child.rows.y1)
            continue;
        if (enf_portal_passes(p->r->scene, child.portal.portal))
            paint(p, child.portal.to, child.rows, portals + 1);
        else
            paint_leaf(p, &child, cell, portals);
    }
    p->child_top = child_first;
    p->top = top;
}

static void paint_band(void *context, uint64_t band, uint32_t thread) {
    Painter *p = &((Painter *)context)[thread];
    const EnfRaycastImage *image = p->image;
    Rows whole = {(int32_t)band * BAND_ROWS, ((int32_t)band + 1) * BAND_ROWS, 0};
    if (whole.y1 > (int32_t)image->height)
        whole.y1 = (int32_t)image->height;
    p->top = (size_t)(whole.y1 - whole.y0);
    if (p->status != ENF_OK || !had(p, ENF_RESERVE(p->lo, p->top) && ENF_RESERVE(p->hi, p->top)))
        return;
    for (size_t i = 0; i < p->top; i++) {
        p->lo[i] = 0;
        p->hi[i] = (int32_t)image->width;
    }
    if (p->task->cell != ENF_NONE)
        paint(p, p->task->cell, whole, 0);
    else
        for (int32_t y = whole.y0; y < whole.y1; y++)
            write_span(p, y, 0, (int32_t)image->width, &nothing, ENF_NONE, ENF_NONE, 0);
}

EnfStatus enf_image_by_spans(const ImageTask *task) {
    EnfRaycastImage *image = task->image;
    uint32_t band_count = (image->height + BAND_ROWS - 1) / BAND_ROWS, threads = image->threads ? image->threads : enf_processor_count();
    threads = threads < band_count ? threads : band_count;
    EnfStatus status = ENF_OK;
    Painter *painters = ENF_NEW(Painter, threads);
    if (!painters)
        return enf_fail_memory();
    for (uint32_t t = 0; t < threads; t++) {
        painters[t].task = task;
        painters[t].r = task->r;
        painters[t].screen = task->screen;
        painters[t].image = image;
    }
    enf_parallel_for(band_count, threads, paint_band, painters);
    for (uint32_t t = 0; t < threads; t++) {
        Painter *p = &painters[t];
        image->spans += p->spans;
        image->visits += p->visits;
        image->patched += p->patched;
        status = p->status != ENF_OK ? p->status : status;
        enf_free(p->lo);
        enf_free(p->hi);
        enf_free(p->children);
        enf_free(p->fronts);
        enf_free(p->front_pieces);
        enf_free(p->child_pieces);
        enf_free(p->polygon);
        enf_free(p->flat);
    }
    enf_free(painters);
    return status == ENF_OK ? ENF_OK : enf_fail_memory();
}
