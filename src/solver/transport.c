#include "solver/transport.h"

#include "direct/direct.h"
#include "link/afford.h"
#include "link/direct_moments.h"
#include "patch/paint.h"
#include "solver/energy.h"
#include "solver/linear.h"
#include "solver/operator.h"
#include "solver/outside.h"

#include <math.h>
#include <string.h>

static bool channels_agree(const hpr_solution *solution)
{
    const hpr_patches *patches = solution->patches;
    size_t n = patches->channel_count;
    for (size_t c = 1; c < n; c++) {
        if (solution->environment[c] != solution->environment[0])
            return false;
    }
    return hpr_patches_are_grey(patches);
}

size_t hpr_solution_distinct_channels(const hpr_solution *solution)
{
    return channels_agree(solution) ? 1 : solution->channel_count;
}

/* Solves as many channels as differ. direct: [channels][dofs] */
static hpr_status solve_system(hpr_solution *solution, const hpr_transport *t, double tolerance)
{
    hpr_context *ctx = solution->context;
    const hpr_patches *patches = solution->patches;
    const hpr_solve_options *options = &solution->summary.options;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    size_t solved = hpr_solution_distinct_channels(solution);
    hpr_linear_problem problem = {.patches = patches,
                                  .links = t->links,
                                  .channel_count = solved,
                                  .coverage = t->coverage,
                                  .direct = t->direct,
                                  .mass = &t->mass,
                                  .method = options->solver,
                                  .tolerance = tolerance,
                                  .max_sweeps = options->max_sweeps};
    hpr_status status =
        hpr_allocate_into(ctx, &problem.irradiance, dofs * solved, sizeof(double), "the solver");
    if (status == HPR_OK) {
        memcpy(problem.irradiance, t->direct, dofs * solved * sizeof *t->direct);
        status = hpr_linear_solve(&problem);
        for (size_t i = 0; i < n * dofs; i++)
            solution->irradiance[i] = problem.irradiance[(solved == 1 ? 0 : i % n) * dofs + i / n];
    }
    solution->summary.channels_solved = solved;
    solution->summary.solver = (int)problem.used;
    solution->summary.sweeps = problem.sweeps;
    solution->summary.residual = problem.residual;
    hpr_release(ctx, problem.irradiance);
    return status;
}

/* D = K M: through the blocks; of all patches, or of those on which M varies. */
static hpr_status gather_direct(const hpr_solution *solution, const hpr_transport *t, bool all,
                                double *direct)
{
    hpr_context *ctx = solution->context;
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    double *emission = NULL;
    hpr_operator *op = NULL;
    hpr_status status = hpr_allocate_into(ctx, &emission, n * dofs, sizeof(double), "direct light");
    if (status != HPR_OK)
        return status;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        for (size_t c = 0; c < n && (all || hpr_mass_glows(&t->mass, leaf)); c++)
            hpr_mass_emit(&t->mass, leaf, c, emission + c * dofs + e->dof[leaf]);
    }
    status = hpr_operator_create(t->links, n, &op);
    if (status == HPR_OK)
        hpr_operator_apply(op, emission, direct);
    hpr_operator_destroy(&op);
    hpr_release(ctx, emission);
    return status;
}

/* The moments of D by clipping: where D jumps the quadrature is cut, so that what the elements cannot show of
 * D is orthogonal to what they send. */
static hpr_status project_direct(hpr_solution *solution, const hpr_coverage *coverage,
                                 const hpr_transport_demand *demand, double *direct)
{
    hpr_direct *emitters = NULL;
    size_t short_count = 0;
    hpr_status status = hpr_direct_create(solution->patches, solution->elements, &emitters);
    if (status == HPR_OK)
        status = hpr_direct_moments(emitters, coverage, solution->elements, demand->open_direct_tolerance,
                                    demand->direct_tolerance, direct, &short_count);
    hpr_direct_destroy(&emitters);
    return status;
}

static void summarise_links(hpr_solution *solution, const hpr_links *links)
{
    hpr_solve_summary *summary = &solution->summary;
    summary->link_count = links->count;
    summary->block_bytes = links->block_count * sizeof(double);
    summary->link_tolerance = links->link_tolerance;
    summary->link_error = links->link_error;
    summary->block_tolerance = links->tolerance;
    summary->blocked_tolerance = links->blocked_tolerance;
    summary->visibility_error = links->sampling_error;
    summary->short_count = links->short_count;
    summary->block_error = links->block_error;
    summary->sampled_error = links->sampled_error;
    summary->occluded = links->occluded;
    if (links->short_count)
        hpr_warn(solution->context, "%zu kernel blocks stopped short of their tolerance", links->short_count);
}

/* A step towards a tolerance was predicted to stay within max_bytes: it may outgrow that by a factor of 2. */
static double most_bytes(const hpr_solve_options *options)
{
    return options->tolerance > 0 ? fmax(hpr_links_most_bytes(0), 2 * options->max_bytes)
                                  : options->max_bytes;
}

/* Does what a patch emits go through links? */
static bool emits_through_links(const hpr_solution *solution, size_t patch)
{
    return solution->summary.direct == HPR_DIRECT_GALERKIN || hpr_patch_glow(solution->patches, patch);
}

/* Which patches send, and how much brighter than the mean those are that emit, in the channel where most. */
static void find_senders(const hpr_solution *solution, bool *sends, double *brightness)
{
    const hpr_patches *patches = solution->patches;
    size_t n = patches->channel_count;
    double area = 0;
    for (size_t i = 0; i < patches->count; i++) {
        brightness[i] = 1;
        area += patches->area_m2[i];
    }
    for (size_t c = 0; c < n; c++) {
        double power = 0;
        for (size_t i = 0; i < patches->count; i++)
            power += patches->exitance[n * i + c] * patches->area_m2[i];
        for (size_t i = 0; i < patches->count; i++) {
            bool emits = emits_through_links(solution, i) && patches->exitance[n * i + c] > 0;
            sends[i] |= emits || patches->reflectance[n * i + c] > 0;
            if (emits)
                brightness[i] = fmax(brightness[i], patches->exitance[n * i + c] * area / power);
        }
    }
}

static hpr_status link_up(const hpr_solution *solution, const hpr_coverage *coverage,
                          const hpr_transport_demand *asked, bool counted, hpr_links **links)
{
    const hpr_patches *patches = solution->patches;
    bool *sends = NULL;
    double *brightness = NULL;
    hpr_status status = hpr_allocate_into(solution->context, &sends, patches->count, sizeof *sends, "links");
    if (status == HPR_OK)
        status =
            hpr_allocate_into(solution->context, &brightness, patches->count, sizeof *brightness, "links");
    if (status != HPR_OK) {
        hpr_release(solution->context, sends);
        return status;
    }
    find_senders(solution, sends, brightness);
    const hpr_solve_options *options = &solution->summary.options;
    const hpr_links_demand demand = {.link_tolerance = asked->link_tolerance,
                                     .block_tolerance = asked->block_tolerance,
                                     .blocked_tolerance = asked->blocked_tolerance,
                                     .known = asked->known,
                                     .keeper = asked->keeper,
                                     .counted = counted,
                                     .constant = options->method == HPR_METHOD_HIERARCHICAL,
                                     .most_bytes = most_bytes(options),
                                     .sends = sends,
                                     .brightness = brightness};
    status = hpr_links_assemble(coverage, solution->elements, &demand, links);
    hpr_release(solution->context, sends);
    hpr_release(solution->context, brightness);
    return status;
}

static hpr_status allocate(const hpr_solution *solution, hpr_transport *t)
{
    hpr_context *ctx = solution->context;
    size_t dofs = solution->summary.dof_count;
    hpr_status status =
        hpr_allocate_into(ctx, &t->direct, solution->channel_count * dofs, sizeof(double), "direct light");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &t->outside, dofs, sizeof(double), "light from outside");
    return status;
}

static hpr_status find_direct(hpr_solution *solution, const hpr_transport_demand *demand, hpr_transport *t)
{
    size_t count = solution->channel_count * solution->summary.dof_count;
    bool exact = solution->summary.direct == HPR_DIRECT_EXACT;
    hpr_stage_begin(solution->context, "direct light");
    hpr_status status = exact ? project_direct(solution, t->coverage, demand, t->direct)
                              : gather_direct(solution, t, true, t->direct);
    if (status == HPR_OK && exact && t->mass.glow)
        status = hpr_allocate_into(solution->context, &t->glow, count, sizeof(double), "direct light");
    if (status == HPR_OK && t->glow)
        status = gather_direct(solution, t, false, t->glow);
    for (size_t i = 0; status == HPR_OK && t->glow && i < count; i++)
        t->direct[i] += t->glow[i];
    hpr_stage_end(solution->context);
    return status;
}

static hpr_status find_outside(hpr_solution *solution, hpr_transport *t)
{
    if (!hpr_outside_shines(solution))
        return HPR_OK;
    hpr_stage_begin(solution->context, "environment");
    hpr_status status = hpr_outside_project(solution, t->coverage, t->outside);
    hpr_stage_end(solution->context);
    hpr_outside_add(solution, t->outside, t->direct);
    return status;
}

static void project_on_open(const hpr_solution *solution, hpr_transport *t)
{
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        for (size_t c = 0; c < n; c++)
            hpr_coverage_project(t->coverage, leaf, t->direct + c * dofs + e->dof[leaf]);
    }
}

/* The moments of D become the coefficients of what is evaluated at points. */
static void split(hpr_solution *solution, hpr_transport *t)
{
    for (size_t i = 0; t->glow && i < solution->channel_count * solution->summary.dof_count; i++)
        t->direct[i] -= t->glow[i];
    hpr_outside_split(solution, t->outside, t->direct);
    project_on_open(solution, t);
}

static hpr_status open_up(const hpr_solution *solution, const hpr_transport_demand *demand, bool counted,
                          hpr_transport *t)
{
    *t = (hpr_transport){.keeper = demand->keeper};
    hpr_stage_begin(solution->context, "assembly");
    hpr_status status = hpr_coverage_create(solution->patches, solution->elements, &t->coverage);
    if (status == HPR_OK)
        status = hpr_mass_init(solution->patches, solution->elements, t->coverage, &t->mass);
    if (status == HPR_OK)
        status = link_up(solution, t->coverage, demand, counted, &t->links);
    hpr_stage_end(solution->context);
    return status == HPR_OK ? allocate(solution, t) : status;
}

hpr_status hpr_transport_solve(hpr_solution *solution, const hpr_transport_demand *demand, hpr_transport *t)
{
    hpr_context *ctx = solution->context;
    hpr_status status = open_up(solution, demand, false, t);
    if (status == HPR_OK) {
        summarise_links(solution, t->links);
        status = find_direct(solution, demand, t);
    }
    if (status == HPR_OK)
        status = find_outside(solution, t);
    if (status == HPR_OK) {
        hpr_stage_begin(ctx, "solver");
        status = solve_system(solution, t, demand->solver_tolerance);
        hpr_stage_end(ctx);
    }
    if (status == HPR_OK)
        split(solution, t);
    return status;
}

hpr_status hpr_transport_finish(hpr_solution *solution, const hpr_transport *t)
{
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    hpr_stage_begin(solution->context, "energy");
    hpr_status status = hpr_energy_compute(solution, t->coverage, &t->mass, t->links, t->outside);
    hpr_stage_end(solution->context);
    for (size_t i = 0; status == HPR_OK && i < n * dofs; i++)
        solution->irradiance[i] -= t->direct[i % n * dofs + i / n];
    return status;
}

hpr_status hpr_transport_restore(hpr_solution *solution, const hpr_transport_demand *demand, hpr_transport *t)
{
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    hpr_status status = open_up(solution, demand, true, t);
    hpr_stage_begin(solution->context, "direct light");
    if (status == HPR_OK && solution->summary.direct == HPR_DIRECT_EXACT)
        status = project_direct(solution, t->coverage, demand, t->direct);
    hpr_stage_end(solution->context);
    if (status == HPR_OK)
        status = find_outside(solution, t);
    if (status != HPR_OK)
        return status;
    hpr_outside_weigh(solution, t->outside, t->direct);
    project_on_open(solution, t);
    for (size_t i = 0; i < n * dofs; i++)
        solution->irradiance[i] += t->direct[i % n * dofs + i / n];
    return HPR_OK;
}

hpr_status hpr_transport_count(const hpr_solution *solution, const hpr_transport_demand *demand,
                               hpr_transport *t)
{
    *t = (hpr_transport){0};
    hpr_status status = hpr_coverage_create(solution->patches, solution->elements, &t->coverage);
    return status == HPR_OK ? link_up(solution, t->coverage, demand, true, &t->links) : status;
}

void hpr_transport_fini(hpr_transport *t)
{
    if (!t->coverage)
        return;
    hpr_context *ctx = hpr_coverage_patches(t->coverage)->context;
    hpr_release(ctx, t->direct);
    hpr_release(ctx, t->outside);
    hpr_release(ctx, t->glow);
    hpr_mass_fini(&t->mass);
    hpr_links_destroy(&t->links);
    hpr_coverage_destroy(&t->coverage);
}
