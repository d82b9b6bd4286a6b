/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rays among triangles: Embree finds them, and the distance is taken again in double precision. */
#include "raycast/triangle_tree.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "geometry/vec3.h"

#include <stdatomic.h>

struct TreeMemory {
    _Atomic int64_t bytes; /* Embree's threads count together */
};

static bool count_bytes(void *user, ssize_t bytes, bool after) {
    (void)after;
    atomic_fetch_add_explicit(&((TreeMemory *)user)->bytes, bytes, memory_order_relaxed);
    return true;
}

void enf_triangle_tree_free(TriangleTree *tree) {
    for (int s = 0; s < ENF_TREE_SCENES; s++) {
        if (tree->scenes[s])
            tree->embree.rtcReleaseScene(tree->scenes[s]);
        enf_free(tree->corner_numbers[s]);
    }
    if (tree->device)
        tree->embree.rtcReleaseDevice(tree->device);
    enf_free(tree->memory);
    *tree = (TriangleTree){.device = NULL};
}

uint64_t enf_triangle_tree_bytes(const TriangleTree *tree) {
    uint64_t bytes = tree->memory ? (uint64_t)atomic_load(&tree->memory->bytes) : 0;
    for (int s = 0; s < ENF_TREE_SCENES; s++)
        bytes += enf_block_size(tree->corner_numbers[s]);
    return bytes;
}

static uint32_t meets(const EnfTriangles *t, uint32_t triangle) {
    switch (t->materials[t->triangles[triangle].material].kind) {
    case ENF_MATERIAL_GLASS:
        return ENF_MEET_GLASS;
    case ENF_MATERIAL_CLEAR:
        return 0;
    default:
        return ENF_MEET_OPAQUE;
    }
}

static EnfStatus build_scene(EnfTriangles *t, int s) {
    TriangleTree *tree = &t->tree;
    const Embree *embree = &tree->embree;
    uint32_t count = 0;
    for (uint32_t i = 0; i < t->count; i++)
        count += meets(t, i) == 1u << s;
    if (count == 0)
        return ENF_OK;
    tree->corner_numbers[s] = enf_alloc_array(count, sizeof *tree->corner_numbers[s]);
    if (!tree->corner_numbers[s])
        return enf_fail_memory();
    count = 0;
    for (uint32_t i = 0; i < t->count; i++)
        if (meets(t, i) == 1u << s) {
            for (uint32_t c = 0; c < 3; c++)
                tree->corner_numbers[s][count][c] = 3 * i + c;
            count++;
        }
    RTCGeometry geometry = embree->rtcNewGeometry(tree->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    tree->scenes[s] = embree->rtcNewScene(tree->device);
    if (!geometry || !tree->scenes[s]) {
        if (geometry)
            embree->rtcReleaseGeometry(geometry);
        return enf_fail_memory();
    }
    embree->rtcSetSceneFlags(tree->scenes[s], RTC_SCENE_FLAG_ROBUST);
    embree->rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, t->corners, 0, sizeof(float[3]),
                                       3 * (size_t)t->count);
    embree->rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, tree->corner_numbers[s], 0,
                                       sizeof(uint32_t[3]), count);
    embree->rtcCommitGeometry(geometry);
    embree->rtcAttachGeometry(tree->scenes[s], geometry);
    embree->rtcReleaseGeometry(geometry);
    embree->rtcCommitScene(tree->scenes[s]);
    enum RTCError error = embree->rtcGetDeviceError(tree->device);
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        return enf_fail_memory();
    return error == RTC_ERROR_NONE ? ENF_OK : enf_fail(ENF_ERROR_INTERNAL, "Embree: error %d over %u triangles", (int)error, count);
}

static void nothing(void *unused) {
    (void)unused;
}

/* Embree's tasks run on threads of its own, and the process ends when the system gives none: so one is asked for before. */
static EnfStatus ask_for_a_thread(void) {
    EnfThread *thread = enf_thread_start(nothing, NULL);
    enf_thread_join(thread);
    return thread ? ENF_OK : enf_fail(ENF_ERROR_INTERNAL, "triangles: the system gives no thread, and Embree needs some");
}

EnfStatus enf_triangle_tree_build(EnfTriangles *t) {
    TriangleTree *tree = &t->tree;
    enf_triangle_tree_free(tree);
    EnfStatus status = enf_embree_open(&tree->embree);
    if (status == ENF_OK)
        status = ask_for_a_thread();
    if (status != ENF_OK)
        return status;
    tree->device = tree->embree.rtcNewDevice(NULL);
    tree->memory = ENF_NEW(TreeMemory, 1);
    if (!tree->device || !tree->memory)
        status = enf_fail_memory();
    else
        tree->embree.rtcSetDeviceMemoryMonitorFunction(tree->device, count_bytes, tree->memory);
    for (int s = 0; s < ENF_TREE_SCENES && status == ENF_OK; s++)
        status = build_scene(t, s);
    if (status != ENF_OK)
        enf_triangle_tree_free(tree);
    return status;
}

/* Where the ray meets the triangle's plane; `otherwise` where it runs along it. */
static double plane_distance(const EnfTriangles *t, uint32_t triangle, const double o[3], const double d[3], double otherwise) {
    const float(*v)[3] = (const float(*)[3])t->corners[triangle];
    double a[3], ab[3], ac[3], n[3];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)v[0][k] - o[k];
        ab[k] = (double)v[1][k] - v[0][k];
        ac[k] = (double)v[2][k] - v[0][k];
    }
    vec_cross(n, ab, ac);
    double distance = vec_dot(n, a) / vec_dot(n, d);
    return isfinite(distance) ? distance : otherwise;
}

/* Metres by which glass must be nearer than what is opaque: a block of glass stands on a floor, whose face is in the same place as its own,
 * and rounding would show now this, now that. */
static const double glass_before = 2e-5;

static float narrow(double x) {
    return (float)fmin(x, INFINITY);
}

static struct RTCRay ray_of(const double o[3], const double d[3], double nearest, double farthest) {
    return (struct RTCRay){.org_x = (float)o[0],
                           .org_y = (float)o[1],
                           .org_z = (float)o[2],
                           .tnear = narrow(nearest),
                           .dir_x = (float)d[0],
                           .dir_y = (float)d[1],
                           .dir_z = (float)d[2],
                           .tfar = narrow(farthest),
                           .mask = ~0u};
}

/* Ray k of a packet: the same fields at any width. */
#define PUT_RAY(packet, k, ox, oy, oz, dx, dy, dz, nearest, farthest)                                                                      \
    ((packet).org_x[k] = (ox), (packet).org_y[k] = (oy), (packet).org_z[k] = (oz), (packet).tnear[k] = (nearest),                          \
     (packet).dir_x[k] = (dx), (packet).dir_y[k] = (dy), (packet).dir_z[k] = (dz), (packet).tfar[k] = (farthest), (packet).mask[k] = ~0u)

TreeHit enf_tree_hit(const EnfTriangles *t, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet) {
    TreeHit best = {INFINITY, 0, 0, ENF_NONE};
    for (int s = 0; s < ENF_TREE_SCENES; s++) {
        if (!t->tree.scenes[s] || !((meet >> s) & 1))
            continue;
        struct RTCIntersectContext context;
        struct RTCRayHit ray = {.ray = ray_of(origin, direction, nearest, fmin(farthest, best.distance - glass_before)),
                                .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
        rtcInitIntersectContext(&context);
        t->tree.embree.rtcIntersect1(t->tree.scenes[s], &context, &ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            continue;
        best.triangle = t->tree.corner_numbers[s][ray.hit.primID][0] / 3;
        best.distance = plane_distance(t, best.triangle, origin, direction, ray.ray.tfar);
        best.u = ray.hit.u;
        best.v = ray.hit.v;
    }
    return best;
}

void enf_tree_hits(const EnfTriangles *t, const TreeRay *rays, uint32_t count, uint32_t meet, TreeHit *hits) {
    double local[TREE_RAYS][3];
    const int alone = count < 4; /* a packet that is nearly empty costs more than its rays */
    for (uint32_t i = 0; i < count; i++) {
        vec_sub(local[i], rays[i].origin, t->origin);
        hits[i] = alone ? enf_tree_hit(t, local[i], rays[i].direction, rays[i].nearest, rays[i].farthest, meet)
                        : (TreeHit){INFINITY, 0, 0, ENF_NONE};
    }
    for (int s = 0; s < ENF_TREE_SCENES && !alone; s++) {
        if (!t->tree.scenes[s] || !((meet >> s) & 1))
            continue;
        struct RTCRayHit16 packet = {.ray = {.tfar = {0}}};
        _Alignas(64) int valid[16] = {0};
        struct RTCIntersectContext context;
        for (uint32_t i = 0; i < count; i++) {
            valid[i] = -1;
            const double *o = local[i], *d = rays[i].direction;
            PUT_RAY(packet.ray, i, (float)o[0], (float)o[1], (float)o[2], (float)d[0], (float)d[1], (float)d[2], narrow(rays[i].nearest),
                    narrow(fmin(rays[i].farthest, hits[i].distance - glass_before)));
            packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        t->tree.embree.rtcIntersect16(valid, t->tree.scenes[s], &context, &packet);
        for (uint32_t i = 0; i < count; i++) {
            if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID)
                continue;
            uint32_t triangle = t->tree.corner_numbers[s][packet.hit.primID[i]][0] / 3;
            hits[i] = (TreeHit){plane_distance(t, triangle, local[i], rays[i].direction, packet.ray.tfar[i]), packet.hit.u[i],
                                packet.hit.v[i], triangle};
        }
    }
}

int enf_tree_blocked(const EnfTriangles *t, const double origin[3], const double direction[3], double nearest, double farthest,
                     uint32_t meet) {
    for (int s = 0; s < ENF_TREE_SCENES; s++) {
        if (!t->tree.scenes[s] || !((meet >> s) & 1))
            continue;
        struct RTCIntersectContext context;
        struct RTCRay ray = ray_of(origin, direction, nearest, farthest);
        rtcInitIntersectContext(&context);
        t->tree.embree.rtcOccluded1(t->tree.scenes[s], &context, &ray);
        if (ray.tfar < 0) /* Embree's mark for a ray that met something */
            return 1;
    }
    return 0;
}

/* Asks about the first `lanes` of the rays in `lane`, by a packet of that width. */
#define BLOCKED_PACKET(width, rays, lane, lanes, embree, scene)                                                                            \
    do {                                                                                                                                   \
        struct RTCRay##width packet = {.tfar = {0}};                                                                                       \
        _Alignas(64) int valid[width] = {0};                                                                                               \
        struct RTCIntersectContext context;                                                                                                \
        for (uint32_t k = 0; k < (lanes); k++) {                                                                                           \
            const uint32_t at = (lane)[k];                                                                                                 \
            const float *const *o = (rays)->origin, *const *d = (rays)->direction;                                                         \
            valid[k] = -1;                                                                                                                 \
            PUT_RAY(packet, k, o[0][at], o[1][at], o[2][at], d[0][at], d[1][at], d[2][at], 0, (rays)->farthest[at]);                       \
        }                                                                                                                                  \
        rtcInitIntersectContext(&context);                                                                                                 \
        (embree)->rtcOccluded##width(valid, scene, &context, &packet);                                                                     \
        for (uint32_t k = 0; k < (lanes); k++)                                                                                             \
            (rays)->blocked[(lane)[k]] |= packet.tfar[k] < 0;                                                                              \
    } while (0)

void enf_tree_blocked_rays(const EnfTriangles *t, const TreeRays *rays) {
    const Embree *embree = &t->tree.embree;
    RTCScene scene = t->tree.scenes[0]; /* what is opaque */
    uint32_t lane[16], lanes = 0;
    for (uint32_t i = 0; scene && i < rays->count; i++) {
        if (!rays->blocked[i])
            lane[lanes++] = i;
        if (lanes == 16 || (lanes > 8 && i + 1 == rays->count)) {
            BLOCKED_PACKET(16, rays, lane, lanes, embree, scene);
            lanes = 0;
        } else if (lanes && i + 1 == rays->count) {
            BLOCKED_PACKET(8, rays, lane, lanes, embree, scene);
        }
    }
}

void enf_tree_plane_normal(const EnfTriangles *t, uint32_t triangle, double out[3]) {
    const float(*v)[3] = (const float(*)[3])t->corners[triangle];
    double ab[3], ac[3];
    for (int k = 0; k < 3; k++) {
        ab[k] = (double)v[1][k] - v[0][k];
        ac[k] = (double)v[2][k] - v[0][k];
    }
    vec_cross(out, ab, ac);
    vec_normalize(out);
}

void enf_tree_shading_normal(const EnfTriangles *t, const TreeHit *hit, double out[3]) {
    if (t->normals) {
        const int16_t *n = t->normals[hit->triangle];
        for (int k = 0; k < 3; k++)
            out[k] = (1 - hit->u - hit->v) * n[k] + hit->u * n[3 + k] + hit->v * n[6 + k];
        if (vec_normalize(out) > 100) /* of 32767: flat meshes are zero */
            return;
    }
    enf_tree_plane_normal(t, hit->triangle, out);
}

EnfStatus enf_triangles_hit(const EnfTriangles *triangles, const double *origins, const double *directions, const double *max_distances,
                            uint64_t count, EnfTriangleHit *out_hits) {
    if (!triangles || (count && (!origins || !directions || !out_hits)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_hit: NULL argument");
    if (!triangles->committed)
        return enf_fail(ENF_ERROR_STATE, "enf_triangles_hit: the triangles aren't committed");
    for (uint64_t i = 0; i < count; i++) {
        EnfTriangleHit *out = &out_hits[i];
        double o[3];
        const double *d = directions + 3 * i;
        *out = (EnfTriangleHit){INFINITY, {0, 0, 0}, ENF_NONE, ENF_NONE, ENF_NONE, 0};
        vec_sub(o, origins + 3 * i, triangles->origin);
        if (!vec_finite(o) || !vec_finite(d) || !(vec_length(d) > 0))
            continue;
        TreeHit hit = enf_tree_hit(triangles, o, d, 0, max_distances ? max_distances[i] : INFINITY, ENF_MEET_ALL);
        if (hit.triangle == ENF_NONE)
            continue;
        out->distance = hit.distance;
        out->triangle = hit.triangle;
        out->object = triangles->triangles[hit.triangle].object;
        out->material = triangles->triangles[hit.triangle].material;
        enf_tree_plane_normal(triangles, hit.triangle, out->normal);
    }
    return ENF_OK;
}
