#include "solver/tolerance.h"

#include "solver/adapt.h"
#include "solver/residual.h"
#include "solver/setup.h"
#include "solver/transport.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* One solve of the series. */
typedef struct step {
    hpr_transport light;
    double *indirect;         /* [dofs][channels] */
    hpr_indicator *indicator; /* [leaf_count] */
    double *norm2, *error2;   /* [channels] of the whole H, of what is left out */
    double *weight;           /* [channels] 1 / norm2 */
} step;

static void close_step(const hpr_solution *solution, step *s)
{
    hpr_context *ctx = solution->context;
    hpr_transport_fini(&s->light);
    void *arrays[] = {s->indirect, s->indicator, s->norm2, s->error2, s->weight};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    *s = (step){0};
}

static hpr_status allocate(const hpr_solution *solution, step *s)
{
    hpr_context *ctx = solution->context;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    hpr_status status = hpr_allocate_into(ctx, &s->indirect, n * dofs, sizeof(double), "the error estimate");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s->indicator, solution->elements->leaf_count, sizeof *s->indicator,
                                   "the error estimate");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s->norm2, n, sizeof(double), "the error estimate");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s->error2, n, sizeof(double), "the error estimate");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &s->weight, n, sizeof(double), "the error estimate");
    return status;
}

/* Of the worst channel; and of all together what marking goes by. */
static double estimate(hpr_solution *solution, step *s, double *all)
{
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        double open = hpr_coverage_open_share(s->light.coverage, leaf);
        for (size_t k = n * e->dof[leaf]; k < n * e->dof[leaf + 1]; k++)
            s->norm2[k % n] += open * solution->irradiance[k] * solution->irradiance[k];
    }
    for (size_t i = 0; i < n * dofs; i++)
        s->indirect[i] = solution->irradiance[i] - s->light.direct[i % n * dofs + i / n];
    for (size_t c = 0; c < n; c++)
        s->weight[c] = s->norm2[c] > 0 ? 1 / s->norm2[c] : 0;
    hpr_indicate(solution, s->light.coverage, s->indirect, s->weight, s->indicator, s->error2);
    double worst = 0;
    *all = 0;
    for (size_t c = 0; c < n; c++) {
        worst = fmax(worst, sqrt(s->error2[c] * s->weight[c]));
        *all += s->error2[c] * s->weight[c];
    }
    *all = sqrt(*all);
    return worst;
}

hpr_status hpr_tolerance_solve(hpr_solution *solution)
{
    enum { MAX_STEPS = 60 };
    static const double safety = 1.5, aim = 0.8;
    const hpr_solve_options *options = &solution->summary.options;
    double tolerance = options->tolerance;
    const hpr_transport_demand demand = {
        .link_tolerance = options->link_tolerance > 0 ? options->link_tolerance : fmax(tolerance / 10, 1e-13),
        .block_tolerance = options->block_tolerance,
        .direct_tolerance = fmax(tolerance / 100, 1e-12),
        .solver_tolerance = fmax(tolerance / 100, 1e-13)};
    hpr_status status = HPR_OK;
    for (int count = 0; status == HPR_OK && count < MAX_STEPS; count++) {
        step s = {0};
        double error = 0, all = 0;
        size_t refined = 0;
        status = hpr_setup_arrays(solution);
        if (status == HPR_OK)
            status = hpr_transport_solve(solution, &demand, &s.light);
        if (status == HPR_OK)
            status = allocate(solution, &s);
        if (status == HPR_OK) {
            error = safety * estimate(solution, &s, &all);
            hpr_residual residual = {0};
            hpr_stage_begin(solution->context, "error estimate");
            status = hpr_residual_measure(solution, &s.light, s.indirect, s.norm2, fmax(tolerance / 100, 1e-12), 256,
                                          s.indicator, &residual);
            hpr_stage_end(solution->context);
            if (getenv("HPR_TRACE"))
                fprintf(stderr, "  measured %.3e +- %.3e\n", sqrt(residual.error2),
                        0.5 * residual.standard_error2 / sqrt(residual.error2));
            if (getenv("HPR_TRACE"))
                fprintf(stderr, "step %d: elements %zu dofs %zu links %zu error %.3e\n", count,
                        solution->elements->leaf_count, solution->summary.dof_count, solution->summary.link_count,
                        error);
            solution->summary.error_estimate = error;
        }
        bool done = error <= tolerance;
        if (status == HPR_OK && !done)
            status = hpr_adapt(solution, s.indicator, options->refine,
                               aim * tolerance / safety * all * safety / error, &refined);
        if (status == HPR_OK && (done || refined == 0))
            status = hpr_transport_finish(solution, &s.light);
        close_step(solution, &s);
        if (done || refined == 0)
            break;
    }
    return status;
}
