#include "solver/resolution.h"

#include "basis/basis.h"

double hpr_resolution_dofs(const hpr_patches *patches, int order, int subdivide)
{
    double dofs = 0;
    for (size_t i = 0; i < patches->count; i++)
        dofs += (double)hpr_basis_count((hpr_shape)patches->shape[i], order);
    return dofs * (double)(1 << 2 * subdivide);
}

bool hpr_resolution_choose(const hpr_patches *patches, hpr_solve_options *options)
{
    static const struct {
        int order, subdivide;
    } steps[] = {{HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 0}, {0, 0}};
    enum { STEPS = sizeof steps / sizeof *steps };
    bool free_order = options->order == HPR_CHOOSE, free_subdivide = options->subdivide == HPR_CHOOSE;
    int step = 0;
    for (;; step++) {
        if (free_order)
            options->order = steps[step].order;
        if (free_subdivide)
            options->subdivide = steps[step].subdivide;
        bool affordable =
            hpr_resolution_dofs(patches, options->order, options->subdivide) <= HPR_RESOLUTION_DOFS;
        if (affordable || step == STEPS - 1 || !(free_order || free_subdivide))
            break;
    }
    if (options->feet == HPR_CHOOSE)
        options->feet = step == 0 ? HPR_DEFAULT_FEET : 0;
    return step == 0;
}
