/* What may be done with an element, what it costs and what is expected of it. */
#ifndef HPR_SOLVER_PROPOSAL_H
#define HPR_SOLVER_PROPOSAL_H

#include "basis/two_scale.h"
#include "solver/indicator.h"

typedef struct hpr_choice {
    double error2; /* what will be left out then: to be compared with the indicator's */
    int cost;      /* coefficients */
    uint8_t halve[2], degree[4];
} hpr_choice;

enum { HPR_CHOICES = 6 };

typedef struct hpr_proposal {
    int count;
    hpr_choice choice[HPR_CHOICES]; /* the first: to leave it as it is */
} hpr_proposal;

/*
 * Where the coefficients of an element fall fast, or the mode is p, its degree may rise by one or two; where
 * they do not, it may be halved along the axes along which they do not; where one axis is so and one so,
 * along both, or get one degree more. Of two axes the worse one alone may be halved. The halves get the
 * lowest degree that still shows the element's own polynomial as well as they are expected to show H: a
 * graded mesh has its low degrees where it is fine (linear degree vector; Schwab 1998, ch. 4). indirect,
 * norm2: as hpr_indicate has them; two_scale: of HPR_MAX_ORDER; far: much is still to be gained, so that a
 * degree too low to tell anything may rise by three. Thread-safe.
 */
void hpr_propose(const hpr_solution *solution, const hpr_two_scale *two_scale, const double *indirect,
                 const double *norm2, const hpr_indicator *indicator, size_t leaf, bool far,
                 hpr_proposal *proposal);

#endif
