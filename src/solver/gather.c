#include "solver/gather.h"

#include "solver/arrivals.h"

#include <math.h>
#include <string.h>

static hpr_status copy(hpr_context *ctx, const double *from, size_t count, double **to)
{
    hpr_status status = hpr_allocate_into(ctx, to, count, sizeof(double), "final gathering");
    if (status == HPR_OK)
        memcpy(*to, from, count * sizeof **to);
    return status;
}

hpr_status hpr_gather(const hpr_solution *solution, size_t count, const hpr_spot *spot, double *indirect)
{
    static const double direct_tolerance = 1e-5, open_tolerance = 1e-12, spot_tolerance = 1e-6;
    const hpr_transport_demand demand = {.link_tolerance = solution->summary.link_tolerance,
                                         .direct_tolerance = direct_tolerance,
                                         .open_direct_tolerance = open_tolerance};
    hpr_context *ctx = solution->context;
    hpr_solution whole = *solution; /* but for the arrays that are written: */
    whole.irradiance = NULL;
    whole.summary.options.max_bytes = INFINITY; /* there are no blocks */
    hpr_transport transport = {0};
    hpr_status status = copy(ctx, solution->irradiance, solution->channel_count * solution->summary.dof_count,
                             &whole.irradiance);
    if (status == HPR_OK)
        status = hpr_transport_restore(&whole, &demand, &transport);
    const hpr_arrivals_task task = {.solution = &whole,
                                    .transport = &transport,
                                    .tolerance = solution->summary.occluded ? spot_tolerance : open_tolerance,
                                    .count = count,
                                    .spot = spot};
    hpr_stage_begin(ctx, "gathering");
    if (status == HPR_OK)
        status = hpr_arrivals_gather(&task, indirect);
    if (status == HPR_OK)
        status = hpr_arrivals_add_outside(&task, false, indirect);
    hpr_stage_end(ctx);
    for (size_t i = 0; status == HPR_OK && i < solution->channel_count * count; i++)
        indirect[i] = fmax(indirect[i], 0);
    hpr_transport_fini(&transport);
    hpr_release(ctx, whole.irradiance);
    return status;
}
