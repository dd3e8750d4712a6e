#include "solver/iterations.h"

#include <float.h>
#include <math.h>

const char *hpr_solver_name(hpr_solver_method method)
{
    static const char *const names[] = {
        [HPR_SOLVER_AUTO] = "auto",         [HPR_SOLVER_GAUSS_SEIDEL] = "gauss-seidel",
        [HPR_SOLVER_GMRES] = "gmres",       [HPR_SOLVER_GATHERING] = "gathering",
        [HPR_SOLVER_SHOOTING] = "shooting", [HPR_SOLVER_DIRECT] = "direct",
    };
    return names[method];
}

hpr_iteration hpr_iterate(hpr_relaxation *r, hpr_relaxation_step *step, bool gives_up)
{
    /* Below this a change is rounding; a ratio this near 1 for that many sweeps is growth without end. */
    static const double rounding = 4 * DBL_EPSILON, standstill = 1e-7;
    enum { STANDSTILL_SWEEPS = 50, TRIAL_SWEEPS = 4, MANY_SWEEPS = 20 };
    hpr_linear_problem *p = r->problem;
    hpr_iteration it = {HPR_ITERATION_LIMIT, 0, 0};
    double before = 0, start = -1;
    int still = 0;
    while (p->sweeps < p->max_sweeps) {
        it.change = step(r, p->irradiance, true);
        p->sweeps++;
        double ratio = it.ratio = before > 0 ? it.change / before : 0;
        if (hpr_cancelled(r->context)) {
            it.end = HPR_ITERATION_CANCELLED;
            return it;
        }
        bool known = p->sweeps > 2 && ratio < 1;
        if (it.change <= rounding || (known && it.change * ratio / (1 - ratio) <= p->tolerance)) {
            it.end = HPR_ITERATION_DONE;
            return it;
        }
        if (gives_up && p->sweeps >= TRIAL_SWEEPS &&
            (!known || log(p->tolerance * (1 - ratio) / it.change) / log(ratio) > MANY_SWEEPS)) {
            it.end = HPR_ITERATION_SLOW;
            return it;
        }
        still = p->sweeps > 2 && ratio > 1 - standstill ? still + 1 : 0;
        if (still >= STANDSTILL_SWEEPS || !isfinite(it.change)) {
            it.end = HPR_ITERATION_STANDSTILL;
            return it;
        }
        start = start < 0 ? log(it.change) : start;
        hpr_stage_progress(r->context, fmin(0.99, (start - log(it.change)) / (start - log(p->tolerance))));
        before = it.change;
    }
    return it;
}

static hpr_status run(hpr_relaxation *r, hpr_iteration *it)
{
    hpr_linear_problem *p = r->problem;
    p->used = p->method == HPR_SOLVER_AUTO ? HPR_SOLVER_GAUSS_SEIDEL : p->method;
    switch (p->used) {
    case HPR_SOLVER_GATHERING:
        *it = hpr_iterate(r, hpr_relaxation_gather, false);
        return HPR_OK;
    case HPR_SOLVER_SHOOTING:
        return hpr_shoot(r, it);
    case HPR_SOLVER_GMRES:
        return hpr_gmres(r, 0, it);
    default:
        *it = hpr_iterate(r, hpr_relaxation_sweep, p->method == HPR_SOLVER_AUTO);
        if (it->end != HPR_ITERATION_SLOW)
            return HPR_OK;
        p->used = HPR_SOLVER_GMRES;
        return hpr_gmres(r, it->ratio, it);
    }
}

static hpr_status failure(const hpr_relaxation *r, const hpr_iteration *it)
{
    if (it->end == HPR_ITERATION_CANCELLED)
        return hpr_fail(r->context, HPR_ERR_INTERRUPTED, "interrupted while solving");
    return hpr_fail(
        r->context, HPR_ERR_NUMERIC,
        "no convergence after %d sweeps (relative change %.3g per sweep): where nothing is absorbed and "
        "nothing escapes there is no finite solution; --max-reflectance 0.99 scales such materials down",
        r->problem->sweeps, it->change);
}

/*
 * A patch that is 1e10 times darker than others, as in a room of its own, is nothing in the norm of all: its
 * error may be as large as itself. Where some patch has not settled, the iteration goes on with the worst
 * patch as its measure. Patches so dark that rounding feeds them may not settle at all, which is no failure.
 */
static hpr_status settle_patches(hpr_relaxation *r)
{
    static const double least = 1e-10, part = 1e3;
    enum { MOST_SWEEPS = 200 };
    hpr_linear_problem *p = r->problem, rest = *p;
    hpr_iteration it = {0};
    rest.tolerance = fmax(least, part * p->tolerance);
    if (!(hpr_relaxation_worst_patch(r) > rest.tolerance))
        return HPR_OK;
    rest.sweeps = 0;
    rest.max_sweeps = p->max_sweeps < MOST_SWEEPS ? p->max_sweeps : MOST_SWEEPS;
    r->problem = &rest;
    r->by_patch = true;
    hpr_status status = HPR_OK;
    it = hpr_iterate(r, hpr_relaxation_sweep, true);
    if (it.end == HPR_ITERATION_SLOW)
        status = hpr_gmres(r, it.ratio, &it);
    r->problem = p;
    r->by_patch = false;
    p->sweeps += rest.sweeps;
    if (status == HPR_OK && it.end == HPR_ITERATION_CANCELLED)
        status = failure(r, &it);
    if (status == HPR_OK)
        p->residual = hpr_relaxation_gather(r, p->irradiance, false);
    return status;
}

hpr_status hpr_linear_solve(hpr_linear_problem *problem)
{
    hpr_relaxation r;
    hpr_iteration it = {0};
    problem->sweeps = 0;
    hpr_status status = hpr_relaxation_init(&r, problem);
    if (status == HPR_OK)
        status = run(&r, &it);
    if (status == HPR_OK && it.end != HPR_ITERATION_DONE)
        status = failure(&r, &it);
    if (status == HPR_OK)
        problem->residual = hpr_relaxation_gather(&r, problem->irradiance, false);
    if (status == HPR_OK)
        status = settle_patches(&r);
    hpr_relaxation_fini(&r);
    return status;
}
