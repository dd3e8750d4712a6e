#include "solver/operator.h"

/*
 * Multiplications from which work is shared between threads. They take about a millisecond. libgomp lets a
 * thread spin for some three while it waits for another that a busy machine does not run: much shorter shares
 * would burn many times what they save.
 */
enum { SHARED_WORK = 1 << 21 };

static void count_work(hpr_operator *op)
{
    const hpr_links *links = op->links;
    const uint32_t *patch = links->tree->elements->patch;
    for (size_t l = 0; l < links->count; l++) {
        const hpr_link *link = &links->link[l];
        size_t size = hpr_link_size(links, link);
        op->work[patch[link->recv]] += size;
        op->work[patch[link->send]] += size;
    }
}

hpr_status hpr_operator_create(const hpr_links *links, size_t channel_count, hpr_operator **out)
{
    hpr_context *ctx = links->context;
    const hpr_elements *e = links->tree->elements;
    hpr_operator *op = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &op, 1, sizeof *op, "the solver");
    if (status != HPR_OK)
        return status;
    op->links = links;
    op->channel_count = channel_count;
    op->leaf_dofs = e->dof[e->leaf_count];
    op->node_dofs = links->tree->dof_count;
    status = hpr_allocate_into(ctx, &op->sent, channel_count * op->node_dofs, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &op->received, channel_count * op->node_dofs, sizeof(double),
                                   "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &op->work, e->patch_count, sizeof *op->work, "the solver");
    if (status == HPR_OK)
        count_work(op);
    else
        hpr_operator_destroy(&op);
    *out = op;
    return status;
}

void hpr_operator_destroy(hpr_operator **out)
{
    hpr_operator *op = *out;
    if (!op)
        return;
    hpr_context *ctx = op->links->context;
    hpr_release(ctx, op->sent);
    hpr_release(ctx, op->received);
    hpr_release(ctx, op->work);
    hpr_release(ctx, op);
    *out = NULL;
}

void hpr_operator_send(hpr_operator *op, size_t patch, const double *radiosity)
{
    for (size_t c = 0; c < op->channel_count; c++)
        hpr_tree_pull(op->links->tree, patch, radiosity + c * op->leaf_dofs, op->sent + c * op->node_dofs);
}

/* What all nodes of a patch received, on its leaves. */
static void push(hpr_operator *op, size_t patch, double *irradiance)
{
    for (size_t c = 0; c < op->channel_count; c++)
        hpr_tree_push(op->links->tree, patch, op->received + c * op->node_dofs,
                      irradiance + c * op->leaf_dofs);
}

void hpr_operator_receive(hpr_operator *op, size_t patch, double *irradiance)
{
    const hpr_tree *tree = op->links->tree;
    size_t first = tree->first[patch], end = tree->first[patch + 1];
    bool shared = op->channel_count * op->work[patch] >= SHARED_WORK;
#pragma omp parallel for schedule(dynamic, 64) num_threads(hpr_context_threads(tree->context)) if (shared)
    for (size_t i = first; i < end; i++)
        hpr_links_gather(op->links, tree->node[i], op->channel_count, op->sent, op->received);
    push(op, patch, irradiance);
}

void hpr_operator_apply(hpr_operator *op, const double *radiosity, double *irradiance)
{
    const hpr_tree *tree = op->links->tree;
    size_t patches = tree->elements->patch_count, work = 0;
    for (size_t patch = 0; patch < patches; patch++)
        work += op->channel_count * op->work[patch];
#pragma omp parallel num_threads(hpr_context_threads(tree->context)) if (work >= SHARED_WORK)
    {
#pragma omp for schedule(dynamic, 1)
        for (size_t patch = 0; patch < patches; patch++)
            hpr_operator_send(op, patch, radiosity);
#pragma omp for schedule(dynamic, 64)
        for (size_t node = 0; node < tree->elements->node_count; node++)
            hpr_links_gather(op->links, node, op->channel_count, op->sent, op->received);
#pragma omp for schedule(dynamic, 1)
        for (size_t patch = 0; patch < patches; patch++)
            push(op, patch, irradiance);
    }
}
