#include "reconstruct/reconstruct.h"

#include <math.h>

/* A stand-in: the constant function only. */
void hpr_reconstruct_point(const hpr_solution *solution, size_t patch, double s, double t, double *irradiance)
{
    const hpr_elements *elements = solution->elements;
    double leaf_s, leaf_t;
    size_t n = solution->channel_count;
    size_t leaf = hpr_elements_locate(solution->patches, elements, patch, s, t, &leaf_s, &leaf_t);
    double area_m2 = elements->area_m2[elements->leaf[leaf]];
    for (size_t c = 0; c < n; c++)
        irradiance[c] = solution->irradiance[elements->dof[leaf] * n + c] / sqrt(area_m2);
}
