#include "solver/solution.h"

void hpr_solution_destroy(hpr_solution **out)
{
    hpr_solution *solution = *out;
    if (!solution)
        return;
    hpr_context *ctx = solution->context;
    for (size_t c = 0; solution->channel_name && c < solution->channel_count; c++)
        hpr_release(ctx, solution->channel_name[c]);
    for (size_t i = 0; solution->camera && i < solution->camera_count; i++)
        hpr_release(ctx, solution->camera[i].name);
    hpr_elements_destroy(&solution->elements);
    hpr_patches_destroy(&solution->patches);
    void *arrays[] = {solution->scene_name, solution->channel_name, solution->environment,
                      solution->irradiance, solution->surroundings, solution->error,
                      solution->camera,     solution->energy};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_release(ctx, solution);
    *out = NULL;
}

size_t hpr_solution_channel_count(const hpr_solution *solution)
{
    return solution->channel_count;
}

const char *hpr_solution_channel_name(const hpr_solution *solution, size_t channel)
{
    return solution->channel_name[channel];
}

const hpr_solve_summary *hpr_solution_summary(const hpr_solution *solution)
{
    return &solution->summary;
}

const hpr_energy *hpr_solution_energy(const hpr_solution *solution)
{
    return solution->energy;
}

size_t hpr_solution_camera_count(const hpr_solution *solution)
{
    return solution->camera_count;
}

const char *hpr_solution_camera_name(const hpr_solution *solution, size_t camera)
{
    return solution->camera[camera].name;
}
