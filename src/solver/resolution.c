#include "solver/resolution.h"

#include "basis/basis.h"

#include <math.h>

double hpr_resolution_dofs(const hpr_patches *patches, int order, int subdivide)
{
    double dofs = 0;
    for (size_t i = 0; i < patches->count; i++)
        dofs += (double)hpr_basis_count((hpr_shape)patches->shape[i], order);
    return dofs * (double)(1 << 2 * subdivide);
}

/* The highest order from `high` to 1 with at most `most` coefficients, 0 if there is none. */
static int highest_order(const hpr_patches *patches, int high, int subdivide, double most)
{
    int order = high;
    while (order > 0 && hpr_resolution_dofs(patches, order, subdivide) > most)
        order--;
    return order;
}

/* One size everywhere, if there is room for it. */
static void choose_even(const hpr_patches *patches, hpr_solve_options *options)
{
    static const double half = HPR_RESOLUTION_DOFS / 2;
    int order = options->order;
    if (order == HPR_CHOOSE)
        order = highest_order(patches, HPR_DEFAULT_ORDER, 0, half);
    bool room = hpr_resolution_dofs(patches, order, 0) <= half && (order > 0 || options->order == 0);
    if (options->order == HPR_CHOOSE && order == 0)
        order = highest_order(patches, 1, 0, HPR_RESOLUTION_DOFS);
    options->order = order;
    options->subdivide = 0;
    if (options->element_size < 0 && !room)
        options->element_size = 0;
}

bool hpr_resolution_choose(const hpr_patches *patches, hpr_solve_options *options)
{
    bool free_order = options->order == HPR_CHOOSE, free_subdivide = options->subdivide == HPR_CHOOSE;
    int order = free_order ? HPR_DEFAULT_ORDER : options->order;
    int subdivide = free_subdivide ? HPR_DEFAULT_SUBDIVIDE : options->subdivide;
    bool sized = options->element_size > 0;
    bool full = (!free_order && !free_subdivide) ||
                (!sized && hpr_resolution_dofs(patches, order, subdivide) <= HPR_RESOLUTION_DOFS);
    if (full) {
        options->order = order;
        options->subdivide = subdivide;
    } else if (free_subdivide) {
        choose_even(patches, options);
    } else {
        options->order = highest_order(patches, HPR_DEFAULT_ORDER, subdivide, HPR_RESOLUTION_DOFS);
    }
    if (options->element_size < 0 && (full || !free_subdivide))
        options->element_size = 0;
    if (options->feet == HPR_CHOOSE)
        options->feet = full ? HPR_DEFAULT_FEET : 0;
    return full || sized;
}

/* Halving alone keeps the degree. Else it begins as low as may suffice: what is met with more than that is
 * overshot; many patches meet at edges and shadow each other, and want more. */
static int begin_order(const hpr_patches *patches, const hpr_solve_options *options)
{
    enum { FINE = 4, COARSE = 2, FEW_PATCHES = 8, MANY = 2 };
    if (options->refine == HPR_REFINE_H)
        return hpr_resolution_dofs(patches, FINE, 0) <= HPR_RESOLUTION_DOFS ? FINE : COARSE;
    double digits = ceil(-log10(options->tolerance) - 1e-9);
    return (int)fmin(fmax(digits - 1, 0) + (patches->count > FEW_PATCHES ? MANY : 0), FINE);
}

void hpr_resolution_begin(const hpr_patches *patches, hpr_solve_options *options)
{
    if (options->order == HPR_CHOOSE)
        options->order = begin_order(patches, options);
    if (options->subdivide == HPR_CHOOSE)
        options->subdivide = 0;
    if (options->feet == HPR_CHOOSE)
        options->feet = 0;
    if (options->element_size < 0)
        options->element_size = 0;
}
