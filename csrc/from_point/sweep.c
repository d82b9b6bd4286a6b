/* SPDX-License-Identifier: GPL-3.0-or-later
 * The sweep: an eye outdoors, all windows in its view at once. Nothing is taken to hide anything outdoors, so no apertures are
 * made: a window shows what its vista has at the slopes under which the eye sees it.
 *
 * Safe direction: slopes are widened by their rounding; an eye so near to a window's plane that they aren't known sees all it can show. */
#include "from_point/aperture_planes.h"
#include "from_point/arrival.h"
#include "from_point/vista.h"

#include "base/simd.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

#include <math.h>
#include <string.h>

/* Slopes under which the eye sees a window, as keys: x, y. */
typedef struct SlopeKeys {
    int16_t lo[2], hi[2];
} SlopeKeys;

typedef struct Sweep {
    EnfView *view;
    const struct EnfVistas *vistas;
    const EnfFacade *facade;
    float eye[3], margin; /* in the facade's frame; of its coordinates' rounding */
    int shut;             /* some opening is */
    int complete;
} Sweep;

#ifdef __GNUC__
#define ENF_ALWAYS_INLINE inline __attribute__((always_inline))
#else
#define ENF_ALWAYS_INLINE inline
#endif

/* ---- Slopes ---------------------------------------------------------------------------------------------------------------------- */
/* Under which the eye sees eight windows; infinite where its distance from their planes is lost in rounding. Bit k: window k looks at
 * the eye. */
static uint32_t slopes_scalar(const EnfWindows8 *w, const float eye[3], float m, SlopeKeys keys[8]) {
    const float *edges[4] = {w->x0, w->y0, w->x1, w->y1};
    uint32_t facing = 0;
    for (int i = 0; i < 8; i++) {
        /* Numerators and the distance are both off by m at most: (x +- m) / (away +- m). */
        const float away = w->z[i] - eye[2], inverse = 1.0f / away, off = 2 * m * inverse;
        const int known = away > 8 * m;
        facing |= (uint32_t)(away > -m) << i;
        for (int k = 0; k < 4; k++) {
            float slope = (edges[k][i] - eye[k % 2]) * inverse, wide = off * fabsf(slope);
            wide = wide + off;
            slope = k < 2 ? slope - wide : slope + wide;
            *(k < 2 ? &keys[i].lo[k] : &keys[i].hi[k - 2]) = enf_slope_key(known ? slope : k < 2 ? -INFINITY : INFINITY);
        }
    }
    return facing;
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2,bmi"))) static inline uint32_t slopes_avx2(const EnfWindows8 *w, const float eye[3], float m,
                                                                       SlopeKeys keys[8]) {
    const float *edges[4] = {w->x0, w->y0, w->x1, w->y1};
    const __m256 away = _mm256_sub_ps(_mm256_loadu_ps(w->z), _mm256_set1_ps(eye[2])), sign = _mm256_set1_ps(-0.0f);
    const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1.0f), away), off = _mm256_mul_ps(_mm256_set1_ps(2 * m), inverse);
    const __m256 known = _mm256_cmp_ps(away, _mm256_set1_ps(8 * m), _CMP_GT_OQ);
    __m256i bits[4];
    for (int k = 0; k < 4; k++) {
        __m256 slope = _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(edges[k]), _mm256_set1_ps(eye[k % 2])), inverse);
        __m256 wide = _mm256_add_ps(_mm256_mul_ps(off, _mm256_andnot_ps(sign, slope)), off);
        slope = k < 2 ? _mm256_sub_ps(slope, wide) : _mm256_add_ps(slope, wide);
        bits[k] = _mm256_castps_si256(_mm256_blendv_ps(_mm256_set1_ps(k < 2 ? -INFINITY : INFINITY), slope, known));
        bits[k] = _mm256_xor_si256(bits[k], _mm256_srli_epi32(_mm256_srai_epi32(bits[k], 31), 1)); /* enf_slope_key's order */
    }
    /* The leading halves, x beside y; then lo beside hi, window by window. */
    const __m256i lo = _mm256_blend_epi16(_mm256_srli_epi32(bits[0], 16), bits[1], 0xAA);
    const __m256i hi = _mm256_blend_epi16(_mm256_srli_epi32(bits[2], 16), bits[3], 0xAA);
    const __m256i even = _mm256_unpacklo_epi32(lo, hi), odd = _mm256_unpackhi_epi32(lo, hi); /* windows 0, 1, 4, 5 and 2, 3, 6, 7 */
    _mm256_storeu_si256((__m256i *)&keys[0], _mm256_permute2x128_si256(even, odd, 0x20));
    _mm256_storeu_si256((__m256i *)&keys[4], _mm256_permute2x128_si256(even, odd, 0x31));
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(away, _mm256_set1_ps(-m), _CMP_GT_OQ));
}
#endif

/* Which of sixteen rectangles of slopes overlap this one. */
static uint32_t overlaps_scalar(const EnfSlopes16 *s, const SlopeKeys *keys) {
    uint32_t mask = 0;
    for (int i = 0; i < ENF_SLOPE_LANES; i++)
        mask |=
            (uint32_t)(s->lo[0][i] <= keys->hi[0] && s->hi[0][i] >= keys->lo[0] && s->lo[1][i] <= keys->hi[1] && s->hi[1][i] >= keys->lo[1])
            << i;
    return mask;
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2,bmi"))) static inline uint32_t overlaps_avx2(const EnfSlopes16 *s, const SlopeKeys *keys) {
    __m256i apart = _mm256_setzero_si256();
    for (int k = 0; k < 2; k++) {
        __m256i above = _mm256_cmpgt_epi16(_mm256_loadu_si256((const __m256i *)s->lo[k]), _mm256_set1_epi16(keys->hi[k]));
        __m256i below = _mm256_cmpgt_epi16(_mm256_set1_epi16(keys->lo[k]), _mm256_loadu_si256((const __m256i *)s->hi[k]));
        apart = _mm256_or_si256(apart, _mm256_or_si256(above, below));
    }
    __m128i packed = _mm_packs_epi16(_mm256_castsi256_si128(apart), _mm256_extracti128_si256(apart, 1));
    return (uint32_t)_mm_movemask_epi8(packed) ^ 0xFFFF;
}
#endif

/* ---- What a window shows ------------------------------------------------------------------------------------------------------------ */
/* Takes from sixteen items those behind shut openings. reached: stages of this window, a bit each from first_slot on; grows where the
 * items are its cells. Rectangles of slopes lie within those of their stages, so that nothing else has to be asked of these. */
static uint32_t drop_shut(const Sweep *sweep, const EnfVistaItems *list, uint32_t first_slot, uint32_t block, uint32_t mask,
                          uint16_t *reached) {
    const struct EnfVistas *vistas = sweep->vistas;
    const uint8_t *shut = sweep->view->index->scene->opening_shut;
    for (uint32_t left = mask; left; left &= left - 1) {
        const uint32_t lane = enf_lowest_bit(left), slot = block * ENF_SLOPE_LANES + lane, stage = list->stages[slot] - first_slot;
        const int is_cell = list == &vistas->cells;
        int open = (is_cell && slot == first_slot) || (reached[stage / ENF_SLOPE_LANES] >> stage % ENF_SLOPE_LANES & 1);
        if (is_cell && open) {
            open = vistas->openings[slot] == ENF_NONE || !shut[vistas->openings[slot]];
            reached[(slot - first_slot) / ENF_SLOPE_LANES] |= (uint16_t)(open << lane);
        }
        mask &= ~((uint32_t)!open << lane);
    }
    return mask;
}

/* Where answers go: `count` of them so far. */
typedef struct Answer {
    uint32_t *seen, *out, *out_step, count;
} Answer;

static ENF_ALWAYS_INLINE void add_items(const Sweep *sweep, const EnfVistaItems *list, uint32_t first_block, uint32_t item_count,
                                        const SlopeKeys *keys, int simd, uint32_t first_slot, uint16_t *reached, Answer *answer) {
    const uint32_t query = sweep->view->query;
    uint32_t *seen = answer->seen, *out = answer->out, *out_step = answer->out_step, count = answer->count;
    for (uint32_t block = first_block, end = first_block + (item_count + ENF_SLOPE_LANES - 1) / ENF_SLOPE_LANES; block < end; block++) {
#ifdef ENF_HAVE_AVX2
        uint32_t mask = simd ? overlaps_avx2(&list->slopes[block], keys) : overlaps_scalar(&list->slopes[block], keys);
#else
        uint32_t mask = overlaps_scalar(&list->slopes[block], keys);
#endif
        if (sweep->shut)
            mask = drop_shut(sweep, list, first_slot, block, mask, reached);
        for (; mask; mask &= mask - 1) {
            const uint32_t slot = block * ENF_SLOPE_LANES + enf_lowest_bit(mask), id = list->ids[slot];
            /* Written in any case, counted when it is new: nobody can foretell which are. */
            out[count] = id;
            out_step[count] = ENF_STEP_SWEPT | slot;
            count += seen[id] != query;
            seen[id] = query;
        }
    }
    answer->count = count;
}

/* Windows of a block. Compiled twice: wide or not is known inside of either. */
static ENF_ALWAYS_INLINE int look_through(Sweep *sweep, uint32_t block, uint32_t mask, int simd) {
    EnfView *view = sweep->view;
    const struct EnfVistas *vistas = sweep->vistas;
    const uint32_t first = sweep->facade->vista_first + block * 8;
    SlopeKeys keys[8];
#ifdef ENF_HAVE_AVX2
    mask &= simd ? slopes_avx2(&vistas->windows[first / 8], sweep->eye, sweep->margin, keys)
                 : slopes_scalar(&vistas->windows[first / 8], sweep->eye, sweep->margin, keys);
#else
    mask &= slopes_scalar(&vistas->windows[first / 8], sweep->eye, sweep->margin, keys);
#endif
    Answer cells = {view->cell_seen, view->answer.cells, view->cell_step, view->answer.cell_count};
    Answer objects = {view->object_seen, view->answer.objects, view->object_step, view->answer.object_count};
    const int want_objects = (int)view->def.want_objects;
    for (mask &= 0xFF; mask; mask &= mask - 1) {
        const uint32_t lane = enf_lowest_bit(mask);
        const EnfVista *vista = &vistas->vistas[first + lane];
        const uint32_t first_slot = vista->cell_block * ENF_SLOPE_LANES;
        uint16_t reached[ENF_VISTA_STAGES / ENF_SLOPE_LANES];
        if (!vista->complete) {
            sweep->complete = 0;
            break;
        }
        if (sweep->shut)
            memset(reached, 0, sizeof reached);
        add_items(sweep, &vistas->cells, vista->cell_block, vista->cell_count, &keys[lane], simd, first_slot, reached, &cells);
        if (want_objects)
            add_items(sweep, &vistas->objects, vista->object_block, vista->object_count, &keys[lane], simd, first_slot, reached, &objects);
        view->stats.windows++;
        view->stats.objects_tested += vista->object_count;
        view->stats.work += vista->work;
    }
    view->answer.cell_count = cells.count;
    view->answer.object_count = objects.count;
    return sweep->complete && !enf_over_budget(view);
}

static int look_through_plain(void *user, uint32_t block, uint32_t mask) {
    return look_through(user, block, mask, 0);
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2,bmi"))) static int look_through_avx2(void *user, uint32_t block, uint32_t mask) {
    return look_through(user, block, mask, 1);
}
#else
#define look_through_avx2 look_through_plain
#endif

/* ---- All windows -------------------------------------------------------------------------------------------------------------------- */
static void sweep_facade(Sweep *sweep, const EnfFacade *f, const EnfPlanes *planes, EnfBoxesTest test, EnfTreeLeaf look) {
    double q[3];
    vec_sub(q, sweep->view->screens.eyes[0], f->corner);
    const double z = vec_dot(f->n, q);
    /* Eye and windows in single precision and their difference are off by 6e-8 of their size each; thrice that to spare for what is
     * computed of them. */
    const double margin = f->slack + 4e-7 * (f->reach + fabs(q[0]) + fabs(q[1]) + fabs(q[2]));
    if (z > f->farthest + margin)
        return;
    sweep->facade = f;
    sweep->eye[0] = (float)vec_dot(f->u, q);
    sweep->eye[1] = (float)vec_dot(f->v, q);
    sweep->eye[2] = (float)z;
    sweep->margin = (float)margin;
    uint32_t blocks = (f->tree.item_count + 7) / 8;
    if (enf_box_within(planes, f->centre, f->half)) {
        for (uint32_t b = 0; b < blocks && look(sweep, b, 0xFF); b++) {
        }
    } else
        blocks = enf_tree_query(sweep->vistas->boxes, &f->tree, planes, test, look, sweep);
    sweep->view->stats.work += ENF_WORK_BLOCK * (1 + blocks);
}

EnfStatus enf_sweep(EnfView *view, const EnfScreen *screen, int *out_done) {
    const struct EnfVistas *vistas = view->index->vistas;
    const int simd = view->def.use_simd && enf_processor_avx2();
    Sweep sweep = {.view = view, .vistas = vistas, .shut = view->index->scene->shut_count > 0, .complete = 1};
    const EnfBoxesTest test = enf_boxes_test((int)view->def.use_simd);
    EnfPlanes for_objects, for_windows;
    if (view->sweep_root == ENF_NONE || view->step_cell[view->sweep_root] != view->start_cells[0]) {
        EnfStatus status = enf_sweep_steps(view); /* of a camera before this one, in another cell */
        if (status != ENF_OK)
            return status;
        if (!enf_arrival_room(view, 1))
            return enf_fail_memory();
        view->sweep_root = enf_make_step(view, view->start_cells[0], ENF_NONE, ENF_NONE);
    }
    enf_screen_planes(view, screen, &for_objects, &for_windows);
    enf_cull_outdoors(view, &for_objects, &for_windows);
    for (uint32_t i = 0; i < vistas->facade_count && sweep.complete && !enf_over_budget(view); i++)
        sweep_facade(&sweep, &vistas->facades[i], &for_windows, test, simd ? look_through_avx2 : look_through_plain);
    *out_done = sweep.complete && !enf_over_budget(view);
    view->stats.swept += *out_done != 0;
    return ENF_OK;
}

/* ---- The why ------------------------------------------------------------------------------------------------------------------------- */
/* made: by slot, the step that leads there; ENF_NONE: none yet. */
static EnfStatus step_to(EnfView *view, uint32_t slot, uint32_t *made, uint32_t *out_step) {
    const struct EnfVistas *vistas = view->index->vistas;
    uint32_t row[ENF_VISTA_STAGES], count = 0, step = view->sweep_root;
    while (made[slot] == ENF_NONE) {
        row[count++] = slot;
        if (vistas->cells.stages[slot] == slot)
            break;
        slot = vistas->cells.stages[slot];
    }
    if (made[slot] != ENF_NONE)
        step = made[slot];
    if (!enf_arrival_room(view, count))
        return enf_fail_memory();
    while (count-- > 0)
        made[row[count]] = step = enf_make_step(view, vistas->cells.ids[row[count]], vistas->portals[row[count]], step);
    *out_step = step;
    return ENF_OK;
}

EnfStatus enf_sweep_steps(EnfView *view) {
    if (view->sweep_root == ENF_NONE)
        return ENF_OK;
    const struct EnfVistas *vistas = view->index->vistas;
    const uint64_t slots = (uint64_t)vistas->cells.block_count * ENF_SLOPE_LANES;
    uint32_t *made = ENF_NEW(uint32_t, slots);
    EnfStatus status = made ? ENF_OK : enf_fail_memory();
    if (made)
        memset(made, 0xFF, slots * sizeof *made);
    for (uint32_t i = 0; i < view->answer.cell_count && status == ENF_OK; i++)
        if (view->cell_step[i] != ENF_NONE && view->cell_step[i] & ENF_STEP_SWEPT)
            status = step_to(view, view->cell_step[i] & ~ENF_STEP_SWEPT, made, &view->cell_step[i]);
    for (uint32_t i = 0; i < view->answer.object_count && status == ENF_OK; i++)
        if (view->object_step[i] != ENF_NONE && view->object_step[i] & ENF_STEP_SWEPT)
            status = step_to(view, vistas->objects.stages[view->object_step[i] & ~ENF_STEP_SWEPT], made, &view->object_step[i]);
    enf_free(made);
    if (status == ENF_OK)
        view->sweep_root = ENF_NONE;
    return status;
}
