/* What a scene calls for, and what is left out and costs nothing. */
#ifndef HPR_SOLVER_EFFECTS_H
#define HPR_SOLVER_EFFECTS_H

#include "solver/solution.h"

#include <hprad/plan.h>

/* What decides it. */
typedef struct hpr_effect_facts {
    hpr_method method;
    size_t patch_count, channel_count, distinct_count;      /* distinct: channels that do not agree */
    size_t emitter_count, reflector_count, two_sided_count; /* patches; surfaces */
    size_t texture_count;                                   /* means of textures that were taken */
    bool lit, shines;                                       /* there is light; there is light from outside */
    bool lamps_exact, outside_exact;                        /* evaluated at points, not through the basis */
    bool occluded;                                          /* something may come between patches */
    bool interreflects;                                     /* something sees a patch that reflects */
    double escaping; /* part of the light that leaves the scene; NaN: unknown */
} hpr_effect_facts;

/* Of a solution; before it is solved occluded, interreflects and outside_exact are false and escaping is NaN.
 */
hpr_effect_facts hpr_effect_facts_of(const hpr_solution *solution);

/* One line for each, as the facts have it. */
void hpr_effects_name(const hpr_effect_facts *facts, hpr_plan_effect effect[HPR_PLAN_EFFECTS]);

#endif
