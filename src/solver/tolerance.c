#include "solver/tolerance.h"

#include "solver/adapt.h"
#include "solver/estimate.h"
#include "solver/setup.h"
#include "solver/transport.h"

#include <math.h>
#include <omp.h>

const char *hpr_refine_name(hpr_refine_mode mode)
{
    static const char *const names[] = {[HPR_REFINE_HP] = "hp", [HPR_REFINE_H] = "h", [HPR_REFINE_P] = "p"};
    return names[mode];
}

/* One solve of the series. */
typedef struct step {
    hpr_transport light;
    hpr_estimate estimate;
    double error; /* estimated, relative */
} step;

static void close_step(step *s)
{
    hpr_transport_fini(&s->light);
    if (s->estimate.context)
        hpr_estimate_fini(&s->estimate);
}

hpr_transport_demand hpr_tolerance_demand(const hpr_solve_options *options)
{
    static const double links = 0.1, blocks = 0.1, direct = 0.01, solver = 0.01, rounding = 1e-13;
    double t = options->tolerance, given = options->block_tolerance;
    return (hpr_transport_demand){.link_tolerance = options->link_tolerance > 0 ? options->link_tolerance
                                                                                : fmax(links * t, rounding),
                                  .block_tolerance = given > 0 ? given : fmax(blocks * t, rounding),
                                  .direct_tolerance = fmax(direct * t, 1e-12),
                                  .solver_tolerance = fmax(solver * t, options->solver_tolerance)};
}

/* Is there time and memory for another step? It may have three times as many coefficients, most of its time
 * goes to near pairs, whose number grows alike, and its blocks stand beside nothing of this step. */
static bool within_limits(const hpr_solve_summary *summary, double begun, double step_begun)
{
    static const double growth = 3;
    const hpr_solve_options *options = &summary->options;
    double now = omp_get_wtime();
    bool in_time =
        options->max_seconds == 0 || now - begun + growth * (now - step_begun) <= options->max_seconds;
    bool in_memory = options->max_bytes == 0 || growth * (double)summary->block_bytes <= options->max_bytes;
    return in_time && in_memory;
}

/* Solves on the elements as they are. */
static hpr_status take_step(hpr_solution *solution, const hpr_transport_demand *demand, step *s)
{
    hpr_status status = hpr_setup_arrays(solution);
    if (status == HPR_OK)
        status = hpr_transport_solve(solution, demand, &s->light);
    if (status == HPR_OK)
        status = hpr_estimate_init(solution, &s->light, solution->summary.options.tolerance, &s->estimate);
    if (status != HPR_OK)
        return status;
    s->error = solution->summary.error_estimate;
    hpr_info(solution->context, "%zu elements, %zu coefficients: estimated error %.2e, tolerance %.2e",
             solution->summary.element_count, solution->summary.dof_count, s->error,
             solution->summary.options.tolerance);
    return status;
}

hpr_status hpr_tolerance_solve(hpr_solution *solution)
{
    enum { MAX_STEPS = 100 };
    static const double aim = 0.6; /* of the tolerance, for a step that should be the last */
    const hpr_solve_options *options = &solution->summary.options;
    hpr_transport_demand demand = hpr_tolerance_demand(options);
    hpr_links *known = NULL;
    double begun = omp_get_wtime();
    hpr_status status = HPR_OK;
    bool last = false;
    for (int count = 1; status == HPR_OK && !last; count++) {
        step s = {0};
        double step_begun = omp_get_wtime();
        size_t refined = 0;
        status = take_step(solution, &demand, &s);
        bool reached = s.error <= options->tolerance;
        last = reached || count == MAX_STEPS || !within_limits(&solution->summary, begun, step_begun);
        if (status == HPR_OK && !last) {
            double goal = aim * options->tolerance / s.error * s.estimate.indicated;
            status = hpr_adapt(solution, s.estimate.indicator, goal, &refined);
            last = refined == 0;
        }
        if (status == HPR_OK && last)
            status = hpr_transport_finish(solution, &s.light);
        hpr_links_destroy(&known);
        known = s.light.links;
        demand.known = known;
        s.light.links = NULL;
        solution->summary.steps = count;
        solution->summary.reached = reached;
        close_step(&s);
    }
    hpr_links_destroy(&known);
    return status;
}
