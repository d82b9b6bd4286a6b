/* SPDX-License-Identifier: GPL-3.0-or-later
 * Packets: LANES rays that go alike. Included by ray_kernel_body.h, once a width.
 *
 * The leader's exit is found by its sixteen corner signs; then all rays of the packet in the same cell are asked about that one section
 * at once, with the section's numbers the same for all lanes: nothing is gathered. */

#define VF        LANE_TYPE(vf, LANES)
#define LT        LANE_TYPE(lanes_lt, LANES)
#define EQ        LANE_TYPE(lanes_eq, LANES)
#define PUT       LANE_TYPE(lanes_put, LANES)
#define PUT_INDEX LANE_TYPE(lanes_put_index, LANES)
#define ADD_ONE   LANE_TYPE(lanes_add_one, LANES)
#define GET       LANE_TYPE(lanes_get, LANES)
#define ALL       LANE_TYPE(lanes_all, LANES)
#define PICK      LANE_TYPE(lanes_pick, LANES)
#define LIVE      LANE_TYPE(lanes_live, LANES)

/* These lanes go on by `link`, their way longer by `way`; gives those that ended. */
static inline __attribute__((always_inline)) uint32_t LANE_TYPE(send, LANES)(const RayBlock *b, uint32_t first, uint32_t lanes,
                                                                             uint32_t link, const PrismNode *node, uint64_t way) {
    if (!lanes)
        return 0;
    if (b->way)
        for (uint32_t left = lanes; left; left &= left - 1) {
            uint64_t *at = &b->way[first + (uint32_t)__builtin_ctz(left)];
            *at = enf_ray_way(*at, way);
        }
    PUT_INDEX(b->link + first, lanes, link);
    if ((link & LINK_PLANES) == LINK_END) {
        PUT_INDEX(b->cell + first, lanes, node->cell);
        return lanes;
    }
    if (link < LINK_END || (link & LINK_INDEX) != node->cell)
        ADD_ONE(b->portals + first, lanes);
    if (!b->target)
        return 0;
    uint32_t there = lanes & EQ(b->target + first, link);
    if (there) {
        PUT_INDEX(b->link + first, there, LINK_NOTHING);
        PUT_INDEX(b->cell + first, there, node->cell);
    }
    return there;
}

static void PACKET_NAME(const EnfRaycaster *r, const RayBlock *b) {
    const PrismModel *m = &r->prisms;
    uint32_t first = 0;
    for (; first + LANES <= b->count; first += LANES) {
        VF ox = GET(b->ox + first), oy = GET(b->oy + first), oz = GET(b->oz + first);
        VF dx = GET(b->dx + first), dy = GET(b->dy + first), dz = GET(b->dz + first), limit = GET(b->limit + first), none = ALL(0.0f);
        uint32_t up = LT(none, dz), down = LT(dz, none), active = LIVE(b->link + first), steps = enf_ray_step_cap(r);
        while (active) {
            uint32_t lane = (uint32_t)__builtin_ctz(active), at = b->link[first + lane];
            if (steps == 0) { /* the cap */
                PUT_INDEX(b->link + first, active, LINK_NOTHING);
                break;
            }
            if (link_asks_planes(at)) {
                enf_ray_block_planes(r, b, first + lane, &steps);
                active &= ~((uint32_t)((b->link[first + lane] & LINK_PLANES) == LINK_END) << lane);
                continue;
            }
            uint32_t group = active & EQ(b->link + first, at);
            steps--;
            while (group) {
                uint32_t leader = (uint32_t)__builtin_ctz(group), i = first + leader, k;
                const PrismNode *node = &m->nodes[at];
                while ((k = first_exit(node, b->ox[i], b->oy[i], b->dx[i], b->dy[i])) == PRISM_CHUNK - 1 && node->next < LINK_END)
                    node = &m->nodes[node->next];
                if (k == PRISM_CHUNK - 1) {
                    b->link[i] = node->next;
                    group &= group - 1;
                    continue;
                }
                const PrismSection *s = &m->sections[node->section_first + k];
                VF x0 = node->x[k] - ox, y0 = node->y[k] - oy;
                VF side0 = dx * y0 - dy * x0, side1 = dx * (node->y[k + 1] - oy) - dy * (node->x[k + 1] - ox);
                uint32_t lanes = (group & LT(side0, none) & ~LT(side1, none)) | 1u << leader;
                VF t = (s->nx * x0 + s->ny * y0) / (s->nx * dx + s->ny * dy), z = oz + t * dz;
                uint32_t above = lanes & up & LT(ALL(node->z[1]), z), below = lanes & down & LT(z, ALL(node->z[0]));
                if (above | below) {
                    VF cap_z = PICK(up, ALL(node->z[1]), ALL(node->z[0]));
                    t = PICK(above | below, (cap_z - oz) / dz, t);
                }
                group &= ~lanes;
                /* a cap or side with openings of all shapes asks the planes of this cell: no distance, no limit yet */
                uint32_t asks = LINK_PLANES | node->cell;
                uint32_t passed = lanes & ~((node->cap_link[1] == asks ? above : 0) | (node->cap_link[0] == asks ? below : 0) |
                                            (s->link[0] == asks ? ~(above | below) : 0));
                uint32_t over = passed & ~LT(t, limit);
                PUT(b->distance + first, passed, t);
                lanes &= ~over;
                uint32_t ended = LANE_TYPE(send, LANES)(b, first, over, LINK_NOTHING, node, 0);
                ended |=
                    LANE_TYPE(send, LANES)(b, first, lanes & above, node->cap_link[1], node, 8 * (uint64_t)(node->section_first + k) + 4);
                ended |=
                    LANE_TYPE(send, LANES)(b, first, lanes & below, node->cap_link[0], node, 8 * (uint64_t)(node->section_first + k) + 5);
                struct {
                    uint32_t section, lanes;
                } towers[32] = {
                    {node->section_first + k, lanes & ~(above | below)}}; /* sections that others lead to: four a level at most */
                for (uint32_t left = 1; left-- > 0;) {
                    uint32_t at_section = towers[left].section, sides = towers[left].lanes;
                    const PrismSection *tower = &m->sections[at_section];
                    uint32_t inner = LT(z, ALL(tower->height[0])), middle = LT(z, ALL(tower->height[1])),
                             outer = LT(z, ALL(tower->height[2]));
                    uint32_t bands[SECTION_HEIGHTS + 1] = {sides & inner, sides & ~inner & middle, sides & ~inner & ~middle & outer,
                                                           sides & ~inner & ~middle & ~outer};
                    for (uint32_t band = 0; band <= SECTION_HEIGHTS; band++) {
                        if (tower->link[band] < LINK_TALL)
                            ended |=
                                LANE_TYPE(send, LANES)(b, first, bands[band], tower->link[band], node, 8 * (uint64_t)at_section + band);
                        else if (bands[band]) {
                            towers[left].section = tower->link[band] & LINK_SECTION;
                            towers[left++].lanes = bands[band];
                        }
                    }
                }
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
#undef LIVE
