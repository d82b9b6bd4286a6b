/* SPDX-License-Identifier: GPL-3.0-or-later
 * State files: finished blocks of a bake, one record each, so that a bake goes on after a crash and shards come together.
 *
 * Little-endian, field by field. A head (what was asked, of which scene; its hash), then records: mark, block, size, hash, bytes. A record
 * is written in one go at the end of the file; one that a crash cut short fails its size or hash and is left out, with all
 * behind it. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/status.h"
#include "from_region/bake.h"

static const char magic[8] = {'E', 'N', 'F', 'P', 'V', 'S', '2', '\n'};
#define RECORD_MARK 0x4B4C4245u

/* ---- Bytes ------------------------------------------------------------------------------------------------- */
typedef struct Bytes {
    unsigned char *data;
    uint64_t size, room;
    int failed;
} Bytes;

static void put(Bytes *b, uint64_t value, int width) {
    if (b->size + (uint64_t)width > b->room) {
        b->failed |= !ENF_RESERVE(b->data, b->size + (uint64_t)width);
        b->room = enf_block_size(b->data);
    }
    if (b->failed)
        return;
    for (int k = 0; k < width; ++k)
        b->data[b->size++] = (unsigned char)(value >> 8 * k);
}
static void put_u32(Bytes *b, uint32_t value) {
    put(b, value, 4);
}
static void put_u64(Bytes *b, uint64_t value) {
    put(b, value, 8);
}
static void put_double(Bytes *b, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_u64(b, bits);
}

typedef struct Reader {
    const unsigned char *at, *end;
    int failed;
} Reader;

static uint64_t get(Reader *r, int width) {
    if (r->failed || r->end - r->at < width) {
        r->failed = 1;
        return 0;
    }
    uint64_t value = 0;
    for (int k = 0; k < width; ++k)
        value |= (uint64_t)*r->at++ << 8 * k;
    return value;
}
static uint32_t get_u32(Reader *r) {
    return (uint32_t)get(r, 4);
}
static uint64_t get_u64(Reader *r) {
    return get(r, 8);
}
static double get_double(Reader *r) {
    uint64_t bits = get_u64(r);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
/* A count of things that take at least `width` bytes each: never more than the file can hold. */
static uint32_t get_count(Reader *r, uint64_t width) {
    uint32_t count = get_u32(r);
    if (!r->failed && (uint64_t)(r->end - r->at) / width < count)
        r->failed = 1;
    return r->failed ? 0 : count;
}

/* FNV-1a over 64 bits, a byte at a time: short, and no adversary to resist. */
#define HASH_START 0xCBF29CE484222325u
static uint64_t hash_bytes(uint64_t hash, const void *data, uint64_t size) {
    const unsigned char *bytes = data;
    for (uint64_t i = 0; i < size; ++i)
        hash = (hash ^ bytes[i]) * 0x100000001B3u;
    return hash;
}
static uint64_t hash_u64(uint64_t hash, uint64_t value) {
    unsigned char bytes[8];
    for (int k = 0; k < 8; ++k)
        bytes[k] = (unsigned char)(value >> 8 * k);
    return hash_bytes(hash, bytes, sizeof bytes);
}
static uint64_t hash_double(uint64_t hash, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return hash_u64(hash, bits);
}

/* ---- The question ------------------------------------------------------------------------------------------ */
uint64_t enf_bake_geometry_hash(const EnfScene *scene) {
    uint64_t h = hash_u64(HASH_START, scene->cell_count);
    h = hash_u64(h, scene->portal_count), h = hash_u64(h, scene->opening_count);
    for (uint32_t p = 0; p < scene->portal_count; ++p) {
        h = hash_u64(h, (uint64_t)scene->portal_cells[p][0] << 32 | scene->portal_cells[p][1]);
        h = hash_u64(h, (uint64_t)scene->portal_openings[p] << 32 | scene->portal_vertex_first[p]);
    }
    for (uint32_t c = 0; c < scene->cell_count; ++c)
        h = hash_u64(h, scene->cell_openings[c]);
    for (uint32_t v = 0; v < scene->portal_vertex_first[scene->portal_count]; ++v)
        for (int k = 0; k < 3; ++k)
            h = hash_double(h, scene->portal_vertices[v][k]);
    return hash_double(h, scene->extent);
}

EnfStatus enf_bake_question(const EnfScene *scene, const EnfRegionModel *model, const EnfRegionVisDef *def, uint32_t block_count,
                            EnfBakeQuestion *out) {
    memset(out, 0, sizeof *out);
    out->clearance = model->delta * model->inverse_scale;
    out->method = def->method, out->block_count = block_count;
    out->cell_count = scene->cell_count, out->portal_count = scene->portal_count;
    out->opening_count = scene->opening_count;
    out->states = ENF_NEW(uint8_t, (uint64_t)scene->opening_count + 1);
    out->asked = ENF_NEW(uint32_t, (uint64_t)def->from_count + 1);
    if (!out->states || !out->asked) {
        enf_bake_question_free(out);
        return enf_fail_memory();
    }
    for (uint32_t k = 0; k < scene->opening_count; ++k)
        out->states[k] = (uint8_t)scene->openings[k].state;
    for (uint32_t i = 0; i < def->from_count; ++i)
        out->asked[i] = def->from_cells[i];
    out->asked_count = def->from_count;
    if (!def->state_path)
        return ENF_OK; /* hashes cost a pass over the scene: only where a file is compared */
    uint64_t h = enf_bake_geometry_hash(scene);
    out->geometry = h;
    h = hash_bytes(h, out->states, out->opening_count);
    h = hash_u64(h, out->method), h = hash_u64(h, out->block_count), h = hash_double(h, out->clearance);
    h = hash_double(h, def->sample_effort), h = hash_u64(h, def->seed), h = hash_u64(h, def->chain_cap);
    h = hash_u64(h, def->block_cells), h = hash_u64(h, out->asked_count);
    for (uint32_t i = 0; i < out->asked_count; ++i)
        h = hash_u64(h, out->asked[i]);
    out->question = h;
    return ENF_OK;
}

void enf_bake_question_free(EnfBakeQuestion *q) {
    enf_free(q->states), enf_free(q->asked);
    memset(q, 0, sizeof *q);
}

EnfStatus enf_bake_question_copy(EnfBakeQuestion *to, const EnfBakeQuestion *from) {
    *to = *from;
    to->states = ENF_NEW(uint8_t, (uint64_t)from->opening_count + 1);
    to->asked = ENF_NEW(uint32_t, (uint64_t)from->asked_count + 1);
    if (!to->states || !to->asked) {
        enf_bake_question_free(to);
        return enf_fail_memory();
    }
    memcpy(to->states, from->states, from->opening_count);
    memcpy(to->asked, from->asked, from->asked_count * sizeof *to->asked);
    return ENF_OK;
}

static void put_question(Bytes *b, const EnfBakeQuestion *q) {
    for (int k = 0; k < 8; ++k)
        put(b, (unsigned char)magic[k], 1);
    put_u64(b, q->geometry), put_u64(b, q->question), put_double(b, q->clearance);
    put_u32(b, q->method), put_u32(b, q->block_count);
    put_u32(b, q->cell_count), put_u32(b, q->portal_count), put_u32(b, q->opening_count), put_u32(b, q->asked_count);
    for (uint32_t k = 0; k < q->opening_count; ++k)
        put(b, q->states[k], 1);
    for (uint32_t i = 0; i < q->asked_count; ++i)
        put_u32(b, q->asked[i]);
    if (!b->failed)
        put_u64(b, hash_bytes(HASH_START, b->data, b->size)); /* the head comes first */
}

static EnfStatus get_question(const char *path, Reader *r, EnfBakeQuestion *q) {
    const unsigned char *head = r->at;
    memset(q, 0, sizeof *q);
    if (r->end - r->at < (ptrdiff_t)sizeof magic || memcmp(r->at, magic, sizeof magic) != 0)
        return enf_fail(ENF_ERROR_BAD_INPUT, "%s: this is no state file of a bake, or one of another version", path);
    r->at += sizeof magic;
    q->geometry = get_u64(r), q->question = get_u64(r), q->clearance = get_double(r);
    q->method = get_u32(r), q->block_count = get_u32(r);
    q->cell_count = get_u32(r), q->portal_count = get_u32(r);
    q->opening_count = get_count(r, 1);
    if (!r->failed && (uint64_t)(r->end - r->at) < 4)
        r->failed = 1;
    q->asked_count = get_u32(r);
    if (!r->failed && (uint64_t)(r->end - r->at) < q->opening_count + 4 * (uint64_t)q->asked_count + 8)
        r->failed = 1;
    if (r->failed || q->method > ENF_REGION_EXACT || q->block_count > (uint64_t)q->cell_count + 1 || !(q->clearance > 0) ||
        q->clearance > 1e300)
        return enf_fail(ENF_ERROR_BAD_INPUT, "%s: the head of the state file is damaged", path);
    q->states = ENF_NEW(uint8_t, (uint64_t)q->opening_count + 1);
    q->asked = ENF_NEW(uint32_t, (uint64_t)q->asked_count + 1);
    if (!q->states || !q->asked) {
        enf_bake_question_free(q);
        return enf_fail_memory();
    }
    int known = 1;
    for (uint32_t k = 0; k < q->opening_count; ++k) {
        q->states[k] = (uint8_t)get(r, 1);
        known &= q->states[k] <= ENF_STATE_GLASS;
    }
    for (uint32_t i = 0; i < q->asked_count; ++i)
        q->asked[i] = get_u32(r);
    uint64_t hash = hash_bytes(HASH_START, head, (uint64_t)(r->at - head));
    if (get_u64(r) == hash && known)
        return ENF_OK;
    enf_bake_question_free(q);
    return enf_fail(ENF_ERROR_BAD_INPUT, "%s: the head of the state file is damaged", path);
}

/* ---- Answers ----------------------------------------------------------------------------------------------- */
/* The counters a record keeps, in this order. */
static uint32_t counters_of(EnfRegionVisStats *s, uint64_t *out[16]) {
    uint64_t *all[] = {&s->might_pairs,     &s->seed_lines,  &s->seed_pairs,   &s->chains,      &s->clips,        &s->targets_dropped,
                       &s->line_tests,      &s->line_hits,   &s->cone_tests,   &s->cone_hidden, &s->cone_visible, &s->cone_rays,
                       &s->filter_failures, &s->exact_signs, &s->chain_capped, &s->cone_signs};
    memcpy(out, all, sizeof all);
    return (uint32_t)(sizeof all / sizeof *all);
}

static void put_answer(Bytes *b, const EnfBlockAnswer *answer) {
    EnfRegionVisStats stats = answer->stats;
    uint64_t *counters[16];
    uint32_t count = counters_of(&stats, counters);
    for (uint32_t k = 0; k < count; ++k)
        put_u64(b, *counters[k]);
    put_double(b, stats.might_s), put_double(b, stats.seed_s), put_double(b, stats.search_s);
    put_u32(b, answer->pair_count);
    for (uint32_t i = 0; i < answer->pair_count; ++i)
        for (int k = 0; k < 3; ++k)
            put_u32(b, answer->pairs[i][k]);
    const EnfLineStore *lines = &answer->lines;
    put_u32(b, lines->count);
    for (uint32_t i = 0; i < lines->count; ++i) {
        const EnfLine *line = &lines->lines[i];
        for (int k = 0; k < 3; ++k)
            put_double(b, line->p[k]);
        for (int k = 0; k < 3; ++k)
            put_double(b, line->d[k]);
        put_u32(b, line->portal_count);
        for (uint32_t k = 0; k < line->portal_count; ++k)
            put_u32(b, lines->portals[line->portal_first + k]);
    }
}

/* Whether a pair's state names a line that's there, or none. */
static int state_holds(uint32_t slot, uint32_t line_count) {
    if (slot == ENF_SLOT_UNDECIDED)
        return 1;
    if (enf_slot_is_visible(slot))
        return slot <= line_count;
    return enf_slot_is_grazing(slot) && (slot & ~ENF_SLOT_GRAZING) - 1 < line_count;
}

static EnfStatus get_answer(Reader *r, const EnfBakeQuestion *q, EnfBlockAnswer *out) {
    uint64_t *counters[16];
    uint32_t count = counters_of(&out->stats, counters);
    for (uint32_t k = 0; k < count; ++k)
        *counters[k] = get_u64(r);
    out->stats.might_s = get_double(r), out->stats.seed_s = get_double(r), out->stats.search_s = get_double(r);
    out->pair_count = get_count(r, 12);
    out->pairs = enf_alloc_array((uint64_t)out->pair_count + 1, sizeof *out->pairs);
    if (!out->pairs)
        return enf_fail_memory();
    for (uint32_t i = 0; i < out->pair_count; ++i)
        for (int k = 0; k < 3; ++k)
            out->pairs[i][k] = get_u32(r);
    uint32_t lines = get_count(r, 52), portals[ENF_WALK_MAX];
    for (uint32_t i = 0; i < lines && !r->failed; ++i) {
        double p[3], d[3];
        for (int k = 0; k < 3; ++k)
            p[k] = get_double(r);
        for (int k = 0; k < 3; ++k)
            d[k] = get_double(r);
        uint32_t length = get_count(r, 4);
        if (length > ENF_WALK_MAX)
            r->failed = 1;
        for (uint32_t k = 0; k < length && !r->failed; ++k) {
            portals[k] = get_u32(r);
            if (portals[k] >= 2 * (uint64_t)q->portal_count)
                r->failed = 1;
        }
        if (!r->failed && !enf_line_store_add(&out->lines, p, d, portals, length))
            return enf_fail_memory();
    }
    for (uint32_t i = 0; i < out->pair_count && !r->failed; ++i)
        if (out->pairs[i][0] >= q->cell_count || out->pairs[i][1] >= q->cell_count || out->pairs[i][0] == out->pairs[i][1] ||
            !state_holds(out->pairs[i][2], lines))
            r->failed = 1;
    out->done = !r->failed;
    return ENF_OK;
}

static void put_record(Bytes *b, uint32_t block, const EnfBlockAnswer *answer) {
    Bytes content = {0};
    put_answer(&content, answer);
    put_u32(b, RECORD_MARK), put_u32(b, block);
    put_u64(b, content.size), put_u64(b, hash_bytes(HASH_START, content.data, content.size));
    if (content.failed || !ENF_RESERVE(b->data, b->size + content.size))
        b->failed = 1;
    else
        memcpy(b->data + b->size, content.data, content.size), b->size += content.size;
    enf_free(content.data);
}

/* The next record. Gives 0 at the end of what is whole. */
static int get_record(Reader *r, const EnfBakeQuestion *q, EnfBlockAnswer *answers, EnfStatus *out_status) {
    *out_status = ENF_OK;
    uint32_t mark = get_u32(r), block = get_u32(r);
    uint64_t size = get_u64(r), hash = get_u64(r);
    if (r->failed || mark != RECORD_MARK || block >= q->block_count || (uint64_t)(r->end - r->at) < size ||
        hash_bytes(HASH_START, r->at, size) != hash)
        return 0;
    Reader inner = {r->at, r->at + size, 0};
    EnfBlockAnswer answer;
    memset(&answer, 0, sizeof answer);
    answer.stats = enf_default_region_vis_stats();
    *out_status = get_answer(&inner, q, &answer);
    int good = *out_status == ENF_OK && answer.done && inner.at == inner.end;
    if (good && !answers[block].done)
        answers[block] = answer;
    else
        enf_block_answer_free(&answer); /* a block that is there twice is the same twice */
    if (!good)
        return 0;
    r->at += size;
    return 1;
}

/* ---- Files ------------------------------------------------------------------------------------------------- */
/* Before anything is made or indexed by what the file says. */
static EnfStatus check_question(const char *path, const EnfBakeQuestion *q, const EnfBakeQuestion *expected, int any_question,
                                const char *as) {
    if (q->geometry != expected->geometry || q->cell_count != expected->cell_count || q->portal_count != expected->portal_count ||
        q->opening_count != expected->opening_count)
        return enf_fail(ENF_ERROR_BAD_INPUT, "%s: the state file belongs to another scene", path);
    for (uint32_t i = 0; i < q->asked_count; ++i)
        if (q->asked[i] >= q->cell_count)
            return enf_fail(ENF_ERROR_BAD_INPUT, "%s: the state file asks for row %u of %u", path, q->asked[i], q->cell_count);
    if (any_question || (q->question == expected->question && q->block_count == expected->block_count))
        return ENF_OK;
    return as ? enf_fail(ENF_ERROR_BAD_INPUT, "%s: not of the same bake as %s (door states, method, clearance, cells or blocks differ)",
                         path, as)
              : enf_fail(ENF_ERROR_BAD_INPUT,
                         "%s: the state file belongs to another question about this scene (door states, method, clearance, cells, "
                         "blocks); remove it to begin anew",
                         path);
}

EnfStatus enf_bake_state_read(const char *path, const EnfBakeQuestion *expected, const char *as, EnfBakeQuestion *out_question,
                              EnfBlockAnswer **answers, int *out_whole) {
    EnfBakeQuestion question;
    char *bytes = NULL;
    uint64_t size = 0;
    int begins = !as && !out_question;
    *out_whole = 0;
    if (begins) { /* a first start has no file */
        FILE *probe = enf_fopen(path, "rb");
        if (!probe)
            return ENF_OK;
        fclose(probe);
    }
    EnfStatus status = enf_file_read(path, &bytes, &size);
    if (status != ENF_OK)
        return status;
    Reader r = {(const unsigned char *)bytes, (const unsigned char *)bytes + size, 0};
    if (!size && begins) { /* a crash before the head was written */
        enf_free(bytes);
        return ENF_OK;
    }
    status = get_question(path, &r, &question);
    if (status == ENF_OK)
        status = check_question(path, &question, expected, out_question != NULL, as);
    if (status == ENF_OK && !*answers) {
        *answers = ENF_NEW(EnfBlockAnswer, (uint64_t)question.block_count + 1);
        if (!*answers)
            status = enf_fail_memory();
    }
    while (status == ENF_OK && r.at < r.end && get_record(&r, &question, *answers, &status)) {
    }
    if (status == ENF_OK)
        *out_whole = r.at == r.end && !r.failed;
    enf_free(bytes);
    if (out_question)
        *out_question = question;
    else
        enf_bake_question_free(&question);
    return status;
}

EnfStatus enf_bake_state_write(const char *path, const EnfBakeQuestion *question, const EnfBlockAnswer *answers) {
    EnfFileWriter writer;
    EnfStatus status = enf_file_write_begin(&writer, path);
    if (status != ENF_OK)
        return status;
    Bytes b = {0};
    put_question(&b, question);
    for (uint32_t k = 0; !b.failed && !ferror(writer.file) && k <= question->block_count; ++k) { /* one record at a time: memory for one */
        fwrite(b.data, 1, b.size, writer.file);
        b.size = 0;
        if (k < question->block_count && answers[k].done)
            put_record(&b, k, &answers[k]);
    }
    int failed = b.failed;
    enf_free(b.data);
    status = enf_file_write_end(&writer, !failed);
    return failed ? enf_fail_memory() : status;
}

EnfStatus enf_bake_state_append(const char *path, uint32_t block, const EnfBlockAnswer *answer) {
    Bytes b = {0};
    put_record(&b, block, answer);
    if (b.failed) {
        enf_free(b.data);
        return enf_fail_memory();
    }
    FILE *file = enf_fopen(path, "ab");
    int ok = file && fwrite(b.data, 1, b.size, file) == b.size;
    if (file && fclose(file) != 0)
        ok = 0;
    enf_free(b.data);
    return ok ? ENF_OK : enf_fail(ENF_ERROR_IO, "%s: the state file can't be written", path);
}
