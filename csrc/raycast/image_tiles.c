/* SPDX-License-Identifier: GPL-3.0-or-later
 * Pictures by rays, and by fewer: what four rays at the corners of a tile agree on, all rays between them do.
 *
 * A ray's way through openings holds for a convex set of directions: it is an intersection of half-spaces through the eye. So does what
 * it ends on: floor or ceiling of a convex cell, or a wall where it has no opening. So when the corners of a tile agree, the tile is
 * filled from the surface's plane.
 * Based on: Reshetov, Soupikov, Hurley, Multi-level ray tracing algorithm, 2005 (tiles); Maria, Horna, Aveneau 2014 (ways through cells). */
#include "raycast/ray_kernel.h"
#include "raycast/screen.h"

#include "base/threads.h"
#include "geometry/vec3.h"

#include <string.h>

enum {
    TILE = 16,
    HALF = 8,
    QUAD = 4,
    MOST_LATTICE = 16384 / TILE + 2,
    INNER = 5 /* points within a split tile */,
    SPLIT_TOGETHER = 3,
    COLUMNS = (MOST_LATTICE + 15) / 16 * 16
};
enum { BAND_TILES = 4 /* rows of tiles a task: each takes over the points at the bottom of the one above it */ };

/* What a ray found. */
typedef struct Way {
    uint32_t way[2], place; /* as in RayBlock */
    uint32_t surface, cell, portals;
    float z; /* metres: where it ended */
} Way;

/* A picture's rays about the first of a tile or of a row: the same for all of them. */
typedef struct TilePicture {
    const ImageTask *task;
    _Alignas(64) float pixel[3][TILE * TILE]; /* 4 x 4 pixels after each other */
    float quarter[3][HALF * HALF];
    float column[3][COLUMNS]; /* points between tiles; they lie on pixels' corners: all centres lie within */
    float inner[INNER][3];
} TilePicture;

typedef struct TilePainter {
    const TilePicture *picture;
    RayBlock rays;
    Way lattice[2][MOST_LATTICE];
    uint32_t split[MOST_LATTICE]; /* tiles of the row at hand */
    uint32_t frame_surface;       /* whose plane is at hand */
    InverseDepth plane;
    FrameFill fill;
} TilePainter;

/* The rays at `offset` from the one through x, y (in pixels), from start to finish. */
static void walk(TilePainter *p, double x, double y, const float *offset, uint32_t stride, uint32_t count, uint32_t ways) {
    const Screen *s = p->picture->task->screen;
    uint32_t cell = p->picture->task->cell;
    EyeRays rays = {{0, 0, 0}, stride, offset, cell == ENF_NONE ? LINK_NOTHING : p->picture->task->r->prisms.node_of_cell[cell], cell};
    for (int k = 0; k < 3; k++)
        rays.base[k] = (float)(s->base[k] + x * s->across[k] + y * s->down[k]);
    p->rays.count = count;
    p->rays.ways = ways;
    p->picture->task->kernel->eye_packets(p->picture->task->r, &p->rays, &rays);
}

static Way way_of(const RayBlock *b, uint32_t i) {
    return (Way){
        {b->way[0][i], b->way[1][i]}, b->place[i], b->link[i], b->cell[i], b->portals[i], b->o[2][i] + b->distance[i] * b->d[2][i]};
}

static void trace_lattice(TilePainter *p, uint32_t y, uint32_t columns, Way *out) {
    for (uint32_t first = 0; first < columns; first += RAY_BLOCK) {
        uint32_t count = columns - first < RAY_BLOCK ? columns - first : RAY_BLOCK;
        walk(p, -0.5, y - 0.5, p->picture->column[0] + first, COLUMNS, count, 1);
        for (uint32_t i = 0; i < count; i++)
            out[first + i] = way_of(&p->rays, i);
    }
}

/* Whether all of a wall between sections `first` and `last`, from height `low` to `high`, is this surface. */
static int is_all_wall(const PrismModel *m, uint32_t first, uint32_t last, float low, float high, uint32_t surface) {
    for (uint32_t i = first; i <= last; i++) {
        const PrismSection *s = &m->sections[i];
        for (uint32_t band = 0; band <= SECTION_HEIGHTS; band++)
            if (s->link[band] != (LINK_END | surface) && (band == 0 || s->height[band - 1] <= high) &&
                (band == SECTION_HEIGHTS || low <= s->height[band]))
                return 0;
    }
    return 1;
}

enum { MOST_SECTIONS = 8 }; /* that a tile is asked about: more are rare, and a tile of more is soon traced */

/* Whether all rays between these four go their way to their surface. */
static int agree(const TilePainter *p, const Way *const corners[4]) {
    const Way *a = corners[0];
    uint32_t first = a->place, last = a->place, apart = 0;
    float low = a->z, high = a->z;
    for (int i = 1; i < 4; i++) {
        const Way *b = corners[i];
        if (((a->way[0] ^ b->way[0]) | (a->way[1] ^ b->way[1]) | (a->surface ^ b->surface)) != 0)
            return 0;
        apart |= a->place ^ b->place;
        first = b->place < first ? b->place : first;
        last = b->place > last ? b->place : last;
        low = b->z < low ? b->z : low;
        high = b->z > high ? b->z : high;
    }
    if (!apart)
        return 1;
    for (int i = 0; i < 4; i++)
        if (corners[i]->place % PLACES >= PLACE_CAP)
            return 0;
    first /= PLACES;
    last /= PLACES;
    return a->surface < p->picture->task->r->face_count && last - first < MOST_SECTIONS &&
           is_all_wall(&p->picture->task->r->prisms, first, last, low, high, a->surface);
}

static void write_rows(TilePainter *p, uint32_t x0, uint32_t x1, uint32_t y0, uint32_t y1, const Way *way) {
    const ImageTask *task = p->picture->task;
    EnfRaycastImage *image = task->image;
    uint32_t surface = way->surface, count = x1 - x0;
    int nothing = surface == ENF_NONE;
    if (!nothing && surface != p->frame_surface) {
        SurfaceFrame frame;
        enf_surface_frame(task->r, surface, &frame);
        p->plane = enf_inverse_depth(task->screen, frame.normal, frame.point);
        p->frame_surface = surface;
        if (image->normal || image->uv)
            p->fill = enf_frame_fill(task, surface);
    }
    for (uint32_t y = y0; y < y1; y++) {
        size_t at = (size_t)y * image->width + x0;
        InverseDepth f = nothing ? (InverseDepth){0, 0, 0} : p->plane; /* 1 / 0: infinity */
        task->kernel->fill(image->depth ? image->depth + at : NULL, image->surface ? image->surface + at : NULL, count,
                           (float)(f.a * x0 + f.b * y + f.c), (float)f.a, surface);
        if (image->cell)
            task->kernel->fill(NULL, image->cell + at, count, 0, 0, way->cell);
        if (image->portals)
            memset(image->portals + at, (int)(way->portals < 255 ? way->portals : 255), count);
        if (image->normal || image->uv)
            enf_image_write_frame(task, x0, y, count,
                                  nothing ? &(FrameFill){{0, 0, 0}, {0, 0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}} : &p->fill);
    }
}

/* Pixels [x0, x0 + size) x [y0, y0 + size) by their own rays; size 16 or 8. What lies outside the picture isn't written. */
static void trace_pixels(TilePainter *p, uint32_t x0, uint32_t y0, uint32_t size) {
    const ImageTask *task = p->picture->task;
    EnfRaycastImage *image = task->image;
    const RayBlock *rays = &p->rays;
    const uint32_t quads = size / QUAD;
    walk(p, x0, y0, size == TILE ? p->picture->pixel[0] : p->picture->quarter[0], size * size, size * size, 0);
    int plain = !image->cell && !image->portals && !image->normal && !image->uv && image->depth && image->surface;
    if (plain && x0 + size <= image->width && y0 + size <= image->height) { /* the usual case without its questions */
        const size_t width = image->width;
        float *depth = image->depth + y0 * width + x0;
        uint32_t *surface = image->surface + y0 * width + x0;
        for (uint32_t quad = 0; quad < quads * quads; quad++)
            for (uint32_t row = 0; row < QUAD; row++) {
                size_t at = (QUAD * (quad / quads) + row) * width + QUAD * (quad % quads), from = 16 * quad + QUAD * row;
                memcpy(depth + at, rays->distance + from, QUAD * sizeof *depth);
                memcpy(surface + at, rays->link + from, QUAD * sizeof *surface);
            }
        return;
    }
    for (uint32_t quad = 0; quad < quads * quads; quad++) {
        uint32_t x = x0 + QUAD * (quad % quads), y = y0 + QUAD * (quad / quads);
        uint32_t wide = x >= image->width ? 0 : image->width - x < QUAD ? image->width - x : QUAD;
        for (uint32_t row = 0; row < QUAD && y + row < image->height && wide > 0; row++) {
            size_t at = (size_t)(y + row) * image->width + x;
            uint32_t from = 16 * quad + QUAD * row;
            if (wide == QUAD) {
                if (image->depth)
                    memcpy(image->depth + at, rays->distance + from, QUAD * sizeof(float));
                if (image->surface)
                    memcpy(image->surface + at, rays->link + from, QUAD * sizeof(uint32_t));
            } else
                for (uint32_t i = 0; i < wide; i++) {
                    if (image->depth)
                        image->depth[at + i] = rays->distance[from + i];
                    if (image->surface)
                        image->surface[at + i] = rays->link[from + i];
                }
            for (uint32_t i = 0; i < wide && image->cell; i++)
                image->cell[at + i] = rays->cell[from + i];
            for (uint32_t i = 0; i < wide && image->portals; i++)
                image->portals[at + i] = (uint8_t)(rays->portals[from + i] < 255 ? rays->portals[from + i] : 255);
            for (uint32_t i = 0; i < wide && (image->normal || image->uv); i++) {
                FrameFill fill = enf_frame_fill(task, rays->link[from + i]);
                enf_image_write_frame(task, x + i, y + row, 1, &fill);
            }
        }
    }
}

/* Tiles of a row whose corners differ: their quarters by five more rays a tile, then those that still differ by all of theirs. */
static void split_tiles(TilePainter *p, const uint32_t *tiles, uint32_t count, uint32_t y0) {
    float offset[3][16];
    Way inner[16];
    for (uint32_t k = 0; k < 3; k++)
        for (uint32_t i = 0; i < 16; i++) {
            uint32_t tile = i / INNER < count ? i / INNER : count - 1;
            offset[k][i] = p->picture->column[k][tiles[tile]] + p->picture->inner[i % INNER][k];
        }
    walk(p, -0.5, y0 - 0.5, offset[0], 16, 16, 1);
    for (uint32_t i = 0; i < INNER * count; i++)
        inner[i] = way_of(&p->rays, i);
    for (uint32_t tile = 0; tile < count; tile++) {
        const Way *top = &p->lattice[0][tiles[tile]], *bottom = &p->lattice[1][tiles[tile]], *in = inner + INNER * tile;
        const Way *const ways[9] = {top, in, top + 1, in + 1, in + 2, in + 3, bottom, in + 4, bottom + 1};
        for (uint32_t quarter = 0; quarter < 4; quarter++) {
            uint32_t a = quarter % 2 + 3 * (quarter / 2), x = tiles[tile] * TILE + HALF * (quarter % 2), y = y0 + HALF * (quarter / 2);
            if (agree(p, (const Way *const[4]){ways[a], ways[a + 1], ways[a + 3], ways[a + 4]}))
                write_rows(p, x, x + HALF, y, y + HALF, ways[a]);
            else
                trace_pixels(p, x, y, HALF);
        }
    }
}

static int tile_agrees(const TilePainter *p, uint32_t i) {
    return agree(p, (const Way *const[4]){&p->lattice[0][i], &p->lattice[0][i + 1], &p->lattice[1][i], &p->lattice[1][i + 1]});
}

/* Row y0 .. y0 + 15 from the points above and below it. */
static void paint_tiles(TilePainter *p, uint32_t y0, uint32_t count) {
    uint32_t split_count = 0;
    for (uint32_t i = 0, end; i < count; i = end) {
        for (end = i; end < count && tile_agrees(p, end); end++)
            ; /* neighbours share two points: those that agree go the same way, and are filled together */
        if (end > i)
            write_rows(p, i * TILE, end * TILE, y0, y0 + TILE, &p->lattice[0][i]);
        else
            p->split[split_count++] = end++;
    }
    for (uint32_t i = 0; i < split_count; i += SPLIT_TOGETHER)
        split_tiles(p, p->split + i, split_count - i < SPLIT_TOGETHER ? split_count - i : SPLIT_TOGETHER, y0);
}

static void paint_band(void *context, uint64_t band, uint32_t thread) {
    TilePainter painter, *p = &painter;
    const TilePicture *picture = context;
    const EnfRaycastImage *image = picture->task->image;
    uint32_t columns = (image->width + TILE - 1) / TILE, whole = image->method == ENF_IMAGE_TILES ? image->width / TILE : 0;
    uint32_t y = (uint32_t)band * BAND_TILES * TILE, end = y + BAND_TILES * TILE;
    (void)thread;
    p->picture = picture;
    p->frame_surface = ENF_NONE;
    p->rays.targets = 0;
    for (uint32_t i = 0; i < RAY_BLOCK; i++) {
        for (int k = 0; k < 3; k++)
            p->rays.o[k][i] = (float)p->picture->task->screen->eye[k];
        p->rays.limit[i] = INFINITY;
    }
    if (whole)
        trace_lattice(p, y, whole + 1, p->lattice[1]);
    for (; y < end && y < image->height; y += TILE) {
        uint32_t first = y + TILE <= image->height ? whole : 0;
        if (first) {
            memcpy(p->lattice[0], p->lattice[1], (whole + 1) * sizeof *p->lattice[0]);
            trace_lattice(p, y + TILE, whole + 1, p->lattice[1]);
            paint_tiles(p, y, whole);
        }
        for (uint32_t i = first; i < columns; i++)
            trace_pixels(p, i * TILE, y, TILE);
    }
}

EnfStatus enf_image_by_rays(const ImageTask *task) {
    static const uint32_t inner[INNER][2] = {{HALF, 0}, {0, HALF}, {HALF, HALF}, {TILE, HALF}, {HALF, TILE}};
    const double *across = task->screen->across, *down = task->screen->down;
    TilePicture picture = {.task = task};
    for (int k = 0; k < 3; k++) {
        for (uint32_t i = 0; i < TILE * TILE; i++) {
            uint32_t quad = i / 16, x = QUAD * (quad % QUAD) + i % QUAD, y = QUAD * (quad / QUAD) + i % 16 / QUAD;
            picture.pixel[k][i] = (float)(x * across[k] + y * down[k]);
        }
        for (uint32_t quad = 0; quad < 4; quad++)
            memcpy(picture.quarter[k] + 16 * quad, picture.pixel[k] + 16 * (quad % 2 + QUAD * (quad / 2)), 16 * sizeof(float));
        for (uint32_t i = 0; i <= task->image->width / TILE; i++)
            picture.column[k][i] = (float)(i * (double)TILE * across[k]);
        for (uint32_t i = 0; i < INNER; i++)
            picture.inner[i][k] = (float)(inner[i][0] * across[k] + inner[i][1] * down[k]);
    }
    enf_parallel_for((task->image->height + BAND_TILES * TILE - 1) / (BAND_TILES * TILE), task->image->threads, paint_band, &picture);
    return ENF_OK;
}
