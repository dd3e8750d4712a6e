/*
 * The fractions that are lost, as polynomials on nodes of the trees: f = sum_k f_k T_k on nodes that have no
 * leaf in common, and ∫ B f = sum over leaves of sum_k B_k f_k with f pushed down to the leaves. What f has
 * beyond the node's degree, r, is neglected where ‖r‖ ‖B‖ on the node is within its share of the tolerance.
 */
#include "basis/basis.h"
#include "math/gauss.h"
#include "math/vec3.h"
#include "quadrature/rule.h"
#include "solver/losses.h"

#include <math.h>
#include <string.h>

enum { MAX_NODES = HPR_MAX_DEGREE + 3, MAX_POINTS = 4 * MAX_NODES * MAX_NODES };

/* f_back, f_out */
enum { KINDS = 2 };

typedef struct field {
    hpr_losses *losses;
    const hpr_tree *tree;
    double *norm2;       /* [nodes] of B, the channels' largest added up over leaves */
    double *node[KINDS]; /* [tree's dofs] */
    double *leaf[KINDS]; /* [leaf dofs] */
} field;

/* A fit over a node by product Gauss with three nodes more than the degree: of two degrees beyond it one
 * shows, however symmetric f is. */
typedef struct fit {
    hpr_element_frame frame;
    size_t functions, count;
    double s[MAX_POINTS], t[MAX_POINTS], weight[MAX_POINTS], value[KINDS][MAX_POINTS];
    double coefficient[KINDS][HPR_MAX_BASIS];
    double left_out2[KINDS]; /* ∫ (f - sum_k f_k T_k)^2 dA */
} fit;

/* ‖B‖^2 of leaves and of what lies above them. */
static void find_norms(field *f)
{
    const hpr_tree *tree = f->tree;
    const hpr_elements *e = tree->elements;
    for (size_t i = e->node_count; i-- > 0;) {
        uint32_t node = tree->node[i], leaf = e->leaf_of_node[node];
        if (e->child[node] != HPR_NONE) {
            f->norm2[node] = f->norm2[e->child[node]] + f->norm2[e->child[node] + 1];
            continue;
        }
        for (size_t c = 0; c < f->losses->solution->channel_count; c++) {
            double sum2 = 0;
            for (size_t k = 0; k < e->dof[leaf + 1] - e->dof[leaf]; k++) {
                double b = hpr_losses_radiosity(f->losses, leaf, c, k);
                sum2 += b * b;
            }
            f->norm2[node] = fmax(f->norm2[node], sum2);
        }
    }
}

/* The middle of corners and how far they are from it. */
static double ball(size_t count, const double corner[4][3], double middle[3])
{
    double radius = 0, offset[3];
    for (size_t k = 0; k < 3; k++) {
        middle[k] = 0;
        for (size_t i = 0; i < count; i++)
            middle[k] += corner[i][k] / (double)count;
    }
    for (size_t i = 0; i < count; i++) {
        hpr_subtract3(corner[i], middle, offset);
        radius = fmax(radius, sqrt(hpr_dot3(offset, offset)));
    }
    return radius;
}

/* May a patch be so small and so near that the points of a fit miss it? */
static bool may_miss(const field *f, uint32_t node, const hpr_element_frame *frame)
{
    const hpr_patches *patches = f->tree->patches;
    uint32_t own = f->tree->elements->patch[node];
    hpr_cell whole = hpr_cell_whole(frame);
    hpr_vec3 at[4];
    double corner[4][3], middle[3], other[3], offset[3];
    size_t count = (size_t)hpr_cell_corners(frame, &whole, at);
    for (size_t i = 0; i < count; i++)
        hpr_vec3_store(corner[i], at[i]);
    double radius = ball(count, (const double(*)[3])corner, middle),
           spacing = 2 * radius / (frame->degree + 1);
    for (size_t j = 0; j < patches->count; j++) {
        if (j == own || j == patches->twin[own] || patches->area_m2[j] > spacing * spacing)
            continue;
        count = hpr_patch_corners(patches, j, corner);
        double reach = ball(count, (const double(*)[3])corner, other) + radius + spacing;
        hpr_subtract3(middle, other, offset);
        if (hpr_dot3(offset, offset) < reach * reach)
            return true;
    }
    return false;
}

static void sample(const field *f, uint32_t node, const hpr_polygon *outline, fit *it)
{
    const hpr_box whole = hpr_box_unit();
    hpr_cell cell[HPR_POLYGON_MAX];
    int nodes = it->frame.degree + 3, cells = hpr_cuts_cells(it->frame.shape, outline, cell);
    double area = hpr_frame_jacobian(&it->frame), point[3];
    for (int c = 0; c < cells; c++) {
        for (int k = 0; k < nodes * nodes; k++) {
            hpr_outer_point x = hpr_outer_at(&hpr_gauss, &it->frame, &cell[c], &whole, nodes, k);
            size_t i = it->count++;
            hpr_vec3_store(point, x.position);
            hpr_fractions at = hpr_losses_at(f->losses, f->tree->elements->patch[node], point);
            it->s[i] = x.s;
            it->t[i] = x.t;
            it->weight[i] = x.weight * area;
            it->value[0][i] = at.back;
            it->value[1][i] = at.out;
        }
    }
}

/* Coefficients, and then what they leave out. */
static void project(fit *it)
{
    double phi[HPR_MAX_BASIS], scale = hpr_frame_scale(&it->frame);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < it->count; i++) {
            hpr_frame_basis(&it->frame, it->s[i], it->t[i], phi);
            for (int kind = 0; kind < KINDS; kind++) {
                double *c = it->coefficient[kind], rest = it->value[kind][i];
                for (size_t k = 0; pass == 0 && k < it->functions; k++)
                    c[k] += it->weight[i] * scale * phi[k] * rest;
                for (size_t k = 0; pass == 1 && k < it->functions; k++)
                    rest -= scale * phi[k] * c[k];
                it->left_out2[kind] += pass == 1 ? it->weight[i] * rest * rest : 0;
            }
        }
    }
}

/* Takes the node, if it may, and says so. */
static bool take_node(field *f, uint32_t node)
{
    const hpr_tree *tree = f->tree;
    const uint32_t *range = tree->leaf + 2 * (size_t)node;
    fit it = {.frame = hpr_tree_frame(tree, node, tree->degree[node])};
    hpr_cuts pieces;
    hpr_losses_cut(f->losses, node, &it.frame, &pieces);
    if (pieces.count > 1 || may_miss(f, node, &it.frame))
        return false;
    it.functions = hpr_tree_count(tree, node, tree->degree[node]);
    sample(f, node, &pieces.piece[0], &it);
    project(&it);
    double share = f->losses->tolerance * (double)(range[1] - range[0]) / (double)tree->elements->leaf_count;
    for (int kind = 0; kind < KINDS; kind++) {
        if (!(it.left_out2[kind] * f->norm2[node] <= share * share))
            return false;
    }
    for (int kind = 0; kind < KINDS; kind++)
        memcpy(f->node[kind] + tree->dof[node], it.coefficient[kind], it.functions * sizeof(double));
    memset(f->losses->done + range[0], true, (range[1] - range[0]) * sizeof *f->losses->done);
    return true;
}

/* Inner nodes only: a leaf is integrated by itself. */
static bool walk(field *f, uint32_t node)
{
    const hpr_elements *e = f->tree->elements;
    if (e->child[node] == HPR_NONE || hpr_cancelled(f->tree->context))
        return false;
    if (f->tree->kind[node] == HPR_NODE_OPEN && take_node(f, node))
        return true;
    bool first = walk(f, e->child[node]), second = walk(f, e->child[node] + 1);
    return first || second;
}

/* ∫ B f over the leaves of a patch that are done. */
static void integrate(const field *f, size_t patch)
{
    const hpr_elements *e = f->tree->elements;
    size_t n = f->losses->solution->channel_count;
    for (int kind = 0; kind < KINDS; kind++)
        hpr_tree_push(f->tree, patch, f->node[kind], f->leaf[kind]);
    for (size_t leaf = e->patch_leaf[patch]; leaf < e->patch_leaf[patch + 1]; leaf++) {
        for (size_t c = 0; c < n && f->losses->done[leaf]; c++) {
            for (size_t k = 0; k < e->dof[leaf + 1] - e->dof[leaf]; k++) {
                double b = hpr_losses_radiosity(f->losses, leaf, c, k);
                for (size_t kind = 0; kind < KINDS; kind++)
                    f->losses->lost[(KINDS * leaf + kind) * n + c] += b * f->leaf[kind][e->dof[leaf] + k];
            }
        }
    }
}

hpr_status hpr_losses_on_nodes(hpr_losses *losses)
{
    const hpr_tree *tree = losses->tree;
    const hpr_elements *e = tree->elements;
    hpr_context *ctx = tree->context;
    field f = {.losses = losses, .tree = tree};
    if (e->leaf_count == e->patch_count)
        return HPR_OK;
    hpr_status status = hpr_allocate_into(ctx, &f.norm2, e->node_count, sizeof(double), "energy terms");
    for (int kind = 0; kind < KINDS; kind++) {
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &f.node[kind], tree->dof_count, sizeof(double), "energy terms");
        if (status == HPR_OK)
            status =
                hpr_allocate_into(ctx, &f.leaf[kind], e->dof[e->leaf_count], sizeof(double), "energy terms");
    }
    if (status == HPR_OK) {
        find_norms(&f);
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
        for (size_t patch = 0; patch < e->patch_count; patch++) {
            if (!losses->shaded[patch] && walk(&f, (uint32_t)patch))
                integrate(&f, patch);
        }
    }
    hpr_release(ctx, f.norm2);
    for (int kind = 0; kind < KINDS; kind++) {
        hpr_release(ctx, f.node[kind]);
        hpr_release(ctx, f.leaf[kind]);
    }
    return status;
}
