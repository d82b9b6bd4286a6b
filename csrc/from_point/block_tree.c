/* SPDX-License-Identifier: GPL-3.0-or-later
 * Eight boxes against half-spaces at once (AVX2 when the processor has it, else the scalar twin), and trees of them. */
#include "from_point/block_tree.h"

#include "base/simd.h"

#include <float.h>
#include <math.h>
#include <string.h>

void enf_planes_add(EnfPlanes *planes, const double n[3], double d, double reach) {
    enf_planes_put(planes, n, d, (fabs(n[0]) + fabs(n[1]) + fabs(n[2])) * reach + fabs(d));
}

void enf_boxes_test_scalar(const EnfBoxes8 *blocks, uint32_t count, const EnfPlanes *planes, uint16_t *masks) {
    for (uint32_t b = 0; b < count; b++) {
        const EnfBoxes8 *box = &blocks[b];
        uint32_t mask = 0xFF, sure = planes->loose ? 0 : 0xFF;
        for (uint32_t k = 0; k < planes->count && mask; k++) {
            uint32_t in = 0, centre = 0;
            for (int i = 0; i < 8; i++) {
                /* The order of operations is the vector twin's: equal bits. */
                float s = planes->n[k][0] * box->cx[i] + planes->d[k];
                s = s + planes->n[k][1] * box->cy[i];
                s = s + planes->n[k][2] * box->cz[i];
                centre |= (uint32_t)(s >= planes->sure[k]) << i;
                s = s + planes->a[k][0] * box->hx[i];
                s = s + planes->a[k][1] * box->hy[i];
                s = s + planes->a[k][2] * box->hz[i];
                in |= (uint32_t)(s >= 0) << i;
            }
            mask &= in;
            sure &= centre;
        }
        if (planes->count == 0)
            for (int i = 0; i < 8; i++)
                if (box->hx[i] < 0)
                    mask &= ~(1u << i);
        masks[b] = (uint16_t)(mask | (mask & sure) << 8);
    }
}

#ifdef ENF_HAVE_AVX2
__attribute__((target("avx2"))) static void boxes_test_avx2(const EnfBoxes8 *blocks, uint32_t count, const EnfPlanes *planes,
                                                            uint16_t *masks) {
    if (planes->count == 0) {
        enf_boxes_test_scalar(blocks, count, planes, masks);
        return;
    }
    for (uint32_t b = 0; b < count; b++) {
        const EnfBoxes8 *box = &blocks[b];
        __m256 cx = _mm256_loadu_ps(box->cx), cy = _mm256_loadu_ps(box->cy), cz = _mm256_loadu_ps(box->cz);
        __m256 hx = _mm256_loadu_ps(box->hx), hy = _mm256_loadu_ps(box->hy), hz = _mm256_loadu_ps(box->hz);
        uint32_t mask = 0xFF, sure = planes->loose ? 0 : 0xFF;
        for (uint32_t k = 0; k < planes->count && mask; k++) {
            __m256 s = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(planes->n[k][0]), cx), _mm256_set1_ps(planes->d[k]));
            s = _mm256_add_ps(s, _mm256_mul_ps(_mm256_set1_ps(planes->n[k][1]), cy));
            s = _mm256_add_ps(s, _mm256_mul_ps(_mm256_set1_ps(planes->n[k][2]), cz));
            sure &= (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(s, _mm256_set1_ps(planes->sure[k]), _CMP_GE_OQ));
            s = _mm256_add_ps(s, _mm256_mul_ps(_mm256_set1_ps(planes->a[k][0]), hx));
            s = _mm256_add_ps(s, _mm256_mul_ps(_mm256_set1_ps(planes->a[k][1]), hy));
            s = _mm256_add_ps(s, _mm256_mul_ps(_mm256_set1_ps(planes->a[k][2]), hz));
            mask &= (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(s, _mm256_setzero_ps(), _CMP_GE_OQ));
        }
        masks[b] = (uint16_t)(mask | (mask & sure) << 8);
    }
}
#endif

EnfBoxesTest enf_boxes_test(int use_simd) {
#ifdef ENF_HAVE_AVX2
    if (use_simd && enf_processor_avx2())
        return boxes_test_avx2;
#endif
    (void)use_simd;
    return enf_boxes_test_scalar;
}

/* Block counts of the levels; returns how many levels there are. */
static uint32_t tree_levels(uint32_t item_count, uint32_t blocks[ENF_TREE_LEVELS]) {
    uint32_t levels = 0, n = item_count;
    do {
        n = n / 8 + (n % 8 != 0);
        blocks[levels++] = n;
    } while (n > ENF_TREE_TOP && levels < ENF_TREE_LEVELS);
    return levels;
}

uint32_t enf_tree_blocks(uint32_t item_count) {
    uint32_t blocks[ENF_TREE_LEVELS], sum = 0;
    for (uint32_t i = 0, levels = tree_levels(item_count, blocks); i < levels; i++)
        sum += blocks[i];
    return sum;
}

/* Ties go by the box's corners, then by index only when two boxes are equal: the order of input doesn't matter. */
static int item_before(const double (*boxes)[6], const EnfTreeItem *a, const EnfTreeItem *b, int axis) {
    if (a->centre[axis] != b->centre[axis])
        return a->centre[axis] < b->centre[axis];
    for (int i = 0; i < 6; i++)
        if (boxes[a->at][i] != boxes[b->at][i])
            return boxes[a->at][i] < boxes[b->at][i];
    return a->at < b->at;
}

/* Puts the `split` smallest along `axis` first (quickselect with the middle as pivot; falls back to sorting nothing:
 * any order is right, only slower to query). */
static void select_split(const double (*boxes)[6], EnfTreeItem *items, uint32_t n, uint32_t split, int axis) {
    uint32_t lo = 0, hi = n;
    for (uint32_t rounds = 0; hi - lo > 1 && rounds < 200; rounds++) {
        const EnfTreeItem pivot = items[lo + (hi - lo) / 2];
        uint32_t i = lo, j = hi - 1;
        for (;;) {
            while (item_before(boxes, &items[i], &pivot, axis))
                i++;
            while (item_before(boxes, &pivot, &items[j], axis))
                j--;
            if (i >= j)
                break;
            EnfTreeItem swap = items[i];
            items[i++] = items[j];
            items[j--] = swap;
        }
        uint32_t middle = j + 1; /* [lo, middle) <= pivot <= [middle, hi) */
        if (middle == lo || middle == hi)
            middle = lo + (hi - lo) / 2;
        if (split < middle)
            hi = middle;
        else
            lo = middle;
    }
}

static void order_items(const double (*boxes)[6], EnfTreeItem *items, uint32_t n) {
    while (n > 8) {
        double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (uint32_t i = 0; i < n; i++)
            for (int c = 0; c < 3; c++) {
                const double centre = items[i].centre[c];
                lo[c] = centre < lo[c] ? centre : lo[c];
                hi[c] = centre > hi[c] ? centre : hi[c];
            }
        int axis = 0;
        for (int c = 1; c < 3; c++)
            if (hi[c] - lo[c] > hi[axis] - lo[axis])
                axis = c;
        /* Left half: a power of two blocks, so that eights of blocks stay together on every level. */
        uint32_t left = 8;
        while (left * 2 < n)
            left *= 2;
        if (left >= n)
            left = n / 2;
        select_split(boxes, items, n, left, axis);
        order_items(boxes, items, left);
        items += left;
        n -= left;
    }
}

static void set_lane(EnfBoxes8 *block, uint32_t lane, const double box[6]) {
    float *c[3] = {block->cx, block->cy, block->cz}, *h[3] = {block->hx, block->hy, block->hz};
    for (int k = 0; k < 3; k++) {
        double centre = 0.5 * (box[k] + box[k + 3]), half = 0.5 * (box[k + 3] - box[k]);
        c[k][lane] = (float)centre;
        /* Outward by the rounding of the centre and of the half extent itself. */
        h[k][lane] = (float)((half + fabs(centre - (double)c[k][lane])) * (1 + 2.4e-7) + fabs(centre) * 1e-12);
    }
}

static void empty_lane(EnfBoxes8 *block, uint32_t lane) {
    block->cx[lane] = block->cy[lane] = block->cz[lane] = 0;
    block->hx[lane] = block->hy[lane] = block->hz[lane] = -1e30f;
}

void enf_tree_build(const double (*boxes)[6], uint32_t item_count, EnfTreeItem *items, EnfBoxes8 *blocks) {
    uint32_t counts[ENF_TREE_LEVELS], levels = tree_levels(item_count, counts);
    for (uint32_t i = 0; i < item_count; i++) {
        items[i].at = i;
        for (int c = 0; c < 3; c++)
            items[i].centre[c] = boxes[i][c] + boxes[i][c + 3];
    }
    order_items(boxes, items, item_count);
    for (uint32_t b = 0; b < counts[0]; b++)
        for (uint32_t lane = 0; lane < 8; lane++) {
            uint32_t i = b * 8 + lane;
            if (i < item_count)
                set_lane(&blocks[b], lane, boxes[items[i].at]);
            else
                empty_lane(&blocks[b], lane);
        }
    for (uint32_t level = 1; level < levels; level++) {
        const EnfBoxes8 *below = blocks;
        blocks += counts[level - 1];
        for (uint32_t b = 0; b < counts[level]; b++)
            for (uint32_t lane = 0; lane < 8; lane++) {
                uint32_t child = b * 8 + lane;
                if (child >= counts[level - 1]) {
                    empty_lane(&blocks[b], lane);
                    continue;
                }
                double box[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
                const float *c[3] = {below[child].cx, below[child].cy, below[child].cz};
                const float *h[3] = {below[child].hx, below[child].hy, below[child].hz};
                for (uint32_t i = 0; i < 8; i++)
                    if (h[0][i] >= 0)
                        for (int k = 0; k < 3; k++) {
                            box[k] = fmin(box[k], (double)c[k][i] - (double)h[k][i]);
                            box[k + 3] = fmax(box[k + 3], (double)c[k][i] + (double)h[k][i]);
                        }
                set_lane(&blocks[b], lane, box);
            }
    }
}

uint32_t enf_tree_query(const EnfBoxes8 *blocks, const EnfBlockTree *tree, const EnfPlanes *planes, EnfBoxesTest test, EnfTreeLeaf leaf,
                        void *user) {
    if (tree->item_count == 0)
        return 0;
    uint32_t counts[ENF_TREE_LEVELS], first[ENF_TREE_LEVELS], levels = tree_levels(tree->item_count, counts);
    first[0] = tree->first_block;
    if (levels == 1) { /* few: all at once */
        uint16_t masks[ENF_TREE_TOP];
        test(&blocks[first[0]], counts[0], planes, masks);
        for (uint32_t b = 0; b < counts[0]; b++)
            if (masks[b] && !leaf(user, b, masks[b]))
                break;
        return counts[0];
    }
    for (uint32_t i = 1; i < levels; i++)
        first[i] = first[i - 1] + counts[i - 1];
    struct {
        uint32_t level, block;
    } stack[ENF_TREE_TOP + 8 * ENF_TREE_LEVELS];
    uint32_t depth = 0, compared = 0;
    for (uint32_t b = counts[levels - 1]; b-- > 0;) {
        stack[depth].level = levels - 1;
        stack[depth++].block = b;
    }
    while (depth > 0) {
        uint32_t level = stack[--depth].level, block = stack[depth].block;
        uint16_t mask;
        compared++;
        test(&blocks[first[level] + block], 1, planes, &mask);
        if (!mask)
            continue;
        if (level == 0) {
            if (!leaf(user, block, mask))
                return compared;
            continue;
        }
        for (uint32_t lane = 8; lane-- > 0;)
            if ((mask >> lane & 1) && block * 8 + lane < counts[level - 1]) {
                stack[depth].level = level - 1;
                stack[depth++].block = block * 8 + lane;
            }
    }
    return compared;
}
