#include "solver/outside.h"

#include "link/environment_moments.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

bool hpr_outside_shines(const hpr_solution *solution)
{
    for (size_t c = 0; c < solution->channel_count; c++) {
        if (solution->environment[c] > 0)
            return true;
    }
    return false;
}

hpr_status hpr_outside_project(hpr_solution *solution, const hpr_coverage *coverage, double *outside)
{
    static const double tolerance = 1e-3;
    hpr_solve_summary *summary = &solution->summary;
    hpr_environment *environment = NULL;
    hpr_environment_figures figures = {0};
    hpr_status status = hpr_environment_create(solution->patches, solution->elements, &environment);
    if (status == HPR_OK)
        status =
            hpr_environment_moments(environment, coverage, solution->elements, tolerance, outside, &figures);
    bool exact = status == HPR_OK && summary->options.direct == HPR_DIRECT_EXACT &&
                 hpr_environment_affordable(environment);
    summary->environment = exact ? HPR_ENVIRONMENT_EXACT : HPR_ENVIRONMENT_GALERKIN;
    summary->environment_closed = figures.closed_form;
    summary->environment_clipped = figures.clipped;
    summary->environment_sampled = figures.sampled;
    summary->environment_error = figures.error;
    hpr_environment_destroy(&environment);
    return status;
}

void hpr_outside_add(const hpr_solution *solution, const double *outside, double *direct)
{
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    for (size_t i = 0; i < n * dofs; i++)
        direct[i] += pi * solution->environment[i / dofs] * outside[i % dofs];
}

static double surroundings_of(const hpr_solution *solution, size_t patch, size_t channel,
                              const double *outside, const double *direct)
{
    static const double open = 1e-9; /* a view that is as good as open shows nothing of them */
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    double indirect = 0, shut = 0;
    for (size_t leaf = e->patch_leaf[patch]; leaf < e->patch_leaf[patch + 1]; leaf++) {
        double root = sqrt(e->area_m2[e->leaf[leaf]]);
        size_t first = e->dof[leaf];
        indirect += root * (solution->irradiance[n * first + channel] - direct[channel * dofs + first]);
        shut += root * (root - outside[first]);
    }
    return indirect > 0 && shut > open * solution->patches->area_m2[patch] ? indirect / shut : 0;
}

void hpr_outside_split(hpr_solution *solution, const double *outside, double *direct)
{
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count;
    bool environment = solution->summary.environment == HPR_ENVIRONMENT_EXACT;
    for (size_t patch = 0; environment && patch < e->patch_count; patch++) {
        for (size_t c = 0; c < n; c++)
            solution->surroundings[n * patch + c] = surroundings_of(solution, patch, c, outside, direct);
    }
    hpr_outside_weigh(solution, outside, direct);
}

void hpr_outside_weigh(const hpr_solution *solution, const double *outside, double *direct)
{
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    bool lamps = solution->summary.direct == HPR_DIRECT_EXACT;
    bool environment = solution->summary.environment == HPR_ENVIRONMENT_EXACT;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        const double *surroundings = solution->surroundings + n * e->patch[e->leaf[leaf]];
        for (size_t c = 0; c < n; c++) {
            double sky = pi * solution->environment[c], weight = environment ? sky - surroundings[c] : 0;
            for (size_t i = e->dof[leaf]; i < e->dof[leaf + 1]; i++) {
                double *d = &direct[c * dofs + i];
                *d = (lamps ? *d - sky * outside[i] : 0) + weight * outside[i];
            }
        }
    }
}
