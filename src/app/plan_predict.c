#include "app/plan_predict.h"

#include "app/plan_trial.h"
#include "solver/tolerance.h"

#include <math.h>

/* Of the program and of each patch: read, kept, written. */
static const double megabyte = 1e6, program_mb = 20, patch_mb = 0.003, patch_s = 3e-5;

typedef struct load {
    double links, block_mb, partly; /* of the links the part that see partly */
} load;

static hpr_status count_links(const hpr_solution *solution, const hpr_solve_options *options, load *out)
{
    hpr_transport_demand demand = {.link_tolerance = options->link_tolerance,
                                   .block_tolerance = options->block_tolerance};
    if (options->tolerance > 0)
        demand = hpr_tolerance_demand(options);
    hpr_transport transport;
    hpr_status status = hpr_transport_count(solution, &demand, &transport);
    if (status == HPR_OK) {
        const hpr_links *links = transport.links;
        double count = (double)links->count;
        *out = (load){.links = count,
                      .block_mb = (double)links->block_count * sizeof(double) / megabyte,
                      .partly = count > 0 ? (double)links->partly_count / count : 0};
    }
    hpr_transport_fini(&transport);
    return status;
}

/* One link for every pair of leaves of patches that see each other; it takes 40 bytes beside its block. */
static load guess_links(const hpr_solution *solution, const hpr_plan *plan)
{
    double n = (double)plan->patch_count, seen = plan->pairs_visible + plan->pairs_partial;
    double leaves = (double)solution->summary.element_count / n,
           dofs = (double)solution->summary.dof_count / n;
    return (load){.links = seen * leaves * leaves,
                  .block_mb =
                      (seen * (dofs * dofs * sizeof(double) + leaves * leaves * 40) + n * n) / megabyte,
                  .partly = seen > 0 ? plan->pairs_partial / seen : 0};
}

/* Of coefficients. */
static double find_growth(const hpr_plan *plan, const hpr_outlook *outlook, double tolerance)
{
    static const double open_edge = 3.6, open_power = 0.5, blocked_edge = 0.1, blocked_power = 0.7,
                        open = 2.2, blocked = 1.3, near = 0.6;
    bool partial = plan->pairs_partial > 0;
    if (!outlook->lit || outlook->uniform || plan->pairs_visible + plan->pairs_partial == 0)
        return 1;
    if (outlook->gap == 0)
        return fmax(
            1, pow((partial ? blocked_edge : open_edge) / tolerance, partial ? blocked_power : open_power));
    return (partial ? blocked : open) * (1 + near * fmax(0, 1 / outlook->gap - 1));
}

/* The part of it that goes to higher degrees, elements making the rest: more where it began low. */
static double find_rise(const hpr_outlook *outlook, double growth, double tolerance)
{
    static const double highest = 4e-4, power = 0.31;
    return outlook->gap == 0 ? fmin(growth, fmax(1, pow(tolerance / highest, power))) : growth;
}

/* CPU seconds to a tolerance: of the trial, more for more coefficients and, past obstacles, for more digits.
 */
static double adaptive_seconds(const hpr_plan *plan, const hpr_outlook *outlook, double tolerance,
                               double growth)
{
    static const double open_power = 0.95, coarser_power = 0.2, finer_power = 0.35;
    if (!(plan->pairs_partial > 0))
        return outlook->trial_cpu_s * pow(growth, open_power);
    double digits = hpr_plan_trial_tolerance / tolerance;
    return outlook->trial_cpu_s * growth * pow(digits, digits < 1 ? coarser_power : finer_power);
}

hpr_status hpr_plan_predict(const hpr_solution *begun, const hpr_plan *plan, const hpr_outlook *outlook,
                            double tolerance, hpr_plan_cost *cost)
{
    load first = {0};
    hpr_status status = HPR_OK;
    const hpr_solve_options *options = &begun->summary.options;
    if (!outlook->lit)
        first = (load){0};
    else if (plan->patch_count <= HPR_PLAN_FEW_PATCHES)
        status = count_links(begun, options, &first);
    else
        first = guess_links(begun, plan);
    double g = tolerance > 0 ? find_growth(plan, outlook, tolerance) : 1;
    double pieces = tolerance > 0 ? g / find_rise(outlook, g, tolerance) : 1;
    double mb = first.block_mb * pow(g, 1.7);
    *cost = (hpr_plan_cost){.elements = (double)begun->summary.element_count * pieces,
                            .dofs = (double)begun->summary.dof_count * g,
                            .links = first.links * pow(pieces, 1.5)};
    double patches = (double)plan->patch_count, base_mb = program_mb + patch_mb * patches;
    if (tolerance > 0) {
        cost->memory_bytes = megabyte * (base_mb + 3 * mb);
        cost->cpu_s = isnan(outlook->trial_error) ? 0.1 + (plan->pairs_partial > 0 ? 0.3 : 0.12) * mb
                                                  : adaptive_seconds(plan, outlook, tolerance, g);
    } else {
        cost->memory_bytes = megabyte * (base_mb + 1.05 * mb);
        cost->cpu_s = outlook->slowness * (0.17 + (0.065 + 0.145 * first.partly) * mb);
    }
    cost->cpu_s += patch_s * patches;
    return status;
}
