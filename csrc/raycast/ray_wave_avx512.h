/* SPDX-License-Identifier: GPL-3.0-or-later
 * Waves: rays that go their own ways, sixteen at a time. Included by ray_kernel_avx512.c.
 *
 * Each ray's exit is found by its sixteen corner signs as for single rays; what comes after it is done for sixteen rays at once, their
 * sections' numbers gathered. Rays that go on move up, so that registers stay full. */
#ifndef ENF_RAYCAST_RAY_WAVE_AVX512_H
#define ENF_RAYCAST_RAY_WAVE_AVX512_H

#include <stddef.h>

enum { NODE_WORDS = sizeof(PrismNode) / 4, SECTION_WORDS = sizeof(PrismSection) / 4 };
#define WORD_OF(type, field) ((int)(offsetof(type, field) / 4))

INLINE __m512 gather(const void *base, __m512i words, int more) {
    return _mm512_i32gather_ps(_mm512_add_epi32(words, _mm512_set1_epi32(more)), base, 4);
}
INLINE __m512i gather_index(const void *base, __m512i words, int more) {
    return _mm512_i32gather_epi32(_mm512_add_epi32(words, _mm512_set1_epi32(more)), base, 4);
}

/* The exits of rays[0 .. count - 1]: node and section in it. Gives the lanes that have one; the others' links become their cells' planes. */
INLINE uint32_t find_exits(const PrismModel *m, RayBlock *b, const uint32_t *rays, uint32_t count, uint32_t nodes[16],
                           uint32_t sections[16]) {
    uint32_t found = 0;
    for (uint32_t lane = 0; lane < count; lane++) {
        uint32_t i = rays[lane];
        const PrismNode *node = &m->nodes[b->link[i]];
        const int leaves = find_section(m->nodes, &node, b->o[0][i], b->o[1][i], b->d[0][i], b->d[1][i], &sections[lane]);
        nodes[lane] = (uint32_t)(node - m->nodes);
        found |= (uint32_t)leaves << lane;
        if (SELDOM(!leaves)) {
            b->link[i] = node->next;
            b->cell[i] = node->cell;
        }
    }
    return found;
}

/* A step of up to sixteen rays. */
INLINE void step_rays(const PrismModel *m, RayBlock *b, const uint32_t *rays, uint32_t count) {
    uint32_t at[16] = {0}, exits[16] = {0};
    const __mmask16 lanes = (__mmask16)find_exits(m, b, rays, count, at, exits);
    const __m512i i = _mm512_maskz_loadu_epi32((__mmask16)((1u << count) - 1), rays), k = _mm512_loadu_si512(exits);
    const __m512i node = _mm512_mullo_epi32(_mm512_loadu_si512(at), _mm512_set1_epi32(NODE_WORDS));
    const __m512 ox = gather(b->o[0], i, 0), oy = gather(b->o[1], i, 0), oz = gather(b->o[2], i, 0), none = _mm512_setzero_ps();
    const __m512 dx = gather(b->d[0], i, 0), dy = gather(b->d[1], i, 0), dz = gather(b->d[2], i, 0), limit = gather(b->limit, i, 0);
    const __m512i corner = _mm512_add_epi32(node, k);
    const __m512i section = _mm512_mullo_epi32(_mm512_add_epi32(gather_index(m->nodes, node, WORD_OF(PrismNode, section_first)), k),
                                               _mm512_set1_epi32(SECTION_WORDS));
    const __m512 nx = gather(m->sections, section, WORD_OF(PrismSection, nx)), ny = gather(m->sections, section, WORD_OF(PrismSection, ny));
    const __m512 x = gather(m->nodes, corner, WORD_OF(PrismNode, x)), y = gather(m->nodes, corner, WORD_OF(PrismNode, y));
    __m512 t = (nx * (x - ox) + ny * (y - oy)) / (nx * dx + ny * dy), z = oz + t * dz;
    const __mmask16 up = _mm512_cmp_ps_mask(none, dz, _CMP_LT_OQ), down = _mm512_cmp_ps_mask(dz, none, _CMP_LT_OQ);
    const __m512i end = _mm512_mask_add_epi32(node, up, node, _mm512_set1_epi32(1)); /* floor or ceiling */
    const __m512 cap_z = gather(m->nodes, end, WORD_OF(PrismNode, z));
    const __mmask16 cap = (__mmask16)((up & _mm512_cmp_ps_mask(cap_z, z, _CMP_LT_OQ)) | (down & _mm512_cmp_ps_mask(z, cap_z, _CMP_LT_OQ)));
    __m512i band = section;
    for (int height = 0; height < SECTION_HEIGHTS; height++) {
        __mmask16 below = _mm512_cmp_ps_mask(z, gather(m->sections, section, WORD_OF(PrismSection, height) + height), _CMP_NLT_UQ);
        band = _mm512_mask_add_epi32(band, below, band, _mm512_set1_epi32(1));
    }
    __m512i link = gather_index(m->sections, band, WORD_OF(PrismSection, link));
    uint32_t tall = number16(_mm512_mask_cmpge_epu32_mask(lanes, link, _mm512_set1_epi32((int)LINK_TALL)));
    if (SELDOM(tall != 0)) {
        vu16 links = (vu16)link;
        vu16 unused = {0};
        ask_towers16(m->sections, tall, z, &links, &unused);
        link = (__m512i)links;
    }
    link = _mm512_mask_blend_epi32(cap, link, gather_index(m->nodes, end, WORD_OF(PrismNode, cap_link)));
    t = _mm512_mask_blend_ps(cap, t, (cap_z - oz) / dz);
    const __m512i cell = gather_index(m->nodes, node, WORD_OF(PrismNode, cell)), kind = _mm512_set1_epi32((int)LINK_PLANES);
    const __m512i over = _mm512_set1_epi32((int)LINK_NOTHING);
    /* openings of all shapes ask the planes of the same cell: no distance, no limit yet */
    const __mmask16 moves = (__mmask16)(lanes & _mm512_cmpneq_epi32_mask(link, _mm512_or_si512(kind, cell)));
    link = _mm512_mask_mov_epi32(link, (__mmask16)(moves & _mm512_cmp_ps_mask(t, limit, _CMP_NLT_UQ)), over);
    const __mmask16 on = (__mmask16)(moves & _mm512_cmpneq_epi32_mask(_mm512_and_si512(link, kind), _mm512_set1_epi32((int)LINK_END)));
    if (b->targets)
        link = _mm512_mask_mov_epi32(link, (__mmask16)(lanes & _mm512_cmpeq_epi32_mask(link, gather_index(b->target, i, 0))), over);
    _mm512_mask_i32scatter_ps(b->distance, moves, i, t, 4);
    _mm512_mask_i32scatter_epi32(b->link, lanes, i, link, 4);
    _mm512_mask_i32scatter_epi32(b->cell, lanes, i, cell, 4);
    _mm512_mask_i32scatter_epi32(b->portals, on, i, _mm512_add_epi32(gather_index(b->portals, i, 0), _mm512_set1_epi32(1)), 4);
}

static void run_wave(const EnfRaycaster *r, RayBlock *b) {
    const PrismModel m = r->prisms;
    uint32_t active[RAY_BLOCK + 1], count = b->count;
    for (uint32_t i = 0; i < count; i++)
        active[i] = i;
    /* first who isn't in a prism, then a step of all who are: until none is left, or the cap */
    for (uint32_t pass = enf_ray_step_cap(r); count > 0 && pass > 0; pass--) {
        uint32_t kept = 0;
        for (uint32_t j = 0; j < count; j++) {
            uint32_t i = active[j], steps = pass;
            if (SELDOM(link_asks_planes(b->link[i])))
                enf_ray_block_planes(r, b, i, &steps);
            active[kept] = i;
            kept += b->link[i] < LINK_END;
        }
        count = kept;
        for (uint32_t j = 0; j < count; j += 16) {
            call_ahead(b, active[j] & ~15u);
            step_rays(&m, b, active + j, count - j < 16 ? count - j : 16);
        }
    }
    for (uint32_t j = 0; j < count; j++)
        if (b->link[active[j]] < LINK_END || link_asks_planes(b->link[active[j]]))
            b->link[active[j]] = LINK_NOTHING; /* the cap */
}

#endif
