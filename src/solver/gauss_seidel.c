#include "solver/gauss_seidel.h"

#include "solver/operator.h"

#include <float.h>
#include <math.h>

typedef struct sweep {
    hpr_gauss_seidel *problem;
    const hpr_elements *elements;
    hpr_context *context;
    hpr_operator *op;
    size_t dofs;
    double *reflected;       /* [channels][dofs] */
    double *fresh;           /* [channels][dofs] the newest irradiance */
    double *change2, *norm2; /* [channels][leaves] squares, summed in leaf order afterwards */
} sweep;

/* rho H on one leaf. */
static void set_reflected(sweep *s, size_t patch, size_t leaf)
{
    const hpr_gauss_seidel *p = s->problem;
    const hpr_elements *e = s->elements;
    for (size_t c = 0; c < p->channel_count; c++) {
        size_t pc = p->channel_count * patch + c, row = c * s->dofs;
        for (size_t i = row + e->dof[leaf]; i < row + e->dof[leaf + 1]; i++)
            s->reflected[i] = p->reflectance[pc] * p->irradiance[i];
    }
}

/* Squares of change and value of one leaf, and the new value taken over if `update`. */
static void compare(sweep *s, size_t leaf, bool update)
{
    const hpr_gauss_seidel *p = s->problem;
    const hpr_elements *e = s->elements;
    for (size_t c = 0; c < p->channel_count; c++) {
        double change2 = 0, norm2 = 0;
        for (size_t i = c * s->dofs + e->dof[leaf]; i < c * s->dofs + e->dof[leaf + 1]; i++) {
            double change = s->fresh[i] - p->irradiance[i];
            change2 += change * change;
            norm2 += s->fresh[i] * s->fresh[i];
            p->irradiance[i] = update ? s->fresh[i] : p->irradiance[i];
        }
        s->change2[c * e->leaf_count + leaf] = change2;
        s->norm2[c * e->leaf_count + leaf] = norm2;
    }
}

static void relax(sweep *s, size_t patch, bool update)
{
    const hpr_gauss_seidel *p = s->problem;
    const hpr_elements *e = s->elements;
    size_t first = e->patch_leaf[patch], end = e->patch_leaf[patch + 1];
    hpr_operator_receive(s->op, patch, s->fresh);
    for (size_t c = 0; c < p->channel_count; c++) {
        size_t row = c * s->dofs;
        for (size_t i = row + e->dof[first]; i < row + e->dof[end]; i++)
            s->fresh[i] += p->direct[i];
    }
    for (size_t leaf = first; leaf < end; leaf++) {
        for (size_t c = 0; c < p->channel_count; c++)
            hpr_coverage_project(p->coverage, leaf, s->fresh + c * s->dofs + e->dof[leaf]);
        compare(s, leaf, update);
    }
}

/* rho H on a patch, sent. */
static void reflect(sweep *s, size_t patch)
{
    for (size_t leaf = s->elements->patch_leaf[patch]; leaf < s->elements->patch_leaf[patch + 1]; leaf++)
        set_reflected(s, patch, leaf);
    hpr_operator_send(s->op, patch, s->reflected);
}

/* Relative change of the last pass: the worst channel. */
static double relative_change(const sweep *s)
{
    size_t leaves = s->elements->leaf_count;
    double worst = 0;
    for (size_t c = 0; c < s->problem->channel_count; c++) {
        double change2 = 0, norm2 = 0;
        for (size_t i = c * leaves; i < (c + 1) * leaves; i++) {
            change2 += s->change2[i];
            norm2 += s->norm2[i];
        }
        if (change2 > 0)
            worst = fmax(worst, sqrt(change2 / norm2));
    }
    return worst;
}

static double sweep_once(sweep *s, bool update)
{
    for (size_t patch = 0; patch < s->elements->patch_count; patch++) {
        relax(s, patch, update);
        if (update)
            reflect(s, patch);
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
    const hpr_elements *e = problem->links->tree->elements;
    hpr_context *ctx = problem->links->context;
    size_t n = problem->channel_count, dofs = e->dof[e->leaf_count];
    sweep s = {.problem = problem, .elements = e, .context = ctx, .dofs = dofs};
    hpr_status status = hpr_allocate_into(ctx, &s.reflected, dofs * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.change2, e->leaf_count * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.norm2, e->leaf_count * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s.fresh, dofs * n, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_operator_create(problem->links, n, &s.op);
    if (status == HPR_OK) {
        for (size_t patch = 0; patch < e->patch_count; patch++)
            reflect(&s, patch);
        status = iterate(&s);
        problem->residual = sweep_once(&s, false);
    }
    hpr_operator_destroy(&s.op);
    hpr_release(ctx, s.reflected);
    hpr_release(ctx, s.change2);
    hpr_release(ctx, s.norm2);
    hpr_release(ctx, s.fresh);
    return status;
}
