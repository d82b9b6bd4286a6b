/* SPDX-License-Identifier: GPL-3.0-or-later
 * Packets: LANES rays that go alike. Included by ray_kernel_body.h, once a width.
 *
 * The leader's exit is found by its sixteen corner signs; then all rays of the packet in the same cell are asked about that one section
 * at once, with the section's numbers the same for all lanes: nothing is gathered. Where they are on their way stays in registers.
 * PACKET_EYE: all rays begin at one eye, so that what belongs to corner and origin is one number. */

#define VF         LANE_TYPE(vf, LANES)
#define LT         LANE_TYPE(lanes_lt, LANES)
#define EQ         LANE_TYPE(lanes_eq, LANES)
#define GET        LANE_TYPE(lanes_get, LANES)
#define ALL        LANE_TYPE(lanes_all, LANES)
#define PICK       LANE_TYPE(lanes_pick, LANES)
#define VU         LANE_TYPE(vu, LANES)
#define GET_INDEX  LANE_TYPE(lanes_get_index, LANES)
#define ALL_INDEX  LANE_TYPE(lanes_all_index, LANES)
#define PICK_INDEX LANE_TYPE(lanes_pick_index, LANES)

#if !PACKET_EYE
/* Bands that other sections decide, lane by lane: a wall of more than three heights is rare. */
static void LANE_TYPE(ask_towers, LANES)(const PrismSection *all, uint32_t lanes, VF z, VU *link, VU *place) {
    for (; lanes; lanes &= lanes - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(lanes), to = (*link)[i];
        while (to >= LINK_TALL) {
            const PrismSection *s = &all[to & LINK_SECTION];
            uint32_t band = (uint32_t) !(z[i] < s->height[0]) + (uint32_t) !(z[i] < s->height[1]) + (uint32_t) !(z[i] < s->height[2]);
            (*place)[i] = PLACES * (to & LINK_SECTION) + PLACE_TALL + band;
            to = s->link[band];
        }
        (*link)[i] = to;
    }
}

static inline __attribute__((always_inline)) void LANE_TYPE(put_packet, LANES)(RayBlock *b, uint32_t first, VU link, VU cell, VU portals,
                                                                               VF distance, VU way0, VU way1, VU ended_at) {
    memcpy(b->link + first, &link, sizeof link);
    memcpy(b->cell + first, &cell, sizeof cell);
    memcpy(b->portals + first, &portals, sizeof portals);
    memcpy(b->distance + first, &distance, sizeof distance);
    if (b->ways) {
        memcpy(b->way[0] + first, &way0, sizeof way0);
        memcpy(b->way[1] + first, &way1, sizeof way1);
        memcpy(b->place + first, &ended_at, sizeof ended_at);
    }
}
#endif

/* From corner k of a node to the rays' origins, along one axis: one number for the whole packet when they share their origin. */
#if PACKET_EYE
#define FROM(value, o, axis) ALL((value)-eye[axis])
#define EYE_RAYS             , const EyeRays *rays
#else
#define FROM(value, o, axis) ((value) - (o))
#define EYE_RAYS
#endif

/* Rays that leave between corners k and k + 1, as lanes. */
#define LEAVING(node, k)                                                                                                                   \
    (LT(dx * FROM((node)->y[k], oy, 1) - dy * FROM((node)->x[k], ox, 0), none) &                                                           \
     ~LT(dx * FROM((node)->y[(k) + 1], oy, 1) - dy * FROM((node)->x[(k) + 1], ox, 0), none))

static void PACKET_NAME(const EnfRaycaster *r, RayBlock *b EYE_RAYS) {
    const PrismNode *const nodes = r->prisms.nodes;
    const PrismSection *const sections = r->prisms.sections;
    const VF none = ALL(0.0f);
    const VU end = ALL_INDEX(LINK_END), planes = ALL_INDEX(LINK_PLANES);
    uint32_t last_at = LINK_NOTHING, last_k = 0;
    const PrismNode *last_node = NULL;
#if PACKET_EYE
    const float *offset = rays->offset, eye[3] = {b->o[0][0], b->o[1][0], b->o[2][0]};
#else
    for (uint32_t i = b->count; i % LANES; i++) /* the last packet's other lanes */
        b->link[i] = LINK_NOTHING;
#endif
    for (uint32_t first = 0; first < b->count; first += LANES) {
        VU way0 = ALL_INDEX(0), way1 = way0, ended_at = way0;
#if PACKET_EYE
        const VF oz = ALL(eye[2]), limit = ALL(INFINITY), dx = ALL(rays->base[0]) + GET(offset + first);
        const VF dy = ALL(rays->base[1]) + GET(offset + rays->stride + first),
                 dz = ALL(rays->base[2]) + GET(offset + 2 * rays->stride + first);
        VF distance = none;
        VU link = ALL_INDEX(rays->link), cell = ALL_INDEX(rays->cell), portals = way0;
        memcpy(b->d[0] + first, &dx, sizeof dx); /* for the leaders, and the planes */
        memcpy(b->d[1] + first, &dy, sizeof dy);
        memcpy(b->d[2] + first, &dz, sizeof dz);
#else
        const VF dx = GET(b->d[0] + first), dy = GET(b->d[1] + first), dz = GET(b->d[2] + first), limit = GET(b->limit + first);
        const VF ox = GET(b->o[0] + first), oy = GET(b->o[1] + first), oz = GET(b->o[2] + first);
        VF distance = GET(b->distance + first);
        VU link = GET_INDEX(b->link + first), cell = GET_INDEX(b->cell + first), portals = GET_INDEX(b->portals + first);
        if (b->ways)
            way0 = GET_INDEX(b->way[0] + first), way1 = GET_INDEX(b->way[1] + first), ended_at = GET_INDEX(b->place + first);
        call_ahead(b, first);
#endif
        uint32_t up = LT(none, dz), down = LT(dz, none), steps = enf_ray_step_cap(r);
        uint32_t active = ~EQ(link & planes, end) & ((1u << LANES) - 1);
        while (active) {
            uint32_t lane = (uint32_t)__builtin_ctz(active), at = link[lane];
            if (SELDOM(steps == 0)) { /* the cap */
                link = PICK_INDEX(active, ALL_INDEX(LINK_NOTHING), link);
                break;
            }
            if (SELDOM(link_asks_planes(at))) {
                LANE_TYPE(put_packet, LANES)(b, first, link, cell, portals, distance, way0, way1, ended_at);
                enf_ray_block_planes(r, b, first + lane, &steps);
                link = GET_INDEX(b->link + first), cell = GET_INDEX(b->cell + first), portals = GET_INDEX(b->portals + first);
                distance = GET(b->distance + first);
                if (b->ways)
                    way0 = GET_INDEX(b->way[0] + first), way1 = GET_INDEX(b->way[1] + first), ended_at = GET_INDEX(b->place + first);
                active &= ~((uint32_t)((b->link[first + lane] & LINK_PLANES) == LINK_END) << lane);
                continue;
            }
            uint32_t group = active & EQ(link, ALL_INDEX(at));
            steps--;
            while (group) {
                /* neighbours leave by the same section more often than not: the last one is tried before the leader looks for its own */
                const PrismNode *node = at == last_at ? last_node : &nodes[at];
                uint32_t k = last_k, lanes = at == last_at ? group & LEAVING(node, k) : 0;
                if (!lanes) {
                    uint32_t leader = (uint32_t)__builtin_ctz(group), i = first + leader;
                    node = &nodes[at];
                    int leaves = find_section(nodes, &node, b->o[0][i], b->o[1][i], b->d[0][i], b->d[1][i], &k);
                    if (SELDOM(!leaves)) {
                        link = PICK_INDEX(1u << leader, ALL_INDEX(node->next), link);
                        group &= group - 1;
                        continue;
                    }
                    lanes = (group & LEAVING(node, k)) | 1u << leader;
                    last_at = at;
                    last_node = node;
                    last_k = k;
                }
                group &= ~lanes;
                const PrismSection *s = &sections[node->section_first + k];
                VF t = (s->nx * FROM(node->x[k], ox, 0) + s->ny * FROM(node->y[k], oy, 1)) / (s->nx * dx + s->ny * dy), z = oz + t * dz;
                uint32_t above = lanes & up & LT(ALL(node->z[1]), z), below = lanes & down & LT(z, ALL(node->z[0]));
                if (above | below)
                    t = PICK(above | below, (PICK(up, ALL(node->z[1]), ALL(node->z[0])) - oz) / dz, t);
                /* where to: the bands from above, then the caps over them; no branch on what no predictor can know */
                uint32_t in0 = LT(z, ALL(s->height[0])), in1 = LT(z, ALL(s->height[1])), in2 = LT(z, ALL(s->height[2]));
                VU to = PICK_INDEX(in2, ALL_INDEX(s->link[2]), ALL_INDEX(s->link[3]));
                to = PICK_INDEX(in0, ALL_INDEX(s->link[0]), PICK_INDEX(in1, ALL_INDEX(s->link[1]), to));
                to = PICK_INDEX(above, ALL_INDEX(node->cap_link[1]), PICK_INDEX(below, ALL_INDEX(node->cap_link[0]), to));
                uint32_t tall = lanes & EQ(to & ALL_INDEX(LINK_TALL), ALL_INDEX(LINK_TALL));
                VU place = way0;
                if (b->ways) {
                    const uint32_t base = PLACES * (node->section_first + k);
                    place = PICK_INDEX(in2, ALL_INDEX(base + 2), ALL_INDEX(base + 3));
                    place = PICK_INDEX(in0, ALL_INDEX(base), PICK_INDEX(in1, ALL_INDEX(base + 1), place));
                }
                if (SELDOM(tall))
                    LANE_TYPE(ask_towers, LANES)(sections, tall, z, &to, &place);
                /* openings of all shapes ask the planes of this cell: no distance, no limit yet */
                uint32_t stays = lanes & EQ(to, ALL_INDEX(LINK_PLANES | node->cell));
                to = PICK_INDEX(~stays & ~LT(t, limit), ALL_INDEX(LINK_NOTHING), to);
                uint32_t ended = lanes & EQ(to & planes, end);
                distance = PICK(lanes & ~stays, t, distance);
                cell = PICK_INDEX(lanes, ALL_INDEX(node->cell), cell);
                portals = PICK_INDEX(lanes & ~stays & ~ended, portals + 1, portals);
                if (b->ways) {
                    place = PICK_INDEX(above, ALL_INDEX(PLACES * node->cell + PLACE_CAP + 1), place);
                    place = PICK_INDEX(below, ALL_INDEX(PLACES * node->cell + PLACE_CAP), place);
                    ended_at = PICK_INDEX(lanes, place, ended_at);
                    way0 = PICK_INDEX(lanes & ~stays & ~ended, WAY_STEP(way0, place, 0), way0);
                    way1 = PICK_INDEX(lanes & ~stays & ~ended, WAY_STEP(way1, place, 1), way1);
                }
                if (b->targets) {
                    uint32_t there = lanes & EQ(GET_INDEX(b->target + first), to);
                    to = PICK_INDEX(there, ALL_INDEX(LINK_NOTHING), to);
                    ended |= there;
                }
                link = PICK_INDEX(lanes, to, link);
                active &= ~ended;
            }
        }
#if PACKET_EYE
        /* as finish() does */
        const VU kind = link & ALL_INDEX(LINK_TALL), number = link & ALL_INDEX(LINK_SURFACE);
        uint32_t nothing = ~EQ(kind, end), out = nothing & ~EQ(link, ALL_INDEX(LINK_NOTHING));
        distance = PICK(nothing, ALL(INFINITY), PICK(LT(distance, none), none, distance));
        cell = PICK_INDEX(out, number, cell);
        portals = PICK_INDEX(out, portals + 1, portals);
        link = PICK_INDEX(nothing, ALL_INDEX(ENF_NONE), number);
#endif
        LANE_TYPE(put_packet, LANES)(b, first, link, cell, portals, distance, way0, way1, ended_at);
    }
}
#undef FROM
#undef EYE_RAYS
#undef LEAVING

#undef VF
#undef LT
#undef EQ
#undef GET
#undef ALL
#undef PICK
#undef VU
#undef GET_INDEX
#undef ALL_INDEX
#undef PICK_INDEX
