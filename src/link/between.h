/* What may come between two nodes of the elements' trees, as one thread asks for one pair after the other. */
#ifndef HPR_LINK_BETWEEN_H
#define HPR_LINK_BETWEEN_H

#include "link/tree.h"
#include "quadrature/block.h"
#include "visibility/views.h"

typedef struct hpr_between {
    hpr_context *context;
    const hpr_visibility *visibility; /* borrowed, like views */
    const hpr_views *views;
    hpr_views_cursor *cursor;
    uint32_t *candidate, *blocker; /* [occluder_count] of a pair of patches, of a pair of nodes */
    size_t candidate_count;
    uint32_t recv_patch, send_patch; /* the pair of patches that verdict and candidates belong to */
    hpr_verdict verdict;
} hpr_between;

/* visibility, views: must outlive it. Fini it in any case. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_between_init(hpr_context *ctx, const hpr_visibility *visibility, const hpr_views *views,
                            hpr_between *between);
void hpr_between_fini(hpr_between *between);

/* The occluders that may come between two patches, in between->candidate; they are kept for the next call
 * with the same patches. */
hpr_verdict hpr_between_patches(hpr_between *between, uint32_t recv, uint32_t send);

/* Sets visibility, blockers (valid until the next call) and blocker_count of a task of two nodes. False if
 * they do not see each other at all. */
bool hpr_between_nodes(hpr_between *between, const hpr_coverage *coverage, const hpr_tree *tree,
                       uint32_t recv, uint32_t send, hpr_block_task *task);

#endif
