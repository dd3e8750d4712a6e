/* What a solve will take, from its first elements and from what sees what. */
#ifndef HPR_APP_PLAN_PREDICT_H
#define HPR_APP_PLAN_PREDICT_H

#include "app/plan_look.h"

/*
 * Of the default, or of given elements: these and their links are those of the solve, found but not
 * integrated (above HPR_PLAN_FEW_PATCHES: from the share of pairs that see each other). With b the bytes of
 * the blocks and q the part of links that see partly
 *   memory = 20 MB + 1.05 b,  CPU seconds = m (0.17 + (0.065 + 0.145 q) b / MB),
 * m the slowness of the machine (plan_trial.h), and of each patch 3 kB and 30 microseconds besides, here and
 * below. Of a tolerance t: the elements of the first step, b0 bytes,
 * and the factor g >= 1 by which their coefficients grow,
 *   g = 1 where the light is constant,
 *   g = (3.6 / t)^0.5 where patches touch that see each other, (0.1 / t)^0.7 with things in the way,
 *   g = 2.2 (1 + 0.6 (1 / gap - 1)) elsewhere (1 / gap >= 1), 1.3 for 2.2 with things in the way,
 *   (t / 4e-4)^0.31 of it, where patches touch, else all of it, as higher degrees, the rest, e, as elements,
 *   links like e^1.5, blocks like g^1.7, memory = 20 MB + 3 b,
 *   CPU seconds = the trial's times g^0.95; with things in the way times g (0.01 / t)^0.35, or (0.01 / t)^0.2
 *   where t > 0.01; without a trial 0.1 + (0.12, or 0.3) b / MB.
 * All constants are observed, on the scenes of scenes/ (12 to 33 MB are the program's own, by what its
 * allocators keep). Refinement goes in steps that multiply the coefficients by 3 to 10, so where one step is
 * just enough or just not, the prediction is off by as much.
 */
hpr_status hpr_plan_predict(const hpr_solution *begun, const hpr_plan *plan, const hpr_outlook *outlook,
                            double tolerance, hpr_plan_cost *cost);

#endif
