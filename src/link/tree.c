#include "link/tree.h"

#include <string.h>

static hpr_shape node_shape(const hpr_tree *tree, size_t node)
{
    return (hpr_shape)tree->patches->shape[tree->elements->patch[node]];
}

size_t hpr_tree_count(const hpr_tree *tree, size_t node, int degree)
{
    return hpr_basis_count(node_shape(tree, node), degree);
}

static size_t own_count(const hpr_tree *tree, size_t node)
{
    return hpr_tree_count(tree, node, tree->degree[node]);
}

hpr_element_frame hpr_tree_frame(const hpr_tree *tree, size_t node, int degree)
{
    hpr_element_frame frame = hpr_node_frame(tree->patches, tree->elements, node);
    frame.degree = degree;
    return frame;
}

/* The functions of a triangle are in the order of their degree, those of a parallelogram in rows. */
static bool same_order(const hpr_tree *tree, size_t node, int degree)
{
    return degree == tree->degree[node] || node_shape(tree, node) == HPR_SHAPE_TRIANGLE;
}

const double *hpr_tree_take(const hpr_tree *tree, size_t node, int degree, const double *value, double *room)
{
    const double *own = value + tree->dof[node];
    if (same_order(tree, node, degree))
        return own;
    size_t count = (size_t)degree + 1, stride = (size_t)tree->degree[node] + 1;
    for (size_t a = 0; a < count; a++)
        memcpy(room + a * count, own + a * stride, count * sizeof *room);
    return room;
}

void hpr_tree_add(const hpr_tree *tree, size_t node, int degree, const double *part, double *value)
{
    double *own = value + tree->dof[node];
    size_t count = (size_t)degree + 1, stride = (size_t)tree->degree[node] + 1;
    if (same_order(tree, node, degree)) {
        for (size_t k = 0; k < hpr_tree_count(tree, node, degree); k++)
            own[k] += part[k];
        return;
    }
    for (size_t a = 0; a < count; a++) {
        for (size_t b = 0; b < count; b++)
            own[a * stride + b] += part[a * count + b];
    }
}

static hpr_node_kind leaf_kind(const hpr_coverage *coverage, size_t leaf)
{
    int parts = 0;
    bool trimmed = hpr_coverage_parts(coverage, leaf, &parts) != NULL;
    return !trimmed ? HPR_NODE_OPEN : parts ? HPR_NODE_MIXED : HPR_NODE_COVERED;
}

/* A block of a link is integrated once and applied in every sweep: with at most so many times the functions
 * of the leaves below, it costs no more memory than the links that it stands for, of which there are at least
 * four (two nodes, two children each). */
enum { WORTH = 4 };

/* The highest degree up to a limit with at most so many functions. */
static uint8_t worthwhile(hpr_shape shape, int limit, size_t functions)
{
    int degree = 0;
    while (degree < limit && hpr_basis_count(shape, degree + 1) <= functions)
        degree++;
    return (uint8_t)degree;
}

/* Lists the nodes below `node`, each before its children, and finds their kinds. Returns the number of
 * coefficients of their leaves. */
static size_t list_below(hpr_tree *tree, const hpr_coverage *coverage, uint32_t node, uint32_t *next)
{
    const hpr_elements *e = tree->elements;
    tree->node[(*next)++] = node;
    if (e->child[node] == HPR_NONE) {
        uint32_t leaf = e->leaf_of_node[node];
        tree->kind[node] = (uint8_t)leaf_kind(coverage, leaf);
        tree->degree[node] = tree->worth[node] = e->degree[node];
        return e->dof[leaf + 1] - e->dof[leaf];
    }
    uint32_t child = e->child[node];
    size_t functions = list_below(tree, coverage, child, next);
    functions += list_below(tree, coverage, child + 1, next);
    bool alike = tree->kind[child] == tree->kind[child + 1];
    tree->kind[node] = alike ? tree->kind[child] : HPR_NODE_MIXED;
    tree->degree[node] = (uint8_t)tree->highest_degree;
    tree->worth[node] = worthwhile(node_shape(tree, node), tree->highest_degree, WORTH * functions);
    return functions;
}

static void fill(hpr_tree *tree, const hpr_coverage *coverage)
{
    const hpr_elements *e = tree->elements;
    uint32_t next = 0;
    for (size_t patch = 0; patch < e->patch_count; patch++) {
        tree->first[patch] = next;
        list_below(tree, coverage, (uint32_t)patch, &next);
    }
    tree->first[e->patch_count] = next;
    for (size_t i = 0; i < e->node_count; i++) {
        uint32_t node = tree->node[i];
        tree->dof[node] = tree->dof_count;
        tree->dof_count += own_count(tree, node);
    }
}

static int highest_degree(const hpr_elements *elements, int least)
{
    for (size_t i = 0; i < elements->leaf_count; i++) {
        int degree = elements->degree[elements->leaf[i]];
        least = degree > least ? degree : least;
    }
    return least;
}

hpr_status hpr_tree_create(const hpr_coverage *coverage, const hpr_elements *elements, int inner_degree,
                           hpr_tree **out)
{
    hpr_context *ctx = elements->context;
    size_t nodes = elements->node_count;
    hpr_tree *tree = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &tree, 1, sizeof *tree, "the trees of elements");
    if (status != HPR_OK)
        return status;
    tree->context = ctx;
    tree->patches = hpr_coverage_patches(coverage);
    tree->elements = elements;
    inner_degree = highest_degree(elements, inner_degree);
    tree->highest_degree = inner_degree;
    status = hpr_two_scale_create(ctx, inner_degree, &tree->two_scale);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->degree, nodes, sizeof *tree->degree, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->worth, nodes, sizeof *tree->worth, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->kind, nodes, sizeof *tree->kind, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->node, nodes, sizeof *tree->node, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->first, elements->patch_count + 1, sizeof *tree->first,
                                   "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->dof, nodes, sizeof *tree->dof, "the trees of elements");
    if (status == HPR_OK)
        fill(tree, coverage);
    else
        hpr_tree_destroy(&tree);
    *out = tree;
    return status;
}

void hpr_tree_destroy(hpr_tree **out)
{
    hpr_tree *tree = *out;
    if (!tree)
        return;
    hpr_context *ctx = tree->context;
    hpr_two_scale_destroy(&tree->two_scale);
    hpr_release(ctx, tree->degree);
    hpr_release(ctx, tree->worth);
    hpr_release(ctx, tree->kind);
    hpr_release(ctx, tree->node);
    hpr_release(ctx, tree->first);
    hpr_release(ctx, tree->dof);
    hpr_release(ctx, tree);
    *out = NULL;
}

/* Child `which` of a node, as the two-scale relations want it. */
static hpr_half half_of(const hpr_tree *tree, uint32_t node, int which)
{
    const hpr_elements *e = tree->elements;
    return (hpr_half){.shape = node_shape(tree, node),
                      .axis = e->axis[node],
                      .which = which,
                      .whole_degree = tree->degree[node],
                      .half_degree = tree->degree[e->child[node] + (uint32_t)which]};
}

static void copy_leaf(const hpr_tree *tree, uint32_t node, const double *from, double *to, bool to_leaf)
{
    const hpr_elements *e = tree->elements;
    size_t leaf = e->dof[e->leaf_of_node[node]], count = e->dof[e->leaf_of_node[node] + 1] - leaf;
    memcpy(to + (to_leaf ? leaf : tree->dof[node]), from + (to_leaf ? tree->dof[node] : leaf),
           count * sizeof *to);
}

void hpr_tree_pull(const hpr_tree *tree, size_t patch, const double *leaf, double *value)
{
    const hpr_elements *e = tree->elements;
    for (uint32_t i = tree->first[patch + 1]; i-- > tree->first[patch];) {
        uint32_t node = tree->node[i];
        if (e->child[node] == HPR_NONE) {
            copy_leaf(tree, node, leaf, value, false);
            continue;
        }
        memset(value + tree->dof[node], 0, own_count(tree, node) * sizeof *value);
        for (int which = 0; which < 2; which++) {
            hpr_half half = half_of(tree, node, which);
            hpr_two_scale_pull(tree->two_scale, &half, value + tree->dof[e->child[node] + (uint32_t)which],
                               value + tree->dof[node]);
        }
    }
}

void hpr_tree_push(const hpr_tree *tree, size_t patch, double *value, double *leaf)
{
    const hpr_elements *e = tree->elements;
    for (uint32_t i = tree->first[patch]; i < tree->first[patch + 1]; i++) {
        uint32_t node = tree->node[i];
        if (e->child[node] == HPR_NONE) {
            copy_leaf(tree, node, value, leaf, true);
            continue;
        }
        for (int which = 0; which < 2; which++) {
            hpr_half half = half_of(tree, node, which);
            hpr_two_scale_push(tree->two_scale, &half, value + tree->dof[node],
                               value + tree->dof[e->child[node] + (uint32_t)which]);
        }
    }
}
