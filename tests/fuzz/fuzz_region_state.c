/* SPDX-License-Identifier: GPL-3.0-or-later
 * Fuzz: state files of bakes with bytes changed, cut off, put in another order. Read as a result and taken up by a bake they give the
 * answer they hold or an error that names the file, never more. */
#include "fuzz_common.h"

#include <string.h>

#define FILE_A "fuzz_region_state.a"
#define FILE_B "fuzz_region_state.b"

static unsigned char *whole[2]; /* two shares of one bake */
static size_t whole_size[2];
static EnfScene *scene;
static uint32_t *right_cells;
static uint64_t *right_first;

/* Rooms in a row, a door (that can be shut) between each two, not all in line. */
static void make_scene(void) {
    uint32_t room, cell, portal, opening;
    FUZZ_CHECK(enf_scene_create(&scene) == ENF_OK);
    FUZZ_CHECK(enf_scene_add_room(scene, "r", ENF_ROOM_INTERIOR, &room) == ENF_OK);
    for (uint32_t i = 0; i < 7; ++i) {
        double box[8][3];
        for (int v = 0; v < 8; ++v)
            box[v][0] = v & 1 ? 10 : 0, box[v][1] = 3.0 * i + (v & 2 ? 3 : 0), box[v][2] = v & 4 ? 3 : 0;
        FUZZ_CHECK(enf_scene_add_cell(scene, room, ENF_NONE, box[0], 8, 0, NULL, 0, NULL, &cell) == ENF_OK);
    }
    for (uint32_t i = 0; i < 6; ++i) {
        double x = i % 3, y = 3.0 * (i + 1), q[4][3] = {{x, y, 0}, {x + 2, y, 0}, {x + 2, y, 2}, {x, y, 2}};
        FUZZ_CHECK(enf_scene_add_opening(scene, "door", ENF_OPENING_DOOR, ENF_STATE_OPEN, &opening) == ENF_OK);
        FUZZ_CHECK(enf_scene_add_portal(scene, i, i + 1, q[0], 4, 0, opening, &portal) == ENF_OK);
    }
    FUZZ_CHECK(enf_scene_commit(scene) == ENF_OK);
}

static EnfRegionVisDef share(uint32_t index, const char *path) {
    EnfRegionVisDef def = enf_default_region_vis_def();
    def.threads = 1, def.block_cells = 2, def.shard_index = index, def.shard_count = 2, def.state_path = path;
    return def;
}

static void read_back(const char *path, unsigned char **out, size_t *out_size) {
    FILE *file = fopen(path, "rb");
    FUZZ_CHECK(file);
    *out = malloc(1 << 20);
    *out_size = fread(*out, 1, 1 << 20, file);
    FUZZ_CHECK(*out_size > 100 && *out_size < 1 << 20);
    fclose(file);
}

static void write_out(const char *path, const unsigned char *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    FUZZ_CHECK(file && fwrite(bytes, 1, size, file) == size);
    FUZZ_CHECK(fclose(file) == 0);
}

static void end(void) {
    enf_scene_destroy(scene);
    remove(FILE_A), remove(FILE_B);
}

static void begin(void) {
    make_scene();
    (void)atexit(end);
    for (uint32_t k = 0; k < 2; ++k) {
        const char *path = k ? FILE_B : FILE_A;
        EnfRegionVisDef def = share(k, path);
        EnfRegionVis *part = NULL;
        remove(path);
        FUZZ_CHECK(enf_region_vis_run(scene, &def, &part) == ENF_OK);
        enf_region_vis_destroy(part);
        read_back(path, &whole[k], &whole_size[k]);
    }
    const char *paths[] = {FILE_A, FILE_B};
    EnfRegionVis *result = NULL;
    FUZZ_CHECK(enf_region_vis_load(scene, paths, 2, &result) == ENF_OK);
    uint32_t n = enf_region_vis_cell_count(result);
    right_first = malloc((n + 1) * sizeof *right_first);
    memcpy(right_first, enf_region_vis_row_first(result), (n + 1) * sizeof *right_first);
    right_cells = malloc(right_first[n] * sizeof *right_cells);
    memcpy(right_cells, enf_region_vis_row_cells(result), right_first[n] * sizeof *right_cells);
    enf_region_vis_destroy(result);
}

static uint64_t number_at(const unsigned char *at, int width) {
    uint64_t value = 0;
    for (int k = 0; k < width; ++k)
        value |= (uint64_t)at[k] << 8 * k;
    return value;
}

static void put_hash(unsigned char *to, const unsigned char *bytes, uint64_t size) {
    uint64_t hash = 0xCBF29CE484222325u;
    for (uint64_t k = 0; k < size; ++k)
        hash = (hash ^ bytes[k]) * 0x100000001B3u;
    for (int k = 0; k < 8; ++k)
        to[k] = (unsigned char)(hash >> 8 * k);
}

/* Hashes anew, so that what was changed inside records is believed. */
static void mend_hashes(unsigned char *bytes, size_t size) {
    size_t at = 8 + 3 * 8 + 6 * 4 + 6; /* magic, hashes and clearance, counts, states */
    if (at + 8 <= size)
        put_hash(bytes + at, bytes, at);
    at += 8;
    while (at + 24 <= size) {
        uint64_t length = number_at(bytes + at + 8, 8);
        if (length > size - at - 24)
            break;
        put_hash(bytes + at + 16, bytes + at + 24, length);
        at += 24 + length;
    }
}

static void use(const EnfRegionVis *result) {
    uint32_t n = enf_region_vis_cell_count(result);
    const uint64_t *first = enf_region_vis_row_first(result);
    const uint32_t *cells = enf_region_vis_row_cells(result);
    for (uint32_t i = 0; i < n; ++i)
        for (uint64_t k = first[i]; k < first[i + 1]; ++k) {
            double segment[6], clearance;
            uint32_t portals[8], count;
            FUZZ_CHECK(cells[k] < n && (k == first[i] || cells[k] > cells[k - 1]));
            (void)enf_region_vis_witness(result, i, cells[k], segment, portals, 8, &count, &clearance);
        }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (!scene)
        begin();
    uint64_t live = enf_live_bytes();
    FuzzBytes in = {data, data + size};
    uint32_t what = fuzz_byte(&in);
    size_t length = whole_size[what & 1];
    unsigned char *bytes = malloc(length + 64);
    memcpy(bytes, whole[what & 1], length);
    while (in.at < in.end) {
        uint32_t kind = fuzz_byte(&in), low = fuzz_byte(&in), high = fuzz_byte(&in), value = fuzz_byte(&in);
        size_t at = length ? (low | high << 8) % length : 0;
        if (kind < 160 && length)
            bytes[at] = (unsigned char)value;
        else if (kind < 200 && at + 4 <= length)
            memset(bytes + at, value & 1 ? 255 : 0, 4);
        else if (kind < 220)
            length = at;
        else if (kind < 230 && value <= length - at) /* a piece comes twice */
            memmove(bytes + at, bytes + length - value, value);
    }
    if (what & 2)
        mend_hashes(bytes, length);
    int same = length == whole_size[what & 1] && !memcmp(bytes, whole[what & 1], length);
    write_out(what & 1 ? FILE_B : FILE_A, bytes, length);
    write_out(what & 1 ? FILE_A : FILE_B, whole[!(what & 1)], whole_size[!(what & 1)]);
    free(bytes);
    const char *paths[2] = {what & 4 ? FILE_B : FILE_A, what & 4 ? FILE_A : FILE_B};
    EnfRegionVis *result = NULL;
    EnfStatus status = enf_region_vis_load(scene, paths, 2, &result);
    FUZZ_CHECK(status != ENF_OK ? !result : result != NULL);
    if (status != ENF_OK)
        FUZZ_CHECK(strstr(enf_last_error(), "fuzz_region_state."));
    if (result)
        use(result);
    if (!(what & 2) && result) { /* what is damaged is left out, never taken */
        uint32_t n = enf_region_vis_cell_count(result);
        FUZZ_CHECK(!memcmp(enf_region_vis_row_first(result), right_first, (n + 1) * sizeof *right_first));
        FUZZ_CHECK(!memcmp(enf_region_vis_row_cells(result), right_cells, right_first[n] * sizeof *right_cells));
    }
    FUZZ_CHECK(!same || status == ENF_OK);
    enf_region_vis_destroy(result), result = NULL;
    EnfRegionVisDef def = share(what & 1, what & 1 ? FILE_B : FILE_A);
    status = enf_region_vis_run(scene, &def, &result); /* goes on from it */
    if (status == ENF_OK)
        use(result);
    else
        FUZZ_CHECK(strstr(enf_last_error(), "fuzz_region_state."));
    enf_region_vis_destroy(result);
    FUZZ_CHECK(enf_live_bytes() == live);
    return 0;
}
