/* Is a scene too large, as far as can be told at once? */
#ifndef HPR_LINK_AFFORD_H
#define HPR_LINK_AFFORD_H

#include "patch/elements.h"
#include "visibility/visibility.h"

/*
 * Predicts the least bytes of the operator before all pairs are classified: 8 for each product of the
 * coefficients of two undivided patches that may see each other, 40 for each such pair, one for every pair.
 * How many there are is estimated from pairs drawn at random, the same ones every time, less two standard
 * errors of that. Takes about a second for 100,000 patches.
 */
double hpr_links_predict(const hpr_visibility *visibility, const hpr_elements *elements);

/* What kernel blocks may take: `asked` bytes; 0: half of the machine's memory, for they are not all of it. */
double hpr_links_most_bytes(double asked);

/*
 * Refuses a scene of more than 2000 patches for which that is more than hpr_links_most_bytes(asked). What
 * passes may still be refused when the links are counted. Errors: HPR_ERR_MEMORY; the message says how much
 * is needed and what helps.
 */
hpr_status hpr_links_afford(const hpr_visibility *visibility, const hpr_elements *elements, double asked);

#endif
