#include "solver/relax.h"

#include <math.h>
#include <stdlib.h>

static int compare_brightness(const void *left, const void *right)
{
    const hpr_bright_patch *a = left, *b = right;
    if (a->power != b->power)
        return a->power > b->power ? -1 : 1;
    return a->patch < b->patch ? -1 : a->patch > b->patch;
}

/* By |rho D|, what they send first. */
static void sort_patches(hpr_relaxation *r)
{
    const hpr_linear_problem *p = r->problem;
    const hpr_elements *e = r->elements;
    for (uint32_t patch = 0; patch < e->patch_count; patch++) {
        double power2 = 0;
        hpr_relaxation_reflect(r, patch, p->direct);
        for (size_t c = 0; c < p->channel_count; c++) {
            for (size_t i = e->dof[e->patch_leaf[patch]]; i < e->dof[e->patch_leaf[patch + 1]]; i++)
                power2 += r->reflected[c * r->dofs + i] * r->reflected[c * r->dofs + i];
        }
        r->order[patch] = (hpr_bright_patch){power2, patch};
    }
    qsort(r->order, e->patch_count, sizeof *r->order, compare_brightness);
}

hpr_status hpr_relaxation_init(hpr_relaxation *r, hpr_linear_problem *problem)
{
    const hpr_elements *e = problem->links->tree->elements;
    hpr_context *ctx = problem->links->context;
    size_t n = problem->channel_count, dofs = e->dof[e->leaf_count];
    *r = (hpr_relaxation){.problem = problem, .elements = e, .context = ctx, .dofs = dofs};
    hpr_status status = hpr_allocate_into(ctx, &r->reflected, dofs * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &r->change2, e->leaf_count * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &r->norm2, e->leaf_count * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &r->fresh, dofs * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_operator_create(problem->links, n, &r->op);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &r->order, e->patch_count, sizeof *r->order, "the solver");
    if (status == HPR_OK)
        sort_patches(r);
    return status;
}

void hpr_relaxation_fini(hpr_relaxation *r)
{
    hpr_operator_destroy(&r->op);
    hpr_release(r->context, r->reflected);
    hpr_release(r->context, r->change2);
    hpr_release(r->context, r->norm2);
    hpr_release(r->context, r->fresh);
    hpr_release(r->context, r->order);
}

/* Is a patch worth being shared between threads? What is done to so many leaves takes about a millisecond. */
static bool is_shared(const hpr_relaxation *r, size_t patch)
{
    enum { SHARED_LEAVES = 1 << 13 };
    return r->elements->patch_leaf[patch + 1] - r->elements->patch_leaf[patch] >= SHARED_LEAVES;
}

void hpr_relaxation_reflect(hpr_relaxation *r, size_t patch, const double *x)
{
    const hpr_elements *e = r->elements;
    size_t from = e->patch_leaf[patch], to = e->patch_leaf[patch + 1];
#pragma omp parallel for num_threads(hpr_context_threads(r->context)) if (is_shared(r, patch))
    for (size_t leaf = from; leaf < to; leaf++) {
        for (size_t c = 0; c < r->problem->channel_count; c++) {
            size_t first = c * r->dofs + e->dof[leaf];
            hpr_mass_reflect(r->problem->mass, leaf, c, 1, x + first, r->reflected + first);
        }
    }
}

/* Squares of change and value of one leaf, and the new value taken over if `update`. */
static void compare(hpr_relaxation *r, size_t leaf, double *x, bool update)
{
    const hpr_elements *e = r->elements;
    for (size_t c = 0; c < r->problem->channel_count; c++) {
        double change2 = 0, norm2 = 0;
        for (size_t i = c * r->dofs + e->dof[leaf]; i < c * r->dofs + e->dof[leaf + 1]; i++) {
            double change = r->fresh[i] - x[i];
            change2 += change * change;
            norm2 += r->fresh[i] * r->fresh[i];
            x[i] = update ? r->fresh[i] : x[i];
        }
        r->change2[c * e->leaf_count + leaf] = change2;
        r->norm2[c * e->leaf_count + leaf] = norm2;
    }
}

/* fresh holds K rho x on the leaf; D is added, what is covered left out, and the result compared with x. */
static void finish_leaf(hpr_relaxation *r, size_t leaf, double *x, bool source, bool update)
{
    const hpr_linear_problem *p = r->problem;
    const size_t *dof = r->elements->dof;
    for (size_t c = 0; c < p->channel_count; c++) {
        size_t first = c * r->dofs + dof[leaf], end = c * r->dofs + dof[leaf + 1];
        for (size_t i = first; source && i < end; i++)
            r->fresh[i] += p->direct[i];
        hpr_coverage_project(p->coverage, leaf, r->fresh + first);
    }
    compare(r, leaf, x, update);
}

static void finish_patch(hpr_relaxation *r, size_t patch, double *x, bool source, bool update)
{
    size_t from = r->elements->patch_leaf[patch], to = r->elements->patch_leaf[patch + 1];
#pragma omp parallel for num_threads(hpr_context_threads(r->context)) if (is_shared(r, patch))
    for (size_t leaf = from; leaf < to; leaf++)
        finish_leaf(r, leaf, x, source, update);
}

/* Relative change of the last pass: the worst channel. */
static double relative_change(const hpr_relaxation *r)
{
    size_t leaves = r->elements->leaf_count;
    double worst = 0;
    for (size_t c = 0; c < r->problem->channel_count; c++) {
        double change2 = 0, norm2 = 0;
        for (size_t i = c * leaves; i < (c + 1) * leaves; i++) {
            change2 += r->change2[i];
            norm2 += r->norm2[i];
        }
        if (change2 > 0)
            worst = fmax(worst, sqrt(change2 / norm2));
    }
    return r->by_patch ? hpr_relaxation_worst_patch(r) : worst;
}

/* The squares of one patch and channel, summed over its leaves. */
static double patch_sum(const hpr_relaxation *r, const double *square, size_t channel, size_t patch)
{
    const hpr_elements *e = r->elements;
    double sum = 0;
    for (size_t leaf = e->patch_leaf[patch]; leaf < e->patch_leaf[patch + 1]; leaf++)
        sum += square[channel * e->leaf_count + leaf];
    return sum;
}

double hpr_relaxation_worst_patch(const hpr_relaxation *r)
{
    static const double rounding2 = 1e-26; /* beside the brightest patch: so dark is what rounding leaves */
    const double *area = r->problem->patches->area_m2;
    double worst = 0;
    for (size_t c = 0; c < r->problem->channel_count; c++) {
        double brightest = 0;
        for (size_t patch = 0; patch < r->elements->patch_count; patch++)
            brightest = fmax(brightest, patch_sum(r, r->norm2, c, patch) / area[patch]);
        for (size_t patch = 0; patch < r->elements->patch_count; patch++) {
            double norm2 = patch_sum(r, r->norm2, c, patch);
            if (norm2 > rounding2 * brightest * area[patch])
                worst = fmax(worst, sqrt(patch_sum(r, r->change2, c, patch) / norm2));
        }
    }
    return worst;
}

double hpr_relaxation_sweep(hpr_relaxation *r, double *x, bool source)
{
    size_t patches = r->elements->patch_count;
    for (size_t patch = 0; patch < patches; patch++) {
        hpr_relaxation_reflect(r, patch, x);
        hpr_operator_send(r->op, patch, r->reflected);
    }
    for (size_t i = 0; i < patches; i++) {
        uint32_t patch = r->order[i].patch;
        hpr_operator_receive(r->op, patch, r->fresh);
        finish_patch(r, patch, x, source, true);
        hpr_relaxation_reflect(r, patch, x);
        hpr_operator_send(r->op, patch, r->reflected);
    }
    return relative_change(r);
}

double hpr_relaxation_gather(hpr_relaxation *r, double *x, bool update)
{
    size_t patches = r->elements->patch_count;
    for (size_t patch = 0; patch < patches; patch++)
        hpr_relaxation_reflect(r, patch, x);
    hpr_operator_apply(r->op, r->reflected, r->fresh);
    for (size_t patch = 0; patch < patches; patch++)
        finish_patch(r, patch, x, true, update);
    return relative_change(r);
}
