#include "render/filter.h"

#include "render/strata.h"

#include <math.h>

/* The Gaussian's F at x, which is 0 at -1/2 and 1 at 1/2. */
static double gaussian_distribution(double x)
{
    static const double deviation = 1.0 / 6;
    return 0.5 * (1 + erf(x / deviation * M_SQRT1_2) / erf(3 * M_SQRT1_2));
}

/* Bisection, for it needs no derivative and ends in the same place everywhere that erf is the same. */
static double gaussian_quantile(double u)
{
    double low = -0.5, high = 0.5;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        if (gaussian_distribution(middle) < u)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

static double warp(hpr_filter filter, double width, double u)
{
    if (filter == HPR_FILTER_GAUSSIAN)
        return 0.5 + (width > 0 ? width : 3) * gaussian_quantile(u);
    return width > 0 && width != 1 ? 0.5 + width * (u - 0.5) : u;
}

void hpr_filter_places(hpr_filter filter, double width, uint32_t samples, double *place)
{
    hpr_strata strata = hpr_strata_of(samples);
    for (uint32_t i = 0; i < samples; i++) {
        double u, v;
        hpr_strata_place(&strata, i, &u, &v);
        place[2 * i] = warp(filter, width, u);
        place[2 * i + 1] = warp(filter, width, v);
    }
}
