#include "link/tree.h"

#include <string.h>

static hpr_shape node_shape(const hpr_tree *tree, size_t node)
{
    return (hpr_shape)tree->patches->shape[tree->elements->patch[node]];
}

static size_t leaves_count(const hpr_tree *tree, size_t node)
{
    const size_t *dof = tree->elements->dof;
    return dof[tree->leaf[2 * node + 1]] - dof[tree->leaf[2 * node]];
}

size_t hpr_tree_count(const hpr_tree *tree, size_t node, int degree)
{
    return degree == HPR_TREE_LEAVES ? leaves_count(tree, node)
                                     : hpr_basis_count(node_shape(tree, node), degree);
}

static size_t own_count(const hpr_tree *tree, size_t node)
{
    return hpr_tree_count(tree, node, tree->degree[node]);
}

bool hpr_tree_at_once(const hpr_tree *tree, size_t node)
{
    return leaves_count(tree, node) <= tree->most_at_once;
}

/* Where the copy of the leaves' coefficients is; of a leaf it is the thing itself. */
static size_t leaves_dof(const hpr_tree *tree, size_t node)
{
    return tree->dof[node] + (tree->elements->child[node] == HPR_NONE ? 0 : own_count(tree, node));
}

static bool has_copy(const hpr_tree *tree, size_t node)
{
    return tree->elements->child[node] != HPR_NONE && hpr_tree_at_once(tree, node);
}

size_t hpr_tree_room(const hpr_tree *tree, size_t node)
{
    return own_count(tree, node) + (has_copy(tree, node) ? leaves_count(tree, node) : 0);
}

hpr_element_frame hpr_tree_frame(const hpr_tree *tree, size_t node, int degree)
{
    hpr_element_frame frame = hpr_node_frame(tree->patches, tree->elements, node);
    frame.degree = degree;
    if (frame.shape == HPR_SHAPE_QUADRILATERAL && tree->elements->child[node] != HPR_NONE)
        frame.recurrence = hpr_quad_tables_basis(tree->quads, node);
    return frame;
}

bool hpr_tree_is_mixed(const hpr_tree *tree, size_t node)
{
    return tree->kind[node] == HPR_NODE_MIXED && tree->elements->child[node] != HPR_NONE;
}

double hpr_tree_stretch(const hpr_tree *tree, size_t node)
{
    return hpr_tree_is_mixed(tree, node) ? 1 / hpr_coverage_node_share(tree->coverage, node) : 1;
}

/* The functions of a parallelogram are in rows, those of other shapes in the order of their degree. */
static bool same_order(const hpr_tree *tree, size_t node, int degree)
{
    return degree == tree->degree[node] || node_shape(tree, node) != HPR_SHAPE_PARALLELOGRAM;
}

const double *hpr_tree_take(const hpr_tree *tree, size_t node, int degree, const double *value, double *room)
{
    const double *own = value + tree->dof[node];
    if (degree == HPR_TREE_LEAVES)
        return value + leaves_dof(tree, node);
    if (same_order(tree, node, degree))
        return own;
    size_t count = (size_t)degree + 1, stride = (size_t)tree->degree[node] + 1;
    for (size_t a = 0; a < count; a++)
        memcpy(room + a * count, own + a * stride, count * sizeof *room);
    return room;
}

void hpr_tree_add(const hpr_tree *tree, size_t node, int degree, const double *part, double *value)
{
    bool leaves = degree == HPR_TREE_LEAVES;
    double *own = value + (leaves ? leaves_dof(tree, node) : tree->dof[node]);
    size_t count = (size_t)degree + 1, stride = (size_t)tree->degree[node] + 1;
    if (leaves || same_order(tree, node, degree)) {
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

/* Lists the nodes below `node`, each before its children, and finds their leaves and kinds. */
static void list_below(hpr_tree *tree, const hpr_coverage *coverage, uint32_t node, uint32_t *next)
{
    const hpr_elements *e = tree->elements;
    tree->node[(*next)++] = node;
    if (e->child[node] == HPR_NONE) {
        uint32_t leaf = e->leaf_of_node[node];
        tree->kind[node] = (uint8_t)leaf_kind(coverage, leaf);
        tree->degree[node] = tree->worth[node] = e->degree[node];
        tree->leaf[2 * node] = leaf;
        tree->leaf[2 * node + 1] = leaf + 1;
        return;
    }
    uint32_t child = e->child[node];
    list_below(tree, coverage, child, next);
    list_below(tree, coverage, child + 1, next);
    tree->leaf[2 * node] = tree->leaf[2 * child];
    tree->leaf[2 * node + 1] = tree->leaf[2 * (child + 1) + 1];
    bool alike = tree->kind[child] == tree->kind[child + 1];
    tree->kind[node] = alike ? tree->kind[child] : HPR_NODE_MIXED;
    tree->degree[node] = (uint8_t)tree->highest_degree;
    tree->worth[node] =
        worthwhile(node_shape(tree, node), tree->highest_degree, WORTH * leaves_count(tree, node));
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
        tree->dof_count += hpr_tree_room(tree, node);
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
    tree->coverage = coverage;
    tree->patches = hpr_coverage_patches(coverage);
    tree->elements = elements;
    inner_degree = highest_degree(elements, inner_degree);
    tree->highest_degree = inner_degree;
    tree->most_at_once = hpr_basis_count(HPR_SHAPE_PARALLELOGRAM, inner_degree);
    status = hpr_two_scale_create(ctx, inner_degree, &tree->two_scale);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->degree, nodes, sizeof *tree->degree, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->worth, nodes, sizeof *tree->worth, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->kind, nodes, sizeof *tree->kind, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->leaf, 2 * nodes, sizeof *tree->leaf, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->node, nodes, sizeof *tree->node, "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->first, elements->patch_count + 1, sizeof *tree->first,
                                   "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tree->dof, nodes, sizeof *tree->dof, "the trees of elements");
    if (status == HPR_OK) {
        fill(tree, coverage);
        status = hpr_quad_tables_create(tree->patches, elements, tree->degree, &tree->quads);
    }
    if (status != HPR_OK)
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
    hpr_quad_tables_destroy(&tree->quads);
    hpr_release(ctx, tree->degree);
    hpr_release(ctx, tree->worth);
    hpr_release(ctx, tree->kind);
    hpr_release(ctx, tree->leaf);
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
    size_t child = e->child[node] + (size_t)which;
    bool skew = node_shape(tree, node) == HPR_SHAPE_QUADRILATERAL;
    return (hpr_half){.shape = node_shape(tree, node),
                      .axis = e->axis[node],
                      .which = which,
                      .whole_degree = tree->degree[node],
                      .half_degree = tree->degree[child],
                      .matrix = skew ? hpr_quad_tables_matrix(tree->quads, child) : NULL};
}

static void copy_leaf(const hpr_tree *tree, uint32_t node, const double *from, double *to, bool to_leaf)
{
    const hpr_elements *e = tree->elements;
    size_t leaf = e->dof[e->leaf_of_node[node]], count = e->dof[e->leaf_of_node[node] + 1] - leaf;
    memcpy(to + (to_leaf ? leaf : tree->dof[node]), from + (to_leaf ? tree->dof[node] : leaf),
           count * sizeof *to);
}

/* What a node received for its leaves, to these. */
static void hand_down(const hpr_tree *tree, uint32_t node, double *value)
{
    const hpr_elements *e = tree->elements;
    const double *part = value + leaves_dof(tree, node);
    for (uint32_t leaf = tree->leaf[2 * node]; leaf < tree->leaf[2 * node + 1]; leaf++) {
        double *own = value + tree->dof[e->leaf[leaf]];
        for (size_t k = 0; k < e->dof[leaf + 1] - e->dof[leaf]; k++)
            own[k] += *part++;
    }
}

/*
 * A patch's nodes in parts for threads: subtrees, which are consecutive in tree->node, and what lies above
 * them. There are few of either, whatever the number of threads.
 */
typedef struct part {
    uint32_t from, to; /* in tree->node */
} part;

enum { MAX_PARTS = 64, SHARED_NODES = 1 << 13 }; /* so many nodes take about a millisecond */

typedef struct parts {
    size_t part_count, above_count;
    part part[MAX_PARTS];
    uint32_t above[MAX_PARTS]; /* in tree->node, each before what is below it */
} parts;

/* A tree of n leaves has 2 n - 1 nodes. */
static uint32_t nodes_below(const hpr_tree *tree, uint32_t node)
{
    return 2 * (tree->leaf[2 * (size_t)node + 1] - tree->leaf[2 * (size_t)node]) - 1;
}

static void split_below(const hpr_tree *tree, uint32_t at, int depth, parts *p)
{
    enum { DEPTH = 5 }; /* 2^DEPTH parts at most */
    uint32_t node = tree->node[at], count = nodes_below(tree, node);
    if (depth == DEPTH || count < SHARED_NODES / 8) {
        p->part[p->part_count++] = (part){at, at + count};
        return;
    }
    p->above[p->above_count++] = at;
    uint32_t second = at + 1 + nodes_below(tree, tree->elements->child[node]);
    split_below(tree, at + 1, depth + 1, p);
    split_below(tree, second, depth + 1, p);
}

static bool is_shared(const hpr_tree *tree, size_t patch)
{
    return tree->first[patch + 1] - tree->first[patch] >= SHARED_NODES;
}

/* A leaf of which some part is covered. */
static bool is_trimmed(const hpr_tree *tree, uint32_t node)
{
    return tree->kind[node] != HPR_NODE_OPEN && tree->elements->child[node] == HPR_NONE;
}

static void pull_node(const hpr_tree *tree, uint32_t node, const double *leaf, double *value)
{
    const hpr_elements *e = tree->elements;
    if (e->child[node] == HPR_NONE) {
        copy_leaf(tree, node, leaf, value, false);
        return;
    }
    memset(value + tree->dof[node], 0, own_count(tree, node) * sizeof *value);
    for (int which = 0; which < 2; which++) {
        uint32_t child = e->child[node] + (uint32_t)which;
        const double *sent = value + tree->dof[child];
        hpr_half half = half_of(tree, node, which);
        double weighed[HPR_MAX_BASIS];
        if (is_trimmed(tree, child)) {
            memcpy(weighed, sent, own_count(tree, child) * sizeof *weighed);
            hpr_coverage_weigh(tree->coverage, e->leaf_of_node[child], weighed);
            sent = weighed;
        }
        hpr_two_scale_pull(tree->two_scale, &half, sent, value + tree->dof[node]);
    }
    if (has_copy(tree, node))
        memcpy(value + leaves_dof(tree, node), leaf + e->dof[tree->leaf[2 * node]],
               leaves_count(tree, node) * sizeof *value);
}

void hpr_tree_pull(const hpr_tree *tree, size_t patch, const double *leaf, double *value)
{
    parts p = {0};
    split_below(tree, tree->first[patch], 0, &p);
#pragma omp parallel for schedule(dynamic, 1)                                                                \
    num_threads(hpr_context_threads(tree->context)) if (is_shared(tree, patch))
    for (size_t k = 0; k < p.part_count; k++) {
        for (uint32_t i = p.part[k].to; i-- > p.part[k].from;)
            pull_node(tree, tree->node[i], leaf, value);
    }
    for (size_t k = p.above_count; k-- > 0;)
        pull_node(tree, tree->node[p.above[k]], leaf, value);
}

static void push_node(const hpr_tree *tree, uint32_t node, double *value, double *leaf)
{
    const hpr_elements *e = tree->elements;
    if (e->child[node] == HPR_NONE) {
        copy_leaf(tree, node, value, leaf, true);
        return;
    }
    if (has_copy(tree, node))
        hand_down(tree, node, value);
    for (int which = 0; which < 2; which++) {
        uint32_t child = e->child[node] + (uint32_t)which;
        double *received = value + tree->dof[child];
        hpr_half half = half_of(tree, node, which);
        if (!is_trimmed(tree, child)) {
            hpr_two_scale_push(tree->two_scale, &half, value + tree->dof[node], received);
            continue;
        }
        double weighed[HPR_MAX_BASIS] = {0};
        hpr_two_scale_push(tree->two_scale, &half, value + tree->dof[node], weighed);
        hpr_coverage_weigh(tree->coverage, e->leaf_of_node[child], weighed);
        for (size_t k = 0; k < own_count(tree, child); k++)
            received[k] += weighed[k];
    }
}

void hpr_tree_push(const hpr_tree *tree, size_t patch, double *value, double *leaf)
{
    parts p = {0};
    split_below(tree, tree->first[patch], 0, &p);
    for (size_t k = 0; k < p.above_count; k++)
        push_node(tree, tree->node[p.above[k]], value, leaf);
#pragma omp parallel for schedule(dynamic, 1)                                                                \
    num_threads(hpr_context_threads(tree->context)) if (is_shared(tree, patch))
    for (size_t k = 0; k < p.part_count; k++) {
        for (uint32_t i = p.part[k].from; i < p.part[k].to; i++)
            push_node(tree, tree->node[i], value, leaf);
    }
}
