/* SPDX-License-Identifier: GPL-3.0-or-later
 * A portal between rooms, split among their cells.
 *
 * Portals as drawn lie on a room's wall, or a little off it on either side. So the polygon is moved a little
 * along its normal, to where most of it lies inside the room, and what each cell cuts out of it there is the
 * cell's piece. The cuts are then made in the polygon itself: pieces share their cut corners bit for bit, and
 * together they are the polygon. What lies in no cell goes to the nearest one (more opening, never less) and
 * is counted. */
#include "base/memory.h"
#include "base/status.h"
#include "geometry/convex_hull.h"
#include "geometry/polygon.h"
#include "geometry/tolerance.h"
#include "geometry/vec3.h"
#include "scene/cell_side.h"
#include "scene/portal_join.h"
#include "scene/problems.h"
#include "scene/room_shapes.h"

typedef struct CellPlane {
    double n[3], d; /* outward, about Join.centre */
} CellPlane;

typedef struct JoinCell {
    uint32_t cell, first, count; /* into Side.planes */
} JoinCell;

typedef struct Side {
    uint32_t only;   /* the one cell everything goes to, or ENF_NONE */
    JoinCell *cells; /* those that may take a piece, ascending */
    uint32_t cell_count;
    CellPlane *planes;
    uint32_t plane_count;
    double shift; /* metres along Join.normal */
    double eps;
    double outside; /* fraction of the area in no cell */
} Side;

typedef struct Piece {
    double (*points)[3]; /* about Join.centre */
    uint32_t count;
    uint32_t cells[2];
} Piece;

typedef struct PieceList {
    Piece *items;
    uint32_t count;
} PieceList;

typedef struct Join {
    EnfScene *scene;
    double (*polygon)[3]; /* about centre */
    uint32_t count;
    double centre[3], normal[3], radius, area;
    Side sides[2];
    PieceList pieces;
    int shaped_only; /* a room's cell without geometry doesn't take part */
} Join;

static void free_pieces(PieceList *list) {
    for (uint32_t i = 0; i < list->count; i++)
        enf_free(list->items[i].points);
    enf_free(list->items);
    memset(list, 0, sizeof *list);
}

static int add_piece(PieceList *list, double (*points)[3], uint32_t count, uint32_t a, uint32_t b) {
    double(*copy)[3] = enf_alloc_array(count, sizeof *copy);
    if (!copy || !ENF_RESERVE(list->items, (uint64_t)list->count + 1)) {
        enf_free(copy);
        return 0;
    }
    memcpy(copy, points, count * sizeof *copy);
    list->items[list->count++] = (Piece){copy, count, {a, b}};
    return 1;
}

/* Outward planes of a cell, from its faces or its vertices' hull, pushed out to the farthest vertex. */
static int gather_planes(const Join *j, Side *side, uint32_t c) {
    const EnfScene *s = j->scene;
    uint32_t first = s->cell_vertex_first[c], count = s->cell_vertex_first[c + 1] - first;
    double(*v)[3] = enf_alloc_array(count, sizeof *v), (*corners)[3] = NULL;
    EnfHull hull = {0};
    double box[6];
    int ok = v != NULL, flat = 0;
    box_empty(box);
    for (uint32_t i = 0; i < count && ok; i++) {
        vec_sub(v[i], s->cell_vertices[first + i], j->centre);
        box_add_point(box, v[i]);
    }
    uint32_t faces = s->cell_face_first[c + 1] - s->cell_face_first[c], begin = s->cell_face_first[c];
    if (ok && faces == 0) {
        int status = enf_hull_build(&hull, v, count, 1e-9 * box_diagonal(box));
        ok = status != ENF_HULL_NO_MEMORY;
        flat = status == ENF_HULL_FLAT;
        faces = hull.face_count;
    }
    ok = ok && ENF_RESERVE(side->cells, (uint64_t)side->cell_count + 1) && ENF_RESERVE(side->planes, (uint64_t)side->plane_count + faces);
    uint32_t start = side->plane_count, at = 0;
    for (uint32_t f = 0; f < faces && ok; f++) {
        const uint32_t *loop = hull.face_count ? hull.face_indices + at : s->face_indices + s->face_index_first[begin + f];
        uint32_t size = hull.face_count ? hull.face_sizes[f] : s->face_index_first[begin + f + 1] - s->face_index_first[begin + f];
        at += size;
        ok = ENF_RESERVE(corners, size);
        int known = size >= 3;
        for (uint32_t i = 0; i < size && ok; i++) {
            known &= loop[i] < count; /* a dangling index is commit's to report */
            if (known)
                vec_copy(corners[i], v[loop[i]]);
        }
        CellPlane plane;
        if (!ok || !known || enf_polygon_normal(plane.n, corners, size) == 0.0)
            continue;
        plane.d = -DBL_MAX;
        for (uint32_t i = 0; i < count; i++)
            plane.d = fmax(plane.d, vec_dot(plane.n, v[i]));
        side->planes[side->plane_count++] = plane;
    }
    if (ok && !flat)
        side->cells[side->cell_count++] = (JoinCell){c, start, side->plane_count - start};
    enf_free(v);
    enf_free(corners);
    enf_hull_free(&hull);
    return ok;
}

/* Scratch polygons for clipping. */
typedef struct Clip {
    double (*a)[3], (*b)[3], (*c)[3];
} Clip;

static void free_clip(Clip *clip) {
    enf_free(clip->a);
    enf_free(clip->b);
    enf_free(clip->c);
}

static int clip_room(Clip *clip, uint32_t count) {
    return ENF_RESERVE(clip->a, count) && ENF_RESERVE(clip->b, count) && ENF_RESERVE(clip->c, count);
}

/* Area of the polygon that cell `c` covers when it is moved by `shift`; -1: no memory. */
static double covered_area(const Join *j, const Side *side, const JoinCell *c, double shift, Clip *clip) {
    uint32_t count = j->count, none;
    double n[3];
    if (!clip_room(clip, count + c->count + 2))
        return -1.0;
    memcpy(clip->a, j->polygon, count * sizeof *clip->a);
    for (uint32_t i = 0; i < c->count; i++) {
        const CellPlane *plane = &side->planes[c->first + i];
        double d = plane->d - shift * vec_dot(plane->n, j->normal);
        enf_polygon_split(clip->a, count, plane->n, d, side->eps, clip->b, &count, clip->c, &none);
        if (count < 3)
            return 0.0;
        double(*t)[3] = clip->a;
        clip->a = clip->b;
        clip->b = t;
    }
    return enf_polygon_normal(n, clip->a, count);
}

static int find_shift(Join *j, Side *side, Clip *clip) {
    /* In portal radii: from "on the wall" to "half a metre off it" for a door. */
    static const double steps[] = {0.0, 1e-3, 1e-2, 0.05, 0.2, 0.5, 1.0};
    double best = -1.0;
    /* The first step at which most of it is inside: farther in, a neighbouring part of the room could cover
     * what hangs over. */
    for (uint32_t k = 0; k < sizeof steps / sizeof *steps && best < 0.5 * j->area; k++)
        for (int sign = -1; sign <= 1; sign += 2) {
            double shift = sign * (4.0 * side->eps + steps[k] * j->radius), sum = 0.0;
            for (uint32_t i = 0; i < side->cell_count; i++) {
                double area = covered_area(j, side, &side->cells[i], shift, clip);
                if (area < 0.0)
                    return 0;
                sum += area;
            }
            if (sum > best * (1.0 + 1e-6) + 1e-12 * j->area) {
                best = sum;
                side->shift = shift;
            }
        }
    side->outside = best > 0.0 ? fmax(0.0, 1.0 - best / j->area) : 1.0;
    return 1;
}

/* On which side of the portal a cell lies: 1 ahead of its normal, -1 behind, 0 on both, or not known. As the validator judges it. */
static int side_of_cell(const Join *j, uint32_t c) {
    double low, high;
    enf_cell_reach(j->scene, c, j->centre, j->normal, 0.0, &low, &high);
    double where = enf_plain_side(low, high);
    return where > ENF_ONE_SIDE ? 1 : where < -ENF_ONE_SIDE ? -1 : 0;
}

/* The cell a point lies least outside of. */
static uint32_t nearest_cell(const Join *j, const Side *side, const double point[3]) {
    double best = DBL_MAX, moved[3];
    uint32_t cell = side->cells[0].cell;
    vec_mad(moved, point, side->shift, j->normal);
    for (uint32_t i = 0; i < side->cell_count; i++) {
        double most = -DBL_MAX;
        for (uint32_t k = 0; k < side->cells[i].count; k++) {
            const CellPlane *plane = &side->planes[side->cells[i].first + k];
            most = fmax(most, vec_dot(plane->n, moved) - plane->d);
        }
        if (most < best) {
            best = most;
            cell = side->cells[i].cell;
        }
    }
    return cell;
}

static void cell_bounds(const EnfScene *s, uint32_t c, double box[6]) {
    for (uint32_t v = s->cell_vertex_first[c]; v < s->cell_vertex_first[c + 1]; v++)
        box_add_point(box, s->cell_vertices[v]);
}

/* Takes the planes of the room's cells near the portal; of all of them if there is none near. Cells on the `wrong` side can't be looked
 * from through the portal: they take no part, unless all lie there. 0: out of memory. */
static int gather_cells(Join *j, Side *side, uint32_t first, int wrong) {
    const EnfScene *s = j->scene;
    double query[6];
    vec_copy(query, j->centre);
    vec_copy(query + 3, j->centre);
    box_grow(query, 2.0 * j->radius + 8.0 * side->eps);
    for (int all = 0; all < 3 && side->cell_count == 0; all++)
        for (uint32_t c = first; c != ENF_NONE; c = s->shapes->next[c]) {
            double box[6];
            if (s->cell_vertex_first[c] == s->cell_vertex_first[c + 1] || (all < 2 && wrong != 0 && side_of_cell(j, c) == wrong))
                continue;
            box_empty(box);
            cell_bounds(s, c, box);
            if ((all || box_touches_box(query, box)) && !gather_planes(j, side, c))
                return 0;
        }
    return 1;
}

/* Where one cell alone takes part, or none does, there is no need to cut. */
static void find_only(Join *j, Side *side, Clip *clip) {
    uint32_t taking = 0, last = ENF_NONE;
    double sliver = 4.0 * side->eps * j->radius;
    for (uint32_t i = 0; i < side->cell_count; i++)
        if (covered_area(j, side, &side->cells[i], side->shift, clip) > sliver) {
            taking++;
            last = side->cells[i].cell;
        }
    if (taking == 1)
        side->only = last;
    if (taking == 0) {
        double zero[3] = {0, 0, 0};
        side->only = nearest_cell(j, side, zero);
    }
}

/* wrong: the side of the portal on which the cell lies that the room is joined with, 0: not known. */
static EnfStatus prepare_room(Join *j, Side *side, uint32_t room, int wrong, Clip *clip) {
    EnfScene *s = j->scene;
    uint32_t first = s->shapes->head[room];
    if (first == ENF_NONE)
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_join: room %u (\"%.60s\") has no cell", room, s->rooms[room].name);
    side->only = ENF_NONE;
    if (s->shapes->next[first] == ENF_NONE) {
        side->only = first;
        return ENF_OK;
    }
    double box[6], largest = 0.0;
    box_empty(box);
    for (uint32_t c = first; c != ENF_NONE; c = s->shapes->next[c]) {
        /* A cell without geometry is everything of its room that no other cell is: it borders on all. */
        if (s->cell_vertex_first[c] == s->cell_vertex_first[c + 1] && !j->shaped_only) {
            side->only = c;
            return ENF_OK;
        }
        cell_bounds(s, c, box);
    }
    for (int k = 0; k < 6; k++)
        largest = fmax(largest, fabs(box[k]));
    side->eps = ENF_TOLERANCE_ROOM * fmax(box_diagonal(box), j->radius) + ENF_TOLERANCE_COORDINATE * largest;
    if (!gather_cells(j, side, first, wrong))
        return enf_fail_memory();
    if (side->cell_count == 0) {
        side->only = first;
        return ENF_OK;
    }
    if (!find_shift(j, side, clip))
        return enf_fail_memory();
    find_only(j, side, clip);
    return ENF_OK;
}

/* Cuts a piece by one of a side's cells: what lies in the cell goes to `done`, what doesn't to `rest`. 0: out of memory. */
static int cut_piece(const Join *j, int which, const JoinCell *c, const Piece *piece, Clip *clip, PieceList *done, PieceList *rest) {
    const Side *side = &j->sides[which];
    const uint32_t rest_before = rest->count;
    uint32_t count = piece->count;
    if (!clip_room(clip, count + c->count + 2))
        return 0;
    memcpy(clip->a, piece->points, count * sizeof *clip->a);
    for (uint32_t k = 0; k < c->count; k++) {
        const CellPlane *plane = &side->planes[c->first + k];
        double d = plane->d - side->shift * vec_dot(plane->n, j->normal);
        uint32_t back = 0, front = 0;
        enf_polygon_split(clip->a, count, plane->n, d, side->eps, clip->b, &back, clip->c, &front);
        if (front >= 3 && back < 3) {
            /* It misses the cell after all: the cuts so far are undone. */
            while (rest->count > rest_before)
                enf_free(rest->items[--rest->count].points);
            return add_piece(rest, piece->points, piece->count, piece->cells[0], piece->cells[1]);
        }
        if (front < 3)
            continue; /* all of it is behind this plane */
        if (!add_piece(rest, clip->c, front, piece->cells[0], piece->cells[1]))
            return 0;
        count = back;
        double(*t)[3] = clip->a;
        clip->a = clip->b;
        clip->b = t;
    }
    if (!add_piece(done, clip->a, count, piece->cells[0], piece->cells[1]))
        return 0;
    done->items[done->count - 1].cells[which] = c->cell;
    return 1;
}

/* Cuts all pieces by one side's cells and labels them. */
static int split_pieces(Join *j, int which, Clip *clip) {
    Side *side = &j->sides[which];
    if (side->only != ENF_NONE) {
        for (uint32_t i = 0; i < j->pieces.count; i++)
            j->pieces.items[i].cells[which] = side->only;
        return 1;
    }
    PieceList done = {NULL, 0};
    int ok = 1;
    for (uint32_t i = 0; i < side->cell_count && ok; i++) {
        PieceList rest = {NULL, 0};
        for (uint32_t p = 0; p < j->pieces.count && ok; p++)
            ok = cut_piece(j, which, &side->cells[i], &j->pieces.items[p], clip, &done, &rest);
        free_pieces(&j->pieces);
        j->pieces = rest;
    }
    for (uint32_t p = 0; p < j->pieces.count && ok; p++) {
        Piece *piece = &j->pieces.items[p];
        double middle[3];
        enf_polygon_centroid(middle, piece->points, piece->count);
        ok = add_piece(&done, piece->points, piece->count, piece->cells[0], piece->cells[1]);
        if (ok)
            done.items[done.count - 1].cells[which] = nearest_cell(j, side, middle);
    }
    free_pieces(&j->pieces);
    j->pieces = done;
    return ok;
}

/* Whether two pieces of the same cells that share an edge are convex together: then *a becomes both. -1: no
 * memory. */
static int merge_two(const Join *j, Piece *a, Piece *b) {
    if (a->cells[0] != b->cells[0] || a->cells[1] != b->cells[1])
        return 0;
    for (uint32_t i = 0; i < a->count; i++)
        for (uint32_t k = 0; k < b->count; k++) {
            if (!vec_equal(a->points[i], b->points[(k + 1) % b->count]) || !vec_equal(a->points[(i + 1) % a->count], b->points[k]))
                continue;
            uint32_t n = 0, total = a->count + b->count - 2;
            double(*both)[3] = enf_alloc_array((uint64_t)total, sizeof *both);
            if (!both)
                return -1;
            for (uint32_t m = 1; m <= a->count; m++)
                vec_copy(both[n++], a->points[(i + m) % a->count]);
            for (uint32_t m = 2; m < b->count; m++)
                vec_copy(both[n++], b->points[(k + m) % b->count]);
            if (!enf_polygon_is_convex(both, n, j->normal, 1e-12 * j->radius)) {
                enf_free(both);
                return 0;
            }
            enf_free(a->points);
            a->points = both;
            a->count = n;
            return 1;
        }
    return 0;
}

static int held_elsewhere(const PieceList *list, const Piece *own, const double point[3]) {
    for (uint32_t p = 0; p < list->count; p++)
        for (uint32_t i = 0; i < list->items[p].count && &list->items[p] != own; i++)
            if (vec_equal(list->items[p].points[i], point))
                return 1;
    return 0;
}

/* After merging: corners that lie on a straight line now and that no other piece has. */
static void drop_straight_corners(const Join *j, const PieceList *list, Piece *piece) {
    for (uint32_t i = 0; i < piece->count && piece->count > 3;) {
        const double *a = piece->points[(i + piece->count - 1) % piece->count], *b = piece->points[i];
        double along[3], to[3], cross[3];
        vec_sub(along, piece->points[(i + 1) % piece->count], a);
        vec_sub(to, b, a);
        vec_cross(cross, along, to);
        if (vec_length(cross) <= 1e-12 * j->radius * vec_length(along) && !held_elsewhere(list, piece, b)) {
            memmove(&piece->points[i], &piece->points[i + 1], (piece->count - i - 1) * sizeof *piece->points);
            piece->count--;
        } else
            i++;
    }
}

static int merge_pieces(Join *j) {
    PieceList *list = &j->pieces;
    for (uint32_t a = 0; a < list->count; a++)
        for (uint32_t b = 0; b < list->count; b++) {
            int merged = a == b ? 0 : merge_two(j, &list->items[a], &list->items[b]);
            if (merged < 0)
                return 0;
            if (merged) {
                enf_free(list->items[b].points);
                memmove(&list->items[b], &list->items[b + 1], (list->count - b - 1) * sizeof *list->items);
                list->count--;
                drop_straight_corners(j, list, &list->items[a < b ? a : a - 1]);
                a = ENF_NONE; /* start over: ++ makes it 0 */
                break;
            }
        }
    return 1;
}

static EnfStatus check_sides(EnfScene *scene, const uint32_t kinds[2], const uint32_t sides[2]) {
    for (int k = 0; k < 2; k++) {
        uint32_t limit = kinds[k] == ENF_SIDE_ROOM ? scene->room_count : scene->cell_count;
        if (kinds[k] > ENF_SIDE_CELL)
            return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_join: side kind %u is unknown", kinds[k]);
        if (sides[k] >= limit)
            return enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_join: %s %u doesn't exist (%u)", kinds[k] == ENF_SIDE_ROOM ? "room" : "cell",
                            sides[k], limit);
    }
    if (kinds[0] == kinds[1] && sides[0] == sides[1])
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_join: joins %s %u with itself", kinds[0] == ENF_SIDE_ROOM ? "room" : "cell",
                        sides[0]);
    return ENF_OK;
}

/* The polygon about its middle; what isn't convex is commit's to judge, here its planar hull is taken. */
static EnfStatus take_polygon(Join *j, const double *polygon, uint64_t count, uint64_t stride) {
    double(*given)[3] = enf_alloc_array(count, sizeof *given);
    uint32_t *hull = ENF_NEW(uint32_t, count);
    j->polygon = enf_alloc_array(count, sizeof *j->polygon);
    if (!given || !hull || !j->polygon) {
        enf_free(given);
        enf_free(hull);
        return enf_fail_memory();
    }
    double box[6];
    int finite = 1;
    box_empty(box);
    for (uint64_t i = 0; i < count; i++) {
        memcpy(given[i], (const char *)polygon + i * (stride ? stride : 3 * sizeof(double)), sizeof given[i]);
        finite &= vec_finite(given[i]) && fabs(given[i][0]) < 1e60 && fabs(given[i][1]) < 1e60 && fabs(given[i][2]) < 1e60;
        box_add_point(box, given[i]);
    }
    EnfStatus status = ENF_OK;
    for (int k = 0; k < 3; k++)
        j->centre[k] = 0.5 * (box[k] + box[3 + k]);
    for (uint64_t i = 0; i < count && finite; i++) {
        vec_sub(given[i], given[i], j->centre);
        j->radius = fmax(j->radius, vec_length(given[i]));
    }
    if (!finite)
        status = enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_join: the polygon is not finite");
    else if (!((j->area = enf_polygon_normal(j->normal, given, (uint32_t)count)) > 1e-14 * j->radius * j->radius))
        status = enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_join: the polygon has no area");
    else if (enf_polygon_is_convex(given, (uint32_t)count, j->normal, 1e-12 * j->radius)) {
        for (; j->count < count; j->count++)
            vec_copy(j->polygon[j->count], given[j->count]);
    } else {
        uint32_t size = enf_planar_hull(given, (uint32_t)count, j->normal, 0.0, hull);
        for (; j->count < size; j->count++)
            vec_copy(j->polygon[j->count], given[hull[j->count]]);
        double n[3];
        j->area = enf_polygon_normal(n, j->polygon, j->count);
        if (size < 3)
            status = enf_fail_memory();
    }
    enf_free(given);
    enf_free(hull);
    return status;
}

/* Corners of the given polygon come back as they were given: the middle is subtracted and added only at cuts.
 */
static void restore(const Join *j, const double *polygon, uint64_t count, uint64_t stride, double point[3]) {
    for (uint64_t i = 0; i < count; i++) {
        double given[3], local[3];
        memcpy(given, (const char *)polygon + i * (stride ? stride : 3 * sizeof(double)), sizeof given);
        vec_sub(local, given, j->centre);
        if (vec_equal(local, point)) {
            vec_copy(point, given);
            return;
        }
    }
    vec_add(point, point, j->centre);
}

static EnfStatus join_sides(EnfScene *scene, uint32_t side_a_kind, uint32_t side_a, uint32_t side_b_kind, uint32_t side_b,
                            const double *polygon, uint64_t vertex_count, uint64_t vertex_stride, uint32_t opening, int shaped_only,
                            uint32_t *out_first_portal, uint32_t *out_portal_count) {
    if (!scene || !polygon)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_scene_join: NULL argument");
    if (vertex_count < 3 || vertex_count > 1000000)
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_scene_join: a polygon of %llu vertices", (unsigned long long)vertex_count);
    const uint32_t kinds[2] = {side_a_kind, side_b_kind}, sides[2] = {side_a, side_b};
    EnfStatus status = check_sides(scene, kinds, sides);
    if (status != ENF_OK)
        return status;
    if (!enf_room_shapes_update(scene))
        return enf_fail_memory();
    Join join, *j = &join;
    Clip clip = {NULL, NULL, NULL};
    memset(j, 0, sizeof *j);
    j->scene = scene;
    j->shaped_only = shaped_only;
    status = take_polygon(j, polygon, vertex_count, vertex_stride);
    for (int k = 0; k < 2 && status == ENF_OK; k++) {
        if (kinds[k] == ENF_SIDE_CELL)
            j->sides[k].only = sides[k];
        else
            status = prepare_room(j, &j->sides[k], sides[k], kinds[1 - k] == ENF_SIDE_CELL ? side_of_cell(j, sides[1 - k]) : 0, &clip);
    }
    int ok = 1;
    if (status == ENF_OK) {
        ok = add_piece(&j->pieces, j->polygon, j->count, ENF_NONE, ENF_NONE) && split_pieces(j, 0, &clip) && split_pieces(j, 1, &clip) &&
             merge_pieces(j);
        if (!ok)
            status = enf_fail_memory();
    }
    uint32_t first = scene->portal_count;
    for (uint32_t p = 0; p < j->pieces.count && status == ENF_OK; p++) {
        Piece *piece = &j->pieces.items[p];
        for (uint32_t i = 0; i < piece->count; i++)
            restore(j, polygon, vertex_count, vertex_stride, piece->points[i]);
        status = enf_scene_add_portal(scene, piece->cells[0], piece->cells[1], piece->points[0], piece->count, 0, opening, NULL);
    }
    for (int k = 0; k < 2 && status == ENF_OK; k++)
        if (j->sides[k].outside > 0.01 && !shaped_only) { /* outdoors it is a recess, or a wall measured otherwise */
            enf_problem_add(scene, ENF_SEVERITY_WARNING, ENF_ITEM_PORTAL, first, ENF_PROBLEM_JOIN_OUTSIDE, j->centre,
                            "%.0f %% of it lies outside of room %u (\"%.60s\"); given to the nearest cell", 100.0 * j->sides[k].outside,
                            sides[k], scene->rooms[sides[k]].name);
            enf_problems_keep(scene);
        }
    if (status == ENF_OK && out_first_portal)
        *out_first_portal = first;
    if (status == ENF_OK && out_portal_count)
        *out_portal_count = scene->portal_count - first;
    free_pieces(&j->pieces);
    free_clip(&clip);
    enf_free(j->polygon);
    for (int k = 0; k < 2; k++) {
        enf_free(j->sides[k].cells);
        enf_free(j->sides[k].planes);
    }
    return status;
}

EnfStatus enf_scene_join(EnfScene *scene, uint32_t side_a_kind, uint32_t side_a, uint32_t side_b_kind, uint32_t side_b,
                         const double *polygon, uint64_t vertex_count, uint64_t vertex_stride, uint32_t opening, uint32_t *out_first_portal,
                         uint32_t *out_portal_count) {
    return join_sides(scene, side_a_kind, side_a, side_b_kind, side_b, polygon, vertex_count, vertex_stride, opening, 0, out_first_portal,
                      out_portal_count);
}

EnfStatus enf_join_shaped(EnfScene *scene, uint32_t cell, uint32_t room, const double *polygon, uint64_t vertex_count, uint32_t opening,
                          uint32_t *out_first_portal, uint32_t *out_portal_count) {
    return join_sides(scene, ENF_SIDE_CELL, cell, ENF_SIDE_ROOM, room, polygon, vertex_count, 0, opening, 1, out_first_portal,
                      out_portal_count);
}
