/* SPDX-License-Identifier: GPL-3.0-or-later
 * Bytes -> triangles, materials and lights, hostile ones among them, in a small building; rays among walls and furniture, and previews
 * through any camera. What is refused says why; what isn't is found alike by every method, is finite where it must be, and light sets
 * change no bit. Without Embree triangles are refused and the walls alone remain. */
#include "fuzz_building.h"

#include "embree_modes.h"

#include <string.h>

enum { RAYS = 20, SIDE = 6, MOST_VERTICES = 12, MOST_TRIANGLES = 10, MOST_LIGHTS = 4 };

static void fuzz_vector(FuzzBytes *b, double out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = fuzz_number(b);
}

/* What meshes the bytes tell; committed, or NULL. */
static EnfTriangles *fuzz_triangles(FuzzBytes *b) {
    EnfTriangles *triangles = NULL;
    double origin[3];
    fuzz_vector(b, origin);
    if (enf_triangles_create(origin, &triangles) != ENF_OK) {
        FUZZ_CHECK(enf_last_error()[0]);
        return NULL;
    }
    uint32_t materials = 1;
    for (uint32_t count = fuzz_byte(b) % 4; materials <= count; materials++) {
        EnfMaterial m = {fuzz_byte(b) % 4, {1, 0.5f, (float)fuzz_number(b)}, {0, 0, 0}, 1 + 0.01f * (float)fuzz_byte(b)};
        uint32_t number;
        if (enf_triangles_add_material(triangles, &m, &number) != ENF_OK)
            FUZZ_CHECK(enf_last_error()[0]);
    }
    for (uint32_t mesh = 0, meshes = fuzz_byte(b) % 3; mesh < meshes; mesh++) {
        double vertices[MOST_VERTICES][3];
        uint32_t corners[3 * MOST_TRIANGLES], of[MOST_TRIANGLES];
        uint32_t vertex_count = fuzz_byte(b) % (MOST_VERTICES + 1), triangle_count = fuzz_byte(b) % (MOST_TRIANGLES + 1);
        for (uint32_t i = 0; i < vertex_count; i++)
            fuzz_vector(b, vertices[i]);
        for (uint32_t i = 0; i < 3 * triangle_count; i++)
            corners[i] = fuzz_byte(b) % (MOST_VERTICES + 1); /* now and then out of range */
        for (uint32_t i = 0; i < triangle_count; i++)
            of[i] = fuzz_byte(b) % 4;
        if (enf_triangles_add_mesh(triangles, mesh, vertices[0], vertex_count, sizeof *vertices, corners, triangle_count,
                                   fuzz_byte(b) % 2 ? of : NULL, NULL) != ENF_OK)
            FUZZ_CHECK(enf_last_error()[0]);
    }
    if (enf_triangles_commit(triangles) == ENF_OK)
        return triangles;
    FUZZ_CHECK(enf_last_error()[0]);
    enf_triangles_destroy(triangles);
    return NULL;
}

/* Nearest hits and shadows by every method, one thread and two. */
static void fuzz_batches(FuzzBytes *b, const EnfRaycaster *r, uint32_t cell_count) {
    float f[7][RAYS], distance[2][RAYS], normal[3 * RAYS], uv[2 * RAYS];
    uint32_t cells[RAYS], targets[RAYS], surface[2][RAYS], cell[2][RAYS];
    uint8_t portals[RAYS], blocked[2][RAYS];
    for (uint32_t i = 0; i < RAYS; i++) {
        for (int k = 0; k < 7; k++)
            f[k][i] = (float)fuzz_number(b) + (k < 6 ? 0 : 5);
        cells[i] = i % 2 ? ENF_NONE : fuzz_byte(b) % cell_count;
        targets[i] = i % 3 ? ENF_NONE : fuzz_byte(b) % (cell_count + 1);
    }
    EnfRayBatch batch = enf_default_ray_batch();
    EnfRayHits hits = enf_default_ray_hits();
    batch.count = RAYS;
    batch.origin_x = f[0], batch.origin_y = f[1], batch.origin_z = f[2];
    batch.direction_x = f[3], batch.direction_y = f[4], batch.direction_z = f[5];
    batch.max_distance = f[6];
    batch.cell = cells;
    batch.target_cell = targets;
    hits.portals = portals, hits.normal = normal, hits.uv = uv;
    for (batch.method = ENF_RAYS_AUTO; batch.method <= ENF_RAYS_WAVES; batch.method++)
        for (batch.threads = 1; batch.threads <= 2; batch.threads++) {
            int which = batch.threads == 2;
            hits.distance = distance[which];
            hits.surface = surface[which];
            hits.cell = cell[which];
            FUZZ_CHECK(enf_raycast_closest(r, &batch, &hits) == ENF_OK);
            FUZZ_CHECK(enf_raycast_any(r, &batch, blocked[which]) == ENF_OK);
            FUZZ_CHECK(!which || (memcmp(distance[0], distance[1], sizeof distance[0]) == 0 &&
                                  memcmp(surface[0], surface[1], sizeof surface[0]) == 0 && memcmp(cell[0], cell[1], sizeof cell[0]) == 0 &&
                                  memcmp(blocked[0], blocked[1], sizeof blocked[0]) == 0));
            for (uint32_t i = 0; i < RAYS; i++) {
                const float *n = normal + 3 * i;
                FUZZ_CHECK(distance[which][i] >= 0 && (distance[which][i] < INFINITY) == (surface[which][i] != ENF_NONE));
                FUZZ_CHECK(surface[which][i] == ENF_NONE || fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-4f);
                FUZZ_CHECK(cell[which][i] == ENF_NONE || cell[which][i] < cell_count);
            }
        }
}

static uint32_t fuzz_lights(FuzzBytes *b, EnfLight lights[MOST_LIGHTS]) {
    uint32_t count = fuzz_byte(b) % (MOST_LIGHTS + 1);
    for (uint32_t i = 0; i < count; i++) {
        EnfLight *l = &lights[i];
        *l = enf_default_light();
        l->kind = fuzz_byte(b) % 4;
        fuzz_vector(b, l->position);
        fuzz_vector(b, l->direction);
        fuzz_vector(b, l->side[0]);
        fuzz_vector(b, l->side[1]);
        l->radius = 0.01 * fuzz_byte(b);
        l->spot_angle = 0.0125 * fuzz_byte(b);
        l->spot_blend = fuzz_byte(b) / 255.0;
        l->reach = fuzz_byte(b) % 2 ? INFINITY : fuzz_number(b);
        l->spread = 0.0125 * fuzz_byte(b);
        l->ellipse = fuzz_byte(b) & 1;
        l->cosine = l->ellipse;
    }
    return count;
}

/* A preview with light sets and without: the same bits. */
static void fuzz_preview(FuzzBytes *b, const EnfScene *scene, const EnfRaycaster *r, const EnfTriangles *triangles) {
    EnfLight lights[MOST_LIGHTS];
    EnfLightSets *sets = NULL;
    float depth[SIDE * SIDE], normal[3 * SIDE * SIDE], direct[2][3 * SIDE * SIDE], open[SIDE * SIDE];
    uint32_t object[SIDE * SIDE], cell[SIDE * SIDE], count = fuzz_lights(b, lights);
    EnfCamera camera = enf_default_camera();
    double eye[3], turn = 0.1 * fuzz_byte(b);
    fuzz_vector(b, eye);
    const double axes[9] = {sin(turn), 0, -cos(turn), -cos(turn), 0, -sin(turn), 0, 1, 0};
    for (int k = 0; k < 3; k++) {
        for (int c = 0; c < 3; c++)
            camera.world_from_camera[4 * k + c] = axes[3 * k + c];
        camera.world_from_camera[4 * k + 3] = eye[k];
    }
    camera.type = fuzz_byte(b) % 3;
    camera.angle_x = camera.angle_y = 0.2 + 0.01 * fuzz_byte(b);
    camera.ortho_width = camera.ortho_height = 0.1 * fuzz_byte(b);
    EnfPreview p = enf_default_preview();
    p.width = p.height = SIDE;
    p.panorama.kind = fuzz_byte(b) % 4;
    p.raycaster = r;
    p.triangles = triangles;
    p.lights = lights;
    p.light_count = count;
    p.light_samples = 1 + fuzz_byte(b) % 3;
    p.max_bounces = fuzz_byte(b) % 5;
    p.ambient_samples = fuzz_byte(b) % 3;
    p.depth = depth, p.object = object, p.cell = cell, p.normal = normal, p.open = open;
    if (enf_light_sets_create(scene, lights, count, fuzz_byte(b) % 2, 1, &sets) != ENF_OK)
        FUZZ_CHECK(enf_last_error()[0]);
    memset(direct, 0, sizeof direct);
    for (uint32_t which = 0; which < 2; which++) {
        p.threads = 1 + which;
        p.light_sets = which ? sets : NULL;
        p.direct = direct[which];
        if (enf_preview(&p, &camera) != ENF_OK) {
            FUZZ_CHECK(enf_last_error()[0]);
            break;
        }
        for (uint32_t i = 0; i < SIDE * SIDE; i++)
            FUZZ_CHECK(depth[i] >= 0 && (object[i] != ENF_NONE || depth[i] == INFINITY));
        FUZZ_CHECK(which == 0 || memcmp(direct[0], direct[1], sizeof direct[0]) == 0);
        FUZZ_CHECK(enf_preview_smooth(open, depth, normal, SIDE, SIDE, 1) == ENF_OK);
    }
    enf_light_sets_destroy(sets);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const families[] = {"office:6,objects=0", "grid:2", "ring:5", "tower:2", "facade:1", "hub:5"};
    FuzzBytes bytes = fuzz_endless(data, size);
    const FuzzBuilding *building = fuzz_building(&bytes, families, 6);
    const EnfScene *scene = building->scene;
    EnfTriangles *triangles = embree_missing() ? NULL : fuzz_triangles(&bytes);
    FUZZ_CHECK(enf_raycaster_furnish(building->raycaster, triangles) == ENF_OK);
    fuzz_batches(&bytes, building->raycaster, scene->cell_count);
    fuzz_preview(&bytes, scene, building->raycaster, triangles);
    enf_raycaster_furnish(building->raycaster, NULL);
    enf_triangles_destroy(triangles);
    return 0;
}
