/* What can be told of a scene without integrating anything: who sees whom, and whether light can leave. */
#ifndef HPR_APP_PLAN_LOOK_H
#define HPR_APP_PLAN_LOOK_H

#include "solver/effects.h"

enum { HPR_PLAN_FEW_PATCHES = 2000 }; /* of which all pairs are classified in a moment */

/* What limits how few elements show the light. */
typedef struct hpr_outlook {
    double gap; /* of pairs that see each other the least distance, in sizes of the smaller; 0: they touch */
    bool lit;   /* there is light: else nothing is solved */
    bool uniform;       /* all patches emit and reflect alike, and nothing leaves: the light is constant */
    double trial_error; /* relative error of the first step of a tolerance, estimated; NaN: not tried */
    double trial_cpu_s; /* what that step took, the least of a few times */
    double slowness;    /* of this machine beside the one of the constants, by the trial; 1 without */
} hpr_outlook;

/*
 * Fills plan->patch_count to least_bytes, and of the facts occluded, interreflects and escaping. Up to
 * HPR_PLAN_FEW_PATCHES every pair is classified, beyond that 400 that see each other, drawn at random. Light
 * can leave if one of some thousand rays from points of the fronts does; where none does, less than a
 * thousandth leaves. Same result for any thread count. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE,
 * HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_plan_look(const hpr_solution *solution, hpr_plan *plan, hpr_effect_facts *facts,
                         hpr_outlook *outlook);

#endif
