/* SPDX-License-Identifier: GPL-3.0-or-later
 * Takes meshes in, and builds the tree of boxes over their triangles.
 *
 * Based on: Wald, On fast construction of SAH-based bounding volume hierarchies, 2007 (binning); children of children are pulled up
 * until a node has four. */
#include "raycast/triangle_tree.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/vec3.h"

enum { BINS = 16, LEAF_MOST = 4, DEPTH_MOST = 60 };

EnfStatus enf_triangles_create(const double origin[3], EnfTriangles **out_triangles) {
    if (!origin || !out_triangles)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_create: NULL argument");
    if (!vec_finite(origin))
        return enf_fail(ENF_ERROR_BAD_INPUT, "enf_triangles_create: the origin isn't finite");
    EnfTriangles *t = ENF_NEW(EnfTriangles, 1);
    const EnfMaterial grey = {ENF_MATERIAL_DIFFUSE, {0.7f, 0.7f, 0.7f}, {0, 0, 0}, 1};
    uint32_t first;
    if (!t)
        return enf_fail_memory();
    vec_copy(t->origin, origin);
    EnfStatus status = enf_triangles_add_material(t, &grey, &first);
    if (status != ENF_OK) {
        enf_triangles_destroy(t);
        return status;
    }
    *out_triangles = t;
    return ENF_OK;
}

void enf_triangles_destroy(EnfTriangles *t) {
    if (!t)
        return;
    enf_free(t->materials);
    enf_free(t->triangles);
    enf_free(t->normals);
    enf_free(t->nodes);
    enf_free(t);
}

EnfStatus enf_triangles_add_material(EnfTriangles *t, const EnfMaterial *material, uint32_t *out_material) {
    if (!t || !material || !out_material)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_add_material: NULL argument");
    int finite = isfinite(material->ior) && material->ior > 0;
    for (int k = 0; k < 3; k++)
        finite = finite && isfinite(material->colour[k]) && isfinite(material->emission[k]);
    if (!finite || material->kind > ENF_MATERIAL_CLEAR)
        return enf_fail(ENF_ERROR_BAD_INPUT, "material %u: its kind is unknown, or a number isn't finite", t->material_count);
    if (!ENF_RESERVE(t->materials, t->material_count + 1))
        return enf_fail_memory();
    t->materials[t->material_count] = *material;
    *out_material = t->material_count++;
    return ENF_OK;
}

static EnfStatus check_mesh(const EnfTriangles *t, uint32_t object, const char *vertices, uint64_t vertex_count, uint64_t stride,
                            const uint32_t *corners, uint64_t triangle_count, const uint32_t *materials) {
    if (triangle_count > ENF_TREE_FIRST - t->count)
        return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: more than %u triangles in all", object, ENF_TREE_FIRST);
    for (uint64_t v = 0; v < vertex_count; v++) {
        double p[3];
        memcpy(p, vertices + v * stride, sizeof p);
        vec_sub(p, p, t->origin);
        if (!vec_finite(p) || fmax(fmax(fabs(p[0]), fabs(p[1])), fabs(p[2])) > 1e15)
            return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: vertex %llu isn't finite", object, (unsigned long long)v);
    }
    for (uint64_t i = 0; i < 3 * triangle_count; i++)
        if (corners[i] >= vertex_count)
            return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: triangle %llu names vertex %u of %llu", object, (unsigned long long)(i / 3),
                            corners[i], (unsigned long long)vertex_count);
    for (uint64_t i = 0; materials && i < triangle_count; i++)
        if (materials[i] >= t->material_count)
            return enf_fail(ENF_ERROR_BAD_INPUT, "object %u: triangle %llu has material %u of %u", object, (unsigned long long)i, materials[i],
                            t->material_count);
    return ENF_OK;
}

static int has_area(const TreeTriangle *t) {
    double ab[3], ac[3], n[3];
    for (int k = 0; k < 3; k++) {
        ab[k] = (double)t->v[1][k] - t->v[0][k];
        ac[k] = (double)t->v[2][k] - t->v[0][k];
    }
    vec_cross(n, ab, ac);
    return vec_dot(n, n) > 0;
}

static EnfStatus add_normals(EnfTriangles *t, const float *normals) {
    uint64_t had = t->normals ? enf_block_size(t->normals) / sizeof *t->normals : 0;
    if (!t->normals && !normals)
        return ENF_OK;
    if (had < t->count + 1 && !ENF_RESERVE(t->normals, t->count + 1))
        return enf_fail_memory();
    uint64_t has = enf_block_size(t->normals) / sizeof *t->normals;
    memset(t->normals + had, 0, (has - had) * sizeof *t->normals);
    for (int k = 0; normals && k < 9; k++)
        t->normals[t->count][k] = isfinite(normals[k]) ? (int16_t)(32767 * fmaxf(-1, fminf(1, normals[k]))) : 0;
    return ENF_OK;
}

EnfStatus enf_triangles_add_mesh(EnfTriangles *t, uint32_t object, const double *vertices, uint64_t vertex_count, uint64_t vertex_stride,
                                 const uint32_t *corners, uint64_t triangle_count, const uint32_t *materials, const float *normals) {
    if (!t || (triangle_count && (!vertices || !corners)))
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_add_mesh: NULL argument");
    uint64_t stride = vertex_stride ? vertex_stride : 3 * sizeof(double);
    EnfStatus status = check_mesh(t, object, (const char *)vertices, vertex_count, stride, corners, triangle_count, materials);
    if (status != ENF_OK)
        return status;
    t->committed = 0;
    if (!ENF_RESERVE(t->triangles, t->count + triangle_count))
        return enf_fail_memory();
    for (uint64_t i = 0; i < triangle_count; i++) {
        TreeTriangle *out = &t->triangles[t->count];
        for (int c = 0; c < 3; c++) {
            double p[3];
            memcpy(p, (const char *)vertices + corners[3 * i + c] * stride, sizeof p);
            for (int k = 0; k < 3; k++) {
                out->v[c][k] = (float)(p[k] - t->origin[k]);
                t->reach = fmax(t->reach, fabs((double)out->v[c][k]));
            }
        }
        out->material = materials ? materials[i] : 0;
        out->object = object;
        out->input = t->count;
        if (!has_area(out)) {
            t->without_area++;
            continue;
        }
        status = add_normals(t, normals ? normals + 9 * i : NULL);
        if (status != ENF_OK)
            return status;
        t->count++;
    }
    return ENF_OK;
}

/* ---- Building -------------------------------------------------------------------------------------------------- */
typedef struct Item {
    float lo[3], hi[3];
    uint32_t triangle;
} Item;

typedef struct Branch {
    float lo[3], hi[3];
    uint32_t left, right; /* inner: branches; leaf: right == ENF_NONE and left is the first item */
    uint32_t count;
} Branch;

typedef struct Builder {
    Item *items;
    Branch *branches;
    uint32_t branch_count;
    TreeNode *nodes;
    uint32_t node_count;
} Builder;

static void empty_box(float lo[3], float hi[3]) {
    for (int k = 0; k < 3; k++) {
        lo[k] = INFINITY;
        hi[k] = -INFINITY;
    }
}
static void grow(float lo[3], float hi[3], const float other_lo[3], const float other_hi[3]) {
    for (int k = 0; k < 3; k++) {
        lo[k] = fminf(lo[k], other_lo[k]);
        hi[k] = fmaxf(hi[k], other_hi[k]);
    }
}
static float half_area(const float lo[3], const float hi[3]) {
    float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

typedef struct Bin {
    float lo[3], hi[3];
    uint32_t count;
} Bin;

/* Orders items [first, first + count) about the cheapest of BINS - 1 planes an axis; gives how many lie before it, 0: no plane helps. */
static uint32_t split(Builder *b, uint32_t first, uint32_t count, const float lo[3], const float hi[3]) {
    float best = INFINITY;
    int best_axis = -1, best_bin = 0;
    for (int axis = 0; axis < 3; axis++) {
        Bin bins[BINS];
        float width = hi[axis] - lo[axis], scale = BINS * 0.99999f / width;
        if (!(width > 0) || !isfinite(scale))
            continue;
        for (int i = 0; i < BINS; i++) {
            empty_box(bins[i].lo, bins[i].hi);
            bins[i].count = 0;
        }
        for (uint32_t i = first; i < first + count; i++) {
            const Item *item = &b->items[i];
            Bin *bin = &bins[(int)((0.5f * (item->lo[axis] + item->hi[axis]) - lo[axis]) * scale)];
            grow(bin->lo, bin->hi, item->lo, item->hi);
            bin->count++;
        }
        float after[BINS], box_lo[3], box_hi[3];
        uint32_t seen = 0;
        empty_box(box_lo, box_hi);
        for (int i = BINS - 1; i > 0; i--) {
            grow(box_lo, box_hi, bins[i].lo, bins[i].hi);
            seen += bins[i].count;
            after[i] = half_area(box_lo, box_hi) * (float)seen;
        }
        empty_box(box_lo, box_hi);
        seen = 0;
        for (int i = 0; i + 1 < BINS; i++) {
            grow(box_lo, box_hi, bins[i].lo, bins[i].hi);
            seen += bins[i].count;
            float cost = half_area(box_lo, box_hi) * (float)seen + after[i + 1];
            if (seen && seen < count && cost < best) {
                best = cost;
                best_axis = axis;
                best_bin = i;
            }
        }
    }
    if (best_axis < 0)
        return 0;
    float scale = BINS * 0.99999f / (hi[best_axis] - lo[best_axis]);
    uint32_t i = first, j = first + count;
    while (i < j) {
        const Item item = b->items[i];
        if ((int)((0.5f * (item.lo[best_axis] + item.hi[best_axis]) - lo[best_axis]) * scale) <= best_bin) {
            i++;
        } else {
            b->items[i] = b->items[--j];
            b->items[j] = item;
        }
    }
    return i - first;
}

static uint32_t build(Builder *b, uint32_t first, uint32_t count, int depth) {
    uint32_t index = b->branch_count++;
    float centre_lo[3], centre_hi[3];
    Branch branch = {.left = first, .right = ENF_NONE, .count = count};
    empty_box(branch.lo, branch.hi);
    empty_box(centre_lo, centre_hi);
    for (uint32_t i = first; i < first + count; i++) {
        const Item *item = &b->items[i];
        float centre[3];
        for (int k = 0; k < 3; k++)
            centre[k] = 0.5f * (item->lo[k] + item->hi[k]);
        grow(branch.lo, branch.hi, item->lo, item->hi);
        grow(centre_lo, centre_hi, centre, centre);
    }
    if (count > LEAF_MOST) {
        /* Deep trees come from long rows of nested boxes: halves keep them within the search's stack. */
        uint32_t before = depth < DEPTH_MOST - 32 ? split(b, first, count, centre_lo, centre_hi) : 0;
        if (before == 0)
            before = count / 2;
        branch.left = build(b, first, before, depth + 1);
        branch.right = build(b, first + before, count - before, depth + 1);
    }
    b->branches[index] = branch;
    return index;
}

/* Writes the node of a branch: its children, those with the largest box opened until there are four. */
static uint32_t collapse(Builder *b, uint32_t branch) {
    uint32_t index = b->node_count++, children[4], count = 1;
    children[0] = branch;
    while (count < 4) {
        int widest = -1;
        float size = -1;
        for (uint32_t i = 0; i < count; i++) {
            const Branch *c = &b->branches[children[i]];
            if (c->right != ENF_NONE && half_area(c->lo, c->hi) > size) {
                size = half_area(c->lo, c->hi);
                widest = (int)i;
            }
        }
        if (widest < 0)
            break;
        const Branch *open = &b->branches[children[widest]];
        children[widest] = open->left;
        children[count++] = open->right;
    }
    TreeNode node;
    for (uint32_t i = 0; i < 4; i++) {
        const Branch *c = i < count ? &b->branches[children[i]] : NULL;
        for (int k = 0; k < 3; k++) {
            node.lo[k][i] = c ? c->lo[k] : INFINITY; /* nobody enters */
            node.hi[k][i] = c ? c->hi[k] : -INFINITY;
        }
        node.child[i] = !c ? 0 : c->right == ENF_NONE ? ENF_TREE_LEAF | ((c->count - 1) << 28) | c->left : collapse(b, children[i]);
    }
    b->nodes[index] = node;
    return index;
}

EnfStatus enf_triangles_commit(EnfTriangles *t) {
    if (!t)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_commit: NULL argument");
    uint32_t count = t->count;
    enf_free(t->nodes);
    t->nodes = NULL;
    t->node_count = 0;
    t->committed = 1;
    if (count == 0)
        return ENF_OK;
    Builder b = {ENF_NEW(Item, count), ENF_NEW(Branch, 2 * (uint64_t)count), 0, ENF_NEW(TreeNode, count), 0};
    TreeTriangle *ordered = ENF_NEW(TreeTriangle, count);
    if (!b.items || !b.branches || !b.nodes || !ordered) {
        enf_free(b.items);
        enf_free(b.branches);
        enf_free(b.nodes);
        enf_free(ordered);
        t->committed = 0;
        return enf_fail_memory();
    }
    for (uint32_t i = 0; i < count; i++) {
        empty_box(b.items[i].lo, b.items[i].hi);
        for (int c = 0; c < 3; c++)
            grow(b.items[i].lo, b.items[i].hi, t->triangles[i].v[c], t->triangles[i].v[c]);
        b.items[i].triangle = i;
    }
    build(&b, 0, count, 0);
    collapse(&b, 0);
    for (uint32_t i = 0; i < count; i++)
        ordered[i] = t->triangles[b.items[i].triangle];
    enf_free(t->triangles);
    t->triangles = ordered;
    t->node_count = b.node_count;
    t->nodes = enf_realloc(b.nodes, b.node_count * sizeof *b.nodes);
    if (!t->nodes)
        t->nodes = b.nodes;
    enf_free(b.items);
    enf_free(b.branches);
    return ENF_OK;
}

EnfTriangleCounts enf_default_triangle_counts(void) {
    EnfTriangleCounts counts = {.struct_size = sizeof counts};
    return counts;
}

EnfStatus enf_triangles_counts(const EnfTriangles *t, EnfTriangleCounts *out) {
    if (!t || !out || out->struct_size != sizeof *out)
        return enf_fail(ENF_ERROR_INVALID_ARGUMENT, "enf_triangles_counts: NULL argument or bad struct_size");
    *out = (EnfTriangleCounts){sizeof *out, (uint32_t)t->committed, t->count, t->without_area, t->node_count, 0, t->material_count, 0};
    out->bytes = enf_block_size(t->triangles) + enf_block_size(t->nodes) + enf_block_size(t->normals) + enf_block_size(t->materials);
    return ENF_OK;
}
