/* SPDX-License-Identifier: GPL-3.0-or-later
 * Bytes -> a small building of boxes, and rays and a camera in it: every method and instruction set gives the same bits, pictures are
 * written once everywhere, nothing goes round. */
#include "fuzz_building.h"

#include <math.h>
#include <string.h>

enum { RAYS = 24, SIDE = 20 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const families[] = {"office:8,objects=0", "grid:3,storeys=2", "ring:7", "columns:2", "tower:3", "facade:2", "hub:9"};
    FuzzBytes bytes = fuzz_endless(data, size);
    float f[7][RAYS], distance[2][RAYS];
    uint32_t cells[RAYS], surface[2][RAYS], cell[2][RAYS];
    const FuzzBuilding *building = fuzz_building(&bytes, families, 7);
    const EnfRaycaster *r = building->raycaster;
    for (uint32_t i = 0; i < RAYS; i++) { /* whole and half metres: corners and edges are met to the last bit */
        for (int k = 0; k < 6; k++)
            f[k][i] = 0.5f * (float)((int)fuzz_byte(&bytes) - 128) / (k < 3 ? 4 : 1);
        f[6][i] = i % 3 ? INFINITY : (float)fuzz_byte(&bytes) / 8;
        cells[i] = i % 2 ? ENF_NONE : (uint32_t)fuzz_byte(&bytes) % building->scene->cell_count;
    }
    EnfRayBatch batch = enf_default_ray_batch();
    EnfRayHits hits = enf_default_ray_hits();
    batch.count = RAYS;
    batch.threads = 1;
    batch.origin_x = f[0], batch.origin_y = f[1], batch.origin_z = f[2];
    batch.direction_x = f[3], batch.direction_y = f[4], batch.direction_z = f[5];
    batch.max_distance = f[6];
    batch.cell = cells;
    for (batch.method = ENF_RAYS_SINGLE; batch.method <= ENF_RAYS_WAVES; batch.method++)
        for (batch.simd = ENF_SIMD_NONE; batch.simd <= ENF_SIMD_AVX512; batch.simd++) {
            int which = batch.simd != ENF_SIMD_NONE;
            hits.distance = distance[which];
            hits.surface = surface[which];
            hits.cell = cell[which];
            FUZZ_CHECK(enf_raycast_closest(r, &batch, &hits) == ENF_OK);
            if (which)
                FUZZ_CHECK(memcmp(distance[0], distance[1], sizeof distance[0]) == 0 &&
                           memcmp(surface[0], surface[1], sizeof surface[0]) == 0 && memcmp(cell[0], cell[1], sizeof cell[0]) == 0);
        }
    EnfCamera camera = enf_default_camera();
    double turn = 0.1 * fuzz_byte(&bytes);
    const double axes[9] = {sin(turn), 0, -cos(turn), -cos(turn), 0, -sin(turn), 0, 1, 0};
    for (int k = 0; k < 3; k++) {
        for (int c = 0; c < 3; c++)
            camera.world_from_camera[4 * k + c] = axes[3 * k + c];
        camera.world_from_camera[4 * k + 3] = 0.25 * ((int)fuzz_byte(&bytes) - 64);
    }
    camera.angle_x = camera.angle_y = 0.2 + 0.01 * fuzz_byte(&bytes);
    uint32_t pixels[SIDE * SIDE];
    float depth[SIDE * SIDE];
    for (uint32_t method = ENF_IMAGE_SPANS; method <= ENF_IMAGE_PACKETS; method++) {
        EnfRaycastImage image = enf_default_raycast_image();
        image.width = image.height = SIDE;
        image.threads = 1;
        image.surface = pixels;
        image.depth = depth;
        image.method = method;
        memset(pixels, 0xEE, sizeof pixels);
        FUZZ_CHECK(enf_raycast_image(r, &camera, &image) == ENF_OK);
        for (uint32_t i = 0; i < SIDE * SIDE; i++)
            FUZZ_CHECK(pixels[i] != 0xEEEEEEEEu && depth[i] >= 0);
    }
    return 0;
}
