/* SPDX-License-Identifier: GPL-3.0-or-later
 * What rays prove visible: the first surfaces they meet among the drawn triangles. The judge of the engines.
 *
 *   ray_oracle view DUMP [--cameras FILE] [--camera INDEX] --rays N [--seed S]
 *   ray_oracle region DUMP --volumes FILE --rays N [--seed S]
 *
 * It shares no code with csrc/ and knows nothing of rooms' portals: triangles come from tests/oracle/dump_triangles.py,
 * ray queries from Embree. Surfaces flagged see-through (glass) are counted as seen and passed.
 * `view`: half of the rays go through random points of the picture, half are aimed at random points of random
 * triangles (kept when they lie in the picture), so that small and far things are proven too. Cameras are the dump's, or
 * those of FILE (a JSON array of the same form); without INDEX all of them, --rays each. Result: one line of JSON a camera,
 * with an entry per object that was hit and one ray as proof.
 * `region`: rays start at random points of random convex volumes (one line each in FILE: `plane count`, then that
 * many `nx ny nz d`, inside where n.p <= d) and every volume that a ray crosses before the first opaque surface is proven
 * visible from where it started. Result: JSON, the proven pairs with one segment each. */
#include <embree3/rtcore.h>
#include <jansson.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Mesh {
    uint32_t vertex_count, triangle_count;
    float (*vertices)[3];
    uint32_t (*triangles)[3];
    uint8_t *clear;
    RTCScene scene;
} Mesh;

typedef struct Dump {
    json_t *header;
    uint32_t mesh_count, object_count;
    Mesh *meshes;
    uint32_t *object_mesh;
    double (*matrices)[12];
    double bounds[6]; /* of everything but the largest object (the ground), where random targets are worth most */
    RTCDevice device;
    RTCScene scene;
} Dump;

static void die(const char *what, const char *name) {
    fprintf(stderr, "ray_oracle: %s%s%s\n", what, name ? ": " : "", name ? name : "");
    exit(2);
}

static void *take(size_t count, size_t size) {
    void *p = calloc(count ? count : 1, size);
    if (!p)
        die("out of memory", NULL);
    return p;
}

static void get(void *to, size_t size, size_t count, FILE *file) {
    if (fread(to, size, count, file) != count)
        die("the dump ends too early", NULL);
}

/* splitmix64: small, known, and not the generator the engines use. */
static uint64_t random_state;
static uint64_t random_bits(void) {
    uint64_t z = (random_state += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
}
static double random_unit(void) {
    return (double)(random_bits() >> 11) * 0x1p-53;
}
static uint32_t random_below(uint32_t n) {
    return (uint32_t)(random_unit() * n);
}

static void world_point(const Dump *dump, uint32_t object, const double p[3], double out[3]) {
    const double *m = dump->matrices[object];
    for (int i = 0; i < 3; ++i)
        out[i] = m[4 * i] * p[0] + m[4 * i + 1] * p[1] + m[4 * i + 2] * p[2] + m[4 * i + 3];
}

static void load(Dump *dump, const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file)
        die("can't open", path);
    size_t room = 1 << 20, length = 0;
    char *line = take(room, 1);
    for (int c; (c = fgetc(file)) != '\n';) {
        if (c == EOF)
            die("no header in", path);
        if (length + 2 > room && !(line = realloc(line, room *= 2)))
            die("out of memory", NULL);
        line[length++] = (char)c;
    }
    json_error_t error;
    dump->header = json_loadb(line, length, 0, &error);
    free(line);
    if (!dump->header)
        die("bad header", error.text);
    json_t *meshes = json_object_get(dump->header, "meshes"), *objects = json_object_get(dump->header, "objects");
    dump->mesh_count = (uint32_t)json_array_size(meshes);
    dump->object_count = (uint32_t)json_array_size(objects);
    dump->meshes = take(dump->mesh_count, sizeof *dump->meshes);
    dump->object_mesh = take(dump->object_count, sizeof *dump->object_mesh);
    dump->matrices = take(dump->object_count, sizeof *dump->matrices);
    dump->device = rtcNewDevice("threads=1");
    for (uint32_t i = 0; i < dump->mesh_count; ++i) {
        Mesh *mesh = &dump->meshes[i];
        json_t *entry = json_array_get(meshes, i);
        mesh->vertex_count = (uint32_t)json_integer_value(json_object_get(entry, "vertices"));
        mesh->triangle_count = (uint32_t)json_integer_value(json_object_get(entry, "triangles"));
        mesh->clear = take(mesh->triangle_count, 1);
        RTCGeometry geometry = rtcNewGeometry(dump->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        /* One vertex more than needed: Embree reads 16 bytes at the last. */
        mesh->vertices = take((size_t)mesh->vertex_count + 2, sizeof *mesh->vertices);
        mesh->triangles = take(mesh->triangle_count, sizeof *mesh->triangles);
        get(mesh->vertices, sizeof *mesh->vertices, mesh->vertex_count, file);
        get(mesh->triangles, sizeof *mesh->triangles, mesh->triangle_count, file);
        get(mesh->clear, 1, mesh->triangle_count, file);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->vertices, 0, sizeof *mesh->vertices,
                                   mesh->vertex_count);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->triangles, 0, sizeof *mesh->triangles,
                                   mesh->triangle_count);
        rtcCommitGeometry(geometry);
        mesh->scene = rtcNewScene(dump->device);
        rtcSetSceneFlags(mesh->scene, RTC_SCENE_FLAG_ROBUST);
        rtcAttachGeometry(mesh->scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(mesh->scene);
    }
    get(dump->matrices, sizeof *dump->matrices, dump->object_count, file);
    fclose(file);
    dump->scene = rtcNewScene(dump->device);
    rtcSetSceneFlags(dump->scene, RTC_SCENE_FLAG_ROBUST);
    for (uint32_t i = 0; i < dump->object_count; ++i) {
        uint32_t mesh = (uint32_t)json_integer_value(json_object_get(json_array_get(objects, i), "mesh"));
        if (mesh >= dump->mesh_count)
            die("an object's mesh is out of range", NULL);
        dump->object_mesh[i] = mesh;
        RTCGeometry geometry = rtcNewGeometry(dump->device, RTC_GEOMETRY_TYPE_INSTANCE);
        float columns[12];
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 3; ++r)
                columns[3 * c + r] = (float)dump->matrices[i][4 * r + c];
        rtcSetGeometryInstancedScene(geometry, dump->meshes[mesh].scene);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(dump->scene, geometry, i);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(dump->scene);
    enum RTCError code = rtcGetDeviceError(dump->device);
    if (code != RTC_ERROR_NONE)
        die("Embree refused the scene", NULL);
}

typedef struct Hit {
    uint32_t object; /* UINT32_MAX: nothing */
    int clear;
    int behind; /* the face is met from behind */
    double t;
} Hit;

/* Whether the ray comes upon the hit's face from behind: from within what the face bounds. In the instance's own frame, so that mirrored
 * instances count like any other. */
static int from_behind(const Dump *dump, const struct RTCRayHit *ray, const double d[3]) {
    float m[12]; /* columns: the three axes, then where it stands */
    rtcGetGeometryTransform(rtcGetGeometry(dump->scene, ray->hit.instID[0]), 0.0f, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    double along = 0, volume = 0, n[3] = {ray->hit.Ng_x, ray->hit.Ng_y, ray->hit.Ng_z};
    for (int k = 0; k < 3; ++k) { /* Cramer: the k-th coordinate of d in the frame, times the frame's volume */
        const float *b = m + 3 * ((k + 1) % 3), *c = m + 3 * ((k + 2) % 3);
        double cross[3] = {(double)b[1] * c[2] - (double)b[2] * c[1], (double)b[2] * c[0] - (double)b[0] * c[2],
                           (double)b[0] * c[1] - (double)b[1] * c[0]};
        along += n[k] * (cross[0] * d[0] + cross[1] * d[1] + cross[2] * d[2]);
        volume = cross[0] * m[3 * k] + cross[1] * m[3 * k + 1] + cross[2] * m[3 * k + 2];
    }
    return along * volume > 0;
}

static Hit shoot(const Dump *dump, const double o[3], const double d[3], double t_min, double t_max) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayHit ray = {0};
    ray.ray.org_x = (float)o[0], ray.ray.org_y = (float)o[1], ray.ray.org_z = (float)o[2];
    ray.ray.dir_x = (float)d[0], ray.ray.dir_y = (float)d[1], ray.ray.dir_z = (float)d[2];
    ray.ray.tnear = (float)t_min, ray.ray.tfar = (float)t_max;
    ray.ray.mask = 0xFFFFFFFFu;
    ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(dump->scene, &context, &ray);
    Hit hit = {UINT32_MAX, 0, 0, t_max};
    if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        hit.object = ray.hit.instID[0];
        hit.clear = dump->meshes[dump->object_mesh[hit.object]].clear[ray.hit.primID];
        hit.t = ray.ray.tfar;
        hit.behind = from_behind(dump, &ray, d);
    }
    return hit;
}

static double vector(const json_t *object, const char *key, double out[3]) {
    json_t *array = json_object_get(object, key);
    if (json_array_size(array) < 2)
        die("the dump's camera lacks", key);
    for (size_t i = 0; i < 3 && i < json_array_size(array); ++i)
        out[i] = json_number_value(json_array_get(array, i));
    return out[0];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A random point of a random triangle of a random object. */
static void random_target(const Dump *dump, double out[3]) {
    uint32_t object = random_below(dump->object_count);
    const Mesh *mesh = &dump->meshes[dump->object_mesh[object]];
    const uint32_t *triangle = mesh->triangles[random_below(mesh->triangle_count)];
    double u = random_unit(), v = random_unit(), p[3];
    if (u + v > 1.0)
        u = 1.0 - u, v = 1.0 - v;
    for (int i = 0; i < 3; ++i) {
        double a = mesh->vertices[triangle[0]][i];
        p[i] = a + u * (mesh->vertices[triangle[1]][i] - a) + v * (mesh->vertices[triangle[2]][i] - a);
    }
    world_point(dump, object, p, out);
}

typedef struct Proof {
    uint64_t count;
    double from[3], to[3];
} Proof;

static json_t *json_point(const double p[3]) {
    return json_pack("[f,f,f]", p[0], p[1], p[2]);
}

static void view(Dump *dump, const json_t *camera, uint64_t rays) {
    double origin[3], corner[3], right[3], up[3], forward[3], clip[3];
    vector(camera, "origin", origin), vector(camera, "corner", corner), vector(camera, "right", right);
    vector(camera, "up", up), vector(camera, "forward", forward), vector(camera, "clip", clip);
    int ortho = strcmp(json_string_value(json_object_get(camera, "type")), "ORTHO") == 0;
    Proof *proofs = take(dump->object_count, sizeof *proofs);
    uint64_t shot = 0, hits = 0, behind = 0;
    double rr = dot(right, right), uu = dot(up, up), cf = dot(corner, forward);
    for (uint64_t n = 0; n < rays; ++n) {
        double u = random_unit(), v = random_unit(), o[3], d[3], scale = 1.0;
        if (n & 1) { /* aimed: where in the picture does the target lie? */
            double target[3], q[3];
            random_target(dump, target);
            for (int i = 0; i < 3; ++i)
                q[i] = target[i] - origin[i];
            double depth = dot(q, forward);
            if (!ortho) {
                if (depth <= 0.0)
                    continue;
                for (int i = 0; i < 3; ++i)
                    q[i] *= cf / depth;
            }
            for (int i = 0; i < 3; ++i)
                q[i] -= corner[i];
            u = dot(q, right) / rr, v = dot(q, up) / uu;
            if (!(u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0))
                continue;
        }
        ++shot;
        for (int i = 0; i < 3; ++i) {
            double p = corner[i] + u * right[i] + v * up[i];
            o[i] = ortho ? origin[i] + p - cf * forward[i] : origin[i];
            d[i] = ortho ? forward[i] : p;
        }
        double length = sqrt(dot(d, d));
        for (int i = 0; i < 3; ++i)
            d[i] /= length;
        scale = dot(d, forward); /* clip distances are measured along the view axis */
        double t = clip[0] / scale, t_max = clip[1] / scale;
        for (int layer = 0; layer < 64; ++layer) {
            Hit hit = shoot(dump, o, d, t, t_max);
            if (hit.object == UINT32_MAX)
                break;
            ++hits;
            behind += layer == 0 && hit.behind;
            Proof *proof = &proofs[hit.object];
            if (!proof->count++)
                for (int i = 0; i < 3; ++i)
                    proof->from[i] = o[i], proof->to[i] = o[i] + hit.t * d[i];
            if (!hit.clear)
                break;
            t = hit.t + 1e-5 * (1.0 + hit.t); /* past the pane, in metres: single precision at that distance */
        }
    }
    json_t *seen = json_array();
    for (uint32_t i = 0; i < dump->object_count; ++i)
        if (proofs[i].count) {
            json_t *name = json_object_get(json_array_get(json_object_get(dump->header, "objects"), i), "name");
            json_array_append_new(seen, json_pack("{s:O,s:I,s:o,s:o}", "object", name, "rays", (json_int_t)proofs[i].count, "from",
                                                  json_point(proofs[i].from), "to", json_point(proofs[i].to)));
        }
    json_t *result = json_pack("{s:O,s:I,s:I,s:I,s:I,s:o}", "camera", json_object_get(camera, "name"), "rays", (json_int_t)shot, "hits",
                               (json_int_t)hits, "behind", (json_int_t)behind, "objects", (json_int_t)dump->object_count, "seen", seen);
    json_dumpf(result, stdout, JSON_COMPACT);
    fputc('\n', stdout);
    json_decref(result);
    free(proofs);
}

typedef struct Volume {
    uint32_t plane_count;
    double (*planes)[4];
    double low[3], high[3];
} Volume;

/* The part of o + t d inside a convex volume shrunk by `margin` metres; 0 when it is shorter than 1e-3 m. */
static int crosses(const Volume *volume, const double o[3], const double d[3], double t_max, double margin) {
    double t0 = 0.0, t1 = t_max;
    for (uint32_t i = 0; i < volume->plane_count; ++i) {
        const double *plane = volume->planes[i];
        double rate = dot(plane, d), room = plane[3] - margin - dot(plane, o);
        if (fabs(rate) < 1e-12) {
            if (room < 0.0)
                return 0;
        } else if (rate > 0.0)
            t1 = fmin(t1, room / rate);
        else
            t0 = fmax(t0, room / rate);
        if (t1 - t0 < 1e-3)
            return 0;
    }
    return 1;
}

static int region(Dump *dump, const char *path, uint64_t rays) {
    FILE *file = fopen(path, "r");
    if (!file)
        die("can't open", path);
    uint32_t count = 0, usable = 0;
    if (fscanf(file, "%u", &count) != 1)
        die("no volumes in", path);
    Volume *volumes = take(count, sizeof *volumes);
    uint32_t *starts = take(count, sizeof *starts);
    for (uint32_t i = 0; i < count; ++i) {
        Volume *volume = &volumes[i];
        if (fscanf(file, "%u %lf %lf %lf %lf %lf %lf", &volume->plane_count, &volume->low[0], &volume->low[1], &volume->low[2],
                   &volume->high[0], &volume->high[1], &volume->high[2]) != 7)
            die("a volume's line is broken in", path);
        volume->planes = take(volume->plane_count, sizeof *volume->planes);
        for (uint32_t k = 0; k < volume->plane_count; ++k)
            for (int j = 0; j < 4; ++j)
                if (fscanf(file, "%lf", &volume->planes[k][j]) != 1)
                    die("a plane is broken in", path);
        if (volume->plane_count)
            starts[usable++] = i;
    }
    fclose(file);
    if (!usable)
        die("no volume has planes in", path);
    Proof *proofs = take((size_t)count * count, sizeof *proofs);
    const double margin = 1e-4; /* metres: a ray that only grazes a volume's face proves nothing */
    uint64_t shot = 0;
    for (uint64_t n = 0; n < rays; ++n) {
        uint32_t from = starts[random_below(usable)];
        const Volume *volume = &volumes[from];
        double o[3], d[3];
        int inside = 0;
        for (int trial = 0; trial < 50 && !inside; ++trial) {
            for (int i = 0; i < 3; ++i)
                o[i] = volume->low[i] + random_unit() * (volume->high[i] - volume->low[i]);
            inside = 1;
            for (uint32_t i = 0; i < volume->plane_count; ++i)
                inside &= dot(volume->planes[i], o) < volume->planes[i][3] - margin;
        }
        if (!inside)
            continue;
        if (n & 1) { /* towards a random point of another volume */
            const Volume *other = &volumes[starts[random_below(usable)]];
            for (int i = 0; i < 3; ++i)
                d[i] = other->low[i] + random_unit() * (other->high[i] - other->low[i]) - o[i];
        } else { /* any direction, rather level than steep */
            double a = 6.283185307179586 * random_unit(), z = 0.6 * (random_unit() + random_unit() - 1.0);
            d[0] = cos(a), d[1] = sin(a), d[2] = z;
        }
        double length = sqrt(dot(d, d));
        if (!(length > 1e-6))
            continue;
        for (int i = 0; i < 3; ++i)
            d[i] /= length;
        ++shot;
        double t = 0.0;
        for (int layer = 0; layer < 64; ++layer) {
            Hit hit = shoot(dump, o, d, t, 1e4);
            t = hit.t;
            if (hit.object == UINT32_MAX || !hit.clear)
                break;
            t += 1e-5 * (1.0 + t);
        }
        /* In single precision the hit may lie a little deep: what is proven ends before it. */
        double reach = t - 1e-3;
        for (uint32_t to = 0; to < count; ++to) {
            if (!volumes[to].plane_count || !crosses(&volumes[to], o, d, reach, margin))
                continue;
            Proof *proof = &proofs[(size_t)from * count + to];
            if (!proof->count++)
                for (int i = 0; i < 3; ++i)
                    proof->from[i] = o[i], proof->to[i] = o[i] + reach * d[i];
        }
    }
    json_t *pairs = json_array();
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t k = 0; k < count; ++k) {
            Proof *proof = &proofs[(size_t)i * count + k];
            if (proof->count)
                json_array_append_new(pairs,
                                      json_pack("{s:I,s:I,s:I,s:o,s:o}", "from_volume", (json_int_t)i, "to_volume", (json_int_t)k, "rays",
                                                (json_int_t)proof->count, "from", json_point(proof->from), "to", json_point(proof->to)));
        }
    json_t *result = json_pack("{s:I,s:I,s:o}", "rays", (json_int_t)shot, "volumes", (json_int_t)count, "pairs", pairs);
    json_dumpf(result, stdout, JSON_COMPACT);
    fputc('\n', stdout);
    json_decref(result);
    free(proofs);
    return 0;
}

int main(int argc, char **argv) {
    if (argc < 3)
        die("usage: ray_oracle view|region DUMP [--camera INDEX] [--cameras FILE] [--volumes FILE] [--rays N] [--seed S]", NULL);
    size_t camera = SIZE_MAX;
    const char *cameras = NULL;
    uint64_t rays = 100000, seed = 1;
    const char *volumes = NULL;
    for (int i = 3; i + 1 < argc; i += 2) {
        if (!strcmp(argv[i], "--camera"))
            camera = strtoul(argv[i + 1], NULL, 10);
        else if (!strcmp(argv[i], "--cameras"))
            cameras = argv[i + 1];
        else if (!strcmp(argv[i], "--rays"))
            rays = strtoull(argv[i + 1], NULL, 10);
        else if (!strcmp(argv[i], "--seed"))
            seed = strtoull(argv[i + 1], NULL, 10);
        else if (!strcmp(argv[i], "--volumes"))
            volumes = argv[i + 1];
        else
            die("unknown option", argv[i]);
    }
    random_state = seed * 0xD1B54A32D192ED03ull;
    Dump dump = {0};
    load(&dump, argv[2]);
    if (!strcmp(argv[1], "view")) {
        json_error_t error;
        json_t *list = cameras ? json_load_file(cameras, 0, &error) : json_object_get(dump.header, "cameras");
        if (!json_is_array(list))
            die("no list of cameras", cameras);
        if (camera != SIZE_MAX && camera >= json_array_size(list))
            die("no such camera", NULL);
        for (size_t i = 0; i < json_array_size(list); ++i)
            if (camera == SIZE_MAX || camera == i) {
                random_state = (seed + i) * 0xD1B54A32D192ED03ull;
                view(&dump, json_array_get(list, i), rays);
            }
        return 0;
    }
    if (!strcmp(argv[1], "region") && volumes)
        return region(&dump, volumes, rays);
    die("unknown mode", argv[1]);
    return 2;
}
