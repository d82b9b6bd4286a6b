/* SPDX-License-Identifier: GPL-3.0-or-later
 * Sightlines of grazing pairs, moved to where they keep furthest from all edges.
 *
 * The line that showed a pair grazing is any that passes. How nearly the pair is visible is said by the best one: asked of its chain of
 * portals alone (chain_query.h) for one clearance after another, half way each time by ratio. A yes is a line, a no is certified, so the
 * clearance left is within the last step of the largest that any line through these portals has. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "enfilade/chain_query.h"
#include "from_region/bake.h"
#include "geometry/vec3.h"

/* Over a factor of ten thousand these leave 1 %. */
#define HALVINGS 10

typedef struct Corners {
    double (*at)[3];
    uint32_t *counts;
} Corners;

/* The corners of the line's portals in metres, wound about the way it goes. */
static int load_corners(const EnfRegionModel *m, const uint32_t *portals, uint32_t count, Corners *corners) {
    uint64_t total = 0;
    if (!ENF_RESERVE(corners->counts, count))
        return 0;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t portal = portals[i] >> 1, first = m->raw.first[portal], size = enf_rm_count(&m->raw, portal);
        if (!ENF_RESERVE(corners->at, total + size))
            return 0;
        for (uint32_t k = 0; k < size; ++k) /* raw polygons run clockwise about direction 0; about the origin nothing is lost */
            vec_scale(corners->at[total + k], m->inverse_scale, m->raw.vertices[first + (portals[i] & 1 ? k : size - 1 - k)]);
        corners->counts[i] = size;
        total += size;
    }
    return 1;
}

/* Gives the clearance in *out_best. */
static EnfStatus move_line(const EnfRegionModel *m, EnfLineStore *lines, EnfLine *line, EnfChainQuery *query, Corners *corners,
                           double *out_best) {
    const uint32_t *portals = lines->portals + line->portal_first;
    if (!load_corners(m, portals, line->portal_count, corners))
        return enf_fail_memory();
    double best = enf_line_clearance(m, line->p, line->d, portals, line->portal_count), high = ENF_INNER_OFFSET * m->delta;
    double low = fmax(best, 1e-4 * m->delta);
    for (int step = 0; step < HALVINGS && low < high; ++step) {
        EnfChainAnswer answer = enf_default_chain_answer();
        double middle = sqrt(low * high), p[3], d[3];
        /* A chain that can't be asked alone (a polygon without a plane of its own) keeps its line. */
        if (enf_chain_query(query, corners->at[0], corners->counts, line->portal_count, middle / ENF_INNER_OFFSET * m->inverse_scale,
                            &answer) != ENF_OK)
            break;
        vec_scale(p, m->scale, answer.segment);
        vec_scale(d, m->scale, answer.segment + 3);
        vec_sub(d, d, p);
        double clearance = -1;
        if ((answer.status == ENF_PAIR_VISIBLE || answer.status == ENF_PAIR_GRAZING) && vec_normalize(d) > 0)
            clearance = enf_line_clearance(m, p, d, portals, line->portal_count);
        if (clearance > best) {
            vec_copy(line->p, p), vec_copy(line->d, d);
            best = clearance;
        }
        middle = ENF_INNER_OFFSET * answer.delta * m->scale; /* raised where it would drown in rounding */
        if (middle >= high)
            break;
        if (answer.status == ENF_PAIR_VISIBLE)
            low = fmax(low, best);
        else
            high = middle;
    }
    *out_best = best;
    return ENF_OK;
}

EnfStatus enf_widen_grazing_lines(EnfRegionBake *bake) {
    const EnfPairTable *t = &bake->table;
    EnfChainQuery *query = NULL;
    Corners corners = {NULL, NULL};
    EnfStatus status = ENF_OK;
    for (uint64_t s = 0; s < t->slot_first[t->cell_count] && status == ENF_OK; ++s) {
        if (!enf_slot_is_grazing(t->slots[s]))
            continue;
        double best = 0;
        if (!query)
            status = enf_chain_query_create(&query);
        if (status == ENF_OK)
            status =
                move_line(bake->model, &bake->lines, &bake->lines.lines[(t->slots[s] & ~ENF_SLOT_GRAZING) - 1], query, &corners, &best);
        if (status == ENF_OK && best >= bake->model->delta)
            t->slots[s] &= ~ENF_SLOT_GRAZING; /* between delta and the inner polygons' 1.05 of it */
    }
    enf_chain_query_destroy(query);
    enf_free(corners.at), enf_free(corners.counts);
    return status;
}
