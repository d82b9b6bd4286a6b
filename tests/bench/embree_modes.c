/* SPDX-License-Identifier: GPL-3.0-or-later
 * Embree 3 behind a handful of function pointers. */
#include "embree_modes.h"

#include "base/shared_library.h"
#include "base/timer.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const embree_mode_names[EMBREE_MODES] = {"rtcIntersect1", "rtcIntersect4", "rtcIntersect8", "rtcIntersect16", "rtcIntersectNp"};

#define FUNCTIONS(f)                                                                                                                       \
    f(rtcNewDevice) f(rtcReleaseDevice) f(rtcSetDeviceMemoryMonitorFunction) f(rtcNewScene) f(rtcReleaseScene) f(rtcCommitScene)           \
        f(rtcSetSceneBuildQuality) f(rtcSetSceneFlags) f(rtcNewGeometry) f(rtcReleaseGeometry) f(rtcCommitGeometry) f(rtcAttachGeometry)   \
            f(rtcSetNewGeometryBuffer) f(rtcSetGeometryBuildQuality) f(rtcIntersect1) f(rtcIntersect4) f(rtcIntersect8) f(rtcIntersect16)  \
                f(rtcIntersectNp) f(rtcOccluded1) f(rtcOccluded4) f(rtcOccluded8) f(rtcOccluded16) f(rtcOccludedNp)

#define DECLARE(name) __typeof__(name) *name;
typedef struct Calls {
    FUNCTIONS(DECLARE)
    int tried;
    const char *missing;
} Calls;
static Calls calls; /* of this process's one library */

struct EmbreeScene {
    RTCDevice device;
    RTCScene scene;
    double seconds;
    int64_t bytes;
};

const char *embree_missing(void) {
    if (calls.tried)
        return calls.missing;
    calls.tried = 1;
    EnfSharedLibrary *library = enf_shared_library_open("libembree3.so.3");
    void *address;
    if (!library)
        return calls.missing = "libembree3.so.3 isn't installed";
#define LOAD(name)                                                                                                                         \
    address = enf_shared_library_symbol(library, #name);                                                                                   \
    memcpy(&calls.name, &address, sizeof address);                                                                                         \
    if (!address)                                                                                                                          \
        return calls.missing = "libembree3.so.3 lacks " #name;
    FUNCTIONS(LOAD)
    return NULL;
}

static bool count_bytes(void *user, ssize_t bytes, bool post) {
    (void)post;
    ((EmbreeScene *)user)->bytes += bytes;
    return true;
}

EmbreeScene *embree_scene_create(const WallTriangles *walls, int high_quality) {
    if (embree_missing())
        return NULL;
    EmbreeScene *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->device = calls.rtcNewDevice("threads=1,set_affinity=0,hugepages=0");
    calls.rtcSetDeviceMemoryMonitorFunction(s->device, count_bytes, s);
    double begin = enf_wall_seconds();
    enum RTCBuildQuality quality = high_quality ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
    s->scene = calls.rtcNewScene(s->device);
    calls.rtcSetSceneBuildQuality(s->scene, quality);
    calls.rtcSetSceneFlags(s->scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = calls.rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    calls.rtcSetGeometryBuildQuality(geometry, quality);
    float *v = calls.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 16, walls->vertex_count);
    for (uint32_t i = 0; i < walls->vertex_count; i++)
        memcpy(v + 4 * (size_t)i, walls->vertices[i], 12);
    uint32_t *t = calls.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, walls->triangle_count);
    memcpy(t, walls->triangles, 12 * (size_t)walls->triangle_count);
    calls.rtcCommitGeometry(geometry);
    calls.rtcAttachGeometry(s->scene, geometry);
    calls.rtcReleaseGeometry(geometry);
    calls.rtcCommitScene(s->scene);
    s->seconds = enf_wall_seconds() - begin;
    return s;
}

void embree_scene_destroy(EmbreeScene *s) {
    if (!s)
        return;
    calls.rtcReleaseScene(s->scene);
    calls.rtcReleaseDevice(s->device);
    free(s);
}

double embree_build_seconds(const EmbreeScene *s) {
    return s->seconds;
}
uint64_t embree_bytes(const EmbreeScene *s) {
    return s->bytes > 0 ? (uint64_t)s->bytes : 0;
}

static struct RTCIntersectContext context_of(int coherent) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
}

#define FILL(n)                                                                                                                            \
    uint32_t some = rays->count - i < n ? (uint32_t)(rays->count - i) : n;                                                                 \
    int valid[n] __attribute__((aligned(64)));                                                                                             \
    for (uint32_t k = 0; k < n; k++)                                                                                                       \
        valid[k] = k < some ? -1 : 0;                                                                                                      \
    memcpy(ray->org_x, rays->ox + i, 4 * some);                                                                                            \
    memcpy(ray->org_y, rays->oy + i, 4 * some);                                                                                            \
    memcpy(ray->org_z, rays->oz + i, 4 * some);                                                                                            \
    memcpy(ray->dir_x, rays->dx + i, 4 * some);                                                                                            \
    memcpy(ray->dir_y, rays->dy + i, 4 * some);                                                                                            \
    memcpy(ray->dir_z, rays->dz + i, 4 * some);                                                                                            \
    memset(ray->tnear, 0, sizeof ray->tnear);                                                                                              \
    memset(ray->time, 0, sizeof ray->time);                                                                                                \
    memset(ray->mask, 0xFF, sizeof ray->mask);                                                                                             \
    for (uint32_t k = 0; k < some; k++)                                                                                                    \
        ray->tfar[k] = rays->limit ? rays->limit[i + k] : INFINITY;

#define PACKETS(n)                                                                                                                         \
    static void closest##n(const EmbreeScene *s, int coherent, const EmbreeRays *rays, float *distance, uint32_t *surface) {               \
        struct RTCIntersectContext context = context_of(coherent);                                                                         \
        struct RTCRayHit##n packet;                                                                                                        \
        struct RTCRay##n *ray = &packet.ray;                                                                                               \
        for (uint64_t i = 0; i < rays->count; i += n) {                                                                                    \
            FILL(n)                                                                                                                        \
            memset(packet.hit.geomID, 0xFF, sizeof packet.hit.geomID);                                                                     \
            calls.rtcIntersect##n(valid, s->scene, &context, &packet);                                                                     \
            for (uint32_t k = 0; k < some; k++) {                                                                                          \
                int hit = packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;                                                                 \
                distance[i + k] = hit ? ray->tfar[k] : INFINITY;                                                                           \
                surface[i + k] = hit ? packet.hit.primID[k] : ENF_NONE;                                                                    \
            }                                                                                                                              \
        }                                                                                                                                  \
    }                                                                                                                                      \
    static void any##n(const EmbreeScene *s, int coherent, const EmbreeRays *rays, uint8_t *blocked) {                                     \
        struct RTCIntersectContext context = context_of(coherent);                                                                         \
        struct RTCRay##n packet, *ray = &packet;                                                                                           \
        for (uint64_t i = 0; i < rays->count; i += n) {                                                                                    \
            FILL(n)                                                                                                                        \
            calls.rtcOccluded##n(valid, s->scene, &context, &packet);                                                                      \
            for (uint32_t k = 0; k < some; k++)                                                                                            \
                blocked[i + k] = ray->tfar[k] < 0;                                                                                         \
        }                                                                                                                                  \
    }
PACKETS(4)
PACKETS(8)
PACKETS(16)

static void closest1(const EmbreeScene *s, int coherent, const EmbreeRays *rays, float *distance, uint32_t *surface) {
    struct RTCIntersectContext context = context_of(coherent);
    for (uint64_t i = 0; i < rays->count; i++) {
        struct RTCRayHit one = {{rays->ox[i], rays->oy[i], rays->oz[i], 0, rays->dx[i], rays->dy[i], rays->dz[i], 0,
                                 rays->limit ? rays->limit[i] : INFINITY, 0xFFFFFFFFu, 0, 0},
                                {0}};
        one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        calls.rtcIntersect1(s->scene, &context, &one);
        int hit = one.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        distance[i] = hit ? one.ray.tfar : INFINITY;
        surface[i] = hit ? one.hit.primID : ENF_NONE;
    }
}

static void any1(const EmbreeScene *s, int coherent, const EmbreeRays *rays, uint8_t *blocked) {
    struct RTCIntersectContext context = context_of(coherent);
    for (uint64_t i = 0; i < rays->count; i++) {
        struct RTCRay one = {rays->ox[i], rays->oy[i], rays->oz[i],
                             0,           rays->dx[i], rays->dy[i],
                             rays->dz[i], 0,           rays->limit ? rays->limit[i] : INFINITY,
                             0xFFFFFFFFu, 0,           0};
        calls.rtcOccluded1(s->scene, &context, &one);
        blocked[i] = one.tfar < 0;
    }
}

enum { STREAM = 1024 };
static void stream(const EmbreeScene *s, int coherent, const EmbreeRays *rays, float *distance, uint32_t *surface, uint8_t *blocked) {
    static float far[STREAM], near[STREAM], n[3][STREAM], uv[2][STREAM];
    static unsigned prim[STREAM], geom[STREAM], inst[STREAM];
    struct RTCIntersectContext context = context_of(coherent);
    for (uint64_t i = 0; i < rays->count; i += STREAM) {
        uint32_t some = rays->count - i < STREAM ? (uint32_t)(rays->count - i) : STREAM;
        for (uint32_t k = 0; k < some; k++) {
            far[k] = rays->limit ? rays->limit[i + k] : INFINITY;
            geom[k] = RTC_INVALID_GEOMETRY_ID;
        }
        struct RTCRayHitNp p = {{(float *)rays->ox + i, (float *)rays->oy + i, (float *)rays->oz + i, near, (float *)rays->dx + i,
                                 (float *)rays->dy + i, (float *)rays->dz + i, NULL, far, NULL, NULL, NULL},
                                {n[0], n[1], n[2], uv[0], uv[1], prim, geom, {inst}}};
        if (blocked) {
            calls.rtcOccludedNp(s->scene, &context, &p.ray, some);
            for (uint32_t k = 0; k < some; k++)
                blocked[i + k] = far[k] < 0;
            continue;
        }
        calls.rtcIntersectNp(s->scene, &context, &p, some);
        for (uint32_t k = 0; k < some; k++) {
            int hit = geom[k] != RTC_INVALID_GEOMETRY_ID;
            distance[i + k] = hit ? far[k] : INFINITY;
            surface[i + k] = hit ? prim[k] : ENF_NONE;
        }
    }
}

void embree_closest(const EmbreeScene *s, int mode, int coherent, const EmbreeRays *rays, float *distance, uint32_t *surface) {
    if (mode == EMBREE_1)
        closest1(s, coherent, rays, distance, surface);
    else if (mode == EMBREE_4)
        closest4(s, coherent, rays, distance, surface);
    else if (mode == EMBREE_8)
        closest8(s, coherent, rays, distance, surface);
    else if (mode == EMBREE_16)
        closest16(s, coherent, rays, distance, surface);
    else
        stream(s, coherent, rays, distance, surface, NULL);
}

void embree_any(const EmbreeScene *s, int mode, int coherent, const EmbreeRays *rays, uint8_t *blocked) {
    if (mode == EMBREE_1)
        any1(s, coherent, rays, blocked);
    else if (mode == EMBREE_4)
        any4(s, coherent, rays, blocked);
    else if (mode == EMBREE_8)
        any8(s, coherent, rays, blocked);
    else if (mode == EMBREE_16)
        any16(s, coherent, rays, blocked);
    else
        stream(s, coherent, rays, NULL, NULL, blocked);
}
