/* SPDX-License-Identifier: GPL-3.0-or-later
 * Pictures by rays, and by fewer: what four rays at the corners of a tile agree on, all rays between them do.
 *
 * A ray's way (sections and bands it passes, surface it ends on) holds for a convex set of directions: the way is an intersection of
 * half-spaces through the eye. So when the corners of a tile took one way, the tile is filled from the surface's plane.
 * Based on: Reshetov, Soupikov, Hurley, Multi-level ray tracing algorithm, 2005 (tiles); Maria, Horna, Aveneau 2014 (ways through cells). */
#include "raycast/ray_kernel.h"
#include "raycast/screen.h"

#include "base/threads.h"
#include "geometry/vec3.h"

#include <string.h>

enum { TILE = 16, HALF = 8, QUAD = 4 };

/* The rays of one block and what they found. */
typedef struct TileRays {
    _Alignas(64) float o[3][RAY_BLOCK]; /* whole cache lines */
    float d[3][RAY_BLOCK], limit[RAY_BLOCK], distance[RAY_BLOCK];
    uint32_t link[RAY_BLOCK], cell[RAY_BLOCK], portals[RAY_BLOCK];
    uint64_t way[RAY_BLOCK];
} TileRays;

typedef struct Way {
    uint64_t way;
    uint32_t surface, cell, portals;
} Way;

enum { MOST_LATTICE = 16384 / TILE + 2 };
typedef struct TilePainter {
    const ImageTask *task;
    /* from the ray of a tile's or a quarter's first pixel to the others, 4 x 4 pixels after each other */
    _Alignas(64) float offset[3][TILE * TILE];
    float half_offset[3][HALF * HALF];
    TileRays rays;
    Way lattice[2][MOST_LATTICE];
    uint32_t frame_surface; /* whose plane is at hand */
    InverseDepth plane;
    FrameFill fill;
} TilePainter;

static void walk(TilePainter *p, uint32_t count, int ways) {
    TileRays *rays = &p->rays;
    const EnfRaycaster *r = p->task->r;
    const RayKernel *kernel = p->task->kernel;
    uint32_t cell = p->task->cell;
    kernel->fill(NULL, rays->link, count, 0, 0, cell == ENF_NONE ? LINK_NOTHING : r->prisms.node_of_cell[cell]);
    kernel->fill(NULL, rays->cell, count, 0, 0, cell);
    kernel->fill(NULL, rays->portals, count, 0, 0, 0);
    memset(rays->distance, 0, count * sizeof *rays->distance);
    if (ways)
        memset(rays->way, 0, count * sizeof *rays->way);
    RayBlock block = {count,       rays->o[0], rays->o[1], rays->o[2],     rays->d[0], rays->d[1],    rays->d[2],
                      rays->limit, NULL,       rays->link, rays->distance, rays->cell, rays->portals, ways ? rays->way : NULL};
    kernel->packets16(r, &block);
    kernel->finish(&block);
}

/* Points of a lattice; they lie on pixels' corners, so that all pixel centres of a tile lie between its four. */
static void set_lattice_ray(TilePainter *p, uint32_t i, double x, double y) {
    const Screen *s = p->task->screen;
    for (int k = 0; k < 3; k++)
        p->rays.d[k][i] = (float)(s->base[k] + (x - 0.5) * s->across[k] + (y - 0.5) * s->down[k]);
}

static Way way_of(const TilePainter *p, uint32_t i) {
    return (Way){p->rays.way[i], p->rays.link[i], p->rays.cell[i], p->rays.portals[i]};
}

static int same_way(const Way *a, const Way *b) {
    return a->way == b->way && a->surface == b->surface;
}

static void trace_lattice(TilePainter *p, uint32_t y, uint32_t columns, Way *out) {
    for (uint32_t first = 0; first < columns; first += RAY_BLOCK) {
        uint32_t count = columns - first < RAY_BLOCK ? columns - first : RAY_BLOCK, padded = (count + 15) / 16 * 16;
        for (uint32_t i = 0; i < padded; i++) /* whole packets: the last ones again */
            set_lattice_ray(p, i, (first + (i < count ? i : count - 1)) * (double)TILE, y);
        walk(p, padded, 1);
        for (uint32_t i = 0; i < count; i++)
            out[first + i] = way_of(p, i);
    }
}

static void write_rows(TilePainter *p, uint32_t x0, uint32_t x1, uint32_t y0, uint32_t y1, const Way *way) {
    const ImageTask *task = p->task;
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
    const ImageTask *task = p->task;
    const Screen *s = task->screen;
    EnfRaycastImage *image = task->image;
    TileRays *rays = &p->rays;
    uint32_t quads = size / QUAD, count = size * size;
    for (int k = 0; k < 3; k++) {
        float base = (float)(s->base[k] + x0 * s->across[k] + y0 * s->down[k]);
        task->kernel->add(rays->d[k], size == TILE ? p->offset[k] : p->half_offset[k], count, base);
    }
    walk(p, count, 0);
    int plain = !image->cell && !image->portals && !image->normal && !image->uv && image->depth && image->surface;
    if (plain && x0 + size <= image->width && y0 + size <= image->height) { /* the usual case without its questions */
        for (uint32_t y = 0; y < size; y++)
            for (uint32_t quad = 0; quad < quads; quad++) {
                size_t at = (size_t)(y0 + y) * image->width + x0 + QUAD * quad, from = 16 * (y / QUAD * quads + quad) + y % QUAD * QUAD;
                memcpy(image->depth + at, rays->distance + from, QUAD * sizeof(float));
                memcpy(image->surface + at, rays->link + from, QUAD * sizeof(uint32_t));
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

/* A tile whose corners differ: its quarters by nine rays, then those that still differ by all of theirs. */
static void split_tile(TilePainter *p, uint32_t x0, uint32_t y0) {
    Way ways[9];
    for (uint32_t i = 0; i < 16; i++) {
        uint32_t at = i < 9 ? i : 8;
        set_lattice_ray(p, i, x0 + HALF * (at % 3), y0 + HALF * (at / 3));
    }
    walk(p, 16, 1);
    for (uint32_t i = 0; i < 9; i++)
        ways[i] = way_of(p, i);
    for (uint32_t quarter = 0; quarter < 4; quarter++) {
        uint32_t a = quarter % 2 + 3 * (quarter / 2), x = x0 + HALF * (quarter % 2), y = y0 + HALF * (quarter / 2);
        if (same_way(&ways[a], &ways[a + 1]) && same_way(&ways[a], &ways[a + 3]) && same_way(&ways[a], &ways[a + 4]))
            write_rows(p, x, x + HALF, y, y + HALF, &ways[a]);
        else
            trace_pixels(p, x, y, HALF);
    }
}

static void paint_band(void *context, uint64_t band, uint32_t thread) {
    TilePainter painter, *p = &painter;
    const ImageTask *task = context;
    const EnfRaycastImage *image = task->image;
    uint32_t y0 = (uint32_t)band * TILE, columns = (image->width + TILE - 1) / TILE + 1, whole = image->width / TILE;
    (void)thread;
    p->task = task;
    p->frame_surface = ENF_NONE;
    for (uint32_t i = 0; i < RAY_BLOCK; i++) {
        uint32_t quad = i / 16, x = QUAD * (quad % QUAD) + i % QUAD, y = QUAD * (quad / QUAD) + i % 16 / QUAD;
        for (int k = 0; k < 3; k++) {
            p->rays.o[k][i] = (float)task->screen->eye[k];
            p->offset[k][i] = (float)(x * task->screen->across[k] + y * task->screen->down[k]);
        }
        p->rays.limit[i] = INFINITY;
    }
    for (int k = 0; k < 3; k++)
        for (uint32_t quad = 0; quad < 4; quad++)
            memcpy(p->half_offset[k] + 16 * quad, p->offset[k] + 16 * (quad % 2 + QUAD * (quad / 2)), 16 * sizeof(float));
    int tiles = image->method == ENF_IMAGE_TILES && y0 + TILE <= image->height;
    if (tiles) {
        trace_lattice(p, y0, columns, p->lattice[0]);
        trace_lattice(p, y0 + TILE, columns, p->lattice[1]);
    }
    for (uint32_t i = 0; i + 1 < columns; i++) {
        const Way *top = &p->lattice[0][i];
        if (!tiles || i >= whole) {
            trace_pixels(p, i * TILE, y0, TILE);
            continue;
        }
        uint32_t end = i; /* neighbours that go the same way are filled together */
        while (end < whole && same_way(top, &p->lattice[0][end]) && same_way(top, &p->lattice[1][end]) &&
               same_way(top, &p->lattice[0][end + 1]) && same_way(top, &p->lattice[1][end + 1]))
            end++;
        if (end == i) {
            split_tile(p, i * TILE, y0);
            continue;
        }
        write_rows(p, i * TILE, end * TILE, y0, y0 + TILE, top);
        i = end - 1;
    }
}

EnfStatus enf_image_by_rays(const ImageTask *task) {
    enf_parallel_for((task->image->height + TILE - 1) / TILE, task->image->threads, paint_band, (void *)task);
    return ENF_OK;
}
