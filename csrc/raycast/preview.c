/* SPDX-License-Identifier: GPL-3.0-or-later
 * Pictures by rays: what a pixel shows, the light there, what mirrors and glass add, how open the place is.
 *
 * A ray asks the triangles for the nearest one and walks through the cells as far as that: the walk gives room, openings and the lights to
 * ask; every further ray starts in the cell where the last one ended. Pixels depend on nothing but their place, so that rows, tiles and
 * threads in any order give the same bits. */
#include "raycast/bounce.h"
#include "raycast/camera_rays.h"
#include "raycast/first_hit.h"
#include "raycast/light.h"
#include "raycast/ray_model.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "geometry/vec3.h"

enum {
    TILE = TREE_RAYS,
    MOST_AMBIENT = 64,
    MOST_RAYS = 64 /* of one pixel's mirrors and glass: two panes opposite each other would double for ever */
};

static const double pi = 3.14159265358979323846;
typedef struct Counts {
    uint64_t rays, bounces, ambient, edges;
    LightCounts light;
    uint64_t apart[4]; /* threads count in cache lines of their own */
} Counts;

typedef double Hemisphere[16][MOST_AMBIENT][4]; /* by slot of a pixel: across, across, up, share of the reach */

typedef struct Renderer {
    EnfPreview *image;
    CameraRays camera;
    EnfDirectLight direct;
    uint32_t *light_cells;
    uint32_t eye_cell; /* ENF_NONE: not one for all pixels */
    uint32_t row_first, row_end, tiles_x;
    Counts *counts; /* one a thread */
    Hemisphere hemisphere;
} Renderer;

EnfPreview enf_default_preview(void) {
    EnfPreview p = {.struct_size = sizeof p,
                    .panorama = enf_default_panorama(),
                    .light_samples = 4,
                    .max_bounces = 4,
                    .ambient_samples = 6,
                    .ambient_reach = 1.5,
                    .edge_samples = 8,
                    .sky = {0.9f, 0.93f, 1.0f},
                    .ground = {0.55f, 0.52f, 0.48f},
                    .background = {{0.93f, 0.95f, 0.97f}, {0.62f, 0.74f, 0.88f}}};
    return p;
}

static void from_all_around(const EnfPreview *p, const double normal[3], const float albedo[3], double out[3]) {
    double up = 0.5 + 0.5 * normal[2];
    for (int k = 0; k < 3; k++)
        out[k] = albedo[k] * (p->ground[k] + up * (p->sky[k] - p->ground[k]));
}

static void add_background(const EnfPreview *p, const double direction[3], const double weight[3], double out[3]) {
    double up = direction[2] > 0 ? pow(direction[2], 0.6) : 0;
    for (int k = 0; k < 3; k++)
        out[k] += weight[k] * (p->background[0][k] + up * (p->background[1][k] - p->background[0][k]));
}

/* A ray that mirrors and glass may have turned. */
typedef struct Bounce {
    SightRay sight;
    double weight[3];
    uint32_t bounces, seed;
} Bounce;

typedef struct Light {
    double direct[3], surroundings[3];
    uint32_t lit;
    Seen first;
} Light;

static void push(Bounce *stack, int *height, const Bounce *from, const Seen *at, const double direction[3], double share,
                 const float tint[3], uint32_t bounces) {
    Bounce *b = &stack[*height];
    double along = 0, off[3];
    for (int k = 0; k < 3; k++) {
        b->weight[k] = from->weight[k] * share * tint[k];
        along = fmax(along, b->weight[k]);
    }
    if (along < 1e-3 || *height + 1 >= 8) /* a thousandth is below a step of the picture */
        return;
    double side = vec_dot(direction, at->plane) > 0 ? 1 : -1;
    vec_scale(off, side * clearance, at->plane);
    b->sight = (SightRay){.ray = {.farthest = INFINITY}, .cell = at->cell, .known = at->cell != ENF_NONE};
    vec_add(b->sight.ray.origin, at->position, off);
    vec_copy(b->sight.ray.direction, direction);
    b->bounces = bounces;
    b->seed = from->seed * 3 + 1;
    (*height)++;
}

static void shade_diffuse(const Renderer *r, const Bounce *ray, const Seen *seen, int first, Light *out, Counts *counts) {
    const EnfPreview *p = r->image;
    double around[3];
    float irradiance[3] = {0, 0, 0};
    uint32_t lit = 0;
    if (p->light_count) {
        EnfLitPoint point = {.cell = seen->cell, .seed = ray->seed};
        vec_copy(point.position, seen->position);
        vec_copy(point.normal, seen->normal);
        lit = enf_light_at(&r->direct, r->light_cells, &point, seen->walk_from, irradiance, &counts->light);
    }
    from_all_around(p, seen->normal, seen->material.colour, around);
    for (int k = 0; k < 3; k++) {
        out->direct[k] += ray->weight[k] * (seen->material.emission[k] + seen->material.colour[k] * irradiance[k] / pi);
        /* behind the first surface nobody measures how open it is: half, as in an ordinary room */
        if (first)
            out->surroundings[k] += ray->weight[k] * around[k];
        else
            out->direct[k] += ray->weight[k] * 0.75 * around[k];
    }
    if (first)
        out->lit = lit;
}

/* Which way glass is entered is told by its faces as wound; how much it bends, by how it is shaded, as smooth glass has it: the plane
 * itself where a bent ray would end on the wrong side of it. Gives the share that is thrown back. */
static double through_glass(const double direction[3], const Seen *seen, double reflected[3], double refracted[3]) {
    double wound[3], side = vec_dot(seen->plane, direction) > 0 ? 1 : -1;
    vec_scale(wound, -side, seen->normal);
    double share = enf_fresnel(direction, wound, seen->material.ior, reflected, refracted);
    if (!(side * vec_dot(seen->plane, reflected) < 0) || (share < 1 && !(side * vec_dot(seen->plane, refracted) > 0)))
        share = enf_fresnel(direction, seen->plane, seen->material.ior, reflected, refracted);
    return share;
}

/* What the ray that met `seen` brings: light, or rays to go on with. spent: rays of the pixel so far, this one being the last. */
static void meet(const Renderer *r, const Bounce *ray, const Seen *seen, int spent, Bounce *stack, int *height, Light *out,
                 Counts *counts) {
    const double *direction = ray->sight.ray.direction;
    const float *colour = seen->material.colour;
    uint32_t left = ray->bounces > 0 ? ray->bounces - 1 : 0;
    double turned[3], bent[3], share = 0;
    if (seen->distance == INFINITY) {
        add_background(r->image, direction, ray->weight, out->direct);
    } else if (seen->material.kind == ENF_MATERIAL_MIRROR && ray->bounces > 0) {
        enf_reflect(direction, seen->normal, turned);
        push(stack, height, ray, seen, turned, 1, colour, left);
    } else if (seen->material.kind == ENF_MATERIAL_GLASS) {
        vec_copy(bent, direction);
        if (ray->bounces > 0) {
            share = through_glass(direction, seen, turned, bent);
            if (share == 1 || spent <= 4) /* what a second pane throws back is seen; what a tenth does isn't */
                push(stack, height, ray, seen, turned, share, colour, left);
        }
        if (share < 1)
            push(stack, height, ray, seen, bent, 1 - share, colour, left);
    } else {
        shade_diffuse(r, ray, seen, spent == 1, out, counts);
    }
}

/* first: what the ray meets. */
static void trace(const Renderer *r, const Bounce *start, const Seen *first, Light *out, Counts *counts) {
    Bounce stack[8];
    int height = 0, spent = 1;
    memset(out, 0, sizeof *out);
    out->first = *first;
    meet(r, start, first, spent, stack, &height, out, counts);
    while (height > 0 && spent++ < MOST_RAYS) {
        Bounce ray = stack[--height];
        Seen seen;
        enf_first_hits(r->image, &ray.sight, 1, 0, &seen);
        counts->bounces++;
        meet(r, &ray, &seen, spent, stack, &height, out, counts);
    }
}

/* Rays over the hemisphere, more towards the normal, each with a reach of its own: near things shade more. The 4 x 4 pixels of a block
 * share one even set of directions, the same for every block, which enf_preview_smooth puts together again: no grain is left to see. */
static void scatter(Hemisphere *rays, uint32_t samples) {
    for (uint32_t slot = 0; slot < 16; slot++)
        for (uint32_t i = 0; i < samples; i++) {
            uint32_t index = i * 16 + slot;
            double u = enf_light_unit(0, index, 0), v = enf_light_unit(0, index, 1), radius = sqrt(u);
            (*rays)[slot][i][0] = radius * cos(2 * pi * v);
            (*rays)[slot][i][1] = radius * sin(2 * pi * v);
            (*rays)[slot][i][2] = sqrt(1 - u);
            (*rays)[slot][i][3] = enf_light_unit(1, index * 7 + 3, 0);
        }
}

/* The short rays of neighbours in a row, asked together: ray i of the k-th pixel is number TREE_RAYS i + k, so that those asked side by side
 * run side by side. */
typedef struct Around {
    float origin[3][TREE_RAYS * MOST_AMBIENT], direction[3][TREE_RAYS * MOST_AMBIENT], reach[TREE_RAYS * MOST_AMBIENT];
    uint8_t blocked[TREE_RAYS * MOST_AMBIENT];
} Around;

static void look_around(const Renderer *r, const Seen *seen, uint32_t x, uint32_t y, Around *around, uint32_t k) {
    const EnfPreview *p = r->image;
    double tangent[3], other[3], from[3], helper[3] = {0, 0, 0};
    uint32_t slot = (x & 3) | ((y & 3) << 2);
    helper[fabs(seen->normal[0]) < 0.6 ? 0 : 1] = 1;
    vec_cross(tangent, seen->normal, helper);
    vec_normalize(tangent);
    vec_cross(other, seen->normal, tangent);
    vec_mad(from, seen->position, clearance, seen->normal);
    if (p->triangles)
        vec_sub(from, from, p->triangles->origin);
    for (uint32_t i = 0; i < p->ambient_samples; i++) {
        const double *ray = r->hemisphere[slot][i];
        uint32_t at = TREE_RAYS * i + k;
        double d[3];
        vec_scale(d, ray[2], seen->normal);
        vec_mad(d, d, ray[0], tangent);
        vec_mad(d, d, ray[1], other);
        around->reach[at] = (float)(p->ambient_reach * ray[3]);
        around->blocked[at] = 0;
        for (int c = 0; c < 3; c++) {
            around->origin[c][at] = (float)from[c];
            around->direction[c][at] = (float)d[c];
        }
        if (!p->triangles && seen->cell != ENF_NONE) {
            EnfRay walked = {
                {seen->walk_from[0], seen->walk_from[1], seen->walk_from[2]}, {d[0], d[1], d[2]}, around->reach[at], seen->cell, 0};
            EnfRayHit hit;
            around->blocked[at] = enf_raycast_rays(p->raycaster, &walked, 1, &hit) == ENF_OK && hit.surface != ENF_NONE;
        }
    }
}

static double openness(const EnfPreview *p, const Around *around, uint32_t k) {
    uint32_t open = 0;
    for (uint32_t i = 0; i < p->ambient_samples; i++)
        open += !around->blocked[TREE_RAYS * i + k];
    return p->ambient_samples ? (double)open / p->ambient_samples : 1;
}

/* Rays from the camera. */
typedef struct Starts {
    uint32_t count;
    Bounce bounce[TREE_RAYS];
    SightRay sight[TREE_RAYS];
    double depth[TREE_RAYS]; /* for each metre along the ray */
} Starts;

/* The ray through a place of the picture joins the others, if the place shows anything. */
static int start(const Renderer *r, double x, double y, uint32_t seed, Starts *starts) {
    CameraRay ray;
    if (!enf_camera_ray(&r->camera, x, y, &ray))
        return 0;
    SightRay *sight = &starts->sight[starts->count];
    *sight = (SightRay){.ray = {.nearest = ray.nearest, .farthest = ray.farthest}, .cell = r->eye_cell, .known = 1};
    vec_copy(sight->ray.origin, ray.origin);
    vec_copy(sight->ray.direction, ray.direction);
    starts->bounce[starts->count] = (Bounce){*sight, {1, 1, 1}, r->image->max_bounces, seed};
    starts->depth[starts->count++] = ray.depth;
    return 1;
}

static void put3(float *layer, size_t at, const double v[3]) {
    for (int k = 0; layer && k < 3; k++)
        layer[3 * at + k] = (float)v[k];
}

static void write_pixel(const Renderer *r, uint32_t x, uint32_t y, const Light *light, double depth, double open) {
    const EnfPreview *p = r->image;
    size_t at = (size_t)y * p->width + x;
    const Seen *seen = &light->first;
    int something = seen->distance < INFINITY;
    if (p->depth)
        p->depth[at] = something ? (float)(seen->distance * depth) : INFINITY;
    if (p->object)
        p->object[at] = seen->object;
    if (p->cell)
        p->cell[at] = seen->cell;
    if (p->openings)
        p->openings[at] = (uint8_t)(seen->openings < 255 ? seen->openings : 255);
    put3(p->normal, at, something ? seen->normal : (const double[3]){0, 0, 0});
    for (int k = 0; p->albedo && k < 3; k++)
        p->albedo[3 * at + k] = something ? seen->material.colour[k] : 0;
    put3(p->direct, at, light->direct);
    put3(p->surroundings, at, light->surroundings);
    if (p->open)
        p->open[at] = (float)open;
    if (p->lit)
        p->lit[at] = (uint16_t)(light->lit < 65535 ? light->lit : 65535);
    for (int k = 0; p->coverage && k < 4; k++) {
        p->coverage[8 * at + 2 * k] = k == 0 && something ? (float)seen->object : -1;
        p->coverage[8 * at + 2 * k + 1] = k == 0 && something ? 1 : 0;
    }
}

/* Neighbours in one row, at most TREE_RAYS. */
static void pixels(const Renderer *r, uint32_t x0, uint32_t x1, uint32_t y, Counts *counts) {
    const EnfPreview *p = r->image;
    Starts starts;
    Seen seen[TREE_RAYS];
    Light light[TREE_RAYS];
    Around around;
    int shown[TREE_RAYS], shaded[TREE_RAYS] = {0};
    memset(&starts, 0, sizeof starts);
    memset(around.blocked, 1, (size_t)TREE_RAYS * p->ambient_samples);
    for (uint32_t x = x0; x < x1; x++)
        shown[x - x0] = start(r, x + 0.5, y + 0.5, y * p->width + x, &starts);
    enf_first_hits(p, starts.sight, starts.count, p->openings != NULL, seen);
    counts->rays += starts.count;
    for (uint32_t x = x0, k = 0; x < x1; x++) {
        if (!shown[x - x0])
            continue;
        trace(r, &starts.bounce[k], &seen[k], &light[k], counts);
        shaded[k] = p->open && seen[k].distance < INFINITY && seen[k].material.kind == ENF_MATERIAL_DIFFUSE;
        counts->ambient += shaded[k] ? p->ambient_samples : 0;
        if (shaded[k])
            look_around(r, &seen[k], x, y, &around, k);
        k++;
    }
    if (p->triangles) {
        TreeRays rays = {TREE_RAYS * p->ambient_samples,
                         {around.origin[0], around.origin[1], around.origin[2]},
                         {around.direction[0], around.direction[1], around.direction[2]},
                         around.reach,
                         around.blocked};
        enf_tree_blocked_rays(p->triangles, &rays);
    }
    for (uint32_t x = x0, k = 0; x < x1; x++) {
        const Light nothing = {.first = {.distance = INFINITY, .object = ENF_NONE, .cell = ENF_NONE}};
        if (shown[x - x0]) {
            write_pixel(r, x, y, &light[k], starts.depth[k], shaded[k] ? openness(p, &around, k) : 1);
            k++;
        } else {
            write_pixel(r, x, y, &nothing, 1, 1);
        }
    }
}

static void one_tile(void *context, uint64_t tile, uint32_t thread) {
    const Renderer *r = context;
    uint32_t x0 = (uint32_t)(tile % r->tiles_x) * TILE, y0 = r->row_first + (uint32_t)(tile / r->tiles_x) * TILE;
    uint32_t x1 = x0 + TILE < r->image->width ? x0 + TILE : r->image->width;
    for (uint32_t y = y0; y < y0 + TILE && y < r->row_end; y++)
        pixels(r, x0, x1, y, &r->counts[thread]);
}

/* ---- Edges ------------------------------------------------------------------------------------------------------ */
/* Whether two neighbours show different things: another object, a surface turned by more than 25 degrees, or a step in depth that no slope
 * explains. */
static int differs(const EnfPreview *p, size_t a, size_t b) {
    if (p->object[a] != p->object[b])
        return 1;
    const float *na = p->normal + 3 * a, *nb = p->normal + 3 * b;
    float along = na[0] * nb[0] + na[1] * nb[1] + na[2] * nb[2], da = p->depth[a], db = p->depth[b];
    if (!isfinite(da) || !isfinite(db))
        return isfinite(da) != isfinite(db);
    return along < 0.9f || fabsf(da - db) > 0.1f * fminf(da, db);
}

static int on_edge(const EnfPreview *p, uint32_t x, uint32_t y) {
    size_t at = (size_t)y * p->width + x;
    return (x > 0 && differs(p, at, at - 1)) || (x + 1 < p->width && differs(p, at, at + 1)) || (y > 0 && differs(p, at, at - p->width)) ||
           (y + 1 < p->height && differs(p, at, at + p->width));
}

static void cover(float *coverage, const uint32_t *objects, uint32_t count) {
    uint32_t numbers[65], times[65], kinds = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t k = 0;
        while (k < kinds && numbers[k] != objects[i])
            k++;
        if (k == kinds) {
            numbers[kinds] = objects[i];
            times[kinds++] = 0;
        }
        times[k]++;
    }
    for (uint32_t slot = 0; slot < 4; slot++) {
        uint32_t best = ENF_NONE;
        for (uint32_t k = 0; k < kinds; k++)
            if (times[k] && numbers[k] != ENF_NONE && (best == ENF_NONE || times[k] > times[best]))
                best = k;
        coverage[2 * slot] = best == ENF_NONE ? -1 : (float)numbers[best];
        coverage[2 * slot + 1] = best == ENF_NONE ? 0 : (float)times[best] / (float)count;
        if (best != ENF_NONE)
            times[best] = 0;
    }
}

static void edge_pixel(const Renderer *r, uint32_t x, uint32_t y, Counts *counts) {
    EnfPreview *p = r->image;
    size_t at = (size_t)y * p->width + x;
    uint32_t objects[65], count = 0;
    double direct[3] = {0, 0, 0}, around[3] = {0, 0, 0};
    counts->edges++;
    objects[count++] = p->object[at];
    for (int k = 0; k < 3; k++) {
        direct[k] = p->direct ? p->direct[3 * at + k] : 0;
        around[k] = p->surroundings ? p->surroundings[3 * at + k] : 0;
    }
    for (uint32_t done = 0; done < p->edge_samples; done += TREE_RAYS) {
        Starts starts;
        Seen seen[TREE_RAYS];
        memset(&starts, 0, sizeof starts);
        for (uint32_t i = done; i < done + TREE_RAYS && i < p->edge_samples; i++)
            start(r, x + enf_light_unit(1, i, 0), y + enf_light_unit(2, i, 1), (y * p->width + x) * 67 + i, &starts);
        enf_first_hits(p, starts.sight, starts.count, 0, seen);
        counts->rays += starts.count;
        for (uint32_t k = 0; k < starts.count; k++) {
            Light light;
            trace(r, &starts.bounce[k], &seen[k], &light, counts);
            vec_add(direct, direct, light.direct);
            vec_add(around, around, light.surroundings);
            objects[count++] = seen[k].object;
        }
    }
    vec_scale(direct, 1.0 / count, direct);
    vec_scale(around, 1.0 / count, around);
    put3(p->direct, at, direct);
    put3(p->surroundings, at, around);
    if (p->coverage)
        cover(p->coverage + 8 * at, objects, count);
}

static void edge_tile(void *context, uint64_t tile, uint32_t thread) {
    const Renderer *r = context;
    uint32_t x0 = (uint32_t)(tile % r->tiles_x) * TILE, y0 = r->row_first + (uint32_t)(tile / r->tiles_x) * TILE;
    for (uint32_t y = y0; y < y0 + TILE && y < r->row_end; y++)
        for (uint32_t x = x0; x < x0 + TILE && x < r->image->width; x++)
            if (on_edge(r->image, x, y))
                edge_pixel(r, x, y, &r->counts[thread]);
}

/* ---- Calls ------------------------------------------------------------------------------------------------------ */
/* light_samples: of a light with a size, for each ray. */
static EnfStatus run(EnfPreview *p, const EnfCamera *camera, uint32_t light_samples, void (*tile)(void *, uint64_t, uint32_t)) {
    static const double origin[3] = {0, 0, 0};
    if (!p || !camera || p->struct_size != sizeof *p)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_preview: NULL argument or bad struct_size");
    if (!p->raycaster && !p->triangles)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_preview: neither cells nor triangles");
    if (p->row_first > p->height || p->row_count > p->height - p->row_first)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_preview: rows %u and %u more of %u", p->row_first, p->row_count, p->height);
    if (p->max_bounces > 16 || p->ambient_samples > MOST_AMBIENT || p->edge_samples < 1 || p->edge_samples > 64 || !(p->ambient_reach > 0))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT,
                        "enf_preview: bounces 0 .. 16, ambient samples 0 .. 64 with a reach above 0, edge samples 1 .. 64");
    uint32_t threads = p->threads ? p->threads : enf_processor_count(), found = 0;
    Renderer r = {.image = p, .eye_cell = ENF_NONE};
    EnfStatus status = enf_camera_rays(camera, &p->panorama, origin, p->width, p->height, &r.camera);
    if (status != ENF_OK)
        return status;
    r.direct = enf_default_direct_light();
    r.direct.raycaster = p->raycaster;
    r.direct.triangles = p->triangles;
    r.direct.lights = p->lights;
    r.direct.light_count = p->light_count;
    r.direct.light_sets = p->light_sets;
    r.direct.samples = light_samples;
    status = enf_direct_light_check(&r.direct);
    if (status != ENF_OK)
        return status;
    if (p->raycaster && camera->type != ENF_CAMERA_ORTHO) {
        status = enf_scene_locate(p->raycaster->scene, r.camera.eye, &r.eye_cell, 1, &found);
        if (status != ENF_OK)
            return status;
    }
    r.row_first = p->row_first;
    r.row_end = p->row_count ? p->row_first + p->row_count : p->height;
    r.tiles_x = (p->width + TILE - 1) / TILE;
    scatter(&r.hemisphere, p->ambient_samples);
    r.light_cells = enf_light_cells(&r.direct);
    r.counts = ENF_NEW(Counts, threads);
    if (r.light_cells && r.counts)
        enf_parallel_for((uint64_t)r.tiles_x * ((r.row_end - r.row_first + TILE - 1) / TILE), threads, tile, &r);
    else
        status = enf_fail_memory();
    for (uint32_t t = 0; r.counts && t < threads; t++) {
        p->rays += r.counts[t].rays;
        p->bounce_rays += r.counts[t].bounces;
        p->ambient_rays += r.counts[t].ambient;
        p->shadow_rays += r.counts[t].light.shadow_rays;
        p->lights_asked += r.counts[t].light.asked;
        p->edge_pixels += r.counts[t].edges;
    }
    enf_free(r.light_cells);
    enf_free(r.counts);
    return status;
}

EnfStatus enf_preview(EnfPreview *preview, const EnfCamera *camera) {
    return run(preview, camera, preview ? preview->light_samples : 0, one_tile);
}

EnfStatus enf_preview_edges(EnfPreview *preview, const EnfCamera *camera) {
    if (preview && (!preview->object || !preview->depth || !preview->normal))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_preview_edges: the layers object, depth and normal are needed");
    /* an edge pixel's many rays share the light's points among them */
    return run(preview, camera, preview && preview->light_samples > 2 ? 2 : preview ? preview->light_samples : 0, edge_tile);
}
