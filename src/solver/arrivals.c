#include "solver/arrivals.h"

#include "direct/environment.h"
#include "solver/operator.h"
#include "solver/outside.h"

static hpr_status gather_spots(const hpr_arrivals_task *task, const double *sent, double *irradiance)
{
    const hpr_spots_task spots = {.links = task->transport->links,
                                  .coverage = task->transport->coverage,
                                  .channel_count = task->solution->channel_count,
                                  .sent = sent,
                                  .tolerance = task->tolerance,
                                  .count = task->count,
                                  .spot = task->spot,
                                  .keeper = task->transport->keeper,
                                  .call = task->call};
    return hpr_spots_gather(&spots, irradiance);
}

/* What the nodes send: M through the basis, of all patches or those on which it varies, and what is
 * reflected. */
hpr_status hpr_arrivals_gather(const hpr_arrivals_task *task, double *irradiance)
{
    const hpr_solution *solution = task->solution;
    const hpr_patches *patches = solution->patches;
    const hpr_elements *e = solution->elements;
    hpr_context *ctx = solution->context;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    const hpr_mass *mass = &task->transport->mass;
    double *radiosity = NULL;
    hpr_operator *op = NULL;
    hpr_status status = hpr_allocate_into(ctx, &radiosity, n * dofs, sizeof(double), "radiosity");
    for (size_t leaf = 0; status == HPR_OK && leaf < e->leaf_count; leaf++) {
        for (size_t c = 0; c < n; c++) {
            double h[HPR_MAX_BASIS];
            for (size_t k = e->dof[leaf]; k < e->dof[leaf + 1]; k++)
                h[k - e->dof[leaf]] = solution->irradiance[n * k + c];
            hpr_mass_reflect(mass, leaf, c, 1, h, radiosity + c * dofs + e->dof[leaf]);
            if (solution->summary.direct == HPR_DIRECT_GALERKIN || hpr_mass_glows(mass, leaf))
                hpr_mass_emit(mass, leaf, c, radiosity + c * dofs + e->dof[leaf]);
        }
    }
    if (status == HPR_OK)
        status = hpr_operator_create(task->transport->links, n, &op);
    for (size_t patch = 0; status == HPR_OK && patch < patches->count; patch++)
        hpr_operator_send(op, patch, radiosity);
    if (status == HPR_OK)
        status = gather_spots(task, op->sent, irradiance);
    hpr_operator_destroy(&op);
    hpr_release(ctx, radiosity);
    return status;
}

hpr_status hpr_arrivals_add_outside(const hpr_arrivals_task *task, bool surroundings, double *irradiance)
{
    enum { SIDE = 64 }; /* of the lattices of rays, if V cannot be clipped */
    static const double pi = 3.14159265358979323846;
    const hpr_solution *solution = task->solution;
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count;
    bool exact = solution->summary.environment == HPR_ENVIRONMENT_EXACT;
    if (!hpr_outside_shines(solution) || (exact && !surroundings))
        return HPR_OK;
    hpr_environment *environment = NULL;
    hpr_status status = hpr_environment_create(solution->patches, e, &environment);
    bool clip = status == HPR_OK && hpr_environment_affordable(environment);
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(solution->context))
    for (size_t i = 0; i < (status == HPR_OK ? task->count : 0); i++) {
        const hpr_spot *spot = &task->spot[i];
        uint32_t node = e->leaf[spot->leaf], patch = e->patch[node];
        hpr_element_frame frame = hpr_node_frame(solution->patches, e, node);
        hpr_vec3 x = hpr_frame_point(&frame, spot->s, spot->t);
        double part = clip ? hpr_environment_opening(environment, patch, x).part
                           : hpr_environment_sample(environment, patch, x, SIDE, i).part;
        for (size_t c = 0; c < n; c++)
            irradiance[n * i + c] +=
                part * (exact ? solution->surroundings[n * patch + c] : pi * solution->environment[c]);
    }
    hpr_environment_destroy(&environment);
    return status;
}
