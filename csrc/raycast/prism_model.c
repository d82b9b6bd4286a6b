/* SPDX-License-Identifier: GPL-3.0-or-later
 * Finds the cells that are upright prisms and packs their outlines. */
#include "raycast/prism_model.h"
#include "raycast/corner_weld.h"
#include "raycast/ray_model.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

#include <stdlib.h>

/* An opening in a side, as wide as the way between two upright lines. */
typedef struct SideHole {
    double from, to; /* along the side, metres */
    double low, high;
    uint32_t side; /* of the raycaster */
} SideHole;

typedef struct Jamb {
    double at; /* along the side, metres */
    uint32_t corner;
} Jamb;

typedef struct Builder {
    const EnfRaycaster *r;
    PrismModel *m;
    CornerWeld weld;
    uint32_t *outline; /* welded corners of the cell at hand, closed: the first one again at the end */
    uint32_t outline_count;
    PrismSection *sections; /* between them */
    struct {
        uint32_t band, side;
        int tall; /* the section is one of `tall` */
    } * bands;    /* openings of the sections at hand: 4 * section + band */
    uint32_t band_count;
    PrismSection *tall; /* what is above three heights; links to each other count from the first of these */
    uint32_t tall_count;
    double *heights;      /* of the section at hand, ascending */
    uint32_t *band_sides; /* [heights + 1] what each band leads through; ENF_NONE: wall */
    Jamb *jambs;
    SideHole *holes;
    int failed; /* out of memory */
} Builder;

static int compare_jambs(const void *left, const void *right) {
    const Jamb *a = left, *b = right;
    return a->at != b->at ? (a->at < b->at ? -1 : 1) : a->corner < b->corner ? -1 : a->corner > b->corner;
}

static int compare_holes(const void *left, const void *right) {
    const SideHole *a = left, *b = right;
    return a->low != b->low ? (a->low < b->low ? -1 : 1) : a->side < b->side ? -1 : a->side > b->side;
}

static uint32_t corner_of(Builder *b, const double p[3]) {
    uint32_t corner = enf_corner_weld_add(&b->weld, p[0], p[1]);
    b->failed |= corner == ENF_NONE;
    return corner;
}

/* A portal as a hole of the side between `ends`, from `start` along `way` (unit) for `length`; 0 when it isn't an upright rectangle in its
 * plane. What hangs over the side's ends is none of its rays' business. */
static int as_hole(Builder *b, uint32_t side, const uint32_t ends[2], const double start[2], const double way[2], double length,
                   SideHole *out, Jamb jambs[2]) {
    const RayPortal portal = enf_ray_portal(b->r, side);
    double v[3], low = INFINITY, high = -INFINITY, tolerance = b->weld.tolerance;
    uint32_t found = 0;
    for (uint32_t i = 0; i < portal.corner_count; i++) {
        enf_ray_portal_corner(b->r, &portal, i, v);
        low = fmin(low, v[2]);
        high = fmax(high, v[2]);
    }
    for (uint32_t i = 0; i < portal.corner_count; i++) {
        enf_ray_portal_corner(b->r, &portal, i, v);
        uint32_t corner = corner_of(b, v);
        if (b->failed || (fabs(v[2] - low) > tolerance && fabs(v[2] - high) > tolerance))
            return 0;
        if ((found > 0 && corner == jambs[0].corner) || (found > 1 && corner == jambs[1].corner))
            continue;
        if (found == 2)
            return 0;
        double x = b->weld.points[corner][0] - start[0], y = b->weld.points[corner][1] - start[1];
        double at = x * way[0] + y * way[1], off = fabs(x * way[1] - y * way[0]);
        if (off > 2 * tolerance)
            return 0;
        jambs[found++] = (Jamb){fmin(fmax(at, 0), length), at < -tolerance ? ends[0] : at > length + tolerance ? ends[1] : corner};
    }
    if (found < 2 || portal.corner_count < 4)
        return 0;
    *out = (SideHole){fmin(jambs[0].at, jambs[1].at), fmax(jambs[0].at, jambs[1].at), low, high, side};
    return 1;
}

/* Bands lo .. hi of the heights at hand, i.e. heights lo .. hi - 1 between them, as one section and those it leads to. */
static int emit_bands(Builder *b, int tall, uint32_t index, uint32_t lo, uint32_t hi, uint32_t face) {
    uint32_t cuts[SECTION_HEIGHTS + 2] = {lo}, count = hi - lo, used = count < SECTION_HEIGHTS ? count : SECTION_HEIGHTS;
    for (uint32_t i = 0; i < used; i++) /* band cuts[i] .. cuts[i + 1] - 1 lie below height cuts[i + 1] - 1 */
        cuts[i + 1] = lo + 1 + (count <= SECTION_HEIGHTS ? i : (i + 1) * count / (SECTION_HEIGHTS + 1));
    cuts[used + 1] = hi + 1;
    for (uint32_t i = 0; i <= SECTION_HEIGHTS; i++) {
        PrismSection *s = tall ? &b->tall[index] : &b->sections[index];
        uint32_t first = cuts[i < used ? i : used], end = cuts[(i < used ? i : used) + 1];
        if (i < SECTION_HEIGHTS)
            s->height[i] = i < used ? (float)b->heights[end - 1] : INFINITY;
        if (end - first > 1) {
            uint32_t next = b->tall_count;
            s->link[i] = LINK_TALL | next;
            if (!ENF_RESERVE(b->tall, (uint64_t)next + 1)) {
                b->failed = 1;
                return 0;
            }
            b->tall[b->tall_count++] = tall ? b->tall[index] : b->sections[index]; /* the same normal */
            if (!emit_bands(b, 1, next, first, end - 1, face))
                return 0;
            continue;
        }
        s->link[i] = LINK_END | face;
        if (b->band_sides[first] == ENF_NONE || i > used)
            continue;
        if (!ENF_RESERVE(b->bands, (uint64_t)b->band_count + 1)) {
            b->failed = 1;
            return 0;
        }
        b->bands[b->band_count].band = (SECTION_HEIGHTS + 1) * index + i;
        b->bands[b->band_count].tall = tall;
        b->bands[b->band_count++].side = b->band_sides[first];
    }
    return 1;
}

/* The bands of one section: holes (by height) that cover it. Where two lie on each other the lower one has the place. 0: out of memory. */
static int stack_bands(Builder *b, uint32_t index, uint32_t face, const double z[2], const SideHole *holes, uint32_t count, double middle) {
    double tolerance = b->weld.tolerance, at = z[0];
    uint32_t heights = 0;
    if (!ENF_RESERVE(b->heights, 2 * (uint64_t)count + 1) || !ENF_RESERVE(b->band_sides, 2 * (uint64_t)count + 2)) {
        b->failed = 1;
        return 0;
    }
    b->band_sides[0] = ENF_NONE;
    for (uint32_t i = 0; i < count; i++) {
        const SideHole *hole = &holes[i];
        if (hole->from > middle || hole->to < middle || hole->high <= at + tolerance || hole->low >= z[1] - tolerance)
            continue;
        if (hole->low > at + tolerance) { /* wall below it */
            b->heights[heights++] = hole->low;
            b->band_sides[heights] = ENF_NONE;
        }
        b->band_sides[heights] = hole->side;
        at = hole->high;
        if (at < z[1] - tolerance) { /* something above it: wall, unless the next hole begins there and takes the band over */
            b->heights[heights++] = at;
            b->band_sides[heights] = ENF_NONE;
        } else
            at = z[1];
    }
    return emit_bands(b, 0, index, 0, heights, face);
}

/* The side between two corners of the outline: appends its sections. */
static int pack_side(Builder *b, uint32_t face_index, uint32_t from, uint32_t to, const double z[2]) {
    const RayFace *face = &b->r->faces[face_index];
    const double *p = b->weld.points[from], *q = b->weld.points[to], *normal = b->r->scene->face_planes[face_index].n;
    double start[2] = {p[0], p[1]}, way[2] = {q[0] - p[0], q[1] - p[1]}, length = hypot(way[0], way[1]);
    uint32_t jamb_count = 0, hole_count = 0;
    if (!(length > 0))
        return 0;
    way[0] /= length;
    way[1] /= length;
    if (!ENF_RESERVE(b->jambs, 2 * (uint64_t)face->side_count + 2) || !ENF_RESERVE(b->holes, (uint64_t)face->side_count + 1)) {
        b->failed = 1;
        return 0;
    }
    b->jambs[jamb_count++] = (Jamb){0, from};
    for (uint32_t i = 0; i < face->side_count; i++, hole_count++, jamb_count += 2)
        if (!as_hole(b, face->side_first + i, (const uint32_t[2]){from, to}, start, way, length, &b->holes[hole_count],
                     &b->jambs[jamb_count]))
            return 0;
    b->jambs[jamb_count++] = (Jamb){length, to};
    qsort(b->jambs, jamb_count, sizeof *b->jambs, compare_jambs);
    qsort(b->holes, hole_count, sizeof *b->holes, compare_holes);
    if (b->jambs[0].corner != from && b->jambs[0].at == 0) /* equal places sort by number: the ends come first and last */
        for (uint32_t i = 0; i < jamb_count; i++)
            if (b->jambs[i].corner == from) {
                Jamb t = b->jambs[0];
                b->jambs[0] = b->jambs[i];
                b->jambs[i] = t;
            }
    uint32_t last = from;
    for (uint32_t i = 1; i < jamb_count; i++) {
        if (b->jambs[i].corner == last)
            continue;
        if (last == to || b->jambs[i].corner == from)
            return 0;
        uint32_t index = b->outline_count - 1;
        if (!ENF_RESERVE(b->outline, (uint64_t)b->outline_count + 1) || !ENF_RESERVE(b->sections, (uint64_t)index + 1)) {
            b->failed = 1;
            return 0;
        }
        double middle = 0.5 * (b->jambs[i].at + b->jambs[i - 1].at), across = hypot(normal[0], normal[1]);
        b->sections[index].nx = (float)(normal[0] / across);
        b->sections[index].ny = (float)(normal[1] / across);
        if (!stack_bands(b, index, face_index, z, b->holes, hole_count, middle))
            return 0;
        b->outline[b->outline_count++] = last = b->jambs[i].corner;
    }
    return last == to;
}

/* A side whose portals don't lie in it side by side and above each other (arches, recesses that overlap): one section, and who leaves by it
 * asks the planes of the cell. */
static void pack_open_side(Builder *b, uint32_t cell, uint32_t face_index, uint32_t to) {
    const double *normal = b->r->scene->face_planes[face_index].n, across = hypot(normal[0], normal[1]);
    uint32_t index = b->outline_count - 1;
    if (!ENF_RESERVE(b->outline, (uint64_t)b->outline_count + 1) || !ENF_RESERVE(b->sections, (uint64_t)index + 1)) {
        b->failed = 1;
        return;
    }
    PrismSection *s = &b->sections[index];
    s->nx = (float)(normal[0] / across);
    s->ny = (float)(normal[1] / across);
    for (uint32_t i = 0; i <= SECTION_HEIGHTS; i++) {
        s->link[i] = LINK_PLANES | cell;
        s->height[i < SECTION_HEIGHTS ? i : 0] = INFINITY;
    }
    b->outline[b->outline_count++] = to;
}

static int add_door(Builder *b, uint32_t link, uint32_t in_node, uint32_t side) {
    const EnfCellPortal *of = &b->r->scene->cell_portals[b->r->sides[side]];
    PrismModel *m = b->m;
    if (!ENF_RESERVE(m->doors, (uint64_t)m->door_count + 1)) {
        b->failed = 1;
        return 0;
    }
    m->doors[m->door_count++] = (PrismDoor){link, in_node, of->portal, of->to};
    return 1;
}

/* What a cap leads to: itself, the one portal that covers it, or the planes of the cell. */
static int pack_cap(Builder *b, uint32_t cell, uint32_t face_index, uint32_t node, uint32_t which) {
    const RayFace *face = &b->r->faces[face_index];
    uint32_t *link = &b->m->nodes[node].cap_link[which];
    *link = face->side_count ? LINK_PLANES | cell : LINK_END | face_index;
    return !face->whole || add_door(b, 2 * node + which, 1, face->side_first);
}

static int level_of(double z, const double levels[2], double tolerance) {
    return fabs(z - levels[0]) <= tolerance ? 0 : fabs(z - levels[1]) <= tolerance ? 1 : -1;
}

/* Which cap a face is (0 floor, 1 ceiling), 2 for a side, -1 for anything else. */
static int kind_of_face(Builder *b, uint32_t cell, uint32_t face, const double z[2]) {
    uint32_t at_level[2] = {0, 0}, count = enf_ray_face_corners(b->r, face);
    for (uint32_t i = 0; i < count; i++) {
        double p[3];
        enf_ray_face_corner(b->r, cell, face, i, p);
        int level = level_of(p[2], z, b->weld.tolerance);
        if (level < 0)
            return -1;
        at_level[level]++;
    }
    if (at_level[0] == count || at_level[1] == count)
        return at_level[0] == count ? 0 : 1;
    /* a side leans less than 1 mm in 1 km */
    return at_level[0] == 2 && at_level[1] == 2 && fabs(b->r->scene->face_planes[face].n[2]) < 1e-6 ? 2 : -1;
}

/* Whether the face stands between two upright lines. */
static int side_has(Builder *b, uint32_t cell, uint32_t face, double z0, uint32_t from, uint32_t to) {
    int has = 0;
    for (uint32_t i = 0; i < enf_ray_face_corners(b->r, face); i++) {
        double p[3];
        enf_ray_face_corner(b->r, cell, face, i, p);
        uint32_t corner = corner_of(b, p);
        if (corner == from || corner == to)
            has |= (corner == from ? 1 : 2) << (fabs(p[2] - z0) <= b->weld.tolerance ? 0 : 2);
    }
    return has == 15;
}

/* Floor and ceiling of a cell that may be a prism, and how many sides stand between; 0 when it isn't one. */
static uint32_t find_caps(Builder *b, uint32_t c, const double z[2], uint32_t caps[2]) {
    const EnfScene *scene = b->r->scene;
    uint32_t sides = 0;
    caps[0] = caps[1] = ENF_NONE;
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++) {
        int kind = kind_of_face(b, c, f, z);
        if (kind < 0 || (kind < 2 && caps[kind] != ENF_NONE))
            return 0;
        if (kind < 2)
            caps[kind] = f;
        else
            sides++;
    }
    if (caps[0] == ENF_NONE || caps[1] == ENF_NONE || sides != enf_ray_face_corners(b->r, caps[0]) || sides < 3)
        return 0;
    return sides;
}

/* Outline and sections of the sides, one after the other round the floor; 0 when they don't close it. */
static int pack_sides(Builder *b, uint32_t c, const double z[2], const uint32_t caps[2], uint32_t n, uint32_t *open_sides) {
    const EnfRaycaster *r = b->r;
    uint32_t face_first = r->scene->cell_face_first[c], face_end = r->scene->cell_face_first[c + 1];
    double p[3];
    *open_sides = b->outline_count = b->band_count = b->tall_count = 0;
    for (uint32_t i = 0; i < n; i++) { /* clockwise seen from above: taken backwards */
        enf_ray_face_corner(r, c, caps[0], n - 1 - i, p);
        uint32_t from = corner_of(b, p), side = face_first;
        enf_ray_face_corner(r, c, caps[0], (2 * n - 2 - i) % n, p);
        uint32_t to = corner_of(b, p);
        if (b->failed || from == to)
            return 0;
        while (side < face_end && (side == caps[0] || side == caps[1] || !side_has(b, c, side, z[0], from, to)))
            side++;
        if (side == face_end)
            return 0;
        if (i == 0) {
            if (!ENF_RESERVE(b->outline, 1)) {
                b->failed = 1;
                return 0;
            }
            b->outline[b->outline_count++] = from;
        }
        uint32_t outline = b->outline_count, bands = b->band_count, tall = b->tall_count;
        if (!pack_side(b, side, from, to, z)) {
            b->outline_count = outline;
            b->band_count = bands;
            b->tall_count = tall;
            pack_open_side(b, c, side, to);
            ++*open_sides;
        }
        if (b->failed)
            return 0;
    }
    return b->outline[b->outline_count - 1] == b->outline[0];
}

/* Appends the sections of the outline, and behind them what is above three heights. 0: out of memory. */
static int append_sections(Builder *b) {
    PrismModel *m = b->m;
    uint32_t sections = b->outline_count - 1, first = m->section_count;
    /* a chunk without an exit reads its last, unused section: there must be one */
    if (!ENF_RESERVE(m->sections, (uint64_t)first + sections + b->tall_count + PRISM_CHUNK))
        return 0;
    memcpy(m->sections + first, b->sections, sections * sizeof *m->sections);
    if (b->tall_count)
        memcpy(m->sections + first + sections, b->tall, b->tall_count * sizeof *m->sections);
    for (uint32_t i = first; i < first + sections + b->tall_count; i++)
        for (uint32_t band = 0; band <= SECTION_HEIGHTS; band++)
            if (m->sections[i].link[band] >= LINK_TALL)
                m->sections[i].link[band] += first + sections;
    m->section_count += sections + b->tall_count;
    memset(m->sections + m->section_count, 0, PRISM_CHUNK * sizeof *m->sections);
    return 1;
}

/* Appends the cell's nodes, a chunk of its outline each, and their caps; section_first: where append_sections put theirs. 0: out of memory. */
static int append_nodes(Builder *b, uint32_t c, const double z[2], const uint32_t caps[2], uint32_t section_first) {
    PrismModel *m = b->m;
    uint32_t sections = b->outline_count - 1, first = m->node_count, chunks = (sections + PRISM_CHUNK - 2) / (PRISM_CHUNK - 1);
    if (!ENF_RESERVE(m->nodes, (uint64_t)first + chunks))
        return 0;
    m->node_count += chunks;
    for (uint32_t k = 0; k < chunks; k++) {
        PrismNode *node = &m->nodes[first + k];
        uint32_t begin = k * (PRISM_CHUNK - 1);
        for (uint32_t i = 0; i < PRISM_CHUNK; i++) {
            const double *corner = b->weld.points[b->outline[begin + i < sections ? begin + i : sections]];
            node->x[i] = (float)corner[0];
            node->y[i] = (float)corner[1];
        }
        node->z[0] = (float)z[0];
        node->z[1] = (float)z[1];
        node->section_first = section_first + begin;
        node->next = k + 1 < chunks ? first + k + 1 : LINK_PLANES | c;
        node->cell = c;
        node->sections = sections - begin < PRISM_CHUNK - 1 ? sections - begin : PRISM_CHUNK - 1;
        for (uint32_t which = 0; which < 2; which++)
            if (!pack_cap(b, c, caps[which], first + k, which))
                return 0;
    }
    return 1;
}

/* Appends the nodes of a cell that is a prism; 0 when it isn't one. */
static int pack_prism(Builder *b, uint32_t c) {
    const EnfRaycaster *r = b->r;
    const EnfScene *scene = r->scene;
    PrismModel *m = b->m;
    double z[2] = {INFINITY, -INFINITY};
    uint32_t caps[2], open_sides;
    for (uint32_t v = scene->cell_vertex_first[c]; v < scene->cell_vertex_first[c + 1]; v++) {
        z[0] = fmin(z[0], scene->cell_vertices[v][2] - scene->origin[2]);
        z[1] = fmax(z[1], scene->cell_vertices[v][2] - scene->origin[2]);
    }
    if (scene->cell_face_first[c + 1] - scene->cell_face_first[c] < 5 || !(z[1] - z[0] > 4 * b->weld.tolerance))
        return 0;
    uint32_t sides = find_caps(b, c, z, caps);
    if (!sides || !pack_sides(b, c, z, caps, sides, &open_sides))
        return 0;
    uint32_t sections = b->outline_count - 1, section_first = m->section_count;
    if (!append_sections(b) || !append_nodes(b, c, z, caps, section_first)) {
        b->failed = 1;
        return 0;
    }
    for (uint32_t i = 0; i < b->band_count; i++)
        if (!add_door(b, (SECTION_HEIGHTS + 1) * (section_first + (b->bands[i].tall ? sections : 0)) + b->bands[i].band, 0,
                      b->bands[i].side))
            return 0;
    m->open_sides += open_sides;
    for (uint32_t which = 0; which < 2; which++)
        m->open_caps += r->faces[caps[which]].side_count > 0 && !r->faces[caps[which]].whole;
    return 1;
}

enum { MOST_FINAL_PLANES = 64 };

/* Whether no portal of a cell without walls lets a ray through that came in by another (or the same): all lie behind each other's planes,
 * seen from inside the cell. So it is for what is outside of a box. */
static int is_final(const EnfScene *scene, uint32_t c) {
    const EnfPlane *planes[MOST_FINAL_PLANES];
    double signs[MOST_FINAL_PLANES];
    uint32_t plane_count = 0, first = scene->cell_portal_first[c], end = scene->cell_portal_first[c + 1];
    if (scene->cell_face_first[c] < scene->cell_face_first[c + 1])
        return 0;
    for (uint32_t s = first; s < end; s++) {
        const EnfPlane *plane = &scene->portal_planes[scene->cell_portals[s].portal];
        double sign = scene->cell_portals[s].side ? 1 : -1; /* into the cell */
        uint32_t k = 0;
        while (k < plane_count && !(sign * signs[k] * vec_dot(plane->n, planes[k]->n) > 1 - 1e-12 &&
                                    fabs(sign * plane->d - signs[k] * planes[k]->d) <= scene->tolerance))
            k++;
        if (k < plane_count)
            continue;
        if (k == MOST_FINAL_PLANES)
            return 0;
        planes[plane_count] = plane;
        signs[plane_count++] = sign;
    }
    for (uint32_t s = first; s < end; s++) {
        uint32_t portal = scene->cell_portals[s].portal;
        for (uint32_t v = scene->portal_vertex_first[portal]; v < scene->portal_vertex_first[portal + 1]; v++) {
            double p[3];
            vec_sub(p, scene->portal_vertices[v], scene->origin);
            for (uint32_t k = 0; k < plane_count; k++)
                if (signs[k] * (vec_dot(planes[k]->n, p) - planes[k]->d) > scene->tolerance)
                    return 0;
        }
    }
    return 1;
}

EnfStatus enf_prism_model_build(PrismModel *m, const EnfRaycaster *r) {
    Builder b;
    memset(&b, 0, sizeof b);
    b.r = r;
    b.m = m;
    /* What the scene holds to be one point is one; and never finer than single precision can tell. */
    double tolerance = fmax(r->scene->tolerance, 2.5 * FLT_EPSILON * 0.5 * r->scene->extent);
    m->node_of_cell = ENF_NEW(uint32_t, r->cell_count);
    m->way_into = ENF_NEW(uint32_t, r->cell_count);
    if (!m->node_of_cell || !m->way_into || !enf_corner_weld_init(&b.weld, tolerance, 4 * (uint64_t)r->cell_count))
        b.failed = 1;
    for (uint32_t c = 0; c < r->cell_count && !b.failed; c++) {
        uint32_t nodes = m->node_count, sections = m->section_count, doors = m->door_count;
        m->node_of_cell[c] = nodes;
        m->unwalled += r->scene->cell_face_first[c] == r->scene->cell_face_first[c + 1];
        if (pack_prism(&b, c)) {
            m->prisms++;
            continue;
        }
        m->node_of_cell[c] = LINK_PLANES | c;
        m->node_count = nodes;
        m->section_count = sections;
        m->door_count = doors;
    }
    enf_corner_weld_free(&b.weld);
    enf_free(b.outline);
    enf_free(b.sections);
    enf_free(b.bands);
    enf_free(b.tall);
    enf_free(b.heights);
    enf_free(b.band_sides);
    enf_free(b.jambs);
    enf_free(b.holes);
    if (b.failed)
        return enf_fail_memory();
    for (uint32_t c = 0; c < r->cell_count; c++)
        m->way_into[c] = is_final(r->scene, c) ? LINK_OUT | c : m->node_of_cell[c];
    enf_prism_model_set_doors(m, r);
    /* Doors without an opening never change again. */
    uint32_t kept = 0;
    for (uint32_t i = 0; i < m->door_count; i++)
        if (r->scene->portal_openings[m->doors[i].portal] != ENF_NONE)
            m->doors[kept++] = m->doors[i];
    m->door_count = kept;
    /* Arrays grew with room to spare: given back, since they stay for good. A smaller block that can't be had leaves the larger one. */
    void *tight;
    if ((tight = enf_realloc(m->nodes, m->node_count * sizeof *m->nodes)))
        m->nodes = tight;
    if ((tight = enf_realloc(m->sections, (m->section_count + PRISM_CHUNK) * sizeof *m->sections)))
        m->sections = tight;
    if ((tight = enf_realloc(m->doors, m->door_count * sizeof *m->doors)))
        m->doors = tight;
    return ENF_OK;
}

void enf_prism_model_set_doors(PrismModel *m, const EnfRaycaster *r) {
    for (uint32_t i = 0; i < m->door_count; i++) {
        const PrismDoor *door = &m->doors[i];
        uint32_t link = enf_portal_passes(r->scene, door->portal) ? m->way_into[door->to] : LINK_END | (r->face_count + door->portal);
        if (door->in_node)
            m->nodes[door->link / 2].cap_link[door->link % 2] = link;
        else
            m->sections[door->link / (SECTION_HEIGHTS + 1)].link[door->link % (SECTION_HEIGHTS + 1)] = link;
    }
}

void enf_prism_model_free(PrismModel *m) {
    enf_free(m->nodes);
    enf_free(m->sections);
    enf_free(m->node_of_cell);
    enf_free(m->way_into);
    enf_free(m->doors);
}
