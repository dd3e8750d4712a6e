/* From a scene to a solution: patches, elements, links, the linear system, the energy balance. */
#include "solver/estimate.h"
#include "solver/outside.h"
#include "solver/setup.h"
#include "solver/tolerance.h"
#include "solver/transport.h"

#include <math.h>

void hpr_solve_options_init(hpr_solve_options *options)
{
    *options = (hpr_solve_options){.order = HPR_CHOOSE,
                                   .subdivide = HPR_CHOOSE,
                                   .feet = HPR_CHOOSE,
                                   .element_size = HPR_CHOOSE,
                                   .solver_tolerance = 1e-13,
                                   .max_sweeps = 20000};
}

const char *hpr_method_name(hpr_method method)
{
    static const char *const names[] = {
        [HPR_METHOD_GALERKIN] = "galerkin", [HPR_METHOD_HIERARCHICAL] = "hierarchical",
        [HPR_METHOD_HEMICUBE] = "hemicube", [HPR_METHOD_RAYCAST] = "raycast",
        [HPR_METHOD_EXACT] = "exact",
    };
    return names[method];
}

static hpr_status check_options(hpr_context *ctx, const hpr_solve_options *options)
{
    if (options->order < HPR_CHOOSE || options->order > HPR_MAX_ORDER)
        return hpr_fail(ctx, HPR_ERR_ARG, "order %d is not in 0 .. %d", options->order, HPR_MAX_ORDER);
    if (options->subdivide < HPR_CHOOSE || options->subdivide > HPR_MAX_SUBDIVIDE)
        return hpr_fail(ctx, HPR_ERR_ARG, "subdivision %d is not in 0 .. %d", options->subdivide,
                        HPR_MAX_SUBDIVIDE);
    if (options->feet < HPR_CHOOSE || options->feet > HPR_MAX_FEET)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d quarterings at feet are not in 0 .. %d", options->feet,
                        HPR_MAX_FEET);
    if (!((options->element_size >= 0 && isfinite(options->element_size)) ||
          options->element_size == HPR_CHOOSE))
        return hpr_fail(ctx, HPR_ERR_ARG, "elements of %g m are not possible", options->element_size);
    if (options->grade < 0 || options->grade > HPR_MAX_GRADE)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d levels of grading are not in 0 .. %d", options->grade,
                        HPR_MAX_GRADE);
    if (!(options->tolerance >= 0 && options->tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "tolerance %g is not in [0, 1)", options->tolerance);
    if (options->tolerance > 0 && options->refine == HPR_REFINE_H && options->order == 1)
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "order 1 tells too little of what it leaves out: halving needs 0, constants, or 2 "
                        "and more");
    if (!(options->max_seconds >= 0 && options->max_bytes >= 0))
        return hpr_fail(ctx, HPR_ERR_ARG, "limits of %g s and %g bytes are not both 0 or more",
                        options->max_seconds, options->max_bytes);
    if (!(options->link_tolerance >= 0 && options->link_tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "link tolerance %g is not in [0, 1)", options->link_tolerance);
    if (!(options->block_tolerance >= 0 && options->block_tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "block tolerance %g is not in [0, 1)", options->block_tolerance);
    if (!(options->solver_tolerance > 0 && options->solver_tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "solver tolerance %g is not in (0, 1)", options->solver_tolerance);
    if (options->max_sweeps < 1)
        return hpr_fail(ctx, HPR_ERR_ARG, "at least one sweep is needed, not %d", options->max_sweeps);
    return HPR_OK;
}

static bool has_light(const hpr_solution *solution)
{
    const hpr_patches *patches = solution->patches;
    for (size_t i = 0; i < patches->count * patches->channel_count; i++) {
        if (patches->exitance[i] > 0)
            return true;
    }
    return hpr_outside_shines(solution);
}

bool hpr_solution_lit(const hpr_solution *solution, const hpr_scene *scene)
{
    if (solution->patches->count == 0)
        hpr_warn(solution->context, "%s: no surface; the solution is empty", scene->path);
    else if (!has_light(solution))
        hpr_warn(solution->context, "%s: no light; the solution is zero", scene->path);
    else
        return true;
    return false;
}

static hpr_status transport(hpr_solution *solution, const hpr_solve_options *options)
{
    static const double direct_tolerance = 1e-5, open_direct_tolerance = 1e-12, blocked_estimate = 1e-4,
                        open_estimate = 1e-11,
                        part_of_links = 1e-6; /* what links leave out no solver brings back */
    const hpr_transport_demand demand = {
        .link_tolerance = options->link_tolerance,
        .block_tolerance = options->block_tolerance,
        .direct_tolerance = direct_tolerance,
        .open_direct_tolerance = open_direct_tolerance,
        .solver_tolerance = fmax(options->solver_tolerance, part_of_links * options->link_tolerance)};
    hpr_transport light;
    hpr_estimate estimate = {0};
    hpr_status status = hpr_transport_solve(solution, &demand, &light);
    if (status == HPR_OK)
        status = hpr_estimate_init(solution, &light, light.links->occluded ? blocked_estimate : open_estimate,
                                   &estimate);
    if (status == HPR_OK)
        status = hpr_transport_finish(solution, &light);
    hpr_estimate_fini(&estimate);
    hpr_transport_fini(&light);
    return status;
}

hpr_status hpr_solution_begin(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *options,
                              hpr_solution **out)
{
    hpr_solution *solution = NULL;
    *out = NULL;
    hpr_status status = check_options(ctx, options);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution, 1, sizeof *solution, "a solution");
    if (status != HPR_OK)
        return status;
    solution->context = ctx;
    solution->summary.options = *options;
    solution->summary.error_estimate = NAN;
    hpr_stage_begin(ctx, "mesh");
    status = hpr_setup_describe(solution, scene);
    if (status == HPR_OK)
        status = hpr_setup_elements(solution, scene);
    if (status == HPR_OK)
        status = hpr_setup_arrays(solution);
    if (status == HPR_OK)
        status = hpr_setup_cameras(solution, scene);
    hpr_stage_end(ctx);
    if (status != HPR_OK)
        hpr_solution_destroy(&solution);
    *out = solution;
    return status;
}

/* What a method of this operator asks for. */
static hpr_status take_method(hpr_context *ctx, hpr_solve_options *options)
{
    static const double hierarchical_tolerance = 0.3;
    if (options->solver == HPR_SOLVER_DIRECT)
        return hpr_fail(ctx, HPR_ERR_ARG, "elimination needs a full matrix, method '%s' has none",
                        hpr_method_name(options->method));
    if (options->method == HPR_METHOD_GALERKIN)
        return HPR_OK;
    if (options->method != HPR_METHOD_HIERARCHICAL)
        return hpr_fail(ctx, HPR_ERR_ARG, "method %d is none of hpr_solve", (int)options->method);
    if (options->order > 0)
        return hpr_fail(ctx, HPR_ERR_ARG, "order %d: method '%s' has one constant per element",
                        options->order, hpr_method_name(options->method));
    options->order = 0;
    options->refine = HPR_REFINE_H;
    options->direct = HPR_DIRECT_GALERKIN;
    if (options->link_tolerance == 0 && options->tolerance == 0)
        options->link_tolerance = hierarchical_tolerance;
    return HPR_OK;
}

static hpr_status solve(hpr_context *context, const hpr_scene *scene, hpr_solve_options *chosen,
                        const hpr_solve_series *series, hpr_solution **out)
{
    hpr_solution *solution = NULL;
    hpr_status status = take_method(context, chosen);
    if (status == HPR_OK)
        status = hpr_solution_begin(context, scene, chosen, &solution);
    if (status == HPR_OK && hpr_solution_lit(solution, scene))
        status = chosen->tolerance > 0 ? hpr_tolerance_solve(solution, series) : transport(solution, chosen);
    if (status != HPR_OK)
        hpr_solution_destroy(&solution);
    *out = solution;
    return status;
}

hpr_status hpr_solve(hpr_context *context, const hpr_scene *scene, const hpr_solve_options *options,
                     hpr_solution **out)
{
    hpr_solve_options chosen;
    hpr_solve_options_init(&chosen);
    if (options)
        chosen = *options;
    hpr_context_clear_error(context);
    return solve(context, scene, &chosen, NULL, out);
}

hpr_status hpr_solve_resume(hpr_context *context, const hpr_scene *scene, const hpr_solve_options *options,
                            const hpr_solve_series *series, hpr_solution **out)
{
    hpr_solve_options chosen = *options;
    hpr_context_clear_error(context);
    *out = NULL;
    if (!(chosen.tolerance > 0))
        return hpr_fail(context, HPR_ERR_ARG, "a solve can be taken up again only if it has a tolerance");
    return solve(context, scene, &chosen, series, out);
}
