#include "solver/energy.h"

#include "solver/losses.h"

#include <math.h>
#include <string.h>

typedef struct energy {
    hpr_solution *solution;
    const hpr_coverage *coverage;
    const hpr_mass *mass;
    double *reflected; /* [dofs][channels] coefficients of rho H where rho varies; NULL: nowhere */
    const hpr_patches *patches;
    const hpr_elements *elements;
    size_t channels;
} energy;

/* What needs no visibility any more: emitted, from outside and absorbed. */
static void sum_local_terms(energy *e, const double *outside)
{
    static const double pi = 3.14159265358979323846;
    hpr_solution *solution = e->solution;
    size_t n = e->channels;
    memset(solution->energy, 0, n * sizeof *solution->energy);
    for (size_t leaf = 0; leaf < e->elements->leaf_count; leaf++) {
        uint32_t node = e->elements->leaf[leaf], patch = e->elements->patch[node];
        double area = e->elements->area_m2[node];
        double open_m2 = area * hpr_coverage_open_share(e->coverage, leaf);
        for (size_t c = 0; c < n; c++) {
            size_t first = n * e->elements->dof[leaf] + c;
            double h = hpr_coverage_mean(e->coverage, leaf, solution->irradiance + first, n);
            solution->energy[c].emitted += e->patches->exitance[n * patch + c] * open_m2;
            solution->energy[c].environment +=
                pi * solution->environment[c] * outside[e->elements->dof[leaf]] * sqrt(area);
            double kept = (1 - e->patches->reflectance[n * patch + c]) * h;
            if (hpr_mass_varies(e->mass, leaf))
                kept = h - hpr_coverage_mean(e->coverage, leaf, e->reflected + first, n);
            solution->energy[c].absorbed += kept * sqrt(area);
        }
    }
}

/* The coefficients of rho H. */
static hpr_status reflect(energy *e)
{
    const hpr_elements *elements = e->elements;
    size_t n = e->channels;
    if (!e->mass->at)
        return HPR_OK;
    hpr_status status =
        hpr_allocate_into(e->solution->context, &e->reflected, n * elements->dof[elements->leaf_count],
                          sizeof(double), "energy terms");
    for (size_t leaf = 0; status == HPR_OK && leaf < elements->leaf_count; leaf++) {
        for (size_t c = 0; c < n; c++) {
            size_t first = n * elements->dof[leaf] + c;
            hpr_mass_reflect(e->mass, leaf, c, n, e->solution->irradiance + first, e->reflected + first);
        }
    }
    return status;
}

static hpr_status sum_losses(const energy *e, const hpr_tree *tree, double tolerance)
{
    double come_in = 0;
    for (size_t c = 0; c < e->channels; c++)
        come_in = fmax(come_in, e->solution->energy[c].emitted + e->solution->energy[c].environment);
    hpr_losses losses = {.solution = e->solution,
                         .coverage = e->coverage,
                         .mass = e->mass,
                         .tree = tree,
                         .reflected = e->reflected,
                         .tolerance = tolerance * come_in};
    return hpr_losses_add(&losses, e->solution->energy);
}

hpr_status hpr_energy_compute(hpr_solution *solution, const hpr_coverage *coverage, const hpr_mass *mass,
                              const hpr_links *links, const double *outside)
{
    static const double least = 1e-11, part_of_links = 1e-4;
    energy e = {.solution = solution,
                .coverage = coverage,
                .mass = mass,
                .patches = solution->patches,
                .elements = solution->elements,
                .channels = solution->channel_count};
    hpr_status status = reflect(&e);
    if (status == HPR_OK) {
        sum_local_terms(&e, outside);
        status = sum_losses(&e, links->tree, fmax(least, part_of_links * links->link_tolerance));
    }
    hpr_release(solution->context, e.reflected);
    return status;
}
