/*
 * Where the rays of a pixel go: the strata of the unit square, warped so that their density is the filter's
 * weight. So all samples count the same, and no pixel needs its neighbours' samples.
 */
#ifndef HPR_RENDER_FILTER_H
#define HPR_RENDER_FILTER_H

#include "base/context.h"

#include <hprad/render.h>

enum { HPR_MAX_FILTER_WIDTH = 16 };

/*
 * place: [samples][2], offsets from the pixel's upper left corner in pixels; the pixel itself is 0 .. 1. A
 * stratum's coordinate u goes to 1/2 + W F^-1(u), F the distribution of the filter of width 1 about 0: for
 * the box F^-1(u) = u - 1/2, for the Gaussian F(x) = (1 + erf(x/(s sqrt 2)) / erf(3/sqrt 2)) / 2, s = 1/6.
 * The box of width 1 leaves the strata as they are. width 0: the filter's own. samples >= 1.
 */
void hpr_filter_places(hpr_filter filter, double width, uint32_t samples, double *place);

#endif
