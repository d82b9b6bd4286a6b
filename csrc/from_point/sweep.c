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

typedef struct Sweep {
    EnfView *view;
    const struct EnfVistas *vistas;
    const EnfFacade *facade;
    float eye[3], margin; /* in the facade's frame; of its coordinates' rounding */
    int simd, failed;
} Sweep;

/* Slopes under which the eye sees eight windows: lo x, lo y, hi x, hi y; infinite where its distance from their planes is lost in
 * rounding. Bit k: window k looks at the eye. */
static uint32_t slopes_scalar(const EnfWindows8 *w, const float eye[3], float m, float s[4][8]) {
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
            s[k][i] = known ? slope : k < 2 ? -INFINITY : INFINITY;
        }
    }
    return facing;
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2"))) static uint32_t slopes_avx2(const EnfWindows8 *w, const float eye[3], float m, float s[4][8]) {
    const float *edges[4] = {w->x0, w->y0, w->x1, w->y1};
    const __m256 away = _mm256_sub_ps(_mm256_loadu_ps(w->z), _mm256_set1_ps(eye[2])), sign = _mm256_set1_ps(-0.0f);
    const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1.0f), away), off = _mm256_mul_ps(_mm256_set1_ps(2 * m), inverse);
    const __m256 known = _mm256_cmp_ps(away, _mm256_set1_ps(8 * m), _CMP_GT_OQ);
    for (int k = 0; k < 4; k++) {
        __m256 slope = _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(edges[k]), _mm256_set1_ps(eye[k % 2])), inverse);
        __m256 wide = _mm256_add_ps(_mm256_mul_ps(off, _mm256_andnot_ps(sign, slope)), off);
        slope = k < 2 ? _mm256_sub_ps(slope, wide) : _mm256_add_ps(slope, wide);
        _mm256_storeu_ps(s[k], _mm256_blendv_ps(_mm256_set1_ps(k < 2 ? -INFINITY : INFINITY), slope, known));
    }
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(away, _mm256_set1_ps(-m), _CMP_GT_OQ));
}
#endif

static uint32_t slopes_to(const Sweep *sweep, const EnfWindows8 *w, float s[4][8]) {
#ifdef ENF_HAVE_AVX2
    if (sweep->simd)
        return slopes_avx2(w, sweep->eye, sweep->margin, s);
#endif
    return slopes_scalar(w, sweep->eye, sweep->margin, s);
}

#ifdef __GNUC__
#define ENF_ALWAYS_INLINE inline __attribute__((always_inline))
#else
#define ENF_ALWAYS_INLINE inline
#endif

/* Which of 32 rectangles of slopes, two blocks, overlap this one. */
static uint32_t overlaps_scalar(const EnfSlopes16 *s, const int16_t lo[2], const int16_t hi[2]) {
    uint32_t mask = 0;
    for (int i = 0; i < 2 * ENF_SLOPE_LANES; i++) {
        const EnfSlopes16 *b = &s[i / ENF_SLOPE_LANES];
        const int k = i % ENF_SLOPE_LANES;
        mask |= (uint32_t)(b->lo[0][k] <= hi[0] && b->hi[0][k] >= lo[0] && b->lo[1][k] <= hi[1] && b->hi[1][k] >= lo[1]) << i;
    }
    return mask;
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2,bmi"))) static inline uint32_t overlaps_avx2(const EnfSlopes16 *s, const int16_t lo[2], const int16_t hi[2]) {
    __m256i apart[2] = {_mm256_setzero_si256(), _mm256_setzero_si256()};
    for (int k = 0; k < 2; k++) {
        const __m256i least = _mm256_set1_epi16(lo[k]), most = _mm256_set1_epi16(hi[k]);
        for (int b = 0; b < 2; b++) {
            __m256i above = _mm256_cmpgt_epi16(_mm256_loadu_si256((const __m256i *)s[b].lo[k]), most);
            __m256i below = _mm256_cmpgt_epi16(least, _mm256_loadu_si256((const __m256i *)s[b].hi[k]));
            apart[b] = _mm256_or_si256(apart[b], _mm256_or_si256(above, below));
        }
    }
    /* Packing goes by halves: 0-7 of both, then 8-15 of both. */
    __m256i packed = _mm256_permute4x64_epi64(_mm256_packs_epi16(apart[0], apart[1]), 0xD8);
    return ~(uint32_t)_mm256_movemask_epi8(packed);
}
#endif

/* Of the first `count` there. */
static ENF_ALWAYS_INLINE uint32_t overlaps(int simd, const EnfSlopes16 *s, uint32_t count, const EnfWindowGlimpse *g) {
    const uint32_t there = count < 32 ? (1u << count) - 1 : ~0u;
#ifdef ENF_HAVE_AVX2
    if (simd)
        return overlaps_avx2(s, g->lo, g->hi) & there;
#endif
    (void)simd;
    return overlaps_scalar(s, g->lo, g->hi) & there;
}

/* ---- The windows in view -------------------------------------------------------------------------------------------------------- */
static int glimpse_block(void *user, uint32_t block, uint32_t mask) {
    Sweep *sweep = user;
    EnfView *view = sweep->view;
    const uint32_t first = sweep->facade->vista_first + block * 8;
    float s[4][8];
    if (!ENF_VIEW_ROOM(view, glimpses, glimpse_capacity, view->glimpse_count + 8u)) {
        sweep->failed = 1;
        return 0;
    }
    mask &= slopes_to(sweep, &sweep->vistas->windows[first / 8], s) & 0xFF;
    for (; mask; mask &= mask - 1) {
        const uint32_t lane = enf_lowest_bit(mask);
        EnfWindowGlimpse *glimpse = &view->glimpses[view->glimpse_count++];
        glimpse->vista = first + lane;
        for (int k = 0; k < 2; k++) {
            glimpse->lo[k] = enf_slope_key(s[k][lane]);
            glimpse->hi[k] = enf_slope_key(s[2 + k][lane]);
        }
    }
    return 1;
}

static void glimpse_facade(Sweep *sweep, const EnfFacade *f, const EnfPlanes *planes, EnfBoxesTest test) {
    double q[3];
    vec_sub(q, sweep->view->screens.eyes[0], f->corner);
    double x = vec_dot(f->u, q), y = vec_dot(f->v, q), z = vec_dot(f->n, q);
    /* Eye and windows in single precision and their difference are off by 6e-8 of their size each; thrice that to spare for what is
     * computed of them. */
    double margin = f->slack + 4e-7 * (f->reach + fabs(x) + fabs(y) + fabs(z));
    if (z > f->farthest + margin)
        return;
    sweep->facade = f;
    sweep->eye[0] = (float)x;
    sweep->eye[1] = (float)y;
    sweep->eye[2] = (float)z;
    sweep->margin = (float)margin;
    sweep->view->stats.work +=
        ENF_WORK_BLOCK + ENF_WORK_BLOCK * enf_tree_query(sweep->vistas->boxes, &f->tree, planes, test, glimpse_block, sweep);
}

/* Into view->glimpses. out_complete: all that they can show is prepared. */
static EnfStatus glimpse_windows(EnfView *view, const EnfScreen *screen, int *out_complete) {
    EnfViewIndex *index = view->index;
    EnfStatus status = enf_view_index_need_vistas(index);
    if (status != ENF_OK)
        return status;
    const struct EnfVistas *vistas = index->vistas;
    Sweep sweep = {.view = view, .vistas = vistas, .simd = view->def.use_simd && enf_processor_avx2()};
    EnfBoxesTest test = enf_boxes_test((int)view->def.use_simd);
    EnfPlanes planes, for_objects;
    enf_screen_planes(view, screen, &for_objects, &planes);
    view->glimpse_count = 0;
    for (uint32_t i = 0; i < vistas->facade_count && !sweep.failed; i++)
        glimpse_facade(&sweep, &vistas->facades[i], &planes, test);
    *out_complete = 1;
    for (uint32_t i = 0; i < view->glimpse_count && vistas->incomplete_count; i++)
        *out_complete &= vistas->vistas[view->glimpses[i].vista].complete;
    return sweep.failed ? enf_fail_memory() : ENF_OK;
}

/* ---- What they show --------------------------------------------------------------------------------------------------------------- */
/* A window's stages at these slopes: the step of each that is reached, else ENF_NONE. root: the eye's step. */
static ENF_ALWAYS_INLINE void reach_stages(EnfView *view, const EnfVista *vista, const EnfWindowGlimpse *glimpse, int simd, uint32_t root,
                                           uint32_t *steps) {
    const struct EnfVistas *vistas = view->index->vistas;
    const uint8_t *shut = view->index->scene->opening_shut;
    const EnfVistaStage *stages = vistas->stages + vista->stage_first;
    const uint32_t query = view->query;
    uint32_t *seen = view->cell_seen, *out = view->answer.cells, *out_step = view->cell_step, count = view->answer.cell_count;
    uint32_t step = view->step_count;
    for (uint32_t first = 0; first < vista->stage_count; first += 32) {
        const EnfSlopes16 *slopes = &vistas->stage_slopes[vista->stage_block + first / ENF_SLOPE_LANES];
        uint32_t mask = overlaps(simd, slopes, vista->stage_count - first, glimpse);
        memset(steps + first, 0xFF, 32 * sizeof *steps); /* ENF_NONE, past the last stage too: of one size is faster */
        for (; mask; mask &= mask - 1) {
            const uint32_t i = first + enf_lowest_bit(mask);
            const EnfVistaStage *stage = &stages[i];
            const uint32_t parent = i > 0 ? steps[stage->parent] : root;
            if (parent == ENF_NONE || (stage->opening != ENF_NONE && shut[stage->opening]))
                continue;
            view->step_cell[step] = stage->cell;
            view->step_portal[step] = stage->portal;
            view->step_parent[step] = parent;
            /* Written in any case, counted when it is new: nobody can foretell which are. */
            out[count] = stage->cell;
            out_step[count] = step;
            count += seen[stage->cell] != query;
            seen[stage->cell] = query;
            steps[i] = step++;
        }
    }
    view->step_count = step;
    view->answer.cell_count = count;
}

/* Compiled twice: wide or not is known inside of either. */
static ENF_ALWAYS_INLINE void look_through(EnfView *view, const EnfWindowGlimpse *glimpse, int simd, uint32_t root) {
    const struct EnfVistas *vistas = view->index->vistas;
    const EnfVista *vista = &vistas->vistas[glimpse->vista];
    uint32_t steps[ENF_VISTA_STAGES];
    reach_stages(view, vista, glimpse, simd, root, steps);
    if (steps[0] == ENF_NONE || !view->def.want_objects)
        return;
    const uint32_t query = view->query, *objects = vistas->objects + vista->object_first;
    const uint8_t *stages = vistas->object_stages + vista->object_first;
    uint32_t *seen = view->object_seen, *out = view->answer.objects, *out_step = view->object_step;
    uint32_t count = view->answer.object_count;
    for (uint32_t first = 0; first < vista->object_count; first += 32) {
        const EnfSlopes16 *slopes = &vistas->object_slopes[(vista->object_first + first) / ENF_SLOPE_LANES];
        uint32_t mask = overlaps(simd, slopes, vista->object_count - first, glimpse);
        for (; mask; mask &= mask - 1) {
            const uint32_t slot = first + enf_lowest_bit(mask), object = objects[slot], step = steps[stages[slot]];
            const uint32_t is_new = (seen[object] != query) & (step != ENF_NONE);
            out[count] = object;
            out_step[count] = step;
            seen[object] = is_new ? query : seen[object];
            count += is_new;
        }
    }
    view->answer.object_count = count;
    view->stats.objects_tested += vista->object_count;
}

static void look_through_plain(EnfView *view, const EnfWindowGlimpse *glimpse, uint32_t root) {
    look_through(view, glimpse, 0, root);
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2,bmi"))) static void look_through_avx2(EnfView *view, const EnfWindowGlimpse *glimpse, uint32_t root) {
    look_through(view, glimpse, 1, root);
}
#else
#define look_through_avx2 look_through_plain
#endif

EnfStatus enf_sweep(EnfView *view, const EnfScreen *screen, int *out_done) {
    EnfStatus status = glimpse_windows(view, screen, out_done);
    if (status != ENF_OK || !*out_done)
        return status;
    const struct EnfVistas *vistas = view->index->vistas;
    const uint32_t count = view->glimpse_count;
    void (*look)(EnfView *, const EnfWindowGlimpse *, uint32_t) =
        view->def.use_simd && enf_processor_avx2() ? look_through_avx2 : look_through_plain;
    enf_cull_outdoors(view, screen, vistas);
    if (!enf_arrival_room(view, 1))
        return enf_fail_memory();
    const uint32_t root = enf_make_step(view, view->start_cells[0], ENF_NONE, ENF_NONE);
    for (uint32_t i = 0; i < count; i++) {
        const EnfVista *vista = &vistas->vistas[view->glimpses[i].vista];
        if (view->step_count + vista->stage_count > view->step_capacity && !enf_arrival_room(view, vista->stage_count))
            return enf_fail_memory();
        look(view, &view->glimpses[i], root);
    }
    view->stats.swept++;
    view->stats.windows += count;
    view->stats.work += ENF_WORK_WINDOW * (uint64_t)count;
    return ENF_OK;
}
