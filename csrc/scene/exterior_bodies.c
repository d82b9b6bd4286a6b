/* SPDX-License-Identifier: GPL-3.0-or-later
 * What a building is made of, as convex bodies: the cells of its rooms, and the walls and slabs between them.
 *
 * Nobody draws walls for us. What is known: a point of a room isn't outdoors; and a point between two walls of rooms that
 * face each other, no farther apart than walls are thick, is in a wall. That thickness is measured where openings go
 * through (exterior.c). Where walls meet, the same rule between the bodies just found fills the joints: walls and
 * slabs first, then the edges where they meet, then the corners where edges meet. */
#include "base/memory.h"
#include "geometry/convex_solid.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"
#include "scene/exterior.h"

#include <stdlib.h>

/* Faces whose normals are opposite up to 2.5 degrees face each other. */
#define FACING (-0.999)
/* Walls, edges, corners. */
#define PASSES 3
/* Walls and joints a room, as many as an office of 1,800 rooms has several times over. Beyond, no more are looked for: the
 * outdoors are larger (safe direction), and scenes of rooms drawn into each other end in time. */
#define BODIES_PER_ROOM 40

void enf_bodies_free(EnfBodies *bodies) {
    enf_free(bodies->items);
    enf_free(bodies->faces);
    enf_free(bodies->points);
    enf_box_tree_free(&bodies->tree);
    memset(bodies, 0, sizeof *bodies);
}

void enf_cover_free(EnfCover *cover) {
    EnfPieces *both[2] = {&cover->now, &cover->next};
    for (int k = 0; k < 2; k++) {
        enf_free(both[k]->items);
        enf_free(both[k]->points);
    }
    enf_free(cover->a);
    enf_free(cover->b);
    enf_free(cover->c);
    memset(cover, 0, sizeof *cover);
}

static int begin_body(EnfBodies *b) {
    if (!ENF_RESERVE(b->items, (uint64_t)b->count + 1))
        return 0;
    EnfBody *body = &b->items[b->count++];
    body->face_first = b->face_count;
    body->face_count = 0;
    box_empty(body->box);
    return 1;
}

/* Of the body begun last. */
static int add_face(EnfBodies *b, const double n[3], double d, double grown, double (*corners)[3], uint32_t count) {
    if (!ENF_RESERVE(b->faces, (uint64_t)b->face_count + 1) || !ENF_RESERVE(b->points, (uint64_t)b->point_count + count))
        return 0;
    EnfBodyFace *face = &b->faces[b->face_count++];
    vec_copy(face->n, n);
    face->d = d;
    face->grown = grown;
    face->first = b->point_count;
    face->count = count;
    for (uint32_t i = 0; i < count; i++) {
        vec_copy(b->points[b->point_count++], corners[i]);
        box_add_point(b->items[b->count - 1].box, corners[i]);
    }
    b->items[b->count - 1].face_count++;
    return 1;
}

static int grow_tree(EnfBodies *b) {
    double(*boxes)[6] = enf_alloc_array(b->count, sizeof *boxes);
    if (!boxes)
        return 0;
    for (uint32_t i = 0; i < b->count; i++) {
        memcpy(boxes[i], b->items[i].box, sizeof boxes[i]);
        box_grow(boxes[i], 4.0 * b->fine);
    }
    enf_box_tree_free(&b->tree);
    int ok = enf_box_tree_build(&b->tree, (const double(*)[6])boxes, b->count);
    enf_free(boxes);
    return ok;
}

/* Cell c as it is. */
static int take_cell(const EnfScene *scene, EnfBodies *b, uint32_t c, double (**corners)[3]) {
    int ok = begin_body(b);
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1] && ok; f++) {
        uint32_t begin = scene->face_index_first[f], n = scene->face_index_first[f + 1] - begin;
        const EnfPlane *plane = &scene->face_planes[f];
        if (vec_length(plane->n) == 0.0)
            continue;
        ok = ENF_RESERVE(*corners, n);
        for (uint32_t i = 0; i < n && ok; i++)
            vec_sub((*corners)[i], scene->cell_vertices[scene->cell_vertex_first[c] + scene->face_indices[begin + i]], scene->origin);
        ok = ok && add_face(b, plane->n, plane->d, 0.0, *corners, n);
    }
    return ok;
}

/* Cell c below `top`, with its faces moved out: where two such walls meet their corner is filled, too. */
static int take_grown(const EnfScene *scene, EnfBodies *b, uint32_t c, const double *depths, double top, double (**corners)[3]) {
    uint32_t first = scene->cell_face_first[c], end = scene->cell_face_first[c + 1];
    double box[6], most = 0.0;
    EnfVertexPool pool = {NULL, 0};
    EnfSolid solid, back, front;
    for (int k = 0; k < 6; k++)
        box[k] = scene->cell_bounds[c][k] - scene->origin[k % 3];
    for (uint32_t f = first; f < end; f++)
        most = fmax(most, depths[f]);
    box_grow(box, fmax(ENF_MITRE * most, 4.0 * b->fine));
    int capped = box[5] > top;
    box[5] = fmin(box[5], top);
    if (box[5] - box[2] <= 8.0 * b->fine)
        return 1;
    int ok = enf_solid_box(&solid, &pool, box);
    for (uint32_t f = first; f < end && ok; f++) {
        const EnfPlane *plane = &scene->face_planes[f];
        if (vec_length(plane->n) == 0.0)
            continue;
        ok = enf_solid_cut(&solid, &pool, f - first, plane->n, plane->d + depths[f], 1e-3 * b->fine, &back, &front);
        enf_solid_free(&front);
        enf_solid_free(&solid);
        solid = back;
    }
    ok = ok && begin_body(b);
    for (uint32_t i = 0; i < solid.face_count && ok; i++) {
        const EnfSolidFace *face = &solid.faces[i];
        uint32_t f = face->plane == ENF_NONE ? ENF_NONE : first + face->plane / 2;
        EnfPlane plane;
        ok = ENF_RESERVE(*corners, face->count);
        for (uint32_t k = 0; k < face->count && ok; k++)
            vec_copy((*corners)[k], pool.points[solid.indices[face->first + k]]);
        if (!ok)
            break;
        if (f != ENF_NONE) {
            plane = scene->face_planes[f];
            plane.d += depths[f];
        } else if (enf_polygon_normal(plane.n, *corners, face->count) > 0.0) /* a corner cut off */
            plane.d = vec_dot(plane.n, (*corners)[0]);
        else
            continue;
        double grown = f == ENF_NONE ? most : depths[f];
        if (capped && f == ENF_NONE && plane.n[2] > -FACING && plane.d >= top - b->fine)
            grown = INFINITY; /* no wall: nothing is between it and what lies over it */
        ok = add_face(b, plane.n, plane.d, grown, *corners, face->count);
    }
    enf_solid_free(&solid);
    enf_free(pool.points);
    return ok;
}

/* Cell c with its walls, below the height at which its room may be outdoors too. */
static int take_solid(const EnfScene *scene, const EnfExteriorDef *def, uint32_t c, const double *depths, double (**corners)[3],
                      EnfBodies *b) {
    uint32_t room = scene->cell_rooms[c];
    double top = def->room_tops && room < def->room_count ? def->room_tops[room] - scene->origin[2] : INFINITY;
    int grown = scene->cell_bounds[c][5] - scene->origin[2] > top;
    for (uint32_t f = scene->cell_face_first[c]; f < scene->cell_face_first[c + 1]; f++)
        grown |= depths[f] > 0.0;
    return grown ? take_grown(scene, b, c, depths, top, corners) : take_cell(scene, b, c, corners);
}

/* Cells of rooms that have faces. An opening's own cell is left out: it lies in a wall, or is a recess of the facade. */
static int take_rooms(const EnfScene *scene, const EnfExteriorDef *def, const double *depths, EnfBodies *b) {
    double(*corners)[3] = NULL;
    int ok = 1;
    for (uint32_t c = 0; c < scene->cell_count && ok; c++) {
        uint32_t room = scene->cell_rooms[c];
        if (room != ENF_NONE && scene->rooms[room].kind != ENF_ROOM_EXTERIOR && scene->cell_face_first[c] < scene->cell_face_first[c + 1])
            ok = take_solid(scene, def, c, depths, &corners, b);
    }
    enf_free(corners);
    b->rooms = b->count;
    return ok;
}

/* ---- Between facing faces ---------------------------------------------------------------------------------------- */
typedef struct Scratch {
    double (*a)[3], (*b)[3], (*spare)[3];
} Scratch;

/* The part of face `f` that lies straight before face `g`, into scratch->a; 0 corners when there is none. -1: no memory. */
static int32_t facing_part(const EnfBodies *bodies, const EnfBodyFace *f, const EnfBodyFace *g, Scratch *s) {
    uint32_t count = f->count, none;
    if (!ENF_RESERVE(s->a, (uint64_t)f->count + g->count + 2) || !ENF_RESERVE(s->b, (uint64_t)f->count + g->count + 2) ||
        !ENF_RESERVE(s->spare, (uint64_t)f->count + g->count + 2))
        return -1;
    memcpy(s->a, bodies->points + f->first, count * sizeof *s->a);
    for (uint32_t i = 0; i < g->count; i++) {
        const double *p = bodies->points[g->first + i], *q = bodies->points[g->first + (i + 1) % g->count];
        double edge[3], outward[3];
        vec_sub(edge, q, p);
        vec_cross(outward, f->n, edge); /* g runs clockwise seen along f's normal */
        if (vec_normalize(outward) == 0.0)
            continue;
        enf_polygon_split(s->a, count, outward, vec_dot(outward, p), bodies->fine, s->b, &count, s->spare, &none);
        double(*t)[3] = s->a;
        s->a = s->b;
        s->b = t;
        if (count < 3)
            return 0;
    }
    double n[3], longest = 0.0, area = enf_polygon_normal(n, s->a, count);
    for (uint32_t i = 0; i < count; i++)
        longest = fmax(longest, vec_distance(s->a[i], s->a[(i + 1) % count]));
    return area > 4.0 * bodies->fine * longest ? (int32_t)count : 0;
}

/* How far the body's face in this plane, if it has one, was moved out. */
static double grown_of(const EnfBodies *b, uint32_t body, const double n[3], double d) {
    for (uint32_t f = b->items[body].face_first; f < b->items[body].face_first + b->items[body].face_count; f++)
        if (b->faces[f].grown > 0.0 && vec_dot(b->faces[f].n, n) > -FACING && fabs(b->faces[f].d - d) <= b->fine)
            return b->faces[f].grown;
    return 0.0;
}

/* The prism over the part of body one's face f that body two's face g lies before, up to g. The indices, because arrays move as
 * they grow. */
static int bridge(EnfBodies *b, uint32_t one, uint32_t two, uint32_t f_index, uint32_t g_index, Scratch *s) {
    const EnfBodyFace f = b->faces[f_index], g = b->faces[g_index];
    int32_t found = facing_part(b, &f, &g, s);
    if (found <= 0)
        return found == 0;
    uint32_t count = (uint32_t)found;
    double down[3], quad[4][3], rate = vec_dot(g.n, f.n);
    vec_scale(down, -1.0, f.n);
    for (uint32_t i = 0; i < count; i++) /* s->b: the same corners on g's plane */
        vec_mad(s->b[i], s->a[i], (g.d - vec_dot(g.n, s->a[i])) / rate, f.n);
    if (!begin_body(b))
        return 0;
    double up[3];
    vec_scale(up, -1.0, g.n);
    if (!add_face(b, up, -g.d, 0.0, s->b, count))
        return 0;
    for (uint32_t i = 0; i < count; i++)
        vec_copy(s->spare[count - 1 - i], s->a[i]);
    if (!add_face(b, down, -f.d, 0.0, s->spare, count))
        return 0;
    for (uint32_t i = 0; i < count; i++) {
        double n[3];
        vec_copy(quad[0], s->a[i]);
        vec_copy(quad[1], s->a[(i + 1) % count]);
        vec_copy(quad[2], s->b[(i + 1) % count]);
        vec_copy(quad[3], s->b[i]);
        if (enf_polygon_normal(n, quad, 4) == 0.0)
            continue;
        double d = fmax(vec_dot(n, quad[0]), vec_dot(n, quad[1]));
        if (!add_face(b, n, d, fmax(grown_of(b, one, n, d), grown_of(b, two, n, d)), quad, 4))
            return 0;
    }
    return 1;
}

/* Least and greatest distance of g's corners before the plane of f. */
static void distances(const EnfBodies *b, const EnfBodyFace *f, const EnfBodyFace *g, double *low, double *high) {
    *low = DBL_MAX;
    *high = -DBL_MAX;
    for (uint32_t i = 0; i < g->count; i++) {
        double distance = vec_dot(f->n, b->points[g->first + i]) - f->d;
        *low = fmin(*low, distance);
        *high = fmax(*high, distance);
    }
}

static int bridge_bodies(EnfBodies *b, uint32_t one, uint32_t two, double wall, double slab, Scratch *s) {
    const EnfBody x = b->items[one], y = b->items[two];
    for (uint32_t i = x.face_first; i < x.face_first + x.face_count; i++) {
        double limit = fabs(b->faces[i].n[2]) > 0.7071 ? slab : wall;
        for (uint32_t j = y.face_first; j < y.face_first + y.face_count; j++) {
            const EnfBodyFace *f = &b->faces[i], *g = &b->faces[j];
            double low, high;
            if (!(vec_dot(f->n, g->n) < FACING))
                continue;
            distances(b, f, g, &low, &high);
            /* Walls are as thick as between the rooms: what stands out already counts. */
            if (low < -b->fine || high + f->grown + g->grown > limit || high <= 4.0 * b->fine)
                continue;
            if (!bridge(b, one, two, i, j, s))
                return 0;
        }
    }
    return 1;
}

static int compare_boxes(const void *left, const void *right) {
    const EnfBody *a = left, *b = right;
    for (int k = 0; k < 6; k++)
        if (a->box[k] != b->box[k])
            return a->box[k] < b->box[k] ? -1 : 1;
    return a->face_first < b->face_first ? -1 : a->face_first > b->face_first;
}

/* A joint is found from each pair of walls that meet there: once is enough. */
static void drop_twins(EnfBodies *b, uint32_t first) {
    uint32_t kept = first;
    if (b->count > first)
        qsort(b->items + first, b->count - first, sizeof *b->items, compare_boxes);
    for (uint32_t i = first; i < b->count; i++) {
        int twin = 0;
        for (uint32_t j = kept; j-- > first && !twin && b->items[i].box[0] - b->items[j].box[0] <= b->fine && kept - j <= 8;) {
            twin = b->items[i].face_count == b->items[j].face_count;
            for (int k = 0; k < 6 && twin; k++)
                twin = fabs(b->items[i].box[k] - b->items[j].box[k]) <= b->fine;
        }
        /* Equal boxes of six faces are the same upright block; others may differ within theirs. */
        if (!twin || b->items[i].face_count != 6)
            b->items[kept++] = b->items[i];
    }
    b->count = kept;
}

/* Whether the polygon lies wholly before one face of the body. */
static int is_apart(const EnfBodies *b, const EnfBody *body, double (*points)[3], uint32_t count, double grow) {
    for (uint32_t f = body->face_first; f < body->face_first + body->face_count; f++) {
        double nearest = DBL_MAX;
        for (uint32_t i = 0; i < count; i++)
            nearest = fmin(nearest, vec_dot(b->faces[f].n, points[i]) - b->faces[f].d);
        if (nearest >= grow)
            return 1;
    }
    return 0;
}

/* A gap that sight enters from a room isn't a wall: hollow walls, ceilings that hang below their slab, floors that nobody drew. Takes
 * bodies that a portal to the hub leads into out, from `first` on. Without, what part of the box its seed is found in, rooms and all,
 * would count as outdoors. */
static int drop_hollow(const EnfScene *scene, uint32_t hub, double beyond, EnfBodies *b, uint32_t first) {
    unsigned char *hollow = ENF_NEW(unsigned char, b->count);
    double(*points)[3] = NULL, box[6];
    int ok = hollow != NULL;
    for (uint32_t p = 0; p < scene->portal_count && ok; p++) {
        if (!enf_leads_to(scene, p, hub))
            continue;
        uint32_t v = scene->portal_vertex_first[p], count = scene->portal_vertex_first[p + 1] - v, other;
        double out = scene->portal_cells[p][1] == hub ? 1.0 : -1.0;
        ok = ENF_RESERVE(points, count);
        /* Right behind the portal, and where the flood begins: portals are drawn some way before or behind a room's face. */
        for (int far = 0; far < 2 && ok; far++) {
            box_empty(box);
            for (uint32_t i = 0; i < count; i++) {
                vec_sub(points[i], scene->portal_vertices[v + i], scene->origin);
                vec_mad(points[i], points[i], out * (far ? beyond : 8.0 * b->fine), scene->portal_planes[p].n);
                box_add_point(box, points[i]);
            }
            EnfBoxWalk walk;
            enf_box_walk_begin(&walk, &b->tree, box);
            while ((other = enf_box_walk_next(&walk)) != ENF_NONE)
                hollow[other] |= other >= first && !is_apart(b, &b->items[other], points, count, -4.0 * b->fine);
        }
    }
    uint32_t kept = first;
    for (uint32_t i = first; i < b->count && ok; i++)
        if (!hollow[i])
            b->items[kept++] = b->items[i];
    ok = ok && (kept == b->count || (b->count = kept, grow_tree(b)));
    enf_free(points);
    enf_free(hollow);
    return ok;
}

/* Passages, those through outer walls too: who is in one isn't outdoors, where the wall round it is hollow either. Virtual ones stand in no
 * wall, and may reach out of the rooms that they join. After the walls: nothing is looked for between them. */
static int take_passages(const EnfScene *scene, EnfBodies *b) {
    double(*corners)[3] = NULL;
    int ok = 1;
    for (uint32_t c = 0; c < scene->cell_count && ok; c++) {
        uint32_t opening = scene->cell_openings[c];
        int passage = opening != ENF_NONE && scene->openings[opening].kind != ENF_OPENING_VIRTUAL && scene->cell_rooms[c] == ENF_NONE &&
                      scene->cell_face_first[c] < scene->cell_face_first[c + 1];
        ok = !passage || take_cell(scene, b, c, &corners);
    }
    enf_free(corners);
    return ok && grow_tree(b);
}

int enf_bodies_build(const EnfScene *scene, uint32_t hub, const EnfExteriorDef *def, double beyond, const double *depths, EnfBodies *b) {
    const double wall = def->wall_gap, slab = def->slab_gap;
    Scratch scratch = {NULL, NULL, NULL};
    memset(b, 0, sizeof *b);
    b->fine = 4.0 * scene->tolerance;
    int ok = take_rooms(scene, def, depths, b) && grow_tree(b);
    uint32_t first_new = 0;
    for (int pass = 0; pass < PASSES && ok && (wall > 0.0 || slab > 0.0); pass++) {
        uint32_t count = b->count;
        for (uint32_t one = 0; one < count && ok && b->count < BODIES_PER_ROOM * (uint64_t)(b->rooms + 8); one++) {
            double box[6];
            uint32_t two;
            EnfBoxWalk walk;
            memcpy(box, b->items[one].box, sizeof box);
            for (int k = 0; k < 3; k++) {
                box[k] -= k == 2 ? slab : wall;
                box[3 + k] += k == 2 ? slab : wall;
            }
            enf_box_walk_begin(&walk, &b->tree, box);
            while (ok && (two = enf_box_walk_next(&walk)) != ENF_NONE)
                if (two > one && two >= first_new && box_touches_box(box, b->items[two].box))
                    ok = bridge_bodies(b, one, two, wall, slab, &scratch);
        }
        first_new = count;
        drop_twins(b, count);
        ok = ok && grow_tree(b) && drop_hollow(scene, hub, beyond, b, count);
        if (b->count == count)
            break;
    }
    enf_free(scratch.a);
    enf_free(scratch.b);
    enf_free(scratch.spare);
    return ok && take_passages(scene, b);
}

/* ---- Covering ------------------------------------------------------------------------------------------------------ */
static int push_piece(EnfPieces *pieces, double (*points)[3], uint32_t count) {
    if (!ENF_RESERVE(pieces->items, (uint64_t)pieces->count + 1) || !ENF_RESERVE(pieces->points, (uint64_t)pieces->point_count + count))
        return 0;
    memcpy(pieces->points + pieces->point_count, points, count * sizeof *points);
    pieces->items[pieces->count++] = (EnfPieceSpan){pieces->point_count, count};
    pieces->point_count += count;
    return 1;
}

/* cover->next = cover->now less the body. */
static int subtract(const EnfBodies *b, const EnfBody *body, double grow, EnfCover *cover) {
    EnfPieces *from = &cover->now, *to = &cover->next;
    to->count = to->point_count = 0;
    for (uint32_t k = 0; k < from->count; k++) {
        double(*points)[3] = from->points + from->items[k].first;
        uint32_t count = from->items[k].count, room = count + body->face_count + 2;
        if (is_apart(b, body, points, count, grow)) {
            if (!push_piece(to, points, count))
                return 0;
            continue;
        }
        if (!ENF_RESERVE(cover->a, room) || !ENF_RESERVE(cover->b, room) || !ENF_RESERVE(cover->c, room))
            return 0;
        memcpy(cover->a, points, count * sizeof *points);
        for (uint32_t f = body->face_first; f < body->face_first + body->face_count && count >= 3; f++) {
            uint32_t back, front;
            enf_polygon_split(cover->a, count, b->faces[f].n, b->faces[f].d + grow, 1e-3 * b->fine, cover->b, &back, cover->c, &front);
            if (front >= 3 && !push_piece(to, cover->c, front))
                return 0;
            if (back == 0 && front == 0)
                continue; /* in the grown face: behind it as well as before it */
            count = back;
            double(*t)[3] = cover->a;
            cover->a = cover->b;
            cover->b = t;
        }
    }
    EnfPieces swap = *from;
    *from = *to;
    *to = swap;
    return 1;
}

int enf_bodies_uncovered(const EnfBodies *b, double (*points)[3], uint32_t count, uint32_t but, double grow, EnfCover *cover) {
    double box[6];
    uint32_t other;
    EnfBoxWalk walk;
    cover->now.count = cover->now.point_count = 0;
    if (!push_piece(&cover->now, points, count))
        return 0;
    box_empty(box);
    for (uint32_t i = 0; i < count; i++)
        box_add_point(box, points[i]);
    box_grow(box, grow);
    enf_box_walk_begin(&walk, &b->tree, box);
    while (cover->now.count && (other = enf_box_walk_next(&walk)) != ENF_NONE)
        if (other != but && box_touches_box(box, b->items[other].box) && !subtract(b, &b->items[other], grow, cover))
            return 0;
    return 1;
}
