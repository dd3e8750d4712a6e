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
} step;

static void close_step(step *s)
{
    hpr_transport_fini(&s->light);
    hpr_estimate_fini(&s->estimate);
}

hpr_transport_demand hpr_tolerance_demand(const hpr_solve_options *options)
{
    static const double links = 0.1, blocks = 0.1, blocked = 0.3, direct = 0.03, solver = 0.01,
                        rounding = 1e-13;
    double t = options->tolerance, given = options->block_tolerance;
    return (hpr_transport_demand){.link_tolerance = options->link_tolerance > 0 ? options->link_tolerance
                                                                                : fmax(links * t, rounding),
                                  .block_tolerance = given > 0 ? given : fmax(blocks * t, rounding),
                                  .blocked_tolerance = given > 0 ? given : fmax(blocked * t, rounding),
                                  .direct_tolerance = fmax(direct * t, 1e-12),
                                  .open_direct_tolerance = fmax(direct * t, 1e-12),
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
    hpr_info(solution->context, "%zu elements, %zu coefficients: estimated error %.2e, tolerance %.2e",
             solution->summary.element_count, solution->summary.dof_count, solution->summary.error_estimate,
             solution->summary.options.tolerance);
    hpr_tell_accuracy(solution->context, solution->summary.error_estimate,
                      solution->summary.options.tolerance);
    return status;
}

/* Refines as it was done before; *step receives the number of the step that follows. */
static hpr_status take_up(hpr_solution *solution, const hpr_solve_series *series, hpr_refinements *done,
                          uint32_t *step)
{
    hpr_status status =
        hpr_grow(solution->context, &done->item, &done->capacity, series->done_count + 1, sizeof *done->item);
    size_t first = 0;
    while (status == HPR_OK && first < series->done_count) {
        size_t end = first;
        for (; end < series->done_count && series->done[end].step == *step; end++)
            done->item[done->count++] = series->done[end];
        status = end > first
                     ? hpr_adapt_again(solution, series->done + first, end - first)
                     : hpr_fail(solution->context, HPR_ERR_ARG, "%s: refinements of step %u are missing",
                                solution->scene_name, (unsigned)*step);
        first = end;
        ++*step;
    }
    return status;
}

/* Refines for the next step, if there is to be one, and tells of it; *last: there is none. */
static hpr_status prepare_step(hpr_solution *solution, const hpr_solve_series *series, const step *s,
                               uint32_t count, hpr_refinements *done, bool *last)
{
    static const double aim = 0.8; /* of the tolerance, for a step that should be the last */
    const hpr_solve_summary *summary = &solution->summary;
    const hpr_error_parts *parts = &summary->error_parts;
    double others = parts->links + parts->visibility + parts->solver, tolerance = summary->options.tolerance;
    double goal =
        fmax(aim * tolerance - others, 0.5 * aim * tolerance) / parts->discretisation * s->estimate.indicated;
    size_t before = done->count;
    hpr_status status = hpr_adapt(solution, &s->estimate, goal, count, done);
    *last = done->count == before;
    if (status == HPR_OK && !*last && series->stepped)
        status = series->stepped(series->user, done->item, done->count);
    return status;
}

hpr_status hpr_tolerance_solve(hpr_solution *solution, const hpr_solve_series *series)
{
    enum { MAX_STEPS = 100 };
    static const hpr_solve_series whole = {0};
    hpr_solve_summary *summary = &solution->summary;
    hpr_transport_demand demand = hpr_tolerance_demand(&summary->options);
    hpr_refinements done = {0};
    hpr_links *known = NULL;
    double begun = omp_get_wtime();
    bool last = false;
    uint32_t count = 1;
    series = series ? series : &whole;
    demand.keeper = series->blocks;
    hpr_status status = take_up(solution, series, &done, &count);
    for (; status == HPR_OK && !last; count++) {
        step s = {0};
        double step_begun = omp_get_wtime();
        summary->steps = (int)count;
        status = take_step(solution, &demand, &s);
        summary->reached = summary->error_estimate <= summary->options.tolerance;
        last = summary->reached || count >= MAX_STEPS || !within_limits(summary, begun, step_begun);
        if (status == HPR_OK && !last)
            status = prepare_step(solution, series, &s, count, &done, &last);
        if (status == HPR_OK && last)
            status = hpr_transport_finish(solution, &s.light);
        hpr_links_destroy(&known);
        known = s.light.links;
        demand.known = known;
        s.light.links = NULL;
        close_step(&s);
    }
    hpr_links_destroy(&known);
    hpr_release(solution->context, done.item);
    return status;
}
