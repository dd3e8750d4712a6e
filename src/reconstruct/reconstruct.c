#include "reconstruct/reconstruct.h"

#include <math.h>

void hpr_reconstruct_point(const hpr_solution *solution, size_t patch, double s, double t, double *irradiance)
{
    const hpr_elements *elements = solution->elements;
    size_t n = solution->channel_count;
    double leaf_s, leaf_t;
    size_t leaf = hpr_elements_locate(solution->patches, elements, patch, s, t, &leaf_s, &leaf_t);
    double constant = 1 / sqrt(elements->area_m2[elements->leaf[leaf]]); /* T_0 on either shape */
    for (size_t c = 0; c < n; c++)
        irradiance[c] = constant * solution->irradiance[n * elements->dof[leaf] + c];
}
