#include "solver/gauss_seidel.h"

#include <float.h>
#include <math.h>
#include <omp.h>
#include <string.h>

enum { MAX_ROW_DOFS = 289 };

typedef struct sweep {
    hpr_gauss_seidel *problem;
    const hpr_elements *elements;
    hpr_context *context;
    double *radiosity;       /* [dofs][channels] */
    double *change2, *norm2; /* [leaves][channels] squares, summed in leaf order afterwards */
    size_t scratch_values;   /* per thread */
    double *scratch;         /* [threads][scratch_values] */
} sweep;

/* B = M + rho H on one leaf. */
static void set_radiosity(sweep *s, size_t patch, size_t leaf)
{
    const hpr_gauss_seidel *p = s->problem;
    const hpr_elements *e = s->elements;
    size_t n = p->channel_count, first = e->dof[leaf] * n, count = (e->dof[leaf + 1] - e->dof[leaf]) * n;
    double constant = sqrt(e->area_m2[e->leaf[leaf]]); /* coefficient of the function 1 */
    for (size_t i = 0; i < count; i++)
        s->radiosity[first + i] = p->reflectance[n * patch + i % n] * p->irradiance[first + i];
    for (size_t c = 0; c < n; c++)
        s->radiosity[first + c] += constant * p->exitance[n * patch + c];
}

/* Gathers one leaf; keeps the new value if `update`, and the squares of change and value in any case. */
static void relax(sweep *s, size_t patch, size_t leaf, bool update)
{
    const hpr_gauss_seidel *p = s->problem;
    const hpr_elements *e = s->elements;
    size_t n = p->channel_count, first = e->dof[leaf] * n, count = (e->dof[leaf + 1] - e->dof[leaf]) * n;
    double *fresh = s->scratch + (size_t)omp_get_thread_num() * s->scratch_values;
    hpr_links_gather(p->links, patch, leaf, n, s->radiosity, fresh);
    for (size_t c = 0; c < n; c++)
        s->change2[n * leaf + c] = s->norm2[n * leaf + c] = 0;
    for (size_t i = 0; i < count; i++) {
        double change = fresh[i] - p->irradiance[first + i];
        s->change2[n * leaf + i % n] += change * change;
        s->norm2[n * leaf + i % n] += fresh[i] * fresh[i];
    }
    if (update)
        memcpy(p->irradiance + first, fresh, count * sizeof *fresh);
}

/* Relative change of the last pass: the worst channel. */
static double relative_change(const sweep *s)
{
    size_t n = s->problem->channel_count;
    double worst = 0;
    for (size_t c = 0; c < n; c++) {
        double change2 = 0, norm2 = 0;
        for (size_t leaf = 0; leaf < s->elements->leaf_count; leaf++) {
            change2 += s->change2[n * leaf + c];
            norm2 += s->norm2[n * leaf + c];
        }
        if (change2 > 0)
            worst = fmax(worst, sqrt(change2 / norm2));
    }
    return worst;
}

static double sweep_once(sweep *s, bool update)
{
    const hpr_elements *e = s->elements;
    for (size_t patch = 0; patch < e->patch_count; patch++) {
        size_t low = e->patch_leaf[patch], high = e->patch_leaf[patch + 1];
#pragma omp parallel for schedule(static) num_threads(hpr_context_threads(s->context)) if (high - low >= 8)
        for (size_t leaf = low; leaf < high; leaf++)
            relax(s, patch, leaf, update);
        for (size_t leaf = low; update && leaf < high; leaf++)
            set_radiosity(s, patch, leaf);
    }
    return relative_change(s);
}

static hpr_status no_convergence(const sweep *s, double change)
{
    return hpr_fail(
        s->context, HPR_ERR_NUMERIC,
        "no convergence after %d sweeps (relative change %.3g per sweep): where nothing is absorbed and "
        "nothing escapes there is no finite solution; --max-reflectance 0.99 scales such materials down",
        s->problem->sweeps, change);
}

static hpr_status iterate(sweep *s)
{
    /* Below this a change is rounding; a ratio this near 1 for that many sweeps is growth without end. */
    static const double rounding = 4 * DBL_EPSILON, standstill = 1e-7;
    enum { STANDSTILL_SWEEPS = 50 };
    hpr_gauss_seidel *p = s->problem;
    double before = 0, change = 0, start = -1;
    int still = 0;
    for (p->sweeps = 0; p->sweeps < p->max_sweeps;) {
        change = sweep_once(s, true);
        p->sweeps++;
        double ratio = before > 0 ? change / before : 0;
        if (hpr_cancelled(s->context))
            return hpr_fail(s->context, HPR_ERR_INTERRUPTED, "interrupted while solving");
        if (change <= rounding ||
            (p->sweeps > 2 && ratio < 1 && change * ratio / (1 - ratio) <= p->tolerance))
            return HPR_OK;
        still = p->sweeps > 2 && ratio > 1 - standstill ? still + 1 : 0;
        if (still >= STANDSTILL_SWEEPS || !isfinite(change))
            return no_convergence(s, change);
        start = start < 0 ? log(change) : start;
        hpr_stage_progress(s->context, fmin(0.99, (start - log(change)) / (start - log(p->tolerance))));
        before = change;
    }
    return no_convergence(s, change);
}

hpr_status hpr_gauss_seidel_solve(hpr_gauss_seidel *problem)
{
    const hpr_elements *e = problem->links->elements;
    hpr_context *ctx = problem->links->context;
    size_t n = problem->channel_count, dofs = e->dof[e->leaf_count];
    sweep s = {.problem = problem, .elements = e, .context = ctx, .scratch_values = MAX_ROW_DOFS * n};
    hpr_status status = hpr_allocate_into(ctx, &s.radiosity, dofs * n, sizeof(double), "radiosity");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.change2, e->leaf_count * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.norm2, e->leaf_count * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.scratch, (size_t)hpr_context_threads(ctx) * s.scratch_values,
                                   sizeof(double), "the solver");
    if (status == HPR_OK) {
        for (size_t patch = 0; patch < e->patch_count; patch++) {
            for (size_t leaf = e->patch_leaf[patch]; leaf < e->patch_leaf[patch + 1]; leaf++)
                set_radiosity(&s, patch, leaf);
        }
        status = iterate(&s);
        problem->residual = sweep_once(&s, false);
    }
    hpr_release(ctx, s.radiosity);
    hpr_release(ctx, s.change2);
    hpr_release(ctx, s.norm2);
    hpr_release(ctx, s.scratch);
    return status;
}
