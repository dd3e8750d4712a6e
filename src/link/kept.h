/* Blocks that need not be integrated again: of the step before, or of a solve that was stopped. */
#ifndef HPR_LINK_KEPT_H
#define HPR_LINK_KEPT_H

#include "link/links.h"

typedef struct hpr_kept {
    const hpr_links *known;         /* as in hpr_links_demand; NULL: none */
    const hpr_block_keeper *keeper; /* NULL: none */
} hpr_kept;

/* The block [count] of a pair of nodes with these degrees, and what its integration told; false: there is
 * none. pair: its offset is not looked at. Concurrent calls allowed. */
bool hpr_kept_take(const hpr_kept *kept, const hpr_link *pair, size_t count, double *block,
                   hpr_link_note *note);

/* Hands on what was integrated. Concurrent calls allowed. */
void hpr_kept_give(const hpr_kept *kept, const hpr_link *pair, size_t count, const double *block,
                   const hpr_link_note *note);

#endif
