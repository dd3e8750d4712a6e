#include "solver/iterations.h"

#include <math.h>
#include <string.h>

typedef struct shooter {
    hpr_relaxation *r;
    hpr_linear_problem *p;
    double *unshot; /* [channels][dofs] the part of H that was not reflected yet */
    double *power;  /* [patches] of what is unshot, reflected: |rho u| */
    bool *reached;  /* [patches] by the last shot */
} shooter;

/* Leaves rho u of the patch in reflected. */
static double patch_power(const shooter *s, size_t patch)
{
    const hpr_elements *e = s->r->elements;
    size_t n = s->p->channel_count, first = e->dof[e->patch_leaf[patch]],
           end = e->dof[e->patch_leaf[patch + 1]];
    double sum2 = 0;
    hpr_relaxation_reflect(s->r, patch, s->unshot);
    for (size_t c = 0; c < n; c++) {
        for (size_t i = c * s->r->dofs + first; i < c * s->r->dofs + end; i++)
            sum2 += s->r->reflected[i] * s->r->reflected[i];
    }
    return sqrt(sum2);
}

/* What a patch received: added to H and to what is unshot. */
static void take_in(shooter *s, size_t patch)
{
    hpr_relaxation *r = s->r;
    const hpr_tree *tree = r->op->links->tree;
    const hpr_elements *e = r->elements;
    size_t first = e->patch_leaf[patch], end = e->patch_leaf[patch + 1];
    size_t node = tree->dof[patch],
           node_end = patch + 1 < e->patch_count ? tree->dof[patch + 1] : tree->dof_count;
    for (size_t c = 0; c < s->p->channel_count; c++) {
        double *received = r->op->received + c * tree->dof_count;
        hpr_tree_push(tree, patch, received, r->fresh + c * r->dofs);
        memset(received + node, 0, (node_end - node) * sizeof *received);
        for (size_t leaf = first; leaf < end; leaf++)
            hpr_coverage_project(s->p->coverage, leaf, r->fresh + c * r->dofs + e->dof[leaf]);
        for (size_t i = c * r->dofs + e->dof[first]; i < c * r->dofs + e->dof[end]; i++) {
            s->p->irradiance[i] += r->fresh[i];
            s->unshot[i] += r->fresh[i];
        }
    }
    s->power[patch] = patch_power(s, patch);
}

static void shoot_from(shooter *s, size_t patch)
{
    hpr_relaxation *r = s->r;
    const hpr_links *links = r->op->links;
    const hpr_tree *tree = links->tree;
    const hpr_elements *e = r->elements;
    size_t n = s->p->channel_count, first = e->dof[e->patch_leaf[patch]],
           end = e->dof[e->patch_leaf[patch + 1]];
    hpr_relaxation_reflect(r, patch, s->unshot);
    for (size_t c = 0; c < n; c++)
        memset(s->unshot + c * r->dofs + first, 0, (end - first) * sizeof *s->unshot);
    hpr_operator_send(r->op, patch, r->reflected);
    memset(s->reached, 0, e->patch_count * sizeof *s->reached);
    for (uint32_t i = tree->first[patch]; i < tree->first[patch + 1]; i++)
        hpr_links_scatter(links, tree->node[i], n, r->op->sent, r->op->received, s->reached);
    s->power[patch] = 0;
    for (size_t other = 0; other < e->patch_count; other++) {
        if (s->reached[other])
            take_in(s, other);
    }
}

/* Nothing is unshot but D, and H is that. */
static void begin(shooter *s)
{
    hpr_relaxation *r = s->r;
    const hpr_elements *e = r->elements;
    size_t n = s->p->channel_count;
    memcpy(s->p->irradiance, s->p->direct, n * r->dofs * sizeof(double));
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        for (size_t c = 0; c < n; c++)
            hpr_coverage_project(s->p->coverage, leaf, s->p->irradiance + c * r->dofs + e->dof[leaf]);
    }
    memcpy(s->unshot, s->p->irradiance, n * r->dofs * sizeof(double));
    for (size_t patch = 0; patch < e->patch_count; patch++)
        s->power[patch] = patch_power(s, patch);
}

static size_t brightest(const shooter *s, double *total)
{
    size_t best = 0;
    double sum2 = 0;
    for (size_t patch = 0; patch < s->r->elements->patch_count; patch++) {
        sum2 += s->power[patch] * s->power[patch];
        best = s->power[patch] > s->power[best] ? patch : best;
    }
    *total = sqrt(sum2);
    return best;
}

static void iterate(shooter *s, hpr_iteration *it)
{
    hpr_linear_problem *p = s->p;
    double reflectance = 0, norm2 = 0, first, rest;
    for (size_t i = 0; i < p->patches->count * p->patches->channel_count; i++)
        reflectance = fmax(reflectance, p->patches->reflectance[i]);
    for (size_t i = 0; i < p->channel_count * s->r->dofs; i++)
        norm2 += p->irradiance[i] * p->irradiance[i];
    size_t patch = brightest(s, &first);
    double target = p->tolerance * sqrt(norm2) * fmax(1 - reflectance, 1e-3);
    it->end = HPR_ITERATION_LIMIT;
    for (rest = first; p->sweeps < p->max_sweeps && rest > target; p->sweeps++) {
        shoot_from(s, patch);
        patch = brightest(s, &rest);
        it->change = rest / sqrt(norm2);
        if (hpr_cancelled(s->r->context)) {
            it->end = HPR_ITERATION_CANCELLED;
            return;
        }
        hpr_stage_progress(s->r->context, fmin(0.99, log(first / rest) / log(first / target)));
    }
    if (rest <= target)
        it->end = HPR_ITERATION_DONE;
}

hpr_status hpr_shoot(hpr_relaxation *r, hpr_iteration *it)
{
    hpr_context *ctx = r->context;
    size_t patches = r->elements->patch_count;
    shooter s = {.r = r, .p = r->problem};
    hpr_status status =
        hpr_allocate_into(ctx, &s.unshot, s.p->channel_count * r->dofs, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.power, patches, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.reached, patches, sizeof *s.reached, "the solver");
    if (status == HPR_OK) {
        begin(&s);
        iterate(&s, it);
    }
    hpr_release(ctx, s.unshot);
    hpr_release(ctx, s.power);
    hpr_release(ctx, s.reached);
    return status;
}
