/* SPDX-License-Identifier: GPL-3.0-or-later
 * Portal files of level editors, PRT1 and PRT2: cells without geometry, joined by portals.
 *
 *   PRT1: header, leafs, portals, then the portals.          The leafs are the cells.
 *   PRT2: header, leafs, clusters, portals, then the portals, then a line of leafs per cluster ending in -1.
 *   A portal: n a b (x y z ) (x y z ) ...  clockwise seen from a, so that cross(p0 - p1, p2 - p1) points into
 * a. Portals are turned on reading: the scene's are counter-clockwise seen from their first cell. */
#include "base/memory.h"
#include "base/number.h"
#include "base/status.h"
#include "scene/scene_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct Reader {
    const char *at, *end;
    uint64_t line;
} Reader;

static void skip_space(Reader *r) {
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t' || *r->at == '\r' || *r->at == '\n')) {
        r->line += *r->at == '\n';
        r->at++;
    }
}

static int read_number(Reader *r, double *out) {
    skip_space(r);
    const char *next = enf_number_parse(r->at, r->end, out);
    if (!next)
        return 0;
    r->at = next;
    return 1;
}

/* A whole number below `limit`. */
static int read_index(Reader *r, uint64_t limit, uint32_t *out) {
    double value;
    if (!read_number(r, &value) || !(value >= 0.0) || value >= (double)limit || value != floor(value))
        return 0;
    *out = (uint32_t)value;
    return 1;
}

static int read_char(Reader *r, char c) {
    skip_space(r);
    if (r->at >= r->end || *r->at != c)
        return 0;
    r->at++;
    return 1;
}

static EnfStatus fail(const Reader *r, const char *what) {
    if (r->at >= r->end)
        return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: the file ends where %s should stand", (unsigned long long)r->line, what);
    return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: %s should stand at \"%.*s\"", (unsigned long long)r->line, what,
                    (int)(r->end - r->at < 16 ? r->end - r->at : 16), r->at);
}

static EnfStatus read_portal(EnfScene *scene, Reader *r, uint32_t index, uint32_t cells, double (**polygon)[3]) {
    uint32_t count, a, b;
    char what[64];
    snprintf(what, sizeof what, "portal %u: a number of vertices", index);
    if (!read_index(r, ENF_NONE, &count))
        return fail(r, what);
    if (count < 3)
        return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: portal %u: %u vertices, at least 3 are needed", (unsigned long long)r->line, index,
                        count);
    /* "(0 0 0)" takes 7 bytes: a count that the rest of the file can't hold is refused before memory is asked
     * for. */
    if ((uint64_t)count * 7 > (uint64_t)(r->end - r->at))
        return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: portal %u: %u vertices don't fit in the rest of the file",
                        (unsigned long long)r->line, index, count);
    for (int side = 0; side < 2; side++) {
        uint32_t *cell = side ? &b : &a;
        snprintf(what, sizeof what, "portal %u: a cluster", index);
        if (!read_index(r, ENF_NONE, cell))
            return fail(r, what);
        if (*cell >= cells)
            return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: portal %u: cluster %u doesn't exist (%u clusters)",
                            (unsigned long long)r->line, index, *cell, cells);
    }
    if (!ENF_RESERVE(*polygon, count))
        return enf_fail_memory();
    for (uint32_t i = 0; i < count; i++) {
        double *p = (*polygon)[count - 1 - i];
        snprintf(what, sizeof what, "portal %u: vertex %u as (x y z)", index, i);
        if (!read_char(r, '(') || !read_number(r, &p[0]) || !read_number(r, &p[1]) || !read_number(r, &p[2]) || !read_char(r, ')'))
            return fail(r, what);
    }
    return enf_scene_add_portal(scene, a, b, (*polygon)[0], count, 0, ENF_NONE, NULL);
}

EnfStatus enf_scene_read_prt(EnfScene *scene, const char *text, uint64_t size) {
    Reader r = {text, text + size, 1};
    int version = 0;
    if (size >= 4 && memcmp(text, "PRT1", 4) == 0)
        version = 1;
    if (size >= 4 && memcmp(text, "PRT2", 4) == 0)
        version = 2;
    if (!version || (size > 4 && text[4] != '\n' && text[4] != '\r' && text[4] != ' '))
        return enf_fail(ENF_ERROR_BAD_INPUT, "line 1: only PRT1 and PRT2 are known");
    r.at += 4;
    uint32_t leafs, clusters, portals;
    if (!read_index(&r, ENF_NONE, &leafs))
        return fail(&r, "the number of leafs");
    clusters = leafs;
    if (version == 2 && !read_index(&r, ENF_NONE, &clusters))
        return fail(&r, "the number of clusters");
    if (!read_index(&r, ENF_NONE, &portals))
        return fail(&r, "the number of portals");
    /* Hostile counts: a portal takes at least 25 bytes, a cluster's line of PRT2 two ("-1"). Leafs of PRT1
     * have no line of their own, but a file with far more leafs than bytes isn't a portal file. */
    if ((uint64_t)portals * 25 > size)
        return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: %u portals don't fit in a file of %llu bytes", (unsigned long long)r.line, portals,
                        (unsigned long long)size);
    if (version == 2 ? (uint64_t)clusters * 2 > size : (uint64_t)clusters > 4096 + size)
        return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: %u clusters don't fit in a file of %llu bytes", (unsigned long long)r.line,
                        clusters, (unsigned long long)size);
    for (uint32_t c = 0; c < clusters; c++) {
        EnfStatus status = enf_scene_add_cell(scene, ENF_NONE, ENF_NONE, NULL, 0, 0, NULL, 0, NULL, NULL);
        if (status != ENF_OK)
            return status;
    }
    double(*polygon)[3] = NULL;
    EnfStatus status = ENF_OK;
    for (uint32_t p = 0; p < portals && status == ENF_OK; p++)
        status = read_portal(scene, &r, p, clusters, &polygon);
    enf_free(polygon);
    if (status != ENF_OK)
        return status;
    if (version == 2)
        for (uint32_t c = 0; c < clusters; c++)
            for (;;) {
                double leaf;
                char what[64];
                snprintf(what, sizeof what, "cluster %u: a leaf or -1", c);
                if (!read_number(&r, &leaf) || leaf != floor(leaf) || leaf < -1.0)
                    return fail(&r, what);
                if (leaf == -1.0)
                    break;
                if (leaf >= (double)leafs)
                    return enf_fail(ENF_ERROR_BAD_INPUT, "line %llu: cluster %u: leaf %.0f doesn't exist (%u leafs)",
                                    (unsigned long long)r.line, c, leaf, leafs);
            }
    skip_space(&r);
    if (r.at < r.end)
        return fail(&r, "the end of the file");
    return ENF_OK;
}
