/* SPDX-License-Identifier: GPL-3.0-or-later
 * Packets: LANES rays that go alike. Included by ray_kernel_body.h, once a width.
 *
 * The leader's exit is found by its sixteen corner signs; then all rays of the packet in the same cell are asked about that one section
 * at once, with the section's numbers the same for all lanes: nothing is gathered. */

#define VF         LANE_TYPE(vf, LANES)
#define LT         LANE_TYPE(lanes_lt, LANES)
#define EQ         LANE_TYPE(lanes_eq, LANES)
#define PUT        LANE_TYPE(lanes_put, LANES)
#define PUT_INDEX  LANE_TYPE(lanes_put_index, LANES)
#define ADD_ONE    LANE_TYPE(lanes_add_one, LANES)
#define GET        LANE_TYPE(lanes_get, LANES)
#define ALL        LANE_TYPE(lanes_all, LANES)
#define PICK       LANE_TYPE(lanes_pick, LANES)
#define VU         LANE_TYPE(vu, LANES)
#define GET_INDEX  LANE_TYPE(lanes_get_index, LANES)
#define ALL_INDEX  LANE_TYPE(lanes_all_index, LANES)
#define PICK_INDEX LANE_TYPE(lanes_pick_index, LANES)

/* Bands that other sections decide, lane by lane: a wall of more than three heights is rare. */
static void LANE_TYPE(ask_towers, LANES)(const PrismModel *m, uint32_t lanes, VF z, VU *link, uint32_t sections[LANES],
                                         uint32_t bands[LANES]) {
    for (; lanes; lanes &= lanes - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(lanes), to = (*link)[i];
        while (to >= LINK_TALL) {
            const PrismSection *s = &m->sections[sections[i] = to & LINK_SECTION];
            bands[i] = (uint32_t) !(z[i] < s->height[0]) + (uint32_t) !(z[i] < s->height[1]) + (uint32_t) !(z[i] < s->height[2]);
            to = s->link[bands[i]];
        }
        (*link)[i] = to;
    }
}

/* Rays that leave between corners k and k + 1. */
static inline __attribute__((always_inline)) uint32_t LANE_TYPE(leaving, LANES)(const PrismNode *node, uint32_t k, VF ox, VF oy, VF dx,
                                                                                VF dy) {
    const VF none = ALL(0.0f);
    VF side0 = dx * (node->y[k] - oy) - dy * (node->x[k] - ox), side1 = dx * (node->y[k + 1] - oy) - dy * (node->x[k + 1] - ox);
    return LT(side0, none) & ~LT(side1, none);
}

static void PACKET_NAME(const EnfRaycaster *r, const RayBlock *b) {
    const PrismModel *m = &r->prisms;
    const VF none = ALL(0.0f);
    const VU end = ALL_INDEX(LINK_END), planes = ALL_INDEX(LINK_PLANES);
    uint32_t first = 0, last_at = LINK_NOTHING, last_k = 0;
    const PrismNode *last_node = NULL;
    for (; first + LANES <= b->count; first += LANES) {
        VF ox = GET(b->ox + first), oy = GET(b->oy + first), oz = GET(b->oz + first);
        VF dx = GET(b->dx + first), dy = GET(b->dy + first), dz = GET(b->dz + first), limit = GET(b->limit + first);
        uint32_t up = LT(none, dz), down = LT(dz, none), steps = enf_ray_step_cap(r);
        uint32_t active = ~EQ(GET_INDEX(b->link + first) & planes, end) & ((1u << LANES) - 1);
        while (active) {
            uint32_t lane = (uint32_t)__builtin_ctz(active), at = b->link[first + lane];
            if (steps == 0) { /* the cap */
                PUT_INDEX(b->link + first, active, ALL_INDEX(LINK_NOTHING));
                break;
            }
            if (link_asks_planes(at)) {
                enf_ray_block_planes(r, b, first + lane, &steps);
                active &= ~((uint32_t)((b->link[first + lane] & LINK_PLANES) == LINK_END) << lane);
                continue;
            }
            uint32_t group = active & EQ(GET_INDEX(b->link + first), ALL_INDEX(at));
            steps--;
            while (group) {
                /* neighbours leave by the same section more often than not: the last one is tried before the leader looks for its own */
                const PrismNode *node = at == last_at ? last_node : &m->nodes[at];
                uint32_t k = last_k, lanes = at == last_at ? group & LANE_TYPE(leaving, LANES)(node, k, ox, oy, dx, dy) : 0;
                if (!lanes) {
                    uint32_t leader = (uint32_t)__builtin_ctz(group), i = first + leader;
                    node = &m->nodes[at];
                    while ((k = first_exit(node, b->ox[i], b->oy[i], b->dx[i], b->dy[i])) == PRISM_CHUNK - 1 && node->next < LINK_END)
                        node = &m->nodes[node->next];
                    if (k == PRISM_CHUNK - 1) {
                        b->link[i] = node->next;
                        group &= group - 1;
                        continue;
                    }
                    lanes = (group & LANE_TYPE(leaving, LANES)(node, k, ox, oy, dx, dy)) | 1u << leader;
                    last_at = at;
                    last_node = node;
                    last_k = k;
                }
                group &= ~lanes;
                const PrismSection *s = &m->sections[node->section_first + k];
                VF x0 = node->x[k] - ox, y0 = node->y[k] - oy;
                VF t = (s->nx * x0 + s->ny * y0) / (s->nx * dx + s->ny * dy), z = oz + t * dz;
                uint32_t above = lanes & up & LT(ALL(node->z[1]), z), below = lanes & down & LT(z, ALL(node->z[0]));
                if (above | below)
                    t = PICK(above | below, (PICK(up, ALL(node->z[1]), ALL(node->z[0])) - oz) / dz, t);
                /* where to: the bands from above, then the caps over them; no branch on what no predictor can know */
                uint32_t in0 = LT(z, ALL(s->height[0])), in1 = LT(z, ALL(s->height[1])), in2 = LT(z, ALL(s->height[2]));
                VU link = PICK_INDEX(in2, ALL_INDEX(s->link[2]), ALL_INDEX(s->link[3]));
                link = PICK_INDEX(in0, ALL_INDEX(s->link[0]), PICK_INDEX(in1, ALL_INDEX(s->link[1]), link));
                link = PICK_INDEX(above, ALL_INDEX(node->cap_link[1]), PICK_INDEX(below, ALL_INDEX(node->cap_link[0]), link));
                uint32_t tall = lanes & EQ(link & ALL_INDEX(LINK_TALL), ALL_INDEX(LINK_TALL));
                if (tall || b->way) {
                    uint32_t sections[LANES], bands[LANES];
                    for (uint32_t j = 0; j < LANES; j++) {
                        sections[j] = node->section_first + k;
                        bands[j] = above >> j & 1 ? 4 : below >> j & 1 ? 5 : 3 - (in0 >> j & 1) - (in1 >> j & 1) - (in2 >> j & 1);
                    }
                    LANE_TYPE(ask_towers, LANES)(m, tall, z, &link, sections, bands);
                    for (uint32_t left = b->way ? lanes : 0; left; left &= left - 1) {
                        uint32_t j = (uint32_t)__builtin_ctz(left);
                        b->way[first + j] = enf_ray_way(b->way[first + j], 8 * (uint64_t)sections[j] + bands[j]);
                    }
                }
                /* openings of all shapes ask the planes of this cell: no distance, no limit yet */
                uint32_t stays = lanes & EQ(link, ALL_INDEX(LINK_PLANES | node->cell));
                link = PICK_INDEX(~stays & ~LT(t, limit), ALL_INDEX(LINK_NOTHING), link);
                uint32_t ended = lanes & EQ(link & planes, end);
                PUT(b->distance + first, lanes & ~stays, t);
                PUT_INDEX(b->cell + first, lanes, ALL_INDEX(node->cell));
                ADD_ONE(b->portals + first, lanes & ~stays & ~ended);
                if (b->target) {
                    uint32_t there = lanes & EQ(GET_INDEX(b->target + first), link);
                    link = PICK_INDEX(there, ALL_INDEX(LINK_NOTHING), link);
                    ended |= there;
                }
                PUT_INDEX(b->link + first, lanes, link);
                active &= ~ended;
            }
        }
    }
    if (first < b->count) { /* the rest, one by one */
        RayBlock rest = *b;
        rest.count = b->count - first;
        rest.ox += first, rest.oy += first, rest.oz += first;
        rest.dx += first, rest.dy += first, rest.dz += first;
        rest.limit += first, rest.link += first, rest.distance += first, rest.cell += first, rest.portals += first;
        rest.target = b->target ? b->target + first : NULL;
        run_single(r, &rest);
    }
}

#undef VF
#undef LT
#undef EQ
#undef PUT
#undef PUT_INDEX
#undef ADD_ONE
#undef GET
#undef ALL
#undef PICK
#undef VU
#undef GET_INDEX
#undef ALL_INDEX
#undef PICK_INDEX
